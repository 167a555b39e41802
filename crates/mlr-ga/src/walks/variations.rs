use mlr_model::Variation;

/// The nominal model and how a robot usually differs from it: servos of other
/// stiffness, ground of other friction, a payload to one side, a slope. Chosen on
/// logs of an independent plant (`docs/decision.md`).
pub fn usual_variations() -> Vec<Variation> {
    let nominal = Variation::default();
    let servo = |stiffness, friction| Variation {
        stiffness,
        friction,
        ..nominal
    };
    let payload = |x, y| Variation {
        payload: 0.18,
        payload_at: [x, y],
        stiffness: 0.87,
        ..nominal
    };
    let slope = |eighth: i32| Variation {
        slope_deg: 6.0,
        uphill_deg: 45.0 * f64::from(eighth),
        stiffness: 0.87,
        ..nominal
    };
    let mut variations = vec![
        nominal,
        servo(0.6, 1.0),
        servo(0.8, 0.65),
        servo(0.8, 1.35),
        servo(1.5, 1.0),
        servo(0.53, 0.65),
        servo(0.53, 1.35),
        servo(1.33, 0.65),
        servo(1.33, 1.35),
        payload(0.67, 0.0),
        payload(-0.67, 0.0),
        payload(0.0, 0.77),
        payload(0.0, -0.77),
    ];
    variations.extend((0..8).map(slope));
    variations
}

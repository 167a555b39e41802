//! Where effects make the body lean. Roll is positive where its left side rises, pitch where its
//! front sinks.

use super::*;

/// Mean roll and pitch that an effect adds, in degrees.
struct Lean {
    standing: [f64; 2],
    walking: [f64; 2],
}

impl Lean {
    /// Over the standing of a record and one cycle of its walk.
    fn of(kind: &str, place: Place, values: &[f64]) -> Self {
        let walks = Walks::lasting(3.2);
        let added = walks.added(kind, place, values);
        let over = |samples: std::ops::Range<usize>| {
            [
                mean(&added.roll[samples.clone()]),
                mean(&added.pitch[samples]),
            ]
        };
        Self {
            standing: over(0..walks.at(-0.1)),
            walking: over(walks.at(2.0)..walks.at(3.0)),
        }
    }

    /// Whether both stretches lean this way by at least so much, along both axes.
    fn is_towards(&self, [roll, pitch]: [f64; 2], least_deg: f64) -> bool {
        [self.standing, self.walking]
            .iter()
            .all(|[roll_deg, pitch_deg]| {
                (roll == 0.0 || roll * roll_deg >= least_deg)
                    && (pitch == 0.0 || pitch * pitch_deg >= least_deg)
            })
    }

    /// How much larger the lean of the walk is along one axis (0 is roll) than along the other.
    fn purity(&self, axis: usize) -> f64 {
        (self.walking[axis] / self.walking[1 - axis]).abs()
    }
}

/// Roll and pitch by which the corner or side of each leg sinks, leg 1 first.
const SINKS: [[f64; 2]; 6] = [
    [-1.0, 1.0],
    [1.0, 1.0],
    [-1.0, 0.0],
    [1.0, 0.0],
    [-1.0, -1.0],
    [1.0, -1.0],
];

fn rises(leg: usize) -> [f64; 2] {
    SINKS[leg].map(|axis| -axis)
}

#[test]
fn the_body_leans_towards_a_load() {
    for (moments, towards, axis) in [
        ([0.0, 0.012], [-1.0, 0.0], 0),
        ([0.0, -0.012], [1.0, 0.0], 0),
        ([0.015, 0.0], [0.0, 1.0], 1),
        ([-0.015, 0.0], [0.0, -1.0], 1),
    ] {
        let lean = Lean::of("payload", Place::Robot, &[0.3, moments[0], moments[1]]);
        assert!(
            lean.is_towards(towards, 0.005),
            "{moments:?} {:?}",
            lean.standing
        );
        assert!(lean.purity(axis) > 4.0, "{moments:?} {:?}", lean.walking);
    }
    // Control: a load in the middle makes it lean nowhere.
    let middle = Lean::of("payload", Place::Robot, &[0.3, 0.0, 0.0]);
    assert!(!SINKS.iter().any(|corner| middle.is_towards(*corner, 0.005)));
}

#[test]
fn the_body_stands_and_walks_along_the_ground() {
    let ahead = Lean::of("slope", Place::Robot, &[5.0, 0.0]);
    let left = Lean::of("slope", Place::Robot, &[0.0, 5.0]);
    for (lean, expected) in [(ahead, [0.0, -5.0]), (left, [5.0, 0.0])] {
        for stretch in [lean.standing, lean.walking] {
            for (seen, expected) in stretch.iter().zip(expected) {
                assert!((seen - expected).abs() < 0.05, "{stretch:?} {expected}");
            }
        }
    }
}

#[test]
fn slopes_and_loads_add_to_those_of_the_description() {
    let mut model = described();
    model.simulation.terrain.slope_rad = 3.0_f64.to_radians();
    let model = changed(model, "slope", Place::Robot, &[0.0, 4.0]);
    assert!((model.simulation.terrain.slope_rad.to_degrees() - 5.0).abs() < 1e-9);
    let reported = effect("slope").report(Place::Robot, &[0.0, 0.0], &model);
    assert!((reported["uphill_deg"] - (4.0_f64).atan2(3.0).to_degrees()).abs() < 1e-9);

    let one = changed(described(), "payload", Place::Robot, &[0.2, 0.01, 0.0]);
    let both = changed(one, "payload", Place::Robot, &[0.1, 0.0, 0.006]);
    let load = both.simulation.payload.expect("two loads");
    let moment = |axis: usize| load.mass_kg * load.position_m[axis];
    assert!((load.mass_kg - 0.3).abs() < 1e-12);
    assert!((moment(0) - 0.01).abs() < 1e-12 && (moment(1) - 0.006).abs() < 1e-12);
}

#[test]
fn the_corner_of_a_leg_that_gives_way_sinks() {
    for leg in [0, 1, 2, 4] {
        let lean = Lean::of("weak_leg", Place::Leg(leg), &[-1.5]);
        assert!(
            lean.is_towards(SINKS[leg], 0.02),
            "{leg} {:?}",
            lean.walking
        );
    }
}

#[test]
fn a_shorter_leg_lowers_its_corner() {
    for leg in [0, 3, 5] {
        let lean = Lean::of("short_link", Place::Link(leg, 2), &[0.02]);
        assert!(
            lean.is_towards(SINKS[leg], 0.02),
            "{leg} {:?}",
            lean.walking
        );
    }
}

#[test]
fn a_joint_that_lifts_its_link_too_far_lowers_its_corner_and_the_other_way_round() {
    for kind in ["joint_offset", "stuck_joint"] {
        for leg in [0, 5] {
            let lifted = Lean::of(kind, Place::Link(leg, 1), &[0.2]);
            assert!(
                lifted.is_towards(SINKS[leg], 0.05),
                "{kind} {leg} {:?}",
                lifted.walking
            );
            let lowered = Lean::of(kind, Place::Link(leg, 1), &[-0.2]);
            assert!(
                lowered.is_towards(rises(leg), 0.05),
                "{kind} {leg} {:?}",
                lowered.walking
            );
        }
    }
}

/// The feet hold the ground and stand wider apart than the hips, so that a body pulled to the left
/// swings up on that side; pulled ahead, it tips over its front.
#[test]
fn opposite_forces_tilt_the_body_oppositely() {
    for (force_n, towards, axis) in [
        ([3.0, 0.0, 0.0], [0.0, 1.0], 1),
        ([-3.0, 0.0, 0.0], [0.0, -1.0], 1),
        ([0.0, 3.0, 0.0], [1.0, 0.0], 0),
        ([0.0, -3.0, 0.0], [-1.0, 0.0], 0),
    ] {
        let lean = Lean::of("external_force", Place::Robot, &force_n);
        assert!(
            lean.is_towards(towards, 0.01),
            "{force_n:?} {:?}",
            lean.walking
        );
        assert!(lean.purity(axis) > 4.0, "{force_n:?} {:?}", lean.walking);
    }
}

#[test]
fn a_tilted_sensor_adds_its_tilt() {
    let lean = Lean::of("imu_misalignment", Place::Robot, &[3.0, -2.0]);
    for [roll_deg, pitch_deg] in [lean.standing, lean.walking] {
        assert!((roll_deg - 3.0).abs() < 0.02 && (pitch_deg + 2.0).abs() < 0.02);
    }
}

#[test]
fn a_bias_about_a_level_axis_tilts_by_its_sign_and_the_more_the_slower_the_filter() {
    let bias = |x_dps: f64, y_dps: f64, ln_filter_time: f64| {
        Lean::of(
            "gyro_bias",
            Place::Robot,
            &[x_dps, y_dps, 0.0, ln_filter_time],
        )
    };
    assert!(bias(1.0, -1.0, 0.0).is_towards([1.0, -1.0], 0.3));
    assert!(bias(-1.0, 1.0, 0.0).is_towards([-1.0, 1.0], 0.3));
    // In the long run, as far as it turns in the filter's time, 2 s as described.
    let [swift_deg, slow_deg] = [-2.0, 0.0].map(|ln| bias(1.0, 0.0, ln).walking[0]);
    assert!(
        (swift_deg - 2.0 * (-2.0_f64).exp()).abs() < 0.01,
        "{swift_deg}"
    );
    assert!(slow_deg > 4.0 * swift_deg, "{slow_deg}");
}

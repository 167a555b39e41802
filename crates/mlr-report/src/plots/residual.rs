use super::SIZE;
use crate::{
    Curve, Figure, Ink, Mark, Panel,
    answer::{AxisResidual, Explanation},
};

/// What the model leaves of roll, pitch and yaw at the harmonics of the gait, without and with the
/// effects.
pub fn residual(name: &str, explanation: &Explanation) -> Figure {
    let (before, after) = (&explanation.residual_before, &explanation.residual_after);
    let axes = [
        ("roll [°]", &before.roll, &after.roll),
        ("pitch [°]", &before.pitch, &after.pitch),
        ("yaw [°]", &before.yaw, &after.yaw),
    ];
    let stems = |name, ink, of: &AxisResidual, aside_hz: f64| {
        let harmonics = of.harmonics.iter();
        let points = harmonics.map(|one| (one.frequency_hz + aside_hz, one.amplitude_deg));
        Curve::line(name, ink, points.collect()).marked(Mark::Stems)
    };
    let harmonics = &before.roll.harmonics;
    let [first_hz, last_hz] = [harmonics.first(), harmonics.last()]
        .map(|harmonic| harmonic.map_or(1.0, |one| one.frequency_hz));
    // Side by side, by a share of the distance between two harmonics.
    let aside_hz = 0.08 * first_hz;
    let panels = axes.map(|(label, before, after)| Panel {
        shows: [0.0, 0.05],
        ..Panel::new(
            label,
            vec![
                stems("without effects", Ink::Simulated, before, -aside_hz),
                stems("with effects", Ink::Measured, after, aside_hz),
            ],
        )
    });
    Figure {
        name: name.into(),
        title: "What the model leaves at the harmonics of the gait".into(),
        description:
            "Three panels over frequency: amplitudes of what is left of roll, pitch and yaw \
                      at multiples of the gait's frequency, without and with the effects."
                .into(),
        is_headed: false,
        x_label: "frequency [Hz]".into(),
        x_shows: vec![0.0, last_hz + 0.5 * first_hz],
        panels: panels.into(),
        size: SIZE,
    }
}

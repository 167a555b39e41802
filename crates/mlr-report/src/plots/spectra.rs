use mlr_filter::{Axis, EvenSamples, FourierFilter, SettingError};

use super::{SIZE, WalkSignals};
use crate::{Curve, Figure, Ink, Mark, Panel, Rule};

/// Frequencies are shown up to this multiple of the cutoff.
const BEYOND_CUTOFF: f64 = 1.15;

/// Amplitude spectra of measured and simulated angles, with what survives the filter.
///
/// # Errors
/// [`SettingError`] when the filter or the length of the stretch makes no sense.
pub fn spectra(name: &str, signals: &WalkSignals) -> Result<Figure, SettingError> {
    let settings = signals.filter;
    let mut filter = FourierFilter::new(settings, signals.duration_s)?;
    // A sine whose mean square is the threshold.
    let threshold_deg = amplitude_deg(settings.power_threshold_deg2);
    let mut panels = Vec::new();
    for axis in [Axis::Roll, Axis::Pitch, Axis::Yaw] {
        let mut curves = Vec::new();
        for (samples, name, ink) in [
            (&signals.measured, "measured", Ink::Measured),
            (&signals.simulated, "simulated", Ink::Simulated),
        ] {
            let spectrum = filter.spectrum(of_axis(samples, axis));
            let kept = filter.select(axis, &spectrum);
            let power = spectrum.power().deg2;
            let point = |bin: usize| {
                let frequency_hz = bin as f64 / signals.duration_s;
                power
                    .get(bin)
                    .map(|power| (frequency_hz, amplitude_deg(*power)))
            };
            let last_hz = BEYOND_CUTOFF * settings.cutoff_hz;
            // The constant is no oscillation.
            let shown = (1..power.len()).filter_map(point);
            let shown = shown.take_while(|(frequency_hz, _)| *frequency_hz <= last_hz);
            curves.push(Curve::line(name, ink, shown.collect()));
            let kept = kept.bins().iter().filter(|bin| **bin > 0);
            let kept = kept.filter_map(|bin| point(*bin)).collect();
            curves.push(Curve::line("", ink, kept).marked(Mark::Dots));
        }
        panels.push(Panel {
            rules: vec![
                Rule::Level(threshold_deg, String::new(), Ink::Muted),
                Rule::At(settings.cutoff_hz, "cutoff".into(), Ink::Muted),
            ],
            ..Panel::new(format!("{} [°]", axis.name()), curves)
        });
    }
    if let Some(Rule::Level(_, name, _)) = panels.first_mut().and_then(|one| one.rules.first_mut())
    {
        *name = "threshold".into();
    }
    Ok(Figure {
        name: name.into(),
        title: "Amplitude spectra of roll, pitch and yaw".into(),
        description:
            "Three panels over frequency: amplitudes of measured and simulated roll, pitch \
                      and yaw; dots mark the bins that the filter keeps."
                .into(),
        is_headed: false,
        x_label: "frequency [Hz]".into(),
        x_shows: vec![0.0],
        panels,
        size: SIZE,
    })
}

fn of_axis(samples: &EvenSamples, axis: Axis) -> &[f64] {
    let angles = samples.angles_rad();
    match axis {
        Axis::Roll => &angles.roll,
        Axis::Pitch => &angles.pitch,
        Axis::Yaw => &angles.yaw,
    }
}

/// Of the sine with this mean square.
fn amplitude_deg(power_deg2: f64) -> f64 {
    (2.0 * power_deg2).sqrt()
}

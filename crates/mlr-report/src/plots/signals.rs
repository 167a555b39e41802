use mlr_filter::{Axes, Conditioned, EvenSamples, FilterSettings};

use super::{COLUMNS, SIZE};
use crate::{Curve, Figure, Ink, Panel, thinned};

/// Measured and simulated roll, pitch and yaw of the compared stretch.
#[derive(Debug, Clone, PartialEq)]
pub struct WalkSignals {
    /// Measured, before the filter.
    pub measured: EvenSamples,
    /// Simulated, before the filter.
    pub simulated: EvenSamples,
    /// Measured, after the filter.
    pub measured_filtered: Conditioned,
    /// Simulated, after the filter.
    pub simulated_filtered: Conditioned,
    /// The filter.
    pub filter: FilterSettings,
    /// Length of the stretch.
    pub duration_s: f64,
}

/// Measured and simulated angles over time, in degrees, each with samples per second.
pub fn signals(
    name: &str,
    title: &str,
    [measured, simulated]: [(&Axes<Vec<f64>>, f64); 2],
) -> Figure {
    let curve = |name, ink, angles_rad: &[f64], rate_hz: f64| {
        let points = angles_rad.iter().enumerate();
        let points = points.map(|(q, angle)| (q as f64 / rate_hz, angle.to_degrees()));
        Curve::line(name, ink, thinned(points, COLUMNS))
    };
    let panel = |label: &str, of: fn(&Axes<Vec<f64>>) -> &[f64]| Panel {
        shows: [-0.5, 0.5],
        ..Panel::new(
            label,
            vec![
                curve("measured", Ink::Measured, of(measured.0), measured.1),
                curve("simulated", Ink::Simulated, of(simulated.0), simulated.1),
            ],
        )
    };
    Figure {
        name: name.into(),
        title: title.into(),
        description: "Three panels over time: measured and simulated roll, pitch and yaw.".into(),
        is_headed: false,
        x_label: "time since the start of the compared stretch [s]".into(),
        x_shows: Vec::new(),
        panels: vec![
            panel("roll [°]", |axes| &axes.roll),
            panel("pitch [°]", |axes| &axes.pitch),
            panel("yaw [°]", |axes| &axes.yaw),
        ],
        size: SIZE,
    }
}

impl WalkSignals {
    /// The plot of the signals before the filter.
    pub fn before(&self, name: &str) -> Figure {
        let [measured, simulated] = [&self.measured, &self.simulated];
        signals(
            name,
            "Roll, pitch and yaw before the filter",
            [
                (measured.angles_rad(), measured.rate_hz()),
                (simulated.angles_rad(), simulated.rate_hz()),
            ],
        )
    }

    /// The plot of the signals after the filter.
    pub fn after(&self, name: &str) -> Figure {
        let rate_hz = self.filter.rate_hz;
        signals(
            name,
            "Roll, pitch and yaw after the filter",
            [
                (&self.measured_filtered, rate_hz),
                (&self.simulated_filtered, rate_hz),
            ],
        )
    }
}

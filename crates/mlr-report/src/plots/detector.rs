use mlr_filter::{Assessment, OrientationSeries};

use super::{COLUMNS, SIZE};
use crate::{Curve, Figure, Ink, Panel, Rule, thinned};

/// What the damage detector made of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct DetectorRun<'a> {
    /// What it saw.
    pub orientation: &'a OrientationSeries,
    /// What it made of each position of its window.
    pub assessments: &'a [Assessment],
    /// Fluctuation that a healthy robot stays below.
    pub threshold_deg: f64,
    /// Largest fluctuation.
    pub max_fluctuation_deg: f64,
    /// Log time at which the walk started.
    pub motion_start_s: Option<f64>,
    /// Log time at which damage was flagged.
    pub damage_s: Option<f64>,
}

/// Roll, pitch and yaw of the whole log, and the fluctuation with its threshold and flag.
pub fn detector(name: &str, run: &DetectorRun<'_>) -> Figure {
    let title = match run.damage_s {
        Some(damage_s) => format!("damage flagged at {damage_s:.1} s"),
        None => "no damage flagged".into(),
    };
    let angles = run.orientation.angles_rad();
    let curve = |name, ink, angles_rad: &[f64]| {
        let times_s = run.orientation.times_s().iter();
        let points = times_s.zip(angles_rad);
        let points = points.map(|(t, angle)| (*t, angle.to_degrees()));
        Curve::line(name, ink, thinned(points, COLUMNS))
    };
    let fluctuations = run.assessments.iter();
    let fluctuations = fluctuations.map(|one| (one.time_s, one.fluctuation_deg));
    let fluctuation = thinned(fluctuations, COLUMNS);
    let marks = |named: bool| {
        let name = |name: &str| {
            if named {
                name.to_string()
            } else {
                String::new()
            }
        };
        let start = run.motion_start_s;
        let flag = run.damage_s;
        start
            .map(|at_s| Rule::At(at_s, name("walk starts"), Ink::Third))
            .into_iter()
            .chain(flag.map(|at_s| Rule::At(at_s, name("damage flagged"), Ink::Alarm)))
    };
    let threshold = Rule::Level(run.threshold_deg, "threshold".into(), Ink::Muted);
    Figure {
        name: name.into(),
        title,
        description:
            "Three panels over the time of the log: roll and pitch, yaw, and the fluctuation \
                      of roll or pitch within the detector's window, with its threshold."
                .into(),
        is_headed: false,
        x_label: "time of the log [s]".into(),
        x_shows: Vec::new(),
        panels: vec![
            Panel {
                rules: marks(true).collect(),
                ..Panel::new(
                    "roll, pitch [°]",
                    vec![
                        curve("roll", Ink::Measured, &angles.roll),
                        curve("pitch", Ink::Simulated, &angles.pitch),
                    ],
                )
            },
            Panel {
                rules: marks(false).collect(),
                ..Panel::new("yaw [°]", vec![curve("yaw", Ink::Third, &angles.yaw)])
            },
            Panel {
                rules: marks(false).chain([threshold]).collect(),
                ..Panel::new(
                    "fluctuation [°]",
                    vec![Curve::line("", Ink::Measured, fluctuation)],
                )
            },
        ],
        size: SIZE,
    }
}

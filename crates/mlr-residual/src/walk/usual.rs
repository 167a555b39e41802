//! What robots of one make differ by without anything being wrong with them.

use mlr_filter::{Axes, OrientationSeries, SettingError};
use mlr_model::{ModelError, Morphology};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{Prediction, WalkModel, WalkRecord};

/// Standard deviations of the usual differences between a robot and its description.
/// They are fitted along with every effect, each at the price of its size, so that
/// only what goes beyond them is put down to an effect.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct UsualDifferences {
    /// Roll and pitch at which the sensor is mounted.
    pub misalignment_deg: f64,
    /// Roll and pitch that the standing sensor's accelerometer is off, where rates are
    /// integrated from there on.
    pub level_deg: f64,
    /// Rates that the gyroscope reports at rest.
    pub bias_dps: f64,
    /// Relative error of its scale: half of what the data sheet of an MPU-6050 allows for.
    pub scale: f64,
    /// Error of the time found for the start of the walk.
    pub start_s: f64,
    /// The same where it was told.
    pub told_start_s: f64,
    /// Relative error of the gait's clock.
    pub clock: f64,
    /// Logarithm of the servos' stiffness.
    pub ln_stiffness: f64,
    /// Logarithm of their damping.
    pub ln_damping: f64,
    /// Logarithm of the ground's friction.
    pub ln_friction: f64,
    /// Position of the body's centre of mass along x, y and z.
    pub center_of_mass_m: f64,
    /// How much further the walking model leans than the robot, in roll and pitch.
    pub lean_deg: f64,
    /// The same where a sensor's own filter made roll and pitch: it takes some of the body's
    /// accelerations for tilt.
    pub filtered_lean_deg: f64,
    /// How much faster the robot turns than the model once it takes full strides, besides a
    /// share of its turning.
    pub turning_dps: f64,
    /// That share.
    pub turning_share: f64,
}

impl Default for UsualDifferences {
    fn default() -> Self {
        Self {
            misalignment_deg: 0.5,
            level_deg: 0.3,
            bias_dps: 0.2,
            scale: 0.015,
            start_s: 0.04,
            told_start_s: 0.006,
            clock: 0.003,
            ln_stiffness: 0.12,
            ln_damping: 0.2,
            ln_friction: 0.12,
            center_of_mass_m: 0.0025,
            lean_deg: 0.08,
            filtered_lean_deg: 0.2,
            turning_dps: 0.3,
            turning_share: 0.25,
        }
    }
}

impl UsualDifferences {
    /// Checks every number. A deviation of zero says that robots do not differ by this.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        for (name, deviation, most, unit) in [
            ("misalignment_deg", self.misalignment_deg, 45.0, "degrees"),
            ("level_deg", self.level_deg, 45.0, "degrees"),
            ("bias_dps", self.bias_dps, 100.0, "°/s"),
            ("scale", self.scale, 1.0, ""),
            ("start_s", self.start_s, 10.0, "s"),
            ("told_start_s", self.told_start_s, 10.0, "s"),
            ("clock", self.clock, 1.0, ""),
            ("ln_stiffness", self.ln_stiffness, 5.0, ""),
            ("ln_damping", self.ln_damping, 5.0, ""),
            ("ln_friction", self.ln_friction, 5.0, ""),
            ("center_of_mass_m", self.center_of_mass_m, 1.0, "m"),
            ("lean_deg", self.lean_deg, 45.0, "degrees"),
            ("filtered_lean_deg", self.filtered_lean_deg, 45.0, "degrees"),
            ("turning_dps", self.turning_dps, 100.0, "°/s"),
            ("turning_share", self.turning_share, 10.0, ""),
        ] {
            SettingError::check(name, deviation, 0.0..=most, unit)?;
        }
        Ok(())
    }
}

/// One of the usual differences.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Difference {
    /// Where yaw is zero.
    YawZero,
    /// Lean of the walking body, roll or pitch.
    Lean(usize),
    /// Rate at which the walking body turns.
    Turning,
    /// Share of the turning that the model shows.
    TurningShare,
    /// Start of the walk.
    Start,
    /// The gait's clock.
    Clock,
    /// Mounting of the sensor, roll or pitch.
    Misalignment(usize),
    /// The level that rates are integrated from, roll or pitch.
    Level(usize),
    /// Bias about x, y or z.
    Bias(usize),
    /// Scale of the gyroscope.
    Scale,
    /// Stiffness of the servos.
    Stiffness,
    /// Damping of the servos.
    Damping,
    /// Friction of the ground.
    Friction,
    /// Centre of mass of the body along x, y or z.
    CenterOfMass(usize),
}

/// What one standard deviation of a usual difference adds to what is measured.
#[derive(Debug, Clone)]
pub(crate) struct Trace {
    /// To roll, pitch and yaw, degrees.
    pub(crate) angles_deg: Axes<Vec<f64>>,
    /// To the raw rates at rest, degrees per second.
    pub(crate) rest_rate_dps: [f64; 3],
}

/// The walk of a model and the walks of models that differ from it in one thing.
#[derive(Debug)]
pub(crate) struct NearbyWalks {
    /// How many samples of the record they cover.
    samples: usize,
    body: OrientationSeries,
    changed: Vec<(Difference, OrientationSeries)>,
}

/// A yaw angle has no zero: this much off is nothing.
const ANY_YAW_DEG: f64 = 180.0;

impl Difference {
    /// All of them, in the order of their traces.
    pub(crate) const ALL: [Self; 21] = [
        Self::YawZero,
        Self::Lean(0),
        Self::Lean(1),
        Self::Turning,
        Self::TurningShare,
        Self::Start,
        Self::Clock,
        Self::Misalignment(0),
        Self::Misalignment(1),
        Self::Level(0),
        Self::Level(1),
        Self::Bias(0),
        Self::Bias(1),
        Self::Bias(2),
        Self::Scale,
        Self::Stiffness,
        Self::Damping,
        Self::Friction,
        Self::CenterOfMass(0),
        Self::CenterOfMass(1),
        Self::CenterOfMass(2),
    ];

    /// The sizes of a robot that is as described.
    pub(crate) fn none() -> Vec<f64> {
        vec![0.0; Self::ALL.len()]
    }

    /// Its name in reports.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::YawZero => "heading",
            Self::Lean(0) => "lean_roll",
            Self::Lean(_) => "lean_pitch",
            Self::Turning => "turning",
            Self::TurningShare => "turning_share",
            Self::Start => "start",
            Self::Clock => "clock",
            Self::Misalignment(0) => "misalignment_roll",
            Self::Misalignment(_) => "misalignment_pitch",
            Self::Level(0) => "level_roll",
            Self::Level(_) => "level_pitch",
            Self::Bias(0) => "bias_x",
            Self::Bias(1) => "bias_y",
            Self::Bias(_) => "bias_z",
            Self::Scale => "scale",
            Self::Stiffness => "stiffness",
            Self::Damping => "damping",
            Self::Friction => "friction",
            Self::CenterOfMass(0) => "center_of_mass_x",
            Self::CenterOfMass(1) => "center_of_mass_y",
            Self::CenterOfMass(_) => "center_of_mass_z",
        }
    }

    /// Whether it only says where yaw and time have their zeros.
    pub(crate) fn is_of_zeros(self) -> bool {
        matches!(self, Self::YawZero | Self::Start)
    }

    /// Whether the body walks otherwise for it.
    pub(crate) fn is_of_body(self) -> bool {
        matches!(
            self,
            Self::Stiffness | Self::Damping | Self::Friction | Self::CenterOfMass(_)
        )
    }

    /// Whether a model can have it, rather than only a comparison.
    pub(crate) fn is_of_model(self) -> bool {
        !matches!(
            self,
            Self::YawZero | Self::Lean(_) | Self::Turning | Self::TurningShare
        )
    }

    /// Makes a model differ by so many standard deviations.
    pub(crate) fn apply(
        self,
        usual: &UsualDifferences,
        size: f64,
        record: &WalkRecord,
        model: &mut WalkModel,
    ) {
        let sensing = &mut model.sensing;
        match self {
            Self::YawZero | Self::Lean(_) | Self::Turning | Self::TurningShare => {}
            Self::Start => {
                sensing.delay_s += size
                    * if record.start_is_told() {
                        usual.told_start_s
                    } else {
                        usual.start_s
                    };
            }
            Self::Clock => model.clock *= 1.0 + size * usual.clock,
            Self::Misalignment(axis) => {
                sensing.misalignment_deg[axis] += size * usual.misalignment_deg;
            }
            Self::Level(axis) if record.is_dead_reckoned() => {
                sensing.level_deg[axis] += size * usual.level_deg;
            }
            Self::Level(_) => {}
            Self::Bias(axis) => sensing.bias_dps[axis] += size * usual.bias_dps,
            Self::Scale => sensing.scale *= 1.0 + size * usual.scale,
            Self::Stiffness => {
                model.servo.stiffness_nm_per_rad *= (size * usual.ln_stiffness).exp();
            }
            Self::Damping => {
                model.servo.damping_nm_s_per_rad *= (size * usual.ln_damping).exp();
            }
            Self::Friction => model.simulation.contact.friction *= (size * usual.ln_friction).exp(),
            Self::CenterOfMass(axis) => {
                let mut by_m = [0.0; 3];
                by_m[axis] = size * usual.center_of_mass_m;
                model.move_center_of_mass(by_m);
            }
        }
    }
}

impl NearbyWalks {
    /// Walks the first `samples` samples of the record, once for the model and once for each
    /// usual difference of the body; `None` when the model itself diverges.
    ///
    /// # Errors
    /// [`ModelError`] when the model makes no sense.
    pub(crate) fn new(
        usual: &UsualDifferences,
        model: &WalkModel,
        morphology: &Morphology,
        record: &WalkRecord,
        samples: usize,
    ) -> Result<Option<Self>, ModelError> {
        let of_body = Difference::ALL.into_iter().filter(|d| d.is_of_body());
        let of_body = of_body.map(Some).collect();
        Self::of(usual, model, morphology, record, samples, of_body)
    }

    /// Walks the model only, to the end of the fitted stretch: usual differences of the body
    /// leave no trace then, and of the unseen stretch nothing is known.
    ///
    /// # Errors
    /// [`ModelError`] when the model makes no sense.
    pub(crate) fn alone(
        usual: &UsualDifferences,
        model: &WalkModel,
        morphology: &Morphology,
        record: &WalkRecord,
    ) -> Result<Option<Self>, ModelError> {
        let samples = record.fit().end;
        Self::of(usual, model, morphology, record, samples, Vec::new())
    }

    fn of(
        usual: &UsualDifferences,
        model: &WalkModel,
        morphology: &Morphology,
        record: &WalkRecord,
        samples: usize,
        of_body: Vec<Option<Difference>>,
    ) -> Result<Option<Self>, ModelError> {
        let models: Vec<(Option<Difference>, WalkModel)> = std::iter::once(None)
            .chain(of_body)
            .map(|difference| {
                let mut changed = model.clone();
                if let Some(difference) = difference {
                    difference.apply(usual, 1.0, record, &mut changed);
                }
                (difference, changed)
            })
            .collect();
        let walks = models
            .into_par_iter()
            .map(|(difference, model)| {
                let walk = model.walk(morphology, record, samples)?;
                Ok(walk.map(|walk| (difference, walk)))
            })
            .collect::<Result<Vec<_>, ModelError>>()?;
        let mut walks = walks.into_iter();
        let Some((None, body)) = walks.next().flatten() else {
            return Ok(None);
        };
        let changed = walks.flatten();
        Ok(Some(Self {
            samples,
            body,
            changed: changed
                .filter_map(|(difference, walk)| Some((difference?, walk)))
                .collect(),
        }))
    }

    /// What the model's sensor reports of these samples.
    pub(crate) fn predicted(&self, model: &WalkModel, record: &WalkRecord) -> Prediction {
        model.predict(&self.body, record, self.samples)
    }

    /// The traces of all usual differences, in their order. One whose walk diverges
    /// leaves none.
    pub(crate) fn traces(
        &self,
        usual: &UsualDifferences,
        model: &WalkModel,
        record: &WalkRecord,
    ) -> Vec<Trace> {
        let samples = self.samples;
        let plain = self.predicted(model, record);
        let of_body = |wanted: Difference| {
            let mut walks = self.changed.iter();
            let walk = walks.find(|(difference, _)| *difference == wanted);
            walk.map_or_else(
                || Trace::of_angles(Axes::from_fn(|_| vec![0.0; samples])),
                |(_, walk)| Trace::between(&plain, &model.predict(walk, record, samples)),
            )
        };
        let of_sensing = |wanted: Difference| {
            let mut changed = model.clone();
            wanted.apply(usual, 1.0, record, &mut changed);
            Trace::between(&plain, &self.predicted(&changed, record))
        };
        Difference::ALL
            .into_iter()
            .map(|wanted| {
                if wanted.is_of_body() {
                    of_body(wanted)
                } else if wanted.is_of_model() {
                    of_sensing(wanted)
                } else {
                    let stride_s = model.clock * model.gait.period_s;
                    Trace::of_angles(usual.of_comparison(
                        wanted,
                        &plain.angles_deg,
                        stride_s,
                        record,
                    ))
                }
            })
            .collect()
    }
}

impl Trace {
    /// What leads from one prediction to another.
    pub(crate) fn between(from: &Prediction, to: &Prediction) -> Self {
        Self {
            angles_deg: difference(&to.angles_deg, &from.angles_deg),
            rest_rate_dps: [0, 1, 2].map(|axis| to.rest_rate_dps[axis] - from.rest_rate_dps[axis]),
        }
    }

    fn of_angles(angles_deg: Axes<Vec<f64>>) -> Self {
        Self {
            angles_deg,
            rest_rate_dps: [0.0; 3],
        }
    }
}

impl UsualDifferences {
    /// The trace of a difference that no model has.
    fn of_comparison(
        &self,
        wanted: Difference,
        plain: &Axes<Vec<f64>>,
        stride_s: f64,
        record: &WalkRecord,
    ) -> Axes<Vec<f64>> {
        let times_s = &record.times_s()[..plain.yaw.len()];
        let walked_s = |time_s: f64| (time_s - record.start_s()).max(0.0);
        let start_index = times_s.partition_point(|time_s| *time_s < record.start_s());
        let yaw_at_start_deg = plain.yaw.get(start_index).copied().unwrap_or(0.0);
        let value = |index: usize, time_s: f64| match (wanted, walked_s(time_s)) {
            (Difference::YawZero, _) => ANY_YAW_DEG,
            (_, 0.0) => 0.0,
            (Difference::Lean(_), _) if record.is_dead_reckoned() => self.lean_deg,
            (Difference::Lean(_), _) => self.filtered_lean_deg,
            // Strides grow over the first cycle.
            (Difference::Turning, walked_s) if walked_s < stride_s => {
                self.turning_dps * walked_s * walked_s / (2.0 * stride_s)
            }
            (Difference::Turning, walked_s) => self.turning_dps * (walked_s - stride_s / 2.0),
            (_, _) => self.turning_share * (plain.yaw[index] - yaw_at_start_deg),
        };
        let changed = times_s
            .iter()
            .enumerate()
            .map(|(k, time_s)| value(k, *time_s));
        let mut angles_deg = Axes::from_fn(|_| vec![0.0; times_s.len()]);
        let axis = match wanted {
            Difference::Lean(0) => &mut angles_deg.roll,
            Difference::Lean(_) => &mut angles_deg.pitch,
            _ => &mut angles_deg.yaw,
        };
        *axis = changed.collect();
        angles_deg
    }
}

/// Sample by sample, axis by axis.
pub(crate) fn difference(a: &Axes<Vec<f64>>, b: &Axes<Vec<f64>>) -> Axes<Vec<f64>> {
    let subtract = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect();
    Axes {
        roll: subtract(&a.roll, &b.roll),
        pitch: subtract(&a.pitch, &b.pitch),
        yaw: subtract(&a.yaw, &b.yaw),
    }
}

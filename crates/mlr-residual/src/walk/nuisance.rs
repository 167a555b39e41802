//! Nuisance parameters: what robots of one make differ by without anything being wrong.

use mlr_filter::SettingError;
use mlr_model::{Calibration, Fault, Gaussian, Morphology, RobotParameter};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::{WalkModel, WalkRecord};

/// Standard deviations of the nuisance parameters about the robot's description. Each
/// parameter has a normal prior.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct NuisanceSettings {
    /// Roll, pitch and yaw at which the sensor is mounted: glued on by hand.
    pub misalignment_deg: f64,
    /// Roll and pitch of the standing sensor as its accelerometer shows them: 5 mg of bias, a
    /// tenth of what the data sheet of an MPU-6050 allows before calibration.
    pub level_deg: f64,
    /// Rates that the gyroscope reports at rest after its own calibration.
    pub bias_dps: f64,
    /// Relative error of the gyroscope's scale: half of the 3 % in the data sheet of an MPU-6050.
    pub scale: f64,
    /// Error of the time found for the start of the walk.
    pub start_s: f64,
    /// The same where the start was commanded.
    pub commanded_start_s: f64,
    /// Relative error of the gait's clock.
    pub clock: f64,
    /// Logarithm of the servos' stiffness.
    pub ln_stiffness: f64,
    /// The same of one robot from day to day: the charge of its battery, the warmth of its servos.
    pub day_ln_stiffness: f64,
    /// Logarithm of their damping.
    pub ln_damping: f64,
    /// Play of the gears of a robot whose description has none: new servos have a quarter to half a
    /// degree.
    pub backlash_rad: f64,
    /// Logarithm of the play of the gears.
    pub ln_backlash: f64,
    /// Logarithm of the ground's friction.
    pub ln_friction: f64,
    /// Logarithm of the natural frequency of a contact.
    pub ln_contact_frequency: f64,
    /// Logarithm of the body's mass.
    pub ln_body_mass: f64,
    /// Position of the body's centre of mass along x, y and z.
    pub center_of_mass_m: f64,
    /// Zero of every joint: a servo's horn trimmed by eye.
    pub joint_zero_rad: f64,
    /// How far off the body of a robot is, and the scale of its gyroscope, that an engine makes walk like a given one, in
    /// standard deviations of the make: more walks of one kind do not tell it.
    pub engine_bias: f64,
}

impl Default for NuisanceSettings {
    fn default() -> Self {
        Self {
            misalignment_deg: 0.6,
            level_deg: 0.3,
            bias_dps: 0.2,
            scale: 0.015,
            start_s: 0.04,
            commanded_start_s: 0.006,
            clock: 0.003,
            ln_stiffness: 0.12,
            day_ln_stiffness: 0.04,
            ln_damping: 0.2,
            backlash_rad: 0.005,
            ln_backlash: 0.6,
            ln_friction: 0.12,
            ln_contact_frequency: 0.3,
            ln_body_mass: 0.02,
            center_of_mass_m: 0.0025,
            joint_zero_rad: 0.015,
            engine_bias: 0.7,
        }
    }
}

impl NuisanceSettings {
    /// Standard deviation of a robot's own parameter among robots of its make, in the coordinate of
    /// the parameter.
    pub fn of_make(&self, parameter: RobotParameter) -> f64 {
        match parameter {
            RobotParameter::ServoStiffness => self.ln_stiffness,
            RobotParameter::ServoDamping => self.ln_damping,
            RobotParameter::BodyMass => self.ln_body_mass,
            RobotParameter::CenterOfMass(_) => self.center_of_mass_m,
            RobotParameter::JointZero { .. } => self.joint_zero_rad,
            RobotParameter::ImuMounting(_) => self.misalignment_deg,
            RobotParameter::GyroScale => self.scale,
            RobotParameter::Clock => self.clock,
        }
    }

    /// The play of the gears of a robot as described, or as its make has it.
    pub(crate) fn usual_backlash_rad(&self, described_rad: f64) -> f64 {
        match described_rad > 0.0 {
            true => described_rad,
            false => self.backlash_rad,
        }
    }

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
            ("commanded_start_s", self.commanded_start_s, 10.0, "s"),
            ("clock", self.clock, 1.0, ""),
            ("ln_stiffness", self.ln_stiffness, 5.0, ""),
            ("day_ln_stiffness", self.day_ln_stiffness, 5.0, ""),
            ("ln_damping", self.ln_damping, 5.0, ""),
            ("backlash_rad", self.backlash_rad, 1.0, "rad"),
            ("ln_backlash", self.ln_backlash, 5.0, ""),
            ("ln_friction", self.ln_friction, 5.0, ""),
            ("ln_contact_frequency", self.ln_contact_frequency, 5.0, ""),
            ("ln_body_mass", self.ln_body_mass, 5.0, ""),
            ("center_of_mass_m", self.center_of_mass_m, 1.0, "m"),
            ("joint_zero_rad", self.joint_zero_rad, 1.0, "rad"),
            ("engine_bias", self.engine_bias, 100.0, ""),
        ] {
            SettingError::check(name, deviation, 0.0..=most, unit)?;
        }
        Ok(())
    }
}

/// One nuisance parameter. Legs and joints are counted from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Nuisance {
    /// Start of the walk.
    Start,
    /// The gait's clock.
    Clock,
    /// Mounting of the sensor, roll, pitch or yaw.
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
    /// Play of their gears.
    Backlash,
    /// Friction of the ground.
    Friction,
    /// Natural frequency of a contact.
    ContactFrequency,
    /// Mass of the body.
    BodyMass,
    /// Centre of mass of the body along x, y or z.
    CenterOfMass(usize),
    /// Zero of a joint: leg and joint.
    JointZero(usize, usize),
}

impl Nuisance {
    /// Those of the sensor and the clock, for which no body has to walk.
    const OF_SENSING: [Self; 11] = [
        Self::Start,
        Self::Clock,
        Self::Misalignment(0),
        Self::Misalignment(1),
        Self::Misalignment(2),
        Self::Level(0),
        Self::Level(1),
        Self::Bias(0),
        Self::Bias(1),
        Self::Bias(2),
        Self::Scale,
    ];
    /// Those of the body as a whole.
    const OF_BODY: [Self; 9] = [
        Self::Stiffness,
        Self::Damping,
        Self::Backlash,
        Self::Friction,
        Self::ContactFrequency,
        Self::BodyMass,
        Self::CenterOfMass(0),
        Self::CenterOfMass(1),
        Self::CenterOfMass(2),
    ];

    /// Those that the walk of a robot with these links may show.
    pub(crate) fn of(morphology: &Morphology, record: &WalkRecord) -> Vec<Self> {
        let joints = (0..morphology.legs()).flat_map(|leg| {
            (0..morphology.remaining(leg)).map(move |joint| Self::JointZero(leg, joint))
        });
        Self::OF_SENSING
            .into_iter()
            .filter(|one| record.is_dead_reckoned() || !matches!(one, Self::Level(_)))
            .chain(Self::OF_BODY)
            .chain(joints)
            .collect()
    }

    /// Name in reports.
    pub(crate) fn name(self) -> String {
        let axis = |axis: usize| ["x", "y", "z"].get(axis).copied().unwrap_or("?");
        let tilt = |axis: usize| ["roll", "pitch", "yaw"].get(axis).copied().unwrap_or("?");
        match self {
            Self::Start => "start".into(),
            Self::Clock => "clock".into(),
            Self::Misalignment(of) => format!("misalignment_{}", tilt(of)),
            Self::Level(of) => format!("level_{}", tilt(of)),
            Self::Bias(of) => format!("bias_{}", axis(of)),
            Self::Scale => "scale".into(),
            Self::Stiffness => "stiffness".into(),
            Self::Damping => "damping".into(),
            Self::Backlash => "backlash".into(),
            Self::Friction => "friction".into(),
            Self::ContactFrequency => "contact_frequency".into(),
            Self::BodyMass => "body_mass".into(),
            Self::CenterOfMass(of) => format!("center_of_mass_{}", axis(of)),
            Self::JointZero(leg, joint) => format!("joint_zero_leg{}_{}", leg + 1, joint + 1),
        }
    }

    /// Whether the body walks the same whatever its value.
    pub(crate) fn is_of_sensing(self) -> bool {
        Self::OF_SENSING.contains(&self)
    }

    /// How far off what the physics engine gets wrong makes it, in standard deviations of the make, where it makes the body
    /// so: as far as the body for the gyroscope's scale, because engines differ in how fast robots turn, and not at all
    /// for the rest of the sensor and the clock.
    pub(super) fn engine_bias(self, of_body: f64) -> f64 {
        match self.is_of_sensing() && self != Self::Scale {
            true => 0.0,
            false => of_body,
        }
    }

    /// The parameter of the robot that it is, if it stays with the robot from day to day.
    pub(crate) fn parameter(self) -> Option<RobotParameter> {
        Some(match self {
            Self::Clock => RobotParameter::Clock,
            Self::Misalignment(axis) => RobotParameter::ImuMounting(axis),
            Self::Scale => RobotParameter::GyroScale,
            Self::Stiffness => RobotParameter::ServoStiffness,
            Self::Damping => RobotParameter::ServoDamping,
            Self::BodyMass => RobotParameter::BodyMass,
            Self::CenterOfMass(axis) => RobotParameter::CenterOfMass(axis),
            Self::JointZero(leg, joint) => RobotParameter::JointZero { leg, joint },
            Self::Start
            | Self::Level(_)
            | Self::Bias(_)
            | Self::Backlash
            | Self::Friction
            | Self::ContactFrequency => return None,
        })
    }

    /// Standard deviation among robots of one make, in the coordinate of the parameter.
    pub(crate) fn deviation(self, settings: &NuisanceSettings, record: &WalkRecord) -> f64 {
        match self {
            Self::Start if record.start_is_told() => settings.commanded_start_s,
            Self::Start => settings.start_s,
            Self::Level(_) => settings.level_deg,
            Self::Bias(_) => settings.bias_dps,
            Self::Backlash => settings.ln_backlash,
            Self::Friction => settings.ln_friction,
            Self::ContactFrequency => settings.ln_contact_frequency,
            _ => self.parameter().map_or(0.0, |own| settings.of_make(own)),
        }
    }

    /// How far the parameter of one robot strays from day to day, in its coordinate.
    pub(crate) fn day_deviation(self, settings: &NuisanceSettings) -> f64 {
        match self {
            Self::Stiffness => settings.day_ln_stiffness,
            _ => 0.0,
        }
    }

    /// How many standard deviations the second model differs by from the first: the reverse of
    /// [`Self::apply`].
    pub(crate) fn z_score(
        self,
        settings: &NuisanceSettings,
        record: &WalkRecord,
        from: &WalkModel,
        to: &WalkModel,
    ) -> f64 {
        let by = self.change(from, to);
        let deviation = self.deviation(settings, record);
        // What the settings say robots do not differ by has no deviation to count in.
        if deviation > 0.0 && by.is_finite() {
            by / deviation
        } else {
            0.0
        }
    }

    /// How far the second model is off the first in this parameter: the logarithm of their ratio where robots differ
    /// by a factor.
    pub(crate) fn change(self, from: &WalkModel, to: &WalkModel) -> f64 {
        let difference = |of: fn(&WalkModel, usize) -> f64, axis| of(to, axis) - of(from, axis);
        let ratio = |of: fn(&WalkModel) -> f64| (of(to) / of(from)).ln();
        match self {
            Self::Start => to.sensing.delay_s - from.sensing.delay_s,
            Self::Clock => ratio(|model| model.clock * model.gait.period_s),
            Self::Misalignment(axis) => {
                difference(|model, axis| model.sensing.misalignment_deg[axis], axis)
            }
            Self::Level(axis) => difference(|model, axis| model.sensing.level_deg[axis], axis),
            Self::Bias(axis) => difference(|model, axis| model.sensing.bias_dps[axis], axis),
            Self::Scale => ratio(|model| model.sensing.scale),
            Self::Stiffness => ratio(|model| model.servo.stiffness_nm_per_rad),
            Self::Damping => ratio(|model| model.servo.damping_nm_s_per_rad),
            Self::Backlash => ratio(|model| model.servo.drive.backlash_rad),
            Self::Friction => ratio(|model| model.simulation.contact.friction),
            Self::ContactFrequency => ratio(|model| model.simulation.contact.natural_frequency_hz),
            Self::BodyMass | Self::CenterOfMass(_) => self.parameter().map_or(0.0, |parameter| {
                parameter.coordinate(&to.robot) - parameter.coordinate(&from.robot)
            }),
            Self::JointZero(leg, joint) => {
                let offset_rad = |model: &WalkModel| -> f64 {
                    let faults = model.simulation.faults.iter();
                    let of_joint = faults.map(|fault| match fault {
                        Fault::JointOffset {
                            leg: of_leg,
                            joint: of_joint,
                            angle_rad,
                        } if (*of_leg, *of_joint) == (leg + 1, joint + 1) => *angle_rad,
                        _ => 0.0,
                    });
                    of_joint.sum()
                };
                offset_rad(to) - offset_rad(from)
            }
        }
    }

    /// Makes a model differ by so many standard deviations.
    pub(crate) fn apply(
        self,
        settings: &NuisanceSettings,
        z_score: f64,
        record: &WalkRecord,
        model: &mut WalkModel,
    ) {
        let by = z_score * self.deviation(settings, record);
        let sensing = &mut model.sensing;
        match self {
            Self::Start => sensing.delay_s += by,
            Self::Clock => model.clock *= by.exp(),
            Self::Misalignment(axis) => sensing.misalignment_deg[axis] += by,
            Self::Level(axis) => sensing.level_deg[axis] += by,
            Self::Bias(axis) => sensing.bias_dps[axis] += by,
            Self::Scale => sensing.scale *= by.exp(),
            Self::Stiffness => model.servo.stiffness_nm_per_rad *= by.exp(),
            Self::Damping => model.servo.damping_nm_s_per_rad *= by.exp(),
            Self::Backlash => model.servo.drive.backlash_rad *= by.exp(),
            Self::Friction => model.simulation.contact.friction *= by.exp(),
            Self::ContactFrequency => {
                model.simulation.contact.natural_frequency_hz *= by.exp();
            }
            Self::BodyMass | Self::CenterOfMass(_) => {
                if let Some(parameter) = self.parameter() {
                    model.robot = model.robot.clone().with_added(parameter, by);
                }
            }
            Self::JointZero(leg, joint) => {
                if z_score != 0.0 {
                    model.simulation.faults.push(Fault::JointOffset {
                        leg: leg + 1,
                        joint: joint + 1,
                        angle_rad: by,
                    });
                }
            }
        }
    }
}

/// What is known of the nuisance parameters before a record is seen: how robots of one make differ,
/// and what calibration told of this one.
#[derive(Debug, Clone)]
pub(crate) struct NuisancePrior {
    pub(crate) settings: NuisanceSettings,
    calibration: Option<Calibration>,
}

impl NuisancePrior {
    /// The prior of the robot of a model.
    pub(crate) fn new(settings: &NuisanceSettings, model: &WalkModel) -> Self {
        Self {
            settings: *settings,
            calibration: model.robot.calibration().cloned(),
        }
    }

    /// A lower triangular matrix that makes deviations of these parameters, in standard deviations
    /// of their make, of coordinates that are independent and standard normal. `None` for a robot of
    /// which nothing more is known than its make: deviations are coordinates then.
    pub(crate) fn mixing(
        &self,
        nuisances: &[Nuisance],
        record: &WalkRecord,
    ) -> Option<DMatrix<f64>> {
        let calibration = self.calibration.as_ref()?;
        let mut covariance =
            self.in_units(calibration, calibration.covariance(), nuisances, record);
        for (i, nuisance) in nuisances.iter().enumerate() {
            let of_make = nuisance.deviation(&self.settings, record);
            let day = nuisance.day_deviation(&self.settings) / of_make.max(f64::MIN_POSITIVE);
            // What the settings say robots do not differ by has no deviation to scale.
            covariance[(i, i)] = (covariance[(i, i)] + day * day).clamp(SMALLEST, 1.0 / SMALLEST);
        }
        covariance.cholesky().map(|factors| factors.unpack())
    }

    /// What is known of the robot's own parameters, in standard deviations of the make from where the
    /// model has them.
    pub(crate) fn physical(
        &self,
        nuisances: &[Nuisance],
        record: &WalkRecord,
        model: &WalkModel,
    ) -> Gaussian {
        let n = nuisances.len();
        let Some(calibration) = &self.calibration else {
            return Gaussian {
                mean: DVector::zeros(n),
                covariance: DMatrix::identity(n, n),
            };
        };
        let physical = calibration.physical();
        let mean = |nuisance: &Nuisance| -> Option<f64> {
            let parameter = nuisance.parameter()?;
            let off =
                physical.mean[calibration.row(parameter)?] - parameter.coordinate(&model.robot);
            let of_make = nuisance.deviation(&self.settings, record);
            (of_make > 0.0).then_some(off / of_make)
        };
        Gaussian {
            mean: DVector::from_iterator(n, nuisances.iter().map(|one| mean(one).unwrap_or(0.0))),
            covariance: self.in_units(calibration, &physical.covariance, nuisances, record),
        }
    }

    /// The covariance of these parameters in standard deviations of the make; 1 for each of which
    /// nothing more is known.
    fn in_units(
        &self,
        calibration: &Calibration,
        covariance: &DMatrix<f64>,
        nuisances: &[Nuisance],
        record: &WalkRecord,
    ) -> DMatrix<f64> {
        let known: Vec<Option<(usize, f64)>> = nuisances
            .iter()
            .map(|nuisance| {
                let of_make = nuisance.deviation(&self.settings, record);
                let row = calibration.row(nuisance.parameter()?)?;
                (of_make > 0.0).then_some((row, of_make))
            })
            .collect();
        DMatrix::from_fn(nuisances.len(), nuisances.len(), |i, j| {
            match (known[i], known[j]) {
                (Some((row, of_row)), Some((column, of_column))) => {
                    covariance[(row, column)] / (of_row * of_column)
                }
                _ if i == j => 1.0,
                _ => 0.0,
            }
        })
    }
}

/// Least variance of a calibrated parameter, of its variance among robots of one make.
const SMALLEST: f64 = 1e-8;

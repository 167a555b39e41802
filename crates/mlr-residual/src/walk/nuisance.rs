//! Nuisance parameters: what robots of one make differ by without anything being wrong.

use mlr_filter::SettingError;
use mlr_model::{Fault, Morphology};
use serde::{Deserialize, Serialize};

use super::{WalkModel, WalkRecord};

/// Standard deviations of the nuisance parameters about the robot's description. Each
/// parameter has a normal prior.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NuisanceSettings {
    /// Roll and pitch at which the sensor is mounted: glued on by hand.
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
    /// Logarithm of their damping.
    pub ln_damping: f64,
    /// Logarithm of the ground's friction.
    pub ln_friction: f64,
    /// Logarithm of the natural frequency of a contact.
    pub ln_contact_frequency: f64,
    /// Position of the body's centre of mass along x, y and z.
    pub center_of_mass_m: f64,
    /// Zero of every joint: a servo's horn trimmed by eye.
    pub joint_zero_rad: f64,
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
            ln_damping: 0.2,
            ln_friction: 0.12,
            ln_contact_frequency: 0.3,
            center_of_mass_m: 0.0025,
            joint_zero_rad: 0.015,
        }
    }
}

impl NuisanceSettings {
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
            ("ln_damping", self.ln_damping, 5.0, ""),
            ("ln_friction", self.ln_friction, 5.0, ""),
            ("ln_contact_frequency", self.ln_contact_frequency, 5.0, ""),
            ("center_of_mass_m", self.center_of_mass_m, 1.0, "m"),
            ("joint_zero_rad", self.joint_zero_rad, 1.0, "rad"),
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
    /// Natural frequency of a contact.
    ContactFrequency,
    /// Centre of mass of the body along x, y or z.
    CenterOfMass(usize),
    /// Zero of a joint: leg and joint.
    JointZero(usize, usize),
}

impl Nuisance {
    /// Those of the sensor and the clock, for which no body has to walk.
    const OF_SENSING: [Self; 10] = [
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
    ];
    /// Those of the body as a whole.
    const OF_BODY: [Self; 7] = [
        Self::Stiffness,
        Self::Damping,
        Self::Friction,
        Self::ContactFrequency,
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
        let tilt = |axis: usize| if axis == 0 { "roll" } else { "pitch" };
        match self {
            Self::Start => "start".into(),
            Self::Clock => "clock".into(),
            Self::Misalignment(of) => format!("misalignment_{}", tilt(of)),
            Self::Level(of) => format!("level_{}", tilt(of)),
            Self::Bias(of) => format!("bias_{}", axis(of)),
            Self::Scale => "scale".into(),
            Self::Stiffness => "stiffness".into(),
            Self::Damping => "damping".into(),
            Self::Friction => "friction".into(),
            Self::ContactFrequency => "contact_frequency".into(),
            Self::CenterOfMass(of) => format!("center_of_mass_{}", axis(of)),
            Self::JointZero(leg, joint) => format!("joint_zero_leg{}_{}", leg + 1, joint + 1),
        }
    }

    /// Whether the body walks the same whatever its value.
    pub(crate) fn is_of_sensing(self) -> bool {
        Self::OF_SENSING.contains(&self)
    }

    /// Makes a model differ by so many standard deviations.
    pub(crate) fn apply(
        self,
        settings: &NuisanceSettings,
        z_score: f64,
        record: &WalkRecord,
        model: &mut WalkModel,
    ) {
        let sensing = &mut model.sensing;
        match self {
            Self::Start => {
                let deviation_s = match record.start_is_told() {
                    true => settings.commanded_start_s,
                    false => settings.start_s,
                };
                sensing.delay_s += z_score * deviation_s;
            }
            Self::Clock => model.clock *= 1.0 + z_score * settings.clock,
            Self::Misalignment(axis) => {
                sensing.misalignment_deg[axis] += z_score * settings.misalignment_deg;
            }
            Self::Level(axis) => sensing.level_deg[axis] += z_score * settings.level_deg,
            Self::Bias(axis) => sensing.bias_dps[axis] += z_score * settings.bias_dps,
            Self::Scale => sensing.scale *= 1.0 + z_score * settings.scale,
            Self::Stiffness => {
                model.servo.stiffness_nm_per_rad *= (z_score * settings.ln_stiffness).exp();
            }
            Self::Damping => {
                model.servo.damping_nm_s_per_rad *= (z_score * settings.ln_damping).exp();
            }
            Self::Friction => {
                model.simulation.contact.friction *= (z_score * settings.ln_friction).exp();
            }
            Self::ContactFrequency => {
                model.simulation.contact.natural_frequency_hz *=
                    (z_score * settings.ln_contact_frequency).exp();
            }
            Self::CenterOfMass(axis) => {
                let mut by_m = [0.0; 3];
                by_m[axis] = z_score * settings.center_of_mass_m;
                model.move_center_of_mass(by_m);
            }
            Self::JointZero(leg, joint) => {
                if z_score != 0.0 {
                    model.simulation.faults.push(Fault::JointOffset {
                        leg: leg + 1,
                        joint: joint + 1,
                        angle_rad: z_score * settings.joint_zero_rad,
                    });
                }
            }
        }
    }
}

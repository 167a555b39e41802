//! A servo that swings a pendulum on a bench: the servo of the walking robot, on one joint.

mod swing;

pub use swing::{Command, Swing};

use mlr_filter::SettingError;
use serde::Deserialize;

use crate::{ModelError, Servo, setting_place::located};

/// A servo whose horizontal shaft carries an arm with a weight at its end.
///
/// Angles are those that the servo reports. The arm turns in a vertical plane; which way is positive
/// does not matter.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bench {
    /// For people.
    pub name: String,
    /// What the servo moves.
    pub arm: Arm,
    /// The servo as its data sheet has it.
    pub servo: Servo,
    /// What the numbers of the servo hold for.
    #[serde(default)]
    pub reference: Reference,
}

/// What a servo moves.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Arm {
    /// Mass of the weight and the arm.
    pub mass_kg: f64,
    /// Distance of its centre of mass from the shaft.
    pub length_m: f64,
    /// Moment of inertia about its centre of mass, about the shaft's direction.
    pub inertia_kg_m2: f64,
    /// Reported angle at which it hangs straight down.
    #[serde(default)]
    pub hanging_rad: f64,
}

/// What the numbers of a servo hold for, where recordings say that it was otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Reference {
    /// Value of the servo's gain register, to which its stiffness is in proportion; none where the
    /// gain does not change.
    pub p_gain: Option<f64>,
    /// Supply voltage; none where it is not recorded.
    pub supply_v: Option<f64>,
    /// What the servo reports as its load where its controller makes its largest effort, as 885 of its
    /// pulse width; none where that is not known.
    pub load: Option<f64>,
}

impl Bench {
    /// Reads and checks the description of a bench.
    ///
    /// # Errors
    /// [`ModelError::Syntax`] with line and column when the text is not TOML of the expected form,
    /// [`ModelError::Setting`] when a value makes no sense.
    pub fn from_toml(text: &str) -> Result<Self, ModelError> {
        let bench: Self = toml::from_str(text).map_err(|source| ModelError::Syntax {
            what: "bench",
            source: Box::new(source),
        })?;
        bench.check().map_err(|error| located(error, text))?;
        Ok(bench)
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        let check = SettingError::check::<f64>;
        let Arm {
            mass_kg,
            length_m,
            inertia_kg_m2,
            hanging_rad,
        } = self.arm;
        check("arm.mass_kg", mass_kg, 1e-6..=1e3, "kg")?;
        check("arm.length_m", length_m, 1e-4..=100.0, "m")?;
        check("arm.inertia_kg_m2", inertia_kg_m2, 0.0..=1e6, "kg m²")?;
        check("arm.hanging_rad", hanging_rad, -10.0..=10.0, "rad")?;
        self.servo.check().map_err(|error| error.under("servo"))?;
        for (name, value) in [
            ("reference.p_gain", self.reference.p_gain),
            ("reference.supply_v", self.reference.supply_v),
            ("reference.load", self.reference.load),
        ] {
            if let Some(value) = value {
                check(name, value, 1e-6..=1e6, "")?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BENCH: &str = "name = \"b\"\n[arm]\nmass_kg = 0.5\nlength_m = 0.1\ninertia_kg_m2 = 0\n\
        [servo]\nstiffness_nm_per_rad = 2\ndamping_nm_s_per_rad = 0.05\ntorque_limit_nm = 0.8\n\
        speed_limit_rad_per_s = 1000\ncommand_hold_s = 0.005\nlatency_s = 0\n";

    #[test]
    fn a_bench_is_read_and_what_is_wrong_is_named_with_its_line() {
        let bench = Bench::from_toml(BENCH).unwrap();
        assert_eq!(bench.arm.hanging_rad, 0.0);
        assert_eq!(bench.servo.drive, crate::Drive::default());
        for (from, to, expected) in [
            ("mass_kg = 0.5", "mass_kg = 0", "arm.mass_kg"),
            ("latency_s = 0", "latency_s = -1", "servo.latency_s"),
            ("length_m = 0.1", "length = 0.1", "unknown field `length`"),
        ] {
            let wrong = BENCH.replace(from, to);
            let message = Bench::from_toml(&wrong).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
            assert!(message.contains("line"), "{message}");
        }
    }
}

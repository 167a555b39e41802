//! Effects as explanations report them, put into a model again.

use std::collections::BTreeMap;

use mlr_filter::SettingError;
use mlr_model::{Fault, LostLinks};

use super::{ground_compliance, payload};
use crate::walk::{Reported, WalkModel};

/// Puts an effect that an explanation reports into `model`: what concerns the robot itself, its
/// grip on the ground included. Returns whether it is such an effect; those of the sensor, of the
/// terrain and of the day are not.
///
/// # Errors
/// [`SettingError`] when a parameter is missing.
pub fn apply_reported(
    kind: &str,
    parameters: &BTreeMap<String, Reported>,
    model: &mut WalkModel,
) -> Result<bool, SettingError> {
    let of = ReportedParameters(parameters);
    let quantity = |name: &str| of.quantity(name);
    let count = |name: &str| of.count(name);
    let fault = match kind {
        "payload" => {
            let mass_kg = quantity("mass_kg")?;
            let place_m = [quantity("x_m")?, quantity("y_m")?];
            payload::add(payload::on_deck(mass_kg, place_m, model), model);
            return Ok(true);
        }
        "friction" => {
            model.simulation.contact.friction = quantity("mu")?;
            return Ok(true);
        }
        "servo_stiffness" => {
            model.servo.stiffness_nm_per_rad = quantity("stiffness")?;
            return Ok(true);
        }
        "servo_lag" => {
            model.servo.latency_s += quantity("delay_s")?;
            return Ok(true);
        }
        "joint_friction" => {
            model.servo.drive.coulomb_nm += quantity("torque_nm")?;
            return Ok(true);
        }
        "backlash" => {
            model.servo.drive.backlash_rad += quantity("angle_rad")?;
            return Ok(true);
        }
        "locked_links" => {
            model.simulation.lost_links = LostLinks::Locked;
            return Ok(true);
        }
        "foot_friction" => Fault::FootFriction {
            leg: count("leg")?,
            mu: quantity("mu")?,
        },
        "weak_leg" => Fault::WeakLeg {
            leg: count("leg")?,
            gain: quantity("gain")?,
        },
        "stuck_joint" => Fault::StuckJoint {
            leg: count("leg")?,
            joint: count("joint")?,
            angle_rad: quantity("angle_rad")?,
        },
        "joint_offset" => Fault::JointOffset {
            leg: count("leg")?,
            joint: count("joint")?,
            angle_rad: quantity("angle_rad")?,
        },
        "short_link" => Fault::ShortLink {
            leg: count("leg")?,
            link: count("link")?,
            length_lost_m: quantity("length_lost_m")?,
        },
        _ => return Ok(false),
    };
    model.simulation.faults.push(fault);
    Ok(true)
}

/// The same with what concerns the place and the day: the ground, and what pulls at the robot.
///
/// # Errors
/// Those of [`apply_reported`].
pub fn apply_reported_surroundings(
    kind: &str,
    parameters: &BTreeMap<String, Reported>,
    model: &mut WalkModel,
) -> Result<bool, SettingError> {
    let of = ReportedParameters(parameters);
    match kind {
        "slope" => {
            let terrain = &mut model.simulation.terrain;
            terrain.slope_rad = of.quantity("angle_deg")?.to_radians();
            terrain.uphill_rad = of.quantity("uphill_deg")?.to_radians();
        }
        "ground_compliance" => ground_compliance::soften(of.quantity("stiffness_npm")?, model),
        "external_force" => {
            let force_n = [
                of.quantity("x_n")?,
                of.quantity("y_n")?,
                of.quantity("z_n")?,
            ];
            model
                .simulation
                .faults
                .push(Fault::ExternalForce { force_n });
        }
        _ => return Ok(false),
    }
    Ok(true)
}

/// Parameters of an effect by their names.
struct ReportedParameters<'p>(&'p BTreeMap<String, Reported>);

impl ReportedParameters<'_> {
    fn quantity(&self, name: &str) -> Result<f64, SettingError> {
        match self.0.get(name) {
            Some(Reported::Quantity(value)) => Ok(*value),
            Some(Reported::Number(number)) => Ok(*number as f64),
            _ => Err(self.missing(name, "a number")),
        }
    }

    fn count(&self, name: &str) -> Result<usize, SettingError> {
        match self.0.get(name) {
            Some(Reported::Number(number)) => Ok(*number),
            _ => Err(self.missing(name, "a whole number, from 1")),
        }
    }

    fn missing(&self, name: &str, expected: &str) -> SettingError {
        let found = self.0.get(name);
        let found = found.map_or("nothing".into(), Reported::to_string);
        SettingError::new(format!("parameters.{name}"), found, expected)
    }
}

#[cfg(test)]
mod tests {
    use mlr_model::{Gait, Morphology, Robot, SimulationSettings};

    use super::*;
    use crate::walk_effects::LIBRARY;

    fn nominal() -> WalkModel {
        WalkModel::nominal(
            Robot::jethexa(),
            Gait::tripod(),
            SimulationSettings::default(),
        )
    }

    /// What an effect reports, applied, is what the effect itself does.
    #[test]
    fn reported_effects_of_robot_and_ground_are_the_effects() {
        let (mut applied, mut around) = (Vec::new(), Vec::new());
        for effect in LIBRARY {
            let model = nominal();
            let healthy = Morphology::healthy(&model.robot.layout());
            let place = effect.places(&model.robot, &healthy)[0];
            let parameters = effect.parameters(place, &model);
            let values: Vec<f64> = parameters
                .iter()
                .map(|one| 0.9 * one.lower + 0.1 * one.upper)
                .collect();
            let mut expected = nominal();
            effect.apply(place, &values, &mut expected);
            let report = effect.report(place, &values, &model);
            let report = report.into_iter().map(|(name, value)| {
                let reported = Reported::new(&name, value);
                (name, reported)
            });
            let mut ours = nominal();
            let report = report.collect();
            let is_of_the_robot = apply_reported(effect.kind(), &report, &mut ours).unwrap();
            let is_around = apply_reported_surroundings(effect.kind(), &report, &mut ours).unwrap();
            assert!(!(is_of_the_robot && is_around), "{}", effect.kind());
            if is_around {
                around.push(effect.kind());
            } else if is_of_the_robot {
                applied.push(effect.kind());
            } else {
                assert_eq!(ours, nominal(), "{}", effect.kind());
                continue;
            }
            let difference = |a: f64, b: f64| (a - b).abs() < 1e-9 * (1.0 + a.abs());
            assert!(difference(
                ours.servo.stiffness_nm_per_rad,
                expected.servo.stiffness_nm_per_rad
            ));
            assert!(difference(ours.servo.latency_s, expected.servo.latency_s));
            let (drive, other) = (ours.servo.drive, expected.servo.drive);
            assert!(difference(drive.coulomb_nm, other.coulomb_nm));
            assert!(difference(drive.backlash_rad, other.backlash_rad));
            let (ours, expected) = (ours.simulation, expected.simulation);
            assert!(difference(ours.contact.friction, expected.contact.friction));
            let [contact, other] = [&ours, &expected].map(|model| model.contact);
            assert!(difference(
                contact.natural_frequency_hz,
                other.natural_frequency_hz
            ));
            assert!(difference(contact.damping_ratio, other.damping_ratio));
            let [terrain, other] = [&ours, &expected].map(|model| &model.terrain);
            assert!(difference(terrain.slope_rad, other.slope_rad));
            assert!(difference(terrain.uphill_rad, other.uphill_rad));
            assert_eq!(ours.faults.len(), expected.faults.len());
            let text =
                |model: &SimulationSettings| format!("{:.6?} {:.6?}", model.faults, model.payload);
            assert_eq!(text(&ours), text(&expected), "{}", effect.kind());
        }
        let of_the_robot = [
            "payload",
            "friction",
            "foot_friction",
            "servo_lag",
            "servo_stiffness",
            "joint_friction",
            "backlash",
            "weak_leg",
            "stuck_joint",
            "joint_offset",
            "short_link",
        ];
        assert_eq!(applied, of_the_robot);
        assert_eq!(around, ["slope", "ground_compliance", "external_force"]);
    }

    #[test]
    fn what_is_missing_is_named() {
        let mut model = nominal();
        let nothing = BTreeMap::new();
        let error = apply_reported("payload", &nothing, &mut model).unwrap_err();
        assert!(error.to_string().contains("parameters.mass_kg"), "{error}");
        let error = apply_reported("weak_leg", &nothing, &mut model).unwrap_err();
        assert!(error.to_string().contains("leg"), "{error}");
    }
}

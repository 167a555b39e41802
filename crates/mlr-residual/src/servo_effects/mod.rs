//! What servos have and their data sheets lack. Each effect is one type in its own file; a new one is
//! added by its file and its line in [`LIBRARY`].

mod armature;
mod back_emf;
mod backlash;
mod command_delay;
mod coulomb_friction;
mod dead_band;
mod driven_friction;
mod effect;
mod encoder_resolution;
mod gravity_offset;
mod load_friction;
mod motor_torque;
mod position_gain;
mod quadratic_friction;
mod quadratic_gears;
mod stribeck_friction;
mod stribeck_load;
mod supply_voltage;
mod torque_saturation;
mod viscous_friction;

pub use crate::EffectParameter;
pub use effect::ServoEffect;

/// All effects, in the order in which they are first fitted: the motor, its rotor, and friction.
pub const LIBRARY: &[&dyn ServoEffect] = &[
    &motor_torque::MotorTorque,
    &position_gain::PositionGain,
    &torque_saturation::TorqueSaturation,
    &back_emf::BackEmf,
    &armature::Armature,
    &viscous_friction::ViscousFriction,
    &coulomb_friction::CoulombFriction,
    &quadratic_friction::QuadraticFriction,
    &stribeck_friction::StribeckFriction,
    &load_friction::LoadFriction,
    &driven_friction::DrivenFriction,
    &quadratic_gears::QuadraticGears,
    &stribeck_load::StribeckLoad,
    &backlash::Backlash,
    &dead_band::DeadBand,
    &command_delay::CommandDelay,
    &supply_voltage::SupplyVoltage,
    &gravity_offset::GravityOffset,
    &encoder_resolution::EncoderResolution,
];

/// The effect of that kind.
pub fn find(kind: &str) -> Option<&'static dyn ServoEffect> {
    LIBRARY.iter().copied().find(|effect| effect.kind() == kind)
}

/// Every kind of effect, separated by commas.
pub fn kinds() -> String {
    let kinds: Vec<_> = LIBRARY.iter().map(|effect| effect.kind()).collect();
    kinds.join(", ")
}

#[cfg(test)]
mod tests {
    use mlr_model::{
        Robot,
        bench::{Arm, Bench, Reference},
    };

    use super::*;
    use crate::servo::ServoModel;

    fn described() -> ServoModel {
        ServoModel::new(Bench {
            name: "test".into(),
            arm: Arm {
                mass_kg: 0.5,
                length_m: 0.1,
                inertia_kg_m2: 0.001,
                hanging_rad: 0.0,
            },
            servo: *Robot::jethexa().servo(),
            reference: Reference::default(),
        })
    }

    #[test]
    fn every_effect_changes_the_model_within_what_a_servo_can_be() {
        for effect in LIBRARY {
            let with = |values: Vec<f64>| {
                let mut model = described();
                effect.apply(&values, &mut model);
                assert!(model.bench.check().is_ok(), "{}", effect.kind());
                model
            };
            let parameters = effect.parameters(&described());
            let at = |coordinate: &f64| parameters.iter().map(|p| p.value(*coordinate)).collect();
            let starts = effect.start_coordinates().iter();
            let models: Vec<ServoModel> = starts.map(|coordinate| with(at(coordinate))).collect();
            let changed = models.iter().any(|model| *model != described());
            assert!(changed, "{}", effect.kind());
            assert_eq!(find(effect.kind()).unwrap().kind(), effect.kind());
        }
    }

    #[test]
    fn an_effect_that_is_absent_changes_nothing() {
        for effect in LIBRARY {
            let parameters = effect.parameters(&described());
            let absent: Option<Vec<f64>> = parameters.iter().map(|one| one.neutral).collect();
            let Some(absent) = absent.filter(|values| !values.is_empty()) else {
                continue;
            };
            let mut model = described();
            effect.apply(&absent, &mut model);
            assert_eq!(model, described(), "{}", effect.kind());
        }
    }

    #[test]
    fn what_is_reported_is_what_is_applied() {
        let mut model = described();
        let report = |kind: &str, values: &[f64], model: &mut ServoModel| {
            let effect = find(kind).unwrap();
            effect.apply(values, model);
            effect.report(values, &described())
        };
        let said = report("coulomb_friction", &[-3.0], &mut model);
        assert_eq!(said["coulomb_nm"], model.bench.servo.drive.coulomb_nm);
        let said = report("armature", &[-1.0], &mut model);
        assert_eq!(
            said["armature_kg_m2"],
            model.bench.servo.drive.armature_kg_m2
        );
        let said = report("back_emf", &[0.3], &mut model);
        assert_eq!(
            said["damping_nm_s_per_rad"],
            model.bench.servo.damping_nm_s_per_rad
        );
        // Shares are of the described torque, whatever the torque is.
        report("motor_torque", &[-0.7], &mut model);
        let said = report("quadratic_friction", &[-2.0], &mut model);
        let drive = model.bench.servo.drive;
        assert_eq!(said["quadratic_load_per_nm"], drive.quadratic_load_per_nm);
    }
}

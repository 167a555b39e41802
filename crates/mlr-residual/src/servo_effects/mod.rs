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
mod stribeck_friction;
mod stribeck_load;
mod supply_voltage;
mod viscous_friction;

pub use crate::EffectParameter;
pub use effect::ServoEffect;

/// All effects.
pub const LIBRARY: &[&dyn ServoEffect] = &[
    &motor_torque::MotorTorque,
    &position_gain::PositionGain,
    &back_emf::BackEmf,
    &armature::Armature,
    &viscous_friction::ViscousFriction,
    &coulomb_friction::CoulombFriction,
    &stribeck_friction::StribeckFriction,
    &load_friction::LoadFriction,
    &driven_friction::DrivenFriction,
    &stribeck_load::StribeckLoad,
    &quadratic_friction::QuadraticFriction,
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

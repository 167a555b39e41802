//! What a gyroscope, its mounting and its reference do that the data sheet's model
//! does not have. Each effect is one type in its own file; a new one is added by
//! its file and its line in [`LIBRARY`].

mod asymmetric_scale;
mod backlash;
mod bias_at_rest;
mod bias_drift;
mod cross_axis;
mod curved_rate;
mod dead_band;
mod effect;
mod end_stops;
mod g_sensitivity;
mod gravity_reference;
mod gyro_bias;
mod gyro_scale;
mod reference_eccentricity;
mod rest;
mod scale_nonlinearity;
mod sensor_delay;
mod sensor_lag;
mod stamp_jitter;
mod start_angle;
mod temperature_drift;

pub use crate::parameter::Parameter;
pub(crate) use rest::rest_bias_dps;
pub(crate) use sensor_delay::MAX_DELAY_S;

pub use effect::{Commonness, Inapplicable, SensorEffect};

/// All effects, in the order in which they act on the signals: first on the time
/// stamps, then on the rate, then on the integrated angle.
pub const LIBRARY: &[&dyn SensorEffect] = &[
    &stamp_jitter::StampJitter,
    &gyro_bias::GyroBias,
    &bias_drift::BiasDrift,
    &temperature_drift::TemperatureDrift,
    &g_sensitivity::GSensitivity,
    &cross_axis::CrossAxis,
    &bias_at_rest::BiasAtRest,
    &dead_band::DeadBand,
    &gyro_scale::GyroScale,
    &asymmetric_scale::AsymmetricScale,
    &scale_nonlinearity::ScaleNonlinearity,
    &curved_rate::CurvedRate,
    &start_angle::StartAngle,
    &gravity_reference::GravityReference,
    &end_stops::EndStops,
    &sensor_lag::SensorLag,
    &sensor_delay::SensorDelay,
    &backlash::Backlash,
    &reference_eccentricity::ReferenceEccentricity,
];

/// The effect of that kind.
pub fn find(kind: &str) -> Option<&'static dyn SensorEffect> {
    LIBRARY.iter().copied().find(|effect| effect.kind() == kind)
}

/// Every kind of effect, separated by commas.
pub fn kinds() -> String {
    let kinds: Vec<_> = LIBRARY.iter().map(|effect| effect.kind()).collect();
    kinds.join(", ")
}

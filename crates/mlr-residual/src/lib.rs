//! What a model lacks: finds the residual between model and measurement, traces
//! it to an effect that the model does not have, adds the effect and measures the
//! error again.
//!
//! The model of a gyroscope is the data sheet: the angle is the integral of the
//! rate ([`SensorModel`]). [`explain_sensor()`] compares it with a measured angle
//! and adds effects from a library ([`sensor_effects`]) one at a time. Parameters
//! are fitted on the first stretch of the record, effects are selected on the
//! second, and the error is reported on the third, which decides nothing
//! ([`Stretches`]).
//!
//! ```
//! use mlr_residual::{SelectionSettings, SensorRecord, SensorSignals, explain_sensor};
//!
//! // A shaft that swings by 60°, and a gyroscope that reports 0.5 °/s too much.
//! let times_s: Vec<f64> = (0..6000).map(|i| f64::from(i) * 0.01).collect();
//! let angle_deg: Vec<f64> = times_s.iter().map(|t| 60.0 * t.sin()).collect();
//! let rate_dps = times_s.iter().map(|t| 60.0 * t.cos() + 0.5).collect();
//! let record = SensorRecord::new(SensorSignals::new(times_s, rate_dps), angle_deg)?;
//! let found = explain_sensor(&record, &SelectionSettings::default())?;
//! assert_eq!(found.effects[0].kind, "gyro_bias");
//! assert!((found.effects[0].parameters["bias_dps"] - 0.5).abs() < 0.01);
//! assert!(found.error_after.validation_deg < 0.1 * found.error_before.validation_deg);
//! # Ok::<(), mlr_residual::SensorError>(())
//! ```
//!
//! The model of a walking robot is its simulation on a described body with a sensor on it
//! ([`walk::WalkModel`]). [`walk::explain_walk()`] compares it with the roll, pitch and yaw of
//! a recorded walk, and gives the probability of each effect of the body, its ground and its sensor
//! ([`walk_effects`]): by the evidence of hypotheses, the parameters that robots of one make
//! differ by ([`walk::NuisanceSettings`]) integrated out, and with what the physics engine
//! gets wrong of the right robot ([`walk::Discrepancy`]).
//!
//! The model of a servo on a bench is the servo of the walking robot
//! ([`mlr_model::bench`]). [`servo::explain_servo()`] compares it with recordings of a real one, and
//! adds effects of motor and gears ([`servo_effects`]) by their evidence.

mod baselines;
mod effect_parameter;
mod error;
mod fit;
mod fitted_model;
mod laplace;
mod parameter;
mod posterior;
mod prior;
mod report;
mod selection;
mod sensor;
pub mod sensor_effects;
pub mod servo;
pub mod servo_effects;
mod statistics;
mod transfer;
pub mod walk;
pub mod walk_effects;

pub use effect_parameter::EffectParameter;
pub use error::SensorError;
pub use mlr_model::Progress;
pub use parameter::Parameter;
pub use posterior::{Posterior, ln_mean};
pub use prior::Prior;
pub use report::{Baseline, Candidate, Effect, ErrorDeg, ResidualDescription, SensorExplanation};
pub use selection::{SelectionSettings, explain_sensor};
pub use sensor::{
    AngleUnit, AxisName, RateUnit, SensorColumns, SensorLog, SensorModel, SensorRecord,
    SensorSignals, Stretches, TimeUnit, Track,
};
pub use transfer::{Transfer, TransferredEffect, apply_effects};

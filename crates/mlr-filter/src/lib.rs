//! Signal processing for body orientation: roll, pitch and yaw over time.
//!
//! The crate knows signals and their settings, no robots and no files. The other crates
//! share its types:
//!
//! | what | items |
//! |:--|:--|
//! | roll, pitch and yaw over time | [`OrientationSeries`], [`Axes`], [`Axis`], [`unwrapped_rad`] |
//! | repair of time stamps | [`increasing_times`], [`TimeStampFaults`] |
//! | start of the walk | [`MotionStart`], [`MotionSettings`] |
//! | how far the body turns in each cycle of a gait | [`Turning`], [`SteadyWalk`] |
//! | resampling of a stretch to an even rate | [`Window`], [`EvenSamples`], [`SamplingLimits`] |
//! | spectra; the FFT filter (Algorithm 2 of the paper) | [`Spectrum`], [`PowerSpectrum`], [`FourierFilter`], [`FilterSettings`], [`Conditioned`] |
//! | moving means | [`MovingMean`] |
//! | damage detection in a sliding window | [`DamageDetector`], [`DetectorSettings`], [`Assessment`] |
//! | a setting outside its range, with its name and line | [`SettingError`] |
//!
//! A recording of a low-cost IMU and a simulation of the same motion differ in sampling,
//! noise, drift and delay. Four steps make them comparable:
//!
//! 1. [`increasing_times`] finds the samples whose time stamps are duplicated or out of
//!    order; [`OrientationSeries::picked`] drops them.
//! 2. [`MotionStart`] finds when the robot started to walk.
//! 3. [`Window::cut`] resamples a stretch of the recording to an even rate, relative to
//!    its first sample.
//! 4. [`FourierFilter`] keeps the dominant frequencies and reconstructs the signal on one
//!    common time vector.
//!
//! ```
//! use mlr_filter::{Axes, FilterSettings, FourierFilter, OrientationSeries, Window};
//! use std::f64::consts::TAU;
//!
//! // Ten seconds of a 1 Hz roll of 5 degrees, sampled at 970 Hz, with a 40 Hz hum.
//! let times_s: Vec<f64> = (0..9700).map(|i| f64::from(i) / 970.0).collect();
//! let roll = |t: &f64| 0.087 * (TAU * t).sin() + 0.01 * (TAU * 40.0 * t).sin();
//! let angles_rad = Axes {
//!     roll: times_s.iter().map(roll).collect(),
//!     pitch: vec![0.0; 9700],
//!     yaw: vec![0.0; 9700],
//! };
//! let recording = OrientationSeries::new(times_s, angles_rad)?;
//!
//! let window = Window { start_s: 2.0, duration_s: 5.0 };
//! let cut = window.cut(&recording, &Default::default())?;
//! let mut filter = FourierFilter::new(FilterSettings::default(), window.duration_s)?;
//! let conditioned = filter.condition(&cut);
//!
//! // One sample per 4 ms; the hum is gone, the roll is not.
//! assert_eq!(conditioned.roll.len(), 1250);
//! let after_quarter_turn_s = 63;
//! assert!((conditioned.roll[after_quarter_turn_s] - 0.087).abs() < 1e-3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod band;
mod damage_detector;
mod fourier_filter;
mod line;
mod motion_start;
mod moving_mean;
mod orientation;
mod setting_error;
mod sliding_range;
mod spectrum;
mod steady_drift;
mod time_stamps;
mod turning;
mod window;

pub use band::Band;
pub use damage_detector::{Assessment, DamageDetector, DetectorSettings, SampledTooSlowly};
pub use fourier_filter::{Conditioned, FilterSettings, FourierFilter, Selection};
pub use motion_start::{MotionSettings, MotionStart, NoMotion};
pub use moving_mean::MovingMean;
pub use orientation::{Axes, Axis, OrientationSeries, SeriesError, unwrapped_rad};
pub use setting_error::SettingError;
pub use spectrum::{PowerSpectrum, Spectrum};
pub use time_stamps::{TimeStampFaults, increasing_times};
pub use turning::{NoTurning, SteadyWalk, Turning};
pub use window::{EvenSamples, SamplingLimits, Window, WindowError};

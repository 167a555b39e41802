//! What an IMU says: on a serial line ([`frames`]) and in log files.
//!
//! Logs are CSV files, plain or gzipped, whose columns are found by name, bags of ROS 1 and MCAP:
//!
//! ```
//! use std::io::Write;
//! use mlr_imu::{Columns, read_log, write_log};
//!
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("walk.csv");
//! std::fs::write(&path, "t_ms,roll_rad,pitch_rad,yaw_rad\n0,0.1,0,0\n10,0.2,0,0\n")?;
//!
//! let mut columns = Columns::default();
//! columns.rename("t=t_ms,ms")?;
//! let log = read_log(&path, &columns)?;
//! assert_eq!(log.orientation.times_s(), [0.0, 0.01]);
//!
//! let copy = folder.path().join("copy.csv.gz");
//! write_log(&copy, &log.orientation)?;
//! assert_eq!(read_log(&copy, &Columns::default())?.orientation, log.orientation);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod dead_reckoning;
pub mod frames;
mod fusion;
mod log;
mod mounting;
mod mpu6050;
mod new_file;
pub mod quality;
mod recording;
mod sample;
mod sample_clock;
mod small_file;
mod terminal_text;

pub use fusion::{CALIBRATION_S, Fusion, RawSeries, rest_bias_radps};
pub use log::{
    ColumnError, Columns, Correction, IN_BODY_AXES, ImuRows, LogColumn, LogError, LogFormat,
    LogLimits, LogProblem, LogStream, LogTable, LogValues, McapBegin, McapStream, Place, Position,
    SampleLines, mcap_library, read_log, write_log, write_log_to, write_recording,
};
pub use mounting::Mounting;
pub use mpu6050::{MPU6050_ADDRESS, Mpu6050, Mpu6050Error};
pub use new_file::NewFile;
pub use recording::{OrientationSource, Recording};
pub use sample::{AccelerometerRange, FullScale, GyroscopeRange, ImuSample, STANDARD_GRAVITY_MPS2};
pub use sample_clock::SampleClock;
pub use small_file::{MAX_TEXT_BYTES, read_text};
pub use terminal_text::{of_a_screen, printable};

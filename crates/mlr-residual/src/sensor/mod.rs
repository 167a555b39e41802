//! A gyroscope axis beside a measured angle.

mod columns;
mod model;
mod read;
mod record;
mod stretches;

pub use columns::{AngleUnit, RateUnit, SensorColumns, TimeUnit};
pub use model::{SensorModel, Track};
pub use read::SensorLog;
pub use record::{AxisName, SensorRecord, SensorSignals};
pub use stretches::Stretches;

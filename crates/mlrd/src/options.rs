use clap::{Parser, ValueEnum};

/// Reads an IMU from a serial port, notices when the robot is damaged, and
/// identifies the damage.
#[derive(Debug, Clone, Parser)]
#[command(name = "mlrd", version, max_term_width = 100)]
pub struct Options {
    /// Serial port of the IMU, as in /dev/ttyTHS1.
    #[arg(long, value_name = "DEVICE")]
    pub port: String,
    /// Speed of the port.
    #[arg(long, value_name = "BAUD", default_value_t = 115_200)]
    pub baud: u32,
    /// Framing of the bytes.
    #[arg(long, value_enum, default_value_t = FramingName::Auto)]
    pub format: FramingName,
    /// Threads for identification [default: all cores but one].
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// Seed of the genetic algorithm.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// A framing, or recognise it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FramingName {
    /// Whichever the line carries.
    Auto,
    /// i2cdevlib's teapot packets.
    Teapot,
    /// WitMotion modules.
    Witmotion,
    /// A bridge of one's own.
    Mlr,
}

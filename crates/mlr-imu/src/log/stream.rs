use std::io::{self, Write};

use mlr_filter::Axes;

use crate::ImuSample;

/// How a comment above the header ends that says that the rows are in the body's axes: the
/// mounting of the sensor has been applied to them.
pub const IN_BODY_AXES: &str = ": recorded in the body's axes (mounting applied)";

/// A log that grows row by row, as CSV: time, orientation, and the raw samples
/// where the first row has them.
///
/// ```
/// use mlr_filter::Axes;
/// use mlr_imu::{ImuSample, LogStream};
///
/// let mut log = LogStream::new(Vec::new());
/// let angles_rad = Axes { roll: 0.1, pitch: 0.0, yaw: -0.2 };
/// log.write(0.5, &angles_rad, &ImuSample::default())?;
/// let text = String::from_utf8(log.into_inner())?;
/// assert_eq!(text, "t_s,roll_rad,pitch_rad,yaw_rad\n0.500000,0.1000000,0.0000000,-0.2000000\n");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct LogStream<W> {
    text: W,
    /// Unknown until the first row.
    with_raw: Option<bool>,
}

impl<W: Write> LogStream<W> {
    /// A log without rows.
    pub fn new(text: W) -> Self {
        Self {
            text,
            with_raw: None,
        }
    }

    /// Adds a row. Raw samples that are missing in a later row stay empty.
    ///
    /// # Errors
    /// When the text cannot be written.
    pub fn write(
        &mut self,
        time_s: f64,
        angles_rad: &Axes<f64>,
        sample: &ImuSample,
    ) -> io::Result<()> {
        let with_raw = match self.with_raw {
            Some(with_raw) => with_raw,
            None => self.write_header(sample)?,
        };
        let Axes { roll, pitch, yaw } = angles_rad;
        write!(self.text, "{time_s:.6},{roll:.7},{pitch:.7},{yaw:.7}")?;
        if with_raw {
            for vector in [sample.acceleration_mps2, sample.angular_rate_radps] {
                match vector {
                    Some(v) => write!(self.text, ",{:.5},{:.5},{:.5}", v.x, v.y, v.z)?,
                    None => write!(self.text, ",,,")?,
                }
            }
        }
        writeln!(self.text)
    }

    /// Hands on what is still held back.
    ///
    /// # Errors
    /// When the text cannot be written.
    pub fn flush(&mut self) -> io::Result<()> {
        self.text.flush()
    }

    /// Where the text goes.
    pub fn get_ref(&self) -> &W {
        &self.text
    }

    /// The text.
    pub fn into_inner(self) -> W {
        self.text
    }

    fn write_header(&mut self, first: &ImuSample) -> io::Result<bool> {
        let with_raw = first.acceleration_mps2.is_some() && first.angular_rate_radps.is_some();
        write!(self.text, "t_s,roll_rad,pitch_rad,yaw_rad")?;
        if with_raw {
            write!(
                self.text,
                ",ax_mps2,ay_mps2,az_mps2,gx_radps,gy_radps,gz_radps"
            )?;
        }
        writeln!(self.text)?;
        self.with_raw = Some(with_raw);
        Ok(with_raw)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::{Columns, read_log};

    #[test]
    fn what_is_recorded_can_be_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("walk.csv");
        let mut log = LogStream::new(std::fs::File::create(&path).unwrap());
        for i in 0..10 {
            let t = f64::from(i) * 0.001;
            let sample = ImuSample {
                acceleration_mps2: Some(Vector3::new(0.0, 0.1, 9.81)),
                angular_rate_radps: (i != 5).then_some(Vector3::new(t, 0.0, 0.0)),
                ..ImuSample::default()
            };
            let angles_rad = Axes {
                roll: t,
                pitch: 0.0,
                yaw: 0.0,
            };
            log.write(t, &angles_rad, &sample).unwrap();
        }
        let read = read_log(&path, &Columns::default()).unwrap().orientation;
        assert_eq!(read.len(), 10);
        assert_eq!(read.angles_rad().roll[7], 0.007);
    }
}

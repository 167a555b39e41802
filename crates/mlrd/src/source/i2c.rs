use std::{
    fmt,
    path::PathBuf,
    thread,
    time::{Duration, Instant},
};

use embedded_hal::i2c::I2c;
use linux_embedded_hal::I2cdev;
use mlr_imu::{FullScale, MPU6050_ADDRESS, Mpu6050, frames::encode_mlr};

use super::{Loss, Reading, Source};

/// An MPU6050 on an I²C bus of this computer, as the vendor wires it.
///
/// The daemon is its own bridge: each burst becomes a frame of the `mlr` framing,
/// with the time of the reading as device time.
#[derive(Debug, Clone, PartialEq)]
pub struct I2cBus {
    /// The bus, as in /dev/i2c-1.
    pub device: PathBuf,
    /// How often the chip is read.
    pub rate_hz: f64,
    /// Ranges that the chip is set to.
    pub scale: FullScale,
}

impl fmt::Display for I2cBus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.device.display())
    }
}

impl Source for I2cBus {
    fn open(&self) -> Result<Box<dyn Reading>, String> {
        let bus = I2cdev::new(&self.device)
            .map_err(|error| format!("{}: {error}", self.device.display()))?;
        let chip = Mpu6050::start(bus, MPU6050_ADDRESS, self.scale)
            .map_err(|error| format!("{}: {error}", self.device.display()))?;
        Ok(Box::new(Polled::new(chip, self.rate_hz)))
    }
}

/// A chip that is read at even times.
struct Polled<Bus> {
    chip: Mpu6050<Bus>,
    period: Duration,
    begin: Instant,
    next: Instant,
    counter: u8,
}

/// Bursts that are handed on together.
const GATHER: Duration = Duration::from_millis(10);

impl<Bus: I2c> Polled<Bus> {
    fn new(chip: Mpu6050<Bus>, rate_hz: f64) -> Self {
        let now = Instant::now();
        Self {
            chip,
            period: Duration::from_secs_f64(1.0 / rate_hz),
            begin: now,
            next: now,
            counter: 0,
        }
    }
}

impl<Bus: I2c> Reading for Polled<Bus> {
    fn read(&mut self) -> Result<Vec<u8>, Loss> {
        let end = Instant::now() + GATHER;
        let mut frames = Vec::new();
        loop {
            thread::sleep(self.next.saturating_duration_since(Instant::now()));
            let taken = Instant::now();
            let burst = self.chip.burst();
            let burst = burst.map_err(|error| Loss::Failed(error.to_string()))?;
            let time_us = taken.duration_since(self.begin).as_micros() as u32;
            frames.extend(encode_mlr(&burst, self.counter, time_us));
            self.counter = self.counter.wrapping_add(1);
            // A reading that came late does not make the next ones hurry.
            self.next = (self.next + self.period).max(taken);
            if taken >= end {
                return Ok(frames);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use embedded_hal_mock::eh1::i2c::{Mock, Transaction};
    use mlr_imu::{
        STANDARD_GRAVITY_MPS2,
        frames::{Decode, Mlr},
    };

    use super::*;

    #[test]
    fn bursts_become_frames_with_the_time_of_reading() {
        let mut counts = vec![0; 14];
        counts[4] = 0x40;
        let setup = [0x6b, 0x1a, 0x19, 0x1b, 0x1c]
            .map(|register| Transaction::write(0x68, vec![register, values(register)]));
        let mut expected = vec![Transaction::write_read(0x68, vec![0x75], vec![0x68])];
        expected.extend(setup);
        let bursts = 5;
        expected
            .extend((0..bursts).map(|_| Transaction::write_read(0x68, vec![0x3b], counts.clone())));
        let mut bus = Mock::new(&expected);
        let scale = FullScale::default();
        let chip = Mpu6050::start(bus.clone(), MPU6050_ADDRESS, scale).unwrap();
        let begin = Instant::now();
        let mut polled = Polled::new(chip, 50.0);
        let mut samples = Vec::new();
        let mut decoder = Mlr::new(scale);
        while samples.len() < bursts {
            decoder.extend(&polled.read().unwrap(), &mut samples);
        }
        bus.done();
        // A computer that is kept busy reads late, but never early.
        let passed_us = u32::try_from(begin.elapsed().as_micros()).unwrap();
        let mut before_us = 0;
        for (sample, due_us) in samples.iter().zip((0..).step_by(20_000)) {
            let time_us = sample.device_time_us.unwrap();
            assert!(time_us >= due_us, "{time_us} {due_us}");
            assert!((before_us..=passed_us).contains(&time_us), "{time_us}");
            before_us = time_us;
        }
        let up = samples[0].acceleration_mps2.unwrap().z;
        assert!((up - STANDARD_GRAVITY_MPS2).abs() < 1e-9);
    }

    fn values(register: u8) -> u8 {
        match register {
            0x6b => 1,
            0x1a => 3,
            _ => 0,
        }
    }

    #[test]
    fn a_bus_that_is_not_there_is_named() {
        let bus = I2cBus {
            device: "/dev/i2c-none".into(),
            rate_hz: 200.0,
            scale: FullScale::default(),
        };
        let reason = bus.open().err().unwrap();
        assert!(reason.contains("/dev/i2c-none"), "{reason}");
    }
}

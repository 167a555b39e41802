//! The chip itself, on an I²C bus.

use embedded_hal::i2c::I2c;
use thiserror::Error;

use crate::{AccelerometerRange, FullScale, GyroscopeRange, frames::MlrPayload};

/// An MPU6050 that has been set up to sample at 1 kHz.
///
/// It is read by the one burst of registers that a bridge would send as a frame
/// of kind 1, so that both take the same way from there.
pub struct Mpu6050<Bus> {
    bus: Bus,
    address: u8,
}

/// Why the chip cannot be used.
#[derive(Debug, Error)]
pub enum Mpu6050Error<E: std::fmt::Debug> {
    /// The bus reports a fault: nothing answers at the address, as a rule.
    #[error("no answer at I²C address {address:#04x}: {cause:?}")]
    Bus {
        /// The chip's address.
        address: u8,
        /// What the bus says.
        cause: E,
    },
    /// Something else answers.
    #[error(
        "the device at I²C address {address:#04x} says it is {found:#04x}, an MPU6050 says 0x68"
    )]
    OtherDevice {
        /// The address.
        address: u8,
        /// What register WHO_AM_I holds.
        found: u8,
    },
}

/// Address with pin AD0 low, as the vendor wires it.
pub const MPU6050_ADDRESS: u8 = 0x68;

/// Registers (register map RM-MPU-6000A-00).
mod register {
    pub(super) const SMPLRT_DIV: u8 = 0x19;
    pub(super) const CONFIG: u8 = 0x1a;
    pub(super) const GYRO_CONFIG: u8 = 0x1b;
    pub(super) const ACCEL_CONFIG: u8 = 0x1c;
    pub(super) const ACCEL_XOUT_H: u8 = 0x3b;
    pub(super) const PWR_MGMT_1: u8 = 0x6b;
    pub(super) const WHO_AM_I: u8 = 0x75;
}

/// What WHO_AM_I holds, whatever AD0 is.
const IDENTITY: u8 = 0x68;
/// Clock from the x gyroscope, awake.
const CLOCK_GYRO_X: u8 = 1;
/// Digital low pass of 44 Hz, which makes the internal rate 1 kHz.
const LOW_PASS_44_HZ: u8 = 3;
/// No division of the internal rate.
const UNDIVIDED: u8 = 0;

impl<Bus: I2c> Mpu6050<Bus> {
    /// Wakes the chip at `address` and sets ranges, low pass and rate.
    ///
    /// # Errors
    /// [`Mpu6050Error`] when nothing or something else answers.
    pub fn start(
        bus: Bus,
        address: u8,
        scale: FullScale,
    ) -> Result<Self, Mpu6050Error<Bus::Error>> {
        let mut chip = Self { bus, address };
        let mut identity = [0];
        chip.read(register::WHO_AM_I, &mut identity)?;
        if identity != [IDENTITY] {
            return Err(Mpu6050Error::OtherDevice {
                address,
                found: identity[0],
            });
        }
        for (register, value) in [
            (register::PWR_MGMT_1, CLOCK_GYRO_X),
            (register::CONFIG, LOW_PASS_44_HZ),
            (register::SMPLRT_DIV, UNDIVIDED),
            (register::GYRO_CONFIG, gyroscope_bits(scale.gyroscope)),
            (
                register::ACCEL_CONFIG,
                accelerometer_bits(scale.accelerometer),
            ),
        ] {
            let written = chip.bus.write(address, &[register, value]);
            written.map_err(|cause| Mpu6050Error::Bus { address, cause })?;
        }
        Ok(chip)
    }

    /// Reads acceleration, temperature and angular rate of one moment.
    ///
    /// # Errors
    /// [`Mpu6050Error::Bus`] when the bus fails.
    pub fn burst(&mut self) -> Result<MlrPayload, Mpu6050Error<Bus::Error>> {
        let mut bytes = [0; 14];
        self.read(register::ACCEL_XOUT_H, &mut bytes)?;
        Ok(MlrPayload::RegisterBurst(bytes))
    }

    fn read(&mut self, register: u8, bytes: &mut [u8]) -> Result<(), Mpu6050Error<Bus::Error>> {
        let address = self.address;
        self.bus
            .write_read(address, &[register], bytes)
            .map_err(|cause| Mpu6050Error::Bus { address, cause })
    }
}

/// FS_SEL, bits 4 and 3 of GYRO_CONFIG.
fn gyroscope_bits(range: GyroscopeRange) -> u8 {
    let selection = match range {
        GyroscopeRange::Dps250 => 0,
        GyroscopeRange::Dps500 => 1,
        GyroscopeRange::Dps1000 => 2,
        GyroscopeRange::Dps2000 => 3,
    };
    selection << 3
}

/// AFS_SEL, bits 4 and 3 of ACCEL_CONFIG.
fn accelerometer_bits(range: AccelerometerRange) -> u8 {
    let selection = match range {
        AccelerometerRange::G2 => 0,
        AccelerometerRange::G4 => 1,
        AccelerometerRange::G8 => 2,
        AccelerometerRange::G16 => 3,
    };
    selection << 3
}

#[cfg(test)]
mod tests {
    use embedded_hal::i2c::ErrorKind;
    use embedded_hal_mock::eh1::i2c::{Mock, Transaction};

    use super::*;

    const COUNTS: [u8; 14] = [
        0x06, 0xf0, 0x02, 0xa4, 0x45, 0x84, 0xfd, 0x00, 0xff, 0xd2, 0x00, 0x2a, 0xfd, 0xf3,
    ];

    #[test]
    fn is_set_up_and_read_as_the_register_map_says() {
        let mut bus = Mock::new(&[
            Transaction::write_read(0x68, vec![0x75], vec![0x68]),
            Transaction::write(0x68, vec![0x6b, 0x01]),
            Transaction::write(0x68, vec![0x1a, 0x03]),
            Transaction::write(0x68, vec![0x19, 0x00]),
            Transaction::write(0x68, vec![0x1b, 0b0000_1000]),
            Transaction::write(0x68, vec![0x1c, 0b0001_0000]),
            Transaction::write_read(0x68, vec![0x3b], COUNTS.to_vec()),
        ]);
        let scale = FullScale {
            accelerometer: AccelerometerRange::G8,
            gyroscope: GyroscopeRange::Dps500,
        };
        let mut chip = Mpu6050::start(bus.clone(), MPU6050_ADDRESS, scale).unwrap();
        assert_eq!(chip.burst().unwrap(), MlrPayload::RegisterBurst(COUNTS));
        bus.done();
    }

    #[test]
    fn another_chip_is_named() {
        let mut bus = Mock::new(&[Transaction::write_read(0x68, vec![0x75], vec![0x71])]);
        let error = Mpu6050::start(bus.clone(), MPU6050_ADDRESS, FullScale::default())
            .err()
            .unwrap();
        assert!(matches!(
            error,
            Mpu6050Error::OtherDevice { found: 0x71, .. }
        ));
        assert!(error.to_string().contains("0x71"));
        bus.done();
    }

    #[test]
    fn silence_is_an_error_with_the_address() {
        let failing = Transaction::write_read(0x69, vec![0x75], vec![0]).with_error(
            ErrorKind::NoAcknowledge(embedded_hal::i2c::NoAcknowledgeSource::Address),
        );
        let mut bus = Mock::new(&[failing]);
        let error = Mpu6050::start(bus.clone(), 0x69, FullScale::default())
            .err()
            .unwrap();
        assert!(error.to_string().contains("0x69"), "{error}");
        bus.done();
    }
}

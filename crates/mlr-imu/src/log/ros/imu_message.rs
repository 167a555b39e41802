//! `sensor_msgs/Imu` as ROS 1 and ROS 2 write it.
//!
//! A header, and then 37 numbers: quaternion x, y, z, w; nine covariances; rates; nine
//! covariances; accelerations; nine covariances. ROS 2 aligns them (CDR, OMG DDSI-RTPS 10), ROS 1
//! does not. That is too little to bring in a crate for.

/// How a message is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Ros1,
    Cdr,
}

/// What a message says, in SI units and the axes of its frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ImuMessage {
    /// Its header's time since 1970.
    pub(super) stamp: Stamp,
    /// w, x, y, z of the rotation from the sensor to the world, if it is known.
    pub(super) orientation: Option<[f64; 4]>,
    /// Angular rate in rad/s, if it is known.
    pub(super) rate_radps: Option<[f64; 3]>,
    /// Specific force in m/s², if it is known.
    pub(super) acceleration_mps2: Option<[f64; 3]>,
}

/// A time of ROS, which may make no sense.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Stamp {
    pub(super) seconds: u32,
    pub(super) nanoseconds: u32,
}

/// Numbers of a message.
const NUMBERS: usize = 37;
/// What the first covariance of a quantity is where the quantity is not known.
const UNKNOWN: f64 = -1.0;
const LITTLE_ENDIAN_CDR: [u8; 2] = [0, 1];
const BIG_ENDIAN_CDR: [u8; 2] = [0, 0];
/// The longest name of a frame that is believed.
const MAX_FRAME_BYTES: usize = 4096;
/// Bytes of the longest message.
pub(super) const MAX_MESSAGE_BYTES: u64 = (8 * NUMBERS + MAX_FRAME_BYTES + 64) as u64;

impl Stamp {
    /// Nanoseconds since 1970; `None` if it is no time.
    pub(super) fn since_1970_ns(self) -> Option<i64> {
        (self.nanoseconds < 1_000_000_000)
            .then(|| i64::from(self.seconds) * 1_000_000_000 + i64::from(self.nanoseconds))
    }

    pub(super) fn of_ns(since_1970_ns: i64) -> Self {
        let seconds = since_1970_ns.div_euclid(1_000_000_000);
        Self {
            seconds: seconds.clamp(0, i64::from(u32::MAX)) as u32,
            nanoseconds: since_1970_ns.rem_euclid(1_000_000_000) as u32,
        }
    }
}

impl ImuMessage {
    /// Reads a message. `Err` says what it lacks.
    pub(super) fn read(bytes: &[u8], encoding: Encoding) -> Result<Self, String> {
        let mut fields = match encoding {
            Encoding::Ros1 => {
                let mut fields = Fields {
                    rest: bytes,
                    read: 0,
                    is_big_endian: false,
                    aligned: false,
                };
                // The sequence number.
                fields.u32()?;
                fields
            }
            Encoding::Cdr => {
                let is_big_endian = match bytes.get(..2) {
                    Some(kind) if kind == LITTLE_ENDIAN_CDR => false,
                    Some(kind) if kind == BIG_ENDIAN_CDR => true,
                    Some(kind) => {
                        return Err(format!(
                            "is encoded as {:02x}{:02x}, expected plain CDR (0000 or 0001)",
                            kind[0], kind[1]
                        ));
                    }
                    None => return Err(ENDS_EARLY.into()),
                };
                Fields {
                    rest: bytes.get(4..).ok_or(ENDS_EARLY)?,
                    read: 0,
                    is_big_endian,
                    aligned: true,
                }
            }
        };
        let stamp = Stamp {
            seconds: fields.u32()?,
            nanoseconds: fields.u32()?,
        };
        let frame_bytes = fields.u32()? as usize;
        if frame_bytes > MAX_FRAME_BYTES {
            return Err(format!("names a frame with {frame_bytes} bytes"));
        }
        fields.take(frame_bytes)?;
        let mut numbers = [0.0; NUMBERS];
        for number in &mut numbers {
            *number = fields.f64()?;
        }
        // CDR may be padded to a multiple of four bytes.
        if fields.rest.len() >= 4 {
            return Err(format!("has {} bytes too many", fields.rest.len()));
        }
        Ok(Self::of(stamp, &numbers))
    }

    fn of(stamp: Stamp, numbers: &[f64; NUMBERS]) -> Self {
        let [x, y, z, w, orientation_covariance, ..] = *numbers;
        let vector = |at: usize| {
            let [x, y, z, covariance] = [0, 1, 2, 3].map(|i| numbers[at + i]);
            (covariance != UNKNOWN).then_some([x, y, z])
        };
        Self {
            stamp,
            orientation: (orientation_covariance != UNKNOWN).then_some([w, x, y, z]),
            rate_radps: vector(13),
            acceleration_mps2: vector(25),
        }
    }

    /// Writes a message of ROS 2, in little-endian CDR. Covariances are zero, which means that
    /// they are not known.
    pub(super) fn to_cdr(self, frame: &str) -> Vec<u8> {
        let mut bytes = vec![0, 1, 0, 0];
        bytes.extend(self.stamp.seconds.to_le_bytes());
        bytes.extend(self.stamp.nanoseconds.to_le_bytes());
        bytes.extend((frame.len() as u32 + 1).to_le_bytes());
        bytes.extend(frame.as_bytes());
        bytes.push(0);
        // Numbers begin at multiples of eight bytes behind the first four.
        bytes.resize((bytes.len() - 4).next_multiple_of(8) + 4, 0);
        let quaternion = self.orientation.map(|[w, x, y, z]| [x, y, z, w]);
        let mut add = |values: Option<&[f64]>, count: usize| {
            for index in 0..count {
                let value = values.and_then(|values| values.get(index));
                bytes.extend(value.unwrap_or(&0.0).to_le_bytes());
            }
            let first = if values.is_some() { 0.0 } else { UNKNOWN };
            for covariance in std::iter::once(first).chain([0.0; 8]) {
                bytes.extend(covariance.to_le_bytes());
            }
        };
        add(quaternion.as_ref().map(<[f64; 4]>::as_slice), 4);
        add(self.rate_radps.as_ref().map(<[f64; 3]>::as_slice), 3);
        add(self.acceleration_mps2.as_ref().map(<[f64; 3]>::as_slice), 3);
        bytes
    }
}

const ENDS_EARLY: &str = "is too short";

/// The fields of a message, one after the other.
struct Fields<'a> {
    rest: &'a [u8],
    read: usize,
    is_big_endian: bool,
    /// Whether each field begins at a multiple of its size.
    aligned: bool,
}

impl<'a> Fields<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self.rest.split_at_checked(count).ok_or(ENDS_EARLY)?;
        self.rest = rest;
        self.read += count;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], String> {
        if self.aligned {
            self.take(self.read.next_multiple_of(N) - self.read)?;
        }
        let mut bytes: [u8; N] = self.take(N)?.try_into().map_err(|_| ENDS_EARLY)?;
        if self.is_big_endian {
            bytes.reverse();
        }
        Ok(bytes)
    }

    fn u32(&mut self) -> Result<u32, String> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    fn f64(&mut self) -> Result<f64, String> {
        Ok(f64::from_le_bytes(self.array()?))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn what_is_not_known_is_written_so() {
        let known = ImuMessage {
            stamp: Stamp::default(),
            orientation: Some([0.5, -0.5, 0.5, 0.5]),
            rate_radps: Some([1.0, 2.0, 3.0]),
            acceleration_mps2: Some([4.0, 5.0, 6.0]),
        };
        let unknown = ImuMessage {
            orientation: None,
            rate_radps: None,
            acceleration_mps2: None,
            ..known
        };
        for message in [known, unknown] {
            let bytes = message.to_cdr("imu_link");
            assert_eq!(ImuMessage::read(&bytes, Encoding::Cdr).unwrap(), message);
        }
    }

    #[test]
    fn both_byte_orders_and_ros_1_say_the_same() {
        let numbers: Vec<f64> = (0..37).map(|i| f64::from(i) * 1.5 - 7.25).collect();
        let frame = b"base_imu";
        let mut ros1 = Vec::new();
        for word in [9, 1_700_000_000, 123_456_789, 8_u32] {
            ros1.extend(word.to_le_bytes());
        }
        ros1.extend(frame);
        let (mut little, mut big) = (vec![0, 1, 0, 0], vec![0, 0, 0, 0]);
        for word in [1_700_000_000, 123_456_789, 9_u32] {
            little.extend(word.to_le_bytes());
            big.extend(word.to_be_bytes());
        }
        for cdr in [&mut little, &mut big] {
            cdr.extend(frame);
            // The end of the text, and three bytes to a multiple of eight.
            cdr.extend([0; 4]);
        }
        for number in numbers {
            ros1.extend(number.to_le_bytes());
            little.extend(number.to_le_bytes());
            big.extend(number.to_be_bytes());
        }
        let read = ImuMessage::read(&ros1, Encoding::Ros1).unwrap();
        assert_eq!(read.stamp.since_1970_ns(), Some(1_700_000_000_123_456_789));
        // Covariances of 4 and 13 numbers are passed over.
        assert_eq!(read.orientation, Some([-2.75, -7.25, -5.75, -4.25]));
        assert_eq!(read.rate_radps, Some([12.25, 13.75, 15.25]));
        assert_eq!(read.acceleration_mps2, Some([30.25, 31.75, 33.25]));
        assert_eq!(ImuMessage::read(&little, Encoding::Cdr).unwrap(), read);
        assert_eq!(ImuMessage::read(&big, Encoding::Cdr).unwrap(), read);
    }

    #[test]
    fn another_message_is_refused() {
        let whole = ImuMessage::of(Stamp::default(), &[0.0; 37]).to_cdr("imu");
        let message = |bytes: &[u8]| ImuMessage::read(bytes, Encoding::Cdr).unwrap_err();
        assert_eq!(message(&whole[..whole.len() - 1]), "is too short");
        assert_eq!(
            message(&[whole.clone(), vec![0; 8]].concat()),
            "has 8 bytes too many"
        );
        let mut other = whole.clone();
        other[1] = 3;
        assert!(message(&other).contains("0003"));
        let mut long = whole;
        long[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(message(&long).contains("4294967295 bytes"));
    }

    proptest! {
        #[test]
        fn no_bytes_panic(
            mut bytes in prop::collection::vec(any::<u8>(), 0..600),
            is_cdr in any::<bool>(),
            big in any::<bool>(),
        ) {
            // Mostly an encoding that is known.
            if is_cdr && bytes.len() > 2 && bytes[2] > 10 {
                bytes[..2].copy_from_slice(&[0, u8::from(!big)]);
            }
            for encoding in [Encoding::Ros1, Encoding::Cdr] {
                let _ = ImuMessage::read(&bytes, encoding);
            }
        }
    }
}

//! Samples as lines of text, as they come.

use nalgebra::{UnitQuaternion, Vector3};
use serde_json::{Map, Value};

use super::fields::{Delimiter, Splitter};
use crate::{
    ImuSample,
    frames::{Counts, Decode},
    sample::unit_quaternion,
};

/// The longest line; what is longer is bad.
const MAX_LINE_BYTES: usize = 10_000;
const MAX_COLUMNS: usize = 200;
const TIME: &str = "t_s";
const ANGLES: [&str; 3] = ["roll_rad", "pitch_rad", "yaw_rad"];
const QUATERNION: [&str; 4] = ["qw", "qx", "qy", "qz"];
const ACCELERATION: [&str; 3] = ["ax_mps2", "ay_mps2", "az_mps2"];
const RATE: [&str; 3] = ["gx_radps", "gy_radps", "gz_radps"];

/// Decoder of samples that another program hands on, one on each line: rows of a table below a
/// line with the names of its columns, as in a log, or JSON objects with these names as keys.
///
/// Known are `t_s`; `roll_rad`, `pitch_rad`, `yaw_rad`, or `qw`, `qx`, `qy`, `qz`; and `ax_mps2` to
/// `az_mps2`, `gx_radps` to `gz_radps`. A line needs an orientation, or accelerations and rates.
/// Empty lines and those that begin with `#` are skipped; a line that makes no sense counts as bad.
#[derive(Debug, Default)]
pub struct SampleLines {
    line: Vec<u8>,
    too_long: bool,
    /// The columns, once a line has named them.
    table: Option<Table>,
    counts: Counts,
}

/// The columns of a table.
#[derive(Debug)]
struct Table {
    splitter: Splitter,
    names: Vec<String>,
}

impl Decode for SampleLines {
    fn push(&mut self, byte: u8, samples: &mut Vec<ImuSample>) {
        if byte != b'\n' {
            if self.line.len() < MAX_LINE_BYTES {
                self.line.push(byte);
            } else {
                self.too_long = true;
            }
            return;
        }
        let line = std::mem::take(&mut self.line);
        match self.read(line.trim_ascii()) {
            _ if self.too_long => self.counts.bad += 1,
            Line::Nothing => {}
            Line::Sample(sample) => {
                self.counts.good += 1;
                samples.push(*sample);
            }
            Line::Bad => self.counts.bad += 1,
        }
        self.too_long = false;
        // What was allocated for it is used again.
        self.line = line;
        self.line.clear();
    }

    fn counts(&self) -> Counts {
        self.counts
    }
}

/// What a line is.
enum Line {
    /// Empty, a comment, or the names of columns.
    Nothing,
    Sample(Box<ImuSample>),
    Bad,
}

impl SampleLines {
    fn read(&mut self, line: &[u8]) -> Line {
        if line.is_empty() || line.starts_with(b"#") {
            return Line::Nothing;
        }
        let sample = if line.starts_with(b"{") {
            serde_json::from_slice::<Map<String, Value>>(line)
                .ok()
                .and_then(|object| sample(|name| number_in(&object, name)))
        } else if let Some(table) = Table::named_by(line) {
            self.table = Some(table);
            return Line::Nothing;
        } else {
            self.table.as_mut().and_then(|table| table.sample(line))
        };
        sample.map_or(Line::Bad, |sample| Line::Sample(Box::new(sample)))
    }
}

impl Table {
    /// The columns that a line names, if it names enough for samples.
    fn named_by(line: &[u8]) -> Option<Self> {
        let mut splitter = Splitter::new(Delimiter::of_header(line), MAX_COLUMNS);
        let names = splitter.split(line)?.iter();
        let names = names.map(|name| str::from_utf8(name).map(String::from));
        let names: Vec<String> = names.collect::<Result<_, _>>().ok()?;
        let is_there = |wanted: &str| names.iter().any(|name| name.eq_ignore_ascii_case(wanted));
        let has = |all: &[&str]| all.iter().all(|wanted| is_there(wanted));
        let is_enough = has(&ANGLES) || has(&QUATERNION) || (has(&ACCELERATION) && has(&RATE));
        is_enough.then_some(Self { splitter, names })
    }

    fn sample(&mut self, line: &[u8]) -> Option<ImuSample> {
        let fields = self.splitter.split(line)?;
        if fields.len() != self.names.len() {
            return None;
        }
        sample(|wanted| {
            let index = self
                .names
                .iter()
                .position(|name| name.eq_ignore_ascii_case(wanted));
            match index.map(|index| fields.get(index)) {
                None | Some([]) => Number::Missing,
                Some(field) => Number::of(
                    str::from_utf8(field)
                        .ok()
                        .and_then(|text| text.parse().ok()),
                ),
            }
        })
    }
}

/// What stands where a number should be.
enum Number {
    Missing,
    Is(f64),
    Senseless,
}

impl Number {
    fn of(number: Option<f64>) -> Self {
        let number = number.filter(|number| number.is_finite());
        number.map_or(Self::Senseless, Self::Is)
    }
}

fn number_in(object: &Map<String, Value>, name: &str) -> Number {
    match object.get(name) {
        None | Some(Value::Null) => Number::Missing,
        Some(value) => Number::of(value.as_f64()),
    }
}

/// The sample that these numbers make; `None` if one makes no sense, or too many are missing.
fn sample(number: impl Fn(&str) -> Number) -> Option<ImuSample> {
    let time_s = numbers([TIME], &number)?;
    let orientation = match numbers(ANGLES, &number)? {
        Some([roll, pitch, yaw]) => Some(UnitQuaternion::from_euler_angles(roll, pitch, yaw)),
        None => match numbers(QUATERNION, &number)? {
            Some(elements) => Some(unit_quaternion(elements)?),
            None => None,
        },
    };
    let acceleration_mps2 = numbers(ACCELERATION, &number)?.map(Vector3::from);
    let angular_rate_radps = numbers(RATE, &number)?.map(Vector3::from);
    let is_enough =
        orientation.is_some() || (acceleration_mps2.is_some() && angular_rate_radps.is_some());
    is_enough.then_some(ImuSample {
        device_time_us: time_s.map(|[time_s]| wrapped_us(time_s)),
        acceleration_mps2,
        angular_rate_radps,
        orientation,
        temperature_c: None,
    })
}

/// All numbers of these names; the inner `None` if none is there, the outer one if only some are.
fn numbers<const N: usize>(
    names: [&str; N],
    number: impl Fn(&str) -> Number,
) -> Option<Option<[f64; N]>> {
    let mut found = [0.0; N];
    let mut missing = 0;
    for (found, name) in found.iter_mut().zip(names) {
        match number(name) {
            Number::Is(number) => *found = number,
            Number::Missing => missing += 1,
            Number::Senseless => return None,
        }
    }
    match missing {
        0 => Some(Some(found)),
        _ if missing == N => Some(None),
        _ => None,
    }
}

/// A device's clock, which wraps.
fn wrapped_us(time_s: f64) -> u32 {
    const WRAP_US: f64 = 4_294_967_296.0;
    (time_s * 1e6).round().rem_euclid(WRAP_US) as u32
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn decode(text: &str) -> (Vec<ImuSample>, Counts) {
        let mut decoder = SampleLines::default();
        let mut samples = Vec::new();
        decoder.extend(text.as_bytes(), &mut samples);
        (samples, decoder.counts())
    }

    fn counts(good: u64, bad: u64) -> Counts {
        Counts {
            good,
            bad,
            ..Counts::default()
        }
    }

    #[test]
    fn rows_and_objects_say_the_same() {
        let table = "# a driver\nt_s, roll_rad,pitch_rad,yaw_rad,ax_mps2,ay_mps2,az_mps2,gx_radps,gy_radps,gz_radps,x\n\
             1.5,0.1,0.2,0.3,1,2,3,4,5,6,words\r\n\n1.51,0.1,0.2,0.3,,,,,,,\n";
        let objects = "{\"t_s\":1.5,\"roll_rad\":0.1,\"pitch_rad\":0.2,\"yaw_rad\":0.3,\"ax_mps2\":1,\
             \"ay_mps2\":2,\"az_mps2\":3,\"gx_radps\":4,\"gy_radps\":5,\"gz_radps\":6,\"x\":\"words\"}\n\
             {\"t_s\":1.51,\"roll_rad\":0.1,\"pitch_rad\":0.2,\"yaw_rad\":0.3,\"ax_mps2\":null}\n";
        let (rows, of_rows) = decode(table);
        assert_eq!(of_rows, counts(2, 0));
        assert_eq!(rows[0].device_time_us, Some(1_500_000));
        assert_eq!(
            rows[0].angular_rate_radps,
            Some(Vector3::new(4.0, 5.0, 6.0))
        );
        let (roll, pitch, yaw) = rows[0].orientation.unwrap().euler_angles();
        assert!((roll - 0.1).abs() + (pitch - 0.2).abs() + (yaw - 0.3).abs() < 1e-12);
        assert_eq!(rows[1].acceleration_mps2, None);
        assert_eq!(decode(objects), (rows, of_rows));
    }

    #[test]
    fn lines_that_make_no_sense_are_counted() {
        let header = "t_s,ax_mps2,ay_mps2,az_mps2,gx_radps,gy_radps,gz_radps\n";
        for bad in [
            "1,2,3,4,5,6",
            "1,2,3,4,5,6,7,8",
            "1,2,3,4,5,6,x",
            "1,2,3,4,5,6,NaN",
            "1,2,3,4,5,6,",
            "1,,,,5,6,7",
            "t,roll,pitch,yaw",
            "{\"t_s\":1}",
            "{\"qw\":2,\"qx\":0,\"qy\":0,\"qz\":0}",
            "{\"qw\":1,\"qx\":0,\"qy\":0}",
            "{\"qw\":\"1\",\"qx\":0,\"qy\":0,\"qz\":0}",
            "{\"qw\":1",
            &"1,".repeat(20_000),
        ] {
            let good = "1,2,3,4,5,6,7\n";
            let (samples, found) = decode(&format!("{header}{good}{bad}\n{good}"));
            assert_eq!((samples.len(), found), (2, counts(2, 1)), "{bad}");
        }
        assert_eq!(decode("1,2,3,4,5,6,7\n").1, counts(0, 1), "no names");
    }

    #[test]
    fn without_a_time_there_is_none_and_a_late_one_wraps() {
        let (samples, _) = decode("qw qx qy qz\n1 0 0 0\n");
        assert_eq!(samples[0].device_time_us, None);
        let now = 1_700_000_000.123_456;
        let step_us = wrapped_us(now + 0.01).wrapping_sub(wrapped_us(now));
        assert!((9_999..=10_001).contains(&step_us), "{step_us}");
    }

    proptest! {
        #[test]
        fn any_bytes_are_survived(bytes in prop::collection::vec(any::<u8>(), 0..300), cut in 0..300_usize) {
            let lines = [b"qw,qx,qy,qz\n".as_slice(), &bytes, b"\n1,0,0,0\n"].concat();
            let mut whole = (SampleLines::default(), Vec::new());
            whole.0.extend(&lines, &mut whole.1);
            let mut pieces = (SampleLines::default(), Vec::new());
            let (begin, end) = lines.split_at(cut.min(lines.len()));
            pieces.0.extend(begin, &mut pieces.1);
            pieces.0.extend(end, &mut pieces.1);
            prop_assert_eq!(whole.1, pieces.1);
            prop_assert_eq!(whole.0.counts(), pieces.0.counts());
        }
    }
}

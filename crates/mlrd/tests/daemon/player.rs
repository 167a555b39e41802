//! Plays a log as the bytes that a sensor would have sent.

use std::{
    fs::{self, File},
    io::{BufReader, Write},
    path::{Path, PathBuf},
    thread,
    time::{Duration, Instant},
};

use flate2::bufread::GzDecoder;
use mlr_imu::{
    STANDARD_GRAVITY_MPS2,
    frames::{MlrPayload, WitmotionFrame, encode_mlr, encode_teapot, encode_witmotion},
};
use nalgebra::{UnitQuaternion, Vector3};
use serialport::{SerialPort, TTYPort};

/// The framings of a sensor, the bridge's by what it carries.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Device {
    Teapot,
    Witmotion,
    RegisterBurst,
    Dmp42,
    Dmp28,
}

pub(crate) const DEVICES: [Device; 5] = [
    Device::Teapot,
    Device::Witmotion,
    Device::RegisterBurst,
    Device::Dmp42,
    Device::Dmp28,
];

/// Bytes, and when they are sent.
#[derive(Debug, Clone)]
pub(crate) struct Frame {
    pub(crate) time_s: f64,
    pub(crate) bytes: Vec<u8>,
}

/// A row of a stand-in log.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row {
    pub(crate) time_s: f64,
    pub(crate) force_mps2: Vector3<f64>,
    pub(crate) rate_radps: Vector3<f64>,
    pub(crate) angles_rad: Vector3<f64>,
}

impl Device {
    /// One row in so many is sent: what the line carries at 115200 baud.
    fn every(self) -> usize {
        match self {
            Self::Witmotion => 5,
            Self::Teapot => 2,
            _ => 1,
        }
    }

    /// A WitMotion module says acceleration, rate and angle one after the other.
    pub(crate) fn frames_per_sample(self) -> usize {
        match self {
            Self::Witmotion => 3,
            _ => 1,
        }
    }

    pub(crate) fn frames(self, log: &str) -> Vec<Frame> {
        self.frames_altered(log, |row| row)
    }

    /// The log as a sensor shows it that does this to it.
    pub(crate) fn frames_altered(self, log: &str, alter: impl FnMut(Row) -> Row) -> Vec<Frame> {
        let rows: Vec<Row> = rows(log)
            .into_iter()
            .step_by(self.every())
            .map(alter)
            .collect();
        self.frames_of(&rows)
    }

    /// These rows as a sensor shows them.
    pub(crate) fn frames_of(self, rows: &[Row]) -> Vec<Frame> {
        rows.iter()
            .zip((0_u8..=255).cycle())
            .map(|(row, counter)| Frame {
                time_s: row.time_s,
                bytes: self.encode(row, counter),
            })
            .collect()
    }

    /// The log again and again for so long, its rows a millisecond apart.
    pub(crate) fn frames_at_1_khz(self, log: &str, duration_s: f64) -> Vec<Frame> {
        let rows = rows(log);
        let count = (duration_s * 1000.0) as usize;
        (0..count)
            .zip(rows.iter().cycle())
            .map(|(index, row)| {
                let row = Row {
                    time_s: index as f64 * 1e-3,
                    ..*row
                };
                Frame {
                    time_s: row.time_s,
                    bytes: self.encode(&row, index as u8),
                }
            })
            .collect()
    }

    fn encode(self, row: &Row, counter: u8) -> Vec<u8> {
        let angles = row.angles_rad;
        let orientation = UnitQuaternion::from_euler_angles(angles.x, angles.y, angles.z);
        let time_us = (row.time_s * 1e6).round() as u32;
        match self {
            Self::Teapot => encode_teapot(&orientation, counter).to_vec(),
            Self::Witmotion => [
                WitmotionFrame::Acceleration(row.force_mps2),
                WitmotionFrame::Rate(row.rate_radps),
                WitmotionFrame::Angle(angles),
            ]
            .iter()
            .flat_map(encode_witmotion)
            .collect(),
            Self::RegisterBurst => {
                let mut chip = [0; 14];
                put(
                    &mut chip[..6],
                    2,
                    row.force_mps2,
                    16384.0 / STANDARD_GRAVITY_MPS2,
                );
                put(&mut chip[8..], 2, row.rate_radps, 131.0_f64.to_degrees());
                encode_mlr(&MlrPayload::RegisterBurst(chip), counter, time_us)
            }
            Self::Dmp42 => {
                let mut chip = [0; 42];
                put_quaternion(&mut chip, &orientation);
                put(&mut chip[16..28], 4, row.rate_radps, 16.4_f64.to_degrees());
                put(
                    &mut chip[28..40],
                    4,
                    row.force_mps2,
                    8192.0 / STANDARD_GRAVITY_MPS2,
                );
                encode_mlr(&MlrPayload::Dmp42(chip), counter, time_us)
            }
            Self::Dmp28 => {
                let mut chip = [0; 28];
                put_quaternion(&mut chip, &orientation);
                put(
                    &mut chip[16..22],
                    2,
                    row.force_mps2,
                    16384.0 / STANDARD_GRAVITY_MPS2,
                );
                put(&mut chip[22..28], 2, row.rate_radps, 16.4_f64.to_degrees());
                encode_mlr(&MlrPayload::Dmp28(chip), counter, time_us)
            }
        }
    }
}

/// Counts of a vector as big-endian words, `stride` bytes apart.
fn put(bytes: &mut [u8], stride: usize, vector: Vector3<f64>, counts_per_unit: f64) {
    for (word, value) in bytes.chunks_mut(stride).zip(vector.iter()) {
        let counts = (value * counts_per_unit).round() as i16;
        word[..2].copy_from_slice(&counts.to_be_bytes());
    }
}

fn put_quaternion(bytes: &mut [u8], q: &UnitQuaternion<f64>) {
    for (long, value) in bytes.chunks_mut(4).zip([q.w, q.i, q.j, q.k]) {
        long.copy_from_slice(&((value * f64::from(1 << 30)) as i32).to_be_bytes());
    }
}

fn rows(log: &str) -> Vec<Row> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../data/logs/stand-in")
        .join(log);
    let text = GzDecoder::new(BufReader::new(File::open(path).unwrap()));
    let mut reader = csv::Reader::from_reader(text);
    reader
        .records()
        .map(|row| {
            let row = row.unwrap();
            let number = |column: usize| row[column].parse::<f64>().unwrap();
            let vector = |first| Vector3::from_fn(|axis, _| number(first + axis));
            Row {
                time_s: number(0),
                force_mps2: vector(1),
                rate_radps: vector(4),
                angles_rad: vector(7),
            }
        })
        .collect()
}

/// One byte in a hundred frames arrives wrong.
pub(crate) fn corrupt(frames: &mut [Frame]) {
    for frame in frames.iter_mut().skip(50).step_by(100) {
        let middle = frame.bytes.len() / 2;
        frame.bytes[middle] ^= 0x40;
    }
}

/// A pseudo-terminal that appears under a name, and can be unplugged. Its name goes before it does:
/// the system gives its number to the next one that is opened, which a daemon that still looks for the
/// name would take from another test.
pub(crate) struct Line {
    link: PathBuf,
    ends: Option<(TTYPort, TTYPort)>,
}

impl Line {
    pub(crate) fn plugged_in(link: &Path) -> Self {
        let mut line = Self {
            link: link.into(),
            ends: None,
        };
        line.plug_in();
        line
    }

    pub(crate) fn plug_in(&mut self) {
        let (mut master, slave) = TTYPort::pair().unwrap();
        master.set_timeout(super::HANG).unwrap();
        super::plug_in(&self.link, &slave.name().unwrap());
        self.ends = Some((master, slave));
    }

    pub(crate) fn unplug(&mut self) {
        let Some((_master, slave)) = self.ends.take() else {
            return;
        };
        let name = slave.name().map(PathBuf::from);
        // The name may be another line's by now.
        if fs::read_link(&self.link).ok() == name {
            let _ = fs::remove_file(&self.link);
        }
    }

    /// Sends as fast as the line takes it.
    pub(crate) fn send_all(&mut self, frames: &[Frame]) {
        for some in frames.chunks(100) {
            self.send(
                &some
                    .iter()
                    .flat_map(|frame| &frame.bytes)
                    .copied()
                    .collect::<Vec<u8>>(),
            );
        }
    }

    pub(crate) fn send(&mut self, bytes: &[u8]) {
        if let Some((master, _)) = &mut self.ends {
            master.write_all(bytes).unwrap();
        }
    }
}

impl Drop for Line {
    fn drop(&mut self) {
        self.unplug();
    }
}

/// When a line is unplugged and plugged in again.
pub(crate) const OUTAGE_S: std::ops::Range<f64> = 12.0..13.5;

/// Plays at the speed of life, a few milliseconds at a time; what falls into an
/// outage is lost. On a computer that cannot keep up it plays slower: the daemon, whose clock
/// some devices rely on, must not get a long stretch at once.
pub(crate) fn play_in_real_time(mut line: Line, frames: &[Frame], with_outage: bool) -> Line {
    const PIECE_S: f64 = 0.004;
    const CATCHES_UP: Duration = Duration::from_millis(200);
    let mut begin = Instant::now();
    let mut outages = with_outage.then_some(OUTAGE_S);
    let mut is_out = false;
    let mut rest = frames;
    while let Some(first) = rest.first() {
        let end_s = first.time_s + PIECE_S;
        let count = rest.partition_point(|frame| frame.time_s < end_s);
        let (piece, later) = rest.split_at(count);
        rest = later;
        let due = begin + Duration::from_secs_f64(end_s);
        thread::sleep(due.saturating_duration_since(Instant::now()));
        let late = Instant::now().saturating_duration_since(due);
        begin += late.saturating_sub(CATCHES_UP);
        if let Some(outage) = &outages {
            if !is_out && end_s >= outage.start {
                line.unplug();
                is_out = true;
            } else if is_out && end_s >= outage.end {
                line.plug_in();
                outages = None;
            }
        }
        line.send(
            &piece
                .iter()
                .flat_map(|frame| &frame.bytes)
                .copied()
                .collect::<Vec<u8>>(),
        );
    }
    line
}

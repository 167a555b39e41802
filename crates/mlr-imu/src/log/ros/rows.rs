//! The messages of a topic as the rows of a table.

use std::sync::Arc;

use super::{
    super::{
        LogColumn, LogLimits, LogProblem, LogValues, Place, skipped_rows::SkippedRows, table::Holds,
    },
    imu_message::Stamp,
    topics::{Chosen, Recorded},
};

/// Messages of one topic that hold what an IMU says, one row for each.
///
/// Their orientation is that of the sensor in a world whose z axis points up, and accelerations
/// and rates are in the axes of the sensor (REP 103 and 145), as in any other log.
pub struct ImuRows {
    topic: Arc<str>,
    in_body_axes: bool,
    /// Messages of other topics.
    others: u64,
    /// When the first one was taken.
    begin_ns: i64,
    columns: Vec<(&'static str, Vec<f64>)>,
    notes: Vec<String>,
    limits: LogLimits,
}

const TIME: &str = "t_s";
const QUATERNION: [&str; 4] = ["qw", "qx", "qy", "qz"];
const RAW: [&str; 6] = [
    "ax_mps2", "ay_mps2", "az_mps2", "gx_radps", "gy_radps", "gz_radps",
];
/// The orientation of many drivers that know none and do not say so.
const UNTURNED: [f64; 4] = [1.0, 0.0, 0.0, 0.0];
/// A stamp of zero beside stamps that are later than this was never set.
const SET_STAMP_NS: i64 = 86_400_000_000_000;
/// Stamps make no sense where they take so many times longer or shorter than recording them did.
const LARGEST_TIME_RATIO: f64 = 20.0;

impl ImuRows {
    pub(super) fn new(chosen: Chosen, limits: LogLimits) -> Result<Self, LogProblem> {
        let Chosen {
            topic,
            messages,
            in_body_axes,
            others,
            mut notes,
        } = chosen;
        let (times_ns, note) = times_ns(&messages);
        notes.extend(note);
        let begin_ns = times_ns
            .iter()
            .flatten()
            .copied()
            .next()
            .unwrap_or_default();
        let times_s = times_ns.into_iter().map(|time_ns| match time_ns {
            Some(time_ns) => time_ns.saturating_sub(begin_ns) as f64 * 1e-9,
            None => f64::NAN,
        });
        let mut columns = vec![(TIME, times_s.collect())];
        let raw = messages.iter().map(|recorded| {
            let [ax, ay, az] = recorded.message.acceleration_mps2?;
            let [gx, gy, gz] = recorded.message.rate_radps?;
            Some([ax, ay, az, gx, gy, gz])
        });
        let raw: Vec<Option<[f64; 6]>> = raw.collect();
        let has_raw = raw.iter().any(Option::is_some);
        let (orientations, note) = orientations(&messages, has_raw, limits);
        notes.extend(note);
        add_columns(&mut columns, QUATERNION, &orientations);
        add_columns(&mut columns, RAW, &raw);
        if columns.len() == 1 {
            let what = "has neither orientations nor accelerations and rates".into();
            let found = topic.to_string();
            let topic = topic.to_string();
            return Err(LogProblem::Topic { topic, what, found });
        }
        Ok(Self {
            topic,
            in_body_axes,
            others,
            begin_ns,
            columns,
            notes,
            limits,
        })
    }

    /// The topic.
    pub fn topic(&self) -> &Arc<str> {
        &self.topic
    }

    /// How many messages the file has on other topics.
    pub fn others(&self) -> u64 {
        self.others
    }

    /// When the first message was taken, in nanoseconds since 1970; times count from then.
    pub fn begin_ns(&self) -> i64 {
        self.begin_ns
    }

    /// Whether the file says that the mounting has been applied to the messages.
    pub fn is_in_body_axes(&self) -> bool {
        self.in_body_axes
    }

    pub(in super::super) fn names(&self) -> Vec<String> {
        let names = self.columns.iter();
        names.map(|(name, _)| (*name).into()).collect()
    }

    /// Reads all rows; one that does not pass the check counts as one that cannot be read.
    pub(in super::super) fn read(
        self,
        wanted: &[LogColumn],
        check: impl Fn(&Place, &[f64]) -> Result<(), LogProblem>,
    ) -> Result<LogValues, LogProblem> {
        let mut read = vec![Vec::new(); wanted.len()];
        let mut skipped = SkippedRows::new(self.limits);
        let rows = self.columns.first().map_or(0, |(_, numbers)| numbers.len());
        let mut row = vec![0.0; wanted.len()];
        for index in 0..rows {
            let place = Place::Message(Arc::clone(&self.topic), index as u64 + 1);
            skipped.begin_row(&place)?;
            let read_row = self
                .read_row(index, wanted, &place, &mut row)
                .and_then(|()| check(&place, &row));
            match read_row {
                Ok(()) => {
                    skipped.keep();
                    for (column, value) in read.iter_mut().zip(&row) {
                        column.push(*value);
                    }
                }
                Err(problem) => skipped.skip(problem)?,
            }
        }
        let mut notes = self.notes;
        notes.extend(skipped.finish()?);
        if read.iter().any(Vec::is_empty) {
            return Err(LogProblem::NoSamples);
        }
        Ok(LogValues {
            columns: read,
            notes,
        })
    }

    fn read_row(
        &self,
        index: usize,
        wanted: &[LogColumn],
        place: &Place,
        row: &mut [f64],
    ) -> Result<(), LogProblem> {
        for (column, value) in wanted.iter().zip(row) {
            let Some((name, numbers)) = self.columns.get(column.index) else {
                continue;
            };
            let number = numbers.get(index).copied().unwrap_or(f64::NAN);
            *value = number * column.factor;
            if column.holds == Holds::NumbersOrNothing {
                *value = if value.is_finite() { *value } else { f64::NAN };
            } else if !value.is_finite() {
                return Err(LogProblem::NotANumber {
                    place: place.clone(),
                    column: (*name).into(),
                    text: number.to_string(),
                });
            }
        }
        Ok(())
    }
}

/// Adds columns, NaN where a row has none; no columns where no row has.
fn add_columns<const N: usize>(
    columns: &mut Vec<(&'static str, Vec<f64>)>,
    names: [&'static str; N],
    rows: &[Option<[f64; N]>],
) {
    if rows.iter().all(Option::is_none) {
        return;
    }
    for (index, name) in names.into_iter().enumerate() {
        let numbers = rows
            .iter()
            .map(|row| row.map_or(f64::NAN, |row| row[index]));
        columns.push((name, numbers.collect()));
    }
}

/// When each message was taken: as its header says, or, where headers make no sense, when it was
/// recorded. `None` for single messages whose headers do not say.
fn times_ns(messages: &[Recorded]) -> (Vec<Option<i64>>, Option<String>) {
    let stamps = messages
        .iter()
        .map(|recorded| recorded.message.stamp.since_1970_ns());
    let mut stamps: Vec<Option<i64>> = stamps.collect();
    let latest = stamps.iter().flatten().copied().max().unwrap_or_default();
    for stamp in &mut stamps {
        *stamp = stamp.filter(|stamp| *stamp != 0 || latest < SET_STAMP_NS);
    }
    let recorded = || messages.iter().map(|recorded| recorded.at_ns);
    let unset = Stamp::default();
    let why = if messages
        .iter()
        .all(|recorded| recorded.message.stamp == unset)
    {
        "are zero"
    } else if is_senseless(&stamps, &recorded().collect::<Vec<_>>()) {
        "make no sense"
    } else {
        return (stamps, None);
    };
    let note = format!("the time stamps of the headers {why}; the times of recording are taken");
    (recorded().map(Some).collect(), Some(note))
}

/// Whether stamps mostly stand still or run backwards, or run much faster or more slowly than
/// they were recorded.
fn is_senseless(stamps: &[Option<i64>], recorded: &[i64]) -> bool {
    let set: Vec<i64> = stamps.iter().flatten().copied().collect();
    let forward = |times: &[i64]| times.windows(2).filter(|pair| pair[1] > pair[0]).count();
    let runs = |times: &[i64]| 2 * forward(times) >= times.len().saturating_sub(1);
    if 2 * set.len() < stamps.len() || !runs(&set) {
        return runs(recorded);
    }
    let length_s = |times: &[i64]| {
        let ends = times.first().zip(times.last());
        ends.map_or(0.0, |(first, last)| {
            last.saturating_sub(*first) as f64 * 1e-9
        })
    };
    let ratio = length_s(&set) / length_s(recorded);
    // What was written at once has no times of recording.
    length_s(recorded) > 1.0 && !(1.0 / LARGEST_TIME_RATIO..=LARGEST_TIME_RATIO).contains(&ratio)
}

/// The orientations of messages, as far as they are some.
fn orientations(
    messages: &[Recorded],
    has_raw: bool,
    limits: LogLimits,
) -> (Vec<Option<[f64; 4]>>, Option<String>) {
    let told = messages.iter().map(|recorded| recorded.message.orientation);
    let told: Vec<Option<[f64; 4]>> = told.collect();
    let (all, none) = (told.len(), vec![None; told.len()]);
    let missing = told
        .iter()
        .filter(|orientation| orientation.is_none())
        .count();
    if !has_raw || missing == all {
        return (told, None);
    }
    let same = |value| {
        told.iter()
            .flatten()
            .all(|orientation| *orientation == value)
    };
    let unused = if same([0.0; 4]) {
        "the orientation is zero in every message: not known, although its covariance does not say so"
            .into()
    } else if all > 1 && same(UNTURNED) {
        "the orientation is that of a body that never turns in every message: not known, although \
         its covariance does not say so"
            .into()
    } else if missing as f64 > limits.max_unreadable_share * all as f64 {
        format!("{missing} of {all} messages have no orientation; none are used")
    } else {
        return (told, None);
    };
    (none, Some(unused))
}

//! What the program says about logs of sensors that fail or are read wrongly: every fault is
//! injected into the stand-in logs, and none of them may get a confident answer. The table in
//! `docs/bad-logs.md` is made here; `UPDATE_DOCS=1 cargo test -p mlr-golden-tests --test stand_in
//! bad_logs` writes it.

use std::{f64::consts::PI, fs, io::Write, path::Path};

use flate2::bufread::GzDecoder;
use mlr_ga::{AnswerError, DetectionSettings, IdentifySettings, Model, detect, identify};
use mlr_golden_tests::{data, shaft_sensor_columns};
use mlr_imu::{Columns, LogLimits, LogTable, Mounting, Recording};
use rayon::prelude::*;

use crate::model::{KNOWN, settings};

/// More than this is confident.
const CONFIDENT: f64 = 0.9;

const LOGS: [&str; 13] = [
    "detect-legs3-4",
    "healthy",
    "leg2-lost",
    "leg3-lost",
    "leg5-lost",
    "legs1-4-harsh",
    "legs1-4-lost",
    "legs2-3-lost",
    "legs3-4-lost",
    "legs4-5-lost",
    "undeclared-a",
    "undeclared-b",
    "undeclared-c",
];

/// Time, acceleration, rate, roll, pitch, yaw.
type Row = [f64; 10];
const FORCE: [usize; 3] = [1, 2, 3];
const RATE: [usize; 3] = [4, 5, 6];
const ANGLE: [usize; 3] = [7, 8, 9];
const HEADER: [&str; 10] = [
    "t_s",
    "ax_mps2",
    "ay_mps2",
    "az_mps2",
    "gx_radps",
    "gy_radps",
    "gz_radps",
    "roll_rad",
    "pitch_rad",
    "yaw_rad",
];

fn rows(log: &str) -> Vec<Row> {
    let file = fs::read(data(&format!("logs/stand-in/{log}.csv.gz"))).unwrap();
    let mut reader = csv::Reader::from_reader(GzDecoder::new(file.as_slice()));
    let names: Vec<String> = reader.headers().unwrap().iter().map(String::from).collect();
    let index = HEADER.map(|name| names.iter().position(|n| n == name).unwrap());
    let records = reader.records().map(|record| {
        let record = record.unwrap();
        index.map(|column| record[column].parse().unwrap())
    });
    records.collect()
}

/// What is done to a log, and which of its columns are kept.
struct Fault {
    name: &'static str,
    columns: &'static [usize],
    spoil: fn(&mut [Row], &[Row]),
}

const ALL: &[usize] = &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9];
const RAW: &[usize] = &[0, 1, 2, 3, 4, 5, 6];
const ANGLES: &[usize] = &[0, 7, 8, 9];

fn scale(rows: &mut [Row], columns: [usize; 3], factor: f64) {
    for row in rows {
        columns.iter().for_each(|&column| row[column] *= factor);
    }
}

/// From the sample at `from_s` after the first on, values stay.
fn freeze(rows: &mut [Row], from_s: f64) {
    let begin_s = rows[0][0] + from_s;
    let from = rows.partition_point(|row| row[0] < begin_s);
    let held = rows[from];
    for row in &mut rows[from..] {
        row[1..].copy_from_slice(&held[1..]);
    }
}

/// Values of the walk are cut off at a share of their largest.
fn cut_off(rows: &mut [Row], columns: [usize; 3], share: f64) {
    let largest = rows
        .iter()
        .flat_map(|row| columns.map(|column| row[column].abs()))
        .fold(0.0, f64::max);
    for row in rows {
        for column in columns {
            row[column] = row[column].clamp(-share * largest, share * largest);
        }
    }
}

/// Axes of NED: y right, z down.
fn to_ned(rows: &mut [Row]) {
    for row in rows {
        for column in [2, 3, 5, 6, 8, 9] {
            row[column] = -row[column];
        }
    }
}

const FAULTS: [Fault; 24] = [
    Fault {
        name: "frozen at 4 s",
        columns: ALL,
        spoil: |rows, _| freeze(rows, 4.0),
    },
    Fault {
        name: "frozen at 4 s, raw samples only",
        columns: RAW,
        spoil: |rows, _| freeze(rows, 4.0),
    },
    Fault {
        name: "frozen at 4 s, angles only",
        columns: ANGLES,
        spoil: |rows, _| freeze(rows, 4.0),
    },
    Fault {
        name: "zero from 4 s on",
        columns: ALL,
        spoil: |rows, _| {
            freeze(rows, 4.0);
            let from = rows[0][0] + 4.0;
            rows.iter_mut()
                .filter(|row| row[0] >= from)
                .for_each(|row| row[1..].fill(0.0));
        },
    },
    Fault {
        name: "all zero, angles only",
        columns: ANGLES,
        spoil: |rows, _| scale(rows, ANGLE, 0.0),
    },
    Fault {
        name: "dead gyroscope",
        columns: ALL,
        spoil: |rows, _| scale(rows, RATE, 0.0),
    },
    Fault {
        name: "dead accelerometer",
        columns: RAW,
        spoil: |rows, _| scale(rows, FORCE, 0.0),
    },
    Fault {
        name: "degrees as radians",
        columns: ALL,
        spoil: |rows, _| scale(rows, ANGLE, 180.0 / PI),
    },
    Fault {
        name: "degrees as radians, angles only",
        columns: ANGLES,
        spoil: |rows, _| scale(rows, ANGLE, 180.0 / PI),
    },
    Fault {
        name: "0 to 360° as radians",
        columns: ALL,
        spoil: |rows, _| {
            scale(rows, ANGLE, 180.0 / PI);
            for row in rows {
                for column in ANGLE {
                    row[column] = row[column].rem_euclid(360.0);
                }
            }
        },
    },
    Fault {
        name: "accelerations in g",
        columns: ALL,
        spoil: |rows, _| scale(rows, FORCE, 1.0 / 9.806_65),
    },
    Fault {
        name: "accelerations in g, raw samples only",
        columns: RAW,
        spoil: |rows, _| scale(rows, FORCE, 1.0 / 9.806_65),
    },
    Fault {
        name: "rates in °/s",
        columns: ALL,
        spoil: |rows, _| scale(rows, RATE, 180.0 / PI),
    },
    Fault {
        name: "rates in °/s, raw samples only",
        columns: RAW,
        spoil: |rows, _| scale(rows, RATE, 180.0 / PI),
    },
    Fault {
        name: "angles and rates in degrees",
        columns: ALL,
        spoil: |rows, _| {
            scale(rows, RATE, 180.0 / PI);
            scale(rows, ANGLE, 180.0 / PI);
        },
    },
    Fault {
        name: "NED",
        columns: ALL,
        spoil: |rows, _| to_ned(rows),
    },
    Fault {
        name: "NED, raw samples only",
        columns: RAW,
        spoil: |rows, _| to_ned(rows),
    },
    Fault {
        name: "upside down",
        columns: ALL,
        spoil: |rows, _| {
            to_ned(rows);
            for row in rows {
                // In its own filter's angles only roll is turned, and wraps.
                row[7] = (row[7] + 2.0 * PI).rem_euclid(2.0 * PI) - PI;
                row[8] = -row[8];
                row[9] = -row[9];
            }
        },
    },
    Fault {
        name: "upside down, angles only",
        columns: ANGLES,
        spoil: |rows, _| {
            for row in rows {
                row[7] = (row[7] + 2.0 * PI).rem_euclid(2.0 * PI) - PI;
            }
        },
    },
    Fault {
        name: "gyroscope saturated at 30 %",
        columns: ALL,
        spoil: |rows, _| cut_off(rows, RATE, 0.3),
    },
    Fault {
        name: "gyroscope saturated at 60 %, raw samples only",
        columns: RAW,
        spoil: |rows, _| cut_off(rows, RATE, 0.6),
    },
    Fault {
        name: "accelerometer saturated just above 1 g",
        columns: ALL,
        spoil: |rows, _| {
            for row in rows {
                FORCE.iter().for_each(|&c| row[c] = row[c].clamp(-9.9, 9.9));
            }
        },
    },
    Fault {
        name: "held at 20 Hz",
        columns: ALL,
        spoil: |rows, _| {
            let begin_s = rows[0][0];
            let mut held = (-1.0, rows[0]);
            for row in rows {
                let slot = ((row[0] - begin_s) * 20.0).floor();
                if slot > held.0 {
                    held = (slot, *row);
                }
                row[1..].copy_from_slice(&held.1[1..]);
            }
        },
    },
    Fault {
        name: "two sensors interleaved",
        columns: ALL,
        spoil: |rows, other| {
            for (row, other) in rows.iter_mut().zip(other).step_by(2) {
                row[1..].copy_from_slice(&other[1..]);
            }
        },
    },
];

fn recording(rows: &[Row], columns: &[usize]) -> Recording {
    recording_as(rows, columns, &Columns::default())
}

fn recording_as(rows: &[Row], columns: &[usize], read_as: &Columns) -> Recording {
    let mut text = Vec::new();
    let names: Vec<&str> = columns.iter().map(|&column| HEADER[column]).collect();
    writeln!(text, "{}", names.join(",")).unwrap();
    for row in rows {
        let numbers: Vec<String> = columns.iter().map(|&c| format!("{:.6}", row[c])).collect();
        writeln!(text, "{}", numbers.join(",")).unwrap();
    }
    let table = LogTable::from_bytes(text.as_slice(), None, LogLimits::default()).unwrap();
    Recording::from_table(table, read_as).unwrap()
}

/// How the logs of a row are identified.
struct Identifier<'a> {
    model: Model<'a>,
    settings: IdentifySettings,
}

impl Identifier<'static> {
    /// For logs that show the start of the walk.
    fn by_atlas() -> Self {
        Self {
            model: KNOWN.with_atlas(),
            settings: settings(),
        }
    }

    /// For any log; on the nominal model alone, because every variation of it takes time.
    fn by_simulation() -> Self {
        let mut settings = IdentifySettings::default();
        settings.variations.truncate(1);
        Self {
            model: Model::jethexa(),
            settings,
        }
    }
}

impl Identifier<'_> {
    /// What became of one log: the confidence of an answer, or why there is none.
    fn identified(&self, recording: &Recording) -> Result<f64, AnswerError> {
        let answer = identify(recording, self.model, &self.settings, &())?;
        Ok(answer.legs_probability)
    }
}

/// The message without what differs from log to log.
fn said(error: &AnswerError) -> String {
    let text = error.to_string();
    text.split(", since ").next().unwrap().to_string()
}

/// A row of the table.
fn row(name: &str, recordings: &[Recording], identifier: &Identifier<'_>) -> String {
    let answers: Vec<_> = recordings
        .par_iter()
        .map(|recording| identifier.identified(recording))
        .collect();
    let refused: Vec<String> = answers
        .iter()
        .filter_map(|a| a.as_ref().err())
        .map(said)
        .collect();
    let surest = answers.iter().flatten().copied().reduce(f64::max);
    if let Some(surest) = surest {
        assert!(surest < CONFIDENT, "{name}: an answer with {surest}");
    }
    for answer in answers.iter().filter_map(|a| a.as_ref().err()) {
        assert!(answer.is_recordings_fault(), "{name}: {answer}");
    }
    let detected = recordings
        .iter()
        .filter(|recording| detect(recording, &DetectionSettings::default()).is_err())
        .count();
    format!(
        "| {name} | {} of {} | {} | {detected} | {} |\n",
        refused.len(),
        recordings.len(),
        surest.map_or("-".into(), |surest| format!("{:.0} %", 100.0 * surest)),
        refused.first().map_or("", String::as_str),
    )
}

/// Writes the table into the document, or makes sure that it is there.
fn keep_in_docs(table: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/bad-logs.md");
    let text = fs::read_to_string(&path).unwrap();
    let (begin, end) = ("<!-- table -->\n", "<!-- end of table -->");
    let from = text.find(begin).unwrap() + begin.len();
    let to = text.find(end).unwrap();
    if std::env::var_os("UPDATE_DOCS").is_some() {
        fs::write(path, format!("{}{table}{}", &text[..from], &text[to..])).unwrap();
    } else {
        assert_eq!(
            &text[from..to],
            table,
            "UPDATE_DOCS=1 writes docs/bad-logs.md anew"
        );
    }
}

#[test]
fn no_fault_gets_a_confident_answer() {
    let logs: Vec<Vec<Row>> = LOGS.par_iter().map(|log| rows(log)).collect();
    let identifier = Identifier::by_atlas();
    let mut table =
        "| what was done | refused | surest answer | `detect` refuses | `identify` says |\n\
                     |:--|--:|--:|--:|:--|\n"
            .to_string();
    for fault in &FAULTS {
        let recordings: Vec<Recording> = (0..logs.len())
            .into_par_iter()
            .map(|index| {
                let mut rows = logs[index].clone();
                (fault.spoil)(&mut rows, &logs[(index + 3) % logs.len()]);
                recording(&rows, fault.columns)
            })
            .collect();
        table += &row(fault.name, &recordings, &identifier);
    }
    let carried = ["roll.csv.gz", "yaw.csv.gz"].map(|file| {
        let columns = shaft_sensor_columns();
        mlr_imu::read_log(data(&format!("real/mpu6050-encoder/{file}")), &columns).unwrap()
    });
    table += &row(
        "a real MPU6050 that is turned to and fro, `data/real`",
        &carried,
        &Identifier::by_simulation(),
    );
    keep_in_docs(&table);
}

/// What is said to type is typed: the log is then as good as before.
#[test]
fn the_cure_that_is_printed_cures() {
    let good = rows("leg3-lost");
    for name in [
        "degrees as radians",
        "accelerations in g",
        "rates in °/s",
        "NED",
        "upside down",
    ] {
        let fault = FAULTS.iter().find(|fault| fault.name == name).unwrap();
        let mut rows = good.clone();
        (fault.spoil)(&mut rows, &good);
        let spoilt = detect(&recording(&rows, ALL), &DetectionSettings::default());
        let Err(AnswerError::Unusable(finding)) = spoilt else {
            panic!("{name}: {spoilt:?}");
        };
        let cure = finding.cure.unwrap();
        let mut columns = Columns::default();
        for argument in cure.split("--column ").skip(1) {
            columns.rename(argument.trim()).unwrap();
        }
        let mut mounting = Mounting::default();
        if let Some(roll) = cure.strip_prefix("[mounting] roll_deg = ") {
            mounting.roll_deg = roll.split(' ').next().unwrap().parse().unwrap();
        }
        let cured = recording_as(&rows, ALL, &columns)
            .mounted(&mounting)
            .unwrap();
        let expected = recording(&good, ALL);
        let detection = detect(&cured, &DetectionSettings::default()).unwrap();
        assert_eq!(detection.log_quality.findings, [], "{name}");
        let (angles, truth) = (
            cured.orientation.angles_rad(),
            expected.orientation.angles_rad(),
        );
        for (ours, theirs) in [
            (&angles.roll, &truth.roll),
            (&angles.pitch, &truth.pitch),
            (&angles.yaw, &truth.yaw),
        ] {
            for (a, b) in ours.iter().zip(theirs) {
                assert!(
                    (a - ours[0] - (b - theirs[0])).abs() < 1e-4,
                    "{name}: {a} {b}"
                );
            }
        }
    }
}

/// The control: nothing is done, and nothing is refused.
#[test]
fn good_logs_are_not_refused() {
    for log in LOGS {
        let rows = rows(log);
        for columns in [ALL, RAW, ANGLES] {
            let recording = recording(&rows, columns);
            let detection = detect(&recording, &DetectionSettings::default()).unwrap();
            assert_eq!(detection.log_quality.findings, [], "{log}");
        }
    }
}

//! Events in words.

use std::{fmt::Write as _, path::Path};

use mlr_model::Morphology;
use serde_json::Value;

use super::told::{Corrected, Effect, Explained, Identified, RecoveryGait, StatusTold, What};
use crate::event::{Level, WatchedLeg};

/// What an event says, in one line, of a robot with these legs.
pub(super) fn saying(name: &str, what: &What, legs: &[WatchedLeg]) -> String {
    match what {
        What::Started {
            port,
            robot,
            last_known,
            calibration,
        } => {
            let mut text = format!("started, reads {port}");
            if let Some(robot) = robot {
                let _ = write!(text, ", watches {}", robot.name);
            }
            if let Some(known) = last_known {
                let damage = damage(&known.morphology, legs);
                let _ = write!(text, "; last known: {damage}");
            }
            if let Some(known) = calibration {
                let _ = write!(text, "; learned from {} healthy walks", known.walks);
            }
            text
        }
        What::PortOpened { port } => format!("{port} is open"),
        What::PortLost { reason } => format!("port lost: {reason}"),
        What::LineFault { reason } => format!("line fault: {reason}"),
        What::SensorFault { fault, reason } => format!("sensor fault, {fault}: {reason}"),
        What::SensorRecovered { fault, lasted_s } => {
            format!("sensor recovered from {fault} after {lasted_s:.1} s")
        }
        What::MotionStarted { motion_start_s } => {
            format!("motion started at {motion_start_s:.2} s")
        }
        What::DamageDetected {
            fluctuation_deg,
            changed: false,
        } => format!("damage detected: roll or pitch swing by {fluctuation_deg:.1}°"),
        What::DamageDetected {
            fluctuation_deg,
            changed: true,
        } => format!("the damaged robot moves otherwise now: it swings by {fluctuation_deg:.1}°"),
        What::Identified { result } => format!("identified: {}", identified(result, legs)),
        What::Unidentified { reason } => format!("not identified: {reason}"),
        What::Explained { result } => format!("explained: {}", explained(result)),
        What::RecoveryGait {
            gait,
            joints,
            result,
        } => format!(
            "recovery gait: {}; {}",
            files(gait, joints),
            recovery(result)
        ),
        What::Calibrated {
            walks,
            gain_nats,
            wear,
        } => {
            let mut text = format!("calibrated: {}", calibrated(*walks, *gain_nats));
            for worn in wear {
                let (parameter, unit) = (&worn.parameter, &worn.unit);
                let (before, now) = (number(worn.reference), number(worn.now));
                let _ = write!(
                    text,
                    "; {parameter} has drifted from {before} to {now} {unit}"
                );
            }
            text
        }
        What::SensorCorrected { sensing } => format!("sensor corrected: {}", corrected(sensing)),
        What::Recovered => "walks calmly again".into(),
        What::Warning { reason } => reason.clone(),
        What::RecordingBegun { path } => format!("records into {}", path.display()),
        What::RecordingRemoved { path } => format!("removed {}", path.display()),
        What::Status(status) => of_status(status),
        What::Stopped => "stopped".into(),
        What::Unknown => name.replace('_', " "),
    }
}

/// The damage, with the names of the legs.
pub(super) fn damage(morphology: &Morphology, legs: &[WatchedLeg]) -> String {
    morphology.describe_with(|number| match legs.get(number - 1) {
        Some(leg) if !leg.name.is_empty() => format!("{number} ({})", leg.name),
        _ => number.to_string(),
    })
}

pub(super) fn identified(result: &Identified, legs: &[WatchedLeg]) -> String {
    let mut text = damage(&result.morphology, legs);
    if let Some(probability) = result.probability {
        let _ = write!(text, ", {}", percent(probability));
    }
    if let Some(probability) = result.legs_probability {
        let _ = write!(text, " (these legs: {})", percent(probability));
    }
    if let Some(elapsed_s) = result.elapsed_s {
        let _ = write!(text, ", in {elapsed_s:.1} s");
    }
    match result.implausible {
        true => format!("nothing explains the walk; closest: {text}"),
        false => text,
    }
}

pub(super) fn explained(result: &Explained) -> String {
    let mut text = match result.effects.as_slice() {
        [] => "nothing unusual besides".into(),
        effects => effects.iter().map(effect).collect::<Vec<_>>().join("; "),
    };
    if result.unexplained {
        text += "; something remains unexplained";
    }
    let error_deg = |errors: &Option<super::told::Errors>| errors.as_ref()?.validation_deg;
    let errors_deg = error_deg(&result.error_before).zip(error_deg(&result.error_after));
    if let Some((before_deg, after_deg)) = errors_deg {
        let _ = write!(text, "; error {before_deg:.2}° → {after_deg:.2}°");
    }
    text
}

fn effect(effect: &Effect) -> String {
    let mut text = effect.kind.replace('_', " ");
    for (name, value) in &effect.parameters {
        let value = match value {
            Value::Number(value) => number(value.as_f64().unwrap_or(f64::NAN)),
            other => other.to_string(),
        };
        let _ = write!(text, " {name} {value}");
    }
    if let Some(probability) = effect.probability {
        let _ = write!(text, " ({})", percent(probability));
    }
    text
}

/// Names of both files, that of the folder once.
pub(super) fn files(gait: &Path, joints: &Path) -> String {
    let joints = match joints.file_name() {
        Some(name) if joints.parent() == gait.parent() => Path::new(name),
        _ => joints,
    };
    format!("{}, {}", gait.display(), joints.display())
}

pub(super) fn recovery(result: &RecoveryGait) -> String {
    let mut text = match result.statically_stable {
        true => "statically stable".to_owned(),
        false => "not statically stable".to_owned(),
    };
    if !result.folded_legs.is_empty() {
        let legs: Vec<String> = result.folded_legs.iter().map(usize::to_string).collect();
        let _ = write!(text, ", folded legs: {}", legs.join(", "));
    }
    let speed = |outlook: &Option<super::told::Outlook>| outlook.as_ref()?.reliable_speed_m_per_s;
    if let Some((before, after)) = speed(&result.before).zip(speed(&result.after)) {
        let _ = write!(
            text,
            ", {:.0} mm/s to be counted on in place of {:.0}",
            millimetres(after),
            millimetres(before)
        );
    }
    text
}

/// Without the sign of a zero.
fn millimetres(length_m: f64) -> f64 {
    (length_m * 1000.0).round() + 0.0
}

pub(super) fn calibrated(walks: u32, gain_nats: f64) -> String {
    format!("learned from {walks} healthy walks, predicts another better by {gain_nats:.1} nats")
}

pub(super) fn corrected(sensing: &Corrected) -> String {
    let nothing = Corrected::default();
    let triple = |values: &[f64; 3]| values.map(number).join(", ");
    let mut parts = Vec::new();
    if sensing.misalignment_deg != nothing.misalignment_deg {
        let angles = triple(&sensing.misalignment_deg);
        parts.push(format!("tilted by roll, pitch, yaw {angles}°"));
    }
    if sensing.bias_dps != nothing.bias_dps {
        parts.push(format!("bias x, y, z {}°/s", triple(&sensing.bias_dps)));
    }
    if sensing.scale != nothing.scale {
        parts.push(format!("scale {}", number(sensing.scale)));
    }
    if sensing.delay_s != nothing.delay_s {
        parts.push(format!("delay {} s", number(sensing.delay_s)));
    }
    match parts.is_empty() {
        true => "nothing".into(),
        false => parts.join("; "),
    }
}

fn of_status(status: &StatusTold) -> String {
    let mut text = status.state.clone();
    if let Some(fault) = &status.fault {
        let _ = write!(text, ", sensor fault {fault}");
    }
    if let Some(fluctuation_deg) = status.fluctuation_deg {
        let _ = write!(text, ", swings by {fluctuation_deg:.1}°");
    }
    let StatusTold {
        good, bad, lost, ..
    } = status;
    let _ = write!(text, ", {}", rate(status));
    let _ = write!(text, ", {good} frames, {bad} bad, {lost} lost");
    text
}

/// How often samples come, or since when there is none.
pub(super) fn rate(status: &StatusTold) -> String {
    match status.rate_hz {
        Some(rate_hz) => format!("{rate_hz:.1} Hz"),
        None => format!("no sample for {:.1} s", status.silent_s),
    }
}

/// A probability; what is neither 0 nor 1 is not shown as such.
pub(super) fn percent(probability: f64) -> String {
    match 100.0 * probability {
        p if p < 0.5 => "< 1 %".into(),
        p if p > 99.5 => "> 99 %".into(),
        p => format!("{p:.0} %"),
    }
}

/// The time of day of an RFC 3339 time.
pub(super) fn time_of_day(time: &str) -> &str {
    match time.split_once('T') {
        Some((_, clock)) => clock.get(..8).unwrap_or(clock),
        None => time,
    }
}

pub(super) fn level(level: Level) -> &'static str {
    match level {
        Level::Ok => "OK",
        Level::Warn => "WARN",
        Level::Error => "ERROR",
        Level::Stale => "STALE",
    }
}

/// Three digits that count.
fn number(value: f64) -> String {
    let decimals = match value.abs() {
        size if size >= 100.0 => 0,
        size if size >= 10.0 => 1,
        size if size >= 1.0 => 2,
        _ => 3,
    };
    let text = format!("{value:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::top::told::Line;

    fn said(text: &str) -> String {
        let Line::Event(told) = Line::new(text) else {
            panic!("{text}");
        };
        let legs = ["front left", "", "middle left"].map(|name| WatchedLeg {
            name: name.into(),
            hip_m: [0.0; 2],
            links: 3,
        });
        assert_ne!(told.what, What::Unknown, "{text}");
        saying(&told.name, &told.what, &legs)
    }

    #[test]
    fn answers_are_said_with_the_names_of_legs() {
        let event = r#""time":"t","level":1"#;
        for (text, expected) in [
            (
                r#""event":"identified","result":{"morphology":[[1,1,1],[1,0,0],[0,0,0]],"probability":0.824,"legs_probability":0.997,"elapsed_s":13.04}"#,
                "identified: leg 3 (middle left) lost, leg 2 lost from link 2 on, 82 % (these legs: > 99 %), in 13.0 s",
            ),
            (
                r#""event":"identified","result":{"morphology":[[1,1,1],[1,1,1],[1,1,1]],"implausible":true,"probability":1.0}"#,
                "identified: nothing explains the walk; closest: healthy, > 99 %",
            ),
            (
                r#""event":"explained","result":{"effects":[{"kind":"weak_leg","parameters":{"leg":2,"gain":0.5123},"probability":0.9}],"error_before":{"validation_deg":1.98},"error_after":{"validation_deg":0.51}}"#,
                "explained: weak leg gain 0.512 leg 2 (90 %); error 1.98° → 0.51°",
            ),
            (
                r#""event":"calibrated","walks":4,"gain_nats":2.25,"wear":[{"parameter":"servo_stiffness","unit":"ln","reference":0.0,"now":-0.2,"change":-0.2,"deviations":4.0}]"#,
                "calibrated: learned from 4 healthy walks, predicts another better by 2.2 nats; servo_stiffness has drifted from 0 to -0.2 ln",
            ),
            (
                r#""event":"sensor_corrected","sensing":{"misalignment_deg":[0.0,-2.08,0.0],"scale":1.02,"filter_time_s":null}"#,
                "sensor corrected: tilted by roll, pitch, yaw 0, -2.08, 0°; scale 1.02",
            ),
            (
                r#""event":"recovery_gait","gait":"/var/lib/mlrd/recovery-1.toml","joints":"/var/lib/mlrd/recovery-1.csv","result":{"folded_legs":[3],"statically_stable":true,"before":{"reliable_speed_m_per_s":-0.0001},"after":{"reliable_speed_m_per_s":0.0312}}"#,
                "recovery gait: /var/lib/mlrd/recovery-1.toml, recovery-1.csv; statically stable, folded legs: 3, 31 mm/s to be counted on in place of 0",
            ),
        ] {
            assert_eq!(said(&format!("{{{event},{text}}}")), expected);
        }
    }

    #[test]
    fn no_probability_is_shown_as_certain() {
        assert_eq!(
            [0.001, 0.5, 0.9999].map(percent),
            ["< 1 %", "50 %", "> 99 %"]
        );
        assert_eq!(
            [123.4, -0.3, 2.0, 0.0].map(number),
            ["123", "-0.3", "2", "0"]
        );
        assert_eq!(time_of_day("2026-11-22T16:10:58.461Z"), "16:10:58");
        assert_eq!(time_of_day("T5"), "5");
    }
}

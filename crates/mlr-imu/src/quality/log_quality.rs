use std::ops::Range;

use mlr_filter::MotionSettings;
use serde::Serialize;

use super::{
    FaultKind, Finding, FindingKind, SampleHealth, Severity, gravity, interleaving, rows::Rows,
    saturation, tipping, units,
};
use crate::Recording;

/// What a log says about itself, before anybody asks what the robot did.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LogQuality {
    /// Rows per second.
    pub sample_rate_hz: f64,
    /// How often a second the values change: the rate of the sensor itself.
    pub value_rate_hz: f64,
    /// Length of the mean specific force, of the standing robot where the log shows it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gravity_mps2: Option<f64>,
    /// What is wrong, the worst first.
    pub findings: Vec<Finding>,
}

/// Values that change less often than this share of the rows are held.
const HELD_SHARE: f64 = 0.7;

impl LogQuality {
    /// Examines a recording whose time stamps increase. `motion` says how the start of the
    /// walk is found: a robot that stands may show what one that walks must not.
    pub fn of(recording: &Recording, motion: &MotionSettings) -> Self {
        let mut rows = Rows::of(recording, motion);
        // A wrong unit or a dead sensor makes values impossible too; causes come first.
        let (impossible, mut findings): (Vec<_>, Vec<_>) = faults_of_samples(&rows)
            .into_iter()
            .partition(|fault| fault.kind == FindingKind::Impossible);
        findings.extend(still_to_the_end(&rows));
        let failed_s = findings.iter().map(|fault| fault.from_s).reduce(f64::min);
        if let Some(failed_s) = failed_s {
            rows.sound_until(failed_s);
        }
        let gravity = gravity::Gravity::of(&rows);
        if let Some(gravity) = &gravity {
            findings.extend(gravity.findings(&rows));
        }
        let value_rate_hz = value_rate_hz(&rows);
        findings.extend(interleaving::alternating(&rows));
        findings.extend(units::finding(&rows, value_rate_hz));
        findings.extend(tipping::finding(&rows));
        findings.extend(impossible);
        findings.extend(interleaving::restless(&rows));
        let sample_rate_hz = rate_hz(rows.times_s.len(), rows.span_s());
        let hold = (sample_rate_hz / value_rate_hz.max(1e-9)).round().max(1.0);
        findings.extend(saturation::findings(&rows, hold as usize));
        findings.extend(held(&rows, value_rate_hz, sample_rate_hz));
        findings.sort_by_key(|finding| finding.severity as u8);
        Self {
            sample_rate_hz,
            value_rate_hz,
            gravity_mps2: gravity.and_then(|gravity| gravity.norm_mps2()),
            findings,
        }
    }

    /// The first finding that makes a stretch of log time useless.
    pub fn spoilt_within(&self, stretch_s: Range<f64>) -> Option<&Finding> {
        self.findings
            .iter()
            .find(|finding| finding.spoils(&stretch_s))
    }

    /// What a person should know although the log has an answer.
    pub fn warnings(&self) -> impl Iterator<Item = String> {
        self.findings.iter().map(Finding::to_string)
    }

    /// Whether something may mislead the answer without making it impossible.
    pub fn is_worse(&self) -> bool {
        self.findings
            .iter()
            .any(|finding| finding.severity != Severity::Note)
    }
}

/// Faults that show in a sample and those before it.
fn faults_of_samples(rows: &Rows<'_>) -> Vec<Finding> {
    let mut health = SampleHealth::without_ranges();
    let mut findings: Vec<Finding> = Vec::new();
    let mut open = false;
    for (index, &time_s) in rows.times_s.iter().enumerate() {
        let walking = index >= rows.walk_start;
        if let Some(fault) = health.take(time_s, &rows.sample(index), walking) {
            findings.push(Finding {
                kind: match fault.kind() {
                    FaultKind::Frozen => FindingKind::Frozen,
                    FaultKind::DeadAccelerometer => FindingKind::DeadAccelerometer,
                    FaultKind::DeadGyroscope => FindingKind::DeadGyroscope,
                    FaultKind::Saturated => FindingKind::Saturated,
                    FaultKind::Impossible => FindingKind::Impossible,
                },
                severity: Severity::Useless,
                from_s: fault.since_s(),
                to_s: time_s,
                reason: fault.to_string(),
                cure: None,
            });
            open = true;
        }
        match findings.last_mut() {
            Some(last) if open && health.fault().is_some() => last.to_s = time_s,
            _ => open = false,
        }
    }
    findings
}

/// A log without a walk whose values stay the same from some time to its end, for longer than
/// a filter holds the angles of a robot at rest.
fn still_to_the_end(rows: &Rows<'_>) -> Option<Finding> {
    const LONGEST_REST_S: f64 = 3.0;
    let last = rows.times_s.len().checked_sub(1)?;
    let held = rows.sample(last);
    let from = (0..last)
        .rev()
        .find(|&index| rows.sample(index) != held)
        .map_or(0, |changed| changed + 1);
    let (from_s, to_s) = (rows.times_s[from], rows.times_s[last]);
    let is_frozen = !rows.has_walk() && last > from && to_s - from_s > LONGEST_REST_S;
    is_frozen.then(|| Finding {
        kind: FindingKind::Frozen,
        severity: Severity::Useless,
        from_s,
        to_s,
        reason: format!(
            "no motion: no value changes from {from_s:.2} s to the end, as those of a working sensor do"
        ),
        cure: None,
    })
}

/// Rows that repeat the values of those before them.
fn held(rows: &Rows<'_>, value_rate_hz: f64, sample_rate_hz: f64) -> Option<Finding> {
    (value_rate_hz < HELD_SHARE * sample_rate_hz).then(|| {
        let reason = format!(
            "values change {value_rate_hz:.1} times a second, although there are \
             {sample_rate_hz:.1} rows a second"
        );
        rows.finding(FindingKind::Held, Severity::Note, reason, None)
    })
}

/// How often the values change while the robot walks.
fn value_rate_hz(rows: &Rows<'_>) -> f64 {
    let walking = rows.walking();
    let times_s = &rows.times_s[walking.clone()];
    let span_s = (
        times_s.first().copied().unwrap_or(0.0),
        times_s.last().copied().unwrap_or(0.0),
    );
    let mut last = None;
    let changes = walking
        .filter(|&index| {
            let sample = rows.sample(index);
            let changed = last != Some(sample);
            last = Some(sample);
            changed
        })
        .count();
    rate_hz(changes, span_s)
}

fn rate_hz(samples: usize, (first_s, last_s): (f64, f64)) -> f64 {
    let intervals = samples.saturating_sub(1) as f64;
    if last_s > first_s {
        intervals / (last_s - first_s)
    } else {
        0.0
    }
}

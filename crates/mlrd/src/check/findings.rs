use std::{
    io::{self, Write},
    process::ExitCode,
};

use mlr_imu::of_a_screen;
use serde::Serialize;

use super::computer::Speed;

/// How well one thing is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Mark {
    Ok,
    Warning,
    Failed,
}

impl Mark {
    fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Warning => "warning",
            Self::Failed => "failed",
        }
    }
}

/// What was found of one thing.
#[derive(Debug, Clone, Serialize)]
struct Finding {
    check: &'static str,
    mark: Mark,
    found: String,
    /// What to do about it.
    #[serde(skip_serializing_if = "Option::is_none")]
    cure: Option<String>,
}

/// Everything found so far, shown line by line or as one object at the end.
#[derive(Debug)]
pub(super) struct Findings {
    shown: bool,
    report: Report,
}

#[derive(Debug, Serialize)]
struct Report {
    schema: &'static str,
    /// The worst mark.
    mark: Mark,
    checks: Vec<Finding>,
    #[serde(skip_serializing_if = "Option::is_none")]
    speed: Option<Speed>,
}

impl Findings {
    pub(super) fn new(shown: bool) -> Self {
        Self {
            shown,
            report: Report {
                schema: "mlr.check/1",
                mark: Mark::Ok,
                checks: Vec::new(),
                speed: None,
            },
        }
    }

    pub(super) fn ok(&mut self, check: &'static str, found: impl Into<String>) {
        self.add(check, Mark::Ok, found.into(), None);
    }

    pub(super) fn warning(
        &mut self,
        check: &'static str,
        found: impl Into<String>,
        cure: impl Into<String>,
    ) {
        self.add(check, Mark::Warning, found.into(), Some(cure.into()));
    }

    pub(super) fn failed(
        &mut self,
        check: &'static str,
        found: impl Into<String>,
        cure: impl Into<String>,
    ) {
        self.add(check, Mark::Failed, found.into(), Some(cure.into()));
    }

    /// A finding whose mark follows from a number.
    pub(super) fn add(
        &mut self,
        check: &'static str,
        mark: Mark,
        found: String,
        cure: Option<String>,
    ) {
        let finding = Finding {
            check,
            mark,
            found,
            cure,
        };
        if self.shown {
            // Whoever closed stdout reads the exit status.
            let _ = io::stdout().write_all(finding.lines().as_bytes());
        }
        self.report.mark = self.report.mark.max(mark);
        self.report.checks.push(finding);
    }

    pub(super) fn speed(&mut self, speed: Speed) {
        if self.shown {
            // As above.
            let _ = io::stdout().write_all(speed.lines().as_bytes());
        }
        self.report.speed = Some(speed);
    }

    pub(super) fn finish(self) -> ExitCode {
        if !self.shown {
            // As above; every value of the report is text or a number.
            let text = serde_json::to_string(&self.report).unwrap_or_default();
            let _ = writeln!(io::stdout(), "{text}");
        }
        match self.report.mark {
            Mark::Ok | Mark::Warning => ExitCode::SUCCESS,
            Mark::Failed => ExitCode::FAILURE,
        }
    }
}

/// Where what was found begins on a line.
pub(super) const COLUMN: usize = 22;

impl Finding {
    fn lines(&self) -> String {
        let indent = " ".repeat(COLUMN);
        let text = of_a_screen(&self.found).replace('\n', &format!("\n{indent}"));
        let mut lines = format!("{:<8} {:<12} {text}\n", self.mark.name(), self.check);
        if let Some(cure) = &self.cure {
            lines += &format!("{indent}→ {}\n", of_a_screen(cure));
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_mark_is_that_of_the_report() {
        let mut findings = Findings::new(false);
        findings.ok("settings", "defaults");
        assert_eq!(findings.report.mark, Mark::Ok);
        findings.failed("port", "/dev/\u{1b}[2J does not exist", "plug it in");
        findings.warning("gravity", "odd", "calibrate it");
        assert_eq!(findings.report.mark, Mark::Failed);
        let lines = findings.report.checks[1].lines();
        assert!(lines.starts_with("failed   port         /dev/"), "{lines}");
        assert!(!lines.contains('\u{1b}'), "{lines}");
        assert!(lines.ends_with("→ plug it in\n"), "{lines}");
    }
}

//! Time stamps: numbers, or dates with times of day.

use jiff::{Timestamp, civil::DateTime, tz::TimeZone};

use super::number::Numbers;

/// Reads the time stamps of a log. The first one decides whether they are numbers or dates.
#[derive(Debug, Clone, Copy)]
pub(super) struct TimeStamps {
    /// What a number is multiplied by to give seconds.
    unit_s: f64,
    form: Form,
}

#[derive(Debug, Clone, Copy)]
enum Form {
    Unknown,
    Number,
    /// ISO 8601 or RFC 3339, counted from the first of them.
    Date {
        first: Timestamp,
        has_zone: bool,
    },
}

impl TimeStamps {
    pub(super) fn new(unit_s: f64) -> Self {
        Self {
            unit_s,
            form: Form::Unknown,
        }
    }

    /// Seconds: of a number as it is, of a date since the first one.
    pub(super) fn parse_s(&mut self, field: &[u8], numbers: &mut Numbers) -> Option<f64> {
        match self.form {
            Form::Number => Some(numbers.parse(field)? * self.unit_s),
            Form::Date { first, has_zone } => {
                let (now, _) = date(field).filter(|(_, zone)| *zone == has_zone)?;
                let elapsed_ns = now.as_nanosecond() - first.as_nanosecond();
                Some(elapsed_ns as f64 / 1e9)
            }
            Form::Unknown => {
                if let Some(number) = numbers.parse(field) {
                    self.form = Form::Number;
                    return Some(number * self.unit_s);
                }
                let (first, has_zone) = date(field)?;
                self.form = Form::Date { first, has_zone };
                Some(0.0)
            }
        }
    }
}

/// A date and time of day, and whether it has a time zone. Without one it is taken as UTC,
/// which makes no difference to what is between two of them.
fn date(field: &[u8]) -> Option<(Timestamp, bool)> {
    let text = str::from_utf8(field).ok()?;
    // A date without a time of day is no time stamp.
    text.contains([':', 'T']).then_some(())?;
    if let Ok(zoned) = text.parse::<Timestamp>() {
        return Some((zoned, true));
    }
    let local = text.parse::<DateTime>().ok()?;
    Some((local.to_zoned(TimeZone::UTC).ok()?.timestamp(), false))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse_s(fields: &[&str]) -> Vec<Option<f64>> {
        let mut stamps = TimeStamps::new(1e-3);
        let mut numbers = Numbers::new(true);
        let mut parse = |field: &&str| stamps.parse_s(field.as_bytes(), &mut numbers);
        fields.iter().map(&mut parse).collect()
    }

    #[test]
    fn dates_in_every_usual_form() {
        for fields in [
            ["2026-02-28T23:59:59.5Z", "2026-03-01T00:00:00.75Z"],
            ["2026-02-28 23:59:59.5", "2026-03-01 00:00:00.75"],
            ["2026-02-28T23:59:59,500", "2026-03-01T00:00:00,750"],
            [
                "2026-02-28T23:59:59.5+02:00",
                "2026-03-01T00:00:00.75+02:00",
            ],
            // When clocks are put back, only the zone tells that time runs forward.
            [
                "2026-10-25T02:59:59.5+02:00",
                "2026-10-25T02:00:00.75+01:00",
            ],
            ["20260228T235959.5Z", "20260301T000000.75Z"],
        ] {
            assert_eq!(parse_s(&fields), [Some(0.0), Some(1.25)], "{fields:?}");
        }
    }

    #[test]
    fn the_first_time_stamp_decides() {
        let dates = ["2026-01-01T00:00:00Z", "12", "2026-01-01T00:00:01"];
        assert_eq!(parse_s(&dates), [Some(0.0), None, None]);
        let numbers = ["12", "2026-01-01T00:00:00Z", "13,5"];
        assert_eq!(parse_s(&numbers), [Some(0.012), None, Some(0.0135)]);
        for nonsense in ["", "2026-01-01", "2026-13-01T00:00:00", "12:30:01", "soon"] {
            assert_eq!(parse_s(&[nonsense]), [None], "{nonsense}");
        }
    }

    #[test]
    fn nanoseconds_survive() {
        let fields = ["2026-01-01T00:00:00Z", "2026-01-01T01:00:00.000000001Z"];
        assert_eq!(parse_s(&fields)[1], Some(3_600.000_000_001));
    }
}

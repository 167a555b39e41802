//! Reading a sensor's log.

use std::io::Read;

use mlr_imu::{LogColumn, LogProblem, LogTable};

use super::{SensorColumns, SensorSignals, columns::Siblings};

/// What a log says of a gyroscope and of the angle measured beside it.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorLog {
    /// What the sensor reports.
    pub signals: SensorSignals,
    /// The measured angle.
    pub angle_deg: Vec<f64>,
    /// What a person should know about how the log was read.
    pub notes: Vec<String>,
}

impl SensorLog {
    /// Reads a gyroscope's signals and the angle in degrees measured beside it. The sensor's other
    /// rates, accelerations and temperature are read where their names tell that they belong to
    /// it: `g2y_dps`, `g2z_dps`, `a2x_g`, `a2y_g` and `a2z_g` beside `g2x_dps`, and
    /// `temperature_c`. Time stamps are taken as they are; dates count from the first.
    ///
    /// # Errors
    /// [`LogProblem`] naming line and column.
    pub fn from_table(
        table: LogTable<impl Read>,
        columns: &SensorColumns,
    ) -> Result<Self, LogProblem> {
        let siblings = Siblings::find(table.names(), &columns.rate.0);
        let rate_scale = columns.rate.1.to_dps();
        let mut wanted = vec![
            LogColumn::of_times(table.find(&columns.time.0)?, columns.time.1.to_s()),
            LogColumn::of_numbers(table.find(&columns.rate.0)?, rate_scale * columns.sign),
            LogColumn::of_numbers(table.find(&columns.angle.0)?, columns.angle.1.to_deg()),
        ];
        let cross = siblings.cross.iter();
        wanted.extend(cross.map(|(_, index)| LogColumn::of_numbers(*index, rate_scale)));
        if let Some((indices, scale)) = siblings.accelerations {
            wanted.extend(indices.map(|index| LogColumn::of_numbers(index, scale)));
        }
        let temperature = siblings.temperature;
        wanted.extend(temperature.map(|index| LogColumn::of_numbers(index, 1.0)));

        let values = table.read(&wanted)?;
        let mut columns_read = values.columns.into_iter();
        let mut next = || columns_read.next().unwrap_or_default();
        let (times_s, rate_dps, angle_deg) = (next(), next(), next());
        let cross_rates_dps = siblings.cross.iter().map(|(axis, _)| (*axis, next()));
        let cross_rates_dps = cross_rates_dps.collect();
        let accelerations_g = siblings.accelerations.map(|_| [next(), next(), next()]);
        let signals = SensorSignals {
            sign: columns.sign,
            axis: siblings.axis,
            cross_rates_dps,
            accelerations_g,
            temperature_c: siblings.temperature.map(|_| next()),
            ..SensorSignals::new(times_s, rate_dps)
        };
        Ok(Self {
            signals,
            angle_deg,
            notes: values.notes,
        })
    }
}

#[cfg(test)]
mod tests {
    use mlr_imu::LogLimits;

    use super::*;
    use crate::{AngleUnit, RateUnit, TimeUnit};

    fn columns() -> SensorColumns {
        SensorColumns {
            time: ("t".into(), TimeUnit::Milliseconds),
            rate: ("gx_radps".into(), RateUnit::RadiansPerSecond),
            angle: ("encoder".into(), AngleUnit::Degrees),
            sign: -1.0,
        }
    }

    #[test]
    fn units_and_sign_are_applied_when_the_log_is_read() {
        let text = "\u{feff}encoder,gx_radps,t\r\n90,0.5,250\r\n";
        let table = LogTable::new(text.as_bytes(), LogLimits::default()).unwrap();
        let SensorLog {
            signals, angle_deg, ..
        } = SensorLog::from_table(table, &columns()).unwrap();
        assert_eq!(angle_deg, [90.0]);
        assert_eq!(signals.times_s, [0.25]);
        assert!((signals.rate_dps[0] + 28.647_889_756_5).abs() < 1e-9);
        assert!(signals.accelerations_g.is_none());
    }

    #[test]
    fn bad_input_is_named_with_line_and_column() {
        for (text, expected) in [
            (
                "t,gx_radps,encoder\n1,2,3\n1,x,3\n",
                "line 3, column \"gx_radps\": \"x\"",
            ),
            (
                "# 1\nt,gx,encoder\n1,2,3\n",
                "line 2: no column \"gx_radps\"",
            ),
            (
                "t,gx_radps,encoder,t\n1,2,3,4\n",
                "column \"t\" appears more than once",
            ),
            ("t,gx_radps,encoder\n", "no samples"),
            ("t,gx_radps,encoder\n1,2\n", "line 2: 2 fields"),
            ("", "is empty"),
        ] {
            let table = LogTable::new(text.as_bytes(), LogLimits::default());
            let problem = table.and_then(|table| SensorLog::from_table(table, &columns()));
            let message = problem.unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}

//! Reading a sensor's log.

use std::{io::Read, path::Path};

use mlr_imu::{LogError, LogProblem, LogTable};

use super::{SensorColumns, SensorSignals, columns::Siblings};

/// Reads a gyroscope's signals and the angle in degrees measured beside it from a
/// CSV file, plain or gzipped. The sensor's other rates, accelerations and
/// temperature are read where their names tell that they belong to it:
/// `g2y_dps`, `g2z_dps`, `a2x_g`, `a2y_g` and `a2z_g` beside `g2x_dps`, and
/// `temperature_c`. Time stamps are taken as they are.
///
/// # Errors
/// [`LogError`] naming file and, where it applies, line and column.
pub fn read_sensor_log(
    path: &Path,
    columns: &SensorColumns,
) -> Result<(SensorSignals, Vec<f64>), LogError> {
    LogTable::open(path)
        .and_then(|table| parse(table, columns))
        .map_err(|problem| LogError {
            path: path.into(),
            problem,
        })
}

fn parse(
    table: LogTable<impl Read>,
    columns: &SensorColumns,
) -> Result<(SensorSignals, Vec<f64>), LogProblem> {
    let siblings = Siblings::find(table.names(), &columns.rate.0);
    let rate_scale = columns.rate.1.to_dps();
    let mut wanted = vec![
        (table.find(&columns.time.0)?, columns.time.1.to_s()),
        (table.find(&columns.rate.0)?, rate_scale * columns.sign),
        (table.find(&columns.angle.0)?, columns.angle.1.to_deg()),
    ];
    wanted.extend(siblings.cross.iter().map(|(_, index)| (*index, rate_scale)));
    if let Some((indices, scale)) = siblings.accelerations {
        wanted.extend(indices.map(|index| (index, scale)));
    }
    wanted.extend(siblings.temperature.map(|index| (index, 1.0)));

    let mut values = table.read(&wanted)?.into_iter();
    let mut next = || values.next().unwrap_or_default();
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
    Ok((signals, angle_deg))
}

#[cfg(test)]
mod tests {
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
        let (signals, angle_deg) =
            parse(LogTable::new(text.as_bytes()).unwrap(), &columns()).unwrap();
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
            let table = LogTable::new(text.as_bytes());
            let problem = table.and_then(|table| parse(table, &columns()));
            let message = problem.unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}

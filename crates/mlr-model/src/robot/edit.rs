//! A description with other numbers, its comments and order kept.

use mlr_filter::SettingError;
use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, Value, value};

use super::Robot;
use crate::ModelError;

impl Robot {
    /// The text of a description of this robot with its numbers in place: servo, body, zeros of the
    /// joints, IMU and clock. A section `[calibration]` is left out: how surely the numbers are known
    /// is another matter.
    ///
    /// # Errors
    /// [`ModelError`] when the text is no description of a robot with as many legs.
    pub fn written_into(&self, text: &str) -> Result<String, ModelError> {
        let described = Self::from_toml(text)?;
        if described.layout() != self.layout() {
            return Err(ModelError::OtherRobot(self.name.clone()));
        }
        let parsed = text.parse::<DocumentMut>();
        let mut file = parsed.map_err(|error| SettingError::new("robot", error, "TOML"))?;
        file.remove("calibration");
        let servo = table(&mut file, "servo");
        set(
            servo,
            "stiffness_nm_per_rad",
            self.servo.stiffness_nm_per_rad,
        );
        set(
            servo,
            "damping_nm_s_per_rad",
            self.servo.damping_nm_s_per_rad,
        );
        let body = table(&mut file, "body");
        set(body, "mass_kg", self.body.mass_kg);
        set_all(
            body,
            "center_of_mass_m",
            self.body.center_of_mass_m.coords.as_slice(),
        );
        set_all(body, "inertia_kg_m2", self.body.inertia_kg_m2.as_slice());
        let legs = file.get_mut("legs").and_then(Item::as_array_of_tables_mut);
        let tables = legs.into_iter().flat_map(ArrayOfTables::iter_mut);
        for (table, leg) in tables.zip(&self.legs) {
            if table.contains_key("joint_zeros_rad")
                || leg.joint_zeros_rad.iter().any(|z| *z != 0.0)
            {
                set_all(table, "joint_zeros_rad", &leg.joint_zeros_rad);
            }
        }
        if file.contains_key("imu") || self.imu != super::Imu::default() {
            let imu = table(&mut file, "imu");
            set_all(imu, "mounting_deg", &self.imu.mounting_deg);
            set(imu, "gyro_scale", self.imu.gyro_scale);
        }
        if file.contains_key("controller") || self.clock != 1.0 {
            set(table(&mut file, "controller"), "clock", self.clock);
        }
        Ok(file.to_string())
    }
}

/// The section of this name, made where there is none.
fn table<'f>(file: &'f mut DocumentMut, name: &str) -> &'f mut Table {
    let section = file
        .entry(name)
        .or_insert_with(|| Item::Table(Table::new()));
    if !section.is_table() {
        // A section in one line becomes one of its own.
        let written = std::mem::take(section).into_table().unwrap_or_default();
        *section = Item::Table(written);
    }
    match section {
        Item::Table(table) => table,
        _ => unreachable!("it was made one"),
    }
}

fn set(table: &mut Table, key: &str, number: f64) {
    replace(table, key, rounded(number).into());
}

fn set_all(table: &mut Table, key: &str, numbers: &[f64]) {
    let numbers = numbers.iter().map(|number| rounded(*number));
    replace(table, key, numbers.collect::<toml_edit::Array>().into());
}

/// The comment behind a number stays.
fn replace(table: &mut Table, key: &str, mut new: Value) {
    if let Some(old) = table.get(key).and_then(Item::as_value) {
        *new.decor_mut() = old.decor().clone();
    }
    table[key] = value(new);
}

/// Seven digits: what is known of a robot has fewer.
fn rounded(number: f64) -> f64 {
    format!("{number:.6e}").parse().unwrap_or(number)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RobotParameter;

    #[test]
    fn a_description_written_back_is_the_same_but_for_its_numbers() {
        let text = Robot::JETHEXA_TOML;
        let robot = Robot::jethexa();
        // A control: nothing changed, nothing written.
        assert_eq!(
            robot.written_into(text).unwrap().lines().count(),
            text.lines().count()
        );
        let changed = RobotParameter::all(&robot)
            .into_iter()
            .enumerate()
            .fold(robot, |robot, (k, one)| {
                robot.with_added(one, 0.001 * (k as f64 + 1.0))
            });
        let written = changed.written_into(text).unwrap();
        let read = Robot::from_toml(&written).unwrap();
        for parameter in RobotParameter::all(&changed) {
            let off = parameter.coordinate(&read) - parameter.coordinate(&changed);
            assert!(off.abs() < 1e-6, "{parameter}: {off}");
        }
        assert_eq!(read.clone().written_into(&written).unwrap(), written);
        for comment in text.lines().filter(|line| line.starts_with('#')) {
            assert!(written.contains(comment), "{comment}");
        }
    }

    #[test]
    fn another_robots_text_is_refused() {
        let five = Robot::JETHEXA_TOML.rsplit_once("[[legs]]").unwrap().0;
        assert!(Robot::jethexa().written_into(five).is_err());
        assert!(Robot::jethexa().written_into("name = 1").is_err());
    }

    #[test]
    fn sections_in_one_line_are_written_too() {
        let (before, after) = Robot::JETHEXA_TOML.split_once("[body]").unwrap();
        let (_, after) = after.split_once("[servo]").unwrap();
        let body = "body = { size_m = [0.2, 0.1, 0.05], mass_kg = 1.0, center_of_mass_m = [0, 0, 0], inertia_kg_m2 = [0.01, 0.01, 0.01] }\n";
        let text = format!("{before}{body}[servo]{after}");
        let robot = Robot::from_toml(&text)
            .unwrap()
            .with_added(RobotParameter::BodyMass, 0.5);
        let read = Robot::from_toml(&robot.written_into(&text).unwrap()).unwrap();
        assert!((read.body().mass_kg - 0.5_f64.exp()).abs() < 1e-5);
    }
}

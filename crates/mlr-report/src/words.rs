//! Numbers and names as people read them.

use mlr_model::{Morphology, Robot};

/// A probability, in one line; what is neither 0 nor 1 is not shown as such.
pub(crate) fn percent(probability: f64) -> String {
    match 100.0 * probability {
        p if p > 0.0 && p < 0.5 => "<\u{a0}1\u{a0}%".into(),
        p if p < 100.0 && p > 99.5 => ">\u{a0}99\u{a0}%".into(),
        p => format!("{p:.0}\u{a0}%"),
    }
}

/// A kind of effect as words.
pub(crate) fn kind(kind: &str) -> String {
    match kind {
        "none" => "none".into(),
        "unknown" => "something unknown".into(),
        kind => kind.replace('_', " ").replace("imu ", "IMU "),
    }
}

/// A number with a true minus sign.
pub(crate) fn signed(number: &str) -> String {
    number.replace('-', "−")
}

/// Units at the end of a parameter's name, the longest first.
const UNITS: [(&str, &str); 13] = [
    ("_dps_per_min", "°/s per min"),
    ("_n_per_m", "N/m"),
    ("_kg", "kg"),
    ("_deg", "°"),
    ("_rad", "rad"),
    ("_dps", "°/s"),
    ("_nm", "N m"),
    ("_hz", "Hz"),
    ("_mm", "mm"),
    ("_ms", "ms"),
    ("_m", "m"),
    ("_s", "s"),
    ("_n", "N"),
];

/// A parameter's name without its unit, and the unit.
pub(crate) fn name_and_unit(name: &str) -> (String, &'static str) {
    let found = UNITS.iter().find_map(|(ending, unit)| {
        let name = name.strip_suffix(ending)?;
        (!name.is_empty()).then_some((name, *unit))
    });
    let (name, unit) = found.unwrap_or((name, ""));
    (name.replace('_', " "), unit)
}

/// Legs (from 1) with their names: "leg 2 (front right) and leg 3 (middle left)".
pub(crate) fn legs(numbers: &[usize], robot: &Robot) -> String {
    let each = numbers.iter().map(|number| {
        let leg = number
            .checked_sub(1)
            .and_then(|index| robot.legs().get(index));
        match leg {
            Some(leg) if !leg.name.is_empty() => format!("leg {number} ({})", leg.name),
            _ => format!("leg {number}"),
        }
    });
    let mut each: Vec<String> = each.collect();
    match each.pop() {
        None => "none".into(),
        Some(last) if each.is_empty() => last,
        Some(last) => format!("{} and {last}", each.join(", ")),
    }
}

/// What is left of a leg: "all 3 links", "1 of 3 links", "nothing".
pub(crate) fn left_of_leg(morphology: &Morphology, leg: usize) -> String {
    let (links, remaining) = (morphology.links(leg), morphology.remaining(leg));
    match remaining {
        0 => "nothing".into(),
        all if all == links => format!("all {links} links"),
        some => format!("{some} of {links} links"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_read_from_names() {
        for (name, read) in [
            ("mass_kg", ("mass", "kg")),
            ("x_m", ("x", "m")),
            ("torque_nm", ("torque", "N m")),
            ("dps_per_min", ("dps per min", "")),
            ("rate_dps_per_min", ("rate", "°/s per min")),
            ("stiffness", ("stiffness", "")),
            ("length_lost_m", ("length lost", "m")),
        ] {
            let (words, unit) = name_and_unit(name);
            assert_eq!((words.as_str(), unit), read);
        }
    }

    #[test]
    fn legs_are_named() {
        let robot = Robot::jethexa();
        assert_eq!(legs(&[], &robot), "none");
        assert_eq!(legs(&[4], &robot), "leg 4 (middle right)");
        let several = legs(&[1, 2, 9], &robot);
        assert_eq!(several, "leg 1 (front left), leg 2 (front right) and leg 9");
    }
}

//! What to type for a column that is not there.

use super::columns::{Column, Columns, Quantity, as_typed};

/// How alike two names must be, of 1 for the same (Jaro and Winkler).
const ALIKE: f64 = 0.88;

/// The end of a name that tells a unit, and how `--column` calls that unit.
const UNIT_ENDINGS: [(&str, &str); 27] = [
    ("deg", "deg"),
    ("degree", "deg"),
    ("degrees", "deg"),
    ("°", "deg"),
    ("rad", "rad"),
    ("radian", "rad"),
    ("radians", "rad"),
    ("dps", "dps"),
    ("deg/s", "dps"),
    ("degps", "dps"),
    ("°/s", "dps"),
    ("rad/s", "radps"),
    ("radps", "radps"),
    ("rads", "radps"),
    ("g", "g"),
    ("mps2", "mps2"),
    ("ms2", "mps2"),
    ("m/s2", "mps2"),
    ("m/s²", "mps2"),
    ("m/s^2", "mps2"),
    ("s", "s"),
    ("sec", "s"),
    ("ms", "ms"),
    ("us", "us"),
    ("µs", "us"),
    ("ns", "ns"),
    ("nsec", "ns"),
];

/// Other names for what `--column` calls `key`.
fn synonyms(key: &str) -> &'static [&'static str] {
    match key {
        "t" => &[
            "time",
            "timestamp",
            "stamp",
            "elapsed",
            "clock",
            "date",
            "datetime",
        ],
        "roll" => &["phi", "eulerx"],
        "pitch" => &["theta", "eulery"],
        "yaw" => &["heading", "psi", "eulerz"],
        "qw" => &[
            "orientationw",
            "quatw",
            "quaternionw",
            "quaternion0",
            "quat0",
            "w",
        ],
        "qx" => &[
            "orientationx",
            "quatx",
            "quaternionx",
            "quaternion1",
            "quat1",
        ],
        "qy" => &[
            "orientationy",
            "quaty",
            "quaterniony",
            "quaternion2",
            "quat2",
        ],
        "qz" => &[
            "orientationz",
            "quatz",
            "quaternionz",
            "quaternion3",
            "quat3",
        ],
        "ax" => &[
            "accx",
            "accelx",
            "accelerationx",
            "linearaccelerationx",
            "accelerometerx",
        ],
        "ay" => &[
            "accy",
            "accely",
            "accelerationy",
            "linearaccelerationy",
            "accelerometery",
        ],
        "az" => &[
            "accz",
            "accelz",
            "accelerationz",
            "linearaccelerationz",
            "accelerometerz",
        ],
        "gx" => &[
            "gyrx",
            "gyrox",
            "gyroscopex",
            "angularvelocityx",
            "wx",
            "omegax",
        ],
        "gy" => &[
            "gyry",
            "gyroy",
            "gyroscopey",
            "angularvelocityy",
            "wy",
            "omegay",
        ],
        "gz" => &[
            "gyrz",
            "gyroz",
            "gyroscopez",
            "angularvelocityz",
            "wz",
            "omegaz",
        ],
        _ => &[],
    }
}

/// What to add to the message that a column is missing: the `--column` arguments to try, for all
/// columns of the kind that this log seems to hold. Empty if no name is alike.
pub(super) fn hint(columns: &Columns, names: &[String]) -> String {
    let kinds: [&[Column]; 3] = [&columns.angles, &columns.quaternion, &columns.raw];
    let there = |kind: &[Column]| {
        let found = |column: &&Column| is_there(column, names) || nearest(column, names).is_some();
        kind.iter().filter(found).count() as f64 / kind.len() as f64
    };
    // The kind of which most is there; of equally much, the first.
    let mut best = kinds[0];
    for kind in kinds {
        if there(kind) > there(best) {
            best = kind;
        }
    }
    let arguments: Vec<String> = std::iter::once(&columns.time)
        .chain(best)
        .filter(|column| !is_there(column, names))
        .filter_map(|column| argument(column, nearest(column, names)?))
        .collect();
    if arguments.is_empty() {
        String::new()
    } else {
        format!("; try {}", arguments.join(" "))
    }
}

/// The names that are like the one looked for, most alike first.
pub(super) fn alike<'a>(wanted: &str, names: &'a [String]) -> Vec<&'a str> {
    let folded = wanted.to_lowercase();
    let (core, _) = core_of(wanted);
    let score = |name: &str| {
        let whole = 0.98 * strsim::jaro_winkler(&folded, &name.to_lowercase());
        likeness(&core, name).max(whole)
    };
    let mut scored: Vec<(f64, &str)> = names
        .iter()
        .map(|name| (score(name), name.as_str()))
        .filter(|(score, _)| *score >= ALIKE)
        .collect();
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    scored.into_iter().take(3).map(|(_, name)| name).collect()
}

fn is_there(column: &Column, names: &[String]) -> bool {
    let wanted = column.name.to_lowercase();
    names.iter().any(|name| name.to_lowercase() == wanted)
}

/// The name that is most like a column's, if one is.
fn nearest<'a>(column: &Column, names: &'a [String]) -> Option<&'a str> {
    let mut wanted = vec![column.key.to_string(), core_of(&column.name).0];
    wanted.extend(synonyms(column.key).iter().map(|name| (*name).to_string()));
    let score = |name: &str| {
        let likes = wanted.iter().map(|wanted| likeness(wanted, name));
        likes.fold(0.0, f64::max)
    };
    let fitting = names
        .iter()
        .filter(|name| unit(column.quantity, name).is_ok());
    fitting
        .map(|name| (score(name), name.as_str()))
        .filter(|(score, _)| *score >= ALIKE)
        .fold(None, |best: Option<(f64, &str)>, now| match best {
            Some(best) if best.0 >= now.0 => Some(best),
            _ => Some(now),
        })
        .map(|(_, name)| name)
}

/// How like the core of a name, or the end of its path, is to what is looked for.
fn likeness(wanted: &str, name: &str) -> f64 {
    let (core, _) = core_of(name);
    if core == wanted {
        return 1.0;
    }
    // As in imu.roll or /imu/linear_acceleration/x.
    let parts: Vec<String> = name
        .split(['.', '/', ':', ' '])
        .map(|p| core_of(p).0)
        .collect();
    let ends_alike =
        (1..parts.len()).any(|begin| parts.get(begin..).is_some_and(|end| end.concat() == wanted));
    if ends_alike {
        return 0.99;
    }
    // Short names are alike by chance: ax and az.
    if wanted.len() < 3 || core.len() < 3 {
        return 0.0;
    }
    0.98 * strsim::jaro_winkler(wanted, &core)
}

/// A name in small letters and digits, without its unit; and that unit.
fn core_of(name: &str) -> (String, Option<&'static str>) {
    let folded = name.trim().to_lowercase();
    let bare = folded.trim_end_matches([']', ')', '}']);
    let split = bare.rfind(['_', '[', '(', '{', ' ', '.', '-']);
    let (stem, unit) = split
        .and_then(|at| {
            let ending = bare
                .get(at..)?
                .trim_start_matches(['_', '[', '(', '{', ' ', '.', '-']);
            let unit = UNIT_ENDINGS.iter().find(|(known, _)| *known == ending)?;
            Some((bare.get(..at)?, Some(unit.1)))
        })
        .unwrap_or((&folded, None));
    (stem.chars().filter(|c| c.is_alphanumeric()).collect(), unit)
}

/// The unit that a name tells, if it tells one.
///
/// # Errors
/// When it is of another quantity.
fn unit(quantity: Quantity, name: &str) -> Result<Option<&'static str>, ()> {
    match core_of(name).1 {
        None => Ok(None),
        Some(unit) if quantity.units().iter().any(|(known, _)| *known == unit) => Ok(Some(unit)),
        Some(_) => Err(()),
    }
}

/// The `--column` argument that maps a name.
fn argument(column: &Column, name: &str) -> Option<String> {
    let unit = unit(column.quantity, name).ok()?;
    let default = column.quantity.units().first().map(|(unit, _)| *unit);
    // A comma in the name needs a unit behind it.
    let unit = unit.or(default.filter(|_| name.contains(',')));
    let unit = unit.map_or(String::new(), |unit| format!(",{unit}"));
    let mapping = format!("{}={name}{unit}", column.key);
    Some(as_typed(&mapping))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hint_for(names: &[&str]) -> String {
        let names: Vec<String> = names.iter().map(|name| (*name).to_string()).collect();
        hint(&Columns::default(), &names)
    }

    #[test]
    fn units_are_guessed_from_names() {
        assert_eq!(
            hint_for(&["t_ms", "roll_deg", "Pitch", "imu.yaw", "temperature"]),
            "; try --column t=t_ms,ms --column roll=roll_deg,deg --column pitch=Pitch \
             --column yaw=imu.yaw"
        );
        assert_eq!(
            hint_for(&["t_s", "ax_g", "ay_g", "az_g", "gx_dps", "gy_dps", "gz_dps"]),
            "; try --column ax=ax_g,g --column ay=ay_g,g --column az=az_g,g \
             --column gx=gx_dps,dps --column gy=gy_dps,dps --column gz=gz_dps,dps"
        );
    }

    #[test]
    fn the_kind_that_is_there_is_suggested() {
        let hint = hint_for(&[
            "timestamp",
            "orientation.w",
            "orientation.x",
            "orientation.y",
            "orientation.z",
            "angular_velocity.x",
        ]);
        assert_eq!(
            hint,
            "; try --column t=timestamp --column qw=orientation.w --column qx=orientation.x \
             --column qy=orientation.y --column qz=orientation.z"
        );
        let hint = hint_for(&["time", "Roll [°]", "Pitch [°]", "Yaw, true [°]"]);
        assert_eq!(
            hint,
            "; try --column t=time --column 'roll=Roll [°],deg' --column 'pitch=Pitch [°],deg'"
        );
        let hint = hint_for(&[
            "time", "acc_x", "acc_y", "acc_z", "gyro_x", "gyro_y", "gyro_z",
        ]);
        assert!(
            hint.contains("--column gz=gyro_z") && hint.contains("ax=acc_x"),
            "{hint}"
        );
    }

    #[test]
    fn misspelt_names_are_near_and_others_are_not() {
        assert!(hint_for(&["t_s", "rol_rad", "pitch_rad", "yaw_rad"]).contains("roll=rol_rad,rad"));
        assert_eq!(hint_for(&["voltage", "current", "x"]), "");
        // An angle is no rate, and a rate no acceleration.
        assert!(!hint_for(&["t_s", "roll_dps", "pitch_dps", "yaw_dps"]).contains("roll"));
        let names = ["gx_dps".to_string(), "encoder".into(), "encoder_deg".into()];
        assert_eq!(alike("encodr_deg", &names), ["encoder", "encoder_deg"]);
        assert_eq!(alike("gx_dsp", &names), ["gx_dps"]);
    }

    #[test]
    fn what_a_shell_would_take_apart_is_quoted() {
        let hint = hint_for(&["t_s", "roll; rm -rf ~", "roll$(x)", "it's.roll"]);
        assert!(hint.contains("--column 'roll=it'\\''s.roll'"), "{hint}");
    }
}

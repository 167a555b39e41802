//! The TOML form of a robot description and its checks.

use std::{collections::BTreeMap, ops::RangeInclusive};

use mlr_filter::SettingError;
use nalgebra::{DMatrix, DVector, Point3, Vector3};
use serde::{Deserialize, de::IgnoredAny};

use super::{
    Body, Calibration, ContactShape, Gaussian, Imu, JointAxis, Leg, Link, Robot, RobotParameter,
    Servo,
};
use crate::ModelError;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RobotFile {
    name: String,
    body: BodyFile,
    servo: Servo,
    links: BTreeMap<String, LinkFile>,
    legs: Vec<LegFile>,
    #[serde(default)]
    imu: Imu,
    #[serde(default)]
    controller: ControllerFile,
    calibration: Option<CalibrationFile>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ControllerFile {
    clock: f64,
}

impl Default for ControllerFile {
    fn default() -> Self {
        Self { clock: 1.0 }
    }
}

/// What says how surely the parameters are known. The rest of the section is a record of how it came
/// about, for people.
#[derive(Deserialize)]
struct CalibrationFile {
    parameters: Vec<CalibratedFile>,
    /// The lower triangle, row by row.
    covariance: Vec<Vec<f64>>,
    physical_covariance: Vec<Vec<f64>>,
    #[serde(flatten)]
    _record: BTreeMap<String, IgnoredAny>,
}

#[derive(Deserialize)]
struct CalibratedFile {
    name: String,
    physical: f64,
    #[serde(flatten)]
    _record: BTreeMap<String, IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BodyFile {
    size_m: [f64; 3],
    mass_kg: f64,
    center_of_mass_m: [f64; 3],
    inertia_kg_m2: [f64; 3],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LinkFile {
    joint: JointAxis,
    length_m: f64,
    mass_kg: f64,
    center_of_mass_m: f64,
    inertia_kg_m2: [f64; 3],
    posture_deg: f64,
    locked_deg: f64,
    contact: Option<ContactFile>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "lowercase", tag = "shape")]
enum ContactFile {
    Capsule { radius_m: f64 },
    Foot { radius_m: f64 },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LegFile {
    name: String,
    hip_m: [f64; 3],
    hip_yaw_deg: f64,
    nominal_foot_m: [f64; 2],
    links: Vec<String>,
    joint_zeros_rad: Option<Vec<f64>>,
}

pub(super) fn parse(text: &str) -> Result<Robot, ModelError> {
    let file: RobotFile = toml::from_str(text).map_err(|source| ModelError::Syntax {
        what: "robot",
        source: Box::new(source),
    })?;
    file.servo.check().map_err(|error| error.under("servo"))?;
    let links = file
        .links
        .into_iter()
        .map(|(name, link)| Ok((name.clone(), link_from_file(name, &link)?)))
        .collect::<Result<BTreeMap<_, _>, SettingError>>()?;
    if file.legs.is_empty() {
        return Err(SettingError::new("legs", "none", "at least one leg").into());
    }
    let legs = file
        .legs
        .into_iter()
        .enumerate()
        .map(|(index, leg)| leg_from_file(index, leg, &links))
        .collect::<Result<Vec<_>, _>>()?;
    if !legs
        .iter()
        .flat_map(|leg| &leg.links)
        .any(|link| link.contact.is_some())
    {
        let expected = "a link with a contact, with which a leg can touch the ground";
        return Err(SettingError::new("links", "none with a contact", expected).into());
    }
    check_imu(&file.imu).map_err(|error| error.under("imu"))?;
    let clock = file.controller.clock;
    SettingError::check("controller.clock", clock, 0.1..=10.0, "")?;
    let robot = Robot {
        name: file.name,
        body: body_from_file(&file.body)?,
        servo: file.servo,
        legs,
        imu: file.imu,
        clock,
        calibration: None,
    };
    Ok(match &file.calibration {
        None => robot,
        Some(calibration) => {
            let calibration = calibration_from_file(&robot, calibration);
            robot.with_calibration(calibration.map_err(|error| error.under("calibration"))?)
        }
    })
}

fn check_imu(imu: &Imu) -> Result<(), SettingError> {
    SettingError::check_each("mounting_deg", &imu.mounting_deg, ANGLES_DEG, "degrees")?;
    SettingError::check("gyro_scale", imu.gyro_scale, 0.1..=10.0, "")
}

fn calibration_from_file(
    robot: &Robot,
    file: &CalibrationFile,
) -> Result<Calibration, SettingError> {
    let named = file.parameters.iter().enumerate().map(|(index, one)| {
        one.name.parse().map_err(|_| {
            let field = format!("parameters[{index}].name");
            let expected = "a name such as \"servo_stiffness\" or \"joint_zero_leg1_2\"";
            SettingError::new(field, &one.name, expected)
        })
    });
    let parameters = named.collect::<Result<Vec<RobotParameter>, _>>()?;
    let n = parameters.len();
    let physical = Gaussian {
        mean: DVector::from_iterator(n, file.parameters.iter().map(|one| one.physical)),
        covariance: from_lower("physical_covariance", &file.physical_covariance, n)?,
    };
    let covariance = from_lower("covariance", &file.covariance, n)?;
    Calibration::new(robot, parameters, covariance, physical)
}

/// The symmetric matrix with this lower triangle, row by row.
fn from_lower(name: &str, rows: &[Vec<f64>], n: usize) -> Result<DMatrix<f64>, SettingError> {
    if rows.len() != n {
        let found = format!("{} rows", rows.len());
        let expected = format!("{n}, one for each parameter");
        return Err(SettingError::new(name, found, expected));
    }
    for (row, numbers) in rows.iter().enumerate() {
        if numbers.len() != row + 1 {
            let found = format!("{} numbers", numbers.len());
            let expected = format!("{}: the lower triangle", row + 1);
            return Err(SettingError::new(format!("{name}[{row}]"), found, expected));
        }
    }
    Ok(DMatrix::from_fn(n, n, |i, j| rows[i.max(j)][i.min(j)]))
}

fn body_from_file(body: &BodyFile) -> Result<Body, SettingError> {
    SettingError::check_each("body.size_m", &body.size_m, LENGTHS_M, "m")?;
    check_mass("body.mass_kg", body.mass_kg)?;
    let center_m = &body.center_of_mass_m;
    SettingError::check_each("body.center_of_mass_m", center_m, PLACES_M, "m")?;
    check_inertia("body.inertia_kg_m2", body.inertia_kg_m2)?;
    Ok(Body {
        size_m: Vector3::from(body.size_m),
        mass_kg: body.mass_kg,
        center_of_mass_m: Point3::from(body.center_of_mass_m),
        inertia_kg_m2: Vector3::from(body.inertia_kg_m2),
    })
}

fn link_from_file(name: String, link: &LinkFile) -> Result<Link, SettingError> {
    let field = |part: &str| format!("links.{name}.{part}");
    let check = |part: &str, value, bounds, unit| {
        SettingError::check::<f64>(field(part), value, bounds, unit)
    };
    check("length_m", link.length_m, LENGTHS_M, "m")?;
    check_mass(&field("mass_kg"), link.mass_kg)?;
    check("center_of_mass_m", link.center_of_mass_m, PLACES_M, "m")?;
    check_inertia(&field("inertia_kg_m2"), link.inertia_kg_m2)?;
    check("posture_deg", link.posture_deg, ANGLES_DEG, "degrees")?;
    check("locked_deg", link.locked_deg, ANGLES_DEG, "degrees")?;
    let contact = match link.contact {
        None => None,
        Some(ContactFile::Capsule { radius_m }) => Some(ContactShape::Capsule { radius_m }),
        Some(ContactFile::Foot { radius_m }) => Some(ContactShape::Foot { radius_m }),
    };
    if let Some(ContactShape::Capsule { radius_m } | ContactShape::Foot { radius_m }) = contact {
        check("contact.radius_m", radius_m, LENGTHS_M, "m")?;
    }
    Ok(Link {
        joint: link.joint,
        length_m: link.length_m,
        mass_kg: link.mass_kg,
        center_of_mass_m: link.center_of_mass_m,
        inertia_kg_m2: Vector3::from(link.inertia_kg_m2),
        posture_rad: link.posture_deg.to_radians(),
        locked_rad: link.locked_deg.to_radians(),
        contact,
        name,
    })
}

fn leg_from_file(
    index: usize,
    leg: LegFile,
    known_links: &BTreeMap<String, Link>,
) -> Result<Leg, SettingError> {
    let field = |part: &str| format!("legs[{index}].{part}");
    SettingError::check_each(&field("hip_m"), &leg.hip_m, PLACES_M, "m")?;
    let yaw_deg = leg.hip_yaw_deg;
    SettingError::check(field("hip_yaw_deg"), yaw_deg, ANGLES_DEG, "degrees")?;
    SettingError::check_each(&field("nominal_foot_m"), &leg.nominal_foot_m, PLACES_M, "m")?;
    if leg.links.is_empty() || leg.links.len() > usize::from(u8::MAX) {
        return Err(SettingError::new(
            field("links"),
            format!("a list of {}", leg.links.len()),
            "1 to 255 links",
        ));
    }
    let links = leg
        .links
        .into_iter()
        .map(|name| {
            known_links.get(&name).cloned().ok_or_else(|| {
                SettingError::new(field("links"), name, "the name of a table [links.NAME]")
            })
        })
        .collect::<Result<Vec<_>, _>>()?;
    let joint_zeros_rad = leg
        .joint_zeros_rad
        .unwrap_or_else(|| vec![0.0; links.len()]);
    if joint_zeros_rad.len() != links.len() {
        let found = format!("a list of {}", joint_zeros_rad.len());
        let expected = format!("{}, one for each joint", links.len());
        return Err(SettingError::new(field("joint_zeros_rad"), found, expected));
    }
    let zeros = &joint_zeros_rad;
    SettingError::check_each(&field("joint_zeros_rad"), zeros, -3.2..=3.2, "rad")?;
    Ok(Leg {
        joint_zeros_rad,
        name: leg.name,
        hip_m: Point3::from(leg.hip_m),
        hip_yaw_rad: leg.hip_yaw_deg.to_radians(),
        nominal_foot_m: leg.nominal_foot_m,
        links,
    })
}

/// Of bodies, links and contacts.
const LENGTHS_M: RangeInclusive<f64> = 1e-4..=1e3;
/// Of hips, feet and centres of mass, along each axis.
const PLACES_M: RangeInclusive<f64> = -1e3..=1e3;
/// Of joints and hips.
const ANGLES_DEG: RangeInclusive<f64> = -360.0..=360.0;

fn check_mass(field: &str, value: f64) -> Result<(), SettingError> {
    if (1e-6..=1e5).contains(&value) {
        return Ok(());
    }
    let expected = "a mass of 0.000001 to 100000 kg";
    Err(SettingError::new(field, value, expected))
}

/// Principal moments of a real body obey the triangle inequality.
fn check_inertia(field: &str, moments: [f64; 3]) -> Result<(), SettingError> {
    for (axis, moment) in moments.iter().enumerate() {
        if !(1e-30..=1e9).contains(moment) {
            let expected = "a positive moment of inertia, in kg m²";
            return Err(SettingError::new(
                format!("{field}[{axis}]"),
                moment,
                expected,
            ));
        }
    }
    let [a, b, c] = moments;
    let slack = 1.0 + 1e-9;
    if a <= (b + c) * slack && b <= (a + c) * slack && c <= (a + b) * slack {
        Ok(())
    } else {
        Err(SettingError::new(
            field,
            format!("[{a}, {b}, {c}]"),
            "three moments, none larger than the sum of the others",
        ))
    }
}

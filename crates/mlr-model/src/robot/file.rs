//! The TOML form of a robot description and its checks.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};
use serde::Deserialize;

use super::{Body, ContactShape, JointAxis, Leg, Link, Robot, Servo};
use crate::ModelError;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RobotFile {
    name: String,
    body: BodyFile,
    servo: Servo,
    links: BTreeMap<String, LinkFile>,
    legs: Vec<LegFile>,
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
}

pub(super) fn parse(text: &str) -> Result<Robot, ModelError> {
    let file: RobotFile = toml::from_str(text).map_err(|source| ModelError::Syntax {
        what: "robot",
        source: Box::new(source),
    })?;
    file.servo.check()?;
    let links = file
        .links
        .into_iter()
        .map(|(name, link)| Ok((name.clone(), link_from_file(name, &link)?)))
        .collect::<Result<BTreeMap<_, _>, ModelError>>()?;
    if file.legs.is_empty() {
        return Err(ModelError::value("legs", "none", "at least one leg"));
    }
    let legs = file
        .legs
        .into_iter()
        .enumerate()
        .map(|(index, leg)| leg_from_file(index, leg, &links))
        .collect::<Result<Vec<_>, _>>()?;
    Ok(Robot {
        name: file.name,
        body: body_from_file(&file.body)?,
        servo: file.servo,
        legs,
    })
}

fn body_from_file(body: &BodyFile) -> Result<Body, ModelError> {
    for (axis, size_m) in body.size_m.iter().enumerate() {
        check_length(format!("body.size_m[{axis}]"), *size_m)?;
    }
    check_mass("body.mass_kg".into(), body.mass_kg)?;
    check_finite("body.center_of_mass_m", &body.center_of_mass_m)?;
    check_inertia("body.inertia_kg_m2", body.inertia_kg_m2)?;
    Ok(Body {
        size_m: Vector3::from(body.size_m),
        mass_kg: body.mass_kg,
        center_of_mass_m: Point3::from(body.center_of_mass_m),
        inertia_kg_m2: Vector3::from(body.inertia_kg_m2),
    })
}

fn link_from_file(name: String, link: &LinkFile) -> Result<Link, ModelError> {
    let field = |part: &str| format!("links.{name}.{part}");
    check_length(field("length_m"), link.length_m)?;
    check_mass(field("mass_kg"), link.mass_kg)?;
    check_finite(&field("center_of_mass_m"), &[link.center_of_mass_m])?;
    check_inertia(&field("inertia_kg_m2"), link.inertia_kg_m2)?;
    check_finite(&field("posture_deg"), &[link.posture_deg])?;
    check_finite(&field("locked_deg"), &[link.locked_deg])?;
    let contact = match link.contact {
        None => None,
        Some(ContactFile::Capsule { radius_m }) => Some(ContactShape::Capsule { radius_m }),
        Some(ContactFile::Foot { radius_m }) => Some(ContactShape::Foot { radius_m }),
    };
    if let Some(ContactShape::Capsule { radius_m } | ContactShape::Foot { radius_m }) = contact {
        check_length(field("contact.radius_m"), radius_m)?;
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
) -> Result<Leg, ModelError> {
    let field = |part: &str| format!("legs[{index}].{part}");
    check_finite(&field("hip_m"), &leg.hip_m)?;
    check_finite(&field("hip_yaw_deg"), &[leg.hip_yaw_deg])?;
    check_finite(&field("nominal_foot_m"), &leg.nominal_foot_m)?;
    if leg.links.is_empty() || leg.links.len() > usize::from(u8::MAX) {
        return Err(ModelError::value(
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
                ModelError::value(field("links"), name, "the name of a table [links.NAME]")
            })
        })
        .collect::<Result<Vec<_>, _>>()?;
    Ok(Leg {
        name: leg.name,
        hip_m: Point3::from(leg.hip_m),
        hip_yaw_rad: leg.hip_yaw_deg.to_radians(),
        nominal_foot_m: leg.nominal_foot_m,
        links,
    })
}

fn check_finite(field: &str, values: &[f64]) -> Result<(), ModelError> {
    match values.iter().find(|value| !value.is_finite()) {
        Some(value) => Err(ModelError::value(field, value, "a finite number")),
        None => Ok(()),
    }
}

fn check_length(field: String, value: f64) -> Result<(), ModelError> {
    ModelError::check_range(
        field,
        value,
        1e-4,
        1e3,
        "a length between 0.0001 and 1000 m",
    )
}

fn check_mass(field: String, value: f64) -> Result<(), ModelError> {
    ModelError::check_range(field, value, 1e-6, 1e6, "a mass above 1e-6 kg")
}

/// Principal moments of a real body obey the triangle inequality.
fn check_inertia(field: &str, [a, b, c]: [f64; 3]) -> Result<(), ModelError> {
    let positive = [a, b, c].iter().all(|m| m.is_finite() && *m > 0.0);
    let slack = 1.0 + 1e-9;
    if positive && a <= (b + c) * slack && b <= (a + c) * slack && c <= (a + b) * slack {
        Ok(())
    } else {
        Err(ModelError::value(
            field,
            format!("[{a}, {b}, {c}]"),
            "three positive moments, none larger than the sum of the others",
        ))
    }
}

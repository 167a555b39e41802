//! The elements of a URDF, every number checked.

use std::{collections::HashMap, ops::RangeInclusive};

use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};
use roxmltree::{Document, Node, ParsingOptions};

use super::ImportError;

/// A file as it stands.
pub(super) struct Urdf {
    pub(super) name: String,
    pub(super) links: Vec<UrdfLink>,
    pub(super) joints: Vec<UrdfJoint>,
    /// What an export of mlr says besides.
    pub(super) own: Option<OwnElement>,
    /// Names of elements that say nothing that is read, each once.
    pub(super) ignored: Vec<String>,
}

pub(super) struct UrdfLink {
    pub(super) name: String,
    /// In bytes of the file.
    pub(super) offset: usize,
    pub(super) inertial: Option<Inertial>,
    pub(super) collisions: Vec<Shape>,
    pub(super) visuals: Vec<Shape>,
}

#[derive(Clone, Copy)]
pub(super) struct Inertial {
    pub(super) frame: Isometry3<f64>,
    pub(super) mass_kg: f64,
    pub(super) inertia_kg_m2: Matrix3<f64>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    pub(super) frame: Isometry3<f64>,
    pub(super) form: Form,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Form {
    Box(Vector3<f64>),
    /// Along z; a capsule is one with round ends.
    Cylinder {
        radius_m: f64,
        length_m: f64,
        round: bool,
    },
    Sphere(f64),
    Mesh,
}

pub(super) struct UrdfJoint {
    pub(super) name: String,
    /// In bytes of the file.
    pub(super) offset: usize,
    pub(super) kind: String,
    /// Indices of links.
    pub(super) parent: usize,
    pub(super) child: usize,
    pub(super) frame: Isometry3<f64>,
    pub(super) axis: Vector3<f64>,
    pub(super) effort_nm: Option<f64>,
    pub(super) velocity_rad_per_s: Option<f64>,
    pub(super) damping: f64,
    pub(super) friction: f64,
}

/// The element `<mlr>`.
#[derive(Default)]
pub(super) struct OwnElement {
    pub(super) robot: HashMap<String, String>,
    pub(super) servo: HashMap<String, String>,
    pub(super) drive: HashMap<String, String>,
    pub(super) legs: Vec<OwnLeg>,
}

#[derive(Default)]
pub(super) struct OwnLeg {
    pub(super) name: String,
    pub(super) nominal_foot_m: [f64; 2],
    pub(super) links: Vec<OwnLink>,
}

pub(super) struct OwnLink {
    pub(super) joint: String,
    pub(super) name: String,
    pub(super) posture_deg: f64,
    pub(super) locked_deg: f64,
    pub(super) zero_rad: f64,
}

/// More than any robot has; a file of nothing but elements is refused before memory is.
const MOST_NODES: u32 = 500_000;
const PLACES_M: RangeInclusive<f64> = -1e3..=1e3;
const LENGTHS_M: RangeInclusive<f64> = 0.0..=1e3;
const ANGLES_RAD: RangeInclusive<f64> = -1e3..=1e3;
const MASSES_KG: RangeInclusive<f64> = 0.0..=1e5;
const INERTIAS: RangeInclusive<f64> = -1e9..=1e9;
const ANY: RangeInclusive<f64> = -1e300..=1e300;

impl Urdf {
    pub(super) fn parse(text: &str) -> Result<Self, ImportError> {
        let options = ParsingOptions {
            nodes_limit: MOST_NODES,
            ..ParsingOptions::default()
        };
        let document = Document::parse_with_options(text, options).map_err(|error| {
            let line = error.pos().row as usize;
            ImportError::at_line(
                line,
                format!("{error}, expected URDF: XML with one <robot>"),
            )
        })?;
        let root = document.root_element();
        if root.tag_name().name() != "robot" {
            let found = root.tag_name().name();
            let hint = match found {
                "mujoco" => ": this is MJCF, whose URDF is needed",
                "sdf" => ": this is SDF, whose URDF is needed",
                _ => "",
            };
            let what = format!("<{found}>, expected <robot>, the root of a URDF{hint}");
            return Err(ImportError::at(offset(&root), what));
        }
        let name = root.attribute("name").unwrap_or("robot").to_string();
        let mut links: Vec<UrdfLink> = Vec::new();
        let mut known: HashMap<String, usize> = HashMap::new();
        for node in elements(&root, "link") {
            let link = link(&node)?;
            if known.insert(link.name.clone(), links.len()).is_some() {
                let what = format!(
                    "link {:?} a second time, expected one of each name",
                    link.name
                );
                return Err(ImportError::at(link.offset, what));
            }
            links.push(link);
        }
        let mut joints = Vec::new();
        for node in elements(&root, "joint") {
            joints.push(joint(&node, &known)?);
        }
        let own = elements(&root, "mlr").next();
        let own = own.map(|node| own_element(&node)).transpose()?;
        let mut ignored: Vec<String> = Vec::new();
        for node in root.children().filter(Node::is_element) {
            let name = node.tag_name().name();
            if name.contains("xacro") || node.tag_name().namespace().is_some() {
                let what =
                    format!("<{name}> of xacro, expected plain URDF: run xacro on the file first");
                return Err(ImportError::at(offset(&node), what));
            }
            let read = ["link", "joint", "mlr", "material", "mujoco"].contains(&name);
            if !read && !ignored.iter().any(|one| one == name) {
                ignored.push(name.into());
            }
        }
        Ok(Self {
            name,
            links,
            joints,
            own,
            ignored,
        })
    }
}

fn link(node: &Node<'_, '_>) -> Result<UrdfLink, ImportError> {
    let shapes = |name: &'static str| -> Result<Vec<Shape>, ImportError> {
        let nodes = elements(node, name);
        let shapes = nodes
            .map(|node| shape(&node))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(shapes.into_iter().flatten().collect())
    };
    Ok(UrdfLink {
        name: named(node)?,
        offset: offset(node),
        inertial: elements(node, "inertial")
            .next()
            .map(|node| inertial(&node))
            .transpose()?,
        collisions: shapes("collision")?,
        visuals: shapes("visual")?,
    })
}

fn inertial(node: &Node<'_, '_>) -> Result<Inertial, ImportError> {
    let mass_kg = match elements(node, "mass").next() {
        Some(mass) => number(&mass, "value", MASSES_KG, "a mass of 0 to 100000 kg")?,
        None => 0.0,
    };
    let mut inertia_kg_m2 = Matrix3::zeros();
    if let Some(inertia) = elements(node, "inertia").next() {
        for (name, i, j) in [
            ("ixx", 0, 0),
            ("iyy", 1, 1),
            ("izz", 2, 2),
            ("ixy", 0, 1),
            ("ixz", 0, 2),
            ("iyz", 1, 2),
        ] {
            if inertia.has_attribute(name) {
                let value = number(&inertia, name, INERTIAS, "an inertia in kg m²")?;
                inertia_kg_m2[(i, j)] = value;
                inertia_kg_m2[(j, i)] = value;
            }
        }
    }
    Ok(Inertial {
        frame: origin(node)?,
        mass_kg,
        inertia_kg_m2,
    })
}

fn shape(node: &Node<'_, '_>) -> Result<Option<Shape>, ImportError> {
    let geometry = elements(node, "geometry").next();
    let Some(geometry) = geometry.and_then(|node| node.children().find(Node::is_element)) else {
        return Ok(None);
    };
    let length = |name| number(&geometry, name, LENGTHS_M, "a length of 0 to 1000 m");
    let form = match geometry.tag_name().name() {
        "box" => Form::Box(three(&geometry, "size", LENGTHS_M, "three lengths in m")?),
        name @ ("cylinder" | "capsule") => Form::Cylinder {
            radius_m: length("radius")?,
            length_m: length("length")?,
            round: name == "capsule",
        },
        "sphere" => Form::Sphere(length("radius")?),
        _ => Form::Mesh,
    };
    let frame = origin(node)?;
    Ok(Some(Shape { frame, form }))
}

fn joint(node: &Node<'_, '_>, links: &HashMap<String, usize>) -> Result<UrdfJoint, ImportError> {
    let name = named(node)?;
    let end = |part: &'static str| -> Result<usize, ImportError> {
        let element = elements(node, part).next();
        let link = element.and_then(|element| element.attribute("link"));
        let Some(link) = link else {
            let what = format!("joint {name:?} without {part}, expected <{part} link=\"…\"/>");
            return Err(ImportError::at(offset(node), what));
        };
        links.get(link).copied().ok_or_else(|| {
            let what =
                format!("joint {name:?} has the {part} {link:?}, expected the name of a <link>");
            ImportError::at(offset(node), what)
        })
    };
    let (parent, child) = (end("parent")?, end("child")?);
    let axis = match elements(node, "axis").next() {
        Some(axis) => three(&axis, "xyz", ANY, "three numbers")?,
        None => Vector3::x(),
    };
    let kind = node.attribute("type").unwrap_or_default().to_string();
    let largest = axis.amax();
    let turns = ["revolute", "continuous"].contains(&kind.as_str());
    if turns && largest < 1e-9 {
        let what = format!("the axis of joint {name:?} is zero, expected a direction");
        return Err(ImportError::at(offset(node), what));
    }
    let axis = if largest > 0.0 {
        (axis / largest).normalize()
    } else {
        axis
    };
    let optional = |element: &'static str, attribute: &str| -> Result<Option<f64>, ImportError> {
        let found = elements(node, element).next();
        let found = found.filter(|found| found.has_attribute(attribute));
        found
            .map(|found| number(&found, attribute, ANY, "a number"))
            .transpose()
    };
    Ok(UrdfJoint {
        offset: offset(node),
        kind,
        parent,
        child,
        frame: origin(node)?,
        axis,
        effort_nm: optional("limit", "effort")?,
        velocity_rad_per_s: optional("limit", "velocity")?,
        damping: optional("dynamics", "damping")?.unwrap_or(0.0),
        friction: optional("dynamics", "friction")?.unwrap_or(0.0),
        name,
    })
}

fn own_element(node: &Node<'_, '_>) -> Result<OwnElement, ImportError> {
    let map = |node: Node<'_, '_>| -> HashMap<String, String> {
        let attributes = node.attributes();
        attributes
            .map(|one| (one.name().to_string(), one.value().to_string()))
            .collect()
    };
    let first = |name| elements(node, name).next().map(map).unwrap_or_default();
    let mut legs = Vec::new();
    for leg in elements(node, "leg") {
        let foot: Vec<f64> = list(&leg, "nominal_foot_m", PLACES_M, 2, "two lengths in m")?;
        let mut links = Vec::new();
        for link in elements(&leg, "link") {
            let text = |name: &str| link.attribute(name).unwrap_or_default().to_string();
            let angle = |name| number(&link, name, ANGLES_RAD, "an angle");
            links.push(OwnLink {
                joint: text("joint"),
                name: text("name"),
                posture_deg: angle("posture_deg")?,
                locked_deg: angle("locked_deg")?,
                zero_rad: angle("zero_rad")?,
            });
        }
        legs.push(OwnLeg {
            name: leg.attribute("name").unwrap_or_default().into(),
            nominal_foot_m: [foot[0], foot[1]],
            links,
        });
    }
    Ok(OwnElement {
        robot: map(*node),
        servo: first("servo"),
        drive: first("drive"),
        legs,
    })
}

fn origin(node: &Node<'_, '_>) -> Result<Isometry3<f64>, ImportError> {
    let Some(origin) = elements(node, "origin").next() else {
        return Ok(Isometry3::identity());
    };
    let of = |name: &'static str, bounds, expected| match origin.has_attribute(name) {
        true => three(&origin, name, bounds, expected),
        false => Ok(Vector3::zeros()),
    };
    let xyz = of("xyz", PLACES_M, "three lengths from -1000 to 1000 m")?;
    let rpy = of("rpy", ANGLES_RAD, "three angles in rad")?;
    let turn = UnitQuaternion::from_euler_angles(rpy.x, rpy.y, rpy.z);
    Ok(Isometry3::from_parts(Translation3::from(xyz), turn))
}

fn named(node: &Node<'_, '_>) -> Result<String, ImportError> {
    match node.attribute("name") {
        Some(name) if !name.is_empty() => Ok(name.to_string()),
        _ => {
            let tag = node.tag_name().name();
            let what = format!("<{tag}> without a name, expected <{tag} name=\"…\">");
            Err(ImportError::at(offset(node), what))
        }
    }
}

fn elements<'a, 'i: 'a>(
    node: &Node<'a, 'i>,
    name: &'static str,
) -> impl Iterator<Item = Node<'a, 'i>> + use<'a, 'i> {
    let children = node.children();
    children.filter(move |child| child.is_element() && child.tag_name().name() == name)
}

/// Where the element begins, in bytes of the file.
fn offset(node: &Node<'_, '_>) -> usize {
    node.range().start
}

fn three(
    node: &Node<'_, '_>,
    name: &str,
    bounds: RangeInclusive<f64>,
    expected: &str,
) -> Result<Vector3<f64>, ImportError> {
    let numbers = list(node, name, bounds, 3, expected)?;
    Ok(Vector3::new(numbers[0], numbers[1], numbers[2]))
}

fn number(
    node: &Node<'_, '_>,
    name: &str,
    bounds: RangeInclusive<f64>,
    expected: &str,
) -> Result<f64, ImportError> {
    Ok(list(node, name, bounds, 1, expected)?[0])
}

/// Exactly so many numbers of an attribute, all within the bounds.
fn list(
    node: &Node<'_, '_>,
    name: &str,
    bounds: RangeInclusive<f64>,
    count: usize,
    expected: &str,
) -> Result<Vec<f64>, ImportError> {
    let text = node.attribute(name).unwrap_or_default();
    let numbers: Result<Vec<f64>, _> = text.split_whitespace().map(str::parse).collect();
    match numbers {
        Ok(numbers) if numbers.len() == count && numbers.iter().all(|one| bounds.contains(one)) => {
            Ok(numbers)
        }
        _ => {
            let tag = node.tag_name().name();
            let what = format!("{name}={text:?} of <{tag}> is not valid, expected {expected}");
            Err(ImportError::at(offset(node), what))
        }
    }
}

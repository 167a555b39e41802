//! URDF in: the description of a robot, as far as it can be held.

mod body;
mod chain;
mod check;
mod description;
mod error;
mod leg;
mod parts;
mod servo;
mod urdf;

pub use error::ImportError;

use mlr_model::{Imu, Robot};
use nalgebra::Vector3;
use serde::Serialize;

use body::ImportedBody;
use description::Description;
use leg::{Chain, ImportedLeg, ImportedLink};
use parts::Parts;
use urdf::{OwnElement, Urdf};

/// The most that is read of a URDF, in bytes: a robot without its meshes has some hundred kB.
pub const MOST_URDF_BYTES: u64 = 10_000_000;

/// Joints that turn, at most: no robot that walks has a tenth of it.
const MOST_JOINTS: usize = 1000;

/// How a URDF is read.
#[derive(Debug, Clone, Default)]
pub struct ImportOptions {
    /// Names of joints that are held still, such as those of an arm or a camera.
    pub fixed_joints: Vec<String>,
}

/// A robot that was read from a URDF.
#[derive(Debug, Clone)]
pub struct Imported {
    /// Its description in TOML, as [`Robot::from_toml`] reads it.
    pub description: String,
    /// What the description says.
    pub robot: Robot,
    /// How joint angles of both are related, in the order of the robot's joints.
    pub joints: Vec<JointMap>,
    /// What the URDF says and a description cannot hold.
    pub left_out: Vec<String>,
    /// What the URDF does not say, and what was put in its place.
    pub assumed: Vec<String>,
    /// The largest distance between a foot of the URDF and of the description, over joint angles of
    /// ±0.5 rad about zero.
    pub foot_error_m: f64,
}

/// One joint in the URDF and in the description.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct JointMap {
    /// Its name in the URDF.
    pub urdf_joint: String,
    /// Its name in joint trajectories of mlr.
    pub joint: String,
    /// Angle of mlr = sign · angle of the URDF + offset.
    pub sign: f64,
    /// In radians.
    pub offset_rad: f64,
}

/// What is said about a reading, each once.
#[derive(Default)]
struct Notes {
    left_out: Vec<String>,
    assumed: Vec<String>,
}

/// What is said of each kind, at most.
const MOST_NOTES: usize = 500;

impl Notes {
    fn left_out(&mut self, what: String) {
        note(&mut self.left_out, what);
    }

    fn assumed(&mut self, what: String) {
        note(&mut self.assumed, what);
    }
}

fn note(notes: &mut Vec<String>, what: String) {
    match notes.len() {
        MOST_NOTES => notes.push("more of the like".into()),
        count if count < MOST_NOTES && !notes.contains(&what) => notes.push(what),
        _ => {}
    }
}

/// Reads a healthy robot: a body, and chains of turning joints that hang on it.
///
/// # Errors
/// [`ImportError`] when the text is no URDF, its links are no tree, a number makes no sense, or a
/// joint of a leg turns about an axis that no description can hold.
pub fn import_urdf(text: &str, options: &ImportOptions) -> Result<Imported, ImportError> {
    read(text, options).map_err(|error| error.located(text))
}

fn read(text: &str, options: &ImportOptions) -> Result<Imported, ImportError> {
    let urdf = Urdf::parse(text)?;
    let parts = Parts::new(&urdf, &options.fixed_joints)?;
    let mut notes = Notes::default();
    for note in &parts.notes {
        notes.left_out(note.clone());
    }
    for name in &urdf.ignored {
        notes.left_out(format!("<{name}>"));
    }
    let legs = &parts.all[0].hanging;
    if legs.is_empty() {
        let what = "no joint that turns hangs on the body, expected the first joints of its legs";
        return Err(ImportError::of_file(what));
    }
    let moving = parts.all.len() - 1;
    if moving > MOST_JOINTS {
        let what = format!("{moving} joints that turn, expected {MOST_JOINTS} at most");
        return Err(ImportError::of_file(what));
    }
    let chains = legs.iter().map(|first| {
        let chain = Chain::new(&urdf, &parts, *first, &mut notes);
        let fitted = chain.fitted(&urdf)?;
        Ok((chain, fitted))
    });
    let chains = chains.collect::<Result<Vec<_>, ImportError>>()?;
    let hips_m: Vec<Vector3<f64>> = chains.iter().map(|(_, one)| one.hip_m.coords).collect();
    let body = ImportedBody::new(&parts.all[0], &hips_m, &mut notes)?;
    let mut foot_error_m = 0.0_f64;
    let mut imported = Vec::with_capacity(chains.len());
    for (chain, mut fitted) in chains {
        let links = chain.links(&urdf, &parts, &fitted, &mut notes);
        fitted.move_by(&-body.origin_m);
        let error_m = check::foot_error_m(&urdf, &chain, &fitted, &body.origin_m);
        foot_error_m = foot_error_m.max(error_m);
        imported.push(ImportedLeg::new(fitted, links));
    }
    match &urdf.own {
        Some(own) => take_own(own, &urdf, &mut imported)?,
        None => {
            imported.sort_by(|a, b| a.place_from_front().total_cmp(&b.place_from_front()));
            for (index, leg) in imported.iter_mut().enumerate() {
                leg.name = leg.common_name().unwrap_or(format!("leg {}", index + 1));
            }
        }
    }
    finish(&urdf, &body, &imported, foot_error_m, notes)
}

fn finish(
    urdf: &Urdf,
    body: &ImportedBody,
    legs: &[ImportedLeg],
    foot_error_m: f64,
    mut notes: Notes,
) -> Result<Imported, ImportError> {
    let joints: Vec<usize> = legs
        .iter()
        .flat_map(|leg| &leg.links)
        .map(|link| link.joint)
        .collect();
    let servo = servo::servo(urdf, &joints, &mut notes)?;
    let postures_rad: Vec<Vec<f64>> = legs.iter().map(|leg| leg.posture_rad(&mut notes)).collect();
    let nominal_feet_m = legs.iter().zip(&postures_rad).map(|(leg, posture_rad)| {
        leg.nominal_foot_m.unwrap_or_else(|| {
            let foot = leg.chain.foot_m(posture_rad);
            [foot.x, foot.y]
        })
    });
    if urdf.own.is_none() {
        notes.assumed("lost links that hang on are locked with the leg lifted by 75°".into());
    }
    let own = |name: &str, otherwise: f64| {
        let text = urdf.own.as_ref().and_then(|own| own.robot.get(name));
        text.and_then(|text| text.parse().ok()).unwrap_or(otherwise)
    };
    let inertia_kg_m2 = body.moments(&mut notes);
    let mut comment = vec![format!(
        "{}, read from its URDF by mlr-ga import.",
        urdf.name
    )];
    for (title, lines) in [("Assumed:", &notes.assumed), ("Left out:", &notes.left_out)] {
        if !lines.is_empty() {
            comment.push(String::new());
            comment.push(title.into());
            comment.extend(lines.iter().map(|line| format!("- {line}")));
        }
    }
    let description = Description {
        name: &urdf.name,
        size_m: body.size_m.into(),
        mass_kg: body.mass.mass_kg(),
        center_of_mass_m: body.mass.center_m().into(),
        inertia_kg_m2,
        servo,
        nominal_feet_m: nominal_feet_m.collect(),
        postures_rad,
        legs,
        clock: own("clock", 1.0),
        mounting_deg: mounting_deg(urdf),
        gyro_scale: own("gyro_scale", Imu::default().gyro_scale),
        comment,
    };
    let description = description.to_toml();
    let robot = Robot::from_toml(&description).map_err(|error| {
        let what = format!("the robot makes no description: {error}");
        ImportError::of_file(what)
    })?;
    let links = legs
        .iter()
        .flat_map(|leg| leg.chain.links.iter().zip(&leg.links));
    let joints = links
        .zip(robot.joint_names())
        .map(|((fitted, link), joint)| JointMap {
            urdf_joint: urdf.joints[link.joint].name.clone(),
            joint,
            sign: fitted.sign,
            offset_rad: fitted.offset_rad - link.own.map_or(0.0, |(_, _, zero_rad)| zero_rad),
        });
    Ok(Imported {
        joints: joints.collect(),
        description,
        robot,
        left_out: notes.left_out,
        assumed: notes.assumed,
        foot_error_m,
    })
}

/// Roll, pitch and yaw of the frame that exports call so.
fn mounting_deg(urdf: &Urdf) -> [f64; 3] {
    let imu = urdf
        .joints
        .iter()
        .find(|joint| joint.kind == "fixed" && urdf.links[joint.child].name == crate::export::IMU);
    let Some(imu) = imu else { return [0.0; 3] };
    let (roll, pitch, yaw) = imu.frame.rotation.euler_angles();
    [roll, pitch, yaw].map(f64::to_degrees)
}

/// Puts in place what an export of mlr says besides. Its legs are those of the file.
fn take_own(own: &OwnElement, urdf: &Urdf, legs: &mut [ImportedLeg]) -> Result<(), ImportError> {
    let mut named = own.legs.iter();
    for leg in legs {
        let first = &urdf.joints[leg.links[0].joint].name;
        let fits = named.next().filter(|own| {
            let joints = leg.links.iter().map(|link| &urdf.joints[link.joint].name);
            own.links.iter().map(|link| &link.joint).eq(joints)
        });
        let Some(own) = fits else {
            let what = format!(
                "<mlr> names other joints than those of the leg that begins with {first:?}, \
                 expected the same in the same order: take <mlr> out of an edited file"
            );
            return Err(ImportError::of_file(what));
        };
        leg.name.clone_from(&own.name);
        leg.nominal_foot_m = Some(own.nominal_foot_m);
        for (link, own) in leg.links.iter_mut().zip(&own.links) {
            link.name.clone_from(&own.name);
            link.own = Some((own.posture_deg, own.locked_deg, own.zero_rad));
        }
        leg.turn_hip_back(own.links[0].zero_rad);
    }
    Ok(())
}

impl ImportedLeg {
    fn new(chain: chain::FittedChain, links: Vec<ImportedLink>) -> Self {
        Self {
            name: String::new(),
            chain,
            links,
            nominal_foot_m: None,
        }
    }

    /// The zero of an upright first joint is where its link points to, and with it the hip; one that
    /// has moved is none of the hip's.
    fn turn_hip_back(&mut self, zero_rad: f64) {
        let first = &mut self.chain.links[0];
        if first.axis == mlr_model::JointAxis::Yaw {
            self.chain.hip_yaw_rad -= zero_rad;
            first.offset_rad += zero_rad;
        }
    }

    /// Legs are numbered in this order: pair by pair from the front, left before right.
    fn place_from_front(&self) -> f64 {
        const PAIR_M: f64 = 0.02;
        let hip = &self.chain.hip_m;
        let side = if hip.y >= 0.0 { 0.0 } else { 0.5 };
        side - (hip.x / PAIR_M).round()
    }

    /// What the names of all its links begin with.
    fn common_name(&self) -> Option<String> {
        let name = self.common_prefix();
        let name = name.trim_matches(|c: char| !c.is_alphanumeric());
        (!name.is_empty()).then(|| name.to_string())
    }

    fn common_prefix(&self) -> &str {
        let mut names = self.links.iter().map(|link| link.name.as_str());
        let first = names.next().unwrap_or_default();
        let shared = names.fold(first.len(), |shared, name| {
            let same = first.bytes().zip(name.bytes()).take_while(|(a, b)| a == b);
            shared.min(same.count())
        });
        // Up to a separator, so that no word is cut.
        let end = first.as_bytes()[..shared]
            .iter()
            .rposition(|byte| b"_-. /".contains(byte));
        end.and_then(|end| first.get(..=end)).unwrap_or_default()
    }

    /// The name of a link without what all of its leg begin with.
    fn plain_name(&self, link: &ImportedLink) -> String {
        let prefix = match link.own {
            Some(_) => "",
            None => self.common_prefix(),
        };
        let plain = link.name.strip_prefix(prefix).unwrap_or(&link.name);
        if plain.is_empty() {
            "link".into()
        } else {
            plain.into()
        }
    }
}

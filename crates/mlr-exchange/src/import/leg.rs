//! A leg: chain, masses, contacts, posture.

use mlr_model::{ContactShape, JointAxis, RigidMass};
use nalgebra::{Isometry3, Point3, Vector3};

use super::{
    ImportError, Notes,
    chain::{AxisLine, FittedChain},
    parts::{Part, Parts, join},
    urdf::{Form, Shape, Urdf},
};

/// A chain of moving joints from the body outward.
pub(super) struct Chain {
    /// Joint, its frame in the body's with all joints at zero, and the part that hangs on it.
    pub(super) joints: Vec<(usize, Isometry3<f64>, usize)>,
    /// Of the outer end, in the frame of the last part.
    pub(super) tip_m: Point3<f64>,
}

/// A leg as a description has it.
pub(super) struct ImportedLeg {
    pub(super) name: String,
    pub(super) chain: FittedChain,
    pub(super) links: Vec<ImportedLink>,
    /// Where an export of mlr says it.
    pub(super) nominal_foot_m: Option<[f64; 2]>,
}

#[derive(Debug, Clone)]
pub(super) struct ImportedLink {
    pub(super) name: String,
    /// Index of the URDF's joint.
    pub(super) joint: usize,
    pub(super) mass_kg: f64,
    pub(super) center_of_mass_m: f64,
    pub(super) inertia_kg_m2: [f64; 3],
    pub(super) contact: Option<ContactShape>,
    /// Where an export of mlr says it; degrees, degrees, radians.
    pub(super) own: Option<(f64, f64, f64)>,
}

/// Mass of a link that has none: less than any servo horn.
const LEAST_MASS_KG: f64 = 1e-3;
/// Offsets of centres of mass, and products of inertia as a share, that are worth a word.
const WORTH_MM: f64 = 0.5;
const WORTH_SHARE: f64 = 0.02;
/// Radius of a foot whose shape is not known, of its link's length at most.
const FOOT_RADIUS_M: f64 = 0.012;
const FOOT_SHARE: f64 = 0.1;
const LEAST_RADIUS_M: f64 = 1e-4;

impl Chain {
    /// The chain that begins with a joint of the body; where it branches, the deepest branch.
    pub(super) fn new(
        urdf: &Urdf,
        parts: &Parts,
        first: (usize, Isometry3<f64>, usize),
        notes: &mut Notes,
    ) -> Self {
        let mut joints = vec![first];
        let (_, mut frame, mut part) = first;
        loop {
            let hanging = &parts.all[part].hanging;
            let deepest = hanging
                .iter()
                .rev()
                .max_by_key(|(_, _, on)| parts.all[*on].depth);
            let Some((joint, at, on)) = deepest else {
                break;
            };
            frame *= at;
            part = *on;
            joints.push((*joint, frame, part));
        }
        let (last, ..) = joints[joints.len() - 1];
        let tip_m = tip_m(&parts.all[part], &urdf.joints[last].axis, notes);
        Self { joints, tip_m }
    }

    fn tip_in_body_m(&self) -> Vector3<f64> {
        let frame = self.joints.last().map(|(_, frame, _)| frame * self.tip_m);
        frame.map_or(Vector3::zeros(), |tip| tip.coords)
    }

    /// Fits it to what a description can hold.
    pub(super) fn fitted(&self, urdf: &Urdf) -> Result<FittedChain, ImportError> {
        let lines: Vec<AxisLine> = self
            .joints
            .iter()
            .map(|(joint, frame, _)| AxisLine {
                point_m: frame.translation.vector,
                axis: frame.rotation * urdf.joints[*joint].axis,
            })
            .collect();
        FittedChain::new(&lines, &self.tip_in_body_m()).map_err(|unfit| {
            let joint = &urdf.joints[self.joints[unfit.0].0];
            let hint = "--fixed holds a joint still that belongs to no leg";
            let what = format!("joint {:?}: {}; {hint}", joint.name, unfit.1);
            ImportError::at(joint.offset, what)
        })
    }

    /// Masses and contacts of the links of a fitted chain.
    pub(super) fn links(
        &self,
        urdf: &Urdf,
        parts: &Parts,
        chain: &FittedChain,
        notes: &mut Notes,
    ) -> Vec<ImportedLink> {
        let mut links = Vec::with_capacity(self.joints.len());
        for (index, ((joint, frame, part), fitted)) in
            self.joints.iter().zip(&chain.links).enumerate()
        {
            let next = self.joints.get(index + 1).map(|(_, _, part)| *part);
            let into_link = fitted.frame.inverse() * frame;
            let name = parts.all[*part].name.clone();
            let mut mass = None;
            if let Some(own) = &parts.all[*part].mass {
                join(&mut mass, own, &into_link);
            }
            for (other, at, on) in &parts.all[*part].hanging {
                if Some(*on) == next {
                    continue;
                }
                notes.left_out(format!(
                    "joint {:?} and what hangs on it: held still as part of link {name:?}",
                    urdf.joints[*other].name
                ));
                if let Some(more) = parts.mass_with_all(*on) {
                    join(&mut mass, &more, &(into_link * at));
                }
            }
            let (mass_kg, center_of_mass_m, inertia_kg_m2) =
                along_the_link(mass, fitted.length_m, &name, notes);
            let is_last = next.is_none();
            let shapes = &parts.all[*part].collisions;
            let contact = contact(shapes, &into_link, fitted.length_m, is_last, &name, notes);
            links.push(ImportedLink {
                name,
                joint: *joint,
                mass_kg,
                center_of_mass_m,
                inertia_kg_m2,
                contact,
                own: None,
            });
        }
        links
    }
}

/// Frames and shapes this near to the last axis tell nothing of a leg's end.
const LEAST_ARM_M: f64 = 1e-3;

/// The outer end of the last part of a leg, in its frame.
fn tip_m(part: &Part, axis: &Vector3<f64>, notes: &mut Notes) -> Point3<f64> {
    let arm = |point: &Point3<f64>| point.coords - axis * point.coords.dot(axis);
    let farthest = |points: &mut dyn Iterator<Item = Point3<f64>>| {
        points.max_by(|a, b| arm(a).norm().total_cmp(&arm(b).norm()))
    };
    // Marked by a frame of its own, as tool and foot frames are.
    let marked = farthest(&mut part.markers_m.iter().copied());
    if let Some(marked) = marked.filter(|marked| arm(marked).norm() > LEAST_ARM_M) {
        return marked;
    }
    let shapes = if part.collisions.is_empty() {
        &part.visuals
    } else {
        &part.collisions
    };
    let ends = shapes.iter().flat_map(|shape| {
        let along = |half: Vector3<f64>| [half, -half].map(|end| shape.frame * Point3::from(end));
        let center = Point3::from(shape.frame.translation.vector);
        match shape.form {
            Form::Sphere(radius_m) => {
                let outward = arm(&center).try_normalize(1e-9).unwrap_or_default();
                [center + outward * radius_m; 2]
            }
            Form::Cylinder {
                radius_m,
                length_m,
                round,
            } => {
                let cap_m = if round { radius_m } else { 0.0 };
                along(Vector3::z() * (length_m / 2.0 + cap_m))
            }
            Form::Box(size) => {
                let longest = size.imax();
                let mut half = Vector3::zeros();
                half[longest] = size[longest] / 2.0;
                along(half)
            }
            Form::Mesh => [center; 2],
        }
    });
    let end = farthest(&mut ends.collect::<Vec<_>>().into_iter());
    if let Some(end) = end.filter(|end| arm(end).norm() > LEAST_ARM_M) {
        return end;
    }
    let center = part.mass.map_or(Point3::origin(), |mass| mass.center_m());
    notes.assumed(format!(
        "the outer end of link {:?}, of which no frame and no shape tells: twice as far as its \
         centre of mass",
        part.name
    ));
    center * 2.0
}

/// Mass, centre of mass along the link, and moments of inertia along and across it.
fn along_the_link(
    mass: Option<RigidMass>,
    length_m: f64,
    name: &str,
    notes: &mut Notes,
) -> (f64, f64, [f64; 3]) {
    let Some(mass) = mass else {
        notes.assumed(format!(
            "a mass of {LEAST_MASS_KG} kg for link {name:?}, which has none"
        ));
        return (LEAST_MASS_KG, length_m / 2.0, rod(LEAST_MASS_KG, length_m));
    };
    let center = mass.center_m();
    let off_mm = 1e3 * center.y.hypot(center.z);
    if off_mm > WORTH_MM {
        notes.left_out(format!(
            "the centre of mass of link {name:?} is {off_mm:.1} mm beside the line between its joints"
        ));
    }
    let inertia = mass.inertia_kg_m2();
    let moments: [f64; 3] = inertia.diagonal().into();
    let [a, b, c] = moments;
    let largest = a.max(b).max(c);
    let physical = a > 0.0 && b > 0.0 && c > 0.0 && 2.0 * largest <= (a + b + c) * (1.0 + 1e-6);
    if !physical {
        notes.assumed(format!(
            "the inertia of a rod for link {name:?}: {a:e}, {b:e}, {c:e} kg m² are no moments of a body"
        ));
        return (mass.mass_kg(), center.x, rod(mass.mass_kg(), length_m));
    }
    let products = inertia[(0, 1)]
        .abs()
        .max(inertia[(0, 2)].abs())
        .max(inertia[(1, 2)].abs());
    if products > WORTH_SHARE * largest {
        notes.left_out(format!(
            "products of inertia of link {name:?}, up to {:.0} % of its largest moment",
            100.0 * products / largest
        ));
    }
    (mass.mass_kg(), center.x, moments)
}

/// Moments of a rod, a tenth as thick as it is long.
pub(super) fn rod(mass_kg: f64, length_m: f64) -> [f64; 3] {
    let square = mass_kg * length_m.max(1e-3).powi(2);
    [square / 800.0, square / 12.0, square / 12.0]
}

/// How a link touches the ground.
fn contact(
    shapes: &[Shape],
    into_link: &Isometry3<f64>,
    length_m: f64,
    is_last: bool,
    name: &str,
    notes: &mut Notes,
) -> Option<ContactShape> {
    let along = |shape: &Shape, axis: Vector3<f64>| {
        (into_link.rotation * shape.frame.rotation * axis).x.abs() > 0.98
    };
    let (mut rod, mut spheres, mut others) = (None, Vec::new(), 0);
    for shape in shapes {
        match shape.form {
            Form::Sphere(radius_m) => {
                let center = into_link * Point3::from(shape.frame.translation.vector);
                spheres.push((center.x, radius_m));
            }
            Form::Cylinder { radius_m, .. } if along(shape, Vector3::z()) => rod = Some(radius_m),
            Form::Box(size) => {
                let longest = size.imax();
                let mut axis = Vector3::zeros();
                axis[longest] = 1.0;
                match along(shape, axis) {
                    true => rod = Some((size.sum() - size[longest]) / 4.0),
                    false => others += 1,
                }
                notes.left_out(format!("the edges of a box of link {name:?}"));
            }
            Form::Cylinder { .. } | Form::Mesh => others += 1,
        }
    }
    // The one farthest out.
    let sphere = spheres.iter().max_by(|a, b| a.0.total_cmp(&b.0));
    let sphere = sphere.filter(|(at_m, radius_m)| at_m + 2.0 * radius_m > length_m);
    if others > 0 {
        notes.left_out(format!(
            "{others} of the shapes with which link {name:?} collides"
        ));
    }
    let is_capsule = spheres.len() > 1 || !is_last;
    match (sphere, rod) {
        (_, Some(radius_m)) if is_capsule || sphere.is_none() => {
            Some(ContactShape::Capsule { radius_m })
        }
        (Some((_, radius_m)), _) => Some(ContactShape::Foot {
            radius_m: *radius_m,
        }),
        (None, _) if is_last => {
            let radius_m = FOOT_RADIUS_M.min(FOOT_SHARE * length_m).max(LEAST_RADIUS_M);
            notes.assumed(format!(
                "a foot with a radius of {:.1} mm for link {name:?}",
                1e3 * radius_m
            ));
            Some(ContactShape::Foot { radius_m })
        }
        (None, _) => None,
    }
}

impl ImportedLeg {
    /// Joint angles of the usual posture: that of the URDF with all joints at zero where its knees are
    /// bent, or one with bent knees.
    pub(super) fn posture_rad(&self, notes: &mut Notes) -> Vec<f64> {
        let own = self.links.iter().map(|link| link.own);
        if let Some(own) = own.collect::<Option<Vec<_>>>() {
            return own
                .iter()
                .map(|(posture_deg, ..)| posture_deg.to_radians())
                .collect();
        }
        let links = &self.chain.links;
        let mut posture: Vec<f64> = links.iter().map(|link| link.offset_rad).collect();
        let reach_m: f64 = links.iter().map(|link| link.length_m).sum();
        let hangs = self.chain.hip_m.z - self.chain.foot_m(&posture).z > STANDING * reach_m;
        let knee = posture.len() - 1;
        if hangs && posture[knee].abs() > BENT_RAD {
            return posture;
        }
        notes.assumed(
            "bent knees for the usual posture: with joints at zero legs are straight".into(),
        );
        if hangs && knee > 0 {
            posture[knee - 1] += HANGING_RAD[0];
            posture[knee] += HANGING_RAD[1];
        } else {
            let lifts = links
                .iter()
                .enumerate()
                .filter(|(_, link)| link.axis == JointAxis::Lift);
            let lifts: Vec<usize> = lifts.map(|(index, _)| index).collect();
            for (index, angle_rad) in lifts.into_iter().zip(SPRAWLING_RAD) {
                posture[index] = angle_rad;
            }
        }
        posture
    }
}

/// A foot that is this share of the leg's reach below its hip, joints at zero, may be one that stands.
const STANDING: f64 = 0.25;
/// Knees are bent from here on.
const BENT_RAD: f64 = 0.1;
/// Femur and tibia of the JetHexa: what legs that stretch to the side do.
const SPRAWLING_RAD: [f64; 2] = [0.523_598_775_598_298_8, -1.745_329_251_994_329_5];
/// Thigh and shank of a leg that hangs straight down.
const HANGING_RAD: [f64; 2] = [0.7, -1.4];

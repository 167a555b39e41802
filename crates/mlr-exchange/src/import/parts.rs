//! Rigid parts: links that fixed joints hold together, and the tree of joints between them.

use std::collections::HashSet;

use mlr_model::RigidMass;
use nalgebra::{Isometry3, Matrix3, Point3, Vector3};

use super::{
    ImportError,
    urdf::{Shape, Urdf, UrdfJoint},
};

/// Links that are rigidly joined. Everything is in the frame of the innermost of them, which is
/// that of the joint that the part hangs on.
#[derive(Default)]
pub(super) struct Part {
    /// Name of the innermost link.
    pub(super) name: String,
    pub(super) mass: Option<RigidMass>,
    pub(super) collisions: Vec<Shape>,
    pub(super) visuals: Vec<Shape>,
    /// Origins of links without mass and shape on which nothing hangs.
    pub(super) markers_m: Vec<Point3<f64>>,
    /// What hangs on it: joint, where it is, and the part.
    pub(super) hanging: Vec<(usize, Isometry3<f64>, usize)>,
    /// Joints from here to the outermost part, at most.
    pub(super) depth: usize,
}

/// All parts, the body first, and every other one after the one that it hangs on.
pub(super) struct Parts {
    pub(super) all: Vec<Part>,
    /// What had to be held still.
    pub(super) notes: Vec<String>,
}

impl Parts {
    /// Joints of other kinds than turning ones are held where their coordinate is zero, and so are
    /// those named in `fixed`.
    pub(super) fn new(urdf: &Urdf, fixed: &[String]) -> Result<Self, ImportError> {
        for name in fixed {
            if !urdf.joints.iter().any(|joint| joint.name == *name) {
                let what = format!("there is no joint {name:?} to be held still");
                return Err(ImportError::of_file(what));
            }
        }
        let below = joints_below(urdf)?;
        let root = root(urdf, &below)?;
        let turns = |joint: &UrdfJoint| {
            ["revolute", "continuous"].contains(&joint.kind.as_str())
                && !fixed.contains(&joint.name)
        };
        let mut notes = Vec::new();
        let mut all = vec![Part::default()];
        // Part, link, and the link's frame in the part's.
        let mut open = vec![(0, body_link(urdf, &below, root), Isometry3::identity())];
        while let Some((part, link, frame)) = open.pop() {
            let of = &urdf.links[link];
            if all[part].name.is_empty() {
                all[part].name = of.name.clone();
            }
            all[part].take(urdf, link, &frame, below[link].is_empty());
            // The first one is taken first.
            for joint_index in below[link].iter().rev() {
                let joint = &urdf.joints[*joint_index];
                let at = frame * joint.frame;
                if turns(joint) {
                    let hanging = all.len();
                    all.push(Part::default());
                    all[part].hanging.push((*joint_index, at, hanging));
                    open.push((hanging, joint.child, Isometry3::identity()));
                } else {
                    if joint.kind != "fixed" {
                        notes.push(format!(
                            "joint {:?} ({}), held still",
                            joint.name, joint.kind
                        ));
                    }
                    open.push((part, joint.child, at));
                }
            }
        }
        for part in (0..all.len()).rev() {
            all[part].hanging.sort_by_key(|(joint, ..)| *joint);
            let depths = all[part]
                .hanging
                .iter()
                .map(|(_, _, on)| all[*on].depth + 1);
            all[part].depth = depths.max().unwrap_or(0);
        }
        Ok(Self { all, notes })
    }

    /// Mass of a part and of all that hangs on it, joints at zero; in the part's frame.
    pub(super) fn mass_with_all(&self, part: usize) -> Option<RigidMass> {
        let mut total: Option<RigidMass> = None;
        let mut open = vec![(part, Isometry3::identity())];
        while let Some((part, frame)) = open.pop() {
            let part = &self.all[part];
            if let Some(mass) = &part.mass {
                join(&mut total, mass, &frame);
            }
            let hanging = part.hanging.iter();
            open.extend(hanging.map(|(_, at, part)| (*part, frame * at)));
        }
        total
    }
}

impl Part {
    fn take(&mut self, urdf: &Urdf, link: usize, frame: &Isometry3<f64>, is_last: bool) {
        let link = &urdf.links[link];
        if let Some(inertial) = link.inertial.filter(|inertial| inertial.mass_kg > 0.0) {
            let mass = RigidMass::new(inertial.mass_kg, Vector3::zeros(), inertial.inertia_kg_m2);
            join(&mut self.mass, &mass, &(frame * inertial.frame));
        } else if is_last && link.collisions.is_empty() && link.visuals.is_empty() {
            self.markers_m.push(frame.translation.vector.into());
        }
        let placed = |shape: &Shape| Shape {
            frame: frame * shape.frame,
            ..*shape
        };
        self.collisions.extend(link.collisions.iter().map(placed));
        self.visuals.extend(link.visuals.iter().map(placed));
    }
}

/// Adds a mass to a sum.
pub(super) fn join(sum: &mut Option<RigidMass>, mass: &RigidMass, frame: &Isometry3<f64>) {
    match sum {
        Some(sum) => sum.attach(mass, frame),
        None => {
            let turn = frame.rotation.to_rotation_matrix();
            let inertia: Matrix3<f64> = turn * mass.inertia_kg_m2() * turn.transpose();
            let center = frame * mass.center_m();
            *sum = Some(RigidMass::new(mass.mass_kg(), center.coords, inertia));
        }
    }
}

/// Of each link, the joints that hang on it.
fn joints_below(urdf: &Urdf) -> Result<Vec<Vec<usize>>, ImportError> {
    let mut below = vec![Vec::new(); urdf.links.len()];
    let mut above: Vec<Option<usize>> = vec![None; urdf.links.len()];
    for (index, joint) in urdf.joints.iter().enumerate() {
        if let Some(other) = above[joint.child] {
            let what = format!(
                "link {:?} hangs on joint {:?} and on joint {:?}, expected one: a robot is a tree",
                urdf.links[joint.child].name, urdf.joints[other].name, joint.name
            );
            return Err(ImportError::at(joint.offset, what));
        }
        above[joint.child] = Some(index);
        below[joint.parent].push(index);
    }
    Ok(below)
}

/// The link that hangs on nothing, from which all others can be reached.
fn root(urdf: &Urdf, below: &[Vec<usize>]) -> Result<usize, ImportError> {
    let hanging: HashSet<usize> = urdf.joints.iter().map(|joint| joint.child).collect();
    let mut roots = (0..urdf.links.len()).filter(|link| !hanging.contains(link));
    let Some(root) = roots.next() else {
        let what = match urdf.links.is_empty() {
            true => "no <link>, expected the links of a robot",
            false => "every link hangs on another, in a circle, expected one that hangs on none",
        };
        return Err(ImportError::of_file(what));
    };
    if let Some(other) = roots.next() {
        let what = format!(
            "link {:?} hangs on nothing, and {:?} neither, expected one such link: the body",
            urdf.links[other].name, urdf.links[root].name
        );
        return Err(ImportError::at(urdf.links[other].offset, what));
    }
    let mut reached = HashSet::from([root]);
    let mut open = vec![root];
    while let Some(link) = open.pop() {
        for joint in &below[link] {
            let child = urdf.joints[*joint].child;
            reached.insert(child);
            open.push(child);
        }
    }
    match (0..urdf.links.len()).find(|link| !reached.contains(link)) {
        None => Ok(root),
        Some(lost) => {
            let link = &urdf.links[lost];
            let what = format!(
                "link {:?} hangs in a circle of joints, expected a tree from {:?} on",
                link.name, urdf.links[root].name
            );
            Err(ImportError::at(link.offset, what))
        }
    }
}

/// The innermost link with a mass, where links without one carry nothing but it: a footprint on the
/// ground, or the world.
fn body_link(urdf: &Urdf, below: &[Vec<usize>], root: usize) -> usize {
    let mut body = root;
    loop {
        let is_heavy = urdf.links[body]
            .inertial
            .is_some_and(|one| one.mass_kg > 0.0);
        let [only] = below[body][..] else { return body };
        let joint = &urdf.joints[only];
        let holds = ["fixed", "floating", "planar"].contains(&joint.kind.as_str());
        if is_heavy || !holds {
            return body;
        }
        body = joint.child;
    }
}

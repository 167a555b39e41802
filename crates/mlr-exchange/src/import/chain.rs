//! One leg: joint axes in space, fitted to what a robot description can hold.
//!
//! A description knows chains in which every link is a straight line, along x, from its joint to
//! the next one, and every joint turns about z or -y of the link before it. In the terms of Denavit
//! and Hartenberg: twists of 0° and 90° and no offsets along axes, with the first axis upright or
//! level. Links are the common normals of successive axes; offsets along axes are what is lost, and
//! moving the hip makes up for their sum in the pose in which all joints are at zero.

use mlr_model::JointAxis;
use nalgebra::{
    Isometry3, Matrix3, Point3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3,
};

/// Axes count as parallel, perpendicular, upright and level within this angle.
const TOLERANCE_RAD: f64 = 0.02;
/// Axes that meet are this far apart in a description, whose links have a length.
const SHORTEST_M: f64 = 1e-4;

/// A joint with its axis through a point, in the frame of the body, all joints at zero.
#[derive(Debug, Clone, Copy)]
pub(super) struct AxisLine {
    pub(super) point_m: Vector3<f64>,
    pub(super) axis: Vector3<f64>,
}

/// A leg as a description holds it.
#[derive(Debug, Clone)]
pub(super) struct FittedChain {
    pub(super) hip_m: Point3<f64>,
    pub(super) hip_yaw_rad: f64,
    pub(super) links: Vec<FittedLink>,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct FittedLink {
    pub(super) axis: JointAxis,
    pub(super) length_m: f64,
    /// Angle of a description = sign · angle of the URDF + offset.
    pub(super) sign: f64,
    pub(super) offset_rad: f64,
    /// The link's frame in the body's, all joints of the URDF at zero.
    pub(super) frame: Isometry3<f64>,
}

/// A chain that no description can hold: joint, from 0, and why.
pub(super) struct Unfit(pub(super) usize, pub(super) String);

impl FittedChain {
    pub(super) fn new(lines: &[AxisLine], tip_m: &Vector3<f64>) -> Result<Self, Unfit> {
        let mut feet = Vec::with_capacity(lines.len());
        let mut normals = Vec::with_capacity(lines.len());
        let mut foot = lines.first().map_or(*tip_m, |line| line.point_m);
        for (index, line) in lines.iter().enumerate() {
            let (from, to) = match lines.get(index + 1) {
                Some(next) => line
                    .normal_to(next, &foot, tip_m)
                    .map_err(|why| Unfit(index + 1, why))?,
                None => (foot, *tip_m - line.axis * (tip_m - foot).dot(&line.axis)),
            };
            if index == 0 {
                // The hip may be anywhere along its axis.
                foot = from;
            }
            let normal = to - from;
            feet.push(foot);
            let next_foot = foot + normal;
            normals.push(normal);
            // What lies along the axis is lost here, and made up for at the hip.
            foot = match lines.get(index + 1) {
                Some(next) => next.nearest(&next_foot),
                None => next_foot,
            };
        }
        let mut chain = Self::oriented(lines, &feet, &normals, tip_m)?;
        let missing = tip_m - chain.end_m();
        chain.move_by(&missing);
        Ok(chain)
    }

    pub(super) fn move_by(&mut self, by_m: &Vector3<f64>) {
        self.hip_m += by_m;
        for link in &mut self.links {
            link.frame.translation.vector += by_m;
        }
    }

    /// Where the outer end is with joints at these angles of a description, in the body's frame.
    pub(super) fn foot_m(&self, angles_rad: &[f64]) -> Point3<f64> {
        let hip = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), self.hip_yaw_rad);
        let mut frame = Isometry3::from_parts(self.hip_m.coords.into(), hip);
        for (link, angle_rad) in self.links.iter().zip(angles_rad) {
            let axis = Unit::new_unchecked(link.axis.direction());
            frame.rotation *= UnitQuaternion::from_axis_angle(&axis, *angle_rad);
            frame *= Isometry3::translation(link.length_m, 0.0, 0.0);
        }
        frame.translation.vector.into()
    }

    /// Where the outer end is, all joints of the URDF at zero.
    fn end_m(&self) -> Vector3<f64> {
        self.links.last().map_or(self.hip_m.coords, |link| {
            (link.frame * Point3::new(link.length_m, 0.0, 0.0)).coords
        })
    }

    fn oriented(
        lines: &[AxisLine],
        feet: &[Vector3<f64>],
        normals: &[Vector3<f64>],
        tip_m: &Vector3<f64>,
    ) -> Result<Self, Unfit> {
        let hip_m = feet[0];
        let mut before = first_frame(&lines[0], &normals[0], &hip_m, tip_m)?;
        let hip_yaw_rad = before[(1, 0)].atan2(before[(0, 0)]);
        let mut links: Vec<FittedLink> = Vec::with_capacity(lines.len());
        let mut at = hip_m;
        for (line, normal) in lines.iter().zip(normals) {
            let (x, y, z) = (column(&before, 0), column(&before, 1), column(&before, 2));
            let (axis, about) = match line.axis.dot(&z).abs() > line.axis.dot(&y).abs() {
                true => (JointAxis::Yaw, z),
                false => (JointAxis::Lift, -y),
            };
            let along = normal - about * normal.dot(&about);
            // Where the axes are one, the link goes on as the last one did.
            let along = along.try_normalize(SHORTEST_M / 10.0).unwrap_or(x);
            let offset_rad = about.dot(&x.cross(&along)).atan2(x.dot(&along));
            let turn = Rotation3::from_axis_angle(&Unit::new_normalize(about), offset_rad);
            before = turn.matrix() * before;
            let rotation =
                UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(before));
            let length_m = normal.norm().max(SHORTEST_M);
            links.push(FittedLink {
                axis,
                length_m,
                sign: line.axis.dot(&about).signum(),
                offset_rad,
                frame: Isometry3::from_parts(Translation3::from(at), rotation),
            });
            at += column(&before, 0) * length_m;
        }
        Ok(Self {
            hip_m: hip_m.into(),
            hip_yaw_rad,
            links,
        })
    }
}

impl AxisLine {
    fn nearest(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.point_m + self.axis * (point - self.point_m).dot(&self.axis)
    }

    /// The common normal from this axis to the next, as its two ends; between parallel axes the one
    /// through `foot`.
    fn normal_to(
        &self,
        next: &Self,
        foot: &Vector3<f64>,
        tip_m: &Vector3<f64>,
    ) -> Result<(Vector3<f64>, Vector3<f64>), String> {
        let cross = self.axis.cross(&next.axis);
        let between_deg = cross
            .norm()
            .atan2(self.axis.dot(&next.axis).abs())
            .to_degrees();
        let tolerance_deg = TOLERANCE_RAD.to_degrees();
        if between_deg < tolerance_deg {
            return Ok((*foot, next.nearest(foot)));
        }
        if between_deg < 90.0 - tolerance_deg {
            return Err(format!(
                "its axis stands at {between_deg:.1}° to that of the joint before it, expected \
                 parallel or perpendicular ones, as a robot description has them"
            ));
        }
        let apart = next.point_m - self.point_m;
        let square = cross.norm_squared();
        let from = self.point_m + self.axis * (apart.cross(&next.axis).dot(&cross) / square);
        let to = next.point_m + next.axis * (apart.cross(&self.axis).dot(&cross) / square);
        if (to - from).norm() > SHORTEST_M {
            return Ok((from, to));
        }
        // Axes that meet: a link of no length, towards the foot.
        let normal = cross.normalize();
        let outward = if normal.dot(&(tip_m - from)) < 0.0 {
            -normal
        } else {
            normal
        };
        Ok((from, from + outward * SHORTEST_M))
    }
}

/// Axes x, y, z of the hip in the body's frame, as columns: z up, x along the leg's plane.
fn first_frame(
    line: &AxisLine,
    normal: &Vector3<f64>,
    hip_m: &Vector3<f64>,
    tip_m: &Vector3<f64>,
) -> Result<Matrix3<f64>, Unfit> {
    let up = Vector3::z();
    let upright = line.axis.z.abs();
    let level = |vector: Vector3<f64>| Vector3::new(vector.x, vector.y, 0.0);
    let x = if upright > TOLERANCE_RAD.cos() {
        // The hip's zero is where the first link points to.
        let outward = level(*normal).try_normalize(SHORTEST_M / 10.0);
        outward.unwrap_or_else(Vector3::x)
    } else if upright < TOLERANCE_RAD.sin() {
        let along = level(line.axis).cross(&up).normalize();
        let (to_tip, from_body) = (level(tip_m - hip_m), level(*hip_m));
        let outward = [to_tip, from_body].map(|towards| along.dot(&towards));
        // A leg that hangs straight down points away from the body.
        let least_m = 0.1 * (tip_m - hip_m).norm();
        let sense = if outward[0].abs() > least_m {
            outward[0]
        } else {
            outward[1]
        };
        if sense < 0.0 { -along } else { along }
    } else {
        let tilt_deg = upright.acos().to_degrees();
        return Err(Unfit(
            0,
            format!(
                "its axis stands at {tilt_deg:.1}° to the upright, expected an upright or a level \
                 one for the first joint of a leg"
            ),
        ));
    };
    Ok(Matrix3::from_columns(&[x, up.cross(&x), up]))
}

fn column(matrix: &Matrix3<f64>, index: usize) -> Vector3<f64> {
    matrix.column(index).into()
}

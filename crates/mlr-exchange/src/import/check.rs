//! How far the feet of a description are from those of the URDF.

use nalgebra::{Isometry3, Unit, UnitQuaternion};

use super::{chain::FittedChain, leg::Chain, urdf::Urdf};

/// Joint angles that are tried: about zero, by at most this much.
const SWING_RAD: f64 = 0.5;
const POSES: usize = 50;

/// The largest distance, over poses in which all joints are turned, and the joints at zero.
pub(super) fn foot_error_m(
    urdf: &Urdf,
    chain: &Chain,
    fitted: &FittedChain,
    origin_m: &nalgebra::Vector3<f64>,
) -> f64 {
    let poses = (0..POSES).map(|pose| {
        let angle = |joint: usize| match pose {
            0 => 0.0,
            // Irrational steps cover all directions.
            _ => SWING_RAD * (1.0 + 2.4 * pose as f64 * (joint as f64 + 1.618)).sin(),
        };
        let mut frame = Isometry3::identity();
        let mut before = Isometry3::identity();
        let mut angles_rad = Vec::with_capacity(chain.joints.len());
        for (index, ((joint, at_zero, _), link)) in
            chain.joints.iter().zip(&fitted.links).enumerate()
        {
            frame *= before.inverse() * at_zero;
            before = *at_zero;
            let axis = Unit::new_unchecked(urdf.joints[*joint].axis);
            frame.rotation *= UnitQuaternion::from_axis_angle(&axis, angle(index));
            angles_rad.push(link.sign * angle(index) + link.offset_rad);
        }
        let tip_m = frame * chain.tip_m - origin_m;
        (tip_m - fitted.foot_m(&angles_rad)).norm()
    });
    poses.fold(0.0, f64::max)
}

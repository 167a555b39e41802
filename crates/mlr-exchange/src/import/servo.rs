//! The servo in every joint.

use std::collections::HashMap;

use mlr_model::{Robot, Servo};
use serde_json::{Map, Value};

use super::{
    ImportError, Notes,
    urdf::{OwnElement, Urdf, UrdfJoint},
};

/// From what an export of mlr says, or from limits and dynamics of the legs' joints.
pub(super) fn servo(
    urdf: &Urdf,
    joints: &[usize],
    notes: &mut Notes,
) -> Result<Servo, ImportError> {
    match &urdf.own {
        Some(own) if !own.servo.is_empty() => own_servo(own),
        _ => {
            let joints: Vec<&UrdfJoint> = joints.iter().map(|joint| &urdf.joints[*joint]).collect();
            Ok(of_limits(&joints, notes))
        }
    }
}

fn own_servo(own: &OwnElement) -> Result<Servo, ImportError> {
    let typed = |map: &HashMap<String, String>| -> Map<String, Value> {
        let fields = map.iter();
        fields
            .map(|(key, text)| {
                let value = serde_json::from_str(text);
                (
                    key.clone(),
                    value.unwrap_or_else(|_| Value::from(text.as_str())),
                )
            })
            .collect()
    };
    let mut fields = typed(&own.servo);
    if !own.drive.is_empty() {
        fields.insert("drive".into(), typed(&own.drive).into());
    }
    serde_json::from_value(fields.into())
        .map_err(|error| ImportError::of_file(format!("<servo> of <mlr>: {error}")))
}

/// Efforts beyond this are no servo's: files put such numbers where none is known.
const LARGEST_EFFORT_NM: f64 = 1e4;

fn of_limits(joints: &[&UrdfJoint], notes: &mut Notes) -> Servo {
    let like = *Robot::jethexa().servo();
    let mut limit = |name: &str,
                     unit: &str,
                     of: &dyn Fn(&UrdfJoint) -> Option<f64>,
                     otherwise: f64| {
        let known = joints.iter().filter_map(|joint| of(joint));
        let known: Vec<f64> = known
            .filter(|one| *one > 0.0 && *one < LARGEST_EFFORT_NM)
            .collect();
        let Some(least) = known.iter().copied().min_by(f64::total_cmp) else {
            notes.assumed(format!(
                "a {name} of {otherwise} {unit}: no joint of a leg has a limit"
            ));
            return otherwise;
        };
        let most = known.iter().copied().fold(least, f64::max);
        if most > least {
            notes.left_out(format!(
                "a {name} of up to {most} {unit}: all joints have one servo, taken with {least} {unit}"
            ));
        }
        least
    };
    let torque_limit_nm = limit(
        "torque limit",
        "N m",
        &|joint| joint.effort_nm,
        like.torque_limit_nm,
    );
    let speed_limit_rad_per_s = limit(
        "speed limit",
        "rad/s",
        &|joint| joint.velocity_rad_per_s,
        like.speed_limit_rad_per_s,
    );
    let strength = torque_limit_nm / like.torque_limit_nm;
    let stiffness_nm_per_rad = rounded(like.stiffness_nm_per_rad * strength);
    let damping_nm_s_per_rad = rounded(like.damping_nm_s_per_rad * strength);
    notes.assumed(format!(
        "servos with {stiffness_nm_per_rad} N m/rad and {damping_nm_s_per_rad} N m s/rad, in \
         proportion to their torque as the JetHexa's, and its timing: no URDF tells"
    ));
    let mut servo = Servo {
        stiffness_nm_per_rad,
        damping_nm_s_per_rad,
        torque_limit_nm,
        speed_limit_rad_per_s,
        ..like
    };
    let mean = |of: &dyn Fn(&UrdfJoint) -> f64| {
        joints.iter().map(|joint| of(joint).max(0.0)).sum::<f64>() / joints.len().max(1) as f64
    };
    servo.drive.viscous_nm_s_per_rad = mean(&|joint| joint.damping);
    servo.drive.coulomb_nm = mean(&|joint| joint.friction);
    servo
}

fn rounded(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

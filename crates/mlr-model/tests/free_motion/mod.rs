//! States of a robot in space, and how they go on.

use mlr_model::dynamics::{Dynamics, Moving, Posed};
use nalgebra::{DVector, Point3, Quaternion, UnitQuaternion, Vector3};

/// Where a robot is and how it moves.
#[derive(Debug, Clone)]
pub(crate) struct State {
    /// Of the body's origin in the world.
    pub(crate) position_m: Vector3<f64>,
    pub(crate) attitude: UnitQuaternion<f64>,
    pub(crate) joints_rad: Vec<f64>,
    pub(crate) velocities: DVector<f64>,
}

impl State {
    /// From numbers between -1 and 1, one after the other.
    pub(crate) fn from_numbers(numbers: &[f64], joints: usize) -> Self {
        let attitude =
            UnitQuaternion::from_euler_angles(3.0 * numbers[0], 1.5 * numbers[1], 3.0 * numbers[2]);
        let velocities = DVector::from_fn(6 + joints, |k, _| 3.0 * numbers[40 + k]);
        Self {
            position_m: Vector3::new(0.1, -0.2, 0.3),
            attitude,
            joints_rad: numbers[3..3 + joints].iter().map(|x| 3.0 * x).collect(),
            velocities,
        }
    }

    /// The same of a robot with more joints: all at these angles and still, but those that this
    /// one has, which `rows` of the other one are.
    pub(crate) fn with_joints(
        &self,
        angles_rad: impl Iterator<Item = f64>,
        rows: &[usize],
    ) -> Self {
        let mut joints_rad: Vec<f64> = angles_rad.collect();
        let mut velocities = DVector::zeros(6 + joints_rad.len());
        for (own, row) in rows.iter().enumerate() {
            velocities[*row] = self.velocities[own];
            if let Some(joint) = row.checked_sub(6) {
                joints_rad[joint] = self.joints_rad[own - 6];
            }
        }
        Self {
            joints_rad,
            velocities,
            ..self.clone()
        }
    }

    pub(crate) fn posed<'d>(&self, dynamics: &'d mut Dynamics) -> Posed<'d> {
        dynamics.at(&self.attitude, &self.joints_rad)
    }

    pub(crate) fn moving<'d>(&self, dynamics: &'d mut Dynamics) -> Moving<'d> {
        self.posed(dynamics).moving(&self.velocities)
    }

    /// Height in the world of a point of the body frame.
    pub(crate) fn height_m(&self, point_m: &Point3<f64>) -> f64 {
        self.position_m.z + (self.attitude * point_m.coords).z
    }

    /// After some time with constant quasi-velocities, exactly.
    pub(crate) fn carried_on(&self, time_s: f64) -> Self {
        let turn = Vector3::from(self.velocities.fixed_rows::<3>(3)) * time_s;
        let speed = Vector3::from(self.velocities.fixed_rows::<3>(0)) * time_s;
        // The exponential of a twist.
        let angle = turn.norm().max(1e-12);
        let (once, twice) = (
            (1.0 - angle.cos()) / angle.powi(2),
            (angle - angle.sin()) / angle.powi(3),
        );
        let moved = speed + turn.cross(&speed) * once + turn.cross(&turn.cross(&speed)) * twice;
        let speeds = self.velocities.iter().skip(6);
        Self {
            position_m: self.position_m + self.attitude * moved,
            attitude: self.attitude * UnitQuaternion::from_scaled_axis(turn),
            joints_rad: self
                .joints_rad
                .iter()
                .zip(speeds)
                .map(|(q, v)| q + v * time_s)
                .collect(),
            velocities: self.velocities.clone(),
        }
    }

    /// One step of the classical Runge-Kutta method.
    pub(crate) fn stepped(
        &self,
        step_s: f64,
        mut rates: impl FnMut(&Self) -> DVector<f64>,
    ) -> Self {
        let first = Slope::of(self, rates(self));
        let second = self.moved(&first, step_s / 2.0);
        let second = Slope::of(&second, rates(&second));
        let third = self.moved(&second, step_s / 2.0);
        let third = Slope::of(&third, rates(&third));
        let fourth = self.moved(&third, step_s);
        let fourth = Slope::of(&fourth, rates(&fourth));
        let weighted = [(&first, 1.0), (&second, 2.0), (&third, 2.0), (&fourth, 1.0)];
        let mut end = weighted
            .into_iter()
            .fold(self.clone(), |state, (slope, weight)| {
                state.moved_raw(slope, step_s * weight / 6.0)
            });
        end.attitude = UnitQuaternion::new_normalize(end.attitude.into_inner());
        end
    }

    /// After `duration_s` in the air, with torques of the joints by their speeds.
    pub(crate) fn flown(
        &self,
        dynamics: &mut Dynamics,
        torque_nm: impl Fn(f64) -> f64,
        duration_s: f64,
        step_s: f64,
    ) -> Self {
        let mut state = self.clone();
        let mut acceleration = DVector::zeros(self.velocities.len());
        for _ in 0..(duration_s / step_s).round() as usize {
            state = state.stepped(step_s, |state| {
                let mut forces = state.velocities.map(&torque_nm);
                forces.rows_mut(0, 6).fill(0.0);
                state.moving(dynamics).forward(&forces, &mut acceleration);
                acceleration.clone()
            });
        }
        state
    }

    fn moved(&self, slope: &Slope, time_s: f64) -> Self {
        let mut state = self.moved_raw(slope, time_s);
        state.attitude = UnitQuaternion::new_normalize(state.attitude.into_inner());
        state
    }

    fn moved_raw(&self, slope: &Slope, time_s: f64) -> Self {
        let attitude = self.attitude.into_inner() + slope.attitude * time_s;
        let joints = self.joints_rad.iter().zip(&slope.joints);
        Self {
            position_m: self.position_m + slope.position * time_s,
            attitude: UnitQuaternion::new_unchecked(attitude),
            joints_rad: joints.map(|(q, v)| q + v * time_s).collect(),
            velocities: &self.velocities + &slope.velocities * time_s,
        }
    }
}

/// Rates of a state.
struct Slope {
    position: Vector3<f64>,
    attitude: Quaternion<f64>,
    joints: Vec<f64>,
    velocities: DVector<f64>,
}

impl Slope {
    fn of(state: &State, accelerations: DVector<f64>) -> Self {
        let turn = Vector3::from(state.velocities.fixed_rows::<3>(3));
        Self {
            position: state.attitude * Vector3::from(state.velocities.fixed_rows::<3>(0)),
            attitude: state.attitude.into_inner() * Quaternion::from_imag(turn) * 0.5,
            joints: state.velocities.iter().skip(6).copied().collect(),
            velocities: accelerations,
        }
    }
}

use mlr_filter::{Axes, OrientationSeries, unwrapped_rad};

use super::{Record, world::World};

/// How a simulation ended.
#[derive(Debug, Clone)]
pub enum Outcome {
    /// The robot walked to the end.
    Walked(Trajectory),
    /// The state stopped being finite; nothing after this gait time means
    /// anything.
    Diverged {
        /// Gait time of the first bad step.
        at_s: f64,
    },
}

/// What the robot did, sampled once per time step. The walk starts at time 0;
/// recorded standing has negative times.
#[derive(Debug, Clone)]
pub struct Trajectory {
    /// Roll, pitch and unwrapped yaw of the body.
    pub orientation: OrientationSeries,
    /// Position of the body's origin, world frame, if recorded.
    pub position_m: Option<Vec<[f64; 3]>>,
    /// Force of the ground on the body (first entry) and on each leg, in
    /// newtons along the contact normals, if recorded.
    pub contact_force_n: Option<Vec<Vec<f64>>>,
    /// Torque of each present joint's servo, leg by leg from the body outward,
    /// if recorded.
    pub torque_nm: Option<Vec<Vec<f64>>>,
    /// Kinetic energy of all parts and potential energy over the world's origin,
    /// in joules, without what the servos' springs hold; if recorded.
    pub energy_j: Option<Vec<f64>>,
}

/// Collects a [`Trajectory`].
pub(super) struct Recorder {
    times_s: Vec<f64>,
    angles_rad: Axes<Vec<f64>>,
    position_m: Option<Vec<[f64; 3]>>,
    contact_force_n: Option<Vec<Vec<f64>>>,
    torque_nm: Option<Vec<Vec<f64>>>,
    energy_j: Option<Vec<f64>>,
}

impl Recorder {
    pub(super) fn new(record: Record) -> Self {
        Self {
            times_s: Vec::new(),
            angles_rad: Axes::default(),
            position_m: record.position.then(Vec::new),
            contact_force_n: record.contacts.then(Vec::new),
            torque_nm: record.torques.then(Vec::new),
            energy_j: record.energy.then(Vec::new),
        }
    }

    pub(super) fn record(&mut self, world: &World<'_>, time_s: f64) {
        let mut angles_rad = world.roll_pitch_yaw_rad();
        if let Some(previous) = self.angles_rad.yaw.last() {
            angles_rad.yaw = unwrapped_rad(*previous, angles_rad.yaw);
        }
        self.times_s.push(time_s);
        self.angles_rad.push(angles_rad);
        if let Some(positions) = &mut self.position_m {
            positions.push(world.position_m());
        }
        if let Some(forces) = &mut self.contact_force_n {
            forces.push(world.contact_force_n());
        }
        if let Some(torques) = &mut self.torque_nm {
            torques.push(world.torque_nm());
        }
        if let Some(energies) = &mut self.energy_j {
            energies.push(world.energy_j());
        }
    }

    /// What the body did so far; `None` when an angle is not finite.
    pub(super) fn orientation(&self) -> Option<OrientationSeries> {
        OrientationSeries::new(self.times_s.clone(), self.angles_rad.clone()).ok()
    }

    /// `None` when an angle is not finite.
    pub(super) fn finish(self) -> Option<Trajectory> {
        Some(Trajectory {
            orientation: OrientationSeries::new(self.times_s, self.angles_rad).ok()?,
            position_m: self.position_m,
            contact_force_n: self.contact_force_n,
            torque_nm: self.torque_nm,
            energy_j: self.energy_j,
        })
    }
}

//! A legged robot with any of its links missing, and how it moves.
//!
//! The paper's formalism is general: a body, N legs, n_i links in leg i. So is
//! this crate. A [`Robot`] describes the healthy machine, a [`Morphology`] says
//! which links are still there, a [`Gait`] what it is commanded to do, and a
//! [`Simulator`] assembles the damaged robot as a rapier3d multibody and walks it.
//!
//! ```
//! use mlr_model::{Gait, Morphology, Outcome, Robot, SimulationSettings, Simulator};
//!
//! let robot = Robot::jethexa();
//! let legs_3_and_4_lost = Morphology::parse_legs_lost("3,4", &robot.layout())?;
//! let settings = SimulationSettings { duration_s: 1.0, ..Default::default() };
//! let simulator = Simulator::new(robot, &Gait::tripod(), settings)?;
//!
//! let Outcome::Walked(trajectory) = simulator.simulate(&legs_3_and_4_lost) else {
//!     panic!("the simulation diverged");
//! };
//! let roll_rad = &trajectory.orientation.angles_rad().roll;
//! assert!(roll_rad.iter().any(|roll| roll.abs() > 0.05));
//! # Ok::<(), mlr_model::ModelError>(())
//! ```
//!
//! # Frames and units
//! SI units and radians. Frames follow REP-103: x forward, y left, z up; roll,
//! pitch and yaw are rotations about x, y and z with
//! `R = Rz(yaw) Ry(pitch) Rx(roll)`. The paper walks along its own Y axis, which
//! is +x here. Legs and links are numbered from 1 where people read them and
//! from 0 in the API.
//!
//! # Same inputs, same bits
//! A simulation gives the same bits whatever the number of threads and on
//! x86-64 and aarch64 alike: rapier runs with `enhanced-determinism`, and every
//! sine, cosine and arctangent on the way comes from the `libm` crate.

mod assembly;
pub mod bench;
mod command_cache;
pub mod dynamics;
mod error;
mod fault;
mod gait;
mod joint_commands;
pub mod kinematics;
mod morphology;
mod progress;
mod random;
mod rigid_mass;
mod robot;
mod setting_place;
mod simulation;
mod terrain;
mod variation;

pub use assembly::{AssembledLeg, Assembly, LinkPart, LockedContact};
pub use command_cache::CommandCache;
pub use error::ModelError;
pub use fault::Fault;
pub use gait::{
    BodyNod, FoldedWalk, FootMotion, FootTarget, Gait, JointTrajectory, LEAST_JERK_PEAK, LegPress,
    Motion, MotionSegment, SegmentTiming, TurnInPlace, least_jerk_share,
};
pub use joint_commands::JointCommands;
pub use morphology::{LegLayout, Morphologies, Morphology, link_logic};
pub use progress::Progress;
pub use random::standard_normal;
pub use rigid_mass::RigidMass;
pub use robot::{
    Body, Calibration, ContactShape, Drive, Gaussian, Imu, JointAxis, Leg, Link, Measurement,
    Robot, RobotParameter, Servo,
};
pub use setting_place::located;
pub use simulation::{
    GroundContact, Impacts, LostLinks, Obedience, Outcome, Record, SimulationSettings, Simulator,
    Trajectory, Walk,
};
pub use terrain::{Roughness, Terrain};
pub use variation::{Payload, Variation};

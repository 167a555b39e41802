use serde::{Deserialize, Serialize};

use crate::{Fault, ModelError, Payload, Robot, Terrain};

/// How a simulation is run. The defaults are the nominal model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SimulationSettings {
    /// How long the robot walks.
    pub duration_s: f64,
    /// How long it stands before anything is recorded, so that servos and
    /// contacts come to rest.
    pub settle_s: f64,
    /// How long it is then recorded standing before it walks.
    pub stand_s: f64,
    /// How far above the ground the robot is set down.
    pub start_clearance_m: f64,
    /// Time between two samples and between two collision detections.
    pub time_step_s: f64,
    /// Solver steps per time step.
    pub substeps: usize,
    /// Whether a lost link is gone or hangs on as dead weight.
    pub lost_links: LostLinks,
    /// How the ground holds what touches it.
    pub contact: GroundContact,
    /// The shape of the ground.
    pub terrain: Terrain,
    /// What the body carries.
    pub payload: Option<Payload>,
    /// What is wrong with the robot besides lost links.
    pub faults: Vec<Fault>,
    /// What to keep besides orientation.
    #[serde(skip)]
    pub record: Record,
}

impl Default for SimulationSettings {
    /// 5 s of walking after 0.5 s of standing, on flat ground. Time step and
    /// substeps are the choice of the convergence study (`docs/convergence.md`).
    fn default() -> Self {
        Self {
            duration_s: 5.0,
            settle_s: 0.5,
            stand_s: 0.0,
            start_clearance_m: 1e-4,
            time_step_s: 0.010,
            substeps: 1,
            lost_links: LostLinks::default(),
            contact: GroundContact::default(),
            terrain: Terrain::default(),
            payload: None,
            faults: Vec::new(),
            record: Record::default(),
        }
    }
}

impl SimulationSettings {
    pub(super) fn check(&self, robot: &Robot) -> Result<(), ModelError> {
        let range = ModelError::check_range;
        range(
            "duration_s",
            self.duration_s,
            0.01,
            3600.0,
            "0.01 to 3600 s",
        )?;
        range("settle_s", self.settle_s, 0.0, 60.0, "0 to 60 s")?;
        range("stand_s", self.stand_s, 0.0, 3600.0, "0 to 3600 s")?;
        range(
            "time_step_s",
            self.time_step_s,
            1e-5,
            0.02,
            "0.00001 to 0.02 s",
        )?;
        range(
            "start_clearance_m",
            self.start_clearance_m,
            0.0,
            1000.0,
            "0 to 1000 m",
        )?;
        if !(1..=1000).contains(&self.substeps) {
            return Err(ModelError::value("substeps", self.substeps, "1 to 1000"));
        }
        let contact = &self.contact;
        range("friction", contact.friction, 0.0, 10.0, "0 to 10")?;
        range(
            "natural_frequency_hz",
            contact.natural_frequency_hz,
            0.1,
            1e6,
            "0.1 to 1e6 Hz",
        )?;
        range(
            "damping_ratio",
            contact.damping_ratio,
            0.01,
            1e3,
            "0.01 to 1000",
        )?;
        if let Some(payload) = &self.payload {
            payload.check()?;
        }
        for fault in &self.faults {
            fault.check(robot)?;
        }
        self.terrain.check()
    }
}

/// What becomes of a link that is lost.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize,
)]
#[serde(rename_all = "lowercase")]
pub enum LostLinks {
    /// Gone, with its mass.
    #[default]
    Absent,
    /// Still there, its servo locked at an angle that keeps it clear of the
    /// ground: the way the paper's experiments emulate a loss.
    Locked,
}

/// The contact law between robot and ground.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GroundContact {
    /// Coulomb friction coefficient.
    pub friction: f64,
    /// Natural frequency of the spring that pushes a penetration out.
    pub natural_frequency_hz: f64,
    /// Damping ratio of that spring.
    pub damping_ratio: f64,
}

impl Default for GroundContact {
    fn default() -> Self {
        Self {
            friction: 0.7,
            natural_frequency_hz: 60.0,
            damping_ratio: 10.0,
        }
    }
}

/// What a simulation keeps besides the body's orientation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Record {
    /// The position of the body's origin.
    pub position: bool,
    /// The force between the ground and each leg.
    pub contacts: bool,
    /// The torque of each present joint's servo.
    pub torques: bool,
    /// The mechanical energy of the whole robot.
    pub energy: bool,
}

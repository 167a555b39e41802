use mlr_filter::SettingError;
use serde::{Deserialize, Serialize};

use crate::{Fault, Payload, Robot, Terrain};

/// How a simulation is run. The defaults are the nominal model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
    /// Steps of a simulation, at most.
    const MOST_STEPS: f64 = 1e7;

    /// Checks every number. Standing for no time is valid.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        let check = SettingError::check::<f64>;
        check("duration_s", self.duration_s, 0.01..=3600.0, "s")?;
        check("settle_s", self.settle_s, 0.0..=60.0, "s")?;
        check("stand_s", self.stand_s, 0.0..=3600.0, "s")?;
        check(
            "start_clearance_m",
            self.start_clearance_m,
            0.0..=1000.0,
            "m",
        )?;
        check("time_step_s", self.time_step_s, 1e-5..=0.02, "s")?;
        let least_s = (self.settle_s + self.stand_s + self.duration_s) / Self::MOST_STEPS;
        if self.time_step_s < least_s {
            let expected = format!("at least {least_s} s for a walk this long");
            return Err(SettingError::new("time_step_s", self.time_step_s, expected));
        }
        SettingError::check("substeps", self.substeps, 1..=1000, "")?;
        self.contact
            .check()
            .map_err(|error| error.under("contact"))?;
        self.terrain
            .check()
            .map_err(|error| error.under("terrain"))?;
        if let Some(payload) = &self.payload {
            payload.check().map_err(|error| error.under("payload"))?;
        }
        self.each_fault(Fault::check)
    }

    /// Checks every number, and whether this robot can have these faults.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check_on(&self, robot: &Robot) -> Result<(), SettingError> {
        self.check()?;
        self.each_fault(|fault| fault.check_on(robot))
    }

    fn each_fault(
        &self,
        check: impl Fn(&Fault) -> Result<(), SettingError>,
    ) -> Result<(), SettingError> {
        let mut numbered = self.faults.iter().enumerate();
        numbered.try_for_each(|(index, fault)| {
            check(fault).map_err(|error| error.under(&format!("faults[{index}]")))
        })
    }
}

/// What becomes of a link that is lost.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize,
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum LostLinks {
    /// Gone, with its mass.
    #[default]
    Absent,
    /// Still there, its servo locked at an angle that keeps it clear of the
    /// ground: the way the paper's experiments emulate a loss.
    Locked,
}

impl LostLinks {
    /// Both, each with its probability where they are locked with this one.
    pub fn with_probabilities(locked: f64) -> [(Self, f64); 2] {
        [(Self::Absent, 1.0 - locked), (Self::Locked, locked)]
    }
}

/// The contact law between robot and ground.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct GroundContact {
    /// Coulomb friction coefficient.
    pub friction: f64,
    /// Natural frequency of the spring that pushes a penetration out.
    pub natural_frequency_hz: f64,
    /// Damping ratio of that spring.
    pub damping_ratio: f64,
    /// How what comes down is stopped.
    pub impacts: Impacts,
}

/// How a contact stops what comes down on it. Engines differ in this, and no description of a robot tells: a
/// robot that falls on its front edge rocks on by 1.7° with the one law and by 9.3° with the other (test `impacts`
/// of `mlr-golden-tests`).
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize,
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Impacts {
    /// Within one time step: rapier removes at its end what the spring has added to the speed.
    #[default]
    Rigid,
    /// By spring and damper alone.
    Compliant,
}

impl Default for GroundContact {
    fn default() -> Self {
        Self {
            friction: 0.7,
            natural_frequency_hz: 60.0,
            damping_ratio: 10.0,
            impacts: Impacts::default(),
        }
    }
}

impl GroundContact {
    /// No ground grips better.
    pub const LARGEST_FRICTION: f64 = 10.0;
    /// Damping ratio at most where impacts are compliant: with it a robot that falls on its nose rocks as far as
    /// in MuJoCo (`tests/impacts.rs`).
    const COMPLIANT_DAMPING_RATIO: f64 = 4.0;

    /// The same ground with impacts of this kind.
    #[must_use]
    pub fn with_impacts(self, impacts: Impacts) -> Self {
        let damping_ratio = match impacts {
            Impacts::Rigid => self.damping_ratio,
            Impacts::Compliant => self.damping_ratio.min(Self::COMPLIANT_DAMPING_RATIO),
        };
        Self {
            damping_ratio,
            impacts,
            ..self
        }
    }

    /// Checks every number. Ground without friction is valid.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        let check = SettingError::check::<f64>;
        let largest = Self::LARGEST_FRICTION;
        check("friction", self.friction, 0.0..=largest, "")?;
        check(
            "natural_frequency_hz",
            self.natural_frequency_hz,
            0.1..=1e6,
            "Hz",
        )?;
        check("damping_ratio", self.damping_ratio, 0.01..=1000.0, "")
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

//! One leg as it is, its faults included.

use std::borrow::Cow;

use crate::{Fault, JointCommands, Robot, Servo, robot::Leg};

/// What the faults make of one leg.
#[derive(Debug)]
pub(crate) struct LegState<'a> {
    index: usize,
    description: Cow<'a, Leg>,
    servo: Servo,
    /// How each joint takes its commands.
    obeys: Vec<Obedience>,
    /// Friction coefficient between this leg and the ground, where it differs.
    pub(crate) friction: Option<f64>,
}

/// How a joint takes its commands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Obedience {
    /// With this much added, radians.
    Shifted(f64),
    /// Not at all: its servo holds it at this angle, radians.
    Stuck(f64),
}

impl<'a> LegState<'a> {
    /// Leg `index`, counted from 0, with those of the faults that concern it.
    pub(crate) fn new(robot: &'a Robot, index: usize, faults: &[Fault]) -> Self {
        let description = &robot.legs()[index];
        let mut state = Self {
            index,
            description: Cow::Borrowed(description),
            servo: *robot.servo(),
            obeys: description
                .joint_zeros_rad
                .iter()
                .map(|zero_rad| Obedience::Shifted(*zero_rad))
                .collect(),
            friction: None,
        };
        for fault in faults {
            state.suffer(fault);
        }
        state
    }

    fn suffer(&mut self, fault: &Fault) {
        let number = self.index + 1;
        match *fault {
            Fault::FootFriction { leg, mu } if leg == number => self.friction = Some(mu),
            Fault::WeakLeg { leg, gain } if leg == number => {
                self.servo.stiffness_nm_per_rad *= gain;
                self.servo.torque_limit_nm *= gain;
            }
            Fault::StuckJoint {
                leg,
                joint,
                angle_rad,
            } if leg == number => self.obeys[joint - 1] = Obedience::Stuck(angle_rad),
            Fault::JointOffset {
                leg,
                joint,
                angle_rad,
            } if leg == number => self.obeys[joint - 1].shift(angle_rad),
            Fault::ShortLink {
                leg,
                link,
                length_lost_m,
            } if leg == number => {
                self.description.to_mut().links[link - 1].shorten(length_lost_m);
            }
            _ => {}
        }
    }

    /// What the leg is made of.
    pub(crate) fn description(&self) -> &Leg {
        &self.description
    }

    /// The servo in each of its joints.
    pub(crate) fn servo(&self) -> &Servo {
        &self.servo
    }

    /// How joint `link`, counted from 0, takes its commands.
    pub(crate) fn obedience(&self, link: usize) -> Obedience {
        self.obeys[link]
    }

    /// The angle that the servo of joint `link`, counted from 0, makes for at gait
    /// time `time_s`.
    pub(crate) fn target_rad(&self, commands: &JointCommands, link: usize, time_s: f64) -> f64 {
        match self.obeys[link] {
            Obedience::Shifted(by_rad) => commands.angle_rad(self.index, link, time_s) + by_rad,
            Obedience::Stuck(angle_rad) => angle_rad,
        }
    }
}

impl Obedience {
    fn shift(&mut self, more_rad: f64) {
        let (Self::Shifted(angle_rad) | Self::Stuck(angle_rad)) = self;
        *angle_rad += more_rad;
    }
}

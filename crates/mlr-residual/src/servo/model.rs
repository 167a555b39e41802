//! The model of a servo on a bench, and what it predicts.

use mlr_model::bench::{Bench, Command, Swing};

use super::ServoRecording;

/// Time step of the simulation, s. How near angles then are to those of much finer steps, a test of
/// `mlr_model::bench` says.
const TIME_STEP_S: f64 = 0.002;

/// A servo on a bench, as described or with effects.
#[derive(Debug, Clone, PartialEq)]
pub struct ServoModel {
    /// The bench and its servo.
    pub bench: Bench,
    /// By what share of the supply's the torque changes: 0 for a servo that holds its torque, 1 for a
    /// motor at its supply.
    pub supply_share: f64,
    /// Whether reported angles are multiples of the encoder's step.
    pub rounds: bool,
    described_limit_nm: f64,
}

impl ServoModel {
    /// The servo as described.
    pub fn new(bench: Bench) -> Self {
        Self {
            described_limit_nm: bench.servo.torque_limit_nm,
            bench,
            supply_share: 0.0,
            rounds: false,
        }
    }

    /// Torque limit of the servo as described, which effects are measured by, whatever other effects
    /// make of it.
    pub(crate) fn described_limit_nm(&self) -> f64 {
        self.described_limit_nm
    }

    /// The angle that the servo reports at each sample of a recording, rad; `None` where the simulation
    /// does not stay finite. It begins at rest where the recording begins.
    pub(super) fn predicted_rad(&self, recording: &ServoRecording) -> Option<Vec<f64>> {
        let commands = self.commands(recording);
        let start_rad = recording.positions_rad.first().copied()?;
        let first_s = recording.times_s.first().copied()?;
        let steps = (recording.duration_s() / TIME_STEP_S).ceil() as usize + 1;
        let swing = Swing::new(&self.bench, &commands, start_rad, TIME_STEP_S);
        let angles_rad = swing.angles_rad(steps)?;
        // The resolution is looked for in all samples.
        let step_rad = if self.rounds {
            recording.resolution_rad()
        } else {
            0.0
        };
        let at = |time_s: &f64| {
            let steps_passed = (time_s - first_s) / TIME_STEP_S;
            let before = (steps_passed as usize).min(angles_rad.len().saturating_sub(2));
            let share = steps_passed - before as f64;
            let angle = angles_rad[before] + share * (angles_rad[before + 1] - angles_rad[before]);
            if step_rad > 0.0 {
                (angle / step_rad).round() * step_rad
            } else {
                angle
            }
        };
        Some(recording.times_s.iter().map(at).collect())
    }

    /// Reported less predicted effort of the controller, over its largest, at each sample with current;
    /// nothing where recording and bench do not tell. The prediction takes the reported angle.
    pub(super) fn effort_errors(&self, recording: &ServoRecording) -> Vec<f64> {
        let Some(largest) = self.bench.reference.load else {
            return Vec::new();
        };
        let commands = self.commands(recording);
        let latency_s = self.bench.servo.latency_s;
        let error = |(sample, load): (usize, &f64)| {
            let time_s = commands[sample].time_s - latency_s;
            let later = commands.partition_point(|one| one.time_s <= time_s);
            let command = &commands[later.saturating_sub(1)];
            let servo = command.servo(&self.bench.servo);
            load / largest - servo.effort(command.goal_rad - recording.positions_rad[sample])
        };
        let loads = recording.load.iter().enumerate();
        loads
            .filter(|(sample, _)| recording.motor_on[*sample])
            .map(error)
            .collect()
    }

    fn commands(&self, recording: &ServoRecording) -> Vec<Command> {
        let reference = self.bench.reference;
        let over = |values: &[f64], sample: usize, reference: Option<f64>| {
            let ratio = values.get(sample).zip(reference);
            ratio.map_or(1.0, |(value, reference)| value / reference)
        };
        let command = |sample: usize| {
            let supply = over(&recording.supply_v, sample, reference.supply_v);
            Command {
                time_s: recording.times_s[sample],
                goal_rad: recording.goals_rad[sample],
                motor_on: recording.motor_on[sample],
                stiffness: over(&recording.p_gain, sample, reference.p_gain),
                torque: 1.0 + self.supply_share * (supply - 1.0),
            }
        };
        (0..recording.times_s.len()).map(command).collect()
    }
}

//! The model of a robot in question.

use mlr_model::{Gait, ModelError, Robot, SimulationSettings};
use mlr_residual::{
    walk::WalkModel,
    walk_effects::{apply_reported, apply_reported_surroundings, find},
};
use rand_chacha::ChaCha8Rng;

use super::question::Hypothesis;

impl Hypothesis<'_> {
    /// The model with what is wrong with the robot and the ground under it. What a sensor adds to all
    /// motions alike is no part of it: the comparison leaves means and trends out. Where an effect is, and its size,
    /// is drawn if nothing is known of that.
    pub(super) fn model(
        &self,
        robot: &Robot,
        gait: &Gait,
        simulation: &SimulationSettings,
        generator: &mut ChaCha8Rng,
    ) -> Result<(Robot, SimulationSettings), ModelError> {
        let simulation = SimulationSettings {
            lost_links: self.lost_links,
            ..simulation.clone()
        };
        let mut model = WalkModel::nominal(robot.clone(), gait.clone(), simulation);
        for effect in &self.robot.effects {
            let (kind, parameters) = (&effect.kind, &effect.parameters);
            if effect.is_of_any_size() {
                if let Some(known) = find(kind) {
                    known.draw(&self.robot.morphology, &mut model, generator);
                }
                continue;
            }
            // An effect that lacks a parameter changes nothing, like those of the sensor.
            let _ = apply_reported(kind, parameters, &mut model);
            let _ = apply_reported_surroundings(kind, parameters, &mut model);
        }
        Ok((model.robot.with_servo(model.servo)?, model.simulation))
    }
}

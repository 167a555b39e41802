use mlr_filter::OrientationSeries;

use super::{Outcome, Simulator, trajectory::Recorder, whole_steps, world::World};
use crate::Morphology;

/// A walk under way, which can be looked at before it is over.
///
/// ```
/// use mlr_model::{Gait, Morphology, Robot, SimulationSettings, Simulator};
///
/// let robot = Robot::jethexa();
/// let healthy = Morphology::healthy(&robot.layout());
/// let settings = SimulationSettings { duration_s: 2.0, ..Default::default() };
/// let simulator = Simulator::new(robot, &Gait::tripod(), settings)?;
/// let mut walk = simulator.start(&healthy);
/// walk.advance_to(0.5);
/// let so_far = walk.orientation().expect("a healthy walk stays finite");
/// assert!(so_far.times_s().last().is_some_and(|&t| (t - 0.5).abs() < 1e-9));
/// # Ok::<(), mlr_model::ModelError>(())
/// ```
pub struct Walk<'a> {
    simulator: &'a Simulator,
    world: World<'a>,
    recorder: Recorder,
    /// The next step; 0 begins the walk.
    next: i64,
    diverged_at_s: Option<f64>,
}

impl<'a> Walk<'a> {
    pub(super) fn new(simulator: &'a Simulator, morphology: &Morphology) -> Self {
        let settings = simulator.settings();
        let steps = |duration_s| whole_steps(duration_s, settings.time_step_s);
        Self {
            world: World::new(simulator, morphology),
            recorder: Recorder::new(settings.record),
            next: -(steps(settings.settle_s) + steps(settings.stand_s)),
            diverged_at_s: None,
            simulator,
        }
    }

    /// Walks on until this gait time, at most to the duration of the settings.
    /// Does nothing once the walk has diverged.
    pub fn advance_to(&mut self, gait_time_s: f64) {
        let settings = self.simulator.settings();
        let steps = |duration_s| whole_steps(duration_s, settings.time_step_s);
        let end = steps(settings.duration_s);
        let standing = -steps(settings.stand_s);
        let last = end.min(steps(gait_time_s));
        while self.next <= last && self.diverged_at_s.is_none() {
            let time_s = self.next as f64 * settings.time_step_s;
            if self.next >= standing {
                self.recorder.record(&self.world, time_s);
            }
            if self.next < end && !self.world.step(self.simulator.commands(), time_s) {
                self.diverged_at_s = Some(time_s);
            }
            self.next += 1;
        }
    }

    /// The body's orientation so far; `None` once it is not finite.
    pub fn orientation(&self) -> Option<OrientationSeries> {
        if self.diverged_at_s.is_some() {
            return None;
        }
        self.recorder.orientation()
    }

    /// Walks to the end.
    pub fn finish(mut self) -> Outcome {
        let duration_s = self.simulator.settings().duration_s;
        self.advance_to(duration_s);
        let diverged_at_s = self.diverged_at_s.unwrap_or(duration_s);
        match self
            .recorder
            .finish()
            .filter(|_| self.diverged_at_s.is_none())
        {
            Some(trajectory) => Outcome::Walked(trajectory),
            None => Outcome::Diverged {
                at_s: diverged_at_s,
            },
        }
    }
}

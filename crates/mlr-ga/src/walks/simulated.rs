use std::collections::BTreeMap;

use mlr_model::{
    CommandCache, Gait, ModelError, Morphology, Robot, SimulationSettings, Simulator, Variation,
};

use super::{Case, Look, WalkSource, Walked};
use crate::comparison::ComparableWalk;

/// Walks that are simulated when they are asked for.
#[derive(Debug)]
pub struct SimulatedWalks {
    simulators: BTreeMap<Case, Simulator>,
    /// Gait times of the checkpoints.
    looks_s: Vec<f64>,
}

impl SimulatedWalks {
    /// Simulates the robot in each of the cases, whose variations are those of the
    /// list, long enough for `samples` samples of a [`ComparableWalk`], with checkpoints
    /// after `looks` samples.
    ///
    /// # Errors
    /// [`ModelError`] when robot, gait, settings and variations do not fit.
    pub fn new(
        robot: &Robot,
        gait: &Gait,
        settings: &SimulationSettings,
        cases: impl IntoIterator<Item = Case>,
        variations: &[Variation],
        samples: usize,
        looks: &[usize],
    ) -> Result<Self, ModelError> {
        let mut simulators = BTreeMap::new();
        let commands = CommandCache::default();
        for case in cases {
            let Some(varied) = variations.get(case.variation) else {
                continue;
            };
            let (robot, simulation) = varied.apply(robot, settings)?;
            let simulation = SimulationSettings {
                duration_s: ComparableWalk::duration_s(samples),
                stand_s: 0.0,
                lost_links: case.lost_links,
                ..simulation
            };
            let simulator = Simulator::sharing(&commands, robot, gait, simulation)?;
            simulators.insert(case, simulator);
        }
        Ok(Self {
            simulators,
            looks_s: looks
                .iter()
                .map(|&samples| ComparableWalk::duration_s(samples))
                .collect(),
        })
    }
}

impl WalkSource for SimulatedWalks {
    fn walk(&self, candidate: &Morphology, case: Case, look: &mut Look<'_>) -> Walked {
        let Some(simulator) = self.simulators.get(&case) else {
            return Walked::Unknown;
        };
        let mut walk = simulator.start(candidate);
        for &look_s in &self.looks_s {
            walk.advance_to(look_s);
            let Some(so_far) = walk.orientation() else {
                return Walked::Diverged;
            };
            if look(&ComparableWalk::new(&so_far)).is_break() {
                return Walked::Stopped;
            }
        }
        walk.advance_to(simulator.settings().duration_s);
        walk.orientation().map_or(Walked::Diverged, |walk| {
            Walked::Whole(ComparableWalk::new(&walk))
        })
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use mlr_model::LostLinks;

    use super::*;

    #[test]
    fn a_walk_is_shown_in_part_and_may_be_stopped() {
        let robot = Robot::jethexa();
        let healthy = Morphology::healthy(&robot.layout());
        let walks = SimulatedWalks::new(
            &robot,
            &Gait::tripod(),
            &SimulationSettings::default(),
            [Case {
                lost_links: LostLinks::Absent,
                variation: 0,
            }],
            &[Variation::default()],
            50,
            &[25, 40],
        )
        .unwrap();
        let case = Case {
            lost_links: LostLinks::Absent,
            variation: 0,
        };
        let mut seen = Vec::new();
        let walked = walks.walk(&healthy, case, &mut |walk| {
            seen.push(walk.len());
            ControlFlow::Continue(())
        });
        assert_eq!(seen, [25, 40]);
        assert!(matches!(walked, Walked::Whole(walk) if walk.len() == 50));
        let stopped = walks.walk(&healthy, case, &mut |_| ControlFlow::Break(()));
        assert_eq!(stopped, Walked::Stopped);
        let other = Case {
            variation: 1,
            ..case
        };
        let unknown = walks.walk(&healthy, other, &mut |_| ControlFlow::Continue(()));
        assert_eq!(unknown, Walked::Unknown);
    }
}

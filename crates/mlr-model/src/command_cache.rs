//! Joint commands that several simulators share.

use std::{
    collections::VecDeque,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use crate::{Gait, JointCommands, Leg, ModelError, Robot};

/// As many tables are kept: a fit changes one gait at a time, and comes back to the one before.
const MOST_KEPT: usize = 4;

/// Keeps the joint commands that were needed last.
///
/// Commands follow from the gait and from where the controller believes the joints are. Robots that
/// differ in masses, servos or joint zeros, as in a fit, are commanded alike, and inverse kinematics
/// would take an eighth of the time of their walks. Clones share what is kept, also between threads;
/// all caches are equal, since the commands do not depend on them.
#[derive(Debug, Clone, Default)]
pub struct CommandCache {
    kept: Arc<Mutex<VecDeque<Kept>>>,
}

#[derive(Debug)]
struct Kept {
    robot: Robot,
    gait: Gait,
    duration_s: f64,
    commands: Arc<JointCommands>,
}

impl CommandCache {
    /// The commands of [`JointCommands::new`], for `duration_s` or longer.
    ///
    /// # Errors
    /// Those of [`JointCommands::new`].
    pub fn commands(
        &self,
        robot: &Robot,
        gait: &Gait,
        duration_s: f64,
    ) -> Result<Arc<JointCommands>, ModelError> {
        if let Some(found) = Self::found(&self.lock(), robot, gait, duration_s) {
            return Ok(found);
        }
        // Others go on meanwhile, and may have made the same before this is done.
        let commands = Arc::new(JointCommands::new(robot, gait, duration_s)?);
        let mut kept = self.lock();
        if let Some(found) = Self::found(&kept, robot, gait, duration_s) {
            return Ok(found);
        }
        kept.push_front(Kept {
            robot: robot.clone(),
            gait: gait.clone(),
            duration_s,
            commands: Arc::clone(&commands),
        });
        kept.truncate(MOST_KEPT);
        Ok(commands)
    }

    fn lock(&self) -> MutexGuard<'_, VecDeque<Kept>> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn found(
        kept: &VecDeque<Kept>,
        robot: &Robot,
        gait: &Gait,
        duration_s: f64,
    ) -> Option<Arc<JointCommands>> {
        let found = kept.iter().find(|kept| kept.serve(robot, gait, duration_s));
        found.map(|found| Arc::clone(&found.commands))
    }
}

impl PartialEq for CommandCache {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Kept {
    fn serve(&self, robot: &Robot, gait: &Gait, duration_s: f64) -> bool {
        let (own, other) = (&self.robot, robot);
        duration_s <= self.duration_s
            && own.servo().command_hold_s == other.servo().command_hold_s
            && own.body().size_m == other.body().size_m
            && own.legs().len() == other.legs().len()
            && own.legs().iter().zip(other.legs()).all(reach_alike)
            && self.gait == *gait
    }
}

/// Whether two legs differ in nothing that commands depend on.
fn reach_alike((one, other): (&Leg, &Leg)) -> bool {
    // Every field is named, so that none is forgotten.
    let Leg {
        name: _,
        hip_m,
        hip_yaw_rad,
        nominal_foot_m,
        links,
        joint_zeros_rad: _,
    } = one;
    *hip_m == other.hip_m
        && *hip_yaw_rad == other.hip_yaw_rad
        && *nominal_foot_m == other.nominal_foot_m
        && *links == other.links
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RobotParameter;

    fn kept(cache: &CommandCache) -> usize {
        cache.kept.lock().unwrap().len()
    }

    #[test]
    fn robots_that_are_commanded_alike_share_a_table() {
        let cache = CommandCache::default();
        let (robot, gait) = (Robot::jethexa(), Gait::tripod());
        let first = cache.commands(&robot, &gait, 2.0).unwrap();
        for parameter in RobotParameter::all(&robot) {
            let own = robot.clone().with_added(parameter, 0.01);
            let commands = cache.clone().commands(&own, &gait, 1.5).unwrap();
            assert!(Arc::ptr_eq(&first, &commands), "{parameter}");
        }
        assert_eq!(kept(&cache), 1);
    }

    #[test]
    fn what_is_commanded_otherwise_has_a_table_of_its_own() {
        let cache = CommandCache::default();
        let (robot, gait) = (Robot::jethexa(), Gait::tripod());
        let first = cache.commands(&robot, &gait, 1.0).unwrap();
        let slower = Gait {
            period_s: 1.1 * gait.period_s,
            ..gait.clone()
        };
        let text = Robot::JETHEXA_TOML.replace("length_m = 0.07703", "length_m = 0.075");
        let shorter = Robot::from_toml(&text).unwrap();
        assert_ne!(shorter.legs(), robot.legs());
        for (robot, gait, duration_s) in [
            (&robot, &slower, 1.0),
            (&shorter, &gait, 1.0),
            (&robot, &gait, 2.0),
        ] {
            let commands = cache.commands(robot, gait, duration_s).unwrap();
            assert!(!Arc::ptr_eq(&first, &commands));
            let computed = JointCommands::new(robot, gait, duration_s).unwrap();
            for tick in 0..100 {
                let time_s = duration_s * f64::from(tick) / 100.0;
                assert_eq!(commands.all_rad(time_s), computed.all_rad(time_s));
            }
        }
        assert!(kept(&cache) <= MOST_KEPT);
    }

    #[test]
    fn a_gait_out_of_reach_is_refused_each_time() {
        let cache = CommandCache::default();
        let mut gait = Gait::tripod();
        gait.feet_mut().unwrap().stride_m = 0.5;
        for _ in 0..2 {
            let refused = cache.commands(&Robot::jethexa(), &gait, 2.0);
            assert!(matches!(refused, Err(ModelError::Unreachable { .. })));
        }
        assert_eq!(kept(&cache), 0);
    }
}

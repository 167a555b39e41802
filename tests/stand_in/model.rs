use std::{num::NonZeroUsize, sync::LazyLock};

use mlr_ga::{
    IdentifySettings, Model,
    atlas::{Atlas, AtlasPlan, build},
};
use mlr_model::{Gait, Robot};

/// The robot in full health, its gait, and an atlas of it.
pub(crate) struct KnownRobot {
    robot: Robot,
    gait: Gait,
    atlas: Atlas,
}

/// What all tests of this program share.
pub(crate) static KNOWN: LazyLock<KnownRobot> = LazyLock::new(KnownRobot::new);

impl KnownRobot {
    /// Simulates all morphologies with at most two damaged legs, gone and locked, under the
    /// variations of [`settings`], for logs that show the start of the walk: one to two minutes
    /// of one core. It is built anew each time: one that was kept would hide what a change of
    /// the simulation does.
    fn new() -> Self {
        let (robot, gait) = (Robot::jethexa(), Gait::tripod());
        let settings = settings();
        let plan = AtlasPlan {
            most_damaged_legs: NonZeroUsize::new(2),
            duration_s: settings.window_s,
            ..AtlasPlan::default()
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("jethexa.atlas");
        build(&path, &robot, &gait, &settings, plan, &()).unwrap();
        let atlas = Atlas::open(&path, &robot, &gait, &settings).unwrap();
        Self { robot, gait, atlas }
    }

    pub(crate) fn with_atlas(&self) -> Model<'_> {
        Model::new(&self.robot, &self.gait).with_atlas(&self.atlas)
    }
}

/// The default settings, but for six variations of the model: each takes time.
pub(crate) fn settings() -> IdentifySettings {
    let mut settings = IdentifySettings::default();
    // As described; soft servos on slippery ground, stiff ones, very soft ones on rough ground; two slopes.
    let all = std::mem::take(&mut settings.variations);
    settings.variations = [0, 2, 4, 6, 14, 18].map(|index| all[index]).into();
    settings
}

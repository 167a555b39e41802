use std::sync::LazyLock;

use mlr_model::{Gait, Robot};

use crate::atlas::Atlas;

/// What is known of the robot before it is damaged.
#[derive(Debug, Clone, Copy)]
pub struct Model<'a> {
    /// The robot in full health.
    pub robot: &'a Robot,
    /// The gait that it walks.
    pub gait: &'a Gait,
    /// Its walks, if they were simulated beforehand: then nothing is simulated but
    /// what the report shows.
    pub atlas: Option<&'a Atlas>,
}

impl<'a> Model<'a> {
    /// A robot and its gait, without an atlas.
    pub fn new(robot: &'a Robot, gait: &'a Gait) -> Self {
        Self {
            robot,
            gait,
            atlas: None,
        }
    }

    /// The same with walks that were simulated beforehand, if there are any.
    #[must_use]
    pub fn with_atlas(self, atlas: impl Into<Option<&'a Atlas>>) -> Self {
        Self {
            atlas: atlas.into(),
            ..self
        }
    }
}

impl Model<'static> {
    /// The embedded Hiwonder JetHexa with its tripod gait.
    pub fn jethexa() -> Self {
        static JETHEXA: LazyLock<(Robot, Gait)> =
            LazyLock::new(|| (Robot::jethexa(), Gait::tripod()));
        let (robot, gait) = &*JETHEXA;
        Self::new(robot, gait)
    }
}

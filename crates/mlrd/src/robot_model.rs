//! What is known of the robot before it walks.

use std::sync::Arc;

use mlr_ga::{IdentifySettings, Model, atlas::Atlas};
use mlr_model::{Gait, Robot};

use crate::Settings;

/// The robot as its make is described, how it is identified, and what answers are labelled with.
pub struct RobotModel {
    /// The robot's description.
    pub description: String,
    /// The robot as described.
    pub robot: Arc<Robot>,
    /// The gait that it walks.
    pub gait: Gait,
    atlas: Option<Atlas>,
    /// How it is identified.
    pub identification: IdentifySettings,
    /// The port that recordings come from.
    pub source: String,
}

impl RobotModel {
    /// Reads what the settings name.
    ///
    /// # Errors
    /// When robot, gait or atlas cannot be read.
    pub fn new(settings: &Settings, source: String) -> anyhow::Result<Self> {
        let (description, robot, gait) = settings.model()?;
        let atlas = settings
            .atlas
            .as_ref()
            .map(|path| Atlas::open(path, &robot, &gait, &settings.identification))
            .transpose()?;
        Ok(Self {
            description,
            robot: Arc::new(robot),
            gait,
            atlas,
            identification: IdentifySettings {
                seed: settings.seed,
                ..settings.identification.clone()
            },
            source,
        })
    }

    /// What candidates of a robot known like this are simulated with. Walks of an atlas stay those
    /// of the robot as described.
    pub fn model<'a>(&'a self, robot: &'a Robot) -> Model<'a> {
        Model::new(robot, &self.gait).with_atlas(self.atlas.as_ref())
    }
}

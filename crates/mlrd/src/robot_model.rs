//! What is known of the robot before it walks.

use mlr_ga::{IdentifySettings, Model, atlas::Atlas};
use mlr_model::{Gait, Robot};

use crate::Settings;

/// The robot, how it is identified, and what answers are labelled with.
pub struct RobotModel {
    robot: Robot,
    gait: Gait,
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
        let (robot, gait) = settings.model()?;
        let atlas = settings
            .atlas
            .as_ref()
            .map(|path| Atlas::open(path, &robot, &gait, &settings.identification))
            .transpose()?;
        Ok(Self {
            robot,
            gait,
            atlas,
            identification: IdentifySettings {
                seed: settings.seed,
                ..settings.identification.clone()
            },
            source,
        })
    }

    /// What candidates are simulated with.
    pub fn model(&self) -> Model<'_> {
        Model {
            robot: &self.robot,
            gait: &self.gait,
            atlas: self.atlas.as_ref(),
        }
    }
}

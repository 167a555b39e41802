use mlr_model::{ModelError, Morphology};

use super::{IdentifySettings, MeasuredWalk, Model, Search};
use crate::{
    AnswerError,
    atlas::Atlas,
    comparison::ComparableWalk,
    walks::{Case, Look, SimulatedWalks, WalkSource, Walked},
};

/// The walks of a model's candidates: from its atlas, or simulated.
pub(super) enum ModelWalks<'a> {
    Atlas(&'a Atlas),
    Simulated(SimulatedWalks),
}

impl<'a> ModelWalks<'a> {
    /// Walks at least as long as the measured stretch.
    pub(super) fn new(
        measured: &MeasuredWalk,
        model: Model<'a>,
        search: Search,
        settings: &IdentifySettings,
    ) -> Result<Self, AnswerError> {
        settings.check_on(model.robot)?;
        let Some(atlas) = model.atlas else {
            return match search {
                Search::Atlas => Err(AnswerError::NoAtlas {
                    gait: model.gait.name.clone(),
                }),
                _ => Ok(Self::Simulated(simulated(measured, model, settings)?)),
            };
        };
        let needed = measured.stretch().walk_samples();
        if needed > atlas.walk_samples() {
            return Err(AnswerError::AtlasTooShort {
                needed_s: ComparableWalk::duration_s(needed),
                there_s: ComparableWalk::duration_s(atlas.walk_samples()),
            });
        }
        Ok(Self::Atlas(atlas))
    }
}

impl WalkSource for ModelWalks<'_> {
    fn walk(&self, candidate: &Morphology, case: Case, look: &mut Look<'_>) -> Walked {
        match self {
            Self::Atlas(atlas) => atlas.walk(candidate, case, look),
            Self::Simulated(simulated) => simulated.walk(candidate, case, look),
        }
    }
}

/// Every case of the settings, simulated when it is asked for.
fn simulated(
    measured: &MeasuredWalk,
    model: Model<'_>,
    settings: &IdentifySettings,
) -> Result<SimulatedWalks, ModelError> {
    let cases = (0..settings.variations.len()).flat_map(|variation| {
        let lost_links = settings.lost_links.cases().iter();
        lost_links.map(move |&lost_links| Case {
            lost_links,
            variation,
        })
    });
    let stretch = measured.stretch();
    SimulatedWalks::new(
        model.robot,
        model.gait,
        &settings.simulation,
        cases,
        &settings.variations,
        stretch.walk_samples(),
        &stretch.looks(),
    )
}

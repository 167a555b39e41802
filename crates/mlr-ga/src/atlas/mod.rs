//! An atlas: walks simulated beforehand, for answers in a fraction of a second.

mod build;
mod file;
mod of_logs;
mod shard;

pub use build::{AtlasPlan, build};
pub use file::AtlasProblem;
pub use of_logs::{AtlasesError, AtlasesOfLogs};
pub use shard::{build_shard, merge};

use std::{collections::BTreeMap, ops::ControlFlow, path::Path};

use mlr_filter::Axes;
use mlr_model::{Gait, LostLinks, Morphology, Robot};
use thiserror::Error;

use crate::{
    IdentifySettings,
    comparison::ComparableWalk,
    walks::{Case, Look, WalkSource, Walked},
};
use file::{AtlasReader, GAIT, Header, SAMPLE_DEG};

/// The walks of every feasible morphology of one robot with one gait on the nominal
/// model, and of those with few damaged legs under its variations. A smaller atlas
/// ([`AtlasPlan::most_damaged_legs`]) knows nothing of morphologies with many damaged legs.
///
/// The file, little-endian throughout: 8 bytes `MLRATLAS`, u32 version of the
/// format, u32 length of the header, the header as JSON, zeros up to a multiple of
/// 64 bytes; then for each case of the header the walks of its morphologies, each
/// as the samples of roll, pitch and yaw in i16 hundredths of a degree; at the end
/// the CRC-64/XZ of all before it. Samples lie at fixed places, so that the file can
/// be mapped into memory.
#[derive(Debug, Clone)]
pub struct Atlas {
    header: Header,
    samples: Vec<i16>,
    /// Index of the first walk of each case.
    cases: BTreeMap<Case, Block>,
    /// Place of a morphology among all that are in it.
    places: BTreeMap<Morphology, usize>,
    /// Place of a morphology among those with few damaged legs.
    few_places: BTreeMap<Morphology, usize>,
}

#[derive(Debug, Clone, Copy)]
struct Block {
    first_walk: usize,
    few_only: bool,
}

/// An atlas that cannot be used: which file, and why.
#[derive(Debug, Error)]
#[error("{}: {problem}", path.display())]
pub struct AtlasError {
    /// The file.
    pub path: std::path::PathBuf,
    /// What is wrong with it.
    pub problem: AtlasProblem,
}

impl AtlasError {
    /// Whether the atlas is in order but for the gait, which another one would fit.
    pub fn is_of_another_gait(&self) -> bool {
        matches!(self.problem, AtlasProblem::Stale { what: GAIT, .. })
    }
}

impl Atlas {
    /// Reads an atlas and checks that it belongs to this robot, gait, settings and
    /// program.
    ///
    /// # Errors
    /// [`AtlasError`] says what does not fit.
    pub fn open(
        path: &Path,
        robot: &Robot,
        gait: &Gait,
        settings: &IdentifySettings,
    ) -> Result<Self, AtlasError> {
        let read = || {
            let reader = AtlasReader::open(path)?;
            reader.header.check(robot, gait, settings)?;
            let atlas = Self::new(reader, robot)?;
            atlas.check_engine(robot, gait, settings)?;
            Ok(atlas)
        };
        read().map_err(|problem| AtlasError {
            path: path.into(),
            problem,
        })
    }

    /// Samples of each walk.
    pub fn walk_samples(&self) -> usize {
        self.header.walk_samples
    }

    /// What whoever reads an answer from it must know: which morphologies it lacks.
    pub fn warning(&self) -> Option<String> {
        let most = self.header.most_damaged_legs?;
        Some(format!(
            "the atlas holds morphologies with at most {most} damaged {}: no others were considered",
            if most.get() == 1 { "leg" } else { "legs" }
        ))
    }

    /// Walks in it.
    pub fn walks(&self) -> usize {
        self.samples.len() / (AXES * self.header.walk_samples)
    }

    fn new(reader: AtlasReader, robot: &Robot) -> Result<Self, AtlasProblem> {
        let header = &reader.header;
        let mut places = BTreeMap::new();
        let mut few_places = BTreeMap::new();
        for morphology in robot.layout().enumerate() {
            if header.holds(&morphology, 1) {
                few_places.insert(morphology.clone(), few_places.len());
            }
            if header.holds(&morphology, 0) {
                places.insert(morphology, places.len());
            }
        }
        let mut cases = BTreeMap::new();
        let mut walks = 0_usize;
        for case in header.cases() {
            let few_only = case.variation > 0;
            let block = Block {
                first_walk: walks,
                few_only,
            };
            cases.insert(case, block);
            walks += if few_only {
                few_places.len()
            } else {
                places.len()
            };
        }
        let count = walks.saturating_mul(AXES * header.walk_samples);
        let (header, samples) = reader.samples(count)?;
        Ok(Self {
            header,
            samples,
            cases,
            places,
            few_places,
        })
    }

    /// The samples of a walk: roll, pitch, yaw one after the other.
    fn find(&self, candidate: &Morphology, case: Case) -> Option<&[i16]> {
        let block = self.cases.get(&case)?;
        let places = if block.few_only {
            &self.few_places
        } else {
            &self.places
        };
        let length = AXES * self.header.walk_samples;
        let begin = (block.first_walk + places.get(candidate)?) * length;
        self.samples.get(begin..begin + length)
    }

    /// Simulates the first steps of one walk again: another version of the physics
    /// engine walks otherwise.
    fn check_engine(
        &self,
        robot: &Robot,
        gait: &Gait,
        settings: &IdentifySettings,
    ) -> Result<(), AtlasProblem> {
        const PROBED: usize = 40;
        let Some(&case) = self.cases.keys().next() else {
            return Err(AtlasProblem::Truncated);
        };
        let probed = Morphology::healthy(&robot.layout()).with_remaining(0, 0);
        let walks = build::simulated(robot, gait, settings, &[case.lost_links], &[0], PROBED)?;
        let Walked::Whole(now) = walks.walk(&probed, case, &mut |_| ControlFlow::Continue(()))
        else {
            return Err(AtlasProblem::OtherEngine);
        };
        let Some(then) = self.find(&probed, case) else {
            return Err(AtlasProblem::Truncated);
        };
        let length = self.header.walk_samples;
        let agrees = now
            .angles_deg()
            .as_ref()
            .into_array()
            .into_iter()
            .zip(then.chunks(length))
            .all(|(now, then)| {
                now.iter()
                    .zip(then)
                    .all(|(now, then)| (now - f32::from(*then) * SAMPLE_DEG).abs() <= SAMPLE_DEG)
            });
        if agrees {
            Ok(())
        } else {
            Err(AtlasProblem::OtherEngine)
        }
    }
}

/// Axes of a sample.
const AXES: usize = 3;
/// What stands for a walk that diverged.
const DIVERGED: i16 = i16::MIN;

impl WalkSource for Atlas {
    fn walk(&self, candidate: &Morphology, case: Case, look: &mut Look<'_>) -> Walked {
        let Some(samples) = self.find(candidate, case) else {
            return Walked::Unknown;
        };
        if samples.first() == Some(&DIVERGED) {
            return Walked::Diverged;
        }
        let mut axes = samples.chunks(self.header.walk_samples).map(|axis| {
            axis.iter()
                .map(|&x| f32::from(x) * SAMPLE_DEG)
                .collect::<Vec<f32>>()
        });
        let mut next = || axes.next().unwrap_or_default();
        let walk = ComparableWalk::from_samples(Axes {
            roll: next(),
            pitch: next(),
            yaw: next(),
        });
        // One look at the beginning saves comparing most walks as a whole.
        if look(&walk).is_break() {
            return Walked::Stopped;
        }
        Walked::Whole(walk)
    }
}

/// What lost links may have become, as the header spells it.
pub(crate) fn all_lost_links() -> [LostLinks; 2] {
    [LostLinks::Absent, LostLinks::Locked]
}

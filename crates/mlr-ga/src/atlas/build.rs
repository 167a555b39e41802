use std::{num::NonZeroUsize, ops::ControlFlow, path::Path};

use mlr_imu::NewFile;
use mlr_model::{Gait, LostLinks, ModelError, Morphology, Robot};
use rayon::prelude::*;

use super::{
    AXES, AtlasError, AtlasProblem, DIVERGED,
    file::{self, Header, SAMPLE_DEG},
};
use crate::{
    IdentifySettings, Progress, Shard,
    walks::{Case, SimulatedWalks, WalkSource, Walked},
};

/// What goes into an atlas.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AtlasPlan {
    /// Morphologies with more damaged legs are left out, which makes the atlas smaller: it
    /// knows nothing of them. `None`: every feasible morphology is in it.
    pub most_damaged_legs: Option<NonZeroUsize>,
    /// Morphologies with at most this many damaged legs are simulated under variations
    /// of the model; all that are in the atlas on the nominal one.
    pub few_legs: usize,
    /// How long each walks: the compared stretch, after a steady gait is reached and
    /// with any phase.
    pub duration_s: f64,
}

impl Default for AtlasPlan {
    fn default() -> Self {
        Self {
            most_damaged_legs: None,
            few_legs: 3,
            duration_s: 8.6,
        }
    }
}

/// Simulates all walks of the plan and writes them to a new file, which appears
/// under its name only when it is complete. Returns its size in bytes.
///
/// # Errors
/// [`AtlasError`] when there is a file of that name already, when it cannot be
/// written, or when robot, gait and settings do not fit.
pub fn build(
    path: &Path,
    robot: &Robot,
    gait: &Gait,
    settings: &IdentifySettings,
    plan: AtlasPlan,
    progress: &dyn Progress,
) -> Result<u64, AtlasError> {
    let write = || {
        // Reserved first: a file that cannot be written is reported before the work.
        let file = NewFile::reserve(path)?;
        let whole = simulate(robot, gait, settings, plan, Shard::WHOLE, progress)?;
        file.write(|file| file::write(file, file::ATLAS, &whole.header, &whole.samples))
    };
    write().map_err(|problem| AtlasError {
        path: path.into(),
        problem,
    })
}

/// What was simulated of an atlas.
pub(super) struct Simulated {
    pub(super) header: Header,
    /// Walks of the whole atlas.
    pub(super) walks: usize,
    /// Samples of the walks that were simulated, in the order that they have in the atlas.
    pub(super) samples: Vec<i16>,
}

/// Simulates one part of the walks of the plan.
pub(super) fn simulate(
    robot: &Robot,
    gait: &Gait,
    settings: &IdentifySettings,
    plan: AtlasPlan,
    shard: Shard,
    progress: &dyn Progress,
) -> Result<Simulated, AtlasProblem> {
    settings.check_on(robot).map_err(ModelError::from)?;
    let header = Header::new(robot, gait, settings, plan);
    let walk_samples = header.walk_samples;
    let layout = robot.layout();
    let [nominal, varied] = [0, 1].map(|variation| -> Vec<Morphology> {
        let is_in = |morphology: &Morphology| header.holds(morphology, variation);
        layout.enumerate().filter(is_in).collect()
    });
    let cases = header.cases();
    let walks_of = |case: &Case| match case.variation {
        0 => &nominal,
        _ => &varied,
    };
    let walks = cases.iter().map(|case| walks_of(case).len()).sum();
    progress.expect(shard.share_of(walks));
    let mut samples = Vec::new();
    let mut before = 0;
    for case in &cases {
        let of_case = walks_of(case);
        let places = (before..).zip(of_case);
        let own = places.filter(|(place, _)| shard.has(*place));
        let own: Vec<&Morphology> = own.map(|(_, morphology)| morphology).collect();
        before += of_case.len();
        let source = simulated(
            robot,
            gait,
            settings,
            &[case.lost_links],
            &[case.variation],
            walk_samples,
        )?;
        let walked: Vec<Vec<i16>> = own
            .par_iter()
            .map(|morphology| {
                let walked = source.walk(morphology, *case, &mut |_| ControlFlow::Continue(()));
                progress.advance();
                counts(&walked, walk_samples)
            })
            .collect();
        samples.extend(walked.into_iter().flatten());
    }
    Ok(Simulated {
        header,
        walks,
        samples,
    })
}

/// A walk in hundredths of a degree, saturated at the range of the type (±327°): beyond
/// it, the yaw angle does not distinguish robots.
fn counts(walked: &Walked, walk_samples: usize) -> Vec<i16> {
    let Walked::Whole(walk) = walked else {
        return vec![DIVERGED; AXES * walk_samples];
    };
    walk.angles_deg()
        .as_ref()
        .into_array()
        .into_iter()
        .flat_map(|axis| axis.iter().take(walk_samples))
        .map(|angle_deg| {
            let counts = (angle_deg / SAMPLE_DEG).round();
            counts.clamp(f32::from(-i16::MAX), f32::from(i16::MAX)) as i16
        })
        .collect()
}

/// Walks of some cases of the settings' variations. Only the cases asked for are
/// prepared; the others are unknown to it.
pub(super) fn simulated(
    robot: &Robot,
    gait: &Gait,
    settings: &IdentifySettings,
    lost_links: &[LostLinks],
    variations: &[usize],
    walk_samples: usize,
) -> Result<SimulatedWalks, AtlasProblem> {
    let wanted = lost_links.iter().flat_map(|&lost_links| {
        variations.iter().map(move |&variation| Case {
            lost_links,
            variation,
        })
    });
    Ok(SimulatedWalks::new(
        robot,
        gait,
        &settings.simulation,
        wanted,
        &settings.variations,
        walk_samples,
        &[],
    )?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::comparison::ComparableWalk;

    #[test]
    fn hundredths_of_a_degree_and_no_more_than_fits() {
        use mlr_filter::Axes;
        let walk = ComparableWalk::from_samples(Axes {
            roll: vec![0.126, -1.0],
            pitch: vec![0.0, 400.0],
            yaw: vec![-400.0, 1.0],
        });
        let counted = counts(&Walked::Whole(walk), 2);
        assert_eq!(counted, [13, -100, 0, i16::MAX, -i16::MAX, 100]);
        assert_eq!(counts(&Walked::Diverged, 1), [DIVERGED; 3]);
    }
}

//! The motion of a damaged robot that tells most about which links it has lost.

mod report;

pub use report::{DiagnosisReport, OpenMorphology};

use mlr_filter::OrientationSeries;
use mlr_model::{
    FoldTiming, FoldedWalk, Gait, JointTrajectory, LostLinks, ModelError, Morphology, Motion,
    Outcome, Record, Robot, SimulationSettings, Simulator,
};
use mlr_residual::{Progress, ln_mean};
use rayon::prelude::*;

use crate::{
    Identification, IdentifySettings, ProbeSettings,
    comparison::{AlignedMeasurement, Alignment, ComparableWalk, SpectralSettings},
    probe::{of_legs, varied},
};

/// What a log leaves open.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenQuestion {
    /// Morphologies with their probabilities, which sum to one, most probable first.
    pub morphologies: Vec<(Morphology, f64)>,
    /// What the lost links have become.
    pub lost_links: LostLinks,
}

/// A segment of the motion.
#[derive(Debug, Clone)]
pub struct DiagnosisSegment {
    /// The walk.
    pub walk: FoldedWalk,
    /// From stance to stance.
    pub duration_s: f64,
    /// Expected entropy of the morphology after it and the segments before it.
    pub entropy_nats: f64,
}

/// The motion with what is to be expected of it.
#[derive(Debug, Clone)]
pub struct DiagnosisMotion {
    /// A joint trajectory that ends; `None` where no motion that keeps the bounds tells anything.
    pub gait: Option<Gait>,
    /// What it is made of, in order.
    pub segments: Vec<DiagnosisSegment>,
    /// How many walks were looked at.
    pub candidates: usize,
    /// How many of them keep the bounds.
    pub bounded: usize,
}

/// A log whose morphology is known better than this leaves nothing to tell apart.
const SURE_NATS: f64 = 0.05;
/// Less probable morphologies are not asked about.
const LEAST_PROBABILITY: f64 = 0.01;
/// A segment must make the expected entropy less by so much.
const LEAST_GAIN_NATS: f64 = 0.01;
/// Variations of the model that each morphology is simulated under, at most.
const DRAWS: usize = 6;
/// Step cycles of a segment at full stride or growing.
const CYCLES: usize = 2;
/// Other steps of the best walks: stride, lift and period over those of the gait.
const STEPS: [[f64; 3]; 4] = [
    [0.5, 1.0, 1.0],
    [1.3, 1.0, 1.0],
    [0.5, 1.5, 1.0],
    [1.0, 1.0, 1.5],
];
/// Of so many walks.
const VARIED: usize = 2;
/// Recorded before the first step, for delays below zero.
const STAND_S: f64 = 0.2;

impl OpenQuestion {
    /// What an answer leaves open: the morphologies of at least one percent.
    pub fn of(answer: &Identification) -> Self {
        let others = answer.alternatives.iter();
        let others = others.map(|other| (other.morphology.clone(), other.probability));
        let mut morphologies: Vec<_> = others
            .filter(|(_, probability)| *probability >= LEAST_PROBABILITY)
            .collect();
        morphologies.push((answer.morphology.clone(), answer.probability.max(1e-12)));
        morphologies.sort_by(|(_, a), (_, b)| b.total_cmp(a));
        let sum: f64 = morphologies
            .iter()
            .map(|(_, probability)| probability)
            .sum();
        for (_, probability) in &mut morphologies {
            *probability /= sum;
        }
        Self {
            morphologies,
            lost_links: answer.fit.lost_links,
        }
    }

    /// Entropy of the morphology.
    pub fn entropy_nats(&self) -> f64 {
        entropy_nats(
            self.morphologies
                .iter()
                .map(|(_, probability)| *probability),
        )
    }

    /// Whether there is nothing to tell apart.
    pub fn is_sure(&self) -> bool {
        self.entropy_nats() < SURE_NATS
    }
}

fn entropy_nats(probabilities: impl Iterator<Item = f64>) -> f64 {
    let positive = probabilities.filter(|p| *p > 0.0);
    positive.map(|p| -p * p.ln()).sum()
}

/// ln L of each morphology, for each true morphology and draw.
type LnLikelihoods = Vec<Vec<f64>>;

struct Candidate {
    walk: FoldedWalk,
    duration_s: f64,
    ln_likelihoods: LnLikelihoods,
}

/// Searches walks with folded legs that keep the bounds under every morphology in question and every
/// variation of the model, and joins those that lower the expected entropy most in their time.
///
/// # Errors
/// [`ModelError`] when robot, gait and settings do not fit.
pub fn diagnosis_motion(
    question: &OpenQuestion,
    robot: &Robot,
    gait: &Gait,
    identification: &IdentifySettings,
    settings: ProbeSettings,
    progress: &dyn Progress,
) -> Result<DiagnosisMotion, ModelError> {
    settings.check()?;
    let search = Search::new(question, robot, identification, settings);
    let walks = of_legs(robot.legs().len(), settings.most_folded_legs)
        .into_iter()
        .map(|folded_legs| FoldedWalk {
            folded_legs,
            gait: gait.clone(),
            cycles: CYCLES,
        });
    let mut walks: Vec<FoldedWalk> = walks.collect();
    let mut kept = search.kept(&walks, progress)?;
    kept.sort_by(|a, b| {
        search
            .rate(a, None)
            .total_cmp(&search.rate(b, None))
            .reverse()
    });
    let leading = kept.iter().take(VARIED).map(|one| one.walk.clone());
    // Steps of the plain walk too, with which a motion begins.
    let mut leading: Vec<FoldedWalk> = leading.collect();
    if !leading.contains(&walks[0]) {
        leading.push(walks[0].clone());
    }
    let more = leading
        .iter()
        .flat_map(|walk| STEPS.map(|steps| varied(walk, steps)));
    let more: Vec<FoldedWalk> = more.collect();
    kept.extend(search.kept(&more, progress)?);
    walks.extend(more);
    let bounded = kept.len();
    let mut segments = search.greedy(kept);
    // Segments are simulated alone; what they leave of the one before may be too much.
    let gait = loop {
        if segments.is_empty() {
            break None;
        }
        let joined: Vec<FoldedWalk> = segments.iter().map(|one| one.walk.clone()).collect();
        let whole = search.joined(&joined)?;
        if search.walked(&whole)?.is_some() {
            break Some(whole);
        }
        segments.pop();
    };
    Ok(DiagnosisMotion {
        gait,
        segments,
        candidates: walks.len(),
        bounded,
    })
}

struct Search<'s> {
    question: &'s OpenQuestion,
    robot: &'s Robot,
    identification: &'s IdentifySettings,
    settings: ProbeSettings,
    /// Indices of the variations that are drawn.
    draws: Vec<usize>,
}

impl<'s> Search<'s> {
    fn new(
        question: &'s OpenQuestion,
        robot: &'s Robot,
        identification: &'s IdentifySettings,
        settings: ProbeSettings,
    ) -> Self {
        let all = identification.variations.len();
        let count = all.min(DRAWS);
        let draws = (0..count).map(|draw| draw * all / count.max(1)).collect();
        Self {
            question,
            robot,
            identification,
            settings,
            draws,
        }
    }

    fn joined(&self, walks: &[FoldedWalk]) -> Result<Gait, ModelError> {
        let joints = JointTrajectory::of_folded_walks(self.robot, walks, FoldTiming::default())?;
        Ok(Gait {
            name: "probe".into(),
            period_s: walks.first().map_or(1.0, |walk| walk.gait.period_s),
            motion: Motion::Joints(joints),
        })
    }

    /// The motion of every morphology under every draw; `None` where one of them breaks a bound.
    fn walked(&self, gait: &Gait) -> Result<Option<Vec<OrientationSeries>>, ModelError> {
        let identification = self.identification;
        let duration_s = Alignment::longest_s(gait.duration_s().unwrap_or_default()) + 0.1;
        let simulators = self.draws.iter().map(|&draw| {
            let variation = &identification.variations[draw];
            let (robot, simulation) = variation.apply(self.robot, &identification.simulation)?;
            let simulation = SimulationSettings {
                duration_s,
                stand_s: STAND_S,
                lost_links: self.question.lost_links,
                record: Record {
                    torques: true,
                    ..Record::default()
                },
                ..simulation
            };
            Simulator::new(robot, gait, simulation)
        });
        let simulators = simulators.collect::<Result<Vec<_>, _>>()?;
        let bounds = self.settings.bounds;
        let limit_nm = self.robot.servo().torque_limit_nm;
        let morphologies = &self.question.morphologies;
        let cases: Vec<_> = morphologies
            .iter()
            .flat_map(|(morphology, _)| simulators.iter().map(move |one| (morphology, one)))
            .collect();
        let walked: Option<Vec<_>> = cases
            .par_iter()
            .map(
                |(morphology, simulator)| match simulator.simulate(morphology) {
                    Outcome::Walked(walk) => {
                        let is_bounded = bounds.broken_by(&walk, limit_nm).is_none();
                        is_bounded.then_some(walk.orientation)
                    }
                    Outcome::Diverged { .. } => None,
                },
            )
            .collect();
        Ok(walked)
    }

    /// Those walks that keep the bounds.
    fn kept(
        &self,
        walks: &[FoldedWalk],
        progress: &dyn Progress,
    ) -> Result<Vec<Candidate>, ModelError> {
        progress.expect_more(walks.len());
        let mut kept = Vec::new();
        for walk in walks {
            match self.joined(std::slice::from_ref(walk)) {
                Ok(gait) => {
                    if let Some(walked) = self.walked(&gait)? {
                        let duration_s = gait.duration_s().unwrap_or_default();
                        kept.push(Candidate {
                            walk: walk.clone(),
                            duration_s,
                            ln_likelihoods: self.ln_likelihoods(&walked, &gait, duration_s),
                        });
                    }
                }
                // Out of reach, or too fast for the servos.
                Err(ModelError::Unreachable { .. } | ModelError::Setting(_)) => {}
                Err(error) => return Err(error),
            }
            progress.advance();
        }
        Ok(kept)
    }

    /// What the comparison of `identify` says of each morphology where each of the walks is recorded.
    /// The variation that a walk was simulated with is left out of all means, or the model would be
    /// taken to be right in every detail.
    fn ln_likelihoods(
        &self,
        walked: &[OrientationSeries],
        gait: &Gait,
        duration_s: f64,
    ) -> LnLikelihoods {
        let samples = (duration_s * ComparableWalk::RATE_HZ) as usize;
        let likelihood = self.identification.likelihood.of_samples(samples);
        let spectral = SpectralSettings {
            cutoff_hz: self.identification.filter.cutoff_hz,
            gait_period_s: gait.period_s,
            between_harmonics: 1.0,
        };
        let simulated: Vec<_> = walked.iter().map(ComparableWalk::new).collect();
        let usual = &self.identification.plausibility.usual;
        let draws = self.draws.len();
        let each = walked.par_iter().enumerate().map(|(truth, recording)| {
            let measured = AlignedMeasurement::new(recording, 0.0, samples, spectral);
            let motion_deg2 = measured.motion_deg2(Alignment::default());
            let ln = |other: &ComparableWalk| {
                let mut misfit = measured.misfit(other, 0, &likelihood)?;
                // What the model lacks of any real robot, as measured on the plant's.
                let squares = misfit.mean_square_deg2.iter_mut().zip(motion_deg2);
                let usual = usual.noise_deg.iter().zip(&usual.motion_share);
                for ((square_deg2, motion_deg2), (noise_deg, share)) in squares.zip(usual) {
                    *square_deg2 += noise_deg.powi(2) + share * share * motion_deg2;
                }
                Some(likelihood.ln_likelihood(&misfit))
            };
            let of_morphology = |others: &[ComparableWalk]| {
                let others = others.iter().enumerate();
                let others = others.filter(|(draw, _)| draws == 1 || *draw != truth % draws);
                let ln: Vec<f64> = others
                    .map(|(_, other)| ln(other).unwrap_or(f64::NEG_INFINITY))
                    .collect();
                ln_mean(ln.iter().copied(), ln.len())
            };
            simulated.chunks(draws).map(of_morphology).collect()
        });
        each.collect()
    }

    /// The mean entropy of the posterior over true morphologies and draws.
    fn expected_entropy_nats(&self, ln_likelihoods: &LnLikelihoods) -> f64 {
        let prior = &self.question.morphologies;
        let draws = self.draws.len();
        let truths = ln_likelihoods.iter().enumerate();
        let each = truths.map(|(truth, ln)| {
            let ln = ln.iter().zip(prior).map(|(ln, (_, prior))| ln + prior.ln());
            let ln: Vec<f64> = ln.collect();
            let most = ln.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let weights: Vec<f64> = ln.iter().map(|ln| (ln - most).exp()).collect();
            let sum: f64 = weights.iter().sum();
            prior[truth / draws].1 * entropy_nats(weights.iter().map(|weight| weight / sum))
        });
        each.sum::<f64>() / draws as f64
    }

    /// Expected entropy after a candidate, after what is known already.
    fn after_nats(&self, candidate: &Candidate, known: Option<&LnLikelihoods>) -> f64 {
        match known {
            Some(known) => self.expected_entropy_nats(&both(known, &candidate.ln_likelihoods)),
            None => self.expected_entropy_nats(&candidate.ln_likelihoods),
        }
    }

    /// Expected reduction of entropy per second.
    fn rate(&self, candidate: &Candidate, known: Option<&LnLikelihoods>) -> f64 {
        let before_nats = match known {
            Some(known) => self.expected_entropy_nats(known),
            None => self.question.entropy_nats(),
        };
        (before_nats - self.after_nats(candidate, known)) / candidate.duration_s
    }

    /// The segments that lower the expected entropy most for their time, until nothing more is gained.
    /// The first has no leg folded where such a walk keeps the bounds: a log shows when that starts.
    fn greedy(&self, mut left: Vec<Candidate>) -> Vec<DiagnosisSegment> {
        let mut chosen: Vec<DiagnosisSegment> = Vec::new();
        let mut known: Option<LnLikelihoods> = None;
        let mut time_s = 0.0;
        loop {
            left.retain(|one| time_s + one.duration_s <= self.settings.longest_s);
            let opens = |one: &Candidate| one.walk.folded_legs.is_empty();
            let opening = chosen.is_empty() && left.iter().any(opens);
            let best = (0..left.len())
                .filter(|index| !opening || opens(&left[*index]))
                .max_by(|a, b| {
                    let rate = |index: &usize| self.rate(&left[*index], known.as_ref());
                    rate(a).total_cmp(&rate(b))
                });
            let Some(best) = best else { break };
            let gain_nats = self.rate(&left[best], known.as_ref()) * left[best].duration_s;
            if !opening && gain_nats < LEAST_GAIN_NATS {
                break;
            }
            let segment = left.swap_remove(best);
            time_s += segment.duration_s;
            let entropy_nats = self.after_nats(&segment, known.as_ref());
            known = Some(match known {
                Some(known) => both(&known, &segment.ln_likelihoods),
                None => segment.ln_likelihoods,
            });
            chosen.push(DiagnosisSegment {
                walk: segment.walk,
                duration_s: segment.duration_s,
                entropy_nats,
            });
        }
        // An opening alone that tells nothing is no motion worth playing.
        let after_nats = chosen
            .last()
            .map_or(f64::INFINITY, |last| last.entropy_nats);
        match after_nats < self.question.entropy_nats() {
            true => chosen,
            false => Vec::new(),
        }
    }
}

/// What two segments of one robot and day say together, their errors taken to be independent.
fn both(one: &LnLikelihoods, other: &LnLikelihoods) -> LnLikelihoods {
    let rows = one.iter().zip(other);
    rows.map(|(one, other)| one.iter().zip(other).map(|(a, b)| a + b).collect())
        .collect()
}

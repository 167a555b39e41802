//! The motion of a damaged robot that tells most about which links it has lost, or what else is wrong
//! with it.

mod candidates;
mod earlier_walk;
mod hypothesis_model;
mod question;
mod recorded;
mod report;
mod variations;

pub use question::{OpenEffect, OpenQuestion, OpenRobot};
pub use report::DiagnosisReport;

use mlr_filter::OrientationSeries;
use mlr_model::{
    Gait, ModelError, MotionSegment, Outcome, Record, Robot, SimulationSettings, Simulator,
};
use mlr_residual::{Progress, ln_mean};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use candidates::Candidates;
use earlier_walk::EarlierWalk;
use question::{Hypothesis, entropy_nats};
use recorded::Recorded;

use crate::{
    IdentifySettings, ProbeSettings,
    comparison::{Alignment, ComparableWalk},
};

/// A segment of the motion.
#[derive(Debug, Clone)]
pub struct DiagnosisSegment {
    /// What the robot does.
    pub motion: MotionSegment,
    /// From stance to stance.
    pub duration_s: f64,
    /// Expected entropy of the hypotheses after it and the segments before it.
    pub entropy_nats: f64,
}

/// The motion with what is to be expected of it.
#[derive(Debug, Clone)]
pub struct DiagnosisMotion {
    /// A joint trajectory that ends; `None` where no motion that keeps the bounds tells anything.
    pub gait: Option<Gait>,
    /// What it is made of, in order.
    pub segments: Vec<DiagnosisSegment>,
    /// How many segments were looked at.
    pub candidates: usize,
    /// How many of them keep the bounds.
    pub bounded: usize,
}

/// A segment must make the expected entropy less by so much.
const LEAST_GAIN_NATS: f64 = 0.01;
/// Recorded before the first step, for delays below zero.
const STAND_S: f64 = 0.2;

/// ln L of each hypothesis, for each true one and draw.
type LnLikelihoods = Vec<Vec<f64>>;

struct Candidate {
    motion: MotionSegment,
    duration_s: f64,
    ln_likelihoods: LnLikelihoods,
}

/// Searches segments that keep the bounds for every robot in question, its lost links gone or
/// locked as far as that is in question, and every variation of the model: legs in doubt press on the
/// ground; where effects are in question, the robot turns on the spot, nods and marks time; where these may be of any
/// size, it also walks with one leg folded. Joins those that lower the expected entropy most in their time.
///
/// No walks with folded legs where links are in question: close to tipping they seem to tell much, and mislead
/// (`docs/probe.md`).
///
/// The motion begins with a nod of the body: a log shows when that starts.
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
    let search = Search::new(question, robot, gait, identification, settings)?;
    let candidates = Candidates { robot, gait };
    let mut tried = candidates.presses(&question.legs_in_doubt());
    if question.is_of_effects() {
        tried.extend(candidates.of_the_whole_body());
    }
    if question.is_of_any_size() {
        tried.extend(candidates.with_a_folded_leg());
    }
    let kept = search.kept(&tried, progress)?;
    let bounded = kept.len();
    let mut segments = search.greedy(kept)?;
    // Segments are simulated alone; what they leave of the one before may be too much.
    let gait = loop {
        if segments.len() < 2 {
            segments.clear();
            break None;
        }
        let joined: Vec<_> = segments.iter().map(|one| one.motion.clone()).collect();
        let whole = search.joined(&joined)?;
        if search.walked(&whole)?.is_some() {
            break Some(whole);
        }
        segments.pop();
    };
    Ok(DiagnosisMotion {
        gait,
        segments,
        candidates: tried.len(),
        bounded,
    })
}

struct Search<'s> {
    question: &'s OpenQuestion,
    hypotheses: Vec<Hypothesis<'s>>,
    /// The model of each hypothesis under each variation that is drawn; of an effect of any size, another draw under
    /// each.
    models: Vec<Vec<(Robot, SimulationSettings)>>,
    robot: &'s Robot,
    gait: &'s Gait,
    identification: &'s IdentifySettings,
    settings: ProbeSettings,
    /// How many variations are drawn.
    draws: usize,
}

impl<'s> Search<'s> {
    fn new(
        question: &'s OpenQuestion,
        robot: &'s Robot,
        gait: &'s Gait,
        identification: &'s IdentifySettings,
        settings: ProbeSettings,
    ) -> Result<Self, ModelError> {
        let mut generator = ChaCha8Rng::seed_from_u64(settings.seed);
        let variations = match (question.is_of_effects(), question.is_of_any_size()) {
            (false, _) => variations::usual(&identification.variations),
            (true, false) => variations::of_the_make(),
            (true, true) => variations::drawn(&mut generator),
        };
        let hypotheses = question.hypotheses();
        let simulation = &identification.simulation;
        // The most probable robot comes first, and is one that is known.
        let earlier = match hypotheses.first().filter(|_| question.is_of_any_size()) {
            Some(best) => EarlierWalk::new(best, robot, gait, identification, &mut generator)?,
            None => None,
        };
        let models = hypotheses.iter().map(|one| {
            let is_drawn = one.robot.effects.iter().any(OpenEffect::is_of_any_size);
            let earlier = earlier.as_ref().filter(|_| is_drawn);
            let varied = variations.iter().map(|variation| {
                if let Some(earlier) = earlier {
                    return earlier.draw(one, robot, simulation, variation, &mut generator);
                }
                let (robot, simulation) = one.model(robot, gait, simulation, &mut generator)?;
                variation.apply(&robot, &simulation)
            });
            varied.collect::<Result<Vec<_>, _>>()
        });
        Ok(Self {
            models: models.collect::<Result<_, _>>()?,
            draws: variations.len(),
            question,
            hypotheses,
            robot,
            gait,
            identification,
            settings,
        })
    }

    fn joined(&self, segments: &[MotionSegment]) -> Result<Gait, ModelError> {
        Gait::of_segments("probe", self.gait.period_s, self.robot, segments)
    }

    /// The motion of every hypothesis under every draw; `None` where one of them breaks a bound.
    fn walked(&self, gait: &Gait) -> Result<Option<Vec<OrientationSeries>>, ModelError> {
        let duration_s = Alignment::longest_s(gait.duration_s().unwrap_or_default()) + 0.1;
        let each = self.hypotheses.iter().zip(&self.models);
        let each = each.flat_map(|(one, models)| {
            models.iter().map(|(robot, simulation)| {
                let simulation = SimulationSettings {
                    duration_s,
                    stand_s: STAND_S,
                    record: Record {
                        torques: true,
                        ..Record::default()
                    },
                    ..simulation.clone()
                };
                let simulator = Simulator::new(robot.clone(), gait, simulation)?;
                Ok((&one.robot.morphology, simulator))
            })
        });
        let cases = each.collect::<Result<Vec<_>, ModelError>>()?;
        let bounds = self.settings.bounds;
        let limit_nm = self.robot.servo().torque_limit_nm;
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

    /// Those segments that keep the bounds.
    fn kept(
        &self,
        segments: &[MotionSegment],
        progress: &dyn Progress,
    ) -> Result<Vec<Candidate>, ModelError> {
        progress.expect_more(segments.len());
        let mut kept = Vec::new();
        for motion in segments {
            match self.joined(std::slice::from_ref(motion)) {
                Ok(gait) => {
                    let duration_s = gait.duration_s().unwrap_or_default();
                    // What takes too long needs no simulation.
                    if duration_s <= self.settings.longest_s
                        && let Some(walked) = self.walked(&gait)?
                    {
                        kept.push(Candidate {
                            motion: motion.clone(),
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
        let simulated: Vec<_> = walked.iter().map(ComparableWalk::new).collect();
        let draws = self.draws;
        let each = walked.par_iter().enumerate().map(|(truth, recording)| {
            let recorded = Recorded::new(recording, duration_s, gait.period_s, self.identification);
            let of_hypothesis = |others: &[ComparableWalk]| {
                let others = others.iter().enumerate();
                let others = others.filter(|(draw, _)| draws == 1 || *draw != truth % draws);
                let ln: Vec<f64> = others
                    .map(|(_, other)| recorded.ln_likelihood(other))
                    .collect();
                ln_mean(ln.iter().copied(), ln.len())
            };
            simulated.chunks(draws).map(of_hypothesis).collect()
        });
        each.collect()
    }

    /// The mean entropy of the posterior over true hypotheses and draws.
    fn expected_entropy_nats(&self, ln_likelihoods: &LnLikelihoods) -> f64 {
        let prior = &self.hypotheses;
        let draws = self.draws;
        let truths = ln_likelihoods.iter().enumerate();
        let each = truths.map(|(truth, ln)| {
            let ln = ln
                .iter()
                .zip(prior)
                .map(|(ln, one)| ln + one.probability.ln());
            let ln: Vec<f64> = ln.collect();
            let most = ln.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let weights: Vec<f64> = ln.iter().map(|ln| (ln - most).exp()).collect();
            let sum: f64 = weights.iter().sum();
            let probability = prior[truth / draws].probability;
            probability * entropy_nats(weights.iter().map(|weight| weight / sum))
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

    /// The segments that lower the expected entropy most for their time, until nothing more is gained,
    /// after a nod.
    fn greedy(&self, mut left: Vec<Candidate>) -> Result<Vec<DiagnosisSegment>, ModelError> {
        let opening = candidates::opening(self.gait);
        let nodded = self.joined(std::slice::from_ref(&opening))?;
        let mut time_s = nodded.duration_s().unwrap_or_default();
        let mut chosen = vec![DiagnosisSegment {
            motion: opening,
            duration_s: time_s,
            entropy_nats: self.question.entropy_nats(),
        }];
        let mut known: Option<LnLikelihoods> = None;
        loop {
            left.retain(|one| time_s + one.duration_s <= self.settings.longest_s);
            let rates = left.iter().map(|one| self.rate(one, known.as_ref()));
            let best = rates.enumerate().max_by(|(_, a), (_, b)| a.total_cmp(b));
            let Some((best, rate)) = best else { break };
            if rate * left[best].duration_s < LEAST_GAIN_NATS {
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
                motion: segment.motion,
                duration_s: segment.duration_s,
                entropy_nats,
            });
        }
        Ok(chosen)
    }
}

/// What two segments of one robot and day say together, their errors taken to be independent.
fn both(one: &LnLikelihoods, other: &LnLikelihoods) -> LnLikelihoods {
    let rows = one.iter().zip(other);
    rows.map(|(one, other)| one.iter().zip(other).map(|(a, b)| a + b).collect())
        .collect()
}

#[cfg(test)]
mod tests {
    use mlr_model::Morphology;
    use mlr_residual::walk::MotionBounds;

    use super::*;

    /// On few candidates: a walk on all legs hardly shows a payload; with one folded it does.
    #[test]
    fn a_payload_of_any_size_is_asked_about_with_a_leg_folded() {
        let robot = Robot::jethexa();
        let nothing_wrong = OpenQuestion {
            robots: vec![OpenRobot {
                morphology: Morphology::healthy(&robot.layout()),
                probability: 1.0,
                locked_probability: 0.0,
                effects: Vec::new(),
            }],
        };
        let settings = ProbeSettings {
            longest_s: 5.8,
            bounds: MotionBounds { tilt_deg: 20.0 },
            ..ProbeSettings::default()
        };
        let asked = |question: &OpenQuestion| {
            let identification = IdentifySettings::default();
            let gait = Gait::tripod();
            diagnosis_motion(question, &robot, &gait, &identification, settings, &()).unwrap()
        };
        let found = asked(&nothing_wrong.clone().asking(&["payload".into()]));
        let folds = |segment: &DiagnosisSegment| matches!(&segment.motion, MotionSegment::Walk(walk) if walk.folded_legs.len() == 1);
        assert!(found.segments.iter().any(folds), "{:?}", found.segments);
        let [first, .., last] = &found.segments[..] else {
            panic!("{:?}", found.segments);
        };
        assert!(last.entropy_nats < first.entropy_nats - 0.02, "{found:?}");
        // The control: where nothing else is asked about, there is nothing to tell apart.
        assert!(nothing_wrong.is_sure());
    }
}

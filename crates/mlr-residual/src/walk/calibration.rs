//! Fitting the usual differences before any effect is looked for.

use mlr_model::{ModelError, Morphology};
use serde::{Deserialize, Serialize};

use super::{
    Comparison, ErrorWeights, Placed, Poll, UsualDifferences, WalkModel, WalkRecord, Walker,
    usual::{Difference, NearbyWalks},
};

/// How models of a walk are compared with its record.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ComparisonSettings {
    /// How robots usually differ from their description.
    pub usual: UsualDifferences,
    /// What errors weigh.
    pub weights: ErrorWeights,
}

/// A model that differs from its description by what is usual, as it fits best.
#[derive(Debug)]
pub(crate) struct Calibration<'a> {
    /// The model, its effects not included.
    pub(crate) model: WalkModel,
    /// Compares with the usual differences left free around those of the model.
    pub(crate) comparison: Comparison<'a>,
}

/// How long an orientation filter may trust the gyroscope while the body shakes: some
/// ignore the accelerometer then.
const FILTER_TIMES_S: [f64; 6] = [1.0, 2.0, 4.0, 8.0, 16.0, 64.0];
/// The best of them is varied by these factors.
const FINER: [f64; 2] = [std::f64::consts::SQRT_2, 1.19];
/// Rounds after which it is taken as it is.
const MAX_ROUNDS: usize = 3;
/// Shares of a step that are tried until one helps.
const STEP_SHARES: [f64; 3] = [1.0, 0.4, 0.15];
/// Gain below which it has settled.
const SETTLED: f64 = 0.3;
/// How a rough calibration is searched, distances in standard deviations.
const POLL: Poll = Poll {
    widest: 1.0,
    narrowest: 0.25,
    least_gain: SETTLED,
    most: 6,
};

/// Where a calibration begins: a model, and what is usual in it already, in standard
/// deviations.
#[derive(Debug, Clone)]
pub(crate) struct Start {
    pub(crate) model: WalkModel,
    pub(crate) there: Vec<f64>,
}

impl Start {
    /// From the description of a robot.
    pub(crate) fn described(model: WalkModel) -> Self {
        Self {
            model,
            there: Difference::none(),
        }
    }
}

impl<'a> Calibration<'a> {
    /// Fits the usual differences of a model with `effects`; `None` when it diverges.
    ///
    /// # Errors
    /// [`ModelError`] when the model makes no sense.
    pub(crate) fn new(
        settings: &ComparisonSettings,
        start: &Start,
        effects: &[Placed],
        morphology: &Morphology,
        record: &'a WalkRecord,
    ) -> Result<Option<Self>, ModelError> {
        let calibrate = Calibrate {
            settings,
            effects,
            morphology,
            record,
        };
        let Some(mut best) = calibrate.at(start)? else {
            return Ok(None);
        };
        for _ in 0..MAX_ROUNDS {
            let sizes = best.sizes.clone();
            let mut gain = 0.0;
            for share in STEP_SHARES {
                let tried = calibrate.moved(&best, &sizes, share)?;
                if let Some(tried) = tried.filter(|tried| tried.cost < best.cost) {
                    gain = best.cost - tried.cost;
                    best = tried;
                    break;
                }
            }
            if gain < SETTLED {
                break;
            }
        }
        if best.is_rough {
            best = calibrate.polled(best)?;
        }
        let weights = settings.weights;
        Ok(Some(Self {
            comparison: Comparison::new(record, weights, best.traces, best.here.there),
            model: best.here.model,
        }))
    }

    /// The cost of a model with effects when the usual differences are fitted in a
    /// straight line: a first look. `None` when it diverges.
    ///
    /// # Errors
    /// [`ModelError`] when the model makes no sense.
    pub(crate) fn glance(
        settings: &ComparisonSettings,
        nominal: &WalkModel,
        effects: &[Placed],
        morphology: &Morphology,
        record: &'a WalkRecord,
    ) -> Result<Option<f64>, ModelError> {
        let calibrate = Calibrate {
            settings,
            effects,
            morphology,
            record,
        };
        calibrate.cost_alone(&Start::described(nominal.clone()))
    }

    /// Compares with the model as it is, the usual differences left free around it.
    ///
    /// # Errors
    /// [`ModelError`] when the model makes no sense.
    pub(crate) fn uncalibrated(
        settings: &ComparisonSettings,
        model: &WalkModel,
        morphology: &Morphology,
        record: &'a WalkRecord,
    ) -> Result<Option<Comparison<'a>>, ModelError> {
        let ComparisonSettings { usual, weights } = settings;
        let walks = NearbyWalks::new(usual, model, morphology, record)?;
        Ok(walks.map(|walks| {
            let traces = walks.traces(usual, model, record);
            Comparison::new(record, *weights, traces, Difference::none())
        }))
    }
}

struct Calibrate<'a, 'r> {
    settings: &'a ComparisonSettings,
    effects: &'a [Placed],
    morphology: &'a Morphology,
    record: &'r WalkRecord,
}

/// Where a calibration has come to.
struct Stage {
    here: Start,
    traces: Vec<super::Trace>,
    /// What the traces would still add.
    sizes: Vec<f64>,
    cost: f64,
    /// See [`Settled::is_rough()`](super::Settled::is_rough).
    is_rough: bool,
}

impl Calibrate<'_, '_> {
    fn with_effects(&self, model: &WalkModel) -> WalkModel {
        let walker = Walker {
            model,
            morphology: self.morphology,
            body: None,
        };
        walker.with(self.effects)
    }

    /// Walks a model and measures it.
    fn at(&self, start: &Start) -> Result<Option<Stage>, ModelError> {
        let usual = &self.settings.usual;
        let with_effects = self.with_effects(&start.model);
        let walks = NearbyWalks::new(usual, &with_effects, self.morphology, self.record)?;
        Ok(walks.map(|walks| self.of(start, &walks)))
    }

    /// Measures a model by its walks, with the filter time that suits it.
    fn of(&self, start: &Start, walks: &NearbyWalks) -> Stage {
        let ComparisonSettings { usual, weights } = self.settings;
        let with_effects = self.with_effects(&start.model);
        let stage = |filter_time_s: f64| {
            let mut tried = with_effects.clone();
            tried.sensing.filter_time_s = filter_time_s;
            let traces = walks.traces(usual, &tried, self.record);
            let there = start.there.clone();
            let comparison = Comparison::new(self.record, *weights, traces.clone(), there);
            let settled = comparison.settle(&walks.predicted(&tried, self.record), &[]);
            let mut here = start.clone();
            here.model.sensing.filter_time_s = filter_time_s;
            Stage {
                here,
                traces,
                is_rough: settled.is_rough(),
                cost: settled.cost,
                sizes: settled.sizes,
            }
        };
        if self.record.is_dead_reckoned() {
            return stage(f64::INFINITY);
        }
        let better = |best: Stage, other: Stage| {
            if other.cost < best.cost { other } else { best }
        };
        let [first, others @ ..] = FILTER_TIMES_S;
        let coarse = others.into_iter().map(stage).fold(stage(first), better);
        FINER.into_iter().fold(coarse, |best, factor| {
            let filter_time_s = best.here.model.sensing.filter_time_s;
            let around = [filter_time_s / factor, filter_time_s * factor];
            around.into_iter().map(stage).fold(best, better)
        })
    }

    /// Moves the model by a share of what the traces would still add.
    fn moved(&self, from: &Stage, sizes: &[f64], share: f64) -> Result<Option<Stage>, ModelError> {
        let mut moved = from.here.clone();
        for (k, difference) in Difference::ALL.into_iter().enumerate() {
            if difference.is_of_model() {
                self.step(&mut moved, k, share * sizes[k]);
            }
        }
        self.at(&moved)
    }

    /// Makes a model and its sizes differ by so much more of the usual difference `k`.
    fn step(&self, here: &mut Start, k: usize, size: f64) {
        Difference::ALL[k].apply(&self.settings.usual, size, self.record, &mut here.model);
        here.there[k] += size;
    }

    /// A model near this one that costs less, the usual differences of the body moved one by
    /// one.
    fn polled(&self, from: Stage) -> Result<Stage, ModelError> {
        let start = from.here.clone();
        let Some(cost) = self.cost_alone(&start)? else {
            return Ok(from);
        };
        let of_body = Difference::ALL.into_iter().enumerate();
        let of_body = of_body.filter(|(_, difference)| difference.is_of_body());
        let around = |here: &Start, width: f64| {
            of_body
                .clone()
                .flat_map(|(k, _)| [(k, -width), (k, width)])
                .map(|(k, size)| {
                    let mut moved = here.clone();
                    self.step(&mut moved, k, size);
                    moved
                })
                .collect()
        };
        let found = POLL.search(start, cost, around, |moved| self.cost_alone(moved))?;
        let polled = self.at(&found)?;
        Ok(polled
            .filter(|polled| polled.cost < from.cost)
            .unwrap_or(from))
    }

    /// The cost of a model when nothing of its body is left free.
    fn cost_alone(&self, start: &Start) -> Result<Option<f64>, ModelError> {
        let usual = &self.settings.usual;
        let with_effects = self.with_effects(&start.model);
        let walks = NearbyWalks::alone(usual, &with_effects, self.morphology, self.record)?;
        Ok(walks.map(|walks| self.of(start, &walks).cost))
    }
}

//! Fitting the usual differences before any effect is looked for.

use mlr_filter::SettingError;
use mlr_model::{ModelError, Morphology};
use serde::{Deserialize, Serialize};

use super::{
    Comparison, Effort, ErrorWeights, Placed, Poll, Trace, UsualDifferences, WalkModel, WalkRecord,
    Walker,
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

impl ComparisonSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        self.usual.check().map_err(|error| error.under("usual"))?;
        self.weights.check().map_err(|error| error.under("weights"))
    }
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
        effort: Effort,
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
            let Some(better) = calibrate.stepped(&best)? else {
                break;
            };
            let gain = best.cost - better.cost;
            best = better;
            if gain < SETTLED {
                break;
            }
        }
        if best.is_rough && effort == Effort::Polls {
            best = calibrate.polled(best)?;
        }
        calibrate.over_the_whole_record(best.here)
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
        let samples = record.times_s().len();
        let walks = NearbyWalks::new(usual, model, morphology, record, samples)?;
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
    /// Of the fitted stretch.
    traces: Vec<Trace>,
    /// What the traces would still add.
    sizes: Vec<f64>,
    cost: f64,
    /// See [`Settled::is_rough()`](super::Settled::is_rough).
    is_rough: bool,
}

impl<'r> Calibrate<'_, 'r> {
    fn with_effects(&self, model: &WalkModel) -> WalkModel {
        let walker = Walker {
            model,
            morphology: self.morphology,
            body: None,
        };
        walker.with(self.effects)
    }

    /// With effects, but the filter time of the model.
    fn sensed(&self, model: &WalkModel) -> WalkModel {
        let mut with_effects = self.with_effects(model);
        with_effects.sensing.filter_time_s = model.sensing.filter_time_s;
        with_effects
    }

    /// Walks the fitted stretch with a model and measures it.
    fn at(&self, start: &Start) -> Result<Option<Stage>, ModelError> {
        let walks = self.walks(&start.model, self.record.fit().end)?;
        Ok(walks.map(|walks| self.of(start, &walks)))
    }

    /// A calibration that has come to its end.
    fn over_the_whole_record(&self, here: Start) -> Result<Option<Calibration<'r>>, ModelError> {
        let ComparisonSettings { usual, weights } = self.settings;
        let walks = self.walks(&here.model, self.record.times_s().len())?;
        Ok(walks.map(|walks| {
            let traces = walks.traces(usual, &self.sensed(&here.model), self.record);
            Calibration {
                comparison: Comparison::new(self.record, *weights, traces, here.there),
                model: here.model,
            }
        }))
    }

    fn walks(&self, model: &WalkModel, samples: usize) -> Result<Option<NearbyWalks>, ModelError> {
        let with_effects = self.with_effects(model);
        let usual = &self.settings.usual;
        NearbyWalks::new(usual, &with_effects, self.morphology, self.record, samples)
    }

    /// Measures a model by its walks, with the filter time that suits it.
    fn of(&self, start: &Start, walks: &NearbyWalks) -> Stage {
        let ComparisonSettings { usual, weights } = self.settings;
        let stage = |filter_time_s: f64| {
            let mut here = start.clone();
            here.model.sensing.filter_time_s = filter_time_s;
            let model = self.sensed(&here.model);
            let traces = walks.traces(usual, &model, self.record);
            let there = start.there.clone();
            let comparison = Comparison::new(self.record, *weights, traces.clone(), there);
            let settled = comparison.settle(&walks.predicted(&model, self.record), &[]);
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

    /// Moves the model by what the traces would still add, or as much of it as helps.
    fn stepped(&self, from: &Stage) -> Result<Option<Stage>, ModelError> {
        for share in STEP_SHARES {
            let mut moved = from.here.clone();
            for (k, difference) in Difference::ALL.into_iter().enumerate() {
                if difference.is_of_model() {
                    self.step(&mut moved, k, share * from.sizes[k]);
                }
            }
            // Its own traces are walked only where those at hand promise something.
            if self.cost_by_traces_of(from, &moved)? >= from.cost {
                continue;
            }
            let tried = self.at(&moved)?;
            if let Some(tried) = tried.filter(|tried| tried.cost < from.cost) {
                return Ok(Some(tried));
            }
        }
        Ok(None)
    }

    /// The cost of a model near this stage if the usual differences leave the same traces there;
    /// infinite when it diverges.
    fn cost_by_traces_of(&self, from: &Stage, moved: &Start) -> Result<f64, ModelError> {
        let ComparisonSettings { usual, weights } = self.settings;
        let model = self.sensed(&moved.model);
        let walks = NearbyWalks::alone(usual, &model, self.morphology, self.record)?;
        Ok(walks.map_or(f64::INFINITY, |walks| {
            let (traces, there) = (from.traces.clone(), moved.there.clone());
            let comparison = Comparison::new(self.record, *weights, traces, there);
            let predicted = walks.predicted(&model, self.record);
            comparison.settle(&predicted, &[]).cost
        }))
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

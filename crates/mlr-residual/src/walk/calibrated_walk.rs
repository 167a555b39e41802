//! The walk of a robot of known morphology with its nuisance parameters fitted: what the model
//! discrepancy is learned from.

use mlr_filter::SettingError;
use mlr_model::{LostLinks, Morphology};
use nalgebra::{DVector, DVectorView};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use super::{
    EvidenceSettings, Nuisance, NuisancePrior, Observation, WalkModel, WalkRecord,
    discrepancy::Scatter,
    evidence::Fit,
    hypothesis::{Placement, Walker},
    search::base::{Base, Setting},
};
use crate::walk_effects;

/// What is known of a robot whose walk is fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownRobot<'r> {
    /// What is left of it.
    pub morphology: &'r Morphology,
    /// What became of what is not.
    pub lost_links: LostLinks,
    /// Its effects; how large they are is fitted.
    pub effects: Vec<KnownEffect>,
}

/// An effect that a robot is known to have.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownEffect {
    /// Its kind.
    pub kind: String,
    /// The leg that it is on, from 1.
    pub leg: Option<usize>,
    /// The joint or link, from 1.
    pub part: Option<usize>,
}

/// Residual and sensitivities of a walk at the most probable parameters of its robot, found about as
/// an explanation finds them.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CalibratedWalk {
    /// Time of each sample since the start of the walk; negative while the robot stands.
    pub walked_s: Vec<f64>,
    /// Time from the first sample of the record to the start of the walk.
    pub stood_s: f64,
    /// Period of the gait.
    pub period_s: f64,
    /// Root mean square of measured roll and pitch about their means.
    pub swing_deg: f64,
    /// Root mean square of measured yaw about its mean and trend.
    pub yaw_swing_deg: f64,
    /// Mean rate of turning as measured.
    pub turned_dps: f64,
    /// How far robots of one make spread in this walk, in the measure of `swing_deg`.
    pub spread_deg: f64,
    /// How far their rates of turning spread.
    pub turning_spread_dps: f64,
    /// Measured less predicted roll, pitch and yaw.
    pub residual_deg: [Vec<f64>; 3],
    /// How single walks scatter about their mean in roll, pitch and yaw: errors whose products with themselves
    /// sum to the covariance. None where no mean was taken.
    pub scatter_deg: Vec<[Vec<f64>; 3]>,
    /// How walks with compliant impacts differ from the mean of these and as many with rigid ones, where a mean was
    /// taken.
    pub impacts_deg: Option<[Vec<f64>; 3]>,
    /// The nuisance parameters, then those of effects.
    pub parameters: Vec<CalibratedParameter>,
    /// Logarithm of the evidence under the present discrepancy.
    pub ln_evidence: f64,
    /// Logarithm of the factor by which something unknown would raise it, where a mean was taken.
    pub ln_gain_of_unknown: Option<f64>,
}

/// A parameter as fitted.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CalibratedParameter {
    /// Its name.
    pub name: String,
    /// Its value in standard deviations of its prior.
    pub z_score: f64,
    /// Change of predicted roll, pitch and yaw per standard deviation.
    pub sensitivity_deg: [Vec<f64>; 3],
}

/// Whose residual it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Simulated<'g> {
    /// A walk with the most probable parameters.
    Once,
    /// The mean of walks about these, which this generator draws.
    Mean(&'g ChaCha8Rng),
}

impl CalibratedWalk {
    /// Fits the parameters of a robot; `None` when it does not walk, or the library lacks one of its effects.
    ///
    /// # Errors
    /// [`SettingError`] naming the first setting that makes no sense.
    pub fn new(
        record: &WalkRecord,
        nominal: &WalkModel,
        known: &KnownRobot<'_>,
        simulated: Simulated<'_>,
        settings: &EvidenceSettings,
    ) -> Result<Option<Self>, SettingError> {
        settings.check()?;
        let period_s = nominal.gait.period_s;
        let observation = Observation::new(record, &settings.discrepancy, period_s);
        let nuisance = NuisancePrior::new(&settings.nuisance, nominal);
        let setting = Setting {
            observation: &observation,
            nuisance: &nuisance,
            nominal,
        };
        let (morphology, lost_links) = (known.morphology, known.lost_links);
        let effects = known.effects.iter();
        let placed: Option<Vec<Placement>> =
            effects.map(|one| one.placed(nominal, morphology)).collect();
        let Some(placed) = placed else {
            return Ok(None);
        };
        let begun = Base::new(setting, morphology, lost_links, 0.0);
        let base = begun.and_then(|base| base.settled());
        let Some(base) = base else { return Ok(None) };
        let walker = base.with(placed);
        let Some(single) = fitted(&base, &walker) else {
            return Ok(None);
        };
        let (fit, of_mean) = match simulated {
            Simulated::Once => (single, None),
            Simulated::Mean(generator) => {
                let of_means = Observation::new(record, &settings.mean_discrepancy, period_s);
                let mut walks = base.mean_walks(&of_means, generator);
                let Some(fit) = walks.average_of_one(&walker, &single, &()) else {
                    return Ok(None);
                };
                let usual = walks.whitening();
                let ln_gain = fit.ln_gain_of_unknown(usual, &of_means.with_unknown(usual));
                (fit, Some((walks.scattered(), ln_gain)))
            }
        };
        let (scatter, ln_gain_of_unknown) = of_mean.unzip();
        let walk = Self::of(
            record,
            &observation,
            &base,
            &walker,
            &fit,
            scatter.flatten().as_ref(),
        );
        Ok(Some(Self {
            ln_gain_of_unknown,
            ..walk
        }))
    }

    fn of(
        record: &WalkRecord,
        observation: &Observation<'_>,
        base: &Base<'_>,
        walker: &Walker<'_>,
        fit: &Fit,
        scatter: Option<&Scatter>,
    ) -> Self {
        let by_axis = |errors: DVectorView<'_, f64>| -> [Vec<f64>; 3] {
            let n = observation.samples_of_an_axis();
            [0, 1, 2].map(|axis| errors.rows(axis * n, n).iter().copied().collect())
        };
        let nuisances = Nuisance::of(&base.morphology, record).into_iter();
        let effects = walker.hypothesis.effects.iter().flat_map(|placed| {
            let parameters = placed.effect.parameters(placed.place, walker.nominal());
            parameters
                .into_iter()
                .map(|parameter| parameter.name.into())
        });
        let names = nuisances.map(Nuisance::name).chain(effects);
        let parameters = names
            .zip(fit.walked.z.iter())
            .zip(fit.jacobian.column_iter());
        let spread = base.spread();
        let start_s = record.start_s();
        let times_s = observation.times_s();
        Self {
            walked_s: times_s.iter().map(|time_s| time_s - start_s).collect(),
            stood_s: record
                .times_s()
                .first()
                .map_or(0.0, |first_s| start_s - first_s),
            period_s: fit.walked.model.gait.period_s,
            swing_deg: record.swing_deg(),
            yaw_swing_deg: record.yaw_swing_deg(),
            turned_dps: record.turned_dps(),
            spread_deg: spread.tilt_deg,
            turning_spread_dps: spread.turning_dps,
            residual_deg: by_axis(fit.residual.column(0)),
            impacts_deg: scatter.map(|scatter| by_axis(scatter.impacts.column(0))),
            scatter_deg: scatter
                .into_iter()
                .flat_map(|scatter| scatter.walks.column_iter())
                .map(by_axis)
                .collect(),
            parameters: parameters
                .map(|((name, z_score), sensitivity)| CalibratedParameter {
                    name,
                    z_score: *z_score,
                    sensitivity_deg: by_axis(sensitivity),
                })
                .collect(),
            ln_evidence: fit.ln_evidence,
            ln_gain_of_unknown: None,
        }
    }
}

impl KnownEffect {
    /// `None` where the library lacks it, or the robot what it is on.
    fn placed(&self, model: &WalkModel, morphology: &Morphology) -> Option<Placement> {
        let effect = walk_effects::find(&self.kind)?;
        let mut places = effect.places(&model.robot, morphology).into_iter();
        let place = places.find(|place| {
            place.leg() == self.leg.unwrap_or(0) && place.link() == self.part.unwrap_or(0)
        })?;
        Some(Placement { effect, place })
    }
}

/// Steps with sensitivities of the robot without effects, then with their own, then with these taken anew.
const STEPS: [usize; 3] = [2, 5, 5];

/// The most probable single walk with the effects of `walker`, from wherever their starts lead.
fn fitted(base: &Base<'_>, walker: &Walker<'_>) -> Option<Fit> {
    let effects = &walker.hypothesis.effects;
    if effects.is_empty() {
        return Some(base.fit(walker));
    }
    let (nominal, record) = (walker.nominal(), base.setting.observation.record);
    let mut together: Vec<Vec<Vec<f64>>> = vec![Vec::new()];
    for placed in effects {
        let starts = placed.effect.starts(placed.place, nominal, record);
        let with = |known: &Vec<Vec<f64>>| -> Vec<Vec<Vec<f64>>> {
            let one_more = starts.iter().map(|start| {
                let values = known.iter().chain([start]);
                values.cloned().collect()
            });
            one_more.collect()
        };
        together = together.iter().flat_map(with).collect();
    }
    let points = together.iter().flat_map(|values| {
        [
            base.beside_reference(walker, values),
            walker.described(values),
        ]
    });
    let points: Vec<DVector<f64>> = points.collect();
    let begun = walker.likelier(points, &base.whitening)?;
    let [first, later @ ..] = STEPS;
    let fit = walker.begun(begun, &base.jacobian, &base.whitening);
    let mut fit = walker.advanced(fit.walked, fit.jacobian, &base.whitening, first);
    for steps in later {
        let jacobian = walker.jacobian(&fit.walked);
        fit = walker.advanced(fit.walked, jacobian, &base.whitening, steps);
    }
    Some(fit)
}

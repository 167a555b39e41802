//! The walk of a robot of known morphology with its nuisance parameters fitted: what the model
//! discrepancy is learned from.

use mlr_filter::SettingError;
use mlr_model::{LostLinks, Morphology};
use nalgebra::DVectorView;
use serde::Serialize;

use super::{
    EvidenceSettings, Nuisance, NuisancePrior, Observation, WalkModel, WalkRecord,
    discrepancy::Scatter,
    evidence::Fit,
    search::base::{Base, Setting},
};

/// Residual and sensitivities of a walk without effects at its most probable nuisance parameters,
/// found with the same effort as in an explanation.
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
    /// The nuisance parameters.
    pub parameters: Vec<CalibratedParameter>,
    /// Logarithm of the evidence under the present discrepancy.
    pub ln_evidence: f64,
}

/// A nuisance parameter as fitted.
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
pub enum Simulated {
    /// A walk with the most probable parameters.
    Once,
    /// The mean of walks about these.
    Mean,
}

impl CalibratedWalk {
    /// Fits the nuisance parameters; `None` when the robot does not walk.
    ///
    /// # Errors
    /// [`SettingError`] naming the first setting that makes no sense.
    pub fn new(
        record: &WalkRecord,
        nominal: &WalkModel,
        morphology: &Morphology,
        lost_links: LostLinks,
        simulated: Simulated,
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
        let base = Base::new(setting, morphology, lost_links, 0.0, None).and_then(Base::settled);
        let Some(base) = base else { return Ok(None) };
        let walker = base.with(Vec::new());
        let single = base.fit(&walker);
        let (fit, scatter) = match simulated {
            Simulated::Once => (single, None),
            Simulated::Mean => {
                let of_means = Observation::new(record, &settings.mean_discrepancy, period_s);
                let walks = base.mean_walks([(&walker, &single)], &of_means);
                let mut averaged = walks.averaged();
                let Some(fit) = averaged.fits.pop().flatten() else {
                    return Ok(None);
                };
                (fit, averaged.scatter)
            }
        };
        Ok(Some(Self::of(
            record,
            &observation,
            &base,
            &fit,
            scatter.as_ref(),
        )))
    }

    fn of(
        record: &WalkRecord,
        observation: &Observation<'_>,
        base: &Base<'_>,
        fit: &Fit,
        scatter: Option<&Scatter>,
    ) -> Self {
        let by_axis = |errors: DVectorView<'_, f64>| -> [Vec<f64>; 3] {
            let n = observation.samples_of_an_axis();
            [0, 1, 2].map(|axis| errors.rows(axis * n, n).iter().copied().collect())
        };
        let names = Nuisance::of(&base.morphology, record)
            .into_iter()
            .map(Nuisance::name);
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
        }
    }
}

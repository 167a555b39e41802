//! A robot's own parameters, from a walk in which nothing is wrong with it.

use std::collections::BTreeMap;

use mlr_model::{Calibration, Gaussian, LostLinks, Morphology, Robot, RobotParameter};
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;

use super::{
    EvidenceSettings, Nuisance, NuisancePrior, Observation, StretchErrors, WalkError, WalkModel,
    WalkRecord,
    evidence::Fit,
    hypothesis::Walker,
    mean_walk::TIMES,
    search::base::{Base, Setting},
    stretch_errors::{Corrected, residual_deg, stretch_errors},
};
use crate::{Progress, statistics::chi_square_tail};

/// What a healthy walk tells of its robot.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibratedRobot {
    /// The robot with its most probable parameters, and how surely these are known.
    pub robot: Robot,
    /// What belongs to the day of the walk, in standard deviations of its prior: friction of the
    /// ground, bias of the gyroscope, start of the walk.
    pub day: BTreeMap<String, f64>,
    /// Share of the robots of the make, or of what was known of this one, that a walk in which nothing
    /// is wrong makes look as different as this one, or more.
    pub tail_probability: f64,
    /// Errors of the robot as it was described before. Of each, the zero of yaw and the start of the
    /// walk are fitted.
    pub error_before: StretchErrors,
    /// Errors of the robot as calibrated on the first stretch, on its day.
    pub error_after: StretchErrors,
}

/// The steps of a calibration: a single walk over the first stretch, then means of walks over it and over all of the walk.
const STEPS: usize = 1 + 2 * TIMES;

/// Fits the robot's own parameters to a walk in which it lacks nothing, and what belongs to the day
/// with them. What is known of the robot already is the prior; several walks tell more one after the
/// other.
///
/// Where single walks are rough, the most probable of them have parameters that are not the robot's: the mean of walks,
/// which `generator` draws, is fitted. The first stretch of the walk is fitted for the errors on the rest; from there
/// on, the whole walk is fitted for the answer.
///
/// # Errors
/// [`WalkError`] when a setting makes no sense, or the walk cannot be simulated.
pub fn calibrate_walk(
    record: &WalkRecord,
    nominal: &WalkModel,
    settings: &EvidenceSettings,
    generator: &ChaCha8Rng,
    progress: &dyn Progress,
) -> Result<CalibratedRobot, WalkError> {
    settings.check()?;
    progress.expect_more(STEPS);
    let morphology = Morphology::healthy(&nominal.robot.layout());
    let nuisance = NuisancePrior::new(&settings.nuisance, nominal);
    let setting = |observation| Setting {
        observation,
        nuisance: &nuisance,
        nominal,
    };
    let period_s = nominal.gait.period_s;
    let [single, means] = [&settings.discrepancy, &settings.mean_discrepancy];
    let [first_stretch, mean_first_stretch] =
        [single, means].map(|of| Observation::new(record, of, period_s));
    let [whole, mean_whole] = [single, means].map(|of| Observation::of_whole(record, of, period_s));

    let base = Base::new(setting(&first_stretch), &morphology, LostLinks::Absent, 0.0)
        .and_then(|base| base.settled())
        .ok_or(WalkError::Diverged)?;
    progress.advance();
    let of_first_stretch = fit_of_mean(&base, &mean_first_stretch, generator, progress)?;
    let [error_before, error_after] = errors_before_and_after(record, &base, &of_first_stretch)?;

    let base = base.at_point(setting(&whole), of_first_stretch.walked.z);
    let base = base.ok_or(WalkError::Diverged)?;
    let fit = fit_of_mean(&base, &mean_whole, generator, progress)?;
    let walker = base.with(Vec::new());
    let posterior = Posterior::new(&walker, &fit, &nuisance, record, settings);
    let bias = settings.nuisance.engine_bias;
    Ok(CalibratedRobot {
        robot: posterior.applied_to(&nominal.robot)?,
        day: posterior.day(),
        tail_probability: tail_probability(&posterior.nuisances, &fit, bias),
        error_before,
        error_after,
    })
}

/// The robot's most probable parameters by the mean of its walks.
fn fit_of_mean(
    base: &Base<'_>,
    of_means: &Observation<'_>,
    generator: &ChaCha8Rng,
    progress: &dyn Progress,
) -> Result<Fit, WalkError> {
    let walker = base.with(Vec::new());
    let mut walks = base.mean_walks(of_means, generator);
    let fit = walks.average_of_one(&walker, &base.fit(&walker), progress);
    fit.ok_or(WalkError::Diverged)
}

/// Errors of the robot as described, and as fitted.
fn errors_before_and_after(
    record: &WalkRecord,
    base: &Base<'_>,
    fit: &Fit,
) -> Result<[StretchErrors; 2], WalkError> {
    let walker = base.with(Vec::new());
    let mut described = walker.described(&[]);
    // Time has no zero: the start of the walk is part of the comparison.
    described[0] = fit.walked.z[0];
    let samples = record.times_s().len();
    let errors = |model: &WalkModel| -> Result<StretchErrors, WalkError> {
        let walked = model.walk(&base.morphology, record, samples)?;
        let body = walked.ok_or(WalkError::Diverged)?;
        let residual_deg = residual_deg(record, &model.observe(&body, record, samples));
        Ok(stretch_errors(record, &residual_deg, Corrected::Heading).0)
    };
    Ok([
        errors(&walker.model(&described))?,
        errors(&fit.walked.model)?,
    ])
}

/// What a walk tells of the nuisance parameters, in standard deviations of the make.
struct Posterior {
    nuisances: Vec<Nuisance>,
    /// Standard deviations of the make, in the coordinates of the parameters.
    units: Vec<f64>,
    /// With these the model walks like the robot.
    effective: Gaussian,
    /// Those of the robot itself, from where the model's were before.
    physical: Gaussian,
}

impl Posterior {
    fn new(
        walker: &Walker<'_>,
        fit: &Fit,
        prior: &NuisancePrior,
        record: &WalkRecord,
        settings: &EvidenceSettings,
    ) -> Self {
        let nuisances = Nuisance::of(&walker.hypothesis.morphology, record);
        let unit = |nuisance: &Nuisance| nuisance.deviation(&settings.nuisance, record);
        let mixing = walker.mixing();
        let effective = Gaussian {
            mean: &mixing * &fit.walked.z,
            covariance: &mixing * fit.covariance() * mixing.transpose(),
        };
        // At the maximum of the posterior the slope of the likelihood is that of the prior.
        let (slope, curvature) = match mixing.clone().try_inverse() {
            Some(unmixing) => (
                unmixing.tr_mul(&fit.walked.z),
                unmixing.tr_mul(&fit.curvature) * &unmixing,
            ),
            None => (fit.walked.z.clone(), fit.curvature.clone()),
        };
        let before = prior.physical(&nuisances, record, walker.nominal());
        let left = left_by_the_engine(&nuisances, settings.nuisance.engine_bias, &curvature);
        let (slope, curvature) = (&left * slope, &left * curvature);
        let mut of_robot = effective.mean.clone();
        for (deviation, nuisance) in of_robot.iter_mut().zip(&nuisances) {
            if *nuisance == Nuisance::Damping {
                *deviation += ln_added_damping(&fit.walked.model) / unit(nuisance);
            }
        }
        Self {
            physical: updated(&before, &of_robot, &slope, &curvature),
            units: nuisances.iter().map(unit).collect(),
            nuisances,
            effective,
        }
    }

    /// What belongs to the day, in standard deviations of the make.
    fn day(&self) -> BTreeMap<String, f64> {
        let each = self.nuisances.iter().zip(self.effective.mean.iter());
        each.filter(|(nuisance, _)| nuisance.parameter().is_none())
            .map(|(nuisance, deviation)| (nuisance.name(), *deviation))
            .collect()
    }

    /// The robot with its own parameters.
    fn applied_to(&self, nominal: &Robot) -> Result<Robot, WalkError> {
        let each = self.nuisances.iter().enumerate();
        let own: Vec<(usize, RobotParameter)> = each
            .filter_map(|(k, nuisance)| Some((k, nuisance.parameter()?)))
            .collect();
        let mut robot = nominal.clone();
        for (k, parameter) in &own {
            robot = robot.with_added(*parameter, self.effective.mean[*k] * self.units[*k]);
        }
        let covariance = |of: &Gaussian| {
            DMatrix::from_fn(own.len(), own.len(), |i, j| {
                let (i, j) = (own[i].0, own[j].0);
                let mean = f64::midpoint(of.covariance[(i, j)], of.covariance[(j, i)]);
                mean * self.units[i] * self.units[j]
            })
        };
        let physical = own.iter().map(|(k, parameter)| {
            parameter.coordinate(nominal) + self.physical.mean[*k] * self.units[*k]
        });
        let physical = Gaussian {
            mean: DVector::from_iterator(own.len(), physical),
            covariance: covariance(&self.physical),
        };
        let parameters = own.iter().map(|(_, parameter)| *parameter).collect();
        let covariance = covariance(&self.effective);
        let calibration = Calibration::new(&robot, parameters, covariance, physical)?;
        Ok(robot.with_calibration(calibration))
    }
}

/// By how much, in the logarithm, servos damp more in steps of the simulation than their description says.
fn ln_added_damping(model: &WalkModel) -> f64 {
    let time_step_s = model.simulation.time_step_s;
    let in_steps = model.servo.damping_in_steps_nm_s_per_rad(time_step_s);
    (in_steps / model.servo.damping_nm_s_per_rad).ln()
}

/// Least share of the prior's variance that a walk must have taken from a combination of parameters
/// for its most probable value to say how usual the robot is.
const TOLD: f64 = 0.1;

/// Share of robots whose most probable coordinates are as far from those described, or farther. The
/// covariance of these among robots is what the posterior has left of the prior's, E = I - S, where nothing
/// else is wrong; and the engine adds its bias.
fn tail_probability(nuisances: &[Nuisance], fit: &Fit, engine_bias: f64) -> f64 {
    let z = &fit.walked.z;
    let told = (DMatrix::identity(z.len(), z.len()) - fit.covariance()).symmetric_eigen();
    let is_told = |k: &usize| told.eigenvalues[*k] > TOLD;
    let directions: Vec<usize> = (0..z.len()).filter(is_told).collect();
    let taken = DMatrix::from_diagonal(&told.eigenvalues.select_rows(&directions));
    let directions = told.eigenvectors.select_columns(&directions);
    let mut biased = &directions * &taken;
    for (mut row, nuisance) in biased.row_iter_mut().zip(nuisances) {
        row *= nuisance.engine_bias(engine_bias);
    }
    let covariance = taken + biased.tr_mul(&biased);
    let found = directions.tr_mul(z);
    let count = found.len();
    match covariance.cholesky() {
        Some(factors) => chi_square_tail(found.dot(&factors.solve(&found)), count),
        None => 1.0,
    }
}

/// What slope and curvature of a likelihood, in standard deviations of the make, are multiplied with
/// because an engine walks like the robot with a body that is off by `engine_bias`: a measurement of
/// precision Λ whose error has the covariance B besides has the precision (I + Λ B)⁻¹ Λ.
pub(super) fn left_by_the_engine(
    nuisances: &[Nuisance],
    engine_bias: f64,
    curvature: &DMatrix<f64>,
) -> DMatrix<f64> {
    let bias = nuisances.iter().map(|one| one.engine_bias(engine_bias));
    let bias = DMatrix::from_diagonal(&DVector::from_iterator(nuisances.len(), bias));
    let n = nuisances.len();
    let identity = DMatrix::identity(n, n);
    let symmetric = &identity + &bias * curvature * &bias;
    match symmetric.cholesky() {
        // Woodbury: a symmetric matrix to invert.
        Some(factors) => identity - curvature * &bias * factors.inverse() * bias,
        None => identity,
    }
}

/// A normal distribution after a likelihood whose logarithm has this slope and curvature at a point.
pub(super) fn updated(
    before: &Gaussian,
    at: &DVector<f64>,
    slope: &DVector<f64>,
    curvature: &DMatrix<f64>,
) -> Gaussian {
    let n = before.mean.len();
    let Some(factors) = before.covariance.clone().cholesky() else {
        return before.clone();
    };
    // In coordinates in which the distribution before is standard normal.
    let l = factors.unpack();
    let precision = DMatrix::identity(n, n) + l.tr_mul(curvature) * &l;
    let rhs = l.tr_mul(&(slope + curvature * (at - &before.mean)));
    match precision.cholesky() {
        None => before.clone(),
        Some(factors) => Gaussian {
            mean: &before.mean + &l * factors.solve(&rhs),
            covariance: &l * factors.inverse() * l.transpose(),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_engine_that_errs_leaves_less_to_learn_of_a_body_and_all_of_a_sensor() {
        let nuisances = [
            Nuisance::Stiffness,
            Nuisance::Damping,
            Nuisance::Misalignment(0),
        ];
        let h = DMatrix::from_row_slice(3, 3, &[5.0, 1.0, 0.5, 0.0, 3.0, 1.0, 0.0, 0.0, 4.0]);
        let curvature = h.tr_mul(&h);
        let told = |bias: f64| left_by_the_engine(&nuisances, bias, &curvature) * &curvature;
        assert!((told(0.0) - &curvature).amax() < 1e-12);
        // Variances add: of the measurement, and of the engine's body.
        let mut variance = curvature.clone().try_inverse().unwrap();
        for k in 0..2 {
            variance[(k, k)] += 1.2 * 1.2;
        }
        let expected = variance.try_inverse().unwrap();
        assert!((told(1.2) - &expected).amax() < 1e-9);
        let alone = &curvature;
        assert!(expected[(0, 0)] < 1.0 / 1.44 && alone[(0, 0)] > 20.0);
        assert!(expected[(2, 2)] > 10.0);
    }

    /// A measurement of two numbers, of which one is known well before, by their sum.
    #[test]
    fn a_likelihood_updates_a_normal_distribution_as_a_measurement_does() {
        let before = Gaussian {
            mean: DVector::from_vec(vec![1.0, -1.0]),
            covariance: DMatrix::from_row_slice(2, 2, &[0.01, 0.0, 0.0, 4.0]),
        };
        let (measured, variance) = (3.0, 0.25);
        let h = DVector::from_vec(vec![1.0, 1.0]);
        let curvature = &h * h.transpose() / variance;
        // Wherever it is linearised.
        for at in [DVector::zeros(2), DVector::from_vec(vec![5.0, 2.0])] {
            let slope = &h * (measured - h.dot(&at)) / variance;
            let after = updated(&before, &at, &slope, &curvature);
            // Kalman's equations.
            let innovation = measured - h.dot(&before.mean);
            let gain = &before.covariance * &h
                / ((h.transpose() * &before.covariance * &h)[(0, 0)] + variance);
            let mean = &before.mean + &gain * innovation;
            let covariance = &before.covariance - &gain * h.transpose() * &before.covariance;
            assert!((after.mean - mean).amax() < 1e-9);
            assert!((after.covariance - covariance).amax() < 1e-9);
        }
    }
}

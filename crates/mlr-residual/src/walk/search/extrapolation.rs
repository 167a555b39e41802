//! Walks extrapolated from those that were simulated.

use nalgebra::{DMatrix, DVector};

use super::screening::Start;
use crate::walk::{
    evidence::Fit,
    hypothesis::{Walked, Walker},
    linear_model::LinearModel,
    observation::{GROUPS, Whitening},
};

/// Standard deviation of the error of an extrapolated walk, of the change by which it was extrapolated, both
/// in standard deviations of the walk's errors.
///
/// Of 192 hypotheses of three logs, what simulated walks left beside the extrapolated ones had a mean square of
/// 0.15 and 0.63² to 0.86² of that of the change, whatever its size.
const RELATIVE_ERROR: f64 = 0.7;

/// A fit, whitened: what hypotheses with more effects on the same robot are extrapolated from.
#[derive(Debug, Clone)]
pub(crate) struct Simulated {
    coordinates: DVector<f64>,
    residual: DVector<f64>,
    jacobian: DMatrix<f64>,
}

/// How a hypothesis walks by what is known of a walk that was simulated.
#[derive(Debug, Clone)]
pub(crate) struct Extrapolation<'s> {
    pub(crate) model: LinearModel,
    /// Whitened residual of the walk that was simulated.
    simulated: &'s DVector<f64>,
}

impl Simulated {
    pub(crate) fn new(fit: &Fit, whitening: &Whitening) -> Self {
        Self {
            coordinates: fit.walked.z.clone(),
            residual: whitening.apply_to(&fit.residual),
            jacobian: whitening.apply(&fit.jacobian),
        }
    }

    /// A single walk, and sensitivities that are assumed of it, whitened.
    pub(crate) fn of(walked: &Walked, slopes: DMatrix<f64>, whitening: &Whitening) -> Self {
        Self {
            coordinates: walked.z.clone(),
            residual: whitening.apply_to(&walked.residual),
            jacobian: slopes,
        }
    }

    /// The linear model of the hypothesis of `walker`, which has what `starts` add to the walk besides: they were
    /// screened on the robot of this fit, with the same whitening.
    /// Their effects stay near the starts where they are `held`.
    pub(crate) fn with(
        &self,
        starts: &[&Start],
        walker: &Walker<'_>,
        held: bool,
    ) -> Extrapolation<'_> {
        let p = self.jacobian.ncols();
        let added: usize = starts.iter().map(|start| start.jacobian.ncols()).sum();
        let mut coordinates = self.coordinates.clone().insert_rows(p, added, 0.0);
        let mut jacobian = self.jacobian.clone().insert_columns(p, added, 0.0);
        let mut residual = self.residual.clone();
        let mut next = p;
        for start in starts {
            let count = start.jacobian.ncols();
            residual -= &start.change;
            coordinates
                .rows_mut(next, count)
                .copy_from(&start.coordinates);
            jacobian.columns_mut(next, count).copy_from(&start.jacobian);
            next += count;
        }
        walker.clamp(&mut coordinates);
        let model = LinearModel {
            residual,
            coordinates,
            jacobian: walker.without_replaced(jacobian),
            held: if held { added } else { 0 },
        };
        Extrapolation {
            model,
            simulated: &self.residual,
        }
    }
}

impl Extrapolation<'_> {
    /// Logarithm of the evidence, and the most probable coordinates.
    ///
    /// What is extrapolated farther errs more, and convicts less: else effects that change a walk much, and
    /// not linearly, would never be simulated.
    pub(crate) fn ln_evidence(&self, whitening: &Whitening) -> (f64, DVector<f64>) {
        self.model.ln_evidence_of_rough(whitening, |step| {
            self.rougher_by(&self.model.residual_after(step), whitening)
        })
    }

    /// So many times the usual variance, group by group, have errors of a walk that leaves this, its
    /// extrapolation included.
    fn rougher_by(&self, left: &DVector<f64>, whitening: &Whitening) -> [f64; GROUPS] {
        let change = self.simulated - left;
        whitening.groups(change.len()).map(|rows| {
            let count = rows.len().max(1) as f64;
            let mean_square = change.rows_range(rows).norm_squared() / count;
            1.0 + RELATIVE_ERROR.powi(2) * mean_square
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::walk::{
        Discrepancy,
        observation::tests::{rows, whitening},
    };

    /// Logarithm of the evidence of an extrapolation by so much that leaves so much, in standard deviations of
    /// the errors; and of the same as if the walk had been simulated.
    fn extrapolated(by: f64, left: f64) -> [f64; 2] {
        let whitening = whitening(&Discrepancy::default());
        let of_size =
            |size: f64| DVector::from_fn(rows(), |row, _| if row % 2 == 0 { size } else { -size });
        let model = LinearModel {
            residual: of_size(left),
            coordinates: DVector::zeros(1),
            jacobian: DMatrix::zeros(rows(), 1),
            held: 0,
        };
        let simulated = model.ln_evidence(&whitening).0;
        let extrapolation = Extrapolation {
            simulated: &of_size(left + by),
            model,
        };
        [extrapolation.ln_evidence(&whitening).0, simulated]
    }

    #[test]
    fn what_is_not_extrapolated_is_weighed_as_if_it_were_simulated() {
        let [extrapolated, simulated] = extrapolated(0.0, 1.3);
        assert!((extrapolated - simulated).abs() < 1e-9);
    }

    #[test]
    fn an_extrapolation_is_less_sure_the_farther_it_goes() {
        // That it fits counts for less, and so does that it does not.
        let gain = |by: f64| extrapolated(by, 0.5)[0] - extrapolated(by, 4.0)[0];
        let gains = [0.0, 1.0, 3.0, 10.0].map(gain);
        assert!(gains.is_sorted_by(|near, far| near > far), "{gains:?}");
        assert!(gains[3] < 0.5 * gains[0], "{gains:?}");
        let [far, simulated] = extrapolated(10.0, 0.5);
        assert!(far < simulated - 1.0, "{far} {simulated}");
    }
}

//! Walks extrapolated from those that were simulated.

use nalgebra::DVector;

use crate::walk::{
    evidence::LinearModel,
    observation::{GROUPS, Whitening},
};

/// Standard deviation of the error of an extrapolated walk, of the change by which it was extrapolated, both
/// in standard deviations of the walk's errors.
///
/// Of 192 hypotheses of three logs, what simulated walks left beside the extrapolated ones had a mean square of
/// 0.15 and 0.63² to 0.86² of that of the change, whatever its size.
const RELATIVE_ERROR: f64 = 0.7;

/// How a hypothesis walks by what is known of a walk that was simulated.
#[derive(Debug, Clone)]
pub(crate) struct Extrapolation {
    pub(crate) model: LinearModel,
    /// Whitened residual of the walk that was simulated.
    pub(crate) simulated: DVector<f64>,
}

impl Extrapolation {
    /// Logarithm of the evidence, and the most probable coordinates.
    ///
    /// What is extrapolated farther errs more, and convicts less: else effects that change a walk much, and
    /// not linearly, would never be simulated.
    pub(crate) fn ln_evidence(&self, whitening: &Whitening) -> (f64, DVector<f64>) {
        self.model
            .ln_evidence_of_rough(whitening, |left| self.rougher_by(left, whitening))
    }

    /// So many times the usual variance, group by group, have errors of a walk that leaves this, its
    /// extrapolation included.
    fn rougher_by(&self, left: &DVector<f64>, whitening: &Whitening) -> [f64; GROUPS] {
        let change = &self.simulated - left;
        whitening.groups(change.len()).map(|rows| {
            let count = rows.len().max(1) as f64;
            let mean_square = change.rows_range(rows).norm_squared() / count;
            1.0 + RELATIVE_ERROR.powi(2) * mean_square
        })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;
    use crate::walk::{
        Discrepancy, Observation,
        discrepancy::{Compared, Spread},
        record::tests::walking_record,
    };

    const SPREAD: Spread = Spread {
        tilt_deg: 0.3,
        turning_dps: 0.5,
    };

    /// Logarithm of the evidence of an extrapolation by so much that leaves so much, in standard deviations of
    /// the errors; and of the same as if the walk had been simulated.
    fn extrapolated(by: f64, left: f64) -> [f64; 2] {
        let record = walking_record();
        let discrepancy = Discrepancy::default();
        let observation = Observation::new(&record, &discrepancy, 1.0);
        let whitening = observation.whitening(SPREAD, Compared::Walk).unwrap();
        let rows = observation.len();
        let of_size =
            |size: f64| DVector::from_fn(rows, |row, _| if row % 2 == 0 { size } else { -size });
        let model = LinearModel {
            residual: of_size(left),
            coordinates: DVector::zeros(1),
            jacobian: DMatrix::zeros(rows, 1),
            held: 0,
        };
        let simulated = model.ln_evidence(&whitening).0;
        let extrapolation = Extrapolation {
            simulated: of_size(left + by),
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

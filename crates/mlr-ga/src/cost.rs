//! The cost F of the paper.

use mlr_filter::Conditioned;

/// F of Eq. (GA:fitness): the absolute errors of roll, pitch and yaw, summed
/// over the samples of the common time vector, in radians.
///
/// # Panics
/// When the two signals differ in length.
pub fn orientation_error_rad(measured: &Conditioned, simulated: &Conditioned) -> f64 {
    let axis = |measured: &[f64], simulated: &[f64]| -> f64 {
        assert_eq!(
            measured.len(),
            simulated.len(),
            "signals are compared on one common time vector"
        );
        measured
            .iter()
            .zip(simulated)
            .map(|(m, s)| (m - s).abs())
            .sum()
    };
    axis(&measured.roll, &simulated.roll)
        + axis(&measured.pitch, &simulated.pitch)
        + axis(&measured.yaw, &simulated.yaw)
}

/// F per sample and axis, in degrees: comparable between windows and rates.
pub fn mean_error_deg(cost_rad: f64, samples: usize) -> f64 {
    (cost_rad / (3 * samples) as f64).to_degrees()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn signal() -> impl Strategy<Value = Conditioned> {
        let axis = || prop::collection::vec(-1.0..1.0_f64, 20);
        (axis(), axis(), axis()).prop_map(|(roll, pitch, yaw)| Conditioned { roll, pitch, yaw })
    }

    proptest! {
        #[test]
        fn a_metric(a in signal(), b in signal(), c in signal()) {
            prop_assert_eq!(orientation_error_rad(&a, &a), 0.0);
            let (ab, ba) = (orientation_error_rad(&a, &b), orientation_error_rad(&b, &a));
            prop_assert_eq!(ab, ba);
            let (bc, ac) = (orientation_error_rad(&b, &c), orientation_error_rad(&a, &c));
            prop_assert!(ac <= ab + bc + 1e-12);
        }
    }

    #[test]
    fn one_degree_everywhere_is_a_mean_error_of_one_degree() {
        let constant = |angle_deg: f64| Conditioned::from_fn(|_| vec![angle_deg.to_radians(); 50]);
        let cost = orientation_error_rad(&constant(1.0), &constant(2.0));
        assert!((mean_error_deg(cost, 50) - 1.0).abs() < 1e-12);
    }
}

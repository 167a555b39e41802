//! Parameters, their bounds and where fits start.

use super::*;
use crate::Prior;

#[test]
fn every_parameter_has_a_proper_prior_whose_mean_is_possible() {
    let model = described();
    for (effect, place) in everywhere() {
        let parameters = effect.parameters(place, &model);
        assert!(!parameters.is_empty(), "{}", effect.kind());
        for parameter in parameters {
            let what = format!("{} {place:?} {}", effect.kind(), parameter.name);
            let Prior::Normal { mean, deviation } = parameter.prior;
            assert!(deviation > 0.0 && deviation.is_finite(), "{what}");
            let possible = parameter.lower..=parameter.upper;
            assert!(possible.contains(&mean), "{what}");
            assert!(
                parameter
                    .neutral
                    .is_none_or(|value| possible.contains(&value)),
                "{what}"
            );
            // Bounds are there for what makes no sense, and do not replace the prior.
            let truncation = parameter.ln_truncation();
            assert!((0.0..0.15).contains(&truncation), "{what}: {truncation}");
        }
    }
}

#[test]
fn fits_start_within_the_bounds_with_a_value_for_each_parameter() {
    let (model, walks) = (described(), Walks::lasting(3.0));
    for (effect, place) in everywhere() {
        let parameters = effect.parameters(place, &model);
        let starts = effect.starts(place, &model, &walks.record);
        assert!(!starts.is_empty(), "{}", effect.kind());
        for values in starts {
            assert_eq!(values.len(), parameters.len(), "{}", effect.kind());
            for (parameter, value) in parameters.iter().zip(values) {
                let possible = parameter.lower..=parameter.upper;
                assert!(
                    possible.contains(&value),
                    "{} {}",
                    effect.kind(),
                    parameter.name
                );
            }
        }
    }
}

/// A line through two starts leads to what lies between them, and one through a start and the value where an effect is
/// absent to what is small.
#[test]
fn an_effect_that_no_value_makes_absent_starts_where_its_prior_is_highest() {
    let (model, walks) = (described(), Walks::lasting(3.0));
    for (effect, place) in everywhere() {
        let parameters = effect.parameters(place, &model);
        let [parameter] = &parameters[..] else {
            continue;
        };
        let Prior::Normal { mean, .. } = parameter.prior;
        if parameter.neutral.is_none() {
            let starts = effect.starts(place, &model, &walks.record);
            assert!(starts.contains(&vec![mean]), "{} {place:?}", effect.kind());
        }
    }
}

#[test]
fn kinds_are_told_apart_by_their_names() {
    let mut kinds: Vec<&str> = LIBRARY.iter().map(|effect| effect.kind()).collect();
    kinds.sort_unstable();
    kinds.dedup();
    assert_eq!(kinds.len(), LIBRARY.len());
    assert!(find("no_effect").is_none());
}

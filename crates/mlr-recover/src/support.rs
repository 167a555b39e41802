//! Whether a body stands on its feet.

/// A point on the ground, or a direction along it: x forward, y left, body frame.
pub(crate) type Ground = [f64; 2];

/// How far the centre of mass is inside the convex hull of the feet that stand, all seen from above:
/// the distance to the nearest edge, negative outside. The static stability margin of McGhee and
/// Frank (1968).
pub fn margin_m(feet_m: &[Ground], center_m: Ground) -> f64 {
    let mut margin_m = f64::INFINITY;
    for (index, from) in feet_m.iter().enumerate() {
        for (other, to) in feet_m.iter().enumerate() {
            let [along_x, along_y] = [to[0] - from[0], to[1] - from[1]];
            let length_m = libm::hypot(along_x, along_y);
            if index == other || length_m < SAME_M {
                continue;
            }
            let left_m = |point: &Ground| {
                (along_x * (point[1] - from[1]) - along_y * (point[0] - from[0])) / length_m
            };
            // An edge of the hull has every foot on its left.
            if feet_m.iter().all(|foot| left_m(foot) > -SAME_M) {
                margin_m = margin_m.min(left_m(&center_m));
            }
        }
    }
    if margin_m.is_finite() {
        return margin_m;
    }
    // No two feet apart.
    match feet_m.first() {
        Some(foot) => -libm::hypot(center_m[0] - foot[0], center_m[1] - foot[1]),
        None => f64::NEG_INFINITY,
    }
}

/// Feet that are closer stand at the same place.
const SAME_M: f64 = 1e-9;

/// The distance between two straight lines from one point to another.
pub(crate) fn distance_m(one: [Ground; 2], other: [Ground; 2]) -> f64 {
    let side = |[from, to]: [Ground; 2], point: Ground| {
        (to[0] - from[0]) * (point[1] - from[1]) - (to[1] - from[1]) * (point[0] - from[0])
    };
    let crosses = side(one, other[0]) * side(one, other[1]) < 0.0
        && side(other, one[0]) * side(other, one[1]) < 0.0;
    if crosses {
        return 0.0;
    }
    let ends = [
        to_segment_m(one, other[0]),
        to_segment_m(one, other[1]),
        to_segment_m(other, one[0]),
        to_segment_m(other, one[1]),
    ];
    ends.into_iter().fold(f64::INFINITY, f64::min)
}

fn to_segment_m([from, to]: [Ground; 2], point: Ground) -> f64 {
    let [x, y] = [to[0] - from[0], to[1] - from[1]];
    let squared = (x * x + y * y).max(f64::MIN_POSITIVE);
    let share = ((point[0] - from[0]) * x + (point[1] - from[1]) * y) / squared;
    let share = share.clamp(0.0, 1.0);
    libm::hypot(
        point[0] - from[0] - share * x,
        point[1] - from[1] - share * y,
    )
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_margin_is_the_distance_to_the_nearest_edge() {
        let square = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
        for (center, expected) in [
            ([0.0, 0.0], 1.0),
            ([0.7, 0.0], 0.3),
            ([0.0, -0.9], 0.1),
            ([1.5, 0.0], -0.5),
        ] {
            assert!((margin_m(&square, center) - expected).abs() < 1e-12);
        }
        // A foot inside changes nothing; one foot less halves the square.
        let with_inner = [&square[..], &[[0.2, 0.1]]].concat();
        assert_eq!(
            margin_m(&with_inner, [0.7, 0.0]),
            margin_m(&square, [0.7, 0.0])
        );
        assert!(margin_m(&square[..3], [0.0, 0.0]).abs() < 1e-12);
    }

    #[test]
    fn nothing_stands_on_two_feet_or_fewer() {
        let line = [[1.0, 0.0], [-1.0, 0.0]];
        assert!((margin_m(&line, [0.0, 0.3]) + 0.3).abs() < 1e-12);
        assert!((margin_m(&line[..1], [1.0, 0.5]) + 0.5).abs() < 1e-12);
        assert_eq!(margin_m(&[], [0.0, 0.0]), f64::NEG_INFINITY);
    }

    #[test]
    fn lines_that_cross_touch() {
        let cross = |other| distance_m([[0.0, 0.0], [2.0, 0.0]], other);
        assert_eq!(cross([[1.0, -1.0], [1.0, 1.0]]), 0.0);
        assert!((cross([[1.0, 0.5], [1.0, 1.0]]) - 0.5).abs() < 1e-12);
        assert!((cross([[3.0, 0.0], [4.0, 0.0]]) - 1.0).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn the_margin_does_not_depend_on_order_or_place(
            feet in prop::collection::vec([-0.2..0.2_f64, -0.2..0.2_f64], 3..7),
            center in [-0.2..0.2_f64, -0.2..0.2_f64],
            moved in [-1.0..1.0_f64, -1.0..1.0_f64],
        ) {
            let margin = margin_m(&feet, center);
            let mut reversed = feet.clone();
            reversed.reverse();
            prop_assert!((margin_m(&reversed, center) - margin).abs() < 1e-9);
            let elsewhere = |[x, y]: Ground| [x + moved[0], y + moved[1]];
            let feet: Vec<Ground> = feet.into_iter().map(elsewhere).collect();
            prop_assert!((margin_m(&feet, elsewhere(center)) - margin).abs() < 1e-9);
        }

        #[test]
        fn another_foot_never_lessens_the_margin_of_a_body_that_stands(
            feet in prop::collection::vec([-0.2..0.2_f64, -0.2..0.2_f64], 3..6),
            more in [-0.2..0.2_f64, -0.2..0.2_f64],
        ) {
            let before = margin_m(&feet, [0.0, 0.0]);
            prop_assume!(before > 0.0);
            let with_more = [&feet[..], &[more]].concat();
            prop_assert!(margin_m(&with_more, [0.0, 0.0]) >= before - 1e-9);
        }
    }
}

/// Points of a curve as far as a picture shows them: of those that fall into one of so many columns
/// of equal width, the first, the lowest, the highest and the last.
pub fn thinned(points: impl IntoIterator<Item = (f64, f64)>, columns: usize) -> Vec<(f64, f64)> {
    let points: Vec<(f64, f64)> = points.into_iter().collect();
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return points;
    };
    if points.len() <= 2 * columns {
        return points;
    }
    let [from, width] = [first.0, (last.0 - first.0) / columns as f64];
    let column = |point: &(f64, f64)| ((point.0 - from) / width).floor();
    let mut kept = Vec::with_capacity(4 * columns);
    for of_column in points.chunk_by(|a, b| column(a) == column(b)) {
        let by_height = |a: &usize, b: &usize| of_column[*a].1.total_cmp(&of_column[*b].1);
        let all = || 0..of_column.len();
        let mut indices = [
            0,
            all().min_by(by_height).unwrap_or(0),
            all().max_by(by_height).unwrap_or(0),
            of_column.len() - 1,
        ];
        indices.sort_unstable();
        let mut before = None;
        for index in indices {
            if before != Some(index) {
                kept.push(of_column[index]);
            }
            before = Some(index);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peaks_ends_and_order_stay() {
        let signal = (0..10_000).map(|i| {
            let t = f64::from(i) / 1000.0;
            (t, if i == 4321 { 9.0 } else { t.sin() })
        });
        let kept = thinned(signal.clone(), 200);
        assert!(kept.len() <= 4 * 201, "{}", kept.len());
        assert_eq!(kept.first(), Some(&(0.0, 0.0)));
        assert_eq!(kept.last(), signal.clone().next_back().as_ref());
        assert!(kept.contains(&(4.321, 9.0)));
        assert!(kept.windows(2).all(|pair| pair[0].0 < pair[1].0));
    }

    #[test]
    fn few_points_stay_as_they_are() {
        let few = vec![(0.0, 1.0), (1.0, -1.0)];
        assert_eq!(thinned(few.clone(), 1), few);
        assert!(thinned([], 10).is_empty());
    }
}

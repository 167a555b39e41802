use super::{COLUMNS, SIZE};
use crate::{Curve, Figure, Ink, Mark, Panel, thinned};

/// More generations than this have no dots.
const MOST_DOTS: usize = 100;

/// The best cost so far, generation by generation of the genetic algorithm, where there was one; `None`
/// of a search that has none.
pub fn course(name: &str, cost_deg: &[Option<f64>]) -> Option<Figure> {
    let generations = (0u32..).map(f64::from).zip(cost_deg);
    let points = generations.filter_map(|(generation, cost)| Some((generation, (*cost)?)));
    let points: Vec<(f64, f64)> = points.collect();
    if points.is_empty() {
        return None;
    }
    let mut curves = vec![Curve::line(
        "",
        Ink::Measured,
        thinned(points.iter().copied(), COLUMNS),
    )];
    if points.len() <= MOST_DOTS {
        curves.push(Curve::line("", Ink::Measured, points).marked(Mark::Dots));
    }
    Some(Figure {
        name: name.into(),
        title: "Best cost so far in each generation".into(),
        description:
            "The best cost that the genetic algorithm had found, generation by generation.".into(),
        is_headed: false,
        x_label: "generation".into(),
        x_shows: vec![0.0],
        panels: vec![Panel::new("best cost [°]", curves)],
        size: [SIZE[0], 230],
    })
}

use super::SIZE;
use crate::{Curve, Figure, Ink, Mark, Panel};

/// The best cost so far, generation by generation of the genetic algorithm; `None` of a search
/// that has none.
pub fn course(name: &str, cost_deg: &[f64]) -> Option<Figure> {
    if cost_deg.is_empty() {
        return None;
    }
    let points = (0u32..).map(f64::from).zip(cost_deg.iter().copied());
    let points: Vec<(f64, f64)> = points.collect();
    Some(Figure {
        name: name.into(),
        title: "Best cost so far in each generation".into(),
        description:
            "The best cost that the genetic algorithm had found, generation by generation.".into(),
        is_headed: false,
        x_label: "generation".into(),
        x_shows: Vec::new(),
        panels: vec![Panel::new(
            "best cost [°]",
            vec![
                Curve::line("", Ink::Measured, points.clone()),
                Curve::line("", Ink::Measured, points).marked(Mark::Dots),
            ],
        )],
        size: [SIZE[0], 230],
    })
}

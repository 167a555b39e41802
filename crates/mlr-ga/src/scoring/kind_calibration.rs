//! How often statements of a probability are true.

use serde::Serialize;

use super::{kinds::Statement, score::mean};

/// Bounds of the probabilities that are counted together.
const BOUNDS: [f64; 8] = [0.0, 0.05, 0.2, 0.5, 0.8, 0.9, 0.97, 1.0];

/// Statements whose probabilities lie between two bounds.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct KindCalibration {
    /// Probability at least, and below; 1 lies in the last row.
    pub probability: [f64; 2],
    /// How many there are.
    pub statements: usize,
    /// Their mean probability; none without any.
    pub mean_probability: Option<f64>,
    /// How many of them are true.
    pub true_ones: usize,
}

impl KindCalibration {
    /// A row for each interval, empty ones too.
    pub(super) fn table(statements: &[&Statement]) -> Vec<Self> {
        let rows = BOUNDS.windows(2).enumerate();
        rows.map(|(row, bounds)| {
            let is_within = |one: &&&Statement| {
                let p = one.probability;
                let is_first = row == 0;
                let is_last = row + 2 == BOUNDS.len();
                (is_first || p >= bounds[0]) && (is_last || p < bounds[1])
            };
            let within: Vec<&&Statement> = statements.iter().filter(is_within).collect();
            Self {
                probability: [bounds[0], bounds[1]],
                statements: within.len(),
                mean_probability: (!within.is_empty())
                    .then(|| mean(within.iter().map(|one| one.probability))),
                true_ones: within.iter().filter(|one| one.is_true).count(),
            }
        })
        .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_statement_is_in_one_row() {
        // The sum of many shares may exceed 1 by rounding.
        let given = [
            0.0,
            0.049,
            0.05,
            0.3,
            0.5,
            0.85,
            0.9,
            0.97,
            1.0,
            1.0 + 1e-12,
        ];
        let statements: Vec<Statement> = given
            .iter()
            .map(|probability| Statement {
                kind: "payload".into(),
                probability: *probability,
                is_true: *probability >= 0.9,
            })
            .collect();
        let table = KindCalibration::table(&statements.iter().collect::<Vec<_>>());
        let counts: Vec<usize> = table.iter().map(|row| row.statements).collect();
        assert_eq!(counts, [2, 1, 1, 1, 1, 1, 3]);
        let true_ones: Vec<usize> = table.iter().map(|row| row.true_ones).collect();
        assert_eq!(true_ones, [0, 0, 0, 0, 0, 1, 3]);
        let mean = table[0].mean_probability.unwrap();
        assert!((mean - 0.0245).abs() < 1e-12);
        assert_eq!(KindCalibration::table(&[])[3].mean_probability, None);
    }
}

//! Search for the least of a cost that changes in jumps.

use rayon::prelude::*;

/// A search by polls (Hooke and Jeeves): the points around are asked for their cost, the
/// search goes to the best, and where none is better it asks nearer by. No slope is needed,
/// which a cost that jumps does not have.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Poll {
    /// How far away the first points are.
    pub(crate) widest: f64,
    /// The search ends where no point at this distance is better.
    pub(crate) narrowest: f64,
    /// Gain that makes a point better.
    pub(crate) least_gain: f64,
    /// Polls after which it ends anyhow.
    pub(crate) most: usize,
}

/// How hard the values of a model are looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Effort {
    /// Along slopes.
    Slopes,
    /// By polls as well, where slopes leave much.
    Polls,
}

impl Poll {
    /// Searches from a point of this cost. `around` gives the points at a distance, `cost_of`
    /// what a point costs: `None` where nothing can be said.
    ///
    /// # Errors
    /// Those of `cost_of`.
    pub(crate) fn search<T: Send, E: Send>(
        &self,
        from: T,
        cost: f64,
        around: impl Fn(&T, f64) -> Vec<T>,
        cost_of: impl Fn(&T) -> Result<Option<f64>, E> + Sync,
    ) -> Result<T, E> {
        let (mut here, mut cost) = (from, cost);
        let mut distance = self.widest;
        for _ in 0..self.most {
            let best = around(&here, distance)
                .into_par_iter()
                .map(|point| Ok(cost_of(&point)?.map(|cost| (cost, point))))
                .collect::<Result<Vec<_>, E>>()?
                .into_iter()
                .flatten()
                .min_by(|(a, _), (b, _)| a.total_cmp(b));
            match best {
                Some((lower, point)) if lower < cost - self.least_gain => {
                    (cost, here) = (lower, point);
                }
                _ if distance <= self.narrowest => break,
                _ => distance /= 2.0,
            }
        }
        Ok(here)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const POLL: Poll = Poll {
        widest: 4.0,
        narrowest: 0.5,
        least_gain: 0.1,
        most: 20,
    };

    fn around(&[x, y]: &[f64; 2], distance: f64) -> Vec<[f64; 2]> {
        let moves = [
            [distance, 0.0],
            [-distance, 0.0],
            [0.0, distance],
            [0.0, -distance],
        ];
        moves.map(|[dx, dy]| [x + dx, y + dy]).into()
    }

    #[test]
    fn stairs_are_descended_although_they_are_level_nearly_everywhere() {
        let stairs = |&[x, y]: &[f64; 2]| Ok(Some((x - 3.0).abs().ceil() + (y + 5.0).abs().ceil()));
        let found: Result<_, ()> = POLL.search([-9.3, 7.2], 25.0, around, stairs);
        let [x, y] = found.unwrap();
        assert!((x - 3.0).abs() <= 1.0 && (y + 5.0).abs() <= 1.0, "{x} {y}");
    }

    #[test]
    fn it_stays_where_nothing_is_better_or_nothing_is_known() {
        let from = [1.0, 2.0];
        let flat: Result<_, ()> = POLL.search(from, 3.0, around, |_| Ok(Some(3.0)));
        assert_eq!(flat, Ok(from));
        let unknown: Result<_, ()> = POLL.search(from, 3.0, around, |_| Ok(None));
        assert_eq!(unknown, Ok(from));
        assert_eq!(
            POLL.search(from, 3.0, around, |_| Err("fails")),
            Err("fails")
        );
    }
}

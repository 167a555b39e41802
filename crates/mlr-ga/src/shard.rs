use std::{fmt, str::FromStr};

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// One of several parts of a long job that are done apart, as in `3/8`: every eighth item from the
/// third on. Which items there are must not depend on the part.
///
/// ```
/// use mlr_ga::Shard;
///
/// let shard: Shard = "3/8".parse()?;
/// let own: Vec<usize> = (0..20).filter(|index| shard.has(*index)).collect();
/// assert_eq!(own, [2, 10, 18]);
/// # Ok::<(), mlr_ga::ShardError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Shard {
    number: usize,
    count: usize,
}

/// What is not one of so many parts.
#[derive(Debug, Error)]
#[error("{text:?} is not valid, expected part K of N, as in 1/8, with N up to {MOST_SHARDS}")]
pub struct ShardError {
    text: String,
}

/// More computers than anybody has.
const MOST_SHARDS: usize = 100_000;

impl Shard {
    /// The whole job as its only part.
    pub const WHOLE: Self = Self {
        number: 1,
        count: 1,
    };

    /// Which part it is, from 1.
    pub fn number(self) -> usize {
        self.number
    }

    /// Of how many.
    pub fn count(self) -> usize {
        self.count
    }

    /// Whether it is up to this part to do the item of this index.
    pub fn has(self, index: usize) -> bool {
        index % self.count == self.number - 1
    }

    /// How many of so many items this part does.
    pub fn share_of(self, items: usize) -> usize {
        (items + self.count - self.number) / self.count
    }

    /// All parts of a job that is done in as many.
    pub fn all(count: usize) -> impl Iterator<Item = Self> {
        (1..=count).map(move |number| Self { number, count })
    }
}

impl FromStr for Shard {
    type Err = ShardError;

    fn from_str(text: &str) -> Result<Self, ShardError> {
        let read = || {
            let (number, count) = text.split_once('/')?;
            let (number, count) = (number.parse().ok()?, count.parse().ok()?);
            let is_one = (1..=count).contains(&number) && count <= MOST_SHARDS;
            is_one.then_some(Self { number, count })
        };
        read().ok_or_else(|| ShardError { text: text.into() })
    }
}

impl TryFrom<String> for Shard {
    type Error = ShardError;

    fn try_from(text: String) -> Result<Self, ShardError> {
        text.parse()
    }
}

impl From<Shard> for String {
    fn from(shard: Shard) -> Self {
        shard.to_string()
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_item_is_in_one_part_and_the_parts_are_equal() {
        for (items, count) in [(0, 3), (20, 1), (20, 3), (20, 8), (2, 8)] {
            let mut done = vec![0; items];
            for shard in Shard::all(count) {
                let own: Vec<usize> = (0..items).filter(|index| shard.has(*index)).collect();
                assert_eq!(own.len(), shard.share_of(items), "{shard} of {items}");
                own.into_iter().for_each(|index| done[index] += 1);
            }
            assert!(done.iter().all(|times| *times == 1), "{done:?}");
        }
    }

    #[test]
    fn what_is_no_part_is_refused() {
        for text in [
            "", "3", "0/8", "9/8", "1/0", "-1/8", "1/8/2", "a/b", "1/100001",
        ] {
            let message = text.parse::<Shard>().unwrap_err().to_string();
            assert!(
                message.contains("expected part K of N, as in 1/8"),
                "{message}"
            );
        }
        assert_eq!("8/8".parse::<Shard>().unwrap().to_string(), "8/8");
    }
}

//! The morphology vector: which links are still there.

mod enumeration;
mod link_logic;
mod rows;
mod text;

pub use enumeration::Morphologies;
pub use link_logic::link_logic;

use mlr_filter::SettingError;

use crate::ModelError;

/// The number of links n_i of each leg of the healthy robot.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LegLayout(Box<[u8]>);

impl LegLayout {
    /// A layout with one entry per leg.
    ///
    /// # Errors
    /// [`ModelError::Setting`] when there is no leg, or a leg without links or
    /// with more than 255.
    pub fn new(links_per_leg: impl IntoIterator<Item = usize>) -> Result<Self, ModelError> {
        let links = links_per_leg
            .into_iter()
            .enumerate()
            .map(|(leg, n)| match u8::try_from(n) {
                Ok(n) if n > 0 => Ok(n),
                _ => Err(SettingError::new(
                    format!("legs[{leg}]"),
                    n,
                    "1 to 255 links",
                )),
            })
            .collect::<Result<Box<[u8]>, _>>()?;
        if links.is_empty() {
            return Err(SettingError::new("legs", "none", "at least one leg").into());
        }
        Ok(Self(links))
    }

    /// N, the number of legs.
    pub fn legs(&self) -> usize {
        self.0.len()
    }

    /// n_i, the links of leg `leg` (from 0).
    pub fn links(&self, leg: usize) -> usize {
        usize::from(self.0[leg])
    }

    /// N_T, the links of all legs together: the length of the morphology vector.
    pub fn total_links(&self) -> usize {
        self.0.iter().map(|&n| usize::from(n)).sum()
    }

    /// How many feasible morphologies there are: the product of n_i + 1, or
    /// `None` beyond the range of `u128`.
    pub fn count(&self) -> Option<u128> {
        self.0
            .iter()
            .try_fold(1_u128, |product, &n| product.checked_mul(u128::from(n) + 1))
    }

    /// All feasible morphologies, each once, the healthy one first.
    pub fn enumerate(&self) -> Morphologies {
        Morphologies::new(self)
    }
}

/// The morphology vector 𝔛 of the paper: one existence number per link.
///
/// A link hangs on the one before it, so a leg is described completely by how
/// many of its links remain. A `Morphology` is therefore connected from
/// construction on: no value of this type violates link logic (Algorithm 1).
///
/// ```
/// use mlr_model::{Morphology, Robot};
/// let layout = Robot::jethexa().layout();
/// let morphology = Morphology::parse("111 111 000 101 111 111", &layout)?;
/// assert_eq!(morphology.to_string(), "111 111 000 100 111 111");
/// assert_eq!(morphology.describe(), "leg 3 lost, leg 4 lost from link 2 on");
/// # Ok::<(), mlr_model::ModelError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Morphology {
    legs: Box<[LegState]>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
struct LegState {
    links: u8,
    remaining: u8,
}

impl Morphology {
    /// Nothing is missing.
    pub fn healthy(layout: &LegLayout) -> Self {
        Self {
            legs: layout
                .0
                .iter()
                .map(|&links| LegState {
                    links,
                    remaining: links,
                })
                .collect(),
        }
    }

    /// Applies link logic to existence numbers, leg by leg from the body
    /// outward: everything beyond the first missing link is missing too.
    ///
    /// # Errors
    /// [`ModelError::Morphology`] when `existence` does not have one entry per link.
    pub fn from_existence(layout: &LegLayout, existence: &[bool]) -> Result<Self, ModelError> {
        if existence.len() != layout.total_links() {
            return Err(ModelError::Morphology {
                text: existence
                    .iter()
                    .map(|&x| if x { '1' } else { '0' })
                    .collect(),
                reason: format!(
                    "has {} existence numbers, the robot has {} links",
                    existence.len(),
                    layout.total_links()
                ),
            });
        }
        let mut refined = existence.to_vec();
        link_logic(layout, &mut refined);
        let mut rest = refined.as_slice();
        let remaining = (0..layout.legs()).map(|leg| {
            let (own, others) = rest.split_at(layout.links(leg));
            rest = others;
            own.iter().filter(|&&exists| exists).count()
        });
        Ok(remaining
            .enumerate()
            .fold(Self::healthy(layout), |morphology, (leg, remaining)| {
                morphology.with_remaining(leg, remaining)
            }))
    }

    /// The same morphology with the whole of leg `leg` (from 0) gone.
    #[must_use]
    pub fn without_leg(self, leg: usize) -> Self {
        self.with_remaining(leg, 0)
    }

    /// The same morphology with the innermost `remaining` links of leg `leg`
    /// (from 0), all of them if it has fewer.
    #[must_use]
    pub fn with_remaining(mut self, leg: usize, remaining: usize) -> Self {
        let state = &mut self.legs[leg];
        state.remaining = u8::try_from(remaining).map_or(state.links, |n| n.min(state.links));
        self
    }

    /// The number of links per leg of the healthy robot.
    pub fn layout(&self) -> LegLayout {
        LegLayout(self.legs.iter().map(|leg| leg.links).collect())
    }

    /// N, the number of legs.
    pub fn legs(&self) -> usize {
        self.legs.len()
    }

    /// n_i, the links that leg `leg` (from 0) had when healthy.
    pub fn links(&self, leg: usize) -> usize {
        usize::from(self.legs[leg].links)
    }

    /// How many links of leg `leg` (from 0) are still there.
    pub fn remaining(&self, leg: usize) -> usize {
        usize::from(self.legs[leg].remaining)
    }

    /// The existence number of link `link` of leg `leg`, both from 0.
    pub fn exists(&self, leg: usize, link: usize) -> bool {
        link < self.remaining(leg)
    }

    /// The existence numbers, leg by leg from the body outward.
    pub fn existence(&self) -> Vec<bool> {
        (0..self.legs())
            .flat_map(|leg| (0..self.links(leg)).map(move |link| (leg, link)))
            .map(|(leg, link)| self.exists(leg, link))
            .collect()
    }

    /// Numbers (from 1) of the legs that miss at least one link.
    pub fn damaged_legs(&self) -> Vec<usize> {
        (0..self.legs())
            .filter(|&leg| self.remaining(leg) < self.links(leg))
            .map(|leg| leg + 1)
            .collect()
    }

    /// Whether nothing is missing.
    pub fn is_healthy(&self) -> bool {
        self.legs.iter().all(|leg| leg.remaining == leg.links)
    }
}

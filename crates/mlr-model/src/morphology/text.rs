//! Morphologies as people write and read them.

use std::fmt;

use super::{LegLayout, Morphology};
use crate::{ModelError, Robot};

impl Morphology {
    /// Reads `111 110 …`: one group of existence numbers per leg, separated by
    /// spaces, commas or nothing. Link logic is applied.
    ///
    /// # Errors
    /// [`ModelError::Morphology`] for other characters or a wrong length.
    pub fn parse(text: &str, layout: &LegLayout) -> Result<Self, ModelError> {
        let existence = text
            .chars()
            .filter(|c| !c.is_whitespace() && *c != ',')
            .map(|c| match c {
                '0' => Ok(false),
                '1' => Ok(true),
                other => Err(ModelError::Morphology {
                    text: text.into(),
                    reason: format!("{other:?} is not an existence number, expected 0 or 1"),
                }),
            })
            .collect::<Result<Vec<_>, _>>()?;
        Self::from_existence(layout, &existence)
    }

    /// The robot without the legs of the given numbers (from 1), as in `3,4`.
    /// An empty text is the healthy robot.
    ///
    /// # Errors
    /// [`ModelError::Morphology`] when a number is no leg of this robot.
    pub fn parse_legs_lost(text: &str, layout: &LegLayout) -> Result<Self, ModelError> {
        text.split(',')
            .map(str::trim)
            .filter(|number| !number.is_empty())
            .try_fold(Self::healthy(layout), |morphology, number| {
                match number.parse::<usize>() {
                    Ok(leg) if (1..=layout.legs()).contains(&leg) => {
                        Ok(morphology.without_leg(leg - 1))
                    }
                    _ => Err(ModelError::Morphology {
                        text: text.into(),
                        reason: format!(
                            "{number:?} is not a leg, expected numbers from 1 to {}",
                            layout.legs()
                        ),
                    }),
                }
            })
    }

    /// The damage in words: "healthy", "legs 3,4 lost",
    /// "leg 2 lost from link 3 on".
    pub fn describe(&self) -> String {
        self.describe_with(|leg| leg.to_string())
    }

    /// The same with the names that the legs have on this robot: "leg 4 (middle right) lost".
    pub fn describe_on(&self, robot: &Robot) -> String {
        self.describe_with(|leg| robot.numbered_name(leg))
    }

    /// The same with a name for each leg by its number from 1.
    pub fn describe_with(&self, name: impl Fn(usize) -> String) -> String {
        let whole: Vec<_> = self
            .damaged_legs()
            .into_iter()
            .filter(|leg| self.remaining(leg - 1) == 0)
            .map(&name)
            .collect();
        let mut parts = Vec::new();
        match whole.len() {
            0 => {}
            1 => parts.push(format!("leg {} lost", whole[0])),
            _ => parts.push(format!("legs {} lost", whole.join(","))),
        }
        for leg in self.damaged_legs() {
            let remaining = self.remaining(leg - 1);
            if remaining > 0 {
                parts.push(format!(
                    "leg {} lost from link {} on",
                    name(leg),
                    remaining + 1
                ));
            }
        }
        if parts.is_empty() {
            "healthy".into()
        } else {
            parts.join(", ")
        }
    }
}

impl fmt::Display for Morphology {
    /// `111 110 …`, the form that [`Morphology::parse`] reads.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for leg in 0..self.legs() {
            if leg > 0 {
                f.write_str(" ")?;
            }
            for link in 0..self.links(leg) {
                f.write_str(if self.exists(leg, link) { "1" } else { "0" })?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn words_for_whole_and_partial_legs() {
        let layout = LegLayout::new([3; 6]).unwrap();
        let lost = |text| Morphology::parse(text, &layout).unwrap().describe();
        assert_eq!(lost("111 111 111 111 111 111"), "healthy");
        assert_eq!(lost("111 111 000 000 111 111"), "legs 3,4 lost");
        assert_eq!(
            lost("111 110 000 111 111 111"),
            "leg 3 lost, leg 2 lost from link 3 on"
        );
    }

    #[test]
    fn refuses_what_does_not_fit_the_robot() {
        let layout = LegLayout::new([3, 2]).unwrap();
        assert!(Morphology::parse("111 1", &layout).is_err());
        assert!(Morphology::parse("111 12", &layout).is_err());
        assert!(Morphology::parse_legs_lost("0", &layout).is_err());
        assert!(Morphology::parse_legs_lost("3", &layout).is_err());
        assert!(Morphology::parse_legs_lost("x", &layout).is_err());
    }

    proptest! {
        #[test]
        fn printing_and_parsing_are_inverse(bits in prop::collection::vec(any::<bool>(), 9)) {
            let layout = LegLayout::new([3, 2, 4]).unwrap();
            let morphology = Morphology::from_existence(&layout, &bits).unwrap();
            prop_assert_eq!(
                Morphology::parse(&morphology.to_string(), &layout).unwrap(),
                morphology
            );
        }

        #[test]
        fn legs_lost_are_the_damaged_legs(lost in prop::collection::btree_set(1_usize..=6, 0..=6)) {
            let layout = LegLayout::new([3; 6]).unwrap();
            let text: Vec<_> = lost.iter().map(usize::to_string).collect();
            let morphology = Morphology::parse_legs_lost(&text.join(","), &layout).unwrap();
            prop_assert_eq!(morphology.damaged_legs(), lost.into_iter().collect::<Vec<_>>());
        }
    }
}

use super::{LegLayout, LegState, Morphology};

/// Iterator over all feasible morphologies of a layout: healthy first, then as
/// a counter runs whose last leg turns fastest.
#[derive(Debug, Clone)]
pub struct Morphologies {
    next: Option<Morphology>,
}

impl Morphologies {
    pub(super) fn new(layout: &LegLayout) -> Self {
        Self {
            next: Some(Morphology::healthy(layout)),
        }
    }
}

impl Iterator for Morphologies {
    type Item = Morphology;

    fn next(&mut self) -> Option<Morphology> {
        let current = self.next.take()?;
        let mut following = current.clone();
        for LegState { links, remaining } in following.legs.iter_mut().rev() {
            if *remaining > 0 {
                *remaining -= 1;
                self.next = Some(following);
                break;
            }
            *remaining = *links;
        }
        Some(current)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn a_hexapod_of_three_link_legs_has_4096() {
        let layout = LegLayout::new([3; 6]).unwrap();
        let all: Vec<_> = layout.enumerate().collect();
        assert_eq!(all.len(), 4096);
        assert_eq!(layout.count(), Some(4096));
        assert!(all[0].is_healthy());
        assert_eq!(all.iter().collect::<HashSet<_>>().len(), all.len());
    }

    #[test]
    fn count_agrees_with_enumeration_on_uneven_legs() {
        let layout = LegLayout::new([2, 3, 1, 4]).unwrap();
        assert_eq!(layout.enumerate().count(), 3 * 4 * 2 * 5);
        assert_eq!(layout.count(), Some(120));
    }

    #[test]
    fn count_beyond_range_is_none() {
        let layout = LegLayout::new([255; 17]).unwrap();
        assert_eq!(layout.count(), None);
    }
}

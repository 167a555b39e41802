use super::LegLayout;

/// Algorithm 1 of the paper: clears the existence number of every link beyond
/// the first missing one of its leg.
///
/// `existence` holds the legs one after the other, each from the body outward.
/// Entries beyond the layout's last link are left alone, so is a vector that
/// ends early where it ends.
pub fn link_logic(layout: &LegLayout, existence: &mut [bool]) {
    let mut rest = existence;
    for leg in 0..layout.legs() {
        let (own, others) = rest.split_at_mut(layout.links(leg).min(rest.len()));
        if let Some(first_missing) = own.iter().position(|&exists| !exists) {
            own[first_missing..].fill(false);
        }
        rest = others;
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn layout_and_bits() -> impl Strategy<Value = (LegLayout, Vec<bool>)> {
        prop::collection::vec(1_usize..5, 1..8).prop_flat_map(|links| {
            let total = links.iter().sum();
            let layout = LegLayout::new(links).unwrap();
            (
                Just(layout),
                prop::collection::vec(any::<bool>(), total..=total),
            )
        })
    }

    #[test]
    fn example_of_the_paper() {
        let layout = LegLayout::new([3]).unwrap();
        let mut leg = [true, false, true];
        link_logic(&layout, &mut leg);
        assert_eq!(leg, [true, false, false]);
    }

    proptest! {
        #[test]
        fn idempotent((layout, bits) in layout_and_bits()) {
            let mut once = bits;
            link_logic(&layout, &mut once);
            let mut twice = once.clone();
            link_logic(&layout, &mut twice);
            prop_assert_eq!(once, twice);
        }

        #[test]
        fn preserves_the_order_of_inclusion((layout, bits) in layout_and_bits(), removed in any::<prop::sample::Index>()) {
            let mut fewer = bits.clone();
            fewer[removed.index(bits.len())] = false;
            let mut more = bits;
            link_logic(&layout, &mut more);
            link_logic(&layout, &mut fewer);
            prop_assert!(fewer.iter().zip(&more).all(|(few, many)| few <= many));
        }

        #[test]
        fn never_adds_a_link_and_leaves_every_leg_connected((layout, bits) in layout_and_bits()) {
            let mut refined = bits.clone();
            link_logic(&layout, &mut refined);
            prop_assert!(refined.iter().zip(&bits).all(|(after, before)| after <= before));
            let mut rest = refined.as_slice();
            for leg in 0..layout.legs() {
                let (own, others) = rest.split_at(layout.links(leg));
                prop_assert!(own.windows(2).all(|pair| pair[1] <= pair[0]));
                rest = others;
            }
        }
    }
}

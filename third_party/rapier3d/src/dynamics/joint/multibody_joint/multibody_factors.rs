// Not in rapier3d 0.36.1: mass matrices are factorized along the tree.

use crate::alloc_prelude::*;
use crate::math::{DMatrix, Real};
use core::ops::Range;

/// The degrees of freedom that each degree of freedom of a multibody hangs on: those of its joint that
/// come before it, and those of the joints between it and the root.
#[cfg_attr(feature = "serde-serialize", derive(Serialize, Deserialize))]
#[derive(Clone, Debug, Default)]
pub(crate) struct DofAncestors {
    /// Those of one degree of freedom after the other, each time in ascending order. So those of an ancestor
    /// are the first of those of its descendants.
    list: Vec<usize>,
    /// Where those of each degree of freedom end.
    ends: Vec<usize>,
}

impl DofAncestors {
    pub fn clear(&mut self) {
        self.list.clear();
        self.ends.clear();
    }

    /// Adds a degree of freedom. Each of its ancestors, given in ascending order, was added before.
    pub fn push(&mut self, ancestors: impl Iterator<Item = usize>) {
        self.list.extend(ancestors);
        self.ends.push(self.list.len());
    }

    fn len(&self) -> usize {
        self.ends.len()
    }

    /// Where the ancestors of a degree of freedom are in the list.
    #[inline(always)]
    fn range(&self, k: usize) -> Range<usize> {
        let start = if k == 0 { 0 } else { self.ends[k - 1] };
        start..self.ends[k]
    }
}

/// The factors `U L` of a mass matrix, `U` being upper triangular with ones on its diagonal and `L` lower
/// triangular.
///
/// An element is zero unless one of its two degrees of freedom is an ancestor of the other. Eliminated from the
/// leaves to the root, it stays zero (Featherstone 2005, Efficient factorization of the joint-space inertia
/// matrix for branched kinematic trees). There is no pivoting: the symmetric part of a mass matrix is positive
/// definite.
#[cfg_attr(feature = "serde-serialize", derive(Serialize, Deserialize))]
#[derive(Clone, Debug, Default)]
pub struct MassFactors {
    ancestors: DofAncestors,
    /// The columns of `U` above its diagonal, without zeros: an element for each of the `ancestors`.
    upper: Vec<Real>,
    /// The rows of `L` left of its diagonal.
    lower: Vec<Real>,
    inv_diagonal: Vec<Real>,
}

impl MassFactors {
    /// Factorizes the leading rows and columns of `mass`, as many as there are in `ancestors`.
    pub(crate) fn factorize(&mut self, mass: &DMatrix, ancestors: &DofAncestors) {
        self.ancestors.clone_from(ancestors);
        for values in [&mut self.upper, &mut self.lower, &mut self.inv_diagonal] {
            values.clear();
        }
        for k in 0..ancestors.len() {
            let above = &ancestors.list[ancestors.range(k)];
            self.upper.extend(above.iter().map(|&i| mass[(i, k)]));
            self.lower.extend(above.iter().map(|&i| mass[(k, i)]));
            self.inv_diagonal.push(mass[(k, k)]);
        }

        for k in (0..ancestors.len()).rev() {
            let range = ancestors.range(k);
            let (upper_before, upper) = self.upper[..range.end].split_at_mut(range.start);
            let (lower_before, lower) = self.lower[..range.end].split_at_mut(range.start);
            let inv = 1.0 / self.inv_diagonal[k];
            self.inv_diagonal[k] = inv;
            for value in &mut *upper {
                *value *= inv;
            }
            for (place, &j) in ancestors.list[range].iter().enumerate() {
                let of_ancestor = ancestors.range(j);
                let (u, l) = (upper[place], lower[place]);
                subtract_product(&mut upper_before[of_ancestor.clone()], upper, l);
                subtract_product(&mut lower_before[of_ancestor], lower, u);
                self.inv_diagonal[j] -= u * l;
            }
        }
    }

    /// Solves `M x = b` for as many rows as the mass matrix has; `b` becomes `x`.
    pub fn solve_mut(&self, b: &mut [Real]) {
        let Self { ancestors, .. } = self;
        for k in (0..ancestors.len()).rev() {
            let value = b[k];
            // A force on one branch has no part in the others.
            if value != 0.0 {
                let range = ancestors.range(k);
                let elements = self.upper[range.clone()].iter();
                for (element, &i) in elements.zip(&ancestors.list[range]) {
                    b[i] -= element * value;
                }
            }
        }
        for k in 0..ancestors.len() {
            let range = ancestors.range(k);
            let mut value = b[k];
            let elements = self.lower[range.clone()].iter();
            for (element, &j) in elements.zip(&ancestors.list[range]) {
                value -= element * b[j];
            }
            b[k] = value * self.inv_diagonal[k];
        }
    }
}

/// Subtracts the product of as many elements with a factor.
#[inline(always)]
fn subtract_product(from: &mut [Real], elements: &[Real], factor: Real) {
    for (value, element) in from.iter_mut().zip(elements) {
        *value -= element * factor;
    }
}

//! Liquid bridges by tables of exact solutions: the law `young-laplace`.

use std::sync::Arc;

use super::bridge::{Bridge, CURVE};
use crate::contact::adhesion::young_laplace::{Bound, NUMBERS, Table};
use crate::lanes::Real;

const _: () = assert!(NUMBERS == CURVE + 1);

/// The tables of a plan's pairs of materials. A [`Liquid`](super::Liquid) names its own by number.
#[derive(Debug, Clone, Default)]
pub struct Tables(Vec<Arc<Table>>);

impl PartialEq for Tables {
    fn eq(&self, other: &Self) -> bool {
        let same = |(a, b): (&Arc<Table>, &Arc<Table>)| Arc::ptr_eq(a, b);
        self.0.len() == other.0.len() && self.0.iter().zip(&other.0).all(same)
    }
}

impl Tables {
    /// The table of this number.
    #[must_use]
    pub fn get(&self, number: u32) -> Option<&Table> {
        self.0.get(number as usize).map(AsRef::as_ref)
    }

    /// Appends a table, or finds the same one; gives its number.
    pub fn add(&mut self, table: &Arc<Table>) -> u32 {
        let known = self.0.iter().position(|other| Arc::ptr_eq(other, table));
        let number = known.unwrap_or_else(|| {
            self.0.push(Arc::clone(table));
            self.0.len() - 1
        });
        number as u32
    }
}

/// The exact force of a bridge, from its end and its curve.
#[inline(always)]
pub(super) fn bound_of<L: Real, const N: usize>(bridge: &Bridge<L, N>) -> Bound<L> {
    let mut numbers = [bridge.end; NUMBERS];
    numbers[1..].copy_from_slice(&bridge.resized::<CURVE>().curve);
    numbers[1] = L::ONE / bridge.end;
    Bound::from_array(numbers)
}

/// The curve of a bridge: the pull at the touch in place of 1/end, then the numbers of the exact force.
pub(super) fn curve_of(bound: &Bound) -> [f64; CURVE] {
    let numbers = bound.to_array();
    let mut curve = [0.0; CURVE];
    curve.copy_from_slice(&numbers[1..]);
    curve[0] = bound.force(0.0);
    curve
}

//! Boundaries: what adds and removes particles.

mod plans;
mod region;

pub use plans::{DeletionPlan, Ingredient, InsertionPlan, Rate};
pub use region::Region;

pub use mercury_common::scene::{Quantity, Total};

use crate::neighbours::Images;
use crate::particles::Particles;
use crate::plan::Plan;
use crate::walls::WallState;

/// Insertions and deletions of a run, and what they counted.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Boundaries {}

impl Boundaries {
    /// Of a plan.
    #[must_use]
    pub fn new(_plan: &Plan) -> Self {
        Self {}
    }
    /// Removes and inserts particles at this time (s); returns whether rows changed.
    pub fn exchange(
        &mut self,
        _particles: &mut Particles,
        _plan: &Plan,
        _images: &Images,
        _walls: &[WallState],
        _time: f64,
    ) -> bool {
        false
    }
    /// Row map.
    pub fn take_row_map(&mut self, rows: usize) -> Vec<u32> {
        (0..rows as u32).collect()
    }
    /// The list was built.
    pub fn listed(&mut self, _particles: &Particles, _skin: f64) {}
}

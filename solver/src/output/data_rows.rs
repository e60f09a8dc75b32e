//! The rows of `.data`, to which `.fstat` refers: spheres, and either bodies or their pebbles, in the order of ids.

use super::FrameCopy;
use mercury_engine::state::{BodyIndex, Id};

/// Object that a row of `.data` shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Row {
    /// The particle (or pebble) of this rank.
    Particle(usize),
    /// The body at this place.
    Body(usize),
}

/// The rows, and the row of each rank.
pub(super) struct DataRows {
    pub(super) rows: Vec<Row>,
    pub(super) row_of_rank: Vec<u32>,
}

impl DataRows {
    /// Of a state; `pebbles`: a body appears as its pebbles.
    pub(super) fn new(state: &FrameCopy, pebbles: bool) -> Self {
        let mut rows = Vec::with_capacity(state.particles.len());
        let mut row_of_rank = Vec::with_capacity(state.particles.len());
        for rank in 0..state.particles.len() {
            let body = if pebbles { None } else { state.body(rank) };
            match body {
                // The pebbles of a body follow one another, the first with the body's own id.
                Some(body) if body.id == Id::new(state.ids[rank]) => {
                    let place = state.body_of_rank[rank].map_or(0, BodyIndex::index);
                    rows.push(Row::Body(place));
                }
                Some(_) => {}
                None => rows.push(Row::Particle(rank)),
            }
            row_of_rank.push(rows.len() as u32 - 1);
        }
        Self { rows, row_of_rank }
    }
}

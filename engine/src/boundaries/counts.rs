//! Counts of what crossed flux planes and left, made in one place from events.

use super::passage::{Gate, Grain, Look, Passages};
use super::{Crossed, Tally};
use crate::cell::Cell;
use crate::state::{Particles, Plain};

/// A grain that crosses a flux plane or leaves. It holds all that is counted, so that the grain itself may be gone.
#[derive(Debug, Clone, Copy)]
pub struct Event {
    /// End of the drift in which it happened, s.
    pub(super) time: f64,
    pub(super) grain: Grain,
    pub(super) gate: Gate,
    pub(super) look: Look,
}

impl Event {
    /// Whether the grain leaves.
    #[must_use]
    pub fn is_exit(&self) -> bool {
        !matches!(self.gate, Gate::Plane { .. })
    }

    /// Encodes what one rank has found.
    #[must_use]
    pub fn encode(events: &[Self]) -> Vec<u8> {
        let mut bytes = Vec::new();
        events.iter().for_each(|event| event.put(&mut bytes));
        bytes
    }

    /// The events of all ranks in the order in which one process finds them: rows are in the order of ranks.
    #[must_use]
    pub fn of_ranks(all: &[Vec<u8>]) -> Vec<Self> {
        let mut events = Vec::new();
        for bytes in all {
            let mut bytes = &bytes[..];
            while let Ok(event) = Self::take(&mut bytes) {
                events.push(event);
            }
        }
        events.sort_by_key(|event| {
            let plane = match event.gate {
                Gate::Plane { index, .. } => index,
                _ => 0,
            };
            let is_body = matches!(event.grain, Grain::Body(_));
            (event.is_exit(), plane, is_body)
        });
        events
    }

    /// A grain at a gate at this time (s).
    pub(super) fn of(
        time: f64,
        (grain, gate): (Grain, Gate),
        particles: &Particles,
        dimensions: u8,
    ) -> Self {
        Self {
            time,
            grain,
            gate,
            look: grain.look(particles, dimensions),
        }
    }
}

crate::state::plain!(Event {
    time,
    grain,
    gate,
    look
});

/// Counts since the start, or since the last reading.
#[derive(Debug, Clone)]
pub(super) struct Counts {
    /// The particles removed by each deletion region, in the order of the plan.
    pub(super) regions: Vec<Tally>,
    /// The particles that left through the faces of the domain, in the order -x, +x, -y, +y, -z, +z.
    pub(super) faces: [Tally; 6],
    /// Amounts that crossed the flux planes since the last reading: plane by plane, each material by material.
    pub(super) crossed: Vec<Crossed>,
    pub(super) passages: Passages,
    materials: usize,
}

impl Counts {
    pub(super) fn new(regions: usize, planes: usize, materials: usize) -> Self {
        Self {
            regions: vec![Tally::default(); regions],
            faces: [Tally::default(); 6],
            crossed: vec![Crossed::default(); planes * materials],
            passages: Passages::default(),
            materials,
        }
    }

    /// Counts events, one after the other. Sums depend on their order, so it is always the same: by steps; in each the crossings plane by
    /// plane, then what leaves; particles in the order of rows, then bodies.
    pub(super) fn count(&mut self, events: &[Event], cell: &Cell) {
        for event in events {
            let look = &event.look;
            match event.gate {
                Gate::Plane { index, forward } => {
                    let place = index as usize * self.materials + look.material.index();
                    self.crossed[place].count(look, forward);
                }
                Gate::Region(index) => self.regions[index as usize].count(look),
                Gate::Face(face) => self.faces[face as usize].count(look),
            }
            self.passages.add(event, cell);
        }
    }

    /// Takes the amounts that crossed, and resets them.
    pub(super) fn take_crossed(&mut self) -> Vec<Crossed> {
        let nothing = vec![Crossed::default(); self.crossed.len()];
        std::mem::replace(&mut self.crossed, nothing)
    }
}

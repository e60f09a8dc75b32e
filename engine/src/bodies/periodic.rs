//! Bodies in periodic domains: each pebble's row is inside the domain by itself, if necessary whole periods away from its body.

use crate::cell::Cell;
use crate::state::{Bodies, Particle};

impl Bodies {
    /// Puts the centres of mass inside the periodic domain; [`Bodies::note_shifts`] must follow once the rows are wrapped too.
    pub fn wrap(&mut self, cell: &Cell) {
        for body in &mut self.all {
            body.position = cell.wrap(body.position);
        }
    }

    /// Stores the periods between the rows and the places of the pebbles in their bodies.
    pub fn note_shifts(&mut self, records: &[Particle], cell: &Cell) {
        for body in &self.all {
            for pebble in &mut self.pebbles[body.pebbles()] {
                let placed = body.position + body.orientation * pebble.offset;
                let off = records[pebble.row.index()].position - placed;
                for axis in 0..3 {
                    pebble.shift[axis] = if cell.is_periodic(axis) {
                        cell.whole_periods(axis, off[axis]) * cell.size()[axis]
                    } else {
                        0.0
                    };
                }
            }
        }
    }
}

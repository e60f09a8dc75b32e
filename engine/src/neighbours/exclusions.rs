//! Pairs of particles that have no contact with each other.

use crate::state::{Bodies, Particles, Unpaired};

/// The pairs that have no contact, however near they are: pebbles of one body, and glued pairs. They are never listed.
#[derive(Debug, Clone, Copy)]
pub struct Exclusions<'a> {
    bodies: Option<&'a Bodies>,
    unpaired: &'a Unpaired,
}

impl<'a> Exclusions<'a> {
    /// Those of particles in their present order.
    #[must_use]
    pub fn of(particles: &'a Particles) -> Self {
        Self {
            bodies: particles.bodies.as_ref(),
            unpaired: &particles.unpaired,
        }
    }

    /// Whether every pair may have a contact.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.bodies.is_none() && self.unpaired.is_empty()
    }

    /// Whether two rows have no contact.
    #[must_use]
    pub fn excludes(&self, row: usize, other: usize) -> bool {
        self.bodies.is_some_and(|bodies| {
            let body = bodies.body_of_row(row);
            body.is_some() && body == bodies.body_of_row(other)
        }) || !self.unpaired.is_empty() && self.unpaired.holds(row, other)
    }
}

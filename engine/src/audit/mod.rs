//! The energy audit: running sums over the steps.
//!
//! The second half kick of one step and the first of the next are made with the same force F, so that it does the work
//! F . (v(t - dt/2) + v(t + dt/2))/2 dt, to round-off. The mean of the two velocities is that of the time of the force. It is known only when all forces
//! on a particle are, after which each contact's share is formed.

mod losses;
mod part;

pub use losses::Losses;
pub(crate) use part::{Auditor, Moving};

use crate::forces::{Exchange, FIRST_VERTEX, Observation, Partner, SpringEnergy};

/// Changes of the energy since the start, J; filled only in audited runs.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Audit {
    /// Dissipated, by what took it.
    pub losses: Losses,
    /// Done by the walls on the particles.
    pub wall_work: f64,
    /// The part of it that walls with a servo did.
    pub servo_work: f64,
    /// Stored in the contacts of particles that left, when they left.
    pub left: SpringEnergy,
    /// Stored in contacts with walls that vanished, when they vanished.
    pub vanished: SpringEnergy,
}

/// Work of the contacts since the start, J.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Sums {
    /// By viscous and plastic normal forces.
    pub(super) dissipated_normal: f64,
    /// By sliding friction and tangential dashpots.
    pub(super) dissipated_tangential: f64,
    /// By rolling and torsion resistance.
    pub(super) dissipated_rolling: f64,
    /// By liquid: viscous forces, and bridges as they form, grow and break.
    pub(super) dissipated_liquid: f64,
    /// Done by the walls on the particles.
    pub(super) wall_work: f64,
    /// The part of it that walls with a servo did.
    pub(super) servo_work: f64,
    /// Stored in the contacts of particles that left, when they left.
    pub(super) left: SpringEnergy,
    /// Stored in contacts with walls that vanished, when they vanished.
    pub(super) vanished: SpringEnergy,
    /// Power of each at the time of the last forces.
    pub(super) last: Powers,
    /// Energy stored at the time of the last forces, by the mechanism that takes it, J.
    pub(super) stored: SpringEnergy,
}

/// A contact of the last forces, and what is lost with it if one side is gone before the next forces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AuditedContact {
    /// Row of the particle.
    pub(super) row: u32,
    /// Row of the other particle, or number of the wall.
    pub(super) partner: u32,
    pub(super) is_wall: bool,
    /// J.
    pub(super) stored: SpringEnergy,
}

impl AuditedContact {
    pub(super) fn of(exchange: &Exchange) -> Self {
        let (partner, is_wall) = match exchange.partner {
            Partner::Particle { row, .. } => (row, false),
            Partner::Wall { wall, .. } => (u32::from(wall.number()), true),
        };
        Self {
            row: exchange.row,
            partner,
            is_wall,
            stored: exchange.next_stored,
        }
    }

    /// Whether it is one of a vertex of a sheet, which never leaves.
    pub(super) fn is_vertex(&self) -> bool {
        self.row >= FIRST_VERTEX
    }

    /// Whether it can be one of so many particles and walls.
    pub(super) fn leads_somewhere(&self, rows: usize, walls: usize) -> bool {
        // Of a vertex only the wall has to be there.
        let rows = if self.is_vertex() { usize::MAX } else { rows };
        let partners = if self.is_wall { walls } else { rows };
        (self.row as usize) < rows && (self.partner as usize) < partners
    }
}

/// Powers of the contacts at one time, W.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Powers {
    /// Taken by viscous normal forces, and by those that are not elastic.
    pub(super) normal: f64,
    /// Taken by tangential forces, springs included.
    pub(super) tangential: f64,
    /// Taken by rolling and torsion couples, springs included.
    pub(super) rolling: f64,
    /// Taken by viscous liquid.
    pub(super) liquid: f64,
    /// Given by walls.
    pub(super) walls: f64,
    /// The part of it given by walls with a servo.
    pub(super) servos: f64,
}

impl Powers {
    pub(super) fn to_array(self) -> [f64; 6] {
        let Self {
            normal,
            tangential,
            rolling,
            liquid,
            walls,
            servos,
        } = self;
        [normal, tangential, rolling, liquid, walls, servos]
    }

    pub(super) fn from_array(
        [normal, tangential, rolling, liquid, walls, servos]: [f64; 6],
    ) -> Self {
        Self {
            normal,
            tangential,
            rolling,
            liquid,
            walls,
            servos,
        }
    }
}

impl Sums {
    /// Takes in the time of `dt` (s) since the last forces, over which powers count by the trapezoidal rule. What springs store
    /// more than then is not lost.
    pub(super) fn take_in(&mut self, observation: &Observation, now: Powers, dt: f64) {
        let half = 0.5 * dt;
        let last = self.last;
        let stored = observation.stored;
        if dt > 0.0 {
            self.dissipated_normal +=
                half * (last.normal + now.normal) - (stored.plastic - self.stored.plastic);
            self.dissipated_liquid +=
                half * (last.liquid + now.liquid) + observation.dissipated_by_liquid;
            self.dissipated_tangential += half * (last.tangential + now.tangential)
                - (stored.tangential - self.stored.tangential);
            self.dissipated_rolling +=
                half * (last.rolling + now.rolling) - (stored.rolling - self.stored.rolling);
            self.wall_work += half * (last.walls + now.walls);
            self.servo_work += half * (last.servos + now.servos);
        }
        (self.last, self.stored) = (now, stored);
    }

    /// Takes account of a contact that is gone with what it stored: that is not dissipated.
    pub(super) fn let_go(&mut self, stored: &SpringEnergy, by_wall: bool) {
        self.stored.add(stored, -1.0);
        let sum = if by_wall {
            &mut self.vanished
        } else {
            &mut self.left
        };
        sum.add(stored, 1.0);
    }
}

crate::state::plain!(Powers {
    normal,
    tangential,
    rolling,
    liquid,
    walls,
    servos
});

crate::state::plain!(AuditedContact {
    row,
    partner,
    is_wall,
    stored
});

crate::state::plain!(Sums {
    dissipated_normal,
    dissipated_tangential,
    dissipated_rolling,
    dissipated_liquid,
    wall_work,
    servo_work,
    left,
    vanished,
    last,
    stored
});

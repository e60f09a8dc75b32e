//! Grains that cross a flux plane or leave the domain, one by one.

use std::ops::Range;

use glam::DVec3;

use super::counts::Event;
use crate::cell::Cell;
use crate::state::{
    Body, Id, MaterialIndex, Particle, Particles, Plain, inverse_inertia_factor, volume,
};

/// A particle or a body, as boundaries see it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Grain {
    /// The particle in this row.
    Row(u32),
    /// The body of this index, with all its pebbles.
    Body(u32),
}

/// The grains of which this rank knows where they are.
#[derive(Debug, Clone)]
pub struct OwnGrains {
    /// Particles of their own in these rows.
    pub rows: Range<usize>,
    /// All bodies.
    pub bodies: bool,
}

impl OwnGrains {
    pub(super) fn has(&self, grain: Grain) -> bool {
        match grain {
            Grain::Row(row) => self.rows.contains(&(row as usize)),
            Grain::Body(_) => self.bodies,
        }
    }
}

impl Grain {
    /// Its centre, m.
    pub(super) fn position(self, particles: &Particles) -> DVec3 {
        match self {
            Self::Row(row) => particles.records[row as usize].position,
            Self::Body(body) => particles.bodies()[body as usize].position,
        }
    }

    /// Its data.
    pub(super) fn look(self, particles: &Particles, dimensions: u8) -> Look {
        match self {
            Self::Row(row) => {
                let row = row as usize;
                let (id, mass) = (particles.ids[row], particles.masses[row]);
                Look::of_particle(id, &particles.records[row], mass, dimensions)
            }
            Self::Body(index) => Look::of_body(&particles.bodies()[index as usize]),
        }
    }

    /// Its rows.
    pub(super) fn rows(self, particles: &Particles) -> Vec<u32> {
        match (self, &particles.bodies) {
            (Self::Row(row), _) => vec![row],
            (Self::Body(index), Some(bodies)) => {
                let pebbles = bodies.all[index as usize].pebbles();
                let pebbles = bodies.pebbles[pebbles].iter();
                pebbles.map(|pebble| pebble.row.number()).collect()
            }
            (Self::Body(_), None) => Vec::new(),
        }
    }
}

impl Plain for Grain {
    fn put(&self, bytes: &mut Vec<u8>) {
        match *self {
            Self::Row(row) => (false, row).put(bytes),
            Self::Body(body) => (true, body).put(bytes),
        }
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        Ok(match Plain::take(bytes)? {
            (false, row) => Self::Row(row),
            (true, body) => Self::Body(body),
        })
    }
}

crate::state::plain!(Look {
    id,
    clump,
    position,
    velocity,
    material,
    mass,
    volume,
    diameter,
    rotational
});

/// The data of a grain that boundaries count.
#[derive(Debug, Clone, Copy)]
pub(super) struct Look {
    pub(super) id: Id,
    /// Index of its clump in the plan.
    pub(super) clump: Option<u32>,
    pub(super) position: DVec3,
    pub(super) velocity: DVec3,
    pub(super) material: MaterialIndex,
    pub(super) mass: f64,
    pub(super) volume: f64,
    /// Diameter; of a body that of a sphere of its volume, m.
    pub(super) diameter: f64,
    /// Energy of rotation, J.
    pub(super) rotational: f64,
}

impl Look {
    pub(super) fn of_particle(id: Id, record: &Particle, mass: f64, dimensions: u8) -> Self {
        let inertia = mass * record.radius * record.radius / inverse_inertia_factor(dimensions);
        Self {
            id,
            clump: None,
            position: record.position,
            velocity: record.velocity,
            material: record.material,
            mass,
            volume: volume(record.radius, dimensions),
            diameter: 2.0 * record.radius,
            rotational: 0.5 * inertia * record.angular_velocity.length_squared(),
        }
    }

    pub(super) fn of_body(body: &Body) -> Self {
        Self {
            id: body.id,
            clump: Some(body.clump),
            position: body.position,
            velocity: body.velocity,
            material: body.material,
            mass: body.mass,
            volume: body.volume,
            diameter: libm::cbrt(6.0 * body.volume / std::f64::consts::PI),
            rotational: body.rotational_energy(),
        }
    }
}

/// The boundary that a grain passed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Gate {
    /// The flux plane of this index; the grain goes on. `forward`: along the normal.
    Plane {
        /// In the order of the plan.
        index: u32,
        /// Along the normal, or against it.
        forward: bool,
    },
    /// The deletion region of this index, in the order of the plan.
    Region(u32),
    /// A face of the domain, in the order -x, +x, -y, +y, -z, +z.
    Face(u32),
}

impl Plain for Gate {
    fn put(&self, bytes: &mut Vec<u8>) {
        let (kind, index, forward) = match *self {
            Self::Plane { index, forward } => (0u8, index, forward),
            Self::Region(index) => (1, index, true),
            Self::Face(index) => (2, index, true),
        };
        kind.put(bytes);
        index.put(bytes);
        forward.put(bytes);
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        let (kind, index) = (u8::take(bytes)?, u32::take(bytes)?);
        let forward = bool::take(bytes)?;
        match kind {
            0 => Ok(Self::Plane { index, forward }),
            1 => Ok(Self::Region(index)),
            2 => Ok(Self::Face(index)),
            _ => Err(format!("{kind} is no kind of boundary")),
        }
    }
}

/// A grain that crossed a flux plane or left, at the end of the drift in which it did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passage {
    /// Time, s.
    pub time: f64,
    /// The plane or face that it passed.
    pub gate: Gate,
    /// Its id; of a body that of the body.
    pub id: u32,
    /// Index of its clump in the plan; `None`: a sphere.
    pub clump: Option<u32>,
    /// Index of its material.
    pub material: u32,
    /// Diameter, m; of a body that of a sphere of its volume.
    pub diameter: f64,
    /// Centre, m, inside a periodic domain.
    pub position: DVec3,
    /// Velocity of the centre, m/s.
    pub velocity: DVec3,
}

crate::state::plain!(Passage {
    time,
    gate,
    id,
    clump,
    material,
    diameter,
    position,
    velocity
});

/// The passages since the last reading, where a plan lists them.
#[derive(Debug, Clone, Default)]
pub(super) struct Passages {
    pub(super) are_listed: bool,
    all: Vec<Passage>,
}

impl Passages {
    /// Notes a grain that passes.
    pub(super) fn add(&mut self, event: &Event, cell: &Cell) {
        let Event {
            time,
            gate,
            look: grain,
            ..
        } = *event;
        if self.are_listed {
            self.all.push(Passage {
                time,
                gate,
                id: grain.id.number(),
                clump: grain.clump,
                material: grain.material.number(),
                diameter: grain.diameter,
                position: cell.wrap(grain.position),
                velocity: grain.velocity,
            });
        }
    }

    /// Passages until now; a step adds them in an order that sorting of rows decides.
    pub(super) fn all(&self) -> &[Passage] {
        &self.all
    }

    /// In the order of time, boundary and id; forgets them.
    pub(super) fn take(&mut self) -> Vec<Passage> {
        let mut all = std::mem::take(&mut self.all);
        all.sort_by(|a, b| {
            let by_time = a.time.total_cmp(&b.time);
            // Spheres and bodies have ids of their own.
            by_time.then((a.gate, a.clump.is_some(), a.id).cmp(&(b.gate, b.clump.is_some(), b.id)))
        });
        all
    }

    /// Goes on from those of a checkpoint.
    pub(super) fn restore(&mut self, all: Vec<Passage>) {
        self.all = all;
    }
}

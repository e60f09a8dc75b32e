//! The rigid bodies of a run and the rows of their pebbles; [`crate::bodies`] moves them.

use glam::{DQuat, DVec3};

use super::{BodyIndex, FIXED, Id, Load, MaterialIndex, PebbleIndex, Row};

/// A rigid body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    /// The number by which users identify it; also that of its first pebble.
    pub id: Id,
    /// Index of its clump in the plan.
    pub clump: u32,
    /// Index of the material of its surface.
    pub material: MaterialIndex,
    /// [`FIXED`] and [`PRESCRIBED`](crate::state::PRESCRIBED), as of its pebbles.
    pub flags: u32,
    /// Its first place in [`Bodies::pebbles`].
    pub first: u32,
    /// Its number of pebbles.
    pub count: u32,
    /// Centre of mass, m. Like a particle it may stand up to half a skin outside a periodic domain.
    pub position: DVec3,
    /// Velocity of the centre of mass, m/s.
    pub velocity: DVec3,
    /// From the principal frame to the global one.
    pub orientation: DQuat,
    /// In the global frame, kg m^2/s.
    pub angular_momentum: DVec3,
    /// In the global frame, rad/s: that of the present orientation and angular momentum.
    pub angular_velocity: DVec3,
    /// Principal moments of inertia, kg m^2.
    pub moments: DVec3,
    /// Mass, kg; also of fixed bodies.
    pub mass: f64,
    /// Volume, m^3.
    pub volume: f64,
    /// Radius of the smallest sphere about the centre of mass that holds all pebbles, m.
    pub radius: f64,
    /// The load of the contacts in the last force evaluation: force and torque about the centre of mass, N and N m.
    pub load: Load,
}

impl Body {
    /// Whether it never moves.
    #[must_use]
    pub fn is_fixed(&self) -> bool {
        self.flags & FIXED != 0
    }

    /// Kinetic energy of rotation, w.L/2, J.
    #[must_use]
    pub fn rotational_energy(&self) -> f64 {
        0.5 * self.angular_velocity.dot(self.angular_momentum)
    }

    /// R I R^T applied to a vector: the angular momentum (kg m^2/s) of an angular velocity (rad/s).
    #[must_use]
    pub fn inertia_times(&self, spin: DVec3) -> DVec3 {
        self.orientation * (self.moments * (self.orientation.inverse() * spin))
    }

    /// Its places in [`Bodies::pebbles`].
    #[must_use]
    pub fn pebbles(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}

/// A pebble of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyPebble {
    /// Its body.
    pub body: BodyIndex,
    /// Its row among the particles, kept up to date by [`Bodies::follow`].
    pub row: Row,
    /// From the centre of mass, in the principal frame, m.
    pub offset: DVec3,
    /// Whole periods between the pebble's place in the body and its row, m.
    pub shift: DVec3,
}

/// Components of motion that a scene prescribes for one body; `None` is free.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PrescribedBody {
    /// The body.
    pub body: BodyIndex,
    /// Velocity components, m/s.
    pub velocity: [Option<f64>; 3],
    /// Angular velocity components, global frame, rad/s.
    pub angular_velocity: [Option<f64>; 3],
}

/// All bodies of a run.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Bodies {
    /// In ascending order of their ids.
    pub all: Vec<Body>,
    /// Pebbles of all bodies, body by body, in the order of their clump.
    pub pebbles: Vec<BodyPebble>,
    /// For each row of the particles its pebble; `None`: a single sphere.
    pub of_row: Vec<Option<PebbleIndex>>,
    /// Bodies with prescribed components; few.
    pub prescribed: Vec<PrescribedBody>,
    /// Ids that pebbles have taken beyond one for each body, over all bodies ever made.
    pub extra_ids: u32,
}

impl Bodies {
    /// Bytes of `bodies` bodies of `pebbles` pebbles in all among `rows` rows, for estimates of memory.
    #[must_use]
    pub fn bytes(bodies: f64, pebbles: f64, rows: f64) -> f64 {
        bodies * size_of::<Body>() as f64
            + pebbles * size_of::<BodyPebble>() as f64
            + rows * size_of::<u32>() as f64
    }

    /// The body that the pebble in `row` belongs to.
    #[must_use]
    pub fn body_of_row(&self, row: usize) -> Option<BodyIndex> {
        let pebble = self.of_row[row]?;
        Some(self.pebbles[pebble.index()].body)
    }

    /// Whether bodies, pebbles and `rows` rows refer to each other consistently.
    pub(super) fn is_consistent(&self, rows: usize) -> bool {
        let is_body = |body: BodyIndex| body.index() < self.all.len();
        let is_pebble = |pebble: &PebbleIndex| pebble.index() < self.pebbles.len();
        let bodies = self.all.iter().all(|body| {
            let end = u64::from(body.first) + u64::from(body.count);
            body.count > 0 && end <= self.pebbles.len() as u64
        });
        self.of_row.len() == rows
            && self.of_row.iter().flatten().all(is_pebble)
            && (self.pebbles.iter()).all(|pebble| is_body(pebble.body) && pebble.row.index() < rows)
            && bodies
            && self.prescribed.iter().all(|body| is_body(body.body))
    }

    /// The rows of the particles were reordered: `new_row[old]`, `None` for rows that were removed. A body leaves with its
    /// pebbles, all of which must have been removed. `rows` is the present number.
    pub fn follow(&mut self, new_row: &[Option<Row>], rows: usize) {
        let now = |pebble: &BodyPebble| new_row[pebble.row.index()];
        if self.pebbles.iter().any(|pebble| now(pebble).is_none()) {
            self.drop_bodies(|first| now(first).is_none());
        }
        self.of_row.clear();
        self.of_row.resize(rows, None);
        for (place, pebble) in self.pebbles.iter_mut().enumerate() {
            if let Some(row) = new_row[pebble.row.index()] {
                pebble.row = row;
                self.of_row[row.index()] = Some(PebbleIndex::new(place));
            }
        }
    }

    /// Removes the bodies whose first pebble `leaves`.
    fn drop_bodies(&mut self, leaves: impl Fn(&BodyPebble) -> bool) {
        let mut present = vec![None; self.all.len()];
        let (mut all, mut pebbles) = (Vec::new(), Vec::new());
        for (index, body) in self.all.iter().enumerate() {
            if leaves(&self.pebbles[body.first as usize]) {
                continue;
            }
            let (first, now) = (pebbles.len() as u32, BodyIndex::new(all.len()));
            present[index] = Some(now);
            let of_body = &self.pebbles[body.pebbles()];
            pebbles.extend(of_body.iter().map(|p| BodyPebble { body: now, ..*p }));
            all.push(Body { first, ..*body });
        }
        (self.all, self.pebbles) = (all, pebbles);
        self.prescribed = (self.prescribed.iter())
            .filter_map(|prescribed| {
                let body = present[prescribed.body.index()]?;
                Some(PrescribedBody {
                    body,
                    ..*prescribed
                })
            })
            .collect();
    }
}

crate::state::plain!(Body {
    id,
    clump,
    material,
    flags,
    first,
    count,
    position,
    velocity,
    orientation,
    angular_momentum,
    angular_velocity,
    moments,
    mass,
    volume,
    radius,
    load
});
crate::state::plain!(BodyPebble {
    body,
    row,
    offset,
    shift
});
crate::state::plain!(PrescribedBody {
    body,
    velocity,
    angular_velocity
});
crate::state::plain!(Bodies {
    all,
    pebbles,
    of_row,
    prescribed,
    extra_ids
});

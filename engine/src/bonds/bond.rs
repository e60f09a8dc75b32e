//! A bond of a run: its element, its ends, and what it does now.

use glam::{DQuat, DVec3};

use super::BondPlan;
use super::element::{Action, Element, Mobility, Section};
use crate::cell::Cell;
use crate::state::{Particles, Plain};
use crate::walls::WallNow;

/// A bond.
#[derive(Debug, Clone, PartialEq)]
pub struct Bond {
    /// Index of its entry in the plan.
    pub plan: u32,
    /// Ids of its ends, the lower one first; of a bond to a wall the second is the index of the wall.
    pub ids: [u32; 2],
    /// Whether end B is a wall.
    pub is_wall: bool,
    /// Rows of the ends by the present list; of a wall its index.
    pub(super) rows: [u32; 2],
    /// Its constants.
    pub element: Element,
    /// The frame of the gluing, in that of each end.
    pub(super) frames: [DQuat; 2],
    /// Point of a wall, in its own frame, m.
    pub(super) anchor: DVec3,
    /// From end A to end B, m, by the image of B that it was glued to.
    pub branch: DVec3,
    /// Tension and shear at which it breaks, Pa.
    pub strengths: [f64; 2],
    /// Loads at the last forces.
    pub now: Action,
    /// Elastic energy at the forces before, J.
    pub(super) last_energy: f64,
}

/// A bond that broke.
#[derive(Debug, Clone, PartialEq)]
pub struct Break {
    /// s
    pub time: f64,
    /// Ids of its ends, as in [`Bond::ids`].
    pub ids: [u32; 2],
    /// Whether end B is a wall.
    pub is_wall: bool,
    /// Index of its entry in the plan.
    pub plan: u32,
    /// How it broke.
    pub mode: BreakMode,
    /// Its middle, m.
    pub position: DVec3,
    /// Elastic energy that it set free, J.
    pub energy: f64,
}

/// How a bond broke.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BreakMode {
    /// Its tension reached the strength.
    Tension,
    /// Its shear stress reached the strength.
    Shear,
    /// One of its ends was removed.
    Deletion,
}

impl BreakMode {
    /// Name of the mode in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Tension => "tension",
            Self::Shear => "shear",
            Self::Deletion => "deletion",
        }
    }
}

/// Particles, walls and the periodic box that bonds are between.
#[derive(Clone, Copy)]
pub(super) struct Surroundings<'a> {
    pub(super) particles: &'a Particles,
    pub(super) walls: &'a [WallNow],
    pub(super) cell: &'a Cell,
    /// m r^2 / I of a sphere.
    pub(super) inverse_inertia: f64,
}

impl Surroundings<'_> {
    /// Orientation of a particle, or of the body of a pebble.
    #[inline]
    pub(super) fn orientation(&self, row: usize) -> DQuat {
        let particles = self.particles;
        if let Some(bodies) = &particles.bodies
            && let Some(body) = bodies.body_of_row(row)
        {
            return bodies.all[body.index()].orientation;
        }
        let orientations = particles.orientations.as_ref();
        orientations.map_or(DQuat::IDENTITY, |all| all[row])
    }

    /// How easily a particle is moved at its centre. A pebble turns its body, about the axis that yields most.
    pub(super) fn mobility(&self, row: usize) -> Mobility {
        let record = &self.particles.records[row];
        let inverse_mass = record.inverse_mass;
        if inverse_mass > 0.0
            && let Some(bodies) = &self.particles.bodies
            && let Some(pebble) = bodies.of_row[row]
        {
            let pebble = &bodies.pebbles[pebble.index()];
            let inverse_inertia = 1.0 / bodies.all[pebble.body.index()].moments.min_element();
            return Mobility {
                inverse_mass: inverse_mass + pebble.offset.length_squared() * inverse_inertia,
                inverse_inertia,
            };
        }
        Mobility {
            inverse_mass,
            inverse_inertia: self.inverse_inertia * inverse_mass / (record.radius * record.radius),
        }
    }
}

impl Bond {
    /// Bond of an entry between a particle and another one (`is_wall`: or a wall), at `branch` (m) from it. The point of a wall is where that ends.
    pub(super) fn glue(
        (number, plan): (usize, &BondPlan),
        rows: [u32; 2],
        is_wall: bool,
        branch: DVec3,
        strengths: [f64; 2],
        around: &Surroundings<'_>,
    ) -> Self {
        let particles = around.particles;
        let [row, other] = rows.map(|row| row as usize);
        let record = &particles.records[row];
        let id = |row: usize| particles.ids[row].number();
        let across = around.orientation(row);
        let (id_b, radius, mobility, beyond, anchor);
        if is_wall {
            let wall = &around.walls[other];
            (id_b, radius, mobility) = (rows[1], record.radius, Mobility::default());
            beyond = wall.state.pose.rotation;
            anchor = wall.state.pose.to_initial(record.position + branch);
        } else {
            id_b = id(other);
            radius = record.radius.min(particles.records[other].radius);
            mobility = around.mobility(other);
            beyond = around.orientation(other);
            anchor = DVec3::ZERO;
        }
        let length = branch.length();
        let section = Section {
            radius: plan.radius_ratio * radius,
        };
        let ends = [around.mobility(row), mobility];
        let frame = DQuat::from_rotation_arc(DVec3::X, branch / length);
        Self {
            plan: number as u32,
            ids: [id(row), id_b],
            is_wall,
            rows,
            element: Element::new(plan.law, length, section, plan.damping, ends),
            frames: [across, beyond].map(|end| end.conjugate() * frame),
            anchor,
            branch,
            strengths,
            now: Action::default(),
            last_energy: 0.0,
        }
    }

    /// How it breaks now, if it does: by the stress that is more over its strength.
    pub(super) fn breaks(&self) -> Option<BreakMode> {
        let ([tension, shear], strengths) = (self.now.stresses, self.strengths);
        // An end that is not a number is found by the step.
        if !(tension >= strengths[0] || shear >= strengths[1]) {
            return None;
        }
        let (tension, shear) = (tension / strengths[0], shear / strengths[1]);
        Some(if tension >= shear {
            BreakMode::Tension
        } else {
            BreakMode::Shear
        })
    }

    /// Elastic energy (J) that it sets free as it breaks. Its last force ended half a step before it broke: at a step whose forces it has computed and does
    /// not exert, or at a removal, before it computes those of the step.
    pub(super) fn released(&self, mode: BreakMode) -> f64 {
        let half = 0.5 * (self.now.energy - self.last_energy);
        let energy = match mode {
            BreakMode::Tension | BreakMode::Shear => self.now.energy - half,
            BreakMode::Deletion => self.now.energy + half,
        };
        energy.max(0.0)
    }

    /// The force and couple on A about the middle of the bond, N and N m.
    #[must_use]
    pub fn load_at_middle(&self) -> [DVec3; 2] {
        let Action { force, couples, .. } = self.now;
        // From the middle A is at minus half the branch.
        [force, couples[0] - (0.5 * self.branch).cross(force)]
    }

    /// Where a wall is held, m.
    pub(super) fn point_of_wall(&self, wall: &WallNow) -> DVec3 {
        wall.state.pose.to_global(self.anchor)
    }
}

impl Plain for BreakMode {
    fn put(&self, bytes: &mut Vec<u8>) {
        (*self as u8).put(bytes);
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        match u8::take(bytes)? {
            0 => Ok(Self::Tension),
            1 => Ok(Self::Shear),
            2 => Ok(Self::Deletion),
            other => Err(format!("{other} is no way to break")),
        }
    }
}

crate::state::plain!(Bond {
    plan,
    ids,
    is_wall,
    rows,
    element,
    frames,
    anchor,
    branch,
    strengths,
    now,
    last_energy
});
crate::state::plain!(Break {
    time,
    ids,
    is_wall,
    plan,
    mode,
    position,
    energy
});

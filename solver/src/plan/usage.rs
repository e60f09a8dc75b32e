//! Which materials occur in a scene, how large their particles are, and who can meet whom.

use mercury_common::scene::Scene;

use super::NewParticle;
use crate::boundaries::InsertionPlan;
use crate::walls::Wall;

/// What is made of a material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MaterialUse {
    /// Particles that contacts can move; insertions count as many.
    pub free: u64,
    /// Particles that never move.
    pub fixed: u64,
    /// Whether a wall is made of it.
    pub walls: bool,
    /// Smallest radius of the free particles, m; infinite if there are none.
    pub smallest_free: f64,
    /// Smallest radius of the fixed particles, m; infinite if there are none.
    pub smallest_fixed: f64,
}

/// What is made of each material.
#[must_use]
pub(super) fn material_uses(
    scene: &Scene,
    particles: &[NewParticle],
    insertions: &[InsertionPlan],
    walls: &[Wall],
) -> Vec<MaterialUse> {
    let unused = MaterialUse {
        free: 0,
        fixed: 0,
        walls: false,
        smallest_free: f64::INFINITY,
        smallest_fixed: f64::INFINITY,
    };
    let mut uses = vec![unused; scene.materials.len()];
    for particle in particles {
        let used = &mut uses[particle.material as usize];
        if particle.fixed {
            used.fixed += 1;
            used.smallest_fixed = used.smallest_fixed.min(particle.radius);
        } else {
            used.free += 1;
            used.smallest_free = used.smallest_free.min(particle.radius);
        }
    }
    for ingredient in insertions.iter().flat_map(|insertion| &insertion.mixture) {
        let used = &mut uses[ingredient.material as usize];
        // Two stand for many: they can meet one another.
        used.free += 2;
        used.smallest_free = used.smallest_free.min(0.5 * ingredient.sizes.smallest());
    }
    for wall in walls {
        uses[wall.material as usize].walls = true;
    }
    uses
}

/// Whether particles of two materials (by row) can meet: at least one of the two can move, and there are two.
#[must_use]
pub(super) fn particles_meet(uses: &[MaterialUse], a: usize, b: usize) -> bool {
    let (one, other) = (&uses[a], &uses[b]);
    if a == b {
        one.free >= 2 || (one.free >= 1 && one.fixed >= 1)
    } else {
        (one.free > 0 && other.free + other.fixed > 0) || (other.free > 0 && one.fixed > 0)
    }
}

/// Whether particles of one of two materials (by row) can meet walls of the other.
#[must_use]
pub(super) fn walls_meet(uses: &[MaterialUse], a: usize, b: usize) -> bool {
    (uses[a].free > 0 && uses[b].walls) || (uses[b].free > 0 && uses[a].walls)
}

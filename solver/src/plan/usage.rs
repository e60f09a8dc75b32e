//! Materials that occur in a scene, the sizes of their particles, and the pairs that can meet.

use mercury_common::scene::Scene;

use super::particles::StartingParticles;
use mercury_engine::bodies::Clump;
use mercury_engine::boundaries::InsertionPlan;
use mercury_engine::walls::Wall;

/// Objects that are made of a material.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MaterialUse {
    /// Particles that contacts can move; insertions count as many.
    pub free: u64,
    /// Particles that never move.
    pub fixed: u64,
    /// Whether a wall is made of it.
    pub walls: bool,
    /// Mass of the lightest vertex of the sheets of it, kg.
    pub lightest_vertex: Option<f64>,
    /// Smallest radius of the free particles and pebbles, m; infinite if there are none.
    pub smallest_free: f64,
    /// Smallest radius of the free spheres, m; infinite if there are none.
    pub smallest_sphere: f64,
    /// Clumps of it that contacts can move: index, and smallest scale.
    pub free_clumps: Vec<(usize, f64)>,
    /// Smallest radius of the fixed particles, m; infinite if there are none.
    pub smallest_fixed: f64,
}

impl MaterialUse {
    fn free_clump(&mut self, index: usize, clump: &Clump, scale: f64) {
        self.smallest_free = self.smallest_free.min(clump.pebble_radii().0 * scale);
        match self.free_clumps.iter_mut().find(|(at, _)| *at == index) {
            Some((_, smallest)) => *smallest = smallest.min(scale),
            None => self.free_clumps.push((index, scale)),
        }
    }
}

/// Objects that are made of each material.
#[must_use]
pub(crate) fn material_uses(
    scene: &Scene,
    start: &StartingParticles,
    clumps: &[Clump],
    insertions: &[InsertionPlan],
    walls: &[Wall],
) -> Vec<MaterialUse> {
    let unused = MaterialUse {
        free: 0,
        fixed: 0,
        walls: false,
        lightest_vertex: None,
        smallest_free: f64::INFINITY,
        smallest_fixed: f64::INFINITY,
        smallest_sphere: f64::INFINITY,
        free_clumps: Vec::new(),
    };
    let mut uses = vec![unused; scene.materials.len()];
    for particle in &start.particles {
        let used = &mut uses[particle.material.index()];
        if particle.fixed {
            used.fixed += 1;
            used.smallest_fixed = used.smallest_fixed.min(particle.radius);
        } else {
            used.free += 1;
            used.smallest_free = used.smallest_free.min(particle.radius);
            used.smallest_sphere = used.smallest_sphere.min(particle.radius);
        }
    }
    for body in &start.bodies {
        let index = body.clump as usize;
        let clump = &clumps[index];
        let used = &mut uses[clump.material.index()];
        if body.fixed {
            used.fixed += 1;
            let radius = clump.pebble_radii().0 * body.scale;
            used.smallest_fixed = used.smallest_fixed.min(radius);
        } else {
            used.free += 1;
            used.free_clump(index, clump, body.scale);
        }
    }
    for ingredient in insertions.iter().flat_map(|insertion| &insertion.mixture) {
        let used = &mut uses[ingredient.material.index()];
        // Two stand for many: they can meet one another.
        used.free += 2;
        let diameter = ingredient.sizes.smallest();
        match ingredient.clump {
            None => {
                used.smallest_free = used.smallest_free.min(0.5 * diameter);
                used.smallest_sphere = used.smallest_sphere.min(0.5 * diameter);
            }
            Some(index) => {
                let clump = &clumps[index as usize];
                let scale = diameter / clump.equal_volume_diameter();
                used.free_clump(index as usize, clump, scale);
            }
        }
    }
    for wall in walls {
        uses[wall.material.index()].walls = true;
    }
    uses
}

/// Whether particles of two materials (by row) can meet: at least one of the two can move, and there are two.
#[must_use]
pub(crate) fn particles_meet(uses: &[MaterialUse], a: usize, b: usize) -> bool {
    let (one, other) = (&uses[a], &uses[b]);
    if a == b {
        one.free >= 2 || (one.free >= 1 && one.fixed >= 1)
    } else {
        (one.free > 0 && other.free + other.fixed > 0) || (other.free > 0 && one.fixed > 0)
    }
}

/// Whether particles of one of two materials (by row) can meet walls of the other.
#[must_use]
pub(crate) fn walls_meet(uses: &[MaterialUse], a: usize, b: usize) -> bool {
    let is_surface = |used: &MaterialUse| used.walls || used.lightest_vertex.is_some();
    let (one, other) = (&uses[a], &uses[b]);
    // Vertices of sheets touch walls, too.
    let sheets = one.lightest_vertex.is_some() && other.walls
        || other.lightest_vertex.is_some() && one.walls;
    (one.free > 0 && is_surface(other)) || (other.free > 0 && is_surface(one)) || sheets
}

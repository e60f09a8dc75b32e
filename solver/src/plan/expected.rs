//! Expected size of a run: grains, spheres, and pairs.

use super::particles::StartingParticles;
use super::{NewBody, Plan};
use crate::boundaries::plan::insertions::expected_inserted;
use mercury_engine::bodies::Clump;

/// The numbers of a run when everything planned is present.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Expected {
    /// Spheres that are grains of their own.
    pub particles: f64,
    /// Bodies.
    pub bodies: f64,
    /// Pebbles of bodies.
    pub pebbles: f64,
    /// Rows: particles and pebbles.
    pub spheres: f64,
    /// Pairs of spheres that touch.
    pub touching: f64,
    /// Pairs of spheres in the candidate list.
    pub listed: f64,
}

/// Pairs that touch, and pairs that are listed, per sphere of a dense bed at rest or in slow flow: of the beds in `scenes/bench` 2.1 to
/// 2.4, and 2.7 to 3.6.
const DENSE: [f64; 2] = [2.35, 3.3];

/// The expected numbers for the run of a plan.
#[must_use]
pub fn expected(plan: &Plan) -> Expected {
    let pebbles = |clump: u32| plan.physics().clumps[clump as usize].pebbles.len() as f64;
    let start = at_start(plan);
    let mut expected = Expected {
        particles: start.particles,
        bodies: start.bodies,
        pebbles: start.pebbles,
        ..Expected::default()
    };
    for insertion in &plan.physics().insertions {
        let number = expected_inserted(insertion, plan);
        for part in &insertion.mixture {
            match part.clump {
                None => expected.particles += number * part.share,
                Some(clump) => {
                    expected.bodies += number * part.share;
                    expected.pebbles += number * part.share * pebbles(clump);
                }
            }
        }
    }
    expected.spheres = expected.particles + expected.pebbles;
    // Grains that are loose now may lie together later.
    expected.touching = (plan.notes().counted().touching as f64).max(DENSE[0] * expected.spheres);
    expected.listed = (plan.notes().counted().listed as f64).max(DENSE[1] * expected.spheres);
    expected
}

/// Grains of the start, those among them that a sketch leaves out.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct AtStart {
    pub particles: f64,
    pub bodies: f64,
    pub pebbles: f64,
}

/// Particles at the start.
pub(super) fn at_start(plan: &Plan) -> AtStart {
    let physics = plan.physics();
    let left_out = plan.notes().counted().left_out;
    let pebbles = |body: &NewBody| body.clump(&physics.clumps).pebbles.len();
    let made: usize = physics.bodies.iter().map(pebbles).sum();
    AtStart {
        particles: physics.particles.len() as f64 + left_out.particles,
        bodies: physics.bodies.len() as f64 + left_out.bodies,
        pebbles: made as f64 + left_out.pebbles,
    }
}

/// Counts made while the start of a scene was read and looked over.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Counted {
    /// Pairs of spheres that touch at the start.
    pub touching: u64,
    /// Pairs that the first candidate list holds.
    pub listed: u64,
    /// The parts of the scene that are not in the plan.
    pub left_out: LeftOut,
}

impl Counted {
    /// Pairs of a sketch extrapolated to the whole: as many for each pebble, as most of those at the start are of one body, else
    /// for each particle.
    pub(super) fn scale_up(&mut self, made: &StartingParticles, clumps: &[Clump]) {
        let LeftOut {
            particles, pebbles, ..
        } = self.left_out;
        let of_bodies = made.bodies.iter();
        let made_pebbles: usize = of_bodies.map(|body| body.clump(clumps).pebbles.len()).sum();
        let factor = if pebbles > 0.0 {
            1.0 + pebbles / made_pebbles.max(1) as f64
        } else if particles > 0.0 {
            1.0 + particles / made.particles.len().max(1) as f64
        } else {
            return;
        };
        for count in [&mut self.touching, &mut self.listed] {
            *count = (*count as f64 * factor).round() as u64;
        }
    }
}

/// Grains on lattices that a [`sketch`](super::sketch) of a scene leaves out; a plan leaves out none.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LeftOut {
    /// Spheres that are grains of their own.
    pub particles: f64,
    /// Bodies.
    pub bodies: f64,
    /// Their pebbles.
    pub pebbles: f64,
}

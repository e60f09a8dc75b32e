//! What a run is expected to hold: grains, spheres, and pairs of them.

use super::Plan;
use super::insertions::expected_inserted;

/// Numbers of what a run holds when all that is planned has come.
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

/// What the run of a plan is expected to hold.
#[must_use]
pub fn expected(plan: &Plan) -> Expected {
    let pebbles = |clump: u32| plan.physics().clumps()[clump as usize].pebbles.len() as f64;
    let mut expected = Expected {
        particles: plan.physics().particles().len() as f64,
        bodies: plan.physics().bodies().len() as f64,
        pebbles: plan
            .physics()
            .bodies()
            .iter()
            .map(|body| pebbles(body.clump))
            .sum(),
        ..Expected::default()
    };
    for insertion in plan.physics().insertions() {
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
    // What is loose now may lie together later.
    expected.touching = (plan.notes().counted().touching as f64).max(DENSE[0] * expected.spheres);
    expected.listed = (plan.notes().counted().listed as f64).max(DENSE[1] * expected.spheres);
    expected
}

/// What was counted while the start of a scene was read and looked over.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Counted {
    /// Pairs of spheres that touch at the start.
    pub touching: u64,
    /// Pairs that the first candidate list holds.
    pub listed: u64,
    /// Bytes of the largest table of particles.
    pub table_bytes: u64,
    /// Particles in it.
    pub table_rows: u64,
}

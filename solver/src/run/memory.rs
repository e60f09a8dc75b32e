//! The memory that a run takes, by what its rooms hold.

use crate::forces::{contact_loop, parked_bytes};
use crate::memory::GROWTH;
use crate::neighbours::{build_bytes, list_bytes};
use crate::output::output_bytes;
use crate::plan::{Memory, Plan, StartBytes, expected};
use crate::state::{Bodies, Particles};

/// What any run takes: the program, its libraries, its pictures.
const PROGRAM: f64 = 16e6;

/// What the run of a plan is expected to take.
///
/// The sum of what the particles, lists and outputs hold by their own account, for as many particles and contacts as are expected. A
/// list that is built while a frame is written takes somewhat more than either, and so do states that wait for a slow disk.
#[must_use]
pub fn memory(plan: &Plan) -> Memory {
    let expected = expected(plan);
    let rows = expected.spheres;
    let (forces, _) = contact_loop(plan.physics().laws());
    let [slot, carried] = forces.pair_bytes().map(|bytes| bytes as f64);

    let columns = Particles::bytes_per_row(plan.physics().orientations()) as f64;
    let mut particles = rows * columns;
    if expected.bodies > 0.0 {
        particles += Bodies::bytes(expected.bodies, expected.pebbles, rows);
    }
    let slots = expected.listed * slot;
    let parked = parked_bytes(rows, expected.touching);
    let output = output_bytes(plan, &expected, &forces.history_columns());
    let start = StartBytes::of(plan);
    let checkpoint = particles + forces.saved_bytes(expected.listed, expected.touching);

    let steps = PROGRAM + start.plan + particles + slots + parked + output.kept;
    // A list is made while the old slots are there; then their histories wait, twice for a moment, for the new ones.
    let searching = build_bytes(rows, expected.listed);
    let waiting = (GROWTH + 1.0) * expected.touching * carried;
    let carrying =
        list_bytes(rows, expected.listed) + waiting + 4.0 * rows * size_of::<u32>() as f64 - slots;
    let checking =
        start.spheres * columns + build_bytes(start.spheres, plan.notes().counted().listed as f64);
    let most = steps + searching.max(carrying).max(output.writing);
    // These histories lie in many small pieces, whose room the allocator keeps for the next list.
    let steps = steps + waiting;
    Memory {
        spheres: rows,
        start: PROGRAM + start.plan + start.reading.max(start.looking_over + checking),
        steps,
        kept_free: waiting,
        most: most.max(steps),
        checkpoint,
    }
}

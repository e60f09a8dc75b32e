//! The memory that a run takes, counted module by module, and whether the machine has it.

use mercury_common::machine::MachineMemory;
use mercury_common::readable::{bytes, count};
use mercury_common::scene::{Scene, SceneError, SceneErrors};

use crate::output::output_bytes;
use crate::plan::{Memory, Plan, StartBytes, expected, largest, lattice_grains, plan, sketch};
use mercury_engine::forces::{contact_loop, parked_bytes};
use mercury_engine::memory::{GROWTH, MANY};
use mercury_engine::neighbours::{build_bytes, list_bytes};
use mercury_engine::physics::ToSetup;
use mercury_engine::state::{Bodies, Particles};
use mercury_engine::step::{SizeEstimate, bytes_of_parts};

/// The memory of any run: the program, its libraries, its pictures.
const PROGRAM: f64 = 16e6;

/// The ranks of a run, and those of them that share the memory of this machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RanksHere {
    /// All ranks.
    pub all: usize,
    /// Those on this machine.
    pub here: usize,
    /// Whether the first one, which writes outputs and checkpoints, is among them.
    pub with_first: bool,
}

impl RanksHere {
    /// One process.
    pub const ALONE: Self = Self {
        all: 1,
        here: 1,
        with_first: true,
    };
}

/// Memory that the run of a plan is expected to need in one process.
#[must_use]
pub fn memory(plan: &Plan) -> Memory {
    memory_of(plan, RanksHere::ALONE)
}

/// Memory that the ranks on this machine are expected to need for the run of a plan: each the columns of all particles, and its part of contacts and
/// lists.
///
/// The sum of the memory of particles, lists, parts of the step and outputs, for the expected number of particles and contacts.
/// A list that is built while a frame is written takes somewhat more than either, and so do states that wait for a slow disk.
#[must_use]
pub(super) fn memory_of(plan: &Plan, ranks: RanksHere) -> Memory {
    let expected = expected(plan);
    let rows = expected.spheres;
    let here = ranks.here as f64;
    let first = f64::from(u8::from(ranks.with_first));
    let [listed, touching] =
        [expected.listed, expected.touching].map(|contacts| contacts / ranks.all as f64);
    let (forces, _) = contact_loop(&plan.physics().laws);
    let layout = forces.layout();
    let (slot, carried) = (layout.slot as f64, layout.carried as f64);

    let columns = Particles::bytes_per_row(plan.physics().orientations) as f64;
    let mut particles = rows * columns;
    if expected.bodies > 0.0 {
        particles += Bodies::bytes(expected.bodies, expected.pebbles, rows);
    }
    let slots = listed * slot;
    let parked = parked_bytes(rows, touching);
    let output = output_bytes(plan, &expected, &layout.columns);
    let start = StartBytes::of(plan);
    let crowd = SizeEstimate { rows, touching };
    let parts = bytes_of_parts(&plan.to_setup(), &crowd);
    let saved = layout.saved_bytes(rows, expected.listed, expected.touching);
    // The first of several ranks holds the contacts of all for a checkpoint.
    let of_others = expected.listed * layout.slot as f64 - slots;
    let checkpoint = first * (particles + saved + of_others);

    let each = PROGRAM + start.meshes + particles + parts + slots + parked;
    // The others drop the grains of the plan.
    let steps = here * each + first * (start.grains + output.kept);
    // A list is made while the old slots exist; then their histories are kept, twice for a moment, for the new ones.
    let searching = build_bytes(rows, listed);
    let waiting = (GROWTH + 1.0) * touching * carried;
    let carrying =
        list_bytes(rows, listed) + waiting + 4.0 * rows * size_of::<u32>() as f64 - slots;
    let checking =
        start.spheres * columns + build_bytes(start.spheres, plan.notes().counted().listed as f64);
    let most = steps + (here * searching.max(carrying)).max(first * output.writing);
    // These histories lie in many small pieces, and the allocator keeps their memory for the next list of few particles.
    let kept_free = if rows > MANY as f64 {
        0.0
    } else {
        here * waiting
    };
    let steps = steps + kept_free;
    let plan = start.grains + start.meshes;
    let at_start = PROGRAM + plan + start.reading.max(start.looking_over + checking);
    Memory {
        spheres: rows,
        start: here * at_start,
        steps,
        kept_free,
        most: most.max(steps),
        checkpoint,
    }
}

/// An upper bound of the memory of a grain, bytes: very large lattices are counted before they are made.
const MOST_EACH: f64 = 1e4;
/// A lower bound of the memory of a grain, bytes, with its contacts and outputs.
const LEAST_EACH: f64 = 1e3;

/// The plan of a scene and the memory that its run is expected to take. Lattices that cannot fit into the machine's memory are
/// refused before they are made; inserted particles are left to [`check_fit`]. Without `machine` there is no limit.
///
/// # Errors
/// Errors of [`plan`](crate::plan::plan), and of [`check_fit`].
pub fn plan_within(
    scene: &Scene,
    machine: Option<MachineMemory>,
) -> Result<(Plan, Memory), SceneErrors> {
    plan_of_ranks(scene, machine, RanksHere::ALONE)
}

/// As [`plan_within`], for the ranks on this machine, which share its memory.
///
/// # Errors
/// Those of [`plan_within`].
pub fn plan_of_ranks(
    scene: &Scene,
    machine: Option<MachineMemory>,
    ranks: RanksHere,
) -> Result<(Plan, Memory), SceneErrors> {
    let memory = |plan: &Plan| memory_of(plan, ranks);
    let grains = lattice_grains(scene);
    if let Some(machine) = machine.filter(|machine| grains * MOST_EACH > machine.total) {
        match sketch(scene) {
            Ok(sketch) => {
                let memory = memory(&sketch);
                // Later particles may never come: the plan is printed before a lack of memory is reported.
                if memory.start.max(LEAST_EACH * grains) > machine.total {
                    check_fit(scene, &sketch, &memory, machine)
                        .map_err(|error| SceneErrors(vec![error]))?;
                }
            }
            Err(errors) if grains * LEAST_EACH > machine.total => return Err(errors),
            // Errors are reported for all sites.
            Err(_) => {}
        }
    }
    let plan = plan(scene)?;
    let memory = memory(&plan);
    Ok((plan, memory))
}

/// Refuses a run that takes more memory than the machine has. The present free memory does not count, as it may change while the
/// run goes on.
///
/// # Errors
/// The memory needed, the memory of the machine, the largest parts, and advice.
pub fn check_fit(
    scene: &Scene,
    plan: &Plan,
    memory: &Memory,
    machine: MachineMemory,
) -> Result<(), SceneError> {
    if memory.peak() <= machine.total {
        return Ok(());
    }
    let mut message = format!(
        "the run is expected to need {} of memory, and this machine has {}",
        bytes(memory.peak()),
        bytes(machine.total)
    );
    let largest = largest(scene, plan);
    if let Some(largest) = &largest {
        let bring = if largest.is_certain {
            "has"
        } else {
            "brings up to"
        };
        message += &format!(
            "; {} {bring} {} of its {} spheres",
            largest.what,
            count(largest.spheres.round() as u64),
            count(memory.spheres.round() as u64)
        );
    }
    let place = largest.map_or(&scene.place, |largest| largest.place);
    Err(place.error(message).with_help(
        "fewer or larger particles (are the units of lengths right?), or a larger machine; --force-memory runs it all the same",
    ))
}

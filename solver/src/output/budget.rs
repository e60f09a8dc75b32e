//! The energy budget: the energies of the particles, the work and the losses since the start, and the error of the balance.

use mercury_pictures::{EnergyFlows, EnergyRow};

use crate::membranes::output::sheet_energies;
use crate::plan::{NewBody, NewParticle};
use mercury_engine::boundaries::Tally;
use mercury_engine::physics::Physics;
use mercury_engine::step::Engine;

/// The gains and losses up to a given time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Exchanged {
    /// By insertions.
    pub inserted: Tally,
    /// By deletions and through faces of the domain.
    pub removed: Tally,
    /// Mass of liquid from outside of the particles, where it has any, kg.
    pub liquid_mass: f64,
    /// Energy that droplets, and liquid with mass, brought to particles, J.
    pub liquid_energy: f64,
}

mercury_engine::state::plain!(Exchanged {
    inserted,
    removed,
    liquid_mass,
    liquid_energy
});

impl Exchanged {
    /// By now.
    #[must_use]
    pub fn by_now(engine: &Engine) -> Self {
        let [of_liquid, of_sprays] = engine.liquid_brought();
        Self {
            inserted: engine.boundaries().inserted(),
            removed: engine.boundaries().removed(),
            liquid_mass: of_liquid[0] + of_sprays[0],
            liquid_energy: of_liquid[1] + of_sprays[1],
        }
    }
}

/// The energy balance since the first state, J; `None` if the plan does not include the budget. `at_start`: the terms before the
/// first state.
#[must_use]
pub fn energy_flows(engine: &Engine, at_start: &Exchanged) -> Option<EnergyFlows> {
    let physics = engine.physics();
    if !physics.energy_budget {
        return None;
    }
    let audit = engine.audit();
    // Velocities of particles that come and go are half a step older than their places. The energy that they carry is that at the
    // time of their velocities.
    let half = 0.5 * physics.time_step;
    let carried = |tally: &Tally| {
        let moment = tally.mass_moment - tally.momentum * half;
        tally.kinetic + tally.rotational - physics.gravity.dot(moment)
    };
    let now = Exchanged::by_now(engine);
    Some(EnergyFlows {
        dissipated: audit.losses.into_list(),
        wall_work: audit.wall_work,
        servo_work: audit.servo_work,
        inserted: carried(&now.inserted) - carried(&at_start.inserted)
            + (now.liquid_energy - at_start.liquid_energy),
        deleted: carried(&now.removed) - carried(&at_start.removed) + audit.left.total(),
        deleted_elastic: audit.left.total(),
        vanished_walls: audit.vanished.total(),
        sheets: sheet_energies(engine),
    })
}

/// Whether all work done on the particles is measured: prescribed motion of particles takes work that is not measured, and where
/// gravity acts along a periodic axis, particles fall for ever while their height within the domain does not change.
#[must_use]
pub fn is_closed(physics: &Physics) -> bool {
    let mut particles = physics.particles.iter();
    let driven = particles.any(NewParticle::is_prescribed);
    let driven = driven || physics.bodies.iter().any(NewBody::is_prescribed);
    let falls_for_ever =
        (0..3).any(|axis| physics.cell.is_periodic(axis) && physics.gravity[axis] != 0.0);
    !driven && !falls_for_ever
}

/// The budget at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct BudgetRow {
    /// Energies, and the balance of all gains and losses.
    pub energies: EnergyRow,
    /// By how much the budget fails to close.
    pub gap: Option<Gap>,
}

/// By how much a budget fails to close.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// The error of the balance, J: the energy of the first state and all gains since, less all losses, less the present energy.
    pub error: f64,
    /// Balance error over the largest term of the budget since the start; 0 if all were 0.
    pub relative: f64,
}

/// The largest term of a budget, J; of gravitational energy the change since `first`, as it has no zero of its own.
pub(super) fn largest_term(row: &EnergyRow, first: &EnergyRow) -> f64 {
    let none = EnergyFlows::default();
    let flows = row.flows.as_ref().unwrap_or(&none);
    let of_first = first.flows.as_ref().unwrap_or(&none);
    [
        row.kinetic,
        row.rotational,
        row.elastic,
        row.gravitational - first.gravitational,
        flows.wall_work,
        flows.inserted,
        flows.deleted,
        flows.vanished_walls,
        flows.all_dissipated(),
        flows.sheets.kinetic,
        flows.sheets.stretching,
        flows.sheets.bending,
        flows.sheets.gravitational - of_first.sheets.gravitational,
        flows.sheets.pressure_work,
        flows.sheets.hold_work,
    ]
    .into_iter()
    .fold(0.0, |largest: f64, energy| largest.max(energy.abs()))
}

/// The gap of a budget whose largest term so far is `largest` (J).
pub(super) fn gap(row: &EnergyRow, first: &EnergyRow, largest: f64) -> Option<Gap> {
    let error = first.stored() - row.stored() - row.flows.as_ref()?.taken();
    let relative = if largest > 0.0 { error / largest } else { 0.0 };
    Some(Gap { error, relative })
}

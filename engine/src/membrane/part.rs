//! Sheets in a step: their vertices are kicked and drift, their meshes follow, and what acts inside them is added to what contacts do.

use std::sync::Arc;

use super::{Fault, Gap, HoldCourse, MembraneNow, MembranePlan, Moment, STRETCHES, SavedMembrane};
use crate::contact::parameter::short;
use crate::forces::{NewList, Observation, StepContext};
use crate::guard::{GuardPolicy, SEEN};
use crate::physics::{
    FeaturePlan, InputError, Inputs, Physics, Plans, Setup, number, positive, present,
};
use crate::state::{Pieces, Plain};
use crate::step::{Core, CriticalStep, Engine, Part, RunError, SizeEstimate};
use crate::surface::Surface;

/// Mechanics of the sheets of a core.
pub(crate) struct Membranes {
    /// The mechanics of the sheets, one for each.
    all: Vec<MembraneNow>,
    /// Whether particles of the present candidate list are near each wall.
    is_near: Vec<bool>,
    /// Whether the mesh of each sheet was left behind, as no particle is near.
    stale: Vec<bool>,
    /// Whether each row is near a sheet by the present candidate list; empty where that is not known.
    beside: Vec<bool>,
}

/// The sheets of a core, their plans, and what their mechanics depend on.
fn sheets<'a>(
    physics: &'a Physics,
    core: &'a mut Core,
) -> (&'a [MembranePlan], &'a mut [Surface], Moment<'a>) {
    let (time, has_pool, width) = (core.time(), core.pool().is_some(), core.width());
    let (surfaces, walls, cell) = core.domain.sheets();
    let at = Moment {
        time,
        dt: physics.time_step,
        gravity: physics.gravity,
        walls,
        cell,
        has_pool,
        width,
    };
    (physics.plans.all(), surfaces, at)
}

impl FeaturePlan for MembranePlan {
    fn check(plans: &[Self], inputs: &Inputs) -> Result<(), InputError> {
        let count = inputs.materials.len();
        for (index, Self { surface, .. }) in plans.iter().enumerate() {
            let name = &surface.name;
            let material = surface.material.number();
            present("surface", index, "material", material, count)?;
            positive(&format!("the thickness of {name}"), surface.thickness)?;
            for &vertex in surface.triangles.iter().flatten() {
                let vertices = surface.vertices.len();
                let what = format!("{name}, surface");
                present(&what, index, "vertex", vertex, vertices)?;
            }
            if surface.masses.len() != surface.vertices.len() {
                let (what, found) = (format!("the masses of {name}"), surface.masses.len());
                return Err(number(&what, "one for each vertex", found));
            }
            // Those that are held have an infinite one.
            let is_wrong = |mass: &&f64| mass.is_nan() || **mass <= 0.0;
            if let Some(mass) = surface.masses.iter().find(is_wrong) {
                return Err(number(
                    &format!("a mass of {name}"),
                    "a number above 0",
                    mass,
                ));
            }
            if surface.touches_walls && (inputs.laws.has_liquid() || inputs.laws.has_dry_cohesion())
            {
                let what = format!("walls of {name}");
                return Err(number(&what, "off in scenes with liquid or adhesion", "on"));
            }
        }
        Ok(())
    }
}

impl Part for Membranes {
    fn name(&self) -> &str {
        "membranes"
    }

    /// Holds act from the start.
    fn of(core: &mut Core) -> Option<Self> {
        let (is_near, stale) = (
            vec![true; core.domain.walls.len()],
            vec![false; core.domain.surfaces.len()],
        );
        let physics = Arc::clone(core.physics());
        let (plans, surfaces, at) = sheets(&physics, core);
        let all = plans.iter().zip(&mut *surfaces);
        let all = all
            .map(|(plan, surface)| MembraneNow::new(plan, surface, &at))
            .collect();
        (!surfaces.is_empty()).then_some(Self {
            all,
            is_near,
            stale,
            beside: Vec::new(),
        })
    }

    /// That of the sheet that sets it. Sheets that are held all over have none, as they move by their holds.
    fn critical_step(plans: &Plans) -> Option<CriticalStep> {
        let plans = plans.all::<MembranePlan>().iter();
        let free = plans.filter(|plan| !plan.is_all_held());
        let steps = free.map(|plan| CriticalStep {
            time: plan.rates().critical_step(),
            of: format!("membranes.{}", plan.surface.name),
            way_out: "soften the sheet, or coarsen its mesh",
        });
        steps.min_by(|one, other| one.time.total_cmp(&other.time))
    }

    /// Sheets, their mechanics and their meshes.
    fn bytes(setup: &Setup, _: &SizeEstimate) -> f64 {
        let plans = setup.physics.plans.all::<MembranePlan>().iter();
        plans
            .map(|plan| {
                Surface::bytes_of(&plan.surface) + plan.sheet.bytes() + MembraneNow::bytes_of(plan)
            })
            .sum()
    }

    /// A mesh that no particle is near is left where it was until the candidate list is built.
    fn advance(&mut self, core: &mut Core, kicks: u32, drift: f64) -> Result<(), RunError> {
        let physics = Arc::clone(core.physics());
        let (plans, surfaces, at) = sheets(&physics, core);
        for (number, surface) in surfaces.iter_mut().enumerate() {
            self.all[number].advance(&plans[number], surface, (kicks, drift), &at);
        }
        if drift == 0.0 {
            return Ok(());
        }
        let first = physics.walls.len();
        // Others than contacts look for walls, too.
        let speeds = core
            .domain
            .surfaces
            .iter()
            .map(|sheet| sheet.squared_speed.sqrt());
        let fastest = speeds.fold(core.fastest(), f64::max);
        let is_fast =
            !core.particles.is_empty() && fastest * drift > SEEN * physics.smallest_radius();
        let all = is_fast || core.needs().all_walls || core.boundaries().expects_more();
        for number in 0..core.domain.surfaces.len() {
            if all || self.is_near[first + number] {
                self.follow(core, number)?;
            } else {
                let way = core.domain.surfaces[number].way_since_listed();
                core.domain.walls[first + number].note_way(way);
                self.stale[number] = true;
            }
        }
        Ok(())
    }

    /// Meshes that were left behind follow.
    fn before_list(&mut self, core: &mut Core) -> Result<(), RunError> {
        if core.particles.is_empty() {
            return Ok(());
        }
        let first = core.physics().walls.len();
        for number in 0..core.domain.surfaces.len() {
            if self.stale[number] {
                self.follow(core, number)?;
            }
            core.domain.walls[first + number].fit();
        }
        Ok(())
    }

    fn new_list(&mut self, list: &NewList<'_>) {
        self.is_near.fill(false);
        self.beside.clear();
        self.beside.resize(list.particles.len(), false);
        let first = self.is_near.len() - self.stale.len();
        for near in list.near_walls {
            let wall = near.wall.index();
            self.is_near[wall] = true;
            self.beside[near.row as usize] |= wall >= first;
        }
    }

    fn works_on_ranks(&self) -> bool {
        true
    }

    /// Every rank moves all sheets. A sheet is near grains where it is near those of any rank.
    fn take_share(&mut self, core: &mut Core) {
        let numbers = |are: &[bool]| -> Vec<u32> {
            let numbers = (0..).zip(are).filter(|(_, is)| **is);
            numbers.map(|(number, _)| number).collect()
        };
        for are in [&mut self.is_near, &mut self.beside] {
            let mut all = numbers(are);
            core.join_ranks(&mut all);
            all.iter().for_each(|&number| are[number as usize] = true);
        }
    }

    fn inform<'a>(&'a self, context: &mut StepContext<'a>) {
        context.beside_sheets = Some(&self.beside);
    }

    /// Forces inside the sheets, pressure and drag, for the positions of the present step and the velocities of half a step before; then
    /// holds begin or end.
    fn add_loads(&mut self, core: &mut Core) {
        let since = core.since_last();
        let physics = Arc::clone(core.physics());
        let (plans, surfaces, at) = sheets(&physics, core);
        for ((plan, surface), membrane) in plans.iter().zip(surfaces).zip(&mut self.all) {
            membrane.add_forces(plan, surface, since, &at);
            membrane.update_holds(plan, surface, &at);
        }
    }

    /// Sheets that are stretched or turned beyond the limits stop the run, or are counted.
    fn end_step(&mut self, core: &mut Core) -> Result<(), RunError> {
        let physics = core.physics();
        let policy = physics.guard.policy;
        let plans = physics.plans.all::<MembranePlan>().iter();
        let plans = plans.zip(&core.domain.surfaces);
        for (membrane, (plan, surface)) in self.all.iter_mut().zip(plans) {
            let Some(fault) = membrane.fault(plan, surface) else {
                continue;
            };
            let is_lost = matches!(fault, Fault::NotFinite { .. });
            if policy == GuardPolicy::Strict || is_lost {
                let name = &plan.surface.name;
                return Err(RunError::Guarded {
                    step: core.steps(),
                    time: core.time(),
                    what: format!("membranes.{name}: {}", words_of(&fault, surface)),
                    help: "the time step is too large for the sheet, or its loads are too large for its stiffness, or a hold is too fast; or go on with guard.policy = \"warn\"".to_owned(),
                });
            }
            if policy == GuardPolicy::Warn {
                membrane.faults += 1;
            }
        }
        Ok(())
    }

    /// The load of sheets on walls that hold their vertices is part of the loads of these walls, and of what servos meet.
    fn observe(&self, core: &Core, observation: &mut Observation) {
        let plans = core.physics().plans.all().iter().zip(&core.domain.surfaces);
        for ((plan, surface), membrane) in plans.zip(&self.all) {
            let walls = core.physics().walls.iter().enumerate();
            for (number, wall) in walls.filter(|_| core.has_servos()) {
                let sum = &mut observation.wall_stiffness[number];
                for (_, axis) in wall.motion.servos(core.time()) {
                    membrane.add_answer((plan, surface), (number, axis), sum);
                }
            }
            for (wall, (load, power)) in observation.walls.iter_mut().enumerate() {
                let state = &core.domain.walls[wall].state;
                let Some((force, torque)) = membrane.load_on_wall(plan, wall, state.reference)
                else {
                    continue;
                };
                load.add(force, torque);
                let at_reference = state.velocity.at(state.reference);
                *power -= force.dot(at_reference) + torque.dot(state.velocity.angular_velocity);
            }
        }
    }

    fn warnings(&self, core: &Core) -> Vec<String> {
        let plans = core.physics().plans.all::<MembranePlan>().iter();
        let sheets = plans.zip(&self.all);
        let faults = (sheets.clone())
            .filter(|(_, membrane)| membrane.faults > 0)
            .map(|(plan, membrane)| {
                format!(
                    "membranes.{}: in {} steps an edge was shorter than {} or longer than {} of its length at rest, or a triangle turned over",
                    plan.surface.name, membrane.faults, STRETCHES[0], STRETCHES[1]
                )
            });
        let gaps = sheets.flat_map(|(plan, membrane)| {
            let words = |gap: &Gap| words_of_gap(core, plan, gap);
            membrane.gaps.iter().map(words)
        });
        faults.chain(gaps).collect()
    }

    fn put(&self, _: &Core, pieces: &mut Pieces) {
        let saved: Vec<_> = self.all.iter().map(MembraneNow::save).collect();
        saved.put(pieces.end());
    }

    fn take(&mut self, core: &mut Core, bytes: &mut &[u8]) -> Result<(), String> {
        let saved: Vec<SavedMembrane> = Plain::take(bytes)?;
        if saved.len() != self.all.len() {
            let (found, planned) = (saved.len(), self.all.len());
            return Err(format!(
                "it has the mechanics of {found} membranes, the plan of {planned}"
            ));
        }
        let plans = core.physics().plans.all().iter().zip(&core.domain.surfaces);
        for (((plan, surface), membrane), saved) in plans.zip(&mut self.all).zip(&saved) {
            membrane.restore(plan, surface, saved)?;
        }
        Ok(())
    }
}

impl Engine {
    /// The mechanics of the sheets, in the order of the plan.
    #[must_use]
    pub fn membranes(&self) -> &[MembraneNow] {
        self.part::<Membranes>().map_or(&[], |part| &part.all)
    }
}

impl Membranes {
    /// Puts the mesh of a sheet to where its vertices are.
    fn follow(&mut self, core: &mut Core, number: usize) -> Result<(), RunError> {
        let (cell, pool) = (*core.cell(), core.pool().cloned());
        let surface = &core.domain.surfaces[number];
        let (corners, way) = (surface.corners(), surface.way_since_listed());
        let first = core.physics().walls.len();
        let wall = &mut core.domain.walls[first + number];
        // Triangles that were left behind for many steps may have turned.
        let is_stale = std::mem::take(&mut self.stale[number]);
        let mut follow = || {
            if is_stale {
                wall.follow_anew(&corners, way, &cell)
            } else {
                wall.follow(&corners, way, &cell)
            }
        };
        let followed = match pool {
            Some(pool) => pool.install(follow),
            None => follow(),
        };
        followed.map_err(|error| RunError::Surface {
            surface: core.domain.surfaces[number].plan().name.clone(),
            step: core.steps(),
            time: core.time(),
            error,
        })
    }
}

fn words_of_gap(core: &Core, plan: &MembranePlan, gap: &Gap) -> String {
    let name = &plan.surface.name;
    let hold = &plan.holds[gap.hold as usize];
    let wall = match hold.ramp {
        HoldCourse::Wall(wall) => core.physics().walls.get(wall),
        _ => None,
    };
    let distance = if gap.distance.is_finite() {
        format!("{} m", short(gap.distance))
    } else {
        "more than the length of the domain".to_owned()
    };
    format!(
        "membranes.{name}: the hold `{}` began at {} s, when its vertex {} was {distance} away from wall `{}`, farther than an edge is long: the sheet may leak or fold there; let it begin (`from`) where the two meet, or make the sheet end at the wall",
        hold.name,
        short(gap.time),
        gap.vertex,
        wall.map_or("", |wall| &wall.name)
    )
}

fn words_of(fault: &Fault, surface: &Surface) -> String {
    let at = |vertex: u32| {
        let [x, y, z] = surface.positions[vertex as usize].to_array().map(short);
        format!("[{x}, {y}, {z}] m")
    };
    match *fault {
        Fault::Stretch { ends, stretch } => format!(
            "the edge between the vertices {} and {}, at {}, has {} of its length at rest; {} to {} are allowed",
            ends[0],
            ends[1],
            at(ends[0]),
            short(stretch),
            STRETCHES[0],
            STRETCHES[1]
        ),
        Fault::TurnedOver { triangle } => format!(
            "triangle {triangle}, at {}, turned over within a step",
            at(surface.triangles()[triangle as usize][0])
        ),
        Fault::NotFinite { vertex } => format!("the position of vertex {vertex} is not finite"),
    }
}

//! The bonds in a step.

use std::array::from_fn;
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;

use super::bond::{Bond, Break, BreakMode, Surroundings};
use super::element::Action;
use super::evaluation::Motion;
use super::gluing::{at_start, to_wall};
use super::groups::Groups;
use super::{BondPlan, BondedStart, Gluing};
use crate::audit::Moving;
use crate::forces::{Needs, NewList, Observation, OverlapOffsets, StepContext};
use crate::physics::{FeaturePlan, Plans, Setup};
use crate::state::{Particles, Pieces, Plain, Row, Unpaired};
use crate::step::{Core, CriticalStep, Leaving, Part, RunError, SizeEstimate};
use crate::walls::RigidVelocity;

/// Counts of the bonds of an entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct BondCounts {
    /// Glued since the start.
    pub made: u64,
    /// Broken since the start, also by the removal of an end.
    pub broken: u64,
}

impl BondCounts {
    /// Those that hold.
    #[must_use]
    pub fn left(self) -> u64 {
        self.made - self.broken
    }
}

/// An overlap that the contact of a glued pair does not count, until the two part.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Offset {
    ids: [u32; 2],
    is_wall: bool,
    rows: [u32; 2],
    /// m
    overlap: f64,
    /// Whether the bond holds: the offset outlives it.
    is_glued: bool,
}

/// A touch that may be glued, and the image of the second by which it is.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Candidate {
    rows: [u32; 2],
    image: u32,
}

/// The part of the step that has the bonds.
#[derive(Debug, Default)]
pub struct Bonds {
    /// In the order in which they were glued; those of one time by the ids of their ends.
    all: Groups,
    offsets: Vec<Offset>,
    /// Pairs of ids that were glued, with walls apart, where touches are glued: each is glued once.
    glued: BTreeSet<(bool, [u32; 2])>,
    counts: Vec<BondCounts>,
    /// Bonds that broke since they were taken last.
    breaks: Vec<Break>,
    /// Taken by damping, and set free by breaks, J.
    taken: f64,
    /// Done by walls on the particles that are glued to them, and the share of walls with servos, J.
    wall_work: [f64; 2],
    /// Power of the damping, of walls and of walls with servos at the last forces, W.
    last_powers: [f64; 3],
    /// Time of the present step, s.
    time: f64,
    /// Offsets as the contact loop reads them.
    informed: OverlapOffsets,
    /// Pairs that may touch by the present list; only where touches are glued.
    candidates: Vec<Candidate>,
    /// Rows and walls that may touch, likewise.
    near_walls: Vec<[u32; 2]>,
    glues_touches: bool,
}

impl FeaturePlan for BondPlan {}

impl FeaturePlan for BondedStart {}

impl Part for Bonds {
    fn name(&self) -> &str {
        "bonds"
    }

    fn of(core: &mut Core) -> Option<Self> {
        let plans = core.physics().plans.all::<BondPlan>();
        let at_touches = |plan: &BondPlan| matches!(plan.when, Gluing::Contact { .. });
        (!plans.is_empty()).then(|| Self {
            counts: vec![BondCounts::default(); plans.len()],
            glues_touches: plans.iter().any(at_touches),
            ..Self::default()
        })
    }

    /// As many bonds as touches, where there are any.
    fn bytes(setup: &Setup, crowd: &SizeEstimate) -> f64 {
        if setup.physics.plans.get::<BondPlan>().is_none() {
            return 0.0;
        }
        crowd.touching * (Groups::BYTES_OF_BOND + size_of::<Offset>()) as f64
    }

    fn critical_step(plans: &Plans) -> Option<CriticalStep> {
        let least = plans.get::<BondedStart>()?.least.clone()?;
        Some(CriticalStep {
            time: least.time,
            of: least.of,
            way_out: least.way_out,
        })
    }

    fn needs(&self) -> Needs {
        Needs {
            orientations: true,
            after_contacts: true,
            ..Needs::default()
        }
    }

    fn start(&mut self, core: &mut Core) {
        let bonds = {
            let around = surroundings(core);
            at_start(core.physics().plans.all(), core.physics().seed, &around)
        };
        self.add(bonds, core);
    }

    fn after_drift(&mut self, core: &mut Core) {
        self.time = core.time();
    }

    /// Bonds of particles that leave break.
    fn before_leaving(&mut self, at: &mut Leaving<'_>) {
        let leaves: BTreeSet<u32> = at.leavers.iter().map(|(row, _)| *row).collect();
        let ends = |rows: [u32; 2], is_wall: bool| {
            leaves.contains(&rows[0]) || !is_wall && leaves.contains(&rows[1])
        };
        let particles = &*at.particles;
        self.break_where(particles, |bond| {
            ends(bond.rows, bond.is_wall).then_some(BreakMode::Deletion)
        });
        self.offsets
            .retain(|offset| !ends(offset.rows, offset.is_wall));
    }

    fn new_list(&mut self, list: &NewList<'_>) {
        let rows = RowsOfIds::new(list.particles);
        (self.all).set_rows(|ids, is_wall| rows.of(ids, is_wall));
        for offset in &mut self.offsets {
            offset.rows = rows.of(offset.ids, offset.is_wall);
        }
        self.inform_contacts(list.particles.len());
        if self.glues_touches {
            self.candidates.clear();
            for row in 0..list.particles.len() {
                let range = list.pairs.start[row] as usize..list.pairs.start[row + 1] as usize;
                let found = list.pairs.entries[range].iter().map(|entry| Candidate {
                    rows: [row as u32, entry.partner],
                    image: entry.image,
                });
                self.candidates.extend(found);
            }
            let near = list.near_walls.iter();
            let near = near.map(|near| [near.row, u32::from(near.wall.number())]);
            self.near_walls = near.collect();
            self.near_walls.dedup();
        }
    }

    fn before_forces(&mut self, core: &mut Core) -> Result<(), RunError> {
        if self.glues_touches {
            self.glue_touches(core);
        }
        Ok(())
    }

    fn inform<'a>(&'a self, context: &mut StepContext<'a>) {
        if !self.informed.is_empty() {
            context.offsets = Some(&self.informed);
        }
    }

    fn add_loads(&mut self, core: &mut Core) {
        let walls = &core.domain.walls;
        let is_gone = |wall: u32| !walls[wall as usize].state.present;
        let mut broken = self.all.walls().iter().any(|&wall| is_gone(wall))
            && self.break_where(&core.particles, |bond| {
                (bond.is_wall && is_gone(bond.rows[1])).then_some(BreakMode::Deletion)
            });
        let parallel = rayon::current_thread_index().is_some();
        if self.all.act(&surroundings(core), core.width(), parallel) {
            broken |= self.break_where(&core.particles, Bond::breaks);
        }
        self.all.add_loads(&mut core.particles.loads);
        let parted = self.forget_parted(core);
        if broken {
            // Pairs that had no contact meet from the next list on.
            self.exclude(core);
        }
        if parted {
            self.inform_contacts(core.particles.len());
        }
    }

    fn after_forces(&mut self, core: &mut Core, _: Option<&Observation>) {
        if core.physics().energy_budget {
            self.take_powers(core);
        }
    }

    fn observe(&self, core: &Core, observation: &mut Observation) {
        observation.elastic_energy += self.all.elastic_energy();
        for bond in self.all.at_walls() {
            let number = bond.rows[1] as usize;
            if let Some((load, power)) = observation.walls.get_mut(number) {
                let wall = &core.domain.walls[number];
                let point = bond.point_of_wall(wall);
                let [force, couple] = [-bond.now.force, bond.now.couples[1]];
                load.add(force, couple + (point - wall.state.reference).cross(force));
                let moves = &wall.state.velocity;
                *power -= force.dot(moves.at(point)) + couple.dot(moves.angular_velocity);
            }
            if core.has_servos() {
                let record = &core.particles.records[bond.rows[0] as usize];
                let wall = core.physics().walls.get(number);
                let servos = wall
                    .into_iter()
                    .flat_map(|wall| wall.motion.servos(core.time()));
                for (_, axis) in servos {
                    let [stiffness, dashpot] = bond.element.along(bond.branch, axis);
                    let mass = record.inverse_mass.recip();
                    observation.wall_stiffness[number].add_spring(mass, stiffness, dashpot);
                }
            }
        }
    }

    fn dissipated(&self) -> Option<f64> {
        Some(self.taken)
    }

    fn wall_work(&self) -> [f64; 2] {
        self.wall_work
    }

    fn put(&self, _: &Core, pieces: &mut Pieces) {
        let bytes = pieces.end();
        self.all().put(bytes);
        self.offsets.put(bytes);
        let glued: Vec<_> = self.glued.iter().copied().collect();
        glued.put(bytes);
        self.counts.put(bytes);
        self.breaks.put(bytes);
        (self.taken, self.wall_work).put(bytes);
        self.last_powers.put(bytes);
        self.near_walls.put(bytes);
        self.candidates.put(bytes);
    }

    fn take(&mut self, core: &mut Core, bytes: &mut &[u8]) -> Result<(), String> {
        let all: Vec<Bond> = Plain::take(bytes)?;
        self.offsets = Plain::take(bytes)?;
        let glued: Vec<(bool, [u32; 2])> = Plain::take(bytes)?;
        self.glued = glued.into_iter().collect();
        let counts: Vec<BondCounts> = Plain::take(bytes)?;
        self.breaks = Plain::take(bytes)?;
        (self.taken, self.wall_work) = Plain::take(bytes)?;
        self.last_powers = Plain::take(bytes)?;
        self.near_walls = Plain::take(bytes)?;
        self.candidates = Plain::take(bytes)?;
        let (rows, walls) = (core.particles.len() as u32, core.domain.walls.len() as u32);
        let plans = self.counts.len();
        let is_there = |ends: [u32; 2], is_wall: bool| {
            ends[0] < rows && ends[1] < if is_wall { walls } else { rows }
        };
        let bonds = (all.iter())
            .all(|bond| is_there(bond.rows, bond.is_wall) && (bond.plan as usize) < plans);
        let offsets = (self.offsets.iter()).all(|offset| is_there(offset.rows, offset.is_wall));
        let breaks = (self.breaks.iter()).all(|broken| (broken.plan as usize) < plans);
        let candidates = (self.candidates.iter()).all(|pair| is_there(pair.rows, false));
        let near_walls = (self.near_walls.iter()).all(|&pair| is_there(pair, true));
        let possible = (counts.iter()).all(|counts| counts.broken <= counts.made);
        let next = core.particles.next_id;
        let known = |ids: [u32; 2], is_wall: bool| ids[0] < next && (is_wall || ids[1] < next);
        let ids = (all.iter()).all(|bond| known(bond.ids, bond.is_wall))
            && (self.offsets.iter()).all(|offset| known(offset.ids, offset.is_wall));
        if !(ids && bonds && offsets && breaks && candidates && near_walls && possible)
            || counts.len() != plans
        {
            return Err(
                "it has bonds of particles, walls or entries that are not there".to_owned(),
            );
        }
        self.all = Groups::new(&all);
        self.counts = counts;
        core.particles.unpaired = self.unpaired(core.physics().plans.all());
        self.inform_contacts(core.particles.len());
        Ok(())
    }
}

impl Bonds {
    /// The bonds that hold, in the order in which they were glued.
    #[must_use]
    pub fn all(&self) -> Vec<Bond> {
        self.all.iter().collect()
    }

    /// Counts of the bonds of each entry.
    #[must_use]
    pub fn counts(&self) -> &[BondCounts] {
        &self.counts
    }

    /// Bonds that broke since the last call.
    pub fn take_breaks(&mut self) -> Vec<Break> {
        std::mem::take(&mut self.breaks)
    }

    /// Fragments by the number of their grains: grains that hang together by bonds; a body is one grain.
    #[must_use]
    pub fn fragments(&self, particles: &Particles) -> BTreeMap<u64, u64> {
        let mut parent: Vec<u32> = (0..particles.len() as u32).collect();
        if let Some(bodies) = &particles.bodies {
            for body in &bodies.all {
                let pebbles = &bodies.pebbles[body.pebbles()];
                let first = pebbles[0].row.index() as u32;
                (pebbles.iter()).for_each(|pebble| parent[pebble.row.index()] = first);
            }
        }
        let is_grain: Vec<bool> = parent
            .iter()
            .zip(0..)
            .map(|(root, row)| *root == row)
            .collect();
        let root = |parent: &mut Vec<u32>, mut row: u32| {
            while parent[row as usize] != row {
                let next = parent[parent[row as usize] as usize];
                parent[row as usize] = next;
                row = next;
            }
            row
        };
        for bond in self.all.iter().filter(|bond| !bond.is_wall) {
            let [a, b] = bond.rows.map(|row| root(&mut parent, row));
            parent[a.max(b) as usize] = a.min(b);
        }
        let mut grains: BTreeMap<u32, u64> = BTreeMap::new();
        for row in (0..particles.len() as u32).filter(|row| is_grain[*row as usize]) {
            *grains.entry(root(&mut parent, row)).or_default() += 1;
        }
        let mut sizes = BTreeMap::new();
        for size in grains.into_values() {
            *sizes.entry(size).or_default() += 1;
        }
        sizes
    }

    /// Takes new bonds, with the overlaps that their contacts do not count.
    fn add(&mut self, bonds: Vec<Bond>, core: &mut Core) {
        let physics = std::sync::Arc::clone(core.physics());
        let plans = physics.plans.all::<BondPlan>();
        let known = self.offsets.iter().zip(0..);
        let mut places: BTreeMap<_, usize> = known
            .map(|(offset, place)| ((offset.is_wall, offset.ids), place))
            .collect();
        for bond in &bonds {
            let plan = &plans[bond.plan as usize];
            self.counts[bond.plan as usize].made += 1;
            if self.glues_touches {
                self.glued.insert((bond.is_wall, bond.ids));
            }
            let reach = reach(&core.particles, bond.rows, bond.is_wall);
            let overlap = reach - bond.element.length;
            if plan.contact && overlap > 0.0 {
                // A pair that has an offset from an earlier bond keeps the larger one.
                match places.entry((bond.is_wall, bond.ids)) {
                    Entry::Occupied(place) => {
                        let offset = &mut self.offsets[*place.get()];
                        offset.overlap = offset.overlap.max(overlap);
                        offset.is_glued = true;
                    }
                    Entry::Vacant(place) => {
                        place.insert(self.offsets.len());
                        self.offsets.push(Offset {
                            ids: bond.ids,
                            is_wall: bond.is_wall,
                            rows: bond.rows,
                            overlap,
                            is_glued: true,
                        });
                    }
                }
            }
        }
        let all: Vec<Bond> = self.all.iter().chain(bonds).collect();
        self.all = Groups::new(&all);
        self.exclude(core);
        self.inform_contacts(core.particles.len());
    }

    /// Names the pairs without contact to the next list, which is made at once if they have changed.
    fn exclude(&self, core: &mut Core) {
        let unpaired = self.unpaired(core.physics().plans.all());
        if unpaired != core.particles.unpaired {
            core.particles.unpaired = unpaired;
            core.lists_are_stale();
        }
    }

    /// Glued pairs that have no contact.
    fn unpaired(&self, plans: &[BondPlan]) -> Unpaired {
        let of = |is_wall: bool| {
            let bonds = self.all.iter();
            let alone = bonds
                .filter(move |bond| bond.is_wall == is_wall && !plans[bond.plan as usize].contact);
            alone.map(|bond| bond.rows)
        };
        Unpaired::new(of(false), of(true))
    }

    /// Gives the contact loop the overlaps that it does not count.
    fn inform_contacts(&mut self, rows: usize) {
        let of = |is_wall: bool| {
            let offsets = self.offsets.iter();
            let wanted = offsets.filter(move |offset| offset.is_wall == is_wall);
            wanted.map(move |offset| {
                let [a, b] = offset.rows;
                let rows = if is_wall {
                    [a, b]
                } else {
                    [a.min(b), a.max(b)]
                };
                (rows, offset.overlap)
            })
        };
        self.informed = if self.offsets.is_empty() {
            OverlapOffsets::default()
        } else {
            OverlapOffsets::new(rows, of(false).collect(), of(true).collect())
        };
    }

    /// Breaks the bonds that a function names; returns whether there are any.
    fn break_where(
        &mut self,
        particles: &Particles,
        breaks: impl Fn(&Bond) -> Option<BreakMode>,
    ) -> bool {
        let before = self.breaks.len();
        let mut kept = Vec::with_capacity(self.all.len());
        for bond in self.all.iter() {
            let Some(mode) = breaks(&bond) else {
                kept.push(bond);
                continue;
            };
            self.counts[bond.plan as usize].broken += 1;
            self.breaks.push(Break {
                time: self.time,
                ids: bond.ids,
                is_wall: bond.is_wall,
                plan: bond.plan,
                mode,
                position: particles.records[bond.rows[0] as usize].position + 0.5 * bond.branch,
                energy: bond.released(mode),
            });
        }
        let broken = &self.breaks[before..];
        if broken.is_empty() {
            return false;
        }
        self.all = Groups::new(&kept);
        self.taken += broken.iter().map(|broken| broken.energy).sum::<f64>();
        if !self.offsets.is_empty() {
            let gone: BTreeSet<_> = broken.iter().map(|gone| (gone.is_wall, gone.ids)).collect();
            for offset in &mut self.offsets {
                offset.is_glued &= !gone.contains(&(offset.is_wall, offset.ids));
            }
        }
        true
    }

    /// Forgets the offsets of broken pairs that have parted; returns whether there were any.
    fn forget_parted(&mut self, core: &Core) -> bool {
        let before = self.offsets.len();
        let (particles, cell) = (&core.particles, core.cell());
        self.offsets.retain(|offset| {
            if offset.is_glued {
                return true;
            }
            let [row, other] = offset.rows.map(|row| row as usize);
            let reach = reach(particles, offset.rows, offset.is_wall);
            let record = &particles.records[row];
            if offset.is_wall {
                return to_wall(record, &core.domain.walls[other], reach, cell).is_some();
            }
            let way = particles.records[other].position - record.position;
            cell.min_image(way, DVec3::ZERO).0.length() < reach
        });
        self.offsets.len() < before
    }

    /// Glues pairs at their first touch.
    fn glue_touches(&mut self, core: &mut Core) {
        let physics = std::sync::Arc::clone(core.physics());
        let (time, seed) = (core.time(), physics.seed);
        let around = surroundings(core);
        let particles = around.particles;
        let records = &particles.records;
        let id = |row: u32| particles.ids[row as usize].number();
        let mut bonds = Vec::new();
        for (number, plan) in physics.plans.all::<BondPlan>().iter().enumerate() {
            let Gluing::Contact { from, until } = plan.when else {
                continue;
            };
            if time < from || time >= until {
                continue;
            }
            let mut found = Vec::new();
            for pair in &self.candidates {
                let [mut row, mut other] = pair.rows;
                let (a, b) = (&records[row as usize], &records[other as usize]);
                let mut branch = b.position + around.cell.shift(pair.image) - a.position;
                let reach = a.radius + b.radius;
                if branch.length_squared() >= reach * reach
                    || !plan.fits([row as usize, other as usize], particles)
                {
                    continue;
                }
                if id(row) > id(other) {
                    (row, other, branch) = (other, row, -branch);
                }
                found.push(((false, [id(row), id(other)]), [row, other], branch));
            }
            for &[row, wall] in &self.near_walls {
                let record = &records[row as usize];
                if plan.walls.contains(&(wall as usize))
                    && plan.fits_wall(record)
                    && let Some(way) = to_wall(
                        record,
                        &around.walls[wall as usize],
                        record.radius,
                        around.cell,
                    )
                {
                    found.push(((true, [id(row), wall]), [row, wall], way));
                }
            }
            found.sort_unstable_by_key(|&(key, ..)| key);
            for (key, rows, branch) in found {
                if self.glued.insert(key) {
                    bonds.push(plan.glue(number, rows, key.0, branch, seed, &around));
                }
            }
        }
        if !bonds.is_empty() {
            self.add(bonds, core);
        }
    }

    /// Takes in the powers of damping and of walls at these forces, by the trapezoidal rule.
    fn take_powers(&mut self, core: &Core) {
        let dt = core.since_last();
        let mut powers = [0.0; 3];
        for bond in self.all.iter() {
            let [row, other] = bond.rows.map(|row| Row::new(row as usize));
            let of_row = |row: Row| {
                let record = &core.particles.records[row.index()];
                Moving {
                    velocity: record.velocity,
                    spin: record.angular_velocity,
                }
            };
            let (seen, now) = if bond.is_wall {
                let wall = other.index();
                let point = bond.point_of_wall(&core.domain.walls[wall]);
                let at = |field: &RigidVelocity| Moving {
                    velocity: field.at(point),
                    spin: field.angular_velocity,
                };
                let [before, after] = core.wall_fields(wall, dt).each_ref().map(at);
                let now = Moving {
                    velocity: 0.5 * (before.velocity + after.velocity),
                    spin: 0.5 * (before.spin + after.spin),
                };
                let Action { force, couples, .. } = bond.now;
                let power = force.dot(now.velocity) - couples[1].dot(now.spin);
                powers[1] += power;
                if !core.domain.walls[wall].servos.is_empty() {
                    powers[2] += power;
                }
                (at(&core.domain.walls[wall].state.velocity), now)
            } else {
                (of_row(other), core.moving(other, 0.5 * dt))
            };
            let motion = |a: Moving, b: Moving| Motion {
                velocity: (b.velocity - a.velocity).into(),
                spins: [a.spin.into(), b.spin.into()],
            };
            let seen = motion(of_row(row), seen);
            let now = motion(core.moving(row, 0.5 * dt), now);
            powers[0] += (bond.element).damping_power(bond.branch.into(), &seen, &now);
        }
        if dt > 0.0 {
            let half = 0.5 * dt;
            let [taken, by_walls, by_servos] =
                from_fn(|k| half * (self.last_powers[k] + powers[k]));
            self.taken += taken;
            self.wall_work[0] += by_walls;
            self.wall_work[1] += by_servos;
        }
        self.last_powers = powers;
    }
}

/// Distance (m) below which the two of a pair touch.
fn reach(particles: &Particles, [row, other]: [u32; 2], is_wall: bool) -> f64 {
    let radius = |row: u32| particles.records[row as usize].radius;
    radius(row) + if is_wall { 0.0 } else { radius(other) }
}

fn surroundings(core: &Core) -> Surroundings<'_> {
    Surroundings {
        particles: &core.particles,
        walls: &core.domain.walls,
        cell: core.cell(),
        inverse_inertia: core.inverse_inertia(),
    }
}

/// The rows of particles by their ids.
struct RowsOfIds(Vec<u32>);

impl RowsOfIds {
    fn new(particles: &Particles) -> Self {
        let mut rows = vec![0; particles.next_id as usize];
        for (id, row) in particles.ids.iter().zip(0..) {
            rows[id.number() as usize] = row;
        }
        Self(rows)
    }

    /// Rows of the ends of a bond; those of bonds that hold are there.
    fn of(&self, [id, other]: [u32; 2], is_wall: bool) -> [u32; 2] {
        let row = |id: u32| self.0[id as usize];
        [row(id), if is_wall { other } else { row(other) }]
    }
}

crate::state::plain!(BondCounts { made, broken });
crate::state::plain!(Offset {
    ids,
    is_wall,
    rows,
    overlap,
    is_glued
});
crate::state::plain!(Candidate { rows, image });

//! The bonds in a step.

mod ranks;

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
use ranks::{BondShare, Broken, Occasion};

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
    /// In the order in which they were glued; those of one time by the ids of their ends. Where rows are divided among ranks: those of this one.
    all: Groups,
    /// Where rows are divided among ranks.
    share: Option<BondShare>,
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
    /// Pairs of own rows that may touch by the present list; only where touches are glued.
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
        if let Some(share) = &mut self.share {
            share.forget_whole();
        }
    }

    /// Bonds of particles that leave break.
    fn before_leaving(&mut self, at: &mut Leaving<'_>) {
        let leaves: BTreeSet<u32> = at.leavers.iter().map(|(row, _)| *row).collect();
        let ends = |rows: [u32; 2], is_wall: bool| {
            leaves.contains(&rows[0]) || !is_wall && leaves.contains(&rows[1])
        };
        let particles = &*at.particles;
        self.break_where(particles, Occasion::Leaving, |bond| {
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
            && self.break_where(&core.particles, Occasion::WallGone, |bond| {
                (bond.is_wall && is_gone(bond.rows[1])).then_some(BreakMode::Deletion)
            });
        let parallel = rayon::current_thread_index().is_some();
        if self.all.act(&surroundings(core), core.width(), parallel) {
            broken |= self.break_where(&core.particles, Occasion::Strength, Bond::breaks);
        }
        self.all.add_loads(&mut core.particles.loads);
        let parted = self.forget_parted(core);
        if broken && self.share.is_none() {
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
        observation.elastic_energy += self.whole().elastic_energy();
        for bond in self.whole().at_walls() {
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

    fn works_on_ranks(&self) -> bool {
        true
    }

    fn send_to_ranks(&mut self) -> Vec<u8> {
        let share = self.share.as_mut();
        share.map_or_else(Vec::new, BondShare::send)
    }

    fn receive_from_ranks(
        &mut self,
        core: &mut Core,
        messages: &[Vec<u8>],
    ) -> Result<(), RunError> {
        self.receive(core, messages)
    }

    fn take_share(&mut self, core: &mut Core) {
        self.divide(core);
    }

    fn collect_from_ranks(&mut self, core: &mut Core) {
        self.collect(core);
    }

    fn dissipated(&self) -> Option<f64> {
        Some(self.taken())
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
        (self.taken(), self.wall_work).put(bytes);
        self.last_powers.put(bytes);
        let whole = self.share.as_ref().and_then(BondShare::whole);
        whole
            .map_or(&self.near_walls, |whole| &whole.near_walls)
            .put(bytes);
        whole
            .map_or(&self.candidates, |whole| &whole.candidates)
            .put(bytes);
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
        self.whole().iter().collect()
    }

    /// Energy taken from the particles since the start, J.
    fn taken(&self) -> f64 {
        let last = self.share.as_ref().map_or(0.0, BondShare::last_taken);
        self.taken + last
    }

    /// All bonds that are known here: on the first of several ranks those that were collected.
    fn whole(&self) -> &Groups {
        let whole = self.share.as_ref().and_then(BondShare::whole);
        whole.map_or(&self.all, |whole| &whole.bonds)
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
        for bond in self.whole().iter().filter(|bond| !bond.is_wall) {
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
        if self.share.is_some() {
            self.add_to_share(&bonds, core);
            for bond in &bonds {
                if self.is_alone(core, bond.plan) {
                    core.particles.unpaired.add(bond.rows, bond.is_wall);
                    core.lists_are_stale();
                }
            }
        } else {
            let all: Vec<Bond> = self.all.iter().chain(bonds).collect();
            self.all = Groups::new(&all);
            self.exclude(core);
        }
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
        occasion: Occasion,
        breaks: impl Fn(&Bond) -> Option<BreakMode>,
    ) -> bool {
        let mut broken = Vec::new();
        let mut kept = Vec::with_capacity(self.all.len());
        for (number, bond) in (0..).zip(self.all.iter()) {
            let Some(mode) = breaks(&bond) else {
                kept.push(bond);
                continue;
            };
            let its = Break {
                time: self.time,
                ids: bond.ids,
                is_wall: bond.is_wall,
                plan: bond.plan,
                mode,
                position: particles.records[bond.rows[0] as usize].position + 0.5 * bond.branch,
                energy: bond.released(mode),
            };
            broken.push(Broken {
                occasion,
                number,
                rows: bond.rows,
                its,
            });
        }
        if broken.is_empty() {
            return false;
        }
        self.all = Groups::new(&kept);
        let breaks: Vec<Break> = broken.iter().map(|broken| broken.its.clone()).collect();
        self.loosen_offsets(&breaks);
        match &mut self.share {
            // Counted when all ranks know them.
            Some(share) => share.note_broken(broken),
            None => self.count(&breaks),
        }
        true
    }

    /// Counts bonds that have broken at once.
    fn count(&mut self, broken: &[Break]) {
        for broken in broken {
            self.counts[broken.plan as usize].broken += 1;
        }
        self.taken += broken.iter().map(|broken| broken.energy).sum::<f64>();
        self.breaks.extend_from_slice(broken);
    }

    /// Offsets of bonds that have broken hold until their pairs part.
    fn loosen_offsets(&mut self, broken: &[Break]) {
        if !self.offsets.is_empty() {
            let gone: BTreeSet<_> = broken.iter().map(|gone| (gone.is_wall, gone.ids)).collect();
            for offset in &mut self.offsets {
                offset.is_glued &= !gone.contains(&(offset.is_wall, offset.ids));
            }
        }
    }

    /// Whether pairs that an entry glues have no contact.
    fn is_alone(&self, core: &Core, plan: u32) -> bool {
        !core.physics().plans.all::<BondPlan>()[plan as usize].contact
    }

    /// Forgets the offsets of broken pairs that have parted; returns whether there were any.
    fn forget_parted(&mut self, core: &Core) -> bool {
        let (particles, cell) = (&core.particles, core.cell());
        let own = core.own_rows();
        let is_known = |offset: &Offset| {
            let ends = if offset.is_wall { 1 } else { 2 };
            offset.rows[..ends]
                .iter()
                .any(|&row| own.contains(&(row as usize)))
        };
        let mut parted = Vec::new();
        self.offsets.retain(|offset| {
            if offset.is_glued || !is_known(offset) {
                return true;
            }
            let [row, other] = offset.rows.map(|row| row as usize);
            let reach = reach(particles, offset.rows, offset.is_wall);
            let record = &particles.records[row];
            let touch = if offset.is_wall {
                to_wall(record, &core.domain.walls[other], reach, cell).is_some()
            } else {
                let way = particles.records[other].position - record.position;
                cell.min_image(way, DVec3::ZERO).0.length() < reach
            };
            if !touch {
                parted.push((offset.is_wall, offset.ids));
            }
            touch
        });
        let any = !parted.is_empty();
        if let Some(share) = &mut self.share {
            share.note_parted(parted);
        }
        any
    }

    /// Glues pairs at their first touch.
    fn glue_touches(&mut self, core: &mut Core) {
        let physics = std::sync::Arc::clone(core.physics());
        let plans = physics.plans.all::<BondPlan>();
        let (time, seed) = (core.time(), physics.seed);
        let glues = |plan: &BondPlan| match plan.when {
            Gluing::Start(_) => false,
            Gluing::Contact { from, until } => time >= from && time < until,
        };
        if !plans.iter().any(glues) {
            return;
        }
        core.fetch_records();
        let around = surroundings(core);
        let particles = around.particles;
        let records = &particles.records;
        let id = |row: u32| particles.ids[row as usize].number();
        let mut bonds = Vec::new();
        for (number, plan) in plans.iter().enumerate().filter(|(_, plan)| glues(plan)) {
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
            found.sort_by_key(|&(key, ..)| key);
            for (key, rows, branch) in found {
                if self.glued.insert(key) {
                    bonds.push(plan.glue(number, rows, key.0, branch, seed, &around));
                }
            }
        }
        if self.share.is_some() {
            core.join_ranks(&mut bonds);
            bonds.sort_by_key(|bond| (bond.plan, bond.is_wall, bond.ids));
        }
        if !bonds.is_empty() {
            self.add(bonds, core);
        }
    }

    /// Takes in the powers of damping and of walls at these forces, by the trapezoidal rule.
    fn take_powers(&mut self, core: &mut Core) {
        let dt = core.since_last();
        let of_bonds: Vec<[f64; 3]> = (self.all.iter())
            .map(|bond| powers_of(&bond, core, dt))
            .collect();
        let powers = self.sum_of_own(core, &of_bonds);
        if dt > 0.0 {
            let half = 0.5 * dt;
            let [taken, by_walls, by_servos] =
                from_fn(|k| half * (self.last_powers[k] + powers[k]));
            match &mut self.share {
                Some(share) => share.take(taken, &mut self.taken),
                None => self.taken += taken,
            }
            self.wall_work[0] += by_walls;
            self.wall_work[1] += by_servos;
        }
        self.last_powers = powers;
    }
}

/// Power that the damping of a bond takes, and power of the wall that it holds to, and of it if it has servos, W.
fn powers_of(bond: &Bond, core: &Core, dt: f64) -> [f64; 3] {
    let [row, other] = bond.rows.map(|row| Row::new(row as usize));
    let of_row = |row: Row| {
        let record = &core.particles.records[row.index()];
        Moving {
            velocity: record.velocity,
            spin: record.angular_velocity,
        }
    };
    let mut by_wall = [0.0; 2];
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
        by_wall[0] = force.dot(now.velocity) - couples[1].dot(now.spin);
        if !core.domain.walls[wall].servos.is_empty() {
            by_wall[1] = by_wall[0];
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
    let taken = (bond.element).damping_power(bond.branch.into(), &seen, &now);
    [taken, by_wall[0], by_wall[1]]
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

//! A sheet in a run: what holds it, its pressure, and the work that is done on it.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::borders::{Border, SheetShape};
use super::forces::{Evaluation, Powers, Workspace};
use super::pressure::Load;
use super::sheet::Sheet;
use crate::cell::Cell;
use crate::lanes::Width;
use crate::parallel::map_parts;
use crate::surface::{CHUNK, LARGE, Surface, SurfacePlan};
use crate::walls::{Motion, Pose, Touches, WallNow, WallStiffness};

/// Stands for "not held".
const FREE: u32 = u32::MAX;

/// Plan of a sheet.
#[derive(Debug, Clone, PartialEq)]
pub struct MembranePlan {
    /// Its surface, as contacts meet it.
    pub surface: Arc<SurfacePlan>,
    /// Its mechanics.
    pub sheet: Arc<Sheet>,
    /// Source of its pressure.
    pub load: Load,
    /// V0, the enclosed volume at the start, m^3.
    pub first_volume: f64,
    /// Holds of its vertices.
    pub holds: Vec<HoldPlan>,
}

/// Vertices that are held.
#[derive(Debug, Clone, PartialEq)]
pub struct HoldPlan {
    /// Name as in the scene.
    pub name: String,
    /// Vertices that are held.
    pub vertices: Vec<u32>,
    /// How they move.
    pub ramp: HoldCourse,
    /// Start, s.
    pub from: f64,
    /// End, s.
    pub until: f64,
}

/// How held vertices move.
#[derive(Debug, Clone, PartialEq)]
pub enum HoldCourse {
    /// With these components of the velocity, m/s; those without one are free.
    Velocity([Option<f64>; 3]),
    /// Motion of a rigid body.
    Motion(Box<Motion>),
    /// With the wall of this index.
    Wall(usize),
}

impl HoldCourse {
    /// Components that are held.
    fn axes(&self) -> [bool; 3] {
        match self {
            Self::Velocity(components) => components.map(|component| component.is_some()),
            Self::Motion(_) | Self::Wall(_) => [true; 3],
        }
    }

    /// Where the frame of the hold stands at `time` (s); velocities have none.
    fn pose(&self, time: f64, walls: &[WallNow]) -> Pose {
        match self {
            Self::Velocity(_) => Pose::IDENTITY,
            Self::Motion(motion) => motion.pose(time),
            Self::Wall(wall) => walls[*wall].state.pose,
        }
    }
}

/// Load of a sheet on a hold.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct HoldLoad {
    /// All that acts on the held vertices but the hold, N.
    pub force: DVec3,
    /// Its torque about the origin, N m.
    pub torque: DVec3,
    /// Power of the hold on the sheet, W.
    pub power: f64,
}

crate::state::plain!(HoldLoad {
    force,
    torque,
    power
});

/// A hold on a wall that began away from the wall.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Gap {
    /// Number of the hold.
    pub hold: u32,
    /// When it began, s.
    pub time: f64,
    /// The held vertex that was farthest from the wall.
    pub vertex: u32,
    /// How far it was, m.
    pub distance: f64,
}

crate::state::plain!(Gap {
    hold,
    time,
    vertex,
    distance
});

/// Sums since the start, J.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Works {
    /// Lost by dashpots and drag.
    pub dissipated: f64,
    /// Done by the pressure.
    pub pressure: f64,
    /// Done by holds.
    pub holds: f64,
}

crate::state::plain!(Works {
    dissipated,
    pressure,
    holds
});

/// A sheet as it is now, beside the positions and velocities of its vertices.
#[derive(Debug, Clone, PartialEq)]
pub struct MembraneNow {
    /// The hold of each vertex, or [`FREE`].
    held_by: Vec<u32>,
    /// Where a held vertex is in the frame of its hold, m.
    place: Vec<DVec3>,
    is_active: Vec<bool>,
    /// Pressure of the last evaluation, Pa.
    pub pressure: f64,
    /// Works since the start.
    pub works: Works,
    /// Load of the sheet on each hold, by the last evaluation.
    pub hold_loads: Vec<HoldLoad>,
    /// Steps in which it was beyond the limits of the guard, where that does not stop the run.
    pub faults: u64,
    /// Holds on walls that began farther from the wall than an edge is long.
    pub gaps: Vec<Gap>,
    dashpots: Vec<f64>,
    /// Borders of the vertices that each wall holds, by the number of the wall.
    borders: Vec<(usize, Border)>,
    powers: Powers,
    workspace: Workspace,
}

/// State of a [`MembraneNow`] that must be kept to go on later.
#[derive(Debug, Clone, PartialEq)]
pub struct SavedMembrane {
    /// The hold of each vertex.
    pub held_by: Vec<u32>,
    /// Where held vertices are in the frames of their holds, m.
    pub place: Vec<DVec3>,
    /// Whether each hold acts.
    pub is_active: Vec<bool>,
    /// Pa
    pub pressure: f64,
    /// Works since the start.
    pub works: Works,
    /// Load of the sheet on each hold.
    pub hold_loads: Vec<HoldLoad>,
    /// Steps beyond the limits of the guard.
    pub faults: u64,
    /// Gaps of [`MembraneNow`].
    pub gaps: Vec<Gap>,
}

crate::state::plain!(SavedMembrane {
    held_by,
    place,
    is_active,
    pressure,
    works,
    hold_loads,
    faults,
    gaps
});

/// When an evaluation or a motion happens, and what it depends on.
#[derive(Debug, Clone, Copy)]
pub struct Moment<'a> {
    /// Time of the positions at the end, s.
    pub time: f64,
    /// Time step, s.
    pub dt: f64,
    /// m/s^2
    pub gravity: DVec3,
    /// Walls as they are at that time.
    pub walls: &'a [WallNow],
    /// Periodic images of the domain.
    pub cell: &'a Cell,
    /// Whether a pool of threads is there.
    pub has_pool: bool,
    /// Lanes in which elements of sheets are taken.
    pub width: Width,
}

/// Fault of a sheet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    /// An edge is too short or too long.
    Stretch {
        /// Its vertices.
        ends: [u32; 2],
        /// Length over length without force.
        stretch: f64,
    },
    /// A triangle turned over.
    TurnedOver {
        /// Its number.
        triangle: u32,
    },
    /// A vertex has no place.
    NotFinite {
        /// Its number.
        vertex: u32,
    },
}

/// Edges outside of this stop a run, over their length without force.
pub const STRETCHES: [f64; 2] = [0.1, 3.0];

impl MembraneNow {
    /// At the start of a run: holds of that time are there.
    #[must_use]
    pub fn new(plan: &MembranePlan, surface: &mut Surface, at: &Moment<'_>) -> Self {
        let count = surface.positions.len();
        let mut new = Self {
            held_by: vec![FREE; count],
            place: vec![DVec3::ZERO; count],
            is_active: vec![false; plan.holds.len()],
            pressure: 0.0,
            works: Works::default(),
            hold_loads: vec![HoldLoad::default(); plan.holds.len()],
            faults: 0,
            gaps: Vec::new(),
            dashpots: Vec::new(),
            borders: Vec::new(),
            powers: Powers::default(),
            workspace: Workspace::default(),
        };
        new.update_holds(plan, surface, at);
        new.note_holds(plan, surface);
        new
    }

    /// Memory of the mechanics of a sheet in a run, bytes: for estimates.
    #[must_use]
    pub fn bytes_of(plan: &MembranePlan) -> f64 {
        let sheet = &plan.sheet;
        let held = sheet.masses().len() * (size_of::<u32>() + size_of::<DVec3>());
        let dashpots = sheet.topology().edges().len() * size_of::<f64>();
        (held + dashpots) as f64 + Workspace::bytes_of(sheet, !plan.load.is_none())
    }

    /// Holds that begin or end at the time of the positions.
    pub fn update_holds(&mut self, plan: &MembranePlan, surface: &mut Surface, at: &Moment<'_>) {
        let half = 0.5 * at.dt;
        let is_wanted = |hold: &HoldPlan| {
            let is_there = match hold.ramp {
                HoldCourse::Wall(wall) => at.walls[wall].state.present,
                _ => true,
            };
            is_there && hold.from <= at.time + half && at.time + half < hold.until
        };
        let wanted: Vec<bool> = plan.holds.iter().map(is_wanted).collect();
        if wanted == self.is_active {
            return;
        }
        let masses = plan.sheet.masses();
        for (hold, _) in plan.holds.iter().zip(0u32..).filter(|(_, number)| {
            let number = *number as usize;
            self.is_active[number] && !wanted[number]
        }) {
            for &vertex in &hold.vertices {
                self.held_by[vertex as usize] = FREE;
                surface.inverse_masses[vertex as usize] = masses[vertex as usize].recip();
            }
        }
        for (number, hold) in plan.holds.iter().enumerate() {
            if self.is_active[number] || !wanted[number] {
                continue;
            }
            if let HoldCourse::Wall(wall) = hold.ramp {
                let gap = gap(plan, (number, hold), &at.walls[wall], surface, at);
                self.gaps.extend(gap);
            }
            let pose = hold.ramp.pose(at.time, at.walls);
            for &vertex in &hold.vertices {
                let k = vertex as usize;
                self.held_by[k] = number as u32;
                self.place[k] = pose.to_initial(surface.positions[k]);
                surface.inverse_masses[k] = 0.0;
            }
        }
        self.is_active = wanted;
        self.note_holds(plan, surface);
    }

    /// Values that follow from the holds of the vertices: dashpots, and borders of the parts that walls hold.
    fn note_holds(&mut self, plan: &MembranePlan, surface: &Surface) {
        self.dashpots = plan.sheet.dashpots(&surface.inverse_masses);
        let wall_of = |hold: &u32| {
            let hold = plan.holds.get(*hold as usize)?;
            match hold.ramp {
                HoldCourse::Wall(wall) => Some(wall),
                HoldCourse::Velocity(_) | HoldCourse::Motion(_) => None,
            }
        };
        let walls: Vec<Option<usize>> = self.held_by.iter().map(wall_of).collect();
        let mut numbers: Vec<usize> = walls.iter().flatten().copied().collect();
        numbers.sort_unstable();
        numbers.dedup();
        let border = |wall: usize| {
            let is_held = walls.iter().map(|other| *other == Some(wall)).collect();
            (wall, Border::new(&plan.sheet, is_held))
        };
        self.borders = numbers.into_iter().map(border).collect();
    }

    /// Adds what the sheet answers to a motion of a wall that holds vertices of it along the unit vector `axis`.
    pub fn add_answer(
        &self,
        (plan, surface): (&MembranePlan, &Surface),
        (wall, axis): (usize, DVec3),
        sum: &mut WallStiffness,
    ) {
        let Some((_, border)) = self.borders.iter().find(|(number, _)| *number == wall) else {
            return;
        };
        let shape = SheetShape {
            positions: &surface.positions,
            inverse_masses: &surface.inverse_masses,
            dashpots: &self.dashpots,
        };
        let load = (&plan.load, plan.first_volume);
        plan.sheet.add_answer(border, &shape, axis, load, sum);
    }

    /// Half kicks, as many as `kicks`, and a drift of `drift` seconds that ends at the time of `at`. Held vertices go with their holds.
    pub fn advance(
        &mut self,
        plan: &MembranePlan,
        surface: &mut Surface,
        (kicks, drift): (u32, f64),
        at: &Moment<'_>,
    ) {
        let half = 0.5 * at.dt;
        let is_parallel = at.has_pool && surface.positions.len() >= LARGE;
        let Surface {
            positions,
            velocities,
            inverse_masses,
            forces,
            ..
        } = surface;
        let chunk = |(first, (positions, velocities)): (usize, (&mut [DVec3], &mut [DVec3]))| {
            let mut squared_speed: f64 = 0.0;
            for (offset, (x, v)) in positions.iter_mut().zip(velocities).enumerate() {
                let k = first * CHUNK + offset;
                if inverse_masses[k] > 0.0 {
                    let kick = (forces[k] * inverse_masses[k] + at.gravity) * half;
                    for _ in 0..kicks {
                        *v += kick;
                    }
                    *x += *v * drift;
                    squared_speed = squared_speed.max(v.length_squared());
                }
            }
            squared_speed
        };
        surface.squared_speed = if is_parallel {
            let chunks = positions
                .par_chunks_mut(CHUNK)
                .zip(velocities.par_chunks_mut(CHUNK));
            // The largest is the same whatever threads find.
            chunks.enumerate().map(chunk).reduce(|| 0.0, f64::max)
        } else {
            let chunks = positions
                .chunks_mut(CHUNK)
                .zip(velocities.chunks_mut(CHUNK));
            chunks.enumerate().map(chunk).fold(0.0, f64::max)
        };
        self.advance_held(plan, surface, (kicks, drift), at);
        if drift > 0.0 {
            self.works.pressure += 0.5 * drift * self.pressure_power(plan, surface, at.has_pool);
        }
    }

    fn advance_held(
        &mut self,
        plan: &MembranePlan,
        surface: &mut Surface,
        (kicks, drift): (u32, f64),
        at: &Moment<'_>,
    ) {
        let half = 0.5 * at.dt;
        for (hold, is_active) in plan.holds.iter().zip(&self.is_active) {
            if !is_active {
                continue;
            }
            let axes = hold.ramp.axes();
            let pose = hold.ramp.pose(at.time, at.walls);
            for &vertex in &hold.vertices {
                let k = vertex as usize;
                let mass = plan.sheet.masses()[k];
                let before = surface.velocities[k];
                let force = surface.forces[k] + mass * at.gravity;
                let mut velocity = before;
                if drift > 0.0 {
                    let wanted = match &hold.ramp {
                        HoldCourse::Velocity(components) => {
                            DVec3::from_array(components.map(Option::unwrap_or_default))
                        }
                        HoldCourse::Motion(_) | HoldCourse::Wall(_) => {
                            let way = pose.to_global(self.place[k]) - surface.positions[k];
                            at.cell.min_image(way, DVec3::ZERO).0 / drift
                        }
                    };
                    for axis in 0..3 {
                        if axes[axis] {
                            velocity[axis] = wanted[axis];
                        }
                    }
                }
                for axis in 0..3 {
                    if axes[axis] {
                        // Its share of the kinetic energy, and half the work of the reaction over this step.
                        let (old, new) = (before[axis], velocity[axis]);
                        self.works.holds += 0.5 * mass * (new * new - old * old);
                        self.works.holds -= 0.5 * drift * force[axis] * new;
                    } else {
                        for _ in 0..kicks {
                            velocity[axis] += force[axis] / mass * half;
                        }
                    }
                }
                surface.velocities[k] = velocity;
                surface.positions[k] += velocity * drift;
                surface.squared_speed = surface.squared_speed.max(velocity.length_squared());
            }
        }
    }

    /// Sets all forces on the vertices: those of contacts, inside the sheet, of the pressure and the drag. `since`: time since the evaluation before, s.
    pub fn add_forces(
        &mut self,
        plan: &MembranePlan,
        surface: &mut Surface,
        since: f64,
        at: &Moment<'_>,
    ) {
        let sheet = &plan.sheet;
        self.pressure = if plan.load.is_none() {
            0.0
        } else if plan.load.needs_volume() {
            let volume = sheet.enclosed(&surface.positions).volume;
            plan.load.at(at.time, volume, plan.first_volume)
        } else {
            plan.load.at(at.time, 0.0, 0.0)
        };
        let is_parallel = at.has_pool && surface.positions.len() >= LARGE;
        let loads: &[DVec3] = if surface.is_loaded {
            &surface.loads
        } else {
            &[]
        };
        let evaluation = Evaluation {
            positions: &surface.positions,
            velocities: &surface.velocities,
            dashpots: &self.dashpots,
            pressure: self.pressure,
            is_parallel,
            width: at.width,
        };
        let work = &mut self.workspace;
        self.powers = sheet.forces(&evaluation, work, loads, &mut surface.forces);
        let mut lost = self.powers.edges + self.powers.hinges;
        lost += drag(sheet, surface, is_parallel);
        self.works.dissipated += since * lost;
        self.works.pressure += 0.5 * since * self.pressure_power(plan, surface, at.has_pool);
        for (number, hold) in plan.holds.iter().enumerate() {
            let mut load = HoldLoad::default();
            if self.is_active[number] {
                let axes = hold.ramp.axes().map(|held| f64::from(u8::from(held)));
                for &vertex in &hold.vertices {
                    let k = vertex as usize;
                    let all = surface.forces[k] + sheet.masses()[k] * at.gravity;
                    let force = all * DVec3::from_array(axes);
                    load.force += force;
                    load.torque += surface.positions[k].cross(force);
                    load.power -= force.dot(surface.velocities[k]);
                }
            }
            self.works.holds += 0.5 * since * load.power;
            self.hold_loads[number] = load;
        }
    }

    /// Power of the pressure's forces of the last evaluation, W, with the present velocities.
    fn pressure_power(&self, plan: &MembranePlan, surface: &Surface, has_pool: bool) -> f64 {
        if self.pressure == 0.0 {
            return 0.0;
        }
        let triangles = plan.sheet.topology().triangles();
        let swept = |first: usize, triangles: &[[u32; 3]]| -> f64 {
            let areas = self.workspace.areas(first).zip(triangles);
            let powers = areas.map(|(area, corners)| {
                let [a, b, c] = corners.map(|k| surface.velocities[k as usize]);
                area.dot(a + b + c)
            });
            powers.sum()
        };
        let is_parallel = has_pool && surface.positions.len() >= LARGE;
        let chunks = triangles.chunks(CHUNK).enumerate();
        let sums = map_parts(is_parallel, chunks, |(chunk, triangles)| {
            swept(chunk * CHUNK, triangles)
        });
        let swept: f64 = sums.into_iter().sum();
        self.pressure * swept / 3.0
    }

    /// Whether each vertex is held in any component.
    #[must_use]
    pub fn is_held(&self, vertex: usize) -> bool {
        self.held_by[vertex] != FREE
    }

    /// The force (N) and the torque about `reference` (m, N m) of a sheet on a wall that holds vertices.
    #[must_use]
    pub fn load_on_wall(
        &self,
        plan: &MembranePlan,
        wall: usize,
        reference: DVec3,
    ) -> Option<(DVec3, DVec3)> {
        let mut found = None;
        for (hold, load) in plan.holds.iter().zip(&self.hold_loads) {
            if hold.ramp == HoldCourse::Wall(wall) {
                let (force, torque) = found.get_or_insert((DVec3::ZERO, DVec3::ZERO));
                *force += load.force;
                *torque += load.torque - reference.cross(load.force);
            }
        }
        found
    }

    /// Fault of the sheet by the last evaluation, if there is one.
    #[must_use]
    pub fn fault(&self, plan: &MembranePlan, surface: &Surface) -> Option<Fault> {
        let [least, largest] = self.powers.stretches;
        if least >= STRETCHES[0] && largest <= STRETCHES[1] {
            return (self.powers.turned_over).map(|triangle| Fault::TurnedOver { triangle });
        }
        let mut numbers = surface.positions.iter().zip(0u32..);
        if let Some((_, vertex)) = numbers.find(|(x, _)| !x.is_finite()) {
            return Some(Fault::NotFinite { vertex });
        }
        let edges = plan.sheet.topology().edges().iter();
        let mut worst: Option<([u32; 2], f64, f64)> = None;
        for (edge, rest) in edges.zip(plan.sheet.rest_lengths()) {
            let [a, b] = edge.ends.map(|k| surface.positions[k as usize]);
            let stretch = (b - a).length() / rest;
            let far = (stretch / STRETCHES[1]).max(STRETCHES[0] / stretch);
            if worst.is_none_or(|(_, _, most)| far > most) {
                worst = Some((edge.ends, stretch, far));
            }
        }
        worst.map(|(ends, stretch, _)| Fault::Stretch { ends, stretch })
    }

    /// State that must be kept.
    #[must_use]
    pub fn save(&self) -> SavedMembrane {
        SavedMembrane {
            held_by: self.held_by.clone(),
            place: self.place.clone(),
            is_active: self.is_active.clone(),
            pressure: self.pressure,
            works: self.works,
            hold_loads: self.hold_loads.clone(),
            faults: self.faults,
            gaps: self.gaps.clone(),
        }
    }

    /// Restores the saved state; the surface is restored already.
    ///
    /// # Errors
    /// If it was another sheet.
    pub fn restore(
        &mut self,
        plan: &MembranePlan,
        surface: &Surface,
        saved: &SavedMembrane,
    ) -> Result<(), String> {
        let (vertices, holds) = (surface.positions.len(), plan.holds.len());
        let fits = saved.held_by.len() == vertices
            && saved.place.len() == vertices
            && saved.is_active.len() == holds
            && saved.hold_loads.len() == holds
            && (saved.held_by.iter()).all(|&hold| hold == FREE || (hold as usize) < holds)
            && (saved.gaps.iter()).all(|gap| (gap.hold as usize) < holds);
        if !fits {
            return Err("it has a membrane of other vertices or holds".to_owned());
        }
        self.held_by.clone_from(&saved.held_by);
        self.place.clone_from(&saved.place);
        self.is_active.clone_from(&saved.is_active);
        self.pressure = saved.pressure;
        self.works = saved.works;
        self.hold_loads.clone_from(&saved.hold_loads);
        self.faults = saved.faults;
        self.gaps.clone_from(&saved.gaps);
        self.note_holds(plan, surface);
        // The next work of the pressure begins with the normals of the last evaluation.
        plan.sheet
            .evaluated_at(&surface.positions, &mut self.workspace);
        Ok(())
    }
}

/// Whether a hold begins farther from its wall than an edge of the sheet is long.
fn gap(
    plan: &MembranePlan,
    (number, hold): (usize, &HoldPlan),
    wall: &WallNow,
    surface: &Surface,
    at: &Moment<'_>,
) -> Option<Gap> {
    let edges = plan.sheet.topology().edges().len();
    let edge = plan.sheet.rest_lengths().sum::<f64>() / edges as f64;
    let mut touches = Touches::default();
    let mut farthest: Option<Gap> = None;
    for &vertex in &hold.vertices {
        let place = surface.positions[vertex as usize];
        let distance = wall.distance(at.cell, place, &mut touches);
        if distance > edge && farthest.is_none_or(|gap| distance > gap.distance) {
            farthest = Some(Gap {
                hold: number as u32,
                time: at.time,
                vertex,
                distance,
            });
        }
    }
    farthest
}

/// Adds the drag on the vertices to all forces on them. Returns what it loses, W.
fn drag(sheet: &Sheet, surface: &mut Surface, is_parallel: bool) -> f64 {
    let drag = sheet.law().drag;
    if drag == 0.0 {
        return 0.0;
    }
    let vertices = surface.velocities.chunks(CHUNK);
    let vertices = vertices.zip(sheet.masses().chunks(CHUNK));
    let chunks = surface.forces.chunks_mut(CHUNK).zip(vertices);
    let lost = map_parts(is_parallel, chunks, |(forces, (velocities, masses))| {
        let mut lost = 0.0;
        for ((force, velocity), mass) in forces.iter_mut().zip(velocities).zip(masses) {
            *force -= *velocity * (drag * mass);
            lost += drag * mass * velocity.length_squared();
        }
        lost
    });
    lost.into_iter().sum()
}

//! Droplets: nozzles that release them, their flight, and what catches them.
//!
//! A droplet is a small ball of liquid that touches no other droplet. It flies along the exact parabola, or with the drag of the air,
//! until a particle or a wall is in its way; the first one that its path meets within a step catches it. Droplets are no particles: they
//! have no id among them, take no part in contacts and in energies.
//!
//! | part | file |
//! |---|---|
//! | when and how droplets leave a nozzle | `nozzle` |
//! | motion of a droplet within a step | `flight` |
//! | particles near a path | `grains` |
//! | these particles as they are now, of all ranks | `among` |
//! | the first particle or wall on a path | `hits` |

mod among;
mod flight;
mod grains;
mod hits;
mod nozzle;
mod part;

pub use crate::liquid::Sum;
use crate::liquid::Weight;
pub use among::Among;
pub use flight::Drag;
pub use nozzle::{Flow, NozzlePlan, NozzleState, Pattern, Point, SourcePlan};

pub use mercury_common::scene::AtWalls;

use std::f64::consts::PI;

use glam::DVec3;

use flight::Flight;
use grains::Grains;
use hits::{Catcher, Passing, Path};

use crate::cell::Cell;
use crate::memory::GROWTH;
use crate::state::Particles;
use crate::walls::{Touches, Wall, WallFilms, WallNow};
use mercury_common::particle_properties::FILM_VOLUME;

/// The share of an edge of a cell that a piece of a path may be long.
const PIECE: f64 = 0.5;

/// Least part of a step that a piece of a path takes, whatever the speed.
const LEAST: f64 = 1e-4;

/// Steps for which the bound of a droplet's speed holds.
const WINDOW: f64 = 64.0;

/// Bounces of a droplet in one step; one with more counts as lost.
const MOST_BOUNCES: usize = 16;

/// All sprays of a plan.
#[derive(Debug, Clone, Default)]
pub struct SprayPlan {
    /// In the order of the scene.
    pub nozzles: Vec<NozzlePlan>,
    /// Seed of the scene.
    pub seed: u64,
}

/// A droplet in flight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Droplet {
    /// Counts from 0 in the order in which droplets left.
    pub id: u64,
    /// Index of its nozzle in the plan.
    pub nozzle: u32,
    /// m
    pub position: DVec3,
    /// m/s
    pub velocity: DVec3,
    /// m
    pub radius: f64,
    /// m^3
    pub volume: f64,
}

crate::state::plain!(Droplet {
    id,
    nozzle,
    position,
    velocity,
    radius,
    volume
});

/// Where the liquid of droplets went; volumes in m^3.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SprayBalance {
    /// Left the nozzles.
    pub emitted: Sum,
    /// Caught by particles.
    pub absorbed: Sum,
    /// Volume into films of walls.
    pub to_walls: Sum,
    /// Lost at walls.
    pub lost: Sum,
    /// Left the domain.
    pub left: Sum,
    /// Round-off of the addition to the last film.
    pub rest: f64,
    /// Momentum that particles got, N s.
    pub momentum: [f64; 3],
    /// Mass that particles got, where liquid has any, kg.
    pub mass: Sum,
    /// Energy that particles got with it, J.
    pub energy: f64,
}

crate::state::plain!(SprayBalance {
    emitted,
    absorbed,
    to_walls,
    lost,
    left,
    rest,
    momentum,
    mass,
    energy
});

/// All of the sprays that must be kept to go on later with the same numbers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SprayState {
    /// Nozzles, in the order of the plan.
    pub nozzles: Vec<NozzleState>,
    /// Droplets in flight, by ascending id.
    pub droplets: Vec<Droplet>,
    /// Id of the next one.
    pub next_id: u64,
    /// Where liquid went.
    pub balance: SprayBalance,
}

crate::state::plain!(SprayState {
    nozzles,
    droplets,
    next_id,
    balance
});

/// Surroundings of the droplets.
pub struct SprayContext<'a> {
    /// Time at the end of the step, s.
    pub time: f64,
    /// Length of the step, s.
    pub dt: f64,
    /// m/s^2
    pub gravity: DVec3,
    /// Walls where they stand at the end of the step.
    pub walls: &'a [WallNow],
    /// The walls as the plan has them.
    pub planned_walls: &'a [Wall],
    /// The domain and its periodic images.
    pub cell: &'a Cell,
    /// Largest speed of a particle in this step, m/s.
    pub fastest: f64,
    /// Number of lists built so far: rows have not changed since the last call if it is the same.
    pub rebuilds: u64,
}

/// The step part that sprays.
#[derive(Debug, Clone, Default)]
pub struct Sprays {
    /// State in a checkpoint.
    pub state: SprayState,
    /// How far each droplet and what surrounds it may move before it must be looked at again, m.
    clearance: Vec<f64>,
    /// Bound of the speed of each droplet until then, m/s.
    bound: Vec<f64>,
    grains: Grains,
    /// Count of list builds for which `grains` holds.
    listed: Option<u64>,
    /// There are too many droplets at the end of this step.
    too_many: Option<TooMany>,
    /// Any number of droplets may fly, to look at a state with too many.
    unlimited: bool,
}

/// There are more droplets in flight than allowed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("spray \"{name}\": more than {most} droplets are in flight")]
pub struct TooMany {
    /// Name of the spray.
    pub name: String,
    /// `max_droplets` of the scene.
    pub most: u64,
}

impl Sprays {
    /// Memory with so many droplets in flight among so many particles, bytes: for estimates.
    #[must_use]
    pub fn bytes_of(droplets: f64, rows: f64) -> f64 {
        let of_droplets = size_of::<Droplet>() + 2 * size_of::<f64>();
        GROWTH * droplets * of_droplets as f64 + rows * Grains::BYTES_OF_ROW as f64
    }

    /// Before the first droplet.
    #[must_use]
    pub fn new(plan: &SprayPlan) -> Self {
        let nozzles = vec![NozzleState::default(); plan.nozzles.len()];
        Self::restored(SprayState {
            nozzles,
            ..SprayState::default()
        })
    }

    /// From a checkpoint.
    #[must_use]
    pub fn restored(state: SprayState) -> Self {
        let droplets = state.droplets.len();
        Self {
            state,
            clearance: vec![0.0; droplets],
            bound: vec![0.0; droplets],
            ..Self::default()
        }
    }

    /// From now on any number of droplets may fly.
    pub(crate) fn lift_limits(&mut self) {
        self.unlimited = true;
    }

    /// Goes on from a checkpoint.
    ///
    /// # Errors
    /// If its sprays are not those of the plan.
    pub fn restore(&mut self, state: SprayState) -> Result<(), String> {
        let nozzles = self.state.nozzles.len();
        let fits = |droplet: &Droplet| (droplet.nozzle as usize) < nozzles;
        if state.nozzles.len() != nozzles || !state.droplets.iter().all(fits) {
            return Err("its sprays are not those of the plan".to_owned());
        }
        *self = Self::restored(state);
        Ok(())
    }

    /// Volume in flight, m^3.
    #[must_use]
    pub fn in_flight(&self) -> f64 {
        let mut sum = Sum::default();
        for droplet in &self.state.droplets {
            sum.add(droplet.volume);
        }
        sum.value()
    }

    /// Where the liquid is, m^3: in flight, emitted, caught by particles, lost at walls, left the domain.
    #[must_use]
    pub fn volumes(&self) -> [f64; 5] {
        let balance = &self.state.balance;
        let sums = [
            balance.emitted,
            balance.absorbed,
            balance.lost,
            balance.left,
        ];
        let [emitted, absorbed, lost, left] = sums.map(Sum::value);
        [self.in_flight(), emitted, absorbed, lost, left]
    }

    /// Releases the droplets of a step and moves all to its end; particles and walls stand there already, with the velocities of its
    /// middle.
    ///
    /// # Errors
    /// If more droplets are in flight than a spray allows; the state is whole.
    pub fn advance(
        &mut self,
        plan: &SprayPlan,
        among: Among<'_>,
        wall_films: &mut WallFilms,
        around: &SprayContext<'_>,
    ) -> Result<(), TooMany> {
        let first_new = self.state.droplets.len();
        let ages = self.release(plan, around);
        if !self.state.droplets.is_empty() {
            self.fly(plan, among, wall_films, around, first_new, &ages);
        }
        for (index, nozzle) in plan.nozzles.iter().enumerate() {
            let of_it = |droplet: &&Droplet| droplet.nozzle as usize == index;
            if self.state.droplets.len() as u64 > nozzle.max_droplets
                && self.state.droplets.iter().filter(of_it).count() as u64 > nozzle.max_droplets
            {
                return Err(TooMany {
                    name: nozzle.name.clone(),
                    most: nozzle.max_droplets,
                });
            }
        }
        Ok(())
    }

    /// Appends the droplets that leave within the step, where they leave; gives how long before its end each does, s.
    fn release(&mut self, plan: &SprayPlan, around: &SprayContext<'_>) -> Vec<f64> {
        let mut ages = Vec::new();
        for (index, nozzle) in plan.nozzles.iter().enumerate() {
            let state = &mut self.state.nozzles[index];
            while let Some(released) = nozzle.next(state, plan.seed, around) {
                let id = self.state.next_id;
                self.state.next_id += 1;
                self.state.balance.emitted.add(released.volume);
                ages.push(released.age);
                self.state.droplets.push(Droplet {
                    id,
                    nozzle: index as u32,
                    position: released.position,
                    velocity: released.velocity,
                    radius: released.radius,
                    volume: released.volume,
                });
                self.clearance.push(0.0);
                self.bound.push(0.0);
            }
        }
        ages
    }

    fn fly(
        &mut self,
        plan: &SprayPlan,
        mut among: Among<'_>,
        wall_films: &mut WallFilms,
        around: &SprayContext<'_>,
        first_new: usize,
        ages: &[f64],
    ) {
        let passing: Vec<Passing<'_>> = (around.walls.iter().enumerate())
            .filter(|(_, wall)| wall.state.present)
            .map(|(index, wall)| Passing::new(index, wall, around))
            .collect();
        let walls_move = passing.iter().map(|wall| wall.way).fold(0.0, f64::max);
        let others = f64::max(around.fastest * around.dt, walls_move);
        let is_listed = self.listed == Some(around.rebuilds);
        if !is_listed || self.grains.drift(around.fastest * around.dt) {
            among.bring_all();
            self.grains = Grains::new(among.particles, around.cell);
            self.listed = Some(around.rebuilds);
            // Particles or walls may have come.
            if !is_listed {
                self.clearance.fill(0.0);
            }
        }
        let flights: Vec<Flight> = (plan.nozzles.iter())
            .map(|nozzle| Flight::new(nozzle, around.gravity))
            .collect();
        let age_of = |k: usize| match k.checked_sub(first_new) {
            Some(new) => ages[new],
            None => around.dt,
        };
        // Grains near all droplets that are looked at come with one message.
        let flown = |k: usize| self.bound[k] * around.dt + others;
        let places = |k: usize| {
            let droplet = &self.state.droplets[k];
            let flight = &flights[droplet.nozzle as usize];
            let age = age_of(k);
            let way = flight.fastest(droplet.velocity, age) * age;
            (droplet.position, droplet.radius + way + self.grains.edge())
        };
        let droplets = 0..self.state.droplets.len();
        let looked_at = droplets.filter(|&k| self.clearance[k] <= flown(k));
        among.bring(&self.grains, looked_at.map(places), around.cell);
        let mut gone = false;
        let mut touches = Touches::new();
        for k in 0..self.state.droplets.len() {
            let droplet = &mut self.state.droplets[k];
            let nozzle = &plan.nozzles[droplet.nozzle as usize];
            let flight = &flights[droplet.nozzle as usize];
            let age = age_of(k);
            self.clearance[k] -= self.bound[k] * around.dt + others;
            if self.clearance[k] > 0.0 {
                flight.advance(droplet, age);
                continue;
            }
            let end = self.follow(
                k,
                flight,
                nozzle,
                age,
                &mut among,
                wall_films,
                &passing,
                around,
                &mut touches,
            );
            if end {
                self.state.droplets[k].radius = 0.0;
                gone = true;
                continue;
            }
            let droplet = &self.state.droplets[k];
            let reach = droplet.radius + self.grains.edge();
            let place = std::iter::once((droplet.position, reach));
            among.bring(&self.grains, place, around.cell);
            self.clearance[k] = (self.grains)
                .clearance(droplet, among.particles, around.cell)
                .min(hits::clearance_of_walls(
                    droplet,
                    &passing,
                    self.grains.edge(),
                    around.cell,
                    &mut touches,
                ))
                .min(around.cell.distance_to_faces(droplet.position));
            self.bound[k] = flight.fastest(droplet.velocity, WINDOW * around.dt);
            // The bound of the speed holds for so many steps only.
            let most = WINDOW * (self.bound[k] * around.dt + others);
            self.clearance[k] = self.clearance[k].min(most);
        }
        if gone {
            let mut stays = self
                .state
                .droplets
                .iter()
                .map(|droplet| droplet.radius > 0.0);
            self.clearance.retain(|_| stays.next().unwrap_or(true));
            let mut stays = self
                .state
                .droplets
                .iter()
                .map(|droplet| droplet.radius > 0.0);
            self.bound.retain(|_| stays.next().unwrap_or(true));
            self.state.droplets.retain(|droplet| droplet.radius > 0.0);
        }
    }

    /// Follows the path of a droplet through the last `age` seconds of the step; whether it ended there.
    fn follow(
        &mut self,
        k: usize,
        flight: &Flight,
        nozzle: &NozzlePlan,
        age: f64,
        among: &mut Among<'_>,
        wall_films: &mut WallFilms,
        passing: &[Passing<'_>],
        around: &SprayContext<'_>,
        touches: &mut Touches,
    ) -> bool {
        let mut left = age;
        let mut bounces = 0;
        while left > 0.0 {
            let mut droplet = self.state.droplets[k];
            let speed = flight.fastest(droplet.velocity, left);
            let longest = (PIECE * self.grains.edge() / speed).max(LEAST * around.dt);
            let piece = if longest < left { longest } else { left };
            let start = droplet.position;
            flight.advance(&mut droplet, piece);
            let path = Path {
                from: start,
                to: droplet.position,
                radius: droplet.radius,
                begin: left,
                end: left - piece,
            };
            among.bring(&self.grains, std::iter::once(path.about()), around.cell);
            let hit = hits::first(
                &path,
                &self.grains,
                among.particles,
                passing,
                around.cell,
                touches,
            );
            let Some(hit) = hit else {
                left -= piece;
                droplet.position = around.cell.wrap(droplet.position);
                self.state.droplets[k] = droplet;
                if !around.cell.holds(droplet.position) {
                    self.state.balance.left.add(droplet.volume);
                    return true;
                }
                continue;
            };
            if !around.cell.holds(start + hit.share * (path.to - start)) {
                // The domain is convex: the droplet has crossed a face before.
                self.state.balance.left.add(droplet.volume);
                return true;
            }
            match hit.by {
                Catcher::Particle(row) => {
                    let particles = &mut *among.particles;
                    self.absorb(&droplet, row as usize, hit.shift, nozzle, particles, around);
                    return true;
                }
                Catcher::Wall(wall, feature) => {
                    let place = (nozzle.at_walls == AtWalls::Film)
                        .then(|| wall_films.place(wall, feature, around.walls))
                        .flatten();
                    if let Some(place) = place {
                        self.state.balance.to_walls.add(droplet.volume);
                        let held = wall_films.volume(place);
                        let (holds, rest) = self.poured(held, droplet.volume);
                        wall_films.set(place, holds);
                        self.state.balance.rest = rest;
                        return true;
                    }
                    if nozzle.at_walls != AtWalls::Bounce || bounces == MOST_BOUNCES {
                        self.state.balance.lost.add(droplet.volume);
                        return true;
                    }
                    bounces += 1;
                    let flown = hit.share * piece;
                    let mut droplet = self.state.droplets[k];
                    flight.advance(&mut droplet, flown);
                    droplet.position = start + hit.share * (path.to - start);
                    let against = (droplet.velocity - hit.velocity).dot(hit.normal);
                    droplet.velocity -= (1.0 + nozzle.restitution) * against.min(0.0) * hit.normal;
                    self.state.droplets[k] = droplet;
                    left -= flown;
                }
            }
        }
        false
    }

    /// Volume of a film (m^3) that takes a droplet (m^3), and the part that the film is too large to hold: that goes to the next
    /// one, so that rounding errors do not add up.
    fn poured(&self, film: f64, droplet: f64) -> (f64, f64) {
        let given = droplet + self.state.balance.rest;
        let holds = film + given;
        (holds, given - (holds - film))
    }

    /// A particle takes the droplet into its film, and its momentum where the spray has this option.
    fn absorb(
        &mut self,
        droplet: &Droplet,
        row: usize,
        shift: DVec3,
        nozzle: &NozzlePlan,
        particles: &mut Particles,
        around: &SprayContext<'_>,
    ) {
        self.state.balance.absorbed.add(droplet.volume);
        if let Some(films) = particles.columns.get_mut(FILM_VOLUME.name) {
            (films[row], self.state.balance.rest) = self.poured(films[row], droplet.volume);
        }
        if !nozzle.momentum {
            return;
        }
        let mass = nozzle.liquid_density * droplet.volume;
        let impulse = mass * droplet.velocity;
        let place = droplet.position - shift;
        let gained = if nozzle.mass {
            let weight = Weight {
                density: nozzle.liquid_density,
                gravity: around.gravity,
                lag: 0.5 * around.dt,
            };
            let gained = weight.add(particles, row, mass, Some(droplet.velocity));
            gained.map(|gained| gained + turn(particles, row, place, impulse))
        } else {
            push(particles, row, impulse)
                .map(|gained| gained + turn(particles, row, place, impulse))
        };
        if let Some(energy) = gained {
            for (sum, part) in self
                .state
                .balance
                .momentum
                .iter_mut()
                .zip(impulse.to_array())
            {
                *sum += part;
            }
            self.state.balance.energy += energy;
            if nozzle.mass {
                self.state.balance.mass.add(mass);
            }
        }
    }
}

/// Gives a particle, or the body of a pebble, the momentum of an impulse (N s); the kinetic energy that it gains, J. `None` for one that
/// nothing moves.
fn push(particles: &mut Particles, row: usize, impulse: DVec3) -> Option<f64> {
    if particles.is_fixed(row) || particles.is_prescribed(row) {
        return None;
    }
    let of_row = (particles.bodies.as_ref()).and_then(|bodies| bodies.body_of_row(row));
    let Some(index) = of_row else {
        let record = &mut particles.records[row];
        if record.inverse_mass == 0.0 {
            return None;
        }
        let change = record.inverse_mass * impulse;
        let energy = impulse.dot(record.velocity + 0.5 * change);
        record.velocity += change;
        return Some(energy);
    };
    let body = &mut particles.bodies.as_mut()?.all[index.index()];
    let change = impulse / body.mass;
    let energy = impulse.dot(body.velocity + 0.5 * change);
    body.velocity += change;
    Some(energy)
}

/// Gives the body of a pebble the moment of an impulse (N s) at a place (m) about its centre of mass, so that the sum of angular momenta
/// about any point is kept; the energy of rotation that it gains, J. A sphere does not turn by what it catches.
fn turn(particles: &mut Particles, row: usize, place: DVec3, impulse: DVec3) -> f64 {
    let position = particles.records[row].position;
    let Some(bodies) = particles.bodies.as_mut() else {
        return 0.0;
    };
    let (Some(index), Some(pebble)) = (bodies.body_of_row(row), bodies.of_row[row]) else {
        return 0.0;
    };
    let offset = bodies.pebbles[pebble.index()].offset;
    let body = &mut bodies.all[index.index()];
    let lever = place - (position - body.orientation * offset);
    let before = body.rotational_energy();
    body.angular_momentum += lever.cross(impulse);
    let turned = body.orientation.inverse() * body.angular_momentum;
    body.angular_velocity = body.orientation * (turned / body.moments);
    body.rotational_energy() - before
}

/// Volume of a droplet, m^3.
pub fn volume_of(radius: f64) -> f64 {
    4.0 / 3.0 * PI * (radius * radius * radius)
}

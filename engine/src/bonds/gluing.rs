//! Which pairs are glued, and how strong the glue of each is.

use std::collections::BTreeSet;

use glam::DVec3;
use mercury_common::random::Stream;

use super::bond::{Bond, Surroundings};
use super::{BondPlan, DEFAULT_REACH, Gluing};
use crate::bodies::{Clump, NewBody};
use crate::cell::{Cell, NO_SHIFT};
use crate::neighbours::Grid;
use crate::state::{Material, NewParticle, Particle, Particles, inverse_inertia_factor};
use crate::walls::{Touches, Wall, WallNow};

/// Set in the second number of a stream of random numbers where it is that of a wall.
const WALL: u64 = 1 << 31;

/// A setting before the run, of which the bonds of the start are found.
pub struct StartOfBonds<'a> {
    /// Materials.
    pub materials: &'a [Material],
    /// 3, or 2 for discs.
    pub dimensions: u8,
    /// Particles of the start.
    pub particles: &'a [NewParticle],
    /// Bodies of the start.
    pub bodies: &'a [NewBody],
    /// Templates of the bodies.
    pub clumps: &'a [Clump],
    /// Walls.
    pub walls: &'a [Wall],
    /// The periodic box.
    pub cell: &'a Cell,
    /// Seed of the strengths.
    pub seed: u64,
}

impl StartOfBonds<'_> {
    /// The bonds of the start, and what they are between.
    pub(super) fn bonds(&self, plans: &[BondPlan]) -> (Vec<Bond>, Particles, Vec<WallNow>) {
        let mut particles = Particles::new(false);
        for new in self.particles {
            let (record, mass, prescribed) = new.build(self.materials, self.dimensions);
            particles.push(record, mass, prescribed);
        }
        for new in self.bodies {
            new.add_to(&mut particles, self.clumps);
        }
        // The step is of no matter for where walls stand at the start.
        let walls = WallNow::all(self.walls, 1.0, self.cell);
        let around = Surroundings {
            particles: &particles,
            walls: &walls,
            cell: self.cell,
            inverse_inertia: inverse_inertia_factor(self.dimensions),
        };
        let bonds = at_start(plans, self.seed, &around);
        (bonds, particles, walls)
    }
}

/// Bonds of the start, in the order of the ids of their ends. Each pair is glued by the first entry that fits.
pub(super) fn at_start(plans: &[BondPlan], seed: u64, around: &Surroundings<'_>) -> Vec<Bond> {
    let Surroundings {
        particles,
        walls,
        cell,
        ..
    } = *around;
    let records = &particles.records;
    let largest = records
        .iter()
        .map(|record| record.radius)
        .fold(0.0, f64::max);
    let position = |row: usize| records[row].position;
    let (grid, rows) = Grid::sort(records.len(), position, 2.0 * largest, cell, false);
    let mut glued = BTreeSet::new();
    let mut bonds = Vec::new();
    for entry in plans.iter().enumerate() {
        let (_, plan) = entry;
        let Gluing::Start(reach) = plan.when else {
            continue;
        };
        let reach_of = |radius: f64| reach.unwrap_or(DEFAULT_REACH * radius);
        let mut found = Vec::new();
        for (row, record) in records.iter().enumerate() {
            for image in std::iter::once(NO_SHIFT).chain(cell.images()) {
                let place = record.position + cell.shift(image);
                let reach = record.radius + largest + reach_of(record.radius);
                grid.visit_near(place, reach, |k| {
                    let other = rows[k] as usize;
                    let partner = &records[other];
                    if particles.ids[row] >= particles.ids[other] {
                        return;
                    }
                    let branch = partner.position - place;
                    let gap = branch.length() - record.radius - partner.radius;
                    if gap <= reach_of(record.radius.min(partner.radius))
                        && plan.fits([row, other], particles)
                    {
                        found.push(([row as u32, other as u32], image, branch));
                    }
                });
            }
        }
        let ids = |&([a, b], image, _): &([u32; 2], u32, DVec3)| {
            let id = |row: u32| particles.ids[row as usize].number();
            (id(a), id(b), image)
        };
        found.sort_unstable_by_key(ids);
        for pair in found {
            if glued.insert((false, ids(&pair))) {
                let ([row, other], _, branch) = pair;
                bonds.push(plan.glue(entry.0, [row, other], false, branch, seed, around));
            }
        }
        for &wall in &plan.walls {
            for &row in &particles.rows_by_id() {
                let record = &records[row as usize];
                let reach = record.radius + reach_of(record.radius);
                let id = particles.ids[row as usize].number();
                if !plan.fits_wall(record) || glued.contains(&(true, (id, wall as u32, NO_SHIFT))) {
                    continue;
                }
                if let Some(branch) = to_wall(record, &walls[wall], reach, cell) {
                    glued.insert((true, (id, wall as u32, NO_SHIFT)));
                    bonds.push(plan.glue(entry.0, [row, wall as u32], true, branch, seed, around));
                }
            }
        }
    }
    bonds
}

/// The way (m) from a particle to the nearest point of a wall within this reach (m), if there is one.
pub(super) fn to_wall(record: &Particle, wall: &WallNow, reach: f64, cell: &Cell) -> Option<DVec3> {
    if !wall.state.present {
        return None;
    }
    let mut touches = Touches::default();
    let mut nearest: Option<(f64, DVec3)> = None;
    for &code in wall.met_by() {
        let image = wall.image_of(record.position, code);
        let centre = record.position + cell.any_shift(image);
        wall.shape()
            .touches(wall.state.into_wall(centre), reach, &mut touches);
        for touch in touches.iter() {
            let is_nearer = nearest.is_none_or(|(distance, _)| touch.distance < distance);
            // Of a centre behind the wall no beam leads to it.
            if touch.distance > 0.0 && touch.distance <= reach && is_nearer {
                let way = wall.state.out_of_wall(touch.normal) * -touch.distance;
                nearest = Some((touch.distance, way));
            }
        }
    }
    nearest.map(|(_, way)| way)
}

impl BondPlan {
    /// Whether it glues two rows, if they are near enough: of two bodies, and not both immovable.
    pub(super) fn fits(&self, [row, other]: [usize; 2], particles: &Particles) -> bool {
        let [a, b] = [row, other].map(|row| &particles.records[row]);
        if !self.glues([a.material, b.material]) || !self.is_within(a) || !self.is_within(b) {
            return false;
        }
        if a.inverse_mass == 0.0 && b.inverse_mass == 0.0 || a.position == b.position {
            return false;
        }
        particles.bodies.as_ref().is_none_or(|bodies| {
            let body = bodies.body_of_row(row);
            body.is_none() || body != bodies.body_of_row(other)
        })
    }

    /// Whether it glues a particle to walls, if they are near enough.
    pub(super) fn fits_wall(&self, record: &Particle) -> bool {
        record.inverse_mass > 0.0 && self.glues_to_walls(record.material) && self.is_within(record)
    }

    fn is_within(&self, record: &Particle) -> bool {
        (self.within.as_ref()).is_none_or(|region| region.contains(record.position))
    }

    /// Bond of this entry, with its number, whose end A has the lower id.
    pub(super) fn glue(
        &self,
        number: usize,
        rows: [u32; 2],
        is_wall: bool,
        branch: DVec3,
        seed: u64,
        around: &Surroundings<'_>,
    ) -> Bond {
        let id = |row: u32| u64::from(around.particles.ids[row as usize].number());
        let other = if is_wall {
            WALL | u64::from(rows[1])
        } else {
            id(rows[1])
        };
        let strengths = self.strengths_of(seed, id(rows[0]) << 32 | other);
        Bond::glue((number, self), rows, is_wall, branch, strengths, around)
    }

    /// Strengths of a pair, Pa: lognormal about those of the entry, by the seed and the pair.
    fn strengths_of(&self, seed: u64, pair: u64) -> [f64; 2] {
        if self.strength_spread == 0.0 {
            return self.strengths;
        }
        let mut stream = Stream::new(seed, &format!("bonds {}", self.name), pair);
        // Of the lognormal distribution with mean 1 and this coefficient of variation.
        let variance = libm::log1p(self.strength_spread * self.strength_spread);
        let deviation = variance.sqrt();
        self.strengths.map(|strength| {
            strength * libm::exp(deviation * stream.standard_normal() - 0.5 * variance)
        })
    }
}

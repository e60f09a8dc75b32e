//! Planes that count the particles that cross them.
//!
//! A particle near a plane when the list is built is checked in every step until the next list: on which side is it now? A change
//! of side is a crossing. Sides are stored, not computed backwards from velocities, so that no particle is counted twice or
//! missed by round-off. A crossing happens at the end of the drift, before anything is deleted: a particle that leaves through a
//! plane at the edge of a deletion region is counted.
//!
//! Across periodic axes a plane has images, one a period: a particle that moves on for ever passes it once in each lap. Wrapping
//! is no crossing, as particles are wrapped only when the list is built.

use glam::DVec3;

use super::counts::Event;
use super::passage::{Grain, Look, OwnGrains};
use super::{FluxPart, FluxPlan, Gate};
use crate::cell::{Cell, NO_SHIFT};
use crate::state::{FIXED, PEBBLE, Particles};

/// Amounts that crossed a plane, of one material, since the last reading. Sums over those that crossed along the normal less
/// those that crossed against it, but for sizes, which are those along it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Crossed {
    /// Particles and bodies along the normal.
    pub forward: u64,
    /// Against it.
    pub backward: u64,
    /// kg (per metre in 2D).
    pub mass: f64,
    /// m^3 (m^2 in 2D).
    pub volume: f64,
    /// Momentum that was carried across, kg m/s.
    pub momentum: DVec3,
    /// Sums of d, d^2, d^3, d^4 of those that crossed along the normal, m ... m^4; a body has the diameter of a sphere of its volume.
    pub diameters: [f64; 4],
}

impl Crossed {
    /// Particles and bodies along the normal less those against it.
    #[must_use]
    pub fn number(&self) -> i64 {
        self.forward as i64 - self.backward as i64
    }

    /// Mean diameter D\[p,p-1\] (m) of the particles that crossed along the normal, the ratio of the sums of d^p and d^(p-1), p
    /// from 1 to 4; 0 if there are none.
    #[must_use]
    pub fn mean_diameter(&self, p: usize) -> f64 {
        let below = match p {
            1 => self.forward as f64,
            _ => self.diameters[p - 2],
        };
        if below > 0.0 {
            self.diameters[p - 1] / below
        } else {
            0.0
        }
    }

    pub(super) fn count(&mut self, what: &Look, ahead: bool) {
        let sign = if ahead { 1.0 } else { -1.0 };
        self.mass += sign * what.mass;
        self.volume += sign * what.volume;
        self.momentum += sign * what.mass * what.velocity;
        if ahead {
            self.forward += 1;
            let mut power = 1.0;
            for sum in &mut self.diameters {
                power *= what.diameter;
                *sum += power;
            }
        } else {
            self.backward += 1;
        }
    }
}

crate::state::plain!(Crossed {
    forward,
    backward,
    mass,
    volume,
    momentum,
    diameters
});

/// A particle or body near a plane.
#[derive(Debug, Clone, Copy)]
struct Watched {
    grain: Grain,
    plane: u32,
    /// Code of the image that is near it.
    image: u32,
    /// Whether it is on the side to which the normal points.
    ahead: bool,
}

/// The planes of a run, and the particles and bodies near them.
#[derive(Debug, Clone)]
pub(super) struct Fluxes {
    planes: Vec<FluxPlan>,
    dimensions: u8,
    /// For each plane the codes of the images that may cross it, the original first: shifted along periodic axes that the plane
    /// is across.
    codes: Vec<Vec<u32>>,
    watched: Vec<Watched>,
}

impl Fluxes {
    pub(super) fn new(planes: &[FluxPlan], dimensions: u8, cell: &Cell) -> Self {
        let planes: Vec<FluxPlan> = planes.iter().map(FluxPlan::straight).collect();
        let codes = planes.iter().map(|plane| {
            let is_across = |code: &u32| {
                (0..3).all(|axis| cell.shift(*code)[axis] == 0.0 || plane.normal[axis] != 0.0)
            };
            std::iter::once(NO_SHIFT)
                .chain(cell.images().filter(is_across))
                .collect()
        });
        Self {
            codes: codes.collect(),
            dimensions,
            watched: Vec::new(),
            planes,
        }
    }

    /// Finds the candidates for a crossing before the next list: particles within `margin` (m) of a plane, and all bodies.
    pub(super) fn listed(&mut self, particles: &Particles, cell: &Cell, margin: f64) {
        self.watched.clear();
        for (index, plane) in self.planes.iter().enumerate() {
            let mut watch = |grain: Grain, position: DVec3, margin: f64| {
                for &image in &self.codes[index] {
                    let distance = plane.ahead(position + cell.shift(image));
                    if distance.abs() <= margin {
                        self.watched.push(Watched {
                            grain,
                            plane: index as u32,
                            image,
                            ahead: distance >= 0.0,
                        });
                    }
                }
            };
            for (row, record) in particles.records.iter().enumerate() {
                if record.flags & (FIXED | PEBBLE) == 0 {
                    watch(Grain::Row(row as u32), record.position, margin);
                }
            }
            for (body, state) in particles.bodies().iter().enumerate() {
                if !state.is_fixed() {
                    watch(Grain::Body(body as u32), state.position, f64::INFINITY);
                }
            }
        }
    }

    /// Appends the particles and bodies that crossed in the step that ends at `time` (s), plane by plane: particles in the order of their rows, then
    /// bodies. Rows must be those of the last list.
    pub(super) fn find(
        &mut self,
        particles: &Particles,
        cell: &Cell,
        time: f64,
        own: &OwnGrains,
        events: &mut Vec<Event>,
    ) {
        let watched = self.watched.iter_mut();
        for watched in watched.filter(|watched| own.has(watched.grain)) {
            let plane = &self.planes[watched.plane as usize];
            let position = watched.grain.position(particles) + cell.shift(watched.image);
            let ahead = plane.ahead(position) >= 0.0;
            if ahead == watched.ahead {
                continue;
            }
            watched.ahead = ahead;
            let look = watched.grain.look(particles, self.dimensions);
            if plane.is_crossed_at(position, look.velocity, cell) {
                let gate = Gate::Plane {
                    index: watched.plane,
                    forward: ahead,
                };
                events.push(Event {
                    time,
                    grain: watched.grain,
                    gate,
                    look,
                });
            }
        }
    }

    /// Whether any grain is near a plane.
    pub(super) fn are_watching(&self) -> bool {
        !self.watched.is_empty()
    }

    /// Continues with the present particles.
    pub(super) fn restore(&mut self, particles: &Particles, cell: &Cell) {
        if !self.planes.is_empty() {
            self.listed(particles, cell, f64::INFINITY);
        }
    }
}

/// A normal with a component below this along an axis (rad) is taken as perpendicular to it.
const SQUARE: f64 = 1e-9;

impl FluxPlan {
    /// The normal made exactly perpendicular to the axes to which it is perpendicular up to round-off: along these the plane has
    /// no images of its own, and a particle that crosses it would be counted once for each of them.
    fn straight(&self) -> Self {
        let cut = |part: f64| if part.abs() < SQUARE { 0.0 } else { part };
        let [x, y, z] = self.normal.to_array().map(cut);
        Self {
            normal: DVec3::new(x, y, z).normalize(),
            ..self.clone()
        }
    }

    /// How far a place (m) is in front of the plane, m; negative behind.
    fn ahead(&self, place: DVec3) -> f64 {
        (place - self.point).dot(self.normal)
    }

    /// Whether a particle that has just come to `position` (m) with this velocity (m/s) has passed through the part that counts.
    fn is_crossed_at(&self, position: DVec3, velocity: DVec3, cell: &Cell) -> bool {
        let Some(place) = self.crossing(position, velocity) else {
            return self.part == FluxPart::All;
        };
        let is_across = |axis: usize| cell.is_periodic(axis) && self.normal[axis] != 0.0;
        // An oblique plane does not continue in the next period: it ends at the faces.
        let is_oblique = self.normal.abs().max_element() < 1.0;
        let beyond = |axis: usize| {
            let along = place[axis] - cell.low()[axis];
            is_oblique && is_across(axis) && !(0.0..cell.size()[axis]).contains(&along)
        };
        if (0..3).any(beyond) {
            return false;
        }
        if self.part == FluxPart::All {
            return true;
        }
        // The nearest image along the plane.
        std::iter::once(NO_SHIFT)
            .chain(cell.images())
            .map(|code| cell.shift(code))
            .filter(|shift| shift.dot(self.normal) == 0.0)
            .any(|shift| self.part.holds(place + shift - self.point))
    }

    /// Where it came through the plane, m.
    fn crossing(&self, position: DVec3, velocity: DVec3) -> Option<DVec3> {
        let speed = velocity.dot(self.normal);
        (speed != 0.0).then(|| position - velocity * (self.ahead(position) / speed))
    }
}

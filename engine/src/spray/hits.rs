//! The first particle or wall on the path of a droplet.

use glam::DVec3;
use mercury_common::turns::by_vector;

use super::grains::Grains;
use super::{Droplet, SprayContext};
use crate::cell::Cell;
use crate::state::Particles;
use crate::walls::{Pose, RigidVelocity, Touches, WallNow};

/// Part of a droplet's radius within which it counts as touching a wall.
const TOUCHES: f64 = 1e-6;

/// Least part of its radius by which a droplet goes on along a wall.
const LEAST: f64 = 1e-3;

/// A straight piece of a path.
pub(super) struct Path {
    pub(super) from: DVec3,
    pub(super) to: DVec3,
    /// Radius of the droplet, m.
    pub(super) radius: f64,
    /// Before the end of the step, s: at its beginning and at its end.
    pub(super) begin: f64,
    pub(super) end: f64,
}

impl Path {
    /// The middle of the path, and half of the edge of a cube about it that holds the droplet on its way, m.
    pub(super) fn about(&self) -> (DVec3, f64) {
        let way = self.to - self.from;
        let middle = self.from + 0.5 * way;
        (middle, self.radius + 0.5 * way.abs().max_element())
    }
}

/// Object that a droplet hits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Catcher {
    /// The particle of a row.
    Particle(u32),
    /// A wall, by its number, and its feature.
    Wall(usize, u32),
}

/// A hit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hit {
    pub(super) by: Catcher,
    /// Share of the piece at which it happens.
    pub(super) share: f64,
    /// Shift of the image of a particle that is hit, m.
    pub(super) shift: DVec3,
    /// Normal of a wall towards the droplet, and its velocity there, m/s.
    pub(super) normal: DVec3,
    pub(super) velocity: DVec3,
}

/// A wall on its way through a step.
pub(super) struct Passing<'a> {
    index: usize,
    wall: &'a WallNow,
    motion: RigidVelocity,
    /// How far points of the surface go in the step at most, m.
    pub(super) way: f64,
    dt: f64,
}

impl<'a> Passing<'a> {
    pub(super) fn new(index: usize, wall: &'a WallNow, around: &SprayContext<'_>) -> Self {
        let mut passing = Self {
            index,
            wall,
            motion: RigidVelocity::REST,
            way: 0.0,
            dt: around.dt,
        };
        let state = &wall.state;
        if state.moves {
            // The velocity is that of the middle of the step.
            let moved = state.velocity.velocity * around.dt;
            let end = state.velocity.origin + 0.5 * moved;
            let turn = by_vector(-around.dt * state.velocity.angular_velocity);
            let before = (state.pose).then(&Pose::about(end, turn, -moved));
            let cell = around.cell;
            let (about, reach) = (cell.middle(), cell.diagonal());
            passing.way = (wall.shape()).displacement(&before, &state.pose, about, reach);
            passing.motion = RigidVelocity {
                origin: end,
                ..state.velocity
            };
        }
        passing
    }

    /// A place `left` (s) before the end of the step as the wall saw it then, in the wall's frame.
    fn place_in_wall(&self, place: DVec3, left: f64) -> DVec3 {
        if self.way == 0.0 {
            return self.wall.state.into_wall(place);
        }
        let motion = &self.motion;
        let from_origin = place - (motion.origin - motion.velocity * left);
        let turn = by_vector(motion.angular_velocity * left);
        self.wall
            .state
            .into_wall(motion.origin + turn * from_origin)
    }

    /// The share of a path at which it meets the wall first, with the normal and the feature there.
    fn first(&self, path: &Path, cell: &Cell, touches: &mut Touches) -> Option<(f64, DVec3, u32)> {
        let way = path.from.distance(path.to) + self.way * (path.begin - path.end) / self.dt;
        let mut first: Option<(f64, DVec3, u32)> = None;
        for &code in self.wall.met_by() {
            let image = self.wall.image_of(path.from, code);
            let shift = cell.any_shift(image);
            let at = |share: f64| {
                let place = path.from + share * (path.to - path.from) + shift;
                self.place_in_wall(place, path.begin + share * (path.end - path.begin))
            };
            let mut share = 0.0;
            loop {
                let place = at(share);
                let reach = path.radius * (1.0 + TOUCHES) + way * (1.0 - share);
                self.wall.shape().touches(place, reach, touches);
                let nearest = (touches.iter()).min_by(|a, b| a.distance.total_cmp(&b.distance));
                let Some(nearest) = nearest else {
                    break;
                };
                let gap = nearest.distance - path.radius;
                if gap <= TOUCHES * path.radius {
                    // One that leaves the wall does not hit it.
                    let ahead = at(1.0) - place;
                    if ahead.dot(nearest.normal) < 0.0 {
                        if first.is_none_or(|(before, ..)| share < before) {
                            first = Some((share, nearest.normal, nearest.feature));
                        }
                        break;
                    }
                }
                if way == 0.0 {
                    break;
                }
                share += (gap.max(LEAST * path.radius) / way).max(1e-5);
                if share >= 1.0 {
                    break;
                }
            }
        }
        first
    }
}

/// First object on a path.
pub(super) fn first(
    path: &Path,
    grains: &Grains,
    particles: &Particles,
    passing: &[Passing<'_>],
    cell: &Cell,
    touches: &mut Touches,
) -> Option<Hit> {
    let mut hit: Option<Hit> = None;
    let way = path.to - path.from;
    let (middle, reach) = path.about();
    let time = path.begin - path.end;
    grains.near(middle, reach, cell, |row, shift| {
        let record = &particles.records[row];
        // Against the particle, which stands at the end of the step now.
        let start = path.from - (record.position + shift - path.begin * record.velocity);
        let against = way - time * record.velocity;
        let contact = record.radius + path.radius;
        let Some(share) = first_within(start, against, contact) else {
            return;
        };
        let is_first = hit.as_ref().is_none_or(|known| match known.by {
            Catcher::Particle(other) => {
                share < known.share || (share == known.share && (row as u32) < other)
            }
            Catcher::Wall(..) => share <= known.share,
        });
        if is_first {
            hit = Some(Hit {
                by: Catcher::Particle(row as u32),
                share,
                shift,
                normal: DVec3::ZERO,
                velocity: DVec3::ZERO,
            });
        }
    });
    for wall in passing {
        let Some((share, normal, feature)) = wall.first(path, cell, touches) else {
            continue;
        };
        if hit.as_ref().is_some_and(|known| known.share <= share) {
            continue;
        }
        let place = path.from + share * way;
        hit = Some(Hit {
            by: Catcher::Wall(wall.index, feature),
            share,
            shift: DVec3::ZERO,
            normal: wall.wall.state.out_of_wall(normal),
            velocity: wall.motion.at(place),
        });
    }
    hit
}

/// The first share of a straight way, relative to a centre, at which the distance is at most `contact` (m).
fn first_within(start: DVec3, way: DVec3, contact: f64) -> Option<f64> {
    let c = start.length_squared() - contact * contact;
    if c <= 0.0 {
        return Some(0.0);
    }
    let (a, b) = (way.length_squared(), start.dot(way));
    if b >= 0.0 {
        return None;
    }
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        return None;
    }
    let share = c / (-b + discriminant.sqrt());
    (share <= 1.0).then_some(share)
}

/// A lower bound of the gap between a droplet and the walls, m; `most` (m) at most.
pub(super) fn clearance_of_walls(
    droplet: &Droplet,
    passing: &[Passing<'_>],
    most: f64,
    cell: &Cell,
    touches: &mut Touches,
) -> f64 {
    let mut clear = most;
    for wall in passing {
        for &code in wall.wall.met_by() {
            let image = wall.wall.image_of(droplet.position, code);
            let place = droplet.position + cell.any_shift(image);
            let place = wall.wall.state.into_wall(place);
            (wall.wall.shape()).touches(place, droplet.radius + clear.max(0.0), touches);
            for touch in touches.iter() {
                clear = clear.min(touch.distance - droplet.radius);
            }
        }
    }
    clear
}

//! Centres that went through a wall in one step, or a wall through them.
//!
//! Contacts see where a centre is at the end of each step. One that is on the other side of a wall at once, because it or the wall is so fast, touches
//! nothing there, or is pushed out to where it should not be. So where a particle and a wall may come nearer by more than [`SEEN`] of its radius in a step, the
//! way of the one past the other is followed; and so is that of a particle which leaves the domain before a contact can see it.

use glam::DVec3;
use mercury_common::turns::by_vector;

use super::super::{GuardPolicy, SEEN};
use super::GuardPart;
use crate::cell::Cell;
use crate::forces::{Alarm, AlarmKind, Alarms, Other, Subject};
use crate::state::{Particle, WallIndex};
use crate::step::Core;
use crate::surface::Surface;
use crate::walls::{Pose, RigidVelocity, Touch, Touches, WallNow};

/// Least part of its way by which a centre is followed on: a damaged state may hold speeds at which a radius is no part of it.
const LEAST: f64 = 1e-5;

/// A wall on its way through a step.
struct Passing<'a> {
    index: WallIndex,
    wall: &'a WallNow,
    /// Its motion, if it changes where the surface is.
    motion: RigidVelocity,
    /// How far points of the surface go at most, m.
    way: f64,
    dt: f64,
    cell: &'a Cell,
    /// The sheet whose shape it is, if it is one.
    surface: Option<&'a Surface>,
}

/// A place on the way of a centre, in the wall's frame.
struct Sample {
    place: DVec3,
    touch: Touch,
    foot: DVec3,
}

impl<'a> Passing<'a> {
    fn new(index: usize, core: &'a Core) -> Self {
        let (wall, cell) = (&core.domain.walls[index], core.cell());
        let dt = core.physics().time_step;
        let surface = wall
            .surface()
            .map(|k| &core.domain.surfaces[usize::from(k)]);
        let mut passing = Self {
            index: WallIndex::new(index as u16),
            wall,
            motion: RigidVelocity::REST,
            way: 0.0,
            dt,
            cell,
            surface,
        };
        if let Some(surface) = surface {
            passing.way = surface.squared_speed.sqrt() * dt;
        }
        let state = &wall.state;
        if state.moves {
            // The velocity is that of the middle of the step.
            let moved = state.velocity.velocity * dt;
            let end = state.velocity.origin + 0.5 * moved;
            let turn = by_vector(-dt * state.velocity.angular_velocity);
            let before = (state.pose).then(&Pose::about(end, turn, -moved));
            let (about, reach) = (cell.middle(), cell.diagonal());
            passing.way = wall
                .shape()
                .displacement(&before, &state.pose, about, reach);
            // A drum that turns in itself is where it was.
            if passing.way > 0.0 {
                passing.motion = RigidVelocity {
                    origin: end,
                    ..state.velocity
                };
            }
        }
        passing
    }

    /// Whether the way of a particle past the wall must be followed; else contacts see all of it.
    fn is_fast(&self, particle: &Particle) -> bool {
        self.way + particle.velocity.length() * self.dt > SEEN * particle.radius
    }

    /// The wall with the motion of a sheet where it is nearest to `centre` (m), within reach of a particle on its way.
    fn carried(&self, particle: &Particle, centre: DVec3, touches: &mut Touches) -> Option<Self> {
        let Some(surface) = self.surface else {
            return Some(Self { ..*self });
        };
        let reach = self.way + particle.velocity.length() * self.dt + particle.radius;
        let nearest = self.sample(centre, reach, touches)?;
        let mesh = self.wall.shape().mesh()?;
        let place = surface.place(mesh, nearest.touch.feature, nearest.foot);
        Some(Self {
            motion: RigidVelocity {
                velocity: surface.velocity_at(&place),
                ..RigidVelocity::REST
            },
            ..*self
        })
    }

    /// Where a centre that is at `centre` now (m) was, with the part `left` of the step to go, as seen from the wall, in its frame.
    fn place(&self, particle: &Particle, centre: DVec3, left: f64) -> DVec3 {
        let (motion, time) = (&self.motion, left * self.dt);
        let then = centre - particle.velocity * time;
        // Carried along with the wall to where that is now.
        let from_origin = then - (motion.origin - motion.velocity * time);
        let turn = by_vector(motion.angular_velocity * time);
        (self.wall.state).into_wall(motion.origin + turn * from_origin)
    }

    /// The nearest place of the wall within `reach` (m).
    fn sample(&self, place: DVec3, reach: f64, touches: &mut Touches) -> Option<Sample> {
        self.wall.shape().touches(place, reach, touches);
        let nearest =
            (touches.iter()).min_by(|a, b| a.distance.abs().total_cmp(&b.distance.abs()))?;
        Some(Sample {
            place,
            touch: *nearest,
            foot: place - nearest.normal * nearest.distance,
        })
    }

    /// Alarm if the centre of a particle went through the wall in this step.
    fn crossing(&self, of: Subject, particle: &Particle, touches: &mut Touches) -> Option<Alarm> {
        // Particles that contacts cannot move do not feel walls, but sheets feel them.
        let feels = particle.inverse_mass > 0.0 || self.surface.is_some();
        if !feels || !self.wall.state.present {
            return None;
        }
        let codes = self.wall.met_by().iter();
        codes
            .filter_map(|&code| {
                let image = (self.wall).image_of(particle.position, code);
                let centre = particle.position + self.cell.any_shift(image);
                (self.carried(particle, centre, touches)?)
                    .crossing_of(of, particle, centre, touches)
            })
            .next()
    }

    fn crossing_of(
        &self,
        of: Subject,
        particle: &Particle,
        centre: DVec3,
        touches: &mut Touches,
    ) -> Option<Alarm> {
        let (dt, radius) = (self.dt, particle.radius);
        let against = particle.velocity - self.motion.at(centre);
        // The velocity of the wall's points changes along the way.
        let turning = self.motion.angular_velocity.length()
            * (particle.velocity - self.motion.velocity).length()
            * dt;
        let way = (against.length() + turning) * dt;
        let (mut left, mut stride) = (1.0, 0.0);
        let mut before: Option<(Sample, f64)> = None;
        loop {
            let place = self.place(particle, centre, left);
            // Of the wall nothing else is in its way any more.
            let now = self.sample(place, way * left + radius, touches)?;
            if let Some((before, then)) = &before
                && is_through(before, &now, stride)
            {
                let end = self.place(particle, centre, 0.0);
                let behind = (before.foot - end).dot(before.touch.normal).max(0.0);
                let nearer = (before.place - now.place).dot(before.touch.normal);
                return Some(Alarm {
                    of,
                    other: Other::Wall(self.index),
                    position: particle.position,
                    radius,
                    overlap: radius + behind,
                    speed: nearer / ((then - left) * dt),
                });
            }
            if left == 0.0 {
                return None;
            }
            // Through the wall it comes only by a stride of the shortest: after a longer one it is still before it.
            let distance = now.touch.distance.abs();
            stride = f64::max(distance - SEEN * radius, SEEN * radius).max(LEAST * way);
            let then = left;
            before = (distance <= stride).then_some((now, then));
            left = (left - stride / way).max(0.0);
        }
    }
}

/// Whether the way between two places, `stride` long at most (m), leads through the surface.
fn is_through(before: &Sample, now: &Sample, stride: f64) -> bool {
    if before.touch.distance < 0.0 {
        // It was behind already.
        return false;
    }
    if now.touch.distance < 0.0 {
        // Not round the rim: it left the front of where it was near, or came from the front of where it is.
        return (now.place - before.foot).dot(before.touch.normal) < 0.0
            || (before.place - now.foot).dot(now.touch.normal) >= 0.0;
    }
    // From one side of a surface with two to the other, not from one surface to one that faces it.
    now.touch.normal.dot(before.touch.normal) < 0.0 && now.foot.distance(before.foot) <= stride
}

impl GuardPart {
    /// Looks for centres that walls were too fast for, or that were too fast for a wall, in this step. Particles have
    /// moved, none has come or gone yet.
    pub(super) fn look_for_crossings(&mut self, core: &Core) {
        let (physics, fastest) = (core.physics(), core.fastest());
        let own = fastest * physics.time_step;
        let seen = SEEN * physics.smallest_radius();
        if physics.guard.policy == GuardPolicy::Off {
            return;
        }
        let mut touches = Touches::default();
        let mut alarms = Alarms::default();
        for (index, wall) in core.domain.walls.iter().enumerate() {
            if !wall.state.moves && wall.surface().is_none() && own <= seen {
                continue;
            }
            let passing = Passing::new(index, core);
            if passing.way + own <= seen {
                continue;
            }
            let rows = core.own_rows();
            let ids = &core.particles.ids[rows.clone()];
            for (record, &id) in core.particles.records[rows].iter().zip(ids) {
                if passing.is_fast(record)
                    && let Some(alarm) =
                        passing.crossing(Subject::Particle(id), record, &mut touches)
                {
                    alarms.note(AlarmKind::Through, alarm);
                }
            }
        }
        self.crossed.take_from(&mut alarms);
    }

    /// Bound for vertices of sheets that touch walls.
    pub(super) fn look_for_crossing_vertices(&mut self, core: &Core) {
        let physics = core.physics();
        if physics.guard.policy == GuardPolicy::Off {
            return;
        }
        let mut touches = Touches::default();
        let mut alarms = Alarms::default();
        for (surface, vertices) in (0..).zip(core.all_vertex_spheres()) {
            let Some(radius) = vertices.first().map(|vertex| vertex.radius) else {
                continue;
            };
            let own = core.domain.surfaces[usize::from(surface)]
                .squared_speed
                .sqrt()
                * physics.time_step;
            for index in 0..physics.walls.len() {
                let passing = Passing::new(index, core);
                if passing.way + own <= SEEN * radius {
                    continue;
                }
                for (vertex, record) in (0..).zip(&vertices) {
                    let of = Subject::Vertex { surface, vertex };
                    if passing.is_fast(record)
                        && let Some(alarm) = passing.crossing(of, record, &mut touches)
                    {
                        alarms.note(AlarmKind::Through, alarm);
                    }
                }
            }
        }
        self.crossed.take_from(&mut alarms);
    }

    /// Looks for crossings of slower particles that have just left through a face of the domain: no contact sees them any more.
    pub(super) fn look_at_leavers(&mut self, core: &Core) {
        let leavers = core.boundaries().left_by_face();
        if leavers.is_empty() || core.physics().guard.policy == GuardPolicy::Off {
            return;
        }
        let mut touches = Touches::default();
        let mut alarms = Alarms::default();
        for index in 0..core.domain.walls.len() {
            let passing = Passing::new(index, core);
            for (id, record) in leavers {
                if !passing.is_fast(record)
                    && let Some(alarm) =
                        passing.crossing(Subject::Particle(*id), record, &mut touches)
                {
                    alarms.note(AlarmKind::Through, alarm);
                }
            }
        }
        self.crossed.take_from(&mut alarms);
    }
}

//! When and how droplets leave.

use std::f64::consts::TAU;

use glam::DVec3;
use libm::{cos, sin, sqrt};
use mercury_common::curve::Curve;
use mercury_common::random::Stream;
use mercury_common::sizes::SizeDistribution;

use super::{AtWalls, Drag, SprayContext, Sum, volume_of};

/// A spray of a plan.
#[derive(Debug, Clone)]
pub struct NozzlePlan {
    /// Unique; random choices follow from it and the seed.
    pub name: String,
    /// Where droplets come from.
    pub source: SourcePlan,
    /// kg/m^3
    pub liquid_density: f64,
    /// Whether gravity acts on droplets.
    pub gravity: bool,
    /// Drag of the gas, if any.
    pub drag: Option<Drag>,
    /// Effect of walls on droplets.
    pub at_walls: AtWalls,
    /// Restitution of bounces.
    pub restitution: f64,
    /// Whether particles get the momentum of what they catch.
    pub momentum: bool,
    /// Whether particles get the mass of what they catch.
    pub mass: bool,
    /// Most droplets in flight.
    pub max_droplets: u64,
    /// Start, s.
    pub from: f64,
    /// End, s.
    pub until: f64,
}

/// Where droplets come from.
#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant, reason = "a scene has a few")]
pub enum SourcePlan {
    /// A nozzle.
    Nozzle {
        /// Middle of the orifice at the start, m.
        position: DVec3,
        /// Mean direction and two across it, all of length 1, at the start.
        frame: [DVec3; 3],
        /// How directions spread.
        pattern: Pattern,
        /// Radius of the orifice, m.
        orifice: f64,
        /// Volume per time.
        flow: Flow,
        /// Mean speed and uniform deviation, m/s.
        speed: [f64; 2],
        /// Diameters.
        sizes: SizeDistribution,
        /// Index of the wall with which it moves.
        carrier: Option<usize>,
    },
    /// Droplets one by one, by ascending time.
    Points(Vec<Point>),
}

/// A droplet of a list.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// s
    pub time: f64,
    /// m
    pub position: DVec3,
    /// m/s
    pub velocity: DVec3,
    /// m
    pub diameter: f64,
}

/// How directions spread, in rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pattern {
    /// Even in both angles up to these half angles, along the second and the third direction of the frame.
    FlatFan([f64; 2]),
    /// Even in the solid angle between two half angles, given by their cosines: of the inner one, then the outer one.
    Cone([f64; 2]),
}

/// Volume per time.
#[derive(Debug, Clone, PartialEq)]
pub enum Flow {
    /// m^3/s
    Constant(f64),
    /// Rows of time (s), rate (m^3/s) and volume that has come until then (m^3); linear rate between rows, none outside of them.
    Table(Vec<[f64; 3]>),
}

impl Flow {
    /// From rates (m^3/s) between the rows of a curve; flow before `from` (s) does not count.
    #[must_use]
    pub fn table(rates: &Curve, from: f64) -> Self {
        let rows = rates.rows();
        let mut table: Vec<[f64; 3]> = Vec::with_capacity(rows.len());
        let mut volume = 0.0;
        for pair in rows.windows(2) {
            let [(mut t0, mut q0), (t1, q1)] = [pair[0], pair[1]];
            if t1 <= from {
                continue;
            }
            if t0 < from {
                (t0, q0) = (from, q0 + (q1 - q0) * (from - t0) / (t1 - t0));
            }
            if table.is_empty() {
                table.push([t0, q0, 0.0]);
            }
            volume += 0.5 * (q0 + q1) * (t1 - t0);
            table.push([t1, q1, volume]);
        }
        Self::Table(table)
    }

    /// When so much (m^3) has come, s; infinite if it never does.
    fn instant(&self, from: f64, volume: f64) -> f64 {
        match self {
            Self::Constant(rate) if *rate > 0.0 => from + volume / rate,
            Self::Constant(_) => f64::INFINITY,
            Self::Table(rows) => {
                let after = rows.partition_point(|row| row[2] < volume);
                let (Some(&[t0, q0, v0]), Some(&[t1, q1, _])) =
                    (rows.get(after.wrapping_sub(1)), rows.get(after))
                else {
                    return f64::INFINITY;
                };
                // v = q0 t + (q1 - q0)/(2 T) t^2, by the root that loses no digits.
                let (v, slope) = (volume - v0, (q1 - q0) / (t1 - t0));
                let root = sqrt((q0 * q0 + 2.0 * slope * v).max(0.0));
                (t0 + 2.0 * v / (q0 + root)).min(t1)
            }
        }
    }

    /// Largest rate, m^3/s.
    #[must_use]
    pub fn largest(&self) -> f64 {
        match self {
            Self::Constant(rate) => *rate,
            Self::Table(rows) => rows.iter().map(|row| row[1]).fold(0.0, f64::max),
        }
    }
}

/// How far a nozzle has come.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct NozzleState {
    /// Droplets that left.
    pub released: u64,
    /// Their volume, m^3.
    pub volume: Sum,
}

crate::state::plain!(NozzleState { released, volume });

/// A droplet as it leaves.
pub(super) struct Released {
    pub(super) position: DVec3,
    pub(super) velocity: DVec3,
    pub(super) radius: f64,
    pub(super) volume: f64,
    /// Time before the end of the step, s.
    pub(super) age: f64,
}

/// Words of the random stream that one droplet takes: its size, its place on the orifice, its direction and its speed.
const WORDS: u64 = 6;

impl NozzlePlan {
    /// Droplets that are in flight at once, as they cross a domain of this size (m) with their mean speed; no more than allowed.
    #[must_use]
    pub fn in_flight(&self, across: f64) -> f64 {
        let droplets = match &self.source {
            SourcePlan::Nozzle {
                flow, speed, sizes, ..
            } => {
                let flight = (across / speed[0]).min(self.until - self.from);
                flow.largest() / sizes.mean_volume() * flight
            }
            SourcePlan::Points(points) => points.len() as f64,
        };
        droplets.min(self.max_droplets as f64)
    }

    /// The next droplet, if it leaves until the end of the step.
    ///
    /// Droplet n leaves when flow times time reaches the volume of the first n, itself included, so that what was emitted is never
    /// more than the flow has brought and never a droplet behind.
    pub(super) fn next(
        &self,
        state: &mut NozzleState,
        seed: u64,
        around: &SprayContext<'_>,
    ) -> Option<Released> {
        match &self.source {
            SourcePlan::Points(points) => {
                let point = points.get(state.released as usize)?;
                if point.time > around.time {
                    return None;
                }
                let radius = 0.5 * point.diameter;
                let volume = volume_of(radius);
                state.released += 1;
                state.volume.add(volume);
                let age = (around.time - point.time).clamp(0.0, around.dt);
                Some(Released {
                    position: point.position,
                    velocity: point.velocity,
                    radius,
                    volume,
                    age,
                })
            }
            SourcePlan::Nozzle {
                position,
                frame,
                pattern,
                orifice,
                flow,
                speed,
                sizes,
                carrier,
            } => {
                let position_in_stream = state.released * WORDS;
                let mut stream = Stream::new(seed, "spray", name_index(&self.name));
                stream = stream.at(position_in_stream);
                let radius = 0.5 * sizes.sample_diameter(stream.uniform());
                let volume = volume_of(radius);
                let mut reached = state.volume;
                reached.add(volume);
                let instant = flow.instant(self.from, reached.value());
                if instant > around.time.min(self.until) {
                    return None;
                }
                state.released += 1;
                state.volume = reached;
                let age = (around.time - instant).clamp(0.0, around.dt);
                let [a, b] = [stream.uniform(), stream.uniform()];
                let (r, turn) = (orifice * sqrt(a), TAU * b);
                let from_middle = [0.0, r * cos(turn), r * sin(turn)];
                let direction = pattern.direction(stream.uniform(), stream.uniform());
                let speed = speed[0] + speed[1] * (2.0 * stream.uniform() - 1.0);
                let place = |v: [f64; 3]| v[0] * frame[0] + v[1] * frame[1] + v[2] * frame[2];
                let mut released = Released {
                    position: *position + place(from_middle),
                    velocity: speed * place(direction),
                    radius,
                    volume,
                    age,
                };
                let walls = (around.walls, around.planned_walls);
                let carrier =
                    carrier.and_then(|index| Some((walls.0.get(index)?, walls.1.get(index)?)));
                if let Some((now, planned)) = carrier {
                    // As it stood and moved when the droplet left.
                    let left_at = around.time - age;
                    let (pose, velocity) = now.motion_at(planned, left_at, around.time);
                    released.position = pose.to_global(released.position);
                    released.velocity =
                        pose.rotation * released.velocity + velocity.at(released.position);
                }
                Some(released)
            }
        }
    }
}

/// The index of the random stream of a spray.
fn name_index(name: &str) -> u64 {
    mercury_common::random::fnv1a_64(name.as_bytes())
}

impl Pattern {
    /// A direction in the frame, from two numbers in (0, 1).
    fn direction(&self, a: f64, b: f64) -> [f64; 3] {
        match self {
            Self::FlatFan([wide, narrow]) => {
                let (alpha, beta) = (wide * (2.0 * a - 1.0), narrow * (2.0 * b - 1.0));
                [cos(alpha) * cos(beta), sin(alpha) * cos(beta), sin(beta)]
            }
            Self::Cone([inner, outer]) => {
                let cosine = inner + (outer - inner) * a;
                let sine = sqrt((1.0 - cosine) * (1.0 + cosine));
                let turn = TAU * b;
                [cosine, sine * cos(turn), sine * sin(turn)]
            }
        }
    }
}

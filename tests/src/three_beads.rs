//! A grain in the groove of two fixed beads must roll off and fall (Vyas et al. 2025, Comput. Phys. Commun. 310, 109524).
//!
//! Friction exceeds the slope of the groove, mu > sqrt((1 + 1/R)^2 - 1) for beads R times as large as the grain, so that the grain
//! can wedge itself in. With the sliding velocity taken against the normal of another time than its own, a grain that rolls in
//! the groove is pulled into it step by step, and hangs there for ever without any adhesion. Nothing but gravity and friction acts, so a grain
//! that hangs below the beads is wrong whatever the step.

use crate::scenes::{advance, particle, plan, sphere, start, wall};
use glam::{DVec3, dvec3};
use mercury_common::formats::clump::Pebble;
use mercury_common::formats::mesh::TriangleMesh;
use mercury_engine::bodies::{Clump, NewBody};
use mercury_engine::contact::registry::AnyPairLaw;
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, CoulombLimits, Hertz, Linear,
    LinearFriction, Mindlin, MindlinRescaled, PairLaw, SlidingNormal, SpringRotation,
};
use mercury_engine::state::{MaterialIndex, volume};
use mercury_engine::walls::{Component, Mesh, Motion, Shape, Side, SphereShell};
use mercury_solver::plan::Draft;

/// Radius of the beads, m.
const BEAD: f64 = 5e-3;
const DENSITY: f64 = 2500.0;
const GRAVITY: f64 = 9.81;
const RESTITUTION: f64 = 0.5;

/// Kind of the two beads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Beads {
    /// Fixed particles.
    Particles,
    /// Surfaces; they turn about the line through their centres, rad/s.
    Walls(f64),
    /// Triangle meshes of these surfaces; they turn in the same way, rad/s.
    Meshes(f64),
    /// Pebbles of a clump that turns about the same line, rad/s.
    Pebbles(f64),
}

/// A grain on top of two beads, 1 degree off the highest place.
#[derive(Debug, Clone, Copy)]
pub struct Groove {
    /// Kind of the two beads.
    pub beads: Beads,
    /// Radius of a bead over that of the grain.
    pub ratio: f64,
    /// Law of all contacts.
    pub law: AnyPairLaw,
    /// Time step, s.
    pub step: f64,
    /// The normal against which sliding is taken.
    pub rule: SlidingNormal,
}

/// Time of contact of a grain with a linear spring (N/m), s: of the undamped pair, whose other side is fixed.
fn contact_time(radius: f64, stiffness: f64) -> f64 {
    std::f64::consts::PI * (DENSITY * volume(radius, 3) / stiffness).sqrt()
}

/// A spring (N/m) with e = 0.5, and a tangential one of 0.8235 of it without a dashpot.
pub fn linear_law(stiffness: f64, friction: f64, rotation: SpringRotation) -> AnyPairLaw {
    let ln = RESTITUTION.ln();
    let ratio = -ln / (std::f64::consts::PI.powi(2) + ln * ln).sqrt();
    PairLaw {
        normal: AnyNormal::Linear(Linear::with_damping_ratio(stiffness, ratio)),
        tangential: AnyTangential::Linear(LinearFriction {
            stiffness: 0.8235 * stiffness,
            dissipation: 0.0,
            friction,
            static_friction: friction,
            rotation,
            limits: CoulombLimits::Bounded,
        }),
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    }
}

/// E (Pa) of both; nu = 0.25.
pub fn hertz_law(modulus: f64, friction: f64, rescaled: bool) -> AnyPairLaw {
    let effective = modulus / (2.0 * (1.0 - 0.25 * 0.25));
    let shear = modulus / 2.5 / (2.0 * (2.0 - 0.25));
    let mindlin = Mindlin::new(shear, 2.0 / 3.0, 0.0, friction, friction);
    PairLaw {
        normal: AnyNormal::Hertz(Hertz::new(effective, 0.5)),
        tangential: if rescaled {
            AnyTangential::MindlinRescaled(MindlinRescaled { plain: mindlin })
        } else {
            AnyTangential::Mindlin(mindlin)
        },
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    }
}

/// A sphere about a centre (m), of triangles between circles of latitude about x.
fn tessellated(radius: f64, centre: DVec3) -> Mesh {
    const AROUND: u32 = 24;
    const ALONG: u32 = 12;
    let at = |i: u32, j: u32| {
        let polar = std::f64::consts::PI * f64::from(i) / f64::from(ALONG);
        let turn = std::f64::consts::TAU * f64::from(j) / f64::from(AROUND);
        let ((sin, cos), (y, z)) = (polar.sin_cos(), turn.sin_cos());
        centre + radius * dvec3(cos, sin * y, sin * z)
    };
    // The two poles, then circle by circle.
    let mut vertices = vec![at(0, 0), at(ALONG, 0)];
    vertices.extend((1..ALONG).flat_map(|i| (0..AROUND).map(move |j| at(i, j))));
    let index = |i: u32, j: u32| match i {
        0 => 0,
        ALONG => 1,
        _ => 2 + (i - 1) * AROUND + j % AROUND,
    };
    let mut triangles = Vec::new();
    for i in 0..ALONG {
        for j in 0..AROUND {
            let [a, b, c, d] = [
                index(i, j),
                index(i, j + 1),
                index(i + 1, j + 1),
                index(i + 1, j),
            ];
            if i > 0 {
                triangles.push([a, b, d]);
            }
            if i + 1 < ALONG {
                triangles.push([b, c, d]);
            }
        }
    }
    let triangles = TriangleMesh {
        vertices,
        triangles,
        ..TriangleMesh::default()
    };
    Mesh::new(&triangles, |x| x, false).expect("triangles with an area")
}

impl Groove {
    /// Linear contacts and a step of so many to a contact time.
    pub fn new(beads: Beads, ratio: f64, friction: f64, steps_per_contact: f64) -> Self {
        // Overlaps under the weight are the same part of the grain at every ratio: m g/(k r).
        let stiffness = 1e4 * (20.0 / ratio) * (20.0 / ratio);
        Self {
            beads,
            ratio,
            law: linear_law(stiffness, friction, SpringRotation::Project),
            step: contact_time(BEAD / ratio, stiffness) / steps_per_contact,
            rule: SlidingNormal::HalfStep,
        }
    }

    fn draft(&self) -> Draft {
        let radius = BEAD / self.ratio;
        let mut plan = plan(self.step, DENSITY, self.law);
        plan.gravity = -GRAVITY * DVec3::Z;
        plan.sliding_normal = self.rule;
        let centres = [DVec3::ZERO, 2.0 * BEAD * DVec3::X];
        let from_line = self.distance_from_line();
        let (sin, cos) = 1f64.to_radians().sin_cos();
        let place = dvec3(BEAD, from_line * sin, from_line * cos);
        let grain = sphere(place, radius, DVec3::ZERO, DVec3::ZERO);
        let turning = |speed: f64| {
            let turn = Component::Rotation {
                axis: DVec3::X,
                origin: DVec3::ZERO,
                angular_velocity: speed,
                from: 0.0,
                until: f64::INFINITY,
            };
            Motion::new(vec![turn]).expect("finite numbers")
        };
        match self.beads {
            Beads::Particles => {
                let beads = centres.map(|centre| {
                    let mut bead = sphere(centre, BEAD, DVec3::ZERO, DVec3::ZERO);
                    bead.fixed = true;
                    bead
                });
                return plan.with_particles([&[grain][..], &beads].concat());
            }
            Beads::Walls(speed) => {
                for centre in centres {
                    let shell =
                        SphereShell::new(centre, BEAD, Side::Outside).expect("finite numbers");
                    plan.walls.push(wall(Shape::Sphere(shell), turning(speed)));
                }
            }
            Beads::Meshes(speed) => {
                for centre in centres {
                    let mesh = Shape::Mesh(tessellated(BEAD, centre).into());
                    plan.walls.push(wall(mesh, turning(speed)));
                }
            }
            Beads::Pebbles(speed) => {
                let pebbles = [-BEAD, BEAD].map(|x| Pebble {
                    position: x * DVec3::X,
                    radius: BEAD,
                });
                let mass = 2.0 * DENSITY * volume(BEAD, 3);
                let own = 0.4 * mass * BEAD * BEAD;
                let across = own + mass * BEAD * BEAD;
                let pair = Clump::new(
                    "pair",
                    MaterialIndex::new(0),
                    pebbles.to_vec(),
                    mass,
                    2.0 * volume(BEAD, 3),
                    dvec3(own, across, across),
                );
                let body = NewBody {
                    prescribed_velocity: [Some(0.0); 3],
                    prescribed_angular_velocity: [Some(speed), Some(0.0), Some(0.0)],
                    angular_velocity: speed * DVec3::X,
                    ..NewBody::at(BEAD * DVec3::X, 0)
                };
                return plan
                    .with_particles(vec![grain])
                    .with_bodies(vec![pair.expect("finite numbers")], vec![body]);
            }
        }
        plan.with_particles(vec![grain])
    }

    /// From the line through the centres of the beads to the centre of a grain in the groove, m.
    fn distance_from_line(&self) -> f64 {
        let radius = BEAD / self.ratio;
        ((BEAD + radius) * (BEAD + radius) - BEAD * BEAD).sqrt()
    }

    /// When (s) a grain that rolls without sliding has come to `degrees` from the top: of the work of its weight m g rho (cos 1 - cos a) the part
    /// 1/K goes into its speed, with K = 1 + 2/5 (r/track)^2 for a track of the contact points' distance from its axis. Simpson's rule over
    /// u with a = 1 degree + u^2, which takes the root out of the integrand.
    pub fn rolling_time(&self, degrees: f64) -> f64 {
        let radius = BEAD / self.ratio;
        let rho = self.distance_from_line();
        let track = radius * rho / (BEAD + radius);
        let factor = 1.0 + 0.4 * (radius / track) * (radius / track);
        let (first, last) = (1f64.to_radians(), degrees.to_radians());
        let end = (last - first).sqrt();
        let at = |u: f64| {
            if u == 0.0 {
                return 2.0 / first.sin().sqrt();
            }
            2.0 * u / (first.cos() - (first + u * u).cos()).sqrt()
        };
        const PARTS: u32 = 10_000;
        let h = end / f64::from(PARTS);
        let weight = |k: u32| match k {
            0 | PARTS => 1.0,
            k if k % 2 == 1 => 4.0,
            _ => 2.0,
        };
        let sum: f64 = (0..=PARTS).map(|k| weight(k) * at(h * f64::from(k))).sum();
        (factor * rho / (2.0 * GRAVITY)).sqrt() * sum * h / 3.0
    }

    /// When (s) the grain has come to `degrees` from the top, to 2e-4 s; `None` if it does not within a second.
    pub fn time_to(&self, degrees: f64) -> Option<f64> {
        let mut engine = start(self.draft());
        let steps = (2e-4 / self.step) as u64;
        let mut time = 0.0;
        while time < 1.0 {
            advance(&mut engine, steps);
            time += steps as f64 * self.step;
            let place = particle(&engine, 0).position;
            if place.y.atan2(place.z) > degrees.to_radians() {
                return Some(time);
            }
        }
        None
    }

    /// When (s) the grain is far below the beads; `None` if it is not within half a second. A grain that rolls without
    /// sliding takes 0.15 s at a ratio of 20 and 0.3 s at 300, where it rolls on a narrow track: its spin takes most of the work of the weight.
    pub fn falls(&self) -> Option<f64> {
        let mut engine = start(self.draft());
        let part = 2e-3;
        for k in 1..=250 {
            advance(&mut engine, (part / self.step) as u64);
            if particle(&engine, 0).position.z < -2.0 * BEAD {
                return Some(f64::from(k) * part);
            }
        }
        None
    }
}

//! When a run has come to rest: energies just below and just above the limit, of all kinds of grains.

use super::*;
use crate::run::rest_criterion::Rest;
use mercury_engine::bodies::NewBody;
use mercury_engine::state::{Particles, PrescribedMotion};

const GRAVITY: f64 = 9.0;
/// I/(m R^2) of a sphere, inverted.
const INVERSE_INERTIA: f64 = 2.5;

/// The particles and bodies of a plan without walls.
fn particles(plan: Draft) -> Particles {
    let plan = plan.plan().unwrap();
    let physics = plan.physics();
    let mut particles = Particles::new(false);
    for new in &physics.particles {
        let (record, mass, prescribed) = new.build(&physics.materials, physics.dimensions);
        particles.push(record, mass, prescribed);
    }
    for new in &physics.bodies {
        new.add_to(&mut particles, &physics.clumps);
    }
    particles
}

/// Checks that make rest: 1,000 steps, every tenth of which is looked at.
const LOOKS: u32 = 100;
/// So long that 1,000 steps are longer than anything here takes to begin to fall, s.
const STEP: f64 = 1e-5;

fn rest() -> Rest {
    let mut plan = plan(1, 1.0, 0.0);
    plan.gravity = DVec3::new(0.0, 0.0, -GRAVITY);
    Rest::new(&plan.plan().unwrap())
}

fn is_calm(particles: &Particles) -> bool {
    let mut rest = rest();
    (1..=LOOKS).all(|look| rest.look(particles, STEP, |_| false) == (look == LOOKS))
}

/// The limit is 1e-6 m g d per grain, m and d their means: of spheres the energy of moving counts, and so does that of bodies. Spin that stays as it is does not.
#[test]
fn the_limit_is_a_millionth_of_the_weight_times_the_diameter() {
    let material = MaterialIndex::new(0);
    let mass = |radius: f64| DENSITY * mercury_engine::state::volume(radius, 3);
    for (part, calm) in [(0.999, true), (1.001, false)] {
        // Two spheres, of which one moves and one turns; fixed and prescribed ones do not count.
        let (small, large) = (RADIUS, 2.0 * RADIUS);
        let mean = 0.5 * (mass(small) + mass(large));
        // Two grains: twice the limit in all, which one of them has.
        let energy = 2.0 * part * 1e-6 * mean * GRAVITY * (small + large);
        let at = |x: f64, radius: f64| NewParticle::at(DVec3::X * x, radius, material);
        let moving = NewParticle {
            velocity: DVec3::Y * (2.0 * energy / mass(small)).sqrt(),
            ..at(0.0, small)
        };
        let turning = NewParticle {
            angular_velocity: DVec3::Z * 1000.0,
            ..at(0.1, large)
        };
        let fixed = NewParticle {
            fixed: true,
            ..at(0.2, 9.0 * RADIUS)
        };
        let driven = NewParticle {
            velocity: DVec3::X,
            prescribed: PrescribedMotion::boxed([Some(1.0), None, None], [None; 3]),
            ..at(0.4, RADIUS)
        };
        let spheres = vec![moving, turning, fixed, driven];
        let spheres = particles(plan(1, 1.0, 0.0).with_particles(spheres));
        assert_eq!(is_calm(&spheres), calm, "spheres at {part}");

        // A body that moves and turns about a principal axis, its diameter that of the sphere around it.
        let pebbles = [-1.0, 1.0].map(|side| Pebble {
            position: DVec3::X * (side * RADIUS),
            radius: RADIUS,
        });
        let (mass, volume) = (
            2.0 * mass(RADIUS),
            2.0 * mercury_engine::state::volume(RADIUS, 3),
        );
        let moments = DVec3::new(0.4, 1.4, 1.4) * (mass * RADIUS * RADIUS);
        let twin = Clump::new("twin", material, pebbles.to_vec(), mass, volume, moments).unwrap();
        let limit = part * 1e-6 * mass * GRAVITY * (4.0 * RADIUS);
        let body = NewBody {
            velocity: DVec3::Z * (2.0 * limit / mass).sqrt(),
            angular_velocity: DVec3::Y * 1000.0,
            ..NewBody::at(DVec3::ZERO, 0)
        };
        let driven = NewBody {
            velocity: DVec3::X,
            prescribed_velocity: [Some(1.0), None, None],
            ..NewBody::at(DVec3::Y, 0)
        };
        let bodies = particles(plan(1, 1.0, 0.0).with_bodies(vec![twin], vec![body, driven]));
        assert_eq!(is_calm(&bodies), calm, "a body at {part}");
    }
}

/// Spin that changes by more than the limit in the calm looks is slowed down by something, and that may be set in motion: the count begins anew. It may be
/// first the larger or the smaller.
#[test]
fn spin_counts_by_how_it_changes() {
    let mass = DENSITY * mercury_engine::state::volume(RADIUS, 3);
    let limit = 1e-6 * mass * GRAVITY * (2.0 * RADIUS);
    let inertia = mass * RADIUS * RADIUS / INVERSE_INERTIA;
    let turning = |energy: f64| {
        let speed = (2.0 * energy / inertia).sqrt();
        let new = NewParticle {
            angular_velocity: DVec3::ONE.normalize() * speed,
            ..NewParticle::at(DVec3::ZERO, RADIUS, MaterialIndex::new(0))
        };
        particles(plan(1, 1.0, 0.0).with_particles(vec![new]))
    };
    for (change, calm) in [(0.99, true), (-0.99, true), (1.01, false), (-1.01, false)] {
        let (before, after) = (turning(1e3 * limit), turning((1e3 + change) * limit));
        let mut rest = rest();
        for _ in 0..LOOKS - 1 {
            assert!(!rest.look(&before, STEP, |_| false));
        }
        assert_eq!(rest.look(&after, STEP, |_| false), calm, "{change}");
        // Else it is the first of another hundred.
        let again = (2..=LOOKS).all(|look| rest.look(&after, STEP, |_| false) == (look == LOOKS));
        assert!(calm || again, "{change}");
    }
}

/// With steps so short that in 1,000 of them nothing has begun to fall: calm lasts a tenth of sqrt(d/g).
#[test]
fn calm_lasts_as_long_as_a_fall_takes_to_show() {
    let new = NewParticle::at(DVec3::ZERO, RADIUS, MaterialIndex::new(0));
    let still = particles(plan(1, 1.0, 0.0).with_particles(vec![new]));
    let least = 0.1 * (2.0 * RADIUS / GRAVITY).sqrt();
    let dt = least / 25_000.0;
    let mut rest = rest();
    let looks = (1..10_000).find(|_| rest.look(&still, dt, |_| false));
    assert!(
        looks.is_some_and(|looks| looks == 2500 || looks == 2501),
        "{looks:?}"
    );
    // A grain that falls from rest has left the limit by then: v^2 / 2 = (g t)^2 / 2 is 1e-2 / 2 of g d.
    let speed = GRAVITY * least;
    assert!(0.5 * speed * speed > 1e3 * 1e-6 * GRAVITY * 2.0 * RADIUS);
}

/// A hundred calm looks in a row: one that is not, and one at which something is awaited, begin the count anew.
#[test]
fn calm_looks_are_counted_in_a_row() {
    let at = |velocity: DVec3| NewParticle {
        velocity,
        ..NewParticle::at(DVec3::ZERO, RADIUS, MaterialIndex::new(0))
    };
    let still = particles(plan(1, 1.0, 0.0).with_particles(vec![at(DVec3::ZERO)]));
    let moving = particles(plan(1, 1.0, 0.0).with_particles(vec![at(DVec3::X)]));
    let mut rest = rest();
    for (last, more) in [(&moving, false), (&still, true)] {
        for _ in 0..LOOKS - 1 {
            assert!(!rest.look(&still, STEP, |_| false));
        }
        assert!(rest.is_near() && !rest.is_over());
        assert!(!rest.look(last, STEP, |_| more));
        assert!(!rest.is_near());
    }
    assert!((1..=LOOKS).all(|look| rest.look(&still, STEP, |_| false) == (look == LOOKS)));
    // Without particles the run is not at rest.
    let mut rest = self::rest();
    let empty = particles(plan(1, 1.0, 0.0));
    assert!((0..200).all(|_| !rest.look(&empty, STEP, |_| false)));
}

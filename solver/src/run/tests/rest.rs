//! When a run has come to rest: kinetic energies just below and just above the limit, of all kinds of grains.

use super::*;
use crate::bodies::NewBody;
use crate::run::rest::Rest;
use crate::state::Particles;

const GRAVITY: f64 = 9.0;
/// I/(m R^2) of a sphere, inverted.
const INVERSE_INERTIA: f64 = 2.5;

/// The particles and bodies of a plan without walls.
fn particles(plan: Draft) -> Particles {
    let plan = plan.plan().unwrap();
    let physics = plan.physics();
    let mut particles = Particles::new(false);
    for new in physics.particles() {
        let (record, mass, prescribed) = new.build(physics.materials(), physics.dimensions());
        particles.push(record, mass, prescribed);
    }
    for new in physics.bodies() {
        new.add_to(&mut particles, physics.clumps());
    }
    particles
}

fn is_calm(particles: &Particles) -> bool {
    let mut rest = Rest::new(GRAVITY, INVERSE_INERTIA);
    (1..=1000).all(|step| rest.is_reached(particles, false) == (step == 1000))
}

/// The limit is 1e-6 m g d per grain, m and d their means: of spheres the energies of moving and of turning count, and so do those of bodies.
#[test]
fn the_limit_is_a_millionth_of_the_weight_times_the_diameter() {
    let material = MaterialIndex::new(0);
    let mass = |radius: f64| DENSITY * crate::state::volume(radius, 3);
    for (part, calm) in [(0.999, true), (1.001, false)] {
        // Two spheres, of which one moves and one turns; fixed and prescribed ones do not count.
        let (small, large) = (RADIUS, 2.0 * RADIUS);
        let mean = 0.5 * (mass(small) + mass(large));
        // Two grains: twice the limit in all, half of it each.
        let each = part * 1e-6 * mean * GRAVITY * (small + large);
        let at = |x: f64, radius: f64| NewParticle::at(DVec3::X * x, radius, material);
        let moving = NewParticle {
            velocity: DVec3::Y * (2.0 * each / mass(small)).sqrt(),
            ..at(0.0, small)
        };
        let inertia = mass(large) * large * large / INVERSE_INERTIA;
        let turning = NewParticle {
            angular_velocity: DVec3::Z * (2.0 * each / inertia).sqrt(),
            ..at(0.1, large)
        };
        let fixed = NewParticle {
            fixed: true,
            ..at(0.2, 9.0 * RADIUS)
        };
        let driven = NewParticle {
            velocity: DVec3::X,
            prescribed_velocity: [Some(1.0), None, None],
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
        let (mass, volume) = (2.0 * mass(RADIUS), 2.0 * crate::state::volume(RADIUS, 3));
        let moments = DVec3::new(0.4, 1.4, 1.4) * (mass * RADIUS * RADIUS);
        let twin = Clump::new("twin", material, pebbles.to_vec(), mass, volume, moments).unwrap();
        let limit = part * 1e-6 * mass * GRAVITY * (4.0 * RADIUS);
        let body = NewBody {
            velocity: DVec3::Z * (2.0 * 0.3 * limit / mass).sqrt(),
            angular_velocity: DVec3::Y * (2.0 * 0.7 * limit / moments.y).sqrt(),
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

/// A thousand calm steps in a row: one that is not, and one at which particles are still to come, begin the count anew.
#[test]
fn calm_steps_are_counted_in_a_row() {
    let at = |velocity: DVec3| NewParticle {
        velocity,
        ..NewParticle::at(DVec3::ZERO, RADIUS, MaterialIndex::new(0))
    };
    let still = particles(plan(1, 1.0, 0.0).with_particles(vec![at(DVec3::ZERO)]));
    let moving = particles(plan(1, 1.0, 0.0).with_particles(vec![at(DVec3::X)]));
    let mut rest = Rest::new(GRAVITY, INVERSE_INERTIA);
    for (last, more) in [(&moving, false), (&still, true)] {
        for _ in 0..999 {
            assert!(!rest.is_reached(&still, false));
        }
        assert!(rest.is_near() && !rest.is_over());
        assert!(!rest.is_reached(last, more));
        assert!(!rest.is_near());
    }
    assert!((1..=1000).all(|step| rest.is_reached(&still, false) == (step == 1000)));
    // Nobody is at rest where there is nobody.
    let mut rest = Rest::new(GRAVITY, INVERSE_INERTIA);
    let nobody = particles(plan(1, 1.0, 0.0));
    assert!((0..2000).all(|_| !rest.is_reached(&nobody, false)));
}

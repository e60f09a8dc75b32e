//! T16 and T17: the Mindlin law along prescribed paths of a sphere on a plane.

use glam::{DVec3, dvec3};

use super::near;
use crate::reference::Simulation;
use crate::reference::laws::*;
use crate::reference::state::Particle;
use crate::reference::walls::{Shape, Wall};

const RADIUS: f64 = 0.25;
const MODULUS: f64 = 1e5;
const SHEAR_MODULUS: f64 = 65000.0;

/// A sphere held at all velocities, pressed into the plane z = 0.
fn pressed(overlap: f64, friction: f64, factor: f64, load_history: LoadHistory) -> Simulation {
    let law = ContactLaw {
        normal: Normal::Hertz {
            effective_modulus: MODULUS,
            damping: 0.0,
        },
        tangential: Tangential::Mindlin {
            effective_shear_modulus: SHEAR_MODULUS,
            damping: 0.0,
            friction,
            static_friction: friction,
            stiffness_factor: factor,
            load_history,
        },
        rolling: None,
        torsion: None,
        cohesion: Cohesion::None,
    };
    let mut simulation = Simulation::new(1.0, law);
    let floor = Shape::Plane {
        point: DVec3::ZERO,
        normal: DVec3::Z,
    };
    simulation.walls.push(Wall::at_rest(floor));
    let mut sphere = Particle::sphere(RADIUS, 1000.0);
    sphere.velocity_held = [true; 3];
    sphere.angular_velocity_held = [true; 3];
    sphere.position = dvec3(0.0, 0.0, RADIUS - overlap);
    simulation.particles.push(sphere);
    simulation.start();
    simulation
}

/// Moves the sphere by `path` in `steps` steps; returns the work that the tangential force does.
fn go(simulation: &mut Simulation, path: DVec3, steps: u64) -> f64 {
    let dx = path.x / steps as f64;
    simulation.particles[0].velocity = path / steps as f64 / simulation.time_step;
    let mut work = 0.0;
    for _ in 0..steps {
        let before = simulation.particles[0].force.x;
        simulation.advance();
        work += 0.5 * (before + simulation.particles[0].force.x) * dx;
    }
    work
}

fn along_x(x: f64) -> DVec3 {
    dvec3(x, 0.0, 0.0)
}

#[test]
fn t16_cycle_at_constant_overlap() {
    for (factor, slip) in [(2.0 / 3.0, 5.769230769e-4), (1.0, 3.846153846e-4)] {
        let mut simulation = pressed(0.015, 0.1, factor, LoadHistory::Secant);
        let contact = simulation.contacts.values().next().unwrap();
        near(contact.response.normal_force, 122.4744871, 1e-9);
        assert_eq!(simulation.particles[0].force.x, 0.0);

        go(&mut simulation, along_x(4e-6), 1);
        near(
            -simulation.particles[0].force.x,
            factor * 31843.366656 * 4e-6,
            1e-9,
        );
        // Just below the slip displacement it sticks, just above it slides at μ N.
        go(&mut simulation, along_x(slip * 0.999999 - 4e-6), 1);
        assert!(-simulation.particles[0].force.x < 12.247448714 * (1.0 - 1e-7));
        go(&mut simulation, along_x(slip * 1.0001 - slip * 0.999999), 1);
        near(-simulation.particles[0].force.x, 12.247448714, 1e-9);

        let amplitude = 0.0025;
        go(&mut simulation, along_x(amplitude - slip * 1.0001), 10);
        // The trapezoid rule cuts off at most k_t dx²/8 at each of four corners, 2e-8 of the whole.
        let steps = 20_000;
        let there = go(&mut simulation, along_x(-2.0 * amplitude), steps);
        let back = go(&mut simulation, along_x(2.0 * amplitude), steps);
        let dissipated = 4.0 * 12.247448714 * (amplitude - slip);
        near(-(there + back), dissipated, 1e-7);
    }
    near(
        4.0 * 12.247448714 * (0.0025 - 5.769230769e-4),
        0.0942111440,
        1e-8,
    );
}

/// Shear under a small load, unshear under a larger one. Returns the work done by the spring, and
/// the force left before and after the load is taken off again.
fn shear_press_unshear_release(load_history: LoadHistory) -> (f64, f64, f64) {
    let (shallow, deep, shear) = (0.00375, 0.015, 1e-4);
    let mut simulation = pressed(shallow, 1e3, 2.0 / 3.0, load_history);
    let mut work = go(&mut simulation, along_x(shear), 7);
    work += go(&mut simulation, dvec3(0.0, 0.0, shallow - deep), 7);
    work += go(&mut simulation, along_x(-shear), 7);
    let before = simulation.particles[0].force.x;
    work += go(&mut simulation, dvec3(0.0, 0.0, deep - shallow), 7);
    (work, before, simulation.particles[0].force.x)
}

#[test]
fn t17_the_secant_law_creates_energy() {
    let (work, _, left) = shear_press_unshear_release(LoadHistory::Secant);
    near(work, 5.30722778e-5, 1e-8);
    assert!(left.abs() < 1e-9);
}

#[test]
fn t17_the_rescaled_law_does_not() {
    let stiffness = |overlap: f64| 2.0 / 3.0 * 8.0 * SHEAR_MODULUS * (RADIUS * overlap).sqrt();
    let (soft, stiff, shear) = (stiffness(0.00375), stiffness(0.015), 1e-4);
    let (work, before, after) = shear_press_unshear_release(LoadHistory::Rescale);
    // −k₁ξ²/2 in; pressing keeps the force k₁ξ; unshearing against k₂ gives k₁ξ² − k₂ξ²/2.
    near(work, 0.5 * (soft - stiff) * shear * shear, 1e-9);
    near(before, (stiff - soft) * shear, 1e-9);
    // Unloading to half the contact radius halves what is left.
    near(after, 0.5 * before, 1e-9);
}

#[test]
fn rescaled_law_equals_secant_law_at_constant_load() {
    let path = [1e-4, 1e-3, -3e-4, -2e-3, 5e-4];
    let run = |load_history| {
        let mut simulation = pressed(0.015, 0.1, 1.0, load_history);
        path.map(|x| {
            go(&mut simulation, along_x(x), 3);
            simulation.particles[0].force.x
        })
    };
    let (secant, rescaled) = (run(LoadHistory::Secant), run(LoadHistory::Rescale));
    for (a, b) in secant.into_iter().zip(rescaled) {
        near(a, b, 1e-12);
    }
}

#[test]
fn static_friction_gives_stick_slip() {
    let mut simulation = pressed(0.015, 0.1, 1.0, LoadHistory::Secant);
    let law = (simulation.pair_parameters)(0, 0);
    let Tangential::Mindlin {
        effective_shear_modulus,
        ..
    } = law.tangential
    else {
        unreachable!()
    };
    let sticky = ContactLaw {
        tangential: Tangential::Mindlin {
            effective_shear_modulus,
            damping: 0.0,
            friction: 0.1,
            static_friction: 0.2,
            stiffness_factor: 1.0,
            load_history: LoadHistory::Secant,
        },
        ..law
    };
    simulation.pair_parameters = Box::new(move |_, _| sticky);
    go(&mut simulation, along_x(1.9 * 3.846153846e-4), 1); // holds up to μ_s N
    near(-simulation.particles[0].force.x, 1.9 * 12.247448714, 1e-8);
    go(&mut simulation, along_x(0.2 * 3.846153846e-4), 1); // beyond, falls back to μ N
    near(-simulation.particles[0].force.x, 12.247448714, 1e-9);
    go(&mut simulation, along_x(0.5 * 3.846153846e-4), 1); // and sticks again
    near(-simulation.particles[0].force.x, 1.5 * 12.247448714, 1e-8);
}

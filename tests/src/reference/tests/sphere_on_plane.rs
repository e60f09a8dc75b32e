//! T12, T14 and T15: sliding, rolling and spinning on a plane, and a sphere squeezed between two.

use std::f64::consts::PI;

use glam::{DVec3, dvec3};

use super::near;
use crate::closed_forms::*;
use crate::reference::Simulation;
use crate::reference::laws::*;
use crate::reference::state::Particle;
use crate::reference::walls::{Shape, Wall};

const RADIUS: f64 = 0.005;
const GRAVITY: f64 = 9.81;
const FRICTION: f64 = 0.3;
/// Stiff enough for δ/R = 2.6e-6, which is how far the lever R − δ/2 is off.
const STIFFNESS: f64 = 1e6;
const TOLERANCE: f64 = 1e-5;

/// A sphere on a slope of `angle`, sunk in to its equilibrium, with springs still relaxed.
///
/// `damping` is that of the sliding and rolling springs, relative to critical damping. The more of it,
/// the sooner they settle; the less, the more sharply sliding ends: a sliding spring begins to hold
/// when k u < γ |du/dt|.
fn on_slope(
    angle: f64,
    [rolling, torsion]: [f64; 2],
    lever: RollingLever,
    damping: f64,
) -> Simulation {
    let sphere = Particle::sphere(RADIUS, 2500.0);
    let mass = sphere.mass;
    let tangential = 2.0 / 7.0 * STIFFNESS;
    let resistance = |friction| Resistance {
        stiffness: ResistanceStiffness::Fixed(tangential),
        dissipation: 2.0 * damping * (1.4 * mass * tangential).sqrt(),
        friction,
        static_friction: friction,
    };
    let law = ContactLaw {
        normal: Normal::Linear {
            stiffness: STIFFNESS,
            damping: LinearDamping::Ratio(0.3),
        },
        tangential: Tangential::Linear {
            stiffness: tangential,
            dissipation: 2.0 * damping * (2.0 / 7.0 * mass * tangential).sqrt(),
            friction: FRICTION,
            static_friction: FRICTION,
        },
        rolling: Some(resistance(rolling)),
        torsion: Some(resistance(torsion)),
        cohesion: Cohesion::None,
    };
    let mut simulation = Simulation::new(1e-6, law);
    simulation.conventions.rolling_lever = lever;
    simulation.gravity = GRAVITY * dvec3(angle.sin(), 0.0, -angle.cos());
    let floor = Shape::Plane {
        point: DVec3::ZERO,
        normal: DVec3::Z,
    };
    simulation.walls.push(Wall::at_rest(floor));
    let overlap = mass * GRAVITY * angle.cos() / STIFFNESS;
    let position = dvec3(0.0, 0.0, RADIUS - overlap);
    simulation
        .particles
        .push(sphere.placed(position, DVec3::ZERO, DVec3::ZERO));
    simulation
}

/// Mean acceleration down the slope, and angular acceleration, after the springs have settled. While
/// they stretch the sphere gains about 3e-4 m/s, which friction needs 12 ms to take back when it
/// exceeds what is needed by as little as it does 0.1 degrees below a threshold.
fn accelerations(mut simulation: Simulation) -> (f64, f64) {
    simulation.advance_by(30_000);
    let (early, spin) = (
        simulation.particles[0].velocity.x,
        simulation.particles[0].angular_velocity.y,
    );
    let steps = 10_000;
    simulation.advance_by(steps);
    let time = steps as f64 * simulation.time_step;
    let sphere = &simulation.particles[0];
    (
        (sphere.velocity.x - early) / time,
        (sphere.angular_velocity.y - spin) / time,
    )
}

#[test]
fn t14_sliding_turns_into_rolling() {
    let mut simulation = on_slope(0.0, [0.0, 0.0], RollingLever::EffectiveRadius, 0.002);
    simulation.particles[0].velocity.x = 1.0;
    let slip = |simulation: &Simulation| {
        let sphere = &simulation.particles[0];
        sphere.velocity.x - sphere.angular_velocity.y * RADIUS
    };
    let (mut before, mut position) = (slip(&simulation), 0.0);
    while slip(&simulation) > 0.0 && simulation.time() < 0.1 {
        (before, position) = (slip(&simulation), simulation.particles[0].position.x);
        simulation.advance();
    }
    // The slip falls linearly; where it vanished lies within the last step.
    let share = before / (before - slip(&simulation));
    let time = simulation.time() - (1.0 - share) * simulation.time_step;
    near(time, 0.0970826659, TOLERANCE);
    position += share * (simulation.particles[0].position.x - position);
    near(position, 0.0832137136, TOLERANCE);
    // Friction has no moment about a line in the plane, so (5/7)(v + (2/5) R ω) is conserved: it is
    // the speed of rolling whatever the springs still do.
    let sphere = &simulation.particles[0];
    let rolling = 5.0 / 7.0 * (sphere.velocity.x + 0.4 * RADIUS * sphere.angular_velocity.y);
    near(rolling, 5.0 / 7.0, TOLERANCE);
    near(sphere.velocity.x, 5.0 / 7.0, TOLERANCE);
}

#[test]
fn t14_slopes() {
    let slope = |degrees: f64| {
        on_slope(
            degrees.to_radians(),
            [0.0, 0.0],
            RollingLever::default(),
            0.5,
        )
    };
    let (rolling, spinning) = accelerations(slope(20.0));
    near(rolling, 2.396584004, TOLERANCE);
    near(spinning * RADIUS, 2.396584004, TOLERANCE);
    // The difference from g sin θ is friction per mass.
    near(
        GRAVITY * 20f64.to_radians().sin() - rolling,
        0.958633602,
        3.0 * TOLERANCE,
    );
    let (slipping, spinning) = accelerations(slope(50.0));
    near(slipping, 5.623172052, TOLERANCE);
    near(spinning, 945.8619677, TOLERANCE);
    // The threshold, seen from both sides: does the contact point stay behind?
    let slip = |degrees| {
        let (linear, angular) = accelerations(slope(degrees));
        linear - angular * RADIUS
    };
    assert!(slip(46.39718103 - 0.1).abs() < TOLERANCE);
    assert!(slip(46.39718103 + 0.1) > 10.0 * TOLERANCE);
}

#[test]
fn t15_rolling_resistance_on_slopes() {
    for (lever, threshold, at_20_degrees) in [
        (RollingLever::EffectiveDiameter, 11.30993, 1.079671917),
        (RollingLever::EffectiveRadius, 5.710593, 1.738127961),
    ] {
        let slope = |degrees: f64| on_slope(degrees.to_radians(), [0.1, 0.0], lever, 1.0);
        near(accelerations(slope(20.0)).0, at_20_degrees, TOLERANCE);
        assert!(accelerations(slope(threshold - 0.1)).0.abs() < TOLERANCE);
        assert!(accelerations(slope(threshold + 0.1)).0 > 10.0 * TOLERANCE);
    }
}

#[test]
fn t15_torsion_stops_a_spinning_sphere() {
    let mut simulation = on_slope(0.0, [0.0, 0.05], RollingLever::EffectiveDiameter, 0.002);
    simulation.particles[0].angular_velocity.z = 100.0;
    simulation.advance_by(100_000);
    let spin = simulation.particles[0].angular_velocity.z;
    near((100.0 - spin) / simulation.time(), 490.5, TOLERANCE);
    while simulation.particles[0].angular_velocity.z > 0.0 && simulation.time() < 0.21 {
        simulation.advance();
    }
    near(simulation.time(), 0.203873598, TOLERANCE);
    // The spring gives back what it has stored: 490.5/√(a² k/I) = 0.0105 rad/s at most.
    simulation.advance_by(2_000);
    assert!(simulation.particles[0].angular_velocity.z.abs() < 0.0105);
}

/// A sphere of unit mass between two fixed ones, turning at 1 rad/s about `axis`. Returns normal
/// force and couple along `axis` of one contact after the steps from 0, dt, 0.02 s and 0.04 s.
fn squeezed(axis: DVec3) -> (f64, [f64; 4]) {
    let (stiffness, dissipation) = linear_from_contact_time(0.02, 0.7, 0.5);
    let resistance = Resistance {
        stiffness: ResistanceStiffness::Fixed(0.4 * stiffness),
        dissipation: 0.4 * dissipation,
        friction: 0.1,
        static_friction: 0.1,
    };
    let law = ContactLaw {
        normal: Normal::Linear {
            stiffness,
            damping: LinearDamping::Dissipation(dissipation),
        },
        tangential: Tangential::None,
        rolling: Some(resistance),
        torsion: Some(resistance),
        cohesion: Cohesion::None,
    };
    let mut simulation = Simulation::new(4e-4, law);
    simulation.conventions.rolling_lever = RollingLever::EffectiveDiameter;
    simulation.conventions.startup_increment = true;
    for x in [-0.995, 0.0, 0.995] {
        let mut sphere = Particle::sphere(0.5, 6.0 / PI);
        sphere.position.x = x;
        sphere.fixed = x != 0.0;
        sphere.angular_velocity = if sphere.fixed { DVec3::ZERO } else { axis };
        simulation.particles.push(sphere);
    }
    let mut normal_force = 0.0;
    let mut couples = [0.0; 4];
    for step in 0..=100u64 {
        simulation.advance();
        let response = simulation.contacts.values().next().unwrap().response;
        normal_force = response.normal_force;
        let wanted = [0, 1, 50, 100].iter().position(|&k| k == step);
        if let Some(row) = wanted {
            couples[row] = response.couple.dot(axis);
        }
    }
    (normal_force, couples)
}

#[test]
fn t15_squeezed_sphere() {
    for axis in [DVec3::Z, DVec3::Y, DVec3::X] {
        let (normal_force, couples) = squeezed(axis);
        assert!((normal_force - 62.480134).abs() < 1e-6);
        // The middle sphere is B of its first contact, so the couple on A has the sign of its spin.
        let expected = [2.7622046, 3.1240067, 1.99994383, -1.3798539];
        for (couple, expected) in couples.into_iter().zip(expected) {
            assert!((couple - expected).abs() <= 1e-7, "{couples:?}");
        }
    }
}

/// Velocity of the contact point after a sticking, undamped collision, relative to before.
fn tangential_rebound(particle: Particle, tangential_stiffness: f64) -> f64 {
    let stiffness = 1e6;
    let law = ContactLaw {
        normal: Normal::Linear {
            stiffness,
            damping: LinearDamping::Dissipation(0.0),
        },
        tangential: Tangential::Linear {
            stiffness: tangential_stiffness * stiffness,
            dissipation: 0.0,
            friction: 1e6,
            static_friction: 1e6,
        },
        rolling: None,
        torsion: None,
        cohesion: Cohesion::None,
    };
    let duration = linear_contact_time(stiffness, 0.0, particle.mass);
    let steps = 20_000;
    let mut simulation = Simulation::new(duration / steps as f64, law);
    let floor = Shape::Plane {
        point: DVec3::ZERO,
        normal: DVec3::Y,
    };
    simulation.walls.push(Wall::at_rest(floor));
    let (approach, slip) = (1e-3, 1e-3);
    let (position, velocity) = (
        dvec3(0.0, particle.radius, 0.0),
        dvec3(slip, -approach, 0.0),
    );
    let radius = particle.radius;
    simulation
        .particles
        .push(particle.placed(position, velocity, DVec3::ZERO));
    simulation.advance_by(steps + 2);
    assert!(simulation.contacts.is_empty());
    let after = &simulation.particles[0];
    assert_eq!(
        (after.velocity.z, after.angular_velocity.truncate().length()),
        (0.0, 0.0)
    );
    (after.velocity.x + after.angular_velocity.z * radius) / slip
}

/// T12: cos(π √(7k_t/2k)) for spheres; for discs, with I = m R²/2, cos(π √(3k_t/k)).
#[test]
fn t12_sticking_rebound_of_spheres_and_discs() {
    for (ratio, expected) in [(1.0, -1.0), (4.0 / 9.0, -0.5), (0.25, 0.0)] {
        let sphere = Particle::sphere(0.5, 100.0);
        let seen = tangential_rebound(sphere, 2.0 / 7.0 * ratio);
        assert!(
            (seen - expected).abs() < 1e-3,
            "sphere: {seen} instead of {expected}"
        );
        let disc = Particle::disc(0.5, 100.0);
        let seen = tangential_rebound(disc, ratio / 3.0);
        assert!(
            (seen - expected).abs() < 1e-3,
            "disc: {seen} instead of {expected}"
        );
    }
}

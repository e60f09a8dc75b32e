//! T1 to T5: head-on collisions under each normal law.

use glam::{DVec3, dvec3};

use super::near;
use crate::closed_forms::*;
use crate::reference::Simulation;
use crate::reference::laws::*;
use crate::reference::state::Particle;

struct Collision {
    restitution: f64,
    duration: f64,
    largest_overlap: f64,
    time_of_largest_overlap: f64,
    largest_force: f64,
    last_force: f64,
}

/// Lets two spheres of `radius` and given masses, just touching, approach at `speed`.
fn collide(
    normal: Normal,
    clamp_tension: bool,
    radius: f64,
    masses: [f64; 2],
    speed: f64,
    time_step: f64,
) -> Collision {
    let mut simulation = Simulation::new(time_step, ContactLaw::frictionless(normal));
    simulation.conventions.clamp_tension = clamp_tension;
    for (side, mass) in [-1.0, 1.0].into_iter().zip(masses) {
        let mut sphere = Particle::sphere(radius, 1.0);
        sphere.inertia *= mass / sphere.mass;
        sphere.mass = mass;
        let velocity = dvec3(-0.5 * side * speed, 0.0, 0.0);
        let position = dvec3(side * radius, 0.0, 0.0);
        simulation
            .particles
            .push(sphere.placed(position, velocity, DVec3::ZERO));
    }
    let mut seen = Collision {
        restitution: 0.0,
        duration: 0.0,
        largest_overlap: 0.0,
        time_of_largest_overlap: 0.0,
        largest_force: 0.0,
        last_force: 0.0,
    };
    while simulation.step < 1_000_000 {
        simulation.advance();
        let [one, two] = &simulation.particles[..] else {
            unreachable!()
        };
        let gap = two.position.x - one.position.x - 2.0 * radius;
        let separation_speed = two.velocity.x - one.velocity.x;
        if gap >= 0.0 {
            seen.restitution = separation_speed / speed;
            seen.duration = simulation.time() - gap / separation_speed;
            return seen;
        }
        if -gap > seen.largest_overlap {
            seen.largest_overlap = -gap;
            seen.time_of_largest_overlap = simulation.time();
        }
        let contact = simulation.contacts.values().next().unwrap();
        seen.last_force = contact.response.normal_force;
        seen.largest_force = seen.largest_force.max(contact.response.normal_force);
    }
    panic!("the spheres never parted");
}

/// Relative error of a damped collision in `steps` per contact time. The dashpot sees the velocity of
/// half a step earlier, as if the mass were off by γ dt/2; and the contact ends up to half a step too
/// early or late, while it still pulls with γ v. Each makes γ dt/(2m*) = ζ π/steps at most.
fn lag(damping_ratio: f64, steps: f64) -> f64 {
    2.0 * damping_ratio * std::f64::consts::PI / steps
}

#[test]
fn t1_linear() {
    let (stiffness, dissipation) = linear_from_contact_time(0.02, 0.7, 0.5);
    let damping = LinearDamping::Dissipation(dissipation);
    let normal = Normal::Linear { stiffness, damping };
    let steps = 20_000.0;
    let time_step = 0.02 / steps;
    let tolerance = lag(damping_ratio(0.7), steps);

    let equal = collide(normal, false, 0.5, [1.0, 1.0], 1.0, time_step);
    near(equal.restitution, 0.7, tolerance);
    near(equal.duration, 0.02, tolerance);
    near(equal.largest_overlap, 0.005360707863247, tolerance);
    assert!((equal.time_of_largest_overlap - 0.00928030711972).abs() < 2.0 * time_step);
    // The last step may end anywhere within one step's travel of the separation.
    assert!((equal.last_force - -12.4836230379).abs() < stiffness * time_step);

    let unequal = collide(normal, false, 0.5, [1.0, 3.0], 1.0, time_step);
    near(unequal.restitution, 0.7478145602066, tolerance);
    near(unequal.duration, 0.0244424440946, tolerance);

    // With ζ given instead of γ the restitution is the same for any masses.
    let ratio = Normal::Linear {
        stiffness,
        damping: LinearDamping::Ratio(damping_ratio(0.7)),
    };
    for masses in [[1.0, 1.0], [1.0, 3.0], [20.0, 0.5]] {
        let seen = collide(ratio, false, 0.5, masses, 1.0, time_step);
        near(seen.restitution, 0.7, tolerance);
    }
}

#[test]
fn t2_clamped() {
    let (stiffness, _) = linear_from_contact_time(0.02, 0.7, 0.5);
    let steps = 20_000.0;
    for nominal in [0.9, 0.7, 0.3] {
        let zeta = damping_ratio(nominal);
        let normal = Normal::Linear {
            stiffness,
            damping: LinearDamping::Ratio(zeta),
        };
        let seen = collide(normal, true, 0.5, [1.0, 1.0], 1.0, 0.02 / steps);
        near(
            seen.restitution,
            clamped_restitution(zeta),
            lag(zeta, steps),
        );
    }
}

fn plastic_law(cohesion_stiffness: f64, penetration_depth: f64) -> Normal {
    Normal::Plastic {
        loading_stiffness: 1e4,
        unloading_stiffness: 2e4,
        cohesion_stiffness,
        penetration_depth,
        dissipation: 0.0,
    }
}

/// Forces at a sequence of overlaps at rest, between two spheres of R = 0.5 m.
fn quasi_static(normal: Normal, overlaps: &[f64]) -> Vec<f64> {
    let mut history = History::default();
    let law = ContactLaw::frictionless(normal);
    let force_at = |&overlap: &f64| {
        let kinematics = Kinematics {
            normal: DVec3::X,
            overlap,
            arm_a: DVec3::ZERO,
            arm_b: DVec3::ZERO,
            relative_velocity: DVec3::ZERO,
            relative_spin: DVec3::ZERO,
            sliding_normal: DVec3::X,
            sliding_velocity: DVec3::ZERO,
            sliding_distance: 1.0,
            pair: Some(DVec3::ZERO),
            effective_mass: 0.5,
            effective_radius: 0.25,
        };
        contact_force(
            &law,
            &Conventions::default(),
            &kinematics,
            &mut history,
            0.0,
        )
        .force
        .x
    };
    overlaps.iter().map(force_at).collect()
}

#[test]
fn t3_plastic_branches() {
    let law = plastic_law(5e3, 0.05);
    let forces = quasi_static(law, &[0.01, 0.02, 0.018, 4.0 / 700.0, 0.08 / 19.0, 0.003]);
    near(forces[0], 100.0, 1e-12); // loading along k₁
    near(forces[1], 200.0, 1e-12);
    near(forces[2], 172.0, 1e-12); // unloading along k₂ = 14000
    assert!(forces[3].abs() < 1e-12 * 200.0); // δ₀ = 0.02 (1 − 10/14)
    near(forces[4], -400.0 / 19.0, 1e-12); // where unloading meets the cohesion branch
    near(forces[5], -15.0, 1e-12); // along −k_c δ
    // Reloading after that starts from the cohesion branch: δ_m = (k₂ + k_c)/(k₂ − k₁) δ.
    let reloaded = quasi_static(law, &[0.02, 0.003, 0.004]);
    let largest = 19.0 / 4.0 * 0.003;
    let k2 = 1e4 + 1e4 * largest / 0.05;
    near(
        reloaded[2],
        k2 * (0.004 - (1.0 - 1e4 / k2) * largest),
        1e-12,
    );
    // Beyond δ* = 0.05 everything follows k₂max from δ₀* = φ 2R* = 0.025.
    let deep = quasi_static(law, &[0.08, 0.06]);
    near(deep[0], 1100.0, 1e-12);
    near(deep[1], 700.0, 1e-12);
}

#[test]
fn t3_plastic_guards() {
    let mut stiff = plastic_law(0.0, 0.05);
    if let Normal::Plastic {
        unloading_stiffness,
        ..
    } = &mut stiff
    {
        *unloading_stiffness = 1e4;
    }
    assert_eq!(quasi_static(stiff, &[0.02, 0.01]), [200.0, 100.0]); // k₁ = k₂: a linear spring
    assert_eq!(
        quasi_static(plastic_law(0.0, 0.0), &[0.02, 0.01]),
        [400.0, 200.0]
    ); // φ = 0
}

#[test]
fn t3_plastic_collisions() {
    for (cohesion, expected) in [(0.0, 0.8829036135323), (5e3, 0.8729429795759)] {
        let law = plastic_law(cohesion, 0.05);
        let seen = collide(law, false, 0.5, [1.0, 1.0], 2.0, 2e-6);
        near(seen.restitution, expected, 1e-8); // 3e-9 seen by another code at this step
        near(seen.largest_overlap, 0.0141421356237, 1e-7);
    }
}

#[test]
fn clamped_tension_spares_cohesion() {
    let forces = |clamp| {
        let law = plastic_law(5e3, 0.05);
        collide(law, clamp, 0.5, [1.0, 1.0], 2.0, 2e-6).restitution
    };
    assert_eq!(forces(true), forces(false));
}

const GLASS: (f64, f64) = (1e7, 0.3);

#[test]
fn t4_hertz_elastic() {
    let law = Normal::Hertz {
        effective_modulus: effective_modulus(GLASS, GLASS),
        damping: 0.0,
    };
    let mass = 0.001308996938995747;
    let seen = collide(
        law,
        false,
        0.005,
        [mass, mass],
        0.2,
        1.406751502853e-3 / 10_000.0,
    );
    near(seen.restitution, 1.0, 1e-7); // second order: (π/10⁴)² = 1e-7
    near(seen.duration, 1.406751502853e-3, 1e-7);
    near(seen.largest_overlap, 9.559089210180e-5, 1e-7);
    near(seen.largest_force, 0.3423435303862, 1e-7);
}

#[test]
fn t4_hertz_force_and_energy() {
    let law = ContactLaw::frictionless(Normal::Hertz {
        effective_modulus: 5494505.494505494,
        damping: 0.0,
    });
    let mut simulation = Simulation::new(1e-6, law);
    for x in [0.0, 0.01 - 1e-5] {
        let sphere = Particle::sphere(0.005, 2500.0);
        simulation
            .particles
            .push(sphere.placed(dvec3(x, 0.0, 0.0), DVec3::ZERO, DVec3::ZERO));
    }
    simulation.start();
    // The overlap 1e-5 is known to round-off of the positions, 1e-18/1e-5.
    near(simulation.particles[1].force.x, 0.01158343465263, 1e-12);
    near(simulation.energies().elastic, 4.633373861053e-8, 1e-12);
}

#[test]
fn t5_hertz_damped() {
    let modulus = effective_modulus(GLASS, GLASS);
    let mass = 0.001308996938995747;
    let elastic = hertz_contact_time(modulus, 0.5 * mass, 0.0025, 0.2);
    let deepest = hertz_largest_overlap(modulus, 0.5 * mass, 0.0025, 0.2);
    for (restitution, duration, overlap) in [
        (0.9, 1.011068, 0.9595942),
        (0.5, 1.093369, 0.7874709),
        (0.1, 1.510660, 0.5768492),
    ] {
        let law = Normal::Hertz {
            effective_modulus: modulus,
            damping: hertz_damping(restitution),
        };
        let seen = collide(law, false, 0.005, [mass, mass], 0.2, elastic / 20_000.0);
        let tolerance = lag(damping_ratio(restitution), 20_000.0);
        near(seen.restitution, restitution, tolerance);
        near(seen.duration / elastic, duration, tolerance);
        near(seen.largest_overlap / deepest, overlap, tolerance);
    }
    // The restitution does not depend on the velocity.
    for speed in [0.02, 0.2, 2.0] {
        let law = Normal::Hertz {
            effective_modulus: modulus,
            damping: hertz_damping(0.5),
        };
        let duration = 1.093369 * hertz_contact_time(modulus, 0.5 * mass, 0.0025, speed);
        let seen = collide(law, false, 0.005, [mass, mass], speed, duration / 100.0);
        assert!(
            (seen.restitution - 0.5).abs() < 1e-3,
            "{}",
            seen.restitution
        );
    }
}

//! What holds for every law: momentum, energy of elastic systems, free motion, periodic images,
//! fixed and held particles, two dimensions.

use std::f64::consts::PI;

use glam::{DVec3, dvec3};

use super::{close, near};
use crate::reference::Simulation;
use crate::reference::laws::*;
use crate::reference::state::{ContactKey, Particle};

fn everything(tangential: Tangential, normal: Normal) -> ContactLaw {
    let resistance = Resistance {
        stiffness: ResistanceStiffness::Sliding,
        dissipation: 0.01,
        friction: 0.2,
        static_friction: 0.25,
    };
    ContactLaw {
        normal,
        tangential,
        rolling: Some(resistance),
        torsion: Some(resistance),
    }
}

fn linear() -> Normal {
    Normal::Linear {
        stiffness: 1e4,
        damping: LinearDamping::Ratio(0.1),
    }
}

fn linear_friction() -> Tangential {
    Tangential::Linear {
        stiffness: 3e3,
        dissipation: 0.1,
        friction: 0.4,
        static_friction: 0.5,
    }
}

fn hertz() -> Normal {
    Normal::Hertz {
        effective_modulus: 1e6,
        damping: 0.2,
    }
}

fn mindlin(load_history: LoadHistory) -> Tangential {
    Tangential::Mindlin {
        effective_shear_modulus: 3e5,
        damping: 0.1,
        friction: 0.4,
        static_friction: 0.5,
        stiffness_factor: 2.0 / 3.0,
        load_history,
    }
}

fn plastic() -> Normal {
    Normal::Plastic {
        loading_stiffness: 1e4,
        unloading_stiffness: 3e4,
        cohesion_stiffness: 2e3,
        penetration_depth: 0.05,
        dissipation: 0.1,
    }
}

/// A dense, turbulent heap of 12 spheres of unequal sizes that all fly inwards.
fn implosion(law: ContactLaw) -> Simulation {
    let mut simulation = Simulation::new(1e-5, law);
    for i in 0..12u8 {
        let angle = f64::from(i);
        let centre = dvec3(
            (2.1 * angle).cos(),
            (2.1 * angle).sin(),
            (0.7 * angle).sin(),
        );
        let radius = 0.025 + 0.001 * angle;
        let spin = 20.0 * dvec3(angle.sin(), angle.cos(), (3.0 * angle).sin());
        let sphere = Particle::sphere(radius, 2000.0);
        simulation
            .particles
            .push(sphere.placed(0.09 * centre, -2.0 * centre, spin));
    }
    simulation
}

#[test]
fn linear_and_angular_momentum() {
    let laws = [
        everything(linear_friction(), linear()),
        everything(mindlin(LoadHistory::Secant), hertz()),
        everything(mindlin(LoadHistory::Rescale), hertz()),
        everything(linear_friction(), plastic()),
    ];
    let variants = [
        Conventions::default(),
        Conventions {
            tangential_history: TangentialHistory::Incremental,
            rolling_lever: RollingLever::EffectiveDiameter,
            clamp_tension: true,
            coulomb_limits: CoulombLimits::Total,
            startup_increment: true,
        },
    ];
    for law in laws {
        for conventions in variants {
            let mut simulation = implosion(law);
            simulation.conventions = conventions;
            let (linear, angular) = simulation.momentum();
            let mut most_contacts = 0;
            for _ in 0..2_000 {
                simulation.advance();
                most_contacts = most_contacts.max(simulation.contacts.len());
            }
            assert!(most_contacts >= 6);
            let (linear_after, angular_after) = simulation.momentum();
            // Round-off of 2000 steps, relative to the momenta that cancel in the sums. The two levers
            // of a contact meet in one point only to round-off, hence more in angular momentum.
            let scale: f64 = simulation.particles.iter().map(|p| p.mass * 2.0).sum();
            let lost = (linear_after - linear).length() / scale;
            let turned = (angular_after - angular).length() / (scale * 0.1);
            assert!(
                lost < 1e-13 && turned < 1e-12,
                "{law:?}: {lost:e}, {turned:e}"
            );
        }
    }
}

#[test]
fn elastic_energy_is_conserved_to_second_order() {
    let drift = |normal, time_step: f64| {
        let mut simulation = implosion(ContactLaw::frictionless(normal));
        simulation.time_step = time_step;
        simulation.gravity = dvec3(0.0, 0.0, -9.81);
        simulation.start();
        let before = simulation.energies();
        // Until all have met and some still touch.
        simulation.advance_by((0.03 / time_step).round() as u64);
        assert!(simulation.energies().elastic > 0.01 * before.kinetic);
        (simulation.energies().total() / before.total() - 1.0).abs()
    };
    let spring = Normal::Linear {
        stiffness: 1e4,
        damping: LinearDamping::Ratio(0.0),
    };
    let spheres = Normal::Hertz {
        effective_modulus: 1e6,
        damping: 0.0,
    };
    for normal in [spring, spheres] {
        let (coarse, fine) = (drift(normal, 1e-5), drift(normal, 1e-6));
        assert!(coarse < 1e-3, "{coarse:e}");
        assert!(fine < 0.05 * coarse, "{coarse:e} -> {fine:e}");
    }
}

/// Stored energies belong to the forces: dE/dδ at rest is the elastic force.
#[test]
fn stored_energy_is_the_integral_of_the_force() {
    let kinematics = |overlap: f64| Kinematics {
        normal: DVec3::X,
        overlap,
        arm_a: DVec3::ZERO,
        arm_b: DVec3::ZERO,
        relative_velocity: DVec3::ZERO,
        relative_spin: DVec3::ZERO,
        pair: Some((DVec3::ZERO, 1.0)),
        effective_mass: 0.5,
        effective_radius: 0.25,
    };
    for normal in [linear(), hertz(), plastic()] {
        let law = ContactLaw::frictionless(normal);
        // Plastic: on the elastic branch below the largest overlap so far.
        let mut history = History {
            largest_overlap: 0.02,
            ..History::default()
        };
        let mut evaluate = |overlap: f64| {
            let conventions = Conventions::default();
            contact_force(&law, &conventions, &kinematics(overlap), &mut history, 0.0)
        };
        let (overlap, step) = (0.019, 1e-6);
        let slope = (evaluate(overlap + step).elastic_energy
            - evaluate(overlap - step).elastic_energy)
            / (2.0 * step);
        near(slope, evaluate(overlap).normal_force, 1e-8);
    }
}

#[test]
fn t7_free_flight_is_exact() {
    for time_step in [0.1, 0.003] {
        let mut simulation = Simulation::new(time_step, ContactLaw::frictionless(linear()));
        simulation.gravity = dvec3(0.3, 0.0, -9.81);
        let (start, speed, spin) = (dvec3(1.0, 2.0, 3.0), dvec3(4.0, -5.0, 6.0), 10.0 * DVec3::Z);
        simulation
            .particles
            .push(Particle::sphere(0.1, 1000.0).placed(start, speed, spin));
        simulation.advance_by(100);
        let (sphere, t) = (&simulation.particles[0], simulation.time());
        close(
            sphere.position,
            start + speed * t + 0.5 * simulation.gravity * t * t,
            1e-13,
        );
        close(sphere.velocity, speed + simulation.gravity * t, 1e-13);
        // Turned by the angle ω t about z, counted modulo full turns.
        let turned = sphere.orientation * DVec3::X;
        close(
            turned,
            dvec3((10.0 * t).cos(), (10.0 * t).sin(), 0.0),
            1e-12,
        );
    }
}

#[test]
fn periodic_images_behave_like_neighbours() {
    let law = everything(linear_friction(), linear());
    let run = |periodic: bool| {
        let mut simulation = Simulation::new(1e-4, law);
        let mut offset = DVec3::ZERO;
        if periodic {
            simulation.periodic_box.min = dvec3(-0.2, 0.0, 0.1);
            simulation.periodic_box.period = [Some(0.5), None, Some(0.7)];
            offset = dvec3(-0.2, 0.0, 0.1); // the corner lies between the two
        }
        for side in [-1.0, 1.0] {
            let position = side * dvec3(0.035, 0.01, 0.035) + offset;
            simulation
                .particles
                .push(Particle::sphere(0.05, 2000.0).placed(
                    simulation.periodic_box.wrap(position),
                    dvec3(-0.4 * side, 0.1, 0.0),
                    dvec3(1.0, 20.0, -3.0 * side),
                ));
        }
        simulation.advance_by(150); // contact lasts about 230 steps
        simulation
    };
    let (open, periodic) = (run(false), run(true));
    assert!(!open.contacts.is_empty());
    for (a, b) in open.particles.iter().zip(&periodic.particles) {
        close(b.velocity, a.velocity, 1e-11);
        close(b.angular_velocity, a.angular_velocity, 1e-11);
    }
    let branch = |s: &Simulation| {
        let branch = s.particles[0].position - s.particles[1].position;
        s.periodic_box.minimum_image(branch)
    };
    assert!((branch(&open) - branch(&periodic)).length() < 1e-12);
    assert!((periodic.particles[0].position - periodic.particles[1].position).length() > 0.3);
}

#[test]
fn fixed_particles_are_infinitely_heavy_and_move_as_told() {
    let law = ContactLaw::frictionless(linear());
    let mut simulation = Simulation::new(1e-5, law);
    simulation.gravity = dvec3(0.0, 0.0, -9.81);
    let push = 0.1 * DVec3::X;
    let mut piston = Particle::sphere(0.05, 2000.0).placed(DVec3::ZERO, push, DVec3::ZERO);
    piston.fixed = true;
    let mut neighbour = piston.clone();
    neighbour.position.x = 0.02; // overlaps the piston without consequence
    let ball = Particle::sphere(0.05, 2000.0);
    let ball = ball.placed(dvec3(0.1199, 0.0, 0.0), DVec3::ZERO, DVec3::ZERO);
    let mass = ball.mass;
    simulation.particles = vec![piston, neighbour, ball];
    simulation.start();
    assert_eq!(simulation.contacts.len(), 1);
    near(
        simulation.contacts[&ContactKey::Pair(1, 2)]
            .kinematics
            .effective_mass,
        mass,
        1e-15,
    );
    simulation.advance_by(1000);
    close(simulation.particles[0].position, 0.001 * DVec3::X, 1e-12);
    assert_eq!(simulation.particles[0].velocity, push);
    assert!(simulation.particles[2].velocity.x > 0.0);
    near(
        simulation.energies().kinetic,
        0.5 * mass * simulation.particles[2].velocity.length_squared(),
        1e-15,
    );
}

#[test]
fn held_components_keep_their_values() {
    let mut simulation = Simulation::new(1e-3, ContactLaw::frictionless(linear()));
    simulation.gravity = dvec3(1.0, 2.0, 3.0);
    let mut sphere = Particle::sphere(0.1, 1.0);
    sphere.velocity = dvec3(0.5, 0.0, 0.0);
    sphere.velocity_held = [true, false, true];
    simulation.particles.push(sphere);
    simulation.advance_by(100);
    close(
        simulation.particles[0].velocity,
        dvec3(0.5, 0.2, 0.0),
        1e-13,
    );
}

#[test]
fn springs_rest_in_the_first_evaluation() {
    let run = |startup_increment| {
        let law = ContactLaw {
            tangential: Tangential::Linear {
                stiffness: 3e3,
                dissipation: 0.0,
                friction: 10.0,
                static_friction: 10.0,
            },
            ..ContactLaw::frictionless(linear())
        };
        let mut simulation = Simulation::new(1e-4, law);
        simulation.conventions.startup_increment = startup_increment;
        for side in [-1.0, 1.0] {
            let position = side * dvec3(0.049, 0.0, 0.0);
            let velocity = side * 0.1 * DVec3::Y;
            let sphere = Particle::sphere(0.05, 2000.0);
            simulation
                .particles
                .push(sphere.placed(position, velocity, DVec3::ZERO));
        }
        simulation.start();
        simulation.particles[0].force.y
    };
    assert_eq!(run(false), 0.0);
    near(run(true), 3e3 * 0.2 * 1e-4, 1e-13); // k_t u_t dt
}

#[test]
fn history_is_lost_when_a_contact_opens() {
    let law = everything(linear_friction(), plastic());
    let mut simulation = Simulation::new(1e-5, law);
    for side in [-1.0, 1.0] {
        let sphere = Particle::sphere(0.05, 2000.0);
        let velocity = dvec3(-side, 0.1 * side, 0.0);
        simulation
            .particles
            .push(sphere.placed(side * 0.05 * DVec3::X, velocity, DVec3::Y));
    }
    simulation.advance_by(10);
    let history = simulation.contacts[&ContactKey::Pair(0, 1)].history;
    assert!(history.sliding.length() > 0.0 && history.largest_overlap > 0.0);
    simulation.particles[1].position.x += 0.01;
    simulation.advance();
    assert!(simulation.contacts.is_empty());
    simulation.particles[1].position.x -= 0.01;
    simulation.advance();
    let fresh = simulation.contacts[&ContactKey::Pair(0, 1)];
    let grown = fresh.kinematics.tangential_velocity() * simulation.time_step;
    close(fresh.history.sliding, grown, 1e-13);
    assert_eq!(fresh.history.largest_overlap, fresh.kinematics.overlap);
}

#[test]
fn discs_stay_in_their_plane() {
    let disc = Particle::disc(0.5, 6.0 / PI);
    near(disc.mass, 1.5, 1e-15);
    near(disc.inertia, 1.5 * 0.125, 1e-15);
    let mut simulation = Simulation::new(1e-5, everything(linear_friction(), linear()));
    for i in 0..6u8 {
        let angle = f64::from(i);
        let out = dvec3(angle.cos(), angle.sin(), 0.0);
        let disc = Particle::disc(0.04 + 0.002 * angle, 2000.0);
        simulation
            .particles
            .push(disc.placed(0.1 * out, -out, (angle - 2.0) * DVec3::Z));
    }
    let before = simulation.momentum();
    let mut touched = 0;
    for _ in 0..5_000 {
        simulation.advance();
        touched = touched.max(simulation.contacts.len());
    }
    assert!(touched >= 5);
    let after = simulation.momentum();
    assert!((after.0 - before.0).length() < 1e-12 && (after.1 - before.1).length() < 1e-12);
    for disc in &simulation.particles {
        assert_eq!((disc.position.z, disc.velocity.z), (0.0, 0.0));
        assert_eq!(disc.angular_velocity.truncate().length(), 0.0);
    }
}

#[test]
fn coulomb_limits() {
    let largest_ratio = |coulomb_limits| {
        let mut law = everything(mindlin(LoadHistory::Secant), hertz());
        if let Tangential::Mindlin {
            damping,
            static_friction,
            ..
        } = &mut law.tangential
        {
            (*damping, *static_friction) = (1.0, 0.4);
        }
        let mut simulation = implosion(law);
        simulation.conventions.coulomb_limits = coulomb_limits;
        let mut largest: f64 = 0.0;
        for _ in 0..2_000 {
            simulation.advance();
            for contact in simulation.contacts.values() {
                let response = contact.response;
                let ratio = response.tangential_force.length() / response.normal_force.abs();
                largest = largest.max(ratio);
            }
        }
        largest
    };
    assert!(largest_ratio(CoulombLimits::Total) <= 0.4 * (1.0 + 1e-12));
    assert!(largest_ratio(CoulombLimits::Elastic) > 0.4 * 1.01); // damping comes on top
}

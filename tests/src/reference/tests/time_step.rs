//! The time step itself: free flight, periodic images, fixed and held particles, the first force
//! evaluation, the life of a contact's history.

use glam::{DVec3, dvec3};

use super::{close, near};
use crate::reference::Simulation;
use crate::reference::laws::*;
use crate::reference::state::{ContactKey, Particle};

fn linear() -> Normal {
    Normal::Linear {
        stiffness: 1e4,
        damping: LinearDamping::Ratio(0.1),
    }
}

fn with_friction(normal: Normal) -> ContactLaw {
    let resistance = Resistance {
        stiffness: ResistanceStiffness::Sliding,
        dissipation: 0.01,
        friction: 0.2,
        static_friction: 0.25,
    };
    ContactLaw {
        normal,
        tangential: Tangential::Linear {
            stiffness: 3e3,
            dissipation: 0.1,
            friction: 0.4,
            static_friction: 0.5,
        },
        rolling: Some(resistance),
        torsion: Some(resistance),
        cohesion: Cohesion::None,
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
    let law = with_friction(linear());
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
fn fixed_particles_are_infinitely_heavy_and_move_as_prescribed() {
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
    let law = with_friction(Normal::Plastic {
        loading_stiffness: 1e4,
        unloading_stiffness: 3e4,
        cohesion_stiffness: 2e3,
        penetration_depth: 0.05,
        dissipation: 0.1,
    });
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

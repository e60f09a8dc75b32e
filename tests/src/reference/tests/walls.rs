//! Where spheres touch walls, and walls that move.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, TAU};

use glam::{DQuat, DVec3, dvec3};

use super::{close, near};
use crate::reference::Simulation;
use crate::reference::laws::*;
use crate::reference::state::Particle;
use crate::reference::walls::*;

fn law() -> ContactLaw {
    ContactLaw {
        normal: Normal::Linear {
            stiffness: 1e4,
            damping: LinearDamping::Ratio(0.1),
        },
        tangential: Tangential::Linear {
            stiffness: 3e3,
            dissipation: 0.1,
            friction: 0.4,
            static_friction: 0.4,
        },
        rolling: None,
        torsion: None,
        cohesion: Cohesion::None,
    }
}

/// The only contact of a sphere with a shape.
#[track_caller]
fn only(shape: &Shape, centre: DVec3, radius: f64) -> WallContact {
    let contacts = shape.contacts(centre, radius);
    assert_eq!(contacts.len(), 1, "{contacts:?}");
    contacts[0]
}

#[test]
fn plane_and_round_walls() {
    let plane = Shape::Plane {
        point: dvec3(0.0, 0.0, 1.0),
        normal: -DVec3::Z,
    };
    let contact = only(&plane, dvec3(5.0, 6.0, 0.95), 0.1);
    close(contact.normal, -DVec3::Z, 1e-15);
    near(contact.distance, 0.05, 1e-13);
    assert!(plane.contacts(dvec3(0.0, 0.0, 0.85), 0.1).is_empty());

    let cylinder = |side| Shape::Cylinder {
        origin: DVec3::X,
        axis: DVec3::Z,
        radius: 0.4,
        side,
    };
    let contact = only(&cylinder(Side::Inside), dvec3(1.0, 0.35, 9.0), 0.1);
    close(contact.normal, -DVec3::Y, 1e-15);
    near(contact.distance, 0.05, 1e-13);
    let contact = only(&cylinder(Side::Outside), dvec3(1.0, 0.45, 9.0), 0.1);
    close(contact.normal, DVec3::Y, 1e-15);
    near(contact.distance, 0.05, 1e-13);

    let sphere = |side| Shape::Sphere {
        origin: DVec3::X,
        radius: 0.4,
        side,
    };
    let out = dvec3(0.6, 0.0, 0.8);
    let contact = only(&sphere(Side::Inside), DVec3::X + 0.35 * out, 0.1);
    close(contact.normal, -out, 1e-14);
    near(contact.distance, 0.05, 1e-13);
    close(
        only(&sphere(Side::Outside), DVec3::X + 0.45 * out, 0.1).normal,
        out,
        1e-14,
    );
}

#[test]
fn disc_has_two_sides_and_a_rim() {
    let disc = Shape::disc(dvec3(0.0, 0.0, 0.3), DVec3::Z, 0.1);
    for side in [-1.0, 1.0] {
        let contact = only(&disc, dvec3(0.02, 0.03, 0.3 + 0.01 * side), 0.02);
        close(contact.normal, side * DVec3::Z, 1e-13);
        close(
            only(&disc, dvec3(0.0, 0.0, 0.3 + 0.01 * side), 0.02).normal,
            side * DVec3::Z,
            1e-13,
        );
    }
    let contact = only(&disc, dvec3(0.0, 0.103, 0.304), 0.02);
    near(contact.distance, 0.005, 1e-12);
    close(contact.normal, dvec3(0.0, 0.6, 0.8), 1e-12);
    assert!(disc.contacts(dvec3(0.0, 0.115, 0.316), 0.02).is_empty());
}

#[test]
fn cone_and_pipe() {
    let funnel = Shape::cone(DVec3::ZERO, DVec3::Z, [0.1, 0.4], [0.1, 0.4]);
    // The line r = z: at (0.15, 0.25) the distance is 0.1/√2, the normal points inwards and up.
    let contact = only(&funnel, dvec3(0.15, 0.0, 0.25), 0.08);
    near(contact.distance, 0.1 * FRAC_1_SQRT_2, 1e-12);
    close(
        contact.normal,
        dvec3(-FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2),
        1e-12,
    );
    let pipe = Shape::pipe(DVec3::ZERO, DVec3::Z, 0.2, [0.0, 1.0]);
    close(
        only(&pipe, dvec3(0.0, -0.17, 0.5), 0.05).normal,
        DVec3::Y,
        1e-12,
    );
    close(
        only(&pipe, dvec3(0.0, -0.23, 0.5), 0.05).normal,
        -DVec3::Y,
        1e-12,
    );
    near(
        only(&pipe, dvec3(0.0, -0.23, 1.04), 0.06).distance,
        0.05,
        1e-12,
    ); // the rim
}

#[test]
fn two_contacts_in_a_groove_one_on_a_ridge() {
    let profile = vec![(0.0, 0.0), (0.2, 0.0), (0.2, 0.3)];
    let vessel = Shape::Revolution {
        origin: DVec3::ZERO,
        axis: DVec3::Z,
        profile,
    };
    let contacts = vessel.contacts(dvec3(0.19, 0.0, 0.01), 0.02);
    assert_eq!(
        contacts.iter().map(|c| c.feature).collect::<Vec<_>>(),
        [0, 2]
    );
    close(contacts[0].normal, DVec3::Z, 1e-12);
    close(contacts[1].normal, -DVec3::X, 1e-12);
    let outside = only(&vessel, dvec3(0.203, 0.0, -0.004), 0.02);
    assert_eq!(outside.feature, 1);
    near(outside.distance, 0.005, 1e-11);
}

/// The nearest contact is as far as the nearest of many points on the shell.
#[test]
fn revolution_against_brute_force() {
    let profile = vec![(0.0, 0.1), (0.2, 0.0), (0.3, 0.3), (0.1, 0.35), (0.1, 0.6)];
    let axis = dvec3(0.48, 0.6, 0.64);
    let origin = dvec3(0.1, -0.2, 0.3);
    let shape = Shape::Revolution {
        origin,
        axis,
        profile: profile.clone(),
    };
    let across = axis.any_orthonormal_vector();
    for i in 0..200u32 {
        // Additive recurrence of the plastic number: points evenly spread over the unit cube.
        let share = |k: i32| (0.5 + f64::from(i) * 1.2207440846057596f64.powi(-k)).fract();
        let centre = origin + 0.8 * (dvec3(share(1), share(2), share(3)) - 0.5) + 0.3 * axis;
        let mut brute = f64::INFINITY;
        for ends in profile.windows(2) {
            for step in 0..=2_000u32 {
                let t = f64::from(step) / 2_000.0;
                let (r, z) = (
                    ends[0].0 + t * (ends[1].0 - ends[0].0),
                    ends[0].1 + t * (ends[1].1 - ends[0].1),
                );
                let from_axis = centre - origin - (centre - origin).dot(axis) * axis;
                let azimuth = from_axis.try_normalize().unwrap_or(across);
                brute = brute.min((origin + r * azimuth + z * axis - centre).length());
            }
        }
        let contacts = shape.contacts(centre, 10.0);
        let nearest = contacts
            .iter()
            .map(|c| c.distance)
            .fold(f64::INFINITY, f64::min);
        // Sampling every 1.6e-4 m misses the foot by at most (8e-5)²/(2 distance), or 8e-5 near zero.
        assert!(
            nearest <= brute + 1e-12 && brute - nearest < 8e-5,
            "{nearest} {brute}"
        );
        for contact in contacts {
            near(contact.normal.length(), 1.0, 1e-12);
        }
    }
}

/// A ball dropped on a floor, seen from the ground and from a lift.
#[test]
fn moving_wall_is_galilean_invariant() {
    let lift = dvec3(0.3, -0.2, 0.7);
    let run = |frame: DVec3| {
        let mut simulation = Simulation::new(1e-4, law());
        let shape = Shape::Plane {
            point: DVec3::ZERO,
            normal: DVec3::Z,
        };
        let motion = Motion::Translation(frame);
        simulation.walls.push(Wall {
            shape,
            motion,
            material: 0,
        });
        simulation
            .particles
            .push(Particle::sphere(0.05, 2000.0).placed(
                dvec3(0.0, 0.0, 0.051),
                dvec3(0.2, 0.1, -0.5) + frame,
                dvec3(1.0, 2.0, 3.0),
            ));
        simulation.advance_by(300);
        let sphere = simulation.particles[0].clone();
        (sphere.velocity - frame, sphere.angular_velocity)
    };
    let (at_rest, moving) = (run(DVec3::ZERO), run(lift));
    assert!(at_rest.0.z > 0.3); // it has bounced
    close(moving.0, at_rest.0, 1e-10);
    close(moving.1, at_rest.1, 1e-10);
}

#[test]
fn rotation_carries_the_shape_and_drags_the_particle() {
    // A ball on an arm of 1 m turns about z; after a quarter turn it is on the y axis.
    let shape = Shape::Sphere {
        origin: DVec3::X,
        radius: 0.1,
        side: Side::Outside,
    };
    let motion = Motion::Rotation {
        origin: DVec3::ZERO,
        angular_velocity: FRAC_PI_2 * DVec3::Z,
    };
    let wall = Wall {
        shape,
        motion,
        material: 0,
    };
    let contacts = wall.contacts(dvec3(0.0, 1.15, 0.0), 0.06, 1.0);
    close(contacts[0].normal, DVec3::Y, 1e-14);
    near(contacts[0].distance, 0.05, 1e-13);
    close(motion.velocity_at(DVec3::Y), -FRAC_PI_2 * DVec3::X, 1e-15);

    // A sphere that lies in a turning drum is dragged along the drum's surface velocity.
    let mut simulation = Simulation::new(1e-5, law());
    simulation.gravity = dvec3(0.0, 0.0, -9.81);
    let axis = DVec3::Y;
    let shape = Shape::Cylinder {
        origin: DVec3::ZERO,
        axis,
        radius: 0.5,
        side: Side::Inside,
    };
    let motion = Motion::Rotation {
        origin: DVec3::ZERO,
        angular_velocity: 2.0 * axis,
    };
    simulation.walls.push(Wall {
        shape,
        motion,
        material: 0,
    });
    let mut sphere = Particle::sphere(0.05, 2000.0);
    sphere.position = dvec3(0.0, 0.0, -0.45001);
    simulation.particles.push(sphere);
    simulation.advance_by(100);
    let dragged = motion.velocity_at(dvec3(0.0, 0.0, -0.5)).x;
    assert!(dragged < 0.0 && simulation.particles[0].velocity.x < 0.0);
    let (force, torque) = simulation.load_on_wall(0, DVec3::ZERO);
    close(force, -simulation.particles[0].force, 1e-15);
    assert!(torque.y < 0.0); // the sphere resists the turning
}

/// Nothing changes when the whole scene is turned, walls and all.
#[test]
fn scenes_have_no_preferred_direction() {
    let run = |turn: DQuat| {
        let mut simulation = Simulation::new(1e-4, law());
        simulation.gravity = turn * dvec3(0.0, 0.0, -9.81);
        let profile = vec![(0.02, 0.0), (0.1, 0.08), (0.1, 0.3)];
        let shape = Shape::Revolution {
            origin: DVec3::ZERO,
            axis: turn * DVec3::Z,
            profile,
        };
        let motion = Motion::Rotation {
            origin: DVec3::ZERO,
            angular_velocity: turn * dvec3(0.0, 0.0, TAU),
        };
        simulation.walls.push(Wall {
            shape,
            motion,
            material: 0,
        });
        for (i, x) in [-0.05, 0.01, 0.06].into_iter().enumerate() {
            let position = turn * dvec3(x, 0.01 * i as f64, 0.14);
            let sphere = Particle::sphere(0.025, 2000.0);
            simulation
                .particles
                .push(sphere.placed(position, DVec3::ZERO, turn * DVec3::X));
        }
        let mut touched = 0;
        for _ in 0..2000 {
            simulation.advance();
            touched += simulation.contacts.len();
        }
        let upright = turn.inverse();
        let positions = simulation.particles.iter().map(|p| upright * p.position);
        (positions.collect::<Vec<_>>(), touched)
    };
    let turn = DQuat::from_scaled_axis(dvec3(0.4, -1.1, 0.8));
    let (upright, turned) = (run(DQuat::IDENTITY), run(turn));
    assert!(upright.1 > 100);
    assert_eq!(upright.1, turned.1);
    for (a, b) in upright.0.into_iter().zip(turned.0) {
        close(b, a, 1e-9); // round-off, amplified by a few collisions
    }
}

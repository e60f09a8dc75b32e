//! Properties that hold for every law: momentum, energy of elastic systems, the plane of discs, friction limits.

use std::f64::consts::PI;

use glam::{DVec3, dvec3};

use super::near;
use crate::reference::Simulation;
use crate::reference::laws::*;
use crate::reference::state::Particle;

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
        cohesion: Cohesion::None,
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
            sliding_normal: SlidingNormal::Step,
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
        sliding_normal: DVec3::X,
        sliding_velocity: DVec3::ZERO,
        sliding_distance: 1.0,
        pair: Some(DVec3::ZERO),
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
        let (mut largest, mut tensile) = (0.0f64, 0.0f64);
        for _ in 0..2_000 {
            simulation.advance();
            for contact in simulation.contacts.values() {
                let response = contact.response;
                let ratio = response.tangential_force.length() / response.normal_force.abs();
                if response.normal_force < 0.0 {
                    tensile = tensile.max(response.tangential_force.length());
                }
                largest = largest.max(ratio);
            }
        }
        (largest, tensile)
    };
    let (ratio, tensile) = largest_ratio(CoulombLimits::Bounded);
    assert!(ratio <= 0.4 * (1.0 + 1e-12) && tensile == 0.0);
    let (ratio, tensile) = largest_ratio(CoulombLimits::Total);
    assert!(ratio <= 0.4 * (1.0 + 1e-12) && tensile > 0.0);
    assert!(largest_ratio(CoulombLimits::Elastic).0 > 0.4 * 1.01); // damping comes on top
}

//! T8, T9, T10: trajectories that independent codes have printed to all digits, with Coulomb's limits
//! as those codes have them.

use std::f64::consts::PI;

use glam::{DVec3, dvec3};

use super::close;
use crate::closed_forms::{hertz_damping, linear_from_contact_time};
use crate::reference::Simulation;
use crate::reference::laws::*;
use crate::reference::state::Particle;
use crate::reference::walls::{Shape, Wall};

/// Two independent codes may differ by round-off that a collision amplifies.
const GOLDEN: f64 = 1e-9;

fn linear_and_sliding(history: TangentialHistory) -> Simulation {
    let (stiffness, dissipation) = linear_from_contact_time(0.02, 0.7, 0.5);
    let law = ContactLaw {
        normal: Normal::Linear {
            stiffness,
            damping: LinearDamping::Dissipation(dissipation),
        },
        tangential: Tangential::Linear {
            stiffness: 2.0 / 7.0 * stiffness,
            dissipation: 0.0,
            friction: 0.5,
            static_friction: 0.5,
        },
        rolling: None,
        torsion: None,
        cohesion: Cohesion::None,
    };
    let mut simulation = Simulation::new(4e-4, law);
    simulation.conventions.sliding_normal = SlidingNormal::Step;
    simulation.conventions.tangential_history = history;
    simulation.conventions.coulomb_limits = CoulombLimits::Total;
    for (side, spin) in [(-1.0, 5.0), (1.0, -2.0)] {
        simulation
            .particles
            .push(Particle::sphere(0.5, 6.0 / PI).placed(
                dvec3(side * 0.5005, 0.0, 0.0),
                dvec3(-side * 0.5, side * 0.3, 0.0),
                dvec3(0.0, 0.0, spin),
            ));
    }
    simulation
}

/// Runs case T8 and checks velocity of 1, spins of both, position of 1.
fn check_t8(history: TangentialHistory, velocity: DVec3, spins: (f64, f64), position: DVec3) {
    let mut simulation = linear_and_sliding(history);
    simulation.advance_by(100);
    let (one, two) = (&simulation.particles[0], &simulation.particles[1]);
    close(one.velocity, velocity, GOLDEN);
    close(two.velocity, -velocity, GOLDEN);
    close(one.angular_velocity, dvec3(0.0, 0.0, spins.0), GOLDEN);
    close(two.angular_velocity, dvec3(0.0, 0.0, spins.1), GOLDEN);
    close(one.position, position, GOLDEN);
}

#[test]
fn t8_linear_with_sliding_incremental() {
    check_t8(
        TangentialHistory::Incremental,
        dvec3(-0.34048476711170006, -0.5503058305389921, 0.0),
        (3.78062819732016, -3.2193718026798326),
        dvec3(-0.5064416194492787, -0.01941524667502733, 0.0),
    );
}

#[test]
fn t8_linear_with_sliding_default() {
    check_t8(
        TangentialHistory::Project,
        dvec3(-0.34048476482689227, -0.5503059654750336, 0.0),
        (3.780627526570739, -3.2193724734292655),
        dvec3(-0.5064416193924911, -0.01941525042084568, 0.0),
    );
}

#[test]
fn t9_hertz_mindlin_sphere_on_wall() {
    let damping = hertz_damping(0.8);
    let law = ContactLaw {
        normal: Normal::Hertz {
            effective_modulus: 5494505.494505494,
            damping,
        },
        tangential: Tangential::Mindlin {
            effective_shear_modulus: 1131221.719457014,
            damping: (2.0f64 / 3.0).sqrt() * damping,
            friction: 0.3,
            static_friction: 0.3,
            stiffness_factor: 2.0 / 3.0,
            load_history: LoadHistory::Secant,
        },
        rolling: None,
        torsion: None,
        cohesion: Cohesion::None,
    };
    let mut simulation = Simulation::new(1e-5, law);
    simulation.conventions.sliding_normal = SlidingNormal::Step;
    simulation.conventions.coulomb_limits = CoulombLimits::Elastic;
    simulation.gravity = dvec3(0.0, 0.0, -9.81);
    let floor = Shape::Plane {
        point: DVec3::ZERO,
        normal: DVec3::Z,
    };
    simulation.walls.push(Wall::at_rest(floor));
    simulation
        .particles
        .push(Particle::sphere(0.005, 2500.0).placed(
            dvec3(0.0, 0.0, 0.0051),
            dvec3(0.1, 0.05, -0.2),
            dvec3(3.0, -4.0, 10.0),
        ));
    simulation.advance_by(400);
    let sphere = &simulation.particles[0];
    let position = dvec3(
        2.5276075022564467e-4,
        1.2029325705069046e-4,
        5.281911862806079e-3,
    );
    close(sphere.position, position, GOLDEN);
    let velocity = dvec3(0.05441137276294136, 0.02532198352330283, 0.1442643911682604);
    close(sphere.velocity, velocity, GOLDEN);
    let spin = dvec3(-9.231377050985667, 18.595450794307528, 10.0);
    close(sphere.angular_velocity, spin, GOLDEN);
}

/// Runs case T10 and checks velocity and spin of both particles, and the total momentum always.
fn check_t10(conventions: Conventions, expected: [(DVec3, DVec3); 2]) {
    let resistance = |stiffness, dissipation, friction| Resistance {
        stiffness: ResistanceStiffness::Fixed(stiffness),
        dissipation,
        friction,
        static_friction: friction,
    };
    let law = ContactLaw {
        normal: Normal::Linear {
            stiffness: 1e4,
            damping: LinearDamping::Dissipation(2.0),
        },
        tangential: Tangential::Linear {
            stiffness: 4e3,
            dissipation: 0.5,
            friction: 0.5,
            static_friction: 0.5,
        },
        rolling: Some(resistance(3e3, 0.2, 0.1)),
        torsion: Some(resistance(2e3, 0.1, 0.05)),
        cohesion: Cohesion::None,
    };
    let mut simulation = Simulation::new(1e-4, law);
    simulation.conventions = Conventions {
        coulomb_limits: CoulombLimits::Total,
        sliding_normal: SlidingNormal::Step,
        ..conventions
    };
    simulation
        .particles
        .push(Particle::sphere(0.05, 2000.0).placed(
            DVec3::ZERO,
            dvec3(0.3, 0.1, 0.0),
            dvec3(1.0, 20.0, -3.0),
        ));
    simulation
        .particles
        .push(Particle::sphere(0.03, 2000.0).placed(
            dvec3(0.081, 0.005, 0.002),
            dvec3(-0.4, 0.0, 0.05),
            dvec3(-10.0, 2.0, 8.0),
        ));
    let momentum = dvec3(0.22368139693559, 0.10471975511966, 0.01130973355292);
    for _ in 0..600 {
        simulation.advance();
        close(simulation.momentum().0, momentum, 1e-13);
    }
    for (particle, (velocity, spin)) in simulation.particles.iter().zip(expected) {
        close(particle.velocity, velocity, GOLDEN);
        close(particle.angular_velocity, spin, GOLDEN);
    }
}

#[test]
fn t10_all_kinds_of_friction_as_mercurydpm() {
    let conventions = Conventions {
        tangential_history: TangentialHistory::Incremental,
        rolling_lever: RollingLever::EffectiveDiameter,
        ..Conventions::default()
    };
    let one = (
        dvec3(
            0.05914679591217452,
            0.07835207145544351,
            0.11491741886880334,
        ),
        dvec3(0.9381355912559206, 13.313545500612783, -3.138996782054753),
    );
    let two = (
        dvec3(0.7150611300362292, 0.10022189140998389, -0.4820250873555715),
        dvec3(-2.17164098634071, -30.78746643452741, 1.9820969652962113),
    );
    check_t10(conventions, [one, two]);
}

#[test]
fn t10_all_kinds_of_friction_default() {
    let one = (
        dvec3(0.05927830312513551, 0.07536194469878962, 0.1112192355360957),
        dvec3(1.1321822293244268, 13.939580268429081, -3.391408439104942),
    );
    let two = (
        dvec3(
            0.7144523003465953,
            0.11406507083893744,
            -0.46490386822266516,
        ),
        dvec3(-4.838759568835323, -35.106873388842565, 2.2668754786808805),
    );
    check_t10(Conventions::default(), [one, two]);
}

//! Bonds: one element on random states, and glued clusters that fly, fall, are pressed and break.

use glam::{DMat3, DQuat, DVec3, dvec3};
use mercury_common::random::Stream;
use mercury_engine::bonds::{
    BondPlan, Bonds, Element, Ends, Gluing, LawOfBonds, Mobility, Section,
};
use mercury_engine::contact::registry::AnyPairLaw;
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, CoulombLimits, Linear, LinearFriction,
    SpringRotation,
};
use mercury_engine::state::MaterialIndex;
use mercury_engine::step::Engine;
use mercury_solver::plan::{Draft, NewParticle};
use mercury_tests::reference::Simulation;
use mercury_tests::reference::bonds::{Bond, BondEnds, BondLaw};
use mercury_tests::scenes::{advance, start};
use mercury_tests::twins::{position_difference, reference_of};
use proptest::prelude::*;

const RADIUS: f64 = 1e-3;
const DENSITY: f64 = 2500.0;

/// A law, twice.
fn both(law: BondLaw) -> (LawOfBonds, BondLaw) {
    let fast = match law {
        BondLaw::Beam {
            youngs_modulus,
            poisson_ratio,
        } => LawOfBonds::Beam {
            youngs_modulus,
            poisson_ratio: Some(poisson_ratio),
        },
        BondLaw::Parallel {
            normal_stiffness,
            shear_stiffness,
        } => LawOfBonds::Parallel {
            normal_stiffness,
            shear_stiffness,
        },
    };
    (fast, law)
}

const BEAM: BondLaw = BondLaw::Beam {
    youngs_modulus: 1e7,
    poisson_ratio: 0.3,
};

const PARALLEL: BondLaw = BondLaw::Parallel {
    normal_stiffness: 5e9,
    shear_stiffness: 2e9,
};

fn vector(size: f64) -> impl Strategy<Value = DVec3> {
    let one = -size..size;
    (one.clone(), one.clone(), one).prop_map(|(x, y, z)| dvec3(x, y, z))
}

proptest! {
    /// Loads, stresses and energy of both laws in any place, stretched, sheared, bent and twisted, with damping.
    ///
    /// Rotation vectors are a series in the engine: 2 asin(s)/s of s = sin(angle/2), cut off at 63/1408 s^10. Ends are turned by up to 0.35 rad along each
    /// axis, at most 0.6 rad, and shifts turn the line by up to 0.35 rad: against the frame some 0.8 rad, s = 0.39, where the rest is 4e-6 of the vector.
    #[test]
    fn elements_agree(
        beam in any::<bool>(),
        turn in vector(3.0),
        branch in vector(1.0),
        shift in vector(0.2),
        a in vector(0.35),
        b in vector(0.35),
        moves in (vector(1.0), vector(300.0), vector(300.0)),
        ratio in 0.1..2.0f64,
        damping in 0.0..0.5f64,
        lighter in 1.0..8.0f64,
    ) {
        prop_assume!(branch.length() > 0.1);
        let (fast, plain) = both(if beam { BEAM } else { PARALLEL });
        let length = 2.0 * RADIUS;
        let axis = branch.normalize();
        let second = axis.any_orthonormal_vector();
        let radius = ratio * RADIUS;
        let masses = [1e5, 1e5 * lighter];
        let inertias = masses.map(|inverse| 2.5 * inverse / (RADIUS * RADIUS));
        let bond = Bond {
            particles: [0, 1],
            law: plain,
            radius,
            damping,
            strengths: [f64::INFINITY; 2],
            contact: true,
            length,
            branch: axis * length,
            frame: DMat3::from_cols(axis, second, axis.cross(second)),
            glued: [DQuat::IDENTITY; 2],
        };
        let whole = DQuat::from_scaled_axis(turn);
        let rotations = [a, b].map(|own| whole * DQuat::from_scaled_axis(own));
        let now = whole * (axis + shift) * length;
        let (velocity, spin_a, spin_b) = moves;
        let expected = bond.loads(&BondEnds {
            branch: now,
            rotations,
            velocities: [DVec3::ZERO, velocity],
            spins: [spin_a, spin_b],
            inverse_masses: masses,
            inverse_inertias: inertias,
        });
        let end = |k: usize| Mobility { inverse_mass: masses[k], inverse_inertia: inertias[k] };
        let element = Element::new(fast, length, Section { radius }, damping, [end(0), end(1)]);
        let frame = DQuat::from_rotation_arc(DVec3::X, axis);
        let found = element.act(&Ends {
            branch: now,
            velocity,
            rotations: rotations.map(|end| end * frame),
            spins: [spin_a, spin_b],
        });
        let close = |one: DVec3, other: DVec3, scale: f64| (one - other).length() <= 1e-5 * scale;
        let force = expected.force.length() + expected.couples[0].length() / length;
        prop_assert!(close(found.force, expected.force, force), "{} {}", found.force, expected.force);
        let couple = force * length + expected.couples[1].length();
        for (one, other) in found.couples.iter().zip(expected.couples) {
            prop_assert!(close(*one, other, couple), "{one} {other}");
        }
        let stress = expected.stresses[0].abs() + expected.stresses[1];
        for (one, other) in found.stresses.iter().zip(expected.stresses) {
            prop_assert!((one - other).abs() <= 1e-5 * stress, "{one} {other}");
        }
        prop_assert!((found.energy - expected.energy).abs() <= 2e-5 * expected.energy);
    }
}

/// What is glued, and how.
#[derive(Clone, Copy)]
struct Glue {
    law: BondLaw,
    ratio: f64,
    damping: f64,
    strengths: [f64; 2],
    contact: bool,
}

/// Springs with friction, which acts at the levers of glued pairs. Without dashpots: pairs that overlap by nothing at the start begin to touch by round-off.
fn law() -> AnyPairLaw {
    AnyPairLaw {
        normal: AnyNormal::Linear(Linear::new(1e4, 0.0)),
        tangential: AnyTangential::Linear(LinearFriction {
            stiffness: 3e3,
            dissipation: 0.0,
            friction: 0.5,
            static_friction: 0.5,
            rotation: SpringRotation::Project,
            limits: CoulombLimits::Bounded,
        }),
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    }
}

/// A cluster of spheres of unequal sizes, one of them fixed, some pairs with overlaps and some with gaps, that moves and spins at random.
fn cluster(glue: Glue, seed: u64, speed: f64) -> (Engine, Simulation) {
    let mut random = Stream::new(seed, "bonds against reference", 0);
    let mut vector = |size: f64| {
        (dvec3(random.uniform(), random.uniform(), random.uniform()) * 2.0 - 1.0) * size
    };
    let period = 12.0 * RADIUS;
    let mut plan = Draft::new(1e-6, (DVec3::ZERO, DVec3::splat(period)), DENSITY, law());
    plan.cell = plan.cell.with_periodic([true, false, false]);
    plan.gravity = DVec3::Z * -9.81;
    let mut particles = Vec::new();
    for k in 0..27u32 {
        let place = dvec3(f64::from(k % 3), f64::from(k / 3 % 3), f64::from(k / 9));
        let radius = RADIUS * (1.0 + 0.03 * vector(1.0).x);
        // Across the periodic face.
        let position =
            dvec3(-2.0, 4.0, 4.0) * RADIUS + place * 2.0 * RADIUS + vector(0.03 * RADIUS);
        let mut particle = NewParticle {
            velocity: vector(speed),
            angular_velocity: vector(speed / RADIUS),
            ..NewParticle::at(
                position.rem_euclid(DVec3::splat(period)),
                radius,
                MaterialIndex::new(0),
            )
        };
        if k == 13 {
            particle.fixed = true;
            particle.velocity = DVec3::ZERO;
            particle.angular_velocity = DVec3::ZERO;
        }
        particles.push(particle);
    }
    let reach = 0.1 * RADIUS;
    let entry = BondPlan {
        name: "glue".to_owned(),
        between: None,
        when: Gluing::Start(Some(reach)),
        within: None,
        walls: Vec::new(),
        law: both(glue.law).0,
        radius_ratio: glue.ratio,
        damping: glue.damping,
        strengths: glue.strengths,
        strength_spread: 0.0,
        contact: glue.contact,
    };
    let mut plan = plan.with_particles(particles);
    plan.plans.insert(entry);
    let mut reference = reference_of(&mut plan, &[]);
    for a in 0..27 {
        for b in a + 1..27 {
            let [one, other] = [a, b].map(|index| &reference.particles[index]);
            let way = reference
                .periodic_box
                .minimum_image(other.position - one.position);
            if way.length() - one.radius - other.radius <= reach {
                reference.glue(
                    [a, b],
                    glue.law,
                    glue.ratio,
                    glue.damping,
                    glue.strengths,
                    glue.contact,
                );
            }
        }
    }
    (start(plan), reference)
}

fn left(engine: &Engine) -> usize {
    engine.part::<Bonds>().map_or(0, |bonds| bonds.all().len())
}

/// Ends turn by 0.05 rad at most, where the series of the engine is exact to round-off. Velocities of 0.1 m/s over 1e-3 s are a tenth of a radius; differences
/// of 1e-16 radii grow with contacts and bonds as those of contacts alone do.
#[test]
fn clusters_move_alike() {
    for (k, law) in [BEAM, PARALLEL].into_iter().enumerate() {
        for (contact, damping, ratio) in [(true, 0.0, 1.0), (false, 0.1, 0.5), (true, 0.3, 0.7)] {
            let glue = Glue {
                law,
                ratio,
                damping,
                strengths: [f64::INFINITY; 2],
                contact,
            };
            let (mut engine, mut reference) = cluster(glue, k as u64, 0.05);
            assert_eq!(left(&engine), reference.bonds.len());
            assert!(reference.bonds.len() > 50);
            assert_eq!(reference.shortened.is_empty(), !contact);
            for _ in 0..10 {
                advance(&mut engine, 100);
                reference.advance_by(100);
                let apart = position_difference(&engine, &reference);
                assert!(apart < 1e-9, "{law:?}, {contact}: {apart:e}");
            }
        }
    }
}

/// The same bonds break in the same steps, and the pairs meet again by what they overlap.
#[test]
fn clusters_break_alike() {
    for (k, law) in [BEAM, PARALLEL].into_iter().enumerate() {
        for contact in [true, false] {
            let glue = Glue {
                law,
                ratio: 0.8,
                damping: 0.05,
                strengths: [1.5e5, 1.2e5],
                contact,
            };
            let (mut engine, mut reference) = cluster(glue, 10 + k as u64, 0.5);
            let glued = reference.bonds.len();
            for step in 0..1000 {
                advance(&mut engine, 1);
                reference.advance();
                assert_eq!(left(&engine), reference.bonds.len(), "after {step} steps");
            }
            let broken = glued - reference.bonds.len();
            assert!(broken > 10 && broken < glued, "{broken} of {glued}");
            let apart = position_difference(&engine, &reference);
            assert!(apart < 1e-8, "{law:?}, {contact}: {apart:e}");
        }
    }
}

//! Momentum: what one particle gains another loses.

use std::sync::Arc;

use glam::{DVec3, dvec3};
use mercury_engine::contact::rolling::FrictionSpring;
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, CoulombLimits, LinearFriction, Luding,
    PairLaw, Plastic, SpringRotation,
};
use mercury_engine::physics::Setup;
use mercury_engine::state::MaterialIndex;
use mercury_engine::step::Engine;
use mercury_solver::plan::NewParticle;
use mercury_tests::scenes::{advance, plan, start};

/// Seven spheres of four sizes that fly together, stick and tumble on, with friction of every kind.
fn cluster() -> Engine {
    let spring = |friction| FrictionSpring {
        stiffness: Some(1e4),
        dissipation: 0.05,
        friction,
        static_friction: friction,
    };
    let law = PairLaw {
        normal: AnyNormal::Plastic(Plastic {
            loading_stiffness: 1e4,
            unloading_stiffness: 5e4,
            cohesion_stiffness: 2e4,
            penetration_depth: 0.05,
            dissipation: 0.5,
            clamp_tension: false,
        }),
        tangential: AnyTangential::Linear(LinearFriction {
            stiffness: 1e4,
            dissipation: 0.1,
            friction: 0.4,
            static_friction: 0.5,
            rotation: SpringRotation::Project,
            limits: CoulombLimits::Bounded,
        }),
        rolling: AnyRolling::Luding(Luding {
            rolling: spring(0.1),
            torsion: spring(0.05),
            lever: 1.0,
            rotation: SpringRotation::Project,
        }),
        adhesion: AnyAdhesion::None,
    };
    let corners = [
        DVec3::ZERO,
        DVec3::X,
        DVec3::NEG_X,
        DVec3::Y,
        DVec3::NEG_Y,
        DVec3::Z,
        DVec3::NEG_Z,
    ];
    let particles = corners
        .iter()
        .enumerate()
        .map(|(k, &out)| NewParticle {
            velocity: -0.4 * out
                + 0.1 * out.cross(dvec3(0.3, 0.2, 1.0))
                + dvec3(0.02, -0.01, 0.015),
            angular_velocity: 5.0 * dvec3(k as f64 - 3.0, 1.0, 2.0 - k as f64),
            ..NewParticle::at(
                out * 0.07 + 0.004 * out.cross(DVec3::ONE),
                0.025 + 0.003 * (k % 4) as f64,
                MaterialIndex::new(0),
            )
        })
        .collect();
    start(plan(2e-5, 2000.0, law).with_particles(particles))
}

/// Linear momentum, angular momentum about the origin, Σ m|v| and Σ |x||m v| + I|w|.
fn momenta(engine: &Engine) -> (DVec3, DVec3, f64, f64) {
    let particles = &engine.particles;
    let mut sums = (DVec3::ZERO, DVec3::ZERO, 0.0, 0.0);
    for (record, &mass) in particles.records.iter().zip(&particles.masses) {
        let momentum = record.velocity * mass;
        let spin = record.angular_velocity * (0.4 * mass * record.radius * record.radius);
        sums.0 += momentum;
        sums.1 += record.position.cross(momentum) + spin;
        sums.2 += momentum.length();
        sums.3 += record.position.length() * momentum.length() + spin.length();
    }
    sums
}

/// 1e5 steps. Each step rounds the momentum of every particle by up to 1e-16 of it; as a random walk that makes 1e-16 √(7e5) =
/// 1e-13 of Σ m|v|. The two levers of a contact meet in one point to round-off of positions, hence ten times that for spins.
#[test]
fn momentum_of_an_isolated_cloud_is_kept_for_1e5_steps() {
    let mut engine = cluster();
    let (linear, angular, scale, angular_scale) = momenta(&engine);
    let mut watched = 0;
    for _ in 0..100 {
        advance(&mut engine, 999);
        mercury_tests::scenes::observed_step(&mut engine);
        watched += engine.observation().particle_contacts;
        let after = momenta(&engine);
        let (lost, turned) = ((after.0 - linear).length(), (after.1 - angular).length());
        assert!(
            lost <= 1e-12 * scale,
            "{:e} of Σ m|v| lost after {} steps",
            lost / scale,
            engine.steps()
        );
        assert!(
            turned <= 1e-11 * angular_scale,
            "{:e} of Σ |x||m v| lost after {} steps",
            turned / angular_scale,
            engine.steps()
        );
    }
    assert!(watched > 500, "the cluster holds together: {watched}");
    assert!(engine.list_statistics().0 > 1, "the list was rebuilt");
}

/// The forces of a pair are opposite bit for bit; the sum over a cluster vanishes to round-off.
#[test]
fn forces_are_equal_and_opposite() {
    let mut engine = cluster();
    let mut touched = 0;
    for _ in 0..6_000 {
        advance(&mut engine, 1);
        let loads = &engine.particles.loads;
        let sum: DVec3 = loads.iter().map(|load| load.force).sum();
        let scale: f64 = loads.iter().map(|load| load.force.length()).sum();
        assert!(sum.length() <= 1e-14 * scale, "{sum} of {scale}");
        touched += u32::from(scale > 0.0);
    }
    assert!(touched > 1_000, "{touched} steps in contact");
    let mut pair = engine.physics().inputs().clone();
    pair.particles.truncate(2);
    let pair = Setup::unwatched(Arc::new(pair.physics().unwrap()));
    let mut engine = Engine::new(pair, 1).unwrap();
    let mut touched = 0;
    for _ in 0..6_000 {
        advance(&mut engine, 1);
        let loads = &engine.particles.loads;
        assert_eq!(loads[0].force, -loads[1].force);
        touched += u32::from(loads[0].force != DVec3::ZERO);
    }
    assert!(touched > 100, "{touched} steps in contact");
}

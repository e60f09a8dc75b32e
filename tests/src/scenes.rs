//! Small scenes for the engine, put together by hand.

use std::collections::HashSet;
use std::mem::discriminant;
use std::sync::Arc;

use glam::DVec3;
use mercury_engine::contact::adhesion::liquid::Tables;
use mercury_engine::contact::registry::{AnyPairLaw, LawTable};
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, Contact, PairLaw,
};
use mercury_engine::forces::Watch;
use mercury_engine::lanes::Vector;
use mercury_engine::state::{Id, MaterialIndex, Particle};
use mercury_engine::step::Engine;
use mercury_engine::walls::{Motion, Plane, Shape, Wall};
use mercury_solver::plan::{Draft, Material, NewParticle, Plan, PrescribedMotion};

/// Records of all contacts, no audit.
pub const RECORDS: Option<Watch> = Some(Watch {
    records: true,
    audit: None,
});

/// A law without friction.
pub fn frictionless(normal: AnyNormal) -> AnyPairLaw {
    PairLaw {
        normal,
        tangential: AnyTangential::None,
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    }
}

/// Fails where some normal, tangential or rolling law is in none of these.
pub fn assert_every_law(laws: impl Iterator<Item = AnyPairLaw>) {
    let (mut normal, mut tangential, mut rolling) =
        <(HashSet<_>, HashSet<_>, HashSet<_>)>::default();
    for law in laws {
        normal.insert(discriminant(&law.normal));
        tangential.insert(discriminant(&law.tangential));
        rolling.insert(discriminant(&law.rolling));
    }
    let found = [normal.len(), tangential.len(), rolling.len()];
    let all = [AnyNormal::COUNT, AnyTangential::COUNT, AnyRolling::COUNT];
    assert_eq!(
        found, all,
        "normal, tangential and rolling laws: some are left out"
    );
}

/// A plan in a domain of 2 km about the origin, which no particle leaves.
pub fn plan(time_step: f64, density: f64, law: AnyPairLaw) -> Draft {
    Draft::new(
        time_step,
        (DVec3::splat(-1e3), DVec3::splat(1e3)),
        density,
        law,
    )
}

/// A second material of another density (kg/m³) that follows the same law.
pub fn add_material(plan: &mut Draft, density: f64) -> u32 {
    let law = plan.laws.laws[0];
    let name = format!("material {}", plan.materials.len());
    plan.materials.push(Material { name, density });
    let count = plan.materials.len();
    plan.laws = LawTable {
        materials: count,
        laws: vec![law; count * count],
        tables: Tables::default(),
    };
    count as u32 - 1
}

/// A free sphere of material 0.
pub fn sphere(position: DVec3, radius: f64, velocity: DVec3, spin: DVec3) -> NewParticle {
    NewParticle {
        velocity,
        angular_velocity: spin,
        ..NewParticle::at(position, radius, MaterialIndex::new(0))
    }
}

/// A copy of the particle, held at all its velocities.
pub fn held(particle: NewParticle) -> NewParticle {
    NewParticle {
        prescribed: PrescribedMotion::boxed(
            particle.velocity.to_array().map(Some),
            particle.angular_velocity.to_array().map(Some),
        ),
        ..particle
    }
}

/// A wall of material 0 that is always there.
pub fn wall(shape: Shape, motion: Motion) -> Wall {
    Wall {
        name: "wall".to_owned(),
        material: MaterialIndex::new(0),
        shape,
        motion,
        from: f64::NEG_INFINITY,
        until: f64::INFINITY,
        reference: DVec3::ZERO,
    }
}

/// A plane at rest through `point` (m) with particles where `normal` points.
pub fn plane(point: DVec3, normal: DVec3) -> Wall {
    let plane = Plane::new(point, normal).expect("a finite point and a direction");
    wall(Shape::Plane(plane), Motion::default())
}

/// The start of what a draft describes, in the calling thread.
pub fn start(draft: Draft) -> Engine {
    start_planned(draft.plan().expect("a plan of finite numbers"))
}

/// The start of a plan, in the calling thread.
pub fn start_planned(plan: Plan) -> Engine {
    Engine::new(Arc::new(plan), 1).expect("the scene starts from finite numbers")
}

/// Makes `steps` steps and completes the last one.
pub fn advance(engine: &mut Engine, steps: u64) {
    for _ in 0..steps {
        engine.step(None).expect("the motion stays finite");
    }
    engine.complete_step().expect("the motion stays finite");
}

/// Makes and completes one step whose contacts are recorded.
pub fn observed_step(engine: &mut Engine) {
    engine.step(RECORDS).expect("the motion stays finite");
    engine.complete_step().expect("the motion stays finite");
}

/// The row of a particle.
pub fn row(engine: &Engine, id: u32) -> usize {
    let ids = &engine.particles.ids;
    ids.iter()
        .position(|&other| other == Id::new(id))
        .expect("the particle is there")
}

/// A particle by its id.
pub fn particle(engine: &Engine, id: u32) -> Particle {
    engine.particles.records[row(engine, id)]
}

/// A contact at rest along z, for laws on their own.
pub fn contact_at_rest(overlap: f64, effective_radius: f64, effective_mass: f64) -> Contact {
    Contact {
        normal: Vector::Z,
        distance: 2.0 * effective_radius - overlap,
        overlap,
        effective_radius,
        effective_mass,
        normal_velocity: 0.0,
        tangential_velocity: Vector::ZERO,
        sliding_normal: Vector::Z,
        sliding_distance: 2.0 * effective_radius - overlap,
        centre_velocity: Vector::ZERO,
        spin: Vector::ZERO,
    }
}

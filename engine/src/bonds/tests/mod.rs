//! Tests of bonds by idea, and the scenes that they share.

mod beams;
mod breaking;
mod critical_step;
mod element;
mod gluing;
mod same_bytes;
mod walls_and_clumps;

use std::f64::consts::PI;

use glam::DVec3;
use mercury_common::formats::clump::Pebble;

use super::element::Mobility;
use super::{BondPlan, Bonds, Element, Gluing, LawOfBonds, Section};
use crate::bodies::Clump;
use crate::contact::registry::AnyPairLaw;
use crate::contact::{AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, Linear};
use crate::physics::Inputs;
use crate::state::{MaterialIndex, NewParticle};
use crate::step::{Engine, StartOptions};
use crate::walls::{Component, Motion, Plane, Shape, Wall};

const RADIUS: f64 = 1e-3;
const LENGTH: f64 = 2e-3;
const YOUNG: f64 = 1e8;
const DENSITY: f64 = 2500.0;
/// Stiffness of the contacts, N/m.
const CONTACT: f64 = 1e3;

const BEAM: LawOfBonds = LawOfBonds::Beam {
    youngs_modulus: YOUNG,
    poisson_ratio: Some(0.25),
};

fn mass() -> f64 {
    DENSITY * 4.0 / 3.0 * PI * RADIUS.powi(3)
}

/// 1/kg and 1/(kg m^2) of a sphere.
fn free() -> Mobility {
    Mobility {
        inverse_mass: 1.0 / mass(),
        inverse_inertia: 2.5 / (mass() * RADIUS * RADIUS),
    }
}

fn element(damping: f64) -> Element {
    Element::new(
        BEAM,
        LENGTH,
        Section { radius: RADIUS },
        damping,
        [free(); 2],
    )
}

fn law() -> AnyPairLaw {
    AnyPairLaw {
        normal: AnyNormal::Linear(Linear::new(CONTACT, 0.0)),
        tangential: AnyTangential::None,
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    }
}

fn glue() -> BondPlan {
    BondPlan {
        name: "glue".to_owned(),
        between: None,
        when: Gluing::Start(Some(0.01 * RADIUS)),
        within: None,
        walls: Vec::new(),
        law: BEAM,
        radius_ratio: 1.0,
        damping: 0.0,
        strengths: [f64::INFINITY; 2],
        strength_spread: 0.0,
        contact: false,
    }
}

fn inputs(dt: f64, places: &[DVec3], plan: BondPlan) -> Inputs {
    let domain = (DVec3::splat(-0.1), DVec3::splat(0.1));
    let mut inputs = Inputs::new(dt, domain, DENSITY, law());
    let sphere = |place: &DVec3| NewParticle::at(*place, RADIUS, MaterialIndex::new(0));
    inputs.particles = places.iter().map(sphere).collect();
    inputs.plans.insert(plan);
    inputs
}

/// Spheres that touch along x.
fn chain(count: usize) -> Vec<DVec3> {
    (0..count).map(|k| DVec3::X * (LENGTH * k as f64)).collect()
}

fn start(inputs: Inputs) -> Engine {
    Engine::start(inputs.setup().unwrap(), StartOptions::threads(1)).unwrap()
}

fn bonds(engine: &Engine) -> &Bonds {
    engine.part::<Bonds>().unwrap()
}

/// Row of an id.
fn row(engine: &Engine, id: usize) -> usize {
    engine.particles.rows_by_id()[id] as usize
}

fn kinetic(engine: &Engine) -> f64 {
    let particles = &engine.particles;
    let rows = particles.records.iter().zip(&particles.masses);
    rows.map(|(r, m)| {
        0.5 * m
            * (r.velocity.length_squared()
                + 0.4 * r.radius * r.radius * r.angular_velocity.length_squared())
    })
    .sum()
}

fn elastic(engine: &Engine) -> f64 {
    bonds(engine).all().iter().map(|bond| bond.now.energy).sum()
}

fn close_to(found: f64, expected: f64, tolerance: f64) {
    assert!(
        (found - expected).abs() <= tolerance * expected.abs(),
        "{found} instead of {expected}"
    );
}

fn floor(point: DVec3, normal: DVec3, motion: Vec<Component>) -> Wall {
    Wall {
        name: "floor".to_owned(),
        material: MaterialIndex::new(0),
        shape: Shape::Plane(Plane::new(point, normal).unwrap()),
        motion: Motion::new(motion).unwrap(),
        from: 0.0,
        until: f64::INFINITY,
        reference: DVec3::ZERO,
    }
}

fn dumbbell() -> Clump {
    let pebble = |x: f64| Pebble {
        position: DVec3::X * x,
        radius: RADIUS,
    };
    let m = 2.0 * mass();
    let moments = DVec3::new(0.4, 1.4, 1.4) * (m * RADIUS * RADIUS);
    Clump::new(
        "dumbbell",
        MaterialIndex::new(0),
        vec![pebble(-RADIUS), pebble(RADIUS)],
        m,
        m / DENSITY,
        moments,
    )
    .unwrap()
}

//! Effect of the two choices of the effective mass on the restitution of an impact.

use glam::{DQuat, DVec3, dvec3};

use super::rod;
use crate::bodies::NewBody;
use crate::contact::registry::AnyPairLaw;
use crate::contact::{AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, Linear};
use crate::physics::Inputs;
use crate::state::MaterialIndex;
use crate::step::Engine;
use crate::walls::{Motion, Plane, Shape, Wall};

/// Damping ratio of restitution 0.6: zeta = -ln e / sqrt(pi^2 + ln^2 e).
fn damping_ratio() -> f64 {
    let log = -f64::ln(0.6);
    log / log.hypot(std::f64::consts::PI)
}

/// Velocity of the contact point along the normal after the impact of the tilted rod's lower end on a smooth floor, over that
/// before.
fn restitution(contact_point_mass: bool, tilt: f64) -> f64 {
    let law = AnyPairLaw {
        normal: AnyNormal::Linear(Linear::with_damping_ratio(1e6, damping_ratio())),
        tangential: AnyTangential::None,
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    };
    let mut plan = Inputs::new(1e-6, (DVec3::splat(-5.0), DVec3::splat(5.0)), 1.0, law);
    plan.contact_point_mass = contact_point_mass;
    plan.walls.push(Wall {
        name: "floor".to_owned(),
        material: MaterialIndex::new(0),
        shape: Shape::Plane(Plane::new(DVec3::ZERO, DVec3::Z).unwrap()),
        motion: Motion::new(Vec::new()).unwrap(),
        from: 0.0,
        until: f64::INFINITY,
        reference: DVec3::ZERO,
    });
    let height = 0.5 + tilt.sin() + 1e-4;
    let body = NewBody {
        orientation: DQuat::from_rotation_y(tilt),
        velocity: dvec3(0.0, 0.0, -1.0),
        ..NewBody::at(dvec3(0.0, 0.0, height), 0)
    };
    let plan = plan.with_bodies(vec![rod()], vec![body]);
    let mut engine = Engine::new(plan.setup().unwrap(), 1).unwrap();
    engine.steps_at_once(6000, None).unwrap();
    engine.complete_step().unwrap();
    let records = &engine.particles.records;
    let lowest = records
        .iter()
        .min_by(|a, b| a.position.z.total_cmp(&b.position.z))
        .unwrap();
    assert!(lowest.position.z > 0.5, "it has left the floor");
    // The pebble's centre and the contact point move alike along the normal.
    lowest.velocity.z
}

#[test]
fn the_mass_at_the_contact_point_gives_every_impact_its_restitution() {
    // The spring ends at no overlap, a little after the force does: the tension there costs some 0.1 %, and the rod turns by a
    // milliradian meanwhile.
    for tilt in [0.2, 0.7] {
        let found = restitution(true, tilt);
        assert!((found - 0.6).abs() < 3e-3, "{tilt}: {found}");
    }
}

#[test]
fn the_mass_of_the_body_damps_impacts_off_the_centre_more() {
    // The dashpot 2 zeta sqrt(M k) on the smaller mass m: zeta' = zeta sqrt(M/m), e' = exp(-pi zeta' / sqrt(1 - zeta'^2)) with
    // M/m = 1 + M cos^2(tilt) / I_2 at the lever of 1 m, M/I_2 = 3/2.3.
    let tilt = 0.2f64;
    let ratio = 1.0 + 3.0 / 2.3 * tilt.cos().powi(2);
    let zeta = damping_ratio() * ratio.sqrt();
    let expected = (-std::f64::consts::PI * zeta / (1.0 - zeta * zeta).sqrt()).exp();
    let found = restitution(false, tilt);
    assert!((found - expected).abs() < 3e-3, "{found} {expected}");
    assert!(expected < 0.5);
}

//! A rattleback from a surface and 500 pebbles: mclump makes the clump, the solver spins it.
//!
//! Its inertia is that of the surface, and what drives the effect is how its principal axes lie to the curvatures of its bottom: a clump whose tensor and
//! pebbles are in different frames behaves alike in both directions. Lengths are those of the file, masses follow from density 1.

use std::path::PathBuf;
use std::sync::Arc;

use glam::{DQuat, DVec3, dvec3};
use mclump::clump::{Input, Options, build};
use mclump::inertia::comparison::Route;
use mclump::surface::prepare;
use mercury_common::formats::mesh::read_mesh;
use mercury_common::formats::pebble_list::read_pebble_list;
use mercury_solver::bodies::Clump;
use mercury_solver::contact::registry::AnyPairLaw;
use mercury_solver::contact::{
    AnyNormal, AnyRolling, AnyTangential, Linear, LinearFriction, SpringRotation,
};
use mercury_solver::engine::Engine;
use mercury_solver::plan::{NewBody, Plan};
use mercury_tests::scenes::plane;

fn shared(relative: &str) -> Option<PathBuf> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../../shared/data/shapes")
        .join(relative);
    if path.exists() {
        return Some(path);
    }
    assert!(
        std::env::var_os("CI").is_none(),
        "the reference data are missing"
    );
    println!("skipped: the reference data are not installed");
    None
}

#[test]
fn it_stops_in_one_direction_and_not_in_the_other() {
    let (Some(mesh), Some(list)) = (
        shared("mesh/Rattleback.stl"),
        shared("pebbles/rattleback_500_input.csv"),
    ) else {
        return;
    };
    let input = Input {
        name: "rattleback".to_owned(),
        surface: Some(prepare(read_mesh(mesh).unwrap(), false).unwrap()),
        pebbles: read_pebble_list(list).unwrap(),
    };
    let options = Options {
        route: Some(Route::Surface),
        ..Options::default()
    };
    let file = build(&input, &options).unwrap().file;
    let clump = Clump::new(
        "rattleback",
        0,
        file.pebbles.clone(),
        file.mass,
        file.volume,
        file.principal_moments,
    )
    .unwrap();
    // Its curved side is up in the file.
    let orientation =
        DQuat::from_rotation_x(std::f64::consts::PI) * DQuat::from_mat3(&file.rotation);
    let spin_after = |spin: f64, time: f64| {
        let stiffness = 1e7;
        let log = -f64::ln(0.7);
        let law = AnyPairLaw {
            normal: AnyNormal::Linear(Linear::with_damping_ratio(
                stiffness,
                log / log.hypot(std::f64::consts::PI),
            )),
            tangential: AnyTangential::Linear(LinearFriction {
                stiffness: 2.0 / 7.0 * stiffness,
                dissipation: 0.0,
                friction: 0.7,
                static_friction: 0.7,
                rotation: SpringRotation::Project,
            }),
            rolling: AnyRolling::None,
        };
        let step = 3e-4;
        let domain = (DVec3::splat(-1000.0), DVec3::splat(1000.0));
        let mut plan = Plan::bare(step, domain, 1.0, law);
        plan.gravity = dvec3(0.0, 0.0, -10.0);
        plan.walls.push(plane(DVec3::ZERO, DVec3::Z));
        let body = NewBody {
            orientation,
            angular_velocity: dvec3(0.01, 0.01, spin),
            ..NewBody::at(dvec3(0.0, 0.0, 5.9), 0)
        };
        let plan = plan.with_bodies(vec![clump.clone()], vec![body]);
        let mut engine = Engine::new(Arc::new(plan), 1).unwrap();
        engine.steps_at_once((time / step) as u64, None).unwrap();
        engine.particles.bodies()[0].angular_velocity.z
    };
    // The one way it rattles itself to a stop in some 20 s, the other way nearly half of its spin is left.
    let (one, other) = (spin_after(0.7, 22.5), spin_after(-0.7, 22.5));
    assert!(one.abs() < 0.05, "{one}");
    assert!(other < -0.2, "{other}");
}

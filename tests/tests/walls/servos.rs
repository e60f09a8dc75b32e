//! Servos and walls that come and go: what is absent neither moves by its servo nor bounds another wall.

use glam::DVec3;
use mercury_common::curve::Curve;
use mercury_engine::contact::{AnyNormal, Linear};
use mercury_engine::walls::{Area, Component, Motion, Plane, Servo, Shape, Target, Wall};
use mercury_solver::plan::Draft;
use mercury_tests::scenes::{advance, frictionless, plane, start, wall};

const TIME_STEP: f64 = 1e-3;

/// A cubic metre.
fn room() -> Draft {
    let law = frictionless(AnyNormal::Linear(Linear::new(1e3, 0.0)));
    Draft::new(TIME_STEP, (DVec3::ZERO, DVec3::ONE), 1000.0, law)
}

/// A plane halfway up that looks down and is pushed down.
fn piston(target: Target, max_speed: f64) -> Wall {
    let servo = Servo {
        axis: -DVec3::Z,
        target,
        max_speed,
        from: 0.0,
        until: f64::INFINITY,
    };
    let motion = Motion::new(vec![Component::Servo(servo)]).unwrap();
    let middle = Plane::new(0.5 * DVec3::Z, -DVec3::Z).unwrap();
    wall(Shape::Plane(middle), motion)
}

/// Without anything before it a piston goes at its largest speed, as long as it is there: v t, give or take the steps in which it comes to know.
#[test]
fn a_servo_rests_while_its_wall_is_absent() {
    let (speed, until) = (0.1, 0.05);
    let mut scene = room();
    scene.walls.push(Wall {
        until,
        ..piston(Target::Force(Curve::constant(1.0).unwrap()), speed)
    });
    let mut engine = start(scene);
    for _ in 0..3 {
        advance(&mut engine, 100);
        let gone = engine.walls()[0].servos[0].displacement;
        let off = (gone - speed * until).abs();
        assert!(off <= 2.0 * speed * TIME_STEP, "{gone} m");
    }
}

/// A piston that presses on its whole section finds half of it behind an upright plane, as long as that is there, and then all.
#[test]
fn a_wall_that_has_gone_bounds_no_section() {
    let mut scene = room();
    let course = Curve::constant(10.0).unwrap();
    scene
        .walls
        .push(piston(Target::Pressure(course, Area::OfWall), 1e-3));
    scene.walls.push(Wall {
        until: 0.05,
        ..plane(0.5 * DVec3::X, DVec3::X)
    });
    let mut engine = start(scene);
    for (steps, section) in [(40, 0.5), (20, 1.0)] {
        advance(&mut engine, steps);
        let found = engine.walls()[0].servos[0].followed.area();
        assert!((found - section).abs() < 1e-12, "{found} m^2");
    }
}

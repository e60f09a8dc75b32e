//! Poses in closed form, velocities as their derivatives, and bounds of the speed.

use super::random::vector;
use crate::walls::{Component, Motion, MotionTable, Plane, Pose, Shape, Wall, WallError};
use glam::{DQuat, DVec3};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::path::Path;

const FOREVER: f64 = f64::INFINITY;

fn table(text: &str) -> MotionTable {
    MotionTable::parse(Path::new("motion.csv"), text).unwrap()
}

fn one(component: Component) -> Motion {
    Motion::new(vec![component]).unwrap()
}

/// A component that runs from 0 to 2 s, with rates up to about 3 1/s.
fn component() -> impl Strategy<Value = Component> {
    let period = (0.0, 2.0);
    prop_oneof![
        vector(2.0).prop_map(move |velocity| Component::Translation {
            velocity,
            from: period.0,
            until: period.1,
        }),
        (vector(1.0), vector(1.0), -3.0..3.0_f64)
            .prop_filter("an axis", |(axis, _, _)| axis.length() > 1e-3)
            .prop_map(
                move |(axis, origin, angular_velocity)| Component::Rotation {
                    axis,
                    origin,
                    angular_velocity,
                    from: period.0,
                    until: period.1,
                }
            ),
        (vector(0.5), 0.0..0.5_f64, -3.0..3.0_f64).prop_map(
            move |(amplitude, frequency, phase)| Component::Oscillation {
                amplitude,
                frequency,
                phase,
                from: period.0,
                until: period.1,
            }
        ),
        (vector(1.0), vector(1.5), vector(2.0), vector(2.0)).prop_map(|(origin, d, a, b)| {
            let text = format!(
                "t,x,y,z,angle_x,angle_y,angle_z\n0,0,0,0,{},{},{}\n2,{},{},{},{},{},{}\n",
                a.x, a.y, a.z, d.x, d.y, d.z, b.x, b.y, b.z
            );
            Component::Table {
                table: table(&text),
                origin,
            }
        }),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    /// The central difference of the position of a material point is its velocity to second order:
    /// the difference is at most h^2/6 times the third derivative, and a quarter of that for half the
    /// step.
    #[test]
    fn velocity_is_the_derivative_of_the_pose(
        components in prop::collection::vec(component(), 1..4),
        point in vector(1.0),
        time in 0.2..1.8_f64,
    ) {
        let motion = Motion::new(components).unwrap();
        let velocity = motion.velocity(time).at(motion.pose(time).to_global(point));
        let error = |h: f64| {
            let ahead = motion.pose(time + h).to_global(point);
            let behind = motion.pose(time - h).to_global(point);
            ((ahead - behind) / (2.0 * h) - velocity).length()
        };
        // Each component contributes rates up to 3 sqrt(3) 1/s (angles) and TAU/2 1/s (oscillations),
        // at arms that stay below 2 + 4 sqrt(3) per component; (sum of rates)^3 times the arm bounds
        // the third derivative.
        let rates: f64 = 3.0 * 27.0_f64.sqrt();
        let third = rates.powi(3) * 3.0 * (2.0 + 48.0_f64.sqrt());
        let round_off = |h: f64| 1e-14 / h;
        let h = 1e-4;
        prop_assert!(error(h) < h * h / 6.0 * third + round_off(h));
        let (coarse, fine) = (error(2e-3), error(1e-3));
        // The next term of the error is smaller by (rates h)^2 / 20.
        let next = (rates * 2e-3).powi(2) * 2e-3_f64.powi(2) / 6.0 * third / 20.0;
        prop_assert!(
            (coarse - 4.0 * fine).abs() <= 2.0 * next + 4.0 * round_off(1e-3),
            "{coarse} is not 4 * {fine}"
        );
    }

    #[test]
    fn no_point_is_faster_than_the_bound(
        components in prop::collection::vec(component(), 1..4),
        about in vector(1.0),
        offset in vector(0.5),
        end in 0.1..3.0_f64,
    ) {
        let motion = Motion::new(components).unwrap();
        let bound = motion.max_speed(about, offset.length(), end);
        for i in 0..=100 {
            let time = end * f64::from(i) / 100.0;
            let point = motion.pose(time).to_global(about + offset);
            let speed = motion.velocity(time).at(point).length();
            prop_assert!(speed <= bound * (1.0 + 1e-12), "{speed} > {bound} at {time}");
        }
    }
}

#[test]
fn a_translation_holds_outside_its_interval() {
    let motion = one(Component::Translation {
        velocity: DVec3::new(0.0, 0.0, -0.1),
        from: 0.2,
        until: 0.4,
    });
    assert!(!motion.is_static());
    assert_eq!(motion.pose(0.1), Pose::IDENTITY);
    assert_eq!(motion.velocity(0.1).velocity, DVec3::ZERO);
    assert_eq!(motion.velocity(0.2).velocity.z, -0.1);
    assert!((motion.pose(0.3).translation.z + 0.01).abs() < 1e-17);
    assert!((motion.pose(9.0).translation.z + 0.02).abs() < 1e-17);
    assert_eq!(motion.velocity(0.4).velocity, DVec3::ZERO);
}

#[test]
fn a_rotation_is_right_handed_about_its_axis() {
    let origin = DVec3::new(1.0, 0.0, 0.0);
    let motion = one(Component::Rotation {
        axis: DVec3::Z * 7.0,
        origin,
        angular_velocity: FRAC_PI_2,
        from: 0.0,
        until: FOREVER,
    });
    let turned = motion.pose(1.0).to_global(DVec3::new(2.0, 0.0, 0.0));
    assert!((turned - DVec3::new(1.0, 1.0, 0.0)).length() < 1e-15);
    assert_eq!(motion.velocity(1.0).angular_velocity, DVec3::Z * FRAC_PI_2);
    assert!(motion.velocity(1.0).at(origin).length() < 1e-15);
    // Never accumulated: after a million turns the wall is where it was, to the round-off of the angle.
    let back = motion.pose(4e6).to_global(DVec3::new(2.0, 0.0, 0.0));
    assert!((back - DVec3::new(2.0, 0.0, 0.0)).length() < 4e6 * FRAC_PI_2 * 2.0 * f64::EPSILON);
}

#[test]
fn an_oscillation_starts_without_a_jump() {
    let amplitude = DVec3::new(0.0, 0.0, 0.01);
    for phase in [0.0, FRAC_PI_2, 1.0] {
        let motion = one(Component::Oscillation {
            amplitude,
            frequency: 5.0,
            phase,
            from: 0.1,
            until: FOREVER,
        });
        assert_eq!(motion.pose(0.1).translation, DVec3::ZERO);
        let expected = amplitude * ((TAU * 5.0 * 0.03 + phase).sin() - phase.sin());
        assert!((motion.pose(0.13).translation - expected).length() < 1e-16);
        let start = amplitude.z * TAU * 5.0 * phase.cos();
        assert!((motion.velocity(0.1).velocity.z - start).abs() < 1e-15);
    }
}

#[test]
fn an_oscillation_holds_outside_its_interval() {
    let motion = one(Component::Oscillation {
        amplitude: DVec3::new(0.0, 0.0, 0.01),
        frequency: 5.0,
        phase: 0.0,
        from: 0.1,
        until: 0.14,
    });
    let end = 0.01 * (TAU * 5.0 * 0.04).sin();
    for time in [0.14, 0.17, 9.0] {
        let found = motion.pose(time).translation.z;
        // The angle's round-off.
        assert!((found - end).abs() < 1e-16, "{time}: {found}");
        assert_eq!(motion.velocity(time).velocity, DVec3::ZERO, "{time}");
    }
    assert_eq!(motion.pose(0.05), Pose::IDENTITY);
    assert_eq!(motion.velocity(0.05).velocity, DVec3::ZERO);
}

#[test]
fn later_motions_carry_the_origins_of_earlier_ones() {
    let spin = Component::Rotation {
        axis: DVec3::Z,
        origin: DVec3::X,
        angular_velocity: 1.0,
        from: 0.0,
        until: FOREVER,
    };
    let travel = Component::Translation {
        velocity: DVec3::Y * 2.0,
        from: 0.0,
        until: FOREVER,
    };
    let motion = Motion::new(vec![spin.clone(), travel.clone()]).unwrap();
    // The axis of the spin travels, and nothing else moves it.
    let axis = motion.pose(3.0).to_global(DVec3::X);
    assert!((axis - DVec3::new(1.0, 6.0, 0.0)).length() < 1e-14);
    assert!((motion.velocity(3.0).at(axis) - DVec3::Y * 2.0).length() < 1e-14);
    // In the other order the wall travels first and then circles the fixed axis.
    let motion = Motion::new(vec![travel, spin]).unwrap();
    let rotation = DQuat::from_rotation_z(PI);
    let expected = DVec3::X + rotation * (DVec3::Y * 2.0 * PI);
    assert!((motion.pose(PI).to_global(DVec3::X) - expected).length() < 1e-14);
}

#[test]
fn speed_bounds_are_sharp_for_single_motions() {
    let drum = one(Component::Rotation {
        axis: DVec3::Y,
        origin: DVec3::new(0.5, 0.0, 0.5),
        angular_velocity: -3.0,
        from: 0.0,
        until: FOREVER,
    });
    // A ball about a point 0.3 from the axis, of radius 0.1: 0.4 m * 3 rad/s.
    let speed = drum.max_speed(DVec3::new(0.5, 7.0, 0.2), 0.1, 10.0);
    assert!((speed - 1.2).abs() < 1e-15);
    let shaker = one(Component::Oscillation {
        amplitude: DVec3::new(0.03, 0.04, 0.0),
        frequency: 10.0,
        phase: 0.3,
        from: 1.0,
        until: FOREVER,
    });
    assert!((shaker.max_speed(DVec3::ZERO, 1.0, 2.0) - 0.05 * TAU * 10.0).abs() < 1e-14);
    assert_eq!(shaker.max_speed(DVec3::ZERO, 1.0, 0.5), 0.0);
}

/// A point on the axis of a turn that an earlier motion carries away from it is swung round.
#[test]
fn speed_bounds_count_the_arm_that_earlier_motions_give() {
    let turn = Component::Rotation {
        axis: DVec3::Z,
        origin: DVec3::ZERO,
        angular_velocity: 3.0,
        from: 0.0,
        until: FOREVER,
    };
    let fastest = |first: Component| {
        let motion = Motion::new(vec![first, turn.clone()]).unwrap();
        let speed = |time| {
            motion
                .velocity(time)
                .at(motion.pose(time).to_global(DVec3::ZERO))
        };
        let fastest = (0..1000)
            .map(|i| speed(f64::from(i) * 0.1).length())
            .fold(0.0, f64::max);
        (fastest, motion.max_speed(DVec3::ZERO, 0.0, 100.0))
    };
    // At its far end, -(1 + sin(phase)) amplitude, the slow oscillation stands still.
    let (amplitude, frequency, phase) = (0.5, 0.01, 0.5_f64);
    let (found, bound) = fastest(Component::Oscillation {
        amplitude: DVec3::X * amplitude,
        frequency,
        phase,
        from: 0.0,
        until: FOREVER,
    });
    let arm = amplitude * (1.0 + phase.sin());
    assert!((bound - (TAU * frequency * amplitude + 3.0 * arm)).abs() < 1e-14);
    assert!(found <= bound && found > 3.0 * arm * 0.999);
    // The table turns about the point itself, and shifts it by 2 in 100 s.
    let text = "t,x,y,z,angle_x,angle_y,angle_z\n0,0,0,0,0,0,0\n100,2,0,0,0,0,1\n";
    let (found, bound) = fastest(Component::Table {
        table: table(text),
        origin: DVec3::ZERO,
    });
    assert!((bound - (2.0 / 100.0 + 3.0 * 2.0)).abs() < 1e-14);
    assert!(found <= bound && found > 3.0 * 2.0 * 0.99);
}

#[test]
fn what_never_moves_is_static() {
    assert!(Motion::default().is_static());
    let still = |component| one(component).is_static();
    let (from, until) = (0.0, FOREVER);
    assert!(still(Component::Translation {
        velocity: DVec3::ZERO,
        from,
        until
    }));
    assert!(still(Component::Translation {
        velocity: DVec3::X,
        from: 1.0,
        until: 1.0
    }));
    assert!(still(Component::Table {
        table: table("t,x,y,z\n0,0,0,0\n"),
        origin: DVec3::X
    }));
    assert!(!still(Component::Table {
        table: table("t,x,y,z\n0,0,1,0\n"),
        origin: DVec3::X
    }));
}

#[test]
fn bad_motions_are_refused() {
    let error = |component| Motion::new(vec![component]).expect_err("must be refused");
    let (from, until) = (0.0, FOREVER);
    let velocity = DVec3::X;
    assert!(matches!(
        error(Component::Translation {
            velocity,
            from: 1.0,
            until: 0.5
        }),
        WallError::NotIncreasing { key: "until", .. }
    ));
    assert!(matches!(
        error(Component::Translation {
            velocity,
            from: 0.0,
            until: f64::NAN
        }),
        WallError::NotIncreasing { .. }
    ));
    assert!(matches!(
        error(Component::Translation {
            velocity,
            from: f64::NEG_INFINITY,
            until
        }),
        WallError::NotFinite { key: "from", .. }
    ));
    assert!(matches!(
        error(Component::Translation {
            velocity: DVec3::NAN,
            from,
            until
        }),
        WallError::NotFinite {
            key: "velocity",
            ..
        }
    ));
    let rotation = |axis, angular_velocity| Component::Rotation {
        axis,
        origin: DVec3::ZERO,
        angular_velocity,
        from,
        until,
    };
    assert!(matches!(
        error(rotation(DVec3::ZERO, 1.0)),
        WallError::NoDirection { .. }
    ));
    assert!(matches!(
        error(rotation(DVec3::X, f64::NAN)),
        WallError::NotFinite { .. }
    ));
    let oscillation = Component::Oscillation {
        amplitude: DVec3::X,
        frequency: -1.0,
        phase: 0.0,
        from,
        until,
    };
    assert!(matches!(
        error(oscillation),
        WallError::Negative {
            key: "frequency",
            ..
        }
    ));
}

/// A wall is there from the step at `from` on, and at `until` no more, whatever round-off the times have.
#[test]
fn a_wall_is_there_from_its_first_step_to_the_one_before_its_last() {
    let dt = 1e-4;
    let plane = Plane::new(DVec3::ZERO, DVec3::Z).unwrap();
    let wall = Wall {
        name: "gate".to_owned(),
        material: crate::state::MaterialIndex::new(0),
        shape: Shape::Plane(plane),
        motion: Motion::default(),
        from: 0.3,
        until: 0.7,
        reference: DVec3::ZERO,
    };
    for step in 0..=10_000u32 {
        let there = (3000..7000).contains(&step);
        for time in [f64::from(step) * dt, f64::from(step) / 10_000.0] {
            assert_eq!(wall.is_present(time, dt), there, "step {step}");
        }
    }
}

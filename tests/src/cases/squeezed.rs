//! T15: rolling and torsion of a sphere squeezed between two fixed ones.

use std::f64::consts::PI;

use glam::{DVec3, dvec3};
use mercury_engine::contact::rolling::FrictionSpring;
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, Linear, Luding, PairLaw, SpringRotation,
};
use mercury_engine::forces::Partner;

use super::Case;
use super::Tolerance::Digit;
use crate::closed_forms::linear_from_contact_time;
use crate::scenes::{observed_step, plan, row, sphere, start};

/// A sphere of 1 kg between two fixed ones, turning at 1 rad/s about `axis`. Returns the normal force (N) of one contact and the
/// couple (N m) that brakes it there, after the steps from 0, dt, 0.02 s and 0.04 s.
fn squeezed(axis: DVec3) -> (f64, [f64; 4]) {
    let (stiffness, dissipation) = linear_from_contact_time(0.02, 0.7, 0.5);
    let spring = FrictionSpring {
        stiffness: Some(0.4 * stiffness),
        dissipation: 0.4 * dissipation,
        friction: 0.1,
        static_friction: 0.1,
    };
    let law = PairLaw {
        normal: AnyNormal::Linear(Linear::new(stiffness, dissipation)),
        tangential: AnyTangential::None,
        rolling: AnyRolling::Luding(Luding {
            rolling: spring,
            torsion: spring,
            lever: 2.0,
            rotation: SpringRotation::Project,
        }),
        adhesion: AnyAdhesion::None,
    };
    let mut plan = plan(4e-4, 6.0 / PI, law);
    plan.startup_increment = true;
    let spheres = [-0.995, 0.0, 0.995].map(|x| {
        let fixed = x != 0.0;
        let spin = if fixed { DVec3::ZERO } else { axis };
        let mut ball = sphere(dvec3(x, 0.0, 0.0), 0.5, DVec3::ZERO, spin);
        ball.fixed = fixed;
        ball
    });
    let mut engine = start(plan.with_particles(spheres.into()));
    let (mut normal_force, mut couples) = (0.0, [0.0; 4]);
    for step in 0..=100u64 {
        observed_step(&mut engine);
        let (left, middle) = (row(&engine, 0) as u32, row(&engine, 1) as u32);
        for record in engine.observation().records {
            let Partner::Particle { row: partner, .. } = record.partner else {
                continue;
            };
            if (record.row, partner) != (left, middle) && (record.row, partner) != (middle, left) {
                continue;
            }
            normal_force = record.force.dot(record.normal);
            if let Some(k) = [0, 1, 50, 100].iter().position(|&k| k == step) {
                let on_left = if record.row == left {
                    record.couple
                } else {
                    -record.couple
                };
                couples[k] = on_left.dot(axis);
            }
        }
    }
    (normal_force, couples)
}

/// Rows of T15 on a sphere between two.
pub(super) fn cases() -> Vec<Case> {
    const SOURCE: &str =
        "data shipped with MercuryDPM (RollingFrictionSelfTest, TorsionFrictionSelfTest)";
    let mut cases = Vec::new();
    for (axis, name) in [
        (DVec3::Z, "rolling about z"),
        (DVec3::Y, "rolling about y"),
        (DVec3::X, "torsion"),
    ] {
        cases.push(Case::new(
            format!("T15 engine: squeezed sphere, {name}, normal force (N)"),
            62.480134,
            Digit(1e-6),
            SOURCE,
            move || squeezed(axis).0,
        ));
        for (index, (time, couple)) in [
            ("0", 2.7622046),
            ("dt", 3.1240067),
            ("0.02 s", 1.99994383),
            ("0.04 s", -1.3798539),
        ]
        .into_iter()
        .enumerate()
        {
            cases.push(Case::new(
                format!(
                    "T15 engine: squeezed sphere, {name}, couple after the step from {time} (N m)"
                ),
                couple,
                Digit(1e-7),
                SOURCE,
                move || squeezed(axis).1[index],
            ));
        }
    }
    cases
}

//! Servos that drive a plane away from the particles.

use glam::DVec3;

use super::Finding;
use crate::plan::Plan;
use crate::plan::motions::vector;
use mercury_engine::contact::AnyAdhesion;
use mercury_engine::contact::parameter::Value;
use mercury_engine::walls::{Component, Shape, Wall};

/// A warning for each such wall.
pub(super) fn servos_that_lift_off(plan: &Plan) -> Vec<Finding> {
    let walls = plan.physics().walls.iter();
    let found = walls.filter_map(|wall| is_driven_away(plan, wall));
    found.map(Finding::Warning).collect()
}

/// Largest difference between a servo's axis and the opposite of a wall's normal: less than friction could make up for.
const OPPOSITE: f64 = 1e-6;

/// A plane pushes along its normal only. A servo with a load in the opposite direction, at all times, drives it away from the
/// particles.
fn is_driven_away(plan: &Plan, wall: &Wall) -> Option<String> {
    let Shape::Plane(plane) = &wall.shape else {
        // On which side of the others the particles are is not known.
        return None;
    };
    let turns = |component: &Component| {
        matches!(
            component,
            Component::Rotation { .. } | Component::Table { .. }
        )
    };
    // Grains that stick to a wall are pulled by it.
    let sticks = plan.notes().pairs().iter().any(|pair| {
        let mut parameters = pair.parameters.iter();
        let has_cohesion = parameters.any(|parameter| {
            parameter.name.contains("cohesion") && parameter.value != Value::Number(0.0)
        });
        pair.at_walls && (has_cohesion || pair.law.adhesion != AnyAdhesion::None)
    });
    if sticks || wall.motion.components().iter().any(turns) {
        return None;
    }
    // Along the normal; 0 is no load, and a wall that is pressed first and then lifted is intended.
    let mut servos = wall.motion.all_servos().peekable();
    servos.peek()?;
    let mut pulls = false;
    for servo in servos {
        let along = servo.axis.normalize_or_zero().dot(plane.normal());
        for (_, load) in servo.target.curve().rows() {
            if *load != 0.0 && along * load.signum() > OPPOSITE - 1.0 {
                return None;
            }
            pulls |= *load != 0.0;
        }
    }
    pulls.then(|| {
        format!(
            "walls.{}: its servo has to push along {}, but it can only push along its normal {}: it will be driven away from \
            the particles at its max_speed; turn the sign of the load, or the axis",
            wall.name,
            vector(DVec3::ZERO - plane.normal()),
            vector(plane.normal()),
        )
    })
}

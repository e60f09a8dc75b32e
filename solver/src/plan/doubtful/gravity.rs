//! Particles that nothing holds, and particles that nothing moves.

use glam::DVec3;
use mercury_common::surfaces::FACES;

use super::Finding;
use crate::plan::Plan;
use mercury_engine::boundaries::InsertionPlan;
use mercury_engine::membrane::MembranePlan;

/// A warning if all particles fall out of the domain.
pub(super) fn particles_that_fall_out(plan: &Plan) -> Vec<Finding> {
    nothing_holds(plan)
        .into_iter()
        .map(Finding::Warning)
        .collect()
}

/// A warning for each insertion whose particles stay where they are placed.
pub(super) fn insertions_at_rest(plan: &Plan) -> Vec<Finding> {
    let insertions = plan.physics().insertions.iter();
    let found = insertions.filter_map(|insertion| stays_in_the_air(plan, insertion));
    found.map(Finding::Warning).collect()
}

/// There is gravity without an obstacle, and the run is long enough for all particles to fall out of the domain.
fn nothing_holds(plan: &Plan) -> Option<String> {
    let physics = plan.physics();
    let gravity = physics.gravity;
    let axis = gravity.abs().max_position();
    let is_fixed = physics.particles.iter().any(|particle| particle.fixed)
        || physics.bodies.iter().any(|body| body.fixed);
    let is_open = !physics.cell.is_periodic(axis) && (axis < 2 || physics.dimensions == 3);
    if gravity == DVec3::ZERO
        || !is_open
        || is_fixed
        || !physics.walls.is_empty()
        || physics.plans.get::<MembranePlan>().is_some()
    {
        return None;
    }
    let is_down = gravity[axis] < 0.0;
    let (low, high) = (physics.cell.low()[axis], physics.cell.high()[axis]);
    let height = |x: f64| if is_down { x - low } else { high - x };
    let down = |v: DVec3| if is_down { -v[axis] } else { v[axis] };
    let starting = (physics
        .particles
        .iter()
        .map(|new| (new.position, new.velocity)))
    .chain(
        physics
            .bodies
            .iter()
            .map(|new| (new.position, new.velocity)),
    );
    let inserted = physics.insertions.iter().map(|insertion| {
        let slowest = insertion.velocity_mean - insertion.velocity_spread.abs();
        (high - low, down(slowest))
    });
    let end = physics.steps as f64 * physics.time_step;
    let mut all = starting
        .map(|(x, v)| (height(x[axis]), down(v)))
        .chain(inserted)
        .peekable();
    all.peek()?;
    // h = v t + g t^2 / 2.
    let is_gone =
        |(height, speed): (f64, f64)| height < speed * end + 0.5 * gravity[axis].abs() * end * end;
    all.all(is_gone).then(|| {
        format!(
            "gravity: nothing holds the particles, all of which fall out of the domain through its face {}: add walls (shape = \"box\" closes the domain), or make the axis periodic",
            FACES[2 * axis + usize::from(!is_down)]
        )
    })
}

/// Without gravity, and with nothing that moves, what is inserted at rest stays where it is put.
fn stays_in_the_air(plan: &Plan, insertion: &InsertionPlan) -> Option<String> {
    let physics = plan.physics();
    let is_moving = physics.walls.iter().any(|wall| !wall.motion.is_static())
        || physics
            .particles
            .iter()
            .any(|new| new.velocity != DVec3::ZERO)
        || physics.bodies.iter().any(|new| new.velocity != DVec3::ZERO)
        || (physics.insertions.iter()).any(|other| {
            other.velocity_mean != DVec3::ZERO || other.velocity_spread != DVec3::ZERO
        });
    (physics.gravity == DVec3::ZERO && !is_moving).then(|| {
        format!(
            "insertions.{}: without gravity, velocity and moving walls what it places stays where it is put: is `gravity` missing?",
            insertion.name
        )
    })
}

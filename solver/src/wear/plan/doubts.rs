//! Walls that nothing can wear, and walls that are worn faster than their surface can follow.

use glam::DVec3;

use crate::plan::Plan;
use crate::plan::doubtful::Finding;
use mercury_engine::contact::parameter::short;
use mercury_engine::forces::{Impact, Rub};
use mercury_engine::state::volume;
use mercury_engine::walls::{Scratch, Shape, Wall};
use mercury_engine::wear::{WearPlan, Worn};

/// Warnings for each wall that wears.
pub(crate) fn wear_without_effect_or_too_fast(plan: &Plan) -> Vec<Finding> {
    let walls = plan.physics().plans.all().iter();
    let found = walls.flat_map(|wear| of_wear(plan, wear));
    found.map(Finding::Warning).collect()
}

/// A wall that nothing can wear, or that is worn faster than its surface can follow.
fn of_wear(plan: &Plan, wear: &WearPlan) -> Vec<String> {
    let physics = plan.physics();
    let wall = &physics.walls[wear.wall];
    let name = &wall.name;
    let end = physics.steps as f64 * physics.time_step;
    let is_empty =
        physics.particles.is_empty() && physics.bodies.is_empty() && physics.insertions.is_empty();
    let reason = if is_empty {
        Some("the scene has no particles")
    } else if wall.from >= end || wall.until <= 0.0 {
        Some("it is not there while the run lasts")
    } else if !can_reach(plan, wall) {
        Some("nothing moves, neither particles nor walls")
    } else {
        None
    };
    let reason = reason.map_or_else(
        || out_of_reach(plan, wall),
        |reason| Some(reason.to_owned()),
    );
    if let Some(reason) = reason {
        return vec![format!(
            "walls.{name}.wear: no particle can wear the wall, as {reason}; leave `wear` out"
        )];
    }
    let mut warnings = Vec::new();
    if !wear.moves && wear.until_depth.is_infinite() && plan.outputs().files().interval > end {
        warnings.push(format!(
            "walls.{name}.wear: the wear map is written at the start and at the end alone; shorten output.interval"
        ));
    }
    if let (true, Some(mesh)) = (wear.moves, wall.shape.mesh()) {
        let part = Worn::new(*wear, mesh).part_of_step(largest_volume(plan, wear));
        if part > 1.0 {
            warnings.push(format!(
                "walls.{name}.wear: one contact in one step can move a vertex by {} times what `step` allows; lower the acceleration, or refine less",
                short(part)
            ));
        }
    }
    warnings
}

/// Why the whole wall is beyond what particles reach, if it is: they stay in the domain, and before walls that act on one side.
fn out_of_reach(plan: &Plan, wall: &Wall) -> Option<String> {
    let physics = plan.physics();
    let mesh = wall.shape.mesh().filter(|_| wall.motion.is_static())?;
    // Contact forces move a centre a little beyond a plane; deeper than its radius it is through.
    let reach = physics.largest_radius();
    let (low, high) = mesh.bounds();
    for axis in 0..3 {
        let (min, max) = (physics.cell.low()[axis], physics.cell.high()[axis]);
        let is_outside = low[axis] > max + reach || high[axis] < min - reach;
        if is_outside && !physics.cell.is_periodic(axis) {
            return Some("it lies outside of the domain".to_owned());
        }
    }
    let lasts = |other: &&Wall| other.from <= 0.0 && other.until.is_infinite();
    let mut others = physics.walls.iter().filter(lasts);
    let mut scratch = Scratch::default();
    let shields = |other: &&Wall| {
        // Around other shapes there may be a way.
        let is_whole = matches!(other.shape, Shape::Plane(_) | Shape::Sphere(_));
        let mut is_behind = |corner: &DVec3| {
            let distance = other.shape.signed_distance(*corner, &mut scratch);
            distance < -2.0 * reach
        };
        is_whole
            && other.shape.is_one_sided()
            && other.motion.is_static()
            && mesh.corners().iter().all(&mut is_behind)
    };
    let before = others.find(shields)?;
    Some(format!("it lies wholly behind the wall `{}`", before.name))
}

/// Whether anything brings particles and the wall together.
fn can_reach(plan: &Plan, wall: &Wall) -> bool {
    let physics = plan.physics();
    let moves = |velocity: DVec3, spin: DVec3| velocity != DVec3::ZERO || spin != DVec3::ZERO;
    physics.gravity != DVec3::ZERO
        || !wall.motion.is_static()
        || physics.walls.iter().any(|other| !other.motion.is_static())
        || !physics.insertions.is_empty()
        || (physics.particles.iter()).any(|new| moves(new.velocity, new.angular_velocity))
        || (physics.bodies.iter()).any(|new| moves(new.velocity, new.angular_velocity))
}

/// The volume that one contact may wear in one step, m^3: the largest particle with its weight, at the reference speed of the time step.
fn largest_volume(plan: &Plan, wear: &WearPlan) -> f64 {
    let physics = plan.physics();
    let densities = physics.materials.iter().map(|material| material.density);
    let density = densities.fold(0.0, f64::max);
    let radius = physics.largest_radius();
    let mass = density * volume(radius, physics.dimensions);
    let speed = plan.notes().step().reference_speed;
    let load = mass * physics.gravity.length();
    let way = speed * physics.time_step;
    // At the angle at which Finnie's law wears most, 17 degrees.
    let impact = Impact {
        mass,
        diameter: 2.0 * radius,
        speed,
        approach: 0.3 * speed,
    };
    wear.acceleration
        * wear.law.volume(&Rub {
            wall: 0,
            feature: 0,
            foot: DVec3::ZERO,
            normal: DVec3::Z,
            load,
            way,
            slip: way,
            work: load * way,
            impact: Some(impact),
        })
}

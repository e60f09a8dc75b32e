//! Warnings about the fate of the particles, where it can be predicted before the run and is hardly intended.

use glam::DVec3;
use mercury_common::plausible;
use mercury_common::surfaces::FACES;

use super::motions::vector;
use super::{PairPlan, Plan};
use crate::boundaries::InsertionPlan;
use crate::contact::AnyRolling;
use crate::contact::adhesion::liquid::reduced_diameter;
use crate::contact::parameter::{Value, short};
use crate::contact::rolling::FrictionSpring;
use crate::forces::{Impact, Rub};
use crate::state::volume;
use crate::walls::{Component, Shape, Wall};
use crate::wear::{WearPlan, Worn};

/// The messages: each names the cause, and gives advice.
pub(super) fn warnings(plan: &Plan) -> Vec<String> {
    let falls = nothing_holds(plan);
    let floats = plan.physics().insertions().iter();
    let floats = floats.filter_map(|insertion| stays_in_the_air(plan, insertion));
    let flees = plan.physics().walls().iter();
    let flees = flees.filter_map(|wall| is_driven_away(plan, wall));
    let fits = plan.notes().pairs().iter();
    let fits = fits.filter_map(|pair| beyond_the_fit(plan, pair));
    let wears = plan.physics().wear().iter();
    let wears = wears.flat_map(|wear| of_wear(plan, wear));
    falls
        .into_iter()
        .chain(wears)
        .chain(floats)
        .chain(flees)
        .chain(fits)
        .collect()
}

/// A note on sizes, densities and a domain that look as if a unit was forgotten.
pub(super) fn forgotten_units(plan: &Plan) -> Option<String> {
    let physics = plan.physics();
    let [_, _, largest] = physics.radii();
    let size = physics.domain_max() - physics.domain_min();
    let densities = physics.materials().iter().map(|material| material.density);
    plausible::forgotten_units(Some(2.0 * largest), densities, Some(size.max_element()))
}

/// A note on each pair whose resistance to rolling or torsion is a spring without a dashpot: nothing ends the swing of its grains.
pub(super) fn turns_for_ever(plan: &Plan) -> Vec<String> {
    let pairs = plan.notes().pairs().iter();
    pairs
        .filter_map(|pair| {
            let AnyRolling::Luding(law) = &pair.law.rolling else {
                return None;
            };
            let springs = [("rolling", &law.rolling), ("torsion", &law.torsion)];
            let swings = |spring: &FrictionSpring| spring.friction > 0.0 && spring.dissipation == 0.0;
            let mut names = springs.iter().filter(|(_, spring)| swings(spring)).map(|(name, _)| *name);
            let name = names.next()?;
            Some(format!(
                "{}: {name} has no `dissipation`, so that rolling grains oscillate for ever; give {name} = {{ dissipation = ... }} in kg/s to bring them to rest",
                pair.names.each_ref().map(String::as_str).join(" and "),
            ))
        })
        .collect()
}

/// Largest volume over R_D^3, and largest contact angle (rad), of the solutions that the laws of liquid bridges were fitted to.
const FITTED: (f64, f64) = (0.1, 50.0 * std::f64::consts::PI / 180.0);

/// A liquid bridge may be larger than those that its law was fitted to, or meet its particles at a wider angle.
fn beyond_the_fit(plan: &Plan, pair: &PairPlan) -> Option<String> {
    let liquid = pair.law.adhesion.liquid()?;
    let diameter = reduced_diameter([plan.physics().smallest_radius(); 2]);
    let volume = liquid.max_volume / (diameter * diameter * diameter);
    let names = pair.names.each_ref().map(String::as_str).join(" and ");
    let law = liquid.fit.name();
    if volume > FITTED.0 {
        Some(format!(
            "{names}: a bridge of max_bridge_volume between the smallest particles has V/R_D^3 = {}; `{law}` was fitted up to {}, and its force is uncertain beyond; give a smaller max_bridge_volume",
            short(volume),
            FITTED.0
        ))
    } else if liquid.contact_angle > FITTED.1 {
        Some(format!(
            "{names}: a contact angle of {} degrees; `{law}` was fitted up to 50, and its force is uncertain beyond; is the angle right?",
            short(liquid.contact_angle.to_degrees())
        ))
    } else {
        None
    }
}

/// A wall that nothing can wear, or that is worn faster than its surface can follow.
fn of_wear(plan: &Plan, wear: &WearPlan) -> Vec<String> {
    let physics = plan.physics();
    let wall = &physics.walls()[wear.wall];
    let name = &wall.name;
    let end = physics.steps() as f64 * physics.time_step();
    let is_empty = physics.particles().is_empty()
        && physics.bodies().is_empty()
        && physics.insertions().is_empty();
    let reason = if is_empty {
        Some("the scene has no particles")
    } else if wall.from >= end || wall.until <= 0.0 {
        Some("it is not there while the run lasts")
    } else if !can_reach(plan, wall) {
        Some("nothing moves, neither particles nor walls")
    } else {
        None
    };
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

/// Whether anything brings particles and the wall together.
fn can_reach(plan: &Plan, wall: &Wall) -> bool {
    let physics = plan.physics();
    let moves = |velocity: DVec3, spin: DVec3| velocity != DVec3::ZERO || spin != DVec3::ZERO;
    physics.gravity() != DVec3::ZERO
        || !wall.motion.is_static()
        || physics
            .walls()
            .iter()
            .any(|other| !other.motion.is_static())
        || !physics.insertions().is_empty()
        || (physics.particles().iter()).any(|new| moves(new.velocity, new.angular_velocity))
        || (physics.bodies().iter()).any(|new| moves(new.velocity, new.angular_velocity))
}

/// The volume that one contact may wear in one step, m^3: the largest particle with its weight, at the reference speed of the time step.
fn largest_volume(plan: &Plan, wear: &WearPlan) -> f64 {
    let physics = plan.physics();
    let densities = physics.materials().iter().map(|material| material.density);
    let density = densities.fold(0.0, f64::max);
    let radius = physics.largest_radius();
    let mass = density * volume(radius, physics.dimensions());
    let speed = plan.notes().step().reference_speed;
    let load = mass * physics.gravity().length();
    let way = speed * physics.time_step();
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

/// What a servo's axis and a wall's normal may differ from being opposite: less than friction could make up for.
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
    // What sticks to a wall is pulled by it.
    let sticks = plan.notes().pairs().iter().any(|pair| {
        let mut parameters = pair.parameters.iter();
        let has_cohesion = parameters.any(|parameter| {
            parameter.name.contains("cohesion") && parameter.value != Value::Number(0.0)
        });
        pair.at_walls && (has_cohesion || pair.law.adhesion.liquid().is_some())
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
        for [_, load] in servo.target.course().rows() {
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

/// There is gravity without an obstacle, and the run is long enough for all particles to fall out of the domain.
fn nothing_holds(plan: &Plan) -> Option<String> {
    let physics = plan.physics();
    let gravity = physics.gravity();
    let axis = gravity.abs().max_position();
    let is_fixed = physics.particles().iter().any(|particle| particle.fixed)
        || physics.bodies().iter().any(|body| body.fixed);
    let is_open = !physics.periodic()[axis] && (axis < 2 || physics.dimensions() == 3);
    if gravity == DVec3::ZERO
        || !is_open
        || is_fixed
        || !physics.walls().is_empty()
        || !physics.membranes().is_empty()
    {
        return None;
    }
    let is_down = gravity[axis] < 0.0;
    let (low, high) = (physics.domain_min()[axis], physics.domain_max()[axis]);
    let height = |x: f64| if is_down { x - low } else { high - x };
    let down = |v: DVec3| if is_down { -v[axis] } else { v[axis] };
    let starting = (physics
        .particles()
        .iter()
        .map(|new| (new.position, new.velocity)))
    .chain(
        physics
            .bodies()
            .iter()
            .map(|new| (new.position, new.velocity)),
    );
    let inserted = physics.insertions().iter().map(|insertion| {
        let slowest = insertion.velocity_mean - insertion.velocity_spread.abs();
        (high - low, down(slowest))
    });
    let end = physics.steps() as f64 * physics.time_step();
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
    let is_moving = physics.walls().iter().any(|wall| !wall.motion.is_static())
        || physics
            .particles()
            .iter()
            .any(|new| new.velocity != DVec3::ZERO)
        || physics
            .bodies()
            .iter()
            .any(|new| new.velocity != DVec3::ZERO)
        || (physics.insertions().iter()).any(|other| {
            other.velocity_mean != DVec3::ZERO || other.velocity_spread != DVec3::ZERO
        });
    (physics.gravity() == DVec3::ZERO && !is_moving).then(|| {
        format!(
            "insertions.{}: without gravity, velocity and moving walls what it places stays where it is put: is `gravity` missing?",
            insertion.name
        )
    })
}

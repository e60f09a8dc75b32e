//! Walls that act on both sides and move through a region while particles are inserted into it: particles may be placed behind
//! them.

use glam::{DVec2, DVec3};

use crate::boundaries::plan::insertions::grains_per_unit;
use mercury_engine::boundaries::{
    InsertionPlan, Quantity, Total, expected_number, overlaps_wall, places, volume_within,
};
use mercury_engine::cell::Cell;
use mercury_engine::physics::Physics;
use mercury_engine::walls::{Component, ServoState, Wall, WallNow};

/// Places of the region that are compared with the wall at each time.
const PLACES: usize = 256;
/// Fewest and most times at which the wall is looked at.
const TIMES: [f64; 2] = [16.0, 1024.0];
/// The wall moves by this share of the region between two times, at its highest speed.
const PART: f64 = 0.125;
/// Solid fraction up to which all particles are placed in the first round: far below that of saturation, 0.38 for equal spheres and 0.55 for discs.
const AT_ONCE: f64 = 0.2;
/// Halvings of the time by which the insertion is complete: to a part in 10^12.
const HALVINGS: u32 = 40;

/// The closing walls of each insertion.
pub(super) fn closing_walls(physics: &Physics) -> Vec<Vec<usize>> {
    let walls = || {
        let walls = physics.walls.iter().enumerate();
        walls.filter(|(_, wall)| !wall.shape.is_one_sided() && closes(wall, end_of(physics)))
    };
    let insertions = physics.insertions.iter();
    insertions
        .map(|insertion| {
            let crossing = walls().filter(|(_, wall)| crosses(physics, insertion, wall));
            crossing.map(|(index, _)| index).collect()
        })
        .collect()
}

fn end_of(physics: &Physics) -> f64 {
    physics.steps as f64 * physics.time_step
}

/// Whether the motion takes the wall somewhere for good. A wall that oscillates or goes on turning, as a paddle does, has no side
/// behind it.
fn closes(wall: &Wall, end: f64) -> bool {
    let mut components = wall.motion.components().iter();
    components.any(|component| match component {
        Component::Translation { .. } => true,
        Component::Rotation {
            angular_velocity,
            from,
            until,
            ..
        } => {
            let angle = angular_velocity.abs() * (until.min(end) - from).max(0.0);
            angle > 0.0 && angle < std::f64::consts::TAU
        }
        // Where another program drives it is not known.
        Component::Oscillation { .. } | Component::External => false,
        Component::Table { .. } | Component::Servo(_) => true,
    })
}

/// The time at which the insertion is complete, s; its end, or that of the run, if that is not known.
fn done_at(physics: &Physics, insertion: &InsertionPlan) -> f64 {
    let end = insertion.until.min(end_of(physics));
    let densities: Vec<f64> = physics.materials.iter().map(|m| m.density).collect();
    let Some(number) = expected_number(insertion, &densities, physics.dimensions) else {
        return match insertion.total {
            Some(Total::Full) => insertion.from,
            _ => end,
        };
    };
    let Some(rate) = &insertion.rate else {
        let volume = number / grains_per_unit(insertion, Quantity::Volume, physics);
        let (low, high) = physics.cell.corners();
        let space = if physics.dimensions == 2 {
            let (from, to) = insertion.region.bounds();
            let size = (to.min(high) - from.max(low)).truncate();
            size.max(DVec2::ZERO).element_product()
        } else {
            volume_within(&insertion.region, low, high)
        };
        let is_at_once = volume <= AT_ONCE * space;
        return if is_at_once { insertion.from } else { end };
    };
    let per_unit = grains_per_unit(insertion, rate.quantity(), physics);
    let is_done = |time: f64| per_unit * rate.allowed(insertion.from, time).1 >= number;
    if !is_done(end) {
        return end;
    }
    // The allowed amount never decreases.
    let (mut before, mut after) = (insertion.from, end);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (before + after);
        if is_done(middle) {
            after = middle;
        } else {
            before = middle;
        }
    }
    after
}

/// Whether a motion has taken the wall into the region before the insertion is done.
fn crosses(physics: &Physics, insertion: &InsertionPlan, wall: &Wall) -> bool {
    let (dt, cell) = (physics.time_step, physics.cell);
    let done = done_at(physics, insertion);
    let sizes = insertion.mixture.iter().filter(|part| part.share > 0.0);
    let diameter = sizes
        .map(|part| part.sizes.smallest())
        .fold(f64::INFINITY, f64::min);
    if !diameter.is_finite() {
        return false;
    }
    let radius = 0.5 * diameter;
    let places = places(
        &insertion.region,
        radius,
        physics.setting(&cell).space(),
        PLACES,
    );
    let (low, high) = places.iter().fold(
        (DVec3::INFINITY, DVec3::NEG_INFINITY),
        |(low, high), place| (low.min(*place), high.max(*place)),
    );
    let size = (high - low).max_element().max(diameter);
    // A sphere about all places: a wall that does not reach it reaches none of them.
    let about = (0.5 * (low + high), 0.5 * low.distance(high) + radius);
    let middle = 0.5 * (physics.cell.low() + physics.cell.high());
    let reach = 0.5 * physics.cell.diagonal();
    let mut now = WallNow::new(wall, dt, &cell);
    wall.motion.windows().any(|[from, until]| {
        // Behind its end the wall stays where it is.
        let (begin, end) = (from.max(0.0), until.min(done));
        if done <= begin || end <= begin {
            return false;
        }
        let way = wall.motion.max_speed(middle, reach, end) * (end - begin);
        let times = (way / (PART * size)).clamp(TIMES[0], TIMES[1]).ceil();
        (1..=times as u32).any(|k| {
            let time = begin + (end - begin) * f64::from(k) / times;
            // The wall at the start of the insertion; then from time to time.
            put(&mut now, wall, time.max(insertion.from), dt, &cell);
            let wall = std::slice::from_ref(&now);
            let overlaps = |place, radius| overlaps_wall(wall, &cell, place, radius);
            overlaps(about.0, about.1) && places.iter().any(|&place| overlaps(place, radius))
        })
    })
}

/// Puts a wall where it is at a time (s); walls with servos where they would be without an obstacle.
fn put(now: &mut WallNow, wall: &Wall, time: f64, dt: f64, cell: &Cell) {
    for (servo, state) in wall.motion.all_servos().zip(&mut now.servos) {
        let loads = servo.target.curve().rows().iter();
        let load: f64 = loads.map(|(_, load)| *load).sum();
        let seconds = (time.min(servo.until) - servo.from).max(0.0);
        let speed = if load == 0.0 {
            0.0
        } else {
            servo.max_speed.copysign(load)
        };
        *state = ServoState {
            displacement: speed * seconds,
            ..ServoState::default()
        };
    }
    now.advance(wall, time, dt, cell);
    now.note_images(cell);
}

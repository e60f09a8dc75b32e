//! A body with one stable pose, of 182 pebbles.
//!
//! Its surface (after Ferellec & McDowell's generator from a Gömböc) has one basin, at +z of its frame; but pebbles are bumps, and where
//! one touches another there is a small pit, on a soft table too. A body that is dropped and left alone may come to rest in one: one
//! or two of eight do. Such a one is thrown again.

use std::sync::OnceLock;

use glam::{DQuat, DVec3};
use mclump::clump::{Input, Options, build};
use mercury_common::formats::clump::ClumpFile;
use mercury_common::formats::pebble_list::read_pebble_list;
use mercury_common::random::Stream;
use mercury_solver::plan::NewBody;

use super::{Shapes, Table, contact_direction, solver_clump};
use crate::cases::Case;
use crate::cases::Tolerance::Absolute;
use crate::scenes::RECORDS;

/// Lengths are those of the file (the body is 1 high and wide), the density is 1. The weight of 7 sinks 2e-3 into the table.
const TABLE: Table = Table {
    stiffness: 3e3,
    restitution: 0.3,
    friction: 0.6,
    gravity: 10.0,
    step: 3e-4,
};
/// Time for which a throw is watched, s.
const WATCHED: f64 = 50.0;
/// Number of throws at most.
const THROWS: u32 = 4;
/// Depth of the basin's bottom below the centre of mass, found by looking into 60,000 directions.
const LOWEST: f64 = 0.48316;

/// How a throw ended.
#[derive(Debug, Clone, Copy)]
struct Rest {
    orientation: DQuat,
    /// z of the contact direction in the frame of the file.
    upright: f64,
    /// Height of the centre of mass.
    height: f64,
    /// Kinetic energy over the weight, as a height.
    motion: f64,
    /// Largest rise of the total energy between two looks, over that at the start.
    rise: f64,
}

fn clump_file(shapes: &Shapes) -> ClumpFile {
    let list = shapes.file("pebbles/clump03_shipped.csv");
    let input = Input {
        name: "goemboec".to_owned(),
        surface: None,
        pebbles: read_pebble_list(list).expect("the reference list is right"),
    };
    let built = build(&input, &Options::default());
    built.expect("the reference list is a body").file
}

/// A pose (Shoemake 1992: uniform over all orientations).
fn pose(index: u64) -> DQuat {
    let mut random = Stream::new(index, "goemboec", 0);
    let [share, a, b] = [(); 3].map(|()| random.uniform());
    let turn = std::f64::consts::TAU;
    let (low, high) = (f64::sqrt(1.0 - share), share.sqrt());
    DQuat::from_xyzw(
        low * (turn * a).sin(),
        low * (turn * a).cos(),
        high * (turn * b).sin(),
        high * (turn * b).cos(),
    )
}

/// Lets the body go from 0.1 above the table with a spin (rad/s).
fn throw(file: &ClumpFile, orientation: DQuat, spin: DVec3) -> Rest {
    let down = orientation.inverse() * -DVec3::Z;
    let reach = file
        .pebbles
        .iter()
        .map(|pebble| down.dot(pebble.position) + pebble.radius);
    let height = reach.fold(0.0, f64::max) + 0.1;
    let body = NewBody {
        orientation,
        angular_velocity: spin,
        ..NewBody::at(height * DVec3::Z, 0)
    };
    let mut engine = TABLE.with(&solver_clump(file), body);
    let weight = file.mass * TABLE.gravity;
    let mut first = f64::NAN;
    let mut energy = f64::INFINITY;
    let mut rest = Rest {
        orientation,
        upright: f64::NAN,
        height: f64::NAN,
        motion: f64::NAN,
        rise: 0.0,
    };
    let looks = 500;
    for _ in 0..looks {
        let steps = (WATCHED / TABLE.step) as u64 / looks;
        engine
            .steps_at_once(steps, RECORDS)
            .expect("the motion stays finite");
        engine.complete_step().expect("the motion stays finite");
        let body = engine.particles.bodies()[0];
        let kinetic = body.rotational_energy() + 0.5 * body.mass * body.velocity.length_squared();
        let now = kinetic + weight * body.position.z + engine.observation().elastic_energy;
        if first.is_nan() {
            first = now;
        }
        rest = Rest {
            orientation: body.orientation,
            upright: contact_direction(file, body.orientation).z,
            height: body.position.z,
            motion: kinetic / weight,
            rise: rest.rise.max((now - energy) / first),
        };
        energy = now;
    }
    rest
}

/// Throws the body until it rests in the basin, at most [`THROWS`] times; all ends, one after another.
fn throws(file: &ClumpFile, index: u64) -> Vec<Rest> {
    let mut ends = vec![throw(file, pose(index), DVec3::ZERO)];
    while ends.len() < THROWS as usize && ends[ends.len() - 1].upright < 0.9 {
        let last = ends[ends.len() - 1];
        ends.push(throw(file, last.orientation, DVec3::new(3.0, 2.0, 1.0)));
    }
    ends
}

const STABLE: &str =
    "height over the table in 60,000 directions: one basin, at +z of the file's frame";

fn upright(name: String, measured: impl Fn() -> f64 + Send + Sync + 'static) -> Case {
    // The basin's floor: within 0.002 in height, n.z is above 0.9; every other pit but the tiny ones lies below 0.7.
    Case::new(name, 1.0, Absolute(0.1), STABLE, measured)
}

pub(super) fn quick(shapes: &Shapes) -> Vec<Case> {
    let shapes = shapes.clone();
    vec![upright(
        "goemboec thrown in one pose: z of the direction that it rests on".to_owned(),
        move || throw(&clump_file(&shapes), pose(0), DVec3::ZERO).upright,
    )]
}

pub(super) fn slow(shapes: &Shapes) -> Vec<Case> {
    static ENDS: OnceLock<Vec<Vec<Rest>>> = OnceLock::new();
    let ask = |of: fn(&[Vec<Rest>]) -> f64| {
        let shapes = shapes.clone();
        move || {
            of(ENDS.get_or_init(|| {
                let file = clump_file(&shapes);
                (0..8).map(|pose| throws(&file, pose)).collect()
            }))
        }
    };
    /// The last throws.
    fn last(ends: &[Vec<Rest>]) -> impl Iterator<Item = &Rest> {
        ends.iter().filter_map(|throws| throws.last())
    }
    vec![
        upright(
            "goemboec from eight random poses, thrown again from pits: least z of the direction that it rests on".to_owned(),
            ask(|ends| last(ends).map(|rest| rest.upright).fold(1.0, f64::min)),
        ),
        Case::new(
            "goemboec: throws that ended in a pit, of those from eight random poses",
            0.0,
            Absolute(2.0),
            "pits are few: a quarter of the throws at most",
            ask(|ends| ends.iter().filter(|throws| throws[0].upright < 0.9).count() as f64),
        ),
        Case::new(
            "goemboec: largest height of the centre of mass at the end",
            // It sinks in by at most its weight over one spring; several pebbles share it.
            LOWEST - 0.5 * 7.073 / TABLE.stiffness,
            Absolute(0.5 * 7.073 / TABLE.stiffness + 0.002),
            "the bottom of the basin less the overlap, and 0.002 for pits near it",
            ask(|ends| last(ends).map(|rest| rest.height).fold(0.0, f64::max)),
        ),
        Case::new(
            "goemboec: largest kinetic energy at the end over the weight, a height",
            0.0,
            // The barriers between pits.
            Absolute(0.0052),
            "no more than the barrier of the deepest pit: it rolls out of the basin no more",
            ask(|ends| last(ends).map(|rest| rest.motion).fold(0.0, f64::max)),
        ),
        Case::new(
            "goemboec: largest rise of the energy in a tenth of a second, over the start",
            0.0,
            // Second order in the step, contacts of some 70 steps.
            Absolute(1e-3),
            "contacts only take energy away",
            ask(|ends| {
                let all = ends.iter().flatten();
                all.map(|rest| rest.rise).fold(0.0, f64::max)
            }),
        ),
    ]
}

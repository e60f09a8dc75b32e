//! A part of the step that lives outside of the engine. It uses public items alone: a column of particles, the candidate list, the
//! walls and the periodic box as they are now, a section of the checkpoint.

use std::sync::Arc;

use glam::DVec3;
use mercury_engine::contact::{AnyNormal, Linear};
use mercury_engine::forces::{NearWall, NewList, Observation};
use mercury_engine::state::{Pieces, Plain, WallIndex};
use mercury_engine::step::{Core, Engine, Part, RunError, StartOptions};
use mercury_engine::walls::Touches;
use mercury_solver::plan::Plan;
use mercury_tests::scenes::{frictionless, plan, plane, sphere};

/// Time for which a particle touched walls, s.
const TOUCHED: &str = "touched_walls";

/// Sums up for how long each particle touches a wall.
#[derive(Default)]
struct WallClock {
    /// Particles near walls by the present candidate list.
    near: Vec<NearWall>,
    /// Steps in which some particle touched a wall.
    busy: u64,
}

impl Part for WallClock {
    fn name(&self) -> &str {
        "wall clock"
    }

    fn columns(&self) -> Vec<(&'static str, f64)> {
        vec![(TOUCHED, 0.0)]
    }

    fn new_list(&mut self, list: &NewList<'_>) {
        self.near = list.near_walls.to_vec();
    }

    fn after_forces(&mut self, core: &mut Core, _: Option<&Observation>) {
        let (since, cell) = (core.since_last(), *core.cell());
        let mut touches = Touches::default();
        let mut touching = Vec::new();
        for near in &self.near {
            let (row, wall) = (near.row as usize, &core.walls()[near.wall.index()]);
            let record = &core.particles.records[row];
            let image = wall.image_of(record.position, near.image);
            let centre = record.position + cell.any_shift(image);
            let place = wall.state.pose.to_initial(centre);
            (wall.shape()).touches(place, record.radius, &mut touches);
            if !touches.as_slice().is_empty() {
                touching.push(row);
            }
        }
        self.busy += u64::from(!touching.is_empty());
        if let Some(times) = core.particles.columns.get_mut(TOUCHED) {
            touching.iter().for_each(|&row| times[row] += since);
        }
    }

    fn put(&self, _: &Core, pieces: &mut Pieces) {
        self.busy.put(pieces.end());
        let near = self.near.iter().map(|near| (near.row, near.wall.number()));
        let images = self.near.iter().map(|near| near.image);
        near.zip(images).collect::<Vec<_>>().put(pieces.end());
    }

    fn take(&mut self, core: &mut Core, bytes: &mut &[u8]) -> Result<(), String> {
        self.busy = u64::take(bytes)?;
        let near: Vec<((u32, u16), u32)> = Plain::take(bytes)?;
        let (rows, walls) = (core.particles.len(), core.walls().len());
        let is_there = |&((row, wall), _): &((u32, u16), u32)| {
            (row as usize) < rows && usize::from(wall) < walls
        };
        if !near.iter().all(is_there) {
            return Err("it has particles near walls that are not there".to_owned());
        }
        self.near = near
            .into_iter()
            .map(|((row, wall), image)| NearWall {
                row,
                wall: WallIndex::new(wall),
                image,
                features: 1,
            })
            .collect();
        Ok(())
    }
}

/// Angular frequency of the contact of the ball, 1/s.
const OMEGA: f64 = 50.0;
const DT: f64 = 1e-4;

/// A ball of 1 kg that falls on a plane without weight, elastic.
fn falling() -> Arc<Plan> {
    // Of a wall m* is the mass of the ball: k = m w^2.
    let law = frictionless(AnyNormal::Linear(Linear::new(OMEGA * OMEGA, 0.0)));
    let radius = 0.5;
    let density = 6.0 / std::f64::consts::PI;
    let mut draft = plan(DT, density, law);
    draft.walls = vec![plane(DVec3::ZERO, DVec3::Z)];
    let ball = sphere(DVec3::Z * (radius + 0.01), radius, -DVec3::Z, DVec3::ZERO);
    Arc::new(draft.with_particles(vec![ball]).plan().unwrap())
}

fn clocked(threads: usize) -> StartOptions {
    StartOptions::threads(threads).parts(vec![Box::new(WallClock::default())])
}

/// An elastic spring is in touch for half a period, pi/w; the times at which a contact begins and ends are found to a step each.
#[test]
fn a_part_from_outside_has_a_column_and_goes_back_in_place() {
    let plan = falling();
    let mut engine = Engine::start(Arc::clone(&plan), clocked(1)).unwrap();
    // 10 ms to the plane, 63 ms in touch: this is in the midst of it.
    engine.steps_at_once(400, None).unwrap();
    let amid = engine.snapshot();
    engine.steps_at_once(600, None).unwrap();
    let touched = |engine: &Engine| engine.particles.columns.get(TOUCHED).unwrap()[0];
    let expected = std::f64::consts::PI / OMEGA;
    assert!(
        (touched(&engine) - expected).abs() <= 2.0 * DT,
        "{}",
        touched(&engine)
    );
    let busy = engine.part::<WallClock>().unwrap().busy;
    assert_eq!((touched(&engine) / DT).round() as u64, busy);
    let end = engine.snapshot();

    // Back in place, and on again to the same bytes; a new engine likewise.
    engine.restore_in_place(&amid).unwrap();
    assert!(engine.snapshot() == amid);
    assert!(touched(&engine) < expected);
    engine.steps_at_once(600, None).unwrap();
    assert!(engine.snapshot() == end);
    let mut other = Engine::resume(plan, amid, clocked(2)).unwrap();
    other.steps_at_once(600, None).unwrap();
    assert!(other.snapshot() == end);
}

/// A state without the part is refused, and the engine goes on as if nothing had been.
#[test]
fn a_state_that_does_not_fit_leaves_the_engine_as_it_was() {
    let plan = falling();
    let mut engine = Engine::start(Arc::clone(&plan), clocked(1)).unwrap();
    let mut undisturbed = Engine::start(Arc::clone(&plan), clocked(1)).unwrap();
    let foreign = Engine::new(plan, 1).unwrap().snapshot();
    engine.steps_at_once(300, None).unwrap();
    undisturbed.steps_at_once(600, None).unwrap();
    let Err(RunError::OtherState { section, .. }) = engine.restore_in_place(&foreign) else {
        panic!("a state without the column is taken");
    };
    assert_eq!(section, "particles");
    engine.steps_at_once(300, None).unwrap();
    assert!(engine.snapshot() == undisturbed.snapshot());
}

/// Columns go by their names: a second one of the same name would never be found.
#[test]
fn a_column_that_is_there_is_refused() {
    let parts: Vec<Box<dyn Part>> = vec![
        Box::new(WallClock::default()),
        Box::new(WallClock::default()),
    ];
    let Err(error) = Engine::start(falling(), StartOptions::threads(1).parts(parts)) else {
        panic!("two columns have one name");
    };
    assert!(error.to_string().contains(TOUCHED), "{error}");
}

//! Energy that parts of the step take stands in the energy budget.

use std::path::Path;
use std::sync::Arc;

use mercury_common::formats::table_head;
use mercury_common::scene::{Files, parse_scene};

use crate::output::{Exchanged, FrameCopy, Schedule, Writer};
use crate::run::budget::energy_summary;
use mercury_engine::forces::{Needs, Observation, Watch};
use mercury_engine::step::{Core, Engine, Part, StartOptions};

/// Drag of a fluid at rest, F = -c v, with the energy that it takes: by the trapezoidal rule over its power at the time of the forces.
#[derive(Default)]
struct Drag {
    power: f64,
    taken: f64,
}

/// N s/m.
const DRAG: f64 = 0.5;

impl Part for Drag {
    fn name(&self) -> &str {
        "air drag"
    }

    fn needs(&self) -> Needs {
        Needs {
            after_contacts: true,
            whole_steps: true,
            ..Needs::default()
        }
    }

    fn add_loads(&mut self, core: &mut Core) {
        let particles = &mut core.particles;
        for (record, load) in particles.records.iter().zip(&mut particles.loads) {
            load.force -= record.velocity * DRAG;
        }
    }

    fn after_forces(&mut self, core: &mut Core, _: Option<&Observation>) {
        let since = core.since_last();
        let particles = &core.particles;
        let forces = particles.records.iter().zip(&particles.loads);
        let powers = forces.map(|(record, load)| {
            let velocity = record.velocity + load.force * (record.inverse_mass * 0.5 * since);
            -load.force.dot(velocity)
        });
        let power = powers.sum();
        self.taken += 0.5 * since * (self.power + power);
        self.power = power;
    }

    fn dissipated(&self) -> Option<f64> {
        Some(self.taken)
    }
}

/// A part that takes energy stands by its name in the budget, its file, the summary and the chart, and the budget closes: of 1/2 m v^2, a sphere
/// of 1 kg loses 1 - exp(-2 c t/m).
#[test]
fn what_a_part_takes_stands_by_its_name_in_the_budget() {
    let text = r#"
        time = { end = 1.0, step = 1e-3 }
        domain = { min = [-2, -2, -2], max = [2, 2, 2] }
        output = { interval = 0.25, energy_budget = true }
        [materials.m]
        density = 1.909859317102744
        normal = { law = "linear", stiffness = 1000.0, restitution = 1.0 }
        [[particles]]
        material = "m"
        radius = 0.5
        position = [0, 0, 0]
        velocity = [1, 0, 0]
    "#;
    let scene = parse_scene(Path::new("drag.toml"), text, &[], Files::Unchecked).unwrap();
    let plan = Arc::new(crate::plan::plan(&scene).unwrap());
    let place = tempfile::tempdir().unwrap();
    let parts: Vec<Box<dyn Part>> = vec![Box::new(Drag::default())];
    let options = StartOptions::threads(1).parts(parts);
    let mut engine = Engine::start(Arc::clone(&plan), options).unwrap();
    let columns = engine.history_columns();
    let losses = engine.audit().losses;
    let task_progress = Arc::default();
    let writer = Writer::start(
        place.path(),
        &plan,
        (&columns, &losses),
        None,
        None,
        &task_progress,
    )
    .unwrap();
    let mut schedule = Schedule::behind(plan.outputs().files(), plan.physics().time_step, 0);
    let at_start = Exchanged::by_now(&engine);
    assert!(writer.send(FrameCopy::take(
        &mut engine,
        schedule.everything(),
        &at_start
    )));
    for step in 1..=plan.physics().steps {
        let due = schedule.due(step);
        engine.step(due.any().then(Watch::default)).unwrap();
        if due.any() {
            engine.complete_step().unwrap();
            assert!(writer.send(FrameCopy::take(&mut engine, due, &at_start)));
        }
    }
    let (written, _) = writer.finish().unwrap();
    let file = std::fs::read_to_string(place.path().join("drag.budget.csv")).unwrap();
    let rows: Vec<Vec<&str>> = file.lines().map(|row| row.split(',').collect()).collect();
    assert!(
        rows[0].join(",").contains(
            ",dissipated_normal [J],dissipated_tangential [J],dissipated_rolling [J],dissipated_liquid [J],dissipated_air_drag [J],wall_work [J],"
        ),
        "{:?}",
        rows[0]
    );
    assert_eq!(rows.len(), 6);
    let of = |row: &[&str], name: &str| -> f64 {
        let column = rows[0]
            .iter()
            .position(|cell| table_head::name(cell) == name)
            .unwrap();
        row[column].parse().unwrap()
    };
    for row in &rows[1..] {
        // The force uses a velocity half a step old: (c/m) dt/2 of it. The budget is of second order: (c dt/m)^2.
        let expected = 0.5 * (1.0 - f64::exp(-2.0 * DRAG * of(row, "time")));
        let found = of(row, "dissipated_air_drag");
        assert!((found - expected).abs() < 2.5e-4, "{found} J, {expected} J");
        assert!(of(row, "closure").abs() < 2.5e-7, "{}", row.join(","));
    }
    let losses = engine.audit().losses;
    assert_eq!(losses.of("air drag"), losses.total());
    let page = mercury_pictures::energy_page("", &written.energies);
    let svg = page.svg().unwrap();
    assert!(svg.contains("dissipated, air drag"));
    let summary = serde_json::to_value(energy_summary(&engine, &written)).unwrap();
    assert_eq!(summary["dissipated"]["air drag"], losses.total());
    assert_eq!(summary["dissipated"]["normal"], 0.0);
}

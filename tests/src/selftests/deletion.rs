//! A sphere that falls out of the run: set-up 29.

use anyhow::{Context, Result, ensure};
use glam::DVec3;
use mercury_common::formats::data::DataReader;
use mercury_engine::boundaries::{DeletionPlan, Region};
use mercury_engine::contact::{AnyNormal, Linear};
use mercury_engine::state::MaterialIndex;
use mercury_solver::plan::{Draft, NewParticle};

use super::Data;
use super::comparison::{Comparison, Tally, Tolerance};
use super::run::{by_id, frictionless, observe, saved_steps};

/// 29: a sphere falls and is deleted below z = 1; frames go on without particles.
pub(super) fn deletion(data: &Data) -> Result<Comparison> {
    let (dt, end) = (1e-3, 3.0);
    let domain = (DVec3::new(-1.0, -1.0, 0.0), DVec3::new(1.0, 1.0, 5.0));
    let law = frictionless(AnyNormal::Linear(Linear::new(1e4, 0.0)));
    let mut plan = Draft::new(dt, domain, 1000.0, law);
    plan.gravity = DVec3::NEG_Z;
    plan.deletions.push(DeletionPlan {
        name: "below".to_owned(),
        region: Region::Box {
            min: DVec3::new(-1.0, -1.0, -1.0),
            max: DVec3::ONE,
        },
    });
    let sphere = NewParticle::at(DVec3::new(0.0, 0.0, 4.0), 0.5, MaterialIndex::new(0));
    let plan = plan.with_particles(vec![sphere]);
    let frames = DataReader::open(data.file("boundaries/DeletionBoundarySelfTest.data"))?;
    let frames = frames.collect::<Result<Vec<_>, _>>()?;
    let saved = saved_steps(dt, end, 100);
    ensure!(saved.len() == frames.len(), "frame count");
    let mut tally = Tally::default();
    let mut frames = frames.iter();
    observe(plan, &saved, |engine| {
        let frame = frames.next().context("more states than frames")?;
        let found = by_id(engine);
        tally.add("time", frame.time, engine.time());
        tally.add(
            "particles",
            frame.particles.len() as f64,
            found.len() as f64,
        );
        for (expected, found) in frame.particles.iter().zip(&found) {
            tally.vector("position", expected.position, found.position);
            tally.vector("velocity", expected.velocity, found.velocity);
            tally.add("radius", expected.radius, found.radius);
        }
        Ok(())
    })?;
    Ok(tally.finish(
        "a falling sphere is deleted",
        "MercuryDPM DeletionBoundarySelfTest (.data)",
        Tolerance::TEN_DIGITS,
    ))
}

//! Which pairs are glued, their contacts, and ends that are removed.

use glam::DVec3;

use super::{CONTACT, LENGTH, RADIUS, bonds, chain, floor, glue, inputs, kinetic, row, start};
use crate::bonds::{BondPlan, Bonds, BreakMode, Gluing, LawOfBonds};
use crate::boundaries::{DeletionPlan, Region};
use crate::forces::Watch;
use crate::step::Engine;

/// Without contact the pair is not listed until the bond breaks; with it, only what overlaps more than when glued counts.
#[test]
fn contacts_of_glued_pairs_begin_where_they_were_glued() {
    let overlap = 0.02 * RADIUS;
    let places = [DVec3::ZERO, DVec3::X * (LENGTH - overlap)];
    let soft = LawOfBonds::Parallel {
        normal_stiffness: 1.0,
        shear_stiffness: 1.0,
    };
    let watch = Some(Watch::default());
    let force = |engine: &mut Engine, overlap: f64| {
        let far = row(engine, 1);
        let near = row(engine, 0);
        let place = engine.particles.records[near].position;
        engine.particles.records[far].position = place + DVec3::X * (LENGTH - overlap);
        engine.lists_are_stale();
        engine.step(watch).unwrap();
        -engine.particles.loads[row(engine, 0)].force.x
    };
    for (contact, wall) in [(true, false), (false, false), (true, true), (false, true)] {
        let mut plan = BondPlan {
            law: soft,
            contact,
            strengths: [1e-2, f64::INFINITY],
            ..glue()
        };
        let mut inputs = if wall {
            plan.walls = vec![0];
            let place = DVec3::X * (-LENGTH - overlap);
            let mut inputs = inputs(1e-9, &[place], plan);
            inputs.walls = vec![floor(DVec3::X * (-3.0 * RADIUS), DVec3::X, Vec::new())];
            inputs
        } else {
            inputs(1e-9, &places, plan)
        };
        if !wall {
            inputs.particles[0].fixed = true;
        }
        let mut engine = start(inputs);
        let pressed = |engine: &mut Engine, overlap: f64| {
            if wall {
                let own = row(engine, 0);
                engine.particles.records[own].position = DVec3::X * (-LENGTH - overlap);
                engine.lists_are_stale();
                engine.step(watch).unwrap();
                engine.particles.loads[row(engine, 0)].force.x
            } else {
                force(engine, overlap)
            }
        };
        // A bond of 1 N/m3 pulls with some 1e-11 N.
        let most = 1e-9;
        assert!(pressed(&mut engine, 0.9 * overlap).abs() < most);
        let more = if contact {
            CONTACT * 0.5 * overlap
        } else {
            0.0
        };
        assert!(
            (pressed(&mut engine, 1.5 * overlap) - more).abs() < most,
            "{contact} {wall}"
        );
        assert_eq!(bonds(&engine).all().len(), 1);
    }
}

/// Glue that sets at touches: in its time alone, once for each pair.
#[test]
fn touches_are_glued_in_their_time() {
    for (from, until, expected) in [(0.0, 1.0, 2), (0.0, 1e-5, 0), (0.9, 1.0, 0)] {
        let plan = BondPlan {
            when: Gluing::Contact { from, until },
            walls: vec![0],
            ..glue()
        };
        let places = [DVec3::Z * (1.01 * RADIUS), DVec3::Z * (3.02 * RADIUS)];
        let mut inputs = inputs(1e-6, &places, plan);
        inputs.walls = vec![floor(DVec3::ZERO, DVec3::Z, Vec::new())];
        for particle in &mut inputs.particles {
            particle.velocity = DVec3::Z * -0.1;
        }
        let mut engine = start(inputs);
        assert_eq!(bonds(&engine).all().len(), 0);
        engine.steps_at_once(400, None).unwrap();
        assert_eq!(bonds(&engine).counts()[0].made, expected, "{from} {until}");
    }
}

/// The removal of an end breaks its bonds, and their energy is booked.
#[test]
fn a_removed_end_breaks_its_bonds() {
    let mut inputs = inputs(1e-6, &chain(3), glue());
    inputs.energy_budget = true;
    inputs.deletions = vec![DeletionPlan {
        name: "end".to_owned(),
        region: Region::HalfSpace {
            point: DVec3::X * (2.05 * LENGTH),
            normal: DVec3::X,
        },
    }];
    for particle in &mut inputs.particles {
        particle.velocity = DVec3::X;
    }
    inputs.particles[2].velocity *= 1.01;
    let mut engine = start(inputs);
    let before = kinetic(&engine);
    engine.steps_at_once(150, None).unwrap();
    let counts = bonds(&engine).counts()[0];
    assert_eq!(
        (counts.made, counts.broken, engine.particles.len()),
        (2, 1, 2)
    );
    let (part, _) = engine.part_and_core::<Bonds>().unwrap();
    let broken = part.take_breaks().remove(0);
    assert_eq!((broken.ids, broken.mode), ([1, 2], BreakMode::Deletion));
    assert!(broken.energy > 0.0 && broken.energy < before);
    assert_eq!(engine.audit().losses.of("bonds"), broken.energy);
}

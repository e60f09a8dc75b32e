//! Flux planes: what passes is what left, each lap and each return counts.

use glam::DVec3;
use mercury_common::random::Stream;

use super::super::{Crossed, DeletionPlan, FluxPart, FluxPlan, Region};
use super::plan;
use crate::physics::{Inputs, Setup};
use crate::state::MaterialIndex;
use crate::state::NewParticle;
use crate::step::Engine;

fn plane(point: DVec3, normal: DVec3) -> FluxPlan {
    FluxPlan {
        name: "plane".to_owned(),
        point,
        normal,
        part: FluxPart::All,
    }
}

fn sphere(position: DVec3, velocity: DVec3, radius: f64) -> NewParticle {
    NewParticle {
        velocity,
        ..NewParticle::at(position, radius, MaterialIndex::new(0))
    }
}

/// Inputs with planes that count.
fn setup(draft: Inputs, fluxes: Vec<FluxPlan>) -> Setup {
    let mut setup = draft.setup().unwrap();
    setup.watched.fluxes = fluxes;
    setup
}

/// Steps without contact, and what crossed each plane.
fn run(draft: Inputs, fluxes: Vec<FluxPlan>, steps: u32) -> (Engine, Vec<Crossed>) {
    let mut engine = Engine::new(setup(draft, fluxes), 1).unwrap();
    for _ in 0..steps {
        engine.step(None).unwrap();
    }
    let crossed = engine.take_crossed();
    (engine, crossed)
}

#[test]
fn a_normal_that_is_square_but_for_round_off_counts_once() {
    let mut draft = plan().with_particles(vec![sphere(
        DVec3::new(0.5, 0.5, 0.49),
        DVec3::new(0.0, 0.0, 1.0),
        0.004,
    )]);
    draft.cell = draft.cell.with_periodic([true, true, false]);
    let normal = DVec3::new(6.1e-17, -6.1e-17, 1.0);
    let fluxes = vec![plane(DVec3::splat(0.5), normal)];
    let steps = (0.02 / draft.time_step) as u32;
    let (_, crossed) = run(draft, fluxes, steps);
    assert_eq!(crossed[0].number(), 1);
}

#[test]
fn what_passes_is_what_left() {
    let mut stream = Stream::new(5, "gas", 0);
    let mut point = |low, high| {
        DVec3::new(
            stream.uniform_in(low, high),
            stream.uniform_in(low, high),
            stream.uniform_in(low, high),
        )
    };
    let particles: Vec<NewParticle> = (0..800)
        .map(|_| sphere(point(0.01, 0.99), point(-2.0, 2.0), 0.004))
        .collect();
    let mut draft = plan().with_particles(particles);
    draft.cell = draft.cell.with_periodic([true, true, false]);
    // All that gets into the region came through the plane that bounds it, in the step in which it is deleted; what leaves below left
    // through a plane in the face.
    draft.deletions = vec![DeletionPlan {
        name: "outlet".to_owned(),
        region: Region::HalfSpace {
            point: DVec3::new(0.0, 0.0, 0.9),
            normal: DVec3::Z,
        },
    }];
    let above = draft
        .particles
        .iter()
        .filter(|particle| particle.position.z >= 0.9)
        .count() as u64;
    let fluxes = vec![
        plane(DVec3::new(0.3, 0.2, 0.9), DVec3::Z),
        plane(DVec3::ZERO, DVec3::NEG_Z),
    ];
    let (engine, crossed) = run(draft, fluxes, 400);
    let boundaries = engine.boundaries();
    for (crossed, left, not_crossed) in [
        (&crossed[0], &boundaries.deletions()[0], above),
        (&crossed[1], &boundaries.faces()[4], 0),
    ] {
        assert!(crossed.forward > 50);
        assert_eq!(crossed.backward, 0);
        assert_eq!(crossed.forward, left.number - not_crossed);
        if not_crossed == 0 {
            // Sums of as many terms in other orders.
            let close = |a: f64, b: f64| (a - b).abs() <= 1e-12 * a.abs().max(1e-3);
            assert!(close(crossed.mass, left.mass) && close(crossed.volume, left.volume));
            assert!((crossed.momentum - left.momentum).length() < 1e-12);
            // All of one size.
            for p in [1, 3, 4] {
                assert!(close(crossed.mean_diameter(p), 0.008));
            }
        }
    }
}

#[test]
fn every_lap_counts_once() {
    let mut draft = plan();
    draft.cell = draft.cell.with_periodic([true, false, false]);
    // 2 m/s for 5 s with a period of 1 m: ten laps, to round-off of 5000 drifts. The planes: in the middle, at either face, where the
    // particle starts, just ahead of it and oblique.
    let start = DVec3::new(0.25, 0.5, 0.5);
    draft.particles = vec![sphere(start, DVec3::X * 2.0, 0.01)];
    let at = |x: f64| DVec3::new(x, 0.1, 0.9);
    let fluxes = [0.5, 0.0, 1.0, 0.26]
        .map(|x| plane(at(x), DVec3::X))
        .into_iter()
        .chain([
            plane(at(0.7), DVec3::NEG_X),
            plane(
                DVec3::new(0.6, 0.5, 0.5),
                DVec3::new(2.0, 1.0, 0.0).normalize(),
            ),
            plane(DVec3::new(0.6, 0.5, 0.5), DVec3::Y),
        ])
        .collect();
    let (_, crossed) = run(draft, fluxes, 5000);
    let net: Vec<i64> = crossed.iter().map(Crossed::number).collect();
    assert_eq!(net, [10, 10, 10, 10, -10, 10, 0]);
    assert!(
        crossed
            .iter()
            .all(|crossed| crossed.forward + crossed.backward <= 10)
    );
    let mass = crossed[0].mass / 10.0;
    assert!((crossed[4].mass + 10.0 * mass).abs() < 1e-12 * mass);
    // Momentum against the normal is carried backwards: its sign turns as well.
    assert!((crossed[4].momentum.x + 20.0 * mass).abs() < 1e-10 * mass);
}

#[test]
fn what_turns_back_is_taken_off_again() {
    let mut draft = plan();
    draft.gravity = DVec3::NEG_Z * 10.0;
    // Thrown up from 0.3 m at 3 m/s it comes to 0.75 m and falls below 0 after 0.69 s; one starts in the plane and falls away.
    draft.particles = vec![
        sphere(DVec3::new(0.2, 0.5, 0.3), DVec3::Z * 3.0, 0.01),
        sphere(DVec3::new(0.8, 0.5, 0.5), DVec3::ZERO, 0.01),
    ];
    let fluxes = vec![
        plane(DVec3::splat(0.5), DVec3::Z),
        plane(DVec3::splat(0.8), DVec3::Z),
    ];
    let (mut engine, up) = run(draft, fluxes, 150);
    assert_eq!((up[0].forward, up[0].backward), (1, 1));
    // The one that fell from the plane stood on its upper side.
    assert!((up[0].mass).abs() < 1e-18 && up[1] == Crossed::default());
    for _ in 150..600 {
        engine.step(None).unwrap();
    }
    let down = engine.take_crossed();
    assert_eq!((down[0].forward, down[0].backward), (0, 1));
    assert!(down[0].momentum.z > 0.0, "downwards and backwards");
}

#[test]
fn a_disc_counts_what_passes_through_it() {
    let mut draft = plan();
    draft.cell = draft.cell.with_periodic([true, false, false]);
    let column = |x: f64, y: f64| sphere(DVec3::new(x, y, 0.5), DVec3::NEG_Z, 0.01);
    // A disc that reaches across the periodic face; not across the other.
    draft.particles = vec![
        column(0.05, 0.9),
        column(0.95, 0.9),
        column(0.75, 0.9),
        column(0.05, 0.1),
    ];
    let fluxes = vec![FluxPlan {
        part: FluxPart::Disc(0.2),
        ..plane(DVec3::new(0.1, 0.95, 0.3), DVec3::NEG_Z)
    }];
    let (_, crossed) = run(draft, fluxes, 400);
    assert_eq!((crossed[0].forward, crossed[0].backward), (2, 0));
}

#[test]
fn the_count_goes_on_from_a_snapshot() {
    let mut draft = plan();
    draft.cell = draft.cell.with_periodic([true, false, false]);
    draft.particles = (0..40)
        .map(|k| {
            let y = 0.02 + 0.024 * f64::from(k);
            sphere(
                DVec3::new(0.1, y, 0.5),
                DVec3::X * (0.5 + 0.1 * f64::from(k)),
                0.01,
            )
        })
        .collect();
    let fluxes = vec![plane(DVec3::splat(0.5), DVec3::X)];
    let setup = setup(draft, fluxes);
    let mut whole = Engine::new(setup.clone(), 1).unwrap();
    let mut parts = Engine::new(setup.clone(), 1).unwrap();
    for step in 0..900 {
        whole.step(None).unwrap();
        parts.step(None).unwrap();
        if step % 7 == 0 {
            parts = Engine::restore(setup.clone(), parts.snapshot(), 1).unwrap();
        }
    }
    assert_eq!(parts.snapshot(), whole.snapshot());
    let (whole, parts) = (whole.take_crossed(), parts.take_crossed());
    assert!(whole[0].forward > 60);
    assert_eq!(whole, parts);
}

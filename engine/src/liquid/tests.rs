//! The rules of migration by the numbers of the specification, and the sum of all volumes.

use std::sync::Arc;

use glam::{DVec3, dvec3};
use proptest::prelude::*;

use crate::contact::adhesion::liquid::Tables;
use crate::contact::adhesion::liquid::{Fit, Rupture};
use crate::contact::adhesion::young_laplace::Table;
use crate::contact::registry::AnyPairLaw;
use crate::contact::{
    AdhesionLaw, AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, Bridge, BridgeEvent, Linear,
    Liquid,
};
use crate::forces::{ContactMemory, Partner};
use crate::lanes::Width;
use crate::liquid::{BridgesForm, LiquidPlan};
use crate::physics::Inputs;
use crate::physics::Setup;
use crate::state::NewParticle;
use crate::state::{MaterialIndex, StartValues};
use crate::step::{Engine, Snapshot, StartOptions};
use crate::walls::{Motion, Plane, Shape, Wall, WallFilmPlan};
use mercury_common::particle_properties::FILM_VOLUME;

/// A unit of volume, m^3: bridges of a few of them are short beside the radius.
const UNIT: f64 = 1e-18;
const RADIUS: f64 = 1e-3;
/// Gap between neighbours that touch in the set-ups below, m: an overlap.
const TOUCH: f64 = -1e-8;

fn liquid(max: f64, min: f64, distribution: f64) -> Liquid {
    Liquid {
        fit: Fit::Willett,
        rupture: Rupture::Lian,
        surface_tension: 1e-12,
        max_volume: max * UNIT,
        min_volume: min * UNIT,
        distribution,
        ..Liquid::NONE
    }
    .reaching(RADIUS, &Tables::default())
}

fn law(liquid: Liquid) -> AnyPairLaw {
    AnyPairLaw {
        normal: AnyNormal::Linear(Linear::new(1e-9, 0.0)),
        tangential: AnyTangential::None,
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::Liquid(liquid),
    }
}

/// Spheres at these places along x (m) with these films (units), that hardly feel each other.
fn row(law: AnyPairLaw, places: &[f64], films: &[f64]) -> Inputs {
    let domain = (DVec3::splat(-0.1), DVec3::splat(0.1));
    let mut draft = Inputs::new(1e-6, domain, 2500.0, law);
    draft.particles = (places.iter())
        .map(|&x| NewParticle::at(DVec3::X * x, RADIUS, MaterialIndex::new(0)))
        .collect();
    draft.start_values.push(StartValues {
        particles: films.iter().map(|film| film * UNIT).enumerate().collect(),
        ..StartValues::new(&FILM_VOLUME)
    });
    draft
}

fn start(draft: Inputs) -> Engine {
    Engine::start(draft.setup().unwrap(), StartOptions::threads(1)).unwrap()
}

/// A pair is listed as far as forces between its materials reach, and no farther where there are none.
#[test]
fn pairs_are_listed_as_far_as_their_materials_reach() {
    let wet = law(liquid(1e3, 0.0, 1.0));
    let dry = AnyPairLaw {
        adhesion: AnyAdhesion::None,
        ..wet
    };
    let range = wet.adhesion.range();
    // The first skin is a tenth of the radius.
    let gap = 0.1 * RADIUS + 0.5 * range;
    let apart = 2.0 * RADIUS + gap;
    for (materials, listed) in [([0, 0], 1), ([0, 1], 0), ([1, 1], 0)] {
        let mut draft = row(wet, &[0.0, apart], &[]);
        draft.materials.push(draft.materials[0].clone());
        draft.laws.materials = 2;
        draft.laws.laws = vec![Some(wet), Some(dry), Some(dry), Some(dry)];
        for (particle, material) in draft.particles.iter_mut().zip(materials) {
            particle.material = MaterialIndex::new(material);
        }
        assert_eq!(start(draft).list_statistics().1, listed, "{materials:?}");
    }
}

/// Each reader names the events and memories that it reads. The log of an evaluation lasts until the next one.
#[test]
fn a_log_of_events_has_any_number_of_readers() {
    let wet = law(liquid(1e3, 0.0, 1.0));
    let mut engine = start(row(wet, &[0.0, 2.0 * RADIUS + TOUCH], &[1.0, 2.0]));
    let of_bridges = |engine: &Engine| -> Vec<_> {
        let events = engine.contacts.events_of::<BridgeEvent, Bridge>().iter();
        events
            .map(|event| (event.event, event.contact.touches, event.contact.memory.wet))
            .collect()
    };
    // The touch of the start was answered after it was logged.
    let expected = [(BridgeEvent::Touch, true, 0.0)];
    assert_eq!(of_bridges(&engine), expected);
    assert_eq!(of_bridges(&engine), expected);
    assert!(engine.contacts.events_of::<(), ()>().is_empty());
    let volumes = |held: Vec<ContactMemory<Bridge>>| -> Vec<f64> {
        held.iter().map(|held| held.memory.volume / UNIT).collect()
    };
    close(&volumes(engine.contacts.memories_of(&|_| true)), &[3.0]);
    close(
        &volumes(engine.contacts.memories_of(&|row| row == 0)),
        &[3.0],
    );
    close(&volumes(engine.contacts.memories_of(&|_| false)), &[]);
    assert!(engine.contacts.memories_of::<()>(&|_| true).is_empty());
    engine.step(None).unwrap();
    assert_eq!(of_bridges(&engine), []);
}

/// Places a sphere anew between two steps.
fn put(engine: &mut Engine, id: u32, x: f64) {
    let row = rows(engine)[id as usize];
    engine.particles.records[row].position.x = x;
    engine.particles.records[row].velocity = DVec3::ZERO;
}

/// Row of each id.
fn rows(engine: &Engine) -> Vec<usize> {
    engine
        .particles
        .rows_by_id()
        .iter()
        .map(|&row| row as usize)
        .collect()
}

/// Films by id, in units.
fn films(engine: &Engine) -> Vec<f64> {
    let films = engine.particles.columns.get(FILM_VOLUME.name).unwrap();
    rows(engine).iter().map(|&row| films[row] / UNIT).collect()
}

/// Bridges by ids, in units.
fn bridges(engine: &Engine) -> Vec<([u32; 2], f64)> {
    let mut all: Vec<_> = (engine.bridges().iter())
        .map(|bridge| {
            let id = |row: u32| engine.particles.ids[row as usize].number();
            let pair = match bridge.partner {
                Partner::Particle { row, .. } => {
                    let (a, b) = (id(bridge.row), id(row));
                    [a.min(b), a.max(b)]
                }
                Partner::Wall { .. } => [id(bridge.row), u32::MAX],
            };
            (pair, bridge.memory.volume / UNIT)
        })
        .collect();
    all.sort_by_key(|(pair, _)| *pair);
    all
}

fn close(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (found, expected) in found.iter().zip(expected) {
        assert!(
            (found - expected).abs() <= 1e-12 * expected.abs().max(1.0),
            "{found} {expected}"
        );
    }
}

/// Case T25: A-B touch, then B-C, then A-B part.
#[test]
fn a_chain_hands_its_liquid_on_as_specified() {
    let at = |k: f64| k * (2.0 * RADIUS + TOUCH);
    let far = 0.01;
    let draft = row(
        law(liquid(2.5, 0.0, 0.8)),
        &[at(0.0), at(1.0), far],
        &[3.0, 1.0, 2.0],
    );
    let mut engine = start(draft);
    close(&films(&engine), &[1.125, 0.375, 2.0]);
    assert_eq!(bridges(&engine).len(), 1);
    close(&[bridges(&engine)[0].1], &[2.5]);

    put(&mut engine, 2, at(2.0));
    engine.lists_are_stale();
    engine.step(None).unwrap();
    close(&films(&engine), &[1.125, 0.0, 0.0]);
    let found: Vec<f64> = bridges(&engine).iter().map(|bridge| bridge.1).collect();
    close(&found, &[2.5, 2.375]);

    // A goes beyond the end of its bridge.
    put(&mut engine, 0, at(0.0) - 1e-5);
    engine.lists_are_stale();
    engine.step(None).unwrap();
    close(&films(&engine), &[2.375, 1.125, 0.0]);
    let found = bridges(&engine);
    assert_eq!(found.len(), 1);
    close(&[found[0].1], &[2.5]);
    let row = engine.liquid().unwrap();
    assert!((row.films + row.bridges - 6.0 * UNIT).abs() < 1e-15 * 6.0 * UNIT);
    assert_eq!((row.balance.formed, row.balance.ruptured), (2, 1));
}

/// Case T25: pairs that touch without enough liquid stay dry until they have parted.
#[test]
fn a_dry_touch_stays_dry() {
    let apart = 2.0 * RADIUS + TOUCH;
    let mut engine = start(row(law(liquid(2.5, 0.0, 1.0)), &[0.0, apart], &[0.0, 0.0]));
    assert!(bridges(&engine).is_empty());
    engine.particles.columns.get_mut(FILM_VOLUME.name).unwrap()[0] = UNIT;
    for _ in 0..3 {
        engine.step(None).unwrap();
        assert!(bridges(&engine).is_empty(), "liquid came after the touch");
    }
    put(&mut engine, 1, 2.0 * RADIUS + 1e-6);
    engine.lists_are_stale();
    engine.step(None).unwrap();
    put(&mut engine, 1, apart);
    engine.lists_are_stale();
    engine.step(None).unwrap();
    assert_eq!(bridges(&engine).len(), 1);
}

/// Case T25: the least volume of a bridge.
#[test]
fn too_little_liquid_forms_no_bridge() {
    let apart = 2.0 * RADIUS + TOUCH;
    for (films, forms) in [([0.4, 0.5], false), ([0.5, 0.5], true), ([0.0, 1.0], true)] {
        let engine = start(row(law(liquid(2.5, 1.0, 1.0)), &[0.0, apart], &films));
        assert_eq!(bridges(&engine).len(), usize::from(forms), "{films:?}");
    }
}

/// Nothing of a broken bridge goes to neighbours with a share of 0, and with a share of 1 as much as they can hold.
#[test]
fn shares_and_largest_volumes_bound_what_neighbours_take() {
    let at = |k: f64| k * (2.0 * RADIUS + TOUCH);
    for (share, expected) in [(0.0, [1.0, 1.0, 0.0]), (1.0, [1.0, 0.5, 0.0])] {
        // A-B and B-C hold 2 each, at most 2.5. Of the 2 of A-B each end gets 1; A has no other bridge, B-C can take 0.5.
        let draft = row(
            law(liquid(2.5, 0.0, share)),
            &[at(0.0), at(1.0), 0.01],
            &[2.0, 0.0, 2.0],
        );
        let mut engine = start(draft);
        put(&mut engine, 2, at(2.0));
        engine.lists_are_stale();
        engine.step(None).unwrap();
        put(&mut engine, 0, at(0.0) - 1e-5);
        engine.lists_are_stale();
        engine.step(None).unwrap();
        close(&films(&engine), &expected);
    }
}

/// A grain that is deleted breaks its bridges by the rules, then takes its film along.
#[test]
fn leavers_leave_the_liquid_of_their_bridges() {
    // The second one passes the face of the domain within the first step, and stays within the end of the bridge.
    let edge = 0.1 - 1e-8;
    let mut draft = row(
        law(liquid(2.5, 0.0, 1.0)),
        &[edge - 2.0 * RADIUS - TOUCH, edge],
        &[2.0, 0.0],
    );
    draft.particles[1].velocity = DVec3::X * 0.02;
    let mut engine = start(draft);
    assert_eq!(bridges(&engine).len(), 1);
    engine.step(None).unwrap();
    assert_eq!(engine.particles.len(), 1);
    assert!(bridges(&engine).is_empty());
    close(&films(&engine), &[1.0]);
    let row = engine.liquid().unwrap();
    close(&[row.balance.left.value() / UNIT], &[1.0]);
    assert!(row.error.abs() <= 2e-14 * 2.0 * UNIT);
}

/// Many wet grains with random speeds and films; `dries`: between plates with films, and liquid evaporates.
fn cloud(
    seed: u64,
    share: f64,
    (periodic, dries): (bool, bool),
    bridges_form: BridgesForm,
) -> Setup {
    let radius = 0.5e-3;
    let volume = 2e-12;
    let law = AnyPairLaw {
        normal: AnyNormal::Linear(Linear::new(200.0, 1e-3)),
        tangential: AnyTangential::None,
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::Liquid(
            Liquid {
                fit: Fit::Bagheri,
                surface_tension: 0.02,
                contact_angle: 0.3,
                max_volume: volume,
                distribution: share,
                viscosity: 1e-3,
                ..Liquid::NONE
            }
            .reaching(radius, &Tables::default()),
        ),
    };
    let box_size = 4.5e-3;
    let mut draft = Inputs::new(
        2e-5,
        (DVec3::splat(0.0), DVec3::splat(box_size)),
        2500.0,
        law,
    );
    draft.cell = draft.cell.with_periodic([periodic; 3]);
    let mut plan = LiquidPlan {
        bridges_form,
        ..LiquidPlan::default()
    };
    if dries {
        let table = Table::new(0.3, (1e-5, 0.05), (0.0, 1.0), 1e-2).unwrap();
        draft.laws.tables.add(&Arc::new(table));
        plan.evaporation = 1e-6;
        draft.cell = draft.cell.with_periodic([periodic, periodic, false]);
        for (name, z, sign) in [("low", 0.0, 1.0), ("high", box_size, -1.0)] {
            let plane = Plane::new(DVec3::Z * z, DVec3::Z * sign).unwrap();
            draft.walls.push(Wall {
                name: name.to_owned(),
                material: MaterialIndex::new(0),
                shape: Shape::Plane(plane),
                motion: Motion::new(Vec::new()).unwrap(),
                from: 0.0,
                until: f64::INFINITY,
                reference: DVec3::ZERO,
            });
            plan.wall_films.push(Some(WallFilmPlan {
                areas: vec![box_size * box_size],
                volumes: vec![1e-6 * box_size * box_size],
                keeps: 0.4,
            }));
        }
    }
    let mut stream = mercury_common::random::Stream::new(seed, "cloud", 0);
    let mut films = Vec::new();
    for i in 0..4 {
        for j in 0..4 {
            for k in 0..4 {
                let index = draft.particles.len();
                let place =
                    dvec3(f64::from(i), f64::from(j), f64::from(k)) * 1.1e-3 + DVec3::splat(0.6e-3);
                let mut speed = || 0.3 * (2.0 * stream.uniform() - 1.0);
                draft.particles.push(NewParticle {
                    velocity: dvec3(speed(), speed(), speed()),
                    ..NewParticle::at(place, radius, MaterialIndex::new(0))
                });
                films.push((index, 1.5 * volume * stream.uniform()));
            }
        }
    }
    draft.start_values.push(StartValues {
        particles: films,
        ..StartValues::new(&FILM_VOLUME)
    });
    draft.plans.insert(plan);
    draft.setup().unwrap()
}

fn check_volumes(engine: &Engine, largest: f64) {
    let row = engine.liquid().unwrap();
    let total = row.balance.initial;
    assert!(row.error.abs() <= 2e-14 * total, "{} of {total}", row.error);
    let films = engine.particles.columns.get(FILM_VOLUME.name).unwrap();
    assert!(films.iter().all(|&film| film >= 0.0));
    for bridge in engine.bridges() {
        assert!(bridge.memory.volume > 0.0 && bridge.memory.volume <= largest);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    /// The sum of all volumes stays, no volume is negative or above its cap, and a run that is interrupted anywhere goes on with the
    /// same numbers on another number of threads and of lanes.
    #[test]
    fn volumes_are_kept_and_runs_go_on_as_they_were(
        seed in 0..1000_u64,
        share in 0.0..=1.0_f64,
        periodic: bool,
        interrupted in 1..1500_u64,
        films: bool,
        dries: bool,
    ) {
        let form = if films { BridgesForm::Films } else { BridgesForm::Contact };
        let plan = cloud(seed, share, (periodic, dries), form);
        let begin = |threads: usize, width: Width| {
            let options = StartOptions::threads(threads).width(Some(width));
            Engine::start(plan.clone(), options).unwrap()
        };
        let mut whole = begin(1, Width::ONE);
        let mut other = begin(2, Width::fastest());
        for step in 0..1500_u64 {
            whole.step(None).unwrap();
            other.step(None).unwrap();
            if step % 100 == 0 {
                check_volumes(&whole, 2e-12);
            }
            if step == interrupted {
                let bytes = other.snapshot().encode();
                let snapshot = Snapshot::decode(&bytes).unwrap();
                other = Engine::restore(plan.clone(), snapshot, 1).unwrap();
            }
        }
        let row = whole.liquid().unwrap();
        prop_assert!(row.balance.formed > 20 && row.balance.ruptured > 20, "{:?}", row.balance);
        prop_assert_eq!(row.balance.evaporated.value() > 0.0, dries);
        prop_assert_eq!(row.wall_films > 0.0, dries);
        prop_assert_eq!(whole.snapshot(), other.snapshot());
    }
}

/// Volumes of two films may add up to more than the largest volume by round-off; the bridge holds no more.
#[test]
fn no_bridge_holds_more_than_the_largest_volume() {
    let apart = 2.0 * RADIUS + TOUCH;
    let mut stream = mercury_common::random::Stream::new(1, "films", 0);
    for _ in 0..300 {
        let films = [(); 2].map(|()| 0.5 + 2.5 * stream.uniform());
        let most = films.iter().sum::<f64>() * (0.3 + 0.6 * stream.uniform());
        let engine = start(row(law(liquid(most, 0.0, 1.0)), &[0.0, apart], &films));
        let bridge = engine.bridges()[0].memory.volume;
        assert!(bridge <= most * UNIT, "{bridge:e} of {:e}", most * UNIT);
        assert!(
            engine.liquid().unwrap().error.abs()
                <= 4e-16 * engine.liquid().unwrap().balance.initial
        );
    }
}

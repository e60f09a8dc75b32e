//! Insertions: totals, rates, sizes, places.

use glam::DVec3;
use mercury_common::curve::Curve;
use mercury_common::random::Stream;
use proptest::prelude::*;

use super::super::{
    Boundaries, Ingredient, InsertionPlan, Limit, OwnGrains, Quantity, Rate, Region, Total, Wait,
};
use super::{insertion, monodisperse, plan, uniform, unit_box};
use crate::cell::Cell;
use crate::physics::Inputs;
use crate::physics::Physics;
use crate::state::Material;
use crate::state::NewParticle;
use crate::state::{MaterialIndex, Particles};
use crate::step::Engine;
use crate::walls::{Cylinder, Motion, Plane, Shape, Side, Touches, Wall, WallNow};

/// Particles and boundaries without an engine: nothing moves.
pub(super) struct Still {
    pub(super) physics: Physics,
    cell: Cell,
    walls: Vec<WallNow>,
    pub(super) particles: Particles,
    pub(super) boundaries: Boundaries,
}

impl Still {
    pub(super) fn new(draft: Inputs) -> Self {
        let physics = draft.physics().unwrap();
        let mut particles = Particles::new(false);
        for new in &physics.particles {
            let (record, mass, prescribed) = new.build(&physics.materials, physics.dimensions);
            particles.push(record, mass, prescribed);
        }
        let cell = physics.cell;
        let (insertions, deletions) = (&physics.insertions, &physics.deletions);
        Self {
            walls: WallNow::all(&physics.walls, physics.time_step, &cell),
            cell,
            boundaries: Boundaries::new(
                insertions,
                deletions,
                &[],
                &physics.setting(&physics.cell),
            ),
            particles,
            physics,
        }
    }

    pub(super) fn exchange(&mut self, time: f64) -> bool {
        let own = OwnGrains {
            rows: 0..self.particles.len(),
            bodies: true,
        };
        let setting = self.physics.setting(&self.cell);
        let events = (self.boundaries).find(&self.particles, &setting, time, &own);
        self.boundaries.exchange(
            &events,
            &mut self.particles,
            &self.physics.insertions,
            &self.physics.setting(&self.cell),
            &self.walls,
            time,
            &mut |_, _| {},
            &mut |_, _, _, _| {},
        )
    }

    pub(super) fn inserted(&self) -> super::super::Tally {
        self.boundaries.inserted()
    }

    fn limit(&self) -> Limit {
        self.boundaries.state().insertions[0].limit
    }
}

pub(super) fn wall(shape: Shape) -> Wall {
    Wall {
        name: "wall".to_owned(),
        material: MaterialIndex::new(0),
        shape,
        motion: Motion::new(Vec::new()).unwrap(),
        from: 0.0,
        until: f64::INFINITY,
        reference: DVec3::ZERO,
    }
}

fn with(insertions: Vec<InsertionPlan>) -> Inputs {
    let mut plan = plan();
    plan.insertions = insertions;
    plan
}

/// Overlap of every pair, by all images and without cells: the deepest, m.
fn deepest_overlap(still: &Still) -> f64 {
    let records = &still.particles.records;
    let mut deepest = f64::NEG_INFINITY;
    for (i, one) in records.iter().enumerate() {
        for other in &records[i + 1..] {
            for code in 0..27 {
                let shift = still.cell.shift(code);
                let allowed = (0..3).all(|axis| shift[axis] == 0.0 || still.cell.is_periodic(axis));
                if allowed {
                    let gap = (one.position - other.position + shift).length();
                    deepest = deepest.max(one.radius + other.radius - gap);
                }
            }
        }
    }
    deepest
}

#[test]
fn totals_are_exact() {
    let feed = |total| insertion(unit_box(), uniform(0.02, 0.04), total);
    let largest = 4.0 / 3.0 * std::f64::consts::PI * 0.02f64.powi(3);

    let mut still = Still::new(with(vec![feed(Total::Number(317))]));
    assert!(still.exchange(0.0));
    assert_eq!((still.particles.len(), still.inserted().number), (317, 317));
    assert_eq!(still.limit(), Limit::Total);
    assert!(!still.exchange(1e-3), "it is finished");
    assert!(!still.boundaries.expects_more());

    let mut still = Still::new(with(vec![feed(Total::Volume(2e-3))]));
    still.exchange(0.0);
    let volume = still.inserted().volume;
    assert!((2e-3..2e-3 + largest).contains(&volume), "{volume}");

    let mut still = Still::new(with(vec![feed(Total::Mass(2.0))]));
    still.exchange(0.0);
    let mass: f64 = still.particles.masses.iter().sum();
    assert!((2.0..2.0 + 1000.0 * largest).contains(&mass), "{mass}");
    assert!((still.inserted().mass - mass).abs() < 1e-12);

    // A whole number of equal particles is met exactly, whatever the round-off of their sum.
    let sphere = 1000.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.01f64.powi(3);
    for number in [1, 3, 10, 77, 300] {
        let total = Total::Mass(sphere * f64::from(number));
        let equal = insertion(unit_box(), monodisperse(0.02), total);
        let mut still = Still::new(with(vec![equal]));
        still.exchange(0.0);
        assert_eq!(still.particles.len(), number as usize);
    }
}

#[test]
fn rates_are_kept_at_every_step() {
    let sphere = 1000.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.005f64.powi(3);
    let steady = |quantity, per_second| Rate::Steady {
        quantity,
        per_second,
    };
    for (rate, per_second, due) in [
        (steady(Quantity::Number, 250.0), 250.0, 0.1),
        (steady(Quantity::Mass, 333.3 * sphere), 333.3, 0.1),
        (
            steady(Quantity::Volume, 2000.0 * sphere / 1000.0),
            2000.0,
            0.1,
        ),
    ] {
        let feed = InsertionPlan {
            rate: Some(rate),
            total: None,
            from: 0.1,
            until: 0.4,
            ..insertion(unit_box(), monodisperse(0.01), Total::Full)
        };
        let mut still = Still::new(with(vec![feed]));
        for step in 0..500 {
            let time = f64::from(step) * 1e-3;
            still.exchange(time);
            // The number that is allowed, rounded up: the last may exceed it.
            let allowed = per_second * (time.min(0.399) - due).max(0.0);
            let expected = (allowed - 1e-6).ceil().max(0.0) as u64;
            assert_eq!(still.inserted().number, expected, "at {time} s");
        }
        assert_eq!(still.limit(), Limit::Time);
        let requested = still.physics.insertions[0].requested(1.0).unwrap().1;
        let quantity_per_second = still.physics.insertions[0].requested(1.1).unwrap().1;
        assert_eq!(requested, quantity_per_second, "nothing more after the end");
    }
}

#[test]
fn a_table_gives_the_flow() {
    let rows = vec![(0.0, 0.0), (0.1, 10.0), (0.2, 10.0), (0.3, 40.0)];
    let feed = InsertionPlan {
        rate: Some(Rate::Table {
            quantity: Quantity::Number,
            amounts: Curve::new(rows).unwrap(),
        }),
        ..insertion(unit_box(), monodisperse(0.01), Total::Number(30))
    };
    let mut still = Still::new(with(vec![feed]));
    for (time, expected) in [
        (0.0, 0),
        (0.05, 5),
        (0.1, 10),
        (0.15, 10),
        (0.2, 10),
        (0.25, 25),
        (0.3, 30),
    ] {
        still.exchange(time);
        assert_eq!(still.particles.len(), expected, "at {time} s");
    }
    assert_eq!(still.limit(), Limit::Total);
}

#[test]
fn sizes_are_those_drawn_however_full_it_is() {
    // Random sequential addition to the end: large particles fail ever more often.
    let distribution = uniform(0.015, 0.045);
    let feed = insertion(unit_box(), distribution.clone(), Total::Full);
    let mut still = Still::new(with(vec![feed]));
    still.exchange(0.0);
    let state = still.boundaries.state().insertions.remove(0);
    assert!(state.failed_attempts > state.inserted.number, "{state:?}");
    assert!(state.is_finished());
    let n = still.particles.len();
    assert!(n > 10_000, "{n}");

    // Exactly the first sizes of the stream, none skipped.
    let mut stream = Stream::new(7, "insertion feed sizes", 0);
    for record in &still.particles.records {
        stream.uniform();
        let radius = 0.5 * distribution.sample_diameter(stream.uniform());
        assert_eq!(record.radius, radius);
    }
    let pending = state.pending.unwrap();
    stream.uniform();
    assert_eq!(
        pending.radius,
        0.5 * distribution.sample_diameter(stream.uniform()),
        "the next one waits"
    );

    // And so they follow the law: Kolmogorov's bound at a significance of 1e-6.
    let mut diameters: Vec<f64> = still
        .particles
        .records
        .iter()
        .map(|record| 2.0 * record.radius)
        .collect();
    diameters.sort_by(f64::total_cmp);
    let distance = diameters
        .iter()
        .enumerate()
        .map(|(i, &d)| {
            let expected = distribution.number_cdf(d);
            let (below, above) = (i as f64 / n as f64, (i + 1) as f64 / n as f64);
            (expected - below).abs().max((above - expected).abs())
        })
        .fold(0.0, f64::max);
    let bound = ((2.0f64 / 1e-6).ln() / (2.0 * n as f64)).sqrt();
    assert!(distance < bound, "{distance} > {bound}");
}

#[test]
fn mixtures_follow_their_shares_by_number() {
    let mut plan = with(Vec::new());
    plan.materials.push(Material {
        name: "heavy".to_owned(),
        density: 3000.0,
    });
    plan.laws.materials = 2;
    plan.laws.laws = vec![plan.laws.laws[0]; 4];
    let mut feed = insertion(unit_box(), monodisperse(0.01), Total::Number(4000));
    feed.mixture.push(Ingredient {
        material: MaterialIndex::new(1),
        clump: None,
        sizes: monodisperse(0.02),
        share: 3.0,
        properties: Vec::new(),
    });
    plan.insertions = vec![feed];
    let mut still = Still::new(plan);
    still.exchange(0.0);
    let records = &still.particles.records;
    let heavy = records
        .iter()
        .filter(|record| record.material == MaterialIndex::new(1))
        .count() as f64;
    // 3 of 4, within four standard deviations.
    assert!((heavy - 3000.0).abs() < 4.0 * (4000.0f64 * 0.75 * 0.25).sqrt());
    for (record, mass) in records.iter().zip(&still.particles.masses) {
        let (radius, density) = [(0.005f64, 1000.0), (0.01, 3000.0)][record.material.index()];
        assert_eq!(record.radius, radius);
        let expected = density * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
        assert!((mass / expected - 1.0).abs() < 1e-14);
    }
}

/// Each of three comes as often as by its share, the last one too.
#[test]
fn a_mixture_of_three_follows_its_shares() {
    let shares = [1.0, 2.0, 5.0];
    let diameters = [0.01, 0.012, 0.014];
    let mut feed = insertion(unit_box(), monodisperse(diameters[0]), Total::Number(4000));
    feed.mixture = (shares.into_iter().zip(diameters))
        .map(|(share, diameter)| Ingredient {
            share,
            sizes: monodisperse(diameter),
            ..feed.mixture[0].clone()
        })
        .collect();
    let mut still = Still::new(with(vec![feed]));
    still.exchange(0.0);
    for (share, diameter) in shares.into_iter().zip(diameters) {
        let records = still.particles.records.iter();
        let count = records
            .filter(|record| record.radius == 0.5 * diameter)
            .count();
        let p = share / 8.0;
        // Within four standard deviations of the binomial law.
        let apart = count as f64 - 4000.0 * p;
        assert!(
            apart.abs() < 4.0 * (4000.0 * p * (1.0 - p)).sqrt(),
            "{count} of {share} in 8"
        );
    }
}

#[test]
fn velocities_are_uniform_about_the_mean() {
    let feed = InsertionPlan {
        velocity_mean: DVec3::new(1.0, 0.0, -0.5),
        velocity_spread: DVec3::new(0.2, 0.0, 0.1),
        ..insertion(unit_box(), monodisperse(0.01), Total::Number(3000))
    };
    let mut still = Still::new(with(vec![feed]));
    still.exchange(0.0);
    let n = still.particles.len() as f64;
    let mut sum = DVec3::ZERO;
    for record in &still.particles.records {
        let deviation = record.velocity - DVec3::new(1.0, 0.0, -0.5);
        assert!(deviation.x.abs() <= 0.2 && deviation.y == 0.0 && deviation.z.abs() <= 0.1 + 1e-15);
        sum += deviation;
    }
    // Four standard deviations of the mean of n uniform numbers of +-a: a / sqrt(3 n).
    assert!((sum.x / n).abs() < 4.0 * 0.2 / (3.0 * n).sqrt());
    assert!((sum.z / n).abs() < 4.0 * 0.1 / (3.0 * n).sqrt());
    let kinetic: f64 = still
        .particles
        .records
        .iter()
        .zip(&still.particles.masses)
        .map(|(record, mass)| 0.5 * mass * record.velocity.length_squared())
        .sum();
    assert!((still.inserted().kinetic / kinetic - 1.0).abs() < 1e-12);
    assert_eq!(still.inserted().rotational, 0.0);
}

#[test]
fn discs_stay_in_their_plane() {
    let mut plan = with(Vec::new());
    plan.dimensions = 2;
    let (low, high) = plan.cell.corners();
    plan.cell = Cell::new(low.with_z(-0.1), high.with_z(0.1), plan.cell.periodic());
    let mut feed = insertion(
        Region::Box {
            min: DVec3::ZERO,
            max: DVec3::new(1.0, 1.0, 0.0),
        },
        monodisperse(0.02),
        Total::Full,
    );
    feed.velocity_spread = DVec3::ONE;
    plan.insertions = vec![feed];
    let mut still = Still::new(plan);
    still.exchange(0.0);
    // Random sequential addition of discs jams at a cover of 0.547 (Feder 1980); 1000 attempts get within a tenth of that.
    let cover = still.particles.len() as f64 * std::f64::consts::PI * 1e-4;
    assert!((0.44..0.547).contains(&cover), "{cover}");
    assert!((still.inserted().volume - cover).abs() < 1e-9);
    for record in &still.particles.records {
        assert_eq!((record.position.z, record.velocity.z), (0.0, 0.0));
    }
    assert!(deepest_overlap(&still) <= 0.0);
}

#[test]
fn what_cannot_fit_fails_at_once() {
    let slit = Region::Box {
        min: DVec3::ZERO,
        max: DVec3::new(1.0, 1.0, 0.01),
    };
    let feed = insertion(slit.clone(), monodisperse(0.02), Total::Number(10));
    let mut still = Still::new(with(vec![feed]));
    assert!(!still.exchange(0.0));
    assert_eq!(still.limit(), Limit::Space);
    assert!(still.boundaries.expects_more());
    let full = insertion(slit, monodisperse(0.02), Total::Full);
    let mut still = Still::new(with(vec![full]));
    assert!(!still.exchange(0.0));
    assert_eq!(still.limit(), Limit::Total, "full of nothing is full");
}

#[test]
fn full_is_once() {
    let feed = InsertionPlan {
        from: 0.01,
        attempts: 50,
        ..insertion(unit_box(), monodisperse(0.2), Total::Full)
    };
    let mut still = Still::new(with(vec![feed]));
    assert!(!still.exchange(0.0) && !still.exchange(0.009));
    assert_eq!(still.limit(), Limit::NotBegun);
    assert!(still.exchange(0.01));
    assert!(!still.exchange(0.011) && still.boundaries.state().insertions[0].is_finished());
    // A hundred attempts would do for a cover of a fifth; many more spheres than one came.
    assert!(still.particles.len() > 20);
}

#[test]
fn goes_on_from_its_state_with_the_same_numbers() {
    let feed = InsertionPlan {
        rate: Some(Rate::Steady {
            quantity: Quantity::Number,
            per_second: 20_000.0,
        }),
        velocity_spread: DVec3::ONE,
        ..insertion(unit_box(), uniform(0.02, 0.06), Total::Number(3000))
    };
    let plan = with(vec![feed]);
    let mut whole = Still::new(plan.clone());
    let mut stopped = Still::new(plan.clone());
    for step in 0..200 {
        let time = f64::from(step) * 1e-3;
        whole.exchange(time);
        stopped.exchange(time);
        if step % 37 == 0 {
            let state = stopped.boundaries.state();
            let physics = &stopped.physics;
            let (insertions, deletions) = (&physics.insertions, &physics.deletions);
            stopped.boundaries =
                Boundaries::new(insertions, deletions, &[], &physics.setting(&physics.cell));
            stopped
                .boundaries
                .restore(&state, &stopped.particles, &stopped.cell)
                .unwrap();
            assert_eq!(stopped.boundaries.state(), state);
        }
    }
    assert!(whole.particles.len() > 1000);
    assert_eq!(whole.particles, stopped.particles);
    assert_eq!(whole.boundaries.state(), stopped.boundaries.state());
}

#[test]
fn the_engine_inserts_the_same_for_any_number_of_threads() {
    let feed = InsertionPlan {
        rate: Some(Rate::Steady {
            quantity: Quantity::Number,
            per_second: 10_000.0,
        }),
        velocity_mean: DVec3::new(0.0, 0.0, -1.0),
        velocity_spread: DVec3::splat(0.5),
        ..insertion(
            Region::Box {
                min: DVec3::new(0.0, 0.0, 0.6),
                max: DVec3::ONE,
            },
            uniform(0.02, 0.04),
            Total::Number(600),
        )
    };
    let mut plan = with(vec![feed]);
    plan.cell = plan.cell.with_periodic([true, true, false]);
    let floor = Plane::new(DVec3::ZERO, DVec3::Z).unwrap();
    plan.walls = vec![wall(Shape::Plane(floor))];
    let plan = plan.setup().unwrap();
    let run = |threads| {
        let mut engine = Engine::new(plan.clone(), threads).unwrap();
        for _ in 0..120 {
            engine.step(None).unwrap();
        }
        (engine.particles.clone(), engine.boundaries().state())
    };
    let (particles, state) = run(1);
    assert_eq!(particles.len(), 600);
    assert_eq!(run(3), (particles, state));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn no_particle_overlaps_another_or_a_wall_and_all_lie_wholly_inside(
        seed in 0..u64::MAX,
        periodic in any::<[bool; 3]>(),
        sticks_out in any::<bool>(),
        ratio in 1.0..5.0f64,
        round in any::<bool>(),
    ) {
        let (low, high) = if sticks_out { (-0.3, 0.8) } else { (0.0, 1.0) };
        let region = if round {
            Region::Sphere { origin: DVec3::splat(0.5 * (low + high)), radius: 0.5 * (high - low) }
        } else {
            Region::Box { min: DVec3::splat(low), max: DVec3::splat(high) }
        };
        let feed = |name: &str| InsertionPlan {
            name: name.to_owned(),
            attempts: 60,
            ..insertion(region.clone(), uniform(0.05, 0.05 * ratio), Total::Full)
        };
        let mut plan = with(vec![feed("one"), feed("two")]);
        plan.seed = seed;
        plan.cell = plan.cell.with_periodic(periodic);
        let tube = Cylinder::new(DVec3::Z, DVec3::splat(0.5), 0.2, Some([-0.2, 0.3]), Side::Both).unwrap();
        let slope = Plane::new(DVec3::splat(0.3), DVec3::new(0.6, 0.0, 0.8)).unwrap();
        plan.walls = vec![wall(Shape::Cylinder(tube)), wall(Shape::Plane(slope))];
        // One is fixed, near a corner, so that its images matter.
        plan.particles = vec![NewParticle { fixed: true, ..NewParticle::at(DVec3::splat(0.95), 0.2, MaterialIndex::new(0)) }];
        let mut still = Still::new(plan);
        still.exchange(0.0);
        prop_assert!(still.particles.len() > 5);
        prop_assert!(deepest_overlap(&still) <= 0.0, "{}", deepest_overlap(&still));
        let mut touches = Touches::new();
        for record in &still.particles.records[1..] {
            for wall in &still.physics.walls {
                wall.shape.touches(record.position, record.radius, &mut touches);
                prop_assert!(touches.is_empty());
            }
            let inside = (0..27).any(|code| region.holds_sphere(
                record.position + still.cell.shift(code), record.radius * (1.0 - 1e-9)));
            prop_assert!(inside);
            prop_assert!(record.position.cmpge(DVec3::ZERO).all() && record.position.cmple(DVec3::ONE).all());
        }
    }
}

/// Two ingredients, a third and two thirds of the number.
fn by_quota(total: Total) -> Inputs {
    let mut plan = with(Vec::new());
    plan.materials.push(Material {
        name: "heavy".to_owned(),
        density: 3000.0,
    });
    plan.laws.materials = 2;
    plan.laws.laws = vec![plan.laws.laws[0]; 4];
    let mut feed = insertion(unit_box(), uniform(0.02, 0.04), total);
    feed.by_quota = true;
    feed.mixture.push(Ingredient {
        material: MaterialIndex::new(1),
        clump: None,
        sizes: uniform(0.01, 0.03),
        share: 2.0,
        properties: Vec::new(),
    });
    plan.insertions = vec![feed];
    plan
}

/// Largest distance of the cumulative numbers of a material's particles, and how many there are.
fn distance_of(still: &Still, material: usize) -> (f64, usize) {
    let sizes = &still.physics.insertions[0].mixture[material].sizes;
    let mut diameters: Vec<f64> = (still.particles.records.iter())
        .filter(|record| record.material.index() == material)
        .map(|record| 2.0 * record.radius)
        .collect();
    diameters.sort_by(f64::total_cmp);
    let n = diameters.len() as f64;
    let distance = |(i, &d): (usize, &f64)| {
        let expected = sizes.number_cdf(d);
        (expected - i as f64 / n).max((i + 1) as f64 / n - expected)
    };
    let largest = (diameters.iter().enumerate()).map(distance);
    (largest.fold(0.0, f64::max), diameters.len())
}

#[test]
fn a_quota_gives_every_size_its_number() {
    let mut still = Still::new(by_quota(Total::Number(900)));
    still.exchange(0.0);
    for (material, expected) in [(0, 300), (1, 600)] {
        let (distance, number) = distance_of(&still, material);
        assert_eq!(number, expected);
        // One in each N-th part of the law; round-off of sizes and shares.
        assert!(distance <= (1.0 + 1e-9) / number as f64, "{distance}");
    }
    assert_eq!(still.limit(), Limit::Total);
    assert!(!still.boundaries.expects_more());
    // Sizes come in no order: those of the first half are not the smaller ones.
    let records = &still.particles.records;
    let mean = |records: &[crate::state::Particle]| {
        records.iter().map(|record| record.radius).sum::<f64>() / records.len() as f64
    };
    let (first, second) = (mean(&records[..450]), mean(&records[450..]));
    // Radii spread by 0.004 m or less; five standard errors of a difference of means of 450 are 0.0013 m.
    assert!((first - second).abs() < 1.3e-3, "{first} {second}");
}

/// The place of a size in the list of all gives its ingredient, also where one of them brings nothing.
#[test]
fn a_quota_knows_the_ingredients_of_its_places() {
    let mut draft = by_quota(Total::Number(90));
    let nothing = |sizes| Ingredient {
        material: MaterialIndex::new(1),
        clump: None,
        sizes,
        share: 0.0,
        properties: Vec::new(),
    };
    let mixture = &mut draft.insertions[0].mixture;
    mixture.insert(1, nothing(uniform(0.3, 0.4)));
    mixture.push(nothing(uniform(0.4, 0.5)));
    let mut still = Still::new(draft);
    still.exchange(0.0);
    let of = |material: usize| {
        let records = still.particles.records.iter();
        let own = records.filter(|record| record.material.index() == material);
        let mut diameters: Vec<f64> = own.map(|record| 2.0 * record.radius).collect();
        diameters.sort_by(f64::total_cmp);
        diameters
    };
    for (diameters, [low, high], number) in [(of(0), [0.02, 0.04], 30), (of(1), [0.01, 0.03], 60)] {
        assert_eq!(diameters.len(), number);
        let part = (high - low) / number as f64;
        for (i, diameter) in diameters.iter().enumerate() {
            let place = (diameter - low) / part - i as f64;
            assert!((-1e-9..=1.0 + 1e-9).contains(&place), "{i}: {diameter}");
        }
    }
}

#[test]
fn a_quota_meets_its_mass_within_half_of_the_smallest_particles() {
    let smallest = [(0.01f64, 1000.0), (0.005, 3000.0)]
        .map(|(radius, density)| density * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3));
    for total in [Total::Mass(2.0), Total::Mass(0.3), Total::Volume(1.5e-3)] {
        let mut still = Still::new(by_quota(total));
        still.exchange(0.0);
        assert_eq!(still.limit(), Limit::Total);
        let inserted = still.inserted();
        let (got, wanted, bound) = match total {
            Total::Mass(mass) => (inserted.mass, mass, 0.5 * (smallest[0] + smallest[1])),
            Total::Volume(volume) => {
                let bound = 0.5 * (smallest[0] / 1000.0 + smallest[1] / 3000.0);
                (inserted.volume, volume, bound)
            }
            _ => unreachable!(),
        };
        assert!(
            (got - wanted).abs() <= bound * (1.0 + 1e-9),
            "{got} {wanted}"
        );
    }
}

#[test]
fn a_quota_goes_on_from_its_state() {
    let slow = |mut plan: Inputs| {
        plan.insertions[0].rate = Some(Rate::Steady {
            quantity: Quantity::Number,
            per_second: 1e5,
        });
        plan
    };
    let mut whole = Still::new(slow(by_quota(Total::Number(500))));
    for step in 0..10 {
        whole.exchange(f64::from(step) * 1e-3);
    }
    let mut first = Still::new(slow(by_quota(Total::Number(500))));
    for step in 0..4 {
        first.exchange(f64::from(step) * 1e-3);
    }
    let mut second = Still::new(slow(by_quota(Total::Number(500))));
    second.particles = first.particles.clone();
    second
        .boundaries
        .restore(&first.boundaries.state(), &first.particles, &first.cell)
        .unwrap();
    for step in 4..10 {
        second.exchange(f64::from(step) * 1e-3);
    }
    assert_eq!(whole.particles.len(), 500);
    assert_eq!(whole.particles.records, second.particles.records);
}

#[test]
fn an_insertion_that_waits_goes_on_from_any_step_as_if_it_had_not_stopped() {
    // Full from the first step on; the spheres fly out of the region, so that lists, and with them the occupancy grid, are
    // rebuilt all the time, and places become free.
    let mut scene = plan();
    scene.insertions = vec![InsertionPlan {
        velocity_mean: DVec3::new(0.0, 0.0, -2.0),
        velocity_spread: DVec3::splat(0.5),
        ..insertion(
            Region::Box {
                min: DVec3::splat(0.2),
                max: DVec3::splat(0.8),
            },
            uniform(0.03, 0.08),
            Total::Number(1_000_000),
        )
    }];
    let plan = scene.setup().unwrap();
    let mut engine = Engine::new(plan.clone(), 1).unwrap();
    let state = |engine: &Engine| engine.boundaries().state();
    let started_with = state(&engine).insertions[0].clone();
    let mut resumed: Vec<Engine> = Vec::new();
    for step in 0..250 {
        engine.step(None).unwrap();
        for other in &mut resumed {
            other.step(None).unwrap();
            assert_eq!(state(other), state(&engine), "step {step}");
            assert_eq!(other.particles.records, engine.particles.records);
        }
        if step % 31 == 0 {
            let snapshot = engine.snapshot();
            resumed.push(Engine::restore(plan.clone(), snapshot, 1).unwrap());
        }
    }
    let now = &state(&engine).insertions[0];
    assert!(now.failed_attempts > started_with.failed_attempts);
    assert!(now.inserted.number > started_with.inserted.number);
}

/// A region that is emptied is filled within the longest wait, and from then on as if it had never been full.
#[test]
fn a_feed_that_was_choked_once_is_not_thinned_for_ever() {
    let mut draft = plan();
    let large = NewParticle::at(DVec3::splat(0.5), 0.45, MaterialIndex::new(0));
    draft.particles = vec![large];
    let region = Region::Box {
        min: DVec3::splat(0.4),
        max: DVec3::splat(0.6),
    };
    draft.insertions = vec![InsertionPlan {
        total: None,
        rate: Some(Rate::Steady {
            quantity: Quantity::Number,
            per_second: 100.0,
        }),
        ..insertion(region, monodisperse(0.01), Total::Full)
    }];
    let mut still = Still::new(draft);
    let wait = |still: &Still| still.boundaries.insertions().next().unwrap().wait;
    let failed = |still: &Still| still.boundaries.state().insertions[0].failed_attempts;
    for step in 0..1000 {
        still.exchange(0.1 + 1e-6 * f64::from(step));
    }
    assert_eq!(still.inserted().number, 0);
    // Rounds at steps 0, 1, 3, ... 63 and from there every 64 steps: 7 + 14. The first six are whole, the others are worth 3 (1 + 10) tries.
    assert_eq!(failed(&still), 6 * 1000 + 33 * (1 + 14));
    // It leaves the domain.
    still.particles.records[0].position = DVec3::splat(5.0);
    let steps = (1000..2000).take_while(|&step| {
        still.exchange(0.1 + 1e-6 * f64::from(step));
        still.inserted().number == 0
    });
    assert!(steps.count() < 64);
    assert_eq!(still.inserted().number, 11);
    assert_eq!(wait(&still), Wait::default());
}

/// Grains fall out of a region that is kept filled. How many come in a time does not depend on the step: with steps of 2e-4 s a round is made every
/// 0.2 ms, in which grains at the bottom, at 1 m/s, move by 0.2 mm, a 25th of their diameter; shorter steps wait for up to 64 of them.
/// Random places alone scatter one ratio by 2 %.
#[test]
fn a_region_that_empties_is_kept_filled_at_any_step() {
    let inserted = |step: f64, seed: u64| {
        let steps = (0.12 / step).round() as u64;
        let mut draft = plan();
        draft.seed = seed;
        draft.time_step = step;
        draft.gravity = DVec3::new(0.0, 0.0, -9.81);
        let high = DVec3::new(0.03, 0.03, 0.15);
        draft.cell = Cell::new(draft.cell.low(), high, [true, true, false]);
        draft.steps = steps;
        draft.insertions = vec![insertion(
            Region::Box {
                min: DVec3::new(0.0, 0.0, 0.1),
                max: DVec3::new(0.03, 0.03, 0.15),
            },
            monodisperse(5e-3),
            Total::Number(1_000_000),
        )];
        let mut engine = Engine::new(draft.setup().unwrap(), 1).unwrap();
        engine.steps_at_once(steps, None).unwrap();
        engine.boundaries().inserted().number
    };
    let of_all = |step: f64| (0..4).map(|seed| inserted(step, seed)).sum::<u64>() as f64;
    let (coarse, fine) = (of_all(2e-4), of_all(1e-5));
    let ratio = fine / coarse;
    assert!((0.95..1.05).contains(&ratio), "{coarse} {fine}");
}

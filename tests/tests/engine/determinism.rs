//! Equal bits for every number of threads, and after a restart.

use std::sync::Arc;

use glam::{DQuat, DVec3, dvec3};
use mercury_common::formats::clump::Pebble;
use mercury_common::random::Stream;
use mercury_engine::bodies::Clump;
use mercury_engine::contact::normal::hertz_damping;
use mercury_engine::contact::rolling::FrictionSpring;
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, Hertz, Luding, Mindlin, PairLaw,
    SpringRotation,
};
use mercury_engine::forces::{SlotState, block_size};
use mercury_engine::state::MaterialIndex;
use mercury_engine::step::Engine;
use mercury_engine::walls::{Component, Cylinder, Motion, Shape, Side};
use mercury_solver::plan::{Draft, NewBody, NewParticle, Plan};
use mercury_tests::scenes::{plane, wall};

/// Frictional spheres that fall, in a periodic layer or into a turning drum.
fn heap(count: usize, drum: bool) -> Arc<Plan> {
    let spring = FrictionSpring {
        stiffness: None,
        dissipation: 0.0,
        friction: 0.1,
        static_friction: 0.12,
    };
    let law = PairLaw {
        normal: AnyNormal::Hertz(Hertz::new(2e6, hertz_damping(0.6))),
        tangential: AnyTangential::Mindlin(Mindlin::new(6e5, 2.0 / 3.0, 0.1, 0.4, 0.4)),
        rolling: AnyRolling::Luding(Luding {
            rolling: spring,
            torsion: spring,
            lever: 1.0,
            rotation: SpringRotation::Project,
        }),
        adhesion: AnyAdhesion::None,
    };
    let size = dvec3(0.3, 0.3, 0.6);
    let mut plan = Draft::new(4e-5, (DVec3::ZERO, size), 2000.0, law);
    plan.gravity = dvec3(0.5, 0.0, -9.81);
    plan.orientations = true;
    plan.energy_budget = true;
    let middle = 0.5 * size;
    if drum {
        plan.cell = plan.cell.with_periodic([false, true, false]);
        let shape = Cylinder::new(DVec3::Y, middle, 0.3, None, Side::Inside)
            .map(Shape::Cylinder)
            .unwrap();
        let turn = Component::Rotation {
            axis: DVec3::Y,
            origin: middle,
            angular_velocity: 20.0,
            from: 0.0,
            until: f64::INFINITY,
        };
        plan.walls
            .push(wall(shape, Motion::new(vec![turn]).unwrap()));
        let shake = Component::Oscillation {
            amplitude: 0.01 * DVec3::Z,
            frequency: 30.0,
            phase: 0.0,
            from: 0.0,
            until: f64::INFINITY,
        };
        let mut floor = plane(dvec3(0.0, 0.0, 0.08), DVec3::Z);
        floor.motion = Motion::new(vec![shake]).unwrap();
        plan.walls.push(floor);
    } else {
        plan.cell = plan.cell.with_periodic([true, true, false]);
        plan.walls.push(plane(DVec3::ZERO, DVec3::Z));
    }
    let mut random = Stream::new(7, "heap", 0);
    let side = (count as f64 / 2.0).cbrt().ceil() as usize;
    let spacing = 0.26 / side as f64;
    let particles = (0..count)
        .map(|k| {
            let place = dvec3(
                (k % side) as f64,
                (k / side % side) as f64,
                (k / (side * side)) as f64,
            );
            let jitter = dvec3(random.uniform(), random.uniform(), random.uniform()) - 0.5;
            NewParticle {
                velocity: jitter * 3.0 - DVec3::Z,
                angular_velocity: jitter * 30.0,
                fixed: k % 401 == 7,
                ..NewParticle::at(
                    dvec3(0.03, 0.02, 0.12) + (place + 0.2 * jitter) * spacing,
                    spacing * (0.4 + 0.15 * random.uniform()),
                    MaterialIndex::new(0),
                )
            }
        })
        .collect();
    Arc::new(plan.with_particles(particles).plan().unwrap())
}

fn run(engine: &mut Engine, steps: u64) {
    for _ in 0..steps {
        engine.step(None).unwrap();
        // as a run does that writes output now and then
        if engine.steps().is_multiple_of(50) {
            engine.complete_step().unwrap();
        }
    }
}

#[test]
fn one_two_and_four_threads_give_the_same_bits() {
    let count = 3200;
    assert!(count > 3 * block_size(count), "four blocks");
    let plan = heap(count, false);
    let mut last = None;
    for threads in [1, 2, 4] {
        let mut engine = Engine::new(plan.clone(), threads).unwrap();
        run(&mut engine, 300);
        let snapshot = engine.snapshot();
        assert!(
            engine.lists().rebuilds > 3,
            "rebuilt {} times",
            engine.lists().rebuilds
        );
        let touching = snapshot
            .pairs()
            .unwrap()
            .iter()
            .filter(|slot| slot.state == SlotState::Touching)
            .count();
        assert!(touching > count / 4, "{touching} contacts");
        if let Some(last) = &last {
            assert!(snapshot == *last, "{threads} threads give other bits");
        }
        last = Some(snapshot);
    }
}

/// The heap with a rigid body of three pebbles in the place of each sphere.
fn heap_of_clumps(count: usize, drum: bool) -> Arc<Plan> {
    let mut draft = heap(count, drum).draft();
    let pebbles = [-0.6, 0.0, 0.6].map(|x| Pebble {
        position: dvec3(x, 0.0, 0.0),
        radius: 0.4,
    });
    let volume = 0.7;
    let moments = dvec3(0.06, 0.2, 0.21) * 2000.0 * volume;
    let clump = Clump::new(
        "bar",
        MaterialIndex::new(0),
        pebbles.to_vec(),
        2000.0 * volume,
        volume,
        moments,
    )
    .unwrap();
    let body = |particle: &NewParticle| NewBody {
        scale: particle.radius,
        velocity: particle.velocity,
        angular_velocity: particle.angular_velocity,
        orientation: DQuat::from_scaled_axis(particle.angular_velocity),
        fixed: particle.fixed,
        ..NewBody::at(particle.position, 0)
    };
    let bodies = draft.particles.iter().map(body).collect();
    draft.particles.clear();
    Arc::new(draft.with_bodies(vec![clump], bodies).plan().unwrap())
}

#[test]
fn clumps_give_the_same_bits_on_one_two_and_four_threads() {
    let count = 1200;
    let rows = 3 * count;
    assert!(rows > 3 * block_size(rows), "four blocks");
    let plan = heap_of_clumps(count, false);
    let mut last = None;
    for threads in [1, 2, 4] {
        let mut engine = Engine::new(plan.clone(), threads).unwrap();
        run(&mut engine, 300);
        let snapshot = engine.snapshot();
        assert!(
            engine.lists().rebuilds > 3,
            "rebuilt {} times",
            engine.lists().rebuilds
        );
        let touching = snapshot
            .pairs()
            .unwrap()
            .iter()
            .filter(|slot| slot.state == SlotState::Touching)
            .count();
        assert!(touching > 50, "{touching} contacts");
        if let Some(last) = &last {
            assert!(snapshot == *last, "{threads} threads give other bits");
        }
        last = Some(snapshot);
    }
}

#[test]
fn clumps_that_were_restored_go_on_bit_for_bit() {
    let plan = heap_of_clumps(300, true);
    let mut straight = Engine::new(plan.clone(), 1).unwrap();
    let mut restarted = Engine::new(plan.clone(), 1).unwrap();
    for (k, steps) in [37, 1, 150, 113, 99].into_iter().enumerate() {
        run(&mut straight, steps);
        run(&mut restarted, steps);
        let snapshot = restarted.snapshot();
        restarted = Engine::restore(plan.clone(), snapshot.clone(), 1 + k % 3).unwrap();
        assert!(restarted.snapshot() == snapshot && snapshot == straight.snapshot());
    }
    let last = straight.snapshot();
    assert!(
        straight.lists().rebuilds > 2
            && last
                .pairs()
                .unwrap()
                .iter()
                .any(|slot| slot.state == SlotState::Touching)
    );
}

#[test]
fn a_restored_run_goes_on_bit_for_bit() {
    for drum in [false, true] {
        let plan = heap(600, drum);
        let mut straight = Engine::new(plan.clone(), 1).unwrap();
        let mut restarted = Engine::new(plan.clone(), 1).unwrap();
        for (k, steps) in [37, 1, 150, 113, 99].into_iter().enumerate() {
            run(&mut straight, steps);
            run(&mut restarted, steps);
            let snapshot = restarted.snapshot();
            restarted = Engine::restore(plan.clone(), snapshot.clone(), 1 + k % 3).unwrap();
            assert!(
                restarted.snapshot() == snapshot,
                "what is restored is what was saved"
            );
            assert!(
                snapshot == straight.snapshot(),
                "after {} steps",
                straight.steps()
            );
        }
        let last = straight.snapshot();
        assert!(straight.lists().rebuilds > 2);
        assert!(
            !drum || straight.boundaries().removed().number > 0,
            "some leave the domain"
        );
        assert!(
            last.pairs()
                .unwrap()
                .iter()
                .any(|slot| slot.state == SlotState::Touching)
        );
        assert!(
            !drum
                || last
                    .near_walls()
                    .unwrap()
                    .iter()
                    .any(|slot| slot.state == SlotState::Touching)
        );
    }
}

/// Also in the very first step, and between the two half kicks.
#[test]
fn a_run_can_be_restored_at_its_start() {
    let plan = heap(100, true);
    let mut straight = Engine::new(plan.clone(), 1).unwrap();
    let mut restored = Engine::restore(plan.clone(), straight.snapshot(), 1).unwrap();
    run(&mut straight, 20);
    run(&mut restored, 20);
    assert!(straight.snapshot() == restored.snapshot());
}

//! Adhesion: forces beyond contact, with memory there. The laws are this file's own; the plan has none.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DVec3, dvec3};
use mercury_common::formats::mesh::TriangleMesh;
use mercury_common::random::Stream;
use mercury_engine::contact::registry::AnyPairLaw;
use mercury_engine::contact::{
    AdhesionForce, AdhesionLaw, AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, Contact,
    CoulombLimits, History, HistoryNumber, Linear, LinearFriction, NoEvents, NoFriction, NoRolling,
    NormalForce, PairLaw, SpringRotation, TangentialLaw,
};
use mercury_engine::forces::{ContactForces, ContactLoop, SlotState, Watch};
use mercury_engine::lanes::{Mask, Real};
use mercury_engine::step::{Engine, Snapshot, StartOptions};
use mercury_engine::walls::{Disc, Mesh, Motion, Shape};
use mercury_solver::plan::{Draft, Plan};
use mercury_tests::scenes::{held, plan, plane, sphere, wall};

/// A bridge that forms on contact and is torn at a gap: it pulls with one force while the two touch, with less the wider the gap,
/// and with none where it ends. It counts its age.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Bridge {
    /// N.
    pull: f64,
    /// m.
    range: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Bond<L> {
    /// 1 once the two have touched.
    formed: L,
    /// Time since then, s.
    age: L,
}

impl<L: Real> History<L> for Bond<L> {
    type One = Bond<f64>;
    const LENGTH: usize = 2;
    fn columns() -> Vec<HistoryNumber> {
        vec![("1", "bond"), ("s", "age of the bond")]
    }
    fn swapped(self) -> Self {
        self
    }
    fn write(&self, numbers: &mut Vec<L>) {
        numbers.extend([self.formed, self.age]);
    }
    fn read(numbers: &[L]) -> Self {
        Self {
            formed: numbers[0],
            age: numbers[1],
        }
    }

    fn gather(one: impl Fn(usize) -> Bond<f64>) -> Self {
        Self {
            formed: L::from_lanes(|k| one(k).formed),
            age: L::from_lanes(|k| one(k).age),
        }
    }

    fn lane(&self, k: usize) -> Bond<f64> {
        Bond {
            formed: self.formed.lane(k),
            age: self.age.lane(k),
        }
    }
}

impl Bridge {
    /// 1 while they touch, 0 where the bridge ends or where there is none.
    fn part<L: Real>(&self, contact: &Contact<L>, bond: &Bond<L>) -> L {
        let part = (contact.overlap / self.range + L::ONE).min(L::ONE);
        let holds = L::ZERO.below(part) & !bond.formed.equals(L::ZERO);
        L::select(holds, part, L::ZERO)
    }
}

impl AdhesionLaw for Bridge {
    type History<L: Real> = Bond<L>;
    type Events = NoEvents;
    const ACTIVE: bool = true;

    fn name(&self) -> &'static str {
        "bridge"
    }

    fn forms_on_contact(&self) -> bool {
        true
    }

    fn range(&self) -> f64 {
        self.range
    }

    fn force<L: Real>(
        &self,
        contact: &Contact<L>,
        dt: f64,
        bond: &mut Bond<L>,
    ) -> AdhesionForce<L> {
        let touches = L::ZERO.below(contact.overlap);
        let older = bond.age + dt;
        bond.age = L::select(bond.formed.equals(L::ZERO), bond.age, older);
        if touches.any() {
            bond.formed = L::select(touches, L::ONE, bond.formed);
        }
        AdhesionForce::along(NormalForce {
            elastic: self.part(contact, bond) * -self.pull,
            viscous: L::ZERO,
        })
    }

    /// -pull range/2 at the moment of contact: what it takes to tear the bridge.
    fn energy<L: Real>(&self, contact: &Contact<L>, bond: &Bond<L>) -> L {
        let part = self.part(contact, bond);
        part * part * (-0.5 * self.pull * self.range) - contact.overlap.max(L::ZERO) * self.pull
    }
}

/// The pull of a bridge without memory: it acts wherever the gap is below its range.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Attraction(Bridge);

impl AdhesionLaw for Attraction {
    type History<L: Real> = ();
    type Events = NoEvents;
    const ACTIVE: bool = true;

    fn name(&self) -> &'static str {
        "attraction"
    }

    fn forms_on_contact(&self) -> bool {
        false
    }

    fn range(&self) -> f64 {
        self.0.range
    }

    fn force<L: Real>(&self, contact: &Contact<L>, _: f64, (): &mut ()) -> AdhesionForce<L> {
        let always = Bond {
            formed: L::ONE,
            age: L::ZERO,
        };
        AdhesionForce::along(NormalForce {
            elastic: self.0.part(contact, &always) * -self.0.pull,
            viscous: L::ZERO,
        })
    }

    fn energy<L: Real>(&self, contact: &Contact<L>, (): &()) -> L {
        let always = Bond {
            formed: L::ONE,
            age: L::ZERO,
        };
        self.0.energy(contact, &always)
    }
}

type Contacts = (Box<dyn ContactForces>, String);

/// The loop for one material.
fn contacts<T: TangentialLaw, A: AdhesionLaw>(
    normal: Linear,
    tangential: T,
    adhesion: A,
) -> Contacts {
    let law = PairLaw {
        normal,
        tangential,
        rolling: NoRolling,
        adhesion,
    };
    (
        Box::new(ContactLoop::new(vec![law], 1)),
        adhesion.name().to_owned(),
    )
}

/// Law as the plan may know it.
fn planned(normal: Linear, friction: Option<LinearFriction>) -> AnyPairLaw {
    AnyPairLaw {
        normal: AnyNormal::Linear(normal),
        tangential: friction.map_or(AnyTangential::None, AnyTangential::Linear),
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    }
}

const RADIUS: f64 = 1e-3;
const DENSITY: f64 = 2500.0;
const MASS: f64 = 4.0 / 3.0 * std::f64::consts::PI * RADIUS * RADIUS * RADIUS * DENSITY;
const STIFFNESS: f64 = 1000.0;
const BRIDGE: Bridge = Bridge {
    pull: 2e-3,
    range: 2e-4,
};
/// Work that tears the bridge, J.
const WORK: f64 = 0.5 * BRIDGE.pull * BRIDGE.range;

/// Two spheres that fly at each other along x with `speed` (m/s) each, their surfaces `gap` (m) apart.
fn pair(speed: f64, gap: f64, dt: f64) -> Draft {
    let law = planned(Linear::new(STIFFNESS, 0.0), None);
    let at = |side: f64| {
        let place = DVec3::X * (side * (RADIUS + 0.5 * gap));
        sphere(place, RADIUS, DVec3::X * (-side * speed), DVec3::ZERO)
    };
    let mut plan = plan(dt, DENSITY, law).with_particles(vec![at(-1.0), at(1.0)]);
    plan.energy_budget = true;
    plan
}

/// Gap between two spheres, m.
fn gap(engine: &Engine) -> f64 {
    let [a, b] = [0, 1].map(|row| engine.particles.records[row].position);
    a.distance(b) - 2.0 * RADIUS
}

fn kinetic(engine: &Engine) -> f64 {
    let records = engine.particles.records.iter();
    records
        .map(|record| 0.5 * MASS * record.velocity.length_squared())
        .sum()
}

/// How the only pair stands, if it is listed.
fn state(engine: &Engine) -> Option<SlotState> {
    engine
        .snapshot()
        .pairs()
        .unwrap()
        .iter()
        .next()
        .map(|slot| slot.state)
}

#[test]
fn the_loop_says_how_far_it_reaches() {
    let (with, _) = contacts(Linear::new(1.0, 0.0), NoFriction, BRIDGE);
    assert_eq!(with.ranges(), [2e-4]);
    let plan = pair(0.1, 0.0, 1e-6);
    let (without, name) = mercury_engine::forces::contact_loop(&plan.laws);
    assert!(without.ranges().is_empty());
    assert!(!name.contains("adhesion"), "{name}");
}

#[test]
fn a_bridge_forms_on_contact_and_is_torn_at_its_range() {
    // Fast enough to part again: the bridge takes its work from the kinetic energy m v² of both.
    let (speed, start, dt) = (0.2, 3.0 * BRIDGE.range, 1e-7);
    let contacts = contacts(Linear::new(STIFFNESS, 0.0), NoFriction, BRIDGE);
    let plan = Arc::new(pair(speed, start, dt).plan().unwrap());
    let mut engine = Engine::start(
        Arc::clone(&plan),
        StartOptions::threads(1).contacts(contacts),
    )
    .unwrap();
    let (mut met, mut torn) = (false, false);
    let watch = Some(Watch::default());
    let energy = |engine: &Engine| {
        kinetic(engine) + engine.observation().elastic_energy + engine.audit().losses.total()
    };
    let before = energy(&engine);
    assert_eq!(before, MASS * speed * speed);
    for _ in 0..400_000 {
        engine.step(watch).unwrap();
        engine.complete_step().unwrap();
        let (gap, seen) = (gap(&engine), engine.observation());
        met |= gap < 0.0;
        torn |= met && gap >= BRIDGE.range;
        let expected = match gap {
            gap if gap < 0.0 => SlotState::Touching,
            gap if met && !torn && gap < BRIDGE.range => SlotState::Adhering,
            _ => SlotState::Near,
        };
        assert!(
            [None, Some(expected)].contains(&state(&engine)),
            "gap {gap}: {:?}, not {expected:?}",
            state(&engine)
        );
        assert_eq!(seen.particle_contacts, u64::from(gap < 0.0));
        // The force and the energy of the bond along its way.
        let part = match expected {
            SlotState::Near => 0.0,
            SlotState::Touching | SlotState::Behind | SlotState::Through | SlotState::Joined => 1.0,
            SlotState::Adhering => 1.0 - gap / BRIDGE.range,
        };
        let overlap = (-gap).max(0.0);
        let stored =
            0.5 * STIFFNESS * overlap * overlap - BRIDGE.pull * overlap - WORK * part * part;
        // The distance of 2e-3 m is known to 4e-19 m.
        let slope = STIFFNESS * overlap + 2.0 * BRIDGE.pull;
        assert!((seen.elastic_energy - stored).abs() < 1e-18 * slope);
        if !met {
            assert_eq!(engine.particles.records[0].velocity.x.abs(), speed);
        }
        // A force that begins within a step acts for up to a step too short or too long: pull v dt, at both spheres, and the
        // spring's discrete energy differs by (ω dt)²/4 of the whole.
        let tolerance =
            2.0 * BRIDGE.pull * 2.0 * speed * dt + before * (2.0 * STIFFNESS / MASS) * dt * dt;
        assert!(
            (energy(&engine) - before).abs() < tolerance,
            "gap {gap}: {} of {before}, tolerance {tolerance}",
            energy(&engine)
        );
        if gap > start {
            break;
        }
    }
    assert!(torn, "the spheres part");
    assert_eq!(engine.observation().elastic_energy, 0.0);
    // The energy that the bridge set free when it formed is the work that tore it.
    let tolerance =
        2.0 * BRIDGE.pull * 2.0 * speed * dt + before * 2.0 * STIFFNESS / MASS * dt * dt;
    assert!((before - kinetic(&engine) - WORK).abs() < tolerance);
    assert!((engine.audit().losses.total() - WORK).abs() < tolerance);
}

#[test]
fn a_slow_pair_stays_bound() {
    // m v² of both below the work of the bridge
    let speed = 0.5 * (WORK / MASS).sqrt();
    let contacts = contacts(Linear::new(STIFFNESS, 0.0), NoFriction, BRIDGE);
    let plan = Arc::new(pair(speed, 0.1 * BRIDGE.range, 5e-7).plan().unwrap());
    let mut engine = Engine::start(plan, StartOptions::threads(1).contacts(contacts)).unwrap();
    let mut widest = 0.0f64;
    let mut met = false;
    for _ in 0..200_000 {
        engine.step(None).unwrap();
        met |= gap(&engine) < 0.0;
        if met {
            widest = widest.max(gap(&engine));
        }
    }
    // Turned where the bond has taken all: WORK (1 - (1 - s/r)²) = m v².
    let turn = BRIDGE.range * (1.0 - (1.0 - MASS * speed * speed / WORK).sqrt());
    assert!((widest / turn - 1.0).abs() < 1e-2, "{widest}, not {turn}");
    assert!(matches!(
        state(&engine),
        Some(SlotState::Touching | SlotState::Adhering)
    ));
}

#[test]
fn an_attraction_acts_before_contact() {
    let contacts = contacts(Linear::new(STIFFNESS, 0.0), NoFriction, Attraction(BRIDGE));
    let (speed, start, dt) = (0.02, 1.5 * BRIDGE.range, 2e-7);
    let plan = Arc::new(pair(speed, start, dt).plan().unwrap());
    let mut engine = Engine::start(plan, StartOptions::threads(1).contacts(contacts)).unwrap();
    let mut fastest = 0.0f64;
    for _ in 0..200_000 {
        engine.step(None).unwrap();
        if gap(&engine) > 0.0 {
            fastest = fastest.max(engine.particles.records[0].velocity.length());
        }
        if gap(&engine) > start {
            break;
        }
    }
    engine.complete_step().unwrap();
    assert!(gap(&engine) > start);
    // MotionBound at the touch, where it has fallen by WORK; in the end as fast as before. Kicks stand half a step off.
    let touch = (speed * speed + WORK / MASS).sqrt();
    let change = BRIDGE.pull / MASS * dt;
    assert!(
        (fastest - touch).abs() < 2.0 * change,
        "{fastest}, not {touch}"
    );
    let error = (kinetic(&engine) - MASS * speed * speed).abs();
    assert!(error < 4.0 * BRIDGE.pull * speed * dt, "{error}");
}

/// A crowd of sticky spheres that fly about in a box, periodic along x, between planes along y and z.
fn crowd(seed: u64, cells: [u32; 3]) -> (Arc<Plan>, Linear, LinearFriction) {
    let normal = Linear::new(20.0, 1e-4);
    let friction = LinearFriction {
        stiffness: 10.0,
        dissipation: 0.0,
        friction: 0.3,
        static_friction: 0.3,
        rotation: SpringRotation::Project,
        limits: CoulombLimits::Bounded,
    };
    let size = 2.4e-3 * DVec3::from_array(cells.map(f64::from));
    let mut plan = Draft::new(
        2e-5,
        (DVec3::ZERO, size),
        DENSITY,
        planned(normal, Some(friction)),
    );
    plan.cell = plan.cell.with_periodic([true, false, false]);
    let mut random = Stream::new(seed, "crowd", 0);
    let mut particles = Vec::new();
    for place in 0..cells.iter().product() {
        let along = [
            place % cells[0],
            place / cells[0] % cells[1],
            place / cells[0] / cells[1],
        ];
        let cell = DVec3::from_array(along.map(f64::from)) + 0.5;
        let mut any = || dvec3(random.uniform(), random.uniform(), random.uniform()) - 0.5;
        let centre = 2.4e-3 * cell + 2e-4 * any();
        let (velocity, spin) = (0.4 * any(), 100.0 * any());
        let radius = 0.95e-3 + 1e-4 * any().x;
        particles.push(sphere(centre, radius, velocity, spin));
    }
    let walls = [
        (DVec3::ZERO, DVec3::Y),
        (size, DVec3::NEG_Y),
        (DVec3::ZERO, DVec3::Z),
        (size, DVec3::NEG_Z),
    ];
    plan.walls = walls.map(|(point, normal)| plane(point, normal)).into();
    (
        Arc::new(plan.with_particles(particles).plan().unwrap()),
        normal,
        friction,
    )
}

const STICKY: Bridge = Bridge {
    pull: 3e-4,
    range: 2.5e-4,
};

/// Bonds as a plain search over all pairs, images and planes finds them, step by step.
#[derive(Default)]
struct BruteForce {
    /// Lower id, higher id or wall: age of the bond, and whether the two touch.
    pairs: HashMap<(u32, u32), (f64, bool)>,
    walls: HashMap<(u32, u32), (f64, bool)>,
}

impl BruteForce {
    fn step(&mut self, plan: &Plan, engine: &Engine, dt: f64) {
        let cell = plan.physics().cell;
        let particles = &engine.particles;
        let count = particles.len();
        let (mut pairs, mut walls) = (HashMap::new(), HashMap::new());
        let follow = |bonds: &HashMap<_, (f64, bool)>, key, gap: f64| {
            let age = bonds.get(&key).map(|bond: &(f64, bool)| bond.0 + dt);
            match age {
                _ if gap >= STICKY.range => None,
                None if gap >= 0.0 => None,
                age => Some((age.unwrap_or_default(), gap < 0.0)),
            }
        };
        for i in 0..count {
            let a = &particles.records[i];
            for j in i + 1..count {
                let b = &particles.records[j];
                let mut offset = a.position - b.position;
                offset.x -= cell.size().x * (offset.x / cell.size().x).round();
                let gap = offset.length() - a.radius - b.radius;
                let (one, other) = (particles.ids[i].number(), particles.ids[j].number());
                let key = (one.min(other), one.max(other));
                if let Some(bond) = follow(&self.pairs, key, gap) {
                    pairs.insert(key, bond);
                }
            }
            let size = plan.physics().cell.high();
            let place = a.position;
            let heights = [place.y, size.y - place.y, place.z, size.z - place.z];
            for (wall, height) in heights.into_iter().enumerate() {
                let key = (particles.ids[i].number(), wall as u32);
                if let Some(bond) = follow(&self.walls, key, height - a.radius) {
                    walls.insert(key, bond);
                }
            }
        }
        (self.pairs, self.walls) = (pairs, walls);
    }

    /// Compares with the loop over contacts; the last two numbers of a history are the bond's.
    fn compare(&self, engine: &Engine) {
        let snapshot = engine.snapshot();
        let id = |row: u32| engine.particles.ids[row as usize].number();
        let bond = |numbers: &[f64], state| {
            let [formed, age] = numbers[numbers.len() - 2..] else {
                panic!("a bond has two numbers")
            };
            assert_eq!(formed, 1.0);
            (age, state == SlotState::Touching)
        };
        let held = |slot: &mercury_engine::forces::SavedSlot<'_>| slot.state != SlotState::Near;
        let mut pairs = HashMap::new();
        for slot in snapshot.pairs().unwrap().iter().filter(held) {
            let (one, other) = (id(slot.row), id(slot.partner));
            let key = (one.min(other), one.max(other));
            assert!(pairs.insert(key, bond(slot.history, slot.state)).is_none());
        }
        assert_eq!(pairs, self.pairs);
        let mut walls = HashMap::new();
        for slot in snapshot.near_walls().unwrap().iter().filter(held) {
            let key = (id(slot.row), slot.partner);
            assert!(walls.insert(key, bond(slot.history, slot.state)).is_none());
        }
        assert_eq!(walls, self.walls);
    }
}

#[test]
fn bonds_are_those_of_a_search_over_all_pairs() {
    let (plan, normal, friction) = crowd(7, [5, 6, 5]);
    let mut engine = Engine::start(
        Arc::clone(&plan),
        StartOptions::threads(1).contacts(contacts(normal, friction, STICKY)),
    )
    .unwrap();
    let mut expected = BruteForce::default();
    expected.step(&plan, &engine, 0.0);
    let (mut across, mut at_walls, mut through) = (0, 0, 0);
    for _ in 0..1500 {
        engine.step(None).unwrap();
        expected.step(&plan, &engine, plan.physics().time_step);
        expected.compare(&engine);
        across += expected.pairs.values().filter(|bond| !bond.1).count();
        at_walls += expected.walls.values().filter(|bond| !bond.1).count();
        let shifted = |slot: &mercury_engine::forces::SavedSlot<'_>| {
            slot.state == SlotState::Adhering && slot.image != mercury_engine::cell::NO_SHIFT
        };
        through += engine
            .snapshot()
            .pairs()
            .unwrap()
            .iter()
            .filter(shifted)
            .count();
    }
    // It was about something: bonds across gaps, at walls and through the periodic face, many lists.
    assert!(
        across > 10_000 && at_walls > 1000 && through > 1000,
        "{across} {at_walls} {through}"
    );
    assert!(
        engine.list_statistics().0 > 10,
        "{:?}",
        engine.list_statistics()
    );
    let oldest = expected
        .pairs
        .values()
        .map(|bond| bond.0)
        .fold(0.0, f64::max);
    assert!(oldest > 500.0 * plan.physics().time_step, "{oldest}");
}

#[test]
fn attraction_acts_between_all_that_are_within_its_range() {
    let (plan, normal, friction) = crowd(8, [5, 6, 5]);
    let law = contacts(normal, friction, Attraction(STICKY));
    let mut engine =
        Engine::start(Arc::clone(&plan), StartOptions::threads(1).contacts(law)).unwrap();
    let cell = plan.physics().cell;
    let watch = Some(Watch {
        records: true,
        audit: None,
    });
    let mut across = 0;
    for _ in 0..300 {
        engine.step(watch).unwrap();
        let records = engine.observation().records;
        let particles = &engine.particles.records;
        let (mut pairs, mut walls) = (0, 0);
        for (i, a) in particles.iter().enumerate() {
            for b in &particles[i + 1..] {
                let mut offset = a.position - b.position;
                offset.x -= cell.size().x * (offset.x / cell.size().x).round();
                pairs += usize::from(offset.length() - a.radius - b.radius < STICKY.range);
            }
            let (place, size) = (a.position, plan.physics().cell.high());
            for height in [place.y, size.y - place.y, place.z, size.z - place.z] {
                walls += usize::from(height - a.radius < STICKY.range);
            }
        }
        let at_walls = records
            .iter()
            .filter(|record| record.feature != u32::MAX)
            .count();
        assert_eq!((records.len() - at_walls, at_walls), (pairs, walls));
        across += records.iter().filter(|record| record.overlap < 0.0).count();
    }
    assert!(across > 10_000, "{across}");
}

#[test]
fn bonds_are_part_of_the_state_and_of_no_number_of_threads() {
    let (plan, normal, friction) = crowd(9, [12, 12, 15]);
    let law = || contacts(normal, friction, STICKY);
    let mut one =
        Engine::start(Arc::clone(&plan), StartOptions::threads(1).contacts(law())).unwrap();
    let mut three =
        Engine::start(Arc::clone(&plan), StartOptions::threads(3).contacts(law())).unwrap();
    one.steps_at_once(400, None).unwrap();
    three.steps_at_once(400, None).unwrap();
    let saved = one.snapshot();
    assert_eq!(saved, three.snapshot());
    let bonded = |slot: &mercury_engine::forces::SavedSlot<'_>| slot.state == SlotState::Adhering;
    assert!(saved.pairs().unwrap().iter().filter(bonded).count() > 3);
    assert!(saved.near_walls().unwrap().iter().filter(bonded).count() > 0);
    let bytes = saved.encode();
    let back = Snapshot::decode(&bytes).unwrap();
    assert_eq!(back, saved);
    let mut back = Engine::resume(
        Arc::clone(&plan),
        back,
        StartOptions::threads(2).contacts(law()),
    )
    .unwrap();
    one.steps_at_once(400, None).unwrap();
    back.steps_at_once(400, None).unwrap();
    assert_eq!(one.snapshot(), back.snapshot());
}

/// A strip of 10 R along x, cut into triangles that get narrower towards the end that particles leave over.
fn strip() -> Mesh {
    let places = [-5.0, 0.0, 4.0, 4.6, 4.7, 4.9, 5.0];
    let vertices = places
        .iter()
        .flat_map(|x| [-5.0, 5.0].map(|y| RADIUS * dvec3(*x, y, 0.0)))
        .collect();
    let cells = 0..places.len() as u32 - 1;
    let triangles = cells
        .flat_map(|k| {
            [
                [2 * k, 2 * k + 2, 2 * k + 1],
                [2 * k + 1, 2 * k + 2, 2 * k + 3],
            ]
        })
        .collect();
    let triangles = TriangleMesh {
        vertices,
        triangles,
        ..TriangleMesh::default()
    };
    Mesh::new(&triangles, |x| x, false).unwrap()
}

#[test]
fn a_bond_goes_along_the_features_of_a_wall_and_ends_at_its_range() {
    let disc = Disc::new(DVec3::Z, DVec3::ZERO, 5.0 * RADIUS).unwrap();
    for shape in [Shape::Disc(disc), Shape::Mesh(Arc::new(strip()))] {
        // A sphere that touches the face rises a little, moves out over its edge, and on.
        let (dt, law) = (1e-5, planned(Linear::new(STIFFNESS, 0.0), None));
        let start = dvec3(4.5 * RADIUS, 0.0, RADIUS - 1e-6);
        let velocity = dvec3(0.1, 0.0, 2e-3);
        let mut plan = plan(dt, DENSITY, law);
        plan.walls.push(wall(shape.clone(), Motion::default()));
        let plan = plan.with_particles(vec![held(sphere(start, RADIUS, velocity, DVec3::ZERO))]);
        let contacts = contacts(Linear::new(STIFFNESS, 0.0), NoFriction, BRIDGE);
        let mut engine = Engine::start(
            Arc::new(plan.plan().unwrap()),
            StartOptions::threads(1).contacts(contacts),
        )
        .unwrap();
        let (mut features, mut steps) = (Vec::new(), 0.0);
        loop {
            engine.step(None).unwrap();
            steps += 1.0;
            let place = engine.particles.records[0].position;
            let beside = (place.x - 5.0 * RADIUS).max(0.0);
            let gap = place.z.hypot(beside) - RADIUS;
            let near_walls = engine.snapshot().near_walls().unwrap();
            let mut slots = near_walls.iter();
            let held = slots.find(|slot| slot.state != SlotState::Near);
            assert_eq!(held.is_some(), gap < BRIDGE.range, "gap {gap} at {shape:?}");
            let Some(held) = held else { break };
            assert_eq!(held.state == SlotState::Touching, gap < 0.0);
            let age = held.history[1];
            assert!(
                (age - steps * dt).abs() < 1e-15 * steps * steps * dt,
                "{age}"
            );
            if features.last() != Some(&held.feature) {
                features.push(held.feature);
            }
        }
        // The face of the disc and its edge; triangles, the edges between them perhaps, and the last edge.
        let least = if matches!(shape, Shape::Mesh(_)) {
            4
        } else {
            2
        };
        assert!(features.len() >= least, "{features:?}");
    }
}

/// Resists the relative spin of two that touch, as glue does: M = -c (w_A - w_B).
#[derive(Debug, Clone, Copy, PartialEq)]
struct Twist(f64);

impl AdhesionLaw for Twist {
    type History<L: Real> = ();
    type Events = NoEvents;
    const ACTIVE: bool = true;
    const TWISTS: bool = true;

    fn name(&self) -> &'static str {
        "twist"
    }

    fn forms_on_contact(&self) -> bool {
        true
    }

    fn range(&self) -> f64 {
        0.0
    }

    fn force<L: Real>(&self, contact: &Contact<L>, _: f64, (): &mut ()) -> AdhesionForce<L> {
        AdhesionForce {
            couple: contact.spin * L::splat(-self.0),
            ..AdhesionForce::NONE
        }
    }

    fn energy<L: Real>(&self, _: &Contact<L>, (): &()) -> L {
        L::ZERO
    }
}

/// I dw/dt = -c (w_A - w_B) about any axis: the spin of one of two equal spheres decays with the rate 2 c/I, at a wall with c/I. The normal
/// force is zero, so that the overlap lasts. Couples see the angular velocity of half a step before, which changes the rate k by the
/// part k dt/2, and the spin after the time t by the part (k t)(k dt).
#[test]
fn a_couple_of_adhesion_slows_the_spin_of_both_and_counts_as_its_loss() {
    let inertia = 0.4 * MASS * RADIUS * RADIUS;
    let (dt, steps) = (1e-5, 1000);
    let rate = 100.0;
    // What the plan knows has friction, so that spheres turn.
    let friction = LinearFriction {
        stiffness: STIFFNESS,
        dissipation: 0.0,
        friction: 0.5,
        static_friction: 0.5,
        rotation: SpringRotation::Project,
        limits: CoulombLimits::Bounded,
    };
    let law = planned(Linear::new(STIFFNESS, 0.0), Some(friction));
    let overlap = 1e-2 * RADIUS;
    for at_wall in [false, true] {
        let twist = Twist(if at_wall { rate } else { 0.5 * rate } * inertia);
        let spin = dvec3(1.0, -2.0, 3.0);
        let mut plan = plan(dt, DENSITY, law);
        plan.energy_budget = true;
        let particles = if at_wall {
            plan.walls.push(plane(DVec3::ZERO, DVec3::Z));
            let place = DVec3::Z * (RADIUS - overlap);
            vec![sphere(place, RADIUS, DVec3::ZERO, spin)]
        } else {
            let at = |side: f64| {
                let place = DVec3::Z * (side * (RADIUS - 0.5 * overlap));
                sphere(place, RADIUS, DVec3::ZERO, spin * side)
            };
            vec![at(-1.0), at(1.0)]
        };
        let plan = Arc::new(plan.with_particles(particles).plan().unwrap());
        let contacts = contacts(Linear::new(0.0, 0.0), NoFriction, twist);
        let options = StartOptions::threads(1).contacts(contacts);
        let mut engine = Engine::start(plan, options).unwrap();
        let spins = |engine: &Engine| -> Vec<DVec3> {
            let records = engine.particles.records.iter();
            records.map(|record| record.angular_velocity).collect()
        };
        let start = spins(&engine);
        for _ in 0..steps {
            engine.step(None).unwrap();
        }
        engine.complete_step().unwrap();
        let passed = rate * f64::from(steps) * dt;
        let tolerance = 2.0 * passed * rate * dt;
        let (mut lost, mut whole) = (0.0, 0.0);
        for (before, after) in start.iter().zip(spins(&engine)) {
            let expected = *before * (-passed).exp();
            let error = (after - expected).length() / expected.length();
            assert!(error < tolerance, "{error} at_wall: {at_wall}");
            whole += 0.5 * inertia * before.length_squared();
            lost += 0.5 * inertia * (before.length_squared() - after.length_squared());
        }
        let losses = engine.audit().losses.total();
        // The first half step ends with the first forces, whose power is counted from there on.
        let error = (losses - lost).abs() / whole;
        assert!(error < 2.0 * rate * dt, "{losses} J, not {lost} J");
    }
}

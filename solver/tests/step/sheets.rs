//! Contacts of particles with sheets: what the one gets the other loses, in every step.

use std::path::Path;
use std::sync::Arc;

use glam::{DVec3, dvec3};
use mercury_common::curve::Curve;
use mercury_common::formats::clump::Pebble;
use mercury_common::random::Stream;
use mercury_common::scene::Files;

use mercury_common::particle_properties::FILM_VOLUME;
use mercury_engine::bodies::{Clump, NewBody};
use mercury_engine::cell::Cell;
use mercury_engine::forces::{Observation, Partner, Watch};
use mercury_engine::membrane::{
    Elasticity, HoldCourse, HoldPlan, Law, Load, MembranePlan, Sheet, Topology,
};
use mercury_engine::state::{MaterialIndex, StartValues};
use mercury_engine::step::{Engine, Snapshot};
use mercury_engine::surface::{Faces, SurfacePlan};
use mercury_solver::plan::{Draft, NewParticle, Plan, parse_scene, plan};

const FRICTION: &str = r#"tangential = { law = "linear", stiffness_ratio = 0.2857, friction = 0.5 }
        rolling = { law = "luding", friction = 0.1, dissipation = 1e-3 }
        torsion = { law = "luding", friction = 0.1, dissipation = 1e-3 }"#;

/// Of the sheets here where contacts are concerned, m; their masses are of others.
const THICKNESS: f64 = 1e-4;

/// A square of `n` by `n` cells of two triangles each, corners shifted by up to `skew` of a cell.
fn square(n: u32, side: f64, skew: f64, seed: u64) -> SurfacePlan {
    let mut random = Stream::new(seed, "sheet", 0);
    let cell = side / f64::from(n);
    let mut any = || 2.0 * DVec3::new(random.uniform(), random.uniform(), random.uniform()) - 1.0;
    let vertices: Vec<DVec3> = (0..=n)
        .flat_map(|j| (0..=n).map(move |i| (i, j)))
        .map(|(i, j)| DVec3::new(f64::from(i), f64::from(j), 0.0) * cell + any() * (skew * cell))
        .collect();
    let triangles: Vec<[u32; 3]> = (0..n)
        .flat_map(|j| (0..n).map(move |i| j * (n + 1) + i))
        .flat_map(|k| [[k, k + 1, k + n + 2], [k, k + n + 2, k + n + 1]])
        .collect();
    let masses = SurfacePlan::lumped_masses(&vertices, &triangles, 1000.0, 1e-3);
    SurfacePlan {
        name: "sheet".to_owned(),
        material: MaterialIndex::new(0),
        thickness: THICKNESS,
        faces: Faces::Both,
        touches_walls: false,
        triangles,
        vertices,
        masses,
    }
}

/// A sheet without inner forces: those of its springs, of 1e-33 N/m, are below the last digit of any load.
fn limp(surface: SurfacePlan) -> MembranePlan {
    let topology = Topology::new(surface.vertices.len(), &surface.triangles).unwrap();
    let corners =
        (surface.triangles.iter()).map(|corners| corners.map(|k| surface.vertices[k as usize]));
    let law = Law {
        thickness: 1e-3,
        youngs_modulus: 1e-30,
        density: 1000.0,
        elasticity: Elasticity::Springs,
        damping_ratio: 0.0,
        drag: 0.0,
        bending: None,
    };
    let sheet = Sheet::new(topology, &corners.collect::<Vec<_>>(), 0.0, law).unwrap();
    MembranePlan {
        surface: Arc::new(surface),
        sheet: Arc::new(sheet),
        load: Load::Given(Curve::default()),
        first_volume: 0.0,
        holds: Vec::new(),
    }
}

/// A sheet that its only hold carries with this velocity, m/s.
fn carried(mut surface: SurfacePlan, velocity: DVec3) -> MembranePlan {
    surface.masses.fill(f64::INFINITY);
    let vertices = (0..surface.vertices.len() as u32).collect();
    let hold = HoldPlan {
        name: "all".to_owned(),
        vertices,
        ramp: HoldCourse::Velocity(velocity.to_array().map(Some)),
        from: 0.0,
        until: f64::INFINITY,
    };
    MembranePlan {
        holds: vec![hold],
        ..limp(surface)
    }
}

/// Keys of a scene of one material `m`, without gravity.
struct Setup<'a> {
    step: f64,
    /// Normal law.
    normal: &'a str,
    /// Further laws.
    laws: &'a str,
    /// Axes that are periodic, in a domain of 2 m about the origin.
    periodic: &'a str,
    /// Keys of [output].
    output: &'a str,
    /// Further lines.
    more: &'a str,
}

impl Default for Setup<'_> {
    fn default() -> Self {
        Self {
            step: 1e-5,
            normal: r#"{ law = "linear", stiffness = 500.0, restitution = 0.6 }"#,
            laws: FRICTION,
            periodic: "[]",
            output: "interval = 0.1",
            more: "",
        }
    }
}

impl Setup<'_> {
    /// The particles of further lines.
    fn scene_particles(&self) -> Vec<NewParticle> {
        let with = self.plan_of(|draft| draft.particles.drain(..2).for_each(drop));
        with.physics().particles.to_vec()
    }

    fn plan(&self, particles: Vec<NewParticle>, surfaces: Vec<SurfacePlan>) -> Arc<Plan> {
        self.plan_of(|draft| {
            // Without particles that may meet a scene has no laws.
            draft.particles = particles;
            *draft.plans.all_mut() = surfaces.into_iter().map(limp).collect();
        })
    }

    fn plan_of(&self, change: impl FnOnce(&mut Draft)) -> Arc<Plan> {
        let text = format!(
            r#"gravity = [0, 0, 0]
            time = {{ end = 1.0, step = {:e} }}
            domain = {{ min = [-1, -1, -1], max = [1, 1, 1], periodic = {} }}
            output = {{ {} }}
            guard = {{ policy = "off" }}
            [materials.m]
            density = 1000.0
            normal = {}
            {}
            [[particles]]
            material = "m"
            position = [0.9, 0.9, 0.9]
            radius = 0.01
            [[particles]]
            material = "m"
            position = [0.5, 0.9, 0.9]
            radius = 0.01
            {}"#,
            self.step, self.periodic, self.output, self.normal, self.laws, self.more
        );
        let scene = parse_scene(Path::new("sheet.toml"), &text, &[], Files::Unchecked);
        let made = scene.and_then(|scene| plan(&scene));
        let mut draft = made.unwrap_or_else(|errors| panic!("{errors}")).draft();
        change(&mut draft);
        Arc::new(draft.plan().unwrap())
    }
}

fn ball(position: DVec3, radius: f64, velocity: DVec3, angular_velocity: DVec3) -> NewParticle {
    NewParticle {
        velocity,
        angular_velocity,
        ..NewParticle::at(position, radius, MaterialIndex::new(0))
    }
}

/// A sum of vectors, and of their sizes.
#[derive(Debug, Clone, Copy, Default)]
struct Sum(DVec3, f64);

impl Sum {
    fn add(&mut self, part: DVec3) {
        self.0 += part;
        self.1 += part.length();
    }
}

/// Momentum, angular momentum about 0.
fn momenta(engine: &Engine) -> [Sum; 2] {
    let [mut linear, mut angular] = [Sum::default(); 2];
    for record in &engine.particles.records {
        let momentum = record.velocity / record.inverse_mass;
        linear.add(momentum);
        angular.add(record.position.cross(momentum));
        let inertia = 0.4 * record.radius * record.radius / record.inverse_mass;
        angular.add(record.angular_velocity * inertia);
    }
    for surface in engine.surfaces() {
        for k in 0..surface.positions.len() {
            let momentum = surface.velocities[k] / surface.inverse_masses[k];
            linear.add(momentum);
            angular.add(surface.positions[k].cross(momentum));
        }
    }
    [linear, angular]
}

fn at_sheets(seen: &Observation) -> usize {
    let records = seen.records.iter();
    records
        .filter(|record| matches!(record.partner, Partner::Wall { .. }))
        .count()
}

const SEE: Watch = Watch {
    records: true,
    audit: None,
};

/// Balls of many sizes, from both sides.
fn thrown(seed: u64) -> Vec<NewParticle> {
    let mut random = Stream::new(seed, "balls", 0);
    let mut any = || 2.0 * DVec3::new(random.uniform(), random.uniform(), random.uniform()) - 1.0;
    (0..30)
        .map(|k| {
            let radius = [0.001, 0.002, 0.004, 0.008, 0.02][k % 5];
            let side = if k % 2 == 0 { 1.0 } else { -1.0 };
            let at = dvec3(0.06, 0.06, 0.0) + any() * dvec3(0.065, 0.065, 0.002);
            let away = dvec3(0.0, 0.0, side * (radius + 0.004));
            ball(
                at + away,
                radius,
                any() - dvec3(0.0, 0.0, side * 2.0),
                any() * 100.0,
            )
        })
        .collect()
}

#[test]
fn momentum_and_angular_momentum_are_kept_in_every_step() {
    for seed in 1..4 {
        let sheet = square(6, 0.12, 0.15, seed);
        let plan = Setup::default().plan(thrown(seed), vec![sheet]);
        let mut engine = Engine::new(plan, 1).unwrap();
        let first = momenta(&engine);
        let (mut contacts, mut couples) = (0, 0);
        for step in 0..600 {
            engine.step(Some(SEE)).unwrap();
            let seen = engine.take_observation();
            contacts += at_sheets(&seen);
            couples += (seen.records.iter())
                .filter(|record| record.couple != DVec3::ZERO)
                .count();
            let now = momenta(&engine);
            for (kind, (now, first)) in now.iter().zip(&first).enumerate() {
                let off = now.0.distance(first.0);
                let size = first.1.max(now.1);
                assert!(off < 1e-11 * size, "{step}, {kind}: {off:e} of {size:e}");
            }
        }
        assert!(contacts > 1000 && couples > 1000, "{contacts}, {couples}");
    }
}

/// Kinetic energy of particles and sheets, and what contacts store, J; `seen`: of the last step, which must be complete.
fn energy(engine: &Engine, seen: &Observation) -> f64 {
    let mut sum = seen.elastic_energy;
    for record in &engine.particles.records {
        let inertia = 0.4 * record.radius * record.radius;
        let squares =
            record.velocity.length_squared() + inertia * record.angular_velocity.length_squared();
        sum += 0.5 * squares / record.inverse_mass;
    }
    for surface in engine.surfaces() {
        let vertices = surface.velocities.iter().zip(&surface.inverse_masses);
        sum += vertices
            .map(|(v, w)| 0.5 * v.length_squared() / w)
            .sum::<f64>();
    }
    sum
}

/// Balls hit a sheet on a face, near an edge and near a corner: the largest error of the energy over the energy, until a contact ends.
fn error_of_bounce(step: f64, laws: &str, normal: &str, spot: usize) -> f64 {
    let setup = Setup {
        step,
        normal,
        laws,
        ..Setup::default()
    };
    let sheet = square(6, 0.12, 0.1, 7);
    let (triangle, weights): (usize, [f64; 3]) = [
        (10, [0.4, 0.3, 0.3]),
        (31, [0.5, 0.5, 0.0]),
        (60, [0.95, 0.03, 0.02]),
    ][spot];
    let corners = sheet.triangles[triangle].map(|k| sheet.vertices[k as usize]);
    let at: DVec3 = (0..3).map(|k| corners[k] * weights[k]).sum();
    let radius = 0.006;
    let thrown = ball(
        at + dvec3(0.0, 0.0, radius + 0.0004),
        radius,
        dvec3(0.2, -0.1, -1.0),
        dvec3(40.0, -60.0, 30.0),
    );
    let plan = setup.plan(vec![thrown], vec![sheet]);
    let mut engine = Engine::new(plan, 1).unwrap();
    let first = energy(&engine, &Observation::empty(0));
    let (mut most, mut contacts, mut touched) = (0.0f64, 0, false);
    for _ in 0..(5e-3 / step).round() as u32 {
        engine.step(Some(SEE)).unwrap();
        let seen = engine.take_observation();
        engine.complete_step().unwrap();
        let touching = at_sheets(&seen);
        // The energy of a friction spring is lost when its contact ends.
        if touched && touching == 0 && !laws.is_empty() {
            break;
        }
        touched = touching > 0;
        most = most.max((energy(&engine, &seen) - first).abs());
        contacts += touching;
    }
    assert!(contacts as f64 * step > 5e-4, "{contacts}");
    most / first
}

const LINEAR: &str = r#"{ law = "linear", stiffness = 500.0, dissipation = 0.0 }"#;
const STICKING: &str =
    r#"tangential = { law = "linear", stiffness_ratio = 0.2857, friction = 1e9 }"#;

/// The sheet bends around the ball: contacts come and go beside the first one, and nothing is lost with them.
#[test]
fn elastic_bounces_close_the_energy_with_order_two() {
    for spot in 0..3 {
        let errors = [4e-6, 2e-6, 1e-6].map(|step| error_of_bounce(step, "", LINEAR, spot));
        assert!(errors[0] < 1e-5, "{spot}: {errors:?}");
        // Begin and end of a contact fall somewhere within a step: one pair of steps proves little. At the corner forces turn at
        // once where contacts change their order.
        let order = (errors[0] / errors[2]).log2() / 2.0;
        let least = if spot == 2 { 1.2 } else { 1.7 };
        assert!(order > least, "{spot}: {errors:?}");
    }
}

/// With springs of friction that never slide: they begin to stretch within a step, which makes an error of first order.
#[test]
fn sticking_bounces_close_the_energy() {
    for spot in 0..3 {
        let errors = [4e-6, 1e-6].map(|step| error_of_bounce(step, STICKING, LINEAR, spot));
        assert!(
            errors.iter().all(|&error| error < 1e-3),
            "{spot}: {errors:?}"
        );
    }
}

/// A ball of twenty edges rolls over a flat sheet that is held: it has one contact in every step, of an even force, and slides over edges as over faces.
#[test]
fn a_large_ball_on_a_flat_sheet_has_one_contact() {
    let mut sheet = square(40, 0.2, 0.0, 0);
    // In its plane the corners are anywhere.
    let mut random = Stream::new(5, "skew", 0);
    for at in &mut sheet.vertices {
        let way = DVec3::new(random.uniform() - 0.5, random.uniform() - 0.5, 0.0);
        *at += way * 0.2 * 0.005;
    }
    sheet.masses.fill(f64::INFINITY);
    let (radius, overlap) = (0.1, 1e-4);
    let height = radius + 0.5 * THICKNESS - overlap;
    let rolling = ball(
        dvec3(0.05, 0.06, height),
        radius,
        dvec3(0.5, 0.4, 0.0),
        dvec3(-0.4, 0.5, 0.0) / height,
    );
    // So heavy that the spring hardly moves it.
    let setup = Setup {
        laws: r#"tangential = { law = "linear", stiffness_ratio = 0.2857, friction = 0.5 }"#,
        normal: r#"{ law = "linear", stiffness = 5.0, dissipation = 0.0 }"#,
        ..Setup::default()
    };
    let mut engine = Engine::new(setup.plan(vec![rolling], vec![sheet]), 1).unwrap();
    let mut features = std::collections::BTreeSet::new();
    let mut last = 5.0 * overlap;
    for step in 0..4_000 {
        engine.step(Some(SEE)).unwrap();
        let seen = engine.take_observation();
        assert_eq!(seen.records.len(), 1, "{step}");
        let record = &seen.records[0];
        features.insert(record.feature);
        let force = record.force.z;
        assert!(
            (force - last).abs() < 1e-3 * last,
            "{step}: {last} to {force}"
        );
        assert!(
            record.tangential.length() < 1e-3 * force,
            "{step}: {record:?}"
        );
        last = force;
    }
    assert!(features.len() > 8, "{}", features.len());
}

/// A ball of twenty edges flies into a free sheet, which bends around it: momenta, and without losses the energy.
#[test]
fn a_sheet_bends_around_a_large_ball() {
    for (laws, normal, bound) in [("", LINEAR, 2e-4), (FRICTION, HARD, f64::INFINITY)] {
        let mut sheet = square(12, 0.06, 0.1, 4);
        for at in &mut sheet.vertices {
            *at -= dvec3(0.03, 0.03, 0.0);
        }
        let radius = 0.1;
        let at = dvec3(0.001, 0.002, radius + 0.003);
        let thrown = ball(at, radius, dvec3(0.1, 0.0, -2.0), dvec3(3.0, 1.0, 0.0));
        let setup = Setup {
            step: 2e-6,
            laws,
            normal,
            ..Setup::default()
        };
        let mut engine = Engine::new(setup.plan(vec![thrown], vec![sheet]), 1).unwrap();
        let (first, start) = (momenta(&engine), energy(&engine, &Observation::empty(0)));
        let mut most_contacts = 0;
        for step in 0..3_000 {
            engine.step(Some(SEE)).unwrap();
            let seen = engine.take_observation();
            engine.complete_step().unwrap();
            most_contacts = most_contacts.max(at_sheets(&seen));
            for (now, first) in momenta(&engine).iter().zip(&first) {
                let size = first.1.max(now.1);
                assert!(now.0.distance(first.0) < 1e-11 * size, "{step}");
            }
            let off = (energy(&engine, &seen) - start) / start;
            assert!(off < bound.min(1e-3), "{step}: {off:e}");
            assert!(-off < bound, "{step}: {off:e}");
        }
        assert!(most_contacts > 3, "{most_contacts}");
    }
}

/// Laws whose contacts count by a part where they join: momenta of a ball in a sheet that bends around it are kept in every step, and the audit lacks
/// no more than by the theory page.
#[test]
fn plastic_and_wet_contacts_join() {
    const PLASTIC: &str = r#"{ law = "plastic", loading_stiffness = 200.0, unloading_stiffness = 800.0, cohesion_stiffness = 50.0, penetration_depth = 0.05, dissipation = 1e-3 }"#;
    const WILLETT: &str = r#"liquid = { law = "willett", surface_tension = 0.07, contact_angle_degrees = 20.0, max_bridge_volume = 1e-10 }"#;
    const BAGHERI: &str = r#"liquid = { law = "bagheri", surface_tension = 0.07, contact_angle_degrees = 20.0, viscosity = 1e-3, max_bridge_volume = 1e-10 }"#;
    for (name, normal, laws, film, bound) in [
        ("plastic", PLASTIC, "", 0.0, 1e-6),
        ("plastic with friction", PLASTIC, FRICTION, 0.0, 1e-6),
        ("wet", LINEAR, WILLETT, 1e-8, 1e-2),
        ("wet and viscous", HARD, BAGHERI, 1e-8, 1e-2),
    ] {
        let mut sheet = square(12, 0.06, 0.1, 4);
        for at in &mut sheet.vertices {
            *at -= dvec3(0.03, 0.03, 0.0);
        }
        let (radius, at) = (0.1, dvec3(0.001, 0.002, 0.103));
        let thrown = ball(at, radius, dvec3(0.1, 0.0, -2.0), dvec3(3.0, 1.0, 0.0));
        let setup = Setup {
            step: 2e-6,
            laws,
            normal,
            output: "interval = 0.1, energy_budget = true",
            ..Setup::default()
        };
        let plan = setup.plan_of(|draft| {
            draft.particles = vec![thrown];
            draft.plans.insert(limp(sheet));
            if film > 0.0 {
                draft.start_values.push(StartValues {
                    particles: vec![(0, film)],
                    ..StartValues::new(&FILM_VOLUME)
                });
            }
        });
        let mut engine = Engine::new(plan, 1).unwrap();
        let seen = engine.take_observation();
        let (first, start) = (momenta(&engine), energy(&engine, &seen));
        let (mut most_contacts, mut most) = (0, 0.0f64);
        for step in 0..3_000 {
            engine.step(Some(SEE)).unwrap();
            let seen = engine.take_observation();
            engine.complete_step().unwrap();
            most_contacts = most_contacts.max(at_sheets(&seen));
            for (now, first) in momenta(&engine).iter().zip(&first) {
                let size = first.1.max(now.1);
                let off = now.0.distance(first.0);
                assert!(off < 1e-11 * size, "{name}, {step}: {off:e} of {size:e}");
            }
            let lacks = energy(&engine, &seen) + engine.audit().losses.total() - start;
            most = most.max((lacks / start).abs());
        }
        assert!(most_contacts > 3, "{name}: {most_contacts}");
        assert!(most < bound, "{name}: {most:e}");
    }
}

const HARD: &str = r#"{ law = "linear", stiffness = 500.0, restitution = 0.6 }"#;

/// Both faces push a ball away, and a sheet with a front only that one; from behind a ball passes.
#[test]
fn faces_act_as_they_are_planned() {
    let passes = |faces: Faces, from: f64| {
        let mut sheet = square(4, 0.08, 0.1, 9);
        sheet.faces = faces;
        sheet.masses.fill(f64::INFINITY);
        let at = dvec3(0.041, 0.043, from * 0.02);
        let thrown = ball(at, 0.01, dvec3(0.0, 0.0, -from), DVec3::ZERO);
        let plan = Setup::default().plan(vec![thrown], vec![sheet]);
        let mut engine = Engine::new(plan, 1).unwrap();
        engine.steps_at_once(4000, None).unwrap();
        engine.complete_step().unwrap();
        let [record] = &engine.particles.records[..] else {
            panic!("one ball");
        };
        record.velocity.z * from < 0.0
    };
    assert!(!passes(Faces::Both, 1.0));
    assert!(!passes(Faces::Both, -1.0));
    assert!(!passes(Faces::Front, 1.0));
    assert!(
        !passes(Faces::Front, -1.0),
        "what begins behind is pushed back behind"
    );
}

/// Pebbles of a clump and a particle whose motion is prescribed push a sheet; momentum of clump and sheet is kept.
#[test]
fn clumps_and_prescribed_particles_push_sheets() {
    let material = MaterialIndex::new(0);
    let (radius, apart) = (0.004, 0.003);
    let pebbles = [-apart, apart].map(|x| Pebble {
        position: dvec3(x, 0.0, 0.0),
        radius,
    });
    // Mass and moments of about such a rod.
    let (mass, moments) = (4e-4, dvec3(2.6e-9, 6e-9, 6e-9));
    let rod = Clump::new("rod", material, pebbles.to_vec(), mass, 4e-7, moments);
    let body = NewBody {
        velocity: dvec3(0.3, 0.1, -1.5),
        angular_velocity: dvec3(10.0, 50.0, 3.0),
        ..NewBody::at(dvec3(0.05, 0.06, 0.006), 0)
    };
    let plan = Setup::default().plan_of(|draft| {
        draft.particles.clear();
        draft.clumps = vec![rod.unwrap()];
        draft.bodies = vec![body];
        draft.plans.insert(limp(square(6, 0.12, 0.1, 3)));
    });
    let mut engine = Engine::new(plan, 1).unwrap();
    let sums = |engine: &Engine| {
        let (mut linear, mut angular) = (Sum::default(), Sum::default());
        let bodies = engine.particles.bodies.as_ref().unwrap();
        for body in &bodies.all {
            linear.add(body.velocity * body.mass);
            angular.add(body.position.cross(body.velocity * body.mass));
            angular.add(body.angular_momentum);
        }
        let surface = &engine.surfaces()[0];
        for (k, at) in surface.positions.iter().enumerate() {
            let momentum = surface.velocities[k] / surface.inverse_masses[k];
            linear.add(momentum);
            angular.add(at.cross(momentum));
        }
        [linear, angular]
    };
    let (first, mut contacts) = (sums(&engine), 0);
    for step in 0..2000 {
        engine.step(Some(SEE)).unwrap();
        contacts += at_sheets(&engine.take_observation());
        for (now, first) in sums(&engine).iter().zip(&first) {
            assert!(
                now.0.distance(first.0) < 1e-11 * first.1.max(now.1),
                "{step}"
            );
        }
    }
    assert!(contacts > 100, "{contacts}");

    let setup = Setup {
        more: r#"
        [[particles]]
        material = "m"
        radius = 0.01
        position = [0.06, 0.06, 0.0105]
        prescribed = { velocity = [0.0, 0.0, -1.0] }"#,
        ..Setup::default()
    };
    let particles = setup.scene_particles();
    let plan = setup.plan(particles, vec![square(6, 0.12, 0.0, 3)]);
    let mut engine = Engine::new(plan, 1).unwrap();
    engine.steps_at_once(600, None).unwrap();
    let lowest = engine.surfaces()[0]
        .velocities
        .iter()
        .map(|v| v.z)
        .fold(0.0, f64::min);
    assert!(lowest < -0.9, "{lowest}");
}

/// One thread, two threads, and a run that is stopped and goes on, give the same bytes; so do steps that are looked at.
#[test]
fn threads_and_resumes_change_nothing() {
    let plan = || {
        let mut balls = thrown(1);
        // More rows than a block has.
        let mut random = Stream::new(8, "crowd", 0);
        let mut any = || DVec3::new(random.uniform(), random.uniform(), random.uniform());
        balls.extend((0..3000).map(|_| {
            let at = any() * dvec3(0.12, 0.12, 0.02) + dvec3(0.0, 0.0, 0.0015);
            ball(
                at,
                0.0008,
                dvec3(0.0, 0.0, -2.0) + any() * 0.3,
                any() * 20.0,
            )
        }));
        Setup::default().plan(
            balls,
            vec![square(6, 0.12, 0.1, 1), {
                let mut other = square(5, 0.1, 0.1, 2);
                other.vertices.iter_mut().for_each(|at| at.z -= 0.02);
                other
            }],
        )
    };
    let plan = plan();
    let mut one = Engine::new(Arc::clone(&plan), 1).unwrap();
    let mut two = Engine::new(Arc::clone(&plan), 2).unwrap();
    let mut resumed = Engine::new(Arc::clone(&plan), 1).unwrap();
    for round in 0..6 {
        for _ in 0..49 {
            one.step(None).unwrap();
        }
        one.step(Some(SEE)).unwrap();
        two.steps_at_once(50, Some(SEE)).unwrap();
        resumed.steps_at_once(50, None).unwrap();
        let bytes = resumed.snapshot().encode();
        let snapshot = Snapshot::decode(&bytes).unwrap();
        resumed = Engine::restore(Arc::clone(&plan), snapshot, 1 + round % 2).unwrap();
        let expected = one.snapshot().encode();
        assert!(expected == two.snapshot().encode(), "two threads, {round}");
        assert!(expected == resumed.snapshot().encode(), "resumed, {round}");
    }
    assert!(
        one.surfaces()
            .iter()
            .any(|s| s.loads.iter().any(|load| *load != DVec3::ZERO))
    );
}

/// With losses, the audit closes: what is lost is what kinetic and stored energy lack.
#[test]
fn the_audit_closes_with_losses() {
    let lacks = |step: f64| {
        let setup = Setup {
            step,
            output: "interval = 0.1, energy_budget = true",
            ..Setup::default()
        };
        let plan = setup.plan(thrown(3), vec![square(6, 0.12, 0.1, 3)]);
        let mut engine = Engine::new(plan, 1).unwrap();
        let seen = engine.take_observation();
        let start = energy(&engine, &seen);
        engine
            .steps_at_once((3e-3 / step).round() as u64, Some(SEE))
            .unwrap();
        let seen = engine.take_observation();
        engine.complete_step().unwrap();
        let audit = engine.audit();
        assert!(audit.losses.total() > 0.02 * start, "{audit:?}");
        assert!(audit.wall_work.abs() < 1e-12 * start, "{audit:?}");
        (energy(&engine, &seen) + audit.losses.total() - start).abs() / start
    };
    let [coarse, fine] = [lacks(4e-6), lacks(1e-6)];
    assert!(coarse < 2e-3 && fine < 1e-3, "{coarse:e}, {fine:e}");
}

/// Lists follow a sheet that moves faster than the particles: nothing is missed.
#[test]
fn fast_sheets_meet_resting_particles() {
    let mut random = Stream::new(8, "rest", 0);
    let mut any = || DVec3::new(random.uniform(), random.uniform(), random.uniform());
    let balls: Vec<NewParticle> = (0..200)
        .map(|_| {
            ball(
                any() * dvec3(0.1, 0.1, 0.05),
                0.001,
                DVec3::ZERO,
                DVec3::ZERO,
            )
        })
        .collect();
    let mut sheet = square(4, 0.12, 0.0, 1);
    for at in &mut sheet.vertices {
        *at += dvec3(-0.01, -0.01, -0.01);
    }
    let plan = Setup::default().plan_of(|draft| {
        draft.particles = balls;
        draft.plans.insert(carried(sheet, dvec3(0.0, 0.0, 10.0)));
    });
    let mut engine = Engine::new(plan, 1).unwrap();
    engine.steps_at_once(700, None).unwrap();
    let front = engine.surfaces()[0].positions[0].z;
    assert!(front > 0.05);
    for record in &engine.particles.records {
        assert!(record.position.z > front, "{record:?} at {front}");
    }
}

/// A sheet that moves far from all particles costs no lists: it uses up the gap between them first. Where it comes from afar it meets them as ever.
#[test]
fn a_sheet_far_away_wears_no_list_out() {
    let places = (0..216).map(|k| dvec3(f64::from(k % 6), f64::from(k / 6 % 6), f64::from(k / 36)));
    let balls: Vec<NewParticle> = places
        .map(|place| ball(0.015 * place, 0.001, DVec3::ZERO, DVec3::ZERO))
        .collect();
    let lists = |height: f64, periodic: &str| {
        let mut sheet = square(4, 0.12, 0.0, 1);
        for at in &mut sheet.vertices {
            *at += dvec3(-0.01, -0.01, height);
        }
        let setup = Setup {
            periodic,
            ..Setup::default()
        };
        let plan = setup.plan_of(|draft| {
            draft.particles = balls.clone();
            draft.plans.insert(carried(sheet, dvec3(0.0, 0.0, 10.0)));
        });
        let mut engine = Engine::new(plan, 1).unwrap();
        let start = engine.list_statistics().0;
        // It goes 0.1 m; the skin of balls at rest is a few hundredths of their millimetre.
        engine.steps_at_once(1000, None).unwrap();
        let front = engine.surfaces()[0].positions[0].z;
        let above = |z: f64| height > 0.1 || z > front || front < 0.0;
        assert!(
            engine
                .particles
                .records
                .iter()
                .all(|ball| above(ball.position.z))
        );
        engine.list_statistics().0 - start
    };
    assert_eq!(lists(-0.5, "[]"), 0);
    assert_eq!(lists(0.3, "[]"), 0);
    // Through the periodic face: it stands below all balls, and above their images by 1.6 m.
    assert_eq!(lists(-0.5, "[\"z\"]"), 0);
    // From 20 mm below them it comes to push them.
    assert!(lists(-0.02, "[]") > 5);
}

/// Vertices bounce on a floor as spheres of half the thickness: they stay above it, the wall feels what they get, and energy is kept.
#[test]
fn vertices_touch_walls() {
    let mut sheet = square(4, 0.04, 0.1, 2);
    sheet.touches_walls = true;
    sheet.thickness = 2e-3;
    sheet.vertices.iter_mut().for_each(|at| at.z += 0.003);
    let count = sheet.vertices.len();
    let setup = Setup {
        step: 1e-6,
        normal: r#"{ law = "linear", stiffness = 500.0, dissipation = 0.0 }"#,
        laws: "",
        output: "interval = 0.1, energy_budget = true, walls = true",
        more: r#"
        [[walls]]
        name = "floor"
        material = "m"
        shape = "plane"
        point = [0.0, 0.0, 0.0]
        normal = [0.0, 0.0, 1.0]"#,
        ..Setup::default()
    };
    let plan = setup.plan(Vec::new(), vec![sheet]);
    let start = |threads| {
        let mut engine = Engine::new(Arc::clone(&plan), threads).unwrap();
        engine.domain.surfaces[0]
            .velocities
            .fill(dvec3(0.0, 0.0, -1.0));
        engine
    };
    let (mut engine, mut resumed) = (start(1), start(1));
    let first = energy(&engine, &Observation::empty(0));
    let (mut pushed, mut lowest, mut most) = (DVec3::ZERO, 1.0f64, 0.0f64);
    for step in 0..6000u32 {
        engine.step(Some(SEE)).unwrap();
        let seen = engine.take_observation();
        let loads: DVec3 = engine.surfaces()[0].loads.iter().sum();
        let felt = seen.walls[0].0.force;
        assert!(
            (felt + loads).length() <= 1e-12 * loads.length(),
            "{felt}, {loads}"
        );
        pushed += loads * 1e-6;
        resumed.step(None).unwrap();
        if step % 1500 == 700 {
            let snapshot = Snapshot::decode(&resumed.snapshot().encode()).unwrap();
            assert!(snapshot == engine.snapshot());
            resumed = Engine::restore(Arc::clone(&plan), snapshot, 2).unwrap();
        }
        let heights = engine.surfaces()[0].positions.iter().map(|at| at.z);
        lowest = heights.fold(lowest, f64::min);
        let seen_energy = seen.elastic_energy;
        // Kinetic energy of the time of the positions, without touching the run.
        if seen_energy == 0.0 {
            most = most.max((energy(&engine, &seen) - first).abs());
        }
    }
    assert!(0.0 < lowest && lowest < 0.001, "{lowest}");
    let upwards = engine.surfaces()[0]
        .velocities
        .iter()
        .filter(|v| v.z > 0.99);
    assert_eq!(upwards.count(), count);
    assert!(most < 1e-4 * first, "{most:e} of {first:e}");
    let momentum: f64 = engine.surfaces()[0]
        .inverse_masses
        .iter()
        .map(|w| 2.0 / w)
        .sum();
    assert!(
        (pushed.z - momentum).abs() < 1e-3 * momentum,
        "{pushed}, {momentum}"
    );
    assert!(engine.snapshot() == resumed.snapshot());
}

/// Walls that act on both sides push vertices back to where they came from, also if their contacts are so soft that they go through: by twice as far as
/// their radius here.
#[test]
fn walls_with_two_sides_hold_vertices() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("floor.obj");
    let corners = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n";
    std::fs::write(&file, format!("{corners}f 1 2 3 4\n")).unwrap();
    let mesh = format!("shape = \"mesh\"\nfile = {file:?}");
    let disc = "shape = \"disc\"\naxis = [0.0, 0.0, 1.0]\norigin = [0.0, 0.0, 0.0]\nradius = 1.0";
    for shape in [&mesh, disc] {
        let mut sheet = square(4, 0.04, 0.1, 2);
        sheet.touches_walls = true;
        sheet.thickness = 2e-3;
        sheet.vertices.iter_mut().for_each(|at| at.z += 0.003);
        let more = format!("[[walls]]\nname = \"floor\"\nmaterial = \"m\"\n{shape}");
        let setup = Setup {
            step: 1e-6,
            normal: r#"{ law = "linear", stiffness = 7.0, dissipation = 0.0 }"#,
            laws: "",
            output: "interval = 0.1, walls = true",
            more: &more,
            ..Setup::default()
        };
        let plan = setup.plan(Vec::new(), vec![sheet]);
        let start = || {
            let mut engine = Engine::new(Arc::clone(&plan), 1).unwrap();
            engine.domain.surfaces[0]
                .velocities
                .fill(dvec3(0.0, 0.0, -1.0));
            engine
        };
        let (mut engine, mut resumed) = (start(), start());
        let lightest = (engine.surfaces()[0].inverse_masses.iter()).fold(0.0f64, |a, b| a.max(*b));
        let mut lowest = 1.0f64;
        for step in 0..20_000u32 {
            engine.step(None).unwrap();
            resumed.step(None).unwrap();
            if step % 2000 == 1000 {
                let snapshot = Snapshot::decode(&resumed.snapshot().encode()).unwrap();
                resumed = Engine::restore(Arc::clone(&plan), snapshot, 2).unwrap();
            }
            let heights = engine.surfaces()[0].positions.iter().map(|at| at.z);
            lowest = heights.fold(lowest, f64::min);
        }
        // The heaviest goes deepest: v sqrt(m/k) below where it begins to touch, and six triangles have six times the mass of one.
        let deepest = 1e-3 - (6.0 / (7.0 * lightest)).sqrt();
        assert!(
            (2.0 * deepest..-1e-3).contains(&lowest),
            "{lowest}, {deepest}"
        );
        for velocity in &engine.surfaces()[0].velocities {
            // Step and period give an error of (omega dt)^2/24, of less than 1e-5.
            assert!((velocity.z - 1.0).abs() < 1e-3, "{velocity}");
        }
        assert!(engine.snapshot() == resumed.snapshot());
    }
}

/// Two balls that press on a sheet from either side, by more than its thickness: each feels a plane at half the thickness, and nothing of the other one, in the
/// domain and across its faces. Beside the sheet they feel each other.
#[test]
fn a_sheet_separates_what_touches_it_from_either_side() {
    const HERTZ: &str =
        r#"{ law = "hertz", youngs_modulus = 1e6, poisson_ratio = 0.3, restitution = 1.0 }"#;
    let (radius, overlap) = (0.004, 2e-4);
    for (periodic, height) in [("[]", 0.0), (r#"["z"]"#, 1.0)] {
        let setup = Setup {
            laws: "",
            normal: HERTZ,
            periodic,
            ..Setup::default()
        };
        let mut sheet = square(7, 0.03, 0.0, 0);
        for at in &mut sheet.vertices {
            at.z += height;
        }
        sheet.masses.fill(f64::INFINITY);
        let away = dvec3(0.0, 0.0, radius + 0.5 * THICKNESS - overlap);
        // Half their distance is less than their radius.
        assert!(away.z < radius);
        // On a face, on an edge, on a corner, anywhere.
        let cell = 0.03 / 7.0;
        let places = [(3.6, 3.3), (3.5, 3.5), (3.0, 3.0), (4.1, 2.0)];
        for (x, y) in places {
            let at = dvec3(x * cell, y * cell, height);
            let mut balls =
                [at + away, at - away].map(|at| ball(at, radius, DVec3::ZERO, DVec3::ZERO));
            balls[1].position.z -= 2.0 * height;
            let plan = setup.plan(balls.to_vec(), vec![sheet.clone()]);
            let mut engine = Engine::new(plan, 1).unwrap();
            let seen = engine.take_observation();
            assert_eq!(seen.records.len(), 2, "{periodic}, {at}");
            // Hertz at a plane: 4/3 E* sqrt(R) delta^(3/2), E* = E/(2 (1 - nu^2)).
            let modulus = 1e6 / (2.0 * (1.0 - 0.09));
            let force = 4.0 / 3.0 * modulus * radius.sqrt() * overlap.powf(1.5);
            for (load, side) in engine.particles.loads.iter().zip([1.0, -1.0]) {
                let expected = dvec3(0.0, 0.0, side * force);
                // Places of 1 m are known to 2e-16 m, of an overlap of 2e-4 m.
                let error = load.force.distance(expected) / force;
                assert!(
                    error < 1e-11,
                    "{periodic}, {at}: {} for {force}",
                    load.force
                );
            }
        }
        // Beside it.
        let at = dvec3(-0.0045, 0.01, height);
        let mut balls = [at + away, at - away].map(|at| ball(at, radius, DVec3::ZERO, DVec3::ZERO));
        balls[1].position.z -= 2.0 * height;
        let plan = setup.plan(balls.to_vec(), vec![sheet]);
        let mut engine = Engine::new(plan, 1).unwrap();
        let seen = engine.take_observation();
        assert_eq!(seen.records.len(), 1, "{periodic}");
        assert!(matches!(seen.records[0].partner, Partner::Particle { .. }));
    }
}

/// A sheet that comes between two wet grains takes their bridge apart: all of its liquid goes back to their films.
#[test]
fn a_sheet_takes_a_bridge_apart() {
    const WILLETT: &str = r#"liquid = { law = "willett", surface_tension = 0.07, contact_angle_degrees = 20.0, max_bridge_volume = 1e-12 }"#;
    let setup = Setup {
        laws: WILLETT,
        normal: LINEAR,
        ..Setup::default()
    };
    let (radius, film) = (1e-3, 1e-12);
    let mut sheet = square(4, 0.02, 0.0, 0);
    for at in &mut sheet.vertices {
        *at += dvec3(0.002, -0.01, 0.0);
    }
    let plan = setup.plan_of(|draft| {
        draft.particles = [1.0, -1.0]
            .map(|side| {
                let at = dvec3(0.0, 0.0, side * (radius - 1e-6));
                ball(at, radius, DVec3::ZERO, DVec3::ZERO)
            })
            .to_vec();
        draft.plans.insert(carried(sheet, dvec3(-2.0, 0.0, 0.0)));
        draft.start_values.push(StartValues {
            particles: vec![(0, film), (1, film)],
            ..StartValues::new(&FILM_VOLUME)
        });
    });
    let mut engine = Engine::new(plan, 1).unwrap();
    let films = |engine: &Engine| -> f64 {
        let films = engine.particles.columns.get(FILM_VOLUME.name).unwrap();
        films.iter().sum()
    };
    let bridges = |engine: &Engine, of_pairs: bool| -> f64 {
        let is_pair = |partner: &Partner| matches!(partner, Partner::Particle { .. });
        let bridges = engine.bridges().into_iter();
        let own = bridges.filter(|bridge| is_pair(&bridge.partner) == of_pairs);
        own.map(|bridge| bridge.memory.volume).sum()
    };
    assert!(bridges(&engine, true) > 0.1 * film);
    for _ in 0..200 {
        engine.step(None).unwrap();
        let all = films(&engine) + bridges(&engine, true) + bridges(&engine, false);
        assert!((all - 2.0 * film).abs() < 1e-12 * film, "{all:e}");
    }
    assert_eq!(bridges(&engine, true), 0.0);
}

/// A sheet of exactly one period: beside its seam, however near, a ball has one contact, with the force of a plane.
#[test]
fn a_ball_beside_a_seam_has_one_contact() {
    let setup = Setup {
        laws: "",
        normal: LINEAR,
        periodic: r#"["x", "y"]"#,
        ..Setup::default()
    };
    let mut sheet = square(8, 2.0, 0.0, 0);
    sheet
        .vertices
        .iter_mut()
        .for_each(|at| *at -= dvec3(1.0, 1.0, 0.0));
    sheet.masses.fill(f64::INFINITY);
    let (radius, overlap) = (0.004, 2e-4);
    let height = radius + 0.5 * THICKNESS - overlap;
    let mut random = Stream::new(3, "offsets", 0);
    let mut offsets = vec![0.0, 1e-9, -1e-9, 1e-7, -1e-7];
    offsets.extend((0..40).map(|k| {
        let size = 10f64.powf(random.uniform_in(-15.0, -3.0));
        if k % 2 == 0 { size } else { -size }
    }));
    for pair in offsets.windows(2) {
        for (x, y) in [(1.0 + pair[0], 0.3), (1.0 + pair[0], 1.0 + pair[1])] {
            let box_of_scene = Cell::new(-DVec3::ONE, DVec3::ONE, [true, true, false]);
            let at = box_of_scene.wrap(dvec3(x, y, height));
            let plan = setup.plan(
                vec![ball(at, radius, DVec3::ZERO, DVec3::ZERO)],
                vec![sheet.clone()],
            );
            let mut engine = Engine::new(plan, 1).unwrap();
            let seen = engine.take_observation();
            assert_eq!(seen.records.len(), 1, "{pair:?}");
            let force = engine.particles.loads[0].force;
            // Places within 1e-9 of the reach are one, so the normal may be tilted by as much.
            let expected = dvec3(0.0, 0.0, 500.0 * overlap);
            let error = force.distance(expected) / expected.z;
            assert!(error < 2e-9, "{pair:?}: {force}");
        }
    }
}

/// The vertices of a large sheet are shared among threads where they touch walls, and its triangles where its mesh follows, to the same bytes, also when
/// the run is stopped meanwhile.
#[test]
fn threads_share_large_sheets() {
    let mut sheet = square(50, 0.1, 0.1, 2);
    sheet.touches_walls = true;
    sheet.thickness = 2e-3;
    sheet.vertices.iter_mut().for_each(|at| at.z += 0.0015);
    assert!(sheet.vertices.len() > 2 * 1024 && sheet.triangles.len() > 4096);
    let above = |ball: &NewParticle| ball.position.z > 0.0;
    let mut balls: Vec<NewParticle> = thrown(1).into_iter().filter(above).collect();
    balls.iter_mut().for_each(|ball| ball.position.z -= 0.001);
    let setup = Setup {
        step: 1e-5,
        output: "interval = 0.1, energy_budget = true, walls = true",
        more: r#"
        [[walls]]
        name = "floor"
        material = "m"
        shape = "plane"
        point = [0.0, 0.0, 0.0]
        normal = [0.0, 0.0, 1.0]"#,
        ..Setup::default()
    };
    let plan = setup.plan(balls, vec![sheet]);
    let start = |threads| {
        let mut engine = Engine::new(Arc::clone(&plan), threads).unwrap();
        let velocities = &mut engine.domain.surfaces[0].velocities;
        velocities.fill(dvec3(0.3, 0.1, -1.0));
        engine
    };
    let [mut one, mut two, mut resumed] = [1, 2, 1].map(start);
    for round in 0..4 {
        one.steps_at_once(40, Some(SEE)).unwrap();
        two.steps_at_once(40, Some(SEE)).unwrap();
        resumed.steps_at_once(40, Some(SEE)).unwrap();
        let snapshot = Snapshot::decode(&resumed.snapshot().encode()).unwrap();
        resumed = Engine::restore(Arc::clone(&plan), snapshot, 2).unwrap();
        let expected = one.snapshot().encode();
        assert!(expected == two.snapshot().encode(), "two threads, {round}");
        assert!(expected == resumed.snapshot().encode(), "resumed, {round}");
        let load = |engine: &Engine| engine.observation().walls[0].0.force;
        assert_eq!(load(&one), load(&two), "{round}");
    }
    assert!((one.surfaces()[0].velocities.iter()).any(|v| v.z > 0.1));
    assert!(at_sheets(&one.observation()) > 0);
}

/// Settings that a sheet cannot be combined with are refused by name.
#[test]
fn scenes_that_sheets_do_not_know_are_refused() {
    let plan = Setup::default().plan(thrown(1), vec![square(2, 0.1, 0.0, 0)]);
    let mut broken = plan.draft();
    Arc::make_mut(&mut broken.plans.all_mut::<MembranePlan>()[0].surface).masses[3] = -1.0;
    let error = broken.plan().unwrap_err().to_string();
    assert!(error.contains("a mass of sheet"), "{error}");
    let mut broken = plan.draft();
    Arc::make_mut(&mut broken.plans.all_mut::<MembranePlan>()[0].surface).triangles[1][2] = 50;
    let error = broken.plan().unwrap_err().to_string();
    assert!(error.contains("vertex 50"), "{error}");
}

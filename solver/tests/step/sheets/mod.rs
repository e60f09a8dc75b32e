//! Contacts of particles with sheets: what the one gets the other loses, in every step.

mod at_walls;
mod conservation;
mod lists;
mod separation;
mod touch;

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

const HARD: &str = r#"{ law = "linear", stiffness = 500.0, restitution = 0.6 }"#;

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

const LINEAR: &str = r#"{ law = "linear", stiffness = 500.0, dissipation = 0.0 }"#;

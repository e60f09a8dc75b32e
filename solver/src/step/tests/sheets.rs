//! Contacts of particles with sheets: what the one gets the other loses, in every step.

use std::path::Path;
use std::sync::Arc;

use glam::{DVec3, dvec3};
use mercury_common::random::Stream;
use mercury_common::scene::Files;

use crate::forces::{Observation, Partner, Watch};
use crate::plan::{NewParticle, Plan, parse_scene, plan};
use crate::state::MaterialIndex;
use crate::step::{Engine, Snapshot};
use crate::surface::tests::square;
use crate::surface::{Faces, SurfacePlan};

const FRICTION: &str = r#"tangential = { law = "linear", stiffness_ratio = 0.2857, friction = 0.5 }
        rolling = { law = "luding", friction = 0.1, dissipation = 1e-3 }
        torsion = { law = "luding", friction = 0.1, dissipation = 1e-3 }"#;

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
    fn plan(&self, particles: Vec<NewParticle>, surfaces: Vec<SurfacePlan>) -> Arc<Plan> {
        let text = format!(
            r#"gravity = [0, 0, 0]
            time = {{ end = 1.0, step = {:e} }}
            domain = {{ min = [-1, -1, -1], max = [1, 1, 1], periodic = {} }}
            output = {{ {} }}
            guard = {{ policy = "off" }}
            {}
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
            radius = 0.01"#,
            self.step, self.periodic, self.output, self.more, self.normal, self.laws
        );
        let scene = parse_scene(Path::new("sheet.toml"), &text, &[], Files::Unchecked);
        let made = scene.and_then(|scene| plan(&scene));
        let mut draft = made.unwrap_or_else(|errors| panic!("{errors}")).draft();
        // Without particles that may meet a scene has no laws.
        draft.particles = particles;
        draft.surfaces = surfaces;
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

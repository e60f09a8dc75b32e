//! Small scenes of soft spheres for tests of sleeping.

use std::path::Path;
use std::sync::Arc;

use mercury_common::scene::Files;
use mercury_engine::state::PEBBLE;
use mercury_engine::step::Engine;
use mercury_solver::plan::{parse_scene, plan};

/// m/s^2
pub const G: f64 = 9.81;
/// Of spheres that stand alone, and the mean of others, m.
pub const R: f64 = 1e-3;
/// Their diameter, m.
pub const D: f64 = 2.0 * R;
/// N/m
pub const STIFFNESS: f64 = 500.0;
/// s; a fourteenth of the contact time of two.
pub const TIME_STEP: f64 = 2e-5;
/// Default of `sleeping.imbalance`.
pub const IMBALANCE: f64 = 0.1;
/// Sizes of beds: no crystals.
const SIZES: &str = r#"psd = { kind = "uniform", min_diameter = 1.8e-3, max_diameter = 2.2e-3, weighting = "number" }"#;
const FRICTION: &str = r#"tangential = { law = "linear", stiffness_ratio = 0.2857, friction = 0.5 }
        rolling = { law = "luding", friction = 0.1, dissipation = 0.01 }"#;

/// Of bodies, which are heavier, so that their springs need a dashpot each.
const DAMPED: &str = r#"tangential = { law = "linear", stiffness_ratio = 0.2857, friction = 0.5, dissipation = 0.02 }
        rolling = { law = "luding", friction = 0.1, dissipation = 0.01 }"#;

/// Of a sphere of radius [`R`], kg.
#[must_use]
pub fn mass() -> f64 {
    2000.0 * 4.0 / 3.0 * std::f64::consts::PI * R.powi(3)
}

/// Of all particles, N.
#[must_use]
pub fn weight(engine: &Engine) -> f64 {
    let particles = &engine.particles;
    let spheres = particles.records.iter().filter(|p| p.flags & PEBBLE == 0);
    let spheres: f64 = spheres.map(|record| 1.0 / record.inverse_mass).sum();
    let bodies: f64 = particles.bodies().iter().map(|body| body.mass).sum();
    G * (spheres + bodies)
}

/// What the walls carry in the watched step just made, N.
#[must_use]
pub fn load_on_walls(engine: &Engine) -> f64 {
    let walls = engine.observation().walls;
    walls.iter().map(|(load, _)| -load.force.z).sum()
}

/// How many sleep, a clump as one; `None` where sleeping is not enabled.
#[must_use]
pub fn asleep(engine: &Engine) -> Option<u64> {
    Some(engine.sleepers()?.0)
}

/// Goes on by so many seconds.
///
/// # Panics
/// If the motion does not stay finite.
pub fn advance_by(engine: &mut Engine, time: f64) {
    let steps = (time / TIME_STEP).round() as u64;
    engine.steps_at_once(steps, None).unwrap();
    engine.complete_step().unwrap();
}

/// A scene over a floor at z = 0, to be completed.
#[derive(Debug, Clone)]
pub struct Scene {
    domain: String,
    floor: String,
    laws: &'static str,
    more: String,
}

impl Scene {
    /// Nothing but the floor, in a wide domain.
    #[must_use]
    pub fn empty() -> Self {
        Self {
            domain: "min = [-0.05, -0.02, -0.05], max = [0.05, 0.02, 0.1]".to_owned(),
            floor: String::new(),
            laws: FRICTION,
            more: String::new(),
        }
    }

    /// A periodic box of 4 by 4 diameters.
    #[must_use]
    pub fn periodic() -> Self {
        Self {
            domain: r#"min = [0, 0, -0.05], max = [0.008, 0.008, 0.1], periodic = ["x", "y"]"#
                .to_owned(),
            ..Self::empty()
        }
    }

    /// `count` spheres fall into it.
    #[must_use]
    pub fn bed(count: u32) -> Self {
        Self::periodic().filled(count, [0.0, 0.008])
    }

    /// Runs it with and without sleepers.
    pub fn both<T>(&self, run: impl Fn(&mut Engine) -> T) -> [T; 2] {
        ["sleeping = {}", ""].map(|sleeping| run(&mut self.start(sleeping)))
    }

    /// `count` spheres fall into a trough that is periodic along y, and ends at x = 0 and, m, at `length`; `keys`: of the wall there.
    #[must_use]
    pub fn trough(length: f64, count: u32, keys: &str) -> Self {
        let mut scene = Self {
            domain: r#"min = [-0.001, 0, -0.05], max = [0.3, 0.008, 0.1], periodic = ["y"]"#
                .to_owned(),
            ..Self::empty()
        }
        .filled(count, [0.0, length]);
        for (at, normal, keys) in [(0.0, 1, ""), (length, -1, keys)] {
            scene = scene.and(&format!(
                "[[walls]]\nshape = \"plane\"\npoint = [{at}, 0, 0]\nnormal = [{normal}, 0, 0]\nmaterial = \"m\"\n{keys}\n"
            ));
        }
        scene
    }

    fn filled(self, count: u32, [from, to]: [f64; 2]) -> Self {
        self.and(&format!(
            r#"
        [[insertions]]
        name = "fill"
        region = {{ shape = "box", min = [{from}, 0, 0.0], max = [{to}, 0.008, 0.03] }}
        material = "m"
        {SIZES}
        total = {{ number = {count} }}
        velocity = {{ mean = [0, 0, -0.1], spread = [0.05, 0.05, 0.05] }}
    "#
        ))
    }

    /// Keys of the floor.
    #[must_use]
    pub fn floor(mut self, keys: &str) -> Self {
        keys.clone_into(&mut self.floor);
        self
    }

    /// The same without friction.
    #[must_use]
    pub fn frictionless(mut self) -> Self {
        self.laws = "";
        self
    }

    /// Periodic along x, from -`half` to `half` (m).
    #[must_use]
    pub fn periodic_x(mut self, half: f64) -> Self {
        self.domain = format!(
            r#"min = [-{half}, -0.02, -0.05], max = [{half}, 0.02, 0.1], periodic = ["x"]"#
        );
        self
    }

    /// Further tables.
    #[must_use]
    pub fn and(mut self, tables: &str) -> Self {
        self.more.push_str(tables);
        self
    }

    /// And so many grains per second from `from` (s) on, over the middle of a bed, until there are `number`.
    #[must_use]
    pub fn rain(self, number: u32, rate: u32, from: f64) -> Self {
        self.and(&format!(
            r#"
            [[insertions]]
            name = "rain"
            region = {{ shape = "box", min = [0.001, 0.001, 0.03], max = [0.007, 0.007, 0.04] }}
            material = "m"
            {SIZES}
            total = {{ number = {number} }}
            rate = {{ number = {rate} }}
            from = {from}
        "#
        ))
    }

    /// And a sphere of radius [`R`] at `place` (m); `keys`: of it.
    #[must_use]
    pub fn sphere(self, place: [f64; 3], keys: &str) -> Self {
        let table = format!(
            "[[particles]]\nmaterial = \"m\"\nradius = {R}\nposition = {place:?}\n{keys}\n"
        );
        self.and(&table)
    }

    /// Eight times as heavy as the others, with the same springs.
    #[must_use]
    pub fn steel(self) -> Self {
        let laws = self.laws;
        self.and(&format!(
            "[materials.steel]\ndensity = 16000.0\nnormal = {{ law = \"linear\", stiffness = {STIFFNESS:?}, restitution = 0.3 }}\n{laws}\n"
        ))
    }

    /// Knows a rod of three spheres of radius [`R`] as the clump `rod` of scale 0.2, and a box of 8 x 24 x 48 mm as `domino`.
    #[must_use]
    pub fn clumps(mut self) -> Self {
        self.laws = DAMPED;
        let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes");
        self.and(&format!(
            "[clumps.rod]\nfile = \"{root}/rod.clump.toml\"\nmaterial = \"m\"\n[clumps.domino]\nfile = \"{root}/clumps/domino.clump.toml\"\nmaterial = \"m\"\n"
        ))
    }

    /// The start of it; `sleeping`: that table, or nothing.
    ///
    /// # Panics
    /// If it is no scene.
    pub fn start(&self, sleeping: &str) -> Engine {
        let text = format!(
            r#"
        seed = 1
        gravity = [0, 0, -{G}]
        {sleeping}
        time = {{ end = 9.0, step = {TIME_STEP} }}
        domain = {{ {} }}
        output = {{ interval = 1.0 }}
        [materials.m]
        density = 2000.0
        normal = {{ law = "linear", stiffness = {STIFFNESS:?}, restitution = 0.3 }}
        {}
        [[walls]]
        name = "floor"
        shape = "plane"
        point = [0, 0, 0]
        normal = [0, 0, 1]
        material = "m"
        {}
        {}
    "#,
            self.domain, self.laws, self.floor, self.more
        );
        let scene = parse_scene(Path::new("sleeping.toml"), &text, &[], Files::Unchecked);
        let scene = scene.unwrap_or_else(|error| panic!("{error}"));
        let plan = plan(&scene).unwrap_or_else(|error| panic!("{error}"));
        Engine::new(Arc::new(plan), 1).unwrap()
    }
}

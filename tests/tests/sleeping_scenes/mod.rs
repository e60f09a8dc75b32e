//! Small scenes of soft spheres for tests of sleeping.

use std::path::Path;
use std::sync::Arc;

use mercury_common::scene::Files;
use mercury_solver::plan::{parse_scene, plan};
use mercury_solver::step::Engine;

pub(crate) const G: f64 = 9.81;
/// Of spheres that stand alone, and the mean of others, m.
pub(crate) const R: f64 = 1e-3;
pub(crate) const D: f64 = 2.0 * R;
/// N/m
pub(crate) const STIFFNESS: f64 = 500.0;
/// s; a fourteenth of the contact time of two.
pub(crate) const TIME_STEP: f64 = 2e-5;
/// Default of `sleeping.imbalance`.
pub(crate) const IMBALANCE: f64 = 0.1;
/// Sizes of beds: no crystals.
pub(crate) const SIZES: &str = r#"psd = { kind = "uniform", min_diameter = 1.8e-3, max_diameter = 2.2e-3, weighting = "number" }"#;
const FRICTION: &str = r#"tangential = { law = "linear", stiffness_ratio = 0.2857, friction = 0.5 }
        rolling = { law = "luding", friction = 0.1, dissipation = 0.01 }"#;

/// Of a sphere of radius [`R`], kg.
pub(crate) fn mass() -> f64 {
    2000.0 * 4.0 / 3.0 * std::f64::consts::PI * R.powi(3)
}

/// Of all particles, N.
pub(crate) fn weight(engine: &Engine) -> f64 {
    let records = engine.particles.records.iter();
    G * records.map(|record| 1.0 / record.inverse_mass).sum::<f64>()
}

/// What the walls carry in the watched step just made, N.
pub(crate) fn load_on_walls(engine: &Engine) -> f64 {
    let walls = engine.observation().walls;
    walls.iter().map(|(load, _)| -load.force.z).sum()
}

pub(crate) fn asleep(engine: &Engine) -> Option<u64> {
    Some(engine.sleepers()?.0)
}

/// Goes on by so many seconds.
pub(crate) fn advance_by(engine: &mut Engine, time: f64) {
    let steps = (time / TIME_STEP).round() as u64;
    engine.steps_at_once(steps, None).unwrap();
    engine.complete_step().unwrap();
}

/// A scene over a floor at z = 0, to be completed.
#[derive(Debug, Clone)]
pub(crate) struct Scene {
    domain: String,
    floor: String,
    laws: &'static str,
    more: String,
}

impl Scene {
    pub(crate) fn empty() -> Self {
        Self {
            domain: "min = [-0.05, -0.02, -0.05], max = [0.05, 0.02, 0.1]".to_owned(),
            floor: String::new(),
            laws: FRICTION,
            more: String::new(),
        }
    }

    /// `count` spheres fall into a periodic box of 4 by 4 diameters.
    pub(crate) fn bed(count: u32) -> Self {
        Self {
            domain: r#"min = [0, 0, -0.05], max = [0.008, 0.008, 0.1], periodic = ["x", "y"]"#
                .to_owned(),
            ..Self::empty()
        }
        .filled(count, [0.0, 0.008])
    }

    /// `count` spheres fall into a trough that is periodic along y, and ends at x = 0 and, m, at `length`; `keys`: of the wall there.
    pub(crate) fn trough(length: f64, count: u32, keys: &str) -> Self {
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
    pub(crate) fn floor(mut self, keys: &str) -> Self {
        keys.clone_into(&mut self.floor);
        self
    }

    pub(crate) fn frictionless(mut self) -> Self {
        self.laws = "";
        self
    }

    pub(crate) fn periodic_x(mut self, half: f64) -> Self {
        self.domain = format!(
            r#"min = [-{half}, -0.02, -0.05], max = [{half}, 0.02, 0.1], periodic = ["x"]"#
        );
        self
    }

    /// Further tables.
    pub(crate) fn and(mut self, tables: &str) -> Self {
        self.more.push_str(tables);
        self
    }

    pub(crate) fn sphere(self, place: [f64; 3], keys: &str) -> Self {
        let table = format!(
            "[[particles]]\nmaterial = \"m\"\nradius = {R}\nposition = {place:?}\n{keys}\n"
        );
        self.and(&table)
    }

    /// Eight times as heavy as the others, with the same springs.
    pub(crate) fn steel(self) -> Self {
        let laws = self.laws;
        self.and(&format!(
            "[materials.steel]\ndensity = 16000.0\nnormal = {{ law = \"linear\", stiffness = {STIFFNESS:?}, restitution = 0.3 }}\n{laws}\n"
        ))
    }

    /// The start of it; `sleeping`: that table, or nothing.
    pub(crate) fn start(&self, sleeping: &str) -> Engine {
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

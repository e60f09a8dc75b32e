//! Wet grains: collisions whose end follows from theory, and the errors of the laws of liquid bridges.

use std::path::Path;
use std::sync::Arc;

use mercury_common::scene::Files;
use mercury_engine::step::{Engine, StartOptions};
use mercury_solver::plan::{Plan, parse_scene, plan};

/// The plan of a scene given as text, with keys replaced.
///
/// # Panics
/// If the scene is wrong.
pub fn planned(text: &str, set: &[&str]) -> Arc<Plan> {
    let set: Vec<String> = set.iter().map(|one| (*one).to_owned()).collect();
    let scene = parse_scene(Path::new("test.toml"), text, &set, Files::MustExist)
        .unwrap_or_else(|errors| panic!("{errors}"));
    Arc::new(plan(&scene).unwrap_or_else(|errors| panic!("{errors}")))
}

/// Its engine, on one thread.
///
/// # Panics
/// If it does not start.
pub fn start(text: &str, set: &[&str]) -> Engine {
    Engine::start(planned(text, set), StartOptions::threads(1)).expect("the scene starts")
}

/// Two wet grains of 1 mm on their way to each other, or one on its way to a wall: Hertz's law with a restitution of 0.8, eta = 0.02 Pa s, films of
/// 6e-11 m3, a roughness of 1 um.
#[derive(Debug, Clone, Copy)]
pub struct WetCollision {
    /// Whether the other one is a wall.
    pub at_wall: bool,
    /// Whether the bridge forms as the films meet, or at the touch.
    pub films: bool,
    /// Surface tension, N/m.
    pub tension: f64,
    /// Relative speed before, m/s.
    pub speed: f64,
}

/// Thickness of the films, m.
const FILM: f64 = 4.752_030_727e-6;

impl WetCollision {
    /// 6 pi eta R*^2/m*, m/s: the speed over it is the Stokes number.
    #[must_use]
    pub fn speed_of_film(&self) -> f64 {
        let (radius, mass) = (1e-3, 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 1e-9);
        let share = if self.at_wall { 1.0 } else { 0.5 };
        6.0 * std::f64::consts::PI * 0.02 * (radius * share) * (radius * share) / (mass * share)
    }

    /// Restitution without tension (Davis et al. 1986; Barnocky & Davis 1988): what the film takes from a rigid pair on the way in and out, 0 below
    /// the critical Stokes number.
    #[must_use]
    pub fn theory(&self) -> f64 {
        let (dry, roughness) = (0.8, 1e-6);
        let (end, first) = if self.at_wall {
            (2.827_570_1e-4, FILM)
        } else {
            (3.274_713_2e-4, 2.0 * FILM)
        };
        let way_in = if self.films {
            dry * (1.0 + f64::ln(first / roughness))
        } else {
            0.0
        };
        let lost = way_in + 1.0 + f64::ln(end / roughness);
        (dry - self.speed_of_film() / self.speed * lost).max(0.0)
    }

    /// The engine at a gap (m).
    #[must_use]
    pub fn start(&self, gap: f64) -> Engine {
        let form = if self.films { "films" } else { "contact" };
        let rest = if self.at_wall {
            "[[walls]]\nname = \"wall\"\nmaterial = \"wet\"\nshape = \"plane\"\npoint = [0, 0, 0]\nnormal = [-1, 0, 0]\n"
        } else {
            "[[particles]]\nmaterial = \"wet\"\nradius = 1e-3\nposition = [1e-3, 0.0, 0.0]\nfilm_volume = 6e-11\n"
        };
        let text = format!(
            r#"
[time]
end = 1.0
step = 1e-7
[domain]
min = [-0.02, -0.02, -0.02]
max = [0.02, 0.02, 0.02]
[liquid]
bridges_form = "{form}"
[materials.wet]
density = 2500.0
normal = {{ law = "hertz", youngs_modulus = 1e7, poisson_ratio = 0.3, restitution = 0.8 }}
liquid = {{ law = "bagheri", surface_tension = {}, contact_angle_degrees = 20.0, viscosity = 0.02, max_bridge_volume = 2e-11, roughness = 1e-6 }}
[[particles]]
material = "wet"
radius = 1e-3
position = [{}, 0.0, 0.0]
velocity = [{}, 0.0, 0.0]
film_volume = 6e-11
{rest}
[output]
interval = 0.01
"#,
            self.tension,
            -1e-3 - gap,
            self.speed
        );
        start(&text, &[])
    }

    /// Restitution; 0 where the two hold together for 0.1 s.
    ///
    /// # Panics
    /// If a step fails.
    #[must_use]
    pub fn restitution(&self) -> f64 {
        let mut engine = self.start(1.2e-5);
        while engine.time() < 0.1 {
            if engine.liquid().is_some_and(|row| row.balance.ruptured > 0) {
                engine.complete_step().expect("numbers");
                let velocity = |row: usize| {
                    let record = engine.particles.records.get(row);
                    record.map_or(0.0, |record| record.velocity.x)
                };
                return (velocity(1) - velocity(0)) / self.speed;
            }
            engine.steps_at_once(10, None).expect("numbers");
        }
        0.0
    }
}

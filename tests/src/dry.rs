//! A sticky sphere and a wall, T28.

use std::f64::consts::PI;

use mercury_engine::step::Engine;

use crate::wet::start;

/// A sphere of 0.1 mm on its way to a wall of its material, of T28.
pub fn ball(speed: f64, wall: &str, set: &[&str]) -> Engine {
    let text = format!(
        r#"
time = {{ end = 1.0, step = 5e-10 }}
domain = {{ min = [-1e-2, -1e-2, -1e-2], max = [1e-2, 1e-2, 1e-2] }}
output = {{ interval = 1.0, energy_budget = true }}
[materials.powder]
density = 1500.0
normal = {{ law = "hertz", youngs_modulus = 1e8, poisson_ratio = 0.3, restitution = 1.0 }}
adhesion = {{ law = "jkr", work_of_adhesion = 0.05 }}
[[walls]]
name = "plate"
material = "powder"
{wall}
[[particles]]
material = "powder"
radius = 1e-4
position = [0.0, 0.0, 1.0005e-4]
velocity = [0.0, 0.0, {:?}]
"#,
        -speed
    );
    start(&text, set)
}

/// The wall of most tests.
pub const PLANE: &str = "shape = \"plane\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]";
/// Speed below which the sphere sticks, √(2 W_s/m), m/s.
pub const STICKS: f64 = 0.022180988;
/// Energy that a touch and a parting lose, J.
pub const W_S: f64 = 1.545651786e-12;
/// kg
pub const MASS: f64 = 4.0 / 3.0 * PI * 1e-12 * 1500.0;

/// m/s, away from the wall.
pub fn velocity(engine: &Engine) -> f64 {
    engine.particles.records[0].velocity.z
}

/// m
pub fn gap(engine: &Engine) -> f64 {
    engine.particles.records[0].position.z - 1e-4
}

/// Speed after the sphere has parted and flown off; 0 if it has not within 60 us, two periods of the contact.
pub fn rebound(engine: &mut Engine) -> f64 {
    while engine.time() < 6e-5 {
        engine.steps_at_once(500, None).expect("numbers");
        if gap(engine) > 2e-7 && velocity(engine) > 0.0 {
            return velocity(engine);
        }
    }
    0.0
}

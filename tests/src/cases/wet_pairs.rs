//! T25: contacts that are observed in every step belong to their own particles.

use mercury_engine::forces::Partner;
use mercury_engine::lanes::Width;
use mercury_engine::step::{Engine, StartOptions};

use super::Case;
use super::Tolerance::Absolute;
use crate::scenes::RECORDS;
use crate::wet::planned;

/// Two pairs of wet grains 20 mm apart, one along x and one along y, of one material. One pair touches while the other is bridged across a gap, so that
/// both lie in one chunk of contacts and follow different branches of the law.
const TWO_PAIRS: &str = r#"
time = { end = 0.01, step = 2e-6 }
domain = { min = [-0.01, -0.01, -0.01], max = [0.03, 0.01, 0.01] }
output = { interval = 0.01 }
[materials.wet]
density = 2500.0
normal = { law = "linear", stiffness = 100.0, restitution = 0.9 }
liquid = { law = "bagheri", surface_tension = 0.07, contact_angle_degrees = 10.0, max_bridge_volume = 1e-12 }
[[particles]]
material = "wet"
radius = 1e-3
position = [-0.999e-3, 0.0, 0.0]
velocity = [-0.02, 0.0, 0.0]
film_volume = 1e-12
[[particles]]
material = "wet"
radius = 1e-3
position = [0.999e-3, 0.0, 0.0]
velocity = [0.02, 0.0, 0.0]
film_volume = 1e-12
[[particles]]
material = "wet"
radius = 1e-3
position = [0.02, -0.998e-3, 0.0]
velocity = [0.0, -0.01, 0.0]
film_volume = 1e-12
[[particles]]
material = "wet"
radius = 1e-3
position = [0.02, 0.998e-3, 0.0]
velocity = [0.0, 0.01, 0.0]
film_volume = 1e-12
"#;

/// Rows of T25.
pub(super) fn cases() -> Vec<Case> {
    vec![
        Case::new(
            "T25 engine: two wet pairs observed in every step, largest distance of a grain from the line of its pair (m)",
            0.0,
            // Every component of the forces across the line is a product with 0.
            Absolute(0.0),
            "nothing acts across",
            || measured()[0],
        ),
        Case::new(
            "T25 engine: two wet pairs observed in every step, largest difference of a recorded overlap from that of the positions (m)",
            0.0,
            // Some rounding errors of numbers below 0.03 m.
            Absolute(1e-17),
            "R_A + R_B - |x_A - x_B|",
            || measured()[1],
        ),
    ]
}

/// The distance from the lines and the difference of the overlaps, m, over 5,000 steps in the most lanes of this processor.
fn measured() -> [f64; 2] {
    let options = StartOptions::threads(1).width(Some(Width::fastest()));
    let mut engine = Engine::start(planned(TWO_PAIRS, &[]), options).expect("the scene starts");
    let (mut off_line, mut difference) = (0.0f64, 0.0f64);
    for _ in 0..5000 {
        engine.step(RECORDS).expect("numbers");
        let particles = &engine.particles.records;
        for particle in particles {
            let at = particle.position;
            let off = if at.x < 0.01 { at.y } else { at.x - 0.02 };
            off_line = off_line.max(off.abs());
        }
        for record in engine.observation().records {
            let Partner::Particle { row, .. } = record.partner else {
                continue;
            };
            let (a, b) = (&particles[record.row as usize], &particles[row as usize]);
            let overlap = a.radius + b.radius - (a.position - b.position).length();
            difference = difference.max((record.overlap - overlap).abs());
        }
    }
    [off_line, difference]
}

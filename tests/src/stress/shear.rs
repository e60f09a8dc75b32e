//! Dense shear: energy and momentum have to add up over a million steps.

use anyhow::Result;

use super::stage::Stage;
use super::{Check, Found, Length};

pub(super) fn dense(length: Length) -> Result<Found> {
    // The short one is pressed faster.
    let (sets, pressing, steps) = length.pick(
        (
            vec![
                "walls.top.motion=[{kind=\"translation\",velocity=[0.0,0.0,-0.96],until=0.02},{kind=\"translation\",velocity=[0.2,0.0,0.0],from=0.02}]".to_owned(),
            ],
            13_000,
            16_000,
        ),
        (Vec::new(), 100_000, 1_000_000),
    );
    let mut stage = Stage::open("dense-shear", &sets)?;
    let dt = stage.time_step();
    // And on, until the plate runs along.
    stage.go(pressing + 10)?;
    let start = Look::at(&stage);
    let (mut ratio, mut touching) = (0.0f64, 0u64);
    let mut moving = Vec::new();
    let every = steps / length.pick(80, 1000);
    let mut made = 0;
    while made < steps {
        stage.go(every)?;
        made += every;
        let observation = stage.engine.observation();
        for (load, _) in &observation.walls {
            let force = load.force;
            let along = force.truncate().length();
            ratio = ratio.max(along / force.z.abs().max(f64::MIN_POSITIVE));
        }
        let energies = stage.energies();
        // In the first half the shock of pressing dies away.
        if 2 * made > steps {
            moving.push(energies.kinetic + energies.rotational);
            touching += observation.particle_contacts;
        }
    }
    let end = Look::at(&stage);
    let work = end.work - start.work;
    let lost = end.lost - start.lost;
    let missing = work - lost - (end.energy - start.energy);
    // Each contact is a collision of 50 steps or lasts for longer; the trapezoidal rule and leapfrog err by (ω Δt)² of what passes.
    // π/t_c is the frequency of a pair.
    let omega = (2.0 * 1e4 / (start.mass / 256.0)).sqrt();
    let closure = 2.0 * (omega * dt).powi(2);
    let speed = 0.2;
    let of_the_plate = 0.5 * start.mass * speed * speed;
    Ok(Found {
        checks: vec![
            Check::at_most(
                "work of the plates less dissipation and stored energy, over the work",
                closure,
                missing / work,
                "energy balance; the audit is of second order: 2 (ω Δt)²",
            ),
            Check::at_most(
                "largest friction over pressure of a plate",
                0.8 * (1.0 + 1e-12),
                ratio,
                "Coulomb's limit holds contact by contact, and so for their sum",
            ),
            Check::at_most(
                "trend of the kinetic energy over the second half, in its standard errors",
                STUDENT,
                trend(&moving).max(0.0),
                "flow after the shock of pressing cools or is steady, it does not heat up; Student's t of a slope through ten means, chance 1 in 2000",
            ),
            Check::exactly(
                "spheres that are still there",
                256,
                stage.len() as u64,
                "nothing leaves",
            ),
            Check::exactly(
                "particles that are not a number",
                0,
                u64::from(!stage.is_finite()),
                "no silent NaN",
            ),
        ],
        particles: stage.len(),
        steps: pressing + steps,
        notes: vec![format!(
            "Strain in shear {:.1}; work of the plates {work:.2e} J, {:.1} % of that went into heat, what pressing had stored among it. In the second half {:.2} contacts of a sphere on average; \
             the kinetic energy is {:.2} of that of all spheres at the speed of the plate on average, {:.2} at most: the height does not give way, and what is stored when spheres lock is set free at once.",
            steps as f64 * dt * speed / 0.0128,
            100.0 * lost / work,
            2.0 * touching as f64 / moving.len() as f64 / stage.len() as f64,
            moving.iter().sum::<f64>() / moving.len() as f64 / of_the_plate,
            moving.iter().fold(0.0f64, |most, &energy| most.max(energy)) / of_the_plate,
        )],
    })
}

/// Blocks whose means are taken as independent.
const BLOCKS: usize = 10;
/// Student's t for [`BLOCKS`] - 2 degrees of freedom, exceeded once in 2000.
const STUDENT: f64 = 5.041;

/// The slope of a series through the means of its blocks, over its standard error.
fn trend(series: &[f64]) -> f64 {
    let size = series.len() / BLOCKS;
    let means: Vec<f64> = (series.chunks_exact(size.max(1)).take(BLOCKS))
        .map(|block| block.iter().sum::<f64>() / block.len() as f64)
        .collect();
    let n = means.len() as f64;
    let middle = 0.5 * (n - 1.0);
    let mean = means.iter().sum::<f64>() / n;
    let numbered = || (0..).map(f64::from).zip(&means);
    let squares: f64 = numbered().map(|(k, _)| (k - middle).powi(2)).sum();
    let slope = numbered()
        .map(|(k, y)| (k - middle) * (y - mean))
        .sum::<f64>()
        / squares;
    let left: f64 = numbered()
        .map(|(k, y)| (y - mean - slope * (k - middle)).powi(2))
        .sum();
    slope / (left / (n - 2.0) / squares).sqrt()
}

/// Running sums.
struct Look {
    work: f64,
    lost: f64,
    energy: f64,
    mass: f64,
}

impl Look {
    fn at(stage: &Stage) -> Self {
        let audit = stage.engine.audit();
        let mass = stage.free().map(|(_, mass)| mass).sum();
        Self {
            work: audit.wall_work,
            lost: audit.losses.total(),
            energy: stage.energies().total(),
            mass,
        }
    }
}

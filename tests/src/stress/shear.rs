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
            4_000,
        ),
        (Vec::new(), 100_000, 1_000_000),
    );
    let mut stage = Stage::open("dense-shear", &sets)?;
    let dt = stage.time_step();
    // And on, until the plate runs along.
    stage.go(pressing + 10)?;
    let start = Look::at(&stage);
    let (mut ratio, mut touching, mut looks) = (0.0f64, 0u64, 0u64);
    let mut hottest = 0.0f64;
    let every = steps / length.pick(20, 1000);
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
            hottest = hottest.max(energies.kinetic + energies.rotational);
            touching += observation.particle_contacts;
            looks += 1;
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
                "largest kinetic energy over that of all spheres at the speed of the plate",
                1.0,
                hottest / (0.5 * start.mass * speed * speed),
                "dense flow: what is sheared by the plate is slower than it, and fluctuates less than it moves",
            ),
            Check::within(
                "contacts of a sphere, mean",
                [3.0, 7.0],
                2.0 * touching as f64 / looks as f64 / stage.len() as f64,
                "dense: isostatic packings have 4 (frictional) to 6 (frictionless)",
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
            "Strain in shear {:.1}; work of the plates {work:.2e} J, of which {:.1} % went into heat.",
            steps as f64 * dt * speed / 0.0128,
            100.0 * lost / work
        )],
    })
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
            lost: audit.dissipated(),
            energy: stage.energies().total(),
            mass,
        }
    }
}

//! A packing of 2,000 spheres: the energy after a few steps, as two other programs give it.

use std::path::Path;

use anyhow::Result;
use glam::DVec3;
use mercury_common::formats::particle_csv::read_particle_csv;
use mercury_solver::contact::normal::{effective_modulus, effective_shear_modulus, hertz_damping};
use mercury_solver::contact::{AnyNormal, AnyRolling, AnyTangential, Hertz, Mindlin, PairLaw};
use mercury_solver::plan::{NewParticle, Plan};

use super::comparison::{Comparison, Tally, Tolerance};
use super::run::{energies, observe, plane};

/// The scene `scenes/bench/dense-2k.toml`, by hand.
fn plan() -> Result<Plan> {
    let bead = (1e7, 0.25);
    let damping = hertz_damping(0.5);
    let law = PairLaw {
        normal: AnyNormal::Hertz(Hertz::new(effective_modulus(bead, bead), damping)),
        // gamma_t = sqrt(2/3) beta_n (Thornton et al. 2023, eq. 4.8)
        tangential: AnyTangential::Mindlin(Mindlin::new(
            effective_shear_modulus(bead, bead),
            1.0,
            (2.0f64 / 3.0).sqrt() * damping,
            0.5,
            0.5,
        )),
        rolling: AnyRolling::None,
    };
    let corner = DVec3::new(0.048, 0.048, 0.07744);
    let mut plan = Plan::bare(3e-5, (DVec3::ZERO, corner), 2500.0, law);
    plan.gravity = DVec3::new(0.0, 0.0, -9.81);
    for (outward, point) in [
        (DVec3::NEG_X, DVec3::ZERO),
        (DVec3::X, corner),
        (DVec3::NEG_Y, DVec3::ZERO),
        (DVec3::Y, corner),
        (DVec3::NEG_Z, DVec3::ZERO),
    ] {
        plan.walls.push(plane(outward, point)?);
    }
    let table = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/bench/dense-2k.csv");
    let spheres = read_particle_csv(table)?
        .into_iter()
        .map(|row| NewParticle {
            velocity: row.velocity,
            angular_velocity: row.angular_velocity,
            ..NewParticle::at(row.position, row.radius, 0)
        });
    let spheres = spheres.collect();
    Ok(plan.with_particles(spheres))
}

/// The translational and rotational kinetic energy after 1 and 10 steps from a start without contact history.
///
/// Every convention of the time step and the laws shows in it: stiffness factor, tangential damping, what the Coulomb limit cuts,
/// the lever, and at which time velocities enter the forces.
///
/// # Errors
/// If the scene's table cannot be read.
pub fn energy_of_a_packing() -> Result<Comparison> {
    let mut tally = Tally::default();
    let expected = [
        None,
        Some((2.183_738_8e-7, 4.458_175_4e-8)),
        Some((1.086_045_4e-6, 3.557_046e-7)),
    ];
    let mut expected = expected.into_iter();
    observe(plan()?, &[0, 1, 10], |engine| {
        let found = energies(engine);
        if let Some(Some((translational, rotational))) = expected.next() {
            let sum = found.translational_kinetic + found.rotational_kinetic;
            tally.add("kinetic energy", translational + rotational, sum);
            tally.add("translational", translational, found.translational_kinetic);
            tally.add("rotational", rotational, found.rotational_kinetic);
        }
        Ok(())
    })?;
    Ok(tally.finish(
        "2,000 spheres at rest begin to move",
        "MercuryDPM and LIGGGHTS on scenes/bench/dense-2k (kinetic energy after 1 and 10 steps, 6 to 7 digits)",
        Tolerance {
            relative: 2e-6,
            floor: 1e-12,
        },
    ))
}

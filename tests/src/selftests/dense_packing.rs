//! A packing of 2,000 spheres: the energy after a few steps, as two other programs give it.

use anyhow::Result;

use super::comparison::{Comparison, Tally, Tolerance};
use super::run::{energies, observe};
use crate::scene_checks::planned;

/// The translational and rotational kinetic energy after 1 and 10 steps from a start without contact history.
///
/// Every convention of the time step and the laws shows in it: stiffness factor, tangential damping, what the Coulomb limit cuts,
/// the lever, and at which time velocities enter the forces.
///
/// # Errors
/// If the scene cannot be read or planned.
pub fn energy_of_a_packing() -> Result<Comparison> {
    let mut tally = Tally::default();
    let expected = [
        None,
        Some((2.183_738_8e-7, 4.458_175_4e-8)),
        Some((1.086_045_4e-6, 3.557_046e-7)),
    ];
    let mut expected = expected.into_iter();
    observe(
        planned("bench/dense-2k.toml", &[])?.draft(),
        &[0, 1, 10],
        |engine| {
            let found = energies(engine);
            if let Some(Some((translational, rotational))) = expected.next() {
                let sum = found.translational_kinetic + found.rotational_kinetic;
                tally.add("kinetic energy", translational + rotational, sum);
                tally.add("translational", translational, found.translational_kinetic);
                tally.add("rotational", rotational, found.rotational_kinetic);
            }
            Ok(())
        },
    )?;
    Ok(tally.finish(
        "2,000 spheres at rest begin to move",
        "MercuryDPM and LIGGGHTS on scenes/bench/dense-2k (kinetic energy after 1 and 10 steps, 6 to 7 digits)",
        Tolerance {
            relative: 2e-6,
            floor: 1e-12,
        },
    ))
}

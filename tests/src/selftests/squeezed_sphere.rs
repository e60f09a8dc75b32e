//! A spinning sphere squeezed between two fixed ones: rolling and torsion resistance (set-ups 20 and 21).

use anyhow::{Context, Result};
use glam::DVec3;
use mercury_engine::contact::rolling::FrictionSpring;
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, CoulombLimits, Linear, LinearFriction,
    Luding, PairLaw, SpringRotation,
};
use mercury_engine::state::MaterialIndex;
use mercury_solver::plan::{Draft, NewParticle};

use super::Data;
use super::comparison::{Comparison, Tally, Tolerance};
use super::run::{observe, saved_steps};

/// Resistance that is on.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Resistance {
    Rolling,
    Torsion,
}

/// 20: rolling resistance.
pub(super) fn rolling(data: &Data) -> Result<Comparison> {
    run(
        data,
        Resistance::Rolling,
        "rolling resistance of a squeezed sphere",
        "MercuryDPM RollingFrictionSelfTest (.torque, every step)",
    )
}

/// 21: torsion resistance. Its file is the one of rolling: by the symmetry of the law the two couples are the same.
pub(super) fn torsion(data: &Data) -> Result<Comparison> {
    run(
        data,
        Resistance::Torsion,
        "torsion resistance of a squeezed sphere",
        "MercuryDPM RollingFrictionSelfTest (.torque, every step), whose numbers TorsionFrictionSelfTest repeats",
    )
}

fn run(
    data: &Data,
    resistance: Resistance,
    name: &'static str,
    source: &'static str,
) -> Result<Comparison> {
    let (dt, end) = (4e-4, 0.2);
    let (stiffness, dissipation) = (12_496.026_770_903_8, 17.833_747_196_936_6);
    let spring = |on: bool| FrictionSpring {
        stiffness: Some(0.4 * stiffness),
        dissipation: 0.4 * dissipation,
        friction: if on { 0.1 } else { 0.0 },
        static_friction: if on { 0.1 } else { 0.0 },
    };
    let law = PairLaw {
        normal: AnyNormal::Linear(Linear::new(stiffness, dissipation)),
        tangential: AnyTangential::Linear(LinearFriction {
            stiffness: 3_570.293_363_115_38,
            dissipation: 5.095_356_342_181_89,
            friction: 0.0,
            static_friction: 0.0,
            rotation: SpringRotation::Incremental,
            limits: CoulombLimits::Total,
        }),
        rolling: AnyRolling::Luding(Luding {
            rolling: spring(resistance == Resistance::Rolling),
            torsion: spring(resistance == Resistance::Torsion),
            lever: 2.0,
            rotation: SpringRotation::Incremental,
        }),
        adhesion: AnyAdhesion::None,
    };
    let domain = (DVec3::splat(-1.0), DVec3::splat(1.0));
    let mut plan = Draft::new(dt, domain, 6.0 / std::f64::consts::PI, law);
    plan.startup_increment = true;
    let spin = match resistance {
        Resistance::Rolling => DVec3::Y,
        Resistance::Torsion => DVec3::Z,
    };
    let fixed = |z: f64| NewParticle {
        fixed: true,
        ..NewParticle::at(DVec3::new(0.0, 0.0, z), 0.5, MaterialIndex::new(0))
    };
    let free = NewParticle {
        angular_velocity: spin,
        ..NewParticle::at(DVec3::ZERO, 0.5, MaterialIndex::new(0))
    };
    let plan = plan.with_particles(vec![free, fixed(-0.995), fixed(0.995)]);

    let path = data.file("interactions/RollingFrictionSelfTest.torque");
    let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let mut rows = text.lines().map(|line| {
        let numbers: Result<Vec<f64>, _> = line.split_ascii_whitespace().map(str::parse).collect();
        numbers.with_context(|| line.to_owned())
    });
    // The file prints the couple after each step beside the time at which the step began.
    let mut saved = saved_steps(dt, end, 1);
    saved.remove(0);
    let mut tally = Tally::default();
    observe(plan, &saved, |engine| {
        let expected = rows.next().context("more states than rows")??;
        let last = engine.particles.rows_by_id()[2] as usize;
        let load = engine.particles.loads[last];
        tally.add("time", expected[0], engine.time() - dt);

        tally.add("torque", expected[1], load.torque.dot(spin));
        tally.add("force", expected[2], load.force.z);
        Ok(())
    })?;
    anyhow::ensure!(rows.next().is_none(), "more rows than states");
    Ok(tally.finish(name, source, Tolerance::SIX_DIGITS))
}

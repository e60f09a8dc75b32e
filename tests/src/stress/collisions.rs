//! Single collisions with a theory: unequal partners, deep starts, grazes.

use std::f64::consts::PI;

use anyhow::Result;
use glam::DVec3;

use super::stage::{Stage, ulp};
use super::{Check, Found, Length};

/// Largest relative error of the speed behind a collision with the linear law, (ω Δt)²/8.
///
/// Leapfrog keeps v² + ω² (1 - (ω Δt)²/4) x² within the contact; beginning and end change v² by (ω Δt)² θ (1 - θ) v² at most, θ (1 - θ) ≤ 1/4, in opposite directions.
fn speed_error(omega: f64, dt: f64) -> f64 {
    (omega * dt).powi(2) / 8.0
}

const CORNERS: &str = "elastic impact; leapfrog errs by (ω Δt)²/8 of the speed at most, by where in a step the contact begins and ends";
const MOMENTUM: &str = "opposite forces; velocities are rounded by ε/2 in each kick";

pub(super) fn size_ratio(_: Length) -> Result<Found> {
    let mut stage = Stage::open("size-ratio", &[])?;
    let steps = stage.engine.physics().steps;
    let starts: Vec<DVec3> = (1..=200).map(|id| stage.particle(id).position).collect();
    let momentum = stage.momentum().0;
    stage.go(steps)?;
    let (mut returned, mut worst, mut aside) = (0, 0.0f64, 0.0f64);
    for (id, start) in (1..=200).zip(&starts) {
        let out = start.normalize();
        let velocity = stage.particle(id).velocity;
        let along = velocity.dot(out);
        returned += u64::from(along > 0.0);
        worst = worst.max((along - 1.0).abs());
        aside = aside.max((velocity - along * out).length());
    }
    let mass = 2500.0 * 4.0 / 3.0 * PI * 1e-12;
    let (omega, dt) = ((420.0 / mass).sqrt(), stage.time_step());
    let (after, sum) = stage.momentum();
    // The large one moves by the momentum of all it has met: 200 of a billionth of its mass.
    let recoil = 2.0 * 200.0 * 1e-9;
    Ok(Found {
        checks: vec![
            Check::exactly(
                "small spheres that come back",
                200,
                returned,
                "all fly at the centre; the search for neighbours must find each pair",
            ),
            Check::at_most(
                "their speeds less 1 m/s, worst (m/s)",
                speed_error(omega, dt) + recoil,
                worst,
                CORNERS,
            ),
            Check::at_most(
                "their speeds sideways (m/s)",
                // Normals of places of 0.1 m, whose numbers lie apart by ulp(0.1), at half a small radius of way; and the recoil.
                recoil + 50.0 * omega * dt * ulp(0.1) / 0.1,
                aside,
                "central forces; the large sphere moves aside by its recoil",
            ),
            Check::at_most(
                "change of the momentum (kg m/s)",
                // Of the large sphere too, whose momentum is no larger than that of the small ones.
                4.0 * ulp(1.0) * sum * 10.0,
                (after - momentum).length(),
                MOMENTUM,
            ),
        ],
        particles: stage.len(),
        steps,
        notes: Vec::new(),
    })
}

pub(super) fn mass_ratio(_: Length) -> Result<Found> {
    let mut stage = Stage::open("mass-ratio-impact", &[])?;
    let steps = stage.engine.physics().steps;
    let momentum = stage.momentum().0;
    stage.go(steps)?;
    let [light, heavy] = [0, 1].map(|id| stage.particle(id).velocity.x);
    let mass = 2.5 * 4.0 / 3.0 * PI * 1e-9;
    let (ratio, omega) = (1e6, (5e3 / mass * (1.0 + 1e-6)).sqrt());
    let error = speed_error(omega, stage.time_step());
    let total = 1.0 + ratio;
    let (after, sum) = stage.momentum();
    Ok(Found {
        checks: vec![
            Check::within(
                "speed of the light sphere (m/s)",
                [-1.0, 1.0].map(|side| 2.0 * ratio / total + side * error),
                light,
                CORNERS,
            ),
            Check::at_most(
                "what the heavy one has lost, less 2 m/(m + M) (m/s)",
                2.0 / total * error + 60.0 * ulp(1.0),
                1.0 - heavy - 2.0 / total,
                "the same; its speed is rounded by ε/2 in each of 50 steps",
            ),
            Check::at_most(
                "change of the momentum (kg m/s)",
                60.0 * ulp(1.0) * sum,
                (after - momentum).length(),
                MOMENTUM,
            ),
        ],
        particles: 2,
        steps,
        notes: Vec::new(),
    })
}

pub(super) fn overlaps(_: Length) -> Result<Found> {
    let mut stage = Stage::open("overlaps", &[])?;
    let steps = stage.engine.physics().steps;
    stage.go(steps)?;
    let (stiffness, depth) = (1e4, 3e-4);
    let mass = 2500.0 * 4.0 / 3.0 * PI * 1e-9;
    let omega = (2.0 * stiffness / mass).sqrt();
    let squared = (omega * stage.time_step()).powi(2);
    let apart = stage.particle(1).velocity.x - stage.particle(0).velocity.x;
    let held = 0.5 * stiffness * depth * depth;
    let energy = stage.energies().total();
    let mut crystal = energy;
    for id in 0..2 {
        crystal -= 0.5 * mass * stage.particle(id).velocity.length_squared();
    }
    Ok(Found {
        checks: vec![
            Check::within(
                "pair: speed apart over ω δ",
                [1.0 - squared / 8.0, 1.0],
                apart / (omega * depth),
                "½ m* v² = ½ k δ²; leapfrog starts at rest with (ω Δt)²/4 of the energy less, of which the end of the contact gives back between 0 and all",
            ),
            Check::within(
                "cube: its energy at the end over that of its 54 springs",
                // Twice six contacts of one sphere bound the fastest mode: 12 k/m = 6 ω².
                [1.0 - 6.0 * squared / 4.0, 1.0 + 6.0 * squared / 4.0],
                crystal / (54.0 * held),
                "energy is kept; leapfrog errs by (ω Δt)²/4 of the fastest mode, whose ω² is 6 times that of a pair at most",
            ),
            Check::says(
                "the plan warns of the overlap and names the pair",
                &[
                    "taken; warnings",
                    "particle 0",
                    "particle 1",
                    "0.3 of the smaller radius",
                    "54 more pairs",
                ],
                &super::stage::complaint("overlaps", &[]),
                "contact.overlap_warning = 0.1; 54 contacts in the cube and one pair",
            ),
            Check::says(
                "with 60 % it is refused",
                &[
                    "nothing was run",
                    "particle 0",
                    "particle 1",
                    "0.6 of the smaller radius",
                ],
                &super::stage::complaint(
                    "overlaps",
                    &["particles.1.position=[0.1014,0.0,0.0]".to_owned()],
                ),
                "contact.overlap_error = 0.5",
            ),
        ],
        particles: stage.len(),
        steps,
        notes: Vec::new(),
    })
}

pub(super) fn grazing(_: Length) -> Result<Found> {
    const OVERLAPS: [f64; 7] = [1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-15, 0.0];
    let mut stage = Stage::open("grazing", &[])?;
    let steps = stage.engine.physics().steps;
    let dt = stage.time_step();
    stage.go(steps)?;
    let (stiffness, radius) = (1e4, 1e-3f64);
    let mass = 2500.0 * 4.0 / 3.0 * PI * radius.powi(3);
    let (mut worst, mut unequal, mut kept) = (0.0f64, 0.0f64, 0.0f64);
    for (k, overlap) in OVERLAPS.into_iter().enumerate() {
        let [target, other] = [0, 1].map(|side| stage.particle(2 * k as u32 + side).velocity);
        // Along a straight way the overlap is δ - x²/4R: the integral of k times it over time, at 1 m/s.
        let lasts = 2.0 * (4.0 * radius * overlap).sqrt();
        let whole = 2.0 / 3.0 * stiffness * overlap * lasts;
        // A sum over points Δt apart misses the integral by a point at most; and as they give way the overlap becomes less, by (ω t)²/2 of it.
        let yields = 0.5 * (2.0 * stiffness / mass) * lasts * lasts;
        let points = stiffness * (overlap + 2.0 * ulp(2e-3)) * dt;
        let allowed = points + whole * yields;
        let push = -mass * target.y;
        worst = worst.max((push - whole).abs() / allowed.max(f64::MIN_POSITIVE));
        unequal = unequal.max((target.y + other.y).abs() * mass);
        let energy = (target.length_squared() + other.length_squared()) - 1.0;
        kept = kept.max(energy.abs() / (1e-12 + whole / mass));
    }
    let [target, other] = [12, 13].map(|id| stage.particle(id).velocity);
    Ok(Found {
        checks: vec![
            Check::at_most(
                "momentum given less (8/3) k √R δ^(3/2)/v, over what a sum in steps may miss",
                1.0,
                worst,
                "integral of k (δ - x²/4R) along the way; missed by k δ Δt, and by (ω t)²/2 of it as both give way",
            ),
            Check::at_most(
                "momenta sideways of both, added (kg m/s)",
                100.0 * ulp(mass * 1e-2),
                unequal,
                "opposite forces; round-off of 100 kicks",
            ),
            Check::at_most(
                "relative change of the energy, over (deflection + 1e-12)",
                1.0,
                kept,
                "elastic; an error of the energy is of the order of the work, which is below push times speed",
            ),
            Check::at_most(
                "touch by nothing: change of the velocities (m/s)",
                0.0,
                target.length() + (other - DVec3::X).length(),
                "no overlap, no force, no number changed",
            ),
        ],
        particles: stage.len(),
        steps,
        notes: Vec::new(),
    })
}

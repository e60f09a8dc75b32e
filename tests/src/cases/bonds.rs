//! T31: bonds. Stiffnesses of one beam and the cantilever by the theory's numbers, and the agglomerates of the scene.

use std::f64::consts::{PI, TAU};
use std::sync::OnceLock;

use glam::{DQuat, DVec3};
use mercury_engine::bonds::{BondCounts, Bonds, Element, Ends, LawOfBonds, Section};
use mercury_engine::step::Engine;

use super::Case;
use super::Tolerance::{Absolute, Relative};
use crate::scene_checks::planned;
use crate::scenes::{particle, start_planned};

const RADIUS: f64 = 1e-3;
const LENGTH: f64 = 2e-3;
const YOUNG: f64 = 1e8;
const PRINTED: &str =
    "Timoshenko's element of round section (Przemieniecki 1968), by independent arithmetic";
const LINE: &str = "P L^3/(3 E I) + P L/(kappa G A), summed over the weights of all spheres";

/// The element of T31, without damping.
fn element() -> Element {
    let law = LawOfBonds::Beam {
        youngs_modulus: YOUNG,
        poisson_ratio: Some(0.25),
    };
    Element::new(
        law,
        LENGTH,
        Section { radius: RADIUS },
        0.0,
        Default::default(),
    )
}

/// Force on end A over the shift of end B (m), and couple on A over the rotation of B (rad).
fn stiffness(shift: DVec3, turn: DVec3) -> (f64, f64) {
    let small = 1e-7;
    let ends = Ends {
        branch: DVec3::X * LENGTH + shift * small,
        velocity: DVec3::ZERO,
        rotations: [DQuat::IDENTITY, DQuat::from_scaled_axis(turn * small)],
        spins: [DVec3::ZERO; 2],
    };
    let action = element().act(&ends);
    (
        action.force.length() / small,
        action.couples[0].length() / small,
    )
}

/// Mean height (m) of the tip of the scene over whole periods, and the period (s) of its swing.
fn cantilever() -> (f64, f64) {
    static FOUND: OnceLock<(f64, f64)> = OnceLock::new();
    *FOUND.get_or_init(|| {
        let plan = planned("bonded-cantilever.toml", &[]).expect("the scene is right");
        let tip = plan.physics().particles.len() as u32 - 1;
        let dt = plan.physics().time_step;
        // It begins straight, at the top of its swing.
        let mut engine = start_planned(plan);
        let (mut heights, mut tops) = (Vec::new(), Vec::new());
        // Eight periods.
        while heights.len() < (8.5 * first_period() / dt) as usize {
            engine.step(None).expect("the motion stays finite");
            heights.push(particle(&engine, tip).position.z);
        }
        let mean = heights.iter().sum::<f64>() / heights.len() as f64;
        // Upward passages through the middle of the swing.
        for k in 1..heights.len() {
            let [last, now] = [heights[k - 1] - mean, heights[k] - mean];
            if last < 0.0 && now >= 0.0 {
                tops.push(k as f64 - now / (now - last));
            }
        }
        let periods = tops.len() - 1;
        let (first, last) = (tops[0], tops[periods]);
        let whole = &heights[first as usize..last as usize];
        let mean = whole.iter().sum::<f64>() / whole.len() as f64;
        (mean, (last - first) / periods as f64 * dt)
    })
}

/// E I, N m^2.
fn bending() -> f64 {
    YOUNG * PI * RADIUS.powi(4) / 4.0
}

fn mass() -> f64 {
    2500.0 * 4.0 / 3.0 * PI * RADIUS.powi(3)
}

/// Period (s) of the first mode of a slender cantilever of the same length, whose last sphere is half beyond it; good for how long to watch.
fn first_period() -> f64 {
    let length = 10.0 * LENGTH;
    TAU / (3.516 * (bending() / (mass() / LENGTH * length.powi(4))).sqrt())
}

/// Deflection (m) of the tip of the scene under the weight of its ten free spheres.
fn deflection() -> f64 {
    let shear = 6.0 * 1.25 / 8.5 * YOUNG / 2.5 * PI * RADIUS * RADIUS;
    let weight = mass() * 9.81;
    let length = 10.0 * LENGTH;
    (1..=10)
        .map(|k| f64::from(k) * LENGTH)
        .map(|a| weight * a * a * (3.0 * length - a) / (6.0 * bending()) + weight * a / shear)
        .sum()
}

/// Bonds of both agglomerates of the scene at its end, and the grains of its largest fragment.
fn agglomerates() -> (Vec<BondCounts>, u64) {
    static FOUND: OnceLock<(Vec<BondCounts>, u64)> = OnceLock::new();
    FOUND
        .get_or_init(|| {
            let plan = planned("agglomerate.toml", &[]).expect("the scene is right");
            let steps = plan.physics().steps;
            let mut engine: Engine = start_planned(plan);
            engine
                .steps_at_once(steps, None)
                .expect("the motion stays finite");
            let bonds = engine.part::<Bonds>().expect("the scene has bonds");
            let sizes = bonds.fragments(&engine.particles);
            let largest = sizes.keys().last().copied().unwrap_or(0);
            (bonds.counts().to_vec(), largest)
        })
        .clone()
}

pub(super) fn cases() -> Vec<Case> {
    let law = |name: &str, expected: f64, found: fn() -> f64| {
        Case::new(
            format!("T31 law: {name}"),
            expected,
            Relative(1e-6),
            PRINTED,
            found,
        )
    };
    // 3 n^2 (n - 1) neighbours in a cubic lattice of 6 spheres along each edge.
    let made = 3.0 * 36.0 * 5.0;
    let whole = "3 n^2 (n - 1) pairs of neighbours in a cubic lattice, n = 6";
    vec![
        law("stiffness of tension (N/m)", 157_079.632_7, || {
            stiffness(DVec3::X, DVec3::ZERO).0
        }),
        law("stiffness of shear (N/m)", 37_699.111_84, || {
            stiffness(DVec3::Y, DVec3::ZERO).0
        }),
        law("couple by shear (N)", 37.699_111_84, || {
            stiffness(DVec3::Z, DVec3::ZERO).1
        }),
        law("stiffness of torsion (N m)", 0.031_415_926_54, || {
            stiffness(DVec3::ZERO, DVec3::X).1
        }),
        Case::new(
            "T31 engine: mean deflection of the tip of bonded-cantilever.toml (m)",
            deflection(),
            // Higher modes do not end with the periods of the first: some percent of their part of 1e-2 each.
            Relative(2e-3),
            LINE,
            || -cantilever().0,
        ),
        Case::new(
            "T31 engine: pairs glued in each agglomerate",
            made,
            Absolute(0.0),
            whole,
            || agglomerates().0[0].made as f64,
        ),
        Case::new(
            "T31 engine: bonds broken at 0.2 m/s",
            0.0,
            Absolute(0.0),
            "stresses of some rho c v, 0.03 MPa, below the strength of 0.2 MPa",
            || agglomerates().0[0].broken as f64,
        ),
        Case::new(
            "T31 engine: grains of the largest fragment",
            216.0,
            Absolute(0.0),
            "the slow agglomerate stays whole",
            || agglomerates().1 as f64,
        ),
        Case::new(
            "T31 engine: share of bonds broken at 4.6 m/s",
            1.0,
            // More than 0.6 of them.
            Absolute(0.4),
            "stresses of some rho c v, 1 MPa, several times the strength",
            || agglomerates().0[1].broken as f64 / agglomerates().0[1].made as f64,
        ),
    ]
}

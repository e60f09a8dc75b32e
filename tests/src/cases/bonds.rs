//! T31: bonds. Stiffnesses of one beam and the cantilever by the theory's numbers, and the agglomerates of the scene.

use std::f64::consts::{PI, TAU};
use std::sync::OnceLock;

use glam::{DQuat, DVec3};
use mercury_engine::bonds::{
    BondCounts, BondPlan, Bonds, Element, Ends, Gluing, LawOfBonds, Section,
};
use mercury_engine::contact::{AnyNormal, Linear};
use mercury_engine::step::Engine;
use mercury_solver::plan::PrescribedMotion;

use super::Case;
use super::Tolerance::{Absolute, Relative};
use crate::closed_forms::Beam;
use crate::scene_checks::planned;
use crate::scenes::{frictionless, particle, plan, sphere, start, start_planned};

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

/// Strength of the beams that are broken, Pa, speed of their tips, m/s, and the step, s: a tenth of the critical one.
const STRENGTH: f64 = 1e5;
const SPEED: f64 = 1e-3;
const STEP: f64 = 5e-7;

/// Time (s) at which the first of so many bonds in a row breaks, and the place (m) along the row: the first sphere is fixed, the last one moves steadily
/// and turns freely.
fn broken(count: usize, velocity: DVec3) -> (f64, f64) {
    let no_contact = frictionless(AnyNormal::Linear(Linear::new(1.0, 0.0)));
    let mut draft = plan(STEP, 2500.0, no_contact);
    let place = |k: usize| DVec3::X * (k as f64 * LENGTH);
    draft.particles = (0..=count)
        .map(|k| sphere(place(k), RADIUS, DVec3::ZERO, DVec3::ZERO))
        .collect();
    draft.particles[0].fixed = true;
    let across = velocity.to_array().map(|v| (v != 0.0).then_some(v));
    draft.particles[count].velocity = velocity;
    draft.particles[count].prescribed = PrescribedMotion::boxed(across, [None; 3]);
    draft.plans.insert(BondPlan {
        name: "glue".to_owned(),
        between: None,
        when: Gluing::Start(None),
        within: None,
        walls: Vec::new(),
        law: LawOfBonds::Beam {
            youngs_modulus: YOUNG,
            poisson_ratio: Some(0.25),
        },
        radius_ratio: 1.0,
        damping: 0.3,
        strengths: [STRENGTH, f64::INFINITY],
        strength_spread: 0.0,
        contact: false,
    });
    let mut engine = start(draft);
    loop {
        engine.step(None).expect("the motion stays finite");
        let (bonds, _) = engine
            .part_and_core::<Bonds>()
            .expect("the scene has bonds");
        if let Some(first) = bonds.take_breaks().first() {
            return (first.time, first.position.x);
        }
        assert!(engine.time() < 1.0, "no bond has broken");
    }
}

/// Deflection (m) of the tip of five beams under the force for which the stress at the root is the strength.
fn deflection_at_the_strength() -> f64 {
    let beam = Beam {
        radius: RADIUS,
        length: 5.0 * LENGTH,
        youngs_modulus: YOUNG,
        poisson_ratio: 0.25,
    };
    // M r/I = M E r/(E I).
    let force = STRENGTH * beam.bending() / (YOUNG * RADIUS * beam.length);
    beam.cantilever(&[force])[0]
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
            "stresses of some rho c v, 0.03 MPa, below the strength of 0.06 MPa",
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
            "T31 engine: time at which a bond breaks that is pulled at a steady speed (s)",
            STRENGTH / YOUNG * LENGTH / SPEED,
            // The step in which it is passed, or the next one by round-off.
            Absolute(1.001 * STEP),
            "strength L0/(E v)",
            || broken(1, DVec3::X * SPEED).0,
        ),
        Case::new(
            "T31 engine: time at which a cantilever breaks whose tip is bent at a steady speed (s)",
            deflection_at_the_strength() / SPEED,
            // Its swing has been damped away. Rotations are 5e-3: squared, 3e-5.
            Relative(1e-3),
            "where P L r/I is the strength: P (L^3/(3 E I) + L/(kappa G A))/v",
            || broken(5, DVec3::Y * SPEED).0,
        ),
        Case::new(
            "T31 engine: place at which this cantilever breaks (m)",
            0.5 * LENGTH,
            // The first bond is as long as the others.
            Absolute(0.1 * LENGTH),
            "the bond at the root, where the moment is largest",
            || broken(5, DVec3::Y * SPEED).1,
        ),
    ]
}

//! T1 to T3: the linear law, its clamped variant, and the plastic law.

use mercury_engine::contact::normal::{MaxOverlap, damping_ratio, damping_ratio_clamped};
use mercury_engine::contact::{AnyNormal, Linear, NormalLaw, Plastic};

use super::Case;
use super::Tolerance::{Absolute, Digit, Relative};
use super::collision::{Collision, HeadOn, lag};
use crate::closed_forms::{clamped_restitution, linear_from_contact_time};
use crate::scenes::contact_at_rest;

/// k (N/m) and γ (kg/s) of two spheres of 1 kg that collide in 0.02 s with restitution 0.7.
const STIFFNESS: f64 = 12496.02677090382;
const DISSIPATION: f64 = 17.83374719693662;
const STEPS: f64 = 20_000.0;

/// Rows of T1 to T3.
pub(super) fn cases() -> Vec<Case> {
    let mut cases = linear();
    cases.extend(clamped());
    cases.extend(plastic_branches());
    cases.extend(plastic_collisions());
    cases
}

fn linear() -> Vec<Case> {
    const SOURCE: &str =
        "damped oscillator over half a period (Schwager & Poeschel 2007; Luding 2008)";
    let law = Linear::new(STIFFNESS, DISSIPATION);
    let clamp_free = 1e-12;
    let mut cases = vec![
        Case::new(
            "T1 setter: stiffness from t_c = 0.02 s, e = 0.7 (N/m)",
            STIFFNESS,
            Relative(clamp_free),
            SOURCE,
            || linear_from_contact_time(0.02, 0.7, 0.5).0,
        ),
        Case::new(
            "T1 setter: dissipation (kg/s)",
            DISSIPATION,
            Relative(clamp_free),
            SOURCE,
            || linear_from_contact_time(0.02, 0.7, 0.5).1,
        ),
        Case::new(
            "T1 law: damping ratio of e = 0.7",
            0.1128084506936,
            Digit(1e-13),
            SOURCE,
            || damping_ratio(0.7),
        ),
        Case::new(
            "T1 law: collision time of 1 kg and 1 kg (s)",
            0.02,
            Relative(clamp_free),
            SOURCE,
            move || law.collision_time(0.5).unwrap_or(f64::NAN),
        ),
        Case::new(
            "T1 law: restitution of 1 kg and 1 kg",
            0.7,
            Relative(clamp_free),
            SOURCE,
            move || law.restitution(0.5),
        ),
        Case::new(
            "T1 law: collision time of 1 kg and 3 kg (s)",
            0.0244424440946,
            Digit(1e-13),
            SOURCE,
            move || law.collision_time(0.75).unwrap_or(f64::NAN),
        ),
        Case::new(
            "T1 law: restitution of 1 kg and 3 kg",
            0.7478145602066,
            Digit(1e-13),
            SOURCE,
            move || law.restitution(0.75),
        ),
        Case::new(
            "T1 law: force at an overlap of 1 mm and 0.1 m/s approach (N)",
            STIFFNESS * 1e-3 + DISSIPATION * 0.1,
            Relative(1e-12),
            SOURCE,
            move || {
                let mut contact = contact_at_rest(1e-3, 0.25, 0.5);
                contact.normal_velocity = -0.1;
                law.force(&contact, &mut ()).total()
            },
        ),
        Case::new(
            "T1 law: energy at an overlap of 1 mm (J)",
            0.5 * STIFFNESS * 1e-6,
            Relative(1e-12),
            SOURCE,
            move || law.energy(&contact_at_rest(1e-3, 0.25, 0.5), &()),
        ),
    ];
    let time_step = 0.02 / STEPS;
    let near = Relative(lag(damping_ratio(0.7), STEPS));
    let mut row =
        |name: &str, masses: [f64; 2], expected, tolerance, pick: fn(Collision) -> f64| {
            let head_on = HeadOn {
                masses,
                ..HeadOn::equal(AnyNormal::Linear(law), 0.5, 1.0, 1.0, time_step)
            };
            cases.push(Case::new(
                format!("T1 engine: {name}"),
                expected,
                tolerance,
                SOURCE,
                move || pick(head_on.run()),
            ));
        };
    row("restitution of 1 kg and 1 kg", [1.0; 2], 0.7, near, |c| {
        c.restitution
    });
    row("duration (s)", [1.0; 2], 0.02, near, |c| c.duration);
    row(
        "largest overlap (m)",
        [1.0; 2],
        0.005360707863247,
        near,
        |c| c.largest_overlap,
    );
    // The largest of the overlaps at whole steps lies within a step of the true one, which damping shifts by less than another.
    row(
        "time of the largest overlap (s)",
        [1.0; 2],
        0.00928030711972,
        Absolute(2.0 * time_step),
        |c| c.time_of_largest_overlap,
    );
    // The last step in contact may lie anywhere within one step's way, at 1 m/s at most, of the separation.
    row(
        "force at separation (N)",
        [1.0; 2],
        -12.4836230379,
        Absolute(STIFFNESS * time_step),
        |c| c.last_force,
    );
    row(
        "restitution of 1 kg and 3 kg",
        [1.0, 3.0],
        0.7478145602066,
        near,
        |c| c.restitution,
    );
    row(
        "duration of 1 kg and 3 kg (s)",
        [1.0, 3.0],
        0.0244424440946,
        near,
        |c| c.duration,
    );
    let constant = Linear::with_damping_ratio(STIFFNESS, damping_ratio(0.7));
    for masses in [[1.0, 1.0], [1.0, 3.0], [20.0, 0.5]] {
        let head_on = HeadOn {
            masses,
            ..HeadOn::equal(AnyNormal::Linear(constant), 0.5, 1.0, 1.0, time_step)
        };
        let name = format!(
            "T1 engine: constant restitution with {} kg and {} kg",
            masses[0], masses[1]
        );
        cases.push(Case::new(name, 0.7, near, SOURCE, move || {
            head_on.run().restitution
        }));
    }
    cases
}

fn clamped() -> Vec<Case> {
    const SOURCE: &str = "force, not overlap, returns to zero (Schwager & Poeschel 2007)";
    let table = [
        (0.9, 0.9020260687),
        (0.8, 0.8080993353),
        (0.7, 0.7182013610),
        (0.6, 0.6322905164),
        (0.5, 0.5502831696),
        (0.3, 0.3971404999),
        (0.1, 0.2527293796),
    ];
    let mut cases = Vec::new();
    for (nominal, clamped) in table {
        cases.push(Case::new(
            format!("T2 law: damping ratio that gives e = {clamped} clamped"),
            damping_ratio(nominal),
            // one unit of the tenth digit of e, through |dζ/de| < 1/2 (steepest at e = 1, 1/π) for e above 0.2, with a margin for
            // two
            Digit(2e-10),
            SOURCE,
            move || damping_ratio_clamped(clamped),
        ));
        cases.push(Case::new(
            format!("T2 engine: clamped restitution for nominal {nominal}"),
            clamped,
            Relative(lag(damping_ratio(nominal), STEPS)),
            SOURCE,
            move || {
                let mut law = Linear::with_damping_ratio(STIFFNESS, damping_ratio(nominal));
                law.clamp_tension = true;
                HeadOn::equal(AnyNormal::Linear(law), 0.5, 1.0, 1.0, 0.02 / STEPS)
                    .run()
                    .restitution
            },
        ));
    }
    let inverse = [
        (0.9, 0.8978874399, 0.0766193257),
        (0.7, 0.6791937155, 0.2732804839),
        (0.5, 0.4362877627, 0.5708136788),
        (0.3, 0.1652189766, 1.1118610876),
    ];
    for (wanted, nominal, beta) in inverse {
        let ratio = damping_ratio_clamped(wanted);
        cases.push(Case::new(
            format!("T6 law: Hertz damping for e = {wanted} clamped"),
            beta,
            Digit(1e-10),
            SOURCE,
            move || 5.0f64.sqrt() * damping_ratio_clamped(wanted),
        ));
        // e = exp(-π ζ/√(1 - ζ²)), |de/dζ| < π e
        cases.push(Case::new(
            format!("T6 law: nominal restitution for e = {wanted} clamped"),
            nominal,
            Digit(1e-10),
            SOURCE,
            move || {
                Linear::with_damping_ratio(STIFFNESS, damping_ratio_clamped(wanted))
                    .restitution(0.5)
            },
        ));
        cases.push(Case::new(
            format!("T6 law: clamping inverted at e = {wanted}"),
            wanted,
            Relative(1e-13),
            SOURCE,
            move || clamped_restitution(damping_ratio_clamped(wanted)),
        ));
        cases.push(Case::new(
            format!("T6 engine: linear restitution {wanted} with clamping"),
            wanted,
            Relative(lag(ratio, STEPS)),
            SOURCE,
            move || {
                let mut law = Linear::with_damping_ratio(STIFFNESS, damping_ratio_clamped(wanted));
                law.clamp_tension = true;
                HeadOn::equal(AnyNormal::Linear(law), 0.5, 1.0, 1.0, 0.02 / STEPS)
                    .run()
                    .restitution
            },
        ));
    }
    cases
}

/// The plastic law of T3.
fn plastic(cohesion_stiffness: f64) -> Plastic {
    Plastic {
        loading_stiffness: 1e4,
        unloading_stiffness: 2e4,
        cohesion_stiffness,
        penetration_depth: 0.05,
        dissipation: 0.0,
        clamp_tension: false,
    }
}

/// Force (N) after a sequence of overlaps (m) of two spheres of R = 0.5 m.
fn after(path: &[f64]) -> f64 {
    let (law, mut history) = (plastic(5e3), MaxOverlap::default());
    path.iter()
        .map(|&overlap| {
            law.force(&contact_at_rest(overlap, 0.25, 0.5), &mut history)
                .total()
        })
        .last()
        .unwrap_or(f64::NAN)
}

fn plastic_branches() -> Vec<Case> {
    const SOURCE: &str = "branches of Luding 2008, eqs. 5-7";
    let near = Relative(1e-12);
    let row = |name: &str, expected, tolerance, path: &'static [f64]| {
        Case::new(
            format!("T3 law: {name} (N)"),
            expected,
            tolerance,
            SOURCE,
            move || after(path),
        )
    };
    let largest = 19.0 / 4.0 * 0.003;
    let k2 = 1e4 + 1e4 * largest / 0.05;
    vec![
        row("loading along k1 to 0.01 m", 100.0, near, &[0.01]),
        row("loading along k1 to 0.02 m", 200.0, near, &[0.02]),
        row("unloading along k2 to 0.018 m", 172.0, near, &[0.02, 0.018]),
        row(
            "no force at the rest overlap 0.02 (1 - 10/14) m",
            0.0,
            Absolute(1e-12 * 200.0),
            &[0.02, 4.0 / 700.0],
        ),
        row(
            "least force, where the cohesive branch begins",
            -400.0 / 19.0,
            near,
            &[0.02, 0.08 / 19.0],
        ),
        row("along the cohesive branch", -15.0, near, &[0.02, 0.003]),
        row(
            "reloading from the cohesive branch",
            k2 * (0.004 - (1.0 - 1e4 / k2) * largest),
            near,
            &[0.02, 0.003, 0.004],
        ),
        row(
            "beyond the plastic limit along k2max",
            1100.0,
            near,
            &[0.08],
        ),
        row(
            "unloading from beyond the plastic limit",
            700.0,
            near,
            &[0.08, 0.06],
        ),
    ]
}

fn plastic_collisions() -> Vec<Case> {
    const SOURCE: &str = "energy balance over the branches of Luding 2008";
    let collide = |cohesion| {
        let head_on = HeadOn::equal(AnyNormal::Plastic(plastic(cohesion)), 0.5, 1.0, 2.0, 2e-6);
        move || head_on.run()
    };
    let (plain, cohesive) = (collide(0.0), collide(5e3));
    vec![
        // Each of the three kinks of the force costs at most (ω dt)²: ω = √(k2/m*) = 170/s, so 1e-7; between them the branches
        // are straight. Another code saw 3e-9 at this step.
        Case::new(
            "T3 engine: restitution without cohesion",
            0.8829036135323,
            Relative(1e-8),
            SOURCE,
            move || plain().restitution,
        ),
        Case::new(
            "T3 engine: restitution with cohesion",
            0.8729429795759,
            Relative(1e-8),
            SOURCE,
            move || cohesive().restitution,
        ),
        // sampled at whole steps: at most (k1/m*) v dt²/8 below the top, 1e-8 relative
        Case::new(
            "T3 engine: largest overlap (m)",
            2.0 * (0.5f64 / 1e4).sqrt(),
            Relative(1e-7),
            SOURCE,
            move || collide(0.0)().largest_overlap,
        ),
    ]
}

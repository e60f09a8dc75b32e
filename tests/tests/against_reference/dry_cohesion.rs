//! Dry cohesion: every law beside springs, Hertz, friction and rolling, in open space, at walls and through periodic faces.
//!
//! Forces agree as those of contacts do. A neck is the exception at its end, where the force falls with infinite slope: the overlap is known to 1e-16 m
//! of the 1e-4 m of the curve, which is 1e-6 of the force within 1e-12 of the end. No state of these runs is that near to it.

use mercury_engine::contact::adhesion::dry::{Branch, Dry, Jkr, Pull, VanDerWaals};
use mercury_engine::contact::registry::{AnyPairLaw, LawTable};
use mercury_engine::contact::{AnyAdhesion, AnyNormal};

use super::laws::laws;
use super::surroundings::surroundings;
use super::{compare, uniform};

/// Overlaps are some 1 mm: necks and branches reach as far.
const REACH: f64 = 5e-4;
/// R* of two of the smallest spheres, m.
const EFFECTIVE_RADIUS: f64 = 0.01;
/// Largest radius, m.
const LARGEST: f64 = 0.036;

fn dry(normal: &AnyNormal) -> Vec<Dry> {
    let branch = |force: f64, per_radius: f64, sign: f64| Branch {
        force,
        force_per_radius: per_radius,
        stiffness: (force + per_radius * EFFECTIVE_RADIUS) / REACH,
        sign,
    };
    // In contact alone.
    let dmt = Branch {
        force_per_radius: 2e3,
        ..Branch::NONE
    };
    let of_size = branch(0.0, 2e3, 1.0);
    let mut all = vec![
        Dry::Pull(Pull::new("dmt", [dmt, Branch::NONE], true)),
        Dry::Pull(Pull::new("reversible", [of_size, Branch::NONE], false)),
        Dry::Pull(Pull::new("irreversible", [of_size, Branch::NONE], true)),
        Dry::Pull(Pull::new(
            "charged",
            [branch(8.0, 0.0, -1.0), branch(20.0, 0.0, 1.0)],
            false,
        )),
        // A R*/6 z₀² is 20 N.
        Dry::VanDerWaals(VanDerWaals {
            hamaker: 6.0 * 20.0 * REACH * REACH / EFFECTIVE_RADIUS,
            separation: REACH,
            range: 2.0 * REACH,
        }),
    ];
    if let AnyNormal::Hertz(hertz) = normal
        && !hertz.clamp_tension
    {
        // The neck ends at 0.47 a₀²/R*, with a₀³ = 2π W R*²/E*.
        let cube = (REACH * EFFECTIVE_RADIUS / 0.4725).powf(1.5);
        let square = EFFECTIVE_RADIUS * EFFECTIVE_RADIUS;
        let work = cube * hertz.effective_modulus / (2.0 * std::f64::consts::PI * square);
        all.push(Dry::Jkr(Jkr::new(work, hertz.effective_modulus)));
    }
    all.into_iter().map(|law| law.reaching(LARGEST)).collect()
}

/// Some of the combinations, each with every law of dry cohesion that goes with its normal law.
fn sticky() -> Vec<AnyPairLaw> {
    let mut all = Vec::new();
    for law in laws().into_iter().step_by(5) {
        for dry in dry(&law.normal) {
            all.push(AnyPairLaw {
                adhesion: AnyAdhesion::Dry(dry),
                ..law
            });
        }
    }
    all
}

#[test]
fn first_forces_of_every_law() {
    let surroundings = surroundings();
    for (k, law) in sticky().into_iter().enumerate() {
        let around = &surroundings[k % surroundings.len()];
        let contacts = compare(uniform(law), around, k as u64, 1);
        assert!(contacts > 0, "{}: nothing touches", around.name);
    }
}

#[test]
fn trajectories_of_every_law() {
    let surroundings = surroundings();
    let laws = sticky();
    let of_neck = |law: &&AnyPairLaw| matches!(law.adhesion, AnyAdhesion::Dry(Dry::Jkr(_)));
    let necks: Vec<_> = laws.iter().filter(of_neck).copied().collect();
    assert!(necks.len() > 3);
    // Necks everywhere, the rest in one surroundings each.
    let everywhere = (0..surroundings.len()).map(|k| (k, necks[k % necks.len()]));
    let rest = laws.iter().copied().enumerate().step_by(3);
    let mut most = 0;
    for (k, law) in everywhere.chain(rest) {
        let around = &surroundings[(k + k / surroundings.len()) % surroundings.len()];
        most = most.max(compare(uniform(law), around, 5000 + k as u64, 700));
    }
    assert!(most > 10, "{most} contacts at most");
}

/// Pairs of materials whose cohesion differs, and pairs without any.
#[test]
fn trajectories_of_several_materials() {
    let surroundings = surroundings();
    let laws: Vec<_> = sticky().into_iter().step_by(4).collect();
    for (k, around) in surroundings.iter().enumerate().step_by(2) {
        // The conventions of the reference path hold for all its contacts.
        let first = laws[k % laws.len()];
        let kin: Vec<_> = laws
            .iter()
            .filter(|law| {
                mercury_tests::twins::reference_law(law).1
                    == mercury_tests::twins::reference_law(&first).1
            })
            .collect();
        let other = *kin[(3 * k + 1) % kin.len()];
        let bare = AnyPairLaw {
            adhesion: AnyAdhesion::None,
            ..first
        };
        let table = LawTable {
            materials: 2,
            laws: vec![Some(first), Some(bare), Some(bare), Some(other)],
            ..uniform(first)
        };
        compare(table, around, 9000 + k as u64, 700);
    }
}

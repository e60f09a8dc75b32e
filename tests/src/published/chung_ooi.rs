//! Tests 4 to 8 of Chung & Ooi (2011) beside their curves, as Kratos digitised them, with Kratos' limits and time steps.
//!
//! The walls are rigid, as in Kratos. The motion of a sphere on them depends on the ratio of the two stiffnesses alone, which a
//! rigid wall leaves as it is.

use anyhow::Result;

use super::{Published, deviation};
use crate::cases::Case;
use crate::cases::Tolerance::Absolute;
use crate::cases::impact::{Impact, RIGID};
use crate::cases::oblique;

/// Kratos' limits of the mean deviation.
const TESTS_4_AND_5: f64 = 0.02;
const TEST_6: f64 = 0.03;

pub(super) const FACTORS: [(&str, f64); 2] = [("factor 1", 1.0), ("factor 2/3", 2.0 / 3.0)];

/// Test 4 by the angle from the normal (degrees).
pub(super) fn test_4(degrees: f64, factor: f64) -> Impact {
    Impact {
        partner: RIGID,
        step: 2e-8,
        ..oblique::test_4(degrees, factor)
    }
}

/// Test 5 by the speed along the wall over mu v_n.
pub(super) fn test_5(psi: f64, factor: f64) -> Impact {
    Impact {
        partner: RIGID,
        step: 3.6e-11,
        ..oblique::test_5(psi, factor)
    }
}

/// Test 6 by R spin over v_n. Tension is cut off, as in Kratos, with the damping that then gives the target restitution.
pub(super) fn test_6(tangent: f64, factor: f64) -> Impact {
    Impact {
        partner: RIGID,
        step: 1e-6,
        cut_tension: true,
        factor,
        ..oblique::test_6(tangent)
    }
}

/// Values in the curves of test 4: v_t after over before, spin (rad/s), rebound angle of the contact point (degrees).
pub(super) fn seen_4(degrees: f64, factor: f64) -> [f64; 3] {
    let impact = test_4(degrees, factor);
    let after = impact.on_wall();
    let rebound = impact.slip(&after).atan2(after.velocity.y).to_degrees();
    [
        after.velocity.x / impact.along,
        after.angular_velocity.z,
        rebound,
    ]
}

/// Values in the curves of test 5: slip and R spin after, over mu v_n.
pub(super) fn seen_5(psi: f64, factor: f64) -> [f64; 2] {
    let impact = test_5(psi, factor);
    let after = impact.on_wall();
    let scale = impact.friction * after.velocity.y;
    [
        impact.slip(&after) / scale,
        impact.radius * after.angular_velocity.z / scale,
    ]
}

/// Values in the curves of tests 6 and 8: tangential restitution, and slip over normal velocity after.
pub(super) fn seen_6(tangent: f64, factor: f64, heavy: bool) -> [f64; 2] {
    let mut impact = test_6(tangent, factor);
    let after = if heavy {
        // A thousand times the modulus and the density.
        impact.partner = (1e3 * impact.elasticity.0, impact.elasticity.1);
        impact.on_heavy_sphere(1e3 * impact.density)
    } else {
        impact.on_wall()
    };
    let slip = impact.slip(&after);
    [
        -slip / (impact.spin * impact.radius),
        slip / after.velocity.y,
    ]
}

/// (7/2) mu (1 + e), the rigid body's limit of sliding: of tan(angle) for tests 4 and 6.
fn limit(impact: &Impact) -> f64 {
    3.5 * impact.friction * (1.0 + impact.restitution)
}

pub(super) const FILES_4: [&str; 3] = [
    "chung_ooi/test4_tangential_restitution_vs_angle.csv",
    "chung_ooi/test4_final_angular_velocity_vs_angle.csv",
    "chung_ooi/test4_rebound_angle_vs_angle.csv",
];
pub(super) const FILES_5: [&str; 2] = [
    "chung_ooi/test5_recoil_vs_incident.csv",
    "chung_ooi/test5_final_spin_vs_incident.csv",
];
pub(super) const FILE_6: &str = "chung_ooi/test6_test8.json";

/// The points of tests 6 and 8, (tangent, value): tangential restitution and recoil. The first is printed over (7/2) mu (1 + e)
/// over the tangent.
pub(super) fn points_6(published: &Published, heavy: bool) -> Result<[Vec<(f64, f64)>; 2]> {
    let names = if heavy {
        [["test8", "beta"], ["test8", "recoil"]]
    } else {
        [["test6_beta", "aluminium"], ["test6_recoil", "aluminium"]]
    };
    let limit = limit(&test_6(1.0, 1.0));
    let pairs = |rows: Vec<Vec<f64>>| rows.iter().map(|row| (row[0], row[1])).collect::<Vec<_>>();
    let beta = pairs(published.points(FILE_6, &names[0])?);
    Ok([
        beta.into_iter().map(|(x, y)| (limit / x, y)).collect(),
        pairs(published.points(FILE_6, &names[1])?),
    ])
}

/// All rows.
pub(super) fn cases(published: &Published) -> Result<Vec<Case>> {
    const SOURCE_4: &str = "curve of Chung & Ooi 2011, alumina, as digitised by Kratos; Kratos' limit: sum of differences over sum of values 2 %";
    const SOURCE_5: &str = "curve of Chung & Ooi 2011, steel, as digitised by Kratos; Kratos' limit 2 %, where it slides";
    const SOURCE_6: &str = "curve of Chung & Ooi 2011, aluminium, as digitised by Kratos; Kratos' limit 3 %, where it slides";
    let mut cases = Vec::new();
    let mut row = |name: String, allowed, source, measured: Box<dyn Fn() -> f64 + Send + Sync>| {
        let name = format!("Chung & Ooi {name}");
        cases.push(Case::new(name, 0.0, Absolute(allowed), source, measured));
    };
    for (k, what) in ["v_t after over before", "spin", "rebound angle"]
        .into_iter()
        .enumerate()
    {
        let curve = published.curve(FILES_4[k], "al_oxide")?;
        let slides =
            |&(angle, _): &(f64, f64)| angle.to_radians().tan() > limit(&test_4(angle, 1.0));
        let sliding: Vec<_> = curve.iter().copied().filter(slides).collect();
        row(
            format!("test 4, 5 to 85 degrees, factor 1: deviation of {what}"),
            TESTS_4_AND_5,
            SOURCE_4,
            Box::new(move || deviation(|angle| seen_4(angle, 1.0)[k], &curve)),
        );
        row(
            format!("test 4 where it slides, factor 2/3: deviation of {what}"),
            TESTS_4_AND_5,
            SOURCE_4,
            Box::new(move || deviation(|angle| seen_4(angle, 2.0 / 3.0)[k], &sliding)),
        );
    }
    for (k, what) in ["slip after", "R spin after"].into_iter().enumerate() {
        for (name, factor) in FACTORS {
            let mut curve = published.curve(FILES_5[k], "steel")?;
            // The rigid body's limit is (7/2)(1 + e) = 7.
            curve.retain(|&(psi, _)| psi > 7.0);
            row(
                format!("test 5, {name}: deviation of {what} over mu v_n"),
                TESTS_4_AND_5,
                SOURCE_5,
                Box::new(move || deviation(|psi| seen_5(psi, factor)[k], &curve)),
            );
        }
    }
    for heavy in [false, true] {
        let test = if heavy { "test 8" } else { "test 6" };
        let what = ["tangential restitution", "slip over normal velocity after"];
        for (k, mut curve) in points_6(published, heavy)?.into_iter().enumerate() {
            curve.retain(|&(tangent, _)| tangent > limit(&test_6(1.0, 1.0)));
            for (name, factor) in FACTORS {
                let curve = curve.clone();
                row(
                    format!("{test}, {name}: deviation of {}", what[k]),
                    TEST_6,
                    SOURCE_6,
                    Box::new(move || {
                        deviation(|tangent| seen_6(tangent, factor, heavy)[k], &curve)
                    }),
                );
            }
        }
    }
    Ok(cases)
}

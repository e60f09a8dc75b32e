//! From materials to pair laws.

use super::*;
use mercury_engine::contact::mixing::harmonic_mean;
use mercury_engine::contact::{
    AnyNormal, AnyRolling, AnyTangential, CoulombLimits, SpringRotation,
};
use proptest::prelude::*;

const PLANE: &str =
    "[[walls]]\nname = \"floor\"\nshape = \"plane\"\npoint = [0, 0, -1]\nnormal = [0, 0, 1]\n";

/// A material with the given tables.
fn material(name: &str, tables: &str) -> String {
    format!("[materials.{name}]\ndensity = 2500.0\n{tables}\n")
}

/// Particles of material `a` above a floor of material `b`, which have these tables, then more of the scene.
fn pair(a: &str, b: &str, more: &str) -> String {
    let floor = format!("{PLANE}material = \"b\"\n");
    material("a", a) + &material("b", b) + &floor + &particle("a", 0.01, [0.0; 3], "") + more
}

#[test]
fn harmonic_means_are_those_of_case_t18() {
    assert_eq!(harmonic_mean(1e5, 3e5), 150_000.0);
    close(harmonic_mean(0.3, 0.5), 0.375, 1e-15);
    assert_eq!(harmonic_mean(7.0, 0.0), 0.0);
    assert_eq!(harmonic_mean(0.0, 7.0), 0.0);
}

proptest! {
    #[test]
    fn harmonic_means_are_symmetric_and_lie_between(a in 1e-9..1e12f64, b in 1e-9..1e12f64) {
        let mean = harmonic_mean(a, b);
        prop_assert_eq!(mean, harmonic_mean(b, a));
        prop_assert!(mean >= a.min(b) * (1.0 - 1e-15) && mean <= a.max(b) * (1.0 + 1e-15));
        prop_assert_eq!(harmonic_mean(a, a), a);
    }
}

#[test]
fn elastic_moduli_mix_exactly() {
    // case T18: E = 1e7, nu = 0.3 with E = 210e9, nu = 0.25
    let soft = "normal = { law = \"hertz\", youngs_modulus = 1e7, poisson_ratio = 0.3, restitution = 0.8 }\n\
        tangential = { law = \"mindlin\", friction = 0.3 }";
    let steel = "normal = { law = \"hertz\", youngs_modulus = 210e9, poisson_ratio = 0.25, restitution = 0.5 }\n\
        tangential = { law = \"mindlin\", friction = 0.5 }";
    let plan = planned(&pair(soft, steel, ""));
    let ab = ["a", "b"];
    close(
        number(&plan, ab, "normal.effective_modulus"),
        10_988_471.915_624_23,
        1e-14,
    );
    close(
        number(&plan, ab, "tangential.effective_shear_modulus"),
        2_262_336.805_391_90,
        1e-14,
    );
    assert_eq!(origin(&plan, ab, "normal.effective_modulus"), "mixed");
    // beta of case T5 is mixed, restitution is not
    let beta = harmonic_mean(0.158_426_09, 0.481_769_26);
    close(number(&plan, ab, "normal.damping"), beta, 1e-7);
    close(
        number(&plan, ab, "tangential.damping"),
        (2.0f64 / 3.0).sqrt() * beta,
        1e-7,
    );
    close(number(&plan, ab, "tangential.friction"), 0.375, 1e-15);
    // the single particle of a meets no other of its kind
    assert_eq!(plan.notes().pairs().len(), 1);
    assert!(plan.physics().laws.get(0, 0).is_none() && plan.physics().laws.get(1, 0).is_some());
}

/// Where one material states k_t and the other k_t/k_n, the ratio is of that one's own normal stiffness, not of the pair's or of the other's.
#[test]
fn a_ratio_beside_a_constant_is_of_its_own_stiffness() {
    let material = |stiffness: f64, tangential: &str| {
        format!(
            "normal = {{ law = \"linear\", stiffness = {stiffness:?}, restitution = 0.8 }}\n\
             tangential = {{ law = \"linear\", {tangential}, friction = 0.3 }}"
        )
    };
    let ratio = material(1000.0, "stiffness_ratio = 0.5");
    let constant = material(3000.0, "stiffness = 600.0");
    for text in [pair(&ratio, &constant, ""), pair(&constant, &ratio, "")] {
        let found = number(&planned(&text), ["a", "b"], "tangential.stiffness");
        close(found, harmonic_mean(500.0, 600.0), 1e-14);
    }
}

/// A side without a static friction counts with its friction.
#[test]
fn static_friction_beside_a_side_without_one() {
    let material = |tangential: &str| {
        format!(
            "normal = {{ law = \"linear\", stiffness = 1000.0, restitution = 0.8 }}\n\
             tangential = {{ law = \"linear\", stiffness_ratio = 0.5, {tangential} }}"
        )
    };
    let sticky = material("friction = 0.3, static_friction = 0.5");
    let plain = material("friction = 0.4");
    for text in [pair(&sticky, &plain, ""), pair(&plain, &sticky, "")] {
        let found = number(&planned(&text), ["a", "b"], "tangential.static_friction");
        close(found, harmonic_mean(0.5, 0.4), 1e-14);
    }
}

#[test]
fn like_like_moduli_mix_to_the_same_as_constants() {
    // E* = E/(2 (1 - nu^2)) given as such: the harmonic mean is exact
    let soft = "normal = { law = \"hertz\", effective_modulus = 5494505.494505494, damping = 0.0 }";
    let steel =
        "normal = { law = \"hertz\", youngs_modulus = 210e9, poisson_ratio = 0.25, damping = 0.0 }";
    let plan = planned(&pair(soft, steel, ""));
    close(
        number(&plan, ["a", "b"], "normal.effective_modulus"),
        10_988_471.915_624_23,
        1e-14,
    );
}

#[test]
fn contacts_replace_key_by_key() {
    // the materials and the entry of the contract's hertz-wall scene
    let m1 = "normal = { law = \"hertz\", youngs_modulus = 1e9, poisson_ratio = 0.2, restitution = 0.5 }\n\
        tangential = { law = \"mindlin\", friction = 0.3 }";
    let steel = "normal = { law = \"hertz\", youngs_modulus = 210e9, poisson_ratio = 0.2, restitution = 0.6 }\n\
        tangential = { law = \"mindlin\", friction = 0.5 }";
    let entry = "[[contacts]]\nbetween = [\"a\", \"b\"]\nnormal = { restitution = 0.4 }\ntangential = { friction = 0.2 }\n";
    let plan = planned(&pair(m1, steel, entry));
    let ab = ["a", "b"];
    close(number(&plan, ab, "normal.restitution"), 0.4, 1e-14);
    assert_eq!(origin(&plan, ab, "normal.restitution"), "contacts[0]");
    assert_eq!(number(&plan, ab, "tangential.friction"), 0.2);
    assert_eq!(origin(&plan, ab, "tangential.friction"), "contacts[0]");
    assert_eq!(number(&plan, ab, "tangential.static_friction"), 0.2);
    // 1/E* = (1 - 0.2^2) (1/1e9 + 1/210e9)
    let modulus = 1.0 / (0.96 * (1e-9 + 1.0 / 210e9));
    close(
        number(&plan, ab, "normal.effective_modulus"),
        modulus,
        1e-14,
    );
    assert_eq!(origin(&plan, ab, "normal.effective_modulus"), "mixed");
    assert_eq!(origin(&plan, ab, "tangential.stiffness_factor"), "mixed");
    assert_eq!(
        origin(&plan, ab, "tangential.damping"),
        "sqrt(2/3) of normal.damping"
    );
}

#[test]
fn linear_setters_give_the_collision_they_promise() {
    let by_time =
        "normal = { law = \"linear\", collision_time = 0.02, restitution = 0.7, mass = 1.0 }";
    for clamp in ["false", "true"] {
        let text = format!("{HEAD}{}{}", material("a", by_time), two("a", 0.01));
        let plan = planned_with(&text, &[&format!("contact.clamp_tension={clamp}")])
            .unwrap_or_else(|errors| panic!("{errors}"));
        let aa = ["a", "a"];
        close(number(&plan, aa, "normal.restitution"), 0.7, 1e-12);
        if clamp == "false" {
            // case T1
            close(
                number(&plan, aa, "normal.stiffness"),
                12496.02677090382,
                1e-12,
            );
        }
        let Some(law) = plan.physics().laws.get(0, 0) else {
            panic!()
        };
        let AnyNormal::Linear(law) = law.normal else {
            panic!()
        };
        assert_eq!(law.clamp_tension, clamp == "true");
        // Integrated: a collision of two spheres of 1 kg (m* = 0.5 kg) at 1 m/s, cut where the force pulls.
        let (mass, dt) = (0.5, 1e-7);
        let (mut overlap, mut speed, mut time) = (0.0, 1.0, 0.0);
        loop {
            let force: f64 = law.stiffness * overlap + law.dissipation_at(mass) * speed;
            let ends = if law.clamp_tension {
                force <= 0.0
            } else {
                overlap <= 0.0
            };
            if ends && time > 0.0 {
                break;
            }
            speed -= force / mass * dt;
            overlap += speed * dt;
            time += dt;
        }
        close(time, 0.02, 1e-4);
        close(-speed, 0.7, 1e-4);
    }
}

#[test]
fn clamped_hertz_damping_is_that_of_case_t6() {
    let soft = "normal = { law = \"hertz\", youngs_modulus = 1e7, poisson_ratio = 0.3, restitution = 0.9 }";
    let text = format!("{HEAD}{}{}", material("a", soft), two("a", 0.01));
    let plan = planned_with(&text, &["contact.clamp_tension=true"]).expect("plans");
    close(
        number(&plan, ["a", "a"], "normal.damping"),
        0.0766193257,
        1e-8,
    );
    close(number(&plan, ["a", "a"], "normal.restitution"), 0.9, 1e-12);
}

#[test]
fn static_friction_defaults_to_friction_and_must_not_lie_below() {
    let linear = |friction: &str| {
        format!(
            "normal = {{ law = \"linear\", stiffness = 1e4, dissipation = 0.0 }}\n\
             tangential = {{ law = \"linear\", stiffness_ratio = 0.25, {friction} }}"
        )
    };
    let (a, b) = (
        linear("friction = 0.4, static_friction = 0.6"),
        linear("friction = 0.4"),
    );
    let plan = planned(&pair(&a, &b, ""));
    let ab = ["a", "b"];
    // the side without one counts with its friction: 2/(1/0.6 + 1/0.4) = 0.48
    close(number(&plan, ab, "tangential.static_friction"), 0.48, 1e-14);
    close(number(&plan, ab, "tangential.stiffness"), 2500.0, 1e-14);
    let entry = "[[contacts]]\nbetween = [\"a\", \"b\"]\ntangential = { friction = 0.9 }\n";
    let found = complaints(&pair(&a, &b, entry));
    assert_eq!(
        found,
        [
            "contacts[0]: tangential.static_friction = 0.48 of the contacts of `a` and `b` lies below tangential.friction = 0.9 | \
          what holds before it slides needs at least the friction of sliding; give both coefficients"
        ]
    );
}

#[test]
fn different_laws_need_a_name_and_take_what_one_side_has() {
    let hertz = "normal = { law = \"hertz\", effective_modulus = 1e7, restitution = 0.8 }";
    let linear = "normal = { law = \"linear\", stiffness = 1e4, dissipation = 1.0 }";
    assert_eq!(
        complaints(&pair(hertz, linear, "")),
        [
            "materials.b.normal: the contacts of `a` and `b` have no normal law: `a` is hertz, `b` is linear | \
          name it: [[contacts]] between = [\"a\", \"b\"] normal = { law = \"...\", ... }"
        ]
    );
    let entry = "[[contacts]]\nbetween = [\"a\", \"b\"]\nnormal = { law = \"hertz\" }\n";
    let plan = planned(&pair(hertz, linear, entry));
    assert_eq!(number(&plan, ["a", "b"], "normal.effective_modulus"), 1e7);
    assert_eq!(
        origin(&plan, ["a", "b"], "normal.effective_modulus"),
        "materials.a"
    );
    assert_eq!(origin(&plan, ["a", "b"], "normal.law"), "contacts[0]");
    let entry = "[[contacts]]\nbetween = [\"a\", \"b\"]\nnormal = { law = \"plastic\", loading_stiffness = 1.0 }\n";
    assert_eq!(
        complaints(&pair(hertz, linear, entry)),
        [
            "contacts[0]: no normal.unloading_stiffness for the contacts of `a` and `b` | \
          [[contacts]] between = [\"a\", \"b\"] normal = { unloading_stiffness = ... }"
        ]
    );
    // a pair that never meets needs no law
    let text = material("a", hertz) + &material("b", linear) + &two("a", 0.01);
    assert_eq!(planned(&text).notes().pairs().len(), 1);
}

#[test]
fn damping_needs_one_meaning() {
    let by_e = "normal = { law = \"linear\", stiffness = 1e4, restitution = 0.8 }";
    let by_gamma = "normal = { law = \"linear\", stiffness = 1e4, dissipation = 1.0 }";
    assert_eq!(
        complaints(&pair(by_e, by_gamma, "")),
        [
            "materials.b.normal: the damping of the contacts of `a` and `b` is ambiguous: one material has a restitution, the other \
          a dissipation | [[contacts]] between = [\"a\", \"b\"] normal = { restitution = ... }"
        ]
    );
    let mindlin = format!(
        "{by_e}\ntangential = {{ law = \"mindlin\", friction = 0.5, effective_shear_modulus = 1e6 }}"
    );
    assert_eq!(
        complaints(&pair(&mindlin, &mindlin, "")),
        [
            "materials.b.tangential: tangential.damping of the contacts of `a` and `b` has no default: it follows from the damping of \
          a hertz law, and their normal law is another | give tangential = { damping = ... } (0 for none)"
        ]
    );
}

#[test]
fn a_side_that_leaves_its_tangential_damping_open_counts_with_the_default() {
    // The default of the pair is sqrt(2/3) of its normal damping, here 0.6 on both sides; the other side has 0.2: their harmonic
    // mean.
    let normal =
        "normal = { law = \"hertz\", youngs_modulus = 1e7, poisson_ratio = 0.3, damping = 0.6 }";
    let side =
        |key: &str| format!("{normal}\ntangential = {{ law = \"mindlin\", friction = 0.3{key} }}");
    let (said, open) = (side(", damping = 0.2"), side(""));
    let default = (2.0f64 / 3.0).sqrt() * 0.6;
    for (a, b, expected) in [
        (&said, &open, 2.0 / (1.0 / 0.2 + 1.0 / default)),
        (&open, &said, 2.0 / (1.0 / 0.2 + 1.0 / default)),
        (&said, &said, 0.2),
        (&open, &open, default),
    ] {
        let plan = planned(&pair(a, b, ""));
        close(
            number(&plan, ["a", "b"], "tangential.damping"),
            expected,
            1e-14,
        );
    }
}

#[test]
fn rolling_takes_the_stiffness_of_the_contact_or_requests_one() {
    let normal = "normal = { law = \"linear\", stiffness = 1e4, dissipation = 0.0 }\n";
    let rolling = "rolling = { law = \"luding\", friction = 0.1 }\n";
    let sliding = "tangential = { law = \"linear\", stiffness = 2e3, friction = 0.5 }\n";
    let smooth = format!("{normal}{rolling}");
    assert_eq!(
        complaints(&pair(&smooth, &smooth, "")),
        [
            "materials.b.rolling: rolling.stiffness of the contacts of `a` and `b` is missing: the pair has no tangential \
          stiffness to take it from | give rolling = { stiffness = ... } in N/m, or a tangential law"
        ]
    );
    let rough = format!("{normal}{sliding}{rolling}");
    let text = format!("{HEAD}{}", pair(&rough, &rough, ""));
    let plan = planned_with(
        &text,
        &[
            "contact.rolling_lever=2R*",
            "contact.tangential_history=incremental",
        ],
    )
    .unwrap_or_else(|errors| panic!("{errors}"));
    let Some(law) = plan.physics().laws.get(0, 1) else {
        panic!()
    };
    let AnyRolling::Luding(luding) = law.rolling else {
        panic!()
    };
    assert_eq!((luding.lever, luding.rolling.stiffness), (2.0, None));
    assert_eq!(luding.rotation, SpringRotation::Incremental);
    assert_eq!(luding.torsion.friction, 0.0);
    let AnyTangential::Linear(linear) = law.tangential else {
        panic!()
    };
    assert_eq!(linear.rotation, SpringRotation::Incremental);
    // without friction the tangential law stays for its stiffness
    let entry = "[[contacts]]\nbetween = [\"a\", \"b\"]\ntangential = { friction = 0.0 }\n";
    let plan = planned(&pair(&rough, &rough, entry));
    let Some(law) = plan.physics().laws.get(0, 1) else {
        panic!()
    };
    let AnyTangential::Linear(linear) = law.tangential else {
        panic!()
    };
    assert_eq!((linear.friction, linear.stiffness), (0.0, 2e3));
}

#[test]
fn mindlin_conventions_arrive_and_always_project() {
    let tables = "normal = { law = \"hertz\", youngs_modulus = 1e7, poisson_ratio = 0.3, restitution = 0.8 }\n\
        tangential = { law = \"mindlin\", friction = 0.5, damping = 0.0, load_history = \"rescale\" }\n\
        rolling = { law = \"luding\", friction = 0.1 }\n";
    let text = format!("{HEAD}{}", pair(tables, tables, ""));
    let plan = planned_with(
        &text,
        &[
            "contact.coulomb_limits=total",
            "contact.tangential_history=incremental",
        ],
    )
    .unwrap_or_else(|errors| panic!("{errors}"));
    let Some(law) = plan.physics().laws.get(0, 1) else {
        panic!()
    };
    let AnyTangential::MindlinRescaled(mindlin) = law.tangential else {
        panic!()
    };
    assert_eq!(mindlin.plain.limits, CoulombLimits::Total);
    assert_eq!(mindlin.plain.damping, 0.0);
    assert_eq!(mindlin.plain.stiffness_factor, 2.0 / 3.0);
    let AnyRolling::Luding(luding) = law.rolling else {
        panic!()
    };
    assert_eq!(luding.rotation, SpringRotation::Project);
}

#[test]
fn a_smooth_material_makes_the_contact_smooth() {
    let rough = "normal = { law = \"linear\", stiffness = 1e4, dissipation = 0.0 }\n\
        tangential = { law = \"linear\", stiffness = 2e3, friction = 0.5 }";
    let smooth = "normal = { law = \"linear\", stiffness = 1e4, dissipation = 0.0 }";
    let plan = planned(&pair(rough, smooth, ""));
    let Some(law) = plan.physics().laws.get(0, 1) else {
        panic!()
    };
    assert_eq!(law.tangential, AnyTangential::None);
    assert!(!plan.physics().laws.turns());
}

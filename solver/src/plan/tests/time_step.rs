//! The time step against closed forms.

use std::f64::consts::PI;

use super::super::time_step::{bearable, steps};
use super::*;
use proptest::prelude::*;

const HERTZ: &str = "[materials.soft]\ndensity = 2500.0\n\
    normal = { law = \"hertz\", youngs_modulus = 1e7, poisson_ratio = 0.3, restitution = 1.0 }\n";

fn contact_time(plan: &Plan) -> f64 {
    plan.notes()
        .step()
        .contact
        .as_ref()
        .expect("a contact")
        .time
}

fn critical(plan: &Plan) -> (f64, &str) {
    let limit = plan.notes().step().critical.as_ref().expect("a contact");
    (limit.time, &limit.of)
}

#[test]
fn linear_auto_is_a_fiftieth_of_the_collision_that_divides_the_interval() {
    // Case T1: t_c = 0.02 s, so 4e-4 s; 0.1 s holds 250 of them.
    let plan = planned(&(BALL.to_owned() + &two("ball", 0.5)));
    close(contact_time(&plan), 0.02, 1e-12);
    close(plan.physics().time_step, 4e-4, 1e-12);
    assert_eq!(plan.physics().steps, 2500);
    assert_eq!(
        plan.notes().step().reason,
        "1/50 of the shortest contact, 0.02 s (ball-ball, particles), rounded down to 1/250 of output.interval"
    );
    // 0.0999 s holds 249.75: rounded down to 0.0999/250.
    let text = format!("{HEAD}{BALL}{}", two("ball", 0.5));
    let plan = planned_with(&text, &["output.interval=0.0999"]).expect("plans");
    close(plan.physics().time_step, 0.0999 / 250.0, 1e-14);
}

#[test]
fn walls_and_fixed_partners_count_with_the_whole_mass() {
    // m* = m at a wall, m/2 between equal spheres: t_c grows by sqrt(2) without damping.
    let free = BALL.replace("17.83374719693662", "0.0");
    let pair = planned(&(free.clone() + &two("ball", 0.5)));
    let wall = "[[walls]]\nname = \"box\"\nshape = \"box\"\nmaterial = \"ball\"\n";
    let single = free.clone() + wall + &particle("ball", 0.5, [0.0; 3], "");
    let single = planned(&single);
    close(
        contact_time(&single) / contact_time(&pair),
        2f64.sqrt(),
        1e-14,
    );
    assert_eq!(
        single.notes().step().contact.as_ref().expect("walls").of,
        "ball-ball, at a wall"
    );
    assert_eq!(single.physics().walls.len(), 6);
    let held = particle("ball", 0.5, [0.52, 0.0, 0.0], "fixed = true");
    let held = planned(&(free + &particle("ball", 0.5, [-0.49, 0.0, 0.0], "") + &held));
    close(
        contact_time(&held) / contact_time(&pair),
        2f64.sqrt(),
        1e-14,
    );
}

/// Hertz: t_c ~ (m*^2/R*)^(1/5). A sphere of radius r and another like it: m* = m/2, R* = r/2. Beside a fixed one of radius 2 r: m* = m,
/// R* = 2/3 r, so m*^2/R* is 4 * 3/4 of that.
#[test]
fn a_fixed_sphere_counts_with_its_radius() {
    let pair = planned(&(HERTZ.to_owned() + &two("soft", 0.2)));
    let free = particle("soft", 0.2, [-0.49, 0.0, 0.0], "");
    let held = particle("soft", 0.4, [0.3, 0.0, 0.0], "fixed = true");
    let held = planned(&(HERTZ.to_owned() + &free + &held));
    let contact = held.notes().step().contact.as_ref().expect("a contact");
    assert_eq!(contact.of, "soft-soft, at a fixed particle");
    close(
        contact_time(&held) / contact_time(&pair),
        3f64.powf(0.2),
        1e-12,
    );
}

#[test]
fn hertz_contacts_are_those_of_case_t4() {
    let text = format!("{HEAD}{HERTZ}{}", two("soft", 5e-3));
    let plan = planned_with(&text, &["time.v_ref=0.2"]).expect("plans");
    close(contact_time(&plan), 1.406_751_502_853e-3, 1e-11);
    close(
        plan.notes().step().rayleigh.expect("E and nu"),
        4.326_991_627_612e-4,
        1e-12,
    );
    // Tangent stiffness 2 E* a at the largest overlap of the impact, m* = m/2.
    let (modulus, mass, overlap) = (
        5_494_505.494_505,
        0.001_308_996_938_995_747,
        9.559_089_210_180e-5,
    );
    let stiffness = 2.0 * modulus * (2.5e-3f64 * overlap).sqrt();
    let (time, of) = critical(&plan);
    close(time, 2.0 / (stiffness / (0.5 * mass)).sqrt(), 1e-10);
    assert_eq!(of, "soft-soft, particles, normal");
}

#[test]
fn plastic_contacts_count_with_their_largest_stiffness() {
    let plastic = "[materials.c]\ndensity = 1.909859317102744\nnormal = { law = \"plastic\", loading_stiffness = 1e4, \
        unloading_stiffness = 2e4, cohesion_stiffness = 5e3, penetration_depth = 0.05, dissipation = 1.0 }\n";
    let plan = planned(&(plastic.to_owned() + &two("c", 0.5)));
    // m* = 0.5 kg: pi/sqrt(k2max/m* - (gamma/2m*)^2)
    close(contact_time(&plan), PI / (4e4f64 - 1.0).sqrt(), 1e-12);
}

#[test]
fn tangential_and_rolling_springs_count() {
    // 7/2 k_t/m* > k/m* for k_t > 2/7 k
    let with = |more: &str| {
        let text = "[materials.ball]\ndensity = 1.909859317102744\nnormal = { law = \"linear\", stiffness = 1e4, dissipation = 0.0 }\n"
            .to_owned() + more + &two("ball", 0.5);
        planned(&text)
    };
    let plan = with("tangential = { law = \"linear\", stiffness = 1e4, friction = 0.5 }\n");
    let (time, of) = critical(&plan);
    close(time, 2.0 / (3.5 * 1e4 / 0.5f64).sqrt(), 1e-12);
    assert_eq!(of, "ball-ball, particles, tangential");
    // rolling: l = R* = 1/4 m, I = 2/5 m R^2 = 0.1 kg m^2: k_r l^2 (1/I + 1/I) = 1.25 k_r
    let plan = with("rolling = { law = \"luding\", friction = 0.5, stiffness = 1e5 }\n");
    let (time, of) = critical(&plan);
    close(time, 2.0 / (1.25 * 1e5f64).sqrt(), 1e-12);
    assert_eq!(of, "ball-ball, particles, rolling");
}

/// The lever may be twice the reduced radius; the spring's moment goes with its square: 2/w is half as long.
#[test]
fn a_doubled_lever_halves_the_critical_step() {
    let rolling = "rolling = { law = \"luding\", friction = 0.5, stiffness = 1e5 }\n";
    let text = format!("{HEAD}{BALL}{rolling}{}", two("ball", 0.5));
    let with = |lever: &str| {
        let lever = format!("contact.rolling_lever=\"{lever}\"");
        let plan = planned_with(&text, &[&lever]).unwrap_or_else(|errors| panic!("{errors}"));
        let (time, of) = critical(&plan);
        assert_eq!(of, "ball-ball, particles, rolling");
        time
    };
    close(with("R*") / with("2R*"), 2.0, 1e-12);
}

#[test]
fn the_bearable_step_is_where_the_integrator_begins_to_grow() {
    for zeta in [0.0, 0.1, 0.5, 1.0, 3.0] {
        let limit = bearable(1.0, 2.0 * zeta);
        close(limit, 2.0 * ((1.0f64 + zeta * zeta).sqrt() - zeta), 1e-14);
        for (part, grows) in [(0.999, false), (1.001, true)] {
            let h = part * limit;
            let (mut x, mut v) = (1.0f64, 0.0);
            for _ in 0..20_000 {
                v += h * (-x - 2.0 * zeta * v);
                x += h * v;
                if x.abs() > 1e6 {
                    break;
                }
            }
            assert_eq!(
                x.abs() > 1e3,
                grows,
                "zeta {zeta}, {part} of the limit: {x}"
            );
        }
    }
    assert_eq!(bearable(0.0, 0.0), f64::INFINITY);
}

#[test]
fn steps_reach_the_end_and_no_further() {
    // 0.3/0.1 is a hair below 3 in doubles, 0.6/0.2 a hair below too
    assert_eq!(steps(0.3, 0.1), 3.0);
    assert_eq!(steps(0.6, 0.2), 3.0);
    assert_eq!(steps(1.0, 0.3), 4.0);
    assert_eq!(steps(1e-9, 1.0), 1.0);
}

#[test]
fn stiff_dashpots_shorten_the_automatic_step() {
    // gamma = 1000 kg/s on m* = 0.5 kg is far overdamped: the dashpot limits the step to about 2 m*/gamma = 1e-3 s
    let scene = BALL.replace("17.83374719693662", "1000.0") + &two("ball", 0.5);
    let plan = planned(&scene);
    let rate: f64 = 2000.0;
    let expected = 4.0 / (rate + (rate * rate + 4.0 * 12496.02677090382 / 0.5).sqrt());
    close(critical(&plan).0, expected, 1e-12);
    let parts = (0.1 / (expected / 5.0)).ceil();
    close(plan.physics().time_step, 0.1 / parts, 1e-14);
    assert!(
        plan.notes()
            .step()
            .reason
            .starts_with("1/5 of the critical step, "),
        "{}",
        plan.notes().step().reason
    );
}

/// Coulomb's limit bounds a tangential dashpot of any strength: it means friction without a spring. The rest of the pair, and the step,
/// are as without it.
#[test]
fn tangential_dashpots_do_not_count() {
    let hertz = "normal = { law = \"hertz\", youngs_modulus = 1e7, poisson_ratio = 0.3, restitution = 0.8 }\n";
    let linear = "normal = { law = \"linear\", stiffness = 1e4, restitution = 0.8 }\n";
    for (normal, tangential, key) in [
        (linear, "law = \"linear\", stiffness = 0.0", "dissipation"),
        (linear, "law = \"linear\", stiffness = 2e3", "dissipation"),
        (hertz, "law = \"mindlin\"", "damping"),
        (
            hertz,
            "law = \"mindlin\", load_history = \"rescale\"",
            "damping",
        ),
    ] {
        let step = |damping: &str, limits: &str| {
            let text = format!(
                "{HEAD}[materials.ball]\ndensity = 1.909859317102744\n{normal}tangential = {{ {tangential}, friction = 0.5, {key} = {damping} }}\n{}",
                two("ball", 0.5)
            );
            let limits = format!("contact.coulomb_limits={limits}");
            planned_with(&text, &[&limits])
                .unwrap_or_else(|errors| panic!("{errors}"))
                .notes()
                .step()
                .clone()
        };
        for limits in ["bounded", "total"] {
            let without = step("0.0", limits);
            for strong in ["1e3", "1e20", "1e300"] {
                assert_eq!(step(strong, limits), without, "{tangential}");
            }
        }
    }
}

#[test]
fn reference_speeds_are_explained() {
    let text = format!("gravity = [0, 0, -8]\n{HEAD}{HERTZ}{}", two("soft", 5e-3));
    let plan = planned_with(&text, &[]).expect("plans");
    // h = 2 m
    close(plan.notes().step().reference_speed, 32f64.sqrt(), 1e-14);
    assert_eq!(
        plan.notes().step().reference_speed_reason,
        "a fall through the domain"
    );
    let plan = planned(&(HERTZ.to_owned() + &two("soft", 5e-3)));
    assert_eq!(plan.notes().step().reference_speed, 0.1);
    assert_eq!(
        plan.notes().step().reference_speed_reason,
        "the least that is assumed"
    );
    let fast = particle("soft", 5e-3, [0.0; 3], "velocity = [3, 0, 4]");
    let plan = planned(&(HERTZ.to_owned() + &fast + &two("soft", 5e-3)));
    close(plan.notes().step().reference_speed, 5.0, 1e-14);
    assert_eq!(
        plan.notes().step().reference_speed_reason,
        "the fastest initial velocity"
    );
}

#[test]
fn bad_steps_are_refused_or_warned_about() {
    let scene = BALL.replace("17.83374719693662", "0.0") + &two("ball", 0.5);
    let text = format!("{HEAD}{scene}");
    // w = sqrt(k/0.5) = 158.089...; 2/w = 0.0126506 s
    let found = complaints_with(&scene, &["time.step=0.012"]);
    assert_eq!(
        found,
        [
            "time.step: 0.012 s is above 0.9 of the critical step, 0.0126511 s (ball-ball, particles, normal) | \
          the integration would be unstable: shorten the step (or use \"auto\"), or soften the contact"
        ]
    );
    let plan = planned_with(&text, &["time.step=0.005"]).expect("plans");
    assert_eq!(
        plan.notes().warnings(),
        [
            "time.step = 0.005 s is 0.251606 of the shortest contact, 0.0198723 s (ball-ball, particles): \
          collisions will be inaccurate; 1/50 is usual"
        ]
    );
    let plan = planned_with(&text, &["time.step=0.003"]).expect("plans");
    assert!(plan.notes().warnings().is_empty());
    assert_eq!(
        complaints_with(&scene, &["time.step=0.002", "time.end=0.001"]),
        ["time.step: is longer than the run: time.end = 0.001 s"]
    );
    assert_eq!(
        complaints_with(&scene, &["time.step=1e-20"]),
        ["time.step: 1e20 steps cannot be counted | lengthen the step"]
    );
    let alone = BALL.to_owned() + &particle("ball", 0.5, [0.0; 3], "");
    assert_eq!(
        complaints(&alone),
        [
            "time.step: \"auto\" needs a contact to follow: nothing in this scene can touch | give the step in seconds"
        ]
    );
}

/// Two spheres of 0.1 m times `length` with their domain.
fn scaled(length: f64, density: f64, normal: &str, speed: f64) -> Plan {
    let l = length;
    let text = format!(
        "[time]\nend = 1.0\nstep = \"auto\"\nv_ref = {speed:?}\n[output]\ninterval = 0.1\n\
         [domain]\nmin = [{0:?}, {0:?}, {0:?}]\nmax = [{1:?}, {1:?}, {1:?}]\n\
         [materials.m]\ndensity = {density:?}\n{normal}\n{2}{3}",
        -l,
        l,
        particle("m", 0.1 * l, [-0.5 * l, 0.0, 0.0], ""),
        particle("m", 0.2 * l, [0.5 * l, 0.0, 0.0], ""),
    );
    planned_with(&text, &[]).unwrap_or_else(|errors| panic!("{errors}"))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// Linear: t ~ sqrt(m/k). Hertz: t ~ length (density^2/(E^2 speed))^(1/5).
    #[test]
    fn contact_times_scale_as_the_laws_say(
        length in 1e-4..10f64, density in 0.1..10f64, stiffness in 1e-3..1e3f64, speed in 0.1..10f64,
    ) {
        let linear = |k: f64| format!("normal = {{ law = \"linear\", stiffness = {:?}, restitution = 0.6 }}", 1e3 * k);
        let (unit, other) = (scaled(1.0, 1e3, &linear(1.0), 1.0), scaled(length, 1e3 * density, &linear(stiffness), speed));
        let expected = (density * length.powi(3) / stiffness).sqrt();
        prop_assert!((contact_time(&other) / contact_time(&unit) / expected - 1.0).abs() < 1e-12);

        let hertz = |e: f64| format!(
            "normal = {{ law = \"hertz\", youngs_modulus = {:?}, poisson_ratio = 0.3, restitution = 0.6 }}", 1e7 * e);
        let (unit, other) = (scaled(1.0, 1e3, &hertz(1.0), 1.0), scaled(length, 1e3 * density, &hertz(stiffness), speed));
        let expected = length * (density * density / (stiffness * stiffness * speed)).powf(0.2);
        prop_assert!((contact_time(&other) / contact_time(&unit) / expected - 1.0).abs() < 1e-12);

        // The step: at most a fiftieth, at least the next part of the interval, and a part of it.
        for plan in [&unit, &other] {
            let wanted = contact_time(plan) / 50.0;
            let parts = (0.1 / plan.physics().time_step).round();
            prop_assert!(plan.physics().time_step <= wanted * (1.0 + 1e-8));
            prop_assert!(parts == 1.0 || 0.1 / (parts - 1.0) > wanted);
            prop_assert!((plan.physics().time_step * parts - 0.1).abs() < 1e-15);
        }
    }
}

/// An interval shorter than what contacts allow decides the step, which is reported, and from half of it on with a warning.
#[test]
fn a_short_interval_decides_the_step_and_is_named() {
    let text = format!("{HEAD}{BALL}{}", two("ball", 0.5));
    // The contact allows 4e-4 s.
    for (interval, is_warned) in [("3e-4", false), ("2.1e-4", false), ("1e-4", true)] {
        let plan = planned_with(&text, &[&format!("output.interval={interval}")]).expect("plans");
        close(plan.physics().time_step, interval.parse().unwrap(), 1e-12);
        let reason = &plan.notes().step().reason;
        assert!(
            reason.starts_with("output.interval, which is shorter than 1/50"),
            "{reason}"
        );
        let warned = |warning: &String| warning.contains("decides the time step");
        assert_eq!(
            plan.notes().warnings().iter().any(warned),
            is_warned,
            "{interval}"
        );
    }
    let plan = planned_with(&text, &["output.interval=1e-4"]).expect("plans");
    let warnings = plan.notes().warnings().join("\n");
    assert!(warnings.contains("would be 4 times as long"), "{warnings}");
}

use super::*;
use crate::plan::parse_scene;
use mercury_common::scene::Files;

/// Grains in a periodic box that touch no other: their number never changes.
fn plan_of(more: &str) -> Plan {
    let text = format!(
        r#"
title = "Constant work"
time = {{ end = 1e-2, step = 1e-5 }}
domain = {{ min = [0, 0, 0], max = [1, 1, 1], periodic = ["x", "y", "z"] }}
output = {{ interval = 1e-4, pictures = false }}
[materials.glass]
density = 2500.0
normal = {{ law = "linear", stiffness = 1000.0, restitution = 0.8 }}
[[particles]]
material = "glass"
radius = 0.01
lattice = {{ min = [0.1, 0.1, 0.1], max = [0.5, 0.5, 0.5], spacing = 0.1 }}
{more}
"#
    );
    let scene = parse_scene("constant.toml".as_ref(), &text, &[], Files::Unchecked)
        .unwrap_or_else(|errors| panic!("{errors}"));
    crate::plan::plan(&scene).unwrap()
}

fn ahead(work: [f64; 2]) -> Ahead {
    Ahead {
        particle_steps: work,
        grains: [1.0; 2],
    }
}

#[test]
fn a_run_takes_its_start_its_first_steps_and_the_cost_of_the_rest() {
    // 1000 steps of 125 grains at 2 µs; 100 of them are made.
    let work = 900.0 * 125.0;
    let all = seconds(
        3.0,
        100.0 * 125.0 * 2e-6,
        2e-6,
        &ahead([work, 2.0 * work]),
        0.0,
    );
    let expected = 3.0 + 1000.0 * 125.0 * 2e-6;
    assert!((all[0] - expected).abs() < 1e-12, "{all:?}");
    assert!((all[1] - expected - work * 2e-6).abs() < 1e-12, "{all:?}");
    // Droplets take their part of a particle-step each.
    let wet = seconds(3.0, 100.0 * 125.0 * 2e-6, 2e-6, &ahead([work; 2]), 5000.0);
    assert!(
        (wet[0] - expected - DROPLET * 5000.0 * 2e-6).abs() < 1e-12,
        "{wet:?}"
    );
}

/// 1e5 droplets a second that cross the box, sqrt(3) m, with 10 m/s: 17,320 at once, and as many in each step to come.
#[test]
fn droplets_of_a_spray_are_counted_in() {
    let spray = r#"
[[sprays]]
name = "nozzle"
position = [0.5, 0.5, 0.9]
axis = [0, 0, 1]
pattern = { kind = "full-cone", half_angle_degrees = 5.0 }
flow_rate = 5.235987755982989e-8
speed = 10.0
droplets = { kind = "monodisperse", diameter = 1e-4 }
liquid_density = 1000.0
until = 0.5
"#;
    let options = RunOptions::default();
    let found = trial(plan_of(spray), &options, Duration::from_micros(200));
    let found = found.unwrap().unwrap();
    let at_once = 1e5 * 3f64.sqrt() / 10.0;
    assert!(
        (found.droplets_at_most / at_once - 1.0).abs() < 1e-12,
        "{found:?}"
    );
    let steps = at_once * (1000 - found.steps) as f64;
    assert!(
        (found.droplet_steps_ahead - steps).abs() <= 1e-9 * steps + at_once * 1e-9,
        "{found:?}"
    );
    let text = found.to_string();
    assert!(
        found.steps == 1000 || text.contains("about 17,321 at once while nozzles spray"),
        "{text}"
    );
}

#[test]
fn of_constant_work_the_estimate_is_steps_times_cost() {
    let options = RunOptions::default();
    let found = trial(plan_of(""), &options, Duration::from_micros(200));
    let found = found.unwrap().unwrap();
    assert!(found.steps > 0 && found.steps <= 1000);
    assert_eq!(found.of_steps, 1000);
    assert_eq!(found.particle_steps, 125 * found.steps);
    assert_eq!(
        found.particle_steps_ahead,
        [125.0 * (1000 - found.steps) as f64; 2]
    );
    assert_eq!(found.particles_at_end, [125.0; 2]);
    // Whatever the clock shows: the steps made took their time, the others take the cost.
    let expected = found.starting
        + found.stepping
        + found.seconds_per_particle_step * found.particle_steps_ahead[0];
    assert_eq!(found.seconds, [expected; 2]);
    assert!(found.seconds_per_particle_step > 0.0);
}

#[test]
fn a_trial_that_comes_to_the_end_says_so() {
    let found = trial(
        plan_of(""),
        &RunOptions::default(),
        Duration::from_secs(600),
    );
    let found = found.unwrap().unwrap();
    assert_eq!(found.steps, 1000);
    assert_eq!(found.particle_steps_ahead, [0.0; 2]);
    assert!(
        found.to_string().contains("the trial came to the end"),
        "{found}"
    );
}

#[test]
fn particles_that_are_still_to_come_are_counted_in() {
    // 1e5 per second for half of the time: 500 of them.
    let rain = r#"
[[insertions]]
name = "rain"
region = { shape = "box", min = [0, 0, 0.6], max = [1, 1, 1] }
material = "glass"
psd = { kind = "uniform", min_diameter = 2e-3, max_diameter = 3e-3, weighting = "number" }
rate = { number = 1e5 }
until = 5e-3
"#;
    let found = trial(
        plan_of(rain),
        &RunOptions::default(),
        Duration::from_nanos(1),
    );
    let found = found.unwrap().unwrap();
    assert!(found.steps < 500, "{found:?}");
    let [least, most] = found.particles_at_end;
    assert_eq!(least, most);
    // The last grain may come early.
    assert!((least - 625.0).abs() <= 1.0, "{least}");
    // Grains that stay add a constant to the sums, those that come add a triangle and a rectangle: a grain that came early counts
    // once more in each step.
    let (made, all) = (found.steps as f64, 1000.0);
    let now = found.particles as f64;
    let to_come = 500.0 - made;
    let expected = now * (all - made) + 0.5 * to_come * to_come + to_come * 500.0;
    let work = found.particle_steps_ahead[1];
    assert!(
        (work - expected).abs() <= all,
        "{work} instead of {expected}"
    );
    assert!(
        found.to_string().contains("625 at the end")
            || found.to_string().contains("626 at the end"),
        "{found}"
    );
}

#[test]
fn a_trial_that_is_stopped_before_its_first_step_reports_nothing() {
    let options = RunOptions::default();
    options.stop.store(true, Ordering::Relaxed);
    let found = trial(plan_of(""), &options, Duration::from_secs(600));
    assert_eq!(found.unwrap(), None);
}

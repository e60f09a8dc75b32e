//! When particles fall asleep, and what wakes them (`docs/theory/sleeping.md`).

use glam::DVec3;
use mercury_common::scene::{Scene, SceneError};

use mercury_engine::contact::parameter::short;
use mercury_engine::physics::Sizes;
use mercury_engine::sleeping::Sleeping;

/// Default of `speed`, in sqrt(g d): a sphere that falls by its diameter becomes 1,400 times as fast.
const SPEED: f64 = 1e-3;
/// Default of `after`, in sqrt(d/g): a sphere without support falls by an eighth of its diameter meanwhile, and a particle that
/// is slower than `speed` before and after is accelerated by 0.004 g at most.
const AFTER: f64 = 0.5;
/// With fewer steps between two checks, rest looks like a point of return.
const LEAST: f64 = 10.0;

/// The meaning of `[sleeping]` for steps of `dt` (s); `None` without the table, or after an error.
pub(super) fn sleeping(
    scene: &Scene,
    sizes: &Sizes,
    dt: f64,
    notes: &mut Vec<String>,
    errors: &mut Vec<SceneError>,
) -> Option<Sleeping> {
    let table = scene.sleeping.as_ref()?;
    let imbalance = *table.imbalance;
    let mut refuse = |error: SceneError, help: &str| {
        errors.push(error.with_help(help));
        None
    };
    if *scene.gravity == DVec3::ZERO {
        let message = "whether a particle is in balance is judged by its weight, and gravity is 0";
        let help = "leave [sleeping] out: without gravity no particle can sleep";
        return refuse(table.place.error(message), help);
    }
    if imbalance >= 1.0 {
        let message = format!(
            "{} times its weight: a particle in free fall is not further out of balance",
            short(imbalance)
        );
        let help = "a number above 0 and below 1, as 0.1";
        return refuse(table.imbalance.place.error(message), help);
    }
    if sizes.smallest == 0.0 {
        notes.push("sleeping: the scene has no particle that can sleep".to_owned());
        return None;
    }
    let (diameter, gravity) = (2.0 * sizes.smallest, scene.gravity.length());
    let (after, after_is) = match &table.after {
        Some(after) => (**after, String::new()),
        None => {
            let after = AFTER * (diameter / gravity).sqrt();
            (after, format!(" = {AFTER} sqrt(d/g)"))
        }
    };
    let (speed, speed_is) = match &table.speed {
        Some(speed) => (**speed, String::new()),
        None => {
            let speed = SPEED * (diameter * gravity).sqrt();
            (speed, format!(" = {SPEED} sqrt(g d)"))
        }
    };
    let every = (after / dt).round();
    if every.is_nan() || every < LEAST {
        let place = (table.after.as_ref()).map_or(&table.place, |after| &after.place);
        let message = format!(
            "{} s between two checks are {} time steps of {} s: too few to detect rest",
            short(after),
            short(every),
            short(dt)
        );
        let help = format!("sleeping.after of {LEAST} steps at least");
        return refuse(place.error(message), &help);
    }
    let of = if after_is.is_empty() && speed_is.is_empty() {
        String::new()
    } else {
        format!(", d = {} m the smallest diameter", short(diameter))
    };
    notes.push(format!(
        "sleeping: checked every {every} steps ({} s{after_is}); at rest below {} m/s{speed_is}{of}; woken by an imbalance of \
        {} times the weight",
        short(after),
        short(speed),
        short(imbalance)
    ));
    Some(Sleeping {
        every: every as u64,
        speed,
        imbalance,
    })
}

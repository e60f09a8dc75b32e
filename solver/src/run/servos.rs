//! The targets of servos, and whether they were reached.

use mercury_common::readable::rounded;

use mercury_engine::step::Engine;
use mercury_engine::walls::{Followed, Servo, Target, Wall};

/// A line for each servo: its target at the end of its time, and the load that it held.
pub(super) fn reported(engine: &Engine) -> Vec<String> {
    all(engine)
        .map(|(name, servo, met)| line(&name, servo, &met, engine.time()))
        .collect()
}

/// A warning for each servo whose load was not reached at the end of its time or of the run; a run that was stopped before may go
/// on.
pub(super) fn missed(engine: &Engine) -> Vec<String> {
    let physics = engine.physics();
    let is_whole = engine.steps() >= physics.steps;
    let missed = all(engine).filter(|(_, servo, met)| {
        let is_over = is_whole || engine.time() >= servo.until;
        is_over && met.means().is_some() && !met.is_near()
    });
    missed
        .map(|(name, servo, met)| warning(&name, servo, &met, engine.time()))
        .collect()
}

/// Each servo that ever moves something, with the name of its wall and how well it followed.
fn all(engine: &Engine) -> impl Iterator<Item = (String, &Servo, Followed)> {
    let walls = engine.physics().walls.iter().zip(engine.walls());
    walls.flat_map(|(wall, now)| {
        let servos = wall.motion.all_servos().zip(&now.servos).enumerate();
        servos.map(|(number, (servo, state))| (name(wall, number), servo, state.followed))
    })
}

/// The name of the wall, with the number of the servo where there are several.
fn name(wall: &Wall, number: usize) -> String {
    match wall.motion.all_servos().count() {
        1 => format!("`{}`", wall.name),
        _ => format!("`{}`, the {} of its servos", wall.name, ordinal(number)),
    }
}

fn ordinal(number: usize) -> String {
    const WORDS: [&str; 5] = ["first", "second", "third", "fourth", "fifth"];
    (WORDS.get(number)).map_or_else(|| format!("{}th", number + 1), |word| (*word).to_owned())
}

/// The load that it held: mean, scatter, target and the window of these means, at `time` (s).
fn held(servo: &Servo, met: &Followed, time: f64) -> Option<String> {
    let ([actual, asked], scatter) = met.means().zip(met.scatter())?;
    let unit = servo.target.unit();
    Some(format!(
        "{} +- {} {unit} of {} {unit} in the mean of the last {} s",
        rounded(actual, 4),
        rounded(scatter, 2),
        rounded(asked, 4),
        rounded(servo.window_of_means(time), 3)
    ))
}

fn line(name: &str, servo: &Servo, met: &Followed, time: f64) -> String {
    let Some(held) = held(servo, met, time) else {
        return format!("{name}: its time has not begun");
    };
    let mut reported = format!("{name}: {held}");
    if let Target::Pressure(..) = servo.target {
        reported += &format!(", over {} m^2", rounded(met.area(), 4));
    }
    match met.reached_at() {
        _ if met.largest() == 0.0 => {}
        Some(time) => reported += &format!("; first there at t = {} s", rounded(time, 6)),
        None => reported += "; never there",
    }
    reported
}

fn warning(name: &str, servo: &Servo, met: &Followed, time: f64) -> String {
    let [actual, _] = met.means().unwrap_or_default();
    let held = held(servo, met, time).unwrap_or_default();
    let over = if servo.until.is_finite() {
        format!(" when its time ended at {} s", rounded(servo.until, 6))
    } else {
        " at the end".to_owned()
    };
    let why = if actual == 0.0 {
        "its wall touched nothing: begin earlier, raise `max_speed`, or let it move towards the particles (the sign of the load and the axis)"
    } else if met.reached_at().is_some() {
        "it had been there before: what is pressed gave way, or the load changes faster than the particles can follow"
    } else {
        "give it more time or a higher `max_speed`; particles that yield, or a wall in the way, can make a load impossible"
    };
    format!("servo of {name}: {held}{over}; {why}")
}

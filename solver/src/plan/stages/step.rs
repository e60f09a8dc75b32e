//! The fourth stage: the time step, with its reasons.

use glam::DVec3;
use mercury_common::scene::{Scene, TimeStep};

use super::parts::densities;
use super::{Findings, Parts};
use crate::plan::membranes;
use crate::plan::pair::PairPlan;
use crate::plan::time_step::{
    Limit, Limits, REFUSED_PART, StepPlan, WARNED_PART, automatic, automatic_part, bearable_step,
    limits, steps,
};
use crate::plan::usage::MaterialUse;
use mercury_engine::contact::mixing::elastic_constants;
use mercury_engine::contact::normal::rayleigh_time;
use mercury_engine::contact::parameter::short;
use mercury_engine::step::{BesideContacts, critical_step};

/// More steps than this cannot be counted in a double, by which times are computed.
const MOST_STEPS: f64 = 9e15;
/// Least reference speed, m/s.
const LEAST_SPEED: f64 = 0.1;

/// The reference speed (m/s) of the time step and where it comes from.
fn reference_speed(scene: &Scene, parts: &Parts) -> (f64, String) {
    let Parts {
        start,
        clumps,
        insertions,
        walls,
        ..
    } = parts;
    if let Some(speed) = &scene.time.v_ref {
        return (**speed, "time.v_ref".to_owned());
    }
    let initial = start
        .particles
        .iter()
        .map(|p| p.velocity.length())
        .chain(start.bodies.iter().map(|body| {
            // Its fastest point.
            let reach = clumps[body.clump as usize].radius * body.scale;
            body.velocity.length() + body.angular_velocity.length() * reach
        }))
        .fold(0.0, f64::max);
    let inserted = insertions
        .iter()
        .map(|plan| (plan.velocity_mean.abs() + plan.velocity_spread.abs()).length())
        .fold(0.0, f64::max);
    let (min, max) = (*scene.domain.min, *scene.domain.max);
    let reach = 0.5 * (max - min).length();
    let moving = walls
        .iter()
        .map(|wall| {
            wall.motion
                .max_speed(0.5 * (min + max), reach, *scene.time.end)
        })
        .fold(0.0, f64::max);
    // g h of a fall through the domain; along periodic axes it has no end and counts nothing.
    let fall: f64 = (0..3)
        .filter(|&axis| !scene.domain.periodic[axis])
        .map(|axis| scene.gravity[axis].abs() * (max[axis] - min[axis]))
        .sum();
    let launched = f64::max(initial, inserted);
    let has_free = !insertions.is_empty()
        || start.particles.iter().any(|particle| !particle.fixed)
        || start.bodies.iter().any(|body| !body.fixed);
    let fallen = if has_free && *scene.gravity != DVec3::ZERO {
        (launched * launched + 2.0 * fall).sqrt()
    } else {
        0.0
    };
    let (speed, reason) = [
        (initial, "the fastest initial velocity"),
        (inserted, "the fastest inserted particle"),
        (moving, "the fastest wall"),
        (fallen, "a fall through the domain"),
    ]
    .into_iter()
    .fold((LEAST_SPEED, "the least that is assumed"), |best, next| {
        if next.0 > best.0 { next } else { best }
    });
    (speed, reason.to_owned())
}

/// The time step (s) and its reasons.
pub(super) fn plan_step(
    scene: &Scene,
    parts: &Parts,
    pairs: &[PairPlan],
    Findings {
        errors, warnings, ..
    }: &mut Findings,
) -> Option<(f64, StepPlan)> {
    let Parts {
        uses,
        clumps,
        dimensions,
        ..
    } = parts;
    let beside = critical_step(&BesideContacts {
        surfaces: &parts.sheets.surfaces,
        membranes: &parts.sheets.membranes,
        bonds: parts.bonded.as_ref(),
    });
    let (speed, speed_reason) = reference_speed(scene, parts);
    let Limits {
        contact,
        critical,
        unbounded,
    } = limits(pairs, uses, clumps, &densities(scene), *dimensions, speed);
    let place = &scene.time.step.place;
    let would_be = match scene.time.step.value {
        TimeStep::Auto => None,
        TimeStep::Seconds(_) => contact.as_ref().zip(critical.as_ref()),
    };
    let would_be = would_be.map(|(contact, critical)| bearable_step(contact, critical));
    // The limit by all else, in the form of a contact with the same limit.
    let by_others = beside
        .as_ref()
        .map(|limit| limit.time / membranes::STEPS_PER_CRITICAL);
    let would_be = match (scene.time.step.value, by_others) {
        (TimeStep::Seconds(_), Some(time)) => Some(would_be.map_or(time, |other| other.min(time))),
        _ => would_be,
    };
    let (step, reason) = match (
        scene.time.step.value,
        contact.as_ref().zip(critical.as_ref()),
    ) {
        (TimeStep::Seconds(step), _) => (step, "as given".to_owned()),
        (TimeStep::Auto, contacts)
            if by_others.is_some_and(|time| {
                contacts.is_none_or(|(contact, critical)| time < bearable_step(contact, critical))
            }) =>
        {
            let limit = beside.as_ref().map(|limit| Limit {
                time: limit.time,
                of: limit.of.clone(),
                part: "",
            });
            let interval = *scene.output.interval;
            let (step, reason, warning) = automatic_part(
                &limit.unwrap_or_default(),
                membranes::STEPS_PER_CRITICAL,
                "critical step",
                interval,
            );
            warnings.extend(warning);
            (step, reason)
        }
        (TimeStep::Auto, Some((contact, critical))) => {
            let (step, reason, warning) = automatic(contact, critical, *scene.output.interval);
            warnings.extend(warning);
            (step, reason)
        }
        (TimeStep::Auto, None) => {
            let message = "\"auto\" needs a contact to follow: nothing in this scene can touch";
            errors.push(place.error(message).with_help("give the step in seconds"));
            return None;
        }
    };
    let end = *scene.time.end;
    if step > end && scene.time.step.value != TimeStep::Auto {
        let message = format!("is longer than the run: time.end = {end} s");
        errors.push(place.error(message));
        return None;
    }
    if steps(end, step) > MOST_STEPS {
        let message = format!("{} steps cannot be counted", short(steps(end, step)));
        errors.push(place.error(message).with_help("lengthen the step"));
        return None;
    }
    if let Some(critical) = &unbounded
        && step > REFUSED_PART * critical.time
    {
        let message = format!(
            "{} s is above 0.9 of the critical step, {} s ({})",
            short(step),
            short(critical.time),
            critical.of
        );
        errors.push(place.error(message).with_help(format!(
            "the integration would be unstable: shorten the step (or use \"auto\"), or {}",
            critical.way_out()
        )));
        return None;
    }
    if let Some(limit) = &beside
        && step > REFUSED_PART * limit.time
    {
        let message = format!(
            "{} s is above 0.9 of the critical step of {}, {} s",
            short(step),
            limit.of,
            short(limit.time)
        );
        errors.push(place.error(message).with_help(format!(
            "the integration would be unstable: shorten the step (or use \"auto\"), {}",
            limit.way_out
        )));
        return None;
    }
    if let Some(critical) = &critical
        && step > REFUSED_PART * critical.time
    {
        warnings.push(format!(
            "time.step = {} s is above 0.9 of the critical step, {} s ({}): in collisions as fast as {} m/s friction will rattle",
            short(step),
            short(critical.time),
            critical.of,
            short(speed)
        ));
    }
    if let Some(contact) = &contact
        && step > WARNED_PART * contact.time
    {
        warnings.push(format!(
            "time.step = {} s is {} of the shortest contact, {} s ({}): collisions will be inaccurate; 1/50 is usual",
            short(step),
            short(step / contact.time),
            short(contact.time),
            contact.of
        ));
    }
    let step_plan = StepPlan {
        is_automatic: scene.time.step.value == TimeStep::Auto,
        automatic: would_be,
        reason,
        reference_speed: speed,
        reference_speed_reason: speed_reason,
        contact,
        critical,
        rayleigh: rayleigh(scene, uses),
    };
    Some((step, step_plan))
}

/// Smallest Rayleigh time (s) of the free particles with E and nu.
fn rayleigh(scene: &Scene, uses: &[MaterialUse]) -> Option<f64> {
    scene
        .materials
        .iter()
        .zip(uses)
        .filter(|(_, used)| used.free > 0)
        .filter_map(|(material, used)| {
            let (e, nu) = elastic_constants(material)?;
            Some(rayleigh_time(used.smallest_free, *material.density, e, nu))
        })
        .reduce(f64::min)
}

//! Holds of vertices of sheets.

use glam::DVec3;
use mercury_common::scene::{Hold, HoldMotion, Membrane, Pick, SceneError};

use crate::boundaries::plan::insertions::region;
use crate::plan::walls::component_about;
use mercury_engine::contact::parameter::short;
use mercury_engine::membrane::{HoldCourse, HoldPlan};
use mercury_engine::walls::{Motion, Wall};

pub(super) fn plan_hold(
    hold: &Hold,
    vertices: &[DVec3],
    is_on_rim: &[bool],
    walls: &[Wall],
    warnings: &mut Vec<String>,
    errors: &mut Vec<SceneError>,
) -> Option<HoldPlan> {
    let mut is_picked = vec![false; vertices.len()];
    for Pick { is_rim, region: of } in &hold.picks {
        let of = match of {
            Some(of) => Some(region(of, warnings, errors)?),
            None => None,
        };
        for (k, picked) in is_picked.iter_mut().enumerate() {
            let is_inside = of.as_ref().is_none_or(|of| of.contains(vertices[k]));
            *picked |= is_inside && (!is_rim || is_on_rim[k]);
        }
    }
    let picked = is_picked.iter().zip(0u32..);
    let held: Vec<u32> = picked
        .filter(|(picked, _)| **picked)
        .map(|(_, k)| k)
        .collect();
    if held.is_empty() {
        let error = hold
            .place
            .error(format!("the hold \"{}\" holds no vertex", hold.name.value));
        errors.push(error.with_help("a closed sheet has no rim; vertices are picked by where they are at the start, inside the region"));
        return None;
    }
    let ramp = match &hold.motion {
        HoldMotion::Still => HoldCourse::Velocity([Some(0.0); 3]),
        HoldMotion::Velocity(components) => HoldCourse::Velocity(**components),
        HoldMotion::Wall(wall) => {
            let index = walls.iter().position(|known| known.name == wall.value);
            let Some(index) = index else {
                let names: Vec<&str> = walls.iter().map(|wall| wall.name.as_str()).collect();
                let error = wall.error(format!("there is no wall \"{}\"", wall.value));
                errors.push(error.with_help(if names.is_empty() {
                    "the scene has no walls".to_owned()
                } else {
                    format!("there are: {}", names.join(", "))
                }));
                return None;
            };
            HoldCourse::Wall(index)
        }
        HoldMotion::Motions(motions) => {
            let mean = held.iter().map(|&k| vertices[k as usize]).sum::<DVec3>();
            let mean = mean / held.len() as f64;
            let mut components = Vec::new();
            for motion in motions {
                match component_about(mean, motion) {
                    Ok(component) => components.push(component),
                    Err(error) => {
                        errors.push(error);
                        return None;
                    }
                }
            }
            match Motion::new(components) {
                Ok(motion) => HoldCourse::Motion(Box::new(motion)),
                Err(error) => {
                    errors.push(hold.place.error(error.to_string()));
                    return None;
                }
            }
        }
    };
    Some(HoldPlan {
        name: hold.name.value.clone(),
        vertices: held,
        ramp,
        from: *hold.from,
        until: hold.until.as_deref().copied().unwrap_or(f64::INFINITY),
    })
}

/// A vertex has one hold at a time.
pub(super) fn check_twice(membrane: &Membrane, holds: &[HoldPlan], errors: &mut Vec<SceneError>) {
    for (number, hold) in holds.iter().enumerate() {
        for other in &holds[..number] {
            if hold.from >= other.until || other.from >= hold.until {
                continue;
            }
            // Both are sorted.
            let twice = (hold.vertices.iter()).find(|k| other.vertices.binary_search(k).is_ok());
            let Some(vertex) = twice else { continue };
            let named = membrane.holds.iter().find(|of| of.name.value == hold.name);
            let place = named.map_or(&membrane.place, |of| &of.place);
            let error = place.error(format!(
                "vertex {vertex} is held by \"{}\" already, at the same time",
                other.name
            ));
            errors.push(error.with_help(
                "a vertex has one hold at a time: narrow one of the regions, or their times (from, until)",
            ));
        }
    }
}

/// Holds that go with a wall end with it, and begin with it.
pub(super) fn check_walls_of_holds(
    name: &str,
    holds: &[HoldPlan],
    walls: &[Wall],
    warnings: &mut Vec<String>,
) {
    for hold in holds {
        let HoldCourse::Wall(wall) = hold.ramp else {
            continue;
        };
        let wall = &walls[wall];
        if wall.until < hold.until {
            warnings.push(format!(
                "membranes.{name}: the hold `{}` ends at {} s, when its wall `{}` is removed, and its vertices are free then; if this is meant, end the hold itself (`until`)",
                hold.name,
                short(wall.until),
                wall.name
            ));
        }
        if wall.from > hold.from.max(0.0) {
            warnings.push(format!(
                "membranes.{name}: the hold `{}` begins at {} s only, when its wall `{}` comes, and its vertices are free before; if this is meant, begin the hold itself then (`from`)",
                hold.name,
                short(wall.from),
                wall.name
            ));
        }
    }
}

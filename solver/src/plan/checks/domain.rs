//! Positions in the domain, periodic axes, two dimensions.

use glam::DVec3;
use mercury_common::particle_properties::{FILM_VOLUME, ParticleProperty};
use mercury_common::scene::{ParticleSource, Scene, SceneError, Shape, SourceSpan};

use super::{name, place, point};
use crate::plan::NewParticle;
use crate::plan::particles::StartingParticles;
use mercury_engine::boundaries::InsertionPlan;
use mercury_engine::contact::parameter::short;

/// A periodic edge must hold two listing distances: contact and a skin, here of a twentieth.
const PERIODIC_ROOM: f64 = 1.05;
/// The tolerance of "the same z" and "in the plane", as a part of the radius or of a direction's length.
const FLAT: f64 = 1e-9;
/// If neighbouring numbers are farther apart than this part of a radius, positions are meaningless: overlaps are a thousandth of
/// it and less.
const COARSE: f64 = 1e-5;
/// Above this part of a radius forces have less than five digits of an overlap of a thousandth.
const COARSER_THAN_USUAL: f64 = 1e-8;

/// Every particle's and body's centre lies in the domain. One error per entry of `[[particles]]`.
pub(in crate::plan) fn inside_the_domain(
    scene: &Scene,
    start: &StartingParticles,
    errors: &mut Vec<SceneError>,
) {
    let (min, max) = (*scene.domain.min, *scene.domain.max);
    let outside = |grain: usize| {
        (0..3).any(|axis| {
            let x = start.centre(grain)[axis];
            !scene.domain.periodic[axis] && (x < min[axis] || x > max[axis])
        })
    };
    let mut reported: Option<usize> = None;
    for id in 0..start.grains() {
        let entry = start.typed(id).entry;
        if reported == Some(entry) || !outside(id) {
            continue;
        }
        reported = Some(entry);
        let others = (id + 1..start.grains())
            .filter(|&other| start.typed(other).entry == entry && outside(other))
            .count();
        let more = match others {
            0 => String::new(),
            n => format!("; {n} more of this entry too"),
        };
        let message = format!(
            "{} lies outside the domain: {} is not within {} to {}{more}",
            name(scene, start, id),
            point(start.centre(id)),
            point(min),
            point(max),
        );
        let of_entry = (0..start.grains()).filter(|&other| start.typed(other).entry == entry);
        let of_entry = of_entry.map(|grain| start.centre(grain));
        let source = &scene.particles[entry].source;
        let help = match source {
            ParticleSource::Table { scale: None, .. } if may_be_millimetres(of_entry, min, max) => {
                "if the file is in millimetres, name the unit in its header, as x [mm], or give scale = \"1 mm\" beside it"
            }
            _ => "move it, or enlarge the domain",
        };
        errors.push(place(scene, start, id).error(message).with_help(help));
    }
}

/// Part of the domain's width that grains in millimetres reach along an axis, as seen from the origin.
const WIDE: f64 = 0.01;

/// Whether all centres would lie in the domain, and not all of them next to the origin, if they were in millimetres.
fn may_be_millimetres(centres: impl Iterator<Item = DVec3>, min: DVec3, max: DVec3) -> bool {
    let mut farthest = DVec3::ZERO;
    for centre in centres.map(|centre| centre * 1e-3) {
        if centre.cmplt(min).any() || centre.cmpgt(max).any() {
            return false;
        }
        farthest = farthest.max(centre.abs());
    }
    farthest.cmpge(WIDE * (max - min)).any()
}

/// The resolution of positions is fine enough for contacts: numbers have 16 digits, so that far from the origin they lie apart by
/// more than an overlap. One error, and one warning, for the worst grain.
pub(in crate::plan) fn far_from_the_origin(
    scene: &Scene,
    start: &StartingParticles,
    smallest: f64,
    errors: &mut Vec<SceneError>,
    warnings: &mut Vec<String>,
) {
    let distance = |grain: usize| start.centre(grain).abs().max_element();
    let Some(farthest) = (0..start.grains()).max_by(|&a, &b| distance(a).total_cmp(&distance(b)))
    else {
        return;
    };
    let spacing = distance(farthest) * f64::EPSILON;
    let message = format!(
        "{} is at {}, where neighbouring numbers lie {} m apart: {} of the smallest radius, {} m; overlaps would be lost in round-off",
        name(scene, start, farthest),
        point(start.centre(farthest)),
        short(spacing),
        short(spacing / smallest),
        short(smallest),
    );
    let help = "move the scene to the origin";
    if spacing > COARSE * smallest {
        errors.push(place(scene, start, farthest).error(message).with_help(help));
    } else if spacing > COARSER_THAN_USUAL * smallest {
        warnings.push(format!("{message}: {help}"));
    }
}

/// Periodic edges are long enough for the particles and bodies, and planes do not cut periodic axes.
pub(in crate::plan) fn periodic_axes(
    scene: &Scene,
    largest_radius: f64,
    largest_body: f64,
    range: f64,
    errors: &mut Vec<SceneError>,
) {
    const AXES: [&str; 3] = ["x", "y", "z"];
    for axis in (0..3).filter(|&axis| scene.domain.periodic[axis]) {
        let edge = scene.domain.max[axis] - scene.domain.min[axis];
        let least = PERIODIC_ROOM * (4.0 * largest_radius + 2.0 * range);
        if edge < least {
            let message = format!(
                "the periodic axis {} is too short: {} m, at least {} m are needed for particles of radius {} m",
                AXES[axis],
                short(edge),
                short(least),
                short(largest_radius)
            );
            errors.push(scene.domain.place.error(message).with_help(
                "a particle must not touch another one and its image at once; enlarge the domain, or make the axis not periodic",
            ));
        }
        let least = PERIODIC_ROOM * 2.0 * largest_body;
        if edge < least {
            let message = format!(
                "the periodic axis {} is too short: {} m, at least {} m are needed for bodies of circumscribed radius {} m",
                AXES[axis],
                short(edge),
                short(least),
                short(largest_body)
            );
            errors.push(scene.domain.place.error(message).with_help(
                "a body must not touch its own image; enlarge the domain, or make the axis not periodic",
            ));
        }
        for wall in &scene.walls {
            if let Shape::Plane { normal, .. } = &wall.shape
                && normal[axis].abs() > FLAT
            {
                let message = format!(
                    "the plane cuts the periodic axis {0}: its normal has a component along {0}",
                    AXES[axis]
                );
                errors.push(
                    normal
                        .error(message)
                        .with_help("set that component to 0, or make the axis not periodic"),
                );
            }
        }
    }
}

/// Two dimensions: one plane, no gravity or motion out of it.
pub(in crate::plan) fn flat(
    scene: &Scene,
    start: &StartingParticles,
    insertions: &[InsertionPlan],
    errors: &mut Vec<SceneError>,
) {
    if scene.gravity.z != 0.0 {
        let message = format!(
            "two dimensions: gravity along z must be 0, got {}",
            scene.gravity.z
        );
        errors.push(scene.gravity.error(message));
    }
    dry(scene, start, errors);
    let Some(first) = start.particles.first() else {
        return flat_insertions(scene, insertions, errors);
    };
    let moves_out = |particle: &NewParticle| {
        particle.velocity.z != 0.0
            || particle.angular_velocity.x != 0.0
            || particle.angular_velocity.y != 0.0
    };
    if let Some(id) = start
        .particles
        .iter()
        .position(|particle| (particle.position.z - first.position.z).abs() > FLAT * first.radius)
    {
        let message = format!(
            "two dimensions: all centres must have the same z, {} has {}, particle 0 has {}",
            name(scene, start, id),
            short(start.particles[id].position.z),
            short(first.position.z)
        );
        errors.push(place(scene, start, id).error(message));
    }
    if let Some(id) = start.particles.iter().position(moves_out) {
        let message = format!(
            "two dimensions: {} moves or turns out of the plane",
            name(scene, start, id)
        );
        errors.push(
            place(scene, start, id)
                .error(message)
                .with_help("velocities have x and y, angular velocities only z"),
        );
    }
    flat_insertions(scene, insertions, errors);
}

/// No liquid: bridges and films are those of spheres.
fn dry(scene: &Scene, start: &StartingParticles, errors: &mut Vec<SceneError>) {
    let mut refuse = |place: &SourceSpan| {
        let error =
            place.error("liquid needs three dimensions: a disc has no surface to be wetted");
        errors.push(error.with_help("leave the liquid out, or set domain.dimensions = 3"));
    };
    for law in (scene.materials.iter()).filter_map(|material| material.liquid.as_ref()) {
        refuse(&law.place);
    }
    for film in scene.walls.iter().filter_map(|wall| wall.film.as_ref()) {
        refuse(&film.thickness.place);
    }
    let is_wet = |property: &ParticleProperty| *property == FILM_VOLUME;
    let values = (start.values.iter()).find(|values| is_wet(values.property));
    if let Some(&(id, _)) = values.and_then(|values| values.particles.first()) {
        refuse(place(scene, start, id));
    }
    let mut components = (scene.insertions.iter()).flat_map(|insertion| &insertion.mixture);
    if let Some(wet) = components.find(|component| {
        component
            .properties
            .iter()
            .any(|(property, _)| is_wet(property))
    }) {
        refuse(&wet.place);
    }
}

fn flat_insertions(scene: &Scene, insertions: &[InsertionPlan], errors: &mut Vec<SceneError>) {
    for insertion in &scene.insertions {
        let is_planned = insertions
            .iter()
            .any(|plan| plan.name == insertion.name.value);
        if is_planned && (insertion.velocity_mean.z != 0.0 || insertion.velocity_spread.z != 0.0) {
            let place = &insertion.velocity_mean.place;
            errors.push(place.error("two dimensions: the velocity along z must be 0"));
        }
    }
}

//! Overlaps of the start, between particles, bodies, walls and sheets.

use glam::DVec3;
use mercury_common::scene::{Scene, SceneError};

use super::crowds::{MOST_TOUCHING, crowded, too_many};
use super::{name, place};
use crate::plan::cell_of;
use crate::plan::particles::{StartingParticles, StartingSphere};
use mercury_engine::bodies::Clump;
use mercury_engine::contact::parameter::short;
use mercury_engine::membrane::MembranePlan;
use mercury_engine::neighbours::{Levels, Margin, Skin, build};
use mercury_engine::state::{MaterialIndex, Particle, Particles};
use mercury_engine::surface::Surface;
use mercury_engine::walls::{Scratch, Touches, Wall, WallNow};

/// The worst overlap of many, and how many there are.
#[derive(Default)]
struct Worst<T> {
    found: Option<(f64, T)>,
    count: usize,
}

impl<T> Worst<T> {
    fn add(&mut self, part: f64, what: T) {
        self.count += 1;
        if self.found.as_ref().is_none_or(|(worst, _)| part > *worst) {
            self.found = Some((part, what));
        }
    }

    /// "; 2 more pairs are above the limit", or nothing.
    fn others(&self, what: &str) -> String {
        match self.count {
            0 | 1 => String::new(),
            2 => format!("; 1 more {what} is above the limit"),
            n => format!("; {} more {what}s are above the limit", n - 1),
        }
    }
}

/// Overlaps of the start between particles, bodies and walls: errors above `contact.overlap_error`, warnings above
/// `contact.overlap_warning`, both parts of the smaller radius. Pairs of fixed particles are exempt. Returns the numbers of pairs that
/// touch and of those that the first candidate list will hold, for spheres of these radii (smallest, mean, largest, m).
///
/// Requires finite positions and periodic edges that [`periodic_axes`] accepts.
pub(in crate::plan) fn overlaps(
    scene: &Scene,
    start: &StartingParticles,
    clumps: &[Clump],
    walls: &[Wall],
    radii: [f64; 3],
    errors: &mut Vec<SceneError>,
    warnings: &mut Vec<String>,
) -> [u64; 2] {
    let (error_limit, warning_limit) =
        (*scene.contact.overlap_error, *scene.contact.overlap_warning);
    let (mut bad, mut dubious) = (Worst::default(), Worst::default());
    let spheres: Vec<StartingSphere> = start.spheres(clumps).collect();
    let crowd = crowded(&spheres, error_limit).map(|pair| {
        let limit = format!("the limit is contact.overlap_error = {error_limit}");
        (pair, limit)
    });
    let crowd = crowd.or_else(|| {
        let limit = format!("no more than {MOST_TOUCHING} for each are listed");
        Some((too_many(&spheres, error_limit)?, limit))
    });
    if let Some(((a, b), limit)) = crowd {
        let message = format!(
            "{} and {} lie so close to each other, and to others, that the pairs that overlap are not counted; {limit}",
            name(scene, start, a),
            name(scene, start, b)
        );
        errors.push(
            place(scene, start, b)
                .error(message)
                .with_help("move them apart; does a table hold the same particles more than once?"),
        );
        return [0, 0];
    }
    let mut touching = 0;
    let listed = for_each_touching_pair(scene, &spheres, radii, |a, b, overlap| {
        let smaller = spheres[a].radius.min(spheres[b].radius);
        let (a, b) = (spheres[a].grain, spheres[b].grain);
        if a == b {
            return;
        }
        touching += 1;
        let part = overlap / smaller;
        if part > error_limit {
            bad.add(part, (a, b, overlap));
        } else if part > warning_limit {
            dubious.add(part, (a, b, overlap));
        }
    });
    let words = |part: f64, (a, b, overlap): (usize, usize, f64)| {
        format!(
            "{} and {} overlap by {} m at the start, {} of the smaller radius",
            name(scene, start, a),
            name(scene, start, b),
            short(overlap),
            short(part)
        )
    };
    if let Some((part, pair)) = bad.found {
        let message = format!(
            "{}; the limit is contact.overlap_error = {error_limit}{}",
            words(part, pair),
            bad.others("pair")
        );
        errors.push(
            place(scene, start, pair.1)
                .error(message)
                .with_help("move them apart, or raise the limit if this is meant"),
        );
    }
    if let Some((part, pair)) = dubious.found {
        warnings.push(format!(
            "{} (contact.overlap_warning = {warning_limit}){}",
            words(part, pair),
            dubious.others("pair")
        ));
    }

    let (mut bad, mut dubious) = (Worst::default(), Worst::default());
    let (mut behind, mut scratch) = (Worst::default(), Scratch::default());
    let mut touches = Touches::new();
    let cell = cell_of(&scene.domain);
    for (index, wall) in walls.iter().enumerate() {
        let wall = WallNow::new(wall, 0.0, &cell);
        if !wall.state.present {
            continue;
        }
        for sphere in &spheres {
            if sphere.fixed {
                continue;
            }
            // Planes push back from any depth: what is behind them overlaps them.
            let has_back = !matches!(wall.shape(), mercury_engine::walls::Shape::Plane(_));
            if has_back && wall.is_behind(&cell, sphere.centre, &mut scratch) {
                behind.add(1.0, (sphere.grain, index, 0.0));
            }
            for &code in wall.met_by() {
                let code = wall.image_of(sphere.centre, code);
                let centre = (wall.state).into_wall(sphere.centre + cell.any_shift(code));
                wall.shape().touches(centre, sphere.radius, &mut touches);
                for touch in touches.iter() {
                    let overlap = sphere.radius - touch.distance;
                    let part = overlap / sphere.radius;
                    if part > error_limit {
                        bad.add(part, (sphere.grain, index, overlap));
                    } else if part > warning_limit {
                        dubious.add(part, (sphere.grain, index, overlap));
                    }
                }
            }
        }
    }
    let words = |part: f64, (id, wall, overlap): (usize, usize, f64)| {
        format!(
            "{} overlaps wall `{}` by {} m at the start, {} of its radius",
            name(scene, start, id),
            walls[wall].name,
            short(overlap),
            short(part)
        )
    };
    if let Some((part, contact)) = bad.found {
        let message = format!(
            "{}; the limit is contact.overlap_error = {error_limit}{}",
            words(part, contact),
            bad.others("contact")
        );
        errors.push(place(scene, start, contact.0).error(message).with_help(
            "move it off the wall (more than 1: its centre is behind it), or raise the limit if this is meant",
        ));
    }
    if let Some((part, contact)) = dubious.found {
        warnings.push(format!(
            "{} (contact.overlap_warning = {warning_limit}){}",
            words(part, contact),
            dubious.others("contact")
        ));
    }
    if let Some((_, (id, wall, _))) = behind.found {
        warnings.push(format!(
            "{} starts behind wall `{}`, which acts on its other side{}",
            name(scene, start, id),
            walls[wall].name,
            match behind.count {
                1 => String::new(),
                count => format!("; so do {} more", count - 1),
            }
        ));
    }
    [touching, listed]
}

/// Warns about particles that sheets lead through, or nearly so, at the start.
pub(in crate::plan) fn through_sheets(
    scene: &Scene,
    start: &StartingParticles,
    clumps: &[Clump],
    sheets: &[MembranePlan],
    warnings: &mut Vec<String>,
) {
    let cell = cell_of(&scene.domain);
    let mut touches = Touches::new();
    for MembranePlan { surface: plan, .. } in sheets {
        // A mesh that cannot be made stops the run with its reason.
        let Ok((_, wall)) = Surface::new(plan) else {
            continue;
        };
        let mut wall = WallNow::new(&wall, 0.0, &cell);
        wall.set_surface(0, plan.thickness);
        let mut worst = Worst::default();
        for sphere in start.spheres(clumps) {
            for &code in wall.met_by() {
                let code = wall.image_of(sphere.centre, code);
                let centre = sphere.centre + cell.any_shift(code);
                let reach = sphere.radius + wall.half_thickness();
                (wall.shape()).touches(centre, reach, &mut touches);
                for touch in touches.iter() {
                    let part = (reach - touch.distance) / sphere.radius;
                    if part > *scene.contact.overlap_error {
                        worst.add(part, sphere.grain);
                    }
                }
            }
        }
        if let Some((part, grain)) = worst.found {
            warnings.push(format!(
                "membranes.{}: it leads through {} at the start, whose overlap is {} of its radius{}; move one of the two",
                plan.name,
                name(scene, start, grain),
                short(part),
                worst.others("contact")
            ));
        }
    }
}

/// Calls `found` with the places (ascending) and the overlap (m) of each pair that overlaps, images included, except pairs of
/// fixed particles. By the engine's own list, so that many particles cost little; returns its length.
fn for_each_touching_pair(
    scene: &Scene,
    spheres: &[StartingSphere],
    radii: [f64; 3],
    mut found: impl FnMut(usize, usize, f64),
) -> u64 {
    let cell = cell_of(&scene.domain);
    let mut particles = Particles::new(false);
    for new in spheres {
        let record = Particle {
            position: new.centre,
            radius: new.radius,
            velocity: DVec3::ZERO,
            // Only whether contacts can move it matters here.
            inverse_mass: if new.fixed { 0.0 } else { 1.0 },
            angular_velocity: DVec3::ZERO,
            material: MaterialIndex::new(0),
            flags: 0,
        };
        particles.push(record, 1.0, None);
    }
    if particles.is_empty() {
        return 0;
    }
    let skin = Skin::first(radii, 0.0, &cell).thickness;
    let levels = Levels::choose(&particles.records, skin);
    let list = build(
        &mut particles,
        &mut Vec::new(),
        &levels,
        &Margin::of_skin(skin),
        &cell,
        false,
    )
    .list;
    for row in 0..particles.len() {
        let one = particles.records[row];
        for entry in &list.entries[list.start[row] as usize..list.start[row + 1] as usize] {
            let other = particles.records[entry.partner as usize];
            let distance = (other.position + cell.shift(entry.image) - one.position).length();
            let overlap = one.radius + other.radius - distance;
            if overlap > 0.0 {
                let ids = [row, entry.partner as usize].map(|row| particles.ids[row].index());
                found(ids[0].min(ids[1]), ids[0].max(ids[1]), overlap);
            }
        }
    }
    list.entries.len() as u64
}

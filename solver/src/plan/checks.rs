//! Whether the scene makes sense as a whole: positions, overlaps, periodic axes, two dimensions.

use std::collections::HashMap;

use glam::DVec3;
use mercury_common::scene::{Place, Scene, SceneError, Shape};

use super::NewParticle;
use super::particles::{StartingParticles, StartingSphere, Typed};
use crate::bodies::Clump;
use crate::boundaries::InsertionPlan;
use crate::contact::parameter::short;
use crate::neighbours::{ExtraSkins, Images, Levels, Skin, build};
use crate::state::{MaterialIndex, Particle, Particles};
use crate::surface::{Surface, SurfacePlan};
use crate::walls::{Scratch, Touches, Wall, WallNow};

/// A periodic edge must hold two listing distances: contact and a skin, here of a twentieth.
const PERIODIC_ROOM: f64 = 1.05;
/// The tolerance of "the same z" and "in the plane", as a part of the radius or of a direction's length.
const FLAT: f64 = 1e-9;
/// If neighbouring numbers are farther apart than this part of a radius, positions are meaningless: overlaps are a thousandth of
/// it and less.
const COARSE: f64 = 1e-5;
/// Above this part of a radius forces have less than five digits of an overlap of a thousandth.
const COARSER_THAN_USUAL: f64 = 1e-8;

/// The name of a particle or body in messages: its id, or its number among the bodies, and the place where it was typed.
pub(super) fn name(scene: &Scene, start: &StartingParticles, grain: usize) -> String {
    let Typed { entry, line } = start.typed(grain);
    let key = scene.particles[entry].place.key();
    match (grain.checked_sub(start.particles.len()), line) {
        (Some(body), _) => format!("body {body} ({key})"),
        (None, Some(line)) => format!("particle {grain} ({key}, line {line} of its file)"),
        (None, None) => format!("particle {grain} ({key})"),
    }
}

/// Where a grain was typed.
pub(super) fn place<'a>(scene: &'a Scene, start: &StartingParticles, grain: usize) -> &'a Place {
    &scene.particles[start.typed(grain).entry].place
}

fn point(position: DVec3) -> String {
    let [x, y, z] = position.to_array().map(short);
    format!("[{x}, {y}, {z}]")
}

/// Every particle's and body's centre lies in the domain. One error per entry of `[[particles]]`.
pub(super) fn inside_the_domain(
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
        errors.push(
            place(scene, start, id)
                .error(message)
                .with_help("move it, or enlarge the domain"),
        );
    }
}

/// The resolution of positions is fine enough for contacts: numbers have 16 digits, so that far from the origin they lie apart by
/// more than an overlap. One error, and one warning, for the worst grain.
pub(super) fn far_from_the_origin(
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
pub(super) fn periodic_axes(
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
pub(super) fn flat(
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
pub(super) fn overlaps(
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
    let images = Images::new(*scene.domain.min, *scene.domain.max, scene.domain.periodic);
    for (index, wall) in walls.iter().enumerate() {
        let wall = WallNow::new(wall, 0.0, &images);
        if !wall.state.present {
            continue;
        }
        for sphere in &spheres {
            if sphere.fixed {
                continue;
            }
            // Planes push back from any depth: what is behind them overlaps them.
            let has_back = !matches!(wall.shape(), crate::walls::Shape::Plane(_));
            if has_back && wall.is_behind(&images, sphere.centre, &mut scratch) {
                behind.add(1.0, (sphere.grain, index, 0.0));
            }
            for &code in wall.met_by() {
                let code = wall.image_of(sphere.centre, code);
                let centre = (wall.state).into_wall(sphere.centre + images.any_shift(code));
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
pub(super) fn through_sheets(
    scene: &Scene,
    start: &StartingParticles,
    clumps: &[Clump],
    surfaces: &[SurfacePlan],
    warnings: &mut Vec<String>,
) {
    let images = Images::new(*scene.domain.min, *scene.domain.max, scene.domain.periodic);
    let mut touches = Touches::new();
    for plan in surfaces {
        // A mesh that cannot be made stops the run with its reason.
        let Ok((_, wall)) = Surface::new(plan) else {
            continue;
        };
        let wall = WallNow::new(&wall, 0.0, &images);
        let mut worst = Worst::default();
        for sphere in start.spheres(clumps) {
            for &code in wall.met_by() {
                let code = wall.image_of(sphere.centre, code);
                let centre = sphere.centre + images.any_shift(code);
                (wall.shape()).touches(centre, sphere.radius, &mut touches);
                for touch in touches.iter() {
                    let part = (sphere.radius - touch.distance) / sphere.radius;
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

/// Spheres in a cube any two of which overlap by more than the limit; so many make a list of all pairs long.
const CROWD: usize = 16;

/// Pairs that touch, for each sphere on the average: up to this number they are tested one by one, whatever the limit.
const MOST_TOUCHING: usize = 500;

/// The spheres of a cube any two of which overlap by more than a part of the smaller radius. Those of a grain come one after the other.
#[derive(Default)]
struct Cube {
    spheres: usize,
    /// The first grain and the last so far, with the spheres of each.
    first: (usize, usize),
    last: (usize, usize),
    /// Pairs of spheres of one grain, without those of the last.
    inner: usize,
}

impl Cube {
    fn add(&mut self, grain: usize) {
        let pairs = |spheres: usize| spheres * spheres.saturating_sub(1) / 2;
        if self.spheres == 0 {
            (self.first, self.last) = ((grain, 0), (grain, 0));
        }
        if self.last.0 != grain {
            self.inner += pairs(self.last.1);
            self.last = (grain, 0);
        }
        self.last.1 += 1;
        self.first.1 += usize::from(self.first.0 == grain);
        self.spheres += 1;
    }

    /// Spheres that are not of the first grain.
    fn others(&self) -> usize {
        self.spheres - self.first.1
    }

    /// Pairs of spheres of different grains.
    fn pairs(&self) -> f64 {
        let all = |spheres: usize| spheres as f64 * (spheres as f64 - 1.0) / 2.0;
        all(self.spheres) - self.inner as f64 - all(self.last.1)
    }

    fn ends(&self) -> (usize, usize) {
        (self.first.0, self.last.0)
    }
}

/// Cubes of spheres.
#[derive(Default)]
struct Cubes(HashMap<(i32, [u64; 3]), Cube>);

impl Cubes {
    /// Puts a sphere into its cube of those in which any two overlap by more than `limit` of the smaller radius, below 2.
    fn add(&mut self, sphere: &StartingSphere, limit: f64) -> &Cube {
        // Radii of a class differ by less than a factor of two: centres nearer than (2 - limit) of the least overlap by more than the limit.
        let class = libm::ilogb(sphere.radius);
        let edge = (2.0 - limit) * libm::scalbn(1.0, class) / 3.0_f64.sqrt();
        // Cells by the bits of their coordinates, which may be beyond all whole numbers.
        let cell = (sphere.centre / edge).floor() + DVec3::ZERO;
        let key = (class, cell.to_array().map(f64::to_bits));
        let cube = self.0.entry(key).or_default();
        cube.add(sphere.grain);
        cube
    }
}

/// Two overlapping grains, if there are such: spheres that are no pebbles of one body nor both fixed, each two of which overlap
/// by more than `limit` of the smaller radius. Checked before all pairs are listed, as those of a thousand spheres at one point
/// are a million.
fn crowded(spheres: &[StartingSphere], limit: f64) -> Option<(usize, usize)> {
    if limit >= 2.0 {
        return None;
    }
    let mut cubes = Cubes::default();
    for sphere in spheres.iter().filter(|sphere| !sphere.fixed) {
        let cube = cubes.add(sphere, limit);
        if cube.others() >= CROWD {
            return Some(cube.ends());
        }
    }
    None
}

/// Two grains of the largest crowd, if there are more pairs than can be looked at: where the limit allows for almost any overlap, and
/// among fixed spheres, which may overlap.
fn too_many(spheres: &[StartingSphere], limit: f64) -> Option<(usize, usize)> {
    let mut cubes = Cubes::default();
    // A grain below this limit that can move is in no crowd of more than some thousands.
    for sphere in spheres.iter().filter(|sphere| sphere.fixed || limit > 1.0) {
        cubes.add(sphere, 0.0);
    }
    let all: f64 = cubes.0.values().map(Cube::pairs).sum();
    if all <= MOST_TOUCHING as f64 * spheres.len() as f64 {
        return None;
    }
    // Of equal ones the first, whatever the order in memory.
    let crowds = cubes.0.values().filter(|cube| cube.others() > 0);
    let largest = crowds.max_by_key(|cube| (cube.others(), std::cmp::Reverse(cube.first)))?;
    Some(largest.ends())
}

/// Calls `found` with the places (ascending) and the overlap (m) of each pair that overlaps, images included, except pairs of
/// fixed particles. By the engine's own list, so that many particles cost little; returns its length.
fn for_each_touching_pair(
    scene: &Scene,
    spheres: &[StartingSphere],
    radii: [f64; 3],
    mut found: impl FnMut(usize, usize, f64),
) -> u64 {
    let images = Images::new(*scene.domain.min, *scene.domain.max, scene.domain.periodic);
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
    let skin = Skin::first(radii, 0.0, &images).thickness;
    let levels = Levels::choose(&particles.records, skin);
    let list = build(
        &mut particles,
        &mut ExtraSkins::default(),
        &levels,
        skin,
        &images,
        false,
    )
    .list;
    for row in 0..particles.len() {
        let one = particles.records[row];
        for entry in &list.entries[list.start[row] as usize..list.start[row + 1] as usize] {
            let other = particles.records[entry.partner as usize];
            let distance = (other.position + images.shift(entry.image) - one.position).length();
            let overlap = one.radius + other.radius - distance;
            if overlap > 0.0 {
                let ids = [row, entry.partner as usize].map(|row| particles.ids[row].index());
                found(ids[0].min(ids[1]), ids[0].max(ids[1]), overlap);
            }
        }
    }
    list.entries.len() as u64
}

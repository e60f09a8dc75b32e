//! Liquid bridges against the grains that they join.

use std::f64::consts::PI;
use std::sync::Arc;

use mercury_common::scene::{LawValues, Located, Scene, SceneError, SourceSpan};

use crate::plan::PairPlan;
use crate::plan::particles::StartingParticles;
use mercury_engine::bodies::Clump;
use mercury_engine::boundaries::InsertionPlan;
use mercury_engine::contact::AnyAdhesion;
use mercury_engine::contact::adhesion::liquid::{Fit, Liquid, Tables, reduced_diameter};
use mercury_engine::contact::adhesion::young_laplace::Table;
use mercury_engine::contact::parameter::short;

/// Finds every `max_bridge_volume` above the volume of the smallest grain of its material, in `[[contacts]]` of either material. Materials
/// of which there are no grains (those of walls) have no such bound.
pub(crate) fn larger_than_grains(
    scene: &Scene,
    start: &StartingParticles,
    clumps: &[Clump],
    insertions: &[InsertionPlan],
    errors: &mut Vec<SceneError>,
) {
    let smallest = smallest_diameters(scene, start, clumps, insertions);
    for (material, &diameter) in scene.materials.iter().zip(&smallest) {
        if let Some(law) = &material.liquid {
            let name = &material.name.value;
            errors.extend(too_large(&law.values, name, diameter));
        }
    }
    for contact in &scene.contacts {
        let Some(law) = &contact.liquid else {
            continue;
        };
        let [a, b] = [0, 1].map(|side| contact.between[side].value.0);
        let smaller = if smallest[b] < smallest[a] { b } else { a };
        let name = &scene.materials[smaller].name.value;
        errors.extend(too_large(&law.values, name, smallest[smaller]));
    }
}

fn too_large(values: &LawValues, material: &str, diameter: f64) -> Option<SceneError> {
    let key = "max_bridge_volume";
    let (most, grain) = (
        values.number(key)?,
        PI / 6.0 * diameter * diameter * diameter,
    );
    // A diameter that was computed from a volume is not more exact than this.
    (most > grain * (1.0 + 1e-12)).then(|| {
        let message = format!(
            "is larger than the smallest grain of `{material}`, which has a diameter of {} m and {} m3, got {} m3",
            short(diameter),
            short(grain),
            short(most)
        );
        let help = format!(
            "a bridge holds a small part of a grain; give at most {} m3 (0.01 of it), or check the unit: 1 mm3 is 1e-9 m3",
            short(0.01 * grain)
        );
        values.get(key).map(|given| given.error(message).with_help(help))
    })?
}

/// Diameter of the smallest grain of each material, of a clump that of a sphere of its volume, m; infinite where there is none.
fn smallest_diameters(
    scene: &Scene,
    start: &StartingParticles,
    clumps: &[Clump],
    insertions: &[InsertionPlan],
) -> Vec<f64> {
    let mut smallest = vec![f64::INFINITY; scene.materials.len()];
    let mut note = |material: usize, diameter: f64| {
        smallest[material] = smallest[material].min(diameter);
    };
    for particle in &start.particles {
        note(particle.material.index(), 2.0 * particle.radius);
    }
    for body in &start.bodies {
        let clump = &clumps[body.clump as usize];
        let diameter = clump.equal_volume_diameter() * body.scale;
        note(clump.material.index(), diameter);
    }
    for part in insertions.iter().flat_map(|insertion| &insertion.mixture) {
        note(part.material.index(), part.sizes.smallest());
    }
    smallest
}

/// Smallest and largest radius of the spheres of each material, those of clumps included, m; an empty range where there is none.
pub(crate) fn radii_of_materials(
    scene: &Scene,
    start: &StartingParticles,
    clumps: &[Clump],
    insertions: &[InsertionPlan],
) -> Vec<[f64; 2]> {
    let mut radii = vec![[f64::INFINITY, 0.0]; scene.materials.len()];
    let mut note = |material: usize, [least, most]: [f64; 2]| {
        let known = &mut radii[material];
        *known = [known[0].min(least), known[1].max(most)];
    };
    for particle in &start.particles {
        note(particle.material.index(), [particle.radius; 2]);
    }
    for body in &start.bodies {
        let clump = &clumps[body.clump as usize];
        let (least, most) = clump.pebble_radii();
        note(
            clump.material.index(),
            [least * body.scale, most * body.scale],
        );
    }
    for part in insertions.iter().flat_map(|insertion| &insertion.mixture) {
        let (least, most) = part.clump.map_or((0.5, 0.5), |index| {
            let clump = &clumps[index as usize];
            let (least, most) = clump.pebble_radii();
            let diameter = clump.equal_volume_diameter();
            (least / diameter, most / diameter)
        });
        let range = [part.sizes.smallest() * least, part.sizes.largest() * most];
        note(part.material.index(), range);
    }
    radii
}

/// Radii whose ratio is smaller differ too much for the formulas, which are for spheres of one size: their force at the touch is then off by
/// more than 3 %.
const WIDE: f64 = 0.2;

/// Warns of pairs of particles whose radii differ too much for the formulas.
pub(crate) fn wide_ratios(pairs: &[PairPlan], radii: &[[f64; 2]]) -> Vec<String> {
    let warning = |pair: &PairPlan| {
        let liquid = pair.law.adhesion.liquid()?;
        if liquid.fit == Fit::YoungLaplace || !pair.between_particles {
            return None;
        }
        let [a, b] = pair.materials.map(|material| radii[material.index()]);
        let ratio = f64::min(a[0] / b[1], b[0] / a[1]);
        (ratio < WIDE && a[1] > 0.0 && b[1] > 0.0).then(|| {
            format!(
                "{}: radii in a ratio of 1 to {}; `{}` was fitted to spheres of one size, and its force is off by more than 3 % beyond 1 to 5; the law `young-laplace` has every ratio",
                names(pair),
                short(1.0 / ratio),
                liquid.fit.name()
            )
        })
    };
    pairs.iter().filter_map(warning).collect()
}

/// Volumes for each power of ten, and powers of ten, over which a law is searched for poles: below, the shape of its force is that of the
/// smallest bridge that it was fitted to.
const SEARCHED: (i32, i32) = (50, 6);

/// Radii of each material for which it is searched, between the smallest and the largest.
const RADII: usize = 9;

/// Refuses laws whose force has a pole in the gap of a bridge that the pair may have: of any volume up to the largest, between any two
/// of its sizes or one and a wall.
pub(crate) fn poles(
    scene: &Scene,
    pairs: &[PairPlan],
    radii: &[[f64; 2]],
    errors: &mut Vec<SceneError>,
) {
    for pair in pairs {
        let Some(liquid) = pair.law.adhesion.liquid() else {
            continue;
        };
        let Some((volume, sizes)) = smallest_with_pole(pair, liquid, radii) else {
            continue;
        };
        let diameter = reduced_diameter(sizes);
        let between = match sizes {
            [radius, f64::INFINITY] => format!("of a sphere of {} m at a wall", short(radius)),
            [a, b] => format!("between spheres of {} m and {} m", short(a), short(b)),
        };
        let message = format!(
            "{}: at a contact angle of {} degrees `{}` has no force for a bridge of {} m3 (V/R_D^3 = {}) {between}: its formula grows beyond all bounds within the gap, and max_bridge_volume is {} m3",
            names(pair),
            short(liquid.contact_angle.to_degrees()),
            liquid.fit.name(),
            short(volume),
            short(volume / (diameter * diameter * diameter)),
            short(liquid.max_volume),
        );
        let help = "give the law `young-laplace`, which is exact up to 90 degrees, or a smaller max_bridge_volume or contact angle";
        let place = place_of(scene, pair, "max_bridge_volume");
        errors.push(place.error(message).with_help(help));
    }
}

/// The smallest volume (m^3) of those that were looked at for which a law has a pole, and the radii (m; infinite at a wall).
fn smallest_with_pole(
    pair: &PairPlan,
    liquid: &Liquid,
    radii: &[[f64; 2]],
) -> Option<(f64, [f64; 2])> {
    let tables = Tables::default();
    let (per_ten, tens) = SEARCHED;
    let volumes = (0..=per_ten * tens).rev().map(|k| {
        let share = libm::exp10(-f64::from(k) / f64::from(per_ten));
        liquid.max_volume * share
    });
    let [a, b] = pair.materials.map(|material| radii[material.index()]);
    let smallest = a[0].min(b[0]);
    let is_any = |volume: f64| liquid.has_pole(volume, [smallest; 2], &tables);
    // Of one volume the bridge between equal spheres is the longest, and that between the smallest the largest for its grains.
    if !smallest.is_finite() || !volumes.clone().any(is_any) {
        return None;
    }
    let all = |[least, most]: [f64; 2]| {
        (0..RADII).map(move |k| {
            let share = k as f64 / (RADII - 1) as f64;
            least * libm::pow(most / least, share)
        })
    };
    let there = |radii: [f64; 2]| radii[1] > 0.0;
    let mut sizes: Vec<[f64; 2]> = Vec::new();
    if pair.between_particles && there(a) && there(b) {
        for one in all(a) {
            sizes.extend(all(b).map(|other| [one, other]));
            sizes.push([one, one.clamp(b[0], b[1])]);
        }
    }
    if pair.at_walls {
        for of_grains in [a, b].into_iter().filter(|radii| there(*radii)) {
            sizes.extend(all(of_grains).map(|one| [one, f64::INFINITY]));
        }
    }
    let mut all = volumes.flat_map(|volume| sizes.iter().map(move |&sizes| (volume, sizes)));
    all.find(|&(volume, sizes)| liquid.has_pole(volume, sizes, &tables))
}

/// Refuses a `roughness` of at least the gap at which the longest bridge of the pair breaks: the viscous force would be the same at every
/// gap.
pub(crate) fn rough(scene: &Scene, pairs: &[PairPlan], errors: &mut Vec<SceneError>) {
    for pair in pairs {
        let Some(liquid) = pair.law.adhesion.liquid() else {
            continue;
        };
        let Some(roughness) =
            (liquid.roughness).filter(|&least| liquid.range > 0.0 && least >= liquid.range)
        else {
            continue;
        };
        let message = format!(
            "{}: a roughness of {} m, and the longest bridge breaks at a gap of {} m: the viscous force would be that of the roughness at every gap",
            names(pair),
            short(roughness),
            short(liquid.range)
        );
        let help = "roughness is the least gap of the viscous force, as of asperities, far below the size of a bridge; check the unit, or leave it out: R*/100";
        let place = place_of(scene, pair, "roughness");
        errors.push(place.error(message).with_help(help));
    }
}

/// Volumes over R_D^3 for which tables of exact bridges are made, and the smallest one that every table has.
const VOLUMES: (f64, f64) = (1e-5, 0.5);
const SMALL: f64 = 1e-4;

/// Accuracy of tables that are made for the areas of bridges alone, from which liquid evaporates.
const OF_AREA: f64 = 1e-2;

/// Range of a table: bridges that it is made for.
struct Wanted {
    theta: f64,
    accuracy: f64,
    volumes: (f64, f64),
    ratios: (f64, f64),
    /// The pairs that take it.
    pairs: Vec<usize>,
}

/// Makes the tables of exact bridges that the pairs need, one for all pairs of the same contact angle and accuracy. Bridges smaller than
/// those of a table are counted when they form; larger ones are refused here.
pub(crate) fn tables(
    scene: &Scene,
    pairs: &mut [PairPlan],
    radii: &[[f64; 2]],
    notes: &mut Vec<String>,
    errors: &mut Vec<SceneError>,
) -> Tables {
    let mut wanted: Vec<Wanted> = Vec::new();
    for (index, pair) in pairs.iter().enumerate() {
        let Some(&liquid) = pair.law.adhesion.liquid() else {
            continue;
        };
        let for_force = liquid.fit == Fit::YoungLaplace;
        if !for_force && *scene.liquid.evaporation == 0.0 {
            continue;
        }
        let Some((mut volumes, ratios)) = ranges(pair, &liquid, radii) else {
            continue;
        };
        if for_force && (volumes.1 > VOLUMES.1 || volumes.1 < VOLUMES.0) {
            errors.push(beyond_tables(scene, pair, volumes.1));
            continue;
        }
        let within = |volume: f64| volume.clamp(VOLUMES.0, VOLUMES.1);
        volumes = (within(volumes.0), within(volumes.1));
        let accuracy = if for_force { liquid.accuracy } else { OF_AREA };
        let same =
            |other: &&mut Wanted| (other.theta, other.accuracy) == (liquid.contact_angle, accuracy);
        match wanted.iter_mut().find(same) {
            Some(other) => {
                let (v, r) = (&mut other.volumes, &mut other.ratios);
                *v = (v.0.min(volumes.0), v.1.max(volumes.1));
                *r = (r.0.min(ratios.0), r.1.max(ratios.1));
                other.pairs.push(index);
            }
            None => wanted.push(Wanted {
                theta: liquid.contact_angle,
                accuracy,
                volumes,
                ratios,
                pairs: vec![index],
            }),
        }
    }
    let mut tables = Tables::default();
    for table in wanted {
        let made = Table::new(table.theta, table.volumes, table.ratios, table.accuracy);
        let made = match made {
            Ok(made) => Arc::new(made),
            Err(error) => {
                let pair = &pairs[table.pairs[0]];
                let message = format!("{}: {error}", names(pair));
                let help = "give a larger `accuracy`, or a smaller range of volumes and radii";
                errors.push(
                    place_of(scene, pair, "accuracy")
                        .error(message)
                        .with_help(help),
                );
                continue;
            }
        };
        let number = tables.add(&made);
        let all: Vec<String> = table
            .pairs
            .iter()
            .map(|&pair| names(&pairs[pair]))
            .collect();
        notes.push(format!(
            "liquid bridges of {}: a table of {} exact ones for {} degrees, V/R_D^3 from {} to {}, ratios of radii from {} to {}; largest errors {:.1e} of the force, {:.1e} of the end",
            all.join(", "),
            made.bridges(),
            short(table.theta.to_degrees()),
            short(table.volumes.0),
            short(table.volumes.1),
            short(table.ratios.0),
            short(table.ratios.1),
            made.errors().force,
            made.errors().end,
        ));
        for pair in table.pairs {
            if let AnyAdhesion::Liquid(liquid) = &mut pairs[pair].law.adhesion {
                liquid.table = number;
            }
        }
    }
    tables
}

/// Volumes over R_D^3 and ratios of radii of the bridges of a pair; `None` if there are no particles.
fn ranges(
    pair: &PairPlan,
    liquid: &Liquid,
    radii: &[[f64; 2]],
) -> Option<((f64, f64), (f64, f64))> {
    let [a, b] = pair.materials.map(|material| radii[material.index()]);
    let (mut diameters, mut ratios) = ((f64::INFINITY, 0.0f64), (f64::INFINITY, 0.0f64));
    let mut note = |diameter: [f64; 2], ratio: [f64; 2]| {
        diameters = (diameters.0.min(diameter[0]), diameters.1.max(diameter[1]));
        ratios = (ratios.0.min(ratio[0]), ratios.1.max(ratio[1]));
    };
    if pair.between_particles && a[1] > 0.0 && b[1] > 0.0 {
        let least = f64::min(a[0] / b[1], b[0] / a[1]).min(1.0);
        let most = f64::min(a[1] / b[0], b[1] / a[0]).min(1.0);
        let diameter = [0, 1].map(|k| reduced_diameter([a[k], b[k]]));
        note(diameter, [least, most]);
    }
    if pair.at_walls {
        for [least, most] in [a, b].into_iter().filter(|radii| radii[1] > 0.0) {
            note([2.0 * least, 2.0 * most], [0.0, 0.0]);
        }
    }
    let relative = |diameter: f64| liquid.max_volume / (diameter * diameter * diameter);
    let (largest, of_largest_grains) = (relative(diameters.0), relative(diameters.1));
    let smallest = (0.1 * of_largest_grains)
        .clamp(VOLUMES.0, SMALL)
        .min(largest);
    (diameters.1 > 0.0).then_some(((smallest, largest), ratios))
}

/// `A and B`.
fn names(pair: &PairPlan) -> String {
    pair.names.each_ref().map(String::as_str).join(" and ")
}

/// Where a key of the liquid of a pair stands, or else the law.
fn place_of(scene: &Scene, pair: &PairPlan, key: &str) -> SourceSpan {
    let materials = pair.materials.map(|material| material.index());
    let of_pair = |between: &[Located<mercury_common::scene::MaterialIndex>; 2]| {
        let mut between = [between[0].value.0, between[1].value.0];
        between.sort_unstable();
        between == materials
    };
    let over = (scene.contacts.iter())
        .filter(|contact| of_pair(&contact.between))
        .filter_map(|contact| contact.liquid.as_ref())
        .find_map(|law| law.values.get(key).map(|given| given.place.clone()));
    let own = || {
        let laws = materials.map(|material| scene.materials[material].liquid.as_ref());
        let of_key = |law: &&mercury_common::scene::Law| {
            law.values.get(key).map(|given| given.place.clone())
        };
        let mut laws = laws.into_iter().flatten();
        let first = laws.clone().next().map(|law| law.place.clone());
        laws.find_map(|law| of_key(&law)).or(first)
    };
    over.or_else(own).unwrap_or_else(|| scene.place.clone())
}

fn beyond_tables(scene: &Scene, pair: &PairPlan, volume: f64) -> SceneError {
    let (least, most) = VOLUMES;
    let message = format!(
        "{}: a bridge of max_bridge_volume between the smallest particles has V/R_D^3 = {}; the tables of `young-laplace` go from {} to {}",
        names(pair),
        short(volume),
        short(least),
        short(most)
    );
    let help = if volume > most {
        "give a smaller max_bridge_volume"
    } else {
        "give a larger max_bridge_volume, or the law `willett-classical`, which is right for small bridges"
    };
    place_of(scene, pair, "max_bridge_volume")
        .error(message)
        .with_help(help)
}

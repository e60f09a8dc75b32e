//! `[[bonds]]` as the engine's plans, and what they glue at the start.

use mercury_common::scene::{
    BondLaw, BondPoisson, BondTime, Bonds, Dimensions, Located, Scene, SceneError,
};

use crate::boundaries::plan::insertions::region;
use crate::plan::cell_of;
use crate::plan::particles::StartingParticles;
use crate::plan::usage::MaterialUse;
use mercury_engine::bodies::Clump;
use mercury_engine::bonds::{
    BondPlan, BondedStart, Gluing, LawOfBonds, SmallestGrain, StartOfBonds, look_ahead,
};
use mercury_engine::contact::parameter::short;
use mercury_engine::state::{Material, MaterialIndex};
use mercury_engine::walls::Wall;

/// All entries, in the order of the file.
pub(crate) fn bonds(
    scene: &Scene,
    walls: &[Wall],
    warnings: &mut Vec<String>,
    errors: &mut Vec<SceneError>,
) -> Vec<BondPlan> {
    let Some(first) = scene.bonds.first() else {
        return Vec::new();
    };
    if scene.domain.dimensions == Dimensions::Two {
        let error = first
            .place
            .error("bonds need three dimensions: their section is round");
        errors.push(error.with_help("set domain.dimensions = 3, or leave out [[bonds]]"));
        return Vec::new();
    }
    if let Some(wet) = scene
        .materials
        .iter()
        .find(|material| material.liquid.is_some())
        && let Some(entry) =
            (scene.bonds.iter()).find(|entry| entry.when == BondTime::Contact && !entry.contact)
    {
        let message = format!(
            "the contact of a pair that is glued at a touch would end with its liquid bridge, but \"{}\" has `liquid`",
            wet.name.value
        );
        let error = entry.place.error(message);
        errors.push(error.with_help("set contact = true, or leave out `liquid`"));
    }
    (scene.bonds.iter())
        .map(|entry| plan_one(entry, walls, warnings, errors))
        .collect()
}

fn plan_one(
    entry: &Bonds,
    walls: &[Wall],
    warnings: &mut Vec<String>,
    errors: &mut Vec<SceneError>,
) -> BondPlan {
    // Keys of the other time of gluing would do nothing.
    let given = match entry.when {
        BondTime::Start => [
            (*entry.from > 0.0).then_some(&entry.from),
            entry.until.as_ref(),
        ],
        BondTime::Contact => [entry.reach.as_ref(), None],
    };
    let when = match entry.when {
        BondTime::Start => "start",
        BondTime::Contact => "contact",
    };
    for key in given.into_iter().flatten() {
        errors.push(key.error(format!(
            "cannot be given together with `when = \"{when}\"`: choose one"
        )));
    }
    let strength =
        |strength: &Option<Located<f64>>| strength.as_deref().copied().unwrap_or(f64::INFINITY);
    let strengths = [&entry.tensile_strength, &entry.shear_strength].map(strength);
    if *entry.strength_spread > 0.0 && strengths == [f64::INFINITY; 2] {
        warnings.push(format!(
            "{}: nothing is spread, as the bonds have no strength; give tensile_strength or shear_strength, or leave the key out",
            entry.strength_spread.place.key()
        ));
    }
    BondPlan {
        name: entry.name.value.clone(),
        between: (entry.between.as_ref())
            .map(|pair| [0, 1].map(|k| MaterialIndex::new(pair[k].value.0 as u32))),
        when: match entry.when {
            BondTime::Start => Gluing::Start(entry.reach.as_deref().copied()),
            BondTime::Contact => Gluing::Contact {
                from: *entry.from,
                until: entry.until.as_deref().copied().unwrap_or(f64::INFINITY),
            },
        },
        within: (entry.within.as_ref()).and_then(|within| region(within, warnings, errors)),
        walls: (entry.walls.iter())
            .flat_map(|name| walls_of(name, walls, errors))
            .collect(),
        law: match entry.law {
            BondLaw::Beam {
                youngs_modulus,
                poisson_ratio,
            } => LawOfBonds::Beam {
                youngs_modulus,
                poisson_ratio: match poisson_ratio {
                    BondPoisson::Number(ratio) => Some(ratio),
                    BondPoisson::RigidInShear => None,
                },
            },
            BondLaw::Parallel {
                normal_stiffness,
                shear_stiffness,
            } => LawOfBonds::Parallel {
                normal_stiffness,
                shear_stiffness,
            },
        },
        radius_ratio: entry.radius_ratio,
        damping: entry.damping,
        strengths,
        strength_spread: *entry.strength_spread,
        contact: entry.contact,
    }
}

/// The walls of this name; that of a box has several, one for each face.
fn walls_of(name: &Located<String>, walls: &[Wall], errors: &mut Vec<SceneError>) -> Vec<usize> {
    let faces = format!("{}.", name.value);
    let found: Vec<usize> = (walls.iter().enumerate())
        .filter(|(_, wall)| wall.name == name.value || wall.name.starts_with(&faces))
        .map(|(index, _)| index)
        .collect();
    if found.is_empty() {
        let names: Vec<&str> = walls.iter().map(|wall| wall.name.as_str()).collect();
        let help = if names.is_empty() {
            "the scene has no walls".to_owned()
        } else {
            format!("the walls are {}", names.join(", "))
        };
        let error = name.error(format!("there is no wall \"{}\"", name.value));
        errors.push(error.with_help(help));
    }
    found
}

/// Pairs that the bonds glue at the start, and the largest stable step. An entry that glues nothing at the start is an error.
pub(crate) fn bonded_start(
    scene: &Scene,
    plans: &[BondPlan],
    start: &StartingParticles,
    (clumps, walls): (&[Clump], &[Wall]),
    uses: &[MaterialUse],
    errors: &mut Vec<SceneError>,
) -> Option<BondedStart> {
    if plans.is_empty() {
        return None;
    }
    let materials: Vec<Material> = (scene.materials.iter())
        .map(|material| Material {
            name: material.name.value.clone(),
            density: *material.density,
        })
        .collect();
    let cell = cell_of(&scene.domain);
    let grains: Vec<SmallestGrain> = (uses.iter().enumerate())
        .filter(|(_, used)| used.free > 0)
        .map(|(index, used)| SmallestGrain {
            material: MaterialIndex::new(index as u32),
            radius: used.smallest_free,
            density: materials[index].density,
        })
        .collect();
    let start_of_bonds = StartOfBonds {
        materials: &materials,
        dimensions: 3,
        particles: &start.particles,
        bodies: &start.bodies,
        clumps,
        walls,
        cell: &cell,
        seed: scene.seed,
    };
    let found = look_ahead(plans, &start_of_bonds, &grains);
    // A sketch has few particles.
    if start.left_out == Default::default() {
        for (entry, made) in scene.bonds.iter().zip(&found.made) {
            if entry.when == BondTime::Start && *made == 0 {
                let message = format!(
                    "the bonds \"{}\" glue nothing: no pair of the start is that near, or earlier entries glue them all",
                    entry.name.value
                );
                errors.push(entry.place.error(message).with_help(
                    "give a larger reach, check between, within and walls, or use when = \"contact\" for particles that come later",
                ));
            }
        }
    }
    Some(found)
}

/// Bonds that an entry glues, and the step that it bears, in words.
pub(crate) fn describe(plan: &BondPlan, number: usize, start: &BondedStart) -> String {
    let mut words = match plan.when {
        Gluing::Start(_) => {
            let mut words = format!("{} bonds at the start", start.made[number]);
            if !plan.walls.is_empty() {
                words += &format!(", {} of them to walls", start.to_walls[number]);
            }
            words
        }
        Gluing::Contact { from, until } => {
            let mut words = format!("pairs that touch from {} s", short(from));
            if until.is_finite() {
                words += &format!(" until {} s", short(until));
            }
            words
        }
    };
    let critical = start.critical[number];
    if critical.is_finite() {
        words += &format!("; critical step {} s", short(critical));
    }
    words
}

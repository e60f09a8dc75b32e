//! `[[insertions]]` and `[[deletions]]` as the engine's plans.

mod expected;
mod quota;
mod region;
mod space;

use std::path::Path;

use mercury_common::curve::Curve;
use mercury_common::error::FormatError;
use mercury_common::formats::time_table::TimeTable;
use mercury_common::scene::{
    Body, Component, Insertion, Located, Method, Psd, Quantity, Rate as SceneRate, Scene,
    SceneError, SizeLaw, Target, Total, listed, nearest,
};
use mercury_common::sizes::{SizeDistribution, SizeError};

use super::regions::DomainBox;
use crate::plan::cell_of;
use mercury_engine::bodies::Clump;
use mercury_engine::boundaries::{
    DeletionPlan, Ingredient, InsertionPlan, Rate, Region, Space, mean_volume,
};
use mercury_engine::state::MaterialIndex;

pub(crate) use expected::{expected_inserted, grains_per_unit};
pub(crate) use region::region;
pub(crate) use space::check_among_walls;

use quota::wrong_quota;
use space::{ALMOST_ALL, check_large, check_room, spheres};

/// All insertions that can be planned, in the order of the file. No `clumps`: they could not be read.
pub(crate) fn insertions(
    scene: &Scene,
    room: &DomainBox,
    clumps: Option<&[Clump]>,
    dimensions: u8,
    warnings: &mut Vec<String>,
    errors: &mut Vec<SceneError>,
) -> Vec<InsertionPlan> {
    scene
        .insertions
        .iter()
        .filter_map(|insertion| {
            plan_one(scene, insertion, room, clumps, dimensions, warnings, errors)
        })
        .collect()
}

/// Reads a table `t,cumulative`: times (s) and amounts that do not decrease.
#[allow(
    clippy::result_large_err,
    reason = "a file is read once; the error type is shared by all readers"
)]
fn rate_table(path: &Path) -> Result<Curve, FormatError> {
    let rows = TimeTable::new(["t", "cumulative"]).read(path)?;
    let mut before = 0.0;
    for row in &rows {
        let amount = row.values[1];
        if amount < before {
            let found = format!("cumulative = {amount}");
            let expected = format!("at least {before}: amounts do not decrease from 0 on");
            return Err(FormatError::at(path, row.line, None, found, expected));
        }
        before = amount;
    }
    Ok(Curve::of_table(&rows, |row| row[1]))
}

/// All deletions, in the order of the file.
pub(crate) fn deletions(
    scene: &Scene,
    warnings: &mut Vec<String>,
    errors: &mut Vec<SceneError>,
) -> Vec<DeletionPlan> {
    scene
        .deletions
        .iter()
        .filter_map(|deletion| {
            Some(DeletionPlan {
                name: deletion.name.value.clone(),
                region: region(&deletion.region, warnings, errors)?,
            })
        })
        .collect()
}

fn plan_one(
    scene: &Scene,
    insertion: &Insertion,
    room: &DomainBox,
    clumps: Option<&[Clump]>,
    dimensions: u8,
    warnings: &mut Vec<String>,
    errors: &mut Vec<SceneError>,
) -> Option<InsertionPlan> {
    let before = errors.len();
    let mut mixture = Vec::new();
    for component in &insertion.mixture {
        let (material, clump) = match &component.body {
            Body::Sphere(material) => (material.value, None),
            // The scene is refused already.
            Body::Clump(_) if clumps.is_none() => return None,
            Body::Clump(clump) => {
                let template = scene.clumps.get(clump.value.0)?;
                (template.material.value, Some(clump.value.0 as u32))
            }
        };
        let own = clump.and_then(|index| clumps?.get(index as usize));
        let sizes = match sizes(component, own) {
            Ok(sizes) => sizes,
            Err(error) => {
                errors.push(error);
                continue;
            }
        };
        if component.share > 0.0
            && let Some(fines) = sizes.warning_of_fines()
        {
            let place = component
                .psd
                .as_ref()
                .map_or(&component.place, |psd| &psd.place);
            errors.push(
                place
                    .error("has no smallest particle, so that no time step is short enough")
                    .with_help(fines),
            );
            continue;
        }
        let mean_volume = mean_volume(&sizes, dimensions);
        // A share of mass or volume is turned into a number of particles by their mean size.
        let per_particle = match insertion.share_by {
            Quantity::Number => 1.0,
            Quantity::Volume => mean_volume,
            Quantity::Mass => mean_volume * *scene.materials.get(material.0)?.density,
        };
        mixture.push(Ingredient {
            material: MaterialIndex::new(material.0 as u32),
            clump,
            sizes,
            share: component.share / per_particle,
            properties: component.properties.clone(),
        });
    }
    let sum: f64 = mixture.iter().map(|ingredient| ingredient.share).sum();
    for ingredient in &mut mixture {
        ingredient.share /= sum;
    }
    let own = region(&insertion.region, warnings, errors);
    let total = match &insertion.total {
        Some(target) => Some(total_of(scene, target, own.as_ref(), room, errors)?),
        None => None,
    };
    let rate = insertion.rate.as_ref().and_then(|rate| {
        let steady = |quantity, per_second| {
            Some(Rate::Steady {
                quantity,
                per_second,
            })
        };
        match &rate.value {
            SceneRate::Number(per_second) => steady(Quantity::Number, *per_second),
            SceneRate::Mass(per_second) => steady(Quantity::Mass, *per_second),
            SceneRate::Volume(per_second) => steady(Quantity::Volume, *per_second),
            SceneRate::Table(file) => match rate_table(file) {
                // The table counts what the total counts.
                Ok(amounts) => Some(Rate::Table {
                    quantity: match total {
                        Some(Total::Number(_)) => Quantity::Number,
                        Some(Total::Volume(_)) => Quantity::Volume,
                        _ => Quantity::Mass,
                    },
                    amounts,
                }),
                Err(error) => {
                    errors.push(rate.error(error.to_string()));
                    None
                }
            },
        }
    });
    let region = own?;
    if errors.len() == before {
        let space = Space {
            cell: &cell_of(&scene.domain),
            dimensions,
        };
        let clumps = clumps.unwrap_or_default();
        let name = &insertion.name.value;
        let smallest = spheres(&mixture, clumps, SizeDistribution::smallest).fold(
            (f64::INFINITY, false),
            |least, next| {
                if next.0 < least.0 { next } else { least }
            },
        );
        let large = spheres(&mixture, clumps, |sizes| sizes.sample_diameter(ALMOST_ALL)).fold(
            (0.0, false),
            |most, next| if next.0 > most.0 { next } else { most },
        );
        let room = check_room(name, &region, smallest, space)
            .and_then(|()| check_large(name, &region, large, space));
        if let Err((message, help)) = room {
            errors.push(insertion.region.error(message).with_help(help));
        }
    }
    let by_quota = insertion.method.value == Method::Quota;
    if errors.len() == before && by_quota {
        errors.extend(wrong_quota(scene, insertion, &mixture, total, dimensions));
    }
    (errors.len() == before).then(|| InsertionPlan {
        name: insertion.name.value.clone(),
        region,
        mixture,
        by_quota,
        total,
        rate,
        velocity_mean: *insertion.velocity_mean,
        velocity_spread: *insertion.velocity_spread,
        from: *insertion.from,
        until: insertion.until.as_deref().copied().unwrap_or(f64::INFINITY),
        attempts: (*insertion.attempts).max(1),
        closing: Vec::new(),
    })
}

/// Total at which an insertion ends; `own`: its region.
fn total_of(
    scene: &Scene,
    target: &Target,
    own: Option<&Region>,
    room: &DomainBox,
    errors: &mut Vec<SceneError>,
) -> Option<Total> {
    let (fraction, of) = match target {
        Target::Of(total) => return Some(*total),
        Target::Fill { fraction, of } => (fraction, of),
    };
    let Some(of) = of else {
        return Some(Total::Volume(fraction * room.volume_of(own?.clone())));
    };
    let Some(named) = scene
        .regions
        .iter()
        .find(|named| named.name.value == of.value)
    else {
        let error = of.error(format!("there is no region {:?}", of.value));
        let names = || scene.regions.iter().map(|named| named.name.as_str());
        errors.push(match nearest(&of.value, names()) {
            Some(near) => error.with_help(format!("did you mean `{near}`?")),
            None if scene.regions.is_empty() => {
                error.with_help("an entry of [[regions]] with this name is needed")
            }
            None => error.with_help(format!("there are: {}", listed(names()))),
        });
        return None;
    };
    // An error of the region is reported where the region is counted.
    let region = region(&named.region, &mut Vec::new(), &mut Vec::new())?;
    Some(Total::Volume(fraction * room.volume_of(region)))
}

/// The sizes of a component; a clump without a distribution has its own size.
fn sizes(component: &Component, clump: Option<&Clump>) -> Result<SizeDistribution, SceneError> {
    let Some(psd) = &component.psd else {
        let own = clump.and_then(|clump| SizeDistribution::single(clump.equal_volume_diameter()));
        return own.ok_or_else(|| component.place.error("the size of the clump is not known"));
    };
    SizeDistribution::from_scene(psd).map_err(|error| match error {
        SizeError::Improper(error) => error,
        SizeError::File(error) => of_file(psd, error),
        error @ SizeError::Law(_) => psd.error(error.to_string()),
    })
}

/// The error in the table that a scene names, at the place of the name.
fn of_file(psd: &Located<Psd>, mut error: FormatError) -> SceneError {
    let help = error.help.take();
    let error = match &psd.law {
        SizeLaw::File { file } => file.error(error.to_string()),
        _ => psd.error(error.to_string()),
    };
    match help {
        Some(help) => error.with_help(help),
        None => error,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_of_a_rate_table_do_not_decrease_from_0_on() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rate.csv");
        std::fs::write(&path, "t,cumulative\n0,0\n1,2\n3,2\n").unwrap();
        let amounts = rate_table(&path).unwrap();
        assert_eq!(amounts.rows(), [(0.0, 0.0), (1.0, 2.0), (3.0, 2.0)]);
        for (text, line, least) in [("0,-1\n", 2, 0), ("0,1\n1,0.5\n", 3, 1)] {
            std::fs::write(&path, format!("t,cumulative\n{text}")).unwrap();
            let error = rate_table(&path).unwrap_err().to_string();
            assert!(error.contains(&format!("rate.csv:{line}")), "{error}");
            assert!(error.contains(&format!("at least {least}")), "{error}");
        }
    }
}

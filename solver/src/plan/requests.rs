//! Insertions that cannot be made: less than a particle, or none before the end.

use mercury_common::scene::{Scene, Total};

use mercury_engine::boundaries::mean_volume;
use mercury_engine::boundaries::{Ingredient, InsertionPlan};
use mercury_engine::contact::parameter::short;
use mercury_engine::state::volume;

/// A warning for each insertion that begins too late, for each ingredient of which a quota brings nothing, as its part of the total is
/// nearer to nothing than to its smallest particle, and for each random insertion whose total the first particle exceeds twice.
pub(super) fn warnings(scene: &Scene, insertions: &[InsertionPlan], dimensions: u8) -> Vec<String> {
    let mut warnings = Vec::new();
    for insertion in insertions {
        warnings.extend(idle(insertion, *scene.time.end));
        let used = || insertion.mixture.iter().filter(|part| part.share > 0.0);
        let (total, unit) = match insertion.total {
            Some(Total::Number(number)) if insertion.by_quota => {
                warnings.extend(of_numbers(scene, insertion, number));
                continue;
            }
            Some(Total::Mass(mass)) => (mass, "kg"),
            Some(Total::Volume(volume)) => (volume, "m^3"),
            _ => continue,
        };
        // Amount of 1 m^3 of an ingredient, in the unit of the total.
        let weight = |part: &Ingredient| {
            let material = scene.materials.get(part.material.index());
            match unit {
                "kg" => material.map_or(f64::NAN, |material| *material.density),
                _ => 1.0,
            }
        };
        let smallest =
            |part: &Ingredient| weight(part) * volume(0.5 * part.sizes.smallest(), dimensions);
        let name = &insertion.name;
        if insertion.by_quota {
            let mean = |part: &Ingredient| {
                part.share * weight(part) * mean_volume(&part.sizes, dimensions)
            };
            let all: f64 = used().map(mean).sum();
            for part in used() {
                let wanted = total * mean(part) / all;
                if wanted < 0.5 * smallest(part) {
                    warnings.push(format!(
                        "nothing of {} will come in \"{name}\": of the total it is to have {} {unit}, below half of its smallest particle, {} {unit}",
                        called(scene, part),
                        short(wanted),
                        short(smallest(part))
                    ));
                }
            }
        } else {
            let least = used().map(smallest).fold(f64::INFINITY, f64::min);
            if total < 0.5 * least {
                warnings.push(format!(
                    "the total of \"{name}\", {} {unit}, is below half of its smallest particle, {} {unit}: one particle will come and exceed it",
                    short(total),
                    short(least)
                ));
            }
        }
    }
    warnings
}

/// Why an insertion is never active in a run of this length (s).
fn idle(insertion: &InsertionPlan, end: f64) -> Option<String> {
    let name = &insertion.name;
    let from = short(insertion.from);
    if insertion.from >= end {
        let end = short(end);
        return Some(format!(
            "\"{name}\" inserts nothing: it begins at {from} s, and the run ends at {end} s"
        ));
    }
    (insertion.until <= insertion.from)
        .then(|| format!("\"{name}\" inserts nothing: it ends at {from} s, when it begins"))
}

/// Ingredients whose share of a number is rounded to none.
fn of_numbers(scene: &Scene, insertion: &InsertionPlan, number: u64) -> Vec<String> {
    let shares: f64 = insertion.mixture.iter().map(|part| part.share).sum();
    let (mut sum, mut before) = (0.0, 0.0);
    let mut warnings = Vec::new();
    for part in &insertion.mixture {
        // As the quota rounds them: the cumulative shares.
        sum += part.share / shares;
        let up_to = (sum * number as f64).round();
        if part.share > 0.0 && up_to <= before {
            warnings.push(format!(
                "nothing of {} will come in \"{}\": its share of {number} particles is {}",
                called(scene, part),
                insertion.name,
                short(part.share / shares * number as f64)
            ));
        }
        before = up_to;
    }
    warnings
}

fn called(scene: &Scene, part: &Ingredient) -> String {
    match part
        .clump
        .and_then(|index| scene.clumps.get(index as usize))
    {
        Some(clump) => format!("`{}`", clump.name.value),
        None => {
            let material = scene.materials.get(part.material.index());
            format!(
                "`{}`",
                material.map_or("", |material| material.name.value.as_str())
            )
        }
    }
}

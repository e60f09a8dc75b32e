//! Particles that insertions placed, and whether their sizes match the given distributions.

use mercury_common::readable::{counted, rounded};

use crate::plan::Plan;
use mercury_engine::boundaries::mean_volume;
use mercury_engine::boundaries::{
    Boundaries, Ingredient, InsertionPlan, InsertionState, Limit, Total, volume_within,
};

/// The probability of a false alarm for random sizes of the right distribution.
const LEVEL: f64 = 0.01;

/// With fewer particles not even the median has an interval at this level: 2/2^7 > 0.01 > 2/2^8.
const FEWEST: u64 = 8;

/// A line for each insertion: how much of the target was placed, how full its region became, why it ended; and one for the sizes
/// of each of its ingredients.
///
/// `have_places`: for each insertion that waits for space, whether there is some.
pub(super) fn reported(plan: &Plan, boundaries: &Boundaries, have_places: &[bool]) -> Vec<String> {
    let mut lines = Vec::new();
    let insertions = plan.physics().insertions.iter();
    for ((insertion, state), &has_place) in insertions.zip(boundaries.insertions()).zip(have_places)
    {
        lines.push(amounts(plan, insertion, state, has_place));
        lines.extend(composition(plan, insertion, state));
        lines.extend(sizes(plan, insertion, state));
    }
    lines
}

fn amounts(
    plan: &Plan,
    insertion: &InsertionPlan,
    state: &InsertionState,
    has_place: bool,
) -> String {
    let inserted = &state.inserted;
    let wanted = match insertion.total {
        Some(Total::Number(number)) => format!(" of {number}"),
        Some(Total::Mass(mass)) => format!(" for {} kg", rounded(mass, 6)),
        Some(Total::Volume(volume)) => format!(" for {} m^3", rounded(volume, 6)),
        Some(Total::Full) | None => String::new(),
    };
    let mut text = format!(
        "`{}`: {}{wanted} inserted, {} kg",
        insertion.name,
        inserted.number,
        rounded(inserted.mass, 6)
    );
    let region = volume_within(
        &insertion.region,
        plan.physics().cell.low(),
        plan.physics().cell.high(),
    );
    if plan.physics().dimensions == 3 && region > 0.0 && region.is_finite() {
        let share = inserted.volume / region;
        // A region out of which particles fall takes in more than its volume.
        text += &match share > 1.0 {
            true => format!(", {} times the volume of its region", rounded(share, 3)),
            false => format!(", {} % of its region's volume", rounded(100.0 * share, 3)),
        };
    }
    text += match state.limit {
        Limit::NotBegun => "; it has not begun",
        Limit::Rate => "; it goes on at its rate",
        Limit::Space if has_place => "; it goes on as places become free",
        Limit::Space => "; its region is full",
        Limit::Total if insertion.total == Some(Total::Full) => "; its region got full",
        Limit::Total if inserted.number == 0 => {
            "; complete with nothing: the target is below half of its smallest particle"
        }
        Limit::Total => "; complete",
        Limit::Time => "; its time is over",
    };
    if state.failed_attempts > 0 {
        let places = counted(state.failed_attempts as usize, "place");
        let were = if state.failed_attempts == 1 {
            "was"
        } else {
            "were"
        };
        text += &format!(", {places} {were} tried in vain");
    }
    text
}

/// A warning for each wall behind which particles were placed, as it moved through the region and acts on both sides.
pub(super) fn behind(plan: &Plan, boundaries: &Boundaries) -> Vec<String> {
    let pairs = plan
        .physics()
        .insertions
        .iter()
        .zip(boundaries.insertions());
    let counts = pairs.flat_map(|(insertion, state)| {
        let walls = insertion.closing.iter().zip(&state.behind);
        walls.map(move |(&wall, &number)| (insertion, state.inserted.number, wall, number))
    });
    let some = counts.filter(|(.., number)| *number > 0);
    some.map(|(insertion, all, wall, number)| {
        format!(
            "`{}`: {number} of {all} were placed behind the wall `{}`, which moved through the region and acts on both sides",
            insertion.name,
            plan.physics().walls[wall].name
        )
    })
    .collect()
}

/// Number of grains that were placed behind walls; empty where no wall moves through a region.
pub(super) fn number_behind(plan: &Plan, boundaries: &Boundaries) -> Option<u64> {
    let mut insertions = plan.physics().insertions.iter();
    let has_closing = insertions.any(|insertion| !insertion.closing.is_empty());
    has_closing.then(|| {
        boundaries
            .insertions()
            .flat_map(|state| &state.behind)
            .sum()
    })
}

/// The shares of a mixture's ingredients, by mass and by number, beside their targets.
fn composition(plan: &Plan, insertion: &InsertionPlan, state: &InsertionState) -> Option<String> {
    let used = (insertion.mixture.iter().enumerate()).filter(|(_, part)| part.share > 0.0);
    if used.clone().count() < 2 || state.inserted.number == 0 {
        return None;
    }
    let asked_mass = |part: &Ingredient| {
        let density = plan.physics().materials[part.material.index()].density;
        part.share * density * mean_volume(&part.sizes, plan.physics().dimensions)
    };
    let all_mass: f64 = used.clone().map(|(_, part)| asked_mass(part)).sum();
    let all_shares: f64 = used.clone().map(|(_, part)| part.share).sum();
    let percent = |share: f64| rounded(100.0 * share, 3);
    let parts: Vec<String> = used
        .map(|(index, part)| {
            let brought = state.brought.get(index).copied().unwrap_or_default();
            format!(
                "{} {} % of the mass ({} % requested) and {} % of the number ({} %)",
                name(plan, part),
                percent(brought.mass / state.inserted.mass),
                percent(asked_mass(part) / all_mass),
                percent(brought.number as f64 / state.inserted.number as f64),
                percent(part.share / all_shares)
            )
        })
        .collect();
    Some(format!("composition: {}", parts.join(", ")))
}

/// Name of the clump or the material of an ingredient.
fn name<'a>(plan: &'a Plan, part: &Ingredient) -> &'a str {
    match part.clump {
        Some(clump) => &plan.physics().clumps[clump as usize].name,
        None => &plan.physics().materials[part.material.index()].name,
    }
}

/// The largest distance of the cumulative numbers from those of each ingredient's distribution, and the verdict.
fn sizes(plan: &Plan, insertion: &InsertionPlan, state: &InsertionState) -> Vec<String> {
    let several = insertion.mixture.len() > 1;
    let mut lines = Vec::new();
    for (index, part) in insertion.mixture.iter().enumerate() {
        let Some(placed) = state.sizes.get(index).filter(|placed| placed.number() > 0) else {
            continue;
        };
        let n = placed.number() as f64;
        let largest = placed.distance(&part.sizes);
        let name = match several {
            false => String::new(),
            true => format!(" of {}", name(plan, part)),
        };
        let quantiles = [10, 50, 90].map(|percent| {
            let share = f64::from(percent) / 100.0;
            let came = rounded(1e3 * placed.quantile(share, &part.sizes), 4);
            let asked = rounded(1e3 * part.sizes.sample_diameter(share), 4);
            format!("d{percent} {came} ({asked})")
        });
        let verdict = if insertion.by_quota && state.limit != Limit::Total {
            "of a quota that is not complete".to_owned()
        } else if insertion.by_quota {
            // The bound of a quota, up to the round-off of shares.
            let kept = largest <= (1.0 + 1e-6) / n;
            format!(
                "{} the quota's 1/N",
                if kept {
                    "PASSED: within"
                } else {
                    "FAILED: beyond"
                }
            )
        } else if placed.number() < FEWEST {
            format!(
                "UNDETERMINED: {} particles are too few to tell",
                placed.number()
            )
        } else {
            // Dvoretzky, Kiefer and Wolfowitz 1956 with the constant of Massart 1990: an upper bound.
            let p = (2.0_f64 * libm::exp(-2.0 * n * largest * largest)).min(1.0);
            format!(
                "{}: random sizes differ as much with a probability of {} % at most",
                if p < LEVEL { "FAILED" } else { "PASSED" },
                rounded(100.0 * p, 2)
            )
        };
        lines.push(format!(
            "sizes{name}: {} mm by number (requested); largest distance from the requested distribution {}, {verdict}",
            quantiles.join(", "),
            rounded(largest, 3)
        ));
    }
    lines
}

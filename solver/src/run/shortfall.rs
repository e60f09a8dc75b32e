//! Missing particles: insertions that placed less than their target, and runs that lost all particles.

use mercury_common::surfaces::FACES;

use crate::plan::Plan;
use mercury_engine::boundaries::{BoundaryState, InsertionPlan, InsertionState, Limit, Total};
use mercury_engine::step::Engine;

/// A warning for each insertion that ended, by its time or for want of space, below its total, or without anything.
///
/// An insertion that continues at its rate when the run ends gives no warning: the run was made that short.
///
/// `have_places`: for each insertion that waits for space, whether there is some.
pub(super) fn shortfalls(
    plan: &Plan,
    state: &BoundaryState,
    have_places: &[bool],
    time: f64,
) -> Vec<String> {
    let pairs = plan.physics().insertions.iter().zip(&state.insertions);
    let slack = 1e-6 * plan.physics().time_step;
    pairs
        .zip(have_places)
        .filter_map(|((insertion, state), &has_place)| {
            let is_over = time >= insertion.until - slack;
            let placed = placed(insertion, state)?;
            let why = why(insertion, state, is_over, has_place)?;
            Some(format!("`{}`: {placed} placed; {why}", insertion.name))
        })
        .collect()
}

/// The amount placed, of the target; `None` if the target is reached.
fn placed(insertion: &InsertionPlan, state: &InsertionState) -> Option<String> {
    let inserted = &state.inserted;
    // By quota all particles may be placed although the mass is less, by half a particle at most.
    let is_complete = state.limit == Limit::Total && insertion.total != Some(Total::Full);
    if is_complete || insertion.total_reached(inserted) {
        return None;
    }
    match insertion.total {
        Some(Total::Number(number)) => Some(format!("{} of {number}", inserted.number)),
        Some(Total::Mass(mass)) => Some(format!("{:.4e} of {mass:.4e} kg", inserted.mass)),
        Some(Total::Volume(volume)) => Some(format!("{:.4e} of {volume:.4e} m^3", inserted.volume)),
        Some(Total::Full) | None => (inserted.number == 0).then(|| "nothing was".to_owned()),
    }
}

/// Why it placed no more; `None` where it would continue if the run went on.
fn why(
    insertion: &InsertionPlan,
    state: &InsertionState,
    is_over: bool,
    has_place: bool,
) -> Option<String> {
    let was_full = state.failed_attempts >= insertion.attempts;
    let until = insertion.until;
    match state.limit {
        _ if is_over && was_full => Some(format!(
            "its time ended at {until} s, and its region was too full at times: enlarge it, or let what is there move away faster"
        )),
        _ if is_over => Some(format!(
            "its time ended at {until} s: raise its rate or insert for longer"
        )),
        Limit::Space if has_place => Some(
            "places in its region became free too slowly: enlarge it, or let the run go on"
                .to_owned(),
        ),
        Limit::Space => Some(
            "its region had no space for more when the run ended: enlarge it, or let the run go on"
                .to_owned(),
        ),
        Limit::Total if insertion.total == Some(Total::Full) => {
            Some("nothing found a place in its region".to_owned())
        }
        Limit::NotBegun | Limit::Rate | Limit::Total | Limit::Time => None,
    }
}

/// A warning where all particles have left through faces of the domain, which no scene intends: through which ones.
pub(super) fn all_left(engine: &Engine) -> Option<String> {
    let boundaries = engine.boundaries();
    let gone = boundaries.removed().number;
    let by_faces: u64 = boundaries.faces().iter().map(|tally| tally.number).sum();
    if gone == 0 || by_faces < gone || engine.particles.grains() > 0 {
        return None;
    }
    let ways: Vec<String> = (FACES.iter().zip(boundaries.faces()))
        .filter(|(_, tally)| tally.number > 0)
        .map(|(face, tally)| format!("{} through the face {face}", tally.number))
        .collect();
    Some(format!(
        "no particle is left: {} of the domain",
        ways.join(", ")
    ))
}

#[cfg(test)]
mod tests {
    use crate::plan::parse_scene;
    use glam::DVec3;
    use mercury_common::scene::Files;

    use super::*;
    use mercury_engine::boundaries::Tally;

    const SCENE: &str = "gravity = [0, 0, -9.81]\n[time]\nend = 1.0\nstep = 1e-4\n\
        [domain]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n[output]\ninterval = 0.1\n\
        [materials.sand]\ndensity = 2000\nnormal = { law = \"linear\", stiffness = 1000.0, restitution = 0.5 }\n\
        [[insertions]]\nname = \"rain\"\nregion = { shape = \"box\", min = [0, 0, 0], max = [1, 1, 1] }\n\
        material = \"sand\"\npsd = { kind = \"monodisperse\", diameter = 0.02 }\nattempts = 100\nuntil = 0.5\n";

    /// Warnings of an insertion with this total that placed so many grains of 0.02 m, at this time (s).
    fn reported(total: &str, number: u64, limit: Limit, failed: u64, time: f64) -> Vec<String> {
        reported_where(false, total, number, limit, failed, time)
    }

    /// Report of the shortfall where its next grain has a place at the end, or has none.
    fn reported_where(
        has_place: bool,
        total: &str,
        number: u64,
        limit: Limit,
        failed: u64,
        time: f64,
    ) -> Vec<String> {
        let path = std::path::Path::new("rain.toml");
        let text = format!("{SCENE}{total}\n");
        let scene = parse_scene(path, &text, &[], Files::Unchecked).unwrap();
        let plan = crate::plan::plan(&scene).unwrap();
        let state = InsertionState {
            inserted: Tally {
                number,
                mass: 0.01 * number as f64,
                volume: 5e-6 * number as f64,
                momentum: DVec3::ZERO,
                ..Tally::default()
            },
            failed_attempts: failed,
            limit,
            ..InsertionState::default()
        };
        let state = BoundaryState {
            insertions: vec![state],
            ..BoundaryState::default()
        };
        shortfalls(&plan, &state, &[has_place], time)
    }

    #[test]
    fn what_did_not_come_is_reported_with_its_reason() {
        let total = "total = { number = 60000 }";
        let late = "its time ended at 0.5 s";
        for (found, expected) in [
            (
                reported(total, 3035, Limit::Time, 99, 1.0),
                format!("`rain`: 3035 of 60000 placed; {late}: raise its rate or insert for longer"),
            ),
            (
                reported(total, 3035, Limit::Time, 100, 1.0),
                format!(
                    "`rain`: 3035 of 60000 placed; {late}, and its region was too full at times: enlarge it, or let what is there move away faster"
                ),
            ),
            // Its last step was the run's last one.
            (
                reported(total, 3035, Limit::Rate, 0, 0.5),
                format!("`rain`: 3035 of 60000 placed; {late}: raise its rate or insert for longer"),
            ),
            (
                reported("total = { mass = 2.5 }", 3, Limit::Space, 500, 0.2),
                "`rain`: 3.0000e-2 of 2.5000e0 kg placed; its region had no space for more when the run ended: enlarge it, or let the run go on".to_owned(),
            ),
            (
                reported_where(true, total, 3035, Limit::Space, 500, 0.2),
                "`rain`: 3035 of 60000 placed; places in its region became free too slowly: enlarge it, or let the run go on".to_owned(),
            ),
            (
                reported("total = { volume = 1e-4 }", 0, Limit::Time, 0, 1.0),
                format!("`rain`: 0.0000e0 of 1.0000e-4 m^3 placed; {late}: raise its rate or insert for longer"),
            ),
            (
                reported("total = { full = true }", 0, Limit::Total, 500, 0.1),
                "`rain`: nothing was placed; nothing found a place in its region".to_owned(),
            ),
            (
                reported("rate = { number = 1e-3 }", 0, Limit::Time, 0, 1.0),
                format!("`rain`: nothing was placed; {late}: raise its rate or insert for longer"),
            ),
        ] {
            assert_eq!(found, [expected]);
        }
    }

    #[test]
    fn nothing_is_reported_of_insertions_that_are_done_or_go_on() {
        let total = "total = { number = 60000 }";
        for found in [
            reported(total, 60000, Limit::Total, 500, 1.0),
            reported(total, 60000, Limit::Rate, 0, 1.0),
            reported(total, 3035, Limit::Rate, 500, 0.2),
            reported(total, 0, Limit::NotBegun, 0, 0.2),
            reported("total = { full = true }", 10, Limit::Total, 500, 1.0),
            reported("rate = { number = 10.0 }", 10, Limit::Time, 0, 1.0),
        ] {
            assert!(found.is_empty(), "{found:?}");
        }
    }
}

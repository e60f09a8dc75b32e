//! Means over the seeds of a study, as in the solver's `study.means.csv` and `study.differences.csv`.

use std::collections::HashMap;

use cloud_api::RunState;
use cloud_api::answers::{PointResult, StudyPoint, StudyRun, StudyTable};
use mercury_common::formats::delimited::push_line;
use mercury_common::formats::table_head;
use mercury_common::statistics::{Mean, root_mean_square};

/// The key that differs between the runs of a point.
const SEED: &str = "seed";

/// Values of all keys but the seed, and the runs with these.
type Point<'a> = (Vec<Option<String>>, Vec<&'a StudyRun>);

/// A number, where it is one.
fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// Values of result `k` of runs.
fn values(runs: &[&StudyRun], k: usize) -> Vec<f64> {
    runs.iter().filter_map(|run| run.results[k]).collect()
}

/// The points of a study whose runs differ in their seed; nothing where each point has one run. The seeds of a point count in their order,
/// up to the first without all results: those that finish early are no fair sample.
pub(crate) fn points(keys: &[String], results: usize, rows: &[StudyRun]) -> Vec<StudyPoint> {
    let Some(seed) = keys.iter().position(|key| key == SEED) else {
        return Vec::new();
    };
    let point = |row: &StudyRun| {
        let mut values = row.values.clone();
        values.remove(seed);
        values
    };
    let mut groups: Vec<Point> = Vec::new();
    let mut places = HashMap::new();
    for row in rows {
        let place = *places.entry(point(row)).or_insert(groups.len());
        match groups.get_mut(place) {
            Some((_, runs)) => runs.push(row),
            None => groups.push((point(row), vec![row])),
        }
    }
    if results == 0 || groups.iter().all(|(_, runs)| runs.len() < 2) {
        return Vec::new();
    }
    for (_, runs) in &mut groups {
        let counts = |run: &&StudyRun| {
            run.state == RunState::Finished && run.results.iter().all(Option::is_some)
        };
        let counted = runs.iter().take_while(|run| counts(run)).count();
        runs.truncate(counted);
    }
    let first = groups.first().map_or(Vec::new(), |(_, runs)| runs.clone());
    let of_point = |(place, (values, runs)): (usize, Point)| {
        let partner = |run: &&StudyRun| {
            first
                .iter()
                .find(|one| one.values[seed] == run.values[seed])
        };
        let (ours, theirs): (Vec<&StudyRun>, Vec<&StudyRun>) = (runs.iter())
            .filter(|_| place > 0)
            .filter_map(|run| Some((*run, *partner(run)?)))
            .unzip();
        StudyPoint {
            seeds: runs.len() as u64,
            pairs: ours.len() as u64,
            values,
            results: (0..results)
                .map(|k| result(&runs, &ours, &theirs, k))
                .collect(),
        }
    };
    groups.into_iter().enumerate().map(of_point).collect()
}

/// Result `k` of a point, and its difference from the first point in the runs that have a seed in common.
fn result(runs: &[&StudyRun], ours: &[&StudyRun], theirs: &[&StudyRun], k: usize) -> PointResult {
    let mean = Mean::of(&values(runs, k));
    let within: Vec<f64> = runs.iter().filter_map(|run| run.errors[k]).collect();
    let (difference, correlation) = Mean::of_differences(&values(ours, k), &values(theirs, k));
    PointResult {
        mean: finite(mean.value),
        error: finite(mean.error),
        low: finite(mean.value - mean.half),
        high: finite(mean.value + mean.half),
        spread: finite(mean.spread),
        within: finite(root_mean_square(&within)),
        difference: finite(difference.value),
        difference_error: finite(difference.error),
        correlation: finite(correlation),
    }
}

/// Parts of the name of a column, and its value.
type Part = (&'static str, fn(&PointResult) -> Option<f64>);

const PARTS: [Part; 6] = [
    ("", |result| result.mean),
    ("_error", |result| result.error),
    ("_low", |result| result.low),
    ("_high", |result| result.high),
    ("_spread", |result| result.spread),
    ("_within", |result| result.within),
];

const DIFFERENCES: [Part; 3] = [
    ("", |result| result.difference),
    ("_error", |result| result.difference_error),
    ("_correlation", |result| result.correlation),
];

/// The means as comma-separated values, with the columns of the solver's `study.means.csv`.
pub(crate) fn csv(table: &StudyTable) -> String {
    written(table, &table.means, |point| point.seeds, PARTS)
}

/// The differences from the first point as comma-separated values, with the columns of the solver's `study.differences.csv`.
pub(crate) fn differences(table: &StudyTable) -> String {
    let others = table.means.get(1..).unwrap_or_default();
    written(table, others, |point| point.pairs, DIFFERENCES)
}

/// A row for each of these points: its keys, how many seeds count, and these parts of its results.
fn written<const N: usize>(
    table: &StudyTable,
    points: &[StudyPoint],
    seeds: fn(&StudyPoint) -> u64,
    parts: [Part; N],
) -> String {
    let keys = table.keys.iter().filter(|key| *key != SEED);
    let mut head: Vec<(String, &str)> = keys.map(|key| (key.clone(), "")).collect();
    head.push(("seeds".to_owned(), ""));
    for column in &table.results {
        let names = parts.map(|(part, _)| (format!("{}{part}", column.name), column.unit.as_str()));
        head.extend(names);
    }
    let head = head.iter().map(|(name, unit)| (name.as_str(), *unit));
    let mut text = table_head::line(head).into_bytes();
    for point in points {
        let values = point.values.iter().cloned().map(Option::unwrap_or_default);
        let mut cells: Vec<String> = values.chain([seeds(point).to_string()]).collect();
        for result in &point.results {
            let number =
                |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
            cells.extend(parts.map(|(_, value)| number(value(result))));
        }
        push_line(&mut text, cells);
    }
    String::from_utf8_lossy(&text).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(friction: &str, seed: &str, result: Option<f64>, error: Option<f64>) -> StudyRun {
        StudyRun {
            id: format!("{friction} {seed}"),
            name: String::new(),
            state: if result.is_some() {
                RunState::Finished
            } else {
                RunState::Running
            },
            problem: String::new(),
            step: 0,
            core_seconds: 0.0,
            values: vec![Some(seed.to_owned()), Some(friction.to_owned())],
            results: vec![result],
            errors: vec![error],
            remarks: vec![None],
        }
    }

    /// Two seeds of 1 and 3, and of 2 and 6: t(0.975; 1) is 12.706205, standard errors are 1 and 2, and of their difference 1.
    #[test]
    fn means_are_those_of_the_solver() {
        let keys = [SEED.to_owned(), "friction".to_owned()];
        let rows = [
            row("0.1", "1", Some(1.0), Some(0.3)),
            row("0.2", "1", Some(2.0), None),
            row("0.1", "2", Some(3.0), Some(0.4)),
            row("0.2", "2", Some(6.0), None),
            // A seed behind one that is on its way does not count.
            row("0.2", "3", None, None),
            row("0.2", "4", Some(100.0), None),
        ];
        let points = points(&keys, 1, &rows);
        let t = 12.706_204_736;
        let near = |found: Option<f64>, expected: f64| (found.unwrap() - expected).abs() < 1e-8;
        assert_eq!(points.len(), 2);
        for (point, mean, error) in [(&points[0], 2.0, 1.0), (&points[1], 4.0, 2.0)] {
            let result = &point.results[0];
            assert_eq!((point.seeds, result.mean), (2, Some(mean)));
            assert!(near(result.error, error * t / 1.96));
            assert!(near(result.low, mean - error * t) && near(result.high, mean + error * t));
        }
        let [first, second] = [&points[0].results[0], &points[1].results[0]];
        assert!(near(first.within, (0.125_f64).sqrt()) && second.within.is_none());
        assert_eq!((points[0].pairs, points[1].pairs), (0, 2));
        assert!(first.difference.is_none());
        assert_eq!(second.difference, Some(2.0));
        assert!(near(second.difference_error, t / 1.96) && near(second.correlation, 1.0));
        assert_eq!(points[0].values, [Some("0.1".to_owned())]);
    }

    #[test]
    fn without_several_seeds_there_are_no_means() {
        let keys = |names: &[&str]| {
            names
                .iter()
                .map(|name| (*name).to_owned())
                .collect::<Vec<_>>()
        };
        let rows = [
            row("0.1", "1", Some(1.0), None),
            row("0.2", "1", Some(2.0), None),
        ];
        assert_eq!(points(&keys(&["seed", "friction"]), 1, &rows), []);
        assert_eq!(points(&keys(&["a", "b"]), 1, &rows), []);
        assert_eq!(points(&keys(&["friction", "seed"]), 0, &rows), []);
    }
}

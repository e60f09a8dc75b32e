//! Several seeds of each point of a study: how many are needed, and what they say together.
//!
//! A point is the values of all keys but `seed`. Seed n is the same number at all points, so that points differ by their values and not by their
//! random numbers (common random numbers). The interval of a mean is that of Student's distribution over the seeds; seeds are added one at a time until
//! it is short enough (Chow & Robbins, Annals of Mathematical Statistics 36 (1965) 457).

use std::collections::{HashMap, HashSet};

use mercury_common::readable::significant;
use mercury_common::scene::nearest;
use mercury_common::statistics::{Mean, root_mean_square};

use super::table::{StudyTable, error_column, number};
use super::{MOST_RUNS, Study, StudyError, StudyRun};
use crate::results::{NamedResult, Wanted};

/// Name of the file with a row for each point, in the study's folder.
pub const MEANS: &str = "study.means.csv";
/// Name of the file with the differences of each point from the first one.
pub const DIFFERENCES: &str = "study.differences.csv";
/// The key that differs between the runs of a point.
pub const SEED: &str = "seed";
/// Seeds from which on intervals of normal outcomes hold the mean in 93 to 95 of 100 cases, also where the number of seeds follows from them.
const TRUSTED: u32 = 8;

/// How many seeds each point has.
#[derive(Debug, Clone, PartialEq)]
pub struct Seeds {
    /// Seeds of each point at least, 1 or more.
    pub least: u32,
    /// Seeds of each point at most.
    pub most: u32,
    /// Standard errors at which results are known, by the names of these.
    errors: Vec<(String, Wanted)>,
}

impl Seeds {
    /// # Errors
    /// Without any seed, with more than a study may have runs, or with fewer at most than at least.
    pub fn new(least: u32, most: u32) -> Result<Self, String> {
        if least == 0 {
            return Err("each point needs a seed: 1 at least".to_owned());
        }
        if most < least {
            return Err(format!("{most} at most are fewer than {least} at least"));
        }
        if most as usize > MOST_RUNS {
            return Err(format!("{most} seeds, more than {MOST_RUNS} runs"));
        }
        Ok(Self {
            least,
            most,
            errors: Vec::new(),
        })
    }

    /// Reads `8`, or `8..64`: from 8 on, as many as the errors need, 64 at most.
    ///
    /// # Errors
    /// As [`new`](Self::new), and for any other text.
    pub fn parse(text: &str) -> Result<Self, String> {
        let count = |text: &str| text.trim().parse::<u32>();
        let (least, most) = text.split_once("..").unwrap_or((text, text));
        match (count(least), count(most)) {
            (Ok(least), Ok(most)) => Self::new(least, most),
            _ => Err("expected a number of seeds, 8, or the least and the most, 8..64".to_owned()),
        }
    }

    /// Lets the number of seeds follow from the error of a result, `2 %` or a number in its unit.
    ///
    /// # Errors
    /// There is no such result, it has an error already, or the error is not valid.
    pub fn until(
        &mut self,
        name: &str,
        error: &str,
        results: &[NamedResult],
    ) -> Result<(), String> {
        let names = results.iter().map(|result| result.name.as_str());
        let Some(result) = results.iter().find(|result| result.name == name) else {
            return Err(match nearest(name, names) {
                Some(near) => format!("no result `{name}`; did you mean `{near}`?"),
                None => format!("no result `{name}`"),
            });
        };
        if self.errors.iter().any(|(known, _)| known == name) {
            return Err(format!("the error of `{name}` is given twice"));
        }
        if self.least == self.most {
            let most = 8 * self.least.max(TRUSTED);
            return Err(format!(
                "the number of seeds is fixed at {}: least and most let it follow from the error, for example from {} to {most}",
                self.least,
                self.least.max(TRUSTED)
            ));
        }
        let wanted = Wanted::parse(error, &result.unit())?;
        self.errors.push((name.to_owned(), wanted));
        Ok(())
    }

    /// The seeds that count of a point of which these are finished, in the order of seeds; `None`: more are needed. A run without a result ends its point.
    fn counted(&self, finished: &[Outcome]) -> Option<usize> {
        let known = |count: usize| {
            self.errors.iter().all(|(name, wanted)| {
                let values: Option<Vec<f64>> = (finished[..count].iter())
                    .map(|outcome| outcome.value(name))
                    .collect();
                values.is_some_and(|values| {
                    let mean = Mean::of(&values);
                    mean.error <= wanted.at(mean.value)
                })
            })
        };
        let failed = finished.iter().position(Outcome::is_failed);
        let upto = failed.unwrap_or(finished.len()).min(self.most as usize);
        let enough = match self.errors.is_empty() {
            true => self.most as usize,
            false => (self.least as usize..=upto)
                .find(|&count| known(count))
                .unwrap_or(self.most as usize),
        };
        match failed {
            Some(failed) if failed < enough => Some(failed),
            _ => (enough <= finished.len()).then_some(enough),
        }
    }
}

/// Results of a finished run, and their own errors.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Outcome(Vec<(String, Option<f64>, Option<f64>)>);

impl Outcome {
    fn value(&self, name: &str) -> Option<f64> {
        self.0.iter().find(|(known, ..)| known == name)?.1
    }

    fn error(&self, name: &str) -> Option<f64> {
        self.0.iter().find(|(known, ..)| known == name)?.2
    }

    /// Whether a result is missing.
    fn is_failed(&self) -> bool {
        self.0.iter().any(|(_, value, _)| value.is_none())
    }
}

/// Values of a result by seed.
fn values(outcomes: &[Outcome], name: &str) -> Vec<f64> {
    let values = outcomes.iter().filter_map(|outcome| outcome.value(name));
    values.collect()
}

impl Study {
    /// Makes each of its runs a point of so many seeds, or as many as `errors` of results need.
    ///
    /// # Errors
    /// If the study varies or sets `seed` already, or would have too many runs.
    pub fn repeat(&mut self, seeds: Seeds, place: &str) -> Result<(), StudyError> {
        let sets_seed = |set: &String| set.split('=').next().is_some_and(|key| key.trim() == SEED);
        if self.keys.iter().any(|key| key == SEED) || self.set.iter().any(sets_seed) {
            let error = StudyError::new(place, "the study gives values of `seed` itself");
            return Err(error
                .with_help("leave out one of the two: seeds are 1, 2, 3 and so on at each point"));
        }
        super::too_many(self.runs.len().saturating_mul(seeds.most as usize), place)?;
        self.keys.push(SEED.to_owned());
        self.units.push(String::new());
        let repeated = |run: &StudyRun| {
            let run = run.clone();
            (1..=seeds.most).map(move |seed| {
                let mut one = run.clone();
                one.name = match run.values.iter().any(Option::is_some) || !run.name.is_empty() {
                    true => format!("{}_{SEED}={seed}", run.name),
                    false => format!("{SEED}={seed}"),
                };
                one.values.push(Some(seed.to_string()));
                one.settled.push(Some(seed.to_string()));
                one
            })
        };
        self.runs = self.runs.iter().flat_map(repeated).collect();
        self.seeds = Some(seeds);
        Ok(())
    }

    /// Runs of each point.
    #[must_use]
    pub fn runs_of_point(&self) -> usize {
        self.seeds.as_ref().map_or(1, |seeds| seeds.most as usize)
    }

    /// Runs that are made in any case, whatever comes out, of each point.
    #[must_use]
    pub fn certain_runs_of_point(&self) -> usize {
        match &self.seeds {
            Some(seeds) if seeds.errors.is_empty() => seeds.most as usize,
            Some(seeds) => seeds.least as usize,
            None => 1,
        }
    }

    /// The next run to begin, if one is needed. `begun`: of each run, whether it has begun; `table`: of those that are finished, made only where more
    /// seeds may follow from it.
    #[must_use]
    pub fn next_run(&self, begun: &[bool], table: impl FnOnce() -> StudyTable) -> Option<usize> {
        let of_point = self.runs_of_point();
        let certain = self.certain_runs_of_point();
        let first = (0..begun.len()).find(|&run| run % of_point < certain && !begun[run]);
        if first.is_some() || certain == of_point {
            return first;
        }
        let open =
            self.outcomes(&table())
                .into_iter()
                .enumerate()
                .filter_map(|(point, finished)| {
                    let own = &begun[point * of_point..(point + 1) * of_point];
                    let next = own.iter().position(|begun| !begun)?;
                    let is_known = self.seeds.as_ref()?.counted(&finished).is_some();
                    (!is_known).then_some((next, point * of_point + next))
                });
        // The point that has the fewest, and of these the first.
        open.min().map(|(_, run)| run)
    }

    /// The outcomes of each point in the order of seeds, up to the first run that is not finished.
    fn outcomes(&self, table: &StudyTable) -> Vec<Vec<Outcome>> {
        let place = |name: &str| table.columns.iter().position(|column| column == name);
        let (name, status) = (place("run"), place("status"));
        let rows: HashMap<&str, &Vec<String>> = (table.rows.iter())
            .filter_map(|row| Some((row[name?].as_str(), row)))
            .collect();
        let results: Vec<_> = (self.results.iter())
            .map(|result| {
                (
                    result,
                    place(&result.name),
                    place(&error_column(&result.name)),
                )
            })
            .collect();
        let of_run = |run: &StudyRun| {
            let row = rows.get(run.name.as_str())?;
            let state = row[status?].as_str();
            if !["finished", "failed"].contains(&state) {
                return None;
            }
            let cell =
                |result: &NamedResult, place: Option<usize>| number(&result.name, &row[place?]);
            let outcome = results.iter().map(|&(result, value, error)| {
                (
                    result.name.clone(),
                    cell(result, value),
                    cell(result, error),
                )
            });
            Some(Outcome(outcome.collect()))
        };
        let points = self.runs.chunks(self.runs_of_point());
        points
            .map(|runs| runs.iter().map_while(of_run).collect())
            .collect()
    }

    /// The seeds that count of each point, and their outcomes.
    fn points(&self, table: &StudyTable) -> Vec<Vec<Outcome>> {
        let mut points = self.outcomes(table);
        if let Some(seeds) = &self.seeds {
            for finished in &mut points {
                let failed = finished.iter().position(Outcome::is_failed);
                let counted = seeds.counted(finished).unwrap_or(finished.len());
                finished.truncate(failed.unwrap_or(counted).min(counted));
            }
        }
        points
    }

    /// The rows of the table that count: not those of seeds beyond the needed ones.
    #[must_use]
    pub fn counted_rows(&self, table: &StudyTable) -> StudyTable {
        let mut counted = table.clone();
        let Some(place) = table.columns.iter().position(|column| column == "run") else {
            return counted;
        };
        let points = self.points(table);
        let runs = self.runs.chunks(self.runs_of_point()).zip(points);
        let beyond: HashSet<&str> = runs
            .flat_map(|(runs, outcomes)| &runs[outcomes.len()..])
            .map(|run| run.name.as_str())
            .collect();
        (counted.rows).retain(|row| !beyond.contains(row[place].as_str()));
        counted
    }

    /// A row for each point: its keys, the seeds that count, and of each result `NAME` their mean, `NAME_error`, the ends of the 95 % interval `NAME_low`
    /// and `NAME_high`, `NAME_spread`, the standard deviation of one seed, and `NAME_within`, the root mean square of the runs' own errors.
    /// `None`: a study without seeds.
    #[must_use]
    pub fn means(&self, table: &StudyTable) -> Option<StudyTable> {
        let seeds = self.seeds.as_ref()?;
        let mut means = self.empty_table(&["", "error", "low", "high", "spread", "within"]);
        let points = self.points(table);
        for (run, outcomes) in self.runs.chunks(self.runs_of_point()).zip(&points) {
            let mut row = self.cells_of_point(&run[0], outcomes.len());
            for result in &self.results {
                let values = values(outcomes, &result.name);
                let within: Vec<f64> = outcomes
                    .iter()
                    .filter_map(|o| o.error(&result.name))
                    .collect();
                let mean = Mean::of(&values);
                row.extend(
                    [
                        mean.value,
                        mean.error,
                        mean.value - mean.half,
                        mean.value + mean.half,
                        mean.spread,
                        root_mean_square(&within),
                    ]
                    .map(cell),
                );
            }
            let at = || match run[0].name.rsplit_once(&format!("_{SEED}=")) {
                Some((point, _)) => format!("`{point}`: "),
                None => String::new(),
            };
            for result in &self.results {
                let values = values(outcomes, &result.name);
                let warning =
                    warning(&values).map(|words| format!("{}{}: {words}", at(), result.name));
                means.problems.extend(warning);
            }
            for (name, wanted) in &seeds.errors {
                let values = values(outcomes, name);
                let mean = Mean::of(&values);
                if values.len() == seeds.most as usize && mean.error > wanted.at(mean.value) {
                    let [error, aim] =
                        [mean.error, wanted.at(mean.value)].map(|x| significant(x, 2));
                    means.problems.push(format!(
                        "{}{name}: its error is {error} after {} seeds, and was to be {aim}",
                        at(),
                        values.len()
                    ));
                }
            }
            means.rows.push(row);
        }
        if !seeds.errors.is_empty() && seeds.least < TRUSTED {
            means.problems.push(format!(
                "from {} seeds on: intervals that are looked at from fewer than {TRUSTED} on hold the mean less often than 95 times of 100",
                seeds.least
            ));
        }
        Some(means)
    }

    /// Of each point but the first: the mean difference of its results from those of the first point, seed by seed, with the error of these differences
    /// (`NAME_error`), and the correlation of the two (`NAME_correlation`). `None`: a study without seeds, or of one point.
    #[must_use]
    pub fn differences(&self, table: &StudyTable) -> Option<StudyTable> {
        self.seeds.as_ref()?;
        let points = self.points(table);
        let (first, others) = points
            .split_first()
            .filter(|(_, others)| !others.is_empty())?;
        let mut differences = self.empty_table(&["", "error", "correlation"]);
        let runs = self.runs.chunks(self.runs_of_point()).skip(1);
        for (run, outcomes) in runs.zip(others) {
            let count = first.len().min(outcomes.len());
            let mut row = self.cells_of_point(&run[0], count);
            for result in &self.results {
                let [ours, theirs] =
                    [outcomes, first].map(|outcomes| values(&outcomes[..count], &result.name));
                let (difference, correlation) = Mean::of_differences(&ours, &theirs);
                row.extend([difference.value, difference.error, correlation].map(cell));
            }
            differences.rows.push(row);
        }
        Some(differences)
    }

    /// A table of points with these columns for each result.
    fn empty_table(&self, parts: &[&str]) -> StudyTable {
        let keys = self.keys.iter().filter(|key| *key != SEED);
        let mut table = StudyTable {
            columns: keys.cloned().collect(),
            ..StudyTable::default()
        };
        table.units = table.columns.iter().map(|key| self.unit(key)).collect();
        table.columns.push("seeds".to_owned());
        table.units.push(String::new());
        for result in &self.results {
            for part in parts {
                let name = match *part {
                    "" => result.name.clone(),
                    part => format!("{}_{part}", result.name),
                };
                table.columns.push(name);
                table.units.push(match *part {
                    "correlation" => String::new(),
                    _ => self.unit(&result.name),
                });
            }
        }
        table
    }

    fn cells_of_point(&self, run: &StudyRun, seeds: usize) -> Vec<String> {
        let values = self
            .keys
            .iter()
            .zip(&run.settled)
            .filter(|(key, _)| *key != SEED);
        let mut row: Vec<String> = values
            .map(|(_, value)| super::table::plain(value.as_deref()))
            .collect();
        row.push(seeds.to_string());
        row
    }
}

/// A number, empty where it is none.
fn cell(value: f64) -> String {
    match value.is_finite() {
        true => format!("{value:?}"),
        false => String::new(),
    }
}

/// What the values of a result by seed say against their mean.
fn warning(values: &[f64]) -> Option<&'static str> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (first, last) = (*sorted.first()?, *sorted.last()?);
    if values.len() > 1 && first == last {
        return Some("the seed changes nothing in this scene: it has no insertion, no jitter");
    }
    let gap = sorted
        .windows(2)
        .map(|two| two[1] - two[0])
        .fold(0.0, f64::max);
    let is_split = values.len() >= TRUSTED as usize && gap > 0.5 * (last - first);
    is_split.then_some("outcomes fall into two groups: their mean may be the outcome of none")
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use mercury_common::random::Stream;

    use super::super::{Sweep, grid};
    use super::*;

    /// A study of one result, without units, of these points.
    fn study(points: &[&str], seeds: &str, error: Option<&str>) -> Study {
        let sweep = Sweep {
            key: "friction".to_owned(),
            values: points.iter().map(|&p| p.to_owned()).collect(),
        };
        let (keys, runs) = grid(&[sweep], "--sweep").unwrap();
        let mut study = Study {
            scene: PathBuf::from("a.toml"),
            folder: PathBuf::from("a-study"),
            set: Vec::new(),
            title: String::new(),
            units: vec![String::new(); keys.len()],
            keys,
            runs,
            results: vec![NamedResult::new("count", "last(energy.traKineticEnergy)").unwrap()],
            seeds: None,
            plots: Vec::new(),
            jobs: None,
            threads: None,
        };
        let mut seeds = Seeds::parse(seeds).unwrap();
        if let Some(error) = error {
            seeds.until("count", error, &study.results).unwrap();
        }
        study.repeat(seeds, "--seeds").unwrap();
        study
    }

    /// The table of these runs, which are finished, by number and value.
    fn table(study: &Study, finished: &[(usize, f64)]) -> StudyTable {
        let names = ["run", "status", "count"].map(str::to_owned);
        StudyTable {
            columns: names.to_vec(),
            units: vec![String::new(); 3],
            rows: finished
                .iter()
                .map(|&(run, value)| {
                    vec![
                        study.runs[run].name.clone(),
                        "finished".to_owned(),
                        format!("{value:?}"),
                    ]
                })
                .collect(),
            problems: Vec::new(),
        }
    }

    fn normal(random: &mut Stream) -> f64 {
        let radius = (-2.0 * libm::log(1.0 - random.uniform())).sqrt();
        radius * libm::cos(std::f64::consts::TAU * random.uniform())
    }

    /// Runs a study with so many jobs, each of which ends in a random order; the value of a run is that of its number. Returns the seeds that count of each point.
    fn counts(study: &Study, values: &[f64], jobs: usize, random: &mut Stream) -> Vec<usize> {
        let (mut begun, mut finished, mut running) =
            (vec![false; study.runs.len()], Vec::new(), Vec::new());
        loop {
            while running.len() < jobs {
                let Some(next) = study.next_run(&begun, || table(study, &finished)) else {
                    break;
                };
                begun[next] = true;
                running.push(next);
            }
            if running.is_empty() {
                break;
            }
            let ended = running.swap_remove((random.uniform() * running.len() as f64) as usize);
            finished.push((ended, values[ended]));
        }
        study
            .points(&table(study, &finished))
            .iter()
            .map(Vec::len)
            .collect()
    }

    #[test]
    fn the_number_of_seeds_does_not_follow_from_the_number_of_jobs() {
        let study = study(&["0.1", "0.2", "0.3"], "3..40", Some("0.25 J"));
        let mut random = Stream::new(7, "seeds", 0);
        let mut different = std::collections::BTreeSet::new();
        for _ in 0..10 {
            let values: Vec<f64> = study
                .runs
                .iter()
                .map(|_| 5.0 + normal(&mut random))
                .collect();
            let one = counts(&study, &values, 1, &mut random);
            assert!(one.iter().all(|&count| (3..=40).contains(&count)));
            for jobs in [2, 4, 9] {
                assert_eq!(counts(&study, &values, jobs, &mut random), one, "{jobs}");
            }
            different.extend(one);
        }
        assert!(different.len() > 5, "{different:?}");
    }

    /// Of 2,000 studies whose outcomes are normal, 91 to 97 of 100 intervals hold the mean, though the number of seeds follows from them: some 16 of 64 are
    /// needed, from 8 on. Chance alone is half a per cent.
    #[test]
    fn intervals_of_as_many_seeds_as_are_needed_hold_the_mean() {
        let study = study(&["0.1"], "8..64", Some("0.25 J"));
        let seeds = study.seeds.as_ref().unwrap();
        let mut random = Stream::new(11, "seeds", 0);
        let (mut inside, mut needed) = (0, 0);
        for _ in 0..2000 {
            let mut outcomes = Vec::new();
            let count = loop {
                outcomes.push(Outcome(vec![(
                    "count".to_owned(),
                    Some(5.0 + normal(&mut random)),
                    None,
                )]));
                if let Some(count) = seeds.counted(&outcomes) {
                    break count;
                }
            };
            let values: Vec<f64> = outcomes[..count]
                .iter()
                .filter_map(|o| o.value("count"))
                .collect();
            let mean = Mean::of(&values);
            inside += usize::from((mean.value - 5.0).abs() < mean.half);
            needed += count;
        }
        assert!((1820..=1940).contains(&inside), "{inside}");
        assert!((24_000..44_000).contains(&needed), "{needed}");
    }

    /// Two seeds of 1 and 3, and of 2 and 6: t(0.975; 1) is 12.706205, standard errors are 1 and 2, and of their difference 1.
    #[test]
    fn means_and_differences_are_those_of_their_formulas() {
        let study = study(&["0.1", "0.2"], "2", None);
        let table = table(&study, &[(0, 1.0), (1, 3.0), (2, 2.0), (3, 6.0)]);
        let number = |table: &StudyTable, column: &str| table.numbers(column).unwrap();
        let means = study.means(&table).unwrap();
        let t = 12.706_204_736;
        let close = |found: Vec<Option<f64>>, expected: [f64; 2]| {
            for (found, expected) in found.into_iter().zip(expected) {
                assert!(
                    (found.unwrap() - expected).abs() < 1e-8,
                    "{found:?} {expected}"
                );
            }
        };
        close(number(&means, "count"), [2.0, 4.0]);
        close(number(&means, "count_error"), [t / 1.96, 2.0 * t / 1.96]);
        close(number(&means, "count_low"), [2.0 - t, 4.0 - 2.0 * t]);
        close(number(&means, "count_high"), [2.0 + t, 4.0 + 2.0 * t]);
        close(
            number(&means, "count_spread"),
            [libm::sqrt(2.0), libm::sqrt(8.0)],
        );
        close(number(&means, "seeds"), [2.0, 2.0]);
        assert_eq!(number(&means, "count_within"), [None, None]);
        let differences = study.differences(&table).unwrap();
        assert_eq!(number(&differences, "count"), [Some(2.0)]);
        let error = number(&differences, "count_error")[0].unwrap();
        assert!((error - t / 1.96).abs() < 1e-8);
        assert!((number(&differences, "count_correlation")[0].unwrap() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn what_the_seeds_say_is_reported() {
        let fixed = study(&["0.1"], "8", None);
        let problems = |study: &Study, values: &[f64]| {
            let finished: Vec<(usize, f64)> = values.iter().copied().enumerate().collect();
            study
                .means(&table(study, &finished))
                .unwrap()
                .problems
                .join("\n")
        };
        assert!(problems(&fixed, &[2.0; 8]).contains("the seed changes nothing"));
        let two = [1.0, 1.1, 0.9, 1.0, 5.0, 5.1, 5.2, 4.9];
        assert!(problems(&fixed, &two).contains("two groups"));
        assert_eq!(
            problems(&fixed, &[1.0, 1.4, 2.0, 2.3, 2.9, 3.5, 4.0, 4.4]),
            ""
        );
        let few = study(&["0.1"], "2..4", Some("1e-3 J"));
        let said = problems(&few, &[1.0, 2.0, 3.0, 4.0]);
        assert!(
            said.contains("after 4 seeds, and was to be 0.001") && said.contains("fewer than 8"),
            "{said}"
        );
        // Without a run there is nothing to say, and no number.
        assert_eq!(
            few.means(&table(&few, &[])).unwrap().rows,
            [["0.1", "0", "", "", "", "", "", ""]]
        );
    }

    /// A run without a result ends its point: no further seed follows from it.
    #[test]
    fn a_failed_run_ends_its_point() {
        let study = study(&["0.1"], "2..9", Some("1e-3 J"));
        let mut table = table(&study, &[(0, 1.0), (1, 2.0), (2, 4.0)]);
        let mut begun = vec![false; 9];
        begun[..3].fill(true);
        assert_eq!(study.next_run(&begun, || table.clone()), Some(3));
        table.rows[2][1] = "failed".to_owned();
        table.rows[2][2].clear();
        assert_eq!(study.next_run(&begun, || table.clone()), None);
        assert_eq!(study.points(&table)[0].len(), 2);
    }

    #[test]
    fn seeds_that_cannot_be_are_refused() {
        for (text, part) in [
            ("0", "1 at least"),
            ("1000000", "more than 10000 runs"),
            ("9..8", "8 at most are fewer than 9 at least"),
            ("x", "expected a number"),
            ("-1", "expected a number"),
        ] {
            let error = Seeds::parse(text).unwrap_err();
            assert!(error.contains(part), "{text}: {error}");
        }
        let results = study(&["0.1"], "2", None).results;
        let mut seeds = Seeds::parse("8..64").unwrap();
        for (name, error, part) in [
            ("cuont", "2 %", "no result `cuont`; did you mean `count`?"),
            ("count", "0 J", "must be above 0"),
            ("count", "-1 %", "must be above 0"),
            ("count", "nan %", "must be above 0"),
            ("count", "2 m", "the result is in J"),
        ] {
            let found = seeds.until(name, error, &results).unwrap_err();
            assert!(found.contains(part), "{name} {error}: {found}");
        }
        let fixed = Seeds::parse("8").unwrap().until("count", "2 %", &results);
        assert!(fixed.unwrap_err().contains("fixed at 8"));
        let mut swept = study(&["0.1"], "2", None);
        let twice = swept
            .repeat(Seeds::parse("2").unwrap(), "--seeds")
            .unwrap_err();
        assert!(twice.to_string().contains("values of `seed` itself"));
    }
}

//! Many runs of one scene.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::Duration;

use mercury_common::frames::{self, ColumnKind, ColumnSpec};
use mercury_common::machine;
use mercury_common::scene::{SceneError, SceneErrors};
use mercury_common::whole_file::write_whole;
use mercury_solver::output::folder::{self, Earlier};
use mercury_solver::output::summary::Status;
use mercury_solver::results::requested;
use mercury_solver::run::{OpenError, OpenRun, SceneInput, check_fit, plan_within};
use mercury_solver::study::seeds::{DIFFERENCES, MEANS};
use mercury_solver::study::table::{FILE, State, StudyTable};
use mercury_solver::study::{Study as SolverStudy, earlier, file};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyMapping;

use crate::errors::{run_error, scene_error, without_interpreter};
use crate::table::Table;
use crate::values::to_json;

/// Between two looks for a signal.
const LOOK: Duration = Duration::from_millis(50);

/// Between two checkpoints of a run.
const CHECKPOINTS: Duration = Duration::from_secs(600);

/// Many runs of one scene, and the table of their results.
#[pyclass(frozen, module = "mercury_dem")]
pub(crate) struct Study {
    scene: SceneInput,
    stage: Mutex<Stage>,
    folder: PathBuf,
}

/// How far the study is.
struct Stage {
    study: SolverStudy,
    states: Vec<State>,
    /// Prefix of the files of its runs, once all of them were checked.
    prefix: Option<String>,
}

/// Why a study cannot go on.
enum Refused {
    Scene(SceneErrors),
    Other(String),
}

impl From<SceneErrors> for Refused {
    fn from(errors: SceneErrors) -> Self {
        Self::Scene(errors)
    }
}

impl From<String> for Refused {
    fn from(text: String) -> Self {
        Self::Other(text)
    }
}

impl Refused {
    fn raised(self, py: Python<'_>) -> PyErr {
        match self {
            Self::Scene(errors) => scene_error(py, &errors),
            Self::Other(text) => run_error(py, text),
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Stage {
    /// Checks that the first run of each point can be planned and fits into its share of the memory: seeds cost the same.
    fn check(&mut self, scene: &SceneInput, jobs: usize) -> Result<String, Refused> {
        let mut limit = machine::memory();
        if let Some(limit) = &mut limit {
            limit.total /= jobs as f64;
        }
        let of_point = self.study.runs_of_point();
        let mut prefix = String::new();
        for number in 0..self.study.runs.len() {
            if number % of_point > 0 {
                // All but the seed.
                for key in 0..self.study.keys.len() - 1 {
                    let settled = self.study.runs[number - 1].settled[key].clone();
                    self.study.runs[number].settled[key] = settled;
                }
                continue;
            }
            let input = self.input(scene, number);
            let scene = input.scene()?;
            let (plan, memory) = plan_within(&scene, limit)?;
            requested(&scene, &plan)?;
            if let Some(limit) = limit {
                let fit = check_fit(&scene, &plan, &memory, limit);
                fit.map_err(|error: SceneError| SceneErrors(vec![error]))?;
            }
            for result in &self.study.results {
                let checked = result.check(&plan);
                checked.map_err(|problem| format!("result `{}`: {problem}", result.name))?;
            }
            self.study.settle(number, &scene);
            plan.outputs().prefix().clone_into(&mut prefix);
        }
        self.prefix = Some(prefix.clone());
        Ok(prefix)
    }

    /// The scene of a run.
    fn input(&self, scene: &SceneInput, run: usize) -> SceneInput {
        SceneInput {
            set: self.study.overrides(&self.study.runs[run]),
            ..scene.clone()
        }
    }

    /// Runs at a time.
    fn jobs(&self, given: Option<usize>) -> usize {
        let available = std::thread::available_parallelism().map_or(1, usize::from);
        let threads = self.study.threads.map_or(1, usize::from);
        let of_study = self.study.jobs.map(usize::from);
        let jobs = given.or(of_study).unwrap_or((available / threads).max(1));
        jobs.min(self.study.runs.len())
    }
}

/// Runs that are made by several threads.
struct Work<'a> {
    study: &'a SolverStudy,
    scene: &'a SceneInput,
    prefix: &'a str,
    earlier: &'a earlier::Rows,
    /// Set to stop all runs.
    stop: Arc<AtomicBool>,
    board: Mutex<Board>,
    /// A thread has ended.
    is_done: Condvar,
}

struct Board {
    states: Vec<State>,
    begun: Vec<bool>,
    /// Runs that may still be begun.
    left: usize,
    threads: usize,
}

impl Work<'_> {
    /// Takes one run after the other until none is left.
    fn take_runs(&self) {
        while let Some(number) = self.next_run() {
            let (state, is_made) = match self.run(number) {
                Ok(None) => (State::Finished, false),
                Ok(Some(Status::Finished)) => (State::Finished, true),
                Ok(Some(Status::Stopped)) => (State::Stopped, true),
                Err(text) => (State::Failed(text), true),
            };
            let mut board = lock(&self.board);
            board.states[number] = state;
            if is_made {
                let table = StudyTable::of(self.study, &board.states, self.prefix, self.earlier);
                // It is written again at the end, and an error reported.
                let _ = write_whole(&self.study.folder.join(FILE), table.csv().as_bytes());
            } else {
                // It was there.
                board.left += 1;
            }
        }
        lock(&self.board).threads -= 1;
        self.is_done.notify_all();
    }

    fn next_run(&self) -> Option<usize> {
        let mut board = lock(&self.board);
        if board.left == 0 || self.stop.load(Ordering::Relaxed) {
            return None;
        }
        let table = || StudyTable::of(self.study, &board.states, self.prefix, self.earlier);
        let next = self.study.next_run(&board.begun, table)?;
        board.begun[next] = true;
        board.left -= 1;
        if board.states[next] == State::Spare {
            board.states[next] = State::Waiting;
        }
        Some(next)
    }

    /// Makes a run, goes on with it, or finds that it has ended.
    fn run(&self, number: usize) -> Result<Option<Status>, String> {
        let run = &self.study.runs[number];
        let opening = OpenRun {
            input: SceneInput {
                set: self.study.overrides(run),
                ..self.scene.clone()
            },
            folder: self.study.folder.join(&run.name),
            earlier: Earlier::Continue,
            results: Vec::new(),
            threads: Some(self.study.threads.map_or(1, usize::from)),
            checkpoint_every: Some(CHECKPOINTS),
            called: "mercury_dem.Study".to_owned(),
            pause: Arc::clone(&self.stop),
            pieces_observed: true,
        };
        let (mut run, _claim) = match opening.begin() {
            Ok(begun) => begun,
            Err(OpenError::Over { .. }) => return Ok(None),
            Err(error) => return Err(error.to_string()),
        };
        let advanced = run.advance(f64::INFINITY, &mut |_| ());
        advanced.map_err(|failure| failure.to_string())?;
        let report = run.finish().map_err(|failure| failure.to_string())?;
        Ok(Some(report.summary.status))
    }
}

/// Why runs failed, by their names.
fn failures(study: &SolverStudy, states: &[State]) -> Option<String> {
    let runs = study.runs.iter().zip(states);
    let failed: Vec<String> = runs
        .filter_map(|(run, state)| match state {
            State::Failed(why) => Some(format!("run `{}`:\n{}", run.name, why.trim_end())),
            _ => None,
        })
        .collect();
    (!failed.is_empty()).then(|| failed.join("\n"))
}

/// A table of a study: columns of numbers, where all cells are numbers or empty, and of texts.
fn table(py: Python<'_>, table: &StudyTable) -> PyResult<Table> {
    let columns = table.columns.iter().zip(&table.units).enumerate();
    let columns = columns.map(|(place, (name, unit))| {
        let cells = || table.rows.iter().map(|row| &row[place]);
        let numbers = table.numbers(name).unwrap_or_default();
        let are_numbers = !["run", "status", "problem"].contains(&name.as_str())
            && cells()
                .zip(&numbers)
                .all(|(cell, number)| cell.is_empty() || number.is_some());
        match are_numbers {
            true => {
                let unit = if unit.is_empty() { "1" } else { unit };
                let numbers = numbers.into_iter().map(|number| number.unwrap_or(f64::NAN));
                (
                    ColumnSpec::new(name, ColumnKind::F64, unit),
                    frames::Column::F64(numbers.collect()),
                )
            }
            false => (
                ColumnSpec::new(name, ColumnKind::Text, "1"),
                frames::Column::Text(cells().cloned().collect()),
            ),
        }
    });
    let (specs, columns): (Vec<_>, Vec<_>) = columns.unzip();
    Table::new(py, None, &specs, columns)
}

impl Study {
    /// Calls the study without the lock of the interpreter.
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut Stage) -> Result<T, Refused> + Send,
    ) -> PyResult<T> {
        let done = without_interpreter(py, || match self.stage.try_lock() {
            Ok(mut stage) => work(&mut stage),
            Err(TryLockError::Poisoned(stage)) => work(&mut stage.into_inner()),
            Err(TryLockError::WouldBlock) => Err(Refused::Other(
                "another thread uses this study: a study is used by one thread at a time"
                    .to_owned(),
            )),
        })?;
        done.map_err(|refused| refused.raised(py))
    }

    /// The rows of now, and the study that they are of.
    fn rows(&self, py: Python<'_>) -> PyResult<(SolverStudy, StudyTable)> {
        self.with(py, |stage| {
            let prefix = match &stage.prefix {
                Some(prefix) => prefix.clone(),
                None => stage.check(&self.scene, 1)?,
            };
            let earlier = earlier::rows(&stage.study, &prefix)?;
            let table = StudyTable::of(&stage.study, &stage.states, &prefix, &earlier);
            Ok((stage.study.clone(), table))
        })
    }
}

#[pymethods]
impl Study {
    #[new]
    #[pyo3(signature = (study, *, folder = None))]
    fn new(py: Python<'_>, study: &Bound<'_, PyAny>, folder: Option<PathBuf>) -> PyResult<Self> {
        let (path, text) = if study.cast::<PyMapping>().is_ok() {
            (
                PathBuf::from("study.json"),
                format!("{:#}", to_json(study)?),
            )
        } else {
            let path: PathBuf = study.extract().map_err(|_| {
                PyTypeError::new_err("a study is a path or a mapping with the table `study`")
            })?;
            let read = std::fs::read_to_string(&path);
            let read = read.map_err(|error| format!("{} cannot be read: {error}", path.display()));
            (path, read.map_err(|text| run_error(py, text))?)
        };
        let study = file::parse(&path, &text);
        let mut study = study.map_err(|error| run_error(py, error))?;
        if let Some(folder) = folder {
            study.folder = folder;
        }
        study.check_names().map_err(|error| run_error(py, error))?;
        let scene = SceneInput::read(&study.scene).map_err(|errors| scene_error(py, &errors))?;
        if file::is_study(&scene.text) {
            let text = format!(
                "{}: study.scene: {} is a study, not a scene",
                path.display(),
                study.scene.display()
            );
            return Err(run_error(py, text));
        }
        let (of_point, certain) = (study.runs_of_point(), study.certain_runs_of_point());
        let state = |run: usize| match run % of_point < certain {
            true => State::Waiting,
            false => State::Spare,
        };
        Ok(Self {
            scene,
            folder: study.folder.clone(),
            stage: Mutex::new(Stage {
                states: (0..study.runs.len()).map(state).collect(),
                study,
                prefix: None,
            }),
        })
    }

    #[getter]
    fn folder(&self) -> String {
        self.folder.display().to_string()
    }

    fn check(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.with(py, |stage| {
            let jobs = stage.jobs(None);
            stage.check(&self.scene, jobs)?;
            let study = &stage.study;
            let (of_point, certain) = (study.runs_of_point(), study.certain_runs_of_point());
            let runs = study.runs.iter().enumerate();
            let certain = runs.filter(|(number, _)| number % of_point < certain);
            Ok(certain.map(|(_, run)| run.name.clone()).collect())
        })
    }

    #[pyo3(signature = (*, jobs = None, runs = None))]
    fn advance(&self, py: Python<'_>, jobs: Option<usize>, runs: Option<usize>) -> PyResult<bool> {
        if jobs == Some(0) {
            return Err(PyValueError::new_err("`jobs` must be at least 1"));
        }
        let stop = Arc::new(AtomicBool::new(false));
        let mut raised = None;
        let done = self.with(py, |stage| {
            let jobs = stage.jobs(jobs);
            let prefix = stage.check(&self.scene, jobs)?;
            folder::make(&self.folder).map_err(|error| error.to_string())?;
            let _lock = folder::take(&self.folder).map_err(|error| error.to_string())?;
            let earlier = earlier::rows(&stage.study, &prefix)?;
            earlier::write_record(&stage.study, &prefix)?;
            let states = std::mem::take(&mut stage.states);
            // What was stopped goes on; what failed is not tried again by this object.
            let begun = |state: &State| matches!(state, State::Finished | State::Failed(_));
            let failed_before = failures(&stage.study, &states);
            let work = Work {
                study: &stage.study,
                scene: &self.scene,
                prefix: &prefix,
                earlier: &earlier,
                stop: Arc::clone(&stop),
                board: Mutex::new(Board {
                    begun: states.iter().map(begun).collect(),
                    states,
                    left: runs.unwrap_or(usize::MAX / 2),
                    threads: jobs,
                }),
                is_done: Condvar::new(),
            };
            std::thread::scope(|scope| {
                for _ in 0..jobs {
                    scope.spawn(|| work.take_runs());
                }
                let mut board = lock(&work.board);
                while board.threads > 0 {
                    let waited = work.is_done.wait_timeout(board, LOOK);
                    drop(waited.unwrap_or_else(PoisonError::into_inner));
                    if raised.is_none()
                        && let Err(error) = Python::attach(|py| py.check_signals())
                    {
                        raised = Some(error);
                        stop.store(true, Ordering::Relaxed);
                    }
                    board = lock(&work.board);
                }
            });
            let board = work.board.into_inner();
            let board = board.unwrap_or_else(PoisonError::into_inner);
            stage.states = board.states;
            let study = &stage.study;
            let table = StudyTable::of(study, &stage.states, &prefix, &earlier);
            let (means, differences) = (study.means(&table), study.differences(&table));
            for (name, table) in [
                (FILE, Some(&table)),
                (MEANS, means.as_ref()),
                (DIFFERENCES, differences.as_ref()),
            ] {
                if let Some(table) = table {
                    let written = write_whole(&self.folder.join(name), table.csv().as_bytes());
                    written.map_err(|error| error.to_string())?;
                }
            }
            let begun: Vec<bool> = stage.states.iter().map(begun).collect();
            let is_done = study.next_run(&begun, || table.clone()).is_none();
            let failed =
                failures(study, &stage.states).filter(|now| Some(now) != failed_before.as_ref());
            Ok((is_done, failed))
        })?;
        match (raised, done) {
            (Some(error), _) => Err(error),
            (None, (_, Some(failed))) => Err(run_error(py, failed)),
            (None, (is_done, None)) => Ok(is_done),
        }
    }

    fn table(&self, py: Python<'_>) -> PyResult<Table> {
        let (_, rows) = self.rows(py)?;
        table(py, &rows)
    }

    fn means(&self, py: Python<'_>) -> PyResult<Table> {
        let (study, rows) = self.rows(py)?;
        let Some(means) = study.means(&rows) else {
            let text = "means are those of several seeds: `study.seeds` says how many";
            return Err(run_error(py, text));
        };
        table(py, &means)
    }

    fn __repr__(&self) -> String {
        format!("<Study in {}>", self.folder.display())
    }
}

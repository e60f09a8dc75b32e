//! A run that is made in pieces.

use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, TryLockError};
use std::time::Duration;

use glam::DQuat;
use mercury_common::cli;
use mercury_common::readable::rounded;
use mercury_solver::output::folder::Earlier;
use mercury_solver::results::NamedResult;
use mercury_solver::run::{
    Advance, Branch, Claim, OpenError, OpenRun, Progress, Rows, Run as SolverRun, RunFailure,
    Saved, WallDrive,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyMapping, PyType};
use tempfile::TempDir;

use crate::errors::{open_error, run_error, without_interpreter};
use crate::estimate::{Estimate, Summary};
use crate::scene::{Plan, Scene};
use crate::table::Table;
use crate::values::overrides;

/// Run that is not over, and its folder. Fields are dropped in this order.
struct Open {
    run: SolverRun,
    _claim: Claim,
}

/// Where a run stands, for readers that need no lock.
#[derive(Default)]
struct Stage {
    open: Option<Open>,
    /// Summary of the run, once it is finished.
    summary: Option<Py<Summary>>,
    moment: (f64, u64),
}

/// A run.
#[pyclass(frozen, module = "mercury_dem")]
pub(crate) struct Run {
    stage: Mutex<Stage>,
    scene: Scene,
    folder: PathBuf,
    /// Set to leave `advance`.
    pause: Arc<AtomicBool>,
    results: Vec<NamedResult>,
    /// Where `advance` shows how far the run is.
    line: Option<Mutex<cli::Progress<StandardError>>>,
    /// A process that was forked from that of the run has none of its threads.
    process: u32,
    /// Removed with this object, behind all else.
    _temporary: Option<TempDir>,
}

/// `sys.stderr`, which a notebook shows beside its cell.
struct StandardError;

impl Write for StandardError {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let text = String::from_utf8_lossy(bytes);
        let written = Python::attach(|py| {
            let stream = py.import("sys")?.getattr("stderr")?;
            stream.call_method1("write", (text,))?;
            stream.call_method0("flush").map(|_| bytes.len())
        });
        written.map_err(io::Error::other)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The line of progress, if one is wanted: in a terminal, or where it is requested.
fn line(py: Python<'_>, wanted: Option<bool>) -> Option<Mutex<cli::Progress<StandardError>>> {
    let is_terminal = || {
        let stream = py.import("sys")?.getattr("stderr")?;
        stream.call_method0("isatty")?.extract::<bool>()
    };
    let is_terminal = is_terminal().unwrap_or(false);
    let line = || Mutex::new(cli::Progress::to(StandardError, is_terminal));
    wanted.unwrap_or(is_terminal).then(line)
}

/// The names and definitions of results.
fn named(results: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<NamedResult>> {
    let Some(results) = results else {
        return Ok(Vec::new());
    };
    let Ok(results) = results.cast::<PyMapping>() else {
        return Err(PyTypeError::new_err(
            "`results` is a mapping from names to definitions, as in {\"torque\": \"mean(walls.drum.ty, 1..)\"}",
        ));
    };
    let mut all = Vec::new();
    for item in results.items()?.iter() {
        let (name, text): (String, String) = item.extract()?;
        let result = NamedResult::new(&name, &text);
        all.push(result.map_err(|problem| run_error(item.py(), format!("{name}: {problem}")))?);
    }
    Ok(all)
}

impl Run {
    /// Calls the run without the lock of the interpreter.
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut Stage) -> Result<T, String> + Send,
    ) -> PyResult<T> {
        if std::process::id() != self.process {
            return Err(run_error(
                py,
                "the run was begun by another process, from which this one was forked: begin runs behind the fork",
            ));
        }
        let done = without_interpreter(py, || {
            let mut stage = match self.stage.try_lock() {
                Ok(stage) => stage,
                Err(TryLockError::WouldBlock) => {
                    return Err(
                        "another thread uses this run: a run is used by one thread at a time"
                            .to_owned(),
                    );
                }
                Err(TryLockError::Poisoned(_)) => {
                    return Err("the run failed before, by a defect of Mercury".to_owned());
                }
            };
            let done = work(&mut stage);
            if let Some(open) = &stage.open {
                let engine = open.run.engine();
                stage.moment = (engine.time(), engine.steps());
            }
            done
        })?;
        done.map_err(|text| run_error(py, text))
    }

    /// Calls a run that is not finished.
    fn open<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut SolverRun) -> Result<T, String> + Send,
    ) -> PyResult<T> {
        self.with(py, |stage| match &mut stage.open {
            Some(open) => work(&mut open.run),
            None => Err("the run is finished: open(run.folder) reads its files".to_owned()),
        })
    }
}

/// State of a run in memory.
#[pyclass(frozen, module = "mercury_dem")]
pub(crate) struct State {
    saved: Saved,
}

/// The number of a wall.
fn numbered(run: &SolverRun, name: &str) -> Result<usize, String> {
    run.wall(name).ok_or_else(|| {
        let walls = run.plan().physics().walls.iter();
        let known: Vec<&str> = walls.map(|wall| wall.name.as_str()).collect();
        format!("no wall `{name}`; there are: {}", known.join(", "))
    })
}

/// A failure in words.
fn text(failure: &RunFailure) -> String {
    format!("the run failed: {failure}")
}

/// The rows of an observed step.
fn observed(rows: Result<Option<Rows>, RunFailure>) -> Result<Rows, String> {
    rows.map_err(|failure| text(&failure))?.ok_or_else(|| {
        "contacts and loads on walls are known when `advance` has come to its time: advance the run first".to_owned()
    })
}

/// How a run is begun.
struct Begin {
    scene: Scene,
    output: Option<PathBuf>,
    results: Vec<NamedResult>,
    threads: Option<usize>,
    earlier: Earlier,
    checkpoint_every: Option<f64>,
    progress: Option<bool>,
}

impl Begin {
    /// Begins it, as a branch of another run where there is one.
    fn run(self, py: Python<'_>, branch: Option<&Branch>) -> PyResult<Run> {
        if self.threads == Some(0) {
            return Err(PyValueError::new_err("`threads` must be at least 1"));
        }
        let checkpoint_every = self
            .checkpoint_every
            .map(Duration::try_from_secs_f64)
            .transpose();
        let checkpoint_every = checkpoint_every.map_err(|_| {
            PyValueError::new_err("`checkpoint_every` must be a time of at least 0 s, or None")
        })?;
        let (folder, temporary) = match self.output {
            Some(folder) => (folder, None),
            None => {
                let made = tempfile::Builder::new().prefix("mercury-").tempdir()?;
                (made.path().to_owned(), Some(made))
            }
        };
        let pause = Arc::new(AtomicBool::new(false));
        let opening = OpenRun {
            input: self.scene.input.clone(),
            folder: folder.clone(),
            earlier: self.earlier,
            results: self.results.clone(),
            threads: self.threads,
            checkpoint_every,
            called: "mercury_dem.Run".to_owned(),
            pause: Arc::clone(&pause),
            pieces_observed: true,
        };
        let begun = without_interpreter(py, || {
            let begun = match branch {
                Some(branch) => opening.begin_branch(branch),
                None => opening.begin(),
            };
            begun.map_err(Box::new)
        })?;
        let (run, claim) = begun.map_err(|error| open_error(py, &error))?;
        let moment = (run.engine().time(), run.engine().steps());
        Ok(Run {
            stage: Mutex::new(Stage {
                open: Some(Open { run, _claim: claim }),
                summary: None,
                moment,
            }),
            scene: self.scene,
            folder,
            pause,
            results: self.results,
            line: line(py, self.progress),
            process: std::process::id(),
            _temporary: temporary,
        })
    }
}

#[pymethods]
impl Run {
    #[new]
    #[pyo3(signature = (scene, *, output = None, set = None, results = None, threads = None, replace = false, resume = false, checkpoint_every = Some(600.0), progress = None))]
    fn new(
        py: Python<'_>,
        scene: &Bound<'_, PyAny>,
        output: Option<PathBuf>,
        set: Option<&Bound<'_, PyAny>>,
        results: Option<&Bound<'_, PyAny>>,
        threads: Option<usize>,
        replace: bool,
        resume: bool,
        checkpoint_every: Option<f64>,
        progress: Option<bool>,
    ) -> PyResult<Self> {
        let scene = Scene::of(scene)?.with(overrides(set)?);
        let results = named(results)?;
        let earlier = match (replace, resume) {
            (false, false) => Earlier::Refuse,
            (true, false) => Earlier::Replace,
            (false, true) => Earlier::Continue,
            (true, true) => {
                return Err(PyValueError::new_err(
                    "`replace` begins a run anew and `resume` goes on with it: set one of them",
                ));
            }
        };
        if resume && output.is_none() {
            return Err(PyValueError::new_err(
                "`resume` needs `output`, the folder of the run",
            ));
        }
        let begin = Begin {
            scene,
            output,
            results,
            threads,
            earlier,
            checkpoint_every,
            progress,
        };
        begin.run(py, None)
    }

    #[classmethod]
    #[pyo3(signature = (run, at, *, output = None, set = None, threads = None))]
    fn branch(
        class: &Bound<'_, PyType>,
        run: PathBuf,
        at: f64,
        output: Option<PathBuf>,
        set: Option<&Bound<'_, PyAny>>,
        threads: Option<usize>,
    ) -> PyResult<Self> {
        let py = class.py();
        let set = overrides(set)?;
        let planned = without_interpreter(py, || Branch::plan(&run, at, &set))?;
        let branch = planned.map_err(|error| open_error(py, &OpenError::Branch(error)))?;
        let begin = Begin {
            scene: Scene {
                input: branch.input.clone(),
            },
            output,
            results: Vec::new(),
            threads,
            earlier: Earlier::Refuse,
            checkpoint_every: Some(600.0),
            progress: None,
        };
        begin.run(py, Some(&branch))
    }

    #[getter]
    fn time(&self, py: Python<'_>) -> PyResult<f64> {
        self.with(py, |stage| Ok(stage.moment.0))
    }

    #[getter]
    fn step(&self, py: Python<'_>) -> PyResult<u64> {
        self.with(py, |stage| Ok(stage.moment.1))
    }

    #[getter]
    fn is_ended(&self, py: Python<'_>) -> PyResult<bool> {
        self.with(py, |stage| {
            Ok(stage.open.as_ref().is_none_or(|open| open.run.is_ended()))
        })
    }

    #[getter]
    fn plan(&self, py: Python<'_>) -> PyResult<Plan> {
        self.scene.check(py)
    }

    #[getter]
    fn folder(&self) -> String {
        self.folder.display().to_string()
    }

    #[pyo3(signature = (until = None, *, by = None))]
    fn advance(
        &self,
        py: Python<'_>,
        until: Option<f64>,
        by: Option<f64>,
    ) -> PyResult<&'static str> {
        if until.is_some() && by.is_some() {
            return Err(PyTypeError::new_err(
                "`until` is a time and `by` a duration: give one of them",
            ));
        }
        if until.or(by).is_some_and(f64::is_nan) {
            return Err(PyValueError::new_err("the time is not a number"));
        }
        if by.is_some_and(|by| by < 0.0) {
            return Err(PyValueError::new_err(
                "a run does not go back: `by` must be at least 0 s",
            ));
        }
        self.pause.store(false, Ordering::Relaxed);
        let mut raised = None;
        let done = self.open(py, |run| {
            let until = match by {
                Some(by) => run.engine().time() + by,
                None => until.unwrap_or(f64::INFINITY),
            };
            let mut look = |now: &Progress<'_>| {
                if let Some(mut line) = self.line.as_ref().and_then(|line| line.lock().ok()) {
                    line.share_left(now.share(), now.left, || {
                        format!("t = {} s", rounded(now.engine.time(), 4))
                    });
                }
                if let Err(error) = Python::attach(|py| py.check_signals()) {
                    raised = Some(error);
                    self.pause.store(true, Ordering::Relaxed);
                }
            };
            run.advance(until, &mut look)
                .map_err(|failure| text(&failure))
        });
        if let Some(mut line) = self.line.as_ref().and_then(|line| line.lock().ok()) {
            line.clear();
        }
        let done = done?;
        match (done, raised) {
            (_, Some(error)) => Err(error),
            (Advance::Ended, None) => Ok("ended"),
            (Advance::Reached | Advance::Paused, None) => Ok("reached"),
        }
    }

    fn finish(&self, py: Python<'_>) -> PyResult<Py<Summary>> {
        let done = self.with(py, |stage| {
            if let Some(summary) = &stage.summary {
                return Ok(Ok(Python::attach(|py| summary.clone_ref(py))));
            }
            let Some(open) = stage.open.take() else {
                return Err("the run failed before".to_owned());
            };
            let engine = open.run.engine();
            stage.moment = (engine.time(), engine.steps());
            let report = open.run.finish().map_err(|failure| text(&failure))?;
            stage.moment = (report.summary.time, report.summary.steps);
            Ok(Err(
                serde_json::to_value(&report.summary).map_err(|error| error.to_string())?
            ))
        })?;
        let content = match done {
            Ok(summary) => return Ok(summary),
            Err(content) => content,
        };
        let summary = Py::new(py, Summary::new(content))?;
        let kept = summary.clone_ref(py);
        self.with(py, |stage| {
            stage.summary = Some(kept);
            Ok(())
        })?;
        Ok(summary)
    }

    fn checkpoint(&self, py: Python<'_>) -> PyResult<()> {
        self.open(py, |run| match run.write_checkpoint() {
            true => Ok(()),
            false => Err("the output of the run failed: finish() says why".to_owned()),
        })
    }

    #[pyo3(signature = (columns = None))]
    fn particles(&self, py: Python<'_>, columns: Option<Vec<String>>) -> PyResult<Table> {
        let rows = self.open(py, |run| run.particles().map_err(|failure| text(&failure)))?;
        Table::of_state(py, rows, columns.as_deref())
    }

    fn contacts(&self, py: Python<'_>) -> PyResult<Table> {
        let rows = self.open(py, |run| observed(run.contacts()))?;
        Table::of_state(py, rows, None)
    }

    fn walls(&self, py: Python<'_>) -> PyResult<Table> {
        let rows = self.open(py, |run| observed(run.walls()))?;
        Table::of_state(py, rows, None)
    }

    #[pyo3(signature = (wall, *, place, turn = [1.0, 0.0, 0.0, 0.0], velocity = [0.0; 3], angular_velocity = [0.0; 3]))]
    fn drive_wall(
        &self,
        py: Python<'_>,
        wall: &str,
        place: [f64; 3],
        turn: [f64; 4],
        velocity: [f64; 3],
        angular_velocity: [f64; 3],
    ) -> PyResult<()> {
        let [w, x, y, z] = turn;
        let drive = WallDrive {
            place: place.into(),
            turn: DQuat::from_xyzw(x, y, z, w),
            velocity: velocity.into(),
            angular_velocity: angular_velocity.into(),
        };
        self.open(py, |run| {
            let wall = numbered(run, wall)?;
            run.drive_wall(wall, drive)
                .map_err(|failure| failure.to_string())
        })
    }

    fn wall_load(&self, py: Python<'_>, wall: &str) -> PyResult<([f64; 6], [f64; 6])> {
        let loads = self.open(py, |run| {
            let wall = numbered(run, wall)?;
            run.wall_load(wall).map_err(|error| error.to_string())
        })?;
        let [now, mean] = loads.map(|load| {
            let (f, t) = (load.force, load.torque);
            [f.x, f.y, f.z, t.x, t.y, t.z]
        });
        Ok((now, mean))
    }

    fn save(&self, py: Python<'_>) -> PyResult<State> {
        let saved = self.open(py, |run| run.save().map_err(|failure| failure.to_string()))?;
        Ok(State { saved })
    }

    fn restore(&self, py: Python<'_>, state: &Bound<'_, State>) -> PyResult<()> {
        let saved = &state.get().saved;
        self.open(py, |run| {
            run.restore(saved).map_err(|failure| failure.to_string())
        })
    }

    fn result(&self, py: Python<'_>, name: &str) -> PyResult<Estimate> {
        let Some(result) = self.results.iter().find(|result| result.name == name) else {
            let names: Vec<&str> = self
                .results
                .iter()
                .map(|result| result.name.as_str())
                .collect();
            let known = match names.is_empty() {
                true => "no result was named when the run was begun".to_owned(),
                false => format!("there are: {}", names.join(", ")),
            };
            return Err(run_error(py, format!("no result `{name}`; {known}")));
        };
        let value = self.open(py, |run| {
            let value = run.result(result);
            value.ok_or_else(|| "the output of the run failed: finish() says why".to_owned())
        })?;
        Ok(Estimate::read(name, &value))
    }

    fn __enter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    #[pyo3(signature = (*exc))]
    fn __exit__(
        &self,
        py: Python<'_>,
        exc: (Bound<'_, PyAny>, Bound<'_, PyAny>, Bound<'_, PyAny>),
    ) -> PyResult<()> {
        let finished = self.finish(py);
        // The exception of the block counts, and not one that follows from it.
        match exc.0.is_none() {
            true => finished.map(|_| ()),
            false => Ok(()),
        }
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let folder = self.folder.display();
        Ok(format!("<Run at t = {} s, in {folder}>", self.time(py)?))
    }
}

/// Runs a scene to its end.
#[pyfunction]
#[pyo3(signature = (scene, *, output = None, set = None, results = None, threads = None, replace = false))]
pub(crate) fn run(
    py: Python<'_>,
    scene: &Bound<'_, PyAny>,
    output: Option<PathBuf>,
    set: Option<&Bound<'_, PyAny>>,
    results: Option<&Bound<'_, PyAny>>,
    threads: Option<usize>,
    replace: bool,
) -> PyResult<Py<Summary>> {
    let run = Run::new(
        py,
        scene,
        output,
        set,
        results,
        threads,
        replace,
        false,
        Some(600.0),
        None,
    )?;
    let advanced = run.advance(py, None, None);
    let finished = run.finish(py);
    advanced.and(finished)
}

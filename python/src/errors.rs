//! Errors as exceptions of Python.

use std::any::Any;
use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};

use mercury_common::problem;
use mercury_common::scene::SceneErrors;
use mercury_solver::plan::refusal;
use mercury_solver::run::OpenError;
use pyo3::call::PyCallArgs;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

/// One mistake of a scene.
#[pyclass(frozen, get_all, module = "mercury_dem")]
pub(crate) struct Problem {
    key: Option<String>,
    message: String,
    help: Option<String>,
    file: Option<String>,
    line: Option<usize>,
    column: Option<usize>,
}

#[pymethods]
impl Problem {
    fn __repr__(&self) -> String {
        match &self.key {
            Some(key) => format!("<Problem {key}: {}>", self.message),
            None => format!("<Problem {}>", self.message),
        }
    }
}

impl From<&problem::Problem> for Problem {
    fn from(problem: &problem::Problem) -> Self {
        Self {
            key: problem.key.clone(),
            message: problem.message.clone(),
            help: problem.help.clone(),
            file: problem.file.clone(),
            line: problem.start.map(|spot| spot.line),
            column: problem.start.map(|spot| spot.column),
        }
    }
}

/// An exception that the package defines in Python.
fn raised<'py>(py: Python<'py>, class: &str, arguments: impl PyCallArgs<'py>) -> PyErr {
    let class = py
        .import("mercury_dem")
        .and_then(|package| package.getattr(class));
    match class.and_then(|class| class.call1(arguments)) {
        Ok(exception) => PyErr::from_value(exception),
        Err(error) => error,
    }
}

/// A scene that cannot be run, with all of its mistakes.
pub(crate) fn scene_error(py: Python<'_>, errors: &SceneErrors) -> PyErr {
    let problems = problem::Problem::of_scene(errors);
    let problems: Vec<Problem> = problems.iter().map(Problem::from).collect();
    let problems = PyTuple::new(py, problems);
    match problems {
        Ok(problems) => raised(py, "SceneError", (refusal(errors), problems)),
        Err(error) => error,
    }
}

/// A failed run. The advice of the command line is given in arguments of Python.
pub(crate) fn run_error(py: Python<'_>, error: impl Display) -> PyErr {
    let text = error.to_string();
    let text = text
        .replace("--output DIR", "output=...")
        .replace("--force", "replace=True")
        .replace("--resume", "resume=True");
    raised(py, "RunError", (text,))
}

/// A run that was not begun.
pub(crate) fn open_error(py: Python<'_>, error: &OpenError) -> PyErr {
    match error {
        OpenError::Scene(errors) => scene_error(py, errors),
        OpenError::Branch(error) => match error.mistakes() {
            Some(errors) => scene_error(py, errors),
            None => run_error(py, error),
        },
        other => run_error(py, other),
    }
}

/// Work of the solver without the interpreter's lock. A panic, which is a defect of Mercury, becomes a `RunError`.
pub(crate) fn without_interpreter<T: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> T + Send,
) -> PyResult<T> {
    let done = py.detach(|| catch_unwind(AssertUnwindSafe(work)).map_err(|panic| text_of(&*panic)));
    done.map_err(|text| {
        let text = format!("defect of Mercury, please report it with the scene: {text}");
        run_error(py, text)
    })
}

fn text_of(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
    text.unwrap_or("a panic without a text").to_owned()
}

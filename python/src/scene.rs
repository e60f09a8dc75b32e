//! Scenes, and what they mean.

use std::path::PathBuf;

use mercury_common::scene::scene_as_json;
use mercury_solver::plan::{self, Disk, Memory, document_as_json, report};
use mercury_solver::run::SceneInput;
use mercury_solver::starters::STARTERS;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyMapping;

use crate::errors::{run_error, scene_error, without_interpreter};
use crate::values::{escaped, from_json, overrides, to_json};

/// A scene as typed.
#[pyclass(frozen, eq, module = "mercury_dem")]
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Scene {
    pub(crate) input: SceneInput,
}

impl Scene {
    /// A scene, mapping or path.
    pub(crate) fn of(value: &Bound<'_, PyAny>) -> PyResult<Self> {
        if let Ok(scene) = value.cast::<Self>() {
            return Ok(scene.get().clone());
        }
        if let Ok(plan) = value.cast::<Plan>() {
            return Ok(plan.get().scene.clone());
        }
        if value.cast::<PyMapping>().is_ok() {
            return Self::new(value, None);
        }
        match value.extract::<PathBuf>() {
            Ok(path) => Self::read(value.py(), path),
            Err(_) => Err(PyTypeError::new_err(format!(
                "a scene is a path, a mapping or a Scene, not {}",
                value.get_type().qualname()?
            ))),
        }
    }

    /// It with `KEY=VALUE` on top.
    pub(crate) fn with(mut self, set: Vec<String>) -> Self {
        self.input.set.extend(set);
        self
    }
}

#[pymethods]
impl Scene {
    #[new]
    #[pyo3(signature = (scene, *, base = None))]
    fn new(scene: &Bound<'_, PyAny>, base: Option<PathBuf>) -> PyResult<Self> {
        let (name, text) = match scene.extract::<String>() {
            Ok(text) => ("scene", text),
            Err(_) => ("scene.json", format!("{:#}", to_json(scene)?)),
        };
        let set = Vec::new();
        let path = base.unwrap_or_default().join(name);
        Ok(Self {
            input: SceneInput { path, text, set },
        })
    }

    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let input = SceneInput::read(&path).map_err(|errors| scene_error(py, &errors))?;
        Ok(Self { input })
    }

    #[staticmethod]
    fn starter(py: Python<'_>, name: &str) -> PyResult<Self> {
        let Some(starter) = STARTERS.iter().find(|starter| starter.name == name) else {
            let names: Vec<&str> = STARTERS.iter().map(|starter| starter.name).collect();
            let text = format!(
                "there is no starter `{name}`; there are: {}",
                names.join(", ")
            );
            return Err(run_error(py, text));
        };
        let [(file, text)] = starter.files else {
            let text = format!(
                "the starter `{name}` has files beside its scene: write them into a folder with `mercury-solve new {name} FOLDER`, and read the scene there"
            );
            return Err(run_error(py, text));
        };
        Ok(Self {
            input: SceneInput {
                path: PathBuf::from(file),
                text: (*text).to_owned(),
                set: Vec::new(),
            },
        })
    }

    /// For pickles.
    #[staticmethod]
    fn _of(path: PathBuf, text: String, set: Vec<String>) -> Self {
        Self {
            input: SceneInput { path, text, set },
        }
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Parts)> {
        let SceneInput { path, text, set } = self.input.clone();
        let make = py.get_type::<Self>().getattr("_of")?;
        Ok((make, (path, text, set)))
    }

    fn with_set(&self, changes: &Bound<'_, PyAny>) -> PyResult<Self> {
        Ok(self.clone().with(overrides(Some(changes))?))
    }

    pub(crate) fn check(&self, py: Python<'_>) -> PyResult<Plan> {
        let planned = without_interpreter(py, || self.input.plan())?;
        let (_, plan, memory) = planned.map_err(|errors| scene_error(py, &errors))?;
        Ok(Plan {
            scene: self.clone(),
            plan,
            memory,
        })
    }

    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let SceneInput { path, text, set } = &self.input;
        let json = scene_as_json(path, text, set).map_err(|errors| scene_error(py, &errors))?;
        from_json(py, &json)
    }

    fn __repr__(&self) -> String {
        format!("<Scene {}>", self.input.path.display())
    }
}

/// Parts of the pickle of a scene: its path, its text, and the changes by `set`.
type Parts = (PathBuf, String, Vec<String>);

/// A consistent scene.
#[pyclass(frozen, module = "mercury_dem")]
pub(crate) struct Plan {
    pub(crate) scene: Scene,
    plan: plan::Plan,
    memory: Memory,
}

#[pymethods]
impl Plan {
    #[getter]
    fn time_step(&self) -> f64 {
        self.plan.physics().time_step
    }

    #[getter]
    fn steps(&self) -> u64 {
        self.plan.physics().steps
    }

    #[getter]
    fn end(&self) -> f64 {
        self.plan.physics().steps as f64 * self.plan.physics().time_step
    }

    #[getter]
    fn memory(&self) -> u64 {
        self.memory.peak() as u64
    }

    #[getter]
    fn disk(&self) -> u64 {
        Disk::of(&self.plan).bytes as u64
    }

    #[getter]
    fn warnings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, pyo3::types::PyTuple>> {
        pyo3::types::PyTuple::new(py, self.plan.notes().warnings())
    }

    fn report(&self) -> String {
        report(&self.plan, &self.memory, None)
    }

    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let object = document_as_json(&self.plan, &self.memory);
        let object = object.map_err(|error| run_error(py, error))?;
        from_json(py, &object.to_string())
    }

    fn __repr__(&self) -> String {
        format!("<Plan: {} steps of {:e} s>", self.steps(), self.time_step())
    }

    fn _repr_html_(&self) -> String {
        format!("<pre>{}</pre>", escaped(&self.report()))
    }
}

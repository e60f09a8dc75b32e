//! Results with their errors, and how a run ended.

use mercury_solver::output::summary::ResultValue;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use serde_json::Value;

use crate::values::{escaped, from_json};

/// A named result.
#[pyclass(frozen, get_all, module = "mercury_dem")]
#[derive(Debug, Clone)]
pub(crate) struct Estimate {
    name: String,
    of: String,
    unit: String,
    value: Option<f64>,
    error: Option<f64>,
    interval: Option<(f64, f64)>,
    batches: Option<f64>,
    window: Option<(f64, f64)>,
    warm_up: Option<f64>,
    steady: Option<bool>,
    note: Option<String>,
    problem: Option<String>,
    why_no_error: Option<String>,
}

impl Estimate {
    /// A result as a summary has it.
    fn of(name: &str, result: &Value) -> Self {
        let text = |key: &str| result[key].as_str().map(str::to_owned);
        let pair = |key: &str| Some((result[key][0].as_f64()?, result[key][1].as_f64()?));
        Self {
            name: name.to_owned(),
            of: text("of").unwrap_or_default(),
            unit: text("unit").unwrap_or_default(),
            value: result["value"].as_f64(),
            error: result["error"].as_f64(),
            interval: pair("interval"),
            batches: result["batches"].as_f64(),
            window: pair("window"),
            warm_up: result["warm_up"].as_f64(),
            steady: result["steady"].as_bool(),
            note: text("note"),
            problem: text("problem"),
            why_no_error: text("why_no_error"),
        }
    }

    /// A result as it was read.
    pub(crate) fn read(name: &str, result: &ResultValue) -> Self {
        let value = serde_json::to_value(result);
        Self::of(name, &value.unwrap_or_default())
    }

    /// Value, error and unit, or why there is no value.
    fn text(&self) -> String {
        let Some(value) = self.value else {
            return self.problem.clone().unwrap_or_default();
        };
        let unit = match self.unit.as_str() {
            "1" => "",
            unit => unit,
        };
        let error = self
            .error
            .map_or(String::new(), |error| format!(" ± {error:.2e}"));
        format!("{value:.6e}{error} {unit}").trim_end().to_owned()
    }
}

#[pymethods]
impl Estimate {
    fn __repr__(&self) -> String {
        format!("<Estimate {} = {}>", self.name, self.text())
    }

    fn _repr_html_(&self) -> String {
        let interval = self.interval.map_or(String::new(), |(low, high)| {
            format!(", 95 %: {low:.6e} to {high:.6e}")
        });
        format!(
            "<b>{}</b> = {}{interval} <small>{}</small>",
            escaped(&self.name),
            escaped(&self.text()),
            escaped(&self.of)
        )
    }
}

/// How a run ended, and its numbers.
#[pyclass(frozen, module = "mercury_dem")]
pub(crate) struct Summary {
    content: Value,
}

impl Summary {
    /// The content of a `summary.json`.
    pub(crate) fn new(content: Value) -> Self {
        Self { content }
    }

    fn estimates(&self) -> Vec<Estimate> {
        let results = self.content["results"].as_object();
        let all = results.into_iter().flatten();
        all.map(|(name, result)| Estimate::of(name, result))
            .collect()
    }

    fn lines(&self) -> Vec<String> {
        let all = self.content["warnings"].as_array();
        let texts = all.into_iter().flatten().filter_map(Value::as_str);
        texts.map(str::to_owned).collect()
    }
}

#[pymethods]
impl Summary {
    #[getter]
    fn status(&self) -> &str {
        self.content["status"].as_str().unwrap_or_default()
    }

    #[getter]
    fn cause(&self) -> Option<&str> {
        self.content["cause"].as_str()
    }

    #[getter]
    fn link(&self) -> Option<&str> {
        self.content["link"].as_str()
    }

    #[getter]
    fn time(&self) -> Option<f64> {
        self.content["time"].as_f64()
    }

    #[getter]
    fn steps(&self) -> Option<u64> {
        self.content["steps"].as_u64()
    }

    #[getter]
    fn warnings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.lines())
    }

    #[getter]
    fn results<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let results = PyDict::new(py);
        for estimate in self.estimates() {
            results.set_item(estimate.name.clone(), Py::new(py, estimate)?)?;
        }
        Ok(results)
    }

    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        from_json(py, &self.content.to_string())
    }

    fn __repr__(&self) -> String {
        let time = self.time().unwrap_or_default();
        format!("<Summary: {} at t = {time} s>", self.status())
    }

    fn _repr_html_(&self) -> String {
        let mut html = format!("<p>{}</p>", escaped(&self.__repr__()));
        for estimate in self.estimates() {
            html += &format!("<p>{}</p>", estimate._repr_html_());
        }
        for warning in self.lines() {
            html += &format!("<p>warning: {}</p>", escaped(&warning));
        }
        html
    }
}

//! Runs compared with their chains.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use mercury_solver::verify::{self, Options, VerifyError};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::errors::{run_error, without_interpreter};

/// Between two looks for Ctrl-C.
const LOOK: Duration = Duration::from_millis(50);

/// The result of a verification.
#[pyclass(frozen, module = "mercury_dem")]
pub(crate) struct Verification {
    found: verify::Verification,
}

/// Verifies the run in a folder; Ctrl-C stops it.
pub(crate) fn verified(
    py: Python<'_>,
    folder: &Path,
    steps: f64,
    seed: Option<u64>,
) -> PyResult<Verification> {
    if !(steps > 0.0 && steps <= 1.0) {
        return Err(PyValueError::new_err(
            "`steps` is a share of the steps, above 0 and at most 1",
        ));
    }
    let stop = Arc::new(AtomicBool::new(false));
    let options = Options {
        share: steps,
        seed,
        jobs: 1,
        threads: std::thread::available_parallelism().map_or(1, usize::from),
        stop: Arc::clone(&stop),
    };
    let mut raised = None;
    let found = without_interpreter(py, || {
        std::thread::scope(|scope| {
            let work = scope.spawn(|| verify::verify(folder, &options));
            while !work.is_finished() {
                std::thread::sleep(LOOK);
                if let Err(error) = Python::attach(|py| py.check_signals()) {
                    raised.get_or_insert(error);
                    stop.store(true, Ordering::Relaxed);
                }
            }
            work.join()
        })
    })?;
    if let Some(error) = raised {
        return Err(error);
    }
    let found: Result<verify::Verification, VerifyError> =
        found.map_err(|_| run_error(py, "defect of Mercury, please report it with the run"))?;
    let found = found.map_err(|error| run_error(py, error))?;
    Ok(Verification { found })
}

#[pymethods]
impl Verification {
    #[getter]
    fn right(&self) -> bool {
        self.found.right
    }

    #[getter]
    fn share(&self) -> f64 {
        self.found.share
    }

    #[getter]
    fn first_difference(&self) -> Option<&str> {
        self.found.first_difference.as_deref()
    }

    #[getter]
    fn link(&self) -> &str {
        &self.found.link
    }

    fn to_dict(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let json = py.import("json")?;
        let text = self.found.as_json().to_string();
        Ok(json.call_method1("loads", (text,))?.unbind())
    }

    fn __bool__(&self) -> bool {
        self.found.right
    }

    fn __repr__(&self) -> String {
        format!("<Verification: {}>", self.found)
    }
}

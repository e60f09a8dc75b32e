//! The module `mercury_dem._mercury_dem`: Mercury's solver as classes of Python.
//!
//! The package `mercury_dem` (in `mercury_dem/`) gives their names to users, holds the exceptions and the stub with types and docstrings.

mod command;
mod errors;
mod estimate;
mod record;
mod run;
mod scene;
mod study;
mod table;
mod values;
mod verification;

use pyo3::prelude::*;

#[pymodule]
mod _mercury_dem {
    #[pymodule_export]
    use super::command::command;
    #[pymodule_export]
    use super::errors::Problem;
    #[pymodule_export]
    use super::estimate::{Estimate, Summary};
    #[pymodule_export]
    use super::record::{Record, open};
    #[pymodule_export]
    use super::run::{Run, State, run};
    #[pymodule_export]
    use super::scene::{Plan, Scene};
    #[pymodule_export]
    use super::study::Study;
    #[pymodule_export]
    use super::table::{Column, Table};
    #[pymodule_export]
    use super::verification::Verification;

    use super::{Bound, PyModule, PyModuleMethods, PyResult};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("PHYSICS", mercury_solver::output::chain::PHYSICS)?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}

//! The program `mercury-solve`, begun from Python.

use std::ffi::OsString;
use std::io::Write as _;

use pyo3::prelude::*;

use crate::errors::without_interpreter;

/// Executes a command line of `mercury-solve`, which begins with the name of the program, and returns its exit code.
#[pyfunction]
pub(crate) fn command(py: Python<'_>, words: Vec<OsString>) -> PyResult<u8> {
    without_interpreter(py, || {
        let exit = mercury_solver::command::main(words);
        // Rust's standard output is not that of Python, which empties its own at the end. A closed one is not an error here.
        let _ = std::io::stdout().flush();
        exit as u8
    })
}

//! Programs of engines, and what they say.

use std::io::Write;
use std::process::{Command, Stdio};

use crate::EngineError;

/// Runs a program of an engine; returns what it says on standard output.
pub(crate) fn call<'a>(
    program: &str,
    arguments: impl IntoIterator<Item = &'a str>,
    input: Option<&str>,
) -> Result<String, EngineError> {
    let failed = |source| EngineError::Program {
        program: program.to_owned(),
        source,
    };
    let mut child = Command::new(program)
        .args(arguments)
        .stdin(if input.is_some() {
            Stdio::piped()
        } else {
            Stdio::null()
        })
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(failed)?;
    if let (Some(input), Some(mut stdin)) = (input, child.stdin.take()) {
        stdin.write_all(input.as_bytes()).map_err(failed)?;
    }
    let output = child.wait_with_output().map_err(failed)?;
    if output.status.success() {
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    } else {
        let message = String::from_utf8_lossy(&output.stderr).trim().to_owned();
        Err(EngineError::Refused {
            program: program.to_owned(),
            message,
        })
    }
}

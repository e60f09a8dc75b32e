//! Exit codes of programs, and the messages of their failures.

use std::fmt;
use std::io::Write;
use std::process::ExitCode;

use crate::problem::Problem;

/// How a program ends: the number that scripts see.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// All was done.
    Done = 0,
    /// The input was good, but the work failed, or its result is that a check fails.
    Failed = 1,
    /// Wrong usage or input: something to correct and type again.
    Input = 2,
    /// The work was stopped before its end and can be resumed (`EX_TEMPFAIL` of sysexits.h).
    Resumable = 75,
    /// The program was stopped by SIGINT or SIGTERM and leaves nothing that can be resumed. The exit code is that of a shell for
    /// SIGINT. A program that has something to keep ends in this way when Ctrl-C is pressed twice.
    AtOnce = 130,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

/// Result of a program's work.
pub type Outcome = Result<(), Failure>;

/// Failure of a program: its exit code and its message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Failure {
    /// How the program ends.
    pub exit: Exit,
    /// Message on standard error; empty for none.
    pub message: String,
    /// Problems of the message one by one, for programs that read them; empty where the text is all that is known.
    problems: Vec<Problem>,
    /// The requested output is already on standard output.
    is_answered: bool,
}

impl Failure {
    /// Wrong usage or input.
    pub fn input(message: impl fmt::Display) -> Self {
        Self::new(Exit::Input, message)
    }

    /// The work failed.
    pub fn run(message: impl fmt::Display) -> Self {
        Self::new(Exit::Failed, message)
    }

    /// Any other end.
    pub fn new(exit: Exit, message: impl fmt::Display) -> Self {
        Self {
            exit,
            message: message.to_string(),
            problems: Vec::new(),
            is_answered: false,
        }
    }

    /// Adds the problems of the message one by one, for programs that read them.
    #[must_use]
    pub fn with_problems(mut self, problems: Vec<Problem>) -> Self {
        self.problems = problems;
        self
    }

    /// The requested output is already on standard output: nothing more is printed there.
    #[must_use]
    pub fn answered(mut self) -> Self {
        self.is_answered = true;
        self
    }

    /// The error as a record for programs; `None` where standard output already holds the requested output.
    #[must_use]
    pub fn problems(&self) -> Option<Vec<Problem>> {
        match (self.is_answered, self.problems.is_empty()) {
            (true, _) => None,
            (false, true) => Some(vec![Problem::of_text(&self.message)]),
            (false, false) => Some(self.problems.clone()),
        }
    }

    /// Adds what to do about it, in a line of its own as the readers of files do.
    #[must_use]
    pub fn with_help(mut self, help: impl fmt::Display) -> Self {
        self.message += &format!("\nhelp: {help}");
        self
    }
}

/// The exit code of an outcome, whose message goes to `errors`.
pub(super) fn ended(outcome: Outcome, errors: &mut dyn Write) -> Exit {
    let Err(failure) = outcome else {
        return Exit::Done;
    };
    if !failure.message.is_empty() {
        // A closed standard error is not an error here: the exit code carries the result.
        let _ = writeln!(errors, "{}", failure.message.trim_end());
    }
    failure.exit
}

#[cfg(test)]
mod tests {
    use super::*;

    fn end(outcome: Outcome) -> (u8, String) {
        let mut errors = Vec::new();
        let exit = ended(outcome, &mut errors);
        (exit as u8, String::from_utf8(errors).unwrap())
    }

    #[test]
    fn each_end_has_its_code_and_says_its_message_once() {
        assert_eq!(end(Ok(())), (0, String::new()));
        assert_eq!(
            end(Err(Failure::run("the disk is full"))),
            (1, "the disk is full\n".to_owned())
        );
        assert_eq!(
            end(Err(
                Failure::input("--size: 0 is not above 0\n").with_help("give a length in m")
            )),
            (
                2,
                "--size: 0 is not above 0\n\nhelp: give a length in m\n".to_owned()
            )
        );
        assert_eq!(
            end(Err(Failure::new(Exit::Resumable, ""))),
            (75, String::new())
        );
    }
}

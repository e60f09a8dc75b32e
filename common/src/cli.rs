//! Command-line conventions of all Mercury programs: exit codes and final messages, completions, progress, Ctrl-C, and the values
//! of options.
//!
//! A program's `main.rs` holds its arguments and what they mean. The rest is in this module:
//!
//! ```no_run
//! use clap::Parser;
//! use mercury_common::cli::{self, Failure, Outcome};
//!
//! const EXAMPLES: &str = "\
//! Examples:
//!   mercury-count sizes.csv        prints the number of lines
//!
//! Exit codes: 0 done, 2 wrong usage or input.";
//!
//! /// Counts the lines of a file.
//! #[derive(Debug, Parser)]
//! #[command(name = "mercury-count", version, after_help = EXAMPLES)]
//! struct Arguments {
//!     /// The file
//!     #[arg(value_name = "FILE", required_unless_present = "completions")]
//!     file: Option<std::path::PathBuf>,
//!
//!     /// Print completions for a shell and exit
//!     #[arg(long, value_name = "SHELL")]
//!     completions: Option<cli::Shell>,
//! }
//!
//! fn main() -> std::process::ExitCode {
//!     cli::main(|arguments: Arguments| {
//!         if let Some(shell) = arguments.completions {
//!             return cli::say_completions::<Arguments>(shell);
//!         }
//!         let path = arguments.file.unwrap_or_default();
//!         let text = std::fs::read_to_string(&path)
//!             .map_err(|error| Failure::input(format!("{}: {error}", path.display())))?;
//!         cli::say(&format!("{} lines", text.lines().count()))
//!     })
//! }
//! ```
//!
//! Behind the feature `cli`, which is on unless a dependent turns it off: libraries that only read and write files need no
//! parser of command lines.

mod failure;
mod interrupt;
mod progress;
mod values;

use std::ffi::OsString;
use std::io::Write as _;
use std::process::ExitCode;

use clap::{CommandFactory, Parser};
pub use clap_complete::Shell;

pub use failure::{Exit, Failure, Outcome};
pub use interrupt::{Temporary, end_at_once, note_on_request, stop_on_request};
pub use progress::Progress;
pub use values::{duration, positive, quantity};

/// Reads the arguments, does what `execute` does with them, and reports what went wrong.
///
/// Wrong usage ends with [`Exit::Input`], `--help` and `--version` with [`Exit::Done`], all else with the exit of `execute`.
pub fn main<A: Parser>(execute: impl FnOnce(A) -> Outcome) -> ExitCode {
    main_of(std::env::args_os().collect(), execute, |_| {}).into()
}

/// As [`main`], of a command line that begins with the name of the program. What went wrong is handed to `tell` before it is printed, wrong
/// usage included.
pub fn main_of<A: Parser>(
    words: Vec<OsString>,
    execute: impl FnOnce(A) -> Outcome,
    tell: impl FnOnce(&Failure),
) -> Exit {
    match A::try_parse_from(words) {
        Ok(arguments) => {
            let outcome = execute(arguments);
            if let Err(failure) = &outcome {
                tell(failure);
            }
            failure::ended(outcome, &mut std::io::stderr())
        }
        Err(error) => {
            // A closed stream is not an error here: the exit code carries the result.
            if !error.use_stderr() {
                let _ = error.print();
                return Exit::Done;
            }
            tell(&Failure::input(wrong_usage(&error.to_string())));
            let _ = error.print();
            Exit::Input
        }
    }
}

/// Message of the command-line parser without its usage text, with its tip in the form of all other advice.
fn wrong_usage(text: &str) -> String {
    let text = text.strip_prefix("error: ").unwrap_or(text);
    let what = text.split("\n\nUsage:").next().unwrap_or_default();
    what.trim_end().replacen("\n\n  tip: ", "\nhelp: ", 1)
}

/// Prints a text on standard output, with one line break at its end. A reader that has gone away (`| head`) is no failure.
///
/// # Errors
/// If standard output takes nothing, for example because the disk is full.
pub fn say(text: &str) -> Outcome {
    match writeln!(std::io::stdout(), "{}", text.trim_end()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::run(format!("standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Prints the completions of a program for a shell.
///
/// # Errors
/// Errors of [`say`].
pub fn say_completions<A: CommandFactory>(shell: Shell) -> Outcome {
    let mut command = A::command();
    let name = command.get_name().to_owned();
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut command, name, &mut script);
    say(&String::from_utf8_lossy(&script))
}

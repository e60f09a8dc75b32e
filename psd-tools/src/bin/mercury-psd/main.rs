//! `mercury-psd`: the command line, nothing else.

mod arguments;
mod commands;

use std::process::ExitCode;

use arguments::{Arguments, Command};
use mercury_common::cli;

fn main() -> ExitCode {
    cli::main(|arguments: Arguments| match &arguments.command {
        Command::Stats(arguments) => commands::stats::run(arguments),
        Command::Convert(arguments) => commands::convert::run(arguments),
        Command::Fit(arguments) => commands::fit::run(arguments),
        Command::Compare(arguments) => commands::compare::run(arguments),
        Command::Sample(arguments) => commands::sample::run(arguments),
        Command::Plot(arguments) => commands::plot::run(arguments),
        Command::Check(arguments) => commands::check::run(arguments),
        Command::Completions { shell } => cli::say_completions::<Arguments>(*shell),
    })
}

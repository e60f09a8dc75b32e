//! `mercury-solve verify`: a run against its chain.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use crate::verify::{self, Options};
use clap::Args;
use mercury_common::cli::{self, Failure, Outcome, say};

use super::MOST_THREADS;
use super::problems::say_object;

/// Arguments of `verify`: the run, and how much of it is made again.
#[derive(Debug, Args)]
pub(crate) struct Verify {
    /// Folder of the run
    #[arg(value_name = "RUN")]
    run: PathBuf,

    /// Share of the steps that are made again, at least
    #[arg(long, value_name = "SHARE", default_value = "1%", value_parser = share)]
    steps: f64,

    /// Make all steps again
    #[arg(long, conflicts_with_all = ["steps", "seed"])]
    all: bool,

    /// For drawing the steps [default: a number of the system]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,

    /// Segments made at a time
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    jobs: u16,

    /// Threads of all of them [default: what the machine has]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    threads: Option<u16>,

    /// Print the result as one JSON object on standard output
    #[arg(long)]
    json: bool,
}

/// A share, in per cent.
fn share(text: &str) -> Result<f64, String> {
    let number = text.trim().strip_suffix('%').map(str::trim);
    let share = number.and_then(|number| number.parse::<f64>().ok());
    share
        .filter(|share| *share > 0.0 && *share <= 100.0)
        .map(|share| share / 100.0)
        .ok_or_else(|| "expected a share like 1%, above 0 and at most 100%".to_owned())
}

/// Verifies it: exit code 0 where nothing differs, 1 where something does, 2 where it cannot be verified.
pub(crate) fn execute(verify: &Verify) -> Outcome {
    let available = || std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    let options = Options {
        share: if verify.all { 1.0 } else { verify.steps },
        seed: verify.seed,
        jobs: usize::from(verify.jobs),
        threads: verify.threads.map_or_else(available, usize::from),
        stop: cli::stop_on_request()?,
    };
    let result = verify::verify(&verify.run, &options).map_err(|error| {
        let message = format!("verify: {error}");
        match error.is_failure() {
            true => Failure::run(message),
            false => Failure::input(message),
        }
    })?;
    if verify.json {
        say_object(&result.as_json())?;
    } else if result.right {
        say(&format!("{}: {result}", verify.run.display()))?;
    }
    match &result.first_difference {
        None => Ok(()),
        Some(difference) => {
            let failure = Failure::run(format!("verify: {difference}"));
            Err(if verify.json {
                failure.answered()
            } else {
                failure
            })
        }
    }
}

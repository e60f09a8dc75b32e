//! The program `mercury-solve` from its command line: input, output, signals, studies.

mod branch;
mod chain;
mod cli;
#[path = "../common/mod.rs"]
mod common;
mod disk;
mod input;
mod machine;
mod progress;
mod prospects;
mod resume;
mod starters;
mod starts_from_runs;
mod stopping;
mod study;
mod trial;
mod until;
mod verify;

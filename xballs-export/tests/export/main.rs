//! `mercury-export` from its command line and as a library.

mod beside;
mod cli;
mod clumps;
mod parquet;
mod pictures;
mod query;
#[path = "../run_folder/mod.rs"]
mod run_folder;

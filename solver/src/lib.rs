//! The solver: from a scene to the files of a run, over the [engine](mercury_engine).
//!
//! The modules, each of which may use those below it: [`command`], [`run`], [`results`], [`output`], [`plan`]. Beside them [`study`]: many runs of one
//! scene; [`starters`]: scenes to start from; [`verify`]: runs against their chains. Plans and output of some features have a folder for each: `bonds`, `boundaries`, `liquid`, `membranes`,
//! `sprays`, `wear`.

#![warn(clippy::disallowed_methods)]
#![cfg_attr(test, allow(clippy::disallowed_methods))]

mod bonds;
mod boundaries;
pub mod command;
mod liquid;
mod membranes;
pub mod output;
pub mod plan;
pub mod results;
pub mod run;
mod sprays;
pub mod starters;
pub mod study;
pub mod verify;
mod wear;

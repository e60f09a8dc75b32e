//! The tasks of `mercury-solve` beside running one scene, each with its part of the command line.

pub(crate) mod check;
pub(crate) mod input;
pub(crate) mod new;
pub(crate) mod problems;
pub(crate) mod progress;
pub(crate) mod ranks;
pub(crate) mod run;
pub(crate) mod scene;
pub(crate) mod study;
pub(crate) mod trial;
pub(crate) mod verify;
pub(crate) mod waiting;

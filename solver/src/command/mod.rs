//! What `mercury-solve` does besides running one scene, each with its part of the command line.

pub(crate) mod new;
pub(crate) mod run;
pub(crate) mod study;
pub(crate) mod trial;
pub(crate) mod waiting;

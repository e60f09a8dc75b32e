//! Nozzles and droplets: what a scene says of them, and their file.

pub(crate) mod output;
pub(crate) mod plan;

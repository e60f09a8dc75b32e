//! Glued grains: what a scene says of them, and their files.

pub(crate) mod output;
pub(crate) mod plan;

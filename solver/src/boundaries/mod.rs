//! Insertions, deletions and what is counted at planes and in regions: what a scene says of them, and their files.

pub(crate) mod output;
pub(crate) mod plan;

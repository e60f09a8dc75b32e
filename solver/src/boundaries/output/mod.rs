//! Tables of what crosses planes and of what is in regions.

pub(crate) mod flux_counts;
pub(crate) mod passage_file;
pub(crate) mod region_counts;

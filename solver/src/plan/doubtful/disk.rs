//! Output that takes much of a disk.

use super::Finding;
use crate::plan::{Disk, Plan};

/// A warning if there are very many frames, or very many bytes.
pub(super) fn much_output(plan: &Plan) -> Vec<Finding> {
    Disk::of(plan)
        .warning()
        .map(Finding::Warning)
        .into_iter()
        .collect()
}

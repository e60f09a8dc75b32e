//! Output that takes much of a disk.

use super::Doubt;
use crate::plan::{Disk, Plan};

/// A warning if there are very many frames, or very many bytes.
pub(super) fn much_output(plan: &Plan) -> Vec<Doubt> {
    Disk::of(plan)
        .warning()
        .map(Doubt::Warning)
        .into_iter()
        .collect()
}

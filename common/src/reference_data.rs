//! Where tests find the reference data, which lie beside the project and are not part of it.

use std::path::{Path, PathBuf};

/// A file or folder of the reference data; `None` (with a message) where they are not installed, unless in continuous
/// integration, where they must be.
///
/// # Panics
/// Where `CI` is set and there is no such file.
#[must_use]
#[allow(clippy::print_stdout, reason = "used by tests alone, for their output")]
pub fn shared(relative: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../shared")
        .join(relative);
    if path.exists() {
        return Some(path);
    }
    let missing = format!("{} is missing", path.display());
    assert!(std::env::var_os("CI").is_none(), "{missing}");
    println!("skipped: {missing}");
    None
}

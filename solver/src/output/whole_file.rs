//! Files that are there as a whole or not at all.

use std::fs;
use std::path::Path;

use super::OutputError;

/// Writes a file under a temporary name beside its place, then renames it.
///
/// # Errors
/// If the system refuses; a file that was there before is still there then.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".tmp-{}", std::process::id()));
    let temporary = path.with_file_name(name);
    let written = fs::write(&temporary, bytes).and_then(|()| fs::rename(&temporary, path));
    written.map_err(|source| {
        // The first error is the one worth telling; a leftover is all that a second one could mean.
        let _ = fs::remove_file(&temporary);
        OutputError::File {
            path: path.to_owned(),
            action: "the file cannot be written",
            source,
        }
    })
}

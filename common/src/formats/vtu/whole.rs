//! Files that are there as a whole or not at all.

use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::Path;

use super::VtuError;

/// Writes a file under a temporary name beside its place, then renames it.
pub(super) fn write_whole(path: &Path, parts: &[Vec<u8>]) -> Result<(), VtuError> {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".tmp-{}", std::process::id()));
    let temporary = path.with_file_name(name);
    let write = || -> io::Result<()> {
        let mut file = File::create(&temporary)?;
        for part in parts {
            file.write_all(part)?;
        }
        fs::rename(&temporary, path)
    };
    let written = write();
    if written.is_err() {
        // The first error is the one worth telling; a leftover is all that a second one could mean.
        let _ = fs::remove_file(&temporary);
    }
    written.map_err(VtuError::file(path, "the file cannot be written"))
}

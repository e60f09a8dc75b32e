//! The folder of a run: what may be there before, and what may be removed.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

/// Why a run cannot use a folder.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// A run is there already.
    #[error(
        "{}: this folder holds a run already (there is a {found})\nhelp: --force replaces it, --output DIR writes elsewhere",
        path.display()
    )]
    HoldsRun {
        /// The folder.
        path: PathBuf,
        /// A file of that run.
        found: String,
    },
    /// Another run writes into the folder at this moment.
    #[error(
        "{}: this folder is being written by another run\nhelp: wait for its end or stop it, or choose another folder with --output DIR",
        path.display()
    )]
    InUse {
        /// The folder.
        path: PathBuf,
    },
    /// The name belongs to something else.
    #[error("{}: this is not a folder\nhelp: choose another one with --output DIR", path.display())]
    NotAFolder {
        /// The name.
        path: PathBuf,
    },
    /// The operating system refused.
    #[error("{}: {action}: {source}\nhelp: choose another folder with --output DIR", path.display())]
    System {
        /// The folder or file.
        path: PathBuf,
        /// What was tried.
        action: &'static str,
        /// What the system said.
        source: io::Error,
    },
}

/// Endings of the files that a run writes behind its prefix.
const ENDINGS: [&str; 20] = [
    "data",
    "ene",
    "fstat",
    "particles.arrow",
    "contacts.arrow",
    "walls.arrow",
    "surfaces.arrow",
    "bodies.arrow",
    "clumps.arrow",
    "triangle_loads.arrow",
    "track.csv",
    "walls.csv",
    "regions.csv",
    "flux.csv",
    "0.restart",
    "1.restart",
    "final.png",
    "final.svg",
    "energy.png",
    "energy.svg",
];

/// Files that every run writes under the same name.
const FIXED_NAMES: [&str; 3] = ["plan.toml", "summary.json", "run.log"];

/// All names that a run with this prefix may write.
pub fn names(prefix: &str) -> impl Iterator<Item = String> + '_ {
    let fixed = FIXED_NAMES.iter().map(|&name| name.to_owned());
    fixed.chain(
        ENDINGS
            .iter()
            .map(move |ending| format!("{prefix}.{ending}")),
    )
}

/// The names of a run with this prefix that are in the folder.
#[must_use]
pub fn present(folder: &Path, prefix: &str) -> Vec<String> {
    // Also links that lead nowhere count: they are in the way.
    names(prefix)
        .filter(|name| folder.join(name).symlink_metadata().is_ok())
        .collect()
}

/// The file that a run holds a lock on as long as it writes into its folder.
pub const LOCK: &str = ".lock";

/// A folder that belongs to one run until this is dropped.
///
/// It is the lock of the operating system that counts, not the file: a file that a killed run left behind is no obstacle.
#[derive(Debug)]
pub struct FolderLock {
    path: PathBuf,
    /// None where the file system has no locks.
    file: Option<File>,
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // While the lock is still held: afterwards the file may be the next run's.
        if self.file.is_some() {
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Takes the folder for a run; nothing if another one holds it.
fn lock(folder: &Path) -> io::Result<Option<FolderLock>> {
    let path = folder.join(LOCK);
    loop {
        let mut options = OpenOptions::new();
        let file = options
            .write(true)
            .create(true)
            .truncate(false)
            .open(&path)?;
        match file.try_lock() {
            // The run that had the lock may have removed the file after it was opened here.
            Ok(()) if !is_at(&file, &path) => {}
            Ok(()) => {
                let file = Some(file);
                return Ok(Some(FolderLock { path, file }));
            }
            Err(TryLockError::WouldBlock) => return Ok(None),
            // Some network file systems have no locks: no reason to refuse a run.
            Err(TryLockError::Error(_)) => {
                let _ = fs::remove_file(&path);
                return Ok(Some(FolderLock { path, file: None }));
            }
        }
    }
}

/// Whether the open file is still the one of that name.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    let identity = |data: fs::Metadata| (data.dev(), data.ino());
    match (file.metadata(), fs::metadata(path)) {
        (Ok(open), Ok(named)) => identity(open) == identity(named),
        _ => false,
    }
}

/// Whether the open file is still the one of that name.
#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> bool {
    path.exists()
}

/// Makes a folder ready for a run: there, writable, without a run. It belongs to this run until what is returned is dropped.
///
/// With `force` the files of an earlier run are removed, and nothing but these.
///
/// # Errors
/// If another run is writing into the folder, with `force` or without; if the folder holds a run and `force` is off; if it is no
/// folder, or cannot be made, emptied or written.
pub fn prepare(folder: &Path, prefix: &str, force: bool) -> Result<FolderLock, FolderError> {
    let system = |path: &Path, action, source| FolderError::System {
        path: path.to_owned(),
        action,
        source,
    };
    if folder.exists() && !folder.is_dir() {
        return Err(FolderError::NotAFolder {
            path: folder.to_owned(),
        });
    }
    fs::create_dir_all(folder)
        .map_err(|source| system(folder, "the folder cannot be made", source))?;
    // First of all: what a running run has written is not to be judged. That it cannot be locked is told below.
    let locked = match lock(folder) {
        Ok(Some(lock)) => Ok(lock),
        Err(error) => Err(error),
        Ok(None) => {
            return Err(FolderError::InUse {
                path: folder.to_owned(),
            });
        }
    };
    let present = present(folder, prefix);
    if let (Some(found), false) = (present.first(), force) {
        return Err(FolderError::HoldsRun {
            path: folder.to_owned(),
            found: found.clone(),
        });
    }
    let cannot = |source| system(folder, "nothing can be written in the folder", source);
    let probe = folder.join(format!(".mercury-{}", std::process::id()));
    fs::write(&probe, b"")
        .and_then(|()| fs::remove_file(&probe))
        .map_err(cannot)?;
    let lock = locked.map_err(cannot)?;
    for name in present {
        let path = folder.join(name);
        fs::remove_file(&path)
            .map_err(|source| system(&path, "the file cannot be removed", source))?;
    }
    Ok(lock)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_belongs_to_one_run_at_a_time() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("run");
        let file = folder.join(LOCK);
        let first = prepare(&folder, "a", false).unwrap();
        assert!(file.exists());
        for force in [false, true] {
            let refused = prepare(&folder, "b", force).unwrap_err().to_string();
            let expected = format!(
                "{}: this folder is being written by another run\nhelp: wait for its end or stop it, or choose another folder with --output DIR",
                folder.display()
            );
            assert_eq!(refused, expected);
        }
        assert!(file.exists(), "a refused run leaves the lock alone");
        drop(first);
        assert!(!file.exists());
        // What a killed run left behind.
        fs::write(&file, "").unwrap();
        drop(prepare(&folder, "a", false).unwrap());
        assert!(!file.exists());
    }
}

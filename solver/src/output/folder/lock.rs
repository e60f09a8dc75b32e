//! A folder belongs to one run at a time: a lock of the operating system, and the name of the run that holds it.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::time::Duration;

use mercury_common::folder_owner::{LOCK, Owner};

/// A program that looks whether a run writes into the folder (`is_written`) holds the lock for some microseconds: the second try comes after
/// this time.
const SECOND_TRY: Duration = Duration::from_millis(20);

/// A folder that belongs to one run until this is dropped.
///
/// The lock of the operating system decides, also between machines where the network file system passes locks on. A file that a killed run left
/// behind is no obstacle. On a file system without locks the file counts, unless its process is known to have ended.
#[derive(Debug)]
pub struct FolderLock {
    path: PathBuf,
    /// Locked while it is open.
    _file: File,
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // While the lock is still held: afterwards the file may be the next run's.
        let _ = fs::remove_file(&self.path);
    }
}

/// Takes the folder for a run; if another run has it, returns that run.
pub(super) fn lock(folder: &Path) -> io::Result<Result<FolderLock, Owner>> {
    let path = folder.join(LOCK);
    let mut is_second = false;
    loop {
        let mut options = OpenOptions::new();
        let mut file = options
            .write(true)
            .create(true)
            .truncate(false)
            .open(&path)?;
        let owner = match file.try_lock() {
            // The run that had the lock may have removed the file after it was opened here.
            Ok(()) if !is_at(&file, &path) => continue,
            Ok(()) => None,
            Err(TryLockError::WouldBlock) if !is_second => {
                is_second = true;
                std::thread::sleep(SECOND_TRY);
                continue;
            }
            Err(TryLockError::WouldBlock) => Some(Owner::read(&path).unwrap_or(Owner {
                host: String::new(),
                process: 0,
            })),
            Err(TryLockError::Error(_)) => owner_without_locks(&path),
        };
        if let Some(owner) = owner {
            return Ok(Err(owner));
        }
        let text = Owner::myself().text();
        file.write_all(text.as_bytes())?;
        file.set_len(text.len() as u64)?;
        return Ok(Ok(FolderLock { path, _file: file }));
    }
}

/// The run that has the folder on a file system without locks, as far as its file and the list of processes show.
fn owner_without_locks(path: &Path) -> Option<Owner> {
    let owner = Owner::read(path)?;
    let is_other = owner != Owner::myself();
    (is_other && owner.is_running().unwrap_or(true)).then_some(owner)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_belongs_to_one_run_at_a_time() {
        let place = tempfile::tempdir().unwrap();
        let file = place.path().join(LOCK);
        let first = lock(place.path()).unwrap().unwrap();
        assert_eq!(Owner::read(&file), Some(Owner::myself()));
        assert_eq!(lock(place.path()).unwrap().unwrap_err(), Owner::myself());
        assert!(file.exists(), "a refused run leaves the lock alone");
        drop(first);
        assert!(!file.exists());
        // Files that killed runs left behind, of this machine and of another one.
        for left in ["", "half of a na", &Owner::myself().text(), "node 17 4711"] {
            fs::write(&file, left).unwrap();
            drop(lock(place.path()).unwrap().unwrap());
            assert!(!file.exists());
        }
    }

    #[test]
    fn without_locks_the_file_counts_unless_its_process_has_ended() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join(LOCK);
        let me = Owner::myself();
        // The first process of the machine always lives, and no number is that high.
        for (process, lives) in [(1, true), (u32::MAX, false)] {
            let other = Owner {
                process,
                ..me.clone()
            };
            fs::write(&path, other.text()).unwrap();
            let found = owner_without_locks(&path);
            let is_seen = cfg!(target_os = "linux");
            assert_eq!(found.is_some(), lives || !is_seen, "{process}");
        }
        fs::write(&path, "node 17 4711\n").unwrap();
        assert!(owner_without_locks(&path).is_some());
        fs::write(&path, me.text()).unwrap();
        assert_eq!(owner_without_locks(&path), None);
    }
}

//! A folder belongs to one run at a time, also where several machines see it.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use mercury_common::folder_owner::{DEAD_AFTER, LOCK, Owner, PULSE};

/// A folder that belongs to one run until this is dropped.
///
/// On one machine the lock of the operating system counts, not the file: a file of a killed run is no obstacle. a file that a
/// killed run left behind is no obstacle. Between machines, whose locks some network file systems do not share, and on file
/// systems without locks, the file counts as long as the run that wrote it gives signs of life.
#[derive(Debug)]
pub struct FolderLock {
    path: PathBuf,
    /// Held while the file is open.
    _file: File,
    /// Ends the thread that gives signs of life.
    end: Option<Sender<()>>,
    pulse: Option<JoinHandle<()>>,
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        drop(self.end.take());
        if let Some(pulse) = self.pulse.take() {
            let _ = pulse.join();
        }
        // While the lock is still held: afterwards the file may be the next run's.
        let _ = fs::remove_file(&self.path);
    }
}

/// Locks the folder for a run; if it is in use, returns its owner.
pub(super) fn lock(folder: &Path) -> io::Result<Result<FolderLock, Owner>> {
    let path = folder.join(LOCK);
    let me = Owner::myself();
    loop {
        let mut options = OpenOptions::new();
        let file = options
            .write(true)
            .create(true)
            .truncate(false)
            .open(&path)?;
        let has_locks = match file.try_lock() {
            // The run that had the lock may have removed the file after it was opened here.
            Ok(()) if !is_at(&file, &path) => continue,
            Ok(()) => true,
            Err(TryLockError::WouldBlock) => {
                return Ok(Err(Owner::read(&path).unwrap_or(Owner {
                    host: String::new(),
                    process: 0,
                })));
            }
            Err(TryLockError::Error(_)) => false,
        };
        if let Some(owner) = living_owner(folder, &path, &me, has_locks)? {
            return Ok(Err(owner));
        }
        give_sign(&path, &me)?;
        if !has_locks {
            // If two runs begin at the same time, the one that wrote last has the folder.
            std::thread::sleep(Duration::from_millis(50));
            match Owner::read(&path) {
                Some(owner) if owner != me => return Ok(Err(owner)),
                _ => {}
            }
        }
        let (end, ended) = channel::<()>();
        let signed = path.clone();
        let pulse = std::thread::Builder::new()
            .name("lock".to_owned())
            .spawn(move || {
                while ended.recv_timeout(PULSE) == Err(RecvTimeoutError::Timeout) {
                    // Problems of the folder are found by the outputs.
                    let _ = give_sign(&signed, &me);
                }
            })?;
        return Ok(Ok(FolderLock {
            path,
            _file: file,
            end: Some(end),
            pulse: Some(pulse),
        }));
    }
}

/// Writes the owner of the folder; the time of the file is the sign of life.
fn give_sign(path: &Path, owner: &Owner) -> io::Result<()> {
    let mut file = OpenOptions::new().write(true).open(path)?;
    let text = owner.text();
    file.write_all(text.as_bytes())?;
    file.set_len(text.len() as u64)
}

/// The other owner of the folder by the content of the file, if it is alive as far as can be seen from this machine.
fn living_owner(
    folder: &Path,
    path: &Path,
    me: &Owner,
    has_locks: bool,
) -> io::Result<Option<Owner>> {
    let Some(owner) = Owner::read(path) else {
        return Ok(None);
    };
    if owner.host == me.host {
        // On this machine the lock says whether it is alive, or else the list of processes.
        let lives =
            !has_locks && owner.process != me.process && owner.is_running().unwrap_or(false);
        return Ok(lives.then_some(owner));
    }
    // Both times are those of the machine that keeps the files.
    let probe = folder.join(format!("{}{}", super::PROBE, std::process::id()));
    fs::write(&probe, b"")?;
    let now = fs::metadata(&probe).and_then(|data| data.modified());
    // The owner of the folder may have removed it already.
    let _ = fs::remove_file(&probe);
    let sign = fs::metadata(path).and_then(|data| data.modified())?;
    let silent = now?.duration_since(sign).unwrap_or_default();
    Ok((silent < DEAD_AFTER).then_some(owner))
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
    use std::time::SystemTime;

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
        // What killed runs of this machine left behind.
        for left in ["", "half of a na", &Owner::myself().text()] {
            fs::write(&file, left).unwrap();
            drop(lock(place.path()).unwrap().unwrap());
            assert!(!file.exists());
        }
    }

    #[test]
    fn a_run_on_another_machine_has_it_while_it_gives_signs() {
        let place = tempfile::tempdir().unwrap();
        let file = place.path().join(LOCK);
        let other = Owner {
            host: "node 17".to_owned(),
            process: 4711,
        };
        fs::write(&file, other.text()).unwrap();
        assert_eq!(lock(place.path()).unwrap().unwrap_err(), other);
        let long_ago = SystemTime::now() - DEAD_AFTER - Duration::from_secs(1);
        let open = File::options().write(true).open(&file).unwrap();
        open.set_modified(long_ago).unwrap();
        drop(lock(place.path()).unwrap().unwrap());
    }

    #[test]
    fn without_locks_the_process_counts() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join(LOCK);
        let me = Owner::myself();
        let mut other = me.clone();
        // The first process of the machine always lives, and no number is that high.
        for (process, lives) in [(1, true), (u32::MAX, false)] {
            other.process = process;
            fs::write(&path, other.text()).unwrap();
            let found = living_owner(place.path(), &path, &me, false).unwrap();
            let known = cfg!(target_os = "linux");
            assert_eq!(found.is_some(), lives && known, "{process}");
        }
    }
}

//! Process that writes into the folder of a run: a run holds a lock on a file there, which names its machine and process.

use std::fs::{self, File, TryLockError};
use std::io::Read as _;
use std::path::Path;

/// The file that a run holds a lock on as long as it writes into its folder. It names the machine and the process.
pub const LOCK: &str = ".lock";

/// Longest text of the file, bytes: a name of 255 characters, a blank and a number.
const LONGEST: u64 = 1100;

/// The process that writes into a folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Owner {
    /// Name of the machine; empty if not known.
    pub host: String,
    /// Number of the process; 0 if not known.
    pub process: u32,
}

impl Owner {
    /// This process.
    #[must_use]
    pub fn myself() -> Self {
        Self {
            host: host(),
            process: std::process::id(),
        }
    }

    /// The owner that the file names; `None` if there is no file, or it holds something else.
    #[must_use]
    pub fn read(path: &Path) -> Option<Self> {
        let mut text = String::new();
        let file = File::open(path).ok()?;
        file.take(LONGEST).read_to_string(&mut text).ok()?;
        if text.contains(|c: char| c.is_control() && c != '\n') {
            return None;
        }
        let (host, process) = text.trim().rsplit_once(' ')?;
        Some(Self {
            host: host.to_owned(),
            process: process.parse().ok()?,
        })
    }

    /// The text of the file.
    #[must_use]
    pub fn text(&self) -> String {
        format!("{} {}\n", self.host, self.process)
    }

    /// Whether the process runs; `None` where that cannot be seen, as for processes of other machines.
    #[must_use]
    pub fn is_running(&self) -> Option<bool> {
        let seen = self.host == host() && Path::new("/proc/self").exists();
        seen.then(|| Path::new(&format!("/proc/{}", self.process)).exists())
    }
}

/// Whether a run writes into a folder: whether its lock is held. On file systems without locks a run on another machine counts as running
/// while its file is there.
#[must_use]
pub fn is_written(folder: &Path) -> bool {
    let path = folder.join(LOCK);
    let Ok(file) = File::open(&path) else {
        return false;
    };
    // The lock taken here ends with the file, at the end of this function.
    match file.try_lock_shared() {
        Ok(()) => false,
        Err(TryLockError::WouldBlock) => true,
        Err(TryLockError::Error(_)) => {
            Owner::read(&path).is_some_and(|owner| owner.is_running().unwrap_or(true))
        }
    }
}

/// The name of this machine.
fn host() -> String {
    let name = fs::read_to_string("/proc/sys/kernel/hostname").ok();
    let name = name.or_else(|| std::env::var("HOSTNAME").ok());
    let name = name.or_else(|| std::env::var("COMPUTERNAME").ok());
    let name = name.unwrap_or_default().trim().to_owned();
    if name.is_empty() {
        "unknown".to_owned()
    } else {
        name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_written_while_its_lock_is_held() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(LOCK);
        assert!(!is_written(folder.path()));
        fs::write(&path, Owner::myself().text()).unwrap();
        // A killed run leaves its file behind, but no lock.
        assert!(!is_written(folder.path()));
        let file = File::open(&path).unwrap();
        file.lock().unwrap();
        assert!(is_written(folder.path()));
        drop(file);
        assert!(!is_written(folder.path()));
    }

    #[test]
    fn only_whole_files_name_an_owner() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(LOCK);
        for other in ["", "half of a na", "a\u{7}b 5"] {
            fs::write(&path, other).unwrap();
            assert_eq!(Owner::read(&path), None, "{other:?}");
        }
        let owner = Owner {
            host: "node 17".to_owned(),
            process: 4711,
        };
        fs::write(&path, owner.text()).unwrap();
        assert_eq!(Owner::read(&path), Some(owner.clone()));
        assert_eq!(owner.is_running(), None);
        assert_ne!(Owner::myself().is_running(), Some(false));
    }
}

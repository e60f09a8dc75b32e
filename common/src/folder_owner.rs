//! The owner of a run folder: a file in it names the machine and the process, and its modification time is a sign of life.
//!
//! The solver takes and keeps it; others only look.

use std::fs::{self, File};
use std::io::Read as _;
use std::path::Path;
use std::time::{Duration, SystemTime};

/// The file that a run holds a lock on as long as it writes into its folder. It says which machine and process that is.
pub const LOCK: &str = ".lock";

/// How often a run gives a sign of life: it writes the file again.
pub const PULSE: Duration = Duration::from_secs(30);

/// After so long without a sign, a run on another machine counts as dead.
pub const DEAD_AFTER: Duration = Duration::from_secs(300);

/// What the file says is shorter than this, in bytes: a name of 255 characters, a blank and a number.
const LONGEST: u64 = 1100;

/// The owner of the folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Owner {
    /// The machine; empty if not known.
    pub host: String,
    /// The process; 0 if not known.
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

    /// What the file says; nothing if there is none, or what is in it is not that.
    #[must_use]
    pub fn read(path: &Path) -> Option<Self> {
        // Whatever lies there under this name: only so much of it can be ours.
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

    /// What the file is to say.
    #[must_use]
    pub fn text(&self) -> String {
        format!("{} {}\n", self.host, self.process)
    }

    /// Whether a process of that number is there, on a machine that this is; nothing where that cannot be seen.
    #[must_use]
    pub fn is_running(&self) -> Option<bool> {
        let seen = self.host == host() && Path::new("/proc/self").exists();
        seen.then(|| Path::new(&format!("/proc/{}", self.process)).exists())
    }
}

/// Whether a run writes into a folder, judged by its last sign of life.
#[must_use]
pub fn is_written(folder: &Path) -> bool {
    let path = folder.join(LOCK);
    let Some(owner) = Owner::read(&path) else {
        return false;
    };
    owner.is_running().unwrap_or_else(|| {
        let sign = fs::metadata(&path).and_then(|data| data.modified());
        // A sign from the future is one of a machine whose clock is ahead.
        let silent = |sign| SystemTime::now().duration_since(sign).unwrap_or_default();
        sign.is_ok_and(|sign| silent(sign) < DEAD_AFTER)
    })
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
    fn a_folder_is_written_while_its_owner_lives() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(LOCK);
        assert!(!is_written(folder.path()));
        fs::write(&file, Owner::myself().text()).unwrap();
        assert!(is_written(folder.path()));
        for left in ["", "half of a na", "a\u{7}b 5"] {
            fs::write(&file, left).unwrap();
            assert!(!is_written(folder.path()), "{left:?}");
        }
        // No process has that number.
        let mut owner = Owner::myself();
        owner.process = u32::MAX;
        fs::write(&file, owner.text()).unwrap();
        assert_eq!(is_written(folder.path()), owner.is_running().is_none());
        // On another machine only signs tell.
        owner.host = "node 17".to_owned();
        fs::write(&file, owner.text()).unwrap();
        assert!(is_written(folder.path()));
        let open = File::options().write(true).open(&file).unwrap();
        open.set_modified(SystemTime::now() - DEAD_AFTER - Duration::from_secs(1))
            .unwrap();
        assert!(!is_written(folder.path()));
    }
}

//! A folder outside of which nothing is read or written: for services that run what strangers hand in.
//!
//! A name is checked twice. First as text, so that a name that leads outside is refused without access to the disk, and the
//! answer does not reveal whether something is there; then with all links followed. Hard links look like files, and a process
//! that can write inside the folder can exchange a link between the check and the use: where that matters the system has to guard
//! the folder, too.

use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

/// A folder outside of which nothing is read or written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Within {
    /// Folder as it was named, from the root.
    named: PathBuf,
    /// Without links.
    real: PathBuf,
}

/// A name leads outside.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Outside {
    /// The text of the name leads outside.
    #[error("leads out of the folder that --within names")]
    Name,
    /// A link leads outside.
    #[error("leads over a link out of the folder that --within names, or nowhere")]
    Link,
}

impl Within {
    /// The folder of this name.
    ///
    /// # Errors
    /// If there is none.
    pub fn new(folder: &Path) -> io::Result<Self> {
        let real = fs::canonicalize(folder)?;
        if !real.is_dir() {
            return Err(io::ErrorKind::NotADirectory.into());
        }
        let named = plain(&std::path::absolute(folder)?);
        Ok(Self { named, real })
    }

    /// Whether a file or folder lies inside; one that is not there yet lies where it would be made.
    ///
    /// # Errors
    /// How it leads outside.
    pub fn check(&self, path: &Path) -> Result<(), Outside> {
        let full = std::path::absolute(path).map_err(|_| Outside::Name)?;
        let as_text = plain(&full);
        if !as_text.starts_with(&self.named) && !as_text.starts_with(&self.real) {
            return Err(Outside::Name);
        }
        // The first part from the end that exists gives the place of the rest.
        let there = full
            .ancestors()
            .find(|part| part.symlink_metadata().is_ok());
        let real = there.and_then(|part| fs::canonicalize(part).ok());
        match real {
            Some(real) if real.starts_with(&self.real) => Ok(()),
            _ => Err(Outside::Link),
        }
    }
}

/// The path from the root without `.` and `..`, as text: links are not followed.
#[must_use]
pub fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => {
                plain.pop();
            }
            other => plain.push(other),
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_lead_outside_are_refused_whether_something_is_there_or_not() {
        let place = tempfile::tempdir().unwrap();
        let inside = place.path().join("inside");
        fs::create_dir_all(inside.join("deeper")).unwrap();
        fs::write(inside.join("a.csv"), "").unwrap();
        fs::write(place.path().join("secret"), "").unwrap();
        // A folder whose name only begins alike.
        fs::create_dir(place.path().join("inside-out")).unwrap();
        let within = Within::new(&inside).unwrap();
        for name in [
            "a.csv",
            "deeper/../a.csv",
            "deeper/./b.csv",
            "new/b.csv",
            "",
            "deeper",
        ] {
            assert_eq!(within.check(&inside.join(name)), Ok(()), "{name}");
        }
        for name in [
            "../secret",
            "../nothing",
            "..",
            "deeper/../../secret",
            "new/../../secret",
            "../inside-out/a.csv",
            "/etc/passwd",
            "/etc/nothing",
            "/",
        ] {
            let found = within.check(&inside.join(name));
            assert_eq!(found, Err(Outside::Name), "{name}");
        }
        assert!(Within::new(&inside.join("a.csv")).is_err());
        assert!(Within::new(&inside.join("nothing")).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed() {
        use std::os::unix::fs::symlink;
        let place = tempfile::tempdir().unwrap();
        let inside = place.path().join("inside");
        fs::create_dir_all(inside.join("deeper")).unwrap();
        fs::create_dir(place.path().join("outside")).unwrap();
        fs::write(place.path().join("outside/secret"), "").unwrap();
        fs::write(inside.join("a.csv"), "").unwrap();
        symlink("../outside/secret", inside.join("file")).unwrap();
        symlink("../outside/nothing", inside.join("dangling")).unwrap();
        symlink("../outside", inside.join("folder")).unwrap();
        symlink("../a.csv", inside.join("deeper/back")).unwrap();
        let within = Within::new(&inside).unwrap();
        assert_eq!(within.check(&inside.join("deeper/back")), Ok(()));
        for name in [
            "file",
            "dangling",
            "folder",
            "folder/secret",
            "folder/new",
            // As text it is inside; the system follows the link first.
            "folder/../inside/../outside/secret",
            "folder/../outside/new",
        ] {
            let found = within.check(&inside.join(name));
            assert!(found.is_err(), "{name}");
        }
        // The folder may be named by a link itself.
        symlink("inside", place.path().join("alias")).unwrap();
        let alias = place.path().join("alias");
        let within = Within::new(&alias).unwrap();
        assert_eq!(within.check(&alias.join("a.csv")), Ok(()));
        assert_eq!(within.check(&inside.join("a.csv")), Ok(()));
        assert!(within.check(&alias.join("file")).is_err());
    }
}

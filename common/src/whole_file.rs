//! Files that are there as a whole or not at all.
//!
//! A file is written under a temporary name beside its place, handed to the disk, and renamed. A reader never meets a part of
//! it, and neither a program that dies half-way nor a loss of power costs the file that was there before.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile};

/// Separator between the name of a file and the letters and digits of its temporary name.
pub const TEMPORARY: &str = ".tmp-";

const WRITE: &str = "the file cannot be written";

/// The operating system refused something that was to be done with a file or folder.
#[derive(Debug, thiserror::Error)]
#[error("{}: {action}: {source}", path.display())]
pub struct FileError {
    /// The file or folder.
    pub path: PathBuf,
    /// Failed action, as `the file cannot be ...`.
    pub action: &'static str,
    /// Error of the system.
    pub source: io::Error,
}

impl FileError {
    /// For `map_err`: makes the error of a path and an action (`the file cannot be ...`) from the system's.
    pub fn of(path: &Path, action: &'static str) -> impl Fn(io::Error) -> Self + use<> {
        let path = path.to_owned();
        move |source| Self {
            path: path.clone(),
            action,
            source,
        }
    }
}

/// Writes a whole file.
///
/// ```
/// use mercury_common::whole_file::write_whole;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("sizes.csv");
/// write_whole(&path, b"radius\n0.001\n")?;
/// write_whole(&path, b"radius\n0.002\n")?; // replaces the first at once
/// assert_eq!(std::fs::read(&path)?, b"radius\n0.002\n");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the system refuses; a file that was there before is still there then.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let mut file = WholeFile::create(path)?;
    file.append(bytes)?;
    file.finish()?;
    Ok(())
}

/// A file that is written in pieces and gets its name when it is whole. Dropped before, it leaves nothing behind.
#[derive(Debug)]
pub struct WholeFile {
    path: PathBuf,
    file: NamedTempFile,
}

impl WholeFile {
    /// Begins a file.
    ///
    /// # Errors
    /// If it cannot be made where it is to be.
    pub fn create(path: impl Into<PathBuf>) -> Result<Self, FileError> {
        let path = path.into();
        // Without a name of its own (`..`, `/`) the path is a folder: renaming would fail after all the work.
        let made = (path.file_name())
            .ok_or_else(|| io::Error::from(io::ErrorKind::IsADirectory))
            .and_then(|name| {
                let mut prefix = name.to_owned();
                prefix.push(TEMPORARY);
                Builder::new()
                    .prefix(&prefix)
                    .make_in(folder_of(&path), |path| File::create_new(path))
            });
        let file = made.map_err(FileError::of(&path, WRITE))?;
        Ok(Self { path, file })
    }

    /// The name that the file will have.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Appends bytes. Nothing is buffered: a call should bring many.
    ///
    /// # Errors
    /// If they cannot be written.
    pub fn append(&mut self, bytes: &[u8]) -> Result<(), FileError> {
        let written = self.file.as_file_mut().write_all(bytes);
        written.map_err(FileError::of(&self.path, WRITE))
    }

    /// A buffered way to append, for encoders that own what they write to. It must have flushed and gone when the file is
    /// finished.
    ///
    /// # Errors
    /// If the system has no further handle for the file.
    pub fn writer(&self) -> Result<BufWriter<File>, FileError> {
        let file = self.file.as_file().try_clone();
        Ok(BufWriter::new(
            file.map_err(FileError::of(&self.path, WRITE))?,
        ))
    }

    /// Hands what was written to the disk; what can go wrong has gone wrong then, so that several files can be named together.
    ///
    /// # Errors
    /// If the disk does not take it.
    pub fn sync(&self) -> Result<(), FileError> {
        let synced = self.file.as_file().sync_all();
        synced.map_err(FileError::of(&self.path, WRITE))
    }

    /// Hands the file to the disk and gives it its name. Returns the open file, so that writing can continue.
    ///
    /// # Errors
    /// If the disk does not take it, or it cannot be renamed; a file that was there before is still there then.
    pub fn finish(self) -> Result<File, FileError> {
        // The name must not reach the disk before what it stands for.
        self.sync()?;
        let renamed = self.file.persist(&self.path);
        let file = renamed.map_err(|error| FileError::of(&self.path, WRITE)(error.error))?;
        // The name reaches the disk with its folder. Not every file system can do that, and the file is whole without it.
        #[cfg(unix)]
        let _ = File::open(folder_of(&self.path)).and_then(|folder| folder.sync_all());
        Ok(file)
    }
}

/// The folder of a file. A temporary file is made in it, because a rename is atomic only inside one file system.
fn folder_of(path: &Path) -> &Path {
    let parent = path.parent().unwrap_or(Path::new(""));
    if parent.as_os_str().is_empty() {
        Path::new(".")
    } else {
        parent
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let name = |entry: io::Result<fs::DirEntry>| entry.unwrap().file_name();
        entries.map(|e| name(e).into_string().unwrap()).collect()
    }

    #[test]
    fn replaces_an_old_file_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        fs::write(&path, "old and longer").unwrap();
        write_whole(&path, b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names(folder.path()), ["a.csv"]);
    }

    #[test]
    fn the_old_file_stays_until_the_new_one_is_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        fs::write(&path, "old").unwrap();
        let mut file = WholeFile::create(&path).unwrap();
        file.append(b"half of the n").unwrap();
        file.sync().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        drop(file);
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["a.csv"]);
    }

    #[test]
    fn a_process_that_dies_half_way_leaves_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        fs::write(&path, "old").unwrap();
        let mut file = WholeFile::create(&path).unwrap();
        file.append(b"half of the n").unwrap();
        // A process that is killed never drops the file.
        std::mem::forget(file);
        assert_eq!(fs::read(&path).unwrap(), b"old");
        // The next one writes as if nothing had been.
        write_whole(&path, b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
    }

    #[test]
    fn an_encoder_may_own_what_it_writes_to() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let mut file = WholeFile::create(&path).unwrap();
        file.append(b"head ").unwrap();
        let mut writer = file.writer().unwrap();
        writer.write_all(b"and body").unwrap();
        drop(writer);
        file.finish().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"head and body");
    }

    #[test]
    fn an_error_names_path_and_action() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("missing").join("a.csv");
        let error = write_whole(&path, b"new").unwrap_err().to_string();
        let start = format!("{}: the file cannot be written: ", path.display());
        assert!(error.starts_with(&start), "{error}");
        assert!(write_whole(Path::new(".."), b"").is_err());
        assert!(write_whole(Path::new(""), b"").is_err());
    }

    #[test]
    fn a_failed_rename_leaves_no_temporary_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("taken");
        fs::create_dir(&path).unwrap();
        assert!(write_whole(&path, b"new").is_err());
        assert_eq!(names(folder.path()), ["taken"]);
    }
}

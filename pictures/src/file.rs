//! Whole files or none: written beside their place under another name, then renamed.

use super::PictureError;
use std::fs::{self, File};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

/// Writes `bytes` to `path`. A reader, or a run killed half-way, never meets a part of the file.
///
/// # Errors
/// If the system refuses; a file that was there before is still there then.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), PictureError> {
    let failed = |source| PictureError::Write {
        path: path.to_path_buf(),
        source,
    };
    let temporary = temporary_name(path);
    let written = fs::write(&temporary, bytes).and_then(|()| fs::rename(&temporary, path));
    if written.is_err() {
        // The first error is the one worth telling; a leftover is all that a second one could mean.
        let _ = fs::remove_file(&temporary);
    }
    written.map_err(failed)
}

/// `<name>.tmp-<process>` in the folder of `path`, because a rename is atomic only inside one file system.
fn temporary_name(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".tmp-{}", std::process::id()));
    path.with_file_name(name)
}

/// A file that is written in pieces and gets its name when it is whole.
pub(crate) struct Growing {
    path: PathBuf,
    temporary: PathBuf,
    writer: Option<BufWriter<File>>,
    finished: bool,
}

impl Growing {
    pub(crate) fn create(path: &Path) -> Result<Self, PictureError> {
        let temporary = temporary_name(path);
        let file = File::create(&temporary).map_err(|source| PictureError::Write {
            path: path.to_path_buf(),
            source,
        })?;
        Ok(Self {
            path: path.to_path_buf(),
            temporary,
            writer: Some(BufWriter::new(file)),
            finished: false,
        })
    }

    /// What to write to, once.
    pub(crate) fn writer(&mut self) -> Result<BufWriter<File>, PictureError> {
        let writer = self.writer.take();
        writer.ok_or_else(|| self.failed(io::Error::other("it is being written already")))
    }

    pub(crate) fn failed(&self, source: io::Error) -> PictureError {
        PictureError::Write {
            path: self.path.clone(),
            source,
        }
    }

    /// Flushes and names the file.
    pub(crate) fn finish(self, writer: BufWriter<File>) -> Result<(), PictureError> {
        writer
            .into_inner()
            .map_err(|error| self.failed(error.into_error()))?;
        self.finish_flushed()
    }

    /// Names the file, whose writer has flushed and gone.
    pub(crate) fn finish_flushed(mut self) -> Result<(), PictureError> {
        fs::rename(&self.temporary, &self.path).map_err(|source| self.failed(source))?;
        self.finished = true;
        Ok(())
    }
}

impl Drop for Growing {
    fn drop(&mut self) {
        if !self.finished {
            // A film that was not finished leaves nothing behind; a second error would tell nothing new.
            let _ = fs::remove_file(&self.temporary);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn replaces_an_old_file_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.svg");
        fs::write(&path, "old and longer").unwrap();
        write_whole(&path, b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_missing_folder_is_an_error_that_names_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("missing").join("a.svg");
        let error = write_whole(&path, b"new").unwrap_err();
        assert!(error.to_string().contains("a.svg"), "{error}");
    }

    #[test]
    fn a_failed_rename_leaves_no_temporary_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("taken");
        fs::create_dir(&path).unwrap();
        assert!(write_whole(&path, b"new").is_err());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}

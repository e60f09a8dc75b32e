//! Where files go: whole files or none, and nothing replaced unless asked for.

use std::fs;
use std::path::{Path, PathBuf};

use mercury_common::paraview::Series;

use crate::{ExportError, Source};

/// A folder for the files of one export.
#[derive(Debug, Clone)]
pub struct Output {
    /// The folder.
    pub folder: PathBuf,
    /// What the names of all files begin with.
    pub prefix: String,
    force: bool,
}

impl Output {
    /// The folder of an export of `source`: `folder`, or else `beside` inside the folder of the source. It is made if it is
    /// not there.
    ///
    /// # Errors
    /// When it is no folder or cannot be made.
    pub fn new(
        source: &Source,
        folder: Option<&Path>,
        beside: &str,
        force: bool,
    ) -> Result<Self, ExportError> {
        let folder = folder.map_or_else(|| source.folder().join(beside), Path::to_owned);
        fs::create_dir_all(&folder).map_err(|source| ExportError::File {
            path: folder.clone(),
            action: "the folder cannot be made",
            source,
        })?;
        Ok(Self {
            folder,
            prefix: source.prefix().to_owned(),
            force,
        })
    }

    /// The file with this ending.
    #[must_use]
    pub fn path(&self, ending: &str) -> PathBuf {
        self.folder.join(format!("{}.{ending}", self.prefix))
    }

    /// Makes sure that a file is not there, or may be replaced.
    ///
    /// # Errors
    /// [`ExportError::Exists`].
    pub fn claim(&self, path: &Path) -> Result<(), ExportError> {
        if self.force || path.symlink_metadata().is_err() {
            Ok(())
        } else {
            Err(ExportError::Exists(path.to_owned()))
        }
    }

    /// Removes the series of a kind that an earlier export left here and this one does not write.
    ///
    /// # Errors
    /// When it may not be replaced, or a file cannot be removed.
    pub(crate) fn clear_series(&self, kind: &str) -> Result<(), ExportError> {
        let list = self.path(&format!("{kind}.pvd"));
        if list.symlink_metadata().is_err() {
            return Ok(());
        }
        self.claim(&list)?;
        let mut old = vec![list];
        old.extend(Series::frames_in(
            &self.folder,
            &format!("{}.{kind}", self.prefix),
        ));
        for path in old {
            fs::remove_file(&path).map_err(|source| ExportError::File {
                path,
                action: "the file cannot be removed",
                source,
            })?;
        }
        Ok(())
    }

    /// Writes a file under a temporary name, then renames it.
    ///
    /// # Errors
    /// When it is there already and may not be replaced, or cannot be written.
    pub fn write(&self, path: &Path, bytes: &[u8]) -> Result<(), ExportError> {
        self.claim(path)?;
        let temporary = temporary_name(path);
        let written = fs::write(&temporary, bytes).and_then(|()| fs::rename(&temporary, path));
        if written.is_err() {
            // The first error is the one worth telling; a leftover is all that a second one could mean.
            let _ = fs::remove_file(&temporary);
        }
        written.map_err(|source| ExportError::File {
            path: path.to_owned(),
            action: "the file cannot be written",
            source,
        })
    }
}

/// `<name>.tmp-<process>` in the folder of `path`, because a rename is atomic only inside one file system.
fn temporary_name(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".tmp-{}", std::process::id()));
    path.with_file_name(name)
}

/// A file that grows frame by frame under a temporary name and gets its own at the end.
#[derive(Debug)]
pub struct Growing {
    path: PathBuf,
    temporary: PathBuf,
    file: fs::File,
    finished: bool,
}

impl Growing {
    /// Begins a file.
    ///
    /// # Errors
    /// When it is there already and may not be replaced, or cannot be made.
    pub fn create(output: &Output, path: PathBuf) -> Result<Self, ExportError> {
        output.claim(&path)?;
        let temporary = temporary_name(&path);
        match fs::File::create(&temporary) {
            Ok(file) => Ok(Self {
                path,
                temporary,
                file,
                finished: false,
            }),
            Err(source) => Err(ExportError::File {
                path,
                action: "the file cannot be made",
                source,
            }),
        }
    }

    /// Appends bytes.
    ///
    /// # Errors
    /// When they cannot be written.
    pub fn append(&mut self, bytes: &[u8]) -> Result<(), ExportError> {
        use std::io::Write as _;
        self.file
            .write_all(bytes)
            .map_err(|source| ExportError::File {
                path: self.path.clone(),
                action: "the file cannot be written",
                source,
            })
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// When it cannot be renamed.
    pub fn finish(mut self) -> Result<PathBuf, ExportError> {
        fs::rename(&self.temporary, &self.path).map_err(|source| ExportError::File {
            path: self.path.clone(),
            action: "the file cannot be written",
            source,
        })?;
        self.finished = true;
        Ok(self.path.clone())
    }
}

impl Drop for Growing {
    fn drop(&mut self) {
        if !self.finished {
            // Whoever stopped half-way has an error to tell already.
            let _ = fs::remove_file(&self.temporary);
        }
    }
}

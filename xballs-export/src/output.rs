//! Where files go: whole files or none, and nothing replaced without a request.

use std::fs;
use std::path::{Path, PathBuf};

use mercury_common::paraview::Series;
use mercury_common::whole_file::{FileError, WholeFile, write_whole};

use crate::{ExportError, Source};

/// Endings that files have: a folder of such a name would surprise.
const ENDINGS: &[&str] = &[
    "apng", "arrow", "avi", "avif", "bmp", "csv", "data", "disp", "dump", "eps", "gif", "gz",
    "jpeg", "jpg", "json", "lammps", "lmp", "m4v", "mkv", "mov", "mp4", "mpeg", "mpg", "ogv",
    "parquet", "pdf", "png", "ppm", "ps", "pvd", "svg", "tif", "tiff", "tsv", "txt", "vti", "vtk",
    "vtu", "webm", "webp", "wmv", "xballs", "zip",
];

/// The ending of a name that is meant as a file's: a known one, and no folder has the name.
#[must_use]
pub fn ending_of_file(path: &Path) -> Option<String> {
    let ending = path.extension()?.to_string_lossy().to_lowercase();
    (ENDINGS.contains(&ending.as_str()) && !path.is_dir()).then_some(ending)
}

/// Refuses the name of a file where a command writes into a folder.
///
/// # Errors
/// The output is the name of a file.
pub fn takes_folder(command: &str, output: Option<&Path>) -> Result<(), ExportError> {
    let Some((path, ending)) = output.and_then(|path| Some((path, ending_of_file(path)?))) else {
        return Ok(());
    };
    Err(ExportError::Input(format!(
        "{}: mercury-export {command} writes files of its own names into a folder, and this is the name of a file\nhelp: name a folder, without the ending .{ending}",
        path.display()
    )))
}

/// A folder for the files of one export.
#[derive(Debug, Clone)]
pub struct Output {
    /// The folder.
    pub folder: PathBuf,
    /// Beginning of the names of all files.
    pub prefix: String,
    /// The one file that was requested instead of a folder.
    file: Option<PathBuf>,
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
        let made = fs::create_dir_all(&folder);
        made.map_err(FileError::of(&folder, "the folder cannot be made"))?;
        Ok(Self {
            folder,
            prefix: source.prefix().to_owned(),
            file: None,
            force,
        })
    }

    /// An export of `source` into one file, whose folder is made if it is not there.
    ///
    /// # Errors
    /// When the folder is none or cannot be made.
    pub fn to_file(source: &Source, file: &Path, force: bool) -> Result<Self, ExportError> {
        let folder = match file.parent() {
            Some(folder) if folder != Path::new("") => folder,
            _ => Path::new("."),
        };
        Ok(Self {
            file: Some(file.to_owned()),
            ..Self::new(source, Some(folder), "", force)?
        })
    }

    /// The one requested file.
    #[must_use]
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// The one requested file, or else the file with this ending.
    #[must_use]
    pub fn one(&self, ending: &str) -> PathBuf {
        self.file.clone().unwrap_or_else(|| self.path(ending))
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
            let removed = fs::remove_file(&path);
            removed.map_err(FileError::of(&path, "the file cannot be removed"))?;
        }
        Ok(())
    }

    /// Writes a file under a temporary name, then renames it.
    ///
    /// # Errors
    /// When it is there already and may not be replaced, or cannot be written.
    pub fn write(&self, path: &Path, bytes: &[u8]) -> Result<(), ExportError> {
        self.claim(path)?;
        Ok(write_whole(path, bytes)?)
    }

    /// Begins a file that grows frame by frame and gets its name when it is finished.
    ///
    /// # Errors
    /// When it is there already and may not be replaced, or cannot be made.
    pub fn begin(&self, path: PathBuf) -> Result<WholeFile, ExportError> {
        self.claim(&path)?;
        Ok(WholeFile::create(path)?)
    }
}

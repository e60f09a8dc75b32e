//! A series of `.vtu` files and the `.pvd` that lists them with their times.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use crate::formats::vtu::{PvdEntry, PvdWriter, VtuError, VtuGrid, VtuOptions, write_vtu};
use crate::whole_file::FileError;

/// Files `<stem>.0000.vtu`, `<stem>.0001.vtu`, ... and `<stem>.pvd`, which is complete after every frame.
#[derive(Debug)]
pub struct Series {
    folder: PathBuf,
    stem: String,
    list: PvdWriter,
    options: VtuOptions,
}

impl Series {
    /// A series without frames; a list of that name is replaced, and the frames of an earlier series of that name are
    /// removed, so that none of them is taken for one of this series.
    ///
    /// # Errors
    /// When the list cannot be written or an old frame cannot be removed.
    pub fn create(folder: &Path, stem: &str, options: VtuOptions) -> Result<Self, VtuError> {
        for old in Self::frames_in(folder, stem) {
            remove(old)?;
        }
        Ok(Self {
            folder: folder.to_owned(),
            stem: stem.to_owned(),
            list: PvdWriter::create(folder.join(format!("{stem}.pvd")))?,
            options,
        })
    }

    /// Continues a series behind its first `frames` frames: takes the others off the list, then removes their files.
    ///
    /// # Errors
    /// When the list cannot be read or written, or has fewer frames, or a file cannot be removed.
    pub fn resume(
        folder: &Path,
        stem: &str,
        options: VtuOptions,
        frames: usize,
    ) -> Result<Self, VtuError> {
        let series = Self {
            folder: folder.to_owned(),
            stem: stem.to_owned(),
            list: PvdWriter::resume(folder.join(format!("{stem}.pvd")), frames)?,
            options,
        };
        let kept: HashSet<PathBuf> = (0..frames)
            .map(|number| folder.join(series.file_name(number)))
            .collect();
        for file in Self::frames_in(folder, stem) {
            if !kept.contains(&file) {
                remove(file)?;
            }
        }
        Ok(series)
    }

    /// The name of the frame with this number.
    #[must_use]
    pub fn file_name(&self, number: usize) -> String {
        format!("{}.{number:04}.vtu", self.stem)
    }

    /// The frames of a series of this name that are in a folder.
    #[must_use]
    pub fn frames_in(folder: &Path, stem: &str) -> Vec<PathBuf> {
        let is_frame = |name: &str| {
            let number = name.strip_prefix(stem)?.strip_prefix('.')?;
            let number = number.strip_suffix(".vtu")?;
            let digits = number.len() >= 4 && number.bytes().all(|b| b.is_ascii_digit());
            digits.then_some(())
        };
        let Ok(entries) = std::fs::read_dir(folder) else {
            return Vec::new();
        };
        let paths = entries.filter_map(|entry| entry.ok().map(|entry| entry.path()));
        let mut found: Vec<PathBuf> = paths
            .filter(|path| {
                let name = path.file_name().and_then(|name| name.to_str());
                name.and_then(is_frame).is_some()
            })
            .collect();
        found.sort();
        found
    }

    /// Writes the frame with this number, and then lists it.
    ///
    /// # Errors
    /// When a file cannot be written or the grid does not fit together.
    pub fn write(&mut self, number: usize, grid: &VtuGrid) -> Result<(), VtuError> {
        let file = self.file_name(number);
        write_vtu(&self.folder.join(&file), grid, self.options)?;
        self.list.append(&PvdEntry {
            time: grid.time.unwrap_or(number as f64),
            file,
        })
    }
}

fn remove(path: PathBuf) -> Result<(), VtuError> {
    let removed = std::fs::remove_file(&path);
    Ok(removed.map_err(FileError::of(&path, "the file cannot be removed"))?)
}

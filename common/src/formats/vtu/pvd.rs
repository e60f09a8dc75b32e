//! `.pvd`: the list of the files of a series with their times.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Seek as _, SeekFrom, Write as _};
use std::path::PathBuf;

use super::VtuError;
use super::encode::escape;
use crate::whole_file::FileError;

const HEAD: &str = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n  <Collection>\n";
const TAIL: &str = "  </Collection>\n</VTKFile>\n";
const ENTRY: &str = "    <DataSet ";

/// One file of a series.
#[derive(Debug, Clone, PartialEq)]
pub struct PvdEntry {
    /// Time in s.
    pub time: f64,
    /// The file, relative to the folder of the list.
    pub file: String,
}

impl PvdEntry {
    fn line(&self) -> String {
        let mut line = format!(
            "{ENTRY}timestep=\"{:?}\" group=\"\" part=\"0\" file=\"",
            self.time
        );
        escape(&self.file, &mut line);
        line.push_str("\"/>\n");
        line
    }
}

/// A whole list as text.
#[must_use]
pub fn pvd_text(entries: &[PvdEntry]) -> String {
    let lines: String = entries.iter().map(PvdEntry::line).collect();
    [HEAD, &lines, TAIL].concat()
}

/// A list that grows with its series and can be opened at every instant.
#[derive(Debug)]
pub struct PvdWriter {
    path: PathBuf,
    file: File,
    /// Where the next entry goes: the offset of the tail.
    end: u64,
}

impl PvdWriter {
    /// Makes a list without entries; a file of that name is replaced.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn create(path: impl Into<PathBuf>) -> Result<Self, VtuError> {
        let path = path.into();
        let text = pvd_text(&[]);
        let file = File::create(&path)
            .and_then(|mut file| file.write_all(text.as_bytes()).map(|()| file))
            .map_err(FileError::of(&path, "the file cannot be written"))?;
        Ok(Self {
            path,
            file,
            end: HEAD.len() as u64,
        })
    }

    /// Continues a list behind its first `entries` entries; later ones are dropped.
    ///
    /// # Errors
    /// When the file cannot be read or written, was not written by this writer, or has fewer entries.
    pub fn resume(path: impl Into<PathBuf>, entries: usize) -> Result<Self, VtuError> {
        let path = path.into();
        let text =
            fs::read_to_string(&path).map_err(FileError::of(&path, "the file cannot be read"))?;
        let list = |found: String, expected: String| VtuError::List {
            path: path.clone(),
            found,
            expected,
        };
        let Some(rest) = text.strip_prefix(HEAD) else {
            let expected = "a list that Mercury wrote".to_owned();
            return Err(list("another XML file".to_owned(), expected));
        };
        let lines = rest.split_inclusive('\n');
        let lines: Vec<&str> = lines.take_while(|line| line.starts_with(ENTRY)).collect();
        if lines.len() < entries {
            let found = format!("a list of {} files", lines.len());
            return Err(list(found, format!("at least {entries}")));
        }
        let kept: usize = lines[..entries].iter().map(|line| line.len()).sum();
        let end = (HEAD.len() + kept) as u64;
        let failed = "the file cannot be written";
        let file = OpenOptions::new()
            .write(true)
            .open(&path)
            .map_err(FileError::of(&path, failed))?;
        let mut writer = Self { path, file, end };
        writer
            .put(TAIL.as_bytes())
            .and_then(|()| writer.file.set_len(end + TAIL.len() as u64))
            .map_err(FileError::of(&writer.path, failed))?;
        Ok(writer)
    }

    /// Adds a file in one write: the new entry covers the old tail and brings its own.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn append(&mut self, entry: &PvdEntry) -> Result<(), VtuError> {
        let line = entry.line();
        let failed = FileError::of(&self.path, "the file cannot be written");
        self.put([line.as_str(), TAIL].concat().as_bytes())
            .map_err(failed)?;
        self.end += line.len() as u64;
        Ok(())
    }

    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.file.seek(SeekFrom::Start(self.end))?;
        self.file.write_all(bytes)
    }
}

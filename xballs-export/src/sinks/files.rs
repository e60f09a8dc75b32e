//! Plain sinks: an encoder makes bytes of a frame, and they become a file of their own or are appended to one file.

use std::path::PathBuf;

use mercury_common::whole_file::WholeFile;

use crate::output::Output;
use crate::{ExportError, Outcome, Sink, Snapshot, Table};

/// Appends the bytes of a frame.
pub trait Encode: FnMut(&Snapshot, &mut Vec<u8>) -> Result<(), ExportError> {}

impl<F: FnMut(&Snapshot, &mut Vec<u8>) -> Result<(), ExportError>> Encode for F {}

/// One file for each frame, `<prefix>.<kind>0000.<ending>`, with the bytes that `encode` appends.
#[derive(Debug)]
pub struct FilePerFrame<'a, E> {
    output: &'a Output,
    table: Table,
    kind: String,
    ending: &'static str,
    encode: E,
    bytes: Vec<u8>,
    files: Vec<PathBuf>,
}

impl<'a, E: Encode> FilePerFrame<'a, E> {
    /// Files of particles.
    pub fn new(output: &'a Output, ending: &'static str, encode: E) -> Self {
        Self {
            output,
            table: Table::Particles,
            kind: String::new(),
            ending,
            encode,
            bytes: Vec::new(),
            files: Vec::new(),
        }
    }

    /// Files of a table, found by their names.
    #[must_use]
    pub fn of_table(self, table: Table) -> Self {
        Self {
            table,
            kind: format!("{}.", table.name()),
            ..self
        }
    }
}

impl<E: Encode> Sink for FilePerFrame<'_, E> {
    fn table(&self) -> Table {
        self.table
    }

    fn write(&mut self, snapshot: Snapshot) -> Result<(), ExportError> {
        self.bytes.clear();
        (self.encode)(&snapshot, &mut self.bytes)?;
        let (kind, number, ending) = (&self.kind, snapshot.number, self.ending);
        let path = self.output.path(&format!("{kind}{number:04}.{ending}"));
        self.output.write(&path, &self.bytes)?;
        self.files.push(path);
        Ok(())
    }

    fn finish(self: Box<Self>, _: &mut Outcome) -> Result<Vec<PathBuf>, ExportError> {
        Ok(self.files)
    }
}

/// One file, `<prefix>.<ending>`, that grows by what `encode` appends for each frame, and gets its name when it is finished.
#[derive(Debug)]
pub struct OneFile<E> {
    file: WholeFile,
    encode: E,
    bytes: Vec<u8>,
}

impl<E: Encode> OneFile<E> {
    /// Begins the file.
    ///
    /// # Errors
    /// When it is there already and may not be replaced, or cannot be made.
    pub fn begin(output: &Output, ending: &str, encode: E) -> Result<Self, ExportError> {
        Ok(Self {
            file: output.begin(output.path(ending))?,
            encode,
            bytes: Vec::new(),
        })
    }
}

impl<E: Encode> Sink for OneFile<E> {
    fn write(&mut self, snapshot: Snapshot) -> Result<(), ExportError> {
        self.bytes.clear();
        (self.encode)(&snapshot, &mut self.bytes)?;
        Ok(self.file.append(&self.bytes)?)
    }

    fn finish(self: Box<Self>, _: &mut Outcome) -> Result<Vec<PathBuf>, ExportError> {
        let path = self.file.path().to_owned();
        self.file.finish()?;
        Ok(vec![path])
    }
}

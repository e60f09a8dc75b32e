//! All frames of a table in one Parquet file.

use std::path::PathBuf;

use mercury_common::frames::{Column, ColumnKind, ColumnSpec};
use mercury_tables::{Kind, ParquetWriter, Spec, Values};

use crate::output::Output;
use crate::{ExportError, Outcome, Sink, Snapshot, Table};

/// `<prefix>.particles.parquet`: all frames below each other, one row group per frame, with columns `time` and `step` in front.
/// A frame without rows leaves no trace.
#[derive(Debug)]
pub struct Parquet {
    table: Table,
    path: PathBuf,
    /// From the first frame on, which defines the columns.
    writer: Option<(Vec<ColumnSpec>, ParquetWriter)>,
}

impl Parquet {
    /// The file of a table.
    #[must_use]
    pub fn new(output: &Output, table: Table) -> Self {
        Self {
            table,
            path: output.one(&format!("{}.parquet", table.name())),
            writer: None,
        }
    }
}

impl Sink for Parquet {
    fn table(&self) -> Table {
        self.table
    }

    fn files(&self) -> Vec<PathBuf> {
        vec![self.path.clone()]
    }

    fn write(&mut self, snapshot: Snapshot) -> Result<(), ExportError> {
        let Snapshot {
            number,
            specs,
            frame,
            ..
        } = snapshot;
        let (known, writer) = match &mut self.writer {
            Some(begun) => begun,
            None => {
                let mut all = vec![
                    Spec::new("time", "s", Kind::F64),
                    Spec::new("step", "1", Kind::U64),
                ];
                all.extend(
                    specs
                        .iter()
                        .map(|s| Spec::new(&s.name, &s.unit, kind(s.kind))),
                );
                let writer = ParquetWriter::create(&self.path, all, &[])?;
                self.writer.insert((specs.clone(), writer))
            }
        };
        if *known != specs {
            let found = format!("frame {number}: other columns than in the frames before");
            return Err(ExportError::Input(found));
        }
        let rows = frame.rows();
        let mut columns = vec![
            Values::F64(vec![frame.time; rows]),
            Values::U64(vec![frame.step; rows]),
        ];
        columns.extend(frame.columns.into_iter().map(values));
        Ok(writer.write(columns)?)
    }

    fn finish(self: Box<Self>, _: &mut Outcome) -> Result<Vec<PathBuf>, ExportError> {
        if let Some((_, writer)) = self.writer {
            writer.finish()?;
        }
        Ok(vec![self.path])
    }
}

fn kind(kind: ColumnKind) -> Kind {
    match kind {
        ColumnKind::F64 => Kind::F64,
        ColumnKind::I32 => Kind::I32,
        ColumnKind::U8 => Kind::U8,
        ColumnKind::U32 => Kind::U32,
        ColumnKind::OptionalU32 => Kind::OptionalU32,
        ColumnKind::U64 => Kind::U64,
        ColumnKind::Text => Kind::Text,
    }
}

fn values(column: Column) -> Values {
    match column {
        Column::F64(v) => Values::F64(v),
        Column::I32(v) => Values::I32(v),
        Column::U8(v) => Values::U8(v),
        Column::U32(v) => Values::U32(v),
        Column::OptionalU32(v) => Values::OptionalU32(v),
        Column::U64(v) => Values::U64(v),
        Column::Text(v) => Values::Text(v),
    }
}

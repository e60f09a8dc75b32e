//! Frames as tables: CSV, one file per frame, and Parquet, one file for all.

use std::path::PathBuf;

use mercury_common::formats::number::{NumberStyle, push_number};
use mercury_common::frames::{Column, ColumnKind, ColumnSpec, ContactReader, Frame, FrameReader};

use crate::beside;
use crate::bodies;
use crate::output::Output;
use crate::parquet::ParquetWriter;
use crate::{ExportError, FrameChoice, Selection, Snapshot, Source, Told, for_each_snapshot};

/// Which table of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Table {
    /// The particles.
    #[default]
    Particles,
    /// The contacts, which only native frames have.
    Contacts,
    /// The rigid bodies (clumps), which only native frames have.
    Bodies,
}

/// Gives the selected frames of a table to `write`.
fn for_each_frame(
    source: &Source,
    selection: &Selection,
    table: Table,
    mut write: impl FnMut(usize, &[ColumnSpec], &Frame) -> Result<(), ExportError>,
) -> Result<Told, ExportError> {
    if table == Table::Particles {
        return for_each_snapshot(source, selection, |snapshot| {
            write(snapshot.number, &snapshot.specs, &snapshot.frame)
        });
    }
    if table == Table::Bodies {
        let help = "--table particles has the spheres";
        let Some(reader) = bodies::reader(source, help)? else {
            return Err(bodies::missing(source, help));
        };
        let (mut before, mut after) = (0, 0);
        let mut told = frames_of(reader.frames(), selection.frames, |number, specs, frame| {
            let mut snapshot = Snapshot {
                path: reader.frames().path().to_owned(),
                number,
                specs: specs.to_vec(),
                frame,
                header: reader.header().clone(),
            };
            before += snapshot.frame.rows();
            selection.apply(&mut snapshot)?;
            after += snapshot.frame.rows();
            write(number, &snapshot.specs, &snapshot.frame)
        })?;
        if before > 0 && after == 0 {
            let warning = "no body is selected in any frame";
            told.warnings.push(warning.to_owned());
        }
        return Ok(told);
    }
    let contacts = match source {
        Source::Run(run) => run.contacts("--table particles has the spheres")?,
        Source::Data(_) => None,
    };
    let Some(contacts) = contacts.map(ContactReader::frames) else {
        let help = "fstat = true in [output] of the scene writes them";
        return Err(beside::missing(source, "contacts", "", help));
    };
    if selection.is_partial() {
        let found = "--region and --material select particles; contacts have neither";
        return Err(ExportError::Input(found.to_owned()));
    }
    frames_of(contacts, selection.frames, |number, specs, frame| {
        write(number, specs, &frame)
    })
}

fn frames_of(
    reader: &FrameReader,
    choice: FrameChoice,
    mut write: impl FnMut(usize, &[ColumnSpec], Frame) -> Result<(), ExportError>,
) -> Result<Told, ExportError> {
    let last = reader.len().saturating_sub(1);
    let chosen = |k: &usize| choice.has(*k) && (choice != FrameChoice::Last || *k == last);
    let mut told = Told {
        frames: 0,
        damage: reader.damage().cloned(),
        ..Told::default()
    };
    for number in (0..reader.len()).filter(chosen) {
        write(number, reader.schema().columns(), reader.frame(number)?)?;
        told.frames += 1;
    }
    told.written = told.frames;
    if told.frames == 0 {
        if let Some(damage) = told.damage {
            return Err(damage.into());
        }
        let path = reader.path().display();
        return Err(ExportError::Input(format!("{path}: no frame is selected")));
    }
    Ok(told)
}

fn name(table: Table) -> &'static str {
    match table {
        Table::Particles => "particles",
        Table::Contacts => "contacts",
        Table::Bodies => "bodies",
    }
}

/// Writes `<prefix>.particles.0000.csv`, ...: a line of names, then one line per row, numbers in the shortest form that reads
/// back exactly. The first column is the time. What is missing is an empty field.
///
/// # Errors
/// When the input cannot be read, a file of an earlier export is in the way, or a file cannot be written.
pub fn export_csv(
    source: &Source,
    selection: &Selection,
    table: Table,
    output: &Output,
    mut progress: impl FnMut(usize),
) -> Result<(Told, Vec<PathBuf>), ExportError> {
    let mut files = Vec::new();
    let mut text = Vec::new();
    let told = for_each_frame(source, selection, table, |number, specs, frame| {
        progress(number);
        text.clear();
        push_csv(specs, frame, &mut text);
        let path = output.path(&format!("{}.{number:04}.csv", name(table)));
        output.write(&path, &text)?;
        files.push(path);
        Ok(())
    })?;
    Ok((told, files))
}

/// Appends a frame as CSV.
pub fn push_csv(specs: &[ColumnSpec], frame: &Frame, out: &mut Vec<u8>) {
    out.extend_from_slice(b"time");
    for spec in specs {
        out.push(b',');
        push_text(&spec.name, out);
    }
    out.push(b'\n');
    let mut time = Vec::new();
    push_number(&mut time, frame.time, NumberStyle::Shortest);
    for row in 0..frame.rows() {
        out.extend_from_slice(&time);
        for column in &frame.columns {
            out.push(b',');
            push_value(column, row, out);
        }
        out.push(b'\n');
    }
}

fn push_value(column: &Column, row: usize, out: &mut Vec<u8>) {
    let integer = |value: u64, out: &mut Vec<u8>| {
        out.extend_from_slice(value.to_string().as_bytes());
    };
    match column {
        Column::F64(v) => push_number(out, v[row], NumberStyle::Shortest),
        Column::I32(v) => out.extend_from_slice(v[row].to_string().as_bytes()),
        Column::U8(v) => integer(v[row].into(), out),
        Column::U32(v) => integer(v[row].into(), out),
        Column::OptionalU32(v) => v[row].into_iter().for_each(|v| integer(v.into(), out)),
        Column::U64(v) => integer(v[row], out),
        Column::Text(v) => push_text(&v[row], out),
    }
}

fn push_text(text: &str, out: &mut Vec<u8>) {
    if text.contains([',', '"', '\n', '\r']) {
        out.push(b'"');
        out.extend_from_slice(text.replace('"', "\"\"").as_bytes());
        out.push(b'"');
    } else {
        out.extend_from_slice(text.as_bytes());
    }
}

/// Writes `<prefix>.particles.parquet`: all frames below each other, one row group per frame, with columns `time` and `step`
/// in front.
///
/// # Errors
/// When the input cannot be read, the columns change from frame to frame, a file of an earlier export is in the way, or the file
/// cannot be written.
pub fn export_parquet(
    source: &Source,
    selection: &Selection,
    table: Table,
    output: &Output,
    mut progress: impl FnMut(usize),
) -> Result<(Told, Vec<PathBuf>), ExportError> {
    let path = output.path(&format!("{}.parquet", name(table)));
    let mut file = output.begin(path)?;
    let mut writer: Option<ParquetWriter> = None;
    let mut bytes = Vec::new();
    let told = for_each_frame(source, selection, table, |number, specs, frame| {
        progress(number);
        let (time, step) = (frame.time, frame.step);
        let mut columns = vec![
            Column::F64(vec![time; frame.rows()]),
            Column::U64(vec![step; frame.rows()]),
        ];
        columns.extend(frame.columns.iter().cloned());
        let writer = writer.get_or_insert_with(|| {
            let mut all = vec![
                ColumnSpec::new("time", ColumnKind::F64, "s"),
                ColumnSpec::new("step", ColumnKind::U64, "1"),
            ];
            all.extend_from_slice(specs);
            ParquetWriter::new(all, &mut bytes)
        });
        writer
            .push(&columns, &mut bytes)
            .map_err(|reason| ExportError::Input(format!("frame {number}: {reason}")))?;
        file.append(&bytes)?;
        bytes.clear();
        Ok(())
    })?;
    if let Some(writer) = writer {
        writer.finish(&mut bytes);
        file.append(&bytes)?;
    }
    let path = file.path().to_owned();
    file.finish()?;
    Ok((told, vec![path]))
}

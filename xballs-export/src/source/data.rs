//! `.data` files of MercuryDPM and of our own, as frames with named columns.

use std::path::{Path, PathBuf};

use mercury_common::error::FormatError;
use mercury_common::formats::data::{DataFrame, DataReader};
use mercury_common::formats::orientation::quaternion_from_euler;
use mercury_common::frames::{Column, ColumnKind, ColumnSpec, Frame, FramesHeader};
use mercury_common::run_files::{prefix, series_from};

use super::{Item, Snapshot};
use crate::FrameChoice;

/// One `.data` file, or a series `NAME.data.0`, `NAME.data.1`, ...
#[derive(Debug)]
pub struct DataSource {
    paths: Vec<PathBuf>,
    prefix: String,
}

impl DataSource {
    pub(super) fn open(path: &Path) -> Result<Self, FormatError> {
        // Says at once what is wrong with the name.
        DataReader::open(path)?;
        Ok(Self {
            paths: series_from(path),
            prefix: prefix(path),
        })
    }

    pub(super) fn path(&self) -> &Path {
        self.paths.first().map_or(Path::new(""), PathBuf::as_path)
    }

    pub(super) fn prefix(&self) -> &str {
        &self.prefix
    }

    fn all(&self) -> impl Iterator<Item = Result<(PathBuf, DataFrame), FormatError>> + Send + '_ {
        let mut stopped = false;
        let files = self.paths.iter().map(|path| (path, DataReader::open(path)));
        files
            .flat_map(|(path, reader)| {
                let (reader, failed) = match reader {
                    Ok(reader) => (Some(reader), None),
                    Err(error) => (None, Some(Err(error))),
                };
                let frames = reader.into_iter().flatten();
                let frames = frames.map(|frame| frame.map(|frame| (path.clone(), frame)));
                frames.chain(failed)
            })
            // After the first damage nothing more is trusted.
            .take_while(move |item| !std::mem::replace(&mut stopped, item.is_err()))
    }

    pub(super) fn frames(&self, choice: FrameChoice) -> Box<dyn Iterator<Item = Item> + Send + '_> {
        let numbered = self.all().enumerate();
        let numbered =
            numbered.map(|(number, item)| item.map(|(path, frame)| (path, number, frame)));
        if choice == FrameChoice::Last {
            let once = std::iter::once_with(move || {
                let (mut last, mut damage) = (None, None);
                for item in numbered {
                    match item {
                        Ok(item) => last = Some(item),
                        Err(error) => damage = Some(error),
                    }
                }
                let last = last.map(|(path, number, frame)| Ok(snapshot(path, number, frame)));
                last.into_iter().chain(damage.map(Err))
            });
            return Box::new(once.flatten());
        }
        let wanted = numbered.take_while(move |item| match item {
            Ok((_, number, _)) => !choice.ends_before(*number),
            Err(_) => true,
        });
        Box::new(wanted.filter_map(move |item| {
            match item {
                Ok((path, number, frame)) => choice
                    .has(number)
                    .then(|| Ok(snapshot(path, number, frame))),
                Err(error) => Some(Err(error)),
            }
        }))
    }
}

/// The columns of the angles of `.data`.
pub(crate) const EULER: [&str; 3] = ["roll", "pitch", "yaw"];

/// Columns as native frames name them. `.data` knows no ids and no masses: the id is the number of the row. `info` is
/// kept as it is, and is the material where all of it are whole numbers, as MercuryDPM writes it by default.
fn snapshot(path: PathBuf, number: usize, data: DataFrame) -> Snapshot {
    let rows = &data.particles;
    let mut specs = vec![ColumnSpec::new("id", ColumnKind::U32, "1")];
    let mut columns = vec![Column::U32((0..rows.len() as u32).collect())];
    let whole = |info: f64| info >= 0.0 && info.fract() == 0.0 && info <= f64::from(u32::MAX);
    if rows.iter().all(|row| whole(row.info)) {
        specs.push(ColumnSpec::new("material", ColumnKind::U32, "1"));
        columns.push(Column::U32(
            rows.iter().map(|row| row.info as u32).collect(),
        ));
    }
    let mut number_column = |name: &str, unit: &str, values: Vec<f64>| {
        specs.push(ColumnSpec::new(name, ColumnKind::F64, unit));
        columns.push(Column::F64(values));
    };
    number_column("radius", "m", rows.iter().map(|row| row.radius).collect());
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        number_column(
            name,
            "m",
            rows.iter().map(|row| row.position[axis]).collect(),
        );
    }
    for (axis, name) in ["vx", "vy", "vz"].into_iter().enumerate() {
        number_column(
            name,
            "m/s",
            rows.iter().map(|row| row.velocity[axis]).collect(),
        );
    }
    // As they stand, so that `.data` written from it is the same again: the way over quaternions rounds.
    for (axis, name) in EULER.into_iter().enumerate() {
        number_column(
            name,
            "rad",
            rows.iter().map(|row| row.angles[axis]).collect(),
        );
    }
    let turns: Vec<[f64; 4]> = rows
        .iter()
        .map(|row| {
            let q = quaternion_from_euler(row.angles);
            [q.w, q.x, q.y, q.z]
        })
        .collect();
    for (part, name) in ["qw", "qx", "qy", "qz"].into_iter().enumerate() {
        number_column(name, "1", turns.iter().map(|turn| turn[part]).collect());
    }
    for (axis, name) in ["wx", "wy", "wz"].into_iter().enumerate() {
        let values = rows.iter().map(|row| row.angular_velocity[axis]);
        number_column(name, "rad/s", values.collect());
    }
    number_column("info", "1", rows.iter().map(|row| row.info).collect());
    Snapshot {
        path,
        number,
        specs,
        frame: Frame {
            time: data.time,
            step: number as u64,
            columns,
        },
        header: FramesHeader {
            domain: Some((data.min, data.max)),
            dimensions: Some(data.dimensions),
            ..FramesHeader::default()
        },
    }
}

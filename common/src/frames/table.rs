//! Between vectors and flat columns: what the tables of particles and contacts share.

use std::path::Path;

use glam::{DQuat, DVec3};

use super::{Column, ColumnKind, ColumnSpec, Frame, FrameReader, FrameSchema, FramesHeader};
use crate::error::FormatError;

/// A column of a table, with what it means.
pub(super) fn number(name: &str, unit: &str, description: &str) -> ColumnSpec {
    ColumnSpec::new(name, ColumnKind::F64, unit).described(description)
}

/// A column of ids, indices or flags.
pub(super) fn index(name: &str, kind: ColumnKind, description: &str) -> ColumnSpec {
    ColumnSpec::new(name, kind, "1").described(description)
}

/// The columns of a vector, one per name.
pub(super) fn components<const N: usize>(
    names: [&str; N],
    unit: &str,
    description: &str,
) -> [ColumnSpec; N] {
    names.map(|name| number(name, unit, description))
}

/// The components of vectors as columns x, y, z.
pub(super) fn split_vectors(vectors: &[DVec3]) -> [Column; 3] {
    [0, 1, 2].map(|axis| Column::F64(vectors.iter().map(|v| v[axis]).collect()))
}

/// The components of quaternions as columns w, x, y, z.
pub(super) fn split_quaternions(quaternions: &[DQuat]) -> [Column; 4] {
    let part = |of: fn(&DQuat) -> f64| Column::F64(quaternions.iter().map(of).collect());
    [part(|q| q.w), part(|q| q.x), part(|q| q.y), part(|q| q.z)]
}

/// Takes the columns of a frame out by name, whatever their order and whatever else is there.
pub(super) struct Taker<'a> {
    schema: &'a FrameSchema,
    columns: Vec<Column>,
}

impl<'a> Taker<'a> {
    pub(super) fn new(schema: &'a FrameSchema, frame: Frame) -> Self {
        Self {
            schema,
            columns: frame.columns,
        }
    }

    fn take(&mut self, name: &str) -> Result<Column, String> {
        let place = self.schema.index_of(name);
        let column = place.and_then(|k| self.columns.get_mut(k));
        let column = column.ok_or_else(|| format!("no column `{name}`"))?;
        Ok(std::mem::replace(column, Column::U8(Vec::new())))
    }

    pub(super) fn f64(&mut self, name: &str) -> Result<Vec<f64>, String> {
        match self.take(name)? {
            Column::F64(values) => Ok(values),
            other => Err(format!(
                "column `{name}` is {:?}, expected F64",
                other.kind()
            )),
        }
    }

    pub(super) fn u8(&mut self, name: &str) -> Result<Vec<u8>, String> {
        match self.take(name)? {
            Column::U8(values) => Ok(values),
            other => Err(format!(
                "column `{name}` is {:?}, expected U8",
                other.kind()
            )),
        }
    }

    /// Also from a column that might miss values (other programs call all columns nullable) but misses none.
    pub(super) fn u32(&mut self, name: &str) -> Result<Vec<u32>, String> {
        match self.take(name)? {
            Column::U32(values) => Ok(values),
            Column::OptionalU32(values) => {
                let values: Option<Vec<u32>> = values.into_iter().collect();
                values.ok_or_else(|| format!("column `{name}` misses values"))
            }
            other => Err(format!(
                "column `{name}` is {:?}, expected U32",
                other.kind()
            )),
        }
    }

    pub(super) fn optional_u32(&mut self, name: &str) -> Result<Vec<Option<u32>>, String> {
        match self.take(name)? {
            Column::U32(values) => Ok(values.into_iter().map(Some).collect()),
            Column::OptionalU32(values) => Ok(values),
            other => Err(format!(
                "column `{name}` is {:?}, expected OptionalU32",
                other.kind()
            )),
        }
    }

    pub(super) fn vectors(&mut self, [x, y, z]: [&str; 3]) -> Result<Vec<DVec3>, String> {
        let (x, y, z) = (self.f64(x)?, self.f64(y)?, self.f64(z)?);
        let parts = x.into_iter().zip(y).zip(z);
        Ok(parts.map(|((x, y), z)| DVec3::new(x, y, z)).collect())
    }

    pub(super) fn quaternions(&mut self, [w, x, y, z]: [&str; 4]) -> Result<Vec<DQuat>, String> {
        let (w, xyz) = (self.f64(w)?, self.vectors([x, y, z])?);
        let parts = w.into_iter().zip(xyz);
        Ok(parts
            .map(|(w, v)| DQuat::from_xyzw(v.x, v.y, v.z, w))
            .collect())
    }
}

/// Opens a file that should hold a table of this kind; `check` says what is missing among its columns.
pub(super) fn open_table<T>(
    path: &Path,
    kind: &str,
    check: impl Fn(&FrameSchema) -> Result<T, String>,
) -> Result<(FrameReader, FramesHeader, T), FormatError> {
    let reader = FrameReader::open(path)?;
    let wrong = |found: String, expected: String| FormatError {
        expected,
        ..FormatError::of_file(path, found)
    };
    // Files of other programs do not say their kind; there the columns decide.
    let found = reader.schema().kind();
    if !found.is_empty() && found != kind {
        return Err(wrong(
            format!("frames of {found}"),
            format!("frames of {kind}"),
        ));
    }
    let columns =
        check(reader.schema()).map_err(|found| wrong(found, format!("a table of {kind}")))?;
    let header =
        FramesHeader::of(reader.schema()).map_err(|[found, expected]| wrong(found, expected))?;
    Ok((reader, header, columns))
}

/// Makes sure that the columns are there; `found` of the error names the first that is not.
pub(super) fn require(schema: &FrameSchema, expected: &[ColumnSpec]) -> Result<(), String> {
    match expected
        .iter()
        .find(|spec| schema.index_of(&spec.name).is_none())
    {
        Some(missing) => Err(format!("no column `{}`", missing.name)),
        None => Ok(()),
    }
}

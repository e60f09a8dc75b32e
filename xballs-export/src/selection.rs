//! Selection of frames and of their rows.

use std::str::FromStr;

use glam::DVec3;
use mercury_common::frames::{Column, FrameChoice};

use crate::{ExportError, Snapshot};

/// A box in space, open where nothing is said.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Region {
    /// Lower corner, m.
    pub min: DVec3,
    /// Upper corner, m.
    pub max: DVec3,
}

impl FromStr for Region {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "expected ranges as in x=0..0.1,z=..0.05, in m".to_owned();
        let mut region = Self {
            min: DVec3::NEG_INFINITY,
            max: DVec3::INFINITY,
        };
        for part in text.split(',') {
            let (axis, range) = part.split_once('=').ok_or_else(wrong)?;
            let axis = ["x", "y", "z"].iter().position(|name| *name == axis.trim());
            let axis = axis.ok_or_else(wrong)?;
            let (low, high) = range.split_once("..").ok_or_else(wrong)?;
            for (text, corner) in [(low, &mut region.min), (high, &mut region.max)] {
                if !text.trim().is_empty() {
                    corner[axis] = text.trim().parse().map_err(|_| wrong())?;
                }
            }
            let ordered = region.min[axis] <= region.max[axis];
            if !ordered {
                return Err(format!("the range of {} is empty", ["x", "y", "z"][axis]));
            }
        }
        Ok(region)
    }
}

/// Selection of frames and of their particles.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Selection {
    /// Frames.
    pub frames: FrameChoice,
    /// Only particles whose centre is in this box.
    pub region: Option<Region>,
    /// Only particles of these materials, given by name or index; all if empty.
    pub materials: Vec<String>,
}

impl Selection {
    /// Whether rows are left out.
    #[must_use]
    pub fn is_partial(&self) -> bool {
        self.region.is_some() || !self.materials.is_empty()
    }

    /// Leaves out the particles that are not selected.
    ///
    /// # Errors
    /// When a material is not known, or the frame has no column of it.
    pub fn apply(&self, snapshot: &mut Snapshot) -> Result<(), ExportError> {
        if !self.is_partial() {
            return Ok(());
        }
        let mut keep = vec![true; snapshot.frame.rows()];
        if let Some(region) = self.region {
            for axis in 0..3 {
                let name = ["x", "y", "z"][axis];
                let places = snapshot.numbers(name)?;
                for (keep, &place) in keep.iter_mut().zip(places) {
                    *keep &= place >= region.min[axis] && place <= region.max[axis];
                }
            }
        }
        if !self.materials.is_empty() {
            let wanted = self.material_indices(snapshot)?;
            let Some(found) = snapshot.column("material").and_then(Column::as_u32) else {
                let path = snapshot.path.display();
                return Err(ExportError::Input(format!(
                    "{path}: no column `material` to select by"
                )));
            };
            for (keep, material) in keep.iter_mut().zip(found) {
                *keep &= wanted.contains(material);
            }
        }
        for column in &mut snapshot.frame.columns {
            retain(column, &keep);
        }
        Ok(())
    }

    fn material_indices(&self, snapshot: &Snapshot) -> Result<Vec<u32>, ExportError> {
        let names = &snapshot.header.materials;
        let index = |wanted: &String| {
            let named = names.iter().position(|name| name == wanted);
            let index = named.map(|k| k as u32).or_else(|| wanted.parse().ok());
            // Files without names know indices only, and any may occur.
            let known = |k: &u32| names.is_empty() || (*k as usize) < names.len();
            index.filter(known).ok_or_else(|| {
                let known = if names.is_empty() {
                    "indices only".to_owned()
                } else {
                    names.join(", ")
                };
                let path = snapshot.path.display();
                ExportError::Input(format!(
                    "{path}: no material {wanted}; the file knows {known}"
                ))
            })
        };
        self.materials.iter().map(index).collect()
    }
}

/// Keeps the rows that are marked.
pub(crate) fn retain(column: &mut Column, keep: &[bool]) {
    fn only<T>(values: &mut Vec<T>, keep: &[bool]) {
        let mut marks = keep.iter();
        values.retain(|_| marks.next().copied().unwrap_or(false));
    }
    match column {
        Column::F64(v) => only(v, keep),
        Column::I32(v) => only(v, keep),
        Column::U8(v) => only(v, keep),
        Column::U32(v) => only(v, keep),
        Column::OptionalU32(v) => only(v, keep),
        Column::U64(v) => only(v, keep),
        Column::Text(v) => only(v, keep),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_are_open_where_nothing_is_said() {
        let region: Region = "x=0..0.1,z=..0.5".parse().unwrap();
        assert_eq!((region.min.x, region.max.x, region.max.z), (0.0, 0.1, 0.5));
        assert_eq!(
            (region.min.y, region.min.z),
            (f64::NEG_INFINITY, f64::NEG_INFINITY)
        );
        for (bad, message) in [
            ("x", "expected ranges"),
            ("q=0..1", "expected ranges"),
            ("x=0..a", "expected ranges"),
            ("x=1..0", "the range of x is empty"),
            ("x=nan..1", "the range of x is empty"),
        ] {
            let error = bad.parse::<Region>().unwrap_err();
            assert!(error.starts_with(message), "{bad}: {error}");
        }
    }
}

//! Triangles that walls or clumps consist of: one frame in a file of its own, beside the table that speaks of them.

use std::path::Path;

use glam::DVec3;

use super::columns::{ColumnVisitor, Columns, Put, Specs, Take};
use super::table::{open_kind, require};
use super::{ColumnSpec, Frame, FrameSchema, FrameWriteError, FrameWriter};
use crate::error::FormatError;
use crate::formats::mesh::TriangleMesh;

const CORNERS: [[&str; 3]; 3] = [["ax", "ay", "az"], ["bx", "by", "bz"], ["cx", "cy", "cz"]];

/// Whose triangles a file holds.
pub(super) struct TriangleFile {
    /// Name of the content in the file, the value of the schema metadata `kind`.
    pub(super) kind: &'static str,
    /// The column with the index of the wall or clump.
    pub(super) owner: &'static str,
    /// Meaning of a corner.
    pub(super) corner: &'static str,
}

#[derive(Default)]
struct Triangles {
    owner: Vec<u32>,
    corners: [Vec<DVec3>; 3],
}

impl TriangleFile {
    fn columns(&self, triangles: &mut Triangles, visitor: &mut impl ColumnVisitor) {
        let owner = format!("index of the {}", self.owner);
        visitor.column(&mut triangles.owner, &[self.owner], "1", &owner);
        for (list, names) in triangles.corners.iter_mut().zip(CORNERS) {
            visitor.column(list, &names, "m", self.corner);
        }
    }

    fn specs(&self) -> Vec<ColumnSpec> {
        let mut specs = Specs::default();
        self.columns(&mut Triangles::default(), &mut specs);
        specs.0
    }

    /// Writes the file; an owner without triangles of its own has none. There is no file if all are.
    pub(super) fn write<'a>(
        &self,
        path: &Path,
        metadata: Vec<(String, String)>,
        owners: impl Iterator<Item = Option<&'a TriangleMesh>>,
    ) -> Result<(), FrameWriteError> {
        let mut triangles = Triangles::default();
        let mut has_any = false;
        for (index, mesh) in owners.enumerate() {
            let Some(mesh) = mesh else { continue };
            has_any = true;
            for triangle in 0..mesh.triangles.len() {
                triangles.owner.push(index as u32);
                let corners = mesh.corners(triangle);
                for (list, corner) in triangles.corners.iter_mut().zip(corners) {
                    list.push(corner);
                }
            }
        }
        if !has_any {
            return Ok(());
        }
        let schema = FrameSchema::new(self.kind, self.specs())?.with_metadata(metadata);
        let mut put = Put::default();
        self.columns(&mut triangles, &mut put);
        FrameWriter::create(path, schema)?.append(&Frame {
            time: 0.0,
            step: 0,
            columns: put.0,
        })
    }

    /// The corners of the triangles of each of `owners` walls or clumps.
    pub(super) fn read(
        &self,
        path: &Path,
        owners: usize,
    ) -> Result<Vec<Vec<[DVec3; 3]>>, FormatError> {
        let frames = open_kind(path, self.kind)?;
        require(path, self.kind, frames.schema(), &self.specs())?;
        let wrong = |found| FormatError::of_file(path, found);
        let mut triangles = Triangles::default();
        let mut take = Take::new(Columns::new(frames.schema(), frames.frame(0)?));
        self.columns(&mut triangles, &mut take);
        take.result.map_err(wrong)?;
        let [a, b, c] = &triangles.corners;
        let mut soups = vec![Vec::new(); owners];
        for (k, &owner) in triangles.owner.iter().enumerate() {
            let soup: Option<&mut Vec<_>> = soups.get_mut(owner as usize);
            let found = || wrong(format!("triangle {k} of {} {owner}", self.owner));
            soup.ok_or_else(found)?.push([a[k], b[k], c[k]]);
        }
        Ok(soups)
    }
}

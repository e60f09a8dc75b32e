//! What the kinds of clumps look like: the triangles of their own surfaces, in a file beside the table of bodies.

use std::path::{Path, PathBuf};

use glam::DVec3;

use super::table::{Taker, components, index, open_table, require, split_vectors};
use super::{
    Column, ColumnKind, ColumnSpec, Frame, FrameSchema, FrameWriteError, FrameWriter, FramesHeader,
};
use crate::error::FormatError;
use crate::formats::mesh::TriangleMesh;

const KIND: &str = "clumps";
const CORNERS: [[&str; 3]; 3] = [["ax", "ay", "az"], ["bx", "by", "bz"], ["cx", "cy", "cz"]];

/// What the bodies of one clump have in common.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ClumpKind {
    /// Name in the scene.
    pub name: String,
    /// The body's own surface at scale 1 in its principal frame, m; without one it is shown by its pebbles.
    pub surface: Option<TriangleMesh>,
}

fn specs() -> Vec<ColumnSpec> {
    let mut specs = vec![index("clump", ColumnKind::U32, "index of the clump")];
    for corner in CORNERS {
        specs.extend(components(
            corner,
            "m",
            "corner of a triangle, the body's principal frame, scale 1",
        ));
    }
    specs
}

/// The file of surfaces that belongs to a file of bodies.
fn path_beside(bodies: &Path) -> PathBuf {
    let name = bodies.file_name().unwrap_or_default().to_string_lossy();
    let prefix = name.strip_suffix("bodies.arrow").unwrap_or(&name);
    bodies.with_file_name(format!("{prefix}clumps.arrow"))
}

/// Names and numbers of triangles in the metadata of the file of bodies.
pub(super) fn entries(kinds: &[ClumpKind]) -> Vec<(String, String)> {
    let mut entries = Vec::new();
    for (k, kind) in kinds.iter().enumerate() {
        entries.push((format!("clump.{k}"), kind.name.clone()));
        if let Some(surface) = &kind.surface {
            let number = surface.triangles.len().to_string();
            entries.push((format!("clump_triangles.{k}"), number));
        }
    }
    entries
}

/// Writes the file beside that of the bodies, if a kind has a surface.
pub(super) fn write(
    bodies: &Path,
    header: &FramesHeader,
    kinds: &[ClumpKind],
) -> Result<(), FrameWriteError> {
    let mut clump = Vec::new();
    let mut corners: [Vec<DVec3>; 3] = Default::default();
    if kinds.iter().all(|kind| kind.surface.is_none()) {
        return Ok(());
    }
    for (k, kind) in kinds.iter().enumerate() {
        let Some(mesh) = &kind.surface else { continue };
        for triangle in 0..mesh.triangles.len() {
            clump.push(k as u32);
            for (list, corner) in corners.iter_mut().zip(mesh.corners(triangle)) {
                list.push(corner);
            }
        }
    }
    let metadata = header.entries().into_iter().chain(entries(kinds));
    let schema = FrameSchema::new(KIND, specs())?.with_metadata(metadata);
    let mut columns = vec![Column::U32(clump)];
    columns.extend(corners.iter().flat_map(|list| split_vectors(list)));
    FrameWriter::create(path_beside(bodies), schema)?.append(&Frame {
        time: 0.0,
        step: 0,
        columns,
    })
}

/// The kinds that the metadata of the file of bodies names, without their surfaces.
pub(super) fn names(schema: &FrameSchema) -> Vec<ClumpKind> {
    let name = |k: usize| schema.metadata().get(&format!("clump.{k}"));
    let kind = |name: &String| ClumpKind {
        name: name.clone(),
        surface: None,
    };
    (0..).map_while(name).map(kind).collect()
}

/// The kinds that the metadata of the file of bodies names, with their surfaces from the file beside it.
pub(super) fn read(bodies: &Path, schema: &FrameSchema) -> Result<Vec<ClumpKind>, FormatError> {
    let metadata = schema.metadata();
    let mut kinds = Vec::new();
    let mut numbers = Vec::new();
    while let Some(name) = metadata.get(&format!("clump.{}", kinds.len())) {
        let key = format!("clump_triangles.{}", kinds.len());
        let number = metadata.get(&key).map(|text| text.parse::<usize>());
        numbers.push(number.transpose().map_err(|_| {
            let found = format!("`{}` in {key}", metadata[&key]);
            FormatError {
                expected: "a number of triangles".to_owned(),
                ..FormatError::of_file(bodies, found)
            }
        })?);
        kinds.push(ClumpKind {
            name: name.clone(),
            surface: None,
        });
    }
    if numbers.iter().any(Option::is_some) {
        let path = path_beside(bodies);
        let soups = triangles(&path, kinds.len())?;
        for ((k, number), soup) in numbers.into_iter().enumerate().zip(soups) {
            let Some(number) = number else { continue };
            if soup.len() != number {
                let found = format!("{} triangles of clump {k}", soup.len());
                return Err(FormatError {
                    expected: format!("{number}, as {} says", bodies.display()),
                    ..FormatError::of_file(&path, found)
                });
            }
            kinds[k].surface = Some(TriangleMesh::from_corners(&soup));
        }
    }
    Ok(kinds)
}

/// The triangles of each of `kinds` clumps.
fn triangles(path: &Path, kinds: usize) -> Result<Vec<Vec<[DVec3; 3]>>, FormatError> {
    let check = |schema: &FrameSchema| require(schema, &specs());
    let (frames, _, ()) = open_table(path, KIND, check)?;
    let wrong = |found| FormatError::of_file(path, found);
    let mut take = Taker::new(frames.schema(), frames.frame(0)?);
    let clumps = take.u32("clump").map_err(wrong)?;
    let mut corners = Vec::with_capacity(3);
    for names in CORNERS {
        corners.push(take.vectors(names).map_err(wrong)?);
    }
    let mut soups = vec![Vec::new(); kinds];
    for (k, &clump) in clumps.iter().enumerate() {
        let soup: Option<&mut Vec<_>> = soups.get_mut(clump as usize);
        let soup = soup.ok_or_else(|| wrong(format!("triangle {k} of clump {clump}")))?;
        soup.push([corners[0][k], corners[1][k], corners[2][k]]);
    }
    Ok(soups)
}

//! Surfaces of the kinds of clumps: triangles in a file beside the table of bodies.

use std::path::{Path, PathBuf};

use super::triangles::TriangleFile;
use super::{FrameSchema, FrameWriteError, FramesHeader};
use crate::error::FormatError;
use crate::formats::mesh::TriangleMesh;

const FILE: TriangleFile = TriangleFile {
    kind: "clumps",
    owner: "clump",
    corner: "corner of a triangle, the body's principal frame, scale 1",
};

/// Data that all bodies of one clump share.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ClumpKind {
    /// Name in the scene.
    pub name: String,
    /// The body's own surface at scale 1 in its principal frame, m; without one it is shown by its pebbles.
    pub surface: Option<TriangleMesh>,
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
    let metadata = header.entries().into_iter().chain(entries(kinds)).collect();
    let surfaces = kinds.iter().map(|kind| kind.surface.as_ref());
    FILE.write(&path_beside(bodies), metadata, surfaces)
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

/// Gives the kinds of a file of bodies their surfaces, from the file beside it.
pub(super) fn read(
    bodies: &Path,
    schema: &FrameSchema,
    kinds: &mut [ClumpKind],
) -> Result<(), FormatError> {
    let mut numbers = Vec::new();
    for k in 0..kinds.len() {
        let key = format!("clump_triangles.{k}");
        let number = schema.metadata().get(&key).map(|text| {
            text.parse::<usize>().map_err(|_| FormatError {
                expected: "a number of triangles".to_owned(),
                ..FormatError::of_file(bodies, format!("`{text}` in {key}"))
            })
        });
        numbers.push(number.transpose()?);
    }
    if numbers.iter().all(Option::is_none) {
        return Ok(());
    }
    let path = path_beside(bodies);
    let soups = FILE.read(&path, kinds.len())?;
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
    Ok(())
}

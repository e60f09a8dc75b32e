//! The table of walls: one row per wall with its placement; its surface is in the header.

use std::path::{Path, PathBuf};

use glam::{DQuat, DVec3};

use super::triangles::TriangleFile;
use super::{
    ColumnVisitor, FrameSchema, FrameWriteError, FramesHeader, Table, TableReader, TableWriter,
};
use crate::error::FormatError;
use crate::formats::mesh::TriangleMesh;
use crate::surfaces::{Placement, Surface};

const MESHES: TriangleFile = TriangleFile {
    kind: "surfaces",
    owner: "wall",
    corner: "corner of a triangle, the wall's own frame",
};

/// Where the walls stand at one instant; both lists have one entry per wall.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WallFrame {
    /// Time, in s.
    pub time: f64,
    /// Number of time steps made.
    pub step: u64,
    /// Whether the wall is there.
    pub present: Vec<bool>,
    /// From the frame in which the scene describes the wall to where it stands.
    pub placement: Vec<Placement>,
}

/// The file of the triangles of meshes that belongs to a file of walls.
fn mesh_path(walls: &Path) -> PathBuf {
    let name = walls.file_name().unwrap_or_default().to_string_lossy();
    let prefix = name.strip_suffix("walls.arrow").unwrap_or(&name);
    walls.with_file_name(format!("{prefix}surfaces.arrow"))
}

impl Table for WallFrame {
    const KIND: &'static str = "walls";
    /// The surfaces of the walls in the order of [`FramesHeader::walls`](super::FramesHeader::walls).
    type Layout = Vec<Surface>;

    fn moment(&mut self) -> (&mut f64, &mut u64) {
        (&mut self.time, &mut self.step)
    }

    fn columns(&mut self, _: &Vec<Surface>, visitor: &mut impl ColumnVisitor) {
        // The file holds a column for each part of a placement, and the index of the wall, which rows here need not give.
        let mut wall: Vec<u32> = (0..self.placement.len() as u32).collect();
        let parts = self.placement.iter().map(|p| (p.translation, p.rotation));
        let (mut translation, mut rotation): (Vec<DVec3>, Vec<DQuat>) = parts.unzip();
        visitor.column(&mut wall, &["wall"], "1", "index of the wall");
        visitor.column(
            &mut self.present,
            &["present"],
            "1",
            "1: there, 0: not there",
        );
        let origin = "where the origin of the wall's own frame is";
        visitor.column(&mut translation, &["x", "y", "z"], "m", origin);
        let turn = "unit quaternion, the wall's own frame to the global frame";
        visitor.column(&mut rotation, &["qw", "qx", "qy", "qz"], "1", turn);
        let parts = rotation.into_iter().zip(translation);
        let placement = parts.map(|(rotation, translation)| Placement {
            rotation,
            translation,
        });
        self.placement = placement.collect();
    }

    fn layout(schema: &FrameSchema) -> Result<Vec<Surface>, String> {
        let text = |k: usize| schema.metadata().get(&format!("surface.{k}"));
        let texts = (0..).map_while(text).enumerate();
        let surface = |(k, text): (usize, &String)| {
            Surface::from_text(text).map_err(|found| format!("surface.{k}: {found}"))
        };
        texts.map(surface).collect()
    }

    fn metadata(surfaces: &Vec<Surface>) -> Vec<(String, String)> {
        let entry = |(k, surface): (usize, &Surface)| (format!("surface.{k}"), surface.to_text());
        surfaces.iter().enumerate().map(entry).collect()
    }

    fn check(&self, surfaces: &Vec<Surface>) -> Result<(), String> {
        let (rows, walls) = (self.placement.len(), surfaces.len());
        if rows == walls {
            Ok(())
        } else {
            Err(format!("{rows} walls, expected {walls}"))
        }
    }

    fn write_beside(
        surfaces: &Vec<Surface>,
        path: &Path,
        header: &FramesHeader,
    ) -> Result<(), FrameWriteError> {
        let meshes = surfaces.iter().map(|surface| match surface {
            Surface::Mesh(mesh) => Some(mesh),
            _ => None,
        });
        MESHES.write(&mesh_path(path), header.entries(), meshes)
    }

    fn read_beside(
        surfaces: &mut Vec<Surface>,
        path: &Path,
        _: &FrameSchema,
    ) -> Result<(), FormatError> {
        if !surfaces.iter().any(|s| matches!(s, Surface::Mesh(_))) {
            return Ok(());
        }
        let soups = MESHES.read(&mesh_path(path), surfaces.len())?;
        for (surface, soup) in surfaces.iter_mut().zip(soups) {
            if let Surface::Mesh(mesh) = surface {
                *mesh = TriangleMesh::from_corners(&soup);
            }
        }
        Ok(())
    }
}

/// Writes `<prefix>.walls.arrow`, and `<prefix>.surfaces.arrow` if a wall is a mesh.
pub type WallWriter = TableWriter<WallFrame>;

/// Reads `<prefix>.walls.arrow`, and `<prefix>.surfaces.arrow` if a wall is a mesh.
pub type WallReader = TableReader<WallFrame>;

impl WallReader {
    /// The surfaces of the walls, each in the frame in which the scene describes it.
    pub fn surfaces(&self) -> &[Surface] {
        self.layout()
    }
}

#[cfg(test)]
mod tests {
    use super::super::FrameWriter;
    use super::*;

    fn surfaces() -> Vec<Surface> {
        let plane = Surface::Plane {
            point: DVec3::new(0.1, 0.2, 0.3),
            normal: DVec3::Z,
        };
        let a = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let b = [DVec3::X, DVec3::ONE, DVec3::Y];
        vec![plane, Surface::Mesh(TriangleMesh::from_corners(&[a, b]))]
    }

    fn header() -> FramesHeader {
        FramesHeader {
            title: "two walls".to_owned(),
            walls: vec!["floor".to_owned(), "plate".to_owned()],
            ..FramesHeader::default()
        }
    }

    fn frame(step: u64) -> WallFrame {
        let placement = Placement {
            rotation: DQuat::from_rotation_x(0.1 * step as f64),
            translation: DVec3::splat(0.3 * step as f64),
        };
        WallFrame {
            time: 0.5 * step as f64,
            step,
            present: vec![true, step > 1],
            placement: vec![Placement::default(), placement],
        }
    }

    #[test]
    fn walls_read_back_exactly() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.walls.arrow");
        let mut writer = WallWriter::create(&path, &header(), &surfaces()).unwrap();
        writer.append(frame(1)).unwrap();
        writer.append(frame(2)).unwrap();
        drop(writer);
        let mut writer = WallWriter::resume(&path, &header(), &surfaces(), 2).unwrap();
        writer.append(frame(3)).unwrap();
        let reader = WallReader::open(&path).unwrap();
        assert_eq!(reader.header().walls, header().walls);
        assert_eq!(reader.frames().len(), 3);
        for k in 0..3 {
            assert_eq!(reader.frame(k).unwrap(), frame(k as u64 + 1));
        }
        let (found, expected) = (reader.surfaces(), surfaces());
        assert_eq!(found[0], expected[0]);
        let [Surface::Mesh(found), Surface::Mesh(expected)] = [&found[1], &expected[1]] else {
            panic!("{found:?}");
        };
        assert_eq!(found, expected);
        assert_eq!(expected.vertices.len(), 4);
    }

    #[test]
    fn what_is_missing_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.walls.arrow");
        WallWriter::create(&path, &header(), &surfaces()).unwrap();
        std::fs::remove_file(folder.path().join("run.surfaces.arrow")).unwrap();
        let error = WallReader::open(&path).unwrap_err().to_string();
        assert!(
            error.contains("run.surfaces.arrow: the file cannot be opened"),
            "{error}"
        );

        let only = surfaces()[..1].to_vec();
        let mut writer = WallWriter::create(&path, &header(), &only).unwrap();
        let refused = writer.append(frame(1)).unwrap_err().to_string();
        assert!(refused.ends_with("2 walls, expected 1"), "{refused}");
        let schema = WallFrame::schema(&only, &header()).unwrap();
        let mut other_writer = FrameWriter::create(&path, schema).unwrap();
        other_writer.append(&frame(1).into_frame()).unwrap();
        let error = WallReader::open(&path).unwrap().frame(0).unwrap_err();
        assert_eq!(error.found, "frame 0: 2 walls, expected 1");
    }
}

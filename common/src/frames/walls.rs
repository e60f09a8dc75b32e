//! The table of walls: one row per wall, saying where it stands; what it looks like stands in the header.

use std::path::{Path, PathBuf};

use glam::DVec3;

use super::table::{
    Taker, components, index, open_table, require, split_quaternions, split_vectors,
};
use super::{
    Column, ColumnKind, ColumnSpec, Frame, FrameReader, FrameSchema, FrameWriteError, FrameWriter,
    FramesHeader,
};
use crate::error::FormatError;
use crate::formats::mesh::TriangleMesh;
use crate::surfaces::{Placement, Surface};

const KIND: &str = "walls";
const TRANSLATION: [&str; 3] = ["x", "y", "z"];
const ROTATION: [&str; 4] = ["qw", "qx", "qy", "qz"];
const MESH_KIND: &str = "surfaces";
const CORNERS: [[&str; 3]; 3] = [["ax", "ay", "az"], ["bx", "by", "bz"], ["cx", "cy", "cz"]];

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

fn specs() -> Vec<ColumnSpec> {
    let mut specs = vec![
        index("wall", ColumnKind::U32, "index of the wall"),
        index("present", ColumnKind::U8, "1: there, 0: not there"),
    ];
    let translation = "where the origin of the wall's own frame is";
    specs.extend(components(TRANSLATION, "m", translation));
    let rotation = "unit quaternion, the wall's own frame to the global frame";
    specs.extend(components(ROTATION, "1", rotation));
    specs
}

fn mesh_specs() -> Vec<ColumnSpec> {
    let mut specs = vec![index("wall", ColumnKind::U32, "index of the wall")];
    for corner in CORNERS {
        specs.extend(components(
            corner,
            "m",
            "corner of a triangle, the wall's own frame",
        ));
    }
    specs
}

/// The file of the triangles of meshes that belongs to a file of walls.
fn mesh_path(walls: &Path) -> PathBuf {
    let name = walls.file_name().unwrap_or_default().to_string_lossy();
    let prefix = name.strip_suffix("walls.arrow").unwrap_or(&name);
    walls.with_file_name(format!("{prefix}surfaces.arrow"))
}

/// Writes `<prefix>.walls.arrow`, and `<prefix>.surfaces.arrow` if a wall is a mesh.
#[derive(Debug)]
pub struct WallWriter {
    frames: FrameWriter,
}

impl WallWriter {
    /// Creates a file without frames for walls of these surfaces, in the order of [`FramesHeader::walls`]; a file of that
    /// name is replaced. The triangles of meshes are written at once.
    ///
    /// # Errors
    /// When a file cannot be made.
    pub fn create(
        path: impl Into<PathBuf>,
        header: &FramesHeader,
        surfaces: &[Surface],
    ) -> Result<Self, FrameWriteError> {
        let path = path.into();
        write_meshes(&mesh_path(&path), header, surfaces)?;
        let frames = FrameWriter::create(path, schema(header, surfaces)?)?;
        Ok(Self { frames })
    }

    /// Continues a file behind its first `frames` frames, see [`FrameWriter::resume`].
    ///
    /// # Errors
    /// When the file has fewer frames or other walls, or cannot be written.
    pub fn resume(
        path: impl Into<PathBuf>,
        header: &FramesHeader,
        surfaces: &[Surface],
        frames: usize,
    ) -> Result<Self, FrameWriteError> {
        let frames = FrameWriter::resume(path, schema(header, surfaces)?, frames)?;
        Ok(Self { frames })
    }

    /// Appends a frame.
    ///
    /// # Errors
    /// When its lists differ in length, or the file cannot be written; the frames before stay as they are.
    pub fn append(&mut self, frame: &WallFrame) -> Result<(), FrameWriteError> {
        let translation: Vec<DVec3> = frame.placement.iter().map(|p| p.translation).collect();
        let rotation: Vec<_> = frame.placement.iter().map(|p| p.rotation).collect();
        let mut columns = vec![
            Column::U32((0..frame.placement.len() as u32).collect()),
            Column::U8(frame.present.iter().map(|&p| u8::from(p)).collect()),
        ];
        columns.extend(split_vectors(&translation));
        columns.extend(split_quaternions(&rotation));
        self.frames.append(&Frame {
            time: frame.time,
            step: frame.step,
            columns,
        })
    }

    /// The file itself: its length, [`FrameWriter::sync`].
    pub fn frames(&self) -> &FrameWriter {
        &self.frames
    }

    /// The file itself, to be cut back.
    pub fn frames_mut(&mut self) -> &mut FrameWriter {
        &mut self.frames
    }
}

fn schema(header: &FramesHeader, surfaces: &[Surface]) -> Result<FrameSchema, super::SchemaError> {
    let mut entries = header.entries();
    for (k, surface) in surfaces.iter().enumerate() {
        entries.push((format!("surface.{k}"), surface.to_text()));
    }
    Ok(FrameSchema::new(KIND, specs())?.with_metadata(entries))
}

fn write_meshes(
    path: &Path,
    header: &FramesHeader,
    surfaces: &[Surface],
) -> Result<(), FrameWriteError> {
    let mut wall = Vec::new();
    let mut corners: [Vec<DVec3>; 3] = Default::default();
    for (k, surface) in surfaces.iter().enumerate() {
        let Surface::Mesh(mesh) = surface else {
            continue;
        };
        for triangle in 0..mesh.triangles.len() {
            wall.push(k as u32);
            for (list, corner) in corners.iter_mut().zip(mesh.corners(triangle)) {
                list.push(corner);
            }
        }
    }
    if !surfaces.iter().any(|s| matches!(s, Surface::Mesh(_))) {
        return Ok(());
    }
    let schema = FrameSchema::new(MESH_KIND, mesh_specs())?.with_metadata(header.entries());
    let mut columns = vec![Column::U32(wall)];
    columns.extend(corners.iter().flat_map(|list| split_vectors(list)));
    FrameWriter::create(path, schema)?.append(&Frame {
        time: 0.0,
        step: 0,
        columns,
    })
}

/// Reads `<prefix>.walls.arrow`, and `<prefix>.surfaces.arrow` if a wall is a mesh.
#[derive(Debug)]
pub struct WallReader {
    frames: FrameReader,
    header: FramesHeader,
    surfaces: Vec<Surface>,
}

impl WallReader {
    /// Opens a file of walls.
    ///
    /// # Errors
    /// When the file (or that of the triangles of meshes) cannot be opened, is no stream of frames, lacks columns, or
    /// describes a surface in words that are not known.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, FormatError> {
        let path = path.as_ref();
        let check = |schema: &FrameSchema| require(schema, &specs());
        let (frames, header, ()) = open_table(path, KIND, check)?;
        let metadata = frames.schema().metadata();
        let mut surfaces = Vec::new();
        while let Some(text) = metadata.get(&format!("surface.{}", surfaces.len())) {
            let surface = Surface::from_text(text).map_err(|found| {
                FormatError::of_file(path, format!("surface.{}: {found}", surfaces.len()))
            })?;
            surfaces.push(surface);
        }
        if surfaces.iter().any(|s| matches!(s, Surface::Mesh(_))) {
            read_meshes(&mesh_path(path), &mut surfaces)?;
        }
        Ok(Self {
            frames,
            header,
            surfaces,
        })
    }

    /// What the file says about its run.
    pub fn header(&self) -> &FramesHeader {
        &self.header
    }

    /// The surfaces of the walls, each in the frame in which the scene describes it.
    pub fn surfaces(&self) -> &[Surface] {
        &self.surfaces
    }

    /// The file itself: number of frames, times, damage.
    pub fn frames(&self) -> &FrameReader {
        &self.frames
    }

    /// Frame `k`, counted from 0.
    ///
    /// # Errors
    /// When there is no such frame, its bytes are damaged, or it has not one row per surface.
    pub fn frame(&self, k: usize) -> Result<WallFrame, FormatError> {
        let frame = self.frames.frame(k)?;
        let walls = self.surfaces.len();
        let read = |frame: Frame| {
            let (time, step, rows) = (frame.time, frame.step, frame.rows());
            if rows != walls {
                return Err(format!("{rows} walls, expected {walls}"));
            }
            let mut take = Taker::new(self.frames.schema(), frame);
            let present = take.u8("present")?;
            let translation = take.vectors(TRANSLATION)?;
            let rotation = take.quaternions(ROTATION)?;
            let both = rotation.into_iter().zip(translation);
            Ok(WallFrame {
                time,
                step,
                present: present.into_iter().map(|p| p != 0).collect(),
                placement: both
                    .map(|(rotation, translation)| Placement {
                        rotation,
                        translation,
                    })
                    .collect(),
            })
        };
        read(frame).map_err(|found| {
            FormatError::of_file(self.frames.path(), format!("frame {k}: {found}"))
        })
    }
}

fn read_meshes(path: &Path, surfaces: &mut [Surface]) -> Result<(), FormatError> {
    let check = |schema: &FrameSchema| require(schema, &mesh_specs());
    let (frames, _, ()) = open_table(path, MESH_KIND, check)?;
    let schema = frames.schema();
    let wrong = |found| FormatError::of_file(path, found);
    let mut take = Taker::new(schema, frames.frame(0)?);
    let walls = take.u32("wall").map_err(wrong)?;
    let mut corners = Vec::with_capacity(3);
    for names in CORNERS {
        corners.push(take.vectors(names).map_err(wrong)?);
    }
    let mut soups: Vec<Vec<[DVec3; 3]>> = vec![Vec::new(); surfaces.len()];
    for (k, &wall) in walls.iter().enumerate() {
        let soup = soups.get_mut(wall as usize);
        let soup = soup.ok_or_else(|| wrong(format!("triangle {k} of wall {wall}")))?;
        soup.push([corners[0][k], corners[1][k], corners[2][k]]);
    }
    for (surface, soup) in surfaces.iter_mut().zip(soups) {
        if let Surface::Mesh(mesh) = surface {
            *mesh = TriangleMesh::from_corners(&soup);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

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
        writer.append(&frame(1)).unwrap();
        writer.append(&frame(2)).unwrap();
        drop(writer);
        let mut writer = WallWriter::resume(&path, &header(), &surfaces(), 2).unwrap();
        writer.append(&frame(3)).unwrap();
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

        let only = &surfaces()[..1];
        let mut writer = WallWriter::create(&path, &header(), only).unwrap();
        writer.append(&frame(1)).unwrap();
        let error = WallReader::open(&path).unwrap().frame(0).unwrap_err();
        assert_eq!(error.found, "frame 0: 2 walls, expected 1");
    }
}

//! The table of rigid bodies: one row per body; the surface of its kind is in a file beside it.

use std::path::Path;

use glam::{DQuat, DVec3};

use super::clump_surfaces::{self, ClumpKind};
use super::{
    ColumnVisitor, FrameSchema, FrameWriteError, FramesHeader, Table, TableReader, TableWriter,
};
use crate::error::FormatError;

/// The rigid bodies at one instant; all lists have one entry per body.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BodyFrame {
    /// Time, in s.
    pub time: f64,
    /// Number of time steps made.
    pub step: u64,
    /// The number that names the body, the column `body` of its pebbles among the particles.
    pub id: Vec<u32>,
    /// Index of its clump, see [`BodyReader::kinds`].
    pub clump: Vec<u32>,
    /// Index of the material of its surface, see [`FramesHeader::materials`](super::FramesHeader::materials).
    pub material: Vec<u32>,
    /// Bits: [`FLAG_FIXED`](super::FLAG_FIXED), [`FLAG_PRESCRIBED`](super::FLAG_PRESCRIBED).
    pub flags: Vec<u8>,
    /// Mass, in kg.
    pub mass: Vec<f64>,
    /// Volume, in m^3.
    pub volume: Vec<f64>,
    /// Size, relative to the clump's file.
    pub scale: Vec<f64>,
    /// Radius of the smallest sphere about the centre of mass that holds all pebbles, in m.
    pub radius: Vec<f64>,
    /// Centre of mass, in m.
    pub position: Vec<DVec3>,
    /// Velocity of the centre of mass, in m/s.
    pub velocity: Vec<DVec3>,
    /// Rotation from the principal frame to the global frame, as unit quaternion.
    pub orientation: Vec<DQuat>,
    /// Angular velocity in the global frame, in rad/s.
    pub angular_velocity: Vec<DVec3>,
    /// Moments of inertia about the axes of the principal frame, in kg m^2.
    pub principal_moments: Vec<DVec3>,
    /// Contact force on the body, in N.
    pub force: Vec<DVec3>,
    /// Contact torque on the body about its centre of mass, in N m.
    pub torque: Vec<DVec3>,
}

impl BodyFrame {
    /// The number of bodies.
    #[must_use]
    pub fn len(&self) -> usize {
        self.id.len()
    }

    /// Whether there are no bodies.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.id.is_empty()
    }
}

impl Table for BodyFrame {
    const KIND: &'static str = "bodies";
    /// The clumps in the order of their indices.
    type Layout = Vec<ClumpKind>;

    fn moment(&mut self) -> (&mut f64, &mut u64) {
        (&mut self.time, &mut self.step)
    }

    fn columns(&mut self, _: &Vec<ClumpKind>, visitor: &mut impl ColumnVisitor) {
        let id = "number of the body, as in the column `body` of particles";
        let flags = "bit 0: fixed, bit 1: prescribed motion";
        let radius = "radius of the smallest sphere about the centre that holds the pebbles";
        visitor.column(&mut self.id, &["id"], "1", id);
        visitor.column(&mut self.clump, &["clump"], "1", "index of the clump");
        visitor.column(
            &mut self.material,
            &["material"],
            "1",
            "index of the material",
        );
        visitor.column(&mut self.flags, &["state"], "1", flags);
        visitor.column(&mut self.mass, &["mass"], "kg", "mass");
        visitor.column(&mut self.volume, &["volume"], "m^3", "volume");
        visitor.column(
            &mut self.scale,
            &["scale"],
            "1",
            "size relative to the clump's file",
        );
        visitor.column(&mut self.radius, &["radius"], "m", radius);
        visitor.column(&mut self.position, &["x", "y", "z"], "m", "centre of mass");
        let velocity = "velocity of the centre";
        visitor.column(&mut self.velocity, &["vx", "vy", "vz"], "m/s", velocity);
        let orientation = "unit quaternion, principal frame to global frame";
        visitor.column(
            &mut self.orientation,
            &["qw", "qx", "qy", "qz"],
            "1",
            orientation,
        );
        let spin = "angular velocity, global frame";
        visitor.column(
            &mut self.angular_velocity,
            &["wx", "wy", "wz"],
            "rad/s",
            spin,
        );
        let moments = "moment of inertia about an axis of the principal frame";
        visitor.column(
            &mut self.principal_moments,
            &["ix", "iy", "iz"],
            "kg m^2",
            moments,
        );
        visitor.column(
            &mut self.force,
            &["fx", "fy", "fz"],
            "N",
            "force of the contacts",
        );
        let torque = "torque of the contacts about the centre of mass";
        visitor.column(&mut self.torque, &["tx", "ty", "tz"], "N m", torque);
    }

    fn layout(schema: &FrameSchema) -> Result<Vec<ClumpKind>, String> {
        Ok(clump_surfaces::names(schema))
    }

    fn metadata(kinds: &Vec<ClumpKind>) -> Vec<(String, String)> {
        clump_surfaces::entries(kinds)
    }

    fn check(&self, kinds: &Vec<ClumpKind>) -> Result<(), String> {
        let known = kinds.len();
        match self.clump.iter().find(|&&clump| clump as usize >= known) {
            Some(clump) => Err(format!("a body of clump {clump}; the file names {known}")),
            None => Ok(()),
        }
    }

    fn write_beside(
        kinds: &Vec<ClumpKind>,
        path: &Path,
        header: &FramesHeader,
    ) -> Result<(), FrameWriteError> {
        clump_surfaces::write(path, header, kinds)
    }

    fn read_beside(
        kinds: &mut Vec<ClumpKind>,
        path: &Path,
        schema: &FrameSchema,
    ) -> Result<(), FormatError> {
        clump_surfaces::read(path, schema, kinds)
    }
}

/// Writes `<prefix>.bodies.arrow`, and `<prefix>.clumps.arrow` if a kind of clump has a surface of its own.
pub type BodyWriter = TableWriter<BodyFrame>;

/// Reads `<prefix>.bodies.arrow`, and `<prefix>.clumps.arrow` if a kind of clump has a surface of its own. Opened alone, its
/// kinds have names and no surfaces.
pub type BodyReader = TableReader<BodyFrame>;

impl BodyReader {
    /// The clumps in the order of their indices.
    pub fn kinds(&self) -> &[ClumpKind] {
        self.layout()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::FrameWriter;
    use super::*;
    use crate::formats::mesh::TriangleMesh;

    fn kinds() -> Vec<ClumpKind> {
        let a = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let b = [DVec3::X, DVec3::splat(0.1), DVec3::Y];
        vec![
            ClumpKind {
                name: "bean".to_owned(),
                surface: None,
            },
            ClumpKind {
                name: "stone".to_owned(),
                surface: Some(TriangleMesh::from_corners(&[a, b])),
            },
        ]
    }

    fn header() -> FramesHeader {
        FramesHeader {
            title: "grains".to_owned(),
            materials: vec!["rock".to_owned()],
            ..FramesHeader::default()
        }
    }

    /// `rows` bodies whose numbers are all different and not exact in decimals.
    fn frame(step: u64, rows: u32, seed: f64) -> BodyFrame {
        let number = |k: u32, column: u32| seed + f64::from(k) / 3.0 + f64::from(column) / 7.0;
        let numbers = |column| (0..rows).map(|k| number(k, column)).collect();
        let vectors = |column| -> Vec<DVec3> {
            let vector = |k| {
                DVec3::new(
                    number(k, column),
                    -number(k, column + 1),
                    number(k, column + 2),
                )
            };
            (0..rows).map(vector).collect()
        };
        BodyFrame {
            time: 0.1 * step as f64,
            step,
            id: (0..rows).map(|k| 3 * k).collect(),
            clump: (0..rows).map(|k| k % 2).collect(),
            material: vec![0; rows as usize],
            flags: (0..rows).map(|k| (k % 4) as u8).collect(),
            mass: numbers(0),
            volume: numbers(1),
            scale: numbers(2),
            radius: numbers(3),
            position: vectors(4),
            velocity: vectors(7),
            orientation: vectors(10)
                .iter()
                .map(|&turn| DQuat::from_scaled_axis(turn))
                .collect(),
            angular_velocity: vectors(13),
            principal_moments: vectors(16),
            force: vectors(19),
            torque: vectors(22),
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(16))]
        #[test]
        fn bodies_read_back_exactly(rows in prop::collection::vec(0..5u32, 1..4), seed in -1e3..1e3f64) {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("run.bodies.arrow");
            let written: Vec<BodyFrame> = rows
                .iter()
                .zip(1..)
                .map(|(&rows, step)| frame(step, rows, seed))
                .collect();
            let mut writer = BodyWriter::create(&path, &header(), &kinds()).unwrap();
            writer.append(written[0].clone()).unwrap();
            drop(writer);
            let mut writer = BodyWriter::resume(&path, &header(), &kinds(), 1).unwrap();
            for frame in &written[1..] {
                writer.append(frame.clone()).unwrap();
            }
            let reader = BodyReader::open(&path).unwrap();
            prop_assert_eq!(reader.kinds(), &kinds()[..]);
            prop_assert_eq!(&reader.header().materials, &header().materials);
            prop_assert_eq!(reader.frames().len(), written.len());
            for (k, expected) in written.iter().enumerate() {
                prop_assert_eq!(&reader.frame(k).unwrap(), expected);
            }
        }
    }

    #[test]
    fn bodies_without_surfaces_leave_one_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.bodies.arrow");
        BodyWriter::create(&path, &header(), &kinds()[..1].to_vec()).unwrap();
        assert!(!folder.path().join("run.clumps.arrow").exists());
        assert_eq!(BodyReader::open(&path).unwrap().kinds(), &kinds()[..1]);
    }

    #[test]
    fn what_is_missing_or_of_another_run_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.bodies.arrow");
        let surfaces = folder.path().join("run.clumps.arrow");
        let mut writer = BodyWriter::create(&path, &header(), &kinds()).unwrap();
        let mut wrong = frame(1, 1, 0.0);
        wrong.clump = vec![2];
        let refused = writer.append(wrong.clone()).unwrap_err().to_string();
        let found = "a body of clump 2; the file names 2";
        assert!(refused.ends_with(found), "{refused}");
        let schema = BodyFrame::schema(&kinds(), &header()).unwrap();
        let mut other_writer = FrameWriter::create(&path, schema).unwrap();
        other_writer.append(&wrong.into_frame()).unwrap();
        let error = BodyReader::open(&path).unwrap().frame(0).unwrap_err();
        assert_eq!(error.found, format!("frame 0: {found}"));

        std::fs::remove_file(&surfaces).unwrap();
        let error = BodyReader::open(&path).unwrap_err().to_string();
        let expected = "run.clumps.arrow: the file cannot be opened";
        assert!(error.contains(expected), "{error}");

        let other = folder.path().join("other.bodies.arrow");
        let mut larger = kinds();
        larger[1].surface = Some(TriangleMesh::from_corners(&[[
            DVec3::ZERO,
            DVec3::X,
            DVec3::Z,
        ]]));
        BodyWriter::create(&other, &header(), &larger).unwrap();
        std::fs::rename(folder.path().join("other.clumps.arrow"), &surfaces).unwrap();
        let error = BodyReader::open(&path).unwrap_err();
        assert_eq!(error.found, "1 triangles of clump 1");
        assert!(error.expected.starts_with("2, as "), "{}", error.expected);
    }
}

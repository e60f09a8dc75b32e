//! `.data`: the particles of each saved time, in MercuryDPM's 2D and 3D layouts.
//!
//! A frame is a header line (`N t min max`: 6 numbers in 2D, 8 in 3D) and N lines of one particle each.
//! In memory every quantity has its physical sign; the 2D layout stores the rotation about z negated
//! (the viewer that the layout was made for looks at the plane from the other side), and the reader and the
//! writer take care of that. See `docs/formats/data.md`.

mod reader;
#[cfg(test)]
mod tests;
mod writer;

use glam::DVec3;

pub use reader::DataReader;
pub use writer::write_frame;

/// The particles at one time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DataFrame {
    /// Time in s.
    pub time: f64,
    /// 2 or 3: decides the layout. In 2D the z components of positions and velocities are not stored.
    pub dimensions: u8,
    /// Lower corner of the domain in m (z = 0 in 2D).
    pub min: DVec3,
    /// Upper corner of the domain in m (z = 0 in 2D).
    pub max: DVec3,
    /// One entry per particle, in the order of the file.
    pub particles: Vec<DataRow>,
}

/// One particle of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DataRow {
    /// Centre in m.
    pub position: DVec3,
    /// Velocity in m/s.
    pub velocity: DVec3,
    /// Radius in m.
    pub radius: f64,
    /// Roll, pitch, yaw in rad; see
    /// [`quaternion_from_euler`](super::orientation::quaternion_from_euler). In 2D only yaw, the rotation about +z.
    pub angles: DVec3,
    /// Angular velocity in rad/s in the global frame. In 2D only z.
    pub angular_velocity: DVec3,
    /// Any number; by default the index of the material.
    pub info: f64,
}

/// The column layouts, named after MercuryDPM's numbers for them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DataLayout {
    /// `x z y vx vz vy r info` with a 3D header: y and z are swapped; no rotation. Only read.
    Format7,
    /// `x y vx vy r angle omega info`: the 2D layout; angle and omega have the flipped sign.
    Format8,
    /// `x y z vx vy vz r ax ay az wx wy wz info`: the 3D layout.
    Format14,
    /// As 14 with one more column before info, which is ignored. Only read.
    Format15,
}

impl DataLayout {
    /// The names of the columns.
    #[must_use]
    pub fn columns(self) -> &'static [&'static str] {
        match self {
            Self::Format7 => &["x", "z", "y", "vx", "vz", "vy", "r", "info"],
            Self::Format8 => &["x", "y", "vx", "vy", "r", "angle", "omega", "info"],
            Self::Format14 => &[
                "x", "y", "z", "vx", "vy", "vz", "r", "ax", "ay", "az", "wx", "wy", "wz", "info",
            ],
            Self::Format15 => &[
                "x",
                "y",
                "z",
                "vx",
                "vy",
                "vz",
                "r",
                "ax",
                "ay",
                "az",
                "wx",
                "wy",
                "wz",
                "extra column",
                "info",
            ],
        }
    }

    /// The layout of a frame whose first particle line has this many numbers. 16 and more are
    /// format 14 with surplus columns, as parallel MercuryDPM writes them.
    fn detect(dimensions: u8, columns: usize) -> Option<Self> {
        match (dimensions, columns) {
            (2, 8..) => Some(Self::Format8),
            (3, 8) => Some(Self::Format7),
            (3, 15) => Some(Self::Format15),
            (3, 14 | 16..) => Some(Self::Format14),
            _ => None,
        }
    }

    /// The numbers of a line in this layout as a particle.
    fn row(self, v: &[f64; MOST_COLUMNS]) -> DataRow {
        match self {
            Self::Format7 => DataRow {
                position: DVec3::new(v[0], v[2], v[1]),
                velocity: DVec3::new(v[3], v[5], v[4]),
                radius: v[6],
                info: v[7],
                ..DataRow::default()
            },
            Self::Format8 => DataRow {
                position: DVec3::new(v[0], v[1], 0.0),
                velocity: DVec3::new(v[2], v[3], 0.0),
                radius: v[4],
                angles: DVec3::new(0.0, 0.0, -v[5]),
                angular_velocity: DVec3::new(0.0, 0.0, -v[6]),
                info: v[7],
            },
            Self::Format14 | Self::Format15 => DataRow {
                position: DVec3::new(v[0], v[1], v[2]),
                velocity: DVec3::new(v[3], v[4], v[5]),
                radius: v[6],
                angles: DVec3::new(v[7], v[8], v[9]),
                angular_velocity: DVec3::new(v[10], v[11], v[12]),
                info: if self == Self::Format14 { v[13] } else { v[14] },
            },
        }
    }
}

/// The longest layout.
const MOST_COLUMNS: usize = 15;

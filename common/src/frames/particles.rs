//! The table of particles: one row per sphere.

use glam::{DQuat, DVec3};

use super::{ColumnKind, ColumnSpec, ColumnVisitor, FrameSchema, Table, TableReader, TableWriter};
use crate::particle_properties::ParticleProperty;

/// Bit of [`ParticleFrame::flags`]: the particle does not move.
pub const FLAG_FIXED: u8 = 1;
/// Bit of [`ParticleFrame::flags`]: the motion of the particle is prescribed.
pub const FLAG_PRESCRIBED: u8 = 2;

const ORIENTATION: [&str; 4] = ["qw", "qx", "qy", "qz"];
const ANGULAR_VELOCITY: [&str; 3] = ["wx", "wy", "wz"];
const FORCE: [&str; 3] = ["fx", "fy", "fz"];
const TORQUE: [&str; 3] = ["tx", "ty", "tz"];

/// Optional columns of a file of particles; fixed for the file.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ParticleColumns {
    /// The body that a sphere belongs to.
    pub body: bool,
    /// Orientation as unit quaternion.
    pub orientation: bool,
    /// Angular velocity.
    pub angular_velocity: bool,
    /// Force on the particle.
    pub force: bool,
    /// Torque on the particle.
    pub torque: bool,
    /// Further numbers of each particle: [properties](crate::particle_properties), or what other programs add.
    pub more: Vec<ColumnSpec>,
}

impl ParticleColumns {
    /// All columns of this version but [`more`](Self::more).
    #[must_use]
    pub fn all() -> Self {
        Self {
            body: true,
            orientation: true,
            angular_velocity: true,
            force: true,
            torque: true,
            more: Vec::new(),
        }
    }

    /// With the columns of these properties.
    #[must_use]
    pub fn with_properties<'a>(
        mut self,
        properties: impl IntoIterator<Item = &'a ParticleProperty>,
    ) -> Self {
        let spec = |property: &ParticleProperty| {
            ColumnSpec::new(property.name, ColumnKind::F64, property.unit_of_frames())
                .described(property.meaning)
        };
        self.more.extend(properties.into_iter().map(spec));
        self
    }

    /// The column of this name among the [further numbers](ParticleFrame::more) of a frame, row by row.
    #[must_use]
    pub fn number<'a>(&self, frame: &'a ParticleFrame, name: &str) -> Option<&'a [f64]> {
        let place = self.more.iter().position(|spec| spec.name == name)?;
        frame.more.get(place).map(Vec::as_slice)
    }
}

/// The particles at one instant; all lists have one entry per particle.
///
/// An optional list is there when it is in the file's [`ParticleColumns`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ParticleFrame {
    /// Time, in s.
    pub time: f64,
    /// Number of time steps made.
    pub step: u64,
    /// The number that names the particle, the same for all its life.
    pub id: Vec<u32>,
    /// Index of the material, see [`FramesHeader::materials`](super::FramesHeader::materials).
    pub material: Vec<u32>,
    /// Bits: [`FLAG_FIXED`], [`FLAG_PRESCRIBED`].
    pub flags: Vec<u8>,
    /// Mass, in kg.
    pub mass: Vec<f64>,
    /// Volume, in m^3.
    pub volume: Vec<f64>,
    /// Radius, in m.
    pub radius: Vec<f64>,
    /// Position of the centre, in m.
    pub position: Vec<DVec3>,
    /// Velocity of the centre, in m/s.
    pub velocity: Vec<DVec3>,
    /// The body that the sphere is a part of, if it is of one.
    pub body: Option<Vec<Option<u32>>>,
    /// Rotation from the body frame to the global frame, as unit quaternion.
    pub orientation: Option<Vec<DQuat>>,
    /// Angular velocity in the global frame, in rad/s.
    pub angular_velocity: Option<Vec<DVec3>>,
    /// Force on the particle, in N.
    pub force: Option<Vec<DVec3>>,
    /// Torque on the particle about its centre, in N m.
    pub torque: Option<Vec<DVec3>>,
    /// The further numbers of [`ParticleColumns::more`], in that order: a list for each column.
    pub more: Vec<Vec<f64>>,
}

impl Table for ParticleFrame {
    const KIND: &'static str = "particles";
    type Layout = ParticleColumns;

    fn moment(&mut self) -> (&mut f64, &mut u64) {
        (&mut self.time, &mut self.step)
    }

    fn columns(&mut self, has: &ParticleColumns, visitor: &mut impl ColumnVisitor) {
        let id = "number of the particle, for all its life";
        let body = "body that the sphere is a part of, null if of none";
        let flags = "bit 0: fixed, bit 1: prescribed motion";
        visitor.column(&mut self.id, &["id"], "1", id);
        visitor.column(
            &mut self.material,
            &["material"],
            "1",
            "index of the material",
        );
        visitor.optional(has.body, &mut self.body, &["body"], "1", body);
        visitor.column(&mut self.flags, &["state"], "1", flags);
        visitor.column(&mut self.mass, &["mass"], "kg", "mass");
        visitor.column(&mut self.volume, &["volume"], "m^3", "volume");
        visitor.column(&mut self.radius, &["radius"], "m", "radius");
        let position = "position of the centre";
        visitor.column(&mut self.position, &["x", "y", "z"], "m", position);
        let velocity = "velocity of the centre";
        visitor.column(&mut self.velocity, &["vx", "vy", "vz"], "m/s", velocity);
        let orientation = "unit quaternion, body frame to global frame";
        visitor.optional(
            has.orientation,
            &mut self.orientation,
            &ORIENTATION,
            "1",
            orientation,
        );
        visitor.optional(
            has.angular_velocity,
            &mut self.angular_velocity,
            &ANGULAR_VELOCITY,
            "rad/s",
            "angular velocity, global frame",
        );
        visitor.optional(
            has.force,
            &mut self.force,
            &FORCE,
            "N",
            "force on the particle",
        );
        visitor.optional(
            has.torque,
            &mut self.torque,
            &TORQUE,
            "N m",
            "torque about the centre",
        );
        visitor.numbers(&mut self.more, &has.more);
    }

    fn layout(schema: &FrameSchema) -> Result<ParticleColumns, String> {
        let has = |name: &str| schema.index_of(name).is_some();
        Ok(ParticleColumns {
            body: has("body"),
            orientation: has(ORIENTATION[0]),
            angular_velocity: has(ANGULAR_VELOCITY[0]),
            force: has(FORCE[0]),
            torque: has(TORQUE[0]),
            more: numbers_beside(schema),
        })
    }
}

/// The columns of numbers that are none of those with a name in [`ParticleFrame`].
fn numbers_beside(schema: &FrameSchema) -> Vec<ColumnSpec> {
    let named = ParticleFrame::specs(&ParticleColumns::all());
    let is_further = |spec: &&ColumnSpec| {
        spec.kind == ColumnKind::F64 && named.iter().all(|known| known.name != spec.name)
    };
    schema
        .columns()
        .iter()
        .filter(is_further)
        .cloned()
        .collect()
}

/// Writes `<prefix>.particles.arrow`.
pub type ParticleWriter = TableWriter<ParticleFrame>;

/// Reads `<prefix>.particles.arrow`.
pub type ParticleReader = TableReader<ParticleFrame>;

impl ParticleFrame {
    /// The number of particles.
    pub fn len(&self) -> usize {
        self.id.len()
    }

    /// Whether there are no particles.
    pub fn is_empty(&self) -> bool {
        self.id.is_empty()
    }
}

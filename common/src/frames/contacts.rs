//! The table of contacts: one row per contact of two particles or of a particle and a wall.

use glam::DVec3;

use super::{ColumnKind, ColumnSpec, ColumnVisitor, FrameSchema, Table, TableReader, TableWriter};

const TORQUE: [&str; 3] = ["tx", "ty", "tz"];
const BRIDGE_VOLUME: [&str; 1] = ["bridge_volume"];
const ADHESION: [&str; 1] = ["adhesion"];
const MEMBRANE: [&str; 1] = ["membrane"];

/// Unit and meaning of one number that a contact law remembers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HistoryColumn {
    /// The SI unit.
    pub unit: String,
    /// Meaning of the value that the law keeps in the column.
    pub description: String,
}

/// Optional columns of a file of contacts; fixed for the file.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ContactColumns {
    /// Couple on particle i beyond the lever arm of the force.
    pub torque: bool,
    /// Liquid bridges.
    pub bridge: bool,
    /// Dry cohesion.
    pub adhesion: bool,
    /// Contacts with membranes.
    pub membrane: bool,
    /// The numbers that the contact laws remember, columns `h0`, `h1`, ...
    pub history: Vec<HistoryColumn>,
}

/// The contacts at one instant; all lists have one entry per contact.
///
/// A contact is of particle `i` with *either* particle `j` *or* wall `wall` *or* membrane `membrane`: of these, exactly one is there.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ContactFrame {
    /// Time, in s.
    pub time: f64,
    /// Number of time steps made.
    pub step: u64,
    /// Id of the particle that force and torque act on.
    pub i: Vec<u32>,
    /// Id of the other particle.
    pub j: Vec<Option<u32>>,
    /// Index of the wall, see [`FramesHeader::walls`](super::FramesHeader::walls).
    pub wall: Vec<Option<u32>>,
    /// Number of the membrane, in the order of the scene.
    pub membrane: Option<Vec<Option<u32>>>,
    /// Contact point, in m, beside particle i where the domain is periodic.
    pub point: Vec<DVec3>,
    /// Branch vector, in m: from the centre of j (its image nearest to i), for a wall from the contact point, to the
    /// centre of i.
    pub branch: Vec<DVec3>,
    /// Unit normal, from j or the wall towards i.
    pub normal: Vec<DVec3>,
    /// Force on i, in N; j or the wall gets the opposite.
    pub force: Vec<DVec3>,
    /// Overlap, in m; negative for particles that pull over a gap.
    pub overlap: Vec<f64>,
    /// Couple on i, in N m, beyond the lever arm of the force: rolling and torsion resistance.
    pub torque: Option<Vec<DVec3>>,
    /// Volume of the liquid bridge, in m^3; 0 where there is none.
    pub bridge_volume: Option<Vec<f64>>,
    /// Capillary and viscous force of the bridge on i along the normal, in N; negative pulls.
    pub bridge_normal: Option<Vec<f64>>,
    /// Its viscous force on i in the tangent plane, in N.
    pub bridge_shear: Option<Vec<DVec3>>,
    /// Force of dry cohesion on i along the normal, in N; negative pulls.
    pub adhesion: Option<Vec<f64>>,
    /// Memory of the contact laws: one list per entry of [`ContactColumns::history`].
    pub history: Vec<Vec<f64>>,
}

impl ContactFrame {
    /// The row, if any, that has not exactly one partner.
    fn without_partner(&self) -> Option<String> {
        let membranes = self.membrane.as_deref();
        let count = |row: usize| {
            let membrane = membranes.and_then(|of_rows| of_rows.get(row).copied().flatten());
            let partners = [self.j[row], self.wall[row], membrane];
            partners.iter().flatten().count()
        };
        let rows = self.j.len().min(self.wall.len());
        let row = (0..rows).find(|&row| count(row) != 1)?;
        let partners = match membranes {
            None => "either a particle j or a wall",
            Some(_) => "one of a particle j, a wall and a membrane",
        };
        Some(format!("contact {row} must have {partners}"))
    }
}

impl ContactFrame {
    /// The number of contacts.
    pub fn len(&self) -> usize {
        self.i.len()
    }

    /// Whether there are no contacts.
    pub fn is_empty(&self) -> bool {
        self.i.is_empty()
    }
}

impl Table for ContactFrame {
    const KIND: &'static str = "contacts";
    type Layout = ContactColumns;

    fn moment(&mut self) -> (&mut f64, &mut u64) {
        (&mut self.time, &mut self.step)
    }

    fn columns(&mut self, has: &ContactColumns, visitor: &mut impl ColumnVisitor) {
        let i = "id of the particle that the force acts on";
        let j = if has.membrane {
            "id of the other particle, null at others"
        } else {
            "id of the other particle, null at a wall"
        };
        let wall = if has.membrane {
            "index of the wall, null at others"
        } else {
            "index of the wall, null between particles"
        };
        let membrane = "number of the membrane, null at others";
        let branch =
            "from the centre of j (nearest image) or the point on the wall to the centre of i";
        let normal = "unit normal, from j or the wall towards i";
        let torque = "couple on i beyond the lever arm of the force";
        visitor.column(&mut self.i, &["i"], "1", i);
        visitor.column(&mut self.j, &["j"], "1", j);
        visitor.column(&mut self.wall, &["wall"], "1", wall);
        visitor.optional(has.membrane, &mut self.membrane, &MEMBRANE, "1", membrane);
        visitor.column(&mut self.point, &["px", "py", "pz"], "m", "contact point");
        visitor.column(&mut self.branch, &["bx", "by", "bz"], "m", branch);
        visitor.column(&mut self.normal, &["nx", "ny", "nz"], "1", normal);
        visitor.column(&mut self.force, &["fx", "fy", "fz"], "N", "force on i");
        visitor.column(
            &mut self.overlap,
            &["overlap"],
            "m",
            "overlap, negative over a gap",
        );
        visitor.optional(has.torque, &mut self.torque, &TORQUE, "N m", torque);
        visitor.optional(
            has.bridge,
            &mut self.bridge_volume,
            &BRIDGE_VOLUME,
            "m3",
            "volume of the liquid bridge, 0 where there is none",
        );
        visitor.optional(
            has.bridge,
            &mut self.bridge_normal,
            &["bridge_normal"],
            "N",
            "force of the bridge on i along the normal, negative pulls",
        );
        visitor.optional(
            has.bridge,
            &mut self.bridge_shear,
            &["bridge_shear_x", "bridge_shear_y", "bridge_shear_z"],
            "N",
            "viscous force of the bridge on i in the tangent plane",
        );
        visitor.optional(
            has.adhesion,
            &mut self.adhesion,
            &ADHESION,
            "N",
            "force of dry cohesion on i along the normal, negative pulls",
        );
        let history = has.history.iter().enumerate().map(|(k, column)| {
            ColumnSpec::new(format!("h{k}"), ColumnKind::F64, column.unit.as_str())
                .described(column.description.as_str())
        });
        visitor.numbers(&mut self.history, &history.collect::<Vec<_>>());
    }

    fn layout(schema: &FrameSchema) -> Result<ContactColumns, String> {
        let history = |k: usize| {
            let place = schema.index_of(&format!("h{k}"))?;
            let spec = &schema.columns()[place];
            Some(HistoryColumn {
                unit: spec.unit.clone(),
                description: spec.description.clone().unwrap_or_default(),
            })
        };
        Ok(ContactColumns {
            torque: schema.index_of(TORQUE[0]).is_some(),
            bridge: schema.index_of(BRIDGE_VOLUME[0]).is_some(),
            adhesion: schema.index_of(ADHESION[0]).is_some(),
            membrane: schema.index_of(MEMBRANE[0]).is_some(),
            history: (0..).map_while(history).collect(),
        })
    }

    fn check(&self, _: &ContactColumns) -> Result<(), String> {
        self.without_partner().map_or(Ok(()), Err)
    }
}

/// Writes `<prefix>.contacts.arrow`.
pub type ContactWriter = TableWriter<ContactFrame>;

/// Reads `<prefix>.contacts.arrow`.
pub type ContactReader = TableReader<ContactFrame>;

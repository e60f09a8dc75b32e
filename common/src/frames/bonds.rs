//! The table of bonds: one row per bond of two particles or of a particle and a wall.

use glam::DVec3;

use super::header::list;
use super::{ColumnVisitor, FrameSchema, Table, TableReader, TableWriter};

/// Bonds at one instant; all lists have one entry per row.
///
/// A bond is of particle `i` with *either* particle `j` *or* wall `wall`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BondFrame {
    /// Time, in s.
    pub time: f64,
    /// Number of time steps made.
    pub step: u64,
    /// Id of the particle that force and couple act on.
    pub i: Vec<u32>,
    /// Id of the other particle.
    pub j: Vec<Option<u32>>,
    /// Index of the wall, see [`FramesHeader::walls`](super::FramesHeader::walls).
    pub wall: Vec<Option<u32>>,
    /// Index of the entry of `[[bonds]]` in the scene, see [`BondNames`].
    pub bond: Vec<u32>,
    /// Force on i, in N; the other end gets the opposite.
    pub force: Vec<DVec3>,
    /// Couple on i about the middle of the bond, in N m.
    pub couple: Vec<DVec3>,
    /// Largest tensile stress of the section, in Pa, as the tensile strength limits it.
    pub tension: Vec<f64>,
    /// Largest shear stress of the section, in Pa, as the shear strength limits it.
    pub shear: Vec<f64>,
    /// Middle of the bond, in m, beside particle i where the domain is periodic.
    pub middle: Vec<DVec3>,
    /// Vector along the bond, in m: from its other end to the centre of i.
    pub branch: Vec<DVec3>,
}

/// Names of the entries of `[[bonds]]` by their index, metadata `bond.0`, `bond.1`, ...
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct BondNames(pub Vec<String>);

impl BondNames {
    /// The names in the metadata of a file; none in files of other tables.
    pub fn of(schema: &FrameSchema) -> Self {
        Self(list(schema.metadata(), "bond"))
    }
}

impl BondFrame {
    /// The number of bonds.
    pub fn len(&self) -> usize {
        self.i.len()
    }

    /// Whether there are no bonds.
    pub fn is_empty(&self) -> bool {
        self.i.is_empty()
    }

    /// Both ends of bond `row`, in m: the centre of particle i, and the centre of j or the point on the wall.
    pub fn ends(&self, row: usize) -> [DVec3; 2] {
        let half = 0.5 * self.branch[row];
        [self.middle[row] + half, self.middle[row] - half]
    }
}

impl Table for BondFrame {
    const KIND: &'static str = "bonds";
    type Layout = BondNames;

    fn moment(&mut self) -> (&mut f64, &mut u64) {
        (&mut self.time, &mut self.step)
    }

    fn columns(&mut self, _: &BondNames, visitor: &mut impl ColumnVisitor) {
        let i = "id of the particle that force and couple act on";
        let j = "id of the other particle, null at a wall";
        let wall = "index of the wall, null between particles";
        let bond = "index of the entry of [[bonds]] in the scene";
        let couple = "couple on i about the middle of the bond";
        let tension = "largest tensile stress, N/A + |M| r/I";
        let shear = "largest shear stress, |V|/A + |M_t| r/J";
        let branch = "from the other end to the centre of i";
        visitor.column(&mut self.i, &["i"], "1", i);
        visitor.column(&mut self.j, &["j"], "1", j);
        visitor.column(&mut self.wall, &["wall"], "1", wall);
        visitor.column(&mut self.bond, &["bond"], "1", bond);
        visitor.column(&mut self.force, &["fx", "fy", "fz"], "N", "force on i");
        visitor.column(&mut self.couple, &["tx", "ty", "tz"], "N m", couple);
        visitor.column(&mut self.tension, &["tension"], "Pa", tension);
        visitor.column(&mut self.shear, &["shear"], "Pa", shear);
        let middle = "middle of the bond";
        visitor.column(&mut self.middle, &["px", "py", "pz"], "m", middle);
        visitor.column(&mut self.branch, &["bx", "by", "bz"], "m", branch);
    }

    fn layout(schema: &FrameSchema) -> Result<BondNames, String> {
        Ok(BondNames::of(schema))
    }

    fn metadata(names: &BondNames) -> Vec<(String, String)> {
        let names = names.0.iter().enumerate();
        names
            .map(|(k, name)| (format!("bond.{k}"), name.clone()))
            .collect()
    }

    fn check(&self, _: &BondNames) -> Result<(), String> {
        let mut partners = self.j.iter().zip(&self.wall);
        match partners.position(|(j, wall)| j.is_some() == wall.is_some()) {
            Some(row) => Err(format!(
                "bond {row} must have either a particle j or a wall"
            )),
            None => Ok(()),
        }
    }
}

/// Writes `<prefix>.bonds.arrow`.
pub type BondWriter = TableWriter<BondFrame>;

/// Reads `<prefix>.bonds.arrow`.
pub type BondReader = TableReader<BondFrame>;

#[cfg(test)]
mod tests {
    use super::super::{FrameSchema, FrameWriter, FramesHeader};
    use super::*;

    /// Rows whose last one is a bond to wall 0.
    fn frame(step: u64, rows: u32) -> BondFrame {
        let vectors = |scale: f64| {
            let vector = |k: u32| DVec3::new(0.1, -0.2, 0.3) * (scale + f64::from(k));
            (0..rows).map(vector).collect()
        };
        let last = |k: u32| k + 1 == rows;
        BondFrame {
            time: 0.1 * step as f64,
            step,
            i: (0..rows).collect(),
            j: (0..rows).map(|k| (!last(k)).then_some(k + 1)).collect(),
            wall: (0..rows).map(|k| last(k).then_some(0)).collect(),
            bond: (0..rows).map(|k| k % 2).collect(),
            force: vectors(1.0),
            couple: vectors(1e-3),
            tension: (0..rows).map(|k| 1e6 / f64::from(k + 3)).collect(),
            shear: vec![1.0 / 3.0; rows as usize],
            middle: vectors(2.0),
            branch: vectors(0.5),
        }
    }

    #[test]
    fn bonds_read_back_exactly_with_their_names_and_without_rows_too() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.bonds.arrow");
        let header = FramesHeader {
            walls: vec!["plate".to_owned()],
            ..FramesHeader::default()
        };
        let names = BondNames(vec!["glue".to_owned(), "mortar".to_owned()]);
        let mut writer = BondWriter::create(&path, &header, &names).unwrap();
        for (step, rows) in [(1, 3), (2, 0), (3, 1)] {
            writer.append(frame(step, rows)).unwrap();
        }
        drop(writer);
        let mut writer = BondWriter::resume(&path, &header, &names, 2).unwrap();
        writer.append(frame(4, 5)).unwrap();
        let reader = BondReader::open(&path).unwrap();
        assert_eq!(reader.layout(), &names);
        assert_eq!(reader.header().walls, header.walls);
        assert_eq!(reader.frames().len(), 3);
        for (k, (step, rows)) in [(1, 3), (2, 0), (4, 5)].into_iter().enumerate() {
            assert_eq!(reader.frame(k).unwrap(), frame(step, rows));
        }
    }

    #[test]
    fn ends_lie_half_a_branch_from_the_middle() {
        let bonds = BondFrame {
            middle: vec![DVec3::new(1.0, 2.0, 3.0)],
            branch: vec![DVec3::new(0.0, 0.0, -4.0)],
            ..BondFrame::default()
        };
        let ends = [DVec3::new(1.0, 2.0, 1.0), DVec3::new(1.0, 2.0, 5.0)];
        assert_eq!(bonds.ends(0), ends);
    }

    #[test]
    fn bonds_without_exactly_one_partner_and_other_tables_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.bonds.arrow");
        let names = BondNames::default();
        let mut writer = BondWriter::create(&path, &FramesHeader::default(), &names).unwrap();
        for (j, wall) in [(None, None), (Some(1), Some(0))] {
            let mut wrong = frame(1, 3);
            (wrong.j[1], wrong.wall[1]) = (j, wall);
            let error = writer.append(wrong).unwrap_err().to_string();
            let expected = "bond 1 must have either a particle j or a wall";
            assert!(error.contains(expected), "{error}");
        }
        let mut short = frame(1, 3);
        short.tension.pop();
        assert!(writer.append(short).is_err());
        // A file of another program may hold such rows.
        let schema = FrameSchema::new("bonds", BondFrame::specs(&names)).unwrap();
        let mut wrong = frame(1, 3);
        wrong.j[2] = Some(0);
        let mut writer = FrameWriter::create(&path, schema).unwrap();
        writer.append(&wrong.into_frame()).unwrap();
        let reader = BondReader::open(&path).unwrap();
        let error = reader.frame(0).unwrap_err();
        let expected = "frame 0: bond 2 must have either a particle j or a wall";
        assert_eq!(error.found, expected);

        let schema = FrameSchema::new("contacts", BondFrame::specs(&names)).unwrap();
        FrameWriter::create(&path, schema).unwrap();
        let error = BondReader::open(&path).unwrap_err();
        assert_eq!(error.found, "frames of contacts");
        assert_eq!(error.expected, "frames of bonds");
        let mut specs = BondFrame::specs(&names);
        specs.retain(|spec| spec.name != "bx");
        FrameWriter::create(&path, FrameSchema::new("bonds", specs).unwrap()).unwrap();
        let error = BondReader::open(&path).unwrap_err();
        assert_eq!(error.found, "no column `bx`");
        assert_eq!(error.expected, "a table of bonds");
    }
}

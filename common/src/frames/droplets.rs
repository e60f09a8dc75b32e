//! The table of droplets in flight: one row per droplet, by ascending id.

use glam::DVec3;

use super::{ColumnVisitor, Table, TableReader, TableWriter};

/// Droplets in flight; all lists have one entry per row.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DropletFrame {
    /// Time, in s.
    pub time: f64,
    /// Number of time steps made.
    pub step: u64,
    /// Counts from 0 in the order in which droplets left, and again from 0 behind 2^32 - 1.
    pub id: Vec<u32>,
    /// Index of the spray.
    pub spray: Vec<u32>,
    /// Centre, in m.
    pub position: Vec<DVec3>,
    /// In m/s.
    pub velocity: Vec<DVec3>,
    /// In m.
    pub radius: Vec<f64>,
}

impl Table for DropletFrame {
    const KIND: &'static str = "droplets";
    type Layout = ();

    fn moment(&mut self) -> (&mut f64, &mut u64) {
        (&mut self.time, &mut self.step)
    }

    fn columns(&mut self, (): &(), visitor: &mut impl ColumnVisitor) {
        let id = "number of the droplet, in the order in which they left";
        visitor.column(&mut self.id, &["id"], "1", id);
        visitor.column(&mut self.spray, &["spray"], "1", "index of the spray");
        visitor.column(&mut self.position, &["x", "y", "z"], "m", "centre");
        visitor.column(&mut self.velocity, &["vx", "vy", "vz"], "m/s", "velocity");
        visitor.column(&mut self.radius, &["radius"], "m", "radius");
    }
}

/// Writes `<prefix>.droplets.arrow`.
pub type DropletWriter = TableWriter<DropletFrame>;

/// Reads `<prefix>.droplets.arrow`.
pub type DropletReader = TableReader<DropletFrame>;

#[cfg(test)]
mod tests {
    use super::super::FramesHeader;
    use super::*;

    #[test]
    fn droplets_read_back_exactly_and_without_rows_too() {
        let frame = |step: u64, rows: u32| DropletFrame {
            time: 0.25 * step as f64,
            step,
            id: (0..rows).map(|k| 7 + 3 * k).collect(),
            spray: vec![1; rows as usize],
            position: vec![DVec3::new(0.1, -0.2, 0.3); rows as usize],
            velocity: vec![DVec3::new(0.0, 1.0 / 3.0, -1e-9); rows as usize],
            radius: vec![1e-4; rows as usize],
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.droplets.arrow");
        let mut writer = DropletWriter::create(&path, &FramesHeader::default(), &()).unwrap();
        for (step, rows) in [(1, 3), (2, 0), (3, 1)] {
            writer.append(frame(step, rows)).unwrap();
        }
        let reader = DropletReader::open(&path).unwrap();
        assert_eq!(reader.frames().len(), 3);
        for (k, (step, rows)) in [(1, 3), (2, 0), (3, 1)].into_iter().enumerate() {
            assert_eq!(reader.frame(k).unwrap(), frame(step, rows));
        }
    }
}

//! `.fstat`: the contacts of each saved time.
//!
//! A frame is three lines that start with `#` (time and marker; domain; smallest and largest radius) and one line of
//! 16 columns per side of a contact. See `docs/formats/fstat.md`.

mod reader;
#[cfg(test)]
mod tests;
mod writer;

use glam::DVec3;

pub use reader::FstatReader;
pub use writer::write_frame;

/// The contacts at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct FstatFrame {
    /// Time in s.
    pub time: f64,
    /// True if the file holds contact points (marker 1). Files of very old versions have the marker 0
    /// and another point in these columns: take the contact point from the particle then.
    pub has_contact_points: bool,
    /// Lower corner of the domain in m.
    pub min: DVec3,
    /// Upper corner of the domain in m.
    pub max: DVec3,
    /// Smallest radius in m; NaN without particles.
    pub radius_min: f64,
    /// Largest radius in m; NaN without particles.
    pub radius_max: f64,
    /// One entry per line: two per contact of particles, one per contact with a wall.
    pub contacts: Vec<ContactRow>,
}

/// One side of a contact: the particle `i` as touched by `j`.
///
/// A contact of two particles makes two rows, `(i, j)` and `(j, i)`, that differ in the sign of
/// `normal` and `tangent`; the row of a fixed particle is left out. A contact with a wall makes one row,
/// and **its normal and tangent have the other sign**: they point from the particle into the wall.
/// [`force`](Self::force) takes account of this.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ContactRow {
    /// Time in s, repeated from the frame.
    pub time: f64,
    /// Index of the particle in the `.data` frame of this time.
    pub i: i64,
    /// Index of the other particle, or `-k-1` for wall `k`.
    pub j: i64,
    /// Contact point in m.
    pub contact_point: DVec3,
    /// Overlap in m; negative for a liquid bridge over a gap.
    pub overlap: f64,
    /// Tangential overlap in m. MercuryDPM writes minus the length of the sliding spring for linear
    /// friction, and the sum of its components for Mindlin's.
    pub tangential_overlap: f64,
    /// Force along the normal in N, positive if it pushes apart; includes adhesion.
    pub normal_force: f64,
    /// Magnitude of the tangential force in N.
    pub tangential_force: f64,
    /// Unit normal: from `j` to `i` for two particles, from `i` into the wall for a wall.
    pub normal: DVec3,
    /// Unit vector of the tangential force on `i`, or zero; negated for a wall.
    pub tangent: DVec3,
}

impl ContactRow {
    /// The index of the wall, if `j` is one.
    #[must_use]
    pub fn wall(&self) -> Option<i64> {
        // -(j + 1) cannot overflow, -j - 1 can.
        (self.j < 0).then(|| -(self.j + 1))
    }

    /// The value of `j` that stands for a wall.
    #[must_use]
    pub fn j_of_wall(wall: u32) -> i64 {
        -i64::from(wall) - 1
    }

    /// The force on particle `i` in N, in the global frame.
    #[must_use]
    pub fn force(&self) -> DVec3 {
        let along = self.normal_force * self.normal + self.tangential_force * self.tangent;
        if self.j < 0 { -along } else { along }
    }
}

/// The names of the columns, as messages use them.
const COLUMNS: [&str; 16] = [
    "time",
    "i",
    "j",
    "contact point x",
    "contact point y",
    "contact point z",
    "overlap",
    "tangential overlap",
    "normal force",
    "tangential force",
    "normal x",
    "normal y",
    "normal z",
    "tangent x",
    "tangent y",
    "tangent z",
];

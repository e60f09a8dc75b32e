//! The cell: the box in which a simulation takes place, and everything that follows from its periodic axes.
//!
//! [`Cell`] alone computes how places, branch vectors and velocities change from one periodic image to another. All that need
//! this are lent the cell of the present state and compute nothing by themselves.

pub mod image;
#[cfg(test)]
mod tests;

use glam::DVec3;

use crate::state::Plain;
pub use image::{NO_SHIFT, opposite};

/// A box with edges along x, y and z, at rest, and which of its axes are periodic.
///
/// Along the other axes its faces are those of the domain: what is beyond them has left it. The default has no extent.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cell {
    low: DVec3,
    high: DVec3,
    size: DVec3,
    periodic: [bool; 3],
    /// Displacements of the neighbouring images, by their codes, m.
    shifts: [DVec3; image::NEIGHBOURS as usize],
}

impl Cell {
    /// A cell with these corners (m).
    #[must_use]
    pub fn new(low: DVec3, high: DVec3, periodic: [bool; 3]) -> Self {
        let size = high - low;
        let mut shifts = [DVec3::ZERO; image::NEIGHBOURS as usize];
        for (code, shift) in (0..).zip(&mut shifts) {
            *shift = image::periods(code) * size;
        }
        Self {
            low,
            high,
            size,
            periodic,
            shifts,
        }
    }

    /// The cell with the same corners and these periodic axes.
    #[must_use]
    pub fn with_periodic(&self, periodic: [bool; 3]) -> Self {
        Self { periodic, ..*self }
    }

    /// Lower corner, m.
    #[inline]
    #[must_use]
    pub fn low(&self) -> DVec3 {
        self.low
    }

    /// Upper corner, m.
    #[inline]
    #[must_use]
    pub fn high(&self) -> DVec3 {
        self.high
    }

    /// Lower and upper corner, m.
    #[inline]
    #[must_use]
    pub fn corners(&self) -> (DVec3, DVec3) {
        (self.low, self.high)
    }

    /// Lower corner, and the sum of it and the edges, m: positions are [wrapped](Self::wrap) from there on. Rounding may make it
    /// differ from the upper corner in the last digit.
    #[inline]
    #[must_use]
    pub fn faces(&self) -> (DVec3, DVec3) {
        (self.low, self.low + self.size)
    }

    /// Middle, m.
    #[inline]
    #[must_use]
    pub fn middle(&self) -> DVec3 {
        self.low + 0.5 * self.size
    }

    /// Lengths of the edges, m.
    #[inline]
    #[must_use]
    pub fn size(&self) -> DVec3 {
        self.size
    }

    /// Length of the diagonal, m.
    #[inline]
    #[must_use]
    pub fn diagonal(&self) -> f64 {
        self.size.length()
    }

    /// Whether x, y and z are periodic.
    #[inline]
    #[must_use]
    pub fn periodic(&self) -> [bool; 3] {
        self.periodic
    }

    /// Whether this axis is periodic.
    #[inline]
    #[must_use]
    pub fn is_periodic(&self, axis: usize) -> bool {
        self.periodic[axis]
    }

    /// Whether any axis is periodic.
    #[inline]
    #[must_use]
    pub fn has_images(&self) -> bool {
        self.periodic.contains(&true)
    }

    /// Codes of all neighbouring images that the periodic axes allow, without the original.
    pub fn images(&self) -> impl Iterator<Item = u32> + '_ {
        (0..image::NEIGHBOURS).filter(|&code| {
            let periods = image::periods(code);
            code != NO_SHIFT && (0..3).all(|axis| periods[axis] == 0.0 || self.periodic[axis])
        })
    }

    /// Displacement of the neighbouring image with this code, m.
    #[inline(always)]
    #[must_use]
    pub fn shift(&self, code: u32) -> DVec3 {
        self.shifts[code as usize]
    }

    /// Displacement of the image with this code, which may be farther than neighbours, m.
    #[inline]
    #[must_use]
    pub fn any_shift(&self, code: u32) -> DVec3 {
        match self.shifts.get(code as usize) {
            Some(&shift) => shift,
            None => image::periods(code) * self.size,
        }
    }

    /// Place in the cell in units of its edges: 0 at the lower face of each axis, 1 at the upper one.
    #[inline]
    #[must_use]
    pub fn fractional(&self, position: DVec3) -> DVec3 {
        (position - self.low) / self.size
    }

    /// Whole periods along `axis` next to a way (m) along it.
    #[inline]
    #[must_use]
    pub fn whole_periods(&self, axis: usize, way: f64) -> f64 {
        (way / self.size[axis]).round()
    }

    /// Shortest branch vector (m) between two particles among those of all their images, and the relative velocity (m/s) of these
    /// images: that of the originals, as the cell is at rest.
    #[inline]
    #[must_use]
    pub fn min_image(&self, mut branch: DVec3, velocity: DVec3) -> (DVec3, DVec3) {
        for axis in 0..3 {
            if self.periodic[axis] {
                let periods = self.whole_periods(axis, branch[axis]);
                // A zero keeps its sign.
                if periods != 0.0 {
                    branch[axis] -= periods * self.size[axis];
                }
            }
        }
        (branch, velocity)
    }

    /// Position inside the periodic faces that is the same place, m. The upper face is the lower one.
    #[must_use]
    pub fn wrap(&self, position: DVec3) -> DVec3 {
        let mut wrapped = position;
        for axis in 0..3 {
            if self.periodic[axis] {
                let (low, size) = (self.low[axis], self.size[axis]);
                let mut x = position[axis];
                if x < low || x >= low + size {
                    x -= ((x - low) / size).floor() * size;
                    // Round-off may leave a position slightly above the upper face, which is the lower one.
                    if x >= low + size || x < low {
                        x = low;
                    }
                }
                wrapped[axis] = x;
            }
        }
        wrapped
    }

    /// Whether a position (m) is inside the faces, or on them, along all axes that are not periodic.
    #[must_use]
    pub fn holds(&self, position: DVec3) -> bool {
        let from_corner = position - self.low;
        (0..3).all(|axis| {
            self.periodic[axis]
                || (from_corner[axis] >= 0.0 && from_corner[axis] <= self.size[axis])
        })
    }

    /// Distance to the nearest face, periodic or not, m; negative outside.
    #[must_use]
    pub fn distance_to_faces(&self, position: DVec3) -> f64 {
        let from_corner = position - self.low;
        (0..3)
            .map(|axis| from_corner[axis].min(self.size[axis] - from_corner[axis]))
            .fold(f64::INFINITY, f64::min)
    }
}

impl Plain for Cell {
    fn put(&self, bytes: &mut Vec<u8>) {
        (self.low, self.high).put(bytes);
        self.periodic.put(bytes);
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        let (low, high) = Plain::take(bytes)?;
        Ok(Self::new(low, high, Plain::take(bytes)?))
    }
}

//! How far beyond contact pairs are listed.

use crate::state::Particle;

/// The distance beyond contact at which a pair is listed: the skin, and as far as forces between the two materials reach.
///
/// Each particle has half the skin and half the largest range of its material with any other, so that a pair is listed at its own range at least, and
/// pairs of materials without forces across a gap at the skin alone.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Margin {
    /// The skin, m.
    pub skin: f64,
    /// Largest range of the forces of each material with any other, m. Materials that are left out have none.
    pub ranges: Vec<f64>,
}

impl Margin {
    /// Without forces across gaps.
    #[must_use]
    pub fn of_skin(skin: f64) -> Self {
        let ranges = Vec::new();
        Self { skin, ranges }
    }

    /// Beyond contact with walls, m: the skin and the whole range.
    #[must_use]
    pub fn to_walls(&self, record: &Particle) -> f64 {
        let range = self.ranges.get(record.material.index());
        self.skin + range.copied().unwrap_or_default()
    }

    /// The share of a particle, m.
    #[must_use]
    pub fn share(&self, record: &Particle) -> f64 {
        0.5 * self.to_walls(record)
    }

    /// The largest that [`Margin::to_walls`] can be, m.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.skin + self.ranges.iter().copied().fold(0.0, f64::max)
    }
}

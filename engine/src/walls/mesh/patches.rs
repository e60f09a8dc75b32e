//! Patches: facets that hang together and hardly bend, so that of their points only the nearest counts.

use glam::DVec3;

use super::facet::Facet;
use super::topology::Topology;

/// Normals of a patch differ from that of its first facet by at most this, degrees: contacts on one patch differ by less than
/// half of [`super::SMOOTH_ANGLE`], so they would be merged.
const BEND: f64 = 1.5;

/// No patch, or no known side of one.
pub(super) const NO_GROUP: u32 = u32::MAX;

/// Patch that a facet belongs to, and the sides on which the facet may be left out for a nearer one of its patch.
///
/// It may on a side from which no point of the rim of the patch can be a contact. Seen from the inside of a bend that is not sharper
/// than a right angle no point of the bend is nearest: the faces beside it are. At other rims a contact may point in any direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Membership(u32);

impl Membership {
    /// In no patch.
    pub(super) const NONE: Self = Self(!(Self::SIDES[0] | Self::SIDES[1]));
    /// The facet is turned over against the first one of its patch.
    const TURNED: u32 = 1;
    /// It may be left out in front, where its normal points, or behind.
    const SIDES: [u32; 2] = [2, 4];
    const NUMBER: u32 = 3;

    fn same_patch(self, other: Self) -> bool {
        self.0 >> Self::NUMBER == other.0 >> Self::NUMBER
    }

    fn turned(self) -> bool {
        self.0 & Self::TURNED != 0
    }
}

/// Sets [`Facet::patch`] of all facets.
pub(super) fn find_patches(facets: &mut [Facet], topology: &Topology, corners: usize) {
    let straight = libm::cos(BEND.to_radians());
    let mut border = Vec::new();
    for first in 0..facets.len() {
        if facets[first].patch != Membership::NONE {
            continue;
        }
        let number = (first as u32) << Membership::NUMBER;
        let upright = facets[first].normal;
        facets[first].patch = Membership(number);
        border.push(first);
        while let Some(from) = border.pop() {
            for (k, edge) in facets[from].edges.into_iter().enumerate() {
                let Some(to) = topology.across(edge, from as u32) else {
                    continue;
                };
                let facet = &facets[to as usize];
                if facet.patch != Membership::NONE {
                    continue;
                }
                let ends = [facets[from].vertices[k], facets[from].vertices[(k + 1) % 3]];
                let turned = facets[from].patch.turned() ^ facet.runs(ends);
                let sign = if turned { -1.0 } else { 1.0 };
                if sign * facet.normal.dot(upright) >= straight {
                    facets[to as usize].patch = Membership(number | u32::from(turned));
                    border.push(to as usize);
                }
            }
        }
    }
    let quiet = quiet_corners(facets, topology, corners);
    for facet in facets {
        for (side, bit) in Membership::SIDES.into_iter().enumerate() {
            let mut around = facet.vertices.iter();
            if around.all(|&corner| quiet[corner as usize][side]) {
                facet.patch.0 |= bit;
            }
        }
    }
}

/// Corners at which, seen from in front or from behind, no edge between patches bends outwards or sharply.
fn quiet_corners(facets: &[Facet], topology: &Topology, corners: usize) -> Vec<[bool; 2]> {
    let mut quiet: Vec<[bool; 2]> = (0..corners)
        .map(|corner| [!topology.is_on_rim(corner as u32); 2])
        .collect();
    let mut normals = vec![DVec3::ZERO; corners];
    for (index, facet) in facets.iter().enumerate() {
        for (k, &edge) in facet.edges.iter().enumerate() {
            normals[facet.vertices[k] as usize] += facet.normal;
            let Some(other) = topology.across(edge, index as u32) else {
                continue;
            };
            let other = &facets[other as usize];
            let ends = [facet.vertices[k], facet.vertices[(k + 1) % 3]];
            let seen = if other.runs(ends) {
                // The two have opposite fronts. Within a patch that is known, elsewhere it is left alone.
                [facet.patch.same_patch(other.patch); 2]
            } else if facet.patch.same_patch(other.patch) {
                continue;
            } else {
                let opposite = (0..3).find(|&k| !ends.contains(&other.vertices[k]));
                let rise = opposite.map_or(0.0, |k| facet.height(other.corners[k]));
                [rise > 0.0, rise < 0.0]
            };
            for end in ends {
                for (known, seen) in quiet[end as usize].iter_mut().zip(seen) {
                    *known &= seen;
                }
            }
        }
    }
    // No two normals at a corner differ by more than a right angle if all are within half of one from their sum.
    for facet in facets {
        for &corner in &facet.vertices {
            let sum = normals[corner as usize];
            if facet.normal.dot(sum) < std::f64::consts::FRAC_1_SQRT_2 * sum.length() {
                quiet[corner as usize] = [false; 2];
            }
        }
    }
    quiet
}

impl Membership {
    /// The patch and the side of it on which a place is that has this `height` (m) over the facet, as one number; [`NO_GROUP`] if
    /// the facet may not be left out there, or if a place whose height differs by no more than `margin` (m) may be on the other side.
    #[inline]
    pub(super) fn group(self, height: f64, margin: f64) -> u32 {
        let behind = height < 0.0;
        if self.0 & Self::SIDES[usize::from(behind)] == 0 || height.abs() <= margin {
            return NO_GROUP;
        }
        let side = u32::from(self.turned() ^ behind);
        (self.0 >> Self::NUMBER) << 1 | side
    }
}

#[cfg(test)]
impl super::Mesh {
    /// This mesh without patches: every facet counts by itself.
    pub(crate) fn without_patches(&self) -> Self {
        let mut new = self.clone();
        for facet in &mut new.facets {
            facet.patch = Membership(0);
        }
        new
    }
}

/// The distance to the nearest point of each patch that was met, m.
#[derive(Debug, Clone, Default)]
pub(super) struct Best {
    groups: Vec<(u32, f64)>,
}

impl Best {
    pub(super) fn clear(&mut self) {
        self.groups.clear();
    }

    /// Notes a point of a group.
    #[inline]
    pub(super) fn note(&mut self, group: u32, distance: f64) {
        if group == NO_GROUP {
            return;
        }
        match self.groups.iter_mut().find(|known| known.0 == group) {
            Some(known) => known.1 = known.1.min(distance),
            None => self.groups.push((group, distance)),
        }
    }

    /// Whether a point at `distance` is farther than another one of its group.
    #[inline]
    pub(super) fn beats(&self, group: u32, distance: f64) -> bool {
        let mut known = self.groups.iter();
        group != NO_GROUP && known.any(|known| known.0 == group && known.1 < distance)
    }
}

//! From nearest points to contacts: which of them are local minima of the distance, and which minima are one contact.

use glam::DVec3;

use super::super::touch::{Touch, Touches, Turning};
use super::facet::{Facet, FacetPart, Nearest};
use super::near::Near;
use super::patches::NO_GROUP;
use super::{Mesh, SMOOTH_ANGLE, Scratch};

/// Part of the distance within which a point is taken to lie on a triangle.
const THIN: f64 = 1e-6;
/// Part of the distance by which that triangle must come nearer, above round-off.
const NEARER: f64 = 1e-10;

/// A local minimum of the distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Minimum {
    /// Negative behind a surface that acts on one side.
    distance: f64,
    normal: DVec3,
    feature: u32,
    /// Whether it is the nearest of its smooth region.
    leads: bool,
    /// Whether it was visited while a smooth region was followed.
    visited: bool,
}

/// The nearest point of a facet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    nearest: Nearest,
    facet: u32,
    feature: u32,
    /// Patch and side; [`NO_GROUP`] if a facet at the rim of a patch, or of none, has the feature too.
    group: u32,
}

impl Mesh {
    /// Finds the local minima of the distance from `centre` below `reach` (m) among the facets `near`, of each patch the
    /// nearest only. `scratch.bounds` holds lower bounds of the squares of their distances. Which of them are tested, and in
    /// which order, changes nothing in the result.
    pub(super) fn collect(&self, near: Near<'_>, centre: DVec3, reach: f64, scratch: &mut Scratch) {
        let Scratch {
            minima,
            best,
            found,
            bounds,
            nearest: last,
            ..
        } = scratch;
        *last = u32::MAX;
        minima.clear();
        best.clear();
        found.clear();
        let mut nearest_of_all: Option<(Nearest, u32, u32)> = None;
        // The facet that seems nearest goes first: it saves the others of its patch from being tested.
        let mut first = (0, f32::INFINITY);
        for (k, &bound) in bounds.iter().enumerate() {
            if bound < first.1 {
                first = (k, bound);
            }
        }
        let others = (0..bounds.len()).filter(|&k| k != first.0);
        for k in std::iter::once(first.0).chain(others) {
            if bounds
                .get(k)
                .is_none_or(|&square| f64::from(square) >= reach * reach)
            {
                continue;
            }
            let bound = f64::from(bounds[k]).sqrt();
            let (index, group) = near.facet(k);
            if best.beats(group, bound) {
                continue;
            }
            // An entry that fills a pack up is no facet; it seems far, but for spheres so fast that single precision does not
            // hold their way.
            if index >= self.facets.len() {
                continue;
            }
            let facet = self.facet(index);
            let Some(nearest) = facet.nearest(centre, reach) else {
                continue;
            };
            let group = facet.patch.group(facet.height(centre), 0.0);
            if best.beats(group, nearest.distance) {
                continue;
            }
            best.note(group, nearest.distance);
            let index = index as u32;
            let feature = self.feature(index, nearest.part);
            if nearest_of_all.is_none_or(|(other, _, theirs)| {
                (nearest.distance, feature) < (other.distance, theirs)
            }) {
                nearest_of_all = Some((nearest, index, feature));
            }
            let known = |other: &Found| other.feature == feature && nearest.part != FacetPart::Face;
            match found.iter_mut().find(|other| known(other)) {
                Some(other) if group == NO_GROUP => other.group = NO_GROUP,
                Some(_) => {}
                None => found.push(Found {
                    nearest,
                    facet: index,
                    feature,
                    group,
                }),
            }
        }
        for point in found.iter() {
            let nearest = &point.nearest;
            if best.beats(point.group, nearest.distance) || !self.is_minimum(nearest, centre) {
                continue;
            }
            let facet = &self.facet(point.facet as usize);
            let minimum = self.minimum(nearest, facet, point.feature, centre);
            // From behind only the nearest of all acts.
            if !(self.front_only && minimum.distance < 0.0) {
                minima.push(minimum);
            }
        }
        // It is a minimum whatever the round-off; for a surface that acts on one side it shows on which side the centre is.
        if let Some((nearest, facet, feature)) = nearest_of_all {
            *last = facet;
            let facet = &self.facet(facet as usize);
            let minimum = self.minimum(&nearest, facet, feature, centre);
            let known = |other: &Minimum| other.distance <= nearest.distance + self.round_off;
            if minimum.distance < 0.0 || !minima.iter().any(known) {
                minima.push(minimum);
            }
        }
        if minima.len() > 1 {
            minima.retain(|minimum| {
                minimum.feature < self.facets.len() as u32
                    || !self.lies_on_nearer(near, minimum, centre)
            });
        }
    }

    /// The minimum at a nearest point; with a negative distance behind a surface that acts on one side.
    #[inline]
    fn minimum(&self, nearest: &Nearest, facet: &Facet, feature: u32, centre: DVec3) -> Minimum {
        let outward = centre - nearest.point;
        let back = outward.dot(facet.normal) < 0.0;
        let mut minimum = Minimum {
            distance: nearest.distance,
            normal: match nearest.part {
                FacetPart::Face if back => -facet.normal,
                FacetPart::Face => facet.normal,
                _ if nearest.distance > 0.0 => outward / nearest.distance,
                _ => facet.normal,
            },
            feature,
            leads: true,
            visited: false,
        };
        if self.front_only && self.is_behind(nearest, outward, facet.normal) {
            minimum.distance = -minimum.distance;
            minimum.normal = -minimum.normal;
        }
        minimum
    }

    /// How the normal of a minimum turns when the centre moves.
    fn turning(&self, minimum: &Minimum) -> Turning {
        let (faces, edges) = (self.facets.len(), self.topology.edge_count());
        let feature = minimum.feature as usize;
        if feature < faces || minimum.distance == 0.0 {
            return Turning::NONE;
        }
        let rate = 1.0 / minimum.distance;
        if feature < faces + edges {
            let [start, end] =
                (self.topology.ends((feature - faces) as u32)).map(|k| self.vertices[k as usize]);
            return Turning {
                along: (end - start).normalize(),
                rates: [0.0, rate],
            };
        }
        Turning {
            along: minimum.normal.any_orthonormal_vector(),
            rates: [rate; 2],
        }
    }

    /// Faces come first, then edges, then corners.
    pub(super) fn feature(&self, facet: u32, part: FacetPart) -> u32 {
        let faces = self.facets.len() as u32;
        match part {
            FacetPart::Face => facet,
            FacetPart::Edge(edge) => faces + edge,
            FacetPart::Corner(corner) => faces + self.topology.edge_count() as u32 + corner,
        }
    }

    /// The point of a feature that is nearest to `centre`.
    pub(super) fn nearest_of(&self, feature: u32, centre: DVec3) -> DVec3 {
        let (faces, edges) = (self.facets.len(), self.topology.edge_count());
        let feature = feature as usize;
        if feature < faces {
            let facet = self.facet(feature);
            let nearest = facet.nearest(centre, f64::INFINITY);
            nearest.map_or(facet.corners[0], |nearest| nearest.point)
        } else if feature < faces + edges {
            let ends = self.topology.ends((feature - faces) as u32);
            let [start, end] = ends.map(|k| self.vertices[k as usize]);
            let along = end - start;
            let t = (centre - start).dot(along) / along.length_squared();
            start + along * t.clamp(0.0, 1.0)
        } else {
            self.vertices[feature - faces - edges]
        }
    }

    /// Whether no triangle that shares the edge or corner comes nearer there. The triangles are convex, so it is enough that
    /// nothing begins to come nearer.
    #[inline]
    fn is_minimum(&self, nearest: &Nearest, centre: DVec3) -> bool {
        let outward = centre - nearest.point;
        let rises = |to: u32| {
            let along = self.vertices[to as usize] - nearest.point;
            let nearer = outward.dot(along);
            // Round-off of the corners and the centre must not make two triangles each leave a contact on their common edge to the
            // other. Contacts that are taken twice are merged.
            nearer <= 0.0 || nearer <= self.round_off * (along.length() + nearest.distance)
        };
        match nearest.part {
            FacetPart::Face => true,
            FacetPart::Edge(edge) => {
                let around = self.topology.triangles_at(edge).iter();
                around.copied().all(|(_, opposite)| rises(opposite))
            }
            FacetPart::Corner(corner) => {
                let around = self.topology.neighbours(corner).iter();
                around.copied().all(rises)
            }
        }
    }

    /// Whether the point of an edge or corner lies on another triangle that comes nearer: where triangles meet without sharing
    /// corners, or across triangles too thin to tell.
    fn lies_on_nearer(&self, near: Near<'_>, minimum: &Minimum, centre: DVec3) -> bool {
        let point = centre - minimum.normal * minimum.distance;
        let distance = minimum.distance.abs();
        let same = self.precision.tolerance.max(THIN * distance);
        near.facets().any(|other| {
            let facet = self.facet(other);
            (point - facet.corners[0]).dot(facet.normal).abs() <= same
                && facet
                    .nearest(point, 2.0 * same)
                    .is_some_and(|foot| foot.distance <= same)
                && facet.nearest(centre, distance * (1.0 - NEARER)).is_some()
        })
    }

    /// Whether the centre is behind the surface. A rim has no back.
    fn is_behind(&self, nearest: &Nearest, outward: DVec3, normal: DVec3) -> bool {
        match nearest.part {
            FacetPart::Face => outward.dot(normal) < 0.0,
            FacetPart::Edge(edge) => {
                !self.topology.is_rim(edge) && outward.dot(self.topology.edge_normal(edge)) < 0.0
            }
            FacetPart::Corner(corner) => {
                !self.topology.is_on_rim(corner)
                    && outward.dot(self.topology.corner_normal(corner)) < 0.0
            }
        }
    }

    /// Appends one touch for each smooth region among the minima: minima are linked if the angle between their normals is below
    /// [`SMOOTH_ANGLE`], and of those that hang together the nearest stands for all.
    pub(super) fn merge(&self, minima: &mut [Minimum], out: &mut Touches) {
        if minima.len() > 1 {
            minima.sort_unstable_by(|a, b| {
                a.distance
                    .total_cmp(&b.distance)
                    .then(a.feature.cmp(&b.feature))
            });
            let linked = libm::cos(SMOOTH_ANGLE.to_radians());
            let leaders = if self.keeps_all { 0 } else { minima.len() };
            for leader in 0..leaders {
                if !minima[leader].leads {
                    continue;
                }
                // Follow the region from its nearest minimum.
                let mut from = Some(leader);
                while let Some(k) = from {
                    minima[k].visited = true;
                    let normal = minima[k].normal;
                    for other in &mut minima[leader + 1..] {
                        if other.leads && other.normal.dot(normal) > linked {
                            other.leads = false;
                        }
                    }
                    from = minima
                        .iter()
                        .position(|other| !other.leads && !other.visited);
                }
            }
        }
        for minimum in minima.iter().filter(|minimum| minimum.leads) {
            out.push(Touch {
                distance: minimum.distance,
                normal: minimum.normal,
                feature: self.continuation.known_as(minimum.feature),
                curvature: [0.0; 2],
                turning: self.turning(minimum),
            });
        }
    }
}

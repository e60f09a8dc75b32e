//! One triangle, and the point of it that is nearest to a sphere's centre.

use glam::DVec3;

use super::patches::Membership;

/// A triangle, prepared for queries. On large meshes memory is what they wait for: all that a query needs lies in two cache lines.
#[derive(Debug, Clone, PartialEq)]
#[repr(align(64))]
pub(super) struct Facet {
    /// Corners, m.
    pub corners: [DVec3; 3],
    /// Unit normal; the corners turn counter-clockwise about it.
    pub normal: DVec3,
    /// Indices of the corners.
    pub vertices: [u32; 3],
    /// Edges: from the first corner to the second, from there to the third, and back.
    pub edges: [u32; 3],
    /// Patch of which it is a part.
    pub patch: Membership,
    /// How far its normal is from that of its corners, for slivers whose own is not exact; rounded up.
    pub skew: f32,
}

/// Part of a triangle that is nearest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FacetPart {
    Face,
    /// Edge, by its index in the mesh.
    Edge(u32),
    /// Corner, by its index in the mesh.
    Corner(u32),
}

/// The nearest point of a triangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nearest {
    pub distance: f64,
    pub point: DVec3,
    pub part: FacetPart,
}

impl Facet {
    pub(super) fn new(vertices: &[DVec3], indices: [u32; 3], edges: [u32; 3]) -> Self {
        let corners = indices.map(|k| vertices[k as usize]);
        let [a, b, c] = corners;
        Self {
            corners,
            normal: (b - a).cross(c - a).normalize(),
            vertices: indices,
            edges,
            patch: Membership::NONE,
            skew: 0.0,
        }
    }

    /// The normal of its corners.
    pub(super) fn own_normal(&self) -> DVec3 {
        if self.skew == 0.0 {
            return self.normal;
        }
        let [a, b, c] = self.corners;
        (b - a).cross(c - a).normalize()
    }

    /// Takes another normal, for slivers whose own is not exact.
    pub(super) fn set_normal(&mut self, normal: DVec3) {
        self.skew = (1.0 + 1e-6) * normal.distance(self.normal) as f32;
        self.normal = normal;
    }

    /// Area, m^2.
    pub(super) fn area(&self) -> f64 {
        let [a, b, c] = self.corners;
        0.5 * (b - a).cross(c - a).length()
    }

    /// Whether its corners are passed in the sense from the first to the second end of one of its edges.
    pub(super) fn runs(&self, ends: [u32; 2]) -> bool {
        (0..3).any(|k| [self.vertices[k], self.vertices[(k + 1) % 3]] == ends)
    }

    /// Distance from the plane, m; negative behind it.
    #[inline]
    pub(super) fn height(&self, x: DVec3) -> f64 {
        (x - self.corners[0]).dot(self.normal)
    }

    /// The nearest point to `centre` if it is closer than `reach` (m).
    #[inline]
    pub(super) fn nearest(&self, centre: DVec3, reach: f64) -> Option<Nearest> {
        let [a, b, c] = self.corners;
        if self.height(centre).abs() >= reach {
            return None;
        }
        // Twice the area of the triangle, and those that the foot spans with two sides, as seen along the normal. They must be normal
        // to the normal, or what is above a sliver would be taken for beside it.
        let (ab, ac) = (b - a, c - a);
        let across = self.normal.cross(centre - a);
        let area = ab.cross(ac).dot(self.normal);
        let (v, w) = (across.dot(ac), -across.dot(ab));
        if v >= 0.0 && w >= 0.0 && v + w <= area {
            // From the corners, not from the height: the normal of a sliver is less exact than its corners.
            let point = a + ab * (v / area) + ac * (w / area);
            let distance = centre.distance(point);
            return (distance < reach).then_some(Nearest {
                distance,
                point,
                part: FacetPart::Face,
            });
        }
        // The nearest point lies on an edge beyond whose line the centre is.
        let mut best: Option<Nearest> = None;
        for (k, beyond) in [w < 0.0, v + w > area, v < 0.0].into_iter().enumerate() {
            if !beyond {
                continue;
            }
            // Always from the lower index, so that both triangles of an edge find the same bits.
            let end_of = |k: usize| (self.vertices[k], self.corners[k]);
            let (one, other) = (end_of(k), end_of((k + 1) % 3));
            let ((from, start), (to, end)) = if one.0 < other.0 {
                (one, other)
            } else {
                (other, one)
            };
            let along = end - start;
            let t = (centre - start).dot(along) / along.length_squared();
            let (point, part) = if t <= 0.0 {
                (start, FacetPart::Corner(from))
            } else if t >= 1.0 {
                (end, FacetPart::Corner(to))
            } else {
                (start + along * t, FacetPart::Edge(self.edges[k]))
            };
            let distance = centre.distance_squared(point);
            if best.is_none_or(|best| distance < best.distance) {
                best = Some(Nearest {
                    distance,
                    point,
                    part,
                });
            }
        }
        let best = best?;
        (best.distance < reach * reach).then(|| Nearest {
            distance: best.distance.sqrt(),
            ..best
        })
    }
}

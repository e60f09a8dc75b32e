//! One triangle, and the point of it that is nearest to a sphere's centre.

use glam::DVec3;

/// A triangle, prepared for queries.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Facet {
    /// First corner, m.
    pub corner: DVec3,
    /// Unit normal; the corners turn counter-clockwise about it.
    pub normal: DVec3,
    /// `(x - corner) . dual` are the barycentric coordinates of x for the second and third corner, 1/m.
    pub dual: [DVec3; 2],
    /// Corners.
    pub vertices: [u32; 3],
    /// Edges: from the first corner to the second, from there to the third, and back.
    pub edges: [u32; 3],
}

/// Which part of a triangle is nearest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
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
    pub part: Part,
}

impl Facet {
    pub(super) fn new(vertices: &[DVec3], corners: [u32; 3], edges: [u32; 3]) -> Self {
        let [a, b, c] = corners.map(|k| vertices[k as usize]);
        let mut new = Self {
            corner: a,
            normal: (b - a).cross(c - a).normalize(),
            dual: [DVec3::ZERO; 2],
            vertices: corners,
            edges,
        };
        new.find_duals(vertices);
        new
    }

    /// Takes another normal, for slivers whose own is not exact.
    pub(super) fn set_normal(&mut self, normal: DVec3, vertices: &[DVec3]) {
        self.normal = normal;
        self.find_duals(vertices);
    }

    /// They must be normal to the normal, or what is above a sliver would be taken for beside it.
    fn find_duals(&mut self, vertices: &[DVec3]) {
        let [a, b, c] = self.vertices.map(|k| vertices[k as usize]);
        let (ab, ac) = (b - a, c - a);
        let twice_area = ab.cross(ac).dot(self.normal);
        self.dual = [
            ac.cross(self.normal) / twice_area,
            self.normal.cross(ab) / twice_area,
        ];
    }

    /// Barycentric coordinates of the foot of `x` for the second and third corner.
    #[inline]
    pub(super) fn barycentric(&self, x: DVec3) -> (f64, f64) {
        let from_corner = x - self.corner;
        (from_corner.dot(self.dual[0]), from_corner.dot(self.dual[1]))
    }

    /// The nearest point to `centre` if it is closer than `reach` (m).
    #[inline]
    pub(super) fn nearest(&self, vertices: &[DVec3], centre: DVec3, reach: f64) -> Option<Nearest> {
        let height = (centre - self.corner).dot(self.normal);
        if height.abs() >= reach {
            return None;
        }
        let (v, w) = self.barycentric(centre);
        if v >= 0.0 && w >= 0.0 && v + w <= 1.0 {
            // From the corners, not from the height: the normal of a sliver is less exact than its corners.
            let [b, c] = [1, 2].map(|k| vertices[self.vertices[k] as usize]);
            let point = self.corner + (b - self.corner) * v + (c - self.corner) * w;
            let distance = centre.distance(point);
            return (distance < reach).then_some(Nearest {
                distance,
                point,
                part: Part::Face,
            });
        }
        // The nearest point lies on an edge beyond whose line the centre is.
        let mut best: Option<Nearest> = None;
        for (k, beyond) in [w < 0.0, v + w > 1.0, v < 0.0].into_iter().enumerate() {
            if !beyond {
                continue;
            }
            // Always from the lower index, so that both triangles of an edge find the same bits.
            let (one, other) = (self.vertices[k], self.vertices[(k + 1) % 3]);
            let (from, to) = (one.min(other), one.max(other));
            let (start, end) = (vertices[from as usize], vertices[to as usize]);
            let along = end - start;
            let t = (centre - start).dot(along) / along.length_squared();
            let (point, part) = if t <= 0.0 {
                (start, Part::Corner(from))
            } else if t >= 1.0 {
                (end, Part::Corner(to))
            } else {
                (start + along * t, Part::Edge(self.edges[k]))
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

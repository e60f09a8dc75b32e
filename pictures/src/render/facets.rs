//! Triangles as the camera sees them.

use std::collections::BTreeMap;

use glam::DVec3;

use super::Look;
use super::bins::Rect;
use crate::camera::Lens;
use crate::colour::Colour;
use crate::frame::{Surface, is_place};

/// A triangle in the window.
#[derive(Debug, Clone)]
pub(super) struct Facet {
    /// Corners in samples from the middle of the window.
    corners: [(f64, f64); 3],
    /// Depth or, in perspective, distance of eye and target over distance of eye and point: linear in the window either
    /// way. Value at the first corner and its slopes.
    plane: (f64, f64, f64),
    /// Towards the eye.
    pub(super) normal: DVec3,
    pub(super) colour: Colour,
    pub(super) opacity: f64,
    /// The skin of something, not a thin sheet.
    pub(super) solid: bool,
    pub(super) rect: Rect,
}

impl Facet {
    fn new(
        places: [DVec3; 3],
        lens: &Lens,
        colour: Colour,
        opacity: f64,
        columns: usize,
        rows: usize,
    ) -> Option<Self> {
        let mut corners = [(0.0, 0.0); 3];
        let mut values = [0.0; 3];
        for (k, place) in places.into_iter().enumerate() {
            corners[k] = lens.project(place)?;
            values[k] = match lens.distance() {
                None => place.z,
                Some(distance) => distance / (distance + place.z),
            };
        }
        let [a, b, c] = corners;
        let (ux, uy, vx, vy) = (b.0 - a.0, b.1 - a.1, c.0 - a.0, c.1 - a.1);
        let twice = ux * vy - uy * vx;
        // Seen from the edge there is nothing to see.
        if !twice.is_finite() || twice.abs() < 1e-9 {
            return None;
        }
        let (du, dv) = (values[1] - values[0], values[2] - values[0]);
        let plane = (
            values[0],
            (du * vy - dv * uy) / twice,
            (dv * ux - du * vx) / twice,
        );
        let normal = (places[1] - places[0])
            .cross(places[2] - places[0])
            .try_normalize()?;
        let middle = (places[0] + places[1] + places[2]) / 3.0;
        let ray = match lens.distance() {
            None => DVec3::Z,
            Some(distance) => middle + DVec3::new(0.0, 0.0, distance),
        };
        let normal = if normal.dot(ray) > 0.0 {
            -normal
        } else {
            normal
        };
        let (half_x, half_y) = (0.5 * columns as f64, 0.5 * rows as f64);
        let low = (
            a.0.min(b.0).min(c.0) + half_x,
            a.1.min(b.1).min(c.1) + half_y,
        );
        let high = (
            a.0.max(b.0).max(c.0) + half_x,
            a.1.max(b.1).max(c.1) + half_y,
        );
        Some(Self {
            corners: if twice > 0.0 { [a, b, c] } else { [a, c, b] },
            plane,
            normal,
            colour,
            opacity,
            solid: false,
            rect: Rect::around(low, high, columns, rows)?,
        })
    }

    /// Whether the triangle owns the place (u, v) of the window. Of triangles that share an edge exactly one owns a place
    /// on it, so translucent surfaces have neither seams nor gaps.
    pub(super) fn owns(&self, u: f64, v: f64) -> bool {
        let [a, b, c] = self.corners;
        [(a, b), (b, c), (c, a)].into_iter().all(|(from, to)| {
            // The same arithmetic for both triangles at an edge: from its lesser to its greater end.
            let swapped = from > to;
            let (p, q) = if swapped { (to, from) } else { (from, to) };
            let side = (q.0 - p.0) * (v - p.1) - (q.1 - p.1) * (u - p.0);
            let side = if swapped { -side } else { side };
            side > 0.0 || (side == 0.0 && !swapped)
        })
    }

    /// Depth at the place (u, v) of the window.
    pub(super) fn depth(&self, distance: Option<f64>, u: f64, v: f64) -> f64 {
        let (value, du, dv) = self.plane;
        let value = value + du * (u - self.origin().0) + dv * (v - self.origin().1);
        match distance {
            None => value,
            Some(distance) => distance / value.max(1e-9) - distance,
        }
    }

    /// The corner that the plane counts from: the first, which turning the triangle round leaves in place.
    fn origin(&self) -> (f64, f64) {
        self.corners[0]
    }
}

/// The triangles of the surfaces that lie in the window, cut where they come too near to the eye.
pub(super) fn seen(
    surfaces: &[Surface],
    wall_colour: Colour,
    lens: &Lens,
    columns: usize,
    rows: usize,
) -> Vec<Facet> {
    let mut facets = Vec::new();
    for surface in surfaces {
        let colour = surface.colour.unwrap_or(wall_colour);
        let opacity = surface.opacity.clamp(0.0, 1.0);
        push(
            &surface.triangles,
            colour,
            opacity,
            lens,
            (columns, rows),
            &mut facets,
        );
    }
    facets
}

fn push(
    triangles: &[[DVec3; 3]],
    colour: Colour,
    opacity: f64,
    lens: &Lens,
    (columns, rows): (usize, usize),
    facets: &mut Vec<Facet>,
) {
    if opacity.is_nan() || opacity == 0.0 {
        return;
    }
    for triangle in triangles {
        if !triangle.iter().all(|corner| is_place(*corner)) {
            continue;
        }
        let places = triangle.map(|corner| lens.place(corner));
        let pieces = in_front(&places, lens);
        for k in 2..pieces.len() {
            let piece = [pieces[0], pieces[k - 1], pieces[k]];
            facets.extend(Facet::new(piece, lens, colour, opacity, columns, rows));
        }
    }
}

/// The triangles of the grains that lie in the window, with a colour for each grain.
pub(super) fn of_grains(look: &Look, lens: &Lens, columns: usize, rows: usize) -> Vec<Facet> {
    let mut facets = Vec::new();
    for (grain, colour) in look.frame.grains.iter().zip(&look.grain_colours) {
        let opacity = look.sphere_opacity.clamp(0.0, 1.0);
        push(
            &grain.triangles,
            *colour,
            opacity,
            lens,
            (columns, rows),
            &mut facets,
        );
    }
    for facet in &mut facets {
        facet.solid = true;
    }
    facets
}

/// The part of a triangle before the eye, a convex polygon (I. Sutherland and G. Hodgman, 1974).
fn in_front(places: &[DVec3; 3], lens: &Lens) -> Vec<DVec3> {
    let Some(distance) = lens.distance() else {
        return places.to_vec();
    };
    let near = 2.0 * lens.nearest() - distance;
    let mut kept = Vec::with_capacity(4);
    for (k, &to) in places.iter().enumerate() {
        let from = places[(k + 2) % 3];
        if (from.z < near) != (to.z < near) {
            kept.push(from + (to - from) * ((near - from.z) / (to.z - from.z)));
        }
        if to.z >= near {
            kept.push(to);
        }
    }
    kept
}

/// The edges of a surface that one wants to see: free ones, and those where it folds by more than [`Surface::FOLD`].
pub(crate) fn folded_edges(triangles: &[[DVec3; 3]]) -> Vec<[DVec3; 2]> {
    let key = |p: DVec3| p.to_array().map(|x| (x + 0.0).to_bits());
    // Normals of the triangles at each edge, which its ends name whichever way round it is walked.
    let mut edges: BTreeMap<_, ([DVec3; 2], Vec<DVec3>)> = BTreeMap::new();
    for [a, b, c] in triangles {
        let Some(normal) = (*b - *a).cross(*c - *a).try_normalize() else {
            continue;
        };
        for (from, to) in [(*a, *b), (*b, *c), (*c, *a)] {
            let (low, high) = (key(from).min(key(to)), key(from).max(key(to)));
            let entry = edges
                .entry((low, high))
                .or_insert_with(|| ([from, to], Vec::new()));
            entry.1.push(normal);
        }
    }
    let cosine = Surface::FOLD.to_radians().cos();
    edges
        .into_values()
        .filter(|(_, normals)| match normals.as_slice() {
            // Orientation does not count: surfaces are seen from both sides.
            [a, b] => a.dot(*b).abs() < cosine,
            _ => true,
        })
        .map(|(edge, _)| edge)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_shows_its_twelve_edges_and_no_diagonals() {
        let square = |o: DVec3, u: DVec3, v: DVec3| [[o, o + u, o + u + v], [o, o + u + v, o + v]];
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
        let o = DVec3::ZERO;
        let cube = [
            square(o, x, y),
            square(z, x, y),
            square(o, y, z),
            square(x, y, z),
            square(o, z, x),
            square(y, z, x),
        ]
        .concat();
        assert_eq!(folded_edges(&cube).len(), 12);
        assert_eq!(folded_edges(&square(o, x, y)).len(), 4, "free edges");
    }
}

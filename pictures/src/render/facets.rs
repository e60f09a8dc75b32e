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
            // Both triangles at an edge compute with the same numbers: from its lesser to its greater end.
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
        let opacity = look.opacity_of(grain);
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

/// Between the edges of a surface that are drawn there is so much space in the window as a mean, in widths of a line: where they lie closer, as on a
/// mesh of scanned stone or one seen at a slant, they would cover more than a tenth of it and make a dark band of it.
const SPACE_BETWEEN_EDGES: f64 = 10.0;

/// Part of a surface with this normal that the eye sees: 1 straight from before, 0 from its edge. In perspective that of the ray
/// in the middle.
pub(super) fn facing(lens: &Lens, normal: DVec3) -> f64 {
    let (x, y) = lens.direction(normal);
    (1.0 - x * x - y * y).max(0.0).sqrt()
}

/// The edges of a surface that one wants to see with lines of this width (m): free ones, and those where it folds by more than
/// [`Surface::FOLD`] beside a smooth patch that is large enough for its outline to be seen as one. `facing` is what the eye sees of a surface with a
/// normal, 0 to 1.
pub(super) fn folded_edges(
    triangles: &[[DVec3; 3]],
    line: f64,
    facing: impl Fn(DVec3) -> f64,
) -> Vec<[DVec3; 2]> {
    let key = |p: DVec3| p.to_array().map(|x| (x + 0.0).to_bits());
    // Triangles at each edge, which its ends name whichever way round it is walked.
    let mut edges: BTreeMap<_, ([DVec3; 2], Vec<usize>)> = BTreeMap::new();
    let mut normals = Vec::new();
    let mut areas = Vec::new();
    for [a, b, c] in triangles {
        let cross = (*b - *a).cross(*c - *a);
        let Some(normal) = cross.try_normalize() else {
            continue;
        };
        let number = normals.len();
        normals.push(normal);
        areas.push(0.5 * cross.length() * facing(normal));
        for (from, to) in [(*a, *b), (*b, *c), (*c, *a)] {
            let (low, high) = (key(from).min(key(to)), key(from).max(key(to)));
            let entry = edges
                .entry((low, high))
                .or_insert_with(|| ([from, to], Vec::new()));
            entry.1.push(number);
        }
    }
    let cosine = Surface::FOLD.to_radians().cos();
    // Orientation does not count: surfaces are seen from both sides.
    let is_smooth = |beside: &[usize]| match *beside {
        [a, b] => normals[a].dot(normals[b]).abs() >= cosine,
        _ => false,
    };
    let mut patches = Patches::new(areas.len());
    for (_, beside) in edges.values() {
        if is_smooth(beside) {
            patches.join(beside[0], beside[1]);
        }
    }
    // Of each patch its area as it is seen, and the length of the edges around and in it.
    let mut sizes = vec![(0.0, 0.0); areas.len()];
    for (number, area) in areas.iter().enumerate() {
        sizes[patches.of(number)].0 += area;
    }
    for ([from, to], beside) in edges.values() {
        if !is_smooth(beside) {
            for &number in beside {
                sizes[patches.of(number)].1 += from.distance(*to);
            }
        }
    }
    let mut is_wide = |number: usize| {
        let (area, length) = sizes[patches.of(number)];
        // Each edge is shared by two patches; so much lies between two of them in a long strip.
        2.0 * area >= SPACE_BETWEEN_EDGES * line * length
    };
    edges
        .into_values()
        .filter(|(_, beside)| match beside.as_slice() {
            [_] => true,
            beside => !is_smooth(beside) && beside.iter().any(|&number| is_wide(number)),
        })
        .map(|(edge, _)| edge)
        .collect()
}

/// Triangles that belong together (R. E. Tarjan, 1975, with halved paths).
struct Patches {
    /// A triangle of the same patch; of one in each patch itself.
    towards: Vec<usize>,
}

impl Patches {
    fn new(count: usize) -> Self {
        Self {
            towards: (0..count).collect(),
        }
    }

    /// The triangle that stands for the patch of this one.
    fn of(&mut self, mut number: usize) -> usize {
        while self.towards[number] != number {
            self.towards[number] = self.towards[self.towards[number]];
            number = self.towards[number];
        }
        number
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.of(a), self.of(b));
        self.towards[a.max(b)] = a.min(b);
    }
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
        assert_eq!(folded_edges(&cube, 0.01, |_| 1.0).len(), 12);
        assert_eq!(
            folded_edges(&square(o, x, y), 0.01, |_| 1.0).len(),
            4,
            "free edges"
        );
    }

    /// A plate of 1 m with a rim of 1 cm: the rim is thinner than the lines, but the plate beside it is not.
    #[test]
    fn a_thin_plate_keeps_its_outline() {
        let square = |o: DVec3, u: DVec3, v: DVec3| [[o, o + u, o + u + v], [o, o + u + v, o + v]];
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z * 0.01);
        let o = DVec3::ZERO;
        let plate = [
            square(o, x, y),
            square(z, x, y),
            square(o, y, z),
            square(x, y, z),
            square(o, z, x),
            square(y, z, x),
        ]
        .concat();
        // The four upright edges, 1 cm long, lie between parts of the rim alone.
        assert_eq!(folded_edges(&plate, 0.01, |_| 1.0).len(), 8);
    }

    /// A sheet of 40 x 40 pyramids whose sides fold by 90 degrees: seen from near, all edges are drawn, seen from far only its outline.
    #[test]
    fn a_bumpy_sheet_is_not_drawn_full_of_lines() {
        let mut sheet = Vec::new();
        for i in 0..40 {
            for j in 0..40 {
                let at = |x: f64, y: f64, z: f64| DVec3::new(f64::from(i) + x, f64::from(j) + y, z);
                let [a, b, c, d] = [
                    at(0.0, 0.0, 0.0),
                    at(1.0, 0.0, 0.0),
                    at(1.0, 1.0, 0.0),
                    at(0.0, 1.0, 0.0),
                ];
                let top = at(0.5, 0.5, 0.5);
                sheet.extend([[a, b, top], [b, c, top], [c, d, top], [d, a, top]]);
            }
        }
        let free = 4 * 40;
        let inner = 2 * 40 * 39 + 4 * 40 * 40;
        // A side of a pyramid has an area of sqrt(2)/4 and edges of 1 + sqrt(3) in all, so that there are 0.26 between them.
        assert_eq!(folded_edges(&sheet, 0.01, |_| 1.0).len(), free + inner);
        assert_eq!(folded_edges(&sheet, 0.1, |_| 1.0).len(), free);
        // At a slant they lie closer.
        assert_eq!(folded_edges(&sheet, 0.01, |_| 0.3).len(), free);
    }
}

//! Content of one picture: plain values in SI units.

use glam::DVec3;

use crate::colour::Colour;

/// Coordinates beyond this (m) are taken for errors: their squares would overflow.
pub(crate) const FARTHEST: f64 = 1e100;

/// One instant.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Frame {
    /// Heading; one line, shortened if it does not fit.
    pub title: String,
    /// Simulated time (s), where there is one.
    pub time: Option<f64>,
    /// Discs in the x-y plane, seen straight and drawn flat, instead of spheres in space.
    pub flat: bool,
    /// Gravity (m/s²); "up" is against it (z without gravity, y in two dimensions).
    pub gravity: DVec3,
    /// Lower and upper corner of the domain (m), drawn as a box; not drawn if not finite.
    pub domain: Option<(DVec3, DVec3)>,
    /// The particles. Those whose centre or radius is not finite or whose radius is not positive are left out and
    /// counted in the heading.
    pub spheres: Vec<Sphere>,
    /// Droplets in flight, drawn like the spheres, but no particles: they are counted apart, and decide neither the range of colours nor what is
    /// framed. Those without a value have a colour of their own.
    pub droplets: Vec<Sphere>,
    /// Particles of other shapes, drawn like the spheres.
    pub grains: Vec<Grain>,
    /// Mesh walls.
    pub surfaces: Vec<Surface>,
    /// Walls as lines, paths.
    pub lines: Vec<Line>,
    /// Contacts or bonds, drawn as lines whose width and colour show their strength.
    pub contacts: Vec<Contact>,
}

/// A sphere, or a disc in two dimensions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    /// Centre (m).
    pub centre: DVec3,
    /// Radius (m).
    pub radius: f64,
    /// Value that its colour shows, in the unit of [`crate::ColourBy`]; the number of a category, counted from 0. NaN: it has no
    /// value and is drawn grey.
    pub value: f64,
    /// Fixed and driven particles are drawn in a grey of their own.
    pub fixed: bool,
}

impl Sphere {
    /// Whether it can be drawn at all.
    pub(crate) fn is_drawable(&self) -> bool {
        is_place(self.centre) && self.radius > 0.0 && self.radius < FARTHEST
    }
}

/// A particle of any shape, given by its surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Grain {
    /// Corners of the triangles (m); those that are not finite are left out.
    pub triangles: Vec<[DVec3; 3]>,
    /// Value that its colour shows, as for a [`Sphere`].
    pub value: f64,
    /// Fixed and driven particles are drawn in a grey of their own.
    pub fixed: bool,
    /// Whether it is a part of a wall that is coloured by a value, and not counted as a particle.
    pub of_wall: bool,
}

impl Grain {
    /// A sphere about all that can be drawn of it: middle of its box and farthest corner; none if that is nothing.
    pub(crate) fn sphere(&self) -> Option<(DVec3, f64)> {
        let whole = |t: &&[DVec3; 3]| t.iter().all(|corner| is_place(*corner));
        let corners = || self.triangles.iter().filter(whole).flatten();
        let low = corners().copied().reduce(DVec3::min)?;
        let middle = 0.5 * (low + corners().copied().reduce(DVec3::max)?);
        let reach = corners().map(|corner| corner.distance(middle));
        Some((middle, reach.fold(0.0, f64::max)))
    }
}

/// A surface of triangles, seen from both sides.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// Corners of the triangles (m).
    pub triangles: Vec<[DVec3; 3]>,
    /// Its colour; the picture's own colour of walls where there is none.
    pub colour: Option<Colour>,
    /// 1: opaque; 0: invisible. Values between them are the opacity of the surface seen straight; a thin sheet hides more
    /// where it is seen at a slant.
    pub opacity: f64,
    /// Draws the edges between triangles that meet at more than [`Surface::FOLD`] degrees, where they do not lie so close that lines would hide the
    /// surface, and free edges.
    pub edges: bool,
}

/// Opacity of elastic sheets that are not coloured by a value.
pub const SHEET_OPACITY: f64 = 0.5;

impl Surface {
    /// Angle (degrees) between neighbouring triangles from which their edge is drawn.
    pub const FOLD: f64 = 25.0;

    /// A translucent wall with its edges.
    #[must_use]
    pub fn wall(triangles: Vec<[DVec3; 3]>) -> Self {
        Self {
            triangles,
            colour: None,
            opacity: 0.18,
            edges: true,
        }
    }
}

/// A line through points in space.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// The points (m).
    pub points: Vec<DVec3>,
    /// Its colour; the picture's own colour of walls where there is none.
    pub colour: Option<Colour>,
    /// Width in pixels of a picture of 1200 x 900; it grows with the picture.
    pub width: f64,
}

impl Line {
    /// The outline of a wall.
    #[must_use]
    pub fn wall(points: Vec<DVec3>) -> Self {
        Self {
            points,
            colour: None,
            width: 1.3,
        }
    }
}

/// A contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Centre of the first particle (m).
    pub from: DVec3,
    /// Centre of the other one, or the point on the wall (m).
    pub to: DVec3,
    /// Value that width and colour show, a force as a rule (N).
    pub strength: f64,
}

/// Whether a point can be drawn.
pub(crate) fn is_place(point: DVec3) -> bool {
    point.is_finite() && point.abs().max_element() < FARTHEST
}

/// Whether a line of this width (pixels) can be drawn.
pub(crate) fn is_width(width: f64) -> bool {
    width > 0.0 && width < 1e5
}

/// The direction against gravity (m/s²); without gravity z, or y in two dimensions.
#[must_use]
pub fn upwards(gravity: DVec3, flat: bool) -> DVec3 {
    let against = -gravity;
    // Scaled first: squares of tiny and huge numbers are no numbers.
    let scaled = against / against.abs().max_element();
    match (scaled.is_finite(), scaled.try_normalize()) {
        (true, Some(up)) => up,
        _ if flat => DVec3::Y,
        _ => DVec3::Z,
    }
}

impl Frame {
    /// The direction against gravity; without gravity z, or y in two dimensions.
    pub(crate) fn up(&self) -> DVec3 {
        upwards(self.gravity, self.flat)
    }

    /// The corners of the domain, numbered by bits: eight, or four in two dimensions; none without a finite extent.
    pub(crate) fn domain_corners(&self) -> Vec<DVec3> {
        let Some((low, mut high)) = self.domain else {
            return Vec::new();
        };
        if self.flat {
            high.z = low.z;
        }
        if !is_place(low) || !is_place(high) || low == high {
            return Vec::new();
        }
        let number = if self.flat { 4 } else { 8 };
        (0..number)
            .map(|corner: u32| {
                let pick = |bit: u32, low: f64, high: f64| {
                    if corner & (1 << bit) == 0 { low } else { high }
                };
                DVec3::new(
                    pick(0, low.x, high.x),
                    pick(1, low.y, high.y),
                    pick(2, low.z, high.z),
                )
            })
            .collect()
    }

    /// The edges of the domain.
    pub(crate) fn domain_edges(&self) -> Vec<[DVec3; 2]> {
        let corners = self.domain_corners();
        let mut edges = Vec::new();
        for (a, low) in corners.iter().enumerate() {
            // Corners that differ in one bit share an edge.
            for bit in 0..3 {
                if let (0, Some(high)) = (a & (1 << bit), corners.get(a | (1 << bit))) {
                    edges.push([*low, *high]);
                }
            }
        }
        edges
    }
}

//! The area of a wall over which a pressure acts.

use std::f64::consts::PI;

use glam::DVec3;

use super::{Shape, WallNow};

/// Planes within so much of parallel (sine of the angle) do not cut each other.
const PARALLEL: f64 = 1e-9;

/// The space that is looked at: lower and upper corner, m; in two dimensions of depth 1 along z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SectionBox {
    /// Lower corner, m.
    pub min: DVec3,
    /// Upper corner, m.
    pub max: DVec3,
    /// Whether there are two dimensions only.
    pub is_flat: bool,
}

impl SectionBox {
    /// A domain of 2 or 3 dimensions.
    #[must_use]
    pub fn new(mut min: DVec3, mut max: DVec3, dimensions: u8) -> Self {
        let is_flat = dimensions == 2;
        if is_flat {
            (min.z, max.z) = (-0.5, 0.5);
        }
        Self { min, max, is_flat }
    }
}

/// Whether the area of such a surface follows from its shape.
#[must_use]
pub fn has_area(shape: &Shape) -> bool {
    matches!(shape, Shape::Plane(_) | Shape::Disc(_))
}

/// The area of wall `index` where it stands now, as seen along `axis` (of length 1), m^2: of a disc all of it, of a plane the
/// part within the domain and in front of all other planes that are there. 0 for other shapes.
#[must_use]
pub fn area(walls: &[WallNow], index: usize, axis: DVec3, room: &SectionBox) -> f64 {
    let wall = &walls[index];
    match wall.shape() {
        Shape::Disc(disc) => {
            let (radius, normal) = (disc.radius(), wall.state.out_of_wall(disc.axis()));
            let whole = if room.is_flat {
                2.0 * radius
            } else {
                PI * radius * radius
            };
            whole * normal.dot(axis).abs()
        }
        Shape::Plane(_) => {
            let Some((point, normal)) = standing(wall) else {
                return 0.0;
            };
            let others = (walls.iter().enumerate())
                .filter(|(other, wall)| *other != index && wall.state.present)
                .filter_map(|(_, wall)| standing(wall));
            plane_area(point, normal, others, room) * normal.dot(axis).abs()
        }
        _ => 0.0,
    }
}

/// The area of a plane through `point` (m) within the room, m^2.
#[must_use]
pub fn plane_section(point: DVec3, normal: DVec3, room: &SectionBox) -> f64 {
    plane_area(point, normal, std::iter::empty(), room)
}

/// Point and normal of a plane where it stands.
fn standing(wall: &WallNow) -> Option<(DVec3, DVec3)> {
    let Shape::Plane(plane) = wall.shape() else {
        return None;
    };
    let pose = &wall.state.pose;
    Some((
        pose.to_global(plane.point()),
        pose.rotation * plane.normal(),
    ))
}

/// A plane cut by the faces of the domain and by other planes: a polygon that each cuts once (Sutherland & Hodgman 1974).
fn plane_area(
    point: DVec3,
    normal: DVec3,
    others: impl Iterator<Item = (DVec3, DVec3)>,
    room: &SectionBox,
) -> f64 {
    let size = room.max - room.min;
    let middle = room.min + 0.5 * size;
    let foot = middle - normal * (middle - point).dot(normal);
    let (u, v) = normal.any_orthonormal_pair();
    let reach = size.length();
    let mut polygon: Vec<DVec3> = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]
        .map(|(a, b)| foot + reach * (a * u + b * v))
        .to_vec();
    let faces = DVec3::AXES.into_iter();
    let faces = faces.flat_map(|axis| [(room.min, axis), (room.max, -axis)]);
    let mut cut = Vec::new();
    for (at, inwards) in faces.chain(others) {
        if inwards.cross(normal).length() < PARALLEL {
            continue;
        }
        let depth = |corner: DVec3| (corner - at).dot(inwards);
        cut.clear();
        for (index, &corner) in polygon.iter().enumerate() {
            let next = polygon[(index + 1) % polygon.len()];
            let (here, there) = (depth(corner), depth(next));
            if here >= 0.0 {
                cut.push(corner);
            }
            if (here >= 0.0) != (there >= 0.0) {
                cut.push(corner + (next - corner) * (here / (here - there)));
            }
        }
        std::mem::swap(&mut polygon, &mut cut);
    }
    let Some(&first) = polygon.first() else {
        return 0.0;
    };
    let corners = polygon.windows(2);
    let twice: DVec3 = corners
        .map(|pair| (pair[0] - first).cross(pair[1] - first))
        .sum();
    0.5 * twice.length()
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;

    const ROOM: SectionBox = SectionBox {
        min: DVec3::ZERO,
        max: DVec3::new(2.0, 3.0, 5.0),
        is_flat: false,
    };

    #[test]
    fn a_plane_ends_at_the_domain_and_at_other_planes() {
        let area = |point, normal: DVec3, others: &[(DVec3, DVec3)]| {
            plane_area(point, normal.normalize(), others.iter().copied(), &ROOM)
        };
        let lid = dvec3(0.0, 0.0, 4.0);
        // Everywhere 1e-12 is far above the round-off of some additions of numbers of about 1.
        assert!((area(lid, -DVec3::Z, &[]) - 6.0).abs() < 1e-12);
        // On the face of the domain and beyond it, too.
        assert!((area(dvec3(0.0, 0.0, 5.0), -DVec3::Z, &[]) - 6.0).abs() < 1e-12);
        assert!((area(dvec3(0.0, 0.0, 6.0), -DVec3::Z, &[]) - 6.0).abs() < 1e-12);
        let at = |x| (dvec3(x, 0.0, 0.0), -DVec3::X);
        let behind = (dvec3(0.0, 1.0, 0.0), DVec3::Y);
        assert!(
            (area(lid, -DVec3::Z, &[at(1.5), behind, (DVec3::ZERO, DVec3::Z)]) - 1.5 * 2.0).abs()
                < 1e-12
        );
        // A plane that leans by 45 degrees is longer by the square root of 2; one that is cut off whole has nothing left.
        let leaning = area(dvec3(0.0, 1.0, 0.0), dvec3(0.0, 1.0, 1.0), &[]);
        assert!((leaning - 2.0 * 2f64.sqrt()).abs() < 1e-12);
        assert_eq!(area(lid, -DVec3::Z, &[at(-1.0)]), 0.0);
    }

    #[test]
    fn in_two_dimensions_it_is_a_length() {
        let room = SectionBox::new(DVec3::ZERO, dvec3(2.0, 3.0, 77.0), 2);
        let lid = plane_area(dvec3(0.0, 2.0, 0.0), -DVec3::Y, std::iter::empty(), &room);
        assert!((lid - 2.0).abs() < 1e-12);
    }
}

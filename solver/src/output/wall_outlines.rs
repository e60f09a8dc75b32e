//! Walls as lines, for the picture of the final state.

use std::f64::consts::TAU;

use glam::DVec3;
use mercury_pictures::PictureWall;

use crate::walls::{Outline, WallNow};

/// Chords of a circle.
const CHORDS: u32 = 72;
/// Straight lines drawn along a surface of revolution.
const GENERATRICES: u32 = 8;

/// The walls that are present, where they stand: planes cut at the domain, circles and generatrices of curved ones.
#[must_use]
pub fn wall_outlines(walls: &[WallNow], domain: (DVec3, DVec3)) -> Vec<PictureWall> {
    let mut lines = Vec::new();
    for wall in walls {
        if wall.state.present {
            let pose = &wall.state.pose;
            // Planes and endless cylinders are cut at the domain as it lies in the wall's own frame.
            for line in outline(&wall.shape().outline(), domain, |x| pose.to_initial(x)) {
                let line: Vec<DVec3> = line.into_iter().map(|x| pose.to_global(x)).collect();
                if line.len() > 1 {
                    lines.push(PictureWall::Polyline(line));
                }
            }
        }
    }
    lines
}

/// Lines of one wall in its own frame.
fn outline(
    outline: &Outline,
    domain: (DVec3, DVec3),
    into_wall: impl Fn(DVec3) -> DVec3,
) -> Vec<Vec<DVec3>> {
    match outline {
        Outline::Plane { point, normal } => {
            let corners = corners(domain).map(&into_wall);
            vec![cut_plane(*point, *normal, &corners)]
        }
        Outline::Sphere { centre, radius } => [
            [DVec3::X, DVec3::Y],
            [DVec3::Y, DVec3::Z],
            [DVec3::Z, DVec3::X],
        ]
        .into_iter()
        .map(|across| circle(*centre, across, *radius))
        .collect(),
        Outline::Mesh { edges, .. } => edges.iter().map(|ends| ends.to_vec()).collect(),
        Outline::Turned {
            origin,
            direction,
            across,
            profile,
            endless,
        } => {
            let mut profile = profile.clone();
            if *endless {
                let along = corners(domain).map(|x| (into_wall(x) - *origin).dot(*direction));
                let radius = profile[0].x;
                profile = [f64::INFINITY, f64::NEG_INFINITY]
                    .into_iter()
                    .zip([f64::min as fn(f64, f64) -> f64, f64::max])
                    .map(|(start, pick)| {
                        glam::DVec2::new(radius, along.iter().copied().fold(start, pick))
                    })
                    .collect();
            }
            // A closed profile ends where it began.
            let again = |k: usize| k > 0 && profile[k] == profile[0];
            let mut lines: Vec<_> = (profile.iter().enumerate())
                .filter(|&(k, corner)| corner.x > 0.0 && !again(k))
                .map(|(_, corner)| circle(*origin + *direction * corner.y, *across, corner.x))
                .collect();
            for k in 0..GENERATRICES {
                let (sin, cos) = (TAU * f64::from(k) / f64::from(GENERATRICES)).sin_cos();
                let outward = across[0] * cos + across[1] * sin;
                let line = profile
                    .iter()
                    .map(|corner| *origin + outward * corner.x + *direction * corner.y);
                lines.push(line.collect());
            }
            lines
        }
    }
}

/// A closed circle in the plane of two unit vectors.
fn circle(centre: DVec3, across: [DVec3; 2], radius: f64) -> Vec<DVec3> {
    (0..=CHORDS)
        .map(|k| {
            let (sin, cos) = (TAU * f64::from(k % CHORDS) / f64::from(CHORDS)).sin_cos();
            centre + (across[0] * cos + across[1] * sin) * radius
        })
        .collect()
}

/// The corners of a box, numbered by bits.
fn corners((min, max): (DVec3, DVec3)) -> [DVec3; 8] {
    std::array::from_fn(|k| {
        DVec3::from_array(std::array::from_fn(|axis| {
            if k >> axis & 1 == 0 {
                min[axis]
            } else {
                max[axis]
            }
        }))
    })
}

/// The closed polygon in which a plane cuts a box; empty if it misses it.
fn cut_plane(point: DVec3, normal: DVec3, corners: &[DVec3; 8]) -> Vec<DVec3> {
    let centre = 0.5 * (corners[0] + corners[7]);
    let size = (corners[7] - corners[0]).length();
    if !(size.is_finite() && size > 0.0) {
        return Vec::new();
    }
    // A square of the plane that is larger than the box, cut by its six faces in turn. A face of the box that lies in the
    // plane must survive round-off.
    let slack = 1e-9 * size;
    let foot = centre - normal * (centre - point).dot(normal);
    let (u, v) = normal.any_orthonormal_pair();
    let mut polygon = vec![
        foot + (u + v) * size,
        foot + (u - v) * -size,
        foot - (u + v) * size,
        foot + (u - v) * size,
    ];
    for bit in 0..3 {
        let edge = corners[1 << bit] - corners[0];
        // A domain without thickness has no direction here: nothing to cut.
        let Some(direction) = edge.try_normalize() else {
            continue;
        };
        polygon = cut(&polygon, |x| (x - corners[0]).dot(direction) + slack);
        polygon = cut(&polygon, |x| (corners[7] - x).dot(direction) + slack);
    }
    polygon.extend(polygon.first().copied());
    polygon
}

/// The part of a convex polygon where `height` is not negative (I. Sutherland and G. Hodgman, 1974).
fn cut(polygon: &[DVec3], height: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (k, &to) in polygon.iter().enumerate() {
        let from = polygon[(k + polygon.len() - 1) % polygon.len()];
        let (a, b) = (height(from), height(to));
        if (a < 0.0) != (b < 0.0) {
            kept.push(from + (to - from) * (a / (a - b)));
        }
        if b >= 0.0 {
            kept.push(to);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::neighbours::Images;
    use crate::walls::{Cylinder, Motion, Plane, Shape, Side, Wall};

    fn lines(shape: Shape) -> Vec<Vec<DVec3>> {
        let wall = Wall {
            name: "wall".to_owned(),
            material: 0,
            shape,
            motion: Motion::new(Vec::new()).unwrap(),
            from: 0.0,
            until: f64::INFINITY,
            reference: DVec3::ZERO,
        };
        let domain = (DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0));
        let images = Images::new(domain.0, domain.1, [false; 3]);
        wall_outlines(&WallNow::all(&[wall], 1.0, &images), domain)
            .into_iter()
            .map(|PictureWall::Polyline(points)| points)
            .collect()
    }

    #[test]
    fn a_floor_is_the_face_of_the_domain() {
        let lines = lines(Shape::Plane(Plane::new(DVec3::ZERO, DVec3::Z).unwrap()));
        assert_eq!((lines.len(), lines[0].len()), (1, 5));
        for corner in [[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [0.0, 2.0]] {
            let corner = DVec3::new(corner[0], corner[1], 0.0);
            assert!(
                lines[0].iter().any(|x| (*x - corner).length() < 1e-7),
                "{lines:?}"
            );
        }
    }

    #[test]
    fn a_plane_beside_the_domain_is_not_seen() {
        assert!(lines(Shape::Plane(Plane::new(-DVec3::Z, DVec3::Z).unwrap())).is_empty());
    }

    #[test]
    fn an_endless_cylinder_ends_with_the_domain() {
        let cylinder = Cylinder::new(DVec3::Y, DVec3::X, 0.5, None, Side::Inside).unwrap();
        let lines = lines(Shape::Cylinder(cylinder));
        assert_eq!(lines.len(), 2 + GENERATRICES as usize);
        for point in lines.iter().flatten() {
            let radial = DVec3::new(point.x - 1.0, 0.0, point.z);
            assert!((radial.length() - 0.5).abs() < 1e-12);
            assert!((0.0..=2.0).contains(&point.y));
        }
    }
}

//! Meshes that span a period go on for ever.

use glam::DVec3;
use mercury_common::formats::mesh::TriangleMesh;
use mercury_common::random::Stream;
use mercury_common::surfaces::Surface;

use super::touches;
use crate::walls::{Mesh, Shape, Touches, WallError};

const LENGTH: f64 = 3.0;

/// A surface over the square from 0 to [`LENGTH`], the same at opposite sides: cells with shifted corners, `height` above each
/// corner by its indices modulo the number of cells.
fn square(cells: u32, height: impl Fn(u32, u32) -> f64) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    let count = cells as usize;
    let mut random = Stream::new(4, "cells", 0);
    let shifts: Vec<f64> = (0..count).map(|_| 0.3 * random.uniform()).collect();
    let along = |k: u32, other: u32| {
        let shift = shifts[(other % cells) as usize];
        let inside = k > 0 && k < cells;
        (f64::from(k) + if inside { shift } else { 0.0 }) * LENGTH / f64::from(cells)
    };
    for j in 0..=cells {
        for i in 0..=cells {
            let z = height(i % cells, j % cells);
            mesh.vertices.push(DVec3::new(along(i, j), along(j, i), z));
        }
    }
    for j in 0..cells {
        for i in 0..cells {
            let a = j * (cells + 1) + i;
            let (b, c, d) = (a + 1, a + cells + 2, a + cells + 1);
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

fn mesh(triangles: &TriangleMesh, front: bool) -> Result<Mesh, WallError> {
    Mesh::new(triangles, |x| x, front)
}

const BOTH: [(usize, f64, f64); 2] = [(0, 0.0, LENGTH), (1, 0.0, LENGTH)];

fn at(shape: &Mesh, centre: DVec3, radius: f64) -> Vec<(DVec3, u32)> {
    let mut out = Touches::new();
    shape.touches(centre, radius, &mut out);
    let mut found: Vec<(DVec3, u32)> = out
        .iter()
        .map(|touch| (touch.normal * touch.distance, touch.feature))
        .collect();
    found.sort_by(|a, b| a.0.to_array().partial_cmp(&b.0.to_array()).unwrap());
    found
}

/// Over hills and valleys a sphere feels at the faces of the period what it feels in the middle of a mesh of three periods, and
/// the query returns the same features a period farther on.
#[test]
fn a_period_is_as_good_as_three() {
    let mut random = Stream::new(9, "heights", 0);
    let heights: Vec<f64> = (0..36).map(|_| 0.5 * random.uniform()).collect();
    let height = |i: u32, j: u32| heights[(6 * j + i) as usize];
    for front in [false, true] {
        let one = mesh(&square(6, height), front).unwrap();
        let endless = one.continued(&BOTH, 1.0).unwrap();
        let mut soup = Vec::new();
        let triangles = square(6, height);
        for periods in 0..9 {
            let shift = DVec3::new(f64::from(periods % 3 - 1), f64::from(periods / 3 - 1), 0.0);
            for k in 0..triangles.triangles.len() {
                soup.push(triangles.corners(k).map(|x| x + shift * LENGTH));
            }
        }
        let three = mesh(&TriangleMesh::from_corners(&soup), front).unwrap();
        let mut several = 0;
        for _ in 0..3000 {
            let mut draw = || random.uniform();
            let face = draw() < 0.5;
            let mut centre = DVec3::new(LENGTH * draw(), LENGTH * draw(), 1.0 - 1.4 * draw());
            if face {
                centre.x = 0.6 * (draw() - 0.5);
            }
            let radius = 0.2 + 0.4 * draw();
            let found = at(&endless, centre, radius);
            let expected = at(&three, centre, radius);
            assert_eq!(found.len(), expected.len(), "{centre} {radius}");
            for (a, b) in found.iter().zip(&expected) {
                assert!(a.0.distance(b.0) < 1e-12, "{centre} {radius}");
            }
            several += usize::from(found.len() > 1);
            let farther = at(&endless, centre + LENGTH * DVec3::X, radius);
            if centre.x < 0.3 {
                let features =
                    |found: &[(DVec3, u32)]| found.iter().map(|f| f.1).collect::<Vec<_>>();
                assert_eq!(features(&found), features(&farther), "{centre} {radius}");
            }
        }
        assert!(several > 100, "{several}");
    }
}

/// A mesh of 1.7 periods is as good as one mesh of all its images: where these are one surface, where they lie one above the other, and
/// where they cross.
#[test]
fn a_long_mesh_is_met_with_its_images() {
    const ROOM: f64 = 1.0;
    let mut random = Stream::new(11, "long", 0);
    let heights: Vec<f64> = (0..100).map(|_| 0.5 * random.uniform()).collect();
    // Ten cells of which six are a period.
    let period = 0.6 * LENGTH;
    let same = |i: u32, j: u32| heights[(6 * (j % 6) + i % 6) as usize];
    let rough = |i: u32, j: u32| heights[(10 * j + i) as usize];
    for (triangles, shift) in [
        (regular(same), DVec3::ZERO),
        (regular(same), DVec3::new(-0.4, 5.3 * period, 0.0)),
        (regular(rough), DVec3::new(0.2, 0.0, 0.0)),
        (regular(|i, _| 0.13 * f64::from(i)), DVec3::ZERO),
    ] {
        let one = Mesh::new(&triangles, |x| x + shift, false).unwrap();
        let axes = [(0, 0.0, period), (1, 0.0, period)];
        let endless = one.continued(&axes, ROOM).unwrap();
        assert_eq!(endless.periods().len(), 2);
        assert_eq!(endless.len(), 200);
        assert_eq!(endless.areas(), one.areas());
        let mut soup = Vec::new();
        for x in -4..=4 {
            for y in -9..=4 {
                let images = shift + period * DVec3::new(f64::from(x), f64::from(y), 0.0);
                for k in 0..triangles.triangles.len() {
                    soup.push(triangles.corners(k).map(|x| x + images));
                }
            }
        }
        let all = mesh(&TriangleMesh::from_corners(&soup), false).unwrap();
        let mut met = 0;
        for _ in 0..2000 {
            let mut draw = || random.uniform();
            let centre = DVec3::new(period * draw(), period * draw(), 1.6 - 2.0 * draw());
            let radius = 0.1 + 0.3 * draw();
            let found = at(&endless, centre, radius);
            let expected = at(&all, centre, radius);
            assert_eq!(found.len(), expected.len(), "{centre} {radius}");
            for a in &found {
                // Not in order: corners in a row of the grid are equally far along it, but for round-off.
                let is_same = |b: &(DVec3, u32)| a.0.distance(b.0) < 1e-12;
                assert!(expected.iter().any(is_same), "{centre} {radius}");
                // A feature of the file that appears in a report.
                let mut of_file = Vec::new();
                endless.triangles_of(a.1, &mut of_file);
                assert!(!of_file.is_empty());
            }
            met += found.len();
        }
        assert!(met > 500, "{met}");
    }
}

/// A square of ten regular cells.
fn regular(height: impl Fn(u32, u32) -> f64) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for j in 0..=10u32 {
        for i in 0..=10u32 {
            let [x, y] = [i, j].map(|k| f64::from(k) * LENGTH / 10.0);
            let (i, j) = (i.min(9), j.min(9));
            mesh.vertices.push(DVec3::new(x, y, height(i, j)));
        }
    }
    for j in 0..10 {
        for i in 0..10 {
            let a = j * 11 + i;
            mesh.triangles
                .extend([[a, a + 1, a + 12], [a, a + 12, a + 11]]);
        }
    }
    mesh
}

/// The copies do not appear in reports on the mesh, and the seams are no rims.
#[test]
fn only_the_triangles_of_the_file_are_reported() {
    let triangles = square(6, |_, _| 0.0);
    let one = mesh(&triangles, false).unwrap();
    let endless = one.continued(&BOTH, 0.7).unwrap();
    assert_eq!(endless.len(), 72);
    assert_eq!(endless.bounds(), one.bounds());
    assert_eq!(endless.areas(), one.areas());
    let Surface::Mesh(drawn) = endless.outline() else {
        panic!("a mesh is drawn as one");
    };
    assert_eq!(drawn.triangles.len(), 72);
    // A torus of 72 triangles: 108 edges, each of two triangles, and 36 corners.
    assert_eq!(endless.edge_counts(), [0, 108, 0]);
    assert_eq!(one.edge_counts(), [24, 96, 0]);
    // One axis: a ring with two rims of 6 edges.
    let ring = one.continued(&BOTH[..1], 0.7).unwrap();
    assert_eq!(ring.edge_counts(), [12, 102, 0]);
    // The corner of both seams belongs to the triangles at all four corners of the square.
    let at_corner = |triangle: u32, corner: DVec3| {
        let corners = triangles.corners(triangle as usize);
        corners.iter().any(|x| x.distance(corner * LENGTH) < 1e-12)
    };
    let mut found = Vec::new();
    let around_corner = (0..1000).find(|&feature| {
        endless.triangles_of(feature, &mut found);
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X + DVec3::Y];
        let touches_file = |&corner: &DVec3| found.iter().any(|&k| at_corner(k, corner));
        corners.iter().all(touches_file)
    });
    assert!(around_corner.is_some());
    assert_eq!(found.len(), 6, "{found:?}");
}

/// Meshes that are shorter than the period, or far from the domain, are left as they are.
#[test]
fn other_meshes_stay_as_they_are() {
    let one = mesh(&square(6, |_, _| 0.0), false).unwrap();
    for other in [
        (0, 0.0, LENGTH * (1.0 + 3e-6)),
        (0, 1.1 * LENGTH, LENGTH),
        (2, 0.0, LENGTH),
    ] {
        assert!(one.continued(&[other], 0.7).is_none(), "{other:?}");
    }
    let shifted = one
        .continued(&[(0, 0.5 * LENGTH, LENGTH * (1.0 + 5e-7))], 0.7)
        .unwrap();
    let [period] = shifted.periods() else {
        panic!("one axis")
    };
    // Nothing is reduced within half a period.
    assert_eq!(period.reduced(0.49 * LENGTH), 0.49 * LENGTH);
    let reduced = period.reduced(-7.3 * LENGTH);
    assert!((reduced + 0.3 * LENGTH).abs() < 1e-5 * LENGTH, "{reduced}");
    assert_eq!(
        [-0.1, 0.1, 3.1].map(|x| period.into_base(x)),
        [1.0, 0.0, -1.0]
    );
}

/// A contact goes on across the seam in whatever period it is seen next.
#[test]
fn contacts_go_on_across_the_seam() {
    let one = mesh(&square(6, |_, _| 0.0), false).unwrap();
    let endless = one.continued(&BOTH, 0.7).unwrap();
    let touch = |x: f64| {
        let centre = DVec3::new(x, 1.3, 0.19);
        (
            touches(&Shape::Mesh(endless.clone().into()), centre, 0.2)[0],
            centre,
        )
    };
    let (before, _) = touch(LENGTH - 0.001);
    for x in [LENGTH + 0.001, 0.001] {
        let (after, centre) = touch(x);
        assert_ne!(after.feature, before.feature);
        let part = endless.continues(before.feature, &after, centre);
        assert!(part.is_some_and(|part| part < 0.01), "{part:?}");
    }
}

//! The own surfaces of rigid bodies as a grid.

use glam::DVec3;

use crate::formats::vtu::{VtuArray, VtuCells, VtuGrid};
use crate::frames::{BodyFrame, ClumpKind};

/// Bodies as the triangles of their clump's surface, at their size, where they stand and as they are turned. On every triangle: `body`
/// (the id), `clump`, `material`, `mass`, `speed`, `velocity` (of the centre of mass) and `angular_velocity`. Bodies whose clump has no surface
/// are left out.
#[must_use]
pub fn clumps(kinds: &[ClumpKind], frame: &BodyFrame) -> VtuGrid<'static> {
    let mut points: Vec<DVec3> = Vec::new();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    let mut row_of: Vec<usize> = Vec::new();
    for (row, &clump) in frame.clump.iter().enumerate() {
        let kind = kinds.get(clump as usize);
        let Some(mesh) = kind.and_then(|kind| kind.surface.as_ref()) else {
            continue;
        };
        let first = points.len() as u32;
        let (centre, turn, scale) = (
            frame.position[row],
            frame.orientation[row],
            frame.scale[row],
        );
        let placed = mesh
            .vertices
            .iter()
            .map(|&own| centre + turn * (own * scale));
        points.extend(placed);
        let moved = mesh.triangles.iter();
        triangles.extend(moved.map(|t| t.map(|corner| first + corner)));
        row_of.resize(triangles.len(), row);
    }
    let indices = |of: &[u32]| row_of.iter().map(|&row| of[row]).collect::<Vec<u32>>();
    let vectors = |of: &[DVec3]| row_of.iter().map(|&row| of[row]).collect::<Vec<DVec3>>();
    let numbers = |of: &dyn Fn(usize) -> f64| row_of.iter().map(|&row| of(row)).collect();
    let mass: Vec<f64> = numbers(&|row| frame.mass[row]);
    let speed: Vec<f64> = numbers(&|row| frame.velocity[row].length());
    let cell_data = vec![
        VtuArray::new("body", indices(&frame.id)),
        VtuArray::new("clump", indices(&frame.clump)),
        VtuArray::new("material", indices(&frame.material)),
        VtuArray::new("mass", mass),
        VtuArray::new("speed", speed),
        VtuArray::new("velocity", vectors(&frame.velocity)),
        VtuArray::new("angular_velocity", vectors(&frame.angular_velocity)),
    ];
    VtuGrid {
        time: Some(frame.time),
        points: points.into(),
        cells: VtuCells::Triangles(triangles.into()),
        point_data: Vec::new(),
        cell_data,
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use glam::DQuat;

    use super::*;
    use crate::formats::mesh::TriangleMesh;
    use crate::formats::vtu::VtuValues;

    #[test]
    fn a_body_stands_where_it_is_with_its_size_and_its_turn() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let kind = |surface| ClumpKind {
            name: "flake".to_owned(),
            surface,
        };
        let kinds = [
            kind(None),
            kind(Some(TriangleMesh::from_corners(&[corners]))),
        ];
        let frame = BodyFrame {
            id: vec![0, 3, 7],
            clump: vec![1, 0, 1],
            material: vec![0, 0, 2],
            mass: vec![1.0, 2.0, 3.0],
            scale: vec![1.0, 1.0, 2.0],
            position: vec![DVec3::ZERO, DVec3::ONE, DVec3::new(1.0, 2.0, 3.0)],
            velocity: vec![DVec3::ZERO, DVec3::ONE, DVec3::new(3.0, 0.0, 4.0)],
            orientation: vec![
                DQuat::IDENTITY,
                DQuat::IDENTITY,
                DQuat::from_rotation_z(FRAC_PI_2),
            ],
            angular_velocity: vec![DVec3::ZERO, DVec3::ZERO, DVec3::Z],
            ..BodyFrame::default()
        };
        let grid = clumps(&kinds, &frame);
        // A quarter turn about z brings x to y and y to -x; twice as large, from (1, 2, 3) on.
        let expected = [
            DVec3::ZERO,
            DVec3::X,
            DVec3::Y,
            DVec3::new(1.0, 2.0, 3.0),
            DVec3::new(1.0, 4.0, 3.0),
            DVec3::new(-1.0, 2.0, 3.0),
        ];
        for (found, expected) in grid.points.iter().zip(expected) {
            assert!(found.distance(expected) < 1e-15, "{found} {expected}");
        }
        assert!(matches!(&grid.cells, VtuCells::Triangles(t) if **t == [[0, 1, 2], [3, 4, 5]]));
        let cell = |name: &str| {
            let found = grid.cell_data.iter().find(|array| array.name == name);
            found.unwrap().values.clone()
        };
        assert!(matches!(cell("body"), VtuValues::U32(v) if *v == [0, 7]));
        assert!(matches!(cell("material"), VtuValues::U32(v) if *v == [0, 2]));
        assert!(matches!(cell("mass"), VtuValues::F64(v) if *v == [1.0, 3.0]));
        assert!(matches!(cell("speed"), VtuValues::F64(v) if *v == [0.0, 5.0]));
    }
}

//! Hinges: energies of bent sheets against those of a plate.

use glam::DVec3;

use super::*;

/// The angle of two equilateral triangles, one turned up by `angle` about their common edge.
fn folded(angle: f64) -> TriangleMesh {
    let height = 0.75_f64.sqrt();
    let (sin, cos) = libm::sincos(angle);
    TriangleMesh {
        vertices: vec![
            DVec3::ZERO,
            DVec3::X,
            DVec3::new(0.5, -height, 0.0),
            DVec3::new(0.5, height * cos, height * sin),
        ],
        triangles: vec![[0, 2, 1], [0, 1, 3]],
        ..TriangleMesh::default()
    }
}

#[test]
fn moment_of_one_hinge_is_that_of_the_formula() {
    let mut law = law(Elasticity::Springs);
    let stiffness = 0.3;
    law.bending = Some(Bending {
        stiffness,
        damping: 0.0,
        rests_flat: true,
    });
    let sheet = sheet(&folded(0.0), law);
    let still = [DVec3::ZERO; 4];
    for angle in [-2.5, -1.0, -1e-5, 1e-3, 0.4, 1.5, 3.0] {
        let positions = folded(angle).vertices;
        let (forces, _) = forces_of(&sheet, &positions, &still, 0.0);
        // dE/dtheta = 2 Ke e^2/(A1 + A2) sin(theta/2); on the free corner over its height, normal to its triangle.
        let moment = 2.0 * stiffness / (2.0 * 0.25 * 3.0_f64.sqrt()) * libm::sin(0.5 * angle);
        let size = moment.abs() / 0.75_f64.sqrt();
        assert!((forces[3].length() - size).abs() < 1e-9 * size, "{angle}");
        // The force flattens the hinge.
        assert!(forces[3].z * libm::cos(angle) * angle < 0.0, "{angle}");
        let energy = sheet.bending_energy(&positions);
        let expected =
            2.0 * stiffness / (0.5 * 3.0_f64.sqrt()) * 2.0 * (1.0 - libm::cos(0.5 * angle));
        // 1 - cos loses digits at small angles, where both are theta^2/8 of it.
        assert!(
            (energy - expected).abs() < 1e-9 * expected + 1e-16,
            "{angle}"
        );
    }
}

/// The angle of each hinge of a sheet bent into z = f(x, y) with small slopes: the jump of the slope along its normal.
#[test]
fn hinge_by_hinge_the_angle_is_the_jump_of_the_slope() {
    let mesh = lattice(6, 6);
    let law = plate(law(Elasticity::Springs));
    let sheet = sheet(&mesh, law);
    let k = 1e-6;
    let height = |x: f64, y: f64| 0.5 * k * x * x + 0.3 * k * x * y;
    let bent: Vec<DVec3> = (mesh.vertices.iter())
        .map(|x| DVec3::new(x.x, x.y, height(x.x, x.y)))
        .collect();
    let slope = |triangle: u32| {
        let [a, b, c] = mesh.triangles[triangle as usize].map(|k| bent[k as usize]);
        let normal = (b - a).cross(c - a);
        -normal.truncate() / normal.z
    };
    let mut expected = 0.0;
    for edge in sheet.topology().hinges() {
        let jump = (slope(edge.triangles[1]) - slope(edge.triangles[0])).length();
        expected += 0.5 * law.plate_stiffness() / (0.5 * 3.0_f64.sqrt()) * jump * jump;
    }
    let found = sheet.bending_energy(&bent);
    // Slopes are below 1e-5, their squares below 1e-10.
    assert!(
        (found - expected).abs() < 1e-9 * expected,
        "{found} {expected}"
    );
}

#[test]
fn rest_angles_of_the_shape_leave_it_free_of_moment() {
    let mut law = plate(law(Elasticity::Springs));
    law.bending = law.bending.map(|bending| Bending {
        rests_flat: false,
        ..bending
    });
    let mesh = super::super::sphere(DVec3::ZERO, 1.0, 0.3);
    let curved = sheet(&mesh, law);
    let still = vec![DVec3::ZERO; mesh.vertices.len()];
    let (forces, _) = forces_of(&curved, &mesh.vertices, &still, 0.0);
    assert!(forces.iter().all(|force| force.length() < 1e-15));
    assert!(curved.bending_energy(&mesh.vertices).abs() < 1e-20);
    law.bending = law.bending.map(|bending| Bending {
        rests_flat: true,
        ..bending
    });
    assert!(sheet(&mesh, law).bending_energy(&mesh.vertices) > 0.0);
}

//! Stiffnesses, energies and forces. Uniform strain and sums of forces are on the validation page (`tests/src/cases/sheets_alone.rs`).

use glam::DVec3;

use super::*;

/// The tension of an isotropic sheet under a small strain: E t/(1 - nu^2) [(1 - nu) e + nu tr(e) 1], by xx, yy, xy.
fn plane_stress(nu: f64, e: [f64; 3]) -> [f64; 3] {
    let [xx, yy, xy] = e;
    let factor = 1.0 / (1.0 - nu * nu);
    let trace = xx + yy;
    [
        factor * ((1.0 - nu) * xx + nu * trace),
        factor * ((1.0 - nu) * yy + nu * trace),
        factor * (1.0 - nu) * xy,
    ]
}

#[test]
fn springs_on_equilateral_triangles_scatter_by_nothing() {
    let sheet = sheet(&lattice(6, 8), law(Elasticity::Springs));
    let scatter = sheet.scatter().unwrap();
    assert!(scatter.worst < 1e-12, "{scatter:?}");
}

#[test]
fn springs_on_the_rim_have_half_the_stiffness() {
    let mesh = lattice(3, 3);
    let sheet = sheet(&mesh, law(Elasticity::Springs));
    let inner = sheet.topology().hinges().len();
    for (index, edge) in sheet.edges.iter().enumerate() {
        let full = 0.75_f64.sqrt();
        let expected = if index < inner { full } else { 0.5 * full };
        assert!((edge.stiffness - expected).abs() < 1e-12);
    }
}

fn skewed() -> TriangleMesh {
    let mut mesh = lattice(6, 6);
    let mut seed = 3;
    for vertex in &mut mesh.vertices {
        *vertex += 0.25 * DVec3::new(noise(&mut seed), noise(&mut seed), 0.0);
    }
    mesh
}

#[test]
fn springs_on_a_skewed_mesh_scatter() {
    let sheet = sheet(&skewed(), law(Elasticity::Springs));
    let scatter = sheet.scatter().unwrap();
    assert!(
        scatter.deviation > 0.1 && scatter.deviation < 0.25,
        "{scatter:?}"
    );
    assert!(scatter.worst > scatter.deviation);
}

#[test]
fn finite_stretch_follows_both_formulas() {
    let mesh = lattice(3, 3);
    let stretch = 0.2;
    let positions: Vec<DVec3> = mesh.vertices.iter().map(|&x| x * (1.0 + stretch)).collect();
    let springs = sheet(&mesh, law(Elasticity::Springs)).seen(&positions);
    let expected = 1.5 * stretch / (1.0 + stretch);
    assert!((springs.tension.0[0] - expected).abs() < 1e-12);
    let nu = 0.4;
    let continuum = sheet(&mesh, law(Elasticity::Continuum { poisson_ratio: nu })).seen(&positions);
    let expected = (stretch + 0.5 * stretch * stretch) / (1.0 - nu);
    assert!((continuum.tension.0[0] - expected).abs() < 1e-12);
    assert!((continuum.largest_stretch - 1.0 - stretch).abs() < 1e-12);
}

/// The law of St. Venant and Kirchhoff by the deformation gradient F of a triangle in its plane, against that by the metric.
#[test]
fn any_deformation_of_a_triangle_agrees_with_the_deformation_gradient() {
    let mut seed = 17;
    for nu in [-0.5, 0.1, 0.45] {
        for _ in 0..50 {
            let flat = noisy(
                &[DVec3::ZERO, DVec3::X, DVec3::new(0.4, 0.9, 0.0)],
                0.2,
                &mut seed,
            );
            let rest: Vec<DVec3> = flat.iter().map(|x| x.with_z(0.0)).collect();
            let mesh = TriangleMesh {
                vertices: rest.clone(),
                triangles: vec![[0, 1, 2]],
                ..TriangleMesh::default()
            };
            let sheet = sheet(&mesh, law(Elasticity::Continuum { poisson_ratio: nu }));
            let now = noisy(&rest, 0.3, &mut seed);
            // F maps the plane's x and y: columns from D F = d.
            let (d1, d2) = (rest[1] - rest[0], rest[2] - rest[0]);
            let determinant = d1.x * d2.y - d1.y * d2.x;
            let (e1, e2) = (now[1] - now[0], now[2] - now[0]);
            let fx = (e1 * d2.y - e2 * d1.y) / determinant;
            let fy = (e2 * d1.x - e1 * d2.x) / determinant;
            let strain = [
                0.5 * (fx.dot(fx) - 1.0),
                0.5 * (fy.dot(fy) - 1.0),
                0.5 * fx.dot(fy),
            ];
            let stress = plane_stress(nu, strain);
            let area = 0.5 * determinant;
            let energy = 0.5
                * area
                * (stress[0] * strain[0] + stress[1] * strain[1] + 2.0 * stress[2] * strain[2]);
            assert!((sheet.stretching_energy(&now) - energy).abs() < 1e-9 * (1.0 + energy));
            // First Piola-Kirchhoff stress P = F S; force on a corner: minus the area times P grad N.
            let px = fx * stress[0] + fy * stress[2];
            let py = fx * stress[2] + fy * stress[1];
            let gradients = [
                (d2.y / determinant, -d2.x / determinant),
                (-d1.y / determinant, d1.x / determinant),
            ];
            let still = [DVec3::ZERO; 3];
            let (forces, _) = forces_of(&sheet, &now, &still, 0.0);
            for k in 0..2 {
                let expected = -area * (px * gradients[k].0 + py * gradients[k].1);
                assert!((forces[k + 1] - expected).length() < 1e-9, "{expected}");
            }
            // Cauchy: F S F^T A0/A.
            let present = 0.5 * e1.cross(e2).length();
            let seen = sheet.triangle(0, &now).tension;
            let expected = (fx * px.x + fy * py.x) * (area / present);
            let column = DVec3::new(seen.0[0], seen.0[3], seen.0[4]);
            assert!((column - expected).length() < 1e-9);
        }
    }
}

/// Losses of dashpots are the power that their forces take.
#[test]
fn dashpots_lose_what_their_forces_take() {
    let mesh = lattice(5, 4);
    let mut seed = 5;
    for elasticity in [
        Elasticity::Springs,
        Elasticity::Continuum { poisson_ratio: 0.2 },
    ] {
        let mut law = plate(law(elasticity));
        law.damping_ratio = 0.3;
        law.bending = law.bending.map(|bending| Bending {
            stiffness: 1e-2,
            damping: 1e-2,
            ..bending
        });
        let sheet = sheet(&mesh, law);
        for _ in 0..20 {
            let positions = noisy(&mesh.vertices, 0.2, &mut seed);
            let velocities = noisy(&vec![DVec3::ZERO; positions.len()], 1.0, &mut seed);
            let (forces, powers) = forces_of(&sheet, &positions, &velocities, 0.0);
            assert!(powers.edges > 0.0 && powers.hinges > 0.0);
            let still = vec![DVec3::ZERO; positions.len()];
            let (elastic, _) = forces_of(&sheet, &positions, &still, 0.0);
            let taken: f64 = (0..forces.len())
                .map(|k| (elastic[k] - forces[k]).dot(velocities[k]))
                .sum();
            assert!((taken - powers.edges - powers.hinges).abs() < 1e-12 * taken);
        }
    }
}

/// Forces are the slope of the energies.
#[test]
fn forces_are_minus_the_slope_of_the_energy() {
    let mesh = lattice(3, 3);
    let mut seed = 11;
    for elasticity in [
        Elasticity::Springs,
        Elasticity::Continuum { poisson_ratio: 0.3 },
    ] {
        for rests_flat in [true, false] {
            let mut law = law(elasticity);
            law.bending = Some(Bending {
                stiffness: 0.1,
                damping: 0.0,
                rests_flat,
            });
            let folded = TriangleMesh {
                vertices: noisy(&mesh.vertices, 0.15, &mut seed),
                ..mesh.clone()
            };
            let sheet = sheet(&folded, law);
            let mut positions = noisy(&mesh.vertices, 0.15, &mut seed);
            let still = vec![DVec3::ZERO; positions.len()];
            let (forces, _) = forces_of(&sheet, &positions, &still, 0.0);
            let energy = |positions: &[DVec3]| {
                sheet.stretching_energy(positions) + sheet.bending_energy(positions)
            };
            let step = 1e-5;
            for vertex in [0, 5, 6, 15] {
                for axis in 0..3 {
                    let place = positions[vertex][axis];
                    positions[vertex][axis] = place + step;
                    let high = energy(&positions);
                    positions[vertex][axis] = place - step;
                    let low = energy(&positions);
                    positions[vertex][axis] = place;
                    let slope = (high - low) / (2.0 * step);
                    let force = forces[vertex][axis];
                    // Central differences: step^2 times a third derivative of order 1.
                    assert!((slope + force).abs() < 1e-8, "{slope} {force}");
                }
            }
        }
    }
}

#[test]
fn chunks_threads_and_lanes_change_no_bit() {
    let mesh = lattice(61, 40);
    let mut seed = 23;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(2)
        .build()
        .unwrap();
    let poisson_ratio = 0.2;
    for elasticity in [Elasticity::Springs, Elasticity::Continuum { poisson_ratio }] {
        let mut law = plate(law(elasticity));
        law.damping_ratio = 0.1;
        law.bending = law.bending.map(|bending| Bending {
            damping: 0.1,
            ..bending
        });
        let sheet = sheet(&mesh, law);
        let positions = noisy(&mesh.vertices, 0.1, &mut seed);
        let velocities = noisy(&mesh.vertices, 0.1, &mut seed);
        let (alone, lost) = forces_of(&sheet, &positions, &velocities, 0.3);
        let inverse_masses: Vec<f64> = sheet.masses().iter().map(|mass| 1.0 / mass).collect();
        let dashpots = sheet.dashpots(&inverse_masses);
        for width in Width::all() {
            let mut forces = vec![DVec3::ZERO; positions.len()];
            let at = Evaluation {
                positions: &positions,
                velocities: &velocities,
                dashpots: &dashpots,
                pressure: 0.3,
                is_parallel: true,
                width,
            };
            let mut work = Workspace::default();
            let powers = pool.install(|| sheet.forces(&at, &mut work, &[], &mut forces));
            assert_eq!(alone, forces, "{} lanes", width.lanes());
            assert_eq!(lost, powers, "{} lanes", width.lanes());
        }
    }
}

#[test]
fn prestrain_shortens_all_rest_lengths() {
    let mesh = lattice(4, 4);
    let topology = Topology::new(mesh.vertices.len(), &mesh.triangles).unwrap();
    let rest: Vec<[DVec3; 3]> = (0..mesh.triangles.len()).map(|k| mesh.corners(k)).collect();
    let stretch = 0.1;
    let sheet = Sheet::new(topology, &rest, stretch, law(Elasticity::Springs)).unwrap();
    let seen = sheet.seen(&mesh.vertices);
    assert!((seen.tension.0[0] - 1.5 * stretch / (1.0 + stretch)).abs() < 1e-12);
    assert!((seen.least_stretch - 1.0 - stretch).abs() < 1e-12);
    let mass: f64 = sheet.masses().iter().sum();
    assert!((mass - sheet.rest_area()).abs() < 1e-12 * mass);
    assert!((seen.area / sheet.rest_area() - (1.0 + stretch) * (1.0 + stretch)).abs() < 1e-12);
}

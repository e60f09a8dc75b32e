//! The largest stable step.

use glam::DVec3;
use mercury_common::curve::Curve;

use super::super::{Load, Rates, sphere};
use super::*;

fn free_rates(sheet: &Sheet, positions: &[DVec3]) -> Rates {
    let inverse_masses: Vec<f64> = sheet.masses().iter().map(|mass| 1.0 / mass).collect();
    let dashpots = sheet.dashpots(&inverse_masses);
    sheet.rates(positions, &dashpots, &Load::Given(Curve::default()), 1.0)
}

/// An equilateral triangle with thirds of its mass: 9 K/m in numbers of the hexagonal sheet.
#[test]
fn the_bound_of_the_hexagonal_sheet_is_nine() {
    let mesh = lattice(4, 4);
    let sheet = sheet(&mesh, law(Elasticity::Springs));
    let spring = 0.75_f64.sqrt();
    let mass = 6.0 * 0.25 * 3.0_f64.sqrt() / 3.0;
    let rates = free_rates(&sheet, &mesh.vertices);
    assert!((rates.stiffness / (9.0 * spring / mass) - 1.0).abs() < 1e-12);
    assert_eq!(rates.damping, 0.0);
    assert!((rates.critical_step() - 2.0 / rates.stiffness.sqrt()).abs() < 1e-12);
    let damped = Rates {
        stiffness: 4.0,
        damping: 3.0,
    };
    // omega = 2, z = 3/4: 2/omega (sqrt(1 + z^2) - z) = 5/4 - 3/4.
    assert!((damped.critical_step() - 0.5).abs() < 1e-15);
}

/// The largest eigenvalue of the whole sheet by iteration of vectors; the slope of the forces by differences.
fn largest(sheet: &Sheet, positions: &[DVec3], pressure: impl Fn(&[DVec3]) -> f64) -> f64 {
    let mut seed = 1;
    let still = vec![DVec3::ZERO; positions.len()];
    let mut mode = noisy(&still, 1.0, &mut seed);
    let mut eigenvalue = 0.0;
    for _ in 0..300 {
        let size: f64 = mode.iter().map(|x| x.length_squared()).sum::<f64>().sqrt();
        let small = 1e-6;
        let at = |sign: f64| {
            let moved: Vec<DVec3> = (positions.iter().zip(&mode))
                .map(|(x, u)| *x + *u * (sign * small / size))
                .collect();
            forces_of(sheet, &moved, &still, pressure(&moved)).0
        };
        let (high, low) = (at(1.0), at(-1.0));
        let next: Vec<DVec3> = (0..mode.len())
            .map(|k| (low[k] - high[k]) / (2.0 * small * sheet.masses()[k]))
            .collect();
        eigenvalue = next.iter().map(|x| x.length_squared()).sum::<f64>().sqrt();
        mode = next;
    }
    eigenvalue
}

#[test]
fn the_bound_is_above_the_largest_eigenvalue_and_near_it() {
    let mut seed = 2;
    for elasticity in [
        Elasticity::Springs,
        Elasticity::Continuum {
            poisson_ratio: 0.45,
        },
    ] {
        for stiffness in [0.0, 1e-3, 1.0] {
            let mut law = law(elasticity);
            law.bending = (stiffness > 0.0).then_some(Bending {
                stiffness,
                damping: 0.0,
                rests_flat: false,
            });
            let mut mesh = lattice(5, 5);
            mesh.vertices = noisy(&mesh.vertices, 0.15, &mut seed);
            let sheet = sheet(&mesh, law);
            let bound = free_rates(&sheet, &mesh.vertices).stiffness;
            let found = largest(&sheet, &mesh.vertices, |_| 0.0);
            assert!(found < bound * 1.0001, "{found} {bound}");
            assert!(found > 0.2 * bound, "{found} {bound}");
        }
    }
}

#[test]
fn an_enclosed_fluid_shortens_the_step() {
    let mesh = sphere(DVec3::ZERO, 1.0, 0.4);
    let sheet = sheet(&mesh, law(Elasticity::Springs));
    let load = Load::Fluid {
        fluid: 0.0,
        bulk_modulus: 100.0,
        ambient: 0.0,
    };
    let first = sheet.enclosed(&mesh.vertices).volume;
    let dashpots = vec![0.0; sheet.topology().edges().len()];
    let bound = sheet
        .rates(&mesh.vertices, &dashpots, &load, first)
        .stiffness;
    let found = largest(&sheet, &mesh.vertices, |moved| {
        load.at(0.0, sheet.enclosed(moved).volume, first)
    });
    assert!(found < bound && found > 0.8 * bound, "{found} {bound}");
}

/// Dashpots along edges and in hinges with velocities half a step old: stable just below the bound of one triangle or hinge.
#[test]
fn damped_elements_are_stable_below_the_bound() {
    let mesh = TriangleMesh {
        vertices: vec![DVec3::ZERO, DVec3::X, DVec3::new(0.5, 0.75_f64.sqrt(), 0.0)],
        triangles: vec![[0, 1, 2]],
        ..TriangleMesh::default()
    };
    let mut law = law(Elasticity::Springs);
    law.damping_ratio = 0.5;
    let sheet = sheet(&mesh, law);
    let grows = |step: f64| {
        let mut positions = mesh.vertices.clone();
        let mut velocities = vec![DVec3::ZERO; 3];
        for (k, x) in mesh.vertices.iter().enumerate() {
            velocities[k] = 1e-6 * (*x - DVec3::new(0.5, 0.2, 0.0));
        }
        for _ in 0..400 {
            let (forces, _) = forces_of(&sheet, &positions, &velocities, 0.0);
            for k in 0..3 {
                velocities[k] += forces[k] * (step / sheet.masses()[k]);
                positions[k] += velocities[k] * step;
            }
        }
        velocities.iter().any(|v| v.length() > 1e-5 || v.is_nan())
    };
    let critical = free_rates(&sheet, &mesh.vertices).critical_step();
    assert!(!grows(0.99 * critical));
    assert!(grows(1.02 * critical));
}

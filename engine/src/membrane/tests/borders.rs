//! Stiffness and damping of a sheet against a wall that holds vertices of it, beside differences of the forces on these vertices.

use glam::DVec3;
use mercury_common::curve::Curve;

use super::{forces_of, lattice, law, noisy, plate, sheet};
use crate::membrane::borders::{Border, SheetShape};
use crate::membrane::{Bending, Elasticity, Law, Load, Sheet, sphere};
use crate::walls::WallStiffness;

const LAWS: [Elasticity; 2] = [
    Elasticity::Springs,
    Elasticity::Continuum { poisson_ratio: 0.3 },
];

/// Stiffness and damping of the sheet.
fn answer(
    sheet: &Sheet,
    is_held: &[bool],
    positions: &[DVec3],
    axis: DVec3,
    load: &Load,
) -> WallStiffness {
    let inverse_masses: Vec<f64> = sheet.masses().iter().map(|mass| 1.0 / mass).collect();
    let dashpots = sheet.dashpots(&inverse_masses);
    let shape = SheetShape {
        positions,
        // Without masses the damping is that of the dashpots alone.
        inverse_masses: &vec![0.0; positions.len()],
        dashpots: &dashpots,
    };
    let border = Border::new(sheet, is_held.to_vec());
    let mut sum = WallStiffness::default();
    let first = sheet.enclosed(positions).volume;
    sheet.add_answer(&border, &shape, axis, (load, first), &mut sum);
    sum
}

/// Force on the held vertices along the axis, N, when they are displaced by `way` (m) and move at `speed` (m/s) along it.
fn force(
    sheet: &Sheet,
    is_held: &[bool],
    positions: &[DVec3],
    axis: DVec3,
    (way, speed): (f64, f64),
    load: &Load,
) -> f64 {
    let moved = |(held, x): (&bool, &DVec3)| if *held { *x + axis * way } else { *x };
    let places: Vec<DVec3> = is_held.iter().zip(positions).map(moved).collect();
    let along = |held: &bool| if *held { axis * speed } else { DVec3::ZERO };
    let velocities: Vec<DVec3> = is_held.iter().map(along).collect();
    let first = sheet.enclosed(positions).volume;
    let pressure = load.at(0.0, sheet.enclosed(&places).volume, first);
    let (forces, _) = forces_of(sheet, &places, &velocities, pressure);
    let held = forces.iter().zip(is_held).filter(|(_, held)| **held);
    held.map(|(force, _)| force.dot(axis)).sum()
}

fn axes() -> [DVec3; 4] {
    [
        DVec3::X,
        DVec3::Y,
        DVec3::Z,
        DVec3::new(1.0, 2.0, 2.0) / 3.0,
    ]
}

/// A sheet that is stretched by a tenth, of uneven triangles, and its lowest row.
fn stretched(law: Law) -> (Sheet, Vec<bool>, Vec<DVec3>) {
    let mesh = lattice(4, 3);
    let sheet = sheet(&mesh, law);
    let is_held = mesh.vertices.iter().map(|x| x.y < 0.1).collect();
    let wide: Vec<DVec3> = mesh.vertices.iter().map(|&x| 1.1 * x).collect();
    (sheet, is_held, noisy(&wide, 0.02, &mut 5))
}

/// Error of the central difference: its step squared times the third derivative, which is of the order of the stiffness over a squared edge of 1 m.
const STEP: f64 = 1e-4;

#[test]
fn its_stiffness_is_the_derivative_of_the_force() {
    let none = Load::Given(Curve::default());
    for elasticity in LAWS {
        let (sheet, is_held, positions) = stretched(law(elasticity));
        for axis in axes() {
            let at = |way: f64| force(&sheet, &is_held, &positions, axis, (way, 0.0), &none);
            let expected = (at(-STEP) - at(STEP)) / (2.0 * STEP);
            let found = answer(&sheet, &is_held, &positions, axis, &none).stiffness;
            // Of sides that pull no part is negative, so none is left out.
            assert!(
                (found / expected - 1.0).abs() < 1e-6,
                "{elasticity:?}, {axis}: {found}, not {expected} N/m"
            );
        }
    }
}

/// Hinges count as in the critical step, without the turn of their moments: of a sheet that is nearly flat at rest and now that is all but a small part.
#[test]
fn hinges_resist_across_the_sheet() {
    let none = Load::Given(Curve::default());
    for elasticity in LAWS {
        let mesh = lattice(4, 3);
        let sheet = sheet(&mesh, plate(law(elasticity)));
        let is_held: Vec<bool> = mesh.vertices.iter().map(|x| x.y < 0.1).collect();
        let positions = &mesh.vertices;
        let at = |way: f64| force(&sheet, &is_held, positions, DVec3::Z, (way, 0.0), &none);
        // Sides resist by E t/2 (way/l)^3: beside D/l^2 of some 1e-7 N/m that is nothing for ways far below the thickness of 1e-3 m.
        let step = 1e-6;
        let expected = (at(-step) - at(step)) / (2.0 * step);
        let found = answer(&sheet, &is_held, positions, DVec3::Z, &none).stiffness;
        assert!(
            expected > 0.0 && (found / expected - 1.0).abs() < 1e-3,
            "{found} {expected}"
        );
    }
}

/// Forces of dashpots and drag are linear in the velocities: the damping is twice their sum, to round-off.
#[test]
fn its_damping_is_twice_that_of_the_dashpots() {
    let none = Load::Given(Curve::default());
    for elasticity in LAWS {
        let own = law(elasticity);
        let own = Law {
            damping_ratio: 0.3,
            bending: Some(Bending {
                stiffness: 1e-3,
                damping: 2e-3,
                rests_flat: true,
            }),
            ..own
        };
        let (sheet, is_held, positions) = stretched(own);
        for axis in axes() {
            let at = |speed: f64| force(&sheet, &is_held, &positions, axis, (0.0, speed), &none);
            let expected = at(-1.0) - at(1.0);
            let found = answer(&sheet, &is_held, &positions, axis, &none).damping;
            assert!(
                (found / expected - 1.0).abs() < 1e-9,
                "{elasticity:?}, {axis}: {found}, not {expected} N s/m"
            );
        }
        // Drag acts on the held vertices, too.
        let (dragged, ..) = stretched(Law { drag: 7.0, ..own });
        let [with, without] = [&dragged, &sheet]
            .map(|sheet| answer(sheet, &is_held, &positions, DVec3::X, &none).damping);
        let masses = sheet.masses().iter().zip(&is_held);
        let mass: f64 = masses
            .filter(|(_, held)| **held)
            .map(|(mass, _)| mass)
            .sum();
        assert!((with - without - 2.0 * 7.0 * mass).abs() < 1e-12 * with);
    }
}

/// A ball of gas whose cap is held: the gas adds the load by its law over the volume that the cap sweeps.
#[test]
fn an_enclosed_fluid_resists() {
    let mesh = sphere(DVec3::ZERO, 1.0, 0.4);
    let sheet = sheet(&mesh, law(LAWS[0]));
    let is_held: Vec<bool> = mesh.vertices.iter().map(|x| x.z > 0.5).collect();
    let none = Load::Given(Curve::default());
    for load in [
        Load::Gas {
            gas: 1e3,
            ambient: 1e3,
            exponent: 1.4,
        },
        Load::Fluid {
            fluid: 0.0,
            bulk_modulus: 1e3,
            ambient: 0.0,
        },
    ] {
        let by = |way: f64, load: &Load| {
            force(&sheet, &is_held, &mesh.vertices, DVec3::Z, (way, 0.0), load)
        };
        let slope = |load: &Load| (by(-STEP, load) - by(STEP, load)) / (2.0 * STEP);
        let expected = slope(&load) - slope(&none);
        let [with, without] = [&load, &none]
            .map(|load| answer(&sheet, &is_held, &mesh.vertices, DVec3::Z, load).stiffness);
        let found = with - without;
        // The pressure is 0 here, so that only its slope counts.
        assert!((found / expected - 1.0).abs() < 1e-5, "{found} {expected}");
    }
}

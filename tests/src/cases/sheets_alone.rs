//! T24: the mechanics of a sheet alone, against formulas.

use std::f64::consts::TAU;

use glam::{DVec3, dvec3};
use mercury_common::formats::mesh::TriangleMesh;
use mercury_common::random::Stream;
use mercury_engine::lanes::Width;
use mercury_engine::membrane::{
    Bending, Elasticity, Evaluation, Law, Load, Sheet, Topology, Workspace, sphere,
};

use super::Case;
use super::Tolerance::{Absolute, Relative};

/// E t = 1 N/m with a thickness of 1 mm; limp, without losses.
fn law(elasticity: Elasticity) -> Law {
    Law {
        thickness: 1e-3,
        youngs_modulus: 1e3,
        density: 1000.0,
        elasticity,
        damping_ratio: 0.0,
        drag: 0.0,
        bending: None,
    }
}

fn continuum(poisson_ratio: f64) -> Elasticity {
    Elasticity::Continuum { poisson_ratio }
}

fn sheet(mesh: &TriangleMesh, law: Law) -> Sheet {
    let topology = Topology::new(mesh.vertices.len(), &mesh.triangles).expect("a sheet");
    let rest: Vec<[DVec3; 3]> = (0..mesh.triangles.len()).map(|k| mesh.corners(k)).collect();
    Sheet::new(topology, &rest, 0.0, law).expect("triangles with areas")
}

fn forces(sheet: &Sheet, positions: &[DVec3], velocities: &[DVec3], pressure: f64) -> Vec<DVec3> {
    let inverse_masses: Vec<f64> = sheet.masses().iter().map(|mass| mass.recip()).collect();
    let at = Evaluation {
        positions,
        velocities,
        dashpots: &sheet.dashpots(&inverse_masses),
        pressure,
        is_parallel: false,
        width: Width::fastest(),
    };
    let mut forces = vec![DVec3::ZERO; positions.len()];
    sheet.forces(&at, &mut Workspace::default(), &[], &mut forces);
    forces
}

/// Equilateral triangles with edges of 1 m, `columns` by `rows` pairs of them.
fn lattice(columns: u32, rows: u32) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for row in 0..=rows {
        for column in 0..=columns {
            let x = f64::from(column) + 0.5 * f64::from(row);
            mesh.vertices
                .push(dvec3(x, f64::from(row) * 0.75f64.sqrt(), 0.0));
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let low = row * (columns + 1) + column;
            let high = low + columns + 1;
            mesh.triangles.push([low, low + 1, high]);
            mesh.triangles.push([low + 1, high + 1, high]);
        }
    }
    mesh
}

/// Each place moved by up to `size` (m) in each of these axes.
fn shaken(places: &[DVec3], size: DVec3, random: &mut Stream) -> Vec<DVec3> {
    let mut any = || 2.0 * random.uniform() - 1.0;
    let moved = |&place: &DVec3| place + size * dvec3(any(), any(), any());
    places.iter().map(moved).collect()
}

fn skewed() -> TriangleMesh {
    let mut mesh = lattice(6, 6);
    let mut random = Stream::new(3, "skewed", 0);
    mesh.vertices = shaken(&mesh.vertices, dvec3(0.25, 0.25, 0.0), &mut random);
    mesh
}

/// Under the strain 1e-6 in all directions, along four of them and in shear: the largest error of a triangle's tension over E t e, and the largest
/// force on an inner vertex over E t e l.
fn uniform(mesh: &TriangleMesh, elasticity: Elasticity) -> [f64; 2] {
    const STRAIN: f64 = 1e-6;
    let sheet = sheet(mesh, law(elasticity));
    let nu = elasticity.poisson_ratio();
    let is_on_rim = sheet.topology().is_on_rim();
    let mut strains = vec![[1.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    strains.extend((0..4).map(|k| {
        let (sin, cos) = (TAU / 16.0 * f64::from(k)).sin_cos();
        [cos * cos, sin * sin, sin * cos]
    }));
    let (mut worst, mut most) = (0.0f64, 0.0f64);
    for [xx, yy, xy] in strains {
        let strained =
            |x: &DVec3| *x + STRAIN * dvec3(xx * x.x + xy * x.y, xy * x.x + yy * x.y, 0.0);
        let places: Vec<DVec3> = mesh.vertices.iter().map(strained).collect();
        // E t/(1 - nu^2) [(1 - nu) e + nu tr(e) 1].
        let plane = 1.0 / (1.0 - nu * nu);
        let expected = [
            plane * (xx + nu * yy),
            plane * (yy + nu * xx),
            plane * (1.0 - nu) * xy,
        ];
        for index in 0..mesh.triangles.len() {
            let found = sheet.triangle(index, &places).tension.0;
            for (found, expected) in [found[0], found[1], found[3]].iter().zip(expected) {
                worst = worst.max((found / STRAIN - expected).abs());
            }
        }
        let still = vec![DVec3::ZERO; places.len()];
        let inner = forces(&sheet, &places, &still, 0.0);
        for (force, _) in inner.iter().zip(&is_on_rim).filter(|(_, on_rim)| !**on_rim) {
            most = most.max(force.length() / STRAIN);
        }
    }
    [worst, most]
}

/// The largest sum of the forces, and of their torques, over the sum of their sizes: stretched, bent and damped in any way.
fn sums() -> [f64; 2] {
    let mesh = lattice(5, 4);
    let mut random = Stream::new(5, "sums", 0);
    let mut most = [0.0f64; 2];
    for elasticity in [Elasticity::Springs, continuum(0.2)] {
        let law = Law {
            damping_ratio: 0.3,
            bending: Some(Bending {
                stiffness: 1e-2,
                damping: 1e-2,
                rests_flat: true,
            }),
            ..law(elasticity)
        };
        let sheet = sheet(&mesh, law);
        for _ in 0..20 {
            let places = shaken(&mesh.vertices, DVec3::splat(0.2), &mut random);
            let zeros = vec![DVec3::ZERO; places.len()];
            let velocities = shaken(&zeros, DVec3::ONE, &mut random);
            let forces = forces(&sheet, &places, &velocities, 0.0);
            let torques = places.iter().zip(&forces).map(|(x, force)| x.cross(*force));
            let torque: DVec3 = torques.sum();
            let arms = places.iter().zip(&forces);
            let sizes: f64 = arms.map(|(x, force)| x.length() * force.length()).sum();
            let size: f64 = forces.iter().map(|force| force.length()).sum();
            let sum: DVec3 = forces.iter().sum();
            most[0] = most[0].max(sum.length() / size);
            most[1] = most[1].max(torque.length() / sizes);
        }
    }
    most
}

/// The bending energy of 24 x 28 cells bent into the shape z = k f(x, y) over D k^2/2 times their area. Each hinge stands for a third of the area of
/// its triangles; those on the rim are missing.
fn bent(shape: impl Fn(DVec3) -> f64) -> f64 {
    const CURVATURE: f64 = 1e-4;
    let mesh = lattice(24, 28);
    let mut law = law(continuum(0.3));
    law.bending = Some(Bending {
        stiffness: law.plate_stiffness(),
        damping: 0.0,
        rests_flat: true,
    });
    let sheet = sheet(&mesh, law);
    let places: Vec<DVec3> = (mesh.vertices.iter())
        .map(|x| x.with_z(CURVATURE * shape(*x)))
        .collect();
    let hinges = sheet.topology().hinges().len() as f64 / (1.5 * mesh.triangles.len() as f64);
    let plate = 0.5 * law.plate_stiffness() * CURVATURE * CURVATURE * sheet.rest_area() * hinges;
    sheet.bending_energy(&places) / plate
}

/// A balloon of radius 1 m at rest under 0.06 Pa: 3 p V over the sum of A tr(n), and by the sheet's finite law the tension of its growth over p R/2.
fn balloon(elasticity: Elasticity) -> [f64; 2] {
    const PRESSURE: f64 = 0.06;
    let mesh = sphere(DVec3::ZERO, 1.0, 0.2);
    let sheet = sheet(&mesh, law(elasticity));
    let none = vec![0.0; sheet.topology().edges().len()];
    let rates = sheet.rates(&mesh.vertices, &none, &Load::Given(Vec::new()), 1.0);
    let step = rates.critical_step() * 0.5;
    let mut places = mesh.vertices.clone();
    let mut velocities = vec![DVec3::ZERO; places.len()];
    let still = velocities.clone();
    for _ in 0..3000 {
        let forces = forces(&sheet, &places, &still, PRESSURE);
        for (k, force) in forces.iter().enumerate() {
            velocities[k] = 0.97 * velocities[k] + *force * (step / sheet.masses()[k]);
            places[k] += velocities[k] * step;
        }
    }
    let seen = sheet.seen(&places);
    let volume = sheet.enclosed(&places).volume;
    let balance = 3.0 * PRESSURE * volume / (seen.area * seen.tension.trace());
    let radius = places.iter().map(|x| x.length()).sum::<f64>() / places.len() as f64;
    let stretch = radius - 1.0;
    let by_law = match elasticity {
        Elasticity::Springs => 1.5 * stretch / (1.0 + stretch),
        Elasticity::Continuum { poisson_ratio } => {
            (stretch + 0.5 * stretch * stretch) / (1.0 - poisson_ratio)
        }
    };
    [balance, by_law / (0.5 * PRESSURE * radius)]
}

const STRAINED: &str = "E t/(1 - nu^2) [(1 - nu) e + nu tr(e) 1]";
const NETWORK: &str = "Seung & Nelson (1988): Poisson's ratio of bending is -1/3";

pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    type Mesh = fn() -> TriangleMesh;
    let hexagonal: Mesh = || lattice(6, 8);
    let meshes: [(&str, Mesh, Elasticity); 3] = [
        (
            "springs on equilateral triangles",
            hexagonal,
            Elasticity::Springs,
        ),
        (
            "continuum on a skewed mesh, nu = 0.1",
            skewed,
            continuum(0.1),
        ),
        (
            "continuum on a skewed mesh, nu = 0.45",
            skewed,
            continuum(0.45),
        ),
    ];
    for (name, mesh, elasticity) in meshes {
        cases.push(Case::new(
            format!("T24 law: {name}, strained by 1e-6 in six ways, largest error of a tension over E t e"),
            0.0,
            Absolute(2e-5),
            STRAINED,
            move || uniform(&mesh(), elasticity)[0],
        ));
        cases.push(Case::new(
            format!("T24 law: {name}, the same, largest force on an inner vertex over E t e l"),
            0.0,
            Absolute(1e-6),
            "balance of forces",
            move || uniform(&mesh(), elasticity)[1],
        ));
    }
    for (index, what) in ["forces", "torques"].into_iter().enumerate() {
        cases.push(Case::new(
            format!(
                "T24 law: sum of the inner {what} of any deformation over the sum of their sizes"
            ),
            0.0,
            Absolute(1e-12),
            "action and reaction",
            move || sums()[index],
        ));
    }
    type Bent = fn(DVec3) -> f64;
    let shapes: [(&str, Bent, f64); 4] = [
        ("a cylinder along the rows", |x| 0.5 * x.x * x.x, 1.0),
        ("a cylinder across the rows", |x| 0.5 * x.y * x.y, 1.0),
        ("a dome", |x| 0.5 * (x.x * x.x + x.y * x.y), 4.0 / 3.0),
        ("a twist", |x| x.x * x.y, 8.0 / 3.0),
    ];
    for (name, shape, expected) in shapes {
        cases.push(Case::new(
            format!("T24 law: 24 x 28 cells bent into {name}, energy over D k^2/2 per area"),
            expected,
            Relative(5e-2),
            NETWORK,
            move || bent(shape),
        ));
    }
    for (name, elasticity) in [
        ("springs", Elasticity::Springs),
        ("continuum, nu = 0.4", continuum(0.4)),
    ] {
        cases.push(Case::new(
            format!("T24 law: balloon at rest, {name}, 3 p V over the sum of A tr(n)"),
            1.0,
            Absolute(2e-5),
            "virtual work of growth",
            move || balloon(elasticity)[0],
        ));
        cases.push(Case::new(
            format!("T24 law: balloon at rest, {name}, tension of its growth over p R/2"),
            1.0,
            Absolute(1e-2),
            "finite law of the sheet",
            move || balloon(elasticity)[1],
        ));
    }
    cases
}

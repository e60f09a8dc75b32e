//! T24: the mechanics of a sheet alone, against formulas.

use std::f64::consts::TAU;

use glam::{DVec3, dvec3};
use mercury_common::curve::Curve;
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

/// The law of St. Venant and Kirchhoff by the deformation gradient of a triangle in its plane, for 150 triangles stretched and turned in any way: the largest
/// difference of forces over E t times 1 m, of energy over that times 1 m, and of tensions over E t.
fn any_deformation() -> [f64; 3] {
    let mut random = Stream::new(17, "triangles", 0);
    let mut most = [0.0f64; 3];
    for nu in [-0.5, 0.1, 0.45] {
        for _ in 0..50 {
            let first = [DVec3::ZERO, DVec3::X, dvec3(0.4, 0.9, 0.0)];
            let rest = shaken(&first, dvec3(0.2, 0.2, 0.0), &mut random);
            let mesh = TriangleMesh {
                vertices: rest.clone(),
                triangles: vec![[0, 1, 2]],
                ..TriangleMesh::default()
            };
            let sheet = sheet(&mesh, law(continuum(nu)));
            let now = shaken(&rest, DVec3::splat(0.3), &mut random);
            let (d1, d2) = (rest[1] - rest[0], rest[2] - rest[0]);
            let determinant = d1.x * d2.y - d1.y * d2.x;
            let (e1, e2) = (now[1] - now[0], now[2] - now[0]);
            // F maps d1 and d2 to e1 and e2: its columns.
            let fx = (e1 * d2.y - e2 * d1.y) / determinant;
            let fy = (e2 * d1.x - e1 * d2.x) / determinant;
            let [xx, yy, xy] = [
                0.5 * (fx.dot(fx) - 1.0),
                0.5 * (fy.dot(fy) - 1.0),
                0.5 * fx.dot(fy),
            ];
            let plane = 1.0 / (1.0 - nu * nu);
            let [sxx, syy, sxy] = [
                plane * (xx + nu * yy),
                plane * (yy + nu * xx),
                plane * (1.0 - nu) * xy,
            ];
            // First Piola-Kirchhoff stress F S; a corner gets minus the area times it and the slope of its weight.
            let (px, py) = (fx * sxx + fy * sxy, fx * sxy + fy * syy);
            let area = 0.5 * determinant;
            let slopes = [[d2.y, -d2.x], [-d1.y, d1.x]];
            let found = forces(&sheet, &now, &[DVec3::ZERO; 3], 0.0);
            for (found, [x, y]) in found[1..].iter().zip(slopes) {
                let expected = (px * x + py * y) * (-area / determinant);
                most[0] = most[0].max(found.distance(expected));
            }
            let energy = 0.5 * area * (sxx * xx + syy * yy + 2.0 * sxy * xy);
            most[1] = most[1].max((sheet.stretching_energy(&now) - energy).abs());
            // Cauchy: F S F^T A0/A.
            let over = area / (0.5 * e1.cross(e2).length());
            let tension = sheet.triangle(0, &now).tension.0;
            let columns = [
                (fx * px.x + fy * py.x) * over - dvec3(tension[0], tension[3], tension[4]),
                (fx * px.y + fy * py.y) * over - dvec3(tension[3], tension[1], tension[5]),
                (fx * px.z + fy * py.z) * over - dvec3(tension[4], tension[5], tension[2]),
            ];
            for column in columns {
                most[2] = most[2].max(column.length());
            }
        }
    }
    most
}

/// Hinge by hinge the angle of a sheet with small slopes is the jump of the slope: energy over the sum of D jump^2/2 times e^2/(A1 + A2).
fn hinge_by_hinge() -> f64 {
    let mesh = lattice(6, 6);
    let mut law = law(Elasticity::Springs);
    law.bending = Some(Bending {
        stiffness: law.plate_stiffness(),
        damping: 0.0,
        rests_flat: true,
    });
    let sheet = sheet(&mesh, law);
    // Slopes are below 1e-5, their squares below 1e-10.
    let bent = |x: &DVec3| x.with_z(1e-6 * (0.5 * x.x * x.x + 0.3 * x.x * x.y));
    let places: Vec<DVec3> = mesh.vertices.iter().map(bent).collect();
    let slope = |triangle: u32| {
        let [a, b, c] = mesh.triangles[triangle as usize].map(|k| places[k as usize]);
        let normal = (b - a).cross(c - a);
        -normal.truncate() / normal.z
    };
    let hinges = sheet.topology().hinges().iter();
    let jumps = hinges.map(|edge| {
        let [one, other] = edge.triangles.map(slope);
        one.distance_squared(other)
    });
    // e^2/(A1 + A2) of equilateral triangles with edges of 1 m.
    let shape = 1.0 / (0.5 * 3.0f64.sqrt());
    let expected = 0.5 * law.plate_stiffness() * shape * jumps.sum::<f64>();
    sheet.bending_energy(&places) / expected
}

/// A balloon of radius 1 m at rest under 0.06 Pa: 3 p V over the sum of A tr(n), and by the sheet's finite law the tension of its growth over p R/2.
fn balloon(elasticity: Elasticity) -> [f64; 2] {
    const PRESSURE: f64 = 0.06;
    let mesh = sphere(DVec3::ZERO, 1.0, 0.2);
    let sheet = sheet(&mesh, law(elasticity));
    let none = vec![0.0; sheet.topology().edges().len()];
    let rates = sheet.rates(&mesh.vertices, &none, &Load::Given(Curve::default()), 1.0);
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
    for (index, what) in ["forces", "energy", "tension"].into_iter().enumerate() {
        cases.push(Case::new(
            format!(
                "T24 law: continuum, any deformation of triangles, largest error of the {what}"
            ),
            0.0,
            Absolute(1e-9),
            "St. Venant and Kirchhoff by the deformation gradient",
            move || any_deformation()[index],
        ));
    }
    cases.push(Case::new(
        "T24 law: hinge by hinge, energy over that of the jumps of the slope",
        1.0,
        Absolute(1e-9),
        "small slopes: the angle of a hinge is the jump of the slope",
        hinge_by_hinge,
    ));
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

//! MercuryCG's own files, number by number.

mod support;

use std::path::Path;

use glam::DVec3;
use mercury_cg::coordinates::{Coordinates, GridAxis, Place};
use mercury_cg::evaluate::Evaluator;
use mercury_cg::input::{FrameChoice, Given, Needs, Source, read_restart};
use mercury_cg::kernel::{KernelChoice, KernelShape, LineCut};
use mercury_cg::output::stat;
use mercury_cg::state::{Contacts, Particles, Partner, Space, State};
use mercury_cg::sums::Layout;
use mercury_common::reference_data::shared;
use support::table;

/// MercuryCG's conventions: cut at 3 widths, cylinders, no periodic images.
fn compat(coordinates: Coordinates, place: Place, shape: KernelShape, width: f64) -> Evaluator {
    let choice = KernelChoice {
        cutoff: 3.0,
        tolerance: 1e-12,
        line_cut: LineCut::Cylinder,
        ..KernelChoice::new(shape, width)
    };
    Evaluator {
        images: false,
        ..Evaluator::new(coordinates, place, choice)
    }
}

/// Compares the 29 columns with those of a file: to half a unit of its sixth digit, and what is nothing against the largest of the column's
/// field. Returns how many rows differ.
fn rows_that_differ(evaluator: &Evaluator, state: &State, file: &Path) -> (usize, usize) {
    let text = std::fs::read_to_string(file).unwrap();
    let expected = table(&text, 2);
    let sums = evaluator.sums(state, &Layout::new(&mercury_cg::fields::MERCURY_SUMS), None);
    assert_eq!(expected.len(), sums.points, "{}", file.display());
    let coordinates = evaluator.coordinates.names().len();
    let groups = [0..1, 1..2, 2..5, 5..11, 11..20, 20..23];
    let scales: Vec<f64> = (0..29)
        .map(|column| {
            let group = groups
                .iter()
                .find(|group| group.contains(&column))
                .cloned()
                .unwrap_or(column..column + 1);
            expected
                .iter()
                .flat_map(|row| &row[1 + coordinates..][group.clone()])
                .fold(0.0f64, |a, b| a.max(b.abs()))
        })
        .collect();
    let mut different = 0;
    for (point, row) in expected.iter().enumerate() {
        let place = evaluator.place.coordinates(point);
        for (a, b) in place.iter().zip(&row[1..]) {
            assert!(
                (a - b).abs() <= 1e-5 * a.abs() + 1e-12,
                "{}: point {point}",
                file.display()
            );
        }
        let found = stat::values(&sums, point);
        let differs = |column: usize| {
            let (a, b) = (found[column], row[1 + coordinates + column]);
            (a - b).abs() > 5.1e-6 * b.abs() + 1e-7 * scales[column] + 1e-12
        };
        if let Some(column) = (0..29).find(|&column| differs(column)) {
            different += 1;
            if different <= 3 {
                println!(
                    "{}: point {place:?} column {column}: {} instead of {}",
                    file.display(),
                    found[column],
                    row[1 + coordinates + column]
                );
            }
        }
    }
    (different, expected.len())
}

fn axis(min: f64, max: f64, count: usize) -> GridAxis {
    GridAxis { min, max, count }
}

#[test]
fn a_dense_packing_as_mercury_cg_has_it() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/dense2k");
    let given = Given {
        density: Some(2500.0),
        ..Given::default()
    };
    let needs = Needs {
        mass: true,
        contacts: true,
        ..Needs::default()
    };
    let source = Source::open(&folder.join("dense2k.data.gz"), &given, needs).unwrap();
    let state = source.states(FrameChoice::All).next().unwrap().unwrap();
    assert_eq!(state.particles.len(), 2000);
    let pairs = state
        .contacts
        .as_ref()
        .unwrap()
        .partner
        .iter()
        .filter(|partner| matches!(partner, Partner::Particle(_)))
        .count();
    assert_eq!(
        (pairs, state.contacts.as_ref().unwrap().len()),
        (4357, 4842)
    );
    let top = 0.07744;
    for (file, coordinates, grid, width) in [
        ("dense2k.O.stat", [false; 3], vec![], 1.0),
        (
            "dense2k.Z.Gauss.stat",
            [false, false, true],
            vec![axis(0.0, top, 50)],
            0.002,
        ),
        (
            "dense2k.XYZ.Gauss.stat",
            [true; 3],
            vec![
                axis(0.0, 0.048, 10),
                axis(0.0, 0.048, 10),
                axis(0.0, top, 10),
            ],
            0.004,
        ),
    ] {
        let evaluator = compat(
            Coordinates::Cartesian(coordinates),
            Place::Grid(grid),
            KernelShape::Gaussian,
            width,
        );
        let (different, _) = rows_that_differ(&evaluator, &state, &folder.join(file));
        assert_eq!(different, 0, "{file}");
    }
}

#[test]
fn newtons_cradle_from_its_restart_file() {
    let Some(folder) = shared("data/selftest/cg") else {
        return;
    };
    let restart = read_restart(&folder.join("NewtonsCradleSelfTest.restart")).unwrap();
    let evaluator = compat(
        Coordinates::Cartesian([false, false, true]),
        Place::Grid(vec![axis(0.0, 4.0, 400)]),
        KernelShape::Gaussian,
        0.46 / 3.0,
    );
    let (different, _) = rows_that_differ(
        &evaluator,
        &restart.state,
        &folder.join("NewtonsCradleSelfTest.fromRestart.stat"),
    );
    assert_eq!(different, 0);
    // The old tool, to 16 digits: volume fraction, density, momentum, stress (normal part), traction (sign opposite).
    let text = std::fs::read_to_string(folder.join("NewtonsCradleSelfTest.stat")).unwrap();
    let expected = table(&text, 3);
    let sums = evaluator.sums(
        &as_the_old_tool_ends(&restart.state),
        &Layout::new(&mercury_cg::fields::MERCURY_SUMS),
        None,
    );
    assert_eq!(expected.len(), sums.points);
    // The stack rests, so its velocities of 1e-12 m/s are rounding: of forces of some N on masses of some 0.1 kg, 2e-19 m/s in a step of
    // 1e-4 s, which collisions of 100 steps remember. The file was made while the run went on, and differs from its restart file by this.
    let noise = 100.0 * 2e-19;
    let heaviest = expected.iter().fold(0.0f64, |a, row| a.max(row[4]));
    for (column, of, sign, rounding) in [
        (3, 0, 1.0, 0.0),
        (4, 1, 1.0, 0.0),
        (7, 4, 1.0, heaviest * noise),
        (40, 19, 1.0, 0.0),
        (52, 22, -1.0, 0.0),
    ] {
        let largest = expected
            .iter()
            .fold(0.0f64, |a, row| a.max(row[column].abs()));
        for (point, row) in expected.iter().enumerate() {
            let found = sign * stat::values(&sums, point)[of];
            assert!(
                (found - row[column]).abs() <= 1e-9 * largest + rounding,
                "column {column} point {point}: {found} {}",
                row[column]
            );
        }
    }
}

/// The old tool gives the branch of a wall contact the distance R - delta of the wall as its length, from the contact point on, which is half an overlap
/// behind the wall: it ends half an overlap before the centre.
fn as_the_old_tool_ends(state: &State) -> State {
    let mut state = state.clone();
    let contacts = state.contacts.as_mut().unwrap();
    for k in 0..contacts.len() {
        if let Partner::Wall(_) = contacts.partner[k] {
            // The arm is R - delta/2.
            let radius = state.particles.radius[contacts.particle[k] as usize];
            contacts.arm[k] = (2.0 * contacts.arm[k].length() - radius) * contacts.normal[k];
        }
    }
    state
}

/// The state that was created anew from the set-up of the test.
fn basic_state(path: &Path) -> State {
    let text = std::fs::read_to_string(path).unwrap();
    let mut particles = Particles::default();
    let mut contacts = Contacts::default();
    let density = 6.0 / std::f64::consts::PI;
    for line in text.lines() {
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let number = |k: usize| words[k].parse::<f64>().unwrap();
        let vector = |k: usize| DVec3::new(number(k), number(k + 1), number(k + 2));
        let after = |key: &str| words.iter().position(|word| *word == key).unwrap() + 1;
        match words[0] {
            "P" => {
                let (r, inverse) = (number(after("r")), number(after("im")));
                let volume = 4.0 / 3.0 * std::f64::consts::PI * r * r * r;
                particles.id.push(particles.len() as u32);
                particles.material.push(0);
                particles.flowing.push(inverse > 0.0);
                particles.position.push(vector(1));
                particles.velocity.push(vector(after("V")));
                particles.mass.push(if inverse > 0.0 {
                    1.0 / inverse
                } else {
                    density * volume
                });
                particles.volume.push(volume);
                particles.radius.push(r);
                particles.angular_velocity.push(DVec3::ZERO);
                particles.spin.push(DVec3::ZERO);
            }
            "I" => {
                let (p, point, normal) =
                    (number(1) as usize, vector(after("C")), vector(after("n")));
                let arm = particles.position[p] - point;
                contacts.particle.push(p as u32);
                contacts.partner.push(Partner::Particle(number(2) as u32));
                contacts.point.push(point);
                contacts.arm.push(arm);
                contacts
                    .partner_arm
                    .push(arm - number(after("dist")) * normal);
                contacts.normal.push(normal);
                contacts.force.push(vector(after("F")));
            }
            _ => {}
        }
    }
    let space = Space {
        min: DVec3::new(-0.1, 0.0, -0.6),
        max: DVec3::new(1.1, 1.0, 2.1),
        ..Space::default()
    };
    State {
        time: 0.21,
        space,
        particles,
        contacts: Some(contacts),
        displacement: None,
    }
}

#[test]
fn the_basic_self_test_of_mercury_cg() {
    let Some(folder) = shared("data/selftest/cg") else {
        return;
    };
    let state = basic_state(&folder.join("derived/CGBasicSelfTest.state.txt"));
    let (x, y, z) = (axis(-0.1, 1.1, 10), axis(0.0, 1.0, 10), axis(-0.6, 2.1, 10));
    let plane = vec![axis(0.0, 1.0, 33), axis(-0.6, 2.1, 33)];
    let gauss = (KernelShape::Gaussian, 0.5 / 3.01);
    let heaviside = (KernelShape::Heaviside, 0.5 / 2.01);
    let cases = [
        (0, [false; 3], vec![], (KernelShape::Lucy, 1.0), 0),
        (
            1,
            [false, false, true],
            vec![axis(-0.6, 2.1, 1000)],
            gauss,
            0,
        ),
        (2, [false, true, true], plane.clone(), gauss, 0),
        // MercuryCG looks for points in a box along the axes and misses two of the cylinder's corners.
        (3, [true; 3], vec![x, y, z], gauss, 2),
        (
            4,
            [false, false, true],
            vec![axis(-0.6, 2.1, 1000)],
            heaviside,
            0,
        ),
        (5, [false, true, true], plane, heaviside, 0),
        (6, [true; 3], vec![x, y, z], heaviside, 0),
    ];
    for (file, resolved, grid, (shape, width), allowed) in cases {
        let evaluator = compat(
            Coordinates::Cartesian(resolved),
            Place::Grid(grid),
            shape,
            width,
        );
        let (different, rows) = rows_that_differ(
            &evaluator,
            &state,
            &folder.join(format!("CGBasicSelfTest.{file}.stat")),
        );
        assert!(
            different <= allowed,
            "file {file}: {different} of {rows} rows differ"
        );
    }
}

#[test]
fn a_square_packing_at_rest_carries_its_weight() {
    let Some(folder) = shared("data/selftest/cg") else {
        return;
    };
    let restart = read_restart(&folder.join("SquarePackingSelfTest.restart")).unwrap();
    let state = &restart.state;
    assert_eq!(
        (
            restart.particle_dimensions,
            state.particles.len(),
            state.contacts.as_ref().unwrap().len()
        ),
        (2, 25, 25)
    );
    let weight: f64 = state.particles.mass.iter().sum();
    let force: DVec3 = {
        let c = state.contacts.as_ref().unwrap();
        (0..c.len())
            .filter(|&k| matches!(c.partner[k], Partner::Wall(_)))
            .map(|k| c.force[k])
            .sum()
    };
    // Not quite at rest yet: the floor carries 7e-5 more than the weight.
    assert!((force.y / weight - 1.0).abs() < 1e-4, "{force}");
    // sigma_yy just above the floor, averaged over x: the weight above it per length, to what the kernel spreads below the floor.
    let choice = KernelChoice {
        cutoff: 8.8,
        tolerance: 1e-15,
        ..KernelChoice::new(KernelShape::Gaussian, 0.02)
    };
    let evaluator = Evaluator::new(
        Coordinates::Cartesian([false, true, false]),
        Place::Points(vec![vec![0.25], vec![4.9], vec![2.25]]),
        choice,
    );
    let sums = evaluator.sums(state, &Layout::new(&mercury_cg::fields::MERCURY_SUMS), None);
    let stress = |point: usize| stat::values(&sums, point)[11 + 4] * 5.0;
    for (point, rows) in [(0, 5.0), (2, 3.0)] {
        assert!(
            (stress(point) / (weight * rows / 5.0) - 1.0).abs() < 1.5e-4,
            "{} {}",
            stress(point),
            weight * rows / 5.0
        );
    }
    assert!(stress(1).abs() < 1e-9 * weight);
}

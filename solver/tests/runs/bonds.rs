//! Bonds in a run: frames, breaks, summary and budget agree with each other.

use std::fs;

use mercury_common::formats::table_head;
use mercury_common::frames::{BondReader, ParticleReader};
use serde_json::Value;

use crate::common::{code, errors, folder_with, solve};

const SCENE: &str = include_str!("../../../tests/scenes/good/bonds.toml");

#[test]
fn files_of_bonds_agree() {
    let folder = folder_with("glued.toml", SCENE);
    let output = solve(folder.path(), &["glued.toml", "--quiet"]);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let path = |name: &str| folder.path().join("glued").join(name);
    let summary: Value =
        serde_json::from_str(&fs::read_to_string(path("summary.json")).unwrap()).unwrap();
    let count = |entry: &str, what: &str| summary["bonds"][entry][what].as_u64().unwrap();
    // Six by five by five spheres, periodic along x.
    assert_eq!(count("glue", "made"), 150 + 2 * 6 * 4 * 5);
    assert!(count("glue", "broken") > 0 && count("foot", "made") > 0);

    let bonds = BondReader::open(path("glued.bonds.arrow")).unwrap();
    assert_eq!(bonds.layout().0, ["glue", "foot"]);
    let particles = ParticleReader::open(path("glued.particles.arrow")).unwrap();
    let frames = bonds.frames().len();
    assert_eq!(frames, particles.frames().len());
    let last = bonds.frame(frames - 1).unwrap();
    for (number, entry) in ["glue", "foot"].into_iter().enumerate() {
        let rows = last.bond.iter().filter(|bond| **bond == number as u32);
        assert_eq!(rows.count() as u64, count(entry, "left"), "{entry}");
    }
    // Both ends of a bond are centres of its particles, or lie on the floor.
    let grains = particles.frame(frames - 1).unwrap();
    for row in 0..last.len() {
        let [i, other] = last.ends(row);
        let centre = |id: u32| grains.position[grains.id.binary_search(&id).unwrap()];
        assert!(i.abs_diff_eq(centre(last.i[row]), 1e-12));
        match last.j[row] {
            None => assert!(other.z.abs() < 1e-12),
            Some(j) => {
                let way = other - centre(j);
                // Whole periods of 12 mm.
                let periods = way.x / 0.012;
                assert!((periods - periods.round()).abs() < 1e-9 && way.y.abs() < 1e-12);
            }
        }
    }

    let text = fs::read_to_string(path("glued.breaks.csv")).unwrap();
    let mut lines = text.lines();
    let names: Vec<&str> = (lines.next().unwrap().split(','))
        .map(table_head::name)
        .collect();
    let place = |name: &str| names.iter().position(|known| *known == name).unwrap();
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    let broken = count("glue", "broken") + count("foot", "broken");
    assert_eq!(rows.len() as u64, broken);
    let number = |row: &[&str], name: &str| row[place(name)].parse::<f64>().unwrap();
    assert!(rows.iter().all(|row| number(row, "energy") >= 0.0));
    assert!(
        rows.iter()
            .all(|row| ["tension", "shear"].contains(&row[place("mode")]))
    );
    assert!(rows.is_sorted_by(|a, b| number(a, "time") <= number(b, "time")));

    let dissipated = summary["energy"]["dissipated"]["bonds"].as_f64().unwrap();
    let by_breaks: f64 = rows.iter().map(|row| number(row, "energy")).sum();
    assert!(dissipated > by_breaks && by_breaks > 0.0);
    // The step is a tenth of the critical one of the bonds or less: (w dt)^2 of the energy in them.
    let closure = summary["energy"]["closure_error"].as_f64().unwrap();
    assert!(closure.abs() < 5e-3, "{closure}");
    // Every grain is in one fragment.
    let fragments = summary["fragments"].as_array().unwrap().iter();
    let grains =
        fragments.map(|one| one["grains"].as_u64().unwrap() * one["count"].as_u64().unwrap());
    assert_eq!(grains.sum::<u64>(), 150);
}

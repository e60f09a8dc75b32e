//! Tables of `[[particles]]`: spheres and clumps, and columns that are not used.

use std::fs;
use std::path::Path;

use crate::common::{code, errors, folder_with, said, solve};

const SCENE: &str = r#"
title = "Grains"
gravity = [0.0, 0.0, -9.81]
time = { end = 2e-3, step = 1e-5 }
domain = { min = [0, 0, 0], max = [0.2, 0.2, 0.2] }
output = { interval = 1e-3, pictures = false }
[materials.m]
density = 2500.0
normal = { law = "linear", stiffness = 1e4, restitution = 0.5 }
[clumps.rod]
file = "rod.clump.toml"
material = "m"
"#;

fn place(more: &str) -> tempfile::TempDir {
    let place = folder_with("grains.toml", &format!("{SCENE}{more}"));
    let rod = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/rod.clump.toml");
    fs::copy(rod, place.path().join("rod.clump.toml")).unwrap();
    place
}

#[test]
fn a_table_holds_clumps_and_spheres_as_entries_do() {
    let one_by_one = place(
        "[[particles]]\nmaterial = \"m\"\nradius = 0.01\nposition = [0.1, 0.1, 0.1]\nvelocity = [0, 0, -1]\n\
         [[particles]]\nclump = \"rod\"\nposition = [0.05, 0.05, 0.1]\norientation = [0, 0, 2, 0]\nscale = 0.5\nangular_velocity = [0, 0, 3]\n\
         [[particles]]\nclump = \"rod\"\nposition = [0.15, 0.15, 0.1]\nscale = 0.5\n",
    );
    let table = place("[[particles]]\nfile = \"all.csv\"\nmaterial = \"m\"\n");
    fs::write(
        table.path().join("all.csv"),
        "id,type,clump,x,y,z,radius,scale,qw,qx,qy,qz,vz,wz,mass\n\
         7,1,rod,0.05,0.05,0.1,,0.5,0,0,2,0,0,3,9\n\
         8,1,,0.1,0.1,0.1,0.01,,,,,,-1,0,9\n\
         9,1,rod,0.15,0.15,0.1,,0.5,1,0,0,0,0,0,9\n",
    )
    .unwrap();
    for place in [&one_by_one, &table] {
        let output = solve(place.path(), &["grains.toml"]);
        assert_eq!(code(&output), Some(0), "{}", errors(&output));
    }
    let data =
        |place: &tempfile::TempDir| fs::read(place.path().join("grains/grains.data")).unwrap();
    assert!(data(&one_by_one) == data(&table));
    // Columns that are not read are reported, once.
    let output = solve(table.path(), &["grains.toml", "--check"]);
    let reported = said(&output);
    let notice = "all.csv: not needed and not read: id, type, mass";
    assert_eq!(reported.matches(notice).count(), 1, "{reported}");
}

#[test]
fn wrong_rows_are_reported() {
    for (row, part) in [
        (
            "rodd,,",
            "all.csv:2: there is no clump named `rodd`; did you mean `rod`?",
        ),
        (
            "rod,,m",
            "the clump `rod` has the material `m` here: leave the cell empty",
        ),
        ("rod,0.1,", ""),
        (",,", "\"\" in column radius"),
    ] {
        let place = place("[[particles]]\nfile = \"all.csv\"\nmaterial = \"m\"\n");
        let text = format!("x,y,z,clump,radius,material\n0.1,0.1,0.1,{row}\n");
        fs::write(place.path().join("all.csv"), text).unwrap();
        let output = solve(place.path(), &["grains.toml", "--check"]);
        // A radius beside a clump has no effect and does no harm.
        let expected = if part.is_empty() { 0 } else { 2 };
        assert_eq!(code(&output), Some(expected), "{row}: {}", errors(&output));
        assert!(errors(&output).contains(part), "{}", errors(&output));
    }
}

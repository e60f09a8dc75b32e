//! Files of particles, contacts, energies, pebbles and surfaces.

use std::fs;
use std::path::Path;

use mercury_common::formats::data::DataReader;
use mercury_common::formats::ene::EnergyReader;
use mercury_common::formats::fstat::FstatReader;
use mercury_common::formats::mesh::{read_mesh, read_mesh_welded};
use mercury_common::formats::particle_csv::parse_particle_csv;
use mercury_common::formats::pebble_list::read_pebble_list;
use mercury_common::formats::vtu::PvdWriter;
use mercury_engine::walls::MotionTable;

use super::{KB, MB, Reader};
use crate::checks::{said, say};
use crate::mutate::Make::{Binary, Text};
use crate::place::{Place, file};

pub(super) const READERS: &[Reader] = &[
    Reader::new("data", Text(&["#", "0"]), data_samples, data).bound(
        512 * KB,
        32,
        "a row of 112 bytes from 16 (`0 0 0 0 0 0 0 0`), three times while the list grows; the line; two buffers",
    ),
    Reader::new("fstat", Text(&["#", "# 0 1", "-1"]), fstat_samples, fstat).bound(
        512 * KB,
        24,
        "a row of 152 bytes from 32, three times while the list grows; the line; two buffers",
    ),
    Reader::new("ene", Text(&["time", "t", "#"]), ene_samples, ene).bound(
        64 * KB,
        4,
        "one line at a time, twice while it grows",
    ),
    Reader::new(
        "particle-csv",
        Text(&["x", "y", "z", "radius", "material", "vx", "wx", "film_volume", "\"a,b\"", ";", "\t", "x [mm]", "wx (rpm)", "["]),
        csv_samples,
        csv,
    )
    .bound(
        64 * KB,
        72,
        "the text; a row of 144 bytes and the name of a material from 8 (`0,0,0,1`), three times while the list grows",
    ),
    Reader::new(
        "pebble-list",
        Text(&["x", "y", "z", "r", "radius", "//", "%", "#", ";"]),
        pebble_samples,
        pebbles,
    )
    .bound(
        64 * KB,
        80,
        "the text; cells of 24 bytes from 1 (`,`), three times while the list grows; or a pebble of 32 bytes from 8",
    ),
    Reader::new("stl", Binary, stl_binary_samples, |bytes, place| {
        mesh(bytes, place, "mesh.stl");
    })
    .bound(MB, 32, MESH),
    Reader::new(
        "stl-text",
        Text(&[
            "solid", "facet", "normal", "outer", "loop", "vertex", "endloop", "endfacet", "endsolid", "end", "color", "#", "\r", "1.0D+00",
            "-1.#IND",
        ]),
        stl_text_samples,
        |bytes, place| mesh(bytes, place, "mesh.stl"),
    )
    .bound(MB, 64, MESH),
    Reader::new(
        "obj",
        Text(&["v", "f", "vn", "1/1", "1//1", "-1", "g", "\\\n", "#", "\r", "1.0D+00"]),
        obj_samples,
        |bytes, place| mesh(bytes, place, "mesh.obj"),
    )
    .bound(MB, 96, MESH),
    Reader::new(
        "motion-table",
        Text(&["t", "x", "y", "z", "angle_x", "angle_y", "angle_z", "#"]),
        |_| vec![file("tests/scenes/good/lift.csv"), file("scenes/motion.csv")],
        motion,
    )
    .bound(64 * KB, 32, "the text, twice; a row of 56 bytes from 8, three times while the list grows"),
    Reader::new(
        "pvd",
        Text(&["<DataSet ", "<Collection>", "</Collection>", "/>"]),
        |place| vec![place.of_run("vtk/scene.particles.pvd")],
        pvd,
    )
    .bound(64 * KB, 8, "the text; a slice of 16 bytes for each line that begins `    <DataSet `, three times while the list grows"),
];

const MESH: &str = "the file; a triangle of 12 bytes and corners of 24 each from the fewest bytes that the format needs for them, three times \
while the lists grow; each corner once more in the table of places, with 60 bytes";

fn data_samples(place: &Place) -> Vec<Vec<u8>> {
    let two = "2 0 0 0 1 1\n0.25 0.5 1 2 0.1 0.5 -1 0\n0.75 0.5 1e-3 2 0.1 0 0 1\n1 0.1 0 0 1 1\n0.25 0.5 1 2 0.1 0.5 -1 0\n";
    let seven = "1 0 -1 -1 0 1 1 3\n0 0.5 0.1 1 2 3 0.5 0\n";
    let fifteen = "1 0 -1 -1 0 1 1 3\n0 0 0.5 0 0 0 0.5 0 0 0 0 0 0 7 0\n";
    vec![
        place.of_run("scene.data"),
        two.into(),
        seven.into(),
        fifteen.into(),
    ]
}

fn data(bytes: &[u8], _: &Place) {
    for frame in DataReader::new(bytes, "a.data") {
        said(frame);
    }
}

fn fstat_samples(place: &Place) -> Vec<Vec<u8>> {
    let small = "# 0 1\n# -1 -1 0 1 1 3\n# 0.5 0.5 0 0 0 0\n0 0 1 0 0 0.995 0.002 0 2 0 0 0 -1 0 0 0\n\
                 0 0 -1 0 0 -0.002 0.004 0 4 0 0 0 -1 0 0 0\n# 1 1\n# -1 -1 0 1 1 3\n# 0.5 0.5 0 0 0 0\n";
    vec![place.of_run("scene.fstat"), small.into()]
}

fn fstat(bytes: &[u8], _: &Place) {
    for frame in FstatReader::new(bytes, "a.fstat") {
        said(frame);
    }
}

fn ene_samples(place: &Place) -> Vec<Vec<u8>> {
    vec![place.of_run("scene.ene")]
}

fn ene(bytes: &[u8], _: &Place) {
    for row in EnergyReader::new(bytes, "a.ene") {
        said(row);
    }
}

fn csv_samples(_: &Place) -> Vec<Vec<u8>> {
    vec![
        file("tests/scenes/good/some.csv"),
        file("scenes/particles.csv"),
        b"x;y;z;radius;material\n0;0;0;1;\"a;b\"\n0;0;1;1;\n".to_vec(),
        b"x [mm],y (um),z,radius [cm],wx [rpm],mass [kg]\n1,2,3,4.5,6,7\n".to_vec(),
    ]
}

fn csv(bytes: &[u8], place: &Place) {
    if let Ok(text) = std::str::from_utf8(bytes) {
        said(parse_particle_csv(Path::new("a.csv"), text));
    } else {
        let path = place.write("a.csv", bytes);
        let result = mercury_common::formats::particle_csv::read_particle_csv(path);
        say(&result.expect_err("bytes that are no text are no table"));
    }
}

fn pebble_samples(_: &Place) -> Vec<Vec<u8>> {
    vec![
        b"x,y,z,r\n0,0,0,1\n1,0.5,-2.5e-3,0.5\n".to_vec(),
        b"# list\n0 0 0 1 // one\n1 0 0 1\n% none\n0.5 1 0 1\n".to_vec(),
        b"r;z;y;x\n0.5;3e-3;-2.5;1;\n2;0;0;0;".to_vec(),
    ]
}

fn pebbles(bytes: &[u8], place: &Place) {
    let path = place.write("p.csv", bytes);
    if let Some(pebbles) = said(read_pebble_list(&path)) {
        let _ = mclump::sizes::pebble_problem(&pebbles);
        if let Ok(text) = std::str::from_utf8(bytes) {
            let last = pebbles.len() - 1;
            let line = mclump::sizes::line_of_pebble(&path, text, last);
            assert!(line.is_some(), "a pebble without a line");
        }
    }
}

fn stl_binary_samples(_: &Place) -> Vec<Vec<u8>> {
    let tetrahedron = mercury_common::formats::mesh::TriangleMesh {
        vertices: [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
        ]
        .map(glam::DVec3::from_array)
        .to_vec(),
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        ..Default::default()
    };
    let mut out = Vec::new();
    mercury_common::formats::mesh::push_binary_stl(&tetrahedron, &mut out)
        .expect("small numbers are in single precision");
    let mut solid = out.clone();
    solid[..5].copy_from_slice(b"solid");
    vec![out, solid, file("scenes/plate.stl")]
}

fn stl_text_samples(_: &Place) -> Vec<Vec<u8>> {
    let facet = |z: f64| {
        format!(
            " facet normal 0 0 1\n  outer loop\n   vertex 0 0 {z}\n   vertex 1 0 {z}\n   vertex 0 1.5e0 {z}\n  endloop\n endfacet\n"
        )
    };
    let one = format!("solid a b c\n{}{}endsolid a b c\n", facet(0.0), facet(1.0));
    let two = format!("{one}solid\n{}endsolid\n", facet(-1e-3));
    vec![one.into_bytes(), two.into_bytes()]
}

fn obj_samples(_: &Place) -> Vec<Vec<u8>> {
    vec![
        file("tests/scenes/good/bin.obj"),
        b"v 0 0 0\nv 3 0 0\nv 0 2 0\nv 0 0 1\nf 1/1/1 3//2 2\nf -4 -3 -1 -2\nvn 0 0 1\nf 2 3 4\nv 1 1 1\n"
            .to_vec(),
    ]
}

/// Reads meshes as for walls, and prepares them as `mclump` does.
fn mesh(bytes: &[u8], place: &Place, name: &str) {
    let path = place.write(name, bytes);
    let Some(mesh) = said(read_mesh(&path)) else {
        return;
    };
    let _ = mesh.degenerate_triangles();
    let size = mesh
        .bounds()
        .map_or(0.0, |(low, high)| (high - low).length());
    if size.is_finite() {
        said(read_mesh_welded(&path, 1e-6 * size));
    }
    if mclump::sizes::surface_problem(&mesh).is_none() {
        let _ = mclump::surface::prepare(mesh, true);
    }
}

fn motion(bytes: &[u8], place: &Place) {
    said(MotionTable::read(&place.write("motion.csv", bytes)));
}

fn pvd(bytes: &[u8], place: &Place) {
    let path = place.write("a.pvd", bytes);
    for entries in [0, 2] {
        said(PvdWriter::resume(&path, entries));
        let _ = fs::write(&path, bytes);
    }
}

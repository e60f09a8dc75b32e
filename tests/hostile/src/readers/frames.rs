//! Native frames: each table of a run by the generic reader and by its own.

use std::path::Path;

use glam::DVec3;

use mercury_common::frames::{
    BodyReader, BondFrame, BondNames, BondReader, BondWriter, ContactReader, FrameReader,
    FramesHeader, MembraneFrame, MembraneReader, MembraneTriangleFrame, MembraneTriangleReader,
    ParticleReader, Table, TableReader, TableWriter, TriangleLoadReader, WallReader, WearReader,
    WearTriangleReader, sheets,
};

use super::{MB, Reader};
use crate::checks::{said, say};
use crate::mutate::Make::Binary;
use crate::place::Place;

const WHY: &str = "the columns of a frame as values: bits of missing values become a byte and a place of eight, the offset of a text (4 bytes) becomes \
a text of 24; in the schema, a field (some 40 bytes) becomes some hundreds, three times while the list grows";

pub(super) const READERS: &[Reader] = &[
    Reader::new(
        "frames-particles",
        Binary,
        |place| of(place, "particles"),
        |bytes, place| {
            let path = place.write("a.particles.arrow", bytes);
            generic(&path);
            all(ParticleReader::open(&path));
        },
    )
    .bound(MB, 64, WHY),
    Reader::new(
        "frames-contacts",
        Binary,
        |place| of(place, "contacts"),
        |bytes, place| {
            all(ContactReader::open(place.write("a.contacts.arrow", bytes)));
        },
    )
    .bound(MB, 64, WHY),
    Reader::new(
        "frames-bonds",
        Binary,
        |place| vec![bond_file(place)],
        |bytes, place| {
            all(BondReader::open(place.write("a.bonds.arrow", bytes)));
        },
    )
    .bound(MB, 64, WHY),
    Reader::new(
        "frames-bodies",
        Binary,
        |place| of(place, "bodies"),
        |bytes, place| {
            let path = place.write("a.bodies.arrow", bytes);
            all(BodyReader::open_alone(&path));
            all(BodyReader::open(&path));
        },
    )
    .bound(MB, 64, WHY),
    Reader::new("frames-walls", Binary, with_surfaces, |bytes, place| {
        all(WallReader::open(place.write("a.walls.arrow", bytes)));
    })
    .bound(MB, 64, WHY),
    Reader::new(
        "frames-surfaces",
        Binary,
        |place| {
            place.write("b.walls.arrow", &place.of_run("scene.walls.arrow"));
            of(place, "surfaces")
        },
        |bytes, place| {
            place.write("b.surfaces.arrow", bytes);
            all(WallReader::open(place.path("b.walls.arrow")));
        },
    )
    .bound(MB, 64, WHY),
    Reader::new(
        "frames-triangle-loads",
        Binary,
        |place| of(place, "triangle_loads"),
        |bytes, place| {
            all(TriangleLoadReader::open(
                place.write("a.triangle_loads.arrow", bytes),
            ));
        },
    )
    .bound(MB, 64, WHY),
    Reader::new(
        "frames-wear",
        Binary,
        |place| of(place, "wear"),
        |bytes, place| {
            all(WearReader::open(place.write("a.wear.arrow", bytes)));
        },
    )
    .bound(MB, 64, WHY),
    Reader::new(
        "frames-wear-triangles",
        Binary,
        |place| of(place, "wear_triangles"),
        |bytes, place| {
            all(WearTriangleReader::open(
                place.write("a.wear_triangles.arrow", bytes),
            ));
        },
    )
    .bound(MB, 64, WHY),
    Reader::new(
        "frames-membranes",
        Binary,
        |place| vec![sheet_files(place)[0].clone()],
        |bytes, place| {
            let path = place.write("a.membranes.arrow", bytes);
            let reader = MembraneReader::open(&path);
            // Both tables together, as pictures read them.
            let triangles = sheet_frames().1;
            if let Some(frame) = said(reader).and_then(|reader| said(reader.frame(0))) {
                let _ = sheets(&frame, &triangles);
            }
            all(MembraneReader::open(&path));
        },
    )
    .bound(MB, 64, WHY),
    Reader::new(
        "frames-membrane-triangles",
        Binary,
        |place| vec![sheet_files(place)[1].clone()],
        |bytes, place| {
            let path = place.write("a.membrane_triangles.arrow", bytes);
            let vertices = sheet_frames().0;
            let reader = MembraneTriangleReader::open(&path);
            if let Some(frame) = said(reader).and_then(|reader| said(reader.frame(0))) {
                let _ = sheets(&vertices, &frame);
            }
            all(MembraneTriangleReader::open(&path));
        },
    )
    .bound(MB, 64, WHY),
];

/// A file of two bonds, one of them to a wall.
pub(super) fn bond_file(place: &Place) -> Vec<u8> {
    let path = place.path("s.bonds.arrow");
    let names = BondNames(vec!["glue".to_owned()]);
    let frame = BondFrame {
        time: 0.5,
        step: 7,
        i: vec![0, 1],
        j: vec![Some(1), None],
        wall: vec![None, Some(0)],
        bond: vec![0; 2],
        force: vec![DVec3::X; 2],
        couple: vec![DVec3::Z; 2],
        tension: vec![1e5, -2e5],
        shear: vec![5e4; 2],
        middle: vec![DVec3::ZERO; 2],
        branch: vec![DVec3::X; 2],
    };
    BondWriter::create(&path, &FramesHeader::default(), &names)
        .and_then(|mut writer| writer.append(frame))
        .expect("a folder of our own can be written");
    std::fs::read(&path).expect("it was written")
}

/// A sheet of two triangles.
fn sheet_frames() -> (MembraneFrame, MembraneTriangleFrame) {
    let corner = |k: u32| DVec3::new(f64::from(k & 1), f64::from(k >> 1), 0.1 * f64::from(k));
    let vertices = MembraneFrame {
        time: 0.5,
        step: 7,
        membrane: vec![0; 4],
        vertex: (0..4).collect(),
        state: vec![1, 0, 0, 1],
        mass: vec![1e-3; 4],
        position: (0..4).map(corner).collect(),
        velocity: vec![DVec3::ZERO; 4],
        force: vec![DVec3::Z; 4],
    };
    let triangles = MembraneTriangleFrame {
        time: 0.5,
        step: 7,
        membrane: vec![0; 2],
        triangle: vec![0, 1],
        corners: [vec![0, 1], vec![1, 3], vec![2, 2]],
        area: vec![0.5; 2],
        tensions: [vec![2.0; 2], vec![1.0; 2]],
        load: vec![DVec3::ZERO; 2],
    };
    (vertices, triangles)
}

/// The files of both tables.
fn sheet_files(place: &Place) -> [Vec<u8>; 2] {
    fn file<T: Table<Layout = ()>>(place: &Place, name: &str, frame: T) -> Vec<u8> {
        let path = place.path(name);
        let writer = TableWriter::create(&path, &FramesHeader::default(), &());
        writer
            .and_then(|mut writer: TableWriter<T>| writer.append(frame))
            .expect("a folder of our own can be written");
        std::fs::read(&path).expect("it was written")
    }
    let (vertices, triangles) = sheet_frames();
    [
        file(place, "s.membranes.arrow", vertices),
        file(place, "s.membrane_triangles.arrow", triangles),
    ]
}

fn of(place: &Place, kind: &str) -> Vec<Vec<u8>> {
    vec![place.of_run(&format!("scene.{kind}.arrow"))]
}

fn with_surfaces(place: &Place) -> Vec<Vec<u8>> {
    place.write("a.surfaces.arrow", &place.of_run("scene.surfaces.arrow"));
    of(place, "walls")
}

/// Reads all frames, one at a time.
fn all<T: Table>(reader: Result<TableReader<T>, mercury_common::error::FormatError>) {
    let Some(reader) = said(reader) else { return };
    for k in 0..reader.frames().len() {
        said(reader.frame(k));
    }
    if let Some(damage) = reader.frames().damage() {
        say(damage);
    }
}

fn generic(path: &Path) {
    let Some(mut reader) = said(FrameReader::open(path)) else {
        return;
    };
    reader.refresh();
    for frame in reader.frames() {
        said(frame);
    }
}

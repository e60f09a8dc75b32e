//! Native frames: each table of a run by the generic reader and by its own.

use std::path::Path;

use mercury_common::frames::{
    BodyReader, ContactReader, FrameReader, ParticleReader, Table, TableReader, TriangleLoadReader,
    WallReader, WearReader, WearTriangleReader,
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
];

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

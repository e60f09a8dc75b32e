//! Readers of `mercury-cg`: `.data` with `.fstat`, compressed too, restart files of MercuryDPM, runs, points; and its fields of
//! them.

use std::io::{Read as _, Write as _};
use std::path::Path;

use flate2::Compression;
use flate2::read::MultiGzDecoder;
use flate2::write::GzEncoder;
use mercury_cg::input::{FrameChoice, Given, Needs, Source, read_restart};
use mercury_cg::options::{Cells, Width};
use mercury_cg::output::push_table;
use mercury_cg::setup::Wanted;
use mercury_cg::state::State;

use super::{MB, Reader};
use crate::checks::{said, say};
use crate::mutate::Make::{Binary, Text};
use crate::mutate::Random;
use crate::place::Place;

const ALL: Needs = Needs {
    mass: true,
    contacts: true,
    couples: false,
    rotation: false,
    identity: true,
    liquid: false,
};

const WHY: &str = "a particle of some 200 bytes from 16, three times while lists grow; of a compressed file the unpacked size counts, and a line \
of at most 16 MiB, twice while it grows";

pub(super) const READERS: &[Reader] = &[
    Reader::new(
        "cg-data",
        Text(&["0", "#"]),
        |place| {
            place.write("a.fstat", &place.of_run("scene.fstat"));
            vec![place.of_run("scene.data"), MINI_DATA.into()]
        },
        |bytes, place| {
            place.write("a.data", bytes);
            states(place, "a.data", ALL);
        },
    )
    .bound(2 * MB, 64, WHY),
    Reader::new(
        "cg-fstat",
        Text(&["#", "-1", "0"]),
        |place| {
            place.write("b.data", &place.of_run("scene.data"));
            vec![place.of_run("scene.fstat"), MINI_FSTAT.into()]
        },
        |bytes, place| {
            place.write("b.fstat", bytes);
            states(place, "b.data", ALL);
        },
    )
    .bound(2 * MB, 64, WHY),
    Reader::new(
        "cg-data-compressed",
        Text(&["0", "#"]),
        |place| {
            place.write("c.fstat.gz", &packed(&place.of_run("scene.fstat")));
            vec![place.of_run("scene.data"), MINI_DATA.into()]
        },
        |bytes, place| {
            place.write("c.data.gz", bytes);
            states(place, "c.data.gz", ALL);
        },
    )
    .bound(60 * MB, 64, WHY)
    .sized(unpacked)
    .wrapped(pack),
    Reader::new("restart", Text(RESTART), restart_samples, |bytes, place| {
        said(read_restart(&place.write("a.restart", bytes)));
    })
    .bound(
        MB,
        64,
        "a particle of some 250 bytes from 100, three times while lists grow; the line",
    ),
    Reader::new(
        "restart-compressed",
        Text(RESTART),
        restart_samples,
        |bytes, place| {
            said(read_restart(&place.write("b.restart", bytes)));
        },
    )
    .bound(60 * MB, 64, WHY)
    .sized(unpacked)
    .wrapped(pack),
    Reader::new(
        "cg-run",
        Binary,
        |place| {
            for kind in ["contacts", "bodies"] {
                place.write(
                    &format!("d.{kind}.arrow"),
                    &place.of_run(&format!("scene.{kind}.arrow")),
                );
            }
            vec![place.of_run("scene.particles.arrow")]
        },
        |bytes, place| {
            place.write("d.particles.arrow", bytes);
            states(place, "d.particles.arrow", ALL);
        },
    )
    .bound(
        2 * MB,
        128,
        "the columns of a frame as values, then as particles with places by number",
    ),
    Reader::new(
        "cg-run-contacts",
        Binary,
        |place| {
            for kind in ["particles", "bodies"] {
                place.write(
                    &format!("e.{kind}.arrow"),
                    &place.of_run(&format!("scene.{kind}.arrow")),
                );
            }
            vec![place.of_run("scene.contacts.arrow")]
        },
        |bytes, place| {
            place.write("e.contacts.arrow", bytes);
            states(place, "e.particles.arrow", ALL);
        },
    )
    .bound(
        2 * MB,
        128,
        "the columns of a frame as values, then as contacts",
    ),
    Reader::new(
        "cg-points",
        Text(&["x", "y,z", "#", ","]),
        |_| vec![b"x,y,z\n0,0.5,1\n1e-3,2,3\n".to_vec(), b"# points\n0 0 0\n\t1 2 3\n\n4 5 6".to_vec()],
        points,
    )
    .bound(
        MB,
        64,
        "the text; a point of 24 bytes and a list of 24 from 6 bytes (`0 0 0`), three times while the list grows; or a word of 16 and a number of 8 \
        from 2 bytes, three times, if all stand on one line",
    ),
    Reader::new(
        "cg-fields",
        Text(&["0", "#"]),
        |place| {
            place.write("f.fstat", &place.of_run("scene.fstat"));
            vec![place.of_run("scene.data"), MINI_DATA.into()]
        },
        |bytes, place| fields(&place.write("f.data", bytes)),
    )
    .bound(
        16 * MB,
        256,
        "a state; where its particles are in the grid; 27 points of 40 fields for each material, of which there is at most one for each particle",
    ),
];

const MINI_DATA: &str =
    "2 0 -1 -1 0 1 1 3\n0 0 0.496 0 0 0 0.5 0 0 0 0 0 0 0\n0 0 1.494 0 0 0 0.5 0 0 0 0 0 0 0\n";
const MINI_FSTAT: &str = "# 0 1\n# -1 -1 0 1 1 3\n# 0.5 0.5 0 0 0 0\n0 0 1 0 0 0.995 0.002 0 2 0 0 0 -1 0 0 0\n\
                          0 1 0 0 0 0.995 0.002 0 2 0 0 0 1 0 0 0\n0 0 -1 0 0 -0.002 0.004 0 4 0 0 0 -1 0 0 0\n";

const RESTART: &[&str] = &[
    "Species",
    "Particles",
    "Interactions",
    "Boundaries",
    "density",
    "radius",
    "position",
    "invMass",
    "particleIds",
    "particleWallIds",
    "MercuryDPM",
    "xMin",
    "timeStep",
    "contactPoint",
    "normal",
    "PeriodicBoundary",
    "id",
];

fn restart_samples(_: &Place) -> Vec<Vec<u8>> {
    let text = "MercuryDPM 1.0 name Mini\nxMin -1 xMax 1 yMin -1 yMax 1 zMin 0 zMax 3\ntimeStep 1e-4 time 0.5\n\
        systemDimensions 3 particleDimensions 3 gravity 0 0 -2\nSpecies 1\nLinearViscoelasticSpecies id 0 density 2\nWalls 0\nBoundaries 1\n\
        PeriodicBoundary id 0 normal 1 0 0 distanceLeft -1 distanceRight 1\nParticles 2\n\
        BaseParticle id 3 indSpecies 0 position 0 0 0.5 velocity 1 2 3 angularVelocity 0 0 1 radius 0.5 invMass 0.5\n\
        BaseParticle id 4 indSpecies 0 position 0 0 1.5 velocity 1 2 3 angularVelocity 0 0 1 radius 0.5 invMass 0.5\nInteractions 2\n\
        LinearViscoelasticInteraction particleIds 3 4 contactPoint 0 0 1 normal 0 0 1 distance 1 overlap 0 force 0 0 4 torque 0 0 0\n\
        LinearViscoelasticInteraction particleWallIds 3 0 contactPoint 0 0 0 normal 0 0 1 distance 0.5 overlap 0 force 0 0 4 torque 0 0 0\n";
    vec![text.into(), text.replace("1.0 name", "0.14 name").into()]
}

fn packed(plain: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(plain).expect("memory takes it");
    encoder.finish().expect("memory takes it")
}

/// Compressed; now and then damaged afterwards, or a bomb: a great deal of one byte.
fn pack(random: &mut Random, plain: Vec<u8>) -> Vec<u8> {
    let plain = if random.one_in(30) {
        let byte = *random.pick(b" 0\n#\0");
        let mut bomb = plain;
        bomb.resize(bomb.len() + (1 << 20 << random.below(6)), byte);
        bomb
    } else {
        plain
    };
    let mut file = packed(&plain);
    if random.one_in(6) {
        let at = random.below(file.len());
        file[at] ^= 1 << random.below(8);
    }
    if random.one_in(10) {
        file.extend_from_within(..);
    }
    file
}

/// Size of a compressed file's content, as far as it can be unpacked; of the file itself, if it is none.
fn unpacked(bytes: &[u8]) -> u64 {
    let mut decoder = MultiGzDecoder::new(bytes);
    let (mut size, mut block) = (0, [0; 1 << 14]);
    while let Ok(length @ 1..) = decoder.read(&mut block) {
        size += length as u64;
    }
    size.max(bytes.len() as u64)
}

fn states(place: &Place, name: &str, needs: Needs) {
    let given = Given {
        density: Some(2500.0),
        ..Given::default()
    };
    let Some(source) = said(Source::open(&place.path(name), &given, needs)) else {
        return;
    };
    for state in source.states(FrameChoice::All) {
        said(state);
    }
    for state in source.states(FrameChoice::Last) {
        said(state);
    }
}

/// Reads points as `mercury-cg --points` does.
fn points(bytes: &[u8], place: &Place) {
    let wanted = Wanted {
        width: Some(Width::Metres(0.1)),
        points: Some(place.write("points.csv", bytes)),
        ..Wanted::default()
    };
    said(wanted.analysis(&[], &State::default(), Vec::new()));
}

/// Computes fields as `mercury-cg` does, on a small grid.
fn fields(path: &Path) {
    let wanted = Wanted {
        grid: Some(Cells(vec![3, 3, 3])),
        by_material: true,
        ..Wanted::default()
    };
    let given = Given {
        density: Some(2500.0),
        ..Given::default()
    };
    let Some((source, fields)) = said(wanted.open(path, &given)) else {
        return;
    };
    let Some(first) = source.states(FrameChoice::All).next().and_then(said) else {
        return;
    };
    let Some(analysis) = said(wanted.analysis(source.materials(), &first, fields)) else {
        return;
    };
    let mut text = Vec::new();
    // Each frame takes its time, however small it is.
    let states = source.states(FrameChoice::All).take(100);
    let computed = analysis.run(states, |block| {
        text.clear();
        push_table(&mut text, &analysis, &block, true, false);
        Ok(())
    });
    if let Some((_, Some(damage))) = said(computed) {
        say(&damage);
    }
}

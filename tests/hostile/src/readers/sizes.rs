//! Tables and lists of sizes, and run folders as `mercury-psd` reads them.

use mercury_common::scene::Weighting;
use mercury_common::sizes::SizeDistribution;
use mercury_common::sizes::table::{Content, Options, SizeKind, ValueKind, read_content};
use mercury_psd::check::run::{Run, Selection};
use mercury_psd::input;

use super::{MB, Reader};
use crate::checks::said;
use crate::mutate::Make::{Binary, Text};
use crate::place::{Place, file};

const WORDS: &[&str] = &[
    "diameter [mm]",
    "radius [m]",
    "sieve [um]",
    "cumulative volume [%]",
    "fraction number [-]",
    "retained mass [g]",
    "cumulative retained mass [g]",
    "count",
    "pan",
    "# in-class: number-uniform",
    "\"",
    ";",
    "\t",
    "Q3",
];

pub(super) const READERS: &[Reader] = &[
    Reader::new("size-table", Text(WORDS), samples, table).bound(
        MB,
        300,
        "the text; a row from 4 bytes (`1,0`): cells, row, edge, share, sums of powers, some 200 bytes, three times while lists grow",
    ),
    Reader::new("sizes-argument", Text(&["{", "}", "kind", "=", "\"lognormal\"", "median_diameter", "sigma", ",", "weighting"]), |_| {
        vec![b"{ kind = \"lognormal\", median_diameter = 1e-3, sigma = 0.3, weighting = \"volume\" }".to_vec()]
    }, |bytes, _| {
        let text = String::from_utf8_lossy(bytes);
        // Without a brace it is the name of a file.
        if text.trim_start().starts_with('{') {
            said(input::read(&text, &Options::default()));
        }
    })
    .bound(8 * MB, 800, "TOML's tree and the scene's: some 300 bytes for a key of 4 (`a=1`), three times while tables grow"),
    Reader::new("sizes-parquet", Binary, |place| {
        let path = place.path("sizes.parquet");
        mercury_psd::parquet::write(&path, "diameter [mm],cumulative volume [%]\n1,0\n2,40\n3,100\n").expect("a table");
        vec![std::fs::read(path).expect("written above")]
    }, |bytes, place| {
        let path = place.write("sizes.parquet", bytes);
        said(input::read(&path.to_string_lossy(), &Options::default()));
    })
    .bound(130 * MB, 4000, super::tables::PARQUET),
    Reader::new("psd-run-frames", Binary, |place| {
        let _ = std::fs::create_dir(place.path("sized"));
        place.write("sized/plan.toml", &place.of_run("plan.toml"));
        vec![place.of_run("scene.particles.arrow")]
    }, |bytes, place| {
        place.write("sized/scene.particles.arrow", bytes);
        run(place);
    })
    .bound(MB, 96, "the columns of a frame as values; pages of 512 bytes for the ids that were seen"),
    Reader::new("psd-run-plan", Text(&["[[insertions]]", "mixture", "psd", "kind", "\"classes\"", "at_start", "total", "number_share"]), |place| {
        let _ = std::fs::create_dir(place.path("sized"));
        place.write("sized/scene.particles.arrow", &place.of_run("scene.particles.arrow"));
        vec![place.of_run("plan.toml")]
    }, |bytes, place| {
        place.write("sized/plan.toml", bytes);
        run(place);
    })
    .bound(8 * MB, 800, "TOML's tree and the scene's: some 300 bytes for a key of 4 (`a=1`), three times while tables grow"),
];

fn samples(_: &Place) -> Vec<Vec<u8>> {
    vec![
        file("tests/scenes/good/sizes.csv"),
        file("scenes/grain.psd.csv"),
        b"diameter [mm],cumulative volume [%]\n1,0\n2,40\n3,100\n".to_vec(),
        b"# in-class: number-uniform\nradius [um];fraction number [-]\n1;0\n2;0,5\n4;0,5\n"
            .to_vec(),
        b"diameter [mm]\n1.5\n1.6\n2\n".to_vec(),
        b"diameter [mm]\tcount [count]\n1\t0\n2\t17\n3\t4\n".to_vec(),
        b"1 0\n2 0.5\n3 1\n".to_vec(),
        b"sieve [mm],cumulative retained mass [g]\n2,0\n1,40\npan,100\n".to_vec(),
    ]
}

fn table(bytes: &[u8], place: &Place) {
    let path = place.write("sizes.csv", bytes);
    let reported = Options {
        size: Some(SizeKind::Diameter),
        per_metre: Some(1e3),
        values: Some((ValueKind::Cumulative, Weighting::Volume)),
        model: None,
        mercury: true,
    };
    for options in [Options::default(), reported] {
        let Some(Content::Table(table)) = said(read_content(&path, &options)) else {
            continue;
        };
        let sizes = SizeDistribution::from_classes(table.classes, table.weighting);
        for u in [0.0, 0.5, 0.999] {
            let diameter = sizes.sample_diameter(u);
            assert!(
                diameter.is_finite() && diameter >= 0.0,
                "drew the diameter {diameter}"
            );
        }
    }
}

fn run(place: &Place) {
    let Some(run) = said(Run::open(&place.path("sized"))) else {
        return;
    };
    said(run.sizes(&Selection::default()));
    said(run.sizes(&Selection {
        at: Some(0.002),
        place: Vec::new(),
    }));
    said(run.targets());
}

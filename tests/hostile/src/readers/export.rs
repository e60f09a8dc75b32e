//! Readers of `mercury-export` beside those of other programs: scripts of XBalls, series of `.data`, runs with all their tables;
//! and its exports of them.

use std::path::Path;

use mercury_common::formats::vtu::VtuOptions;
use mercury_export::output::Output;
use mercury_export::sinks::pictures::{BondStress, PictureChoice, PictureKind, Pictures};
use mercury_export::sinks::{self, Density, Vtu, VtuChoice, Xballs, XballsChoice};
use mercury_export::{ClumpsAs, FrameChoice, Job, Selection, Sink, Source, Table, export};
use mercury_pictures::{ColourMap, Options};

use super::frames::bond_file;
use super::{MB, Reader};
use crate::checks::{said, say};
use crate::mutate::Make::{Binary, Text};
use crate::place::Place;

pub(super) const READERS: &[Reader] = &[
    Reader::new("xballs-script", Text(&["-f", "-format", "-s", "-oh", "-moh", "-cmode", "'", "\"", "\\", "xballs"]), |place| {
        place.write("a.data", &place.of_run("scene.data"));
        vec![
            b"#!/bin/bash\ncd \"$(dirname \"$0\")\" || exit 1\n\"${XBALLS:-xballs}\" -format 14 -f 'a.data' -s 1.2 -cmode 8 -cmax -sort -oh 500 -mo 3 \"$@\"\n".to_vec(),
            b"../xballs -format 8 -f a.data -s 0.1 -cmode 8\n".to_vec(),
        ]
    }, |bytes, place| {
        let path = place.write("a.disp", bytes);
        frames(&path);
    })
    .bound(2 * MB, 64, "the text, and once more where it is no UTF-8; a word of 24 bytes and its own allocation from 2, three times while the list grows"),
    Reader::new("export-data", Text(&["0", "#"]), |place| {
        place.write("b.data.1", &place.of_run("scene.data"));
        vec![place.of_run("scene.data")]
    }, |bytes, place| frames(&place.write("b.data.0", bytes)))
    .bound(MB, 96, "a row of 112 bytes from 16, three times while the list grows, then its columns"),
    Reader::new("export-run", Binary, |place| {
        for kind in ["contacts", "bodies", "walls", "surfaces", "triangle_loads", "wear"] {
            place.write(&format!("c.{kind}.arrow"), &place.of_run(&format!("scene.{kind}.arrow")));
        }
        vec![place.of_run("scene.particles.arrow")]
    }, |bytes, place| frames(&place.write("c.particles.arrow", bytes)))
    .bound(MB, 64, "the columns of a frame as values; the schema, once more for each frame"),
    Reader::new("export-files", Binary, |place| beside(place, "d"), |bytes, place| {
        each_kind(&place.write("d.particles.arrow", bytes), place);
    })
    .bound(64 * MB, 1000, "a frame as values, and each of them as text of at most 24 bytes, twice while it grows"),
    Reader::new("export-pictures", Binary, |place| beside(place, "e"), |bytes, place| {
        pictures(&place.write("e.particles.arrow", bytes), place, None);
    })
    .bound(64 * MB, 1000, "a frame as values; 40 bytes for each pixel; each sphere as some hundred bytes of SVG from 12 bytes of a frame"),
    Reader::new("export-bonds", Binary, |place| {
        place.write("f.particles.arrow", &place.of_run("scene.particles.arrow"));
        vec![bond_file(place)]
    }, |bytes, place| {
        place.write("f.bonds.arrow", bytes);
        let path = place.path("f.particles.arrow");
        pictures(&path, place, Some(BondStress::Larger));
        let Some(job) = job(&path, place) else { return };
        if let Some(sink) = said(Vtu::new(&job, VTU)) {
            exported(&job, Box::new(sink));
        }
    })
    .bound(64 * MB, 1000, "a frame as values, and each of them as text of at most 24 bytes; 40 bytes for each pixel"),
];

const VTU: VtuChoice = VtuChoice {
    options: VtuOptions::DEFAULT,
    contacts: true,
    walls: true,
    clumps: ClumpsAs::Both,
};

/// All tables of the run but its particles, which are the sample.
fn beside(place: &Place, prefix: &str) -> Vec<Vec<u8>> {
    for kind in [
        "contacts",
        "bodies",
        "walls",
        "surfaces",
        "triangle_loads",
        "wear",
    ] {
        let table = place.of_run(&format!("scene.{kind}.arrow"));
        place.write(&format!("{prefix}.{kind}.arrow"), &table);
    }
    vec![place.of_run("scene.particles.arrow")]
}

/// Exports all kinds of files as `mercury-export` does.
fn each_kind(path: &Path, place: &Place) {
    let Some(job) = job(path, place) else { return };
    let density = Density::new(2500.0).ok();
    let xballs = Xballs::begin(&job.output, XballsChoice::default());
    for sink in [
        Some(Box::new(sinks::csv(&job.output, Table::Particles)) as Box<dyn Sink>),
        Some(Box::new(sinks::csv(&job.output, Table::Contacts))),
        Some(Box::new(sinks::csv(&job.output, Table::Bodies))),
        Some(Box::new(sinks::csv(&job.output, Table::WearTriangles))),
        Some(Box::new(sinks::Parquet::new(&job.output, Table::Particles))),
        Some(Box::new(sinks::particle_tables(&job.output))),
        said(sinks::Stl::new(&job, false)).map(|sink| Box::new(sink) as Box<dyn Sink>),
        Some(Box::new(sinks::data_files(&job.output, density))),
        said(sinks::dump(&job.output)).map(|sink| Box::new(sink) as Box<dyn Sink>),
        said(xballs).map(|sink| Box::new(sink) as Box<dyn Sink>),
        said(Vtu::new(&job, VTU)).map(|sink| Box::new(sink) as Box<dyn Sink>),
    ]
    .into_iter()
    .flatten()
    {
        exported(&job, sink);
    }
}

/// Draws small pictures as `mercury-export png` and `svg` do.
fn pictures(path: &Path, place: &Place, bonds: Option<BondStress>) {
    let Some(job) = job(path, place) else { return };
    for kind in [PictureKind::Png, PictureKind::Svg] {
        let choice = PictureChoice {
            options: Options {
                width: 120,
                height: 90,
                ..Options::default()
            },
            quantity: "auto".to_owned(),
            range: None,
            map: ColourMap::default(),
            logarithmic: false,
            particles: true,
            contacts: bonds.is_none(),
            bridges: bonds.is_none(),
            bonds,
            droplets: true,
            walls: true,
            clumps: ClumpsAs::Both,
            title: None,
        };
        if let Some(sink) = said(Pictures::new(&job, choice, kind)) {
            exported(&job, Box::new(sink));
        }
    }
}

fn job(path: &Path, place: &Place) -> Option<Job> {
    let source = said(Source::open(path))?;
    let output = said(Output::new(
        &source,
        Some(&place.path("exported")),
        "",
        true,
    ))?;
    Some(Job {
        source,
        selection: Selection::default(),
        output,
    })
}

fn exported<'a>(job: &'a Job, sink: Box<dyn Sink + 'a>) {
    if let Some((outcome, _)) = said(export(job, sink, |_| {})) {
        for text in outcome.warnings.iter().chain(&outcome.notes) {
            say(text);
        }
        if let Some(damage) = outcome.damage {
            say(&damage);
        }
    }
}

fn frames(path: &Path) {
    let Some(source) = said(Source::open(path)) else {
        return;
    };
    for frame in source.frames(FrameChoice::All) {
        if let Some(frame) = said(frame) {
            said(frame.domain());
        }
    }
}

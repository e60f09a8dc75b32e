//! What `mercury-export` reads beside what others read: scripts of XBalls, series of `.data`, runs with all their tables.

use mercury_export::{FrameChoice, Source};

use super::{MB, Reader};
use crate::checks::said;
use crate::mutate::Make::{Binary, Text};

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
        for kind in ["contacts", "bodies", "walls", "surfaces", "triangle_loads"] {
            place.write(&format!("c.{kind}.arrow"), &place.of_run(&format!("scene.{kind}.arrow")));
        }
        vec![place.of_run("scene.particles.arrow")]
    }, |bytes, place| frames(&place.write("c.particles.arrow", bytes)))
    .bound(MB, 64, "the columns of a frame as values; the schema, once more for each frame"),
];

fn frames(path: &std::path::Path) {
    let Some(source) = said(Source::open(path)) else {
        return;
    };
    for frame in source.frames(FrameChoice::All) {
        if let Some(frame) = said(frame) {
            said(frame.domain());
        }
    }
}

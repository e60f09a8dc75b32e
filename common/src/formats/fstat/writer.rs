//! Writing `.fstat`.

use super::FstatFrame;
use crate::formats::number::{NumberStyle, push_integer, push_number, push_numbers};

/// Appends a whole frame.
///
/// With [`NumberStyle::Shortest`] every number reads back exactly; with
/// [`NumberStyle::Digits(10)`](NumberStyle::Digits) the text is what MercuryDPM prints (10 digits everywhere).
pub fn write_frame(frame: &FstatFrame, style: NumberStyle, out: &mut Vec<u8>) {
    // About the length of a line at full precision, so that the buffer seldom grows.
    out.reserve(256 + frame.contacts.len() * 280);

    out.extend_from_slice(b"# ");
    push_number(out, frame.time, style);
    out.extend_from_slice(if frame.has_contact_points {
        b" 1\n# "
    } else {
        b" 0\n# "
    });
    let (a, b) = (frame.min, frame.max);
    push_numbers(out, &[a.x, a.y, a.z, b.x, b.y, b.z], style);
    out.extend_from_slice(b"\n# ");
    push_numbers(out, &[frame.radius_min, frame.radius_max], style);
    out.extend_from_slice(b" 0 0 0 0\n");

    for row in &frame.contacts {
        push_number(out, row.time, style);
        for index in [row.i, row.j] {
            out.push(b' ');
            push_integer(out, index);
        }
        out.push(b' ');
        let (c, n, t) = (row.contact_point, row.normal, row.tangent);
        let numbers = [
            c.x,
            c.y,
            c.z,
            row.overlap,
            row.tangential_overlap,
            row.normal_force,
            row.tangential_force,
            n.x,
            n.y,
            n.z,
            t.x,
            t.y,
            t.z,
        ];
        push_numbers(out, &numbers, style);
        out.push(b'\n');
    }
}

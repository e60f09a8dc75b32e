//! Writing `.data`.

use super::DataFrame;
use crate::formats::number::{NumberStyle, push_number, push_numbers};

/// Appends a whole frame: format 8 if `frame.dimensions` is 2, else format 14.
///
/// With [`NumberStyle::Shortest`] everything that the layout holds reads back exactly; with
/// [`NumberStyle::Digits(10)`](NumberStyle::Digits) the text is what MercuryDPM prints, with 15 digits for positions.
pub fn write_frame(frame: &DataFrame, style: NumberStyle, out: &mut Vec<u8>) {
    let two_dimensional = frame.dimensions == 2;
    // About the length of a line at full precision, so that the buffer seldom grows.
    out.reserve(128 + frame.particles.len() * if two_dimensional { 120 } else { 240 });

    push_number(out, frame.particles.len() as f64, NumberStyle::Shortest);
    out.push(b' ');
    push_number(out, frame.time, style);
    let axes = usize::from(if two_dimensional { 2 } else { 3u8 });
    for corner in [frame.min, frame.max] {
        out.push(b' ');
        push_numbers(out, &corner.to_array()[..axes], style);
    }
    // MercuryDPM ends this line with a blank.
    out.extend_from_slice(b" \n");

    for row in &frame.particles {
        let (x, v, w) = (row.position, row.velocity, row.angular_velocity);
        push_numbers(out, &x.to_array()[..axes], style.for_positions());
        out.push(b' ');
        if two_dimensional {
            let rest = [v.x, v.y, row.radius, -row.angles.z, -w.z, row.info];
            push_numbers(out, &rest, style);
        } else {
            let a = row.angles;
            let rest = [
                v.x, v.y, v.z, row.radius, a.x, a.y, a.z, w.x, w.y, w.z, row.info,
            ];
            push_numbers(out, &rest, style);
        }
        out.push(b'\n');
    }
}

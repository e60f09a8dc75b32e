//! Straight lines in space as the camera sees them.

use glam::DVec3;

use super::bins::Rect;
use super::facets::{facing, folded_edges};
use super::{Look, SAMPLES};
use crate::camera::Lens;
use crate::colour::Colour;
use crate::frame::{is_place, is_width};

/// Lines on a surface are drawn this much (samples) nearer, or half of them would sink into it.
const LIFT: f64 = 1.5;
/// Width of the edges of walls, in pixels of a picture of 1200 x 900.
const WALL_EDGE: f64 = 1.1;
/// Before everything.
const IN_FRONT: f64 = 1e9;

/// A straight line in the window.
#[derive(Debug, Clone)]
pub(super) struct SeenStroke {
    /// Ends in samples from the middle of the window.
    from: (f64, f64),
    to: (f64, f64),
    /// Depths of the ends, or in perspective the reciprocal distances from the eye.
    depths: (f64, f64),
    /// Samples.
    half_width: f64,
    /// Distance (samples) by which the line is drawn nearer than it is.
    lift: f64,
    pub(super) colour: Colour,
    pub(super) rect: Rect,
}

impl SeenStroke {
    /// Part of the sample at (u, v) that the line covers, and its depth there.
    pub(super) fn cover(&self, distance: Option<f64>, u: f64, v: f64) -> Option<(f64, f64)> {
        let (dx, dy) = (self.to.0 - self.from.0, self.to.1 - self.from.1);
        let (px, py) = (u - self.from.0, v - self.from.1);
        let squared = dx * dx + dy * dy;
        let along = if squared > 0.0 {
            ((px * dx + py * dy) / squared).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let (x, y) = (px - along * dx, py - along * dy);
        let off = (x * x + y * y).sqrt();
        let covered = (self.half_width + 0.5 - off)
            .min(1.0)
            .min(2.0 * self.half_width);
        (covered > 0.0).then(|| {
            let value = self.depths.0 + along * (self.depths.1 - self.depths.0);
            let depth = distance.map_or(value, |d| 1.0 / value - d);
            (covered, depth - self.lift)
        })
    }
}

/// All lines of a frame: domain, walls, folds of surfaces, contacts.
pub(super) fn seen(look: &Look, lens: &Lens, columns: usize, rows: usize) -> Vec<SeenStroke> {
    let (frame, theme) = (look.frame, &look.theme);
    let mut strokes = Vec::new();
    let mut add = |from: DVec3, to: DVec3, colour: Colour, width: f64| {
        strokes.extend(stroke(lens, from, to, colour, width, columns, rows));
    };
    if look.shows_domain(lens, (columns, rows)) {
        for [from, to] in frame.domain_edges() {
            add(from, to, theme.domain, look.unit);
        }
    }
    let width = WALL_EDGE * look.unit;
    let line = width * SAMPLES as f64 / lens.target_scale();
    for surface in frame.surfaces.iter().filter(|surface| surface.edges) {
        for [from, to] in folded_edges(&surface.triangles, line, |normal| facing(lens, normal)) {
            add(from, to, theme.wall, width);
        }
    }
    for line in &frame.lines {
        let colour = line.colour.unwrap_or(theme.wall);
        for pair in line.points.windows(2) {
            add(pair[0], pair[1], colour, line.width * look.unit);
        }
    }
    let walls = strokes.len();
    let contacts = frame.contacts.iter().zip(&look.contacts);
    strokes.extend(contacts.filter_map(|(contact, (colour, width))| {
        stroke(
            lens,
            contact.from,
            contact.to,
            *colour,
            *width,
            columns,
            rows,
        )
    }));
    // The weakest first, so that none is hidden by one that matters less.
    strokes[walls..].sort_by(|a, b| f64::total_cmp(&a.half_width, &b.half_width));
    if frame.flat {
        // Discs have no inside that a line could be hidden in.
        for contact in &mut strokes[walls..] {
            contact.lift = IN_FRONT;
        }
    }
    strokes
}

fn stroke(
    lens: &Lens,
    from: DVec3,
    to: DVec3,
    colour: Colour,
    width: f64,
    columns: usize,
    rows: usize,
) -> Option<SeenStroke> {
    if !is_place(from) || !is_place(to) || !is_width(width) {
        return None;
    }
    let (mut a, mut b) = (lens.place(from), lens.place(to));
    if let Some(distance) = lens.distance() {
        let near = 2.0 * lens.nearest() - distance;
        let cut = |from: DVec3, to: DVec3| from + (to - from) * ((near - from.z) / (to.z - from.z));
        match (a.z < near, b.z < near) {
            (true, true) => return None,
            (true, false) => a = cut(a, b),
            (false, true) => b = cut(b, a),
            (false, false) => {}
        }
    }
    let (p, q) = (lens.project(a)?, lens.project(b)?);
    let half_width = 0.5 * width * SAMPLES as f64;
    let reach = half_width + 1.0;
    let (half_x, half_y) = (0.5 * columns as f64, 0.5 * rows as f64);
    let low = (p.0.min(q.0) + half_x - reach, p.1.min(q.1) + half_y - reach);
    let high = (p.0.max(q.0) + half_x + reach, p.1.max(q.1) + half_y + reach);
    let value = |place: DVec3| lens.distance().map_or(place.z, |d| 1.0 / (d + place.z));
    Some(SeenStroke {
        from: p,
        to: q,
        depths: (value(a), value(b)),
        half_width,
        lift: LIFT,
        colour,
        rect: Rect::around(low, high, columns, rows)?,
    })
}

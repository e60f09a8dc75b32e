//! Headings, axes, gravity, scale.

use glam::DVec3;

use super::layout::{Area, Layout};
use super::sheet::{Cell, Sheet};
use super::text_size;
use crate::camera::Lens;
use crate::canvas::{Anchor, Canvas, HALF_CAPITAL, Lettering, Spot, Stroke, arrow};
use crate::font;
use crate::frame::Frame;
use crate::scale::{count, length_label, quantity, round_down};
use crate::theme::Theme;

/// Title and line of numbers.
pub(super) fn headings(sheet: &Sheet, layout: &Layout, canvas: &mut dyn Canvas) {
    let Some((title_line, numbers_line)) = layout.headings else {
        return;
    };
    let room = layout.width - 2.0 * layout.left;
    let mut line = |text: &str, y: f64, size: f64, smallest: f64, colour| {
        let size = text_size(size, layout.unit);
        let (text, size) = font::fit(text, size, (smallest * layout.unit).clamp(8.0, size), room);
        canvas.text(
            &text,
            (layout.left, y),
            Lettering::new(size, colour, Anchor::Start),
        );
    };
    line(&sheet.title, title_line, 24.0, 13.0, sheet.theme.ink);
    line(
        &sheet.numbers,
        numbers_line,
        15.0,
        11.0,
        sheet.theme.soft_ink,
    );
}

/// Time and numbers of a frame; `noun` is one of its lines between particles.
pub(super) fn numbers(frame: &Frame, noun: &str, with_time: bool) -> String {
    let mut parts = Vec::new();
    let time = frame.time.filter(|time| time.is_finite());
    if let (true, Some(time)) = (with_time, time) {
        parts.push(time_label(time));
    }
    let number = frame.spheres.len();
    if number > 0 || (frame.surfaces.is_empty() && frame.grains.is_empty()) {
        let what = if frame.flat { "disc" } else { "sphere" };
        let plural = if number == 1 { "" } else { "s" };
        let mut text = format!("{} {what}{plural}", count(number));
        let fixed = frame.spheres.iter().filter(|s| s.fixed).count();
        if fixed > 0 {
            text += &format!(" ({} fixed)", count(fixed));
        }
        parts.push(text);
        let lost = frame.spheres.iter().filter(|s| !s.is_drawable()).count();
        if lost > 0 {
            parts.push(format!("{} without place or size", count(lost)));
        }
    }
    if !frame.droplets.is_empty() {
        let plural = if frame.droplets.len() == 1 { "" } else { "s" };
        parts.push(format!("{} droplet{plural}", count(frame.droplets.len())));
    }
    let grains = || frame.grains.iter().filter(|grain| !grain.of_wall);
    if grains().next().is_some() {
        let plural = if grains().count() == 1 { "" } else { "s" };
        let mut text = format!("{} grain{plural}", count(grains().count()));
        let fixed = grains().filter(|g| g.fixed).count();
        if fixed > 0 {
            text += &format!(" ({} fixed)", count(fixed));
        }
        parts.push(text);
    }
    if !frame.contacts.is_empty() {
        let plural = if frame.contacts.len() == 1 { "" } else { "s" };
        parts.push(format!("{} {noun}{plural}", count(frame.contacts.len())));
    }
    parts.join("\u{a0}\u{a0}·\u{a0}\u{a0}")
}

/// `t = 12.5 ms`.
pub(super) fn time_label(time: f64) -> String {
    format!("t = {}", quantity(time, "s", 4))
}

/// The caption above a window.
pub(super) fn caption(
    text: &str,
    lens: &Lens,
    y: f64,
    unit: f64,
    theme: &Theme,
    canvas: &mut dyn Canvas,
) {
    let window = lens.window();
    let size = text_size(15.0, unit);
    let (text, size) = font::fit(text, size, size.min(8.0), window.width as f64);
    let at = (window.x as f64 + 0.5 * window.width as f64, y);
    canvas.text(&text, at, Lettering::new(size, theme.ink, Anchor::Middle));
}

/// Axes, gravity and scale in the band below the scene, as requested and from left to right.
pub(super) fn footer(
    sheet: &Sheet,
    area: &Area,
    lenses: &[Lens],
    unit: f64,
    canvas: &mut dyn Canvas,
) {
    let Some(lens) = lenses.first() else { return };
    let mut x = area.x0;
    if sheet.axes && !sheet.cell_axes() {
        x = axes(
            lens,
            sheet.cells[0].frame,
            (x, area.y0),
            area.height(),
            &sheet.theme,
            canvas,
        );
    }
    if sheet.scale_bar
        && let Some(scale) = lens.scale()
    {
        scale_bar(scale, (x, area.y0), area, unit, &sheet.theme, canvas);
    }
}

/// The axes of one cell below its window.
pub(super) fn cell_axes(
    cell: &Cell,
    lens: &Lens,
    unit: f64,
    theme: &Theme,
    canvas: &mut dyn Canvas,
) {
    let window = lens.window();
    let height = 76.0 * unit;
    let x = window.x as f64 + 0.5 * window.width as f64 - 0.5 * height;
    let y = (window.y + window.height) as f64 + 2.0 * unit;
    axes(lens, cell.frame, (x, y), height, theme, canvas);
}

/// Arrows of the axes and of gravity in a band of this height; returns where the next thing may start.
fn axes(
    lens: &Lens,
    frame: &Frame,
    (x, y): Spot,
    height: f64,
    theme: &Theme,
    canvas: &mut dyn Canvas,
) -> f64 {
    let size = (0.2 * height).max(8.0);
    let width = (0.024 * height).max(0.9);
    let directions: Vec<(&str, Spot)> = [("x", DVec3::X), ("y", DVec3::Y), ("z", DVec3::Z)]
        .into_iter()
        .map(|(name, axis)| (name, lens.direction(axis)))
        .filter(|(_, (dx, dy))| dx.hypot(*dy) > 0.05)
        .collect();
    // The letters stand beyond the tips; all of it is centred in a square of the band's height.
    let reach = |pick: fn(&Spot) -> f64| {
        let ends = || directions.iter().map(|(_, d)| pick(d)).chain([0.0]);
        (ends().fold(0.0, f64::min), ends().fold(0.0, f64::max))
    };
    let (left, right) = reach(|d| d.0);
    let (top, bottom) = reach(|d| d.1);
    let length = (height - 2.2 * size) / (right - left).max(bottom - top).max(1.0);
    let origin = (
        x + 0.5 * height - 0.5 * (left + right) * length,
        y + 0.5 * height - 0.5 * (top + bottom) * length,
    );
    for (name, (dx, dy)) in &directions {
        let tip = (origin.0 + length * dx, origin.1 + length * dy);
        arrow(canvas, origin, tip, Stroke::solid(theme.ink, width));
        let long = dx.hypot(*dy);
        let at = (
            tip.0 + 0.75 * size * dx / long,
            tip.1 + 0.75 * size * dy / long + 0.27 * size,
        );
        canvas.text(name, at, Lettering::new(size, theme.ink, Anchor::Middle));
    }
    let mut next = x + height + 0.3 * height;
    let down = (frame.gravity.try_normalize()).map(|gravity| lens.direction(gravity));
    if let Some((dx, dy)) = down
        && dx.hypot(dy) > 0.05
    {
        let half = 0.26 * height;
        let middle = (next + half * dx.abs(), y + 0.5 * height);
        let (from, to) = (
            (middle.0 - half * dx, middle.1 - half * dy),
            (middle.0 + half * dx, middle.1 + half * dy),
        );
        arrow(canvas, from, to, Stroke::solid(theme.gravity, 1.2 * width));
        // Beside the arrow, on its right-hand side.
        let at = (
            middle.0 + size * dy.abs() + 0.1 * size,
            middle.1 + HALF_CAPITAL * size - size * dx.abs(),
        );
        canvas.text("g", at, Lettering::new(size, theme.gravity, Anchor::Start));
        next = middle.0 + half * dx.abs() + 2.2 * size;
    }
    next + 0.2 * height
}

/// A round length; left out where there is no space for one.
fn scale_bar(
    scale: f64,
    (x, y): Spot,
    area: &Area,
    unit: f64,
    theme: &Theme,
    canvas: &mut dyn Canvas,
) {
    let room = (area.x1 - x).min(210.0 * unit.max(0.5));
    let size = text_size(14.0, unit);
    let length = round_down(room / scale);
    let width = length * scale;
    let label = length_label(length);
    if !(width.is_finite() && width > 4.0) || font::width(&label, size) > area.x1 - x {
        return;
    }
    let y = y + 0.68 * area.height();
    let stroke = Stroke::solid(theme.ink, (2.0 * unit).max(1.0));
    let end = 5.0 * unit;
    // A label longer than its bar starts where the bar does.
    let middle = x + (0.5 * width).max(0.5 * font::width(&label, size));
    canvas.polyline(&[(x, y), (x + width, y)], stroke);
    for x in [x, x + width] {
        canvas.polyline(&[(x, y - end), (x, y + end)], stroke);
    }
    let at = (middle, y - end - 0.5 * size);
    canvas.text(&label, at, Lettering::new(size, theme.ink, Anchor::Middle));
}

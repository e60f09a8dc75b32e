//! What one needs to read the final state: headings, colour bar, axes, gravity and scale.

use super::colouring::Colouring;
use super::final_state::{FinalState, LEFT};
use crate::canvas::{Anchor, Canvas, HALF_CAPITAL, Lettering, Spot, Stroke, WIDTH, arrow, frame};
use crate::colour::{Colour, value_colour};
use crate::font;
use crate::scale::{Ticks, Unit, count, length_label, quantity, round_down, short_number};
use glam::DVec3;

/// The colour bar.
const BAR: (Spot, Spot) = ((1074.0, 190.0), (1096.0, 650.0));

impl FinalState<'_> {
    /// Title, time and numbers.
    pub(super) fn headings(&self, canvas: &mut dyn Canvas) {
        let (title, size) = font::fit(self.scene.title, 24.0, 13.0, WIDTH - 2.0 * LEFT);
        canvas.text(
            &title,
            (LEFT, 50.0),
            Lettering::new(size, Colour::INK, Anchor::Start),
        );
        let number = self.scene.spheres.len();
        let fixed = self.scene.spheres.iter().filter(|s| s.fixed).count();
        let what = if self.scene.dimensions == 2 {
            "disc"
        } else {
            "sphere"
        };
        let mut parts = vec![
            format!("t = {}", quantity(self.scene.time, "s", 4)),
            format!(
                "{} {what}{}",
                count(number),
                if number == 1 { "" } else { "s" }
            ),
        ];
        if fixed > 0 {
            parts[1] += &format!(" ({} fixed)", count(fixed));
        }
        match self.colouring {
            Colouring::Speed { .. } => {
                let free = self
                    .scene
                    .spheres
                    .iter()
                    .filter(|s| !s.fixed && s.speed.is_finite());
                let fastest = free.map(|s| s.speed.abs()).fold(0.0, f64::max);
                parts.push(format!("fastest {}", quantity(fastest, "m/s", 3)));
            }
            Colouring::Height { .. } => parts.push("all at rest, coloured by height".into()),
            Colouring::None => {}
        }
        let unseen = number - self.spheres.len();
        if unseen > 0 {
            parts.push(format!("{} outside the picture", count(unseen)));
        }
        let (text, size) = font::fit(
            &parts.join("\u{a0}\u{a0}·\u{a0}\u{a0}"),
            15.0,
            11.0,
            WIDTH - 2.0 * LEFT,
        );
        canvas.text(
            &text,
            (LEFT, 77.0),
            Lettering::new(size, Colour::SOFT_INK, Anchor::Start),
        );
    }

    /// The colour bar and the key to what is grey.
    pub(super) fn colour_bar(&self, canvas: &mut dyn Canvas) {
        let ((x0, y0), (x1, y1)) = BAR;
        let (name, low, high, plain, exceeded) = match self.colouring {
            Colouring::None => ("", 0.0, 0.0, "", false),
            Colouring::Speed { top, exceeded } => ("speed", 0.0, top, "m/s", exceeded),
            Colouring::Height { low, high, .. } => ("height", low, high, "m", false),
        };
        if !name.is_empty() && high > low {
            let unit = Unit::not_above_plain(low.abs().max(high.abs()), plain);
            let rows = (y1 - y0) as usize;
            for row in 0..rows {
                let y = y0 + row as f64;
                let value = 1.0 - (row as f64 + 0.5) / rows as f64;
                canvas.rectangle((x0, y), (x1, y + 1.0), value_colour(value));
            }
            frame(
                canvas,
                (x0, y0),
                (x1, y1),
                Stroke::solid(Colour::SOFT_INK, 1.0),
            );
            let ticks = Ticks::new(low / unit.size, high / unit.size, 6);
            for tick in &ticks.at {
                let y = y1 - (tick * unit.size - low) / (high - low) * (y1 - y0);
                canvas.polyline(
                    &[(x1, y), (x1 + 5.0, y)],
                    Stroke::solid(Colour::SOFT_INK, 1.0),
                );
                let (label, size) = font::fit(&ticks.label(*tick), 13.5, 9.0, WIDTH - x1 - 16.0);
                let at = (x1 + 10.0, y + HALF_CAPITAL * size);
                canvas.text(&label, at, Lettering::new(size, Colour::INK, Anchor::Start));
            }
            let label = format!("{name} ({})", unit.name);
            let (label, size) = font::fit(&label, 15.0, 10.0, WIDTH - x0 - 12.0);
            canvas.text(
                &label,
                (x0, y0 - 30.0),
                Lettering::new(size, Colour::INK, Anchor::Start),
            );
            if exceeded {
                let text = format!("≥ {}", short_number(high / unit.size, 2));
                canvas.text(
                    &text,
                    (x0, y0 - 10.0),
                    Lettering::new(12.0, Colour::SOFT_INK, Anchor::Start),
                );
            }
        }
        if self.scene.spheres.iter().any(|s| s.fixed) {
            let y = y1 + 34.0;
            canvas.disc((x0 + 11.0, y), 9.0, Colour::FIXED.lit(0.7));
            canvas.disc((x0 + 11.0, y), 8.0, Colour::FIXED);
            let at = (x0 + 30.0, y + HALF_CAPITAL * 13.5);
            canvas.text(
                "fixed",
                at,
                Lettering::new(13.5, Colour::INK, Anchor::Start),
            );
        }
    }

    /// Axes, gravity and the scale bar.
    pub(super) fn footer(&self, canvas: &mut dyn Canvas) {
        let origin = (LEFT + 44.0, 856.0);
        let axes = [("x", DVec3::X), ("y", DVec3::Y), ("z", DVec3::Z)];
        for (name, axis) in axes {
            let (dx, dy) = self.camera.direction(axis);
            let length = dx.hypot(dy);
            if length < 0.05 {
                continue;
            }
            let tip = (origin.0 + 34.0 * dx, origin.1 + 34.0 * dy);
            arrow(canvas, origin, tip, Stroke::solid(Colour::INK, 1.7));
            let at = (
                tip.0 + 11.0 * dx / length,
                tip.1 + 11.0 * dy / length + 0.27 * 14.0,
            );
            canvas.text(name, at, Lettering::new(14.0, Colour::INK, Anchor::Middle));
        }
        if let Some(gravity) = self.scene.gravity.try_normalize() {
            let (dx, dy) = self.camera.direction(gravity);
            if dx.hypot(dy) > 0.05 {
                let middle = (LEFT + 136.0, 845.0);
                let half = 20.0;
                let (from, to) = (
                    (middle.0 - half * dx, middle.1 - half * dy),
                    (middle.0 + half * dx, middle.1 + half * dy),
                );
                arrow(canvas, from, to, Stroke::solid(Colour(190, 72, 50), 2.0));
                // Beside the arrow, on its right-hand side.
                let at = (
                    middle.0 + 14.0 * dy.abs() + 2.0,
                    middle.1 + 5.0 - 14.0 * dx.abs(),
                );
                canvas.text(
                    "g",
                    at,
                    Lettering::new(14.0, Colour(190, 72, 50), Anchor::Start),
                );
            }
        }
        let length = round_down(210.0 / self.camera.scale());
        let width = length * self.camera.scale();
        let (x0, y) = (LEFT + 210.0, 860.0);
        let stroke = Stroke::solid(Colour::INK, 2.0);
        canvas.polyline(&[(x0, y), (x0 + width, y)], stroke);
        for x in [x0, x0 + width] {
            canvas.polyline(&[(x, y - 5.0), (x, y + 5.0)], stroke);
        }
        let at = (x0 + 0.5 * width, y - 12.0);
        canvas.text(
            &length_label(length),
            at,
            Lettering::new(14.0, Colour::INK, Anchor::Middle),
        );
    }
}

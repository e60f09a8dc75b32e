//! The picture of the final state: shaded spheres, outlines of domain and walls, and what one needs to read it.

use super::camera::{self, Camera, Seen, SeenSphere, Window};
use super::canvas::{Anchor, Canvas, HALF_CAPITAL, Lettering, Spot, Stroke, WIDTH, arrow, frame};
use super::colour::{Colour, value_colour};
use super::scale::{Ticks, Unit, count, quantity, round_down, short_number};
use super::shade::DepthBuffer;
use super::svg::{Svg, short};
use super::{PictureScene, PictureSphere, PictureWall, font};
use glam::DVec3;
use std::collections::BTreeSet;
use std::fmt::Write as _;

const LEFT: f64 = 40.0;
const WINDOW: Window = Window {
    upper_left: (LEFT, 96.0),
    lower_right: (1044.0, 796.0),
};
/// The colour bar.
const BAR: (Spot, Spot) = ((1074.0, 190.0), (1096.0, 650.0));
/// Above this number the SVG leaves out the spheres that are hidden, ...
const ALL_IN_SVG: usize = 5_000;
/// ... and of those in sight it keeps at most this many, the ones that cover most.
const MOST_IN_SVG: usize = 20_000;
/// Spheres slower than this share of sqrt(g d) are at rest: they rose by less than 1e-12 diameters with it.
const REST: f64 = 1e-6;
/// Colours that an SVG tells apart: along the map, and in depth.
const SHADES: usize = 48;
const DEPTHS: usize = 5;

/// Everything about the picture that does not depend on what it is drawn on.
pub(super) struct FinalState<'a> {
    scene: &'a PictureScene<'a>,
    pub(super) camera: Camera,
    /// The nearest first.
    pub(super) spheres: Vec<SeenSphere>,
    pub(super) buffer: DepthBuffer,
    colouring: Colouring,
}

/// What the colours mean.
enum Colouring {
    /// Nothing moves freely: no bar.
    None,
    /// 0 to `top` (m/s); faster ones are drawn as `top`.
    Speed { top: f64, exceeded: bool },
    /// Height against gravity (m).
    Height { up: DVec3, low: f64, high: f64 },
}

impl Colouring {
    fn new(scene: &PictureScene) -> Self {
        let free = || {
            scene
                .spheres
                .iter()
                .filter(|s| !s.fixed && s.speed.is_finite() && s.centre.is_finite())
        };
        let mut speeds: Vec<f64> = free().map(|s| s.speed.abs()).collect();
        if speeds.is_empty() {
            return Self::None;
        }
        let fastest = speeds.iter().copied().fold(0.0, f64::max);
        let diameter = free().map(|s| 2.0 * s.radius).sum::<f64>() / speeds.len() as f64;
        let gravity = scene.gravity.length();
        if fastest <= REST * (gravity * diameter).max(0.0).sqrt() {
            let up = camera::upward(scene);
            let heights = || free().map(|s| s.centre.dot(up));
            let (low, high) = (
                heights().fold(f64::MAX, f64::min),
                heights().fold(f64::MIN, f64::max),
            );
            // One layer: give the bar the thickness of a grain.
            let room = if high - low > 1e-9 * diameter {
                0.0
            } else {
                0.5 * diameter
            };
            return Self::Height {
                up,
                low: low - room,
                high: high + room,
            };
        }
        // A few that fly must not leave all others in one colour; of fewer than a hundred none is "a few".
        let place = (speeds.len() - 1) * 99 / 100;
        let usual = *speeds.select_nth_unstable_by(place, f64::total_cmp).1;
        if speeds.len() >= 100 && usual > 0.0 && fastest > 3.0 * usual {
            Self::Speed {
                top: usual,
                exceeded: true,
            }
        } else {
            Self::Speed {
                top: fastest,
                exceeded: false,
            }
        }
    }

    /// Place of a sphere along the colour bar, 0 to 1; `None` for grey.
    fn place(&self, sphere: &PictureSphere) -> Option<f64> {
        if sphere.fixed {
            return None;
        }
        match self {
            Self::None => None,
            Self::Speed { top, .. } => Some((sphere.speed.abs() / top).clamp(0.0, 1.0)),
            Self::Height { up, low, high } => {
                Some(((sphere.centre.dot(*up) - low) / (high - low)).clamp(0.0, 1.0))
            }
        }
    }

    fn colour(&self, sphere: &PictureSphere) -> Colour {
        self.place(sphere).map_or(Colour::FIXED, value_colour)
    }
}

impl<'a> FinalState<'a> {
    pub(super) fn new(scene: &'a PictureScene<'a>) -> Self {
        let camera = Camera::new(scene, WINDOW);
        let spheres = camera.spheres(scene.spheres);
        let buffer = DepthBuffer::new(&camera, &spheres);
        Self {
            scene,
            camera,
            spheres,
            buffer,
            colouring: Colouring::new(scene),
        }
    }

    /// The colour of each seen sphere.
    pub(super) fn colours(&self) -> Vec<Colour> {
        self.spheres
            .iter()
            .map(|seen| self.colouring.colour(&self.scene.spheres[seen.index]))
            .collect()
    }

    /// The places of the spheres that an SVG draws, the farthest first, and a sentence about them.
    fn drawn_in_svg(&self) -> (Vec<usize>, String) {
        let number = self.spheres.len();
        let mut drawn: Vec<usize> = (0..number).collect();
        if number > ALL_IN_SVG {
            let owned = self.buffer.owned(number);
            drawn.retain(|place| owned[*place] > 0);
            if drawn.len() > MOST_IN_SVG {
                drawn.sort_by_key(|place| (std::cmp::Reverse(owned[*place]), *place));
                drawn.truncate(MOST_IN_SVG);
            }
        }
        // Painted by centres: what the eye sees of touching spheres of any sizes.
        drawn.sort_by(|a, b| {
            f64::total_cmp(&self.spheres[*b].at.depth, &self.spheres[*a].at.depth).then(a.cmp(b))
        });
        let text = format!(
            "{} of {} spheres are drawn; the others are hidden.",
            drawn.len(),
            self.scene.spheres.len()
        );
        (drawn, text)
    }

    /// The whole picture as SVG.
    pub(super) fn svg(&self) -> String {
        let (drawn, description) = self.drawn_in_svg();
        let mut svg = Svg::new(self.scene.title, &description);
        svg.raw(&self.svg_spheres(&drawn));
        self.annotate(&mut svg);
        svg.finish()
    }

    fn svg_spheres(&self, drawn: &[usize]) -> String {
        let depths = || drawn.iter().map(|place| self.spheres[*place].at.depth);
        let (near, far) = (
            depths().fold(f64::MAX, f64::min),
            depths().fold(f64::MIN, f64::max),
        );
        let mut circles = String::new();
        let mut used: BTreeSet<(usize, usize)> = BTreeSet::new();
        for place in drawn {
            let seen = &self.spheres[*place];
            let value = self.colouring.place(&self.scene.spheres[seen.index]);
            // The last shade is the grey of what is fixed.
            let shade = value.map_or(SHADES, |v| (v * (SHADES - 1) as f64).round() as usize);
            let share = if far > near {
                (seen.at.depth - near) / (far - near)
            } else {
                0.0
            };
            let depth = (share * (DEPTHS - 1) as f64).round() as usize;
            used.insert((shade, depth));
            let _ = writeln!(
                circles,
                "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"url(#s{shade}-{depth})\"/>",
                short(seen.at.x),
                short(seen.at.y),
                short(seen.radius.max(0.3))
            );
        }
        let mut markup = String::from("<defs>\n");
        let ((x0, y0), (x1, y1)) = (WINDOW.upper_left, WINDOW.lower_right);
        let _ = writeln!(
            markup,
            "<clipPath id=\"window\"><rect x=\"{x0}\" y=\"{y0}\" width=\"{}\" height=\"{}\"/></clipPath>",
            x1 - x0,
            y1 - y0
        );
        for (shade, depth) in used {
            let colour = if shade == SHADES {
                Colour::FIXED
            } else {
                value_colour(shade as f64 / (SHADES - 1) as f64)
            };
            let haze = 0.2 * depth as f64 / (DEPTHS - 1) as f64;
            let stop = |at: &str, colour: Colour| {
                format!(
                    "<stop offset=\"{at}\" stop-color=\"{}\"/>",
                    colour.mix(Colour(236, 239, 243), haze).hex()
                )
            };
            let _ = writeln!(
                markup,
                "<radialGradient id=\"s{shade}-{depth}\" cx=\"0.5\" cy=\"0.5\" r=\"0.5\" fx=\"0.32\" fy=\"0.26\">{}{}{}{}</radialGradient>",
                stop("0", colour.mix(Colour::WHITE, 0.2)),
                stop("0.3", colour),
                stop("0.85", colour.lit(0.66)),
                stop("1", colour.lit(0.38))
            );
        }
        let _ = write!(
            markup,
            "</defs>\n<g clip-path=\"url(#window)\">\n{circles}</g>\n"
        );
        markup
    }

    /// Everything but the spheres.
    pub(super) fn annotate(&self, canvas: &mut dyn Canvas) {
        self.outlines(canvas);
        self.headings(canvas);
        self.colour_bar(canvas);
        self.footer(canvas);
    }

    fn outlines(&self, canvas: &mut dyn Canvas) {
        let corners = camera::domain_corners(self.scene);
        for (a, low) in corners.iter().enumerate() {
            // Corners are numbered by bits: those that differ in one bit share an edge.
            for bit in 0..3 {
                if let (0, Some(high)) = (a & (1 << bit), corners.get(a | (1 << bit))) {
                    self.line(canvas, *low, *high, Stroke::solid(Colour::DOMAIN, 1.0));
                }
            }
        }
        for PictureWall::Polyline(points) in self.scene.walls {
            for pair in points.windows(2) {
                self.line(canvas, pair[0], pair[1], Stroke::solid(Colour::WALL, 1.3));
            }
        }
    }

    /// The parts of a straight line that no sphere hides.
    fn line(&self, canvas: &mut dyn Canvas, from: DVec3, to: DVec3, stroke: Stroke) {
        let (from, to) = (self.camera.see(from), self.camera.see(to));
        let finite = |s: Seen| s.x.is_finite() && s.y.is_finite() && s.depth.is_finite();
        if !finite(from) || !finite(to) {
            return;
        }
        let Some((from, to)) = self.camera.clip(from, to) else {
            return;
        };
        // Inside the window a line is at most some thousand points long; half a point is finer than its width.
        let steps = (2.0 * (to.x - from.x).hypot(to.y - from.y))
            .ceil()
            .clamp(1.0, 1e4) as usize;
        let at = |step: usize| {
            let t = step as f64 / steps as f64;
            Seen {
                x: from.x + t * (to.x - from.x),
                y: from.y + t * (to.y - from.y),
                depth: from.depth + t * (to.depth - from.depth),
            }
        };
        let mut start: Option<Spot> = None;
        let mut last = (from.x, from.y);
        for step in 0..=steps {
            let here = at(step);
            match (self.buffer.is_visible(here), start) {
                (true, None) => start = Some((here.x, here.y)),
                (false, Some(first)) => {
                    canvas.polyline(&[first, last], stroke);
                    start = None;
                }
                _ => {}
            }
            last = (here.x, here.y);
        }
        if let Some(first) = start {
            canvas.polyline(&[first, last], stroke);
        }
    }

    fn headings(&self, canvas: &mut dyn Canvas) {
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

    fn colour_bar(&self, canvas: &mut dyn Canvas) {
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
    fn footer(&self, canvas: &mut dyn Canvas) {
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

/// A round length in the unit people use for it: µm, mm, cm, m, km.
fn length_label(length: f64) -> String {
    // Centimetres from 1 cm to 50 cm; the SI's steps of a thousand elsewhere.
    if (0.00999..0.999).contains(&length) {
        return format!("{} cm", short_number(length * 100.0, 3));
    }
    let unit = Unit::for_magnitude(length * (1.0 + 1e-9), "m");
    format!("{} {}", short_number(length / unit.size, 3), unit.name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_in_the_units_of_the_lab() {
        for (length, label) in [
            (5e-6, "5 µm"),
            (0.002, "2 mm"),
            (0.01, "1 cm"),
            (0.5, "50 cm"),
            (1.0, "1 m"),
            (2e4, "20 km"),
        ] {
            assert_eq!(length_label(length), label);
        }
    }

    fn scene(spheres: &[PictureSphere]) -> PictureScene<'_> {
        PictureScene {
            title: "",
            time: 0.0,
            spheres,
            domain_min: DVec3::ZERO,
            domain_max: DVec3::ONE,
            gravity: DVec3::new(0.0, 0.0, -9.81),
            dimensions: 3,
            walls: &[],
        }
    }

    fn moving(z: f64, speed: f64) -> PictureSphere {
        PictureSphere {
            centre: DVec3::new(0.5, 0.5, z),
            radius: 0.01,
            speed,
            fixed: false,
        }
    }

    #[test]
    fn speed_colours_the_moving_height_the_resting() {
        let spheres = [moving(0.1, 0.0), moving(0.3, 2.0)];
        let colouring = Colouring::new(&scene(&spheres));
        assert!(matches!(
            colouring,
            Colouring::Speed {
                top: 2.0,
                exceeded: false
            }
        ));
        // sqrt(9.81 * 0.02) = 0.44 m/s: a nanometre per second is rest.
        let spheres = [moving(0.1, 1e-9), moving(0.3, 0.0)];
        match Colouring::new(&scene(&spheres)) {
            Colouring::Height { low, high, .. } => assert_eq!((low, high), (0.1, 0.3)),
            _ => panic!("expected height"),
        }
    }

    #[test]
    fn one_flying_sphere_does_not_flatten_the_colours() {
        let mut spheres: Vec<_> = (0..200)
            .map(|i| moving(0.1, 0.001 * f64::from(i)))
            .collect();
        spheres.push(moving(0.9, 50.0));
        match Colouring::new(&scene(&spheres)) {
            Colouring::Speed { top, exceeded } => assert!(exceeded && top < 0.2, "{top}"),
            _ => panic!("expected speed"),
        }
    }
}

//! The picture of the final state: shaded spheres, outlines of domain and walls, and what one needs to read it.

use super::camera::{Camera, Seen, SeenSphere, Window};
use super::colouring::Colouring;
use super::framing;
use super::shade::DepthBuffer;
use super::{PictureScene, PictureWall};
use crate::canvas::{Canvas, Spot, Stroke};
use crate::colour::Colour;
use crate::svg::Svg;
use glam::DVec3;

/// Left margin of everything.
pub(super) const LEFT: f64 = 40.0;
/// Where the scene is.
pub(super) const WINDOW: Window = Window {
    upper_left: (LEFT, 96.0),
    lower_right: (1044.0, 796.0),
};

/// Everything about the picture that does not depend on what it is drawn on.
pub(super) struct FinalState<'a> {
    pub(super) scene: &'a PictureScene<'a>,
    pub(super) camera: Camera,
    /// The nearest first.
    pub(super) spheres: Vec<SeenSphere>,
    pub(super) buffer: DepthBuffer,
    pub(super) colouring: Colouring,
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

    /// The whole picture as SVG.
    pub(super) fn svg(&self) -> String {
        let (drawn, description) = self.drawn_in_svg();
        let mut svg = Svg::new(self.scene.title, &description);
        svg.raw(&self.svg_spheres(&drawn));
        self.annotate(&mut svg);
        svg.finish()
    }

    /// Everything but the spheres.
    pub(super) fn annotate(&self, canvas: &mut dyn Canvas) {
        self.outlines(canvas);
        self.headings(canvas);
        self.colour_bar(canvas);
        self.footer(canvas);
    }

    fn outlines(&self, canvas: &mut dyn Canvas) {
        let corners = framing::domain_corners(self.scene);
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
}

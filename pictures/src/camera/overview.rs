//! Overview of several frames: one camera and one range of colours for a whole film.

use std::collections::BTreeSet;

use glam::DVec3;

use super::extent::Extent;
use super::{Axes, Lens, Window};
use crate::frame::{Frame, Grain, is_place};
use crate::options::{ColourBy, Framing, Options};
use crate::value_range::ValueRange;

/// The bed fills at least this share of the window; else the camera closes in on it and what stands near.
const SMALLEST_BED: f64 = 0.3;
/// How far from the bed "near" is: a share of its larger side, ...
const NEAR: f64 = 0.1;
/// ... but at least so many radii of the median particle.
const NEAR_RADII: f64 = 3.0;

/// The sizes and values of all frames of a film. Show it every frame before the first is drawn; then camera and colours
/// stand still.
#[derive(Debug, Clone)]
pub struct Overview {
    pub(crate) axes: Option<Axes>,
    bed: Extent,
    spheres: Extent,
    walls: Extent,
    domain: Extent,
    /// The largest median of radii (m).
    median: f64,
    pub(crate) values: ValueRange,
    pub(crate) strengths: ValueRange,
    pub(crate) has_fixed: bool,
    pub(crate) has_missing: bool,
    /// Droplets that show no value.
    pub(crate) has_droplets: bool,
    pub(crate) categories: BTreeSet<usize>,
}

impl Default for Overview {
    fn default() -> Self {
        Self {
            axes: None,
            bed: Extent::EMPTY,
            spheres: Extent::EMPTY,
            walls: Extent::EMPTY,
            domain: Extent::EMPTY,
            median: 0.0,
            values: ValueRange::default(),
            strengths: ValueRange::default(),
            has_fixed: false,
            has_missing: false,
            has_droplets: false,
            categories: BTreeSet::new(),
        }
    }
}

impl Overview {
    /// Overview of one frame.
    #[must_use]
    pub fn of(frame: &Frame, options: &Options) -> Self {
        let mut overview = Self::default();
        overview.add(frame, options);
        overview
    }

    /// Takes a frame into account.
    pub fn add(&mut self, frame: &Frame, options: &Options) {
        // The first frame decides where the camera stands.
        let axes = *(self.axes).get_or_insert_with(|| Axes::new(frame, options.view));
        let spheres = frame.spheres.iter().filter(|sphere| sphere.is_drawable());
        let spheres = spheres.map(|sphere| (sphere.centre, sphere.radius));
        let grains = frame.grains.iter().filter_map(Grain::sphere);
        let seen: Vec<(DVec3, f64)> = spheres
            .chain(grains)
            .map(|(centre, radius)| (axes.coordinates(centre), radius))
            .collect();
        self.bed = self.bed.union(Extent::of_bed(&seen));
        for (centre, radius) in &seen {
            self.spheres.add(*centre, *radius);
        }
        let mut radii: Vec<f64> = seen.iter().map(|s| s.1).collect();
        if !radii.is_empty() {
            let half = radii.len() / 2;
            let median = *radii.select_nth_unstable_by(half, f64::total_cmp).1;
            self.median = self.median.max(median);
        }
        let corners = frame
            .surfaces
            .iter()
            .flat_map(|s| s.triangles.iter().flatten());
        let points = frame.lines.iter().flat_map(|line| &line.points);
        for point in corners.chain(points).filter(|point| is_place(**point)) {
            self.walls.add(axes.coordinates(*point), 0.0);
        }
        if options.domain {
            for corner in frame.domain_corners() {
                self.domain.add(axes.coordinates(corner), 0.0);
            }
        }
        self.add_values(frame, options);
    }

    fn add_values(&mut self, frame: &Frame, options: &Options) {
        let spheres = || frame.spheres.iter().filter(|s| s.is_drawable());
        let shown = || {
            let grains = frame.grains.iter().map(|g| (g.value, g.fixed));
            spheres().map(|s| (s.value, s.fixed)).chain(grains)
        };
        let values = || shown().filter(|(_, fixed)| !fixed).map(|(value, _)| value);
        self.values.add(values());
        self.strengths
            .add(frame.contacts.iter().map(|c| c.strength.abs()));
        self.has_fixed |= shown().any(|(_, fixed)| fixed);
        self.has_droplets |= (frame.droplets.iter()).any(|droplet| droplet.value.is_nan());
        self.has_missing |= values().any(f64::is_nan);
        if matches!(options.colour, ColourBy::Category { .. }) {
            let numbers = values().filter(|value| *value >= 0.0);
            self.categories.extend(numbers.map(|value| value as usize));
        }
    }

    /// Extent that the camera must see.
    fn framed(&self, framing: Framing) -> Extent {
        let around = self.walls.union(self.domain);
        match framing {
            Framing::Everything => self.spheres.union(around),
            Framing::Particles if !self.spheres.is_empty() => self.spheres,
            _ if self.bed.is_empty() => around,
            _ => {
                let area = |extent: &Extent| extent.size().x * extent.size().y;
                let shows_bed = |extent: &Extent| area(&self.bed) >= SMALLEST_BED * area(extent);
                // A scene without walls has no such picture between that with the domain and that of the bed.
                let with_walls = (!self.walls.is_empty()).then(|| self.bed.union(self.walls));
                let candidates = [Some(self.bed.union(around)), with_walls];
                let fitting = candidates.into_iter().flatten().find(shows_bed);
                fitting.unwrap_or_else(|| {
                    let size = self.bed.size();
                    let reach = (NEAR * size.x.max(size.y)).max(NEAR_RADII * self.median);
                    self.bed.union(around.within(&self.bed.widened(reach)))
                })
            }
        }
    }

    /// Width over height of what the camera must see; 1 where there is nothing.
    pub(crate) fn aspect(&self, options: &Options) -> f64 {
        let size = self.framed(options.framing).size();
        let aspect = size.x / size.y;
        if aspect.is_finite() && aspect > 0.0 {
            aspect.clamp(0.05, 20.0)
        } else {
            1.0
        }
    }

    /// The lens for a window of the picture.
    pub(crate) fn lens(&self, options: &Options, window: Window) -> Lens {
        let axes = (self.axes).unwrap_or_else(|| Axes::new(&Frame::default(), options.view));
        Lens::new(axes, &self.framed(options.framing), options, window)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Sphere;
    use crate::options::View;

    /// Spheres of radius 0.5 m on the floor of a box of 10 x 10 m and `box_height`, seen from the front.
    fn seen(layers: u32, box_height: f64) -> DVec3 {
        let place = |n: u32| {
            DVec3::new(
                f64::from(n % 10),
                f64::from(n / 10 % 10),
                f64::from(n / 100),
            )
        };
        let sphere = |n| Sphere {
            centre: place(n) + 0.5,
            radius: 0.5,
            value: 0.0,
            fixed: false,
        };
        let frame = Frame {
            domain: Some((DVec3::ZERO, DVec3::new(10.0, 10.0, box_height))),
            spheres: (0..100 * layers).map(sphere).collect(),
            ..Frame::default()
        };
        let options = Options {
            view: View::FRONT,
            ..Options::default()
        };
        Overview::of(&frame, &options).framed(Framing::Auto).size()
    }

    #[test]
    fn an_empty_box_above_a_bed_is_left_out() {
        // A bed of 3 m in a box of 21 m: three radii above it are near.
        let size = seen(3, 21.0);
        assert!(
            (size.x - 10.0).abs() < 1e-9 && (size.y - 4.5).abs() < 1e-9,
            "{size}"
        );
    }

    #[test]
    fn a_box_that_is_a_third_full_is_shown_whole() {
        let size = seen(7, 21.0);
        assert!(
            (size.x - 10.0).abs() < 1e-9 && (size.y - 21.0).abs() < 1e-9,
            "{size}"
        );
    }
}

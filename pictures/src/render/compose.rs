//! A frame painted into its window of the picture.

use rayon::prelude::*;

use super::bins::{Bins, Rect};
use super::facets::{self, Facet};
use super::layers::{Layers, Light};
use super::light;
use super::opaque::{FACET, NO_OWNER, Opaque};
use super::relief::Relief;
use super::spheres::{self, SeenSphere, hit};
use super::strokes::{self, SeenStroke};
use super::{Look, SAMPLES, TILE};
use crate::camera::Lens;
use crate::colour::Colour;
use crate::image::Image;

/// Everything that the samples of the window look up.
struct Painting<'a> {
    look: &'a Look<'a>,
    distance: Option<f64>,
    spheres: Vec<SeenSphere>,
    facets: Vec<Facet>,
    strokes: Vec<SeenStroke>,
    opaque: Opaque,
    relief: Relief,
    /// The depth of the nearest sample, and the haze per depth behind it.
    haze: (f64, f64),
    /// Translucent things by tile; spheres only if they are.
    sphere_bins: Option<Bins>,
    facet_bins: Bins,
    /// The triangles that `facet_bins` numbers.
    translucent: Vec<usize>,
    stroke_bins: Bins,
}

/// Paints the window of `lens` and leaves the rest of the picture alone.
pub(crate) fn paint(image: &mut Image, lens: &Lens, look: &Look) {
    let window = lens.window();
    if window.width == 0 || window.height == 0 {
        return;
    }
    let painting = Painting::new(&lens.finer(SAMPLES as f64), look);
    let row_bytes = 4 * image.width as usize;
    let bytes = &mut image.rgba[window.y * row_bytes..(window.y + window.height) * row_bytes];
    bytes
        .par_chunks_mut(row_bytes * (TILE / SAMPLES))
        .enumerate()
        .for_each(|(band, bytes)| {
            let mut layers = Layers::new(TILE * TILE);
            let mut pixels: Vec<&mut [u8]> = bytes
                .chunks_mut(row_bytes)
                .map(|row| &mut row[4 * window.x..4 * (window.x + window.width)])
                .collect();
            for column in 0..painting.opaque.columns.div_ceil(TILE) {
                painting.tile(column, band, &mut layers, &mut pixels);
            }
        });
}

impl<'a> Painting<'a> {
    fn new(lens: &Lens, look: &'a Look<'a>) -> Self {
        let window = lens.window();
        let (columns, rows) = (window.width * SAMPLES, window.height * SAMPLES);
        let spheres = spheres::seen(&look.spheres, lens, columns, rows);
        let surface = look.theme.surface;
        let mut facets = facets::seen(&look.frame.surfaces, surface, lens, columns, rows);
        facets.extend(facets::of_grains(look, lens, columns, rows));
        let strokes = strokes::seen(look, lens, columns, rows);
        let distance = lens.distance();
        let rects: Vec<Rect> = spheres.iter().map(|sphere| sphere.rect).collect();
        let solid = look.sphere_opacity >= 1.0;
        let opaque = if solid {
            Opaque::new(columns, rows, distance, &spheres, &facets)
        } else {
            Opaque::new(columns, rows, distance, &[], &facets)
        };
        let mut radii: Vec<f64> = spheres.iter().map(|sphere| sphere.radius).collect();
        let half = radii.len() / 2;
        let typical = radii
            .get(half)
            .is_some()
            .then(|| *radii.select_nth_unstable_by(half, f64::total_cmp).1);
        let reach = typical.unwrap_or(20.0).clamp(3.0, 40.0);
        let haze = match opaque.span() {
            // A shallow scene has no distance to fade into.
            Some((near, far))
                if f64::from(far - near) > 8.0 * reach && look.theme.paper.is_some() =>
            {
                (f64::from(near), light::HAZE / f64::from(far - near))
            }
            _ => (0.0, 0.0),
        };
        let translucent: Vec<usize> = (0..facets.len())
            .filter(|facet| facets[*facet].opacity < 1.0)
            .collect();
        let facet_rects: Vec<Rect> = translucent.iter().map(|f| facets[*f].rect).collect();
        let stroke_rects: Vec<Rect> = strokes.iter().map(|stroke| stroke.rect).collect();
        Self {
            look,
            distance,
            relief: Relief::new(&opaque, reach),
            haze,
            sphere_bins: (!solid).then(|| Bins::new(columns, rows, &rects)),
            facet_bins: Bins::new(columns, rows, &facet_rects),
            stroke_bins: Bins::new(columns, rows, &stroke_rects),
            translucent,
            opaque,
            spheres,
            facets,
            strokes,
        }
    }

    /// Paints one tile into rows of pixels.
    fn tile(&self, column: usize, band: usize, layers: &mut Layers, pixels: &mut [&mut [u8]]) {
        let rect = Rect {
            x0: column * TILE,
            y0: band * TILE,
            x1: ((column + 1) * TILE).min(self.opaque.columns),
            y1: (band * TILE + pixels.len() * SAMPLES).min(self.opaque.rows),
        };
        layers.clear();
        self.lay(rect, column, band, layers);
        for (y, row) in pixels.iter_mut().enumerate() {
            for x in rect.x0 / SAMPLES..rect.x1 / SAMPLES {
                let mut sum = Light::NONE;
                for line in 0..SAMPLES {
                    for step in 0..SAMPLES {
                        let (column, row) = (x * SAMPLES + step, rect.y0 + y * SAMPLES + line);
                        let mut light = self.ground(column, row);
                        if !layers.is_empty() {
                            light = layers.over(sample(rect, column, row), light);
                        }
                        sum.add(light);
                    }
                }
                row[4 * x..4 * x + 4].copy_from_slice(&sum.pixel(SAMPLES * SAMPLES));
            }
        }
    }

    /// The place of a sample's centre from the middle of the window.
    fn place(&self, column: usize, row: usize) -> (f64, f64) {
        (
            column as f64 + 0.5 - 0.5 * self.opaque.columns as f64,
            row as f64 + 0.5 - 0.5 * self.opaque.rows as f64,
        )
    }

    /// Every translucent thing of a tile that nothing opaque hides.
    fn lay(&self, rect: Rect, column: usize, band: usize, layers: &mut Layers) {
        let mut each = |part: Rect, cover: &dyn Fn(f64, f64) -> Option<(f64, Light)>| {
            let part = part.cut(rect);
            for row in part.y0..part.y1 {
                for column in part.x0..part.x1 {
                    let (u, v) = self.place(column, row);
                    if let Some((depth, light)) = cover(u, v)
                        && (depth as f32) < self.opaque.depth[row * self.opaque.columns + column]
                    {
                        layers.push(sample(rect, column, row), depth as f32, light);
                    }
                }
            }
        };
        for place in self.facet_bins.tile(column, band) {
            let facet = &self.facets[self.translucent[*place as usize]];
            let light = if facet.solid {
                let colour = light::grain(facet.colour, facet.normal, 1.0);
                Light::new(colour, facet.opacity)
            } else {
                let colour = light::facet(facet.colour, facet.normal, 1.0);
                Light::new(colour, light::slanted(facet.opacity, facet.normal))
            };
            each(facet.rect, &|u, v| {
                facet
                    .owns(u, v)
                    .then(|| (facet.depth(self.distance, u, v), light))
            });
        }
        if let Some(bins) = &self.sphere_bins {
            for place in bins.tile(column, band) {
                let sphere = &self.spheres[*place as usize];
                each(sphere.rect, &|u, v| {
                    let (normal, depth) = hit(sphere, self.distance, u, v)?;
                    let colour = self.sphere_colour(sphere, normal, 1.0);
                    Some((depth, Light::new(colour, self.look.sphere_opacity)))
                });
            }
        }
        for place in self.stroke_bins.tile(column, band) {
            let stroke = &self.strokes[*place as usize];
            each(stroke.rect, &|u, v| {
                let (covered, depth) = stroke.cover(self.distance, u, v)?;
                Some((depth, Light::new(stroke.colour, covered)))
            });
        }
    }

    fn sphere_colour(&self, sphere: &SeenSphere, normal: glam::DVec3, shade: f64) -> Colour {
        let colour = self.look.sphere_colours[sphere.index as usize];
        if self.look.frame.flat {
            light::disc(colour, normal, sphere.radius)
        } else {
            light::sphere(colour, normal, sphere.radius, shade)
        }
    }

    /// The opaque thing that a sample shows, or the paper.
    fn ground(&self, column: usize, row: usize) -> Light {
        let here = row * self.opaque.columns + column;
        let owner = self.opaque.owner[here];
        if owner == NO_OWNER {
            return self.look.theme.paper.map_or(Light::NONE, Light::opaque);
        }
        let depth = f64::from(self.opaque.depth[here]);
        let shade = |depth: f64| {
            let behind = (depth - self.relief.mean(column, row)) / (1.5 * self.relief.reach);
            1.0 - light::CREVICE * behind.clamp(0.0, 1.0)
        };
        let colour = if owner >= FACET {
            let facet = &self.facets[(owner - FACET) as usize];
            if facet.solid {
                light::grain(facet.colour, facet.normal, shade(depth))
            } else {
                light::facet(facet.colour, facet.normal, shade(depth))
            }
        } else {
            let sphere = &self.spheres[owner as usize];
            let (u, v) = self.place(column, row);
            // Round-off may let a ray of the first pass miss here: the rim, then.
            let normal =
                hit(sphere, self.distance, u, v).map_or(glam::DVec3::X, |(normal, _)| normal);
            // The sphere's own rim is no crevice: count from its shoulder.
            let shoulder = depth.min(sphere.centre.z - 0.5 * sphere.radius);
            self.sphere_colour(sphere, normal, shade(shoulder))
        };
        Light::opaque(colour.mix(self.look.theme.haze, self.haze.1 * (depth - self.haze.0)))
    }
}

/// The number of a sample in its tile.
fn sample(rect: Rect, column: usize, row: usize) -> usize {
    (row - rect.y0) * TILE + column - rect.x0
}

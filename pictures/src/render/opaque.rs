//! Opaque surfaces: the nearest one at each sample hides all behind it.

use rayon::prelude::*;

use super::TILE;
use super::bins::{Bins, Rect};
use super::facets::Facet;
use super::spheres::{SeenSphere, hit};

/// Owner of a sample that shows nothing.
pub(super) const NO_OWNER: u32 = u32::MAX;
/// Added to the numbers of triangles, to tell them from spheres.
pub(super) const FACET: u32 = 1 << 31;
/// After so many spheres a tile looks whether it is full.
const LOOK_AFTER: usize = 32;

/// Depth and owner of each sample of the window.
pub(super) struct Opaque {
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// Place in the list of seen spheres, or [`FACET`] plus place in the list of triangles.
    pub(super) owner: Vec<u32>,
    /// Infinite where no body covers the pixel.
    pub(super) depth: Vec<f32>,
}

/// A tile's part of a band of rows.
struct Tile<'a> {
    rect: Rect,
    /// Samples from the middle of the window to its upper left corner.
    half: (f64, f64),
    columns: usize,
    owner: &'a mut [u32],
    depth: &'a mut [f32],
}

impl Opaque {
    /// Casts `spheres`, the nearest first, and the opaque ones among `facets`.
    pub(super) fn new(
        columns: usize,
        rows: usize,
        distance: Option<f64>,
        spheres: &[SeenSphere],
        facets: &[Facet],
    ) -> Self {
        let rects: Vec<Rect> = spheres.iter().map(|sphere| sphere.rect).collect();
        let sphere_bins = Bins::new(columns, rows, &rects);
        let opaque: Vec<usize> = (0..facets.len())
            .filter(|facet| facets[*facet].opacity >= 1.0)
            .collect();
        let rects: Vec<Rect> = opaque.iter().map(|facet| facets[*facet].rect).collect();
        let facet_bins = Bins::new(columns, rows, &rects);
        let mut owner = vec![NO_OWNER; columns * rows];
        let mut depth = vec![f32::INFINITY; columns * rows];
        owner
            .par_chunks_mut(columns * TILE)
            .zip(depth.par_chunks_mut(columns * TILE))
            .enumerate()
            .for_each(|(band, (owner, depth))| {
                let last = band * TILE + owner.len() / columns;
                for column in 0..columns.div_ceil(TILE) {
                    let mut tile = Tile {
                        rect: Rect {
                            x0: column * TILE,
                            y0: band * TILE,
                            x1: ((column + 1) * TILE).min(columns),
                            y1: last,
                        },
                        half: (0.5 * columns as f64, 0.5 * rows as f64),
                        columns,
                        owner,
                        depth,
                    };
                    for place in facet_bins.tile(column, band) {
                        let number = opaque[*place as usize];
                        tile.facet(&facets[number], FACET | number as u32, distance);
                    }
                    tile.spheres(spheres, sphere_bins.tile(column, band), distance);
                }
            });
        Self {
            columns,
            rows,
            owner,
            depth,
        }
    }

    /// The depths of the nearest and of the farthest sample that shows something; none if none does.
    pub(super) fn span(&self) -> Option<(f32, f32)> {
        let shown = self.depth.iter().filter(|depth| depth.is_finite());
        let (near, far) = shown.fold((f32::INFINITY, f32::NEG_INFINITY), |(near, far), d| {
            (near.min(*d), far.max(*d))
        });
        (near <= far).then_some((near, far))
    }
}

impl Tile<'_> {
    fn spheres(&mut self, spheres: &[SeenSphere], places: &[u32], distance: Option<f64>) {
        let mut farthest = f32::INFINITY;
        for (count, place) in places.iter().enumerate() {
            let sphere = &spheres[*place as usize];
            if count % LOOK_AFTER == LOOK_AFTER - 1 {
                farthest = self.farthest();
            }
            // The nearest first: whatever follows is hidden as well.
            if sphere.nearest() as f32 >= farthest {
                break;
            }
            match distance {
                None => self.orthographic(sphere, *place),
                Some(_) => self.perspective(sphere, *place, distance),
            }
        }
    }

    /// The depth behind which nothing of the tile is seen.
    fn farthest(&self) -> f32 {
        let mut farthest = f32::NEG_INFINITY;
        for row in self.rect.y0..self.rect.y1 {
            let line = self.line(row);
            let row = &self.depth[line + self.rect.x0..line + self.rect.x1];
            farthest = row.iter().fold(farthest, |far, d| far.max(*d));
        }
        farthest
    }

    /// Where a row of the window starts in the band.
    fn line(&self, row: usize) -> usize {
        (row - self.rect.y0) * self.columns
    }

    fn orthographic(&mut self, sphere: &SeenSphere, place: u32) {
        let rect = sphere.rect.cut(self.rect);
        // Single precision from the sphere's own centre: exact to a millionth of its radius.
        let (x, y) = (
            sphere.centre.x + self.half.0 - 0.5,
            sphere.centre.y + self.half.1 - 0.5,
        );
        let square = (sphere.radius * sphere.radius) as f32;
        let (centre, nearest) = (sphere.centre.z, sphere.nearest() as f32);
        let centre = centre as f32;
        for row in rect.y0..rect.y1 {
            let dy = (row as f64 - y) as f32;
            let left = square - dy * dy;
            if left < 0.0 {
                continue;
            }
            let line = self.line(row);
            let first = (rect.x0 as f64 - x) as f32;
            let depths = &mut self.depth[line + rect.x0..line + rect.x1];
            let owners = &mut self.owner[line + rect.x0..line + rect.x1];
            for (step, (depth, owner)) in depths.iter_mut().zip(owners).enumerate() {
                let dx = first + step as f32;
                let height = left - dx * dx;
                if height >= 0.0 && nearest < *depth {
                    let here = centre - height.sqrt();
                    if here < *depth {
                        *depth = here;
                        *owner = place;
                    }
                }
            }
        }
    }

    fn perspective(&mut self, sphere: &SeenSphere, place: u32, distance: Option<f64>) {
        let rect = sphere.rect.cut(self.rect);
        let nearest = sphere.nearest() as f32;
        for row in rect.y0..rect.y1 {
            for column in rect.x0..rect.x1 {
                let sample = self.line(row) + column;
                if nearest >= self.depth[sample] {
                    continue;
                }
                let (u, v) = (
                    column as f64 + 0.5 - self.half.0,
                    row as f64 + 0.5 - self.half.1,
                );
                if let Some((_, depth)) = hit(sphere, distance, u, v)
                    && (depth as f32) < self.depth[sample]
                {
                    self.depth[sample] = depth as f32;
                    self.owner[sample] = place;
                }
            }
        }
    }

    fn facet(&mut self, facet: &Facet, number: u32, distance: Option<f64>) {
        let rect = facet.rect.cut(self.rect);
        for row in rect.y0..rect.y1 {
            for column in rect.x0..rect.x1 {
                let (u, v) = (
                    column as f64 + 0.5 - self.half.0,
                    row as f64 + 0.5 - self.half.1,
                );
                if facet.owns(u, v) {
                    let depth = facet.depth(distance, u, v) as f32;
                    let sample = self.line(row) + column;
                    if depth < self.depth[sample] {
                        self.depth[sample] = depth;
                        self.owner[sample] = number;
                    }
                }
            }
        }
    }
}

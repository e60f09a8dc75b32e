//! Where a particle or contact is seen from the grid: periodic and mirror images.

use glam::DVec3;
use rayon::prelude::*;

use super::spread::Placed;
use crate::state::Space;

/// Faces of the domain that mirror: of each axis the lower and the upper one.
pub type Mirrors = [[bool; 2]; 3];

/// Something to be placed, in Cartesian coordinates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Original {
    pub middle: DVec3,
    pub segment: DVec3,
}

impl Original {
    /// Until something is there.
    pub(crate) const NOWHERE: Self = Self {
        middle: DVec3::ZERO,
        segment: DVec3::ZERO,
    };
}

/// One way to be seen along one axis.
#[derive(Debug, Clone, Copy)]
struct Image {
    at: f64,
    mirrored: bool,
}

/// Originals that a thread places in one go.
const CHUNK: usize = 4096;

/// Data from which images are made.
pub(crate) struct Imager<'a> {
    pub space: &'a Space,
    pub mirrors: &'a Mirrors,
    /// Box of the points, in Cartesian coordinates; of no meaning along axes that are not resolved.
    pub low: DVec3,
    pub high: DVec3,
    pub resolved: [bool; 3],
    pub reach: f64,
}

impl Imager<'_> {
    fn along(&self, axis: usize, at: f64, half: f64, out: &mut Vec<Image>) {
        out.clear();
        if !self.resolved[axis] {
            out.push(Image {
                at: 0.0,
                mirrored: false,
            });
            return;
        }
        let reach = self.reach + half;
        let (low, high) = (self.low[axis] - reach, self.high[axis] + reach);
        let mut push = |at: f64, mirrored: bool| {
            if at >= low && at <= high {
                out.push(Image { at, mirrored });
            }
        };
        let mut push_all = |at: f64, period: f64, mirrored: bool| {
            let first = ((low - at) / period).ceil();
            let last = ((high - at) / period).floor();
            let mut k = first;
            while k <= last {
                push(at + k * period, mirrored);
                k += 1.0;
            }
        };
        if let Some(period) = self.space.period(axis) {
            push_all(at, period, false);
            return;
        }
        let [lower, upper] = [self.space.min[axis], self.space.max[axis]];
        match self.mirrors[axis] {
            // Mirrors see each other: mirror images of mirror images repeat after two lengths of the domain.
            [true, true] => {
                let period = 2.0 * (upper - lower);
                push_all(at, period, false);
                push_all(2.0 * lower - at, period, true);
            }
            [lower_mirrors, upper_mirrors] => {
                push(at, false);
                if lower_mirrors {
                    push(2.0 * lower - at, true);
                }
                if upper_mirrors {
                    push(2.0 * upper - at, true);
                }
            }
        }
    }

    /// Largest mean number of images.
    pub(crate) fn count(&self) -> f64 {
        let along = |axis: usize| {
            let seen = self.high[axis] - self.low[axis] + 2.0 * self.reach;
            let length = self.space.max[axis] - self.space.min[axis];
            match (self.resolved[axis], self.space.period(axis)) {
                (false, _) => 1.0,
                (true, Some(period)) => seen / period + 1.0,
                (true, None) => match self.mirrors[axis] {
                    [true, true] => seen / length + 2.0,
                    [false, false] => 1.0,
                    _ => 2.0,
                },
            }
        };
        (0..3).map(along).product()
    }

    /// All images that the points can see, in the order of the originals, in the place of what is in `placed`; `project` brings vectors into the
    /// order of the grid.
    pub(crate) fn place(
        &self,
        originals: &[Original],
        project: impl Fn(DVec3) -> DVec3 + Sync,
        placed: &mut Vec<Placed>,
    ) {
        if self.none() {
            self.place_plainly(originals, &project, placed);
            return;
        }
        let parts: Vec<Vec<Placed>> = originals
            .par_chunks(CHUNK)
            .enumerate()
            .map(|(k, originals)| {
                let mut images = [const { Vec::new() }; 3];
                let mut placed = Vec::with_capacity(originals.len());
                for (row, original) in originals.iter().enumerate() {
                    let row = (k * CHUNK + row) as u32;
                    self.place_one(original, row, &mut images, &project, &mut placed);
                }
                placed
            })
            .collect();
        placed.clear();
        placed.reserve(parts.iter().map(Vec::len).sum());
        parts.iter().for_each(|part| placed.extend_from_slice(part));
    }

    /// Whether nothing has images.
    fn none(&self) -> bool {
        (0..3).all(|axis| self.space.period(axis).is_none() && self.mirrors[axis] == [false; 2])
    }

    /// Places the originals that the points can see, where there are no images.
    fn place_plainly(
        &self,
        originals: &[Original],
        project: &(impl Fn(DVec3) -> DVec3 + Sync),
        placed: &mut Vec<Placed>,
    ) {
        let all = DVec3::splat(f64::INFINITY);
        let limit = |limit: DVec3, all: DVec3| {
            let part = |a: usize| if self.resolved[a] { limit[a] } else { all[a] };
            DVec3::new(part(0), part(1), part(2))
        };
        let low = limit(self.low - DVec3::splat(self.reach), -all);
        let high = limit(self.high + DVec3::splat(self.reach), all);
        let is_seen = |original: &Original| {
            let (at, half) = (original.middle, 0.5 * original.segment.abs());
            (at + half).cmpge(low).all() && (at - half).cmple(high).all()
        };
        let chunks = originals.par_chunks(CHUNK);
        let counts: Vec<usize> = chunks
            .map(|chunk| chunk.iter().filter(|one| is_seen(one)).count())
            .collect();
        placed.resize(counts.iter().sum(), Placed::NOWHERE);
        let mut rest = &mut placed[..];
        let mut parts = Vec::with_capacity(counts.len());
        for (chunk, count) in originals.chunks(CHUNK).zip(counts) {
            let (own, others) = rest.split_at_mut(count);
            rest = others;
            parts.push((chunk, own));
        }
        let parts = parts.into_par_iter().enumerate().with_max_len(1);
        parts.for_each(|(k, (chunk, own))| {
            let rows = ((k * CHUNK) as u32..).zip(chunk);
            let seen = rows.filter(|(_, original)| is_seen(original));
            for ((row, original), own) in seen.zip(own) {
                *own = Placed {
                    centre: project(original.middle),
                    segment: project(original.segment),
                    row,
                    mirrored: 0,
                };
            }
        });
    }

    fn place_one(
        &self,
        original: &Original,
        row: u32,
        images: &mut [Vec<Image>; 3],
        project: &impl Fn(DVec3) -> DVec3,
        placed: &mut Vec<Placed>,
    ) {
        for (axis, images) in images.iter_mut().enumerate() {
            self.along(
                axis,
                original.middle[axis],
                0.5 * original.segment[axis].abs(),
                images,
            );
        }
        let [xs, ys, zs] = images;
        for x in &*xs {
            for y in &*ys {
                for z in &*zs {
                    let turned = [x.mirrored, y.mirrored, z.mirrored];
                    let sign =
                        DVec3::from_array(turned.map(|turned| if turned { -1.0 } else { 1.0 }));
                    let bits = turned
                        .iter()
                        .rev()
                        .fold(0, |bits, &turned| bits << 1 | u8::from(turned));
                    placed.push(Placed {
                        centre: project(DVec3::new(x.at, y.at, z.at)),
                        segment: project(original.segment * sign),
                        row,
                        mirrored: bits,
                    });
                }
            }
        }
    }
}

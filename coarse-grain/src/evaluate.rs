//! From a state to sums at points.
//!
//! [`Evaluator`] holds the points and the kernel; it takes plain lists ([`State`]) and nothing of files, so that a program that
//! has particles in memory gets the same fields from the same code.

mod gather;
mod grid;
mod images;
mod instructions;
mod lattice;
mod layers;
mod scratch;
mod spread;
mod weights;
mod window;

use glam::DVec3;
use rayon::prelude::*;

use crate::coordinates::{Coordinates, CylinderAxis, Place, angles};
use crate::kernel::{Kernel, KernelChoice, KernelShape};
use crate::state::{Space, State};
use crate::sums::{Layout, Rank, SYMMETRIC, Spread, Sum, Sums};
use gather::{gather, total};
pub use images::Mirrors;
use images::{Imager, Original};
use lattice::Lattice;
use layers::{Roles, Rows, SIZES};
pub use scratch::Scratch;
use scratch::{Buffers, SpreadScratch};
use spread::Layer;

/// Most numbers in the sums of parts of the grid, of all five spreads.
pub(crate) const MOST_GROUPED: f64 = (5 * grid::MOST_BYTES / size_of::<f64>()) as f64;

/// Where and how fields are evaluated.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluator {
    /// Resolved coordinates.
    pub coordinates: Coordinates,
    /// Points or grid in these coordinates.
    pub place: Place,
    /// The kernel.
    pub kernel: KernelChoice,
    /// Axis of cylindrical coordinates.
    pub axis: CylinderAxis,
    /// Faces of the domain at which particles and contacts are mirrored.
    pub mirrors: Mirrors,
    /// Whether fields are continued through periodic faces.
    pub images: bool,
}

impl Evaluator {
    /// An evaluator without mirrors, with the usual axis.
    #[must_use]
    pub fn new(coordinates: Coordinates, place: Place, kernel: KernelChoice) -> Self {
        Self {
            coordinates,
            place,
            kernel,
            axis: CylinderAxis::default(),
            mirrors: [[false; 2]; 3],
            images: true,
        }
    }

    /// Names of the directions of vectors and tensors.
    #[must_use]
    pub fn axis_names(&self) -> [&'static str; 3] {
        if self.is_turned() {
            ["r", "phi", "z"]
        } else {
            ["x", "y", "z"]
        }
    }

    /// The sums of a layout over the flowing particles (of one material, if one is given) and their contacts.
    ///
    /// Contacts that are not in the state add nothing.
    #[must_use]
    pub fn sums(&self, state: &State, layout: &Layout, material: Option<u32>) -> Sums {
        self.sums_with(state, layout, material, &mut Scratch::default())
    }

    /// The sums of [`Self::sums`], in memory that was used for another frame before.
    #[must_use]
    pub fn sums_with(
        &self,
        state: &State,
        layout: &Layout,
        material: Option<u32>,
        scratch: &mut Scratch,
    ) -> Sums {
        let roles = Roles::new(&state.particles, material);
        let uniform = roles.uniform(layout);
        let kernel = Kernel::new(self.kernel, self.coordinates.kernel_dimensions());
        let has = |spread: Spread| layout.of(spread).next().is_some();
        let spread = |spread: Spread, scratch: &mut SpreadScratch| {
            let uniform = uniform.as_deref().filter(|_| spread == Spread::Particles);
            self.spread(&state.space, &kernel, layout, spread, scratch, uniform)
        };
        // Side by side, so that what one thread alone can do of one spread does not keep the others waiting.
        let [particles, gradients, lines, moments, boundary] = &mut scratch.spreads;
        let of_particles = || {
            if has(Spread::Particles) {
                roles.particles(state, layout, uniform.is_some(), &mut particles.rows);
            }
            if has(Spread::Gradients) {
                roles.gradients(state, layout, &mut gradients.rows);
            }
            rayon::join(
                || spread(Spread::Particles, particles),
                || spread(Spread::Gradients, gradients),
            )
        };
        let of_contacts = || {
            let rows = [&mut lines.rows, &mut moments.rows, &mut boundary.rows];
            match &state.contacts {
                Some(contacts) => roles.contacts(contacts, layout, rows),
                None => rows.into_iter().for_each(Rows::clear),
            }
            rayon::join(
                || spread(Spread::Lines, lines),
                || {
                    rayon::join(
                        || spread(Spread::Moments, moments),
                        || spread(Spread::Boundary, boundary),
                    )
                },
            )
        };
        let ((particles, gradients), (lines, (moments, boundary))) =
            rayon::join(of_particles, of_contacts);
        Sums {
            layout: layout.clone(),
            points: self.place.len(),
            values: [particles, gradients, lines, moments, boundary],
        }
    }

    /// The numbers of one spread at all points, in the order of the layout.
    fn spread(
        &self,
        space: &Space,
        kernel: &Kernel,
        layout: &Layout,
        spread: Spread,
        scratch: &mut SpreadScratch,
        uniform: Option<&[f64]>,
    ) -> Vec<f64> {
        if layout.stride(spread) == 0 {
            return Vec::new();
        }
        let rows = &mut scratch.rows;
        let carried = layout
            .of(spread)
            .filter(|sum| uniform.is_none() || !SIZES.contains(sum));
        let mut parity: Vec<u8> = uniform.iter().map(|_| 0).collect();
        for sum in carried {
            // Of gradients only what is differentiated: they are made of its products with positions.
            let rank = if spread == Spread::Gradients {
                differentiated(sum)
            } else {
                sum.rank()
            };
            parity.extend(rank.parity());
        }
        let mut layer = Layer {
            spread,
            width: parity.len(),
            parity,
            values: std::mem::take(&mut rows.values),
            placed: std::mem::take(&mut scratch.placed),
            spare: std::mem::take(&mut scratch.spare),
            origin: DVec3::ZERO,
        };
        let space = if self.images {
            *space
        } else {
            Space {
                periodic: [false; 3],
                ..*space
            }
        };
        let mut found = match (&self.coordinates, &self.place) {
            (Coordinates::Cartesian([false, false, false]), place) => {
                let one = total(&layer);
                one.repeat(place.len())
            }
            (Coordinates::Cartesian(resolved), Place::Grid(grid)) => {
                let lattice = Lattice::new(*resolved, grid);
                let (low, high) = lattice.bounds();
                let unfold = |v: DVec3| {
                    let mut out = DVec3::ZERO;
                    for (k, &axis) in lattice.cartesian.iter().enumerate() {
                        out[axis] = v[k];
                    }
                    out
                };
                let imager = self.imager(&space, kernel, unfold(low), unfold(high));
                layer.origin = 0.5 * (low + high);
                imager.place(&rows.originals, |v| lattice.project(v), &mut layer.placed);
                let found = grid::spread(&lattice, kernel, &mut layer, &mut scratch.sums);
                if spread == Spread::Gradients {
                    let at = |point: usize| lattice.point(point);
                    let buffers = &mut scratch.sums.buffers;
                    finish_gradients(found, &layer, at, lattice.cartesian, buffers)
                } else {
                    found
                }
            }
            _ => {
                let buffers = &mut scratch.sums.buffers;
                self.at_points(&space, kernel, &mut layer, &mut rows.originals, buffers)
            }
        };
        (rows.values, scratch.placed, scratch.spare) = (layer.values, layer.placed, layer.spare);
        let width = layer.width;
        if let Some(uniform) = uniform {
            found = expand(found, width, uniform, &mut scratch.sums.buffers);
        }
        let kernel_axes = self.coordinates.kernel_axes();
        let unresolved = (0..3).filter(|&axis| !kernel_axes[axis]);
        let lengths: f64 = unresolved
            .map(|axis| self.turned_space(&space).extent(axis))
            .product();
        if lengths != 1.0 {
            found.par_iter_mut().for_each(|value| *value /= lengths);
        }
        if let Coordinates::Cylindrical { angle, .. } = self.coordinates {
            found = self.in_cylinder(&found, layout, spread, angle);
        }
        found
    }

    /// Largest mean number of images of a particle, itself among them: as many as the kernel sees through periodic faces and
    /// mirrors.
    #[must_use]
    pub fn images_of_each(&self, space: &Space) -> f64 {
        let mut space = self.turned_space(space);
        space.periodic = space.periodic.map(|periodic| periodic && self.images);
        let all = |a: usize, ends: [f64; 2]| -> [f64; 2] {
            (0..self.place.len()).fold(ends, |[low, high], point| {
                let at = self.place.coordinates(point)[a];
                [low.min(at), high.max(at)]
            })
        };
        let ends = |a: usize| match &self.place {
            Place::Grid(axes) => [axes[a].min, axes[a].max],
            Place::Points(_) => all(a, [f64::INFINITY, f64::NEG_INFINITY]),
        };
        let (mut low, mut high) = (DVec3::ZERO, DVec3::ZERO);
        match self.coordinates {
            Coordinates::Cartesian(resolved) => {
                for (k, axis) in (0..3).filter(|&axis| resolved[axis]).enumerate() {
                    [low[axis], high[axis]] = ends(k);
                }
            }
            Coordinates::Cylindrical { angle, along } => {
                let [_, radius] = ends(0);
                (low, high) = (DVec3::splat(-radius), DVec3::splat(radius));
                if along {
                    [low.z, high.z] = ends(1 + usize::from(angle));
                }
            }
        }
        let kernel = &self.kernel;
        let reach = match kernel.shape {
            KernelShape::Gaussian => kernel.cutoff * kernel.width,
            _ => kernel.width,
        };
        Imager {
            space: &space,
            mirrors: &self.mirrors,
            low,
            high,
            resolved: self.coordinates.kernel_axes(),
            reach,
        }
        .count()
    }

    fn imager<'a>(
        &'a self,
        space: &'a Space,
        kernel: &Kernel,
        low: DVec3,
        high: DVec3,
    ) -> Imager<'a> {
        Imager {
            space,
            mirrors: &self.mirrors,
            low,
            high,
            resolved: self.coordinates.kernel_axes(),
            reach: kernel.reach(),
        }
    }

    /// The space with the axis of cylindrical coordinates as its third.
    fn turned_space(&self, space: &Space) -> Space {
        if !self.is_turned() {
            return *space;
        }
        let k = self.axis.along;
        Space {
            min: self.axis.turn_point(space.min),
            max: self.axis.turn_point(space.max),
            periodic: [1, 2, 3].map(|a| space.periodic[(k + a) % 3]),
            dimensions: space.dimensions,
        }
    }

    fn is_turned(&self) -> bool {
        matches!(self.coordinates, Coordinates::Cylindrical { .. })
    }

    /// The points in Cartesian coordinates, and how many make one point of the result: means over circles take several.
    fn cartesian_points(&self) -> (Vec<DVec3>, Vec<usize>) {
        let mut points = Vec::new();
        let mut counts = Vec::with_capacity(self.place.len());
        for k in 0..self.place.len() {
            let at = self.place.coordinates(k);
            match self.coordinates {
                Coordinates::Cartesian(resolved) => {
                    let mut rest = at.into_iter();
                    let part = |resolved: bool| {
                        if resolved {
                            rest.next().unwrap_or(0.0)
                        } else {
                            0.0
                        }
                    };
                    points.push(DVec3::from_array(resolved.map(part)));
                    counts.push(1);
                }
                Coordinates::Cylindrical { angle, along } => {
                    let z = if along { at[at.len() - 1] } else { 0.0 };
                    let smooth = self.kernel.width
                        * if self.kernel.shape == KernelShape::Gaussian {
                            1.0
                        } else {
                            0.125
                        };
                    let around = if angle {
                        vec![at[1]]
                    } else {
                        circle(at[0], smooth)
                    };
                    counts.push(around.len());
                    points.extend(
                        around.into_iter().map(|phi| {
                            DVec3::new(at[0] * libm::cos(phi), at[0] * libm::sin(phi), z)
                        }),
                    );
                }
            }
        }
        (points, counts)
    }

    fn at_points(
        &self,
        space: &Space,
        kernel: &Kernel,
        layer: &mut Layer,
        originals: &mut [Original],
        buffers: &mut Buffers,
    ) -> Vec<f64> {
        let (points, _) = self.cartesian_points();
        let turned = self.is_turned();
        let space = self.turned_space(space);
        let resolved = self.coordinates.kernel_axes();
        let project = |v: DVec3| {
            let part = |axis: usize| if resolved[axis] { v[axis] } else { 0.0 };
            DVec3::new(part(0), part(1), part(2))
        };
        let low = points.iter().fold(DVec3::INFINITY, |low, &p| low.min(p));
        let high = points
            .iter()
            .fold(DVec3::NEG_INFINITY, |high, &p| high.max(p));
        if turned {
            for original in &mut *originals {
                original.middle = self.axis.turn_point(original.middle);
                original.segment = self.axis.turn(original.segment);
            }
        }
        layer.origin = if points.is_empty() {
            DVec3::ZERO
        } else {
            0.5 * (low + high)
        };
        let imager = self.imager(&space, kernel, low, high);
        imager.place(originals, project, &mut layer.placed);
        let found = gather(&points, kernel, layer);
        if layer.spread == Spread::Gradients {
            // Directions are those of the turned axes, numbers along those of the input.
            let k = if turned { self.axis.along } else { 2 };
            let axes = [1, 2, 3].map(|a| (k + a) % 3);
            finish_gradients(found, layer, |point| points[point], axes, buffers)
        } else {
            found
        }
    }

    /// Turns vectors and tensors into the directions r, phi, z of each point, and takes means over circles.
    fn in_cylinder(&self, found: &[f64], layout: &Layout, spread: Spread, angle: bool) -> Vec<f64> {
        let stride = layout.stride(spread);
        if stride == 0 {
            return Vec::new();
        }
        let (points, counts) = self.cartesian_points();
        let mut out = vec![0.0; counts.len() * stride];
        let mut first = 0;
        for (out, &count) in out.chunks_exact_mut(stride).zip(&counts) {
            for k in first..first + count {
                let at = points[k];
                let radius = libm::hypot(at.x, at.y);
                // On the axis itself the direction is that of the angle 0, or of the requested angle.
                let (cos, sin) = if radius > 0.0 {
                    (at.x / radius, at.y / radius)
                } else {
                    (1.0, 0.0)
                };
                let basis = [
                    DVec3::new(cos, sin, 0.0),
                    DVec3::new(-sin, cos, 0.0),
                    DVec3::Z,
                ];
                let mut offset = 0;
                for sum in layout.of(spread) {
                    let numbers = sum.rank().components();
                    let part = &found[k * stride + offset..][..numbers];
                    self.turn(sum.rank(), part, &basis, &mut out[offset..offset + numbers]);
                    offset += numbers;
                }
            }
            first += count;
            if !angle {
                for value in out {
                    *value /= count as f64;
                }
            }
        }
        out
    }

    /// Adds the components along a basis, which is one of the turned axes.
    fn turn(&self, rank: Rank, from: &[f64], basis: &[DVec3; 3], to: &mut [f64]) {
        // The numbers are along the axes of the input; the basis is written in the turned ones.
        let k = self.axis.along;
        let back = |v: DVec3| {
            let mut out = DVec3::ZERO;
            for a in 0..3 {
                out[(k + 1 + a) % 3] = v[a];
            }
            out
        };
        let basis = basis.map(back);
        match rank {
            Rank::Scalars(_) => {
                for (to, from) in to.iter_mut().zip(from) {
                    *to += from;
                }
            }
            Rank::Vector | Rank::Axial => {
                let v = DVec3::new(from[0], from[1], from[2]);
                for (to, direction) in to.iter_mut().zip(basis) {
                    *to += v.dot(direction);
                }
            }
            Rank::Symmetric => {
                let tensor = |a: usize, b: usize| {
                    let pair = (a.min(b), a.max(b));
                    let place = SYMMETRIC
                        .iter()
                        .position(|&other| other == pair)
                        .unwrap_or(0);
                    from[place]
                };
                for (to, &(a, b)) in to.iter_mut().zip(&SYMMETRIC) {
                    *to += along(&tensor, basis[a], basis[b]);
                }
            }
            Rank::Tensor | Rank::AxialTensor => {
                let tensor = |a: usize, b: usize| from[3 * a + b];
                for (k, to) in to.iter_mut().enumerate() {
                    *to += along(&tensor, basis[k / 3], basis[k % 3]);
                }
            }
        }
    }
}

/// a . tensor . b
fn along(tensor: &impl Fn(usize, usize) -> f64, a: DVec3, b: DVec3) -> f64 {
    let mut sum = 0.0;
    for i in 0..3 {
        for j in 0..3 {
            sum += a[i] * tensor(i, j) * b[j];
        }
    }
    sum
}

/// Angles at equal distances around a circle.
fn circle(radius: f64, smooth: f64) -> Vec<f64> {
    let count = angles(radius, smooth);
    let step = 2.0 * std::f64::consts::PI / count as f64;
    (0..count).map(|k| (k as f64 + 0.5) * step).collect()
}

/// Rank of the quantity whose gradient this is.
fn differentiated(gradient: Sum) -> Rank {
    match gradient {
        Sum::MassGradient | Sum::DisplacedMassGradient => Rank::Scalars(1),
        _ => Rank::Vector,
    }
}

/// Gradients from sums with and without positions, in the order of the layout: of each number its derivatives along x, y, z.
fn finish_gradients(
    found: Vec<f64>,
    layer: &Layer,
    at: impl Fn(usize) -> DVec3 + Sync,
    cartesian: [usize; 3],
    buffers: &mut Buffers,
) -> Vec<f64> {
    let (width, channels) = (layer.width, layer.channels());
    let mut out = buffers.any(found.len() / channels * 3 * width);
    out.par_chunks_exact_mut(3 * width)
        .zip(found.par_chunks_exact(channels))
        .enumerate()
        .for_each(|(point, (out, found))| {
            let from = at(point) - layer.origin;
            for k in 0..width {
                for direction in 0..3 {
                    let slope = from[direction] * found[k] - found[width * (1 + direction) + k];
                    out[3 * k + cartesian[direction]] = slope;
                }
            }
        });
    buffers.keep(found);
    out
}

/// Sizes, volume and mass from the number of equal particles, which stands first in the reduced rows.
fn expand(found: Vec<f64>, width: usize, uniform: &[f64], buffers: &mut Buffers) -> Vec<f64> {
    let whole = width - 1 + uniform.len();
    let mut out = buffers.any(found.len() / width * whole);
    out.par_chunks_exact_mut(whole)
        .zip(found.par_chunks_exact(width))
        .for_each(|(out, found)| {
            for (out, of_one) in out.iter_mut().zip(uniform) {
                *out = of_one * found[0];
            }
            out[uniform.len()..].copy_from_slice(&found[1..]);
        });
    buffers.keep(found);
    out
}

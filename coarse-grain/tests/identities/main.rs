//! The identities that fields must obey, on random packings.

mod balances;
mod cylinders;
mod definitions;
mod images;
mod places;
#[path = "../support/mod.rs"]
mod support;
mod totals;

use mercury_cg::coordinates::{Coordinates, GridAxis, Place};
use mercury_cg::evaluate::Evaluator;
use mercury_cg::kernel::{KernelChoice, KernelShape};
use mercury_cg::state::State;
use mercury_cg::sums::{Layout, SUMS, Sum, Sums};

pub(crate) const SHAPES: [KernelShape; 4] = [
    KernelShape::Gaussian,
    KernelShape::Lucy,
    KernelShape::Linear,
    KernelShape::Heaviside,
];

/// A kernel without cut-off or quadrature error in double precision.
pub(crate) fn exact(shape: KernelShape, width: f64) -> KernelChoice {
    KernelChoice {
        cutoff: 8.8,
        tolerance: 1e-16,
        ..KernelChoice::new(shape, width)
    }
}

pub(crate) fn axis(min: f64, max: f64, count: usize) -> GridAxis {
    GridAxis { min, max, count }
}

pub(crate) fn all() -> Layout {
    Layout::new(SUMS)
}

pub(crate) fn integral(sums: &Sums, sum: Sum, cell: f64) -> Vec<f64> {
    let mut total = vec![0.0; sum.rank().components()];
    for point in 0..sums.points {
        for (total, value) in total.iter_mut().zip(sums.at(sum, point)) {
            *total += cell * value;
        }
    }
    total
}

pub(crate) fn close(found: &[f64], expected: &[f64], tolerance: f64, what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let scale = expected
        .iter()
        .fold(1e-300f64, |scale, value| scale.max(value.abs()));
    for (a, b) in found.iter().zip(expected) {
        assert!(
            (a - b).abs() <= tolerance * scale,
            "{what}: {found:?} {expected:?}"
        );
    }
}

/// Without coordinates the sums are plain sums, divided by the volume.
pub(crate) fn totals(state: &State, layout: &Layout) -> Sums {
    let place = Place::Points(vec![Vec::new()]);
    let evaluator = Evaluator::new(
        Coordinates::Cartesian([false; 3]),
        place,
        exact(KernelShape::Gaussian, 0.1),
    );
    evaluator.sums(state, layout, None)
}

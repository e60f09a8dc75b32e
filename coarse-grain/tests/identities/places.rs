//! Fields do not depend on the grid, nor on threads.

use mercury_cg::coordinates::{Coordinates, GridAxis, Place};
use mercury_cg::evaluate::Evaluator;
use mercury_cg::kernel::{KernelChoice, KernelShape};
use mercury_cg::sums::{Sum, Sums};

use crate::support::packing;
use crate::{SHAPES, all, axis, close};

#[test]
fn a_grid_and_points_give_the_same() {
    let state = packing(60, 5, false);
    let layout = all();
    let axes = [axis(0.1, 0.9, 4), axis(-0.2, 0.7, 5), axis(0.0, 1.2, 3)];
    for shape in SHAPES {
        for resolved in [
            [true, true, true],
            [true, false, true],
            [true, true, false],
            [false, false, true],
            [false, true, false],
        ] {
            let grid: Vec<GridAxis> = (0..3).filter(|&a| resolved[a]).map(|a| axes[a]).collect();
            let choice = KernelChoice {
                cutoff: 4.0,
                tolerance: 1e-16,
                ..KernelChoice::new(
                    shape,
                    if shape == KernelShape::Gaussian {
                        0.09
                    } else {
                        0.31
                    },
                )
            };
            let on_grid =
                Evaluator::new(Coordinates::Cartesian(resolved), Place::Grid(grid), choice);
            let points = (0..on_grid.place.len())
                .map(|k| on_grid.place.coordinates(k))
                .collect();
            let at_points = Evaluator {
                place: Place::Points(points),
                ..on_grid.clone()
            };
            let (a, b) = (
                on_grid.sums(&state, &layout, None),
                at_points.sums(&state, &layout, None),
            );
            for (spread, (a, b)) in a.values.iter().zip(&b.values).enumerate() {
                // A constant has no slope.
                let flat = shape == KernelShape::Heaviside && spread == 1;
                assert!(flat || a.iter().any(|&value| value != 0.0));
                // Gradients of the linear kernel and moments by differences lose digits.
                close(a, b, 2e-10, &format!("{shape:?} {resolved:?} {spread}"));
            }
        }
    }
}

#[test]
fn a_point_does_not_depend_on_its_grid() {
    let state = packing(60, 6, false);
    let choice = KernelChoice {
        tolerance: 1e-16,
        ..KernelChoice::new(KernelShape::Gaussian, 0.1)
    };
    let value = |place: Place, point: usize| {
        Evaluator::new(Coordinates::Cartesian([true, false, true]), place, choice)
            .sums(&state, &all(), None)
            .at(Sum::Stress, point)
            .to_vec()
    };
    // The middle of one cell is the middle of three.
    let one = value(Place::Grid(vec![axis(0.3, 0.5, 1), axis(0.2, 0.4, 1)]), 0);
    let three = value(Place::Grid(vec![axis(0.3, 0.5, 3), axis(0.2, 0.4, 3)]), 4);
    let many = value(
        Place::Grid(vec![axis(0.0, 0.8, 4 * 5), axis(0.1, 0.5, 2 * 7)]),
        9 * 14 + 6,
    );
    close(&one, &three, 1e-13, "one and three");
    assert!(many.iter().all(|value| value.is_finite()));
}

#[test]
fn the_bytes_do_not_depend_on_threads() {
    let state = packing(150, 11, false);
    let places = [
        (
            Coordinates::default(),
            Place::Grid(vec![
                axis(0.0, 1.0, 17),
                axis(0.0, 1.0, 9),
                axis(0.0, 1.0, 11),
            ]),
        ),
        (
            Coordinates::Cartesian([false, false, true]),
            Place::Grid(vec![axis(0.0, 1.0, 23)]),
        ),
        (
            Coordinates::Cartesian([false; 3]),
            Place::Points(vec![Vec::new()]),
        ),
        (
            Coordinates::Cylindrical {
                angle: false,
                along: true,
            },
            Place::Grid(vec![axis(0.0, 0.5, 7), axis(0.0, 1.0, 5)]),
        ),
    ];
    for (coordinates, place) in places {
        for shape in [KernelShape::Gaussian, KernelShape::Lucy] {
            let evaluator =
                Evaluator::new(coordinates, place.clone(), KernelChoice::new(shape, 0.12));
            let with = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new()
                    .num_threads(threads)
                    .build()
                    .unwrap();
                pool.install(|| evaluator.sums(&state, &all(), None))
            };
            let bits = |sums: &Sums| {
                sums.values
                    .iter()
                    .flatten()
                    .map(|value| value.to_bits())
                    .collect::<Vec<_>>()
            };
            let one = bits(&with(1));
            for threads in [2, 3, 7] {
                assert!(
                    one == bits(&with(threads)),
                    "{coordinates} {shape:?} {threads}"
                );
            }
        }
    }
}

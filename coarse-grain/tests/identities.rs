//! The identities that fields must obey, on random packings.

mod support;

use glam::DVec3;
use mercury_cg::coordinates::{Coordinates, CylinderAxis, GridAxis, Place};
use mercury_cg::evaluate::Evaluator;
use mercury_cg::kernel::{Kernel, KernelChoice, KernelShape};
use mercury_cg::state::{Partner, State};
use mercury_cg::sums::{Layout, SUMS, Sum, Sums};
use support::{loads, packing};

const SHAPES: [KernelShape; 4] = [
    KernelShape::Gaussian,
    KernelShape::Lucy,
    KernelShape::Linear,
    KernelShape::Heaviside,
];

/// A kernel without cut-off or quadrature error in double precision.
fn exact(shape: KernelShape, width: f64) -> KernelChoice {
    KernelChoice {
        cutoff: 8.8,
        tolerance: 1e-16,
        ..KernelChoice::new(shape, width)
    }
}

fn axis(min: f64, max: f64, count: usize) -> GridAxis {
    GridAxis { min, max, count }
}

fn all() -> Layout {
    Layout::new(SUMS)
}

fn integral(sums: &Sums, sum: Sum, cell: f64) -> Vec<f64> {
    let mut total = vec![0.0; sum.rank().components()];
    for point in 0..sums.points {
        for (total, value) in total.iter_mut().zip(sums.at(sum, point)) {
            *total += cell * value;
        }
    }
    total
}

fn close(found: &[f64], expected: &[f64], tolerance: f64, what: &str) {
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
fn totals(state: &State, layout: &Layout) -> Sums {
    let place = Place::Points(vec![Vec::new()]);
    let evaluator = Evaluator::new(
        Coordinates::Cartesian([false; 3]),
        place,
        exact(KernelShape::Gaussian, 0.1),
    );
    evaluator.sums(state, layout, None)
}

#[test]
fn integrals_of_fields_are_sums_over_particles_and_contacts() {
    let state = packing(40, 1, false);
    let total = totals(&state, &all());
    // The sums without coordinates: Love's and Weber's stress, written out once more.
    let c = state.contacts.as_ref().unwrap();
    let mut stress = [0.0; 9];
    for k in 0..c.len() {
        let flows = |partner: Partner| matches!(partner, Partner::Particle(j) if state.particles.flowing[j as usize]);
        let mut l = DVec3::ZERO;
        l += if state.particles.flowing[c.particle[k] as usize] {
            c.arm[k]
        } else {
            DVec3::ZERO
        };
        l -= if flows(c.partner[k]) {
            c.partner_arm[k]
        } else {
            DVec3::ZERO
        };
        for a in 0..9 {
            stress[a] += c.force[k][a / 3] * l[a % 3];
        }
    }
    close(total.at(Sum::Stress, 0), &stress, 1e-13, "stress");
    // x and y are periodic, z is open: the grid goes on as far as the kernel reaches. h = 0.75 w: exact to 4e-15.
    let w = 0.1;
    let count = |length: f64| (length / (0.75 * w)).ceil() as usize;
    let grid = vec![
        axis(0.0, 1.0, count(1.0)),
        axis(0.0, 1.0, count(1.0)),
        axis(-1.0, 2.0, count(3.0)),
    ];
    let cell = grid.iter().map(GridAxis::step).product::<f64>();
    let evaluator = Evaluator::new(
        Coordinates::default(),
        Place::Grid(grid),
        exact(KernelShape::Gaussian, w),
    );
    let sums = evaluator.sums(&state, &all(), None);
    for sum in [
        Sum::Sizes,
        Sum::Volume,
        Sum::Mass,
        Sum::Momentum,
        Sum::MomentumFlux,
        Sum::Touching,
        Sum::Spin,
        Sum::SpinFlux,
        Sum::Stress,
        Sum::ContactCount,
        Sum::Fabric,
        Sum::CoupleDifference,
        Sum::BoundaryForce,
        Sum::BoundaryCouple,
    ] {
        close(
            &integral(&sums, sum, cell),
            total.at(sum, 0),
            2e-13,
            &format!("{sum:?}"),
        );
    }
    // First moments of line integrals and gradients integrate to nothing.
    for sum in [Sum::CoupleSum, Sum::MomentumGradient, Sum::MassGradient] {
        let largest = sums
            .values
            .iter()
            .flatten()
            .fold(0.0f64, |a, b| a.max(b.abs()));
        for value in integral(&sums, sum, cell) {
            assert!(value.abs() < 1e-12 * largest, "{sum:?}: {value}");
        }
    }
}

#[test]
fn one_contact_integrates_to_force_times_branch_for_every_kernel() {
    let state = |l: DVec3, force: DVec3| {
        let mut state = packing(2, 3, true);
        state.space.periodic = [false; 3];
        let c = state.contacts.as_mut().unwrap();
        *c = Default::default();
        state.particles.flowing = vec![true; 2];
        let middle = DVec3::splat(0.5);
        c.particle.push(0);
        c.partner.push(Partner::Particle(1));
        c.point.push(middle);
        c.arm.push(0.4 * l);
        c.partner_arm.push(-0.6 * l);
        c.normal.push(l.normalize());
        c.force.push(force);
        state
    };
    let (l, force) = (DVec3::new(0.06, -0.02, 0.11), DVec3::new(1.0, 2.0, -0.5));
    let expected: Vec<f64> = (0..9).map(|k| force[k / 3] * l[k % 3]).collect();
    for shape in SHAPES {
        for cutoff in [3.0, 5.0, 8.8] {
            let w = if shape == KernelShape::Gaussian {
                0.1
            } else {
                0.35
            };
            let grid = |n| vec![axis(-0.6, 1.6, n), axis(-0.6, 1.6, n), axis(-0.6, 1.6, n)];
            let n = 44;
            let choice = KernelChoice {
                cutoff,
                tolerance: 1e-15,
                ..KernelChoice::new(shape, w)
            };
            let evaluator = Evaluator::new(Coordinates::default(), Place::Grid(grid(n)), choice);
            let sums = evaluator.sums(&state(l, force), &Layout::new(&[Sum::Stress]), None);
            let cell = (2.2 / n as f64).powi(3);
            // What a sum over cells sees of a function with a jump or a kink at its edge.
            let tolerance = match (shape, cutoff) {
                (KernelShape::Gaussian, 8.8) => 1e-13,
                (KernelShape::Gaussian, 5.0) => 2e-5,
                (KernelShape::Gaussian, _) => 5e-3,
                (KernelShape::Lucy, _) => 1e-4,
                (KernelShape::Linear, _) => 5e-3,
                (KernelShape::Heaviside, _) => 2e-2,
            };
            close(
                &integral(&sums, Sum::Stress, cell),
                &expected,
                tolerance,
                &format!("{shape:?} {cutoff}"),
            );
            if shape != KernelShape::Gaussian {
                break;
            }
        }
    }
}

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

/// d/dt j = -div(k + sigma_c) + sum (f - contacts) phi + boundary force, at points, with the exact derivative of the sums in time on the
/// left and differences of sixth order of the fields on the right.
#[test]
fn momentum_and_spin_are_balanced() {
    let state = packing(80, 7, false);
    let loads = loads(&state);
    let layout = all();
    let resolved_sets = [
        [true, true, true],
        [false, true, true],
        [false, false, true],
    ];
    for (shape, w) in [(KernelShape::Gaussian, 0.1), (KernelShape::Lucy, 0.4)] {
        for resolved in resolved_sets {
            let coordinates = Coordinates::Cartesian(resolved);
            let dimensions = coordinates.kernel_dimensions();
            let choice = exact(shape, w);
            let kernel = Kernel::new(choice, dimensions);
            // Lucy's third derivative jumps at its edge: there differences are of second order, and steps short.
            let h = if shape == KernelShape::Lucy {
                2e-4
            } else {
                0.02
            } * w;
            let centre = DVec3::new(0.37, 0.81, 0.43);
            let offsets = [-3.0, -2.0, -1.0, 1.0, 2.0, 3.0];
            let weights = [
                -1.0 / 60.0,
                9.0 / 60.0,
                -45.0 / 60.0,
                45.0 / 60.0,
                -9.0 / 60.0,
                1.0 / 60.0,
            ];
            let axes: Vec<usize> = (0..3).filter(|&axis| resolved[axis]).collect();
            let mut points = vec![axes.iter().map(|&axis| centre[axis]).collect::<Vec<f64>>()];
            for k in 0..axes.len() {
                for offset in offsets {
                    let mut point = points[0].clone();
                    point[k] += offset * h;
                    points.push(point);
                }
            }
            let sums = Evaluator::new(coordinates, Place::Points(points), choice)
                .sums(&state, &layout, None);
            // Divergence over the second index of a tensor.
            let divergence = |of: &dyn Fn(usize, usize, usize) -> f64| {
                let mut out = [0.0; 3];
                for (a, out) in out.iter_mut().enumerate() {
                    for (k, &axis) in axes.iter().enumerate() {
                        for (q, weight) in weights.iter().enumerate() {
                            *out += weight * of(1 + 6 * k + q, a, axis) / h;
                        }
                    }
                }
                DVec3::from_array(out)
            };
            let flux = |point: usize, a: usize, b: usize| {
                let place = mercury_cg::sums::SYMMETRIC
                    .iter()
                    .position(|&pair| pair == (a.min(b), a.max(b)))
                    .unwrap();
                sums.at(Sum::MomentumFlux, point)[place]
            };
            let tensor = |sum: Sum| {
                let sums = &sums;
                move |point: usize, a: usize, b: usize| sums.at(sum, point)[3 * a + b]
            };
            let vector = |sum: Sum| DVec3::from_slice(sums.at(sum, 0));
            let (stress, spin_flux) = (tensor(Sum::Stress), tensor(Sum::SpinFlux));
            let (difference, couple_sum) = (tensor(Sum::CoupleDifference), tensor(Sum::CoupleSum));
            let right =
                vector(Sum::BoundaryForce) - divergence(&|p, a, b| flux(p, a, b) + stress(p, a, b));
            // eps_abg sigma_gb: what the asymmetric part of the stress turns.
            let turning = DVec3::new(
                stress(0, 2, 1) - stress(0, 1, 2),
                stress(0, 0, 2) - stress(0, 2, 0),
                stress(0, 1, 0) - stress(0, 0, 1),
            );
            let right_spin = vector(Sum::BoundaryCouple)
                - turning
                - divergence(&|p, a, b| {
                    spin_flux(p, a, b) + difference(p, a, b) + couple_sum(p, a, b)
                });
            // The derivative of the sums, images included.
            let project = |v: DVec3| {
                DVec3::from_array([0, 1, 2].map(|axis| if resolved[axis] { v[axis] } else { 0.0 }))
            };
            let (mut left, mut left_spin, mut scale) = (DVec3::ZERO, DVec3::ZERO, [0.0f64; 2]);
            let particles = &state.particles;
            for (k, &(force, torque)) in loads.iter().enumerate() {
                if !particles.flowing[k] {
                    continue;
                }
                for i in -2..=2 {
                    for j in -2..=2 {
                        if (i != 0 && !resolved[0]) || (j != 0 && !resolved[1]) {
                            continue;
                        }
                        let from = project(
                            centre
                                - particles.position[k]
                                - DVec3::new(f64::from(i), f64::from(j), 0.0),
                        );
                        let square = from.length_squared();
                        let (phi, slope) = (kernel.phi(square), kernel.slope(square));
                        let v = project(particles.velocity[k]);
                        let moved = -slope * from.dot(v);
                        let (a, b) = (
                            force * phi,
                            particles.mass[k] * particles.velocity[k] * moved,
                        );
                        let (c, d) = (torque * phi, particles.spin[k] * moved);
                        left += a + b;
                        left_spin += c + d;
                        scale[0] = scale[0]
                            .max(a.abs().max_element())
                            .max(b.abs().max_element());
                        scale[1] = scale[1]
                            .max(c.abs().max_element())
                            .max(d.abs().max_element());
                    }
                }
            }
            let tolerance = if shape == KernelShape::Lucy {
                1e-5
            } else {
                1e-9
            };
            assert!(
                (left - right).abs().max_element() < tolerance * scale[0],
                "{shape:?} {resolved:?}: {left} {right}"
            );
            assert!(
                (left_spin - right_spin).abs().max_element() < 30.0 * tolerance * scale[1],
                "{shape:?} {resolved:?}: {left_spin} {right_spin}"
            );
        }
    }
}

#[test]
fn gradients_are_those_of_the_fields() {
    let state = packing(60, 8, false);
    for (shape, w, tolerance) in [
        (KernelShape::Gaussian, 0.1, 1e-9),
        (KernelShape::Lucy, 0.4, 1e-5),
    ] {
        let h = if shape == KernelShape::Lucy {
            2e-4
        } else {
            0.02
        } * w;
        let centre = DVec3::new(0.52, 0.13, 0.6);
        let mut points = vec![centre.to_array().to_vec()];
        for axis in 0..3 {
            for offset in [-2.0, -1.0, 1.0, 2.0] {
                let mut point = centre;
                point[axis] += offset * h;
                points.push(point.to_array().to_vec());
            }
        }
        let sums = Evaluator::new(
            Coordinates::default(),
            Place::Points(points),
            exact(shape, w),
        )
        .sums(&state, &all(), None);
        let largest = sums
            .at(Sum::MomentumGradient, 0)
            .iter()
            .fold(0.0f64, |a, b| a.max(b.abs()));
        for a in 0..3 {
            for axis in 0..3 {
                let j = |k: usize| sums.at(Sum::Momentum, 1 + 4 * axis + k)[a];
                let slope = (j(0) - 8.0 * j(1) + 8.0 * j(2) - j(3)) / (12.0 * h);
                let found = sums.at(Sum::MomentumGradient, 0)[3 * a + axis];
                assert!(
                    (slope - found).abs() < 100.0 * tolerance * largest,
                    "{shape:?} {a} {axis}: {slope} {found}"
                );
            }
        }
    }
}

#[test]
fn materials_add_up_to_the_mixture_and_their_drag_to_nothing() {
    let state = packing(80, 9, false);
    let grid = vec![axis(0.0, 1.0, 4), axis(0.0, 1.0, 3), axis(0.0, 1.0, 5)];
    let evaluator = Evaluator::new(
        Coordinates::default(),
        Place::Grid(grid),
        exact(KernelShape::Gaussian, 0.1),
    );
    let whole = evaluator.sums(&state, &all(), None);
    let mut parts = evaluator.sums(&state, &all(), Some(0));
    parts.add(&evaluator.sums(&state, &all(), Some(1)), 1.0);
    for sum in [
        Sum::Sizes,
        Sum::Mass,
        Sum::Momentum,
        Sum::MomentumFlux,
        Sum::Stress,
        Sum::BoundaryForce,
        Sum::BoundaryCouple,
        Sum::MomentumGradient,
    ] {
        for point in 0..whole.points {
            close(
                parts.at(sum, point),
                whole.at(sum, point),
                1e-11,
                &format!("{sum:?}"),
            );
        }
    }
    let single = evaluator.sums(&state, &all(), Some(0));
    let largest = single.values[4].iter().fold(0.0f64, |a, b| a.max(b.abs()));
    for point in 0..whole.points {
        assert!(
            single
                .at(Sum::Drag, point)
                .iter()
                .any(|value| value.abs() > 1e-6 * largest)
                || point > 0
        );
        for value in parts
            .at(Sum::Drag, point)
            .iter()
            .chain(whole.at(Sum::Drag, point))
        {
            assert!(value.abs() < 1e-12 * largest);
        }
    }
}

#[test]
fn equal_particles_give_the_same_as_nearly_equal_ones() {
    let mut state = packing(60, 10, true);
    let layout = Layout::new(&[
        Sum::Sizes,
        Sum::Volume,
        Sum::Mass,
        Sum::Momentum,
        Sum::MomentumFlux,
    ]);
    let evaluator = |coordinates, place| {
        Evaluator::new(
            coordinates,
            place,
            KernelChoice::new(KernelShape::Gaussian, 0.1),
        )
    };
    for evaluator in [
        evaluator(
            Coordinates::default(),
            Place::Grid(vec![axis(0.0, 1.0, 3); 3]),
        ),
        evaluator(
            Coordinates::default(),
            Place::Points(vec![vec![0.3, 0.4, 0.2]]),
        ),
        evaluator(
            Coordinates::Cartesian([false; 3]),
            Place::Points(vec![Vec::new()]),
        ),
    ] {
        let equal = evaluator.sums(&state, &layout, None);
        let mass = state.particles.mass[0];
        state.particles.mass[0] *= 1.0 + 1e-15;
        let nearly = evaluator.sums(&state, &layout, None);
        state.particles.mass[0] = mass;
        close(&equal.values[0], &nearly.values[0], 1e-13, "equal");
    }
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

#[test]
fn fields_wrap_with_the_particles() {
    let state = packing(60, 12, false);
    let mut shifted = state.clone();
    for x in &mut shifted.particles.position {
        *x += DVec3::new(0.25, 0.5, 0.0);
        *x -= DVec3::new(
            f64::from(u8::from(x.x >= 1.0)),
            f64::from(u8::from(x.y >= 1.0)),
            0.0,
        );
    }
    let contacts = shifted.contacts.as_mut().unwrap();
    for k in 0..contacts.len() {
        contacts.point[k] =
            shifted.particles.position[contacts.particle[k] as usize] - contacts.arm[k];
    }
    let grid = vec![axis(0.0, 1.0, 4), axis(0.0, 1.0, 4), axis(0.0, 1.0, 2)];
    // A kernel that reaches farther than the box: images of images.
    let evaluator = Evaluator::new(
        Coordinates::default(),
        Place::Grid(grid),
        exact(KernelShape::Gaussian, 0.2),
    );
    let (a, b) = (
        evaluator.sums(&state, &all(), None),
        evaluator.sums(&shifted, &all(), None),
    );
    for point in 0..a.points {
        let (i, j, k) = (point / 8, point / 2 % 4, point % 2);
        let moved = ((i + 1) % 4) * 8 + ((j + 2) % 4) * 2 + k;
        for sum in [
            Sum::Mass,
            Sum::MomentumFlux,
            Sum::Stress,
            Sum::BoundaryForce,
            Sum::SpinFlux,
        ] {
            close(
                b.at(sum, moved),
                a.at(sum, point),
                1e-11,
                &format!("{sum:?}"),
            );
        }
    }
}

#[test]
fn a_mirror_keeps_all_mass_inside() {
    let mut state = packing(60, 13, false);
    state.space.periodic = [true, true, false];
    let w = 0.05;
    let grid = vec![axis(0.0, 1.0, 80)];
    let cell = grid[0].step();
    let coordinates = Coordinates::Cartesian([false, false, true]);
    let open = Evaluator::new(
        coordinates,
        Place::Grid(grid),
        exact(KernelShape::Gaussian, w),
    );
    let mirrored = Evaluator {
        mirrors: [[false; 2], [false; 2], [true; 2]],
        ..open.clone()
    };
    let layout = all();
    let total = totals(&state, &layout);
    let found = integral(&mirrored.sums(&state, &layout, None), Sum::Mass, cell);
    // Sums over cells of a function whose slope is zero at both ends are exact.
    close(&found, total.at(Sum::Mass, 0), 1e-12, "mass");
    // Without mirrors what lies beyond the faces is lost: of each particle, the tails of its Gaussian. A midpoint sum misses h^2/24 of the
    // difference of the slopes at both ends.
    let kept = integral(&open.sums(&state, &layout, None), Sum::Mass, cell)[0];
    let (mut expected, mut slope) = (0.0, 0.0);
    let peak = 1.0 / ((2.0 * std::f64::consts::PI).sqrt() * w);
    let p = &state.particles;
    for k in (0..p.len()).filter(|&k| p.flowing[k]) {
        let below = |z: f64| libm::erf((z - p.position[k].z) / (2f64.sqrt() * w));
        expected += 0.5 * p.mass[k] * (below(1.0) - below(0.0));
        let at = |z: f64| (z - p.position[k].z) / w;
        let steepness =
            |z: f64| peak / w * at(z).abs() * libm::exp(-0.5 * at(z) * at(z)) * p.mass[k];
        slope += steepness(0.0) + steepness(1.0);
    }
    assert!(
        (kept - expected).abs() <= 1.2 * cell * cell / 24.0 * slope,
        "{kept} {expected}"
    );
    assert!(expected < total.at(Sum::Mass, 0)[0]);
    // Momentum through the mirror vanishes on it.
    let on_wall = Evaluator {
        place: Place::Points(vec![vec![0.0]]),
        ..mirrored
    };
    let sums = on_wall.sums(&state, &layout, None);
    let j = sums.at(Sum::Momentum, 0);
    assert!(j[2].abs() < 1e-12 * j[0].abs().max(j[1].abs()), "{j:?}");
    assert!(
        sums.at(Sum::BoundaryForce, 0)[2].abs()
            < 1e-9 * sums.at(Sum::BoundaryForce, 0)[0].abs().max(1e-3)
    );
}

#[test]
fn cylindrical_fields_keep_mass_and_turn_vectors() {
    let mut state = packing(60, 14, false);
    state.space.periodic = [false; 3];
    let middle = DVec3::splat(0.5);
    // A rigid rotation about the axis: only the velocity along phi remains.
    let omega = 3.0;
    for k in 0..state.particles.len() {
        let from = state.particles.position[k] - middle;
        state.particles.velocity[k] = omega * DVec3::new(-from.y, from.x, 0.0);
    }
    let w = 0.1;
    let layout = all();
    let coordinates = Coordinates::Cylindrical {
        angle: false,
        along: false,
    };
    let outer = 1.8;
    let count = 60;
    let grid = vec![axis(0.0, outer, count)];
    let mut evaluator = Evaluator::new(
        coordinates,
        Place::Grid(grid.clone()),
        exact(KernelShape::Gaussian, w),
    );
    evaluator.axis = CylinderAxis {
        along: 2,
        through: middle,
    };
    let sums = evaluator.sums(&state, &layout, None);
    let total = totals(&state, &layout);
    // The mean over the length of the domain, 1 m, so the integral over rings is the sum.
    let mut mass = 0.0;
    for k in 0..count {
        mass +=
            2.0 * std::f64::consts::PI * grid[0].at(k) * grid[0].step() * sums.at(Sum::Mass, k)[0];
        let j = sums.at(Sum::Momentum, k);
        let scale = sums.at(Sum::Mass, 0)[0].max(sums.at(Sum::Mass, k)[0]) * omega;
        assert!(j[0].abs() <= 1e-7 * scale && j[2].abs() < 1e-12, "{j:?}");
    }
    // A midpoint sum with an end at r = 0, where r rho is odd: h^2/24 (r rho)'(0) 2 pi is missing.
    let missing =
        2.0 * std::f64::consts::PI * grid[0].step().powi(2) / 24.0 * sums.at(Sum::Mass, 0)[0];
    assert!(
        (mass - total.at(Sum::Mass, 0)[0]).abs() < 1.2 * missing + 1e-9 * mass,
        "{mass} {:?}",
        total.at(Sum::Mass, 0)
    );
    // Turned by the angle, points of a plane are those of the plane.
    let angle = 0.7;
    let mut round = Evaluator::new(
        Coordinates::Cylindrical {
            angle: true,
            along: true,
        },
        Place::Points(vec![vec![0.3, angle, 0.4]]),
        exact(KernelShape::Gaussian, w),
    );
    round.axis = evaluator.axis;
    let plane = vec![0.5 + 0.3 * angle.cos(), 0.5 + 0.3 * angle.sin(), 0.9];
    let flat = Evaluator::new(
        Coordinates::default(),
        Place::Points(vec![plane]),
        exact(KernelShape::Gaussian, w),
    );
    let (a, b) = (
        round.sums(&state, &layout, None),
        flat.sums(&state, &layout, None),
    );
    close(a.at(Sum::Mass, 0), b.at(Sum::Mass, 0), 1e-12, "mass");
    let (s, t) = (a.at(Sum::Stress, 0), b.at(Sum::Stress, 0));
    close(&[s[0] + s[4] + s[8]], &[t[0] + t[4] + t[8]], 1e-11, "trace");
    let (e_r, e_phi) = (
        DVec3::new(angle.cos(), angle.sin(), 0.0),
        DVec3::new(-angle.sin(), angle.cos(), 0.0),
    );
    let along = |x: DVec3, y: DVec3| (0..9).map(|k| x[k / 3] * t[k] * y[k % 3]).sum::<f64>();
    close(
        &[s[1], s[3]],
        &[along(e_r, e_phi), along(e_phi, e_r)],
        1e-11,
        "shear",
    );
}

#[test]
fn an_axis_may_be_any_and_turns_with_the_state() {
    let state = packing(40, 15, false);
    // The same state with its axes permuted: x to z, y to x, z to y.
    let turn = |v: DVec3| DVec3::new(v.y, v.z, v.x);
    let mut turned = state.clone();
    let p = &mut turned.particles;
    for list in [
        &mut p.position,
        &mut p.velocity,
        &mut p.angular_velocity,
        &mut p.spin,
    ] {
        for v in list.iter_mut() {
            *v = turn(*v);
        }
    }
    let c = turned.contacts.as_mut().unwrap();
    for list in [
        &mut c.point,
        &mut c.arm,
        &mut c.partner_arm,
        &mut c.normal,
        &mut c.force,
        &mut c.couple,
    ] {
        for v in list.iter_mut() {
            *v = turn(*v);
        }
    }
    turned.space.periodic = [true, false, true];
    let coordinates = Coordinates::Cylindrical {
        angle: true,
        along: true,
    };
    let place = Place::Points(vec![vec![0.2, 0.4, 0.5], vec![0.35, 2.0, 0.1]]);
    let mut about_x = Evaluator::new(
        coordinates,
        place,
        KernelChoice::new(KernelShape::Gaussian, 0.1),
    );
    about_x.axis = CylinderAxis {
        along: 0,
        through: DVec3::new(0.0, 0.5, 0.5),
    };
    let mut about_z = about_x.clone();
    about_z.axis = CylinderAxis {
        along: 2,
        through: DVec3::new(0.5, 0.5, 0.0),
    };
    let (a, b) = (
        about_x.sums(&state, &all(), None),
        about_z.sums(&turned, &all(), None),
    );
    for (a, b) in a.values.iter().zip(&b.values) {
        close(a, b, 1e-12, "turned");
    }
}

//! Fields that are made of several sums, against their definitions.

use glam::{DMat3, DVec3};
use mercury_cg::coordinates::{Coordinates, Place};
use mercury_cg::evaluate::Evaluator;
use mercury_cg::fields::Field;
use mercury_cg::kernel::KernelShape;
use mercury_cg::state::State;
use mercury_cg::sums::Sums;

use crate::support::packing;
use crate::{all, close, exact, totals};

fn values(name: &str, sums: &Sums, point: usize) -> Vec<f64> {
    let field = Field::by_name(name).unwrap();
    let mut values = vec![0.0; field.components.count()];
    field.compute(sums, point, 3, &mut values);
    values
}

fn value(name: &str, sums: &Sums, point: usize) -> f64 {
    values(name, sums, point)[0]
}

/// Moments of the radii about their mean, one particle after the other.
#[test]
fn moments_of_the_radii_are_central_ones() {
    let state = packing(70, 15, false);
    let sums = totals(&state, &all());
    let p = &state.particles;
    let radii = p.radius.iter().zip(&p.flowing).filter(|(_, flows)| **flows);
    let radii: Vec<f64> = radii.map(|(radius, _)| *radius).collect();
    let count = radii.len() as f64;
    let mean = radii.iter().sum::<f64>() / count;
    let central = |q: i32| radii.iter().map(|r| (r - mean).powi(q)).sum::<f64>() / count;
    let variance = central(2);
    for (name, expected, tolerance) in [
        ("mean_radius", mean, 1e-13),
        // Differences of moments about 0, of which the variance is a thirtieth, its square a thousandth.
        ("radius_variance", variance, 1e-11),
        ("radius_skewness", central(3) / variance.powf(1.5), 1e-8),
        ("radius_kurtosis", central(4) / (variance * variance), 1e-8),
    ] {
        let found = value(name, &sums, 0);
        let apart = (found - expected).abs();
        assert!(
            apart < tolerance * expected.abs().max(1.0),
            "{name}: {found}, not {expected}"
        );
    }
}

/// Differences of fourth order of a vector field about the first point: of component a along b. Points: the middle, then along each axis -2h,
/// -h, h, 2h.
fn differences(name: &str, sums: &Sums, h: f64) -> DMat3 {
    let along = |axis: usize| {
        let at = |k: usize| DVec3::from_slice(&values(name, sums, 1 + 4 * axis + k));
        (at(0) - 8.0 * at(1) + 8.0 * at(2) - at(3)) / (12.0 * h)
    };
    DMat3::from_cols(along(0), along(1), along(2))
}

/// Derived rates and strains are gradients of the fields themselves, of velocities and of displacements that not all particles
/// have.
#[test]
fn rates_and_strains_are_gradients_of_fields() {
    let mut state: State = packing(60, 16, false);
    let velocities = state.particles.velocity.iter().enumerate();
    let of_some = velocities.map(|(k, v)| {
        if k % 3 == 0 {
            DVec3::NAN
        } else {
            DVec3::new(v.y, -v.x, 0.3 + v.z) * 0.01
        }
    });
    state.displacement = Some(of_some.collect());
    let (width, h) = (0.1, 2e-3);
    let centre = DVec3::new(0.45, 0.2, 0.55);
    let mut points = vec![centre.to_array().to_vec()];
    for axis in DVec3::AXES {
        for k in [-2.0, -1.0, 1.0, 2.0] {
            points.push((centre + k * h * axis).to_array().to_vec());
        }
    }
    let kernel = exact(KernelShape::Gaussian, width);
    let sums = Evaluator::new(Coordinates::default(), Place::Points(points), kernel).sums(
        &state,
        &all(),
        None,
    );
    // Of differences: (h/w)^4 = 1.6e-7 of the values.
    let tolerance = 1e-5;
    let of_velocity = differences("velocity", &sums, h);
    let symmetric = |m: DMat3| 0.5 * (m + m.transpose());
    let six = |m: DMat3| {
        let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
        [x.x, y.x, z.x, y.y, z.y, z.z]
    };
    let rate = symmetric(of_velocity);
    let check = |name: &str, expected: &[f64]| {
        close(&values(name, &sums, 0), expected, tolerance, name);
    };
    check(
        "velocity_gradient",
        &of_velocity.transpose().to_cols_array(),
    );
    check("strain_rate", &six(rate));
    check(
        "strain",
        &six(symmetric(differences("displacement", &sums, h))),
    );
    let g = |a: usize, b: usize| of_velocity.col(b)[a];
    check(
        "vorticity",
        &[g(2, 1) - g(1, 2), g(0, 2) - g(2, 0), g(1, 0) - g(0, 1)],
    );
    let mean = (rate.x_axis.x + rate.y_axis.y + rate.z_axis.z) / 3.0;
    let deviator = rate - DMat3::from_diagonal(DVec3::splat(mean));
    let squares: f64 = deviator.to_cols_array().iter().map(|x| x * x).sum();
    let shear_rate = (2.0 * squares).sqrt();
    check("shear_rate", &[shear_rate]);
    // I = shear rate times diameter over sqrt(p/rho of the grains), da Cruz et al. 2005.
    let at = |name: &str| value(name, &sums, 0);
    let grains = at("density") / at("volume_fraction");
    let number = shear_rate * 2.0 * at("mean_radius") * (grains / at("pressure")).sqrt();
    check("inertial_number", &[number]);
}

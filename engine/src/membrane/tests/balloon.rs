//! Pressure: volumes and laws. Balloons at rest are on the validation page.

use glam::DVec3;
use mercury_common::curve::Curve;

use super::super::{Load, cylinder, sphere};
use super::*;

#[test]
fn laws_of_gas_and_fluid() {
    let gas = Load::Gas {
        gas: 1e5,
        ambient: 0.9e5,
        exponent: 1.4,
    };
    let expected = 1e5 * libm::pow(1.25, 1.4) - 0.9e5;
    assert!((gas.at(0.0, 0.8, 1.0) - expected).abs() < 1e-6);
    let fluid = Load::Fluid {
        fluid: 1e4,
        bulk_modulus: 2e9,
        ambient: 1e3,
    };
    let expected = 1e4 + 2e9 * 1e-3 - 1e3;
    assert!((fluid.at(0.0, 0.999 * 2.0, 2.0) - expected).abs() < 1e-5);
    let slope = (gas.at(0.0, 1.0 - 1e-6, 1.0) - gas.at(0.0, 1.0 + 1e-6, 1.0)) / 2e-6;
    assert!((slope - gas.stiffness(1.0)).abs() < 1e-3 * slope);
    let rows = Load::Given(Curve::new(vec![(0.0, 10.0), (1.0, 30.0)]).unwrap());
    for (time, pressure) in [(-1.0, 10.0), (0.25, 15.0), (1.0, 30.0), (2.0, 30.0)] {
        assert_eq!(rows.at(time, 1.0, 1.0), pressure);
    }
    assert!(Load::Given(Curve::default()).is_none());
}

#[test]
fn fans_close_open_rims() {
    let (radius, height) = (0.05, 0.1);
    let origin = DVec3::new(1000.0, 0.0, 0.0);
    let mesh = cylinder(DVec3::Z, origin, radius, [0.0, height], 2e-3);
    let tube = sheet(&mesh, law(Elasticity::Springs));
    assert_eq!(tube.topology().rims().len(), 2);
    // Rows are polygons turned against each other; the volume is between that of the polygon and of the cylinder.
    let cylinder = std::f64::consts::PI * radius * radius * height;
    let volume = tube.enclosed(&mesh.vertices).volume;
    assert!(volume < cylinder && volume > 0.997 * cylinder, "{volume}");
    let ball = super::super::sphere(origin, radius, 5e-3);
    let closed = sheet(&ball, law(Elasticity::Springs));
    assert!(closed.topology().rims().is_empty());
    let volume = closed.enclosed(&ball.vertices).volume;
    let expected = 4.0 / 3.0 * std::f64::consts::PI * radius * radius * radius;
    assert!((volume / expected - 1.0).abs() < 0.01);
}

/// On a closed surface p A n/3 is exactly the gradient of the volume; with fans the gradient has their part too.
#[test]
fn the_gradient_of_the_volume() {
    let mut seed = 7;
    let mesh = sphere(DVec3::new(3.0, 2.0, 1.0), 1.0, 0.5);
    let ball = sheet(&mesh, law(Elasticity::Springs));
    let positions = noisy(&mesh.vertices, 0.1, &mut seed);
    let still = vec![DVec3::ZERO; positions.len()];
    let (loose, _) = forces_of(&ball, &positions, &still, 0.0);
    let (pressed, _) = forces_of(&ball, &positions, &still, 2.0);
    for (k, slope) in ball.volume_gradient(&positions).iter().enumerate() {
        assert!((pressed[k] - loose[k] - 2.0 * slope).length() < 1e-12);
    }
    let mesh = cylinder(DVec3::Z, DVec3::X, 1.0, [0.0, 1.0], 0.5);
    let tube = sheet(&mesh, law(Elasticity::Springs));
    let mut positions = noisy(&mesh.vertices, 0.1, &mut seed);
    let gradient = tube.volume_gradient(&positions);
    for vertex in [0, 5, 15] {
        for axis in 0..3 {
            let place = positions[vertex][axis];
            positions[vertex][axis] = place + 1e-5;
            let high = tube.enclosed(&positions).volume;
            positions[vertex][axis] = place - 1e-5;
            let low = tube.enclosed(&positions).volume;
            positions[vertex][axis] = place;
            let slope = (high - low) / 2e-5;
            assert!((slope - gradient[vertex][axis]).abs() < 1e-9);
        }
    }
}

//! Periodic and mirror images.

use glam::DVec3;
use mercury_cg::coordinates::{Coordinates, Place};
use mercury_cg::evaluate::Evaluator;
use mercury_cg::kernel::KernelShape;
use mercury_cg::state::{Partner, State};
use mercury_cg::sums::{SUMS, Sum};

use crate::support::packing;
use crate::{all, axis, close, exact, integral, totals};

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

/// Mirrors that face each other see each other: nothing is lost however wide the kernel is, and deep images stand where reflections put them.
#[test]
fn mirrors_see_each_other() {
    let mut state = packing(60, 15, false);
    state.space.periodic = [true, true, false];
    let coordinates = Coordinates::Cartesian([false, false, true]);
    let total = totals(&state, &all());
    for width in [0.4, 1.5] {
        let evaluator = Evaluator {
            mirrors: [[false; 2], [false; 2], [true; 2]],
            ..Evaluator::new(
                coordinates,
                Place::Grid(vec![axis(0.0, 1.0, 40)]),
                exact(KernelShape::Gaussian, width),
            )
        };
        let sums = evaluator.sums(&state, &all(), None);
        let found = integral(&sums, Sum::Mass, 1.0 / 40.0);
        close(&found, total.at(Sum::Mass, 0), 1e-12, "mass");
        // By the cosine series of this sum: the n-th term decays as exp(-(n pi w)^2 / 2).
        let p = &state.particles;
        for point in 0..sums.points {
            let z = (point as f64 + 0.5) / 40.0;
            let pi = std::f64::consts::PI;
            let term = |k: usize, n: f64| {
                let decay = libm::exp(-0.5 * (n * pi * width) * (n * pi * width));
                2.0 * decay * libm::cos(n * pi * p.position[k].z) * libm::cos(n * pi * z)
            };
            let expected: f64 = (0..p.len())
                .filter(|&k| p.flowing[k])
                .map(|k| p.mass[k] * (1.0 + (1..12).map(|n| term(k, f64::from(n))).sum::<f64>()))
                .sum();
            close(sums.at(Sum::Mass, point), &[expected], 1e-12, "density");
        }
    }
}

/// The state and its mirror image below z = 0: what is axial, as angular velocities and couples are, turns as a product of two vectors does.
fn with_mirror_image(state: &State) -> State {
    let polar = |v: DVec3| DVec3::new(v.x, v.y, -v.z);
    let axial = |v: DVec3| DVec3::new(-v.x, -v.y, v.z);
    let mut both = state.clone();
    let (p, of) = (&mut both.particles, &state.particles);
    let count = of.len() as u32;
    p.id.extend(of.id.iter().map(|id| id + count));
    p.material.extend(&of.material);
    p.flowing.extend(&of.flowing);
    p.position.extend(of.position.iter().map(|&v| polar(v)));
    p.velocity.extend(of.velocity.iter().map(|&v| polar(v)));
    p.mass.extend(&of.mass);
    p.volume.extend(&of.volume);
    p.radius.extend(&of.radius);
    p.angular_velocity
        .extend(of.angular_velocity.iter().map(|&v| axial(v)));
    p.spin.extend(of.spin.iter().map(|&v| axial(v)));
    if let (Some(c), Some(of)) = (&mut both.contacts, &state.contacts) {
        c.particle.extend(of.particle.iter().map(|row| row + count));
        c.partner
            .extend(of.partner.iter().map(|partner| match partner {
                Partner::Particle(row) => Partner::Particle(row + count),
                wall => *wall,
            }));
        for (mine, theirs) in [
            (&mut c.point, &of.point),
            (&mut c.arm, &of.arm),
            (&mut c.partner_arm, &of.partner_arm),
            (&mut c.normal, &of.normal),
            (&mut c.force, &of.force),
        ] {
            mine.extend(theirs.iter().map(|&v| polar(v)));
        }
        c.couple.extend(of.couple.iter().map(|&v| axial(v)));
    }
    both
}

#[test]
fn a_mirror_shows_the_mirror_image_of_everything() {
    let state = packing(60, 14, false);
    let both = with_mirror_image(&state);
    // The grid, where rows of it share their work, and points by themselves.
    let grid = vec![axis(0.0, 1.0, 3), axis(0.0, 1.0, 3), axis(0.0, 0.2, 4)];
    let points = (0..6)
        .map(|k| vec![0.2, 0.7, 0.03 * f64::from(k)])
        .collect();
    for place in [Place::Grid(grid), Place::Points(points)] {
        let plain = Evaluator::new(
            Coordinates::default(),
            place,
            exact(KernelShape::Lucy, 0.25),
        );
        let mirrored = Evaluator {
            mirrors: [[false; 2], [false; 2], [true, false]],
            ..plain.clone()
        };
        let found = mirrored.sums(&state, &all(), None);
        let expected = plain.sums(&both, &all(), None);
        for &sum in SUMS {
            for point in 0..found.points {
                let (found, expected) = (found.at(sum, point), expected.at(sum, point));
                let what = format!("{sum:?} at {point}");
                // On the mirror some components are nothing but round-off.
                let size = |of: &[f64]| of.iter().fold(0.0f64, |size, x| size.max(x.abs()));
                if size(expected) > 1e-9 || size(found) > 1e-9 {
                    close(found, expected, 1e-8, &what);
                }
            }
        }
    }
}

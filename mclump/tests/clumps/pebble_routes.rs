//! Mass properties of pebbles: closed form, union, voxels, against exact values and the reference lists.

use std::f64::consts::PI;

use crate::common::{assert_close, assert_vectors, ball_volume, odd_pebbles, pebble, shared, turn};
use glam::{DMat3, DVec3};
use mclump::inertia::{MassProperties, pebbles, union, voxels};
use mercury_common::formats::clump::Pebble;
use mercury_common::formats::pebble_list::read_pebble_list;
use proptest::prelude::*;

fn list(name: &str) -> Option<Vec<Pebble>> {
    let path = shared("data/shapes/pebbles")?.join(name);
    Some(read_pebble_list(path).unwrap())
}

fn union_of(pebbles: &[Pebble], tolerance: f64) -> MassProperties {
    union::integrate(pebbles, tolerance).unwrap().properties
}

#[test]
fn rod_and_t_bar_are_exact() {
    // Moments in units of (pi/6) d^5 rho, d = 1: the rod of three, the T-bar of ten touching spheres.
    for (name, volume, moments) in [
        ("clump01_shipped.csv", 3.0, DVec3::new(0.3, 2.3, 2.3)),
        ("clump02_shipped.csv", 10.0, DVec3::new(11.4, 29.0, 39.4)),
    ] {
        let Some(list) = list(name) else { return };
        let sum = pebbles::integrate(&list).unwrap();
        assert_close(sum.volume, PI / 6.0 * volume, 1e-14, name);
        assert_vectors(sum.principal_moments(), PI / 6.0 * moments, 1e-12, name);
        // They touch only, so the union is the same, and its integrand is a polynomial.
        let union = union_of(&list, 1e-6);
        assert_close(union.volume, PI / 6.0 * volume, 1e-12, name);
        assert_vectors(union.principal_moments(), PI / 6.0 * moments, 1e-11, name);
    }
}

#[test]
fn the_reference_lists_have_their_values() {
    // Sums as printed with nine digits; unions converged to 1e-7 by another program's columns.
    let Some(gomboc) = list("clump03_shipped.csv") else {
        return;
    };
    let sum = pebbles::integrate(&gomboc).unwrap();
    assert_close(sum.volume, 7.80055802, 1e-9, "sum of clump 3");
    let union = union::integrate(&gomboc, 1e-5).unwrap();
    assert_close(union.properties.volume, 0.7073147, 1e-5, "union of clump 3");
    assert!(union.relative_error < 1e-4, "{}", union.relative_error);
    // Moments and centre are printed to 1e-4.
    let moments = union.properties.principal_moments();
    assert_vectors(
        moments / DVec3::new(0.0770184, 0.0931532, 0.0975296),
        DVec3::ONE,
        1e-4,
        "moments of clump 3",
    );
    assert_vectors(
        union.properties.centre,
        DVec3::new(-3.2e-4, -3.4e-4, 6e-6),
        1e-5,
        "centre of clump 3",
    );

    let Some(rattleback) = list("clump04_shipped.csv") else {
        return;
    };
    let sum = pebbles::integrate(&rattleback).unwrap();
    assert_close(sum.volume, 30241.5475, 1e-8, "sum of clump 4");
    let union = union::integrate(&rattleback, 1e-5).unwrap();
    assert_close(union.properties.volume, 8084.730, 1e-5, "union of clump 4");
    let moments = union.properties.principal_moments();
    assert_vectors(
        moments / DVec3::new(201575.60, 3050896.01, 3178425.57),
        DVec3::ONE,
        // Printed from 200 columns, whose volume was off by 3.4e-5.
        4e-4,
        "moments of clump 4",
    );
}

#[test]
fn a_lens_of_two_balls_counts_once() {
    // Two balls of radius 1 at distance d: the lens has pi (4 + d) (2 - d)²/12 (spherical caps). With the caps' first moment
    // about the plane between, pi (h²/4) (2 - h)² for height h, the second moment along the axis follows from the halves.
    for d in [0.1, 0.7, 1.3, 1.9, 1.999] {
        let pair = [pebble(0.3, -0.2, 0.9, 1.0), pebble(0.3, -0.2 + d, 0.9, 1.0)];
        let lens = PI * (4.0 + d) * (2.0 - d).powi(2) / 12.0;
        for tolerance in [1e-4, 1e-8] {
            let union = union::integrate(&pair, tolerance).unwrap();
            let exact = 2.0 * ball_volume(1.0) - lens;
            let error = (union.properties.volume / exact - 1.0).abs();
            assert!(
                error <= union.relative_error + 1e-13,
                "{d}: {error:e} {:e}",
                union.relative_error
            );
            assert!(
                union.relative_error < 10.0 * tolerance,
                "{}",
                union.relative_error
            );
            assert_vectors(
                union.properties.centre,
                DVec3::new(0.3, -0.2 + 0.5 * d, 0.9),
                10.0 * tolerance,
                "centre",
            );
            // Along the axis: each half is the ball cut at the plane, s in [-d/2, 1] from its centre, and
            // ∫ (s + d/2)² pi (1 - s²) ds over that.
            let primitive = |s: f64| {
                let a = 0.5 * d;
                // (s² + 2 a s + a²)(1 - s²)
                s.powi(3) / 3.0 - s.powi(5) / 5.0
                    + a * (s * s - s.powi(4) / 2.0)
                    + a * a * (s - s.powi(3) / 3.0)
            };
            let along = 2.0 * PI * (primitive(1.0) - primitive(-0.5 * d));
            let second = union.properties.second_moment;
            assert_close(second.y_axis.y, along, 10.0 * tolerance, "second moment");
        }
    }
}

#[test]
fn hidden_and_doubled_pebbles_change_no_union() {
    let alone = union_of(&[pebble(1.0, 2.0, 3.0, 0.5)], 1e-6);
    let many = union_of(
        &[
            pebble(1.0, 2.0, 3.0, 0.5),
            pebble(1.0, 2.0, 3.0, 0.5),
            pebble(1.1, 2.0, 3.0, 0.3),
            // Touches from inside.
            pebble(1.2, 2.0, 3.0, 0.3),
        ],
        1e-6,
    );
    assert_close(alone.volume, ball_volume(0.5), 1e-14, "one ball");
    assert_close(many.volume, ball_volume(0.5), 1e-14, "with hidden ones");
    assert_vectors(many.centre, DVec3::new(1.0, 2.0, 3.0), 1e-14, "centre");
}

#[test]
fn voxels_of_a_ball_have_the_moment_of_a_ball_wherever_it_is() {
    // A defect of the existing tool: the shift to the centre of mass was made twice, so that the ball at x = 2 had the moments
    // (1.68, 18.4, 18.4) instead of 1.676 = 2/5 (4/3 pi).
    let exact = 0.4 * ball_volume(1.0);
    for x in [0.0, 2.0, 1e3] {
        let estimate = voxels::integrate(&[pebble(x, 0.0, 0.0, 1.0)], 100).unwrap();
        let moments = estimate.properties.principal_moments();
        let error = (moments / exact - 1.0).abs().max_element();
        assert!(error < 2e-3, "{x}: {moments}");
        assert!(
            error < 3.0 * estimate.relative_error,
            "{error:e} {:e}",
            estimate.relative_error
        );
        assert_close(estimate.properties.centre.x, x, 1e-9, "centre");
    }
}

#[test]
fn third_moments_of_pebbles_are_integrals_over_balls() {
    // Along an axis a ball at s of radius r is discs of area pi (r² - t²) at s + t. Balls of different sizes: the small ones count for their
    // distance, the large ones for their size too.
    let list = odd_pebbles();
    let centre = pebbles::integrate(&list).unwrap().centre;
    for direction in [DVec3::X, DVec3::Z, DVec3::new(0.6, -0.64, 0.48)] {
        let of_ball = |ball: &Pebble| {
            let (s, r) = ((ball.position - centre).dot(direction), ball.radius);
            let at = |t: f64| (s + t).powi(3) * PI * (r * r - t * t);
            // Boole's rule is exact up to the fifth power, as this is.
            let weights = [7.0, 32.0, 12.0, 32.0, 7.0]
                .into_iter()
                .zip([-1.0, -0.5, 0.0, 0.5, 1.0]);
            weights.map(|(weight, x)| weight * at(x * r)).sum::<f64>() * (2.0 * r / 90.0)
        };
        let parts: Vec<f64> = list.iter().map(of_ball).collect();
        let (sum, size): (f64, f64) = (parts.iter().sum(), parts.iter().map(|x| x.abs()).sum());
        let found = pebbles::third_moment(&list, centre, direction);
        assert!((found - sum).abs() < 1e-13 * size, "{found} and {sum}");
    }
}

#[test]
fn voxels_of_a_lopsided_body_have_its_centre() {
    // Four balls that do not overlap, off the origin along every axis, and lopsided along every axis.
    let list = [
        pebble(5.0, -3.0, 2.0, 1.0),
        pebble(6.7, -3.0, 2.0, 0.6),
        pebble(5.0, -1.4, 2.0, 0.5),
        pebble(5.0, -3.0, 3.5, 0.4),
    ];
    let exact = pebbles::integrate(&list).unwrap();
    let estimate = voxels::integrate(&list, 100).unwrap();
    let off = estimate.properties.centre - exact.centre;
    // A share e of the volume is counted where it is not or not counted where it is, which moves the centre by at most e times the size
    // of the body, here 33 voxels along the longest edge of 3.3: well below half a voxel.
    let (size, voxel) = (3.3, 3.3 / 100.0);
    let allowed = estimate.relative_error * size;
    assert!(allowed < 0.2 * voxel, "{allowed} of {voxel}");
    assert!(off.abs().max_element() < allowed, "{off} of {allowed}");
}

#[test]
fn voxels_count_their_own_moment() {
    // One voxel of edge 2 inside its pebble: the moment of a cube, m h²/6. The existing tool neglects it.
    let properties = voxels::integrate(&[pebble(0.0, 0.0, 0.0, 1.0)], 1)
        .unwrap()
        .properties;
    assert_close(properties.volume, 8.0, 1e-14, "volume");
    assert_vectors(
        properties.principal_moments(),
        DVec3::splat(8.0 * 4.0 / 6.0),
        1e-13,
        "moments",
    );
}

#[test]
fn voxels_refine_to_a_tolerance() {
    let pear = odd_pebbles();
    let exact = pebbles::integrate(&pear).unwrap();
    let (estimate, number) = voxels::integrate_to(&pear, 20, 2e-3).unwrap();
    assert!(number > 20, "{number}");
    assert!(estimate.relative_error <= 2e-3);
    assert_close(estimate.properties.volume, exact.volume, 2e-3, "volume");
    let moments = estimate.properties.principal_moments() / exact.principal_moments();
    assert_vectors(moments, DVec3::ONE, 1e-2, "moments");
}

#[test]
fn routes_are_the_same_at_any_number_of_threads() {
    let pear: Vec<Pebble> = (0..40)
        .map(|i| {
            let t = f64::from(i);
            pebble(
                t.sin(),
                (1.7 * t).cos(),
                0.05 * t,
                0.3 + 0.1 * (3.0 * t).sin(),
            )
        })
        .collect();
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| (union::integrate(&pear, 1e-6), voxels::integrate(&pear, 60)))
    };
    assert_eq!(run(1), run(3));
}

fn any_pebbles() -> impl Strategy<Value = Vec<Pebble>> {
    let one = ([-1.0..1.0, -1.0..1.0, -1.0..1.0f64], 0.05..0.8f64).prop_map(|(p, radius)| Pebble {
        position: DVec3::from_array(p),
        radius,
    });
    prop::collection::vec(one, 1..12)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Union and voxels are two roads to the same number; the union lies between the largest ball and the sum.
    #[test]
    fn union_and_voxels_agree(list in any_pebbles()) {
        let union = union::integrate(&list, 1e-5).unwrap();
        let sum = pebbles::integrate(&list).unwrap();
        let largest = list.iter().map(|p| ball_volume(p.radius)).fold(0.0, f64::max);
        prop_assert!(union.properties.volume <= sum.volume * (1.0 + 1e-12));
        prop_assert!(union.properties.volume >= largest * (1.0 - 1e-5));
        let voxels = voxels::integrate(&list, 60).unwrap();
        let error = (voxels.properties.volume / union.properties.volume - 1.0).abs();
        // A ball of 10 voxels across may be off by some per cent.
        prop_assert!(error < 0.03, "{error}");
    }

    /// Any pose gives the same moments. The union meets other planes, so it agrees to its accuracy only.
    #[test]
    fn poses_do_not_matter(
        list in any_pebbles(),
        numbers in [-1.0..1.0f64, -1.0..1.0, -1.0..1.0, 0.1..1.0],
        shift in [-100.0..100.0f64, -100.0..100.0, -100.0..100.0],
    ) {
        let (rotation, shift) = (turn(numbers), DVec3::from_array(shift));
        let moved: Vec<Pebble> = list
            .iter()
            .map(|p| Pebble { position: rotation * p.position + shift, radius: p.radius })
            .collect();
        let (a, b) = (pebbles::integrate(&list).unwrap(), pebbles::integrate(&moved).unwrap());
        let expected = rotation * a.inertia() * rotation.transpose();
        prop_assert!(close(b.inertia(), expected, 1e-10), "{} {}", b.inertia(), expected);
        let (a, b) = (union_of(&list, 1e-7), union_of(&moved, 1e-7));
        let expected = rotation * a.inertia() * rotation.transpose();
        prop_assert!(close(b.inertia(), expected, 1e-5), "{} {}", b.inertia(), expected);
        prop_assert!((b.volume / a.volume - 1.0).abs() < 1e-6);
    }
}

fn close(a: DMat3, b: DMat3, relative: f64) -> bool {
    let trace = b.x_axis.x + b.y_axis.y + b.z_axis.z;
    a.abs_diff_eq(b, relative * trace)
}

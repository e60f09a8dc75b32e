//! A wall is met by its images as by copies of it in all periods, wherever it has gone.

use std::sync::Arc;

use glam::{DVec3, dvec3};
use mercury_common::formats::mesh::TriangleMesh;
use mercury_common::random::Stream;
use proptest::prelude::*;

use super::touches;
use crate::cell::Cell;
use crate::state::MaterialIndex;
use crate::walls::{
    Component, Cone, Cylinder, Disc, Mesh, Motion, Revolution, Scratch, Shape, Side, SphereShell,
    Touches, Wall, WallNow, WallState,
};

const SIZE: DVec3 = DVec3::new(1.0, 1.3, 0.9);

/// Shapes of up to two periods, some along a coordinate axis, meshes of any length, and one without an end along y.
fn shape(draw: &mut impl FnMut(f64, f64) -> f64) -> Shape {
    let origin = dvec3(draw(-2.0, 3.0), draw(-2.0, 3.0), draw(-2.0, 3.0));
    let axis = dvec3(draw(-1.0, 1.0), draw(-1.0, 1.0), draw(-1.0, 1.0));
    let axis = match draw(0.0, 2.0) as usize {
        0 => axis,
        _ => DVec3::AXES[draw(0.0, 3.0) as usize],
    };
    let (size, side) = (draw(0.05, 0.9), Side::Both);
    match draw(0.0, 7.5) as u32 {
        6.. => {
            // Longer than a period, too.
            let across = dvec3(draw(-0.1, 0.1), draw(-0.1, 0.1), draw(0.1, 0.2));
            let corners = [origin, origin + 1.5 * axis, origin + across];
            let triangles = TriangleMesh::from_corners(&[corners]);
            Shape::Mesh(Arc::new(Mesh::new(&triangles, |x| x, false).unwrap()))
        }
        0 => Shape::Disc(Disc::new(axis, origin, size).unwrap()),
        1 => Shape::Cylinder(Cylinder::new(DVec3::Y, origin, size, None, side).unwrap()),
        2 => {
            let along = Some([-size, 0.7 * size]);
            Shape::Cylinder(Cylinder::new(axis, origin, size, along, side).unwrap())
        }
        3 => Shape::Cone(Cone::new(axis, origin, [0.0, size], [0.0, size], side).unwrap()),
        4 => Shape::Sphere(SphereShell::new(origin, size, side).unwrap()),
        _ => {
            let profile = [[0.0, 0.0], [size, 0.1 * size], [0.5 * size, size]];
            Shape::Revolution(Revolution::new(axis, origin, &profile, side).unwrap())
        }
    }
}

/// Where a sphere touches a wall, from its centre, m; sorted.
fn feet(shape: &Shape, centre: DVec3, reach: f64, out: impl Fn(DVec3) -> DVec3) -> Vec<DVec3> {
    let all = touches(shape, centre, reach);
    all.iter()
        .map(|touch| out(touch.normal) * touch.distance)
        .collect()
}

/// Whether a place that is touched on one copy of a shape is a rim that lies on the surface of another one, which is touched elsewhere.
fn is_rim_within(
    foot: DVec3,
    of_others: &[(DVec3, Vec<DVec3>)],
    shape: &Shape,
    gone: &WallState,
) -> bool {
    of_others.iter().any(|(centre, feet)| {
        let place = gone.into_wall(*centre - foot);
        let is_there = !touches(shape, place, 1e-10).is_empty();
        is_there && !feet.iter().any(|its| its.distance(foot) < 1e-8)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn images_are_copies_in_all_periods(
        seed in any::<u64>(),
        periodic in any::<[bool; 3]>(),
        time in 0.0..40.0f64,
        turns in any::<bool>(),
    ) {
        let mut stream = Stream::new(seed, "images", 0);
        let mut draw = |low: f64, high: f64| stream.uniform_in(low, high);
        let cell = Cell::new(DVec3::ZERO, SIZE, periodic);
        let shape = shape(&mut draw);
        let endless = !shape.bounds().0.y.is_finite();
        let velocity = dvec3(draw(-1.0, 1.0), draw(-1.0, 1.0), draw(-1.0, 1.0));
        let (from, until) = (0.0, f64::INFINITY);
        let turn = Component::Rotation {
            axis: if endless { DVec3::Y } else { dvec3(0.3, -0.5, 0.7) },
            origin: dvec3(0.3, 0.1, 0.2),
            angular_velocity: if turns { 1.3 } else { 0.0 },
            from,
            until,
        };
        let shift = Component::Translation { velocity, from, until };
        let wall = Wall {
            name: "wall".to_owned(),
            material: MaterialIndex::new(0),
            shape: shape.clone(),
            motion: Motion::new(vec![turn, shift]).unwrap(),
            from: 0.0,
            until,
            reference: dvec3(0.1, 0.2, 0.3),
        };
        let mut now = WallNow::new(&wall, 1e-3, &cell);
        now.advance(&wall, time, 1e-3, &cell);
        now.note_images(&cell);
        let gone = wall.state(time, 1e-3);
        let periods = |axis: usize| if periodic[axis] { -60..=60 } else { 0..=0 };
        let mut met = 0;
        for _ in 0..40 {
            // Particles are near the wall, wrapped into the domain.
            let (low, high) = now.outer_box();
            let at = |axis: usize, part: f64| {
                if endless && axis == 1 { part } else { low[axis] + part * (high[axis] - low[axis]) }
            };
            let place = dvec3(
                at(0, draw(-0.1, 1.1)),
                at(1, draw(-0.1, 1.1)),
                at(2, draw(-0.1, 1.1)),
            );
            let (place, radius) = (cell.wrap(place), draw(0.02, 0.1));
            let mut found = Vec::new();
            for &code in now.met_by() {
                let code = now.image_of(place, code);
                let shifted = place + cell.any_shift(code);
                let centre = now.state.into_wall(shifted);
                let mut own = Touches::new();
                shape.touches(centre, radius, &mut own);
                if now.may_join() {
                    let mut scratch = Touches::new();
                    now.keep_own(&cell, place, (code, radius), &mut own, &mut scratch);
                }
                for touch in &own {
                    let foot = now.state.out_of_wall(touch.normal) * touch.distance;
                    // The velocity where it is touched is that of the wall where it has gone.
                    let touched = shifted - foot;
                    found.push((foot, now.state.velocity.at(touched), touched - now.state.reference));
                }
            }
            let mut expected: Vec<(DVec3, DVec3, DVec3)> = Vec::new();
            let mut shared = false;
            let mut copies = Vec::new();
            // Only near images are tested: the wall is nowhere else.
            let (low, high) = (gone.pose.to_global(DVec3::ZERO), now.state.pose.to_global(DVec3::ZERO));
            let back = ((low - high) / SIZE).round();
            for x in periods(0).filter(|x| (f64::from(*x) - back.x).abs() <= 3.0) {
                for y in periods(1).filter(|y| (f64::from(*y) - back.y).abs() <= 3.0) {
                    for z in periods(2).filter(|z| (f64::from(*z) - back.z).abs() <= 3.0) {
                        if endless && y != 0 {
                            continue;
                        }
                        let way = dvec3(f64::from(x), f64::from(y), f64::from(z)) * SIZE;
                        let centre = gone.into_wall(place + way);
                        let feet = feet(&shape, centre, radius, |x| gone.out_of_wall(x));
                        copies.push((place + way, feet));
                    }
                }
            }
            for (centre, feet) in &copies {
                for &foot in feet {
                    // Of several copies in one place it is any of them that is met.
                    let is_new = expected.iter().all(|other| other.0.distance(foot) > 1e-8);
                    shared |= !is_new;
                    if is_new && !is_rim_within(foot, &copies, &shape, &gone) {
                        let touched = *centre - foot;
                        expected.push((foot, gone.velocity.at(touched), touched - gone.reference));
                    }
                }
            }
            let key = |a: &(DVec3, DVec3, DVec3)| (1e6 * a.0).round().to_array().map(|x| x as i64);
            found.sort_by_key(key);
            expected.sort_by_key(key);
            prop_assert_eq!(found.len(), expected.len(), "{} {:?}", place, shape);
            for (a, b) in found.iter().zip(&expected) {
                // Round-off of places tens of metres away.
                prop_assert!(a.0.distance(b.0) < 1e-11, "{:?} {:?}", a, b);
                prop_assert!(shared || a.1.distance(b.1) < 1e-9, "{:?} {:?}", a, b);
                // Its torque is about the same point of it, if it has ends.
                prop_assert!(endless || shared || a.2.distance(b.2) < 1e-11, "{:?} {:?}", a, b);
            }
            met += found.len();
        }
        let way = now.state.pose.to_global(DVec3::ZERO) - gone.pose.to_global(DVec3::ZERO);
        for axis in 0..3 {
            let periods = way[axis] / SIZE[axis];
            prop_assert!(periodic[axis] || periods == 0.0, "it goes on along other axes");
            prop_assert!((periods - periods.round()).abs() < 1e-12);
        }
        if met == 0 {
            return Err(TestCaseError::reject("nothing was met"));
        }
    }
}

/// In domes that cross, a place near the surface of one may lie deep in another one.
#[test]
fn what_lies_in_any_image_of_a_solid_lies_behind_it() {
    let cell = Cell::new(DVec3::ZERO, SIZE, [true, false, false]);
    let dome = |side| {
        let sphere = SphereShell::new(dvec3(0.5, 0.6, 0.4), 0.6, side).unwrap();
        let wall = Wall {
            name: "wall".to_owned(),
            material: MaterialIndex::new(0),
            shape: Shape::Sphere(sphere),
            motion: Motion::default(),
            from: 0.0,
            until: f64::INFINITY,
            reference: DVec3::ZERO,
        };
        WallNow::new(&wall, 1e-3, &cell)
    };
    let mut scratch = Scratch::default();
    let mut behind =
        |x: f64, z: f64| dome(Side::Outside).is_behind(&cell, dvec3(x, 0.6, z), &mut scratch);
    // Its image reaches to x = 0.1 and beyond: just outside of that, 0.2 deep in the dome itself.
    assert!(behind(0.11, 0.4));
    // The crease is 0.33 above the middle.
    assert!(behind(0.0, 0.4 + 0.32) && !behind(0.0, 0.4 + 0.34));
    assert!(!behind(0.5, 0.4 + 0.61));
}

/// A particle that arrives between two lists meets a wall that was set back by a period in the same step at its position then.
#[test]
fn a_wall_that_is_set_back_is_met_where_it_stands() {
    let cell = Cell::new(DVec3::ZERO, SIZE, [true; 3]);
    let origin = dvec3(0.2, 0.6, 0.4);
    let shape = Shape::Disc(Disc::new(DVec3::X, origin, 0.1).unwrap());
    let along = Component::Translation {
        velocity: DVec3::X,
        from: 0.0,
        until: f64::INFINITY,
    };
    let wall = Wall {
        name: "wall".to_owned(),
        material: MaterialIndex::new(0),
        shape: shape.clone(),
        motion: Motion::new(vec![along]).unwrap(),
        from: 0.0,
        until: f64::INFINITY,
        reference: DVec3::ZERO,
    };
    let dt = 0.01;
    let mut now = WallNow::new(&wall, dt, &cell);
    for step in 1..=300 {
        let time = f64::from(step) * dt;
        now.advance(&wall, time, dt, &cell);
        // In front of its middle, where that has gone.
        let centre = cell.wrap(origin + (time + 0.01) * DVec3::X);
        let is_met = |&code: &u32| {
            let code = now.image_of(centre, code);
            let place = now.state.into_wall(centre + cell.any_shift(code));
            !touches(&shape, place, 0.02).is_empty()
        };
        assert!(now.met_by().iter().any(is_met), "at {time} s");
        // As each list does.
        now.note_images(&cell);
    }
}

/// A surface of exactly one period is one with its images: beside the seam, however near, a particle touches it in one place.
#[test]
fn beside_a_seam_a_surface_is_touched_once() {
    let cell = Cell::new(DVec3::ZERO, SIZE, [true, true, false]);
    let [a, b, c, d] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
        .map(|[x, y]| dvec3(x * SIZE.x, y * SIZE.y, 0.4));
    let triangles = TriangleMesh::from_corners(&[[a, b, c], [a, c, d]]);
    let mesh = Mesh::new(&triangles, |x| x, false).unwrap();
    let disc = Disc::new(DVec3::Z, dvec3(0.5, 0.65, 0.4), 1.5).unwrap();
    let shapes = [
        Shape::Mesh(Arc::new(mesh.clone())),
        Shape::Mesh(Arc::new(mesh.keeping_all())),
        Shape::Disc(disc),
    ];
    let (radius, height) = (0.05, 0.045);
    let mut stream = Stream::new(1, "offsets", 0);
    let mut offsets = vec![0.0, 1e-9, -1e-9, 1e-7, -1e-7];
    for _ in 0..200 {
        let size = 10f64.powf(stream.uniform_in(-17.0, -1.5));
        offsets.push(if stream.uniform() < 0.5 { size } else { -size });
    }
    for shape in shapes {
        let wall = Wall {
            name: "wall".to_owned(),
            material: MaterialIndex::new(0),
            shape: shape.clone(),
            motion: Motion::default(),
            from: 0.0,
            until: f64::INFINITY,
            reference: DVec3::ZERO,
        };
        let now = WallNow::new(&wall, 1e-3, &cell);
        assert!(now.may_join());
        let (mut touches, mut scratch) = (Touches::new(), Touches::new());
        for pair in offsets.windows(2) {
            for (x, y) in [(pair[0], 0.5), (0.3, pair[1]), (pair[0], pair[1])] {
                let centre = cell.wrap(dvec3(x, y, 0.4 + height));
                let mut found = Vec::new();
                for &code in now.met_by() {
                    let code = now.image_of(centre, code);
                    let place = now.state.into_wall(centre + cell.any_shift(code));
                    shape.touches(place, radius, &mut touches);
                    now.keep_own(&cell, centre, (code, radius), &mut touches, &mut scratch);
                    found.extend(touches.iter().map(|touch| touch.distance));
                }
                assert_eq!(found.len(), 1, "{x:e}, {y:e}: {found:?}");
                assert!((found[0] - height).abs() < 1e-15, "{x:e}, {y:e}");
            }
        }
    }
}

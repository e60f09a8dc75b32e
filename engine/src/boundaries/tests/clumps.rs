//! Clumps that are inserted and deleted: places, orientations, sizes, and whole bodies.

use glam::{DVec3, dvec3};
use mercury_common::formats::clump::Pebble;

use super::inserting::{Still, wall};
use super::{insertion, plan, uniform, unit_box};
use crate::bodies::Clump;
use crate::boundaries::{DeletionPlan, Ingredient, Region, Total};
use crate::state::{MaterialIndex, PEBBLE, PebbleIndex};
use crate::walls::{Cylinder, Shape, Side, Touches};

/// Two spheres that lie half in one another, of volume 1 m^3 by decree.
fn bean() -> Clump {
    let pebbles = [-0.25, 0.25].map(|x| Pebble {
        position: dvec3(x, 0.0, 0.0),
        radius: 0.5,
    });
    let moments = dvec3(90.0, 150.0, 150.0);
    Clump::new(
        "bean",
        MaterialIndex::new(0),
        pebbles.to_vec(),
        1000.0,
        1.0,
        moments,
    )
    .unwrap()
}

/// Beans and spheres that fill a periodic box around a column, `number` of them.
fn filled(total: Total) -> Still {
    let mut plan = plan();
    plan.cell = plan.cell.with_periodic([true; 3]);
    plan.clumps = vec![bean()];
    let column = Cylinder::new(DVec3::Z, DVec3::splat(0.5), 0.1, None, Side::Outside);
    plan.walls.push(wall(Shape::Cylinder(column.unwrap())));
    let mut feed = insertion(unit_box(), uniform(0.05, 0.08), total);
    feed.mixture[0].clump = Some(0);
    feed.mixture.push(Ingredient {
        clump: None,
        share: 0.25,
        properties: Vec::new(),
        ..feed.mixture[0].clone()
    });
    feed.velocity_spread = DVec3::ONE;
    plan.insertions.push(feed);
    let mut still = Still::new(plan);
    still.exchange(0.0);
    still
}

#[test]
fn bodies_overlap_neither_each_other_nor_walls_nor_images() {
    let still = filled(Total::Number(600));
    let bodies = still.particles.bodies.as_ref().unwrap();
    assert_eq!(still.particles.grains(), 600);
    assert!(bodies.all.len() > 400);
    let records = &still.particles.records;
    for (row, a) in records.iter().enumerate() {
        for (other, b) in records.iter().enumerate().skip(row + 1) {
            let body = bodies.body_of_row(row);
            if body.is_some() && body == bodies.body_of_row(other) {
                continue;
            }
            let branch = a.position - b.position;
            let nearest = branch - branch.round();
            assert!(nearest.length() >= a.radius + b.radius, "{row} {other}");
        }
        let mut touches = Touches::new();
        let column = &still.physics.walls[0].shape;
        for shift in [DVec3::ZERO, DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y] {
            column.touches(a.position + shift, a.radius, &mut touches);
            assert!(touches.is_empty(), "row {row} lies in the column");
        }
    }
}

#[test]
fn orientations_are_uniform_and_sizes_those_requested() {
    let still = filled(Total::Number(600));
    let bodies = still.particles.bodies();
    // The mean of u u^T over a uniform axis u is 1/3 with a standard deviation of 0.298/sqrt(n) per diagonal entry and
    // 0.26/sqrt(n) beside it; four of them. At a sixth of the volume the positions taken do not bias the directions.
    let n = bodies.len() as f64;
    let axes = bodies.iter().map(|body| body.orientation * DVec3::X);
    let (mut squares, mut products) = (DVec3::ZERO, DVec3::ZERO);
    for u in axes {
        squares += u * u / n;
        products += dvec3(u.y * u.z, u.z * u.x, u.x * u.y) / n;
    }
    assert!((squares - 1.0 / 3.0).abs().max_element() < 4.0 * 0.298 / n.sqrt());
    assert!(products.abs().max_element() < 4.0 * 0.26 / n.sqrt());
    let mut mass = 0.0;
    for body in bodies {
        let diameter = (6.0 * body.volume / std::f64::consts::PI).cbrt();
        assert!((0.05..=0.08).contains(&diameter), "{diameter}");
        // Mass, moments and sizes belong to one scale s: s^3, s^5, s.
        let scale = body.volume.cbrt();
        assert!((body.mass / (1000.0 * body.volume) - 1.0).abs() < 1e-12);
        assert!((body.moments.x / (90.0 * scale.powi(5)) - 1.0).abs() < 1e-12);
        assert!((body.radius / (0.75 * scale) - 1.0).abs() < 1e-12);
        mass += body.mass;
    }
    let records = still.particles.records.iter().zip(&still.particles.masses);
    let spheres = records.filter(|(record, _)| record.flags & PEBBLE == 0);
    mass += spheres.map(|(_, mass)| mass).sum::<f64>();
    assert!((still.inserted().mass / mass - 1.0).abs() < 1e-12);
}

#[test]
fn bodies_lie_wholly_in_their_region() {
    let mut plan = plan();
    plan.clumps = vec![bean()];
    let region = Region::Sphere {
        origin: DVec3::splat(0.5),
        radius: 0.15,
    };
    let mut feed = insertion(region.clone(), uniform(0.05, 0.08), Total::Full);
    feed.mixture[0].clump = Some(0);
    plan.insertions.push(feed);
    let mut still = Still::new(plan);
    still.exchange(0.0);
    assert!(
        still.particles.grains() > 10,
        "{}",
        still.particles.grains()
    );
    for record in &still.particles.records {
        assert!(region.holds_sphere(record.position, record.radius));
    }
}

#[test]
fn bodies_leave_as_wholes_by_their_centres() {
    let still = filled(Total::Number(300));
    let mut plan = still.physics.inputs().clone();
    plan.insertions = Vec::new();
    plan.deletions = vec![DeletionPlan {
        name: "half".to_owned(),
        region: Region::Box {
            min: DVec3::ZERO,
            max: dvec3(0.5, 1.0, 1.0),
        },
    }];
    let inserted = still.inserted();
    let left = |still: &Still| {
        let bodies = still.particles.bodies().iter();
        bodies.filter(|body| body.position.x < 0.5).count()
    };
    let leaving = left(&still);
    assert!(leaving > 50);
    let before = still.particles.bodies().len();
    let mut again = Still::new(plan);
    again.particles = still.particles.clone();
    again.exchange(0.0);
    assert_eq!(again.particles.bodies().len(), before - leaving);
    assert_eq!(left(&again), 0);
    let bodies = again.particles.bodies.as_ref().unwrap();
    assert_eq!(bodies.pebbles.len(), 2 * bodies.all.len());
    for (place, pebble) in bodies.pebbles.iter().enumerate() {
        // Rows, places and bodies still refer to one another, and ids have not changed.
        assert_eq!(
            bodies.of_row[pebble.row.index()],
            Some(PebbleIndex::new(place))
        );
        let body = &bodies.all[pebble.body.index()];
        let id = again.particles.ids[pebble.row.index()];
        assert_eq!(id.number(), body.id.number() + (place as u32 - body.first));
        let record = &again.particles.records[pebble.row.index()];
        let placed = body.position + body.orientation * pebble.offset;
        assert_eq!(record.position, placed);
    }
    let removed = again.boundaries.removed();
    let present: f64 = again.particles.masses.iter().sum();
    assert!(((removed.mass + present) / inserted.mass - 1.0).abs() < 1e-12);
}

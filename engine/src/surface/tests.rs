//! Points of sheets and shares of forces, for sheets of any shape.

use glam::DVec3;
use mercury_common::random::Stream;
use proptest::prelude::*;

use super::*;
use crate::state::MaterialIndex;

/// A square of `n` by `n` cells of two triangles each, corners shifted by up to `skew` of a cell.
pub(crate) fn square(n: u32, side: f64, skew: f64, seed: u64) -> SurfacePlan {
    let mut random = Stream::new(seed, "sheet", 0);
    let cell = side / f64::from(n);
    let mut any = || 2.0 * DVec3::new(random.uniform(), random.uniform(), random.uniform()) - 1.0;
    let vertices: Vec<DVec3> = (0..=n)
        .flat_map(|j| (0..=n).map(move |i| (i, j)))
        .map(|(i, j)| DVec3::new(f64::from(i), f64::from(j), 0.0) * cell + any() * (skew * cell))
        .collect();
    let triangles: Vec<[u32; 3]> = (0..n)
        .flat_map(|j| (0..n).map(move |i| j * (n + 1) + i))
        .flat_map(|k| [[k, k + 1, k + n + 2], [k, k + n + 2, k + n + 1]])
        .collect();
    let masses = SurfacePlan::lumped_masses(&vertices, &triangles, 1000.0, 1e-3);
    SurfacePlan {
        name: "sheet".to_owned(),
        material: MaterialIndex::new(0),
        thickness: 1e-3,
        faces: Faces::Both,
        touches_walls: false,
        triangles,
        vertices,
        masses,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Forces and couples at points of a sheet arrive at its vertices with their sum and torque, and their power there is that at the
    /// point; weights are those of the point, on faces, edges and corners.
    #[test]
    fn shares_keep_force_torque_and_power(seed in any::<u64>()) {
        let (mut surface, wall) = Surface::new(&Arc::new(square(3, 1.0, 0.2, seed))).unwrap();
        let mesh = wall.shape.mesh().unwrap();
        let mut random = Stream::new(seed, "points", 0);
        let mut any = || 2.0 * DVec3::new(random.uniform(), random.uniform(), random.uniform()) - 1.0;
        for velocity in &mut surface.velocities {
            *velocity = any();
        }
        let mut touches = crate::walls::Touches::default();
        let (mut met, mut tries) = ([0; 3], 0);
        while tries < 300 {
            tries += 1;
            let centre = DVec3::new(0.5, 0.5, 0.0) + any();
            mesh.touches(centre, 3.0, &mut touches);
            for touch in touches.iter() {
                let foot = centre - touch.normal * touch.distance;
                let place = surface.place(mesh, touch.feature, foot);
                let corners = surface.triangles()[place.triangle as usize];
                let positions = corners.map(|k| surface.positions[k as usize]);
                let [u, v, w] = place.weights;
                prop_assert!(place.weights.iter().all(|&weight| weight >= 0.0));
                prop_assert_eq!(u + (v + w), 1.0);
                let point = positions[0] * u + positions[1] * v + positions[2] * w;
                prop_assert!(point.distance(foot) < 1e-13, "{} from {}", point, foot);
                let (force, couple) = (any(), any());
                let shares = surface.shares(&place, force, couple);
                let sum: DVec3 = shares.iter().sum();
                prop_assert!((sum - force).length() < 1e-14 * (1.0 + 10.0 * couple.length()));
                let torque: DVec3 = (0..3).map(|k| positions[k].cross(shares[k])).sum();
                prop_assert!((torque - point.cross(force) - couple).length() < 1e-13);
                let power: f64 = (0..3)
                    .map(|k| shares[k].dot(surface.velocities[corners[k] as usize]))
                    .sum();
                let spin = surface.spin(place.triangle);
                let at_point = force.dot(surface.velocity_at(&place)) + couple.dot(spin);
                prop_assert!((power - at_point).abs() < 1e-12);
                met[match mesh.feature_of(touch.feature) {
                    crate::walls::Feature::Face(_) => 0,
                    crate::walls::Feature::Edge(_) => 1,
                    crate::walls::Feature::Corner(_) => 2,
                }] += 1;
            }
        }
        prop_assert!(met.iter().all(|&met| met > 0), "{:?}", met);
    }

    /// The spin of a triangle that turns as a rigid body is that of the body.
    #[test]
    fn rigid_rotation_is_found(seed in any::<u64>()) {
        let (mut surface, _) = Surface::new(&Arc::new(square(2, 1.0, 0.2, seed))).unwrap();
        let (spin, velocity) = (DVec3::new(0.3, -0.7, 1.1), DVec3::new(2.0, 0.5, -1.0));
        for (at, moves) in surface.positions.iter().zip(&mut surface.velocities) {
            *moves = velocity + spin.cross(*at);
        }
        for triangle in 0..8 {
            prop_assert!((surface.spin(triangle) - spin).length() < 1e-12);
        }
    }
}

#[test]
fn sheets_that_cannot_be_are_refused() {
    let mut plan = square(2, 1.0, 0.0, 0);
    plan.triangles.push([0, 1, 2]);
    assert!(
        Surface::new(&Arc::new(plan)).is_err(),
        "a triangle without area"
    );
    let mut plan = square(2, 1.0, 0.0, 0);
    plan.triangles[0][1] = 99;
    assert!(
        Surface::new(&Arc::new(plan)).is_err(),
        "a vertex that is not there"
    );
}

#[test]
fn saved_states_of_other_sheets_are_refused() {
    let (mut surface, _) = Surface::new(&Arc::new(square(2, 1.0, 0.1, 3))).unwrap();
    let (other, _) = Surface::new(&Arc::new(square(3, 1.0, 0.1, 3))).unwrap();
    let saved = surface.save();
    assert!(surface.restore(&other.save()).is_err());
    let mut broken = saved.clone();
    broken.positions[3].y = f64::NAN;
    assert!(surface.restore(&broken).is_err());
    assert!(surface.restore(&saved).is_ok());
}

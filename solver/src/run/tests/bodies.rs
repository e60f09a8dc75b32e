//! The table of bodies agrees with that of their pebbles.

use mercury_common::formats::mesh::TriangleMesh;
use mercury_common::frames::{BodyReader, FLAG_FIXED};

use super::*;
use mercury_engine::state::MaterialIndex;

/// A lopsided body: its pebbles' own centre is not its centre of mass, and its moments are all different.
fn stone(surface: Option<TriangleMesh>) -> Clump {
    let at = |x: f64, y: f64, radius: f64| Pebble {
        position: DVec3::new(x, y, 0.0) * RADIUS,
        radius: radius * RADIUS,
    };
    let pebbles = vec![at(-0.7, 0.1, 1.0), at(0.6, 0.0, 0.8), at(0.2, 0.9, 0.5)];
    let volume = 1.7 * mercury_engine::state::volume(RADIUS, 3);
    let mass = DENSITY * volume;
    let moments = DVec3::new(0.5, 0.7, 0.9) * (mass * RADIUS * RADIUS);
    let stone = Clump::new(
        "stone",
        MaterialIndex::new(0),
        pebbles,
        mass,
        volume,
        moments,
    )
    .unwrap();
    Clump { surface, ..stone }
}

fn tetrahedron() -> TriangleMesh {
    let corners = [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::ONE].map(|x| x * RADIUS);
    let faces = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
    TriangleMesh::from_corners(&faces.map(|face| face.map(|k| corners[k])))
}

/// Stones of two sizes that fall on a floor and on each other, across the periodic face at x = 0.
fn falling(surface: Option<TriangleMesh>) -> Draft {
    let mut plan = plan(600, 0.01, 0.5);
    plan.cell = plan.cell.with_periodic([true, false, false]);
    plan.walls = vec![floor()];
    let body = |x: f64, z: f64, scale: f64| NewBody {
        scale,
        orientation: DQuat::from_rotation_y(0.7 * x + 1.0),
        velocity: DVec3::new(-0.6, 0.1, -0.5),
        angular_velocity: DVec3::new(9.0, 1.0, -5.0),
        ..NewBody::at(DVec3::new(x, 0.2, z) * DVec3::new(1.0, 1.0, RADIUS), 0)
    };
    let mut fixed = body(0.3, 2.0, 1.0);
    (fixed.fixed, fixed.velocity, fixed.angular_velocity) = (true, DVec3::ZERO, DVec3::ZERO);
    let bodies = vec![
        body(0.02, 2.0, 1.0),
        body(0.012, 5.0, 1.3),
        body(0.2, 2.2, 0.7),
        fixed,
    ];
    plan.with_bodies(vec![stone(surface)], bodies)
}

#[test]
fn bodies_are_the_sums_of_their_pebbles() {
    let place = tempfile::tempdir().unwrap();
    go(falling(Some(tetrahedron())), place.path());
    let bodies = BodyReader::open(place.path().join("test.bodies.arrow")).unwrap();
    let particles = ParticleReader::open(place.path().join("test.particles.arrow")).unwrap();
    assert_eq!(bodies.kinds().len(), 1);
    assert_eq!(bodies.kinds()[0].name, "stone");
    assert_eq!(bodies.kinds()[0].surface, Some(tetrahedron()));
    assert_eq!(bodies.frames().len(), particles.frames().len());
    let stone = stone(None);
    let shares = stone.shares();
    let offsets = || stone.pebbles.iter().map(|pebble| pebble.position);
    let middle: DVec3 = offsets().zip(&shares).map(|(x, share)| *share * x).sum();
    assert!(
        middle.length() > 0.05 * RADIUS,
        "else momentum shows little"
    );
    let scales = [1.0, 1.3, 0.7, 1.0];
    let (mut touched, mut crossed) = (false, false);
    for k in 0..bodies.frames().len() {
        let frame = bodies.frame(k).unwrap();
        let pebbles = particles.frame(k).unwrap();
        assert_eq!((frame.time, frame.step), (pebbles.time, pebbles.step));
        assert_eq!(frame.id, [0, 3, 6, 9]);
        assert_eq!(frame.flags, [0, 0, 0, FLAG_FIXED]);
        for (row, scale) in scales.into_iter().enumerate() {
            // Sizes come back from a quotient of radii: to a unit in the last place.
            assert!((frame.scale[row] / scale - 1.0).abs() < 4e-16);
            assert!((frame.radius[row] / (scale * stone.radius) - 1.0).abs() < 4e-16);
            let moments = frame.principal_moments[row] / (scale.powi(5) * stone.moments);
            assert!(moments.abs_diff_eq(DVec3::ONE, 1e-15));
            let mine: Vec<usize> = (0..pebbles.len())
                .filter(|&p| pebbles.body.as_ref().unwrap()[p] == Some(frame.id[row]))
                .collect();
            assert_eq!(mine.len(), 3);
            let sum = |of: &[f64]| mine.iter().map(|&p| of[p]).sum::<f64>();
            assert!((sum(&pebbles.mass) / frame.mass[row] - 1.0).abs() < 1e-15);
            assert!((sum(&pebbles.volume) / frame.volume[row] - 1.0).abs() < 1e-15);

            // Positions are written inside the domain; levers are those to the nearest image.
            let lever = |p: usize| {
                let mut lever = pebbles.position[p] - frame.position[row];
                lever.x -= 0.4 * (lever.x / 0.4).round();
                lever
            };
            crossed |= mine
                .iter()
                .any(|&p| (pebbles.position[p].x - frame.position[row].x).abs() > 0.2);
            let turned = |own: DVec3| frame.orientation[row] * (own * scale);
            for (&p, own) in mine.iter().zip(offsets()) {
                assert!((lever(p) - turned(own)).length() < 1e-14);
                assert_eq!(
                    pebbles.orientation.as_ref().unwrap()[p],
                    frame.orientation[row]
                );
            }
            // Momentum of the shares: that of the body, at the shares' own centre.
            let momentum: DVec3 = mine
                .iter()
                .map(|&p| pebbles.mass[p] * pebbles.velocity[p])
                .sum();
            let spin = frame.angular_velocity[row];
            let velocity = frame.velocity[row] + spin.cross(turned(middle));
            let lost = momentum / frame.mass[row] - velocity;
            assert!(lost.length() < 1e-14, "frame {k}, body {row}: {lost}");

            let forces = pebbles.force.as_ref().unwrap();
            let force: DVec3 = mine.iter().map(|&p| forces[p]).sum();
            let torques = pebbles.torque.as_ref().unwrap();
            let torque: DVec3 = mine
                .iter()
                .map(|&p| torques[p] + lever(p).cross(forces[p]))
                .sum();
            assert!((force - frame.force[row]).length() <= 1e-14 * force.length());
            let scale = torque.length() + RADIUS * force.length();
            assert!((torque - frame.torque[row]).length() <= 1e-12 * scale);
            touched |= force.length() > 0.0;
        }
    }
    assert!(touched && crossed, "contacts {touched}, crossing {crossed}");
}

#[test]
fn scenes_without_clumps_have_no_table_of_bodies() {
    let place = tempfile::tempdir().unwrap();
    go(collision(10, 1e-3), place.path());
    let bodies = |place: &Path| place.join("test.bodies.arrow").exists();
    assert!(place.path().join("test.particles.arrow").exists() && !bodies(place.path()));
    let place = tempfile::tempdir().unwrap();
    let mut plan = falling(None);
    plan.steps = 10;
    go(plan, place.path());
    assert!(bodies(place.path()) && !place.path().join("test.clumps.arrow").exists());
}

/// A body that spins about a principal axis flies freely: it keeps its energy, and takes all of it along when it leaves through a face.
#[test]
fn a_spinning_body_leaves_with_all_of_its_energy() {
    let place = tempfile::tempdir().unwrap();
    let mut plan = plan(400, 0.01, 0.5);
    plan.gravity = DVec3::ZERO;
    plan.energy_budget = true;
    let face = plan.cell.high().x;
    let body = |beside: f64, spin: f64| NewBody {
        orientation: DQuat::from_rotation_x(0.4),
        velocity: DVec3::X,
        angular_velocity: DQuat::from_rotation_x(0.4) * DVec3::Y * spin,
        ..NewBody::at(DVec3::new(face - beside, 0.2, 0.2), 0)
    };
    let stone = stone(None);
    let (mass, moment) = (stone.mass, stone.moments.y);
    let dt = plan.time_step;
    let (leaves, stays) = (body(100.0 * dt, 200.0), body(600.0 * dt, 0.0));
    let report = go(
        plan.with_bodies(vec![stone], vec![leaves, stays]),
        place.path(),
    );
    assert_eq!((report.summary.deleted, report.summary.particles), (1, 1));
    let energy = report.summary.energy;
    let taken = 0.5 * mass + 0.5 * moment * 200.0 * 200.0;
    let deleted = energy.deleted.unwrap();
    assert!(
        (deleted / taken - 1.0).abs() < 1e-11,
        "{deleted} of {taken} J"
    );
    // No other change: a hundred turns by 0.02 rad, each exact to round-off.
    let error = energy.closure_error.unwrap();
    assert!(error.abs() < 1e-11, "{error:e}");
}

#[test]
fn memory_of_the_start_counts_every_pebble() {
    let mut plan = falling(None);
    let ball = NewParticle::at(DVec3::splat(0.3), RADIUS, MaterialIndex::new(0));
    plan.particles = vec![ball.clone(), ball];
    // Four stones of three pebbles.
    let start = crate::plan::StartBytes::of(&plan.plan().unwrap());
    assert_eq!(start.spheres, 2.0 + 4.0 * 3.0);
}

//! `.data` and `.fstat` of unequal spheres that turn.

use mercury_common::formats::fstat::FstatReader;
use mercury_common::formats::orientation::euler_from_quaternion;

use super::*;

/// Two spheres of different sizes that spin and meet.
fn unequal() -> Draft {
    let ball = |x: f64, radius: f64, spin: DVec3| NewParticle {
        velocity: DVec3::X * (if x > 0.0 { -1.0 } else { 1.0 }),
        angular_velocity: spin,
        ..NewParticle::at(
            DVec3::splat(0.2) + DVec3::X * x,
            radius,
            MaterialIndex::new(0),
        )
    };
    let mut plan = plan(40, 1e-3, 0.5);
    plan.gravity = DVec3::ZERO;
    plan.with_particles(vec![
        ball(-1.01 * RADIUS, RADIUS, DVec3::new(90.0, 30.0, -50.0)),
        ball(2.01 * RADIUS, 2.0 * RADIUS, DVec3::new(-20.0, 70.0, 10.0)),
    ])
}

#[test]
fn angles_of_spheres_are_those_of_their_orientations() {
    let place = tempfile::tempdir().unwrap();
    go(unequal(), place.path());
    let data = DataReader::open(place.path().join("test.data")).unwrap();
    let last = data.last().unwrap().unwrap();
    let native = ParticleReader::open(place.path().join("test.particles.arrow")).unwrap();
    let frame = native.frame(native.frames().len() - 1).unwrap();
    let orientations = frame.orientation.unwrap();
    for (row, orientation) in last.particles.iter().zip(orientations) {
        // 4 ms at some 100 rad/s.
        assert!(row.angles.length() > 0.1, "{row:?}");
        assert_eq!(row.angles, euler_from_quaternion(orientation));
    }
}

#[test]
fn heads_of_contacts_tell_the_range_of_radii() {
    let place = tempfile::tempdir().unwrap();
    go(unequal(), place.path());
    let frames = FstatReader::open(place.path().join("test.fstat")).unwrap();
    let mut contacts = 0;
    for frame in frames {
        let frame = frame.unwrap();
        assert_eq!((frame.radius_min, frame.radius_max), (RADIUS, 2.0 * RADIUS));
        contacts += frame.contacts.len();
    }
    assert!(contacts > 0, "they meet");
}

//! Small inputs for tests.

use std::fs;

use glam::DVec3;
use mercury_common::frames::{
    ContactColumns, ContactFrame, ContactWriter, FramesHeader, ParticleColumns, ParticleFrame,
    ParticleWriter, WallFrame, WallWriter,
};
use mercury_common::surfaces::{Placement, Surface};

/// Three frames in the look of MercuryDPM, with numbers that are not exact in binary.
pub(crate) const DATA: &str = "\
2 0 -1 -1 0 1 1 3 \n\
0.1 0.2 0.3 1 2 3 0.02 0.7 -0.3 1.2 0.4 0.5 0.6 0\n\
0.5 -0.25 0.125 1 2 3 0.01 -0.1 0.2 3 0 -0 0 2\n\
2 0.1 -1 -1 0 1 1 3 \n\
0.15 0.2 0.3 1 2 3 0.02 0.7 -0.3 1.2 0.4 0.5 0.6 0\n\
0.55 -0.25 0.125 1 2 3 0.01 -0.1 0.2 3 0 -0 0 2\n\
1 0.2 -1 -1 0 1 1 3 \n\
0.2 0.2 0.3 1 2 3 0.02 0.7 -0.3 1.2 0.4 0.5 0.6 0.25\n";

/// A folder with `old.data`.
pub(crate) fn folder_with_data(text: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("old.data"), text).unwrap();
    folder
}

/// A folder with the run `run/`: three spheres (one of a clump), a pair and a wall contact, a floor that rises, four frames.
pub(crate) fn folder_with_run() -> tempfile::TempDir {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("run");
    fs::create_dir(&folder).unwrap();
    let header = FramesHeader {
        title: "three spheres".to_owned(),
        materials: vec!["glass".to_owned(), "steel".to_owned()],
        walls: vec!["floor".to_owned()],
        domain: Some((DVec3::ZERO, DVec3::new(4.0, 1.0, 2.0))),
        periodic: [false, true, false],
        dimensions: Some(3),
        gravity: None,
    };
    let columns = ParticleColumns {
        body: true,
        angular_velocity: true,
        force: true,
        ..ParticleColumns::default()
    };
    let path = |kind: &str| folder.join(format!("run.{kind}.arrow"));
    let mut particles = ParticleWriter::create(path("particles"), &header, &columns).unwrap();
    let mut contacts =
        ContactWriter::create(path("contacts"), &header, &ContactColumns::default()).unwrap();
    let floor = Surface::Plane {
        point: DVec3::ZERO,
        normal: DVec3::Z,
    };
    let mut walls = WallWriter::create(path("walls"), &header, &vec![floor]).unwrap();
    for k in 0..4u32 {
        let (time, step) = (0.5 * f64::from(k), 50 * u64::from(k));
        particles.append(particle_frame(time, step)).unwrap();
        contacts.append(contact_frame(time, step)).unwrap();
        let lifted = Placement {
            translation: DVec3::new(0.0, 0.0, 0.1 * time),
            ..Placement::default()
        };
        let frame = WallFrame {
            time,
            step,
            present: vec![true],
            placement: vec![lifted],
        };
        walls.append(frame).unwrap();
    }
    place
}

fn particle_frame(time: f64, step: u64) -> ParticleFrame {
    let at = |x: f64| DVec3::new(x, 0.1, 1.0 / 3.0);
    ParticleFrame {
        time,
        step,
        id: vec![0, 4, 7],
        material: vec![0, 0, 1],
        flags: vec![0, 1, 0],
        mass: vec![0.1; 3],
        volume: vec![0.2; 3],
        radius: vec![0.5; 3],
        position: vec![at(1.0), at(2.0), at(3.0)],
        velocity: vec![DVec3::new(0.0, time, 0.0); 3],
        body: Some(vec![None, None, Some(2)]),
        angular_velocity: Some(vec![DVec3::ZERO; 3]),
        force: Some(vec![-DVec3::Z; 3]),
        ..ParticleFrame::default()
    }
}

fn contact_frame(time: f64, step: u64) -> ContactFrame {
    ContactFrame {
        time,
        step,
        i: vec![0, 7],
        j: vec![Some(4), None],
        wall: vec![None, Some(0)],
        point: vec![DVec3::new(1.5, 0.1, 0.3), DVec3::new(3.0, 0.1, 0.0)],
        branch: vec![-DVec3::X, DVec3::new(0.0, 0.0, 1.0 / 3.0)],
        normal: vec![-DVec3::X, DVec3::Z],
        force: vec![-DVec3::X, DVec3::Z],
        overlap: vec![0.0, 0.1],
        history: Vec::new(),
        ..ContactFrame::default()
    }
}

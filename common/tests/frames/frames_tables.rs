//! The tables of particles and contacts come back as they were written, whatever columns were planned.

use glam::{DQuat, DVec3};
use mercury_common::frames::{
    ColumnKind, ColumnSpec, ContactColumns, ContactFrame, ContactReader, ContactWriter, FLAG_FIXED,
    FLAG_PRESCRIBED, FramesHeader, HistoryColumn, ParticleColumns, ParticleFrame, ParticleReader,
    ParticleWriter,
};
use mercury_common::particle_properties::FILM_VOLUME;

fn header() -> FramesHeader {
    FramesHeader {
        title: "Two, \"quoted\"".to_owned(),
        materials: vec!["glass".to_owned(), "soft, red".to_owned()],
        walls: vec!["box.-z".to_owned()],
        domain: Some((
            DVec3::new(-0.1, 0.0, 1e-300),
            DVec3::new(0.1, 1.0 / 3.0, 2e22),
        )),
        periodic: [true, false, true],
        dimensions: Some(3),
        gravity: Some(DVec3::new(0.0, 0.0, -9.81)),
    }
}

fn vectors(n: usize, scale: f64) -> Vec<DVec3> {
    (0..n)
        .map(|k| scale * DVec3::new(k as f64, 0.1 * k as f64, -0.7))
        .collect()
}

fn particles(n: usize, columns: &ParticleColumns) -> ParticleFrame {
    let numbers = |scale: f64| {
        (0..n)
            .map(|k| scale * (1.0 + k as f64))
            .collect::<Vec<f64>>()
    };
    ParticleFrame {
        time: 0.125,
        step: 1250,
        id: (0..n as u32).collect(),
        material: (0..n as u32).map(|k| k % 2).collect(),
        flags: (0..n)
            .map(|k| [0, FLAG_FIXED, FLAG_PRESCRIBED][k % 3])
            .collect(),
        mass: numbers(1e-3),
        volume: numbers(1e-9),
        radius: numbers(1e-3),
        position: vectors(n, 1.0),
        velocity: vectors(n, 2.0),
        body: columns
            .body
            .then(|| (0..n as u32).map(|k| (k > 1).then_some(k / 2)).collect()),
        orientation: columns
            .orientation
            .then(|| (0..n).map(|k| DQuat::from_rotation_x(k as f64)).collect()),
        angular_velocity: columns.angular_velocity.then(|| vectors(n, 3.0)),
        force: columns.force.then(|| vectors(n, 4.0)),
        torque: columns.torque.then(|| vectors(n, 5.0)),
        more: (1..=columns.more.len())
            .map(|k| numbers(1e-12 * k as f64))
            .collect(),
    }
}

#[test]
fn particles_come_back_with_any_choice_of_columns() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.particles.arrow");
    let of_another_program = ColumnSpec::new("albedo", ColumnKind::F64, "");
    for choice in 0..128_u32 {
        let bit = |k: u32| choice >> k & 1 == 1;
        let columns = ParticleColumns {
            body: bit(0),
            orientation: bit(1),
            angular_velocity: bit(2),
            force: bit(3),
            torque: bit(4),
            ..ParticleColumns::default()
        };
        let mut columns = columns.with_properties(bit(5).then_some(&FILM_VOLUME));
        columns
            .more
            .extend(bit(6).then(|| of_another_program.clone()));
        let frame = particles(5, &columns);
        let mut writer = ParticleWriter::create(&path, &header(), &columns).unwrap();
        writer.append(frame.clone()).unwrap();
        let more = ParticleFrame {
            step: 1251,
            force: None,
            body: None,
            ..frame.clone()
        };
        assert_eq!(writer.append(more).is_err(), columns.force || columns.body);
        let reader = ParticleReader::open(&path).unwrap();
        assert_eq!(*reader.layout(), columns);
        assert_eq!(reader.header(), &header());
        let read = reader.frame(0).unwrap();
        assert_eq!(read, frame);
        let films = bit(5).then(|| frame.more[0].as_slice());
        assert_eq!(reader.layout().number(&read, "film_volume"), films);
    }
}

/// `state` was called `flags`, which is as long: files of then are these with other letters.
#[test]
fn columns_of_earlier_versions_are_read_under_their_present_names() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.particles.arrow");
    let columns = ParticleColumns::default();
    let frame = particles(5, &columns);
    let mut writer = ParticleWriter::create(&path, &header(), &columns).unwrap();
    writer.append(frame.clone()).unwrap();
    drop(writer);
    let mut bytes = std::fs::read(&path).unwrap();
    let places: Vec<usize> = (0..bytes.len())
        .filter(|&k| bytes[k..].starts_with(b"state"))
        .collect();
    assert!(!places.is_empty());
    for place in places {
        bytes[place..place + 5].copy_from_slice(b"flags");
    }
    std::fs::write(&path, bytes).unwrap();
    let reader = ParticleReader::open(&path).unwrap();
    assert_eq!(reader.frame(0).unwrap(), frame);
}

#[test]
fn contacts_come_back_and_have_one_partner_each() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.contacts.arrow");
    let spring = |axis: &str| HistoryColumn {
        unit: "m".to_owned(),
        description: format!("tangential spring, {axis}"),
    };
    let columns = ContactColumns {
        membrane: false,
        torque: true,
        bridge: true,
        adhesion: true,
        history: vec![spring("x"), spring("y"), spring("z")],
    };
    let frame = ContactFrame {
        membrane: None,
        time: 2.5,
        step: 3,
        i: vec![4, 5, 6],
        j: vec![Some(7), None, Some(u32::MAX)],
        wall: vec![None, Some(0), None],
        point: vectors(3, 1.0),
        branch: vectors(3, 2.0),
        normal: vectors(3, 3.0),
        force: vectors(3, 4.0),
        overlap: vec![1e-6, -1e-7, 0.0],
        torque: Some(vectors(3, 5.0)),
        bridge_volume: Some(vec![1e-12, 0.0, 2e-12]),
        bridge_normal: Some(vec![-1e-5, 0.0, 1e-6]),
        bridge_shear: Some(vectors(3, 6.0)),
        adhesion: Some(vec![-2e-5, 0.0, -1e-6]),
        history: vec![vec![1.0; 3], vec![2.0; 3], vec![3.0; 3]],
    };
    let mut writer = ContactWriter::create(&path, &header(), &columns).unwrap();
    writer.append(frame.clone()).unwrap();
    for (j, wall) in [(None, None), (Some(1), Some(1))] {
        let mut wrong = ContactFrame {
            step: 4,
            ..frame.clone()
        };
        (wrong.j[2], wrong.wall[2]) = (j, wall);
        let error = writer.append(wrong).unwrap_err().to_string();
        assert!(error.contains("contact 2 must have either"), "{error}");
    }
    let reader = ContactReader::open(&path).unwrap();
    assert_eq!(reader.layout(), &columns);
    assert_eq!(reader.header(), &header());
    assert_eq!(
        reader.iter().map(Result::unwrap).collect::<Vec<_>>(),
        [frame]
    );
    let error = ParticleReader::open(&path).unwrap_err().to_string();
    assert!(
        error.contains("frames of contacts, expected frames of particles"),
        "{error}"
    );
}

#[test]
fn contacts_with_membranes_have_a_column_and_one_partner() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.contacts.arrow");
    let columns = ContactColumns {
        membrane: true,
        ..ContactColumns::default()
    };
    let frame = ContactFrame {
        i: vec![1, 2, 3],
        j: vec![Some(7), None, None],
        wall: vec![None, Some(0), None],
        membrane: Some(vec![None, None, Some(1)]),
        point: vectors(3, 1.0),
        branch: vectors(3, 2.0),
        normal: vectors(3, 3.0),
        force: vectors(3, 4.0),
        overlap: vec![1e-6; 3],
        ..ContactFrame::default()
    };
    let mut writer = ContactWriter::create(&path, &header(), &columns).unwrap();
    writer.append(frame.clone()).unwrap();
    for membrane in [None, Some(0)] {
        let mut wrong = frame.clone();
        let row = if membrane.is_some() { 1 } else { 2 };
        wrong.membrane.as_mut().unwrap()[row] = membrane;
        let error = writer.append(wrong).unwrap_err().to_string();
        assert!(
            error.contains(&format!("contact {row} must have one of")),
            "{error}"
        );
    }
    let reader = ContactReader::open(&path).unwrap();
    assert_eq!(reader.layout(), &columns);
    assert_eq!(reader.frame(0).unwrap(), frame);
}

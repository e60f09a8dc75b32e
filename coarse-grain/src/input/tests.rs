use std::fs;
use std::path::Path;

use glam::DVec3;
use mercury_common::folder_owner::{LOCK, Owner};
use mercury_common::frames::{
    ContactColumns, ContactFrame, ContactWriter, FLAG_FIXED, FramesHeader, ParticleColumns,
    ParticleFrame, ParticleWriter,
};
use tempfile::TempDir;

use super::*;
use crate::state::Partner;

const ALL: Needs = Needs {
    mass: true,
    contacts: true,
    couples: false,
    rotation: false,
    liquid: false,
    identity: false,
};

fn given() -> Given {
    Given {
        density: Some(6.0 / std::f64::consts::PI),
        ..Given::default()
    }
}

/// The miniature of the format description: two spheres stacked on a floor, at rest, at several times.
fn miniature(folder: &Path, times: &[&str]) {
    let (mut data, mut fstat) = (String::new(), String::new());
    for t in times {
        data += &format!(
            "2 {t} -1 -1 0 1 1 3\n0 0 0.496 0 0 0 0.5 0 0 0 0 0 0 0\n0 0 1.494 0 0 0 0.5 0 0 0 0 0 0 0\n"
        );
        fstat += &format!(
            "# {t} 1\n# -1 -1 0 1 1 3\n# 0.5 0.5 0 0 0 0\n\
             {t} 0 1 0 0 0.995 0.002 0 2 0 0 0 -1 0 0 0\n\
             {t} 1 0 0 0 0.995 0.002 0 2 0 0 0 1 0 0 0\n\
             {t} 0 -1 0 0 -0.002 0.004 0 4 0 0 0 -1 0 0 0\n"
        );
    }
    fs::write(folder.join("Mini.data"), data).unwrap();
    fs::write(folder.join("Mini.fstat"), fstat).unwrap();
}

fn states(path: &Path, given: &Given, needs: Needs) -> Result<Vec<State>, CgError> {
    Source::open(path, given, needs)?
        .states(FrameChoice::All)
        .collect()
}

fn error(path: &Path, given: &Given, needs: Needs) -> String {
    states(path, given, needs).unwrap_err().to_string()
}

#[test]
fn a_stack_of_two_spheres_is_read_with_its_contacts() {
    let folder = TempDir::new().unwrap();
    miniature(folder.path(), &["0", "0.1"]);
    let found = states(&folder.path().join("Mini.data"), &given(), ALL).unwrap();
    assert_eq!(found.len(), 2);
    let state = &found[1];
    assert_eq!(
        (state.time, state.space.dimensions, state.space.max.z),
        (0.1, 3, 3.0)
    );
    assert!((state.particles.mass[0] - 1.0).abs() < 1e-15);
    let c = state.contacts.as_ref().unwrap();
    assert_eq!(c.partner, [Partner::Particle(1), Partner::Wall(0)]);
    assert_eq!(
        c.force,
        [DVec3::new(0.0, 0.0, -2.0), DVec3::new(0.0, 0.0, 4.0)]
    );
    for (found, expected) in [
        (c.point[0], DVec3::new(0.0, 0.0, 0.995)),
        (c.point[1], DVec3::new(0.0, 0.0, -0.002)),
        (c.arm[0], DVec3::new(0.0, 0.0, -0.499)),
        (c.partner_arm[0], DVec3::new(0.0, 0.0, 0.499)),
        (c.arm[1], DVec3::new(0.0, 0.0, 0.498)),
        (c.partner_arm[1], DVec3::ZERO),
    ] {
        assert!((found - expected).length() < 1e-15, "{found} {expected}");
    }
}

#[test]
fn the_last_number_of_all_is_a_series_of_one() {
    let folder = TempDir::new().unwrap();
    miniature(folder.path(), &["0"]);
    let name = format!("Mini.data.{}", u64::MAX);
    fs::rename(folder.path().join("Mini.data"), folder.path().join(&name)).unwrap();
    let found = states(&folder.path().join(name), &given(), Needs::default()).unwrap();
    assert_eq!(found.len(), 1);
    let last: FrameChoice = u64::MAX.to_string().parse().unwrap();
    assert!(!last.has(0));
}

/// How test files are packed.
type Packer = (&'static str, fn(&[u8]) -> Vec<u8>);
const PACKERS: [Packer; 4] = [
    ("gz", |text| {
        let mut writer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        std::io::Write::write_all(&mut writer, text).unwrap();
        writer.finish().unwrap()
    }),
    ("zst", |text| {
        let frame =
            ruzstd::encoding::compress_to_vec(text, ruzstd::encoding::CompressionLevel::Fastest);
        // Frames that are to be passed over may stand between.
        [&[0x50, 0x2a, 0x4d, 0x18, 3, 0, 0, 0, 1, 2, 3], &frame[..]].concat()
    }),
    ("xz", |text| {
        let options = lzma_rust2::XzOptions::default();
        let mut writer = lzma_rust2::XzWriter::new(Vec::new(), options).unwrap();
        std::io::Write::write_all(&mut writer, text).unwrap();
        writer.finish().unwrap()
    }),
    ("bz2", |text| {
        let mut writer = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
        std::io::Write::write_all(&mut writer, text).unwrap();
        writer.finish().unwrap()
    }),
];

#[test]
fn compressed_files_and_series_are_read_alike() {
    let folder = TempDir::new().unwrap();
    miniature(folder.path(), &["0", "0.1"]);
    let plain = states(&folder.path().join("Mini.data"), &given(), ALL).unwrap();
    for (name, pack) in PACKERS {
        let packed = folder.path().join(name);
        fs::create_dir(&packed).unwrap();
        let mut cut = Vec::new();
        for kind in ["data", "fstat"] {
            let text = fs::read(folder.path().join(format!("Mini.{kind}"))).unwrap();
            // Two files packed apart, one behind the other.
            let half = text.len() / 2;
            let whole = [pack(&text[..half]), pack(&text[half..])].concat();
            cut = whole[..whole.len() - 12].to_vec();
            fs::write(packed.join(format!("Mini.{kind}.{name}")), whole).unwrap();
        }
        assert_eq!(states(&packed, &given(), ALL).unwrap(), plain, "{name}");
        // A series, with contacts that are not packed.
        let series = folder.path().join(format!("{name}-series"));
        fs::create_dir(&series).unwrap();
        miniature(&series, &["0"]);
        let data = fs::read(series.join("Mini.data")).unwrap();
        fs::remove_file(series.join("Mini.data")).unwrap();
        fs::write(series.join(format!("Mini.data.0000.{name}")), pack(&data)).unwrap();
        fs::rename(series.join("Mini.fstat"), series.join("Mini.fstat.0000")).unwrap();
        assert_eq!(
            states(&series, &given(), ALL).unwrap(),
            plain[..1],
            "{name}"
        );
        // The message names the truncated part and the file.
        fs::write(packed.join(format!("Mini.fstat.{name}")), cut).unwrap();
        let message = error(&packed, &given(), ALL);
        let expected = format!("Mini.fstat.{name}:");
        assert!(
            message.contains(&expected) && message.contains("the file cannot be read"),
            "{message}"
        );
    }
    for (k, time) in ["0", "0.1"].iter().enumerate() {
        let part = folder.path().join(format!("part{k}"));
        fs::create_dir(&part).unwrap();
        miniature(&part, &[time]);
        for kind in ["data", "fstat"] {
            fs::copy(
                part.join(format!("Mini.{kind}")),
                folder.path().join(format!("Series.{kind}.{k:04}")),
            )
            .unwrap();
        }
    }
    assert_eq!(
        states(&folder.path().join("Series.data.0000"), &given(), ALL).unwrap(),
        plain
    );
}

#[test]
fn what_data_files_lack_is_refused_with_the_reason() {
    let folder = TempDir::new().unwrap();
    miniature(folder.path(), &["0"]);
    let path = folder.path().join("Mini.data");
    let message = error(&path, &Given::default(), ALL);
    assert!(
        message.contains("no masses") && message.contains("--density"),
        "{message}"
    );
    let message = error(
        &path,
        &given(),
        Needs {
            couples: true,
            ..ALL
        },
    );
    assert!(message.contains("no torques"), "{message}");
    fs::remove_file(folder.path().join("Mini.fstat")).unwrap();
    let message = error(&path, &given(), ALL);
    assert!(
        message.contains("Mini.fstat: there is no such file"),
        "{message}"
    );
    // Without fields of contacts it is not missed, nor are masses without fields of mass.
    let found = states(&path, &Given::default(), Needs::default()).unwrap();
    assert!(found[0].contacts.is_none() && found[0].particles.mass.is_empty());
    let only = Given {
        densities: [(3, 1.0)].into(),
        ..Given::default()
    };
    let message = error(
        &path,
        &only,
        Needs {
            mass: true,
            ..Needs::default()
        },
    );
    assert!(
        message.contains("no density of material 0") && message.contains("--density 0=RHO"),
        "{message}"
    );
    for name in ["nothing.data", "nothing"] {
        let message = error(&folder.path().join(name), &given(), ALL);
        assert!(message.contains(name), "{message}");
    }
    let empty = folder.path().join("empty");
    fs::create_dir(&empty).unwrap();
    assert!(error(&empty, &given(), ALL).contains("no particles in this folder"));
}

#[test]
fn frames_without_contacts_of_their_time_are_counted() {
    let folder = TempDir::new().unwrap();
    miniature(folder.path(), &["0", "0.1", "0.2"]);
    let fstat = fs::read_to_string(folder.path().join("Mini.fstat")).unwrap();
    fs::write(
        folder.path().join("Mini.fstat"),
        fstat.replace("0.1 ", "0.15 "),
    )
    .unwrap();
    let source = Source::open(&folder.path().join("Mini.data"), &given(), ALL).unwrap();
    let times: Vec<f64> = source
        .states(FrameChoice::All)
        .map(|state| state.unwrap().time)
        .collect();
    assert_eq!(times, [0.0, 0.2]);
    let (count, reported) = source.skipped();
    assert_eq!(
        (count, reported.as_deref()),
        (1, Some("particles at t = 0.1, contacts at t = 0.15"))
    );
    let last = source.states(FrameChoice::Last).next().unwrap().unwrap();
    assert_eq!(last.time, 0.2);
    // However often they are met.
    assert_eq!(source.skipped().0, 1);
}

#[test]
fn damaged_files_give_their_good_frames_first() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("Mini.data");
    for (from, to, expected) in [
        ("0 0 1.494 0 0 0 0.5 0 0 0 0 0 0 0\n2 0.2", "2 0.2", "13"),
        ("0.496 0 0 0 0.5", "nan 0 0 0 0.5", "NaN"),
        ("0.496 0 0 0 0.5", "0.496 inf 0 0 0.5", "inf"),
        ("0.496 0 0 0 0.5", "0.496 0 0 0 -0.5", "radius"),
        ("0.496 0 0 0 0.5", "0.496 0 x 0 0.5", "\"x\""),
    ] {
        miniature(folder.path(), &["0", "0.1", "0.2"]);
        let text = fs::read_to_string(&path).unwrap();
        // Only in the second frame.
        let second = text.find("2 0.1").unwrap();
        let changed = text[second..].replacen(from, to, 1);
        fs::write(&path, format!("{}{changed}", &text[..second])).unwrap();
        let source = Source::open(&path, &given(), ALL).unwrap();
        let found: Vec<_> = source.states(FrameChoice::All).collect();
        assert!(found.len() == 2 && found[0].is_ok(), "{from}: {found:?}");
        let message = found[1].as_ref().unwrap_err().to_string();
        assert!(message.contains(expected) || expected == "13", "{message}");
    }
    miniature(folder.path(), &["0", "0.1"]);
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, &text[..text.len() - 40]).unwrap();
    let source = Source::open(&path, &given(), ALL).unwrap();
    let found: Vec<_> = source.states(FrameChoice::All).collect();
    assert!(
        found.len() == 2
            && found[1]
                .as_ref()
                .unwrap_err()
                .to_string()
                .contains("unfinished"),
        "{found:?}"
    );
    // The last good one is the last.
    let last: Vec<_> = source.states(FrameChoice::Last).collect();
    assert!(last.len() == 2 && last[0].as_ref().unwrap().time == 0.0);
}

#[test]
fn contacts_of_particles_that_are_not_there_are_reported() {
    let folder = TempDir::new().unwrap();
    for (from, to, expected) in [
        (
            "0 1 0 0 0.995",
            "0 7 0 0 0.995",
            "name particle 7; the particles are 0 to 1",
        ),
        ("0 1 0 0 0.995", "-2 1 0 0 0.995", "name particle -2"),
        ("0 1 0 0 0.995", "0 0 0 0 0.995", "touch itself"),
        ("0.002 0 2 0 0 0 -1", "0.002 0 nan 0 0 0 -1", "force"),
    ] {
        miniature(folder.path(), &["0"]);
        let path = folder.path().join("Mini.fstat");
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, text.replacen(from, to, 1)).unwrap();
        let message = error(&folder.path().join("Mini.data"), &given(), ALL);
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn empty_frames_are_frames() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("Empty.data");
    fs::write(&path, "0 0 0 0 0 1 1 1\n0 1 0 0 0 1 1 1\n").unwrap();
    let found = states(
        &path,
        &given(),
        Needs {
            mass: true,
            ..Needs::default()
        },
    )
    .unwrap();
    assert_eq!(found.len(), 2);
    assert!(found[0].particles.is_empty());
}

#[test]
fn fixed_particles_are_boundary_and_their_lines_are_not_missed() {
    let folder = TempDir::new().unwrap();
    miniature(folder.path(), &["0"]);
    let path = folder.path().join("Mini.data");
    // The lower one fixed: MercuryDPM leaves its lines out, others may not.
    let fixed = Given {
        fixed: vec![(0, 0)],
        ..given()
    };
    let fstat = folder.path().join("Mini.fstat");
    let text = fs::read_to_string(&fstat).unwrap();
    let without: String = text
        .lines()
        .filter(|line| !line.starts_with("0 0 1 "))
        .map(|line| format!("{line}\n"))
        .collect();
    for text in [text.clone(), without] {
        fs::write(&fstat, text).unwrap();
        let found = states(&path, &fixed, ALL).unwrap();
        let c = found[0].contacts.as_ref().unwrap();
        assert_eq!(found[0].particles.flowing, [false, true]);
        assert_eq!(
            (c.particle[0], c.partner[0], c.force[0]),
            (1, Partner::Particle(0), DVec3::new(0.0, 0.0, 2.0))
        );
        assert_eq!(
            c.partner
                .iter()
                .filter(|partner| matches!(partner, Partner::Particle(_)))
                .count(),
            1
        );
    }
}

#[test]
fn two_dimensions_have_discs() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("Flat.data");
    fs::write(&path, "1 0.5 0 0 2 3\n1 1 0.5 0 0.5 0 0.25 0\n").unwrap();
    let state = &states(
        &path,
        &Given {
            density: Some(3.0),
            ..Given::default()
        },
        Needs {
            mass: true,
            ..Needs::default()
        },
    )
    .unwrap()[0];
    assert_eq!(state.space.dimensions, 2);
    assert!((state.particles.volume[0] - std::f64::consts::PI / 4.0).abs() < 1e-15);
    assert!((state.particles.mass[0] - 3.0 * std::f64::consts::PI / 4.0).abs() < 1e-15);
    // w_z is stored with the other sign; spin of a disc: m r^2 w / 2.
    assert!(
        (state.particles.spin[0].z + 0.25 * 0.5 * 0.25 * state.particles.mass[0]).abs() < 1e-15
    );
}

fn run(folder: &Path, fixed: bool) {
    let header = FramesHeader {
        materials: vec!["glass".to_owned()],
        domain: Some((DVec3::ZERO, DVec3::ONE)),
        periodic: [true, false, false],
        dimensions: Some(3),
        ..FramesHeader::default()
    };
    let columns = ParticleColumns::default();
    let mut particles =
        ParticleWriter::create(folder.join("a.particles.arrow"), &header, &columns).unwrap();
    let mut contacts = ContactWriter::create(
        folder.join("a.contacts.arrow"),
        &header,
        &ContactColumns::default(),
    )
    .unwrap();
    for step in 0..3u64 {
        particles
            .append(ParticleFrame {
                time: step as f64,
                step,
                id: vec![4, 2],
                material: vec![0, 0],
                flags: vec![0, if fixed { FLAG_FIXED } else { 0 }],
                mass: vec![1.0, 2.0],
                volume: vec![0.1, 0.2],
                radius: vec![0.1, 0.1],
                position: vec![DVec3::new(0.05, 0.5, 0.5), DVec3::new(0.9, 0.5, 0.5)],
                velocity: vec![DVec3::ZERO; 2],
                ..ParticleFrame::default()
            })
            .unwrap();
        if step == 1 {
            continue;
        }
        contacts
            .append(ContactFrame {
                time: step as f64,
                step,
                i: vec![4],
                j: vec![Some(2)],
                wall: vec![None],
                point: vec![DVec3::new(-0.025, 0.5, 0.5)],
                branch: vec![DVec3::new(0.15, 0.0, 0.0)],
                normal: vec![DVec3::X],
                force: vec![DVec3::new(3.0, 1.0, 0.0)],
                overlap: vec![0.05],
                ..ContactFrame::default()
            })
            .unwrap();
    }
}

#[test]
fn frames_of_a_run_bring_masses_flags_and_contacts_through_periodic_faces() {
    let folder = TempDir::new().unwrap();
    run(folder.path(), true);
    let source = Source::open(folder.path(), &Given::default(), ALL).unwrap();
    assert_eq!(
        (source.prefix().as_str(), source.materials()),
        ("a", &["glass".to_owned()][..])
    );
    let found: Vec<State> = source
        .states(FrameChoice::All)
        .collect::<Result<_, _>>()
        .unwrap();
    // The frame in the middle has no contacts of its own.
    assert_eq!(
        found.iter().map(|state| state.time).collect::<Vec<_>>(),
        [0.0, 2.0]
    );
    assert_eq!(source.skipped().0, 1);
    let state = &found[0];
    assert_eq!(state.particles.flowing, [true, false]);
    assert_eq!(state.particles.mass, [1.0, 2.0]);
    let c = state.contacts.as_ref().unwrap();
    assert_eq!((c.particle[0], c.partner[0]), (0, Partner::Particle(1)));
    assert!((c.arm[0] - DVec3::new(0.075, 0.0, 0.0)).length() < 1e-15);
    assert!((c.partner_arm[0] - DVec3::new(-0.075, 0.0, 0.0)).length() < 1e-15);
    fs::remove_file(folder.path().join("a.contacts.arrow")).unwrap();
    let message = error(folder.path(), &Given::default(), ALL);
    assert!(
        message.contains("a.contacts.arrow: there is no such file")
            && message.contains("fstat = true"),
        "{message}"
    );
    let message = error(
        folder.path(),
        &Given::default(),
        Needs {
            rotation: true,
            ..Needs::default()
        },
    );
    assert!(message.contains("no angular velocities"), "{message}");
    let message = error(
        folder.path(),
        &Given::default(),
        Needs {
            liquid: true,
            ..Needs::default()
        },
    );
    assert!(message.contains("no column liquid_volume"), "{message}");
}

#[test]
fn a_growing_run_is_followed_to_its_end() {
    let folder = TempDir::new().unwrap();
    run(folder.path(), false);
    fs::write(folder.path().join("summary.json"), "{}").unwrap();
    let mut source = Source::open(folder.path(), &Given::default(), ALL).unwrap();
    let Source::Run(run) = &mut source else {
        panic!("not a run")
    };
    let times: Vec<f64> = run
        .follow(FrameChoice::All, folder.path().join("summary.json"))
        .map(|state| state.unwrap().time)
        .collect();
    assert_eq!(times, [0.0, 2.0]);
    assert!(!run.broke_off());
}

/// A run that was killed leaves neither its end nor a process that writes: what is there is given, and the waiting ends.
#[test]
fn a_run_that_broke_off_is_not_waited_for() {
    let folder = TempDir::new().unwrap();
    run(folder.path(), false);
    // The last process number is never given out.
    let mut owner = Owner::myself();
    owner.process = u32::MAX;
    fs::write(folder.path().join(LOCK), owner.text()).unwrap();
    let mut source = Source::open(folder.path(), &Given::default(), ALL).unwrap();
    let Source::Run(run) = &mut source else {
        panic!("not a run")
    };
    let states = run.follow(FrameChoice::All, folder.path().join("summary.json"));
    let times: Vec<f64> = states.map(|state| state.unwrap().time).collect();
    assert_eq!(times, [0.0, 2.0]);
    assert!(run.broke_off());
}

#[test]
fn a_cut_file_of_frames_gives_the_whole_ones() {
    let folder = TempDir::new().unwrap();
    run(folder.path(), false);
    let path = folder.path().join("a.particles.arrow");
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() - 200]).unwrap();
    let source = Source::open(
        folder.path(),
        &Given::default(),
        Needs {
            mass: true,
            ..Needs::default()
        },
    )
    .unwrap();
    let found: Vec<_> = source.states(FrameChoice::All).collect();
    assert!(
        found.len() == 3
            && found[1].is_ok()
            && found[2]
                .as_ref()
                .unwrap_err()
                .to_string()
                .contains("behind 2 whole frames"),
        "{found:?}"
    );
}

/// Wherever the file of contacts is cut, it is named as cut, after the frames whose contacts are whole.
#[test]
fn a_cut_file_of_contacts_is_reported_as_cut() {
    let folder = TempDir::new().unwrap();
    run(folder.path(), false);
    let path = folder.path().join("a.contacts.arrow");
    let end = folder.path().join("summary.json");
    fs::write(&end, "{}").unwrap();
    let bytes = fs::read(&path).unwrap();
    let mut seen = [0; 3];
    for length in (0..bytes.len()).step_by(8) {
        fs::write(&path, &bytes[..length]).unwrap();
        let mut source = match Source::open(folder.path(), &Given::default(), ALL) {
            Ok(source) => source,
            Err(error) => {
                let message = error.to_string();
                assert!(message.contains("a.contacts.arrow: "), "{message}");
                continue;
            }
        };
        let all: Vec<_> = source.states(FrameChoice::All).collect();
        let last: Vec<_> = source.states(FrameChoice::Last).collect();
        let Source::Run(run) = &mut source else {
            panic!("not a run")
        };
        let followed: Vec<_> = run.follow(FrameChoice::All, end.clone()).collect();
        let whole = all.len() - 1;
        seen[whole] += 1;
        let expected = [0.0, 2.0];
        for (found, times) in [
            (&all, &expected[..whole]),
            (&followed, &expected[..whole]),
            (&last, &expected[whole.saturating_sub(1)..whole]),
        ] {
            let (damage, good) = found.split_last().unwrap();
            let good = good.iter().map(|state| state.as_ref().unwrap().time);
            assert_eq!(good.collect::<Vec<_>>(), times, "{length}");
            let message = damage.as_ref().unwrap_err().to_string();
            let plural = if whole == 1 { "frame" } else { "frames" };
            assert!(
                message.contains("a.contacts.arrow: ")
                    && message.contains(&format!("behind {whole} whole {plural}")),
                "{message}"
            );
        }
    }
    assert!(seen.iter().all(|&count| count > 0), "{seen:?}");
    // Fields without contacts do not need the file.
    fs::write(&path, &bytes[..9]).unwrap();
    let needs = Needs {
        contacts: false,
        ..ALL
    };
    let found = states(folder.path(), &Given::default(), needs).unwrap();
    assert_eq!(found.len(), 3);
}

#[test]
fn restart_files_of_other_kinds_are_refused() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.restart");
    let good = "MercuryDPM 1.0 name Mini\nxMin -1 xMax 1 yMin -1 yMax 1 zMin 0 zMax 3\ntimeStep 1e-4 time 0.5\n\
        systemDimensions 3 particleDimensions 3 gravity 0 0 -2\nSpecies 1\nLinearViscoelasticSpecies id 0 density 2\nWalls 0\nBoundaries 1\n\
        PeriodicBoundary id 0 normal 1 0 0 distanceLeft -1 distanceRight 1\nParticles 1\n\
        BaseParticle id 3 indSpecies 0 position 0 0 0.5 velocity 1 2 3 angularVelocity 0 0 1 radius 0.5 invMass 0.5\nInteractions 1\n\
        LinearViscoelasticInteraction particleWallIds 3 0 contactPoint 0 0 0 normal 0 0 1 distance 0.5 overlap 0 force 0 0 4 torque 0 0 0\n";
    fs::write(&path, good).unwrap();
    let restart = read_restart(&path).unwrap();
    assert_eq!(
        (
            restart.state.time,
            restart.densities.as_slice(),
            restart.state.particles.mass[0]
        ),
        (0.5, &[2.0][..], 2.0)
    );
    assert_eq!(
        (
            restart.state.space.periodic,
            restart.state.contacts.as_ref().unwrap().len()
        ),
        ([true, false, false], 1)
    );
    for (from, to, expected) in [
        (
            "MercuryDPM 1.0",
            "restart_version 3",
            "from before MercuryDPM 1.0",
        ),
        ("MercuryDPM 1.0", "MercuryDPM 9.9", "version 9.9"),
        ("density 2", "density", "density without its numbers"),
        ("invMass 0.5", "", "no word invMass"),
        ("indSpecies 0", "indSpecies 4", "species 4"),
        ("particleWallIds 3 0", "particleWallIds 8 0", "particle 8"),
        ("Interactions 1\n", "", "a file that is cut"),
        (
            "Interactions 1",
            "Interactions 2",
            "ends within the interactions",
        ),
        ("Particles 1", "Particles x", "without a number"),
    ] {
        fs::write(&path, good.replace(from, to)).unwrap();
        let message = read_restart(&path).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
}

/// A restart file for the miniature: the upper sphere is fixed.
fn restart_beside(folder: &Path, boundaries: &[&str]) {
    let text = format!(
        "MercuryDPM 1.0 name Mini\nxMin -1 xMax 1 yMin -1 yMax 1 zMin 0 zMax 3\ntimeStep 1e-4 time 0.5\n\
        systemDimensions 3 particleDimensions 3 gravity 0 0 -2\nSpecies 1\nLinearViscoelasticSpecies id 0 density 2\nWalls 0\n\
        Boundaries {}\n{}Particles 2\n\
        BaseParticle id 0 indSpecies 0 position 0 0 0.496 velocity 0 0 0 angularVelocity 0 0 0 radius 0.5 invMass 1\n\
        BaseParticle id 1 indSpecies 0 position 0 0 1.494 velocity 0 0 0 angularVelocity 0 0 0 radius 0.5 invMass 0\nInteractions 0\n",
        boundaries.len(),
        boundaries
            .iter()
            .map(|line| format!("{line}\n"))
            .collect::<String>(),
    );
    fs::write(folder.join("Mini.restart"), text).unwrap();
}

#[test]
fn densities_that_are_given_leave_the_rest_of_the_restart_file() {
    let folder = TempDir::new().unwrap();
    miniature(folder.path(), &["0"]);
    let path = folder.path().join("Mini.data");
    restart_beside(
        folder.path(),
        &["PeriodicBoundary id 0 normal 1 0 0 distanceLeft -1 distanceRight 1 shift 2 0 0"],
    );
    for (given, mass) in [
        (given(), 1.0),
        (Given::default(), std::f64::consts::PI / 3.0),
    ] {
        let source = Source::open(&path, &given, ALL).unwrap();
        let state = source.states(FrameChoice::All).next().unwrap().unwrap();
        assert_eq!(state.particles.flowing, [true, false]);
        assert_eq!(state.space.periodic, [true, false, false]);
        assert!((state.particles.mass[0] - mass).abs() < 1e-15);
        assert!(source.notes().is_empty(), "{:?}", source.notes());
    }
    // A restart file that cannot be read matters only if no density is given.
    let restart = folder.path().join("Mini.restart");
    let text = fs::read_to_string(&restart).unwrap();
    fs::write(&restart, text.replace("MercuryDPM 1.0", "MercuryDPM 9.9")).unwrap();
    let source = Source::open(&path, &given(), ALL).unwrap();
    let notes = source.notes().join("\n");
    assert!(
        notes.contains("fixed particles and periodic faces are not known")
            && notes.contains("version 9.9"),
        "{notes}"
    );
    assert!(error(&path, &Given::default(), ALL).contains("version 9.9"));
}

#[test]
fn periods_are_where_the_restart_file_says() {
    let folder = TempDir::new().unwrap();
    miniature(folder.path(), &["0"]);
    restart_beside(
        folder.path(),
        &[
            "PeriodicBoundary id 0 normal -1 0 0 distanceLeft -0.75 distanceRight 0.5 shift 1.25 0 0",
            "PeriodicBoundary id 1 normal 0.6 0.8 0 distanceLeft -1 distanceRight 1 shift 2 0 0",
            "LeesEdwardsBoundary id 2 left 0.3 right 0.4 down 0.5 up 0.6 shift 0.1 vel 0.2",
        ],
    );
    for name in ["Mini.data", "Mini.restart"] {
        let source = Source::open(&folder.path().join(name), &Given::default(), ALL).unwrap();
        let state = source.states(FrameChoice::All).next().unwrap().unwrap();
        assert_eq!(state.space.periodic, [true, false, false]);
        assert_eq!((state.space.min.x, state.space.max.x), (-0.5, 0.75));
        assert_eq!(state.space.period(0), Some(1.25));
        let notes = source.notes();
        assert_eq!(notes.len(), 3, "{notes:?}");
        for (note, expected) in notes.iter().zip([
            "Mini.restart:9: the domain is periodic along x from -0.5 to 0.75, and is taken to end there",
            "Mini.restart:10: fields do not go on through a periodic boundary with the normal [0.6, 0.8, 0]",
            "Mini.restart:11: fields do not go on through this LeesEdwardsBoundary",
        ]) {
            assert!(note.contains(expected), "{note}");
        }
    }
    restart_beside(
        folder.path(),
        &["PeriodicBoundary id 0 normal 1 0 0 distanceLeft 1 distanceRight 1"],
    );
    let message = error(&folder.path().join("Mini.data"), &Given::default(), ALL);
    assert!(
        message.contains("Mini.restart:9: a period from 1 to 1"),
        "{message}"
    );
}

#[test]
fn what_is_missing_from_data_files_is_unknown() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("Few.data");
    let row = "0 0 0.5 0 0 0 0.5 0 0 0 0 0 0 0\n";
    let frame =
        |time: u32, count: usize| format!("{count} {time} -1 -1 0 1 1 3\n{}", row.repeat(count));
    let counts = [2, 3, 3, 1];
    let text: String = (0..)
        .zip(counts)
        .map(|(t, count)| frame(t, count))
        .collect();
    fs::write(&path, text).unwrap();
    let needs = Needs {
        identity: true,
        ..Needs::default()
    };
    let source = Source::open(&path, &given(), needs).unwrap();
    let found: Vec<_> = source.states(FrameChoice::All).collect();
    assert_eq!(found.len(), 4);
    let message = found[3].as_ref().unwrap_err().to_string();
    assert!(
        message.contains("frame 3 at t = 3: 1 particles, 3 in the frame before")
            && message.contains("displacements cannot be known"),
        "{message}"
    );
    // Without displacements the same input is accepted.
    assert_eq!(states(&path, &given(), Needs::default()).unwrap().len(), 4);
}

#[test]
fn numbers_that_are_none_are_refused_wherever_they_stand() {
    let folder = TempDir::new().unwrap();
    run(folder.path(), false);
    let source = Source::open(folder.path(), &Given::default(), ALL).unwrap();
    let good = source.states(FrameChoice::All).next().unwrap().unwrap();
    assert!(check(&good, "a").is_ok());
    type Spoil = (&'static str, fn(&mut State));
    let spoil: [Spoil; 5] = [
        ("angular velocity", |s| {
            s.particles.angular_velocity[0].x = f64::NAN
        }),
        ("spin", |s| s.particles.spin[1].z = f64::INFINITY),
        ("way to its particle", |s| {
            s.contacts.as_mut().unwrap().arm[0].y = f64::NAN
        }),
        ("way to its partner", |s| {
            s.contacts.as_mut().unwrap().partner_arm[0].y = f64::NAN
        }),
        ("couple", |s| {
            s.contacts.as_mut().unwrap().couple[0].y = f64::NAN
        }),
    ];
    for (name, spoil) in spoil {
        let mut bad = good.clone();
        spoil(&mut bad);
        let message = check(&bad, "a").unwrap_err().to_string();
        assert!(message.contains(name), "{message}");
    }
}

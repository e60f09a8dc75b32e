//! Conventions of the files, on states made by hand.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;

use super::contact_frames::contact_frame;
use super::fstat_file::contact_rows;
use super::{Due, Exchanged, FrameCopy, STREAMS, Schedule, Writer, energies, folder};
use crate::boundaries::output::region_counts::{Content, contents};
use crate::plan::Plan;
use mercury_common::formats::clump::Pebble;
use mercury_common::frames::ContactColumns;
use mercury_common::scene::{Files, parse_scene};
use mercury_engine::bodies::{Clump, NewBody};
use mercury_engine::boundaries::{CountedRegion, Region};
use mercury_engine::cell::{Cell, NO_SHIFT};
use mercury_engine::forces::{ContactRecord, Observation, Partner, Watch};
use mercury_engine::state::{FIXED, Load, MaterialIndex, Particle, WallIndex};
use mercury_engine::step::Engine;

fn particle(x: f64, radius: f64, flags: u32) -> Particle {
    Particle {
        position: DVec3::new(x, 0.0, 0.0),
        radius,
        velocity: DVec3::new(0.0, 2.0, 0.0),
        inverse_mass: if flags & FIXED != 0 { 0.0 } else { 0.5 },
        angular_velocity: DVec3::new(0.0, 0.0, 3.0),
        material: MaterialIndex::new(0),
        flags,
    }
}

/// A contact of the particle in `row` with force (4, 3, 0) N along the normal +x and overlap 0.2 m.
fn record(row: u32, partner: Partner) -> ContactRecord {
    ContactRecord {
        bridge_volume: 0.0,
        bridge_normal: 0.0,
        bridge_shear: DVec3::ZERO,
        adhesion: 0.0,
        row,
        partner,
        feature: u32::MAX,
        point: DVec3::ZERO,
        normal: DVec3::X,
        overlap: 0.2,
        force: DVec3::new(4.0, 3.0, 0.0),
        tangential: DVec3::new(0.0, 3.0, 0.0),
        couple: DVec3::Z,
        tangential_overlap: -0.01,
        history: vec![7.0],
    }
}

/// Rows 0, 1, 2 hold the ids 9, 4, 6: ranks 2, 0, 1.
fn state(flags_of_id_6: u32, records: Vec<ContactRecord>) -> FrameCopy {
    let moment = FrameCopy {
        time: 1.5,
        step: 3,
        due: Due {
            frame: true,
            contacts: true,
            ..Due::default()
        },
        particles: vec![
            particle(5.0, 0.5, 0),
            particle(11.0, 1.0, 0),
            particle(-0.8, 1.0, flags_of_id_6),
        ],
        loads: vec![Load::default(); 3],
        ids: vec![9, 4, 6],
        masses: vec![2.0; 3],
        observation: Observation {
            records,
            elastic_energy: 0.25,
            ..Observation::default()
        },
        ..FrameCopy::default()
    };
    let cell = Cell::new(DVec3::ZERO, DVec3::splat(10.0), [true, false, false]);
    moment.in_order_of_ids(&cell)
}

#[test]
fn states_are_ordered_by_id_and_wrapped() {
    let state = state(0, Vec::new());
    assert_eq!(state.ids, [4, 6, 9]);
    let x: Vec<f64> = state.particles.iter().map(|p| p.position.x).collect();
    assert_eq!(x, [1.0, 10.0 - 0.8, 5.0]);
    assert_eq!(state.rank_of_row, [2, 0, 1]);
}

#[test]
fn a_pair_makes_two_lines_with_the_point_of_the_lower_index() {
    // id 4 (rank 0) with id 6 (rank 1), across the periodic face.
    let partner = Partner::Particle {
        row: 2,
        image: NO_SHIFT,
    };
    let rows = contact_rows(&state(0, vec![record(1, partner)]), false);
    assert_eq!(
        rows.iter().map(|row| (row.i, row.j)).collect::<Vec<_>>(),
        [(0, 1), (1, 0)]
    );
    // c = x_P - (R_P - overlap / 2) n with the wrapped position 1: 1 - 0.9
    let point = DVec3::new(1.0 - (1.0 - 0.1), 0.0, 0.0);
    for row in &rows {
        assert_eq!(row.time, 1.5);
        assert!((row.contact_point - point).length() < 1e-15);
        assert_eq!((row.overlap, row.tangential_overlap), (0.2, -0.01));
        assert_eq!((row.normal_force, row.tangential_force), (4.0, 3.0));
    }
    assert_eq!(rows[0].force(), DVec3::new(4.0, 3.0, 0.0), "on P");
    assert_eq!(rows[1].force(), -rows[0].force(), "on I");
    assert_eq!((rows[0].normal, rows[0].tangent), (DVec3::X, DVec3::Y));
}

#[test]
fn a_fixed_particle_has_no_line() {
    let partner = Partner::Particle {
        row: 2,
        image: NO_SHIFT,
    };
    let rows = contact_rows(&state(FIXED, vec![record(1, partner)]), false);
    assert_eq!(
        rows.iter().map(|row| (row.i, row.j)).collect::<Vec<_>>(),
        [(0, 1)]
    );
}

#[test]
fn a_wall_makes_one_line_that_points_into_it() {
    let partner = Partner::Wall {
        wall: WallIndex::new(2),
        image: NO_SHIFT,
    };
    let rows = contact_rows(&state(0, vec![record(0, partner)]), false);
    assert_eq!(rows.len(), 1);
    assert_eq!((rows[0].i, rows[0].j, rows[0].wall()), (2, -3, Some(2)));
    assert_eq!((rows[0].normal, rows[0].tangent), (-DVec3::X, -DVec3::Y));
    assert_eq!(rows[0].normal_force, 4.0, "repulsion is positive");
    assert_eq!(rows[0].force(), DVec3::new(4.0, 3.0, 0.0));
    // The point is on the wall side of the particle: 5 - (0.5 - 0.1).
    assert!((rows[0].contact_point.x - 4.6).abs() < 1e-15);
}

#[test]
fn lines_are_sorted_by_both_indices() {
    let pair = |row| Partner::Particle {
        row,
        image: NO_SHIFT,
    };
    let wall = Partner::Wall {
        wall: WallIndex::new(0),
        image: NO_SHIFT,
    };
    let records = vec![record(2, pair(0)), record(1, wall), record(1, pair(2))];
    let rows = contact_rows(&state(0, records), false);
    let keys: Vec<_> = rows.iter().map(|row| (row.i, row.j)).collect();
    assert_eq!(keys, [(0, -1), (0, 1), (1, 0), (1, 2), (2, 1)]);
}

#[test]
fn native_contacts_carry_ids_and_branch_vectors() {
    let pair = Partner::Particle {
        row: 2,
        image: NO_SHIFT,
    };
    let wall = Partner::Wall {
        wall: WallIndex::new(2),
        image: NO_SHIFT,
    };
    let columns = ContactColumns {
        membrane: false,
        bridge: false,
        adhesion: false,
        torque: true,
        history: vec![mercury_common::frames::HistoryColumn {
            unit: "m".to_owned(),
            description: String::new(),
        }],
    };
    let frame = contact_frame(&state(0, vec![record(0, wall), record(1, pair)]), &columns);
    assert_eq!(frame.i, [4, 9]);
    assert_eq!(frame.j, [Some(6), None]);
    assert_eq!(frame.wall, [None, Some(2)]);
    // R_i + R_j - overlap, and R_i - overlap / 2.
    assert!((frame.branch[0] - DVec3::X * 1.8).length() < 1e-15);
    assert!((frame.branch[1] - DVec3::X * 0.4).length() < 1e-15);
    assert_eq!(frame.normal, [DVec3::X, DVec3::X]);
    assert_eq!(frame.torque, Some(vec![DVec3::Z, DVec3::Z]));
    assert_eq!(frame.history, [[7.0, 7.0]]);
}

/// Of unequal spheres the branch joins the centres, whichever has the lower id.
#[test]
fn branches_of_unequal_spheres_join_their_centres() {
    let columns = ContactColumns {
        membrane: false,
        bridge: false,
        adhesion: false,
        torque: false,
        history: Vec::new(),
    };
    // Ids 4 and 9 of radii 1 and 0.5 m.
    let with = |row: u32| Partner::Particle {
        row,
        image: NO_SHIFT,
    };
    let mut reported = record(1, with(0));
    reported.history.clear();
    let frame = contact_frame(&state(0, vec![reported]), &columns);
    assert_eq!((frame.i[0], frame.j[0]), (4, Some(9)));
    assert!((frame.branch[0] - DVec3::X * (1.0 + 0.5 - 0.2)).length() < 1e-15);
}

#[test]
fn energies_leave_fixed_particles_out() {
    let gravity = DVec3::new(-10.0, 0.0, 0.0);
    let row = energies(&state(FIXED, Vec::new()), gravity, 3);
    // two particles of 2 kg at x = 1 and 5, v = 2, radii 1 and 0.5, w = 3
    assert!((row.gravitational - 2.0 * 10.0 * (1.0 + 5.0)).abs() < 1e-12);
    assert!((row.translational_kinetic - 2.0 * (0.5 * 2.0 * 4.0)).abs() < 1e-12);
    let inertia = 0.4 * 2.0 * (1.0 + 0.25);
    assert!((row.rotational_kinetic - 0.5 * inertia * 9.0).abs() < 1e-12);
    assert_eq!(row.elastic, 0.25);
    assert!((row.center_of_mass.x - 3.0).abs() < 1e-15);
}

/// A fixed body has no energy and no part in the centre of mass, whatever motion is prescribed.
#[test]
fn energies_leave_fixed_bodies_out() {
    let pebbles = vec![Pebble {
        position: DVec3::ZERO,
        radius: 1.0,
    }];
    let moments = DVec3::splat(1.2);
    let clumps = [Clump::new("ball", MaterialIndex::new(0), pebbles, 3.0, 4.0, moments).unwrap()];
    let body = |x: f64, fixed: bool| {
        let new = NewBody {
            velocity: DVec3::new(0.0, 4.0, 0.0),
            angular_velocity: DVec3::new(0.0, 0.0, 5.0),
            fixed,
            ..NewBody::at(DVec3::new(x, 0.0, 0.0), 0)
        };
        new.body(&clumps)
    };
    let mut state = state(FIXED, Vec::new());
    state.bodies = vec![body(7.0, false), body(20.0, true)];
    let row = energies(&state, DVec3::new(-10.0, 0.0, 0.0), 3);
    // Two particles of 2 kg as above, and a body of 3 kg and 1.2 kg m^2 at x = 7.
    assert!((row.gravitational - 10.0 * (2.0 + 10.0 + 21.0)).abs() < 1e-12);
    assert!((row.translational_kinetic - (8.0 + 0.5 * 3.0 * 16.0)).abs() < 1e-12);
    let inertia = 0.4 * 2.0 * (1.0 + 0.25);
    assert!((row.rotational_kinetic - (0.5 * inertia * 9.0 + 0.5 * 1.2 * 25.0)).abs() < 1e-12);
    assert!((row.center_of_mass.x - (2.0 + 10.0 + 21.0) / 7.0).abs() < 1e-14);
}

/// A disc's moment of inertia is m R^2/2.
#[test]
fn energies_of_discs_turn_as_discs() {
    let row = energies(&state(FIXED, Vec::new()), DVec3::ZERO, 2);
    let inertia = 0.5 * 2.0 * (1.0 + 0.25);
    assert!((row.rotational_kinetic - 0.5 * inertia * 9.0).abs() < 1e-12);
}

#[test]
fn a_folder_with_a_run_is_kept_unless_forced_and_other_files_always() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("run");
    folder::prepare(&path, "drum", folder::Earlier::Refuse).unwrap();
    for name in [
        "drum.data",
        "drum.toml",
        "drum.csv",
        "other.data",
        "notes.txt",
    ] {
        std::fs::write(path.join(name), name).unwrap();
    }
    let error = folder::prepare(&path, "drum", folder::Earlier::Refuse)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("drum.data") && error.contains("--force"),
        "{error}"
    );
    assert!(path.join("drum.data").exists());
    folder::prepare(&path, "drum", folder::Earlier::Replace).unwrap();
    let mut left: Vec<_> = std::fs::read_dir(&path)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    left.sort();
    assert_eq!(left, ["drum.csv", "drum.toml", "notes.txt", "other.data"]);
    for name in ["plan.toml", "summary.json"] {
        std::fs::write(path.join(name), name).unwrap();
        assert!(
            folder::prepare(&path, "drum", folder::Earlier::Refuse).is_err(),
            "{name}"
        );
        std::fs::remove_file(path.join(name)).unwrap();
    }
}

#[test]
fn a_file_is_no_folder() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("taken");
    std::fs::write(&path, "").unwrap();
    for earlier in [folder::Earlier::Refuse, folder::Earlier::Replace] {
        let error = folder::prepare(&path, "drum", earlier)
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("not a folder") && error.contains("--output"),
            "{error}"
        );
    }
}

#[test]
fn a_region_counts_whole_spheres_by_their_centres() {
    let state = state(0, Vec::new());
    let region = CountedRegion {
        name: "left".to_owned(),
        region: Region::Box {
            min: DVec3::new(0.0, -1.0, -1.0),
            max: DVec3::new(5.0, 1.0, 1.0),
        },
        volume: 20.0,
    };
    let materials = [
        (MaterialIndex::new(0), "stone".to_owned()),
        (MaterialIndex::new(3), "steel".to_owned()),
    ];
    let found = contents(&state, &region, &materials, 3);
    // The centres x = 1 and x = 5; the one at 9.2 is out. A centre on the face counts.
    let sphere = 4.0 / 3.0 * std::f64::consts::PI;
    assert_eq!(found[0].number, 2);
    assert_eq!(found[0].mass, 4.0);
    assert_eq!(found[0].momentum, DVec3::new(0.0, 8.0, 0.0));
    assert_eq!(found[0].kinetic, 8.0);
    assert!((found[0].volume - sphere * (1.0 + 0.125)).abs() < 1e-14);
    assert_eq!(found[1], Content::default());
}

#[test]
fn fixed_particles_are_not_counted() {
    let state = state(FIXED, Vec::new());
    let everywhere = CountedRegion {
        name: "all".to_owned(),
        region: Region::Intersection(Vec::new()),
        volume: 1.0,
    };
    let found = contents(
        &state,
        &everywhere,
        &[(MaterialIndex::new(0), "stone".to_owned())],
        3,
    );
    assert_eq!(found[0].number, 2);
}

/// Every file of a folder with its bytes.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path));
        } else {
            let bytes = std::fs::read(&path).unwrap();
            found.insert(path, bytes);
        }
    }
    found
}

/// A bouncing clump and sphere on a mesh, with every output that there is.
fn everything_written() -> Arc<Plan> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    let text = r#"
        gravity = [0, 0, -9.81]
        time = { end = 0.05, step = 1e-4 }
        domain = { min = [0, 0, 0], max = [1, 1, 1] }
        [output]
        interval = 0.002
        rows_interval = 0.0007
        fstat_interval = 0.003
        vtk_interval = 0.005
        data = true
        ene = true
        fstat = true
        vtk = true
        frames = true
        walls = true
        triangle_loads = true
        energy_budget = true
        track = ["ball"]
        [materials.m]
        density = 2000.0
        normal = { law = "linear", stiffness = 1e4, restitution = 0.7 }
        tangential = { law = "linear", stiffness_ratio = 0.2857, friction = 0.5 }
        [[walls]]
        name = "plate"
        shape = "mesh"
        file = "plate.stl"
        material = "m"
        [[fields]]
        name = "ramp"
        fields = ["density", "stress"]
        coordinates = "Z"
        grid = [5]
        width = 0.1
        [[fields]]
        name = "smooth"
        fields = ["density", "displacement"]
        coordinates = "O"
        materials = ["m"]
        since = "first"
        width = 0.1
        smooth = [0.002, 0.003]
        interval = 0.001
        [[fields]]
        name = "whole"
        coordinates = "O"
        interval = 0.003
        [[regions]]
        name = "all"
        region = { shape = "box", min = [0, 0, 0], max = [1, 1, 1] }
        [[particles]]
        name = "ball"
        material = "m"
        radius = 0.01
        position = [0.5, 0.5, 0.211]
        velocity = [0, 0, -1]
        [clumps.rod]
        file = "rod.clump.toml"
        material = "m"
        [[particles]]
        clump = "rod"
        position = [0.45, 0.45, 0.3]
    "#;
    let scene = parse_scene(&folder.join("all.toml"), text, &[], Files::MustExist).unwrap();
    Arc::new(crate::plan::plan(&scene).unwrap())
}

#[test]
fn outputs_continued_are_the_same_bytes() {
    let plan = everything_written();
    let place = tempfile::tempdir().unwrap();
    let mut engine = Engine::new(Arc::clone(&plan), 1).unwrap();
    let columns = engine.history_columns();
    let losses = engine.audit().losses;
    let begin = |from| {
        Writer::start(
            place.path(),
            &plan,
            (&columns, &losses),
            from,
            None,
            &Arc::default(),
        )
        .unwrap()
    };
    let writer = begin(None);
    let time_step = plan.physics().time_step;
    let mut schedule = Schedule::behind(plan.outputs().files(), time_step, 0);
    let at_start = Exchanged::by_now(&engine);
    let moment = FrameCopy::take(&mut engine, schedule.everything(), &at_start);
    assert!(writer.send(moment));
    let mut moments = Vec::new();
    for step in 1..=plan.physics().steps {
        let due = schedule.due(step);
        let watch = due.any().then_some(Watch {
            records: due.needs_records(),
            audit: None,
        });
        engine.step(watch).unwrap();
        if due.any() {
            engine.complete_step().unwrap();
            moments.push(FrameCopy::take(&mut engine, due, &at_start));
        }
    }
    let (first, second) = moments.split_at(moments.len() / 2);
    assert!(first.iter().all(|moment| writer.send(moment.clone())));
    let positions = writer.positions().unwrap();
    let amid = files(place.path());
    assert!(second.iter().all(|moment| writer.send(moment.clone())));
    let at_end = (writer.positions().unwrap(), files(place.path()));
    assert!(at_end.1.len() > 20, "{:?}", at_end.1.keys());
    writer.finish().unwrap();
    let writer = begin(Some((positions.clone(), 0, 0.0)));
    assert_eq!(writer.positions().unwrap(), positions);
    assert_eq!(files(place.path()), amid);
    assert!(second.iter().all(|moment| writer.send(moment.clone())));
    assert_eq!(writer.positions().unwrap(), at_end.0);
    assert_eq!(files(place.path()), at_end.1);
    let (written, _) = writer.finish().unwrap();
    assert_eq!(written.energies.len(), 26);

    // A file that has lost what was written is refused by name.
    let data = place
        .path()
        .join(format!("{}.data", plan.outputs().prefix()));
    std::fs::write(&data, "1 0.0\n").unwrap();
    let refused = Writer::start(
        place.path(),
        &plan,
        (&columns, &losses),
        Some((positions, 0, 0.0)),
        None,
        &Arc::default(),
    );
    let refused = refused.unwrap_err().to_string();
    assert!(
        refused.contains(".data: the file has 6 bytes, the run had written"),
        "{refused}"
    );
}

/// Checkpoints store positions by name.
#[test]
fn names_of_streams_differ() {
    let mut names: Vec<&str> = STREAMS.iter().map(|kind| kind.name).collect();
    names.sort_unstable();
    let count = names.len();
    names.dedup();
    assert_eq!(names.len(), count);
    assert!(!names.iter().any(|name| name.starts_with("fields.")));
}

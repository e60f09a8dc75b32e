//! Broken surfaces end in a clear message or in a stated repair, never in a number that is silently wrong.

use crate::common::*;
use glam::DVec3;
use mclump::inertia::surface::integrate;
use mclump::surface::{SurfaceError, inspect, prepare};
use mercury_common::formats::mesh::{TriangleMesh, push_binary_stl, read_mesh};
use proptest::prelude::*;

fn cube() -> TriangleMesh {
    cuboid(DVec3::splat(0.5))
}

fn volume(mesh: &TriangleMesh) -> f64 {
    integrate(mesh).unwrap().volume
}

#[test]
fn a_sound_surface_is_reported_as_such() {
    let report = inspect(&cube());
    assert!(report.is_sound() && report.is_closed() && report.is_manifold());
    assert_eq!(report.edges, 18);
    assert_eq!(
        report.to_string(),
        "12 triangles, 8 vertices (0 corners merged), 18 edges\nclosed: yes\nmanifold: yes\n\
         consistently oriented: yes\nshells: 1; self-intersection: not checked"
    );
    // Euler: vertices - edges + triangles is 0 for a torus, 2 for what is like a sphere.
    let ring = inspect(&torus(2.0, 0.5, 8));
    assert_eq!(ring.vertices + ring.triangles, ring.edges);
    assert_eq!(report.vertices + report.triangles, report.edges + 2);
}

#[test]
fn a_missing_triangle_is_refused_by_its_edges_and_closed_by_repair() {
    let mut open = cube();
    open.triangles.pop();
    let error = prepare(open.clone(), false).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the surface is not closed, so it encloses no defined volume:\n  3 edges with one triangle only (a hole):\n\
         \x20   (-0.5, -0.5, 0.5) - (-0.5, 0.5, 0.5)\n    (-0.5, -0.5, 0.5) - (0.5, 0.5, 0.5)\n    (-0.5, 0.5, 0.5) - (0.5, 0.5, 0.5)\n\
         help: --repair welds vertices, drops doubled triangles, turns inconsistent ones and closes small holes; or take \
         --inertia union with pebbles, which needs no closed surface"
    );
    let repaired = prepare(open, true).unwrap();
    assert_eq!(repaired.done, ["1 hole closed, 5.00e-1 m2 of 5.50e0 m2"]);
    assert_close(volume(&repaired.mesh), 1.0, 1e-14, "volume");
}

#[test]
fn a_large_hole_is_not_guessed() {
    let mut open = cube();
    // A whole face, a fifth of what is left.
    open.triangles.truncate(10);
    let error = prepare(open, true).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("also after the repair"), "{text}");
    assert!(text.contains("4 edges with one triangle only"), "{text}");
    assert!(text.contains("holes of up to 10 %"), "{text}");
}

#[test]
fn a_flipped_triangle_is_refused_and_turned_by_repair() {
    let mut wrong = cube();
    wrong.triangles[3].swap(0, 1);
    let text = prepare(wrong.clone(), false).unwrap_err().to_string();
    assert!(
        text.contains(
            "3 edges whose two triangles disagree on which side is outside:\n    (0.5, -0.5, -0.5)"
        ),
        "{text}"
    );
    let repaired = prepare(wrong, true).unwrap();
    assert_eq!(
        repaired.done,
        ["1 triangle turned to agree with the neighbours"]
    );
    assert_close(volume(&repaired.mesh), 1.0, 1e-14, "volume");
}

#[test]
fn doubled_and_collapsed_triangles_are_dropped_by_repair() {
    let mut wrong = cube();
    wrong.triangles.push(wrong.triangles[5]);
    wrong.triangles.push([2, 2, 7]);
    let report = inspect(&wrong);
    assert_eq!(
        (report.duplicates.clone(), report.collapsed.clone()),
        (vec![12], vec![13])
    );
    let text = prepare(wrong.clone(), false).unwrap_err().to_string();
    assert!(
        text.contains("3 edges with more than two triangles that do not pair up"),
        "{text}"
    );
    assert!(
        text.contains("1 triangle standing twice (number 13)"),
        "{text}"
    );
    let repaired = prepare(wrong, true).unwrap();
    assert_eq!(
        repaired.done,
        [
            "1 triangle with equal corners dropped",
            "1 triangle standing twice dropped"
        ]
    );
    assert_close(volume(&repaired.mesh), 1.0, 1e-14, "volume");
}

#[test]
fn collapsed_triangles_alone_do_no_harm() {
    let mut mesh = cube();
    mesh.triangles.push([2, 2, 7]);
    assert_close(
        volume(&prepare(mesh, false).unwrap().mesh),
        1.0,
        1e-14,
        "volume",
    );
}

#[test]
fn an_inward_surface_is_turned_round_with_a_word() {
    let prepared = prepare(turned_round(&cube()), false).unwrap();
    assert_eq!(
        prepared.done,
        ["the surface was turned inward (its volume was negative): it is turned round"]
    );
    assert_close(volume(&prepared.mesh), 1.0, 1e-14, "volume");
}

#[test]
fn a_cavity_counts_as_one_if_it_is_turned_inward() {
    let small = mapped(&cube(), |v| 0.5 * v + DVec3::splat(0.1));
    let hollow = together(&cube(), &turned_round(&small));
    let prepared = prepare(hollow, false).unwrap();
    assert_eq!(
        (prepared.report.shells.len(), prepared.report.cavities()),
        (2, 1)
    );
    assert!(prepared.done.is_empty() && prepared.warnings.is_empty());
    assert_close(volume(&prepared.mesh), 1.0 - 0.125, 1e-14, "volume");
    // Turned outward it is a mistake or a doubled part: reported, and turned by repair only.
    let doubtful = together(&cube(), &small);
    let prepared = prepare(doubtful.clone(), false).unwrap();
    assert_eq!(prepared.warnings.len(), 1, "{:?}", prepared.warnings);
    assert!(
        prepared.warnings[0]
            .contains("shell 2 (12 triangles) lies inside another one and is turned outward")
    );
    let prepared = prepare(doubtful, true).unwrap();
    assert_eq!(
        prepared.done,
        ["1 shell of 2 turned round (0 inward, 1 cavities outward)"]
    );
    assert_close(volume(&prepared.mesh), 1.0 - 0.125, 1e-14, "volume");
}

#[test]
fn separate_parts_are_one_body_with_a_word_and_inward_parts_are_turned() {
    let far = mapped(&turned_round(&cube()), |v| v + DVec3::new(3.0, 0.0, 0.0));
    let prepared = prepare(together(&cube(), &far), false).unwrap();
    assert_eq!(
        prepared.done,
        ["1 shell of 2 turned round (1 inward, 0 cavities outward)"]
    );
    assert!(
        prepared.warnings[0].contains("2 separate parts"),
        "{:?}",
        prepared.warnings
    );
    assert_close(volume(&prepared.mesh), 2.0, 1e-14, "volume");
}

#[test]
fn sheets_and_bad_corners_are_refused() {
    let fold = mesh(
        vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        vec![[0, 1, 2], [0, 2, 1]],
    );
    assert!(matches!(
        prepare(fold, false),
        Err(SurfaceError::NoVolume { .. })
    ));
    let mut bad = cube();
    bad.vertices[3].y = f64::NAN;
    assert_eq!(
        prepare(bad.clone(), true).unwrap_err().to_string(),
        "triangle 1 has a corner that is not a finite point: the mesh is damaged".replace(
            "triangle 1 ",
            &format!(
                "triangle {} ",
                1 + bad.triangles.iter().position(|t| t.contains(&3)).unwrap()
            )
        )
    );
    let empty = TriangleMesh::default();
    assert!(prepare(empty, false).is_err());
}

#[test]
fn a_moebius_band_cannot_be_oriented() {
    // Five triangles around, half turned.
    let band = mesh(
        (0..5)
            .map(|i| {
                let t = f64::from(i);
                DVec3::new(t.cos(), t.sin(), 0.3 * f64::from(i % 2))
            })
            .collect(),
        (0..5u32).map(|i| [i, (i + 1) % 5, (i + 2) % 5]).collect(),
    );
    assert!(matches!(
        prepare(band, true),
        Err(SurfaceError::NotClosed(_))
    ));
}

#[test]
fn seams_within_single_precision_are_welded_by_repair() {
    // Every triangle with corners of its own, moved by some 1e-8.
    let whole = cube();
    let mut loose = TriangleMesh::default();
    for index in 0..whole.triangles.len() {
        let corners = whole.corners(index);
        let first = loose.vertices.len() as u32;
        loose
            .vertices
            .extend(corners.map(|c| c + DVec3::splat(1e-8 * index as f64)));
        loose.triangles.push([first, first + 1, first + 2]);
    }
    assert!(prepare(loose.clone(), false).is_err());
    let repaired = prepare(loose, true).unwrap();
    assert_eq!(
        repaired.done,
        ["28 vertices nearer than 1.7e-6 m to another one merged"]
    );
    assert_close(volume(&repaired.mesh), 1.0, 1e-6, "volume");
}

#[test]
fn the_torture_surfaces_are_refused_with_their_edges() {
    let Some(folder) = shared("data/shapes/mesh") else {
        return;
    };
    for name in ["Screw.stl", "MembraneDemo.stl", "MembraneSelfTest.stl"] {
        let mesh = read_mesh(folder.join(name)).unwrap();
        for repair in [false, true] {
            match prepare(mesh.clone(), repair) {
                Err(error) => {
                    let text = error.to_string();
                    assert!(text.contains("the surface is not closed"), "{name}: {text}");
                    assert!(text.contains("edge"), "{name}: {text}");
                }
                Ok(prepared) => {
                    // Only a reported repair may make it closed.
                    assert!(repair && !prepared.done.is_empty(), "{name}");
                    assert!(prepared.report.is_closed(), "{name}");
                }
            }
        }
    }
}

#[test]
fn thousands_of_loose_triangles_are_refused_at_once() {
    // As many shells as triangles: comparing all with all would take minutes.
    let mut loose = torus(2.0, 0.5, 200);
    loose.triangles = loose.triangles.into_iter().step_by(2).collect();
    let begin = std::time::Instant::now();
    assert!(prepare(loose, false).is_err());
    assert!(begin.elapsed().as_secs() < 5);
}

#[test]
fn a_closed_surface_whose_parts_share_edges_is_taken_with_a_word() {
    // Each of four edges belongs to four triangles, but is passed as often in both directions: the inside is defined.
    let Some(path) = shared("data/shapes/mesh/Casing.stl") else {
        return;
    };
    let prepared = prepare(read_mesh(path).unwrap(), false).unwrap();
    assert!(prepared.report.is_closed() && !prepared.report.is_manifold());
    assert_eq!(
        prepared.warnings,
        ["4 edges belong to more than two triangles: parts touch or overlap there"]
    );
}

#[test]
fn single_precision_files_keep_their_polyhedron() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("torus.stl");
    let mut bytes = Vec::new();
    push_binary_stl(&torus(2.0, 0.5, 24), &mut bytes).unwrap();
    std::fs::write(&path, bytes).unwrap();
    let prepared = prepare(read_mesh(&path).unwrap(), false).unwrap();
    assert!(prepared.report.is_sound());
    // Each coordinate is off by at most 6e-8 relative.
    assert_close(
        volume(&prepared.mesh),
        volume(&torus(2.0, 0.5, 24)),
        1e-6,
        "volume",
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Whatever few triangles are lost, turned or doubled: refused without repair; with it either refused or right.
    #[test]
    fn damage_never_gives_a_wrong_number(
        lost in prop::collection::btree_set(0usize..128, 0..3),
        turned in prop::collection::btree_set(0usize..128, 0..4),
        doubled in prop::collection::btree_set(0usize..128, 0..3),
    ) {
        let good = sphere(2);
        let mut bad = good.clone();
        for &index in &turned {
            bad.triangles[index].swap(1, 2);
        }
        for &index in &doubled {
            bad.triangles.push(bad.triangles[index]);
        }
        let mut index = 0;
        bad.triangles.retain(|_| { index += 1; !lost.contains(&(index - 1)) });
        let unharmed = turned.is_empty() && doubled.iter().all(|d| lost.contains(d)) && lost.iter().all(|l| doubled.contains(l));
        if !unharmed {
            prop_assert!(prepare(bad.clone(), false).is_err());
        }
        if let Ok(repaired) = prepare(bad, true) {
            // A patch cuts off the bulge of the missing triangles: three of 128 at most.
            prop_assert!((volume(&repaired.mesh) / volume(&good) - 1.0).abs() < 0.02);
        }
    }
}

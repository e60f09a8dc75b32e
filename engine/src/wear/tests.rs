//! Moves of worn surfaces: volumes to round-off, limits, thin bodies, periodic faces, and the same numbers after a restore.

use glam::{DVec3, dvec3};
use mercury_common::formats::mesh::TriangleMesh;
use mercury_common::random::Stream;
use proptest::prelude::*;

use super::{WearBasis, WearLaw, WearPlan, Worn};
use crate::forces::{Impact, Rub};
use crate::walls::{Mesh, Touches};

/// Archard's law with K/H = 1, so that load times way is the volume.
fn plan() -> WearPlan {
    WearPlan {
        wall: 0,
        law: WearLaw::Archard {
            rate: 1.0,
            basis: WearBasis::NormalLoad,
        },
        acceleration: 1.0,
        moves: true,
        step: 1e-3,
        smoothing: 0.0,
        until_depth: f64::INFINITY,
    }
}

fn mesh(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> Mesh {
    let mesh = TriangleMesh {
        vertices: vertices.iter().copied().map(DVec3::from).collect(),
        triangles: triangles.to_vec(),
        ..TriangleMesh::default()
    };
    Mesh::new(&mesh, |x| x, false).unwrap()
}

/// A unit square of `cells` by `cells` cells at z = 0, normals along z.
fn square(cells: u32) -> Mesh {
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    for j in 0..=cells {
        for i in 0..=cells {
            let at = |k: u32| f64::from(k) / f64::from(cells);
            vertices.push([at(i), at(j), 0.0]);
        }
    }
    for j in 0..cells {
        for i in 0..cells {
            let a = j * (cells + 1) + i;
            let [b, c, d] = [a + 1, a + cells + 2, a + cells + 1];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh(&vertices, &triangles)
}

/// A box of these sides, each face of two triangles, normals outwards.
fn slab(sides: [f64; 3]) -> Mesh {
    let corner =
        |k: usize| [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { sides[axis] } else { 0.0 });
    let vertices: Vec<[f64; 3]> = (0..8).map(corner).collect();
    let mut triangles = Vec::new();
    for [a, b, c, d] in [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ] {
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    mesh(&vertices, &triangles)
}

/// Rub of a small ball at `centre`, worn by `volume`.
fn rub(mesh: &Mesh, centre: DVec3, volume: f64) -> Rub {
    let mut touches = Touches::default();
    mesh.touches(centre, 1.0, &mut touches);
    let nearest = touches
        .iter()
        .min_by(|a, b| a.distance.total_cmp(&b.distance))
        .unwrap();
    Rub {
        wall: 0,
        feature: nearest.feature,
        foot: centre - nearest.normal * nearest.distance,
        normal: nearest.normal,
        load: volume,
        way: 1.0,
        slip: 1.0,
        work: volume,
        impact: None,
    }
}

/// Notes a contact, and moves the surface where it is due.
fn wear(worn: &mut Worn, mesh: &mut Mesh, centre: DVec3, volume: f64) {
    worn.note(&rub(mesh, centre, volume), mesh);
    if worn.is_due() {
        follow(worn, mesh);
    }
}

fn follow(worn: &mut Worn, mesh: &mut Mesh) {
    worn.advance(mesh);
    mesh.reshape(&worn.corners()).unwrap();
    worn.find_worn_through(mesh);
}

/// Volume of a closed mesh.
fn volume_of(mesh: &Mesh) -> f64 {
    let corners = mesh.corners();
    let of = |t: [u32; 3]| {
        let [a, b, c] = t.map(|k| corners[k as usize]);
        a.dot(b.cross(c)) / 6.0
    };
    mesh.triangles().into_iter().map(of).sum()
}

proptest! {
    /// Whatever wears a box, on faces, edges and corners: what was owed is what is gone, and what waits is the rest.
    #[test]
    fn what_is_owed_is_what_is_gone(
        seed in 0u64..1000,
        contacts in 1usize..60,
        smoothing in 0.0f64..1.0,
        step in 1e-4f64..0.1,
    ) {
        let mut mesh = slab([1.0, 0.8, 0.6]);
        let whole = volume_of(&mesh);
        let mut worn = Worn::new(WearPlan { smoothing, step, ..plan() }, &mesh);
        let mut random = Stream::new(seed, "wear", 0);
        for _ in 0..contacts {
            let place = dvec3(random.uniform(), random.uniform(), random.uniform());
            let centre = (place * 1.4 - 0.2) * dvec3(1.0, 0.8, 0.6);
            let inside = centre.cmpgt(DVec3::ZERO).all() && centre.cmplt(dvec3(1.0, 0.8, 0.6)).all();
            if !inside {
                wear(&mut worn, &mut mesh, centre, 1e-3 * random.uniform());
            }
        }
        follow(&mut worn, &mut mesh);
        let row = worn.row();
        let waiting: f64 = worn.vertices().map(|vertex| vertex.owed).sum();
        prop_assert!((row.owed - row.removed - waiting).abs() <= 1e-12 * row.owed.max(1e-12));
        prop_assert!((row.pending - waiting).abs() <= 1e-12 * row.owed.max(1e-12));
        prop_assert!((whole - volume_of(&mesh) - row.removed).abs() < 1e-13);
        let of_triangles: f64 = worn.triangles().map(|(_, _, removed)| removed).sum();
        prop_assert!((of_triangles - row.removed).abs() <= 1e-12 * row.removed.abs() + 1e-18);
        let owed: f64 = worn.triangles().map(|(_, owed, _)| owed).sum();
        prop_assert!((owed - row.owed).abs() <= 1e-12 * row.owed);
    }

    /// A run that goes on from what was saved moves to the same bits.
    #[test]
    fn what_was_saved_goes_on_to_the_same_bits(seed in 0u64..1000, contacts in 1usize..40) {
        let mut mesh = square(6);
        let mut wears = Worn::new(plan(), &mesh);
        let mut random = Stream::new(seed, "saved", 0);
        let mut contact = |worn: &mut Worn, mesh: &mut Mesh| {
            let centre = dvec3(random.uniform(), random.uniform(), 0.1);
            wear(worn, mesh, centre, 1e-6 * random.uniform());
        };
        for _ in 0..contacts {
            contact(&mut wears, &mut mesh);
        }
        let mut bytes = Vec::new();
        crate::state::Plain::put(&wears.save(), &mut bytes);
        let saved = crate::state::Plain::take(&mut bytes.as_slice()).unwrap();
        let mut again = Worn::new(plan(), &square(6));
        again.restore(&saved).unwrap();
        let mut again_mesh = mesh.clone();
        let mut other = Stream::new(seed + 1, "saved", 0);
        for _ in 0..20 {
            let centre = dvec3(other.uniform(), other.uniform(), 0.1);
            let volume = 1e-6 * other.uniform();
            wear(&mut wears, &mut mesh, centre, volume);
            wear(&mut again, &mut again_mesh, centre, volume);
        }
        prop_assert_eq!(wears.save(), again.save());
        prop_assert_eq!(wears.corners(), again.corners());
        prop_assert_eq!(wears.row(), again.row());
    }
}

/// On a plate d = V/(A/3), along the normal, by the weights of the nearest point.
#[test]
fn a_plate_moves_down_by_what_each_vertex_owes() {
    let mut mesh = square(4);
    let mut worn = Worn::new(plan(), &mesh);
    let (cell, volume) = (0.25, 1e-8);
    // Above the middle of a triangle.
    let centre = dvec3(0.25 + 2.0 * cell / 3.0, 0.25 + cell / 3.0, 0.1);
    wear(&mut worn, &mut mesh, centre, volume);
    follow(&mut worn, &mut mesh);
    let moved: Vec<_> = worn.vertices().collect();
    assert_eq!(moved.len(), 3);
    for vertex in moved {
        // Six triangles around each inner vertex.
        let expected = volume / 3.0 / (6.0 * 0.5 * cell * cell / 3.0);
        assert!((vertex.depth / expected - 1.0).abs() < 1e-6, "{vertex:?}");
        assert_eq!(vertex.displacement.truncate(), glam::DVec2::ZERO);
        assert_eq!(vertex.owed, 0.0);
    }
}

/// The surface moves when a vertex would go by more than `step` of its edge, and not before.
#[test]
fn moves_wait_for_the_step() {
    let mut mesh = square(4);
    let mut worn = Worn::new(plan(), &mesh);
    let area = 6.0 * 0.5 * 0.0625;
    let limit = 1e-3 * 0.25 * area / 3.0;
    let centre = dvec3(0.5, 0.5, 0.1);
    for part in [0.4, 0.4] {
        worn.note(&rub(&mesh, centre, part * limit), &mesh);
        assert!(!worn.is_due());
    }
    wear(&mut worn, &mut mesh, centre, 0.3 * limit);
    let row = worn.row();
    assert_eq!(row.moves, 1);
    assert!(
        (row.max_depth / (1.1e-3 * 0.25) - 1.0).abs() < 1e-5,
        "{row:?}"
    );
    assert_eq!(row.place, dvec3(0.5, 0.5, 0.0));
}

/// A pit gets no deeper than triangles may turn; neighbours take what it cannot, and what remains is pending, never lost.
#[test]
fn what_cannot_be_placed_is_pending() {
    let mut mesh = square(4);
    let mut worn = Worn::new(
        WearPlan {
            step: 0.1,
            ..plan()
        },
        &mesh,
    );
    for _ in 0..400 {
        wear(&mut worn, &mut mesh, dvec3(0.5, 0.5, 0.1), 2e-3);
    }
    follow(&mut worn, &mut mesh);
    let row = worn.row();
    assert!(row.blocked > 0 && row.pending > 0.0, "{row:?}");
    assert!((row.owed - 0.8).abs() < 1e-12);
    assert!((row.removed + row.pending - row.owed).abs() < 1e-12);
    let waiting: f64 = worn.vertices().map(|vertex| vertex.owed).sum();
    assert!((waiting - row.pending).abs() < 1e-12, "{waiting} {row:?}");
    let corners = mesh.corners();
    for triangle in mesh.triangles() {
        let [a, b, c] = triangle.map(|k| corners[k as usize]);
        let normal = (b - a).cross(c - a);
        assert!(
            normal.z >= 0.5 * normal.length() * (1.0 - 1e-12),
            "it has turned by more than 60 degrees"
        );
    }
}

/// Two squares, one 0.02 below the other and turned over, joined by nothing.
fn thin_plate() -> Mesh {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    const CELLS: u32 = 4;
    for z in [0.0, -0.02] {
        for j in 0..=CELLS {
            for i in 0..=CELLS {
                vertices.push([f64::from(i) / 4.0, f64::from(j) / 4.0, z]);
            }
        }
    }
    for (first, turned) in [(0, false), ((CELLS + 1) * (CELLS + 1), true)] {
        for j in 0..CELLS {
            for i in 0..CELLS {
                let a = first + j * (CELLS + 1) + i;
                let [b, c, d] = [a + 1, a + CELLS + 2, a + CELLS + 1];
                let pair = if turned {
                    [[a, c, b], [a, d, c]]
                } else {
                    [[a, b, c], [a, c, d]]
                };
                triangles.extend(pair);
            }
        }
    }
    mesh(&vertices, &triangles)
}

/// A thin plate is worn until its faces meet; there it stays.
#[test]
fn faces_that_meet_are_worn_through() {
    let mut mesh = thin_plate();
    let mut worn = Worn::new(plan(), &mesh);
    let mut count = 0;
    while worn.worn_through().is_none() {
        wear(&mut worn, &mut mesh, dvec3(0.5, 0.5, 0.1), 1e-5);
        count += 1;
        assert!(count < 10_000);
    }
    let row = worn.row();
    // To a thousandth of an edge, and no farther than the other face.
    assert!(
        row.max_depth > 0.02 - 1e-3 && row.max_depth < 0.02,
        "{row:?}"
    );
    let place = worn.worn_through().unwrap().place;
    assert!(place.distance(dvec3(0.5, 0.5, -0.02)) < 0.3, "{place}");
    for _ in 0..100 {
        wear(&mut worn, &mut mesh, dvec3(0.5, 0.5, 0.1), 1e-5);
    }
    follow(&mut worn, &mut mesh);
    let after = worn.row();
    assert_eq!(after.max_depth, row.max_depth);
    assert!(after.pending > 0.0 && (after.owed - after.removed - after.pending).abs() < 1e-15);
}

/// Moves that are longer than the plate is thick pass no face: the upper one goes no farther than the lower one, to what counts as met.
#[test]
fn large_moves_pass_no_face() {
    let mut mesh = thin_plate();
    let mut worn = Worn::new(plan(), &mesh);
    let mut random = Stream::new(7, "thin", 0);
    // Alone, a move of a vertex with six triangles of 1/32 m^2 would be 3 V/(6/32) = 0.03 m.
    for _ in 0..300 {
        let centre = dvec3(random.uniform(), random.uniform(), 0.1);
        wear(&mut worn, &mut mesh, centre, 0.03 * 6.0 / 32.0 / 3.0);
    }
    let row = worn.row();
    let thin = 1e-3 * 0.25 * 2.0f64.sqrt();
    assert!(worn.worn_through().is_some());
    assert!(row.max_depth < 0.02 + thin, "{row:?}");
    assert!((row.owed - row.removed - row.pending).abs() < 1e-12 * row.owed);
}

/// A sheet that is worn on both sides moves by the difference, and both depths are reported; worn behind alone, its depth counts
/// there.
#[test]
fn sides_are_told_apart() {
    let mut mesh = square(4);
    let mut worn = Worn::new(plan(), &mesh);
    wear(&mut worn, &mut mesh, dvec3(0.3, 0.4, 0.1), 3e-4);
    wear(&mut worn, &mut mesh, dvec3(0.7, 0.6, -0.1), 1e-4);
    follow(&mut worn, &mut mesh);
    let row = worn.row();
    assert_eq!((row.front, row.back), (3e-4, 1e-4));
    assert!((row.removed - 2e-4).abs() < 1e-15 && row.pending.abs() < 1e-15);
    let mut mesh = square(4);
    let mut worn = Worn::new(plan(), &mesh);
    wear(&mut worn, &mut mesh, dvec3(0.7, 0.6, -0.1), 1e-4);
    follow(&mut worn, &mut mesh);
    let row = worn.row();
    assert!((row.removed - 1e-4).abs() < 1e-15 && row.max_depth > 0.0);
    assert!(
        worn.vertices()
            .all(|vertex| vertex.displacement.z > 0.0 && vertex.depth > 0.0)
    );
}

/// A wear map has depths and no displacement; with `until_depth` it is worn at that depth.
#[test]
fn a_map_does_not_move() {
    let mut mesh = square(4);
    let area = 6.0 * 0.5 * 0.0625;
    let mut worn = Worn::new(
        WearPlan {
            moves: false,
            until_depth: 0.01,
            ..plan()
        },
        &mesh,
    );
    for k in 1..=10 {
        assert!(!worn.is_worn());
        wear(
            &mut worn,
            &mut mesh,
            dvec3(0.5, 0.5, 0.1),
            1.001e-3 * area / 3.0,
        );
        let row = worn.row();
        assert!(
            (row.max_depth - 1.001e-3 * f64::from(k)).abs() < 1e-15,
            "{row:?}"
        );
        assert_eq!((row.removed, row.moves), (0.0, 0));
        assert_eq!(row.pending, row.owed);
    }
    assert!(worn.is_worn());
    assert_eq!(mesh, square(4));
}

/// With moves the run ends at the step that takes a vertex to the depth.
#[test]
fn a_surface_is_worn_at_its_depth() {
    let mut mesh = square(4);
    let mut worn = Worn::new(
        WearPlan {
            until_depth: 2e-3,
            ..plan()
        },
        &mesh,
    );
    let mut before = 0.0;
    while !worn.is_worn() {
        before = worn.row().max_depth;
        wear(&mut worn, &mut mesh, dvec3(0.5, 0.5, 0.1), 1e-7);
    }
    let depth = worn.row().max_depth;
    assert!(
        before < 2e-3 && (2e-3..2.01e-3).contains(&depth),
        "{before} {depth}"
    );
}

/// The two faces of a period move alike, though contacts are at one of them alone.
#[test]
fn a_periodic_mesh_stays_periodic() {
    let mut mesh = square(4).continued(&[(0, 0.0, 1.0)], 0.2).unwrap();
    let mut worn = Worn::new(plan(), &mesh);
    wear(&mut worn, &mut mesh, dvec3(0.99, 0.5, 0.1), 1e-4);
    // By its copy beyond the face.
    wear(&mut worn, &mut mesh, dvec3(1.01, 0.5, 0.1), 1e-4);
    follow(&mut worn, &mut mesh);
    let depth = |x: f64| {
        let found = worn.vertices().find(|v| v.first == dvec3(x, 0.5, 0.0));
        found.map_or(0.0, |vertex| vertex.depth)
    };
    assert!(depth(0.0) > 0.0);
    assert_eq!(depth(0.0), depth(1.0));
    let row = worn.row();
    assert!((row.removed - 2e-4).abs() < 1e-16 && (row.owed - 2e-4).abs() < 1e-16);
}

/// Corners of a file that does not share them stay together.
#[test]
fn corners_at_one_place_move_alike() {
    let mut mesh = mesh(
        &[
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 0.0, -0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
        ],
        &[[0, 1, 2], [3, 4, 5]],
    );
    let mut worn = Worn::new(plan(), &mesh);
    wear(&mut worn, &mut mesh, dvec3(0.9, 0.8, 0.1), 1e-4);
    follow(&mut worn, &mut mesh);
    let ways: Vec<DVec3> = worn
        .vertices()
        .filter(|v| v.first == dvec3(1.0, 1.0, 0.0))
        .map(|v| v.displacement)
        .collect();
    assert_eq!(ways.len(), 2);
    assert_eq!(ways[0], ways[1]);
    assert!(ways[0].z < 0.0);
}

/// The limits of the laws: nothing at grazing and straight incidence by Finnie, E90 at straight incidence by Oka, and nothing where nothing arrives.
#[test]
fn laws_of_erosion_at_their_limits() {
    let impact = |degrees: f64, speed: f64| Impact {
        mass: 2.0,
        diameter: 326e-6,
        speed,
        approach: speed * degrees.to_radians().sin(),
    };
    let finnie = WearLaw::Finnie { constant: 0.5 };
    assert_eq!(finnie.eroded(&impact(0.0, 3.0)), 0.0);
    assert!(finnie.eroded(&impact(90.0, 3.0)) < 1e-15);
    // The branches meet where tan a = 1/3: sin 2a - 3 sin^2 a = 0.6 - 0.3, cos^2 a / 3 = 0.3.
    for side in [-1e-9, 1e-9] {
        let angle = (1.0f64 / 3.0).atan().to_degrees() + side;
        let volume = finnie.eroded(&impact(angle, 3.0));
        assert!((volume - 0.5 * 2.0 * 9.0 * 0.3).abs() < 1e-8);
    }
    let oka = WearLaw::Oka {
        hardness: 1.2,
        erosion: 65e-9,
        speed: 104.0,
        diameter: 326e-6,
        speed_exponent: 2.35,
        diameter_exponent: 0.19,
        n1: 0.8,
        n2: 1.3,
    };
    assert!((oka.eroded(&impact(90.0, 104.0)) / 130e-9 - 1.0).abs() < 1e-12);
    for law in [finnie, oka] {
        let away = Impact {
            approach: -1.0,
            ..impact(45.0, 3.0)
        };
        assert_eq!(law.eroded(&away), 0.0);
        assert_eq!(law.eroded(&impact(0.0, 0.0)), 0.0);
    }
}

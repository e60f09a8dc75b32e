//! Mesh walls: what a tessellated plane, box and cylinder feel like.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DQuat, DVec3};
use mercury_common::formats::mesh::TriangleMesh;
use mercury_common::random::Stream;
use proptest::prelude::*;

use super::touches;
use crate::walls::{
    LeftOut, Mesh, NearMeshes, Pose, SMOOTH_ANGLE, Scratch, Shape, Touches, WallError,
};

fn mesh(vertices: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> TriangleMesh {
    TriangleMesh {
        vertices,
        triangles,
        ..TriangleMesh::default()
    }
}

fn shape(triangles: &TriangleMesh, front: bool) -> Shape {
    Shape::Mesh(Arc::new(Mesh::new(triangles, |x| x, front).unwrap()))
}

/// A random triangulation of the square from -1 to 1 in the plane z = 0: triangles are split at random places, at a point
/// inside or, with both neighbours, on an edge. `junctions`: sometimes only one of the neighbours is split.
fn square(seed: u64, splits: usize, junctions: bool) -> TriangleMesh {
    let mut random = Stream::new(seed, "square", 0);
    let mut vertices: Vec<DVec3> = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
        .map(|[x, y]| DVec3::new(x, y, 0.0))
        .into();
    let mut triangles = vec![[0, 1, 2], [0, 2, 3]];
    for _ in 0..splits {
        let index = (random.uniform() * triangles.len() as f64) as usize;
        let [a, b, c]: [u32; 3] = triangles[index];
        let new = vertices.len() as u32;
        let at = |k: u32| vertices[k as usize];
        if random.uniform() < 0.5 {
            let (u, v) = (random.uniform(), random.uniform());
            let (u, v) = if u + v > 1.0 {
                (1.0 - u, 1.0 - v)
            } else {
                (u, v)
            };
            vertices.push(at(a) + u * (at(b) - at(a)) + v * (at(c) - at(a)));
            triangles[index] = [a, b, new];
            triangles.extend([[b, c, new], [c, a, new]]);
        } else {
            // Slivers come from places near the ends; splits of splits are thinner than 1e-6.
            let place = at(a) + (0.001 + 0.998 * random.uniform().powi(2)) * (at(b) - at(a));
            vertices.push(place);
            let alone = junctions && random.uniform() < 0.5;
            for k in 0..triangles.len() {
                let [p, q, r] = triangles[k];
                for [p, q, r] in [[p, q, r], [q, r, p], [r, p, q]] {
                    if (p, q) == (a, b) || (!alone && (p, q) == (b, a)) {
                        triangles[k] = [p, new, r];
                        triangles.push([new, q, r]);
                    }
                }
            }
        }
    }
    mesh(vertices, triangles)
}

fn turned(triangles: &TriangleMesh, turn: DQuat, shift: DVec3) -> TriangleMesh {
    let mut out = triangles.clone();
    for vertex in &mut out.vertices {
        *vertex = turn * *vertex + shift;
    }
    out
}

fn any_turn() -> impl Strategy<Value = DQuat> {
    prop::array::uniform3(-3.0..3.0f64).prop_map(|v| DQuat::from_scaled_axis(v.into()))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Over any triangulation of a plane, in any direction, there is one contact with the plane's distance and normal: over
    /// faces, exactly over edges and corners, and on both sides.
    #[test]
    fn a_tessellated_plane_is_a_plane(
        seed in any::<u64>(),
        splits in 0usize..60,
        junctions in any::<bool>(),
        turn in any_turn(),
        shift in prop::array::uniform3(-2.0..2.0f64),
        height in prop_oneof![0.02..0.2f64, -0.2..-0.02f64],
        depth in 1e-6..0.3f64,
    ) {
        let shift = DVec3::from(shift);
        let flat = square(seed, splits, junctions);
        let wall = shape(&turned(&flat, turn, shift), false);
        let mut random = Stream::new(seed, "places", 0);
        let radius = height.abs() * (1.0 + depth);
        let mut places = Vec::new();
        for triangle in 0..flat.triangles.len() {
            let [a, b, c] = flat.corners(triangle);
            let (u, v) = (random.uniform(), random.uniform());
            places.extend([a, a + u * (b - a), a + u * (1.0 - v) * (b - a) + v * (c - a)]);
        }
        for place in places {
            // At the rim of the square the wall ends.
            if place.x.abs().max(place.y.abs()) < 1.0 {
                let centre = turn * (place + DVec3::Z * height) + shift;
                let found = touches(&wall, centre, radius);
                prop_assert_eq!(found.len(), 1, "at {} of {:?}: {:?}", place, flat, found);
                let normal = turn * DVec3::Z * height.signum();
                prop_assert!((found[0].distance - height.abs()).abs() < 1e-13);
                // Exact to 1e-13 but for slivers: round-off of 2e-16 turns those of height 1e-9, above which they are kept, by 1e-7,
                // and a crack of that width puts the foot on its rim.
                let limit = 1e-6 + 1e-8 / height.abs();
                prop_assert!((found[0].normal - normal).length() < limit, "{:?}", found[0]);
            }
        }
    }

    /// Contacts by lists that go on from place to place are those of fresh queries and those of all facets, bit by bit.
    #[test]
    fn lists_give_the_same_as_queries(
        seed in any::<u64>(),
        count in 1usize..60,
        centre in prop::array::uniform3(-1.0..1.0f64),
        step in 0.001..0.2f64,
        reach in 0.05..0.5f64,
    ) {
        let Ok(wall) = Mesh::new(&soup(seed, count), |x| x, seed.is_multiple_of(2)) else { return Ok(()) };
        lists_and_queries_agree(&wall, seed, centre.into(), step * reach, reach)?;
    }

    /// Lists give the touches of queries on a fine wavy sheet, where patches are large and lists are long.
    #[test]
    fn lists_give_the_same_as_queries_on_fine_meshes(
        seed in any::<u64>(),
        cells in 2usize..40,
        waves in 0.0..0.3f64,
        place in prop::array::uniform2(-0.8..0.8f64),
        height in -0.9..0.9f64,
        step in 0.0001..0.1f64,
        reach in 0.05..0.5f64,
        single in any::<bool>(),
    ) {
        let mut triangles = sheet(cells, waves);
        if single {
            // As in a binary STL: normals are then steadied.
            for vertex in &mut triangles.vertices {
                *vertex = (*vertex * 0.9).as_vec3().as_dvec3();
            }
        }
        let wall = Mesh::new(&triangles, |x| x, false).unwrap();
        let centre = DVec3::new(place[0], place[1], height * reach);
        lists_and_queries_agree(&wall, seed, centre, step * reach, reach)?;
    }

    /// Patches save time and change nothing: the contacts are those of a mesh of which every facet counts by itself.
    #[test]
    fn patches_change_no_contact(
        cells in 2usize..40,
        waves in 0.0..0.3f64,
        place in prop::array::uniform2(-1.1..1.1f64),
        height in -1.0..1.0f64,
        reach in 0.05..0.5f64,
        box_too in any::<bool>(),
    ) {
        let mut triangles = sheet(cells, waves);
        if box_too {
            // A fine box: corners and edges from inside and outside.
            triangles = fine_cube(cells.min(12));
        }
        let wall = Mesh::new(&triangles, |x| x, false).unwrap();
        let apart = wall.without_patches();
        let [x, y] = place;
        let base = if box_too { 1.0 } else { waves * (4.0 * x).sin() };
        let centre = DVec3::new(x, y, base + height * reach);
        let (mut one, mut other) = (Touches::new(), Touches::new());
        wall.touches(centre, reach, &mut one);
        apart.touches(centre, reach, &mut other);
        prop_assert_eq!(one.as_slice(), other.as_slice());
    }

    /// The test that no place nearby is near a mesh is never wrong about any of these places, also where it covers too much.
    #[test]
    fn whole_balls_are_left_out_only_if_every_place_is(
        seed in any::<u64>(),
        count in 1usize..40,
        away in 0.0..3.0f64,
        size in -3.0..1.0f64,
        short in -6.0..0.0f64,
        within in prop_oneof![Just(0.0), 0.0..0.3f64],
    ) {
        let mut triangles = soup(seed, count);
        let shift = DVec3::new(0.7, -0.2, 0.5) * 10f64.powf(away);
        for vertex in &mut triangles.vertices {
            *vertex += shift;
        }
        let Ok(wall) = Mesh::new(&triangles, |x| x, false) else { return Ok(()) };
        let mut random = Stream::new(seed, "balls", 0);
        let mut draw = || DVec3::from([0; 3].map(|_| random.uniform_in(-1.0, 1.0)));
        let (mut all, mut scratch) = (Touches::new(), Scratch::default());
        for _ in 0..20 {
            let place = shift + draw() * (1.0 + 10f64.powf(size));
            wall.touches_of_all(place, 100.0, &mut all);
            let nearest = all.iter().map(|touch| touch.distance).fold(f64::INFINITY, f64::min);
            // Hardly too far, and hardly not.
            for reach in [nearest * (1.0 - 10f64.powf(short)), nearest * (1.0 + 1e-9)] {
                let way = draw().normalize() * within;
                let near = wall.may_be_near(place, reach, &mut scratch);
                let length = way.length() * (1.0 + 1e-9);
                prop_assert!(!near || wall.may_be_near_some(place + way, length, reach, &mut scratch));
            }
        }
    }

    /// No vertex moves by more than the bound.
    #[test]
    fn displacements_are_bounded(
        seed in any::<u64>(),
        from in any_turn(),
        to in any_turn(),
        shift in prop::array::uniform3(-1.0..1.0f64),
    ) {
        let triangles = soup(seed, 10);
        let Ok(wall) = Mesh::new(&triangles, |x| x, false) else { return Ok(()) };
        let from = Pose { rotation: from, translation: DVec3::ZERO };
        let to = Pose { rotation: to, translation: shift.into() };
        let bound = wall.displacement(&from, &to, DVec3::ZERO, 10.0);
        let with_area = |[a, b, c]: &&[u32; 3]| a != b && b != c && c != a;
        for vertex in triangles.triangles.iter().filter(with_area).flatten() {
            let vertex = triangles.vertices[*vertex as usize];
            prop_assert!(from.to_global(vertex).distance(to.to_global(vertex)) <= bound + 1e-12);
        }
    }
}

/// Walks with steps of a random direction, and compares all kinds of query at each place.
fn lists_and_queries_agree(
    wall: &Mesh,
    seed: u64,
    mut centre: DVec3,
    step: f64,
    reach: f64,
) -> Result<(), TestCaseError> {
    let mut random = Stream::new(seed, "walk", 0);
    let (mut lists, mut scratch) = (NearMeshes::default(), Scratch::default());
    let (mut listed, mut asked, mut all) = (Touches::new(), Touches::new(), Touches::new());
    for _ in 0..30 {
        // The second sphere has its lists made again and again in the memory that the first leaves.
        for (index, place) in [centre, -centre].into_iter().enumerate() {
            lists.touches(index, wall, place, reach, &mut scratch, &mut listed);
            wall.touches(place, reach, &mut asked);
            wall.touches_of_all(place, reach, &mut all);
            prop_assert_eq!(listed.as_slice(), all.as_slice());
            prop_assert_eq!(asked.as_slice(), all.as_slice());
            if let Some(touch) = asked.iter().next() {
                prop_assert!(wall.may_be_near(place, reach, &mut scratch));
                // A contact that has just begun must not be missed either.
                let barely =
                    touch.distance.abs() * (1.0 + 10f64.powf(-7.0 + 4.0 * random.uniform()));
                let mut fresh = NearMeshes::default();
                for from in [place + DVec3::splat(0.1 * step), place] {
                    fresh.touches(0, wall, from, barely, &mut scratch, &mut listed);
                }
                wall.touches_of_all(place, barely, &mut all);
                prop_assert_eq!(listed.as_slice(), all.as_slice());
            }
        }
        centre += step
            * DVec3::new(
                random.uniform() - 0.5,
                random.uniform() - 0.5,
                random.uniform() - 0.5,
            );
    }
    Ok(())
}

/// A square sheet from -1 to 1 of twice `cells` squared triangles, with a wave of height `waves` along x.
fn sheet(cells: usize, waves: f64) -> TriangleMesh {
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    for j in 0..=cells {
        for i in 0..=cells {
            let [x, y] = [i, j].map(|k| 2.0 * k as f64 / cells as f64 - 1.0);
            vertices.push(DVec3::new(x, y, waves * (4.0 * x).sin()));
            if i < cells && j < cells {
                let k = (j * (cells + 1) + i) as u32;
                let above = k + cells as u32 + 1;
                triangles.push([k, k + 1, above + 1]);
                triangles.push([k, above + 1, above]);
            }
        }
    }
    mesh(vertices, triangles)
}

/// The cube from -1 to 1 with twice `cells` squared triangles a face.
fn fine_cube(cells: usize) -> TriangleMesh {
    let face = sheet(cells, 0.0);
    let mut vertices: Vec<DVec3> = Vec::new();
    let mut triangles = Vec::new();
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let numbers: Vec<u32> = face
                .vertices
                .iter()
                .map(|x| {
                    let mut place = DVec3::ZERO;
                    (place[(axis + 1) % 3], place[(axis + 2) % 3]) = (x.x, x.y);
                    place[axis] = side;
                    let known = vertices.iter().position(|&known| known == place);
                    known.unwrap_or_else(|| {
                        vertices.push(place);
                        vertices.len() - 1
                    }) as u32
                })
                .collect();
            let turned = |[a, b, c]: [u32; 3]| if side > 0.0 { [a, b, c] } else { [a, c, b] };
            let numbered = face
                .triangles
                .iter()
                .map(|corners| corners.map(|k| numbers[k as usize]));
            triangles.extend(numbered.map(turned));
        }
    }
    mesh(vertices, triangles)
}

/// Triangles between random corners of a small set: they share edges, in twos and threes, cross and repeat.
fn soup(seed: u64, count: usize) -> TriangleMesh {
    let mut random = Stream::new(seed, "soup", 0);
    let corners = 4 + count / 2;
    let vertices = (0..corners)
        .map(|_| DVec3::new(random.uniform(), random.uniform(), random.uniform()) * 2.0 - 1.0)
        .collect();
    let mut pick = || (random.uniform() * corners as f64) as u32;
    let triangles = (0..count).map(|_| [pick(), pick(), pick()]).collect();
    mesh(vertices, triangles)
}

/// The cube from -1 to 1, normals outwards, faces in the order -x +x -y +y -z +z.
fn cube() -> TriangleMesh {
    let vertices = (0..8)
        .map(|k| DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2)) * 2.0 - 1.0)
        .collect();
    let faces = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let halves = faces.map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    mesh(vertices, halves.concat())
}

#[test]
fn convex_edges_and_corners_are_one_contact() {
    let wall = shape(&cube(), false);
    for (centre, foot) in [
        ([0.3, 0.2, 1.09], [0.3, 0.2, 1.0]),
        ([0.0, 0.0, 1.09], [0.0, 0.0, 1.0]),
        ([1.06, 0.3, 1.06], [1.0, 0.3, 1.0]),
        ([1.05, 1.05, 1.05], [1.0, 1.0, 1.0]),
        ([1.0, 1.0, 1.09], [1.0, 1.0, 1.0]),
    ] {
        let (centre, foot) = (DVec3::from(centre), DVec3::from(foot));
        let found = touches(&wall, centre, 0.1);
        assert_eq!(found.len(), 1, "at {centre}: {found:?}");
        assert!((centre - found[0].normal * found[0].distance - foot).length() < 1e-15);
    }
    assert!(touches(&wall, DVec3::new(1.08, 0.0, 1.08), 0.1).is_empty());
}

#[test]
fn concave_corners_are_as_many_contacts_as_faces() {
    for front in [false, true] {
        let mut inside_out = cube();
        for triangle in &mut inside_out.triangles {
            triangle.swap(1, 2);
        }
        let wall = shape(&inside_out, front);
        for (centre, count) in [
            ([0.0, 0.0, 0.95], 1),
            ([0.95, 0.0, 0.95], 2),
            ([0.95, -0.94, 0.95], 3),
            ([0.95, -0.95, 0.95], 3),
        ] {
            let found = touches(&wall, centre.into(), 0.1);
            assert_eq!(found.len(), count, "at {centre:?}: {found:?}");
            for touch in found {
                assert!(touch.normal.abs().max_element() == 1.0 && touch.distance < 0.061);
            }
        }
    }
}

/// Where two tessellated walls meet in a concave corner, a place over an edge in both has both contacts, in any direction: the farther one too, which
/// nothing but its own triangles can show.
#[test]
fn round_off_over_edges_loses_no_contact_of_a_corner() {
    let steps = [0.0, 0.3, 0.45, 0.8, 1.0];
    let mut corner = TriangleMesh::default();
    // A floor at z = 0 and a wall at y = 0, in strips along x that are cut along diagonals.
    for normal in [DVec3::Z, DVec3::Y] {
        let across = DVec3::Y + DVec3::Z - normal;
        let first = corner.vertices.len() as u32;
        for x in steps {
            corner
                .vertices
                .extend([0.0, 1.0].map(|s| x * DVec3::X + s * across));
        }
        for k in 0..steps.len() as u32 - 1 {
            let [a, b, c, d] = [0, 1, 2, 3].map(|i| first + 2 * k + i);
            corner.triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    let mut random = Stream::new(8, "corner", 0);
    for _ in 0..400 {
        let turn = random.unit_quaternion();
        let wall = shape(&turned(&corner, turn, DVec3::ZERO), false);
        for x in steps {
            // Over the common edges of strips in both, and over a diagonal in both.
            let strip = steps
                .partition_point(|&other| other <= x)
                .min(steps.len() - 1);
            let within = 0.3 * (steps[strip] - steps[strip - 1]);
            for place in [
                DVec3::new(x, 0.2, 0.25),
                DVec3::new(steps[strip - 1] + within, 0.3, 0.3),
            ] {
                let found = touches(&wall, turn * place, 0.4);
                assert_eq!(found.len(), 2, "over {place}: {found:?}");
            }
        }
    }
}

#[test]
fn one_sided_meshes_push_out_where_they_are_nearest() {
    let wall = shape(&cube(), true);
    let found = touches(&wall, DVec3::new(0.2, 0.1, 1.05), 0.1);
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].normal, DVec3::Z);
    // 0.03 behind the upper face, 0.04 behind the one beside it: out by the upper one.
    let found = touches(&wall, DVec3::new(0.96, 0.1, 0.97), 0.1);
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].normal, DVec3::Z);
    assert!((found[0].distance + 0.03).abs() < 1e-15);
    assert!(touches(&wall, DVec3::new(0.0, 0.0, 0.8), 0.1).is_empty());
    // Two-sided, the same places feel both faces from inside.
    let wall = shape(&cube(), false);
    assert_eq!(touches(&wall, DVec3::new(0.96, 0.1, 0.97), 0.1).len(), 2);
}

/// On which side of a one-sided mesh a centre beyond a corner is does not depend on how the faces are cut into triangles: each counts with its
/// angle at the corner (Baerentzen and Aanaes 2005).
#[test]
fn the_side_at_a_corner_does_not_depend_on_the_triangulation() {
    let rim = |turn: f64| DVec3::new(-1.0, 0.2 * (TAU * turn).cos(), 0.2 * (TAU * turn).sin());
    for cuts in [1, 40] {
        // A spike of three sides with its tip at the origin, the first of them cut into many that meet there.
        let mut ring: Vec<DVec3> = (0..cuts)
            .map(|k| rim(0.0).lerp(rim(1.0 / 3.0), f64::from(k) / f64::from(cuts)))
            .collect();
        ring.extend([rim(1.0 / 3.0), rim(2.0 / 3.0)]);
        let count = ring.len() as u32;
        let sides = (0..count).map(|k| [0, 1 + k, 1 + (k + 1) % count]);
        let base = (0..count - 2).map(|k| [count, 2 + k, 1 + k]);
        let triangles = sides.chain(base).collect();
        let spike = mesh([vec![DVec3::ZERO], ring].concat(), triangles);
        let wall = shape(&spike, true);
        for k in 0..24 {
            let angle = TAU * f64::from(k) / 24.0;
            // In front of all edges that end in the tip.
            let away = DVec3::new(0.3, angle.cos(), angle.sin()).normalize();
            let found = touches(&wall, 0.05 * away, 0.1);
            assert_eq!(found.len(), 1, "{cuts} cuts, {away}: {found:?}");
            assert!(
                (found[0].distance - 0.05).abs() < 1e-15,
                "{cuts} cuts, {away}"
            );
            assert!(
                found[0].normal.distance(away) < 1e-14,
                "{cuts} cuts, {away}"
            );
        }
    }
}

/// Sheets that are there twice, seams of more than two triangles and cracks thinner than the precision give one contact.
#[test]
fn repeated_and_unwelded_triangles_are_one_contact() {
    let corners = |x: f64| {
        [
            DVec3::ZERO,
            DVec3::new(x, 0.0, 0.0),
            DVec3::new(0.5, x, 0.0),
        ]
    };
    let twice = mesh(corners(1.0).to_vec(), vec![[0, 1, 2], [0, 1, 2], [0, 2, 1]]);
    for y in [0.2, 0.0, -0.01] {
        let found = touches(&shape(&twice, false), DVec3::new(0.5, y, 0.09), 0.1);
        assert_eq!(found.len(), 1, "{y}: {found:?}");
    }
    // Two halves of a square whose common side differs in the last digits of single precision.
    let crack = 1.0 + f64::from(f32::EPSILON);
    let halves = mesh(
        vec![
            DVec3::new(1.0, -1.0, 0.0),
            DVec3::new(1.0, 1.0, 0.0),
            DVec3::new(-1.0, 0.0, 0.0),
            DVec3::new(crack, 1.0, 0.0),
            DVec3::new(crack, -1.0, 0.0),
            DVec3::new(3.0, 0.0, 0.0),
        ],
        vec![[0, 1, 2], [3, 4, 5]],
    );
    let halves = TriangleMesh {
        is_single_precision: true,
        ..halves
    };
    let wall = shape(&halves, false);
    for offset in [-0.09, -0.03, -1e-8, 0.0, 3e-8, 6e-8, 1e-7, 0.03, 0.09] {
        let found = touches(&wall, DVec3::new(1.0 + offset, 0.2, 0.05), 0.12);
        assert_eq!(found.len(), 1, "{offset}: {found:?}");
    }
}

#[test]
fn triangles_without_area_are_left_out() {
    let mut triangles = cube();
    triangles.triangles.extend([[0, 0, 1], [3, 3, 3]]);
    triangles.vertices.push(DVec3::new(0.0, -1.0, -1.0));
    triangles.triangles.push([0, 8, 1]);
    let wall = Mesh::new(&triangles, |x| x, false).unwrap();
    let left_out = LeftOut { thin: 3, far: 0 };
    assert_eq!((wall.len(), wall.left_out()), (12, left_out));
    assert_eq!(wall.edge_counts(), [0, 18, 0]);
    let error = Mesh::new(
        &mesh(vec![DVec3::ZERO, DVec3::X], vec![[0, 1, 0]]),
        |x| x,
        false,
    );
    assert_eq!(
        error.unwrap_err().to_string(),
        "file: none of the 1 triangles has an area: they are thinner than 1e-9 m, 1e-9 of the mesh's size of 1 m"
    );
    let error = Mesh::new(&triangles, |x| x / 0.0, false).unwrap_err();
    assert!(matches!(error, WallError::NotFinite { key: "file", .. }));
}

/// Squares of 1 m in map coordinates, two triangles each.
fn terrain() -> TriangleMesh {
    let corner = |i: u32, j: u32| DVec3::new(5e5 + f64::from(i), 4.6e6 + f64::from(j), 100.0);
    let vertices = (0..=4).flat_map(|j| (0..=4).map(move |i| corner(i, j)));
    let squares = (0..4).flat_map(|j| (0..4).map(move |i| 5 * j + i));
    let triangles = squares.flat_map(|k| [[k, k + 1, k + 6], [k, k + 6, k + 5]]);
    mesh(vertices.collect(), triangles.collect())
}

/// Numbers of a text are exact, however short they are in binary: 1 m in 4.6e6 m is far above their round-off. The same numbers
/// in single precision differ by half a metre from one to the next.
#[test]
fn triangles_in_map_coordinates_are_kept_where_the_numbers_are_exact() {
    let near = |x: DVec3| x - DVec3::new(5e5, 4.6e6, 100.0);
    let wall = Mesh::new(&terrain(), near, false).unwrap();
    assert_eq!((wall.len(), wall.left_out()), (32, LeftOut::default()));
    let wall = Shape::Mesh(Arc::new(wall));
    for k in 0..40 {
        let centre = DVec3::new(0.1 * f64::from(k), 4.0 - 0.1 * f64::from(k), 0.09);
        let found = touches(&wall, centre, 0.1);
        assert_eq!(found.len(), 1, "{centre}");
        assert_eq!((found[0].distance, found[0].normal), (0.09, DVec3::Z));
    }
    let single = TriangleMesh {
        is_single_precision: true,
        ..terrain()
    };
    // 4 times 2^-23 of 4600004.
    assert_eq!(
        Mesh::new(&single, near, false).unwrap_err().to_string(),
        "file: none of the 32 triangles has an area: they are thinner than 2.19345 m, \
         4 units of single precision of the coordinate 4.6e6 of the file"
    );
}

/// A far triangle changes neither what the others do nor how exactly they are known.
#[test]
fn a_stray_triangle_does_not_drop_the_mesh() {
    let plate = mesh(
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
            .map(|[x, y]| DVec3::new(x, y, 0.0))
            .to_vec(),
        vec![[0, 1, 2], [0, 2, 3]],
    );
    let alone = shape(&plate, false);
    for is_single_precision in [false, true] {
        for exponent in [3, 6, 9, 12, 14, 16, 30, 150, 300] {
            let far = 10.0_f64.powi(exponent);
            let mut both = plate.clone();
            both.is_single_precision = is_single_precision;
            both.vertices.extend([
                DVec3::new(far, 0.0, 0.0),
                DVec3::new(far, 0.01 * far, 0.0),
                DVec3::new(far, 0.0, 0.01 * far),
            ]);
            both.triangles.push([4, 5, 6]);
            let wall = Mesh::new(&both, |x| x, false).unwrap();
            let left_out = LeftOut {
                thin: 0,
                far: usize::from(far > Mesh::FARTHEST),
            };
            assert_eq!((wall.len(), wall.left_out()), (3 - left_out.far, left_out));
            let wall = Shape::Mesh(Arc::new(wall));
            for k in 0..60 {
                let x = 0.02 * f64::from(k);
                let centre = DVec3::new(x, 1.1 - x, 0.05);
                let (found, expected) = (touches(&wall, centre, 0.1), touches(&alone, centre, 0.1));
                assert_eq!(found.len(), expected.len(), "{far} {centre}");
                for (found, expected) in found.iter().zip(&expected) {
                    assert_eq!(found.distance, expected.distance, "{far} {centre}");
                    assert_eq!(found.normal, expected.normal, "{far} {centre}");
                }
            }
        }
    }
}

/// A cylinder of radius 1 about z, of `around` facets.
pub(super) fn cylinder(around: u32) -> TriangleMesh {
    let corner = |k: u32, z: f64| {
        let angle = TAU * f64::from(k % around) / f64::from(around);
        DVec3::new(angle.cos(), angle.sin(), z)
    };
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for k in 0..around {
        vertices.extend([corner(k, -1.0), corner(k, 1.0)]);
        let [a, b, c, d] = [2 * k, 2 * k + 1, 2 * k + 2, 2 * k + 3].map(|i| i % (2 * around));
        triangles.extend([[a, c, b], [c, d, b]]);
    }
    mesh(vertices, triangles)
}

/// Inside and outside there is one contact everywhere; its distance is off by at most the sagitta 1 - cos(pi/n) of the facets,
/// its normal by at most the angle that leaves the centre: pi/n / (1 - r) inside, where r is the sphere's radius.
#[test]
fn a_tessellated_cylinder_becomes_a_cylinder() {
    for around in [32, 64, 256] {
        let wall = shape(&cylinder(around), false);
        let half = TAU / 2.0 / f64::from(around);
        assert!(2.0 * half < SMOOTH_ANGLE.to_radians());
        let sagitta = 1.0 - half.cos();
        // Spheres of two fifths and nine tenths of the drum's radius, and one outside.
        for (from_axis, radius) in [(0.61, 0.4), (0.13, 0.9), (1.29, 0.3)] {
            for k in 0..500 {
                let angle = 0.01357 * f64::from(k);
                let outward = DVec3::new(angle.cos(), angle.sin(), 0.0);
                let centre = outward * from_axis + DVec3::Z * (0.3 * (7.0 * angle).sin());
                let found = touches(&wall, centre, radius);
                assert_eq!(found.len(), 1, "{around} {radius} {angle}: {found:?}");
                let analytic = (1.0f64 - from_axis).abs();
                let difference = (found[0].distance - analytic).abs();
                assert!(difference <= sagitta * 1.0001, "{difference} {sagitta}");
                let normal = outward * (from_axis - 1.0f64).signum();
                let turn = found[0].normal.angle_between(normal);
                let limit = if from_axis < 1.0 { half } else { 2.0 * half };
                assert!(
                    turn <= limit + 1e-12,
                    "{around} {radius} {angle}: {turn} {limit}"
                );
            }
        }
    }
}

/// Every feature belongs to a triangle of the file that touches the sphere there.
#[test]
fn features_name_triangles_of_the_file() {
    let triangles = cube();
    let wall = Mesh::new(&triangles, |x| x, false).unwrap();
    let mut out = Touches::new();
    let mut found = Vec::new();
    for centre in [
        [0.3, 0.2, 1.09],
        [1.06, 0.3, 1.06],
        [1.05, 1.05, 1.05],
        [-1.05, -1.05, -1.05],
    ] {
        let centre = DVec3::from(centre);
        wall.touches(centre, 0.1, &mut out);
        let touch = out.as_slice()[0];
        let foot = centre - touch.normal * touch.distance;
        wall.triangles_of(touch.feature, &mut found);
        for &triangle in &found {
            let [a, b, c] = triangles.corners(triangle as usize);
            let height = (foot - a).dot((b - a).cross(c - a));
            assert!(height.abs() < 1e-14, "{centre}: {triangle}");
        }
    }
    // 12 faces, 18 edges, 8 corners
    let counts: Vec<usize> = (0..39)
        .map(|feature| {
            wall.triangles_of(feature, &mut found);
            assert!(found.is_sorted());
            found.len()
        })
        .collect();
    assert!(counts[..12].iter().all(|&count| count == 1));
    assert!(counts[12..30].iter().all(|&count| count == 2));
    // Three faces meet at a corner, each cut into two triangles, one or both of them at the corner.
    assert!(counts[30..38].iter().all(|count| (3..=6).contains(count)));
    assert_eq!(counts[30..38].iter().sum::<usize>(), 3 * 12);
    assert_eq!(counts[38], 0);
    // The cube has edges of 2 m.
    assert!(wall.areas().iter().all(|&area| area == 2.0));
}

/// A contact is followed over edges, round a convex edge, and not into the other face of a corner.
#[test]
fn contacts_go_on_over_edges() {
    let Shape::Mesh(wall) = shape(&cube(), false) else {
        unreachable!("it is a mesh")
    };
    let only = |centre: DVec3| {
        let found = touches(&Shape::Mesh(wall.clone()), centre, 0.1);
        assert_eq!(found.len(), 1, "{found:?}");
        found[0]
    };
    // Along the upper face and round its edge: every contact continues the one before.
    let path = (0..200).map(|k| {
        let way = 0.01 * f64::from(k);
        if way < 1.0 {
            DVec3::new(way, 0.1, 1.095)
        } else {
            let angle = (way - 1.0) * 1.5;
            DVec3::new(1.0 + 0.095 * angle.sin(), 0.1, 1.0 + 0.095 * angle.cos())
        }
    });
    let mut last = None;
    for centre in path {
        let touch = only(centre);
        if let Some(feature) = last {
            assert!(
                wall.continues(feature, &touch, centre).is_some(),
                "{centre}"
            );
        }
        last = Some(touch.feature);
    }
    let corner = DVec3::new(0.95, 0.0, 0.95);
    let found = touches(&Shape::Mesh(wall.clone()), corner, 0.1);
    assert_eq!(wall.continues(found[0].feature, &found[1], corner), None);
}

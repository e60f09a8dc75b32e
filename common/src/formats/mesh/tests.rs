use std::fs;
use std::path::PathBuf;

use proptest::prelude::*;

use super::*;
use crate::formats::number::NumberStyle;
use crate::reference_data::shared;

/// Writes a file and reads it as a mesh.
fn read_as(name: &str, content: &[u8]) -> Result<TriangleMesh, FormatError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, content).unwrap();
    read_mesh(path)
}

/// A tetrahedron with corners at the origin and on the axes, seen from outside counter-clockwise.
fn tetrahedron() -> TriangleMesh {
    TriangleMesh {
        vertices: vec![DVec3::ZERO, DVec3::Y, DVec3::X, DVec3::Z],
        triangles: vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [2, 1, 3]],
        ..TriangleMesh::default()
    }
}

fn binary(mesh: &TriangleMesh) -> Vec<u8> {
    let mut out = Vec::new();
    push_binary_stl(mesh, &mut out).unwrap();
    out
}

/// Signed volume by the divergence theorem: positive if the triangles look outwards.
fn volume(mesh: &TriangleMesh) -> f64 {
    let tetrahedra = (0..mesh.triangles.len()).map(|index| {
        let [a, b, c] = mesh.corners(index);
        a.dot(b.cross(c)) / 6.0
    });
    tetrahedra.sum()
}

/// True if every edge is used once in each direction.
fn is_closed(mesh: &TriangleMesh) -> bool {
    let mut edges = std::collections::HashMap::new();
    for [a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *edges.entry((*from, *to)).or_insert(0) += 1;
            *edges.entry((*to, *from)).or_insert(0) -= 1;
        }
    }
    edges.values().all(|&balance| balance == 0)
}

#[test]
fn binary_stl_there_and_back() {
    let mesh = tetrahedron();
    let bytes = binary(&mesh);
    assert_eq!(bytes.len(), 84 + 4 * 50);
    let back = read_as("t.stl", &bytes).unwrap();
    assert_eq!(back.vertices, mesh.vertices);
    assert_eq!(back.triangles, mesh.triangles);
    assert_eq!(back.welded, 12 - 4);
    assert_eq!(volume(&back), 1.0 / 6.0);
    assert!(back.is_single_precision);
    // The head does not begin with `solid`, and the first normal looks down.
    assert_eq!(bytes[..80].trim_ascii(), b"binary STL");
    let normal = [0.0_f32, 0.0, -1.0].map(f32::to_le_bytes).concat();
    assert_eq!(bytes[84..96], normal);
}

#[test]
fn a_binary_stl_may_begin_with_solid_and_end_with_surplus() {
    let mut bytes = binary(&tetrahedron());
    bytes[..11].copy_from_slice(b"solid facet");
    assert_eq!(read_as("t.STL", &bytes).unwrap().triangles.len(), 4);
    bytes.push(0);
    assert_eq!(read_as("t.stl", &bytes).unwrap().triangles.len(), 4);
    // A truncated file is still recognised as binary, and the message gives both counts.
    bytes.truncate(84 + 2 * 50 + 7);
    let error = read_as("t.stl", &bytes).unwrap_err();
    assert!(
        error.found.contains("2 whole triangles (191 bytes)"),
        "{error}"
    );
    assert!(
        error.expected.contains("4 triangles (284 bytes)"),
        "{error}"
    );
}

const TEXT: &str = "solid a name with facet\n facet normal nan 0 0\n  outer loop\n   vertex 0 0 0.1\n   \
                    VERTEX 1e-3 0 0\n   vertex 0 1.0000000000000002 0\n  endloop\n endfacet\nendsolid a name\n";

#[test]
fn text_stl_keeps_double_precision() {
    for text in [
        TEXT.to_owned(),
        TEXT.replace('\n', "\r\n"),
        TEXT.replace("solid", "SOLID"),
        format!("\u{feff}{TEXT}"),
        format!("{TEXT}\n{}", "solid\nendsolid\n"),
    ] {
        let mesh = read_as("t.stl", text.as_bytes()).unwrap();
        assert_eq!(
            mesh.vertices,
            [
                DVec3::new(0.0, 0.0, 0.1),
                DVec3::new(1e-3, 0.0, 0.0),
                DVec3::new(0.0, 1.0 + f64::EPSILON, 0.0)
            ]
        );
        assert_eq!(mesh.triangles, [[0, 1, 2]]);
        assert!(!mesh.is_single_precision);
    }
}

/// Two triangles of a square, in many ways of writing them.
#[test]
fn text_stl_of_other_programs_is_read() {
    let plate = "solid plate\n\
        facet normal 0 0 1\nouter loop\nvertex -1 -1 0\nvertex 1 -1 0\nvertex 1 1 0\nendloop\nendfacet\n\
        facet normal 0 0 1\nouter loop\nvertex -1 -1 0\nvertex 1 1 0\nvertex -1 1 0\nendloop\nendfacet\n\
        endsolid plate\n";
    let changed = |from: &str, to: &str| {
        assert!(plate.contains(from), "{from}");
        plate.replace(from, to).into_bytes()
    };
    let named = |name: &[u8]| [b"solid ", name, &plate.as_bytes()[11..]].concat();
    let expected = read_as("t.stl", plate.as_bytes()).unwrap();
    assert_eq!((expected.triangles.len(), expected.warnings.len()), (2, 0));
    for text in [
        changed("normal 0 0 1", "normal -1.#IND -1.#IND -1.#IND"),
        changed("normal 0 0 1", "normal 0 0"),
        changed("normal 0 0 1", "normal "),
        changed("endloop\nendfacet", "end loop\nend facet"),
        changed("endsolid", "End Solid"),
        changed(
            "endsolid plate\n",
            "endsolid plate\n\nexported by CAD 12.3\n",
        ),
        changed("solid plate\nfacet", "# made by hand\nsolid plate\nfacet"),
        changed("solid plate\nfacet", "; by hand\n% by hand\nfacet"),
        changed("outer loop", "color 1 0 0\nouter loop"),
        changed("endloop\n", "endloop\n  COLOR 1 0 0\n// a remark\n"),
        changed("\n", "\r"),
        changed("\n", "\r\n"),
        changed("1 1 0\n", "1 1 0 # a corner\n"),
        changed("vertex -1 -1 0", "vertex -1.000000D+00 -1.0d0 0.000000D+00"),
        changed(
            "vertex -1 -1 0",
            "vertex -1.000000+00 -10.00000-01 0.000000+000",
        ),
        changed(
            "0\nendloop\nendfacet\nfacet",
            "0\nendloop\nendfacet\nendsolid asolid b\nfacet",
        ),
        named(b"Geh\xe4use Gr\xf6\xdfe"),
        named(b"\xc4\xe5\xf2\xe0\xeb\xfc"),
        named(b"\xc1\xe3\xbc\xfe \xd6\x5c"),
    ] {
        let shown = String::from_utf8_lossy(&text).into_owned();
        let mesh = read_as("t.stl", &text).unwrap_or_else(|error| panic!("{shown}\n{error}"));
        assert_eq!(mesh, expected, "{shown}");
    }
    // A file that was cut behind a facet looks like one without `endsolid`.
    let mesh = read_as("t.stl", &changed("endsolid plate\n", "")).unwrap();
    assert_eq!(mesh.triangles, expected.triangles);
    assert_eq!(
        mesh.warnings,
        ["it ends without endsolid, so it may be cut"]
    );
}

#[test]
fn surplus_triangles_of_a_binary_stl_are_a_warning() {
    let mut bytes = binary(&tetrahedron());
    bytes[80..84].copy_from_slice(&1_u32.to_le_bytes());
    let mesh = read_as("t.stl", &bytes).unwrap();
    assert_eq!(mesh.triangles.len(), 1);
    assert_eq!(
        mesh.warnings,
        ["its header announces 1 triangle, and bytes for 3 more follow, which are not read"]
    );
    // Less than a triangle is padding.
    bytes.truncate(84 + 99);
    assert!(read_as("t.stl", &bytes).unwrap().warnings.is_empty());
    bytes[80..84].copy_from_slice(&0_u32.to_le_bytes());
    let error = read_as("t.stl", &bytes).unwrap_err();
    assert!(error.help.unwrap().contains("bytes for 1 more follow"));
}

#[test]
fn obj_of_other_programs_is_read() {
    let expected = vec![[0, 1, 2], [0, 2, 3]];
    for text in [
        &b"v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 \\\n3 4\n"[..],
        b"v -1 -1 0\rv 1 -1 0\rv 1 1 0\rv -1 1 0\rf 1 2 3 4\r",
        b"v -1 -1 0 # a\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4 # face\n",
        b"v -1 -1 0 0\nv 1 -1 0 2.0\nv 1 1 0 0.5 0.5\nv -1 1 0 1 1 1 1\nvt x\nvn 0\no\nusemtl\nmtllib a.mtl\nf 1/-5 2//-9 3/7/7/7 4/x\n",
        b"# from C:\\meshes\\\nv -1 \\\r\n-1 \\\r\n 0\r\nv 1.0D+00 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 \\\n4",
        b"g Geh\xe4use\nusemtl \xd6\x5c\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nusemtl \xd6\x5c\nv -1 1 0\nf 1 2 3 4\n",
    ] {
        let shown = String::from_utf8_lossy(text);
        let mesh = read_as("t.obj", text).unwrap_or_else(|error| panic!("{shown}\n{error}"));
        assert_eq!(mesh.triangles, expected, "{shown}");
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        assert_eq!(mesh.vertices, corners.map(|[x, y]| DVec3::new(x, y, 0.0)), "{shown}");
    }
    // Lines behind a continued one keep their numbers.
    let error = read_as("t.obj", b"v 0 \\\n0 \\\n0\nv 1 0 x\n").unwrap_err();
    assert_eq!((error.line, error.column), (Some(4), Some(7)));
}

#[test]
fn bad_text_stl_is_located() {
    for (from, to, line, column, part) in [
        (
            "0 0 0.1",
            "0 0 nan",
            4,
            Some(15),
            "\"nan\" for a coordinate",
        ),
        (
            "0 0 0.1",
            "0 zero 0",
            4,
            Some(13),
            "\"zero\" for a coordinate",
        ),
        ("0 0 0.1", "0 0", 5, Some(4), "\"VERTEX\" for a coordinate"),
        (
            "endloop",
            "vertex 1 1 1",
            7,
            Some(3),
            "\"vertex\" for a keyword",
        ),
        (
            "endfacet",
            "endface",
            8,
            Some(2),
            "\"endface\" for a keyword",
        ),
        (
            "facet normal nan",
            "fcaet normal nan",
            3,
            Some(3),
            "\"outer\" for a keyword",
        ),
        (
            "normal nan 0 0",
            "normal nan 0 0 facet",
            2,
            Some(23),
            "\"facet\" for a keyword",
        ),
        (
            " endfacet\nendsolid a name\n",
            "",
            7,
            None,
            "the end of the file",
        ),
    ] {
        let text = TEXT.replacen(from, to, 1);
        let error = read_as("t.stl", text.as_bytes()).unwrap_err();
        assert_eq!((error.line, error.column), (Some(line), column), "{error}");
        assert!(error.found.contains(part), "{error}");
    }
    let polygon = TEXT.replacen("endloop", "vertex 1 1 1", 1);
    let error = read_as("t.stl", polygon.as_bytes()).unwrap_err();
    assert!(error.help.unwrap().contains("only triangles"));
}

#[test]
fn bad_files_are_explained() {
    let mut nan = binary(&tetrahedron());
    nan[84 + 50 + 12..84 + 50 + 16].copy_from_slice(&f32::NAN.to_le_bytes());
    let many = {
        let mut bytes = vec![b'x'; 84];
        bytes[80..].fill(0xff);
        bytes
    };
    for (name, content, part) in [
        ("t.stl", &b""[..], "the file is empty"),
        ("t.obj", b"", "the file is empty"),
        ("t.ply", b"ply", "the file type .ply"),
        ("t", b"solid", "a file name without type"),
        (
            "t.stl",
            b"abc",
            "a text without a line that begins with solid or facet",
        ),
        ("t.stl", b"\xffbc", "3 bytes"),
        ("t.stl", b"\xff\xfes\0o\0l\0i\0d\0", "a text in UTF-16"),
        ("t.stl", b"\x1f\x8b\x08\0", "a compressed file"),
        (
            "t.stl",
            b"<!DOCTYPE html>\n<html><body>404 not found</body></html>\n",
            "a page of the web (HTML)",
        ),
        ("t.obj", b"\n<HTML>", "a page of the web (HTML)"),
        (
            "t.stl",
            b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n",
            "a pointer of Git LFS",
        ),
        ("t.stl", b"solid\nendsolid\n", "no triangles"),
        ("t.obj", b"v 0 0 0\n", "no triangles"),
        ("t.stl", &nan, "in triangle 2"),
        ("t.stl", &many, "0 whole triangles"),
    ] {
        let error = read_as(name, content).unwrap_err();
        assert!(error.found.contains(part), "{error}");
        assert!(error.path.ends_with(name));
    }
    assert!(
        read_mesh("no/such.stl")
            .unwrap_err()
            .found
            .contains("cannot be read")
    );
    for tolerance in [-1.0, f64::NAN, f64::INFINITY] {
        let error = read_mesh_welded("any.stl", tolerance).unwrap_err();
        assert!(error.found.contains("welding tolerance"), "{error}");
    }
}

#[test]
fn obj_faces_of_every_kind() {
    let text = "# c\nmtllib no.mtl\no cube\nv 0 0 0\nv 1 0 0 1.0\nv 1 1 0\nvt 0 0\nvn 0 0 1\n\
                f 1 2/1 3/1/1 4//1\nv 0 1 0\nf -4 -1 -2\nl 1 2\ns off\n";
    let mesh = read_as("t.obj", text.as_bytes()).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 2]]);
    assert_eq!(mesh.vertices[3], DVec3::Y);
    assert_eq!(mesh.welded, 0);
}

#[test]
fn bad_obj_is_located() {
    let three = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (tail, line, column, part, expected) in [
        ("f 1 2 4\n", 4, Some(7), "\"4\" for a corner", "from 1 to 3"),
        (
            "f 1 9 4\nf 1 2 7\n",
            4,
            Some(5),
            "\"9\" for a corner",
            "from 1 to 3",
        ),
        (
            "f 1 2 0\n",
            4,
            Some(7),
            "\"0\" for a corner",
            "counted from 1",
        ),
        ("f 1 2 -4\n", 4, Some(7), "\"-4\" for a corner", "-3 to -1"),
        (
            "f 1 2 x\n",
            4,
            Some(7),
            "\"x\" for a corner",
            "counted from 1",
        ),
        (
            "f 1 2 //3\n",
            4,
            Some(7),
            "\"//3\" for a corner",
            "counted from 1",
        ),
        ("f 1 2 99999999999\n", 4, Some(7), "for a corner", "below"),
        ("f 1 2\n", 4, Some(1), "a face of 2 corners", "at least 3"),
        ("v 1 2\n", 4, Some(6), "in place of z", "a number"),
        ("v 1 inf 2\n", 4, Some(5), "\"inf\" for y", "finite"),
        ("v 1 one 2\n", 4, Some(5), "\"one\" for y", "a number"),
    ] {
        let error = read_as("t.obj", format!("{three}{tail}").as_bytes()).unwrap_err();
        assert_eq!((error.line, error.column), (Some(line), column), "{error}");
        assert!(
            error.found.contains(part) && error.expected.contains(expected),
            "{error}"
        );
    }
}

/// A polygon is a fan, and vertices keep the order of the file, whichever is used first.
#[test]
fn obj_keeps_the_order_of_vertices() {
    let text = b"f 5 4 3 2 1\nv 0 0 0\nv 1 0 0\nv 1.5 1 0\nv 0.5 2 0\nv -0.5 1 0\nv 9 9 9\n";
    let surface = obj::parse(Path::new("t.obj"), text.to_vec()).unwrap();
    assert_eq!(surface.triangles, [[4, 3, 2], [4, 2, 1], [4, 1, 0]]);
    assert_eq!(surface.vertices[2], DVec3::new(1.5, 1.0, 0.0));
    assert_eq!(surface.vertices.len(), 6);
    // One vertex, three times.
    let surface = obj::parse(Path::new("t.obj"), b"v 1 2 3\nf 1 1 1\n".to_vec()).unwrap();
    assert_eq!(surface.vertices, [DVec3::new(1.0, 2.0, 3.0)]);
    assert_eq!(surface.triangles, [[0, 0, 0]]);
}

#[test]
fn obj_agrees_with_tobj() {
    let mut text = Vec::new();
    push_obj(&tetrahedron(), NumberStyle::Shortest, &mut text);
    text.extend_from_slice(b"v 3.1 3 1e-300\nv 4 3 0.30000000000000004\nv 4 4 3\nv 3.5 5 3\nv 3 4 3\nf -5 -4 -3 -2 -1\n");
    let options = tobj::LoadOptions {
        triangulate: true,
        single_index: true,
        ..Default::default()
    };
    let (models, _) = tobj::load_obj_buf(&mut &text[..], &options, |_| {
        Err(tobj::LoadError::GenericFailure)
    })
    .unwrap();
    let ours = read_as("t.obj", &text).unwrap();
    let theirs: Vec<DVec3> = models[0]
        .mesh
        .indices
        .iter()
        .map(|&index| {
            let at = 3 * index as usize;
            let p = &models[0].mesh.positions[at..at + 3];
            DVec3::new(p[0], p[1], p[2])
        })
        .collect();
    let corners: Vec<DVec3> = (0..ours.triangles.len())
        .flat_map(|index| ours.corners(index))
        .collect();
    assert_eq!(corners, theirs);
    assert_eq!(ours.triangles.len(), 4 + 3);
}

#[test]
fn degenerate_triangles_are_kept_and_reported() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 1 2\nf 1 2 4\n";
    let mesh = read_as("t.obj", text.as_bytes()).unwrap();
    assert_eq!(mesh.triangles.len(), 3);
    assert_eq!(mesh.degenerate_triangles(), [1, 2]);
    assert_eq!(
        mesh.bounds(),
        Some((DVec3::ZERO, DVec3::new(2.0, 1.0, 0.0)))
    );
    assert_eq!(TriangleMesh::default().bounds(), None);
}

#[test]
fn what_stl_cannot_hold_is_refused() {
    let mut mesh = tetrahedron();
    mesh.vertices[1] = DVec3::new(1e300, 0.0, 0.0);
    assert!(
        push_binary_stl(&mesh, &mut Vec::new())
            .unwrap_err()
            .contains("single precision")
    );
    mesh.vertices[1] = DVec3::Y;
    mesh.vertices.truncate(2);
    assert!(
        push_binary_stl(&mesh, &mut Vec::new())
            .unwrap_err()
            .contains("vertex 2 of 2")
    );
}

/// Meshes of MercuryDPM and our scenes: counts from the size of the file or from its words.
#[test]
fn real_meshes() {
    let files: [(&str, bool); 10] = [
        ("scenes/plate.stl", false),
        ("data/bench/mesh-drum.stl", false),
        ("data/shapes/mesh/Box1x1x1.stl", true),
        ("data/shapes/mesh/Casing.stl", true),
        ("data/shapes/mesh/MembraneDemo.stl", false),
        ("data/shapes/mesh/MembraneSelfTest.stl", false),
        ("data/shapes/mesh/Rattleback.stl", true),
        ("data/shapes/mesh/RotatingDrum_clump.stl", true),
        ("data/shapes/mesh/RotatingDrum_nozzle.stl", true),
        ("data/shapes/mesh/Screw.stl", false),
    ];
    for (name, closed) in files {
        let Some(path): Option<PathBuf> = shared(name) else {
            return;
        };
        let mesh = read_mesh(&path).unwrap();
        let bytes = fs::read(&path).unwrap();
        let is_text = std::str::from_utf8(&bytes).is_ok_and(|text| text.contains("endsolid"));
        if is_text {
            let text = String::from_utf8(bytes).unwrap();
            assert_eq!(
                mesh.triangles.len(),
                text.matches("endfacet").count(),
                "{name}"
            );
        } else {
            assert_eq!(mesh.triangles.len(), (bytes.len() - 84) / 50, "{name}");
        }
        assert_eq!(
            mesh.vertices.len() + mesh.welded,
            3 * mesh.triangles.len(),
            "{name}"
        );
        assert!(mesh.degenerate_triangles().is_empty(), "{name}");
        if closed {
            assert!(is_closed(&mesh) && volume(&mesh) > 0.0, "{name}");
        }
        if name.ends_with("Box1x1x1.stl") {
            // A unit cube in single precision: three edges, each with a relative error of 2^-24 per corner.
            let tolerance = 6.0 * f64::from(f32::EPSILON);
            assert!((volume(&mesh) - 1.0).abs() < tolerance, "{}", volume(&mesh));
        }
    }
}

fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![-1e30..1e30, -1.0..1.0, Just(0.0), Just(-0.0), 1e-30..1e-20]
}

prop_compose! {
    fn any_mesh(single: bool)(
        corners in prop::collection::vec([coordinate(), coordinate(), coordinate()], 3..12),
        faces in prop::collection::vec([any::<prop::sample::Index>(), any::<prop::sample::Index>(), any::<prop::sample::Index>()], 1..12),
    ) -> TriangleMesh {
        let vertices: Vec<DVec3> = corners.into_iter().map(|corner: [f64; 3]| {
            DVec3::from_array(if single { corner.map(|x| f64::from(x as f32)) } else { corner })
        }).collect();
        let triangles = faces.into_iter().map(|face| face.map(|index| index.index(vertices.len()) as u32)).collect();
        TriangleMesh { vertices, triangles, ..TriangleMesh::default() }
    }
}

fn all_corners(mesh: &TriangleMesh) -> Vec<[DVec3; 3]> {
    (0..mesh.triangles.len())
        .map(|index| mesh.corners(index))
        .collect()
}

proptest! {
    #[test]
    fn obj_round_trip_is_exact(mesh in any_mesh(false)) {
        let mut text = Vec::new();
        push_obj(&mesh, NumberStyle::Shortest, &mut text);
        prop_assert_eq!(all_corners(&read_as("t.obj", &text).unwrap()), all_corners(&mesh));
    }

    #[test]
    fn binary_round_trip_is_exact_in_single_precision(mesh in any_mesh(true)) {
        prop_assert_eq!(all_corners(&read_as("t.stl", &binary(&mesh)).unwrap()), all_corners(&mesh));
    }

    #[test]
    fn garbage_never_panics(
        bytes in prop::collection::vec(any::<u8>(), 0..300),
        text in "(solid|facet|normal|outer|loop|vertex|endloop|endfacet|endsolid|v|f|[0-9.-]{1,3}|[ /\n]){0,60}",
    ) {
        for content in [&bytes[..], text.as_bytes()] {
            let path = Path::new("t");
            let _ = stl::parse(path, content.to_vec()).map(|surface| weld::weld(&surface, 0.1));
            let _ = obj::parse(path, content.to_vec()).map(|surface| weld::weld(&surface, 0.0));
        }
        let _ = stl::parse(Path::new("t"), format!("solid {text}").into_bytes());
    }
}

//! Mesh walls: which go on for ever, and the warnings of their triangles.

use super::super::passes;
use super::*;
use mercury_engine::walls::Shape;

/// A scene of two balls over a square of corners -1 and 1 in x and y; the domain is periodic in x and y.
fn scene(mesh: bool, output: &str, scale: f64, motion: &str) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("square.obj");
    let square = "v -1 -1 -0.9\nv 1 -1 -0.9\nv 1 1 -0.9\nv -1 1 -0.9\nf 1 2 3\nf 1 3 4\n";
    std::fs::write(&file, square).unwrap();
    let head = HEAD
        .replace(
            "max = [1, 1, 1]\n",
            "max = [1, 1, 1]\nperiodic = [\"x\", \"y\"]\n",
        )
        .replace("interval = 0.1\n", &format!("interval = 0.1\n{output}"));
    let wall = if mesh {
        let file = file.display();
        format!("shape = \"mesh\"\nfile = \"{file}\"\nscale = {scale:?}\n{motion}")
    } else {
        "shape = \"plane\"\npoint = [0, 0, -0.9]\nnormal = [0, 0, 1]\n".to_owned()
    };
    let walls = format!("[[walls]]\nname = \"floor\"\nmaterial = \"ball\"\n{wall}");
    let text = format!("{head}{BALL}{walls}{}", two("ball", 0.1));
    (folder, text)
}

fn notes(scale: f64, motion: &str) -> (Vec<String>, usize) {
    let (_folder, text) = scene(true, "", scale, motion);
    let plan = planned_with(&text, &[]).unwrap_or_else(|errors| panic!("{errors}"));
    let Shape::Mesh(mesh) = &plan.physics().walls[0].shape else {
        panic!("a mesh")
    };
    let about_floor = |note: &&String| note.starts_with("walls.floor");
    (
        plan.notes()
            .remarks()
            .iter()
            .filter(about_floor)
            .cloned()
            .collect(),
        mesh.periods().len(),
    )
}

#[test]
fn a_mesh_of_one_period_goes_on_and_says_so() {
    let (reported, periods) = notes(1.0, "");
    assert_eq!(periods, 2);
    let expected = |letter: &str| {
        format!(
            "walls.floor: the mesh spans the periodic axis {letter} and goes on for ever along it"
        )
    };
    assert_eq!(reported, [expected("x"), expected("y")]);
    // It may travel, but not turn away from its axes.
    let slide = "motion = [{ kind = \"translation\", velocity = [1.0, 0.0, 0.0] }]\n";
    assert_eq!(notes(1.0, slide).1, 2);
    let turn = "motion = [{ kind = \"rotation\", axis = [1.0, 0.0, 0.0], origin = [0, 0, -0.9], angular_velocity = 1.0 }]\n";
    assert_eq!(notes(1.0, turn), (vec![expected("x")], 1));
}

#[test]
fn a_mesh_that_misses_the_period_is_reported() {
    let (reported, periods) = notes(0.995, "");
    assert_eq!(periods, 0);
    assert_eq!(
        reported[0],
        "walls.floor: the mesh is 1.99 m long along the periodic axis x, whose period is 2 m: it ends there; a mesh of just one period goes on for ever"
    );
    assert_eq!(reported.len(), 2);
    assert_eq!(notes(0.5, ""), (Vec::new(), 0));
}

#[test]
fn loads_on_triangles_need_triangles_and_a_file() {
    let done = |mesh: bool, output: &str| {
        let (_folder, text) = scene(mesh, output, 1.0, "");
        let plan = planned_with(&text, &[]).unwrap_or_else(|errors| panic!("{errors}"));
        let reported = |text: &String| text.starts_with("output.triangle_loads");
        let warning = plan
            .notes()
            .warnings()
            .iter()
            .find(|text| reported(text))
            .cloned();
        let pass = passes(&plan)
            .into_iter()
            .find(|pass| pass.name == "loads on triangles")
            .unwrap();
        assert_eq!(pass.is_done, plan.outputs().files().triangle_loads);
        (pass.is_done, pass.reason, warning.unwrap_or_default())
    };
    let text =
        |done: bool, reason: &str, warning: &str| (done, reason.to_owned(), warning.to_owned());
    let on = "triangle_loads = true\n";
    assert_eq!(done(true, on), text(true, "summed up in every step", ""));
    assert_eq!(
        done(true, ""),
        text(false, "output.triangle_loads = false", "")
    );
    assert_eq!(
        done(false, on),
        text(
            false,
            "no wall is a mesh",
            "output.triangle_loads: no wall is a mesh, so there are no triangles"
        )
    );
    assert_eq!(
        done(true, "triangle_loads = true\nframes = false\n").2,
        "output.triangle_loads: nothing would hold them, as output.frames and output.vtk are false"
    );
}

#[test]
fn a_mesh_in_the_wrong_place_or_unit_is_reported() {
    let warnings = |scale: f64, more: &str| {
        let (folder, text) = scene(true, "", scale, more);
        let plan = planned_with(&text, &[]).unwrap_or_else(|errors| panic!("{errors}"));
        let folder = format!("{}{}", folder.path().display(), std::path::MAIN_SEPARATOR);
        let warnings = plan.notes().warnings().iter();
        let about_mesh = warnings.filter(|warning| warning.contains("the mesh"));
        let texts = about_mesh.map(|warning| warning.replace(&folder, ""));
        texts.collect::<Vec<String>>()
    };
    let reported = |what: &str, from: &str, to: &str| {
        format!(
            "walls.floor: the mesh of square.obj {what}: it reaches from {from} to {to} m, the domain from (-1, -1, -1) to (1, 1, 1) m; correct its unit by scale (\"1 mm\" for a file in millimetres, 1 for one in metres) and its place by offset"
        )
    };
    let above = "offset = [0.0, 0.0, 5.0]\n";
    assert_eq!(
        warnings(1.0, above),
        [reported(
            "lies wholly outside the domain",
            "(-1, -1, 4.1)",
            "(1, 1, 4.1)"
        )]
    );
    // A mesh that moves may come in.
    let motion = "motion = [{ kind = \"translation\", velocity = [0.0, 0.0, -1.0] }]\n";
    assert_eq!(warnings(1.0, &format!("{above}{motion}")), [""; 0]);
    // A diagonal of 2 sqrt(2) scale beside that of the domain, 2 sqrt(3): 10 times at scale 12.2.
    let down = "offset = [0.0, 0.0, 10.5]\n";
    assert_eq!(warnings(12.0, down), [""; 0]);
    assert_eq!(
        warnings(12.5, down),
        [reported(
            "is more than 10 times as large as the domain",
            "(-12.5, -12.5, -0.75)",
            "(12.5, 12.5, -0.75)"
        )]
    );
    // The balls have a diameter of 0.2 m, which is the diagonal at scale 0.0707.
    assert_eq!(warnings(0.0708, ""), [""; 0]);
    assert_eq!(
        warnings(0.05, ""),
        [reported(
            "is very small beside the smallest particle, whose diameter is 0.2 m",
            "(-0.05, -0.05, -0.045)",
            "(0.05, 0.05, -0.045)"
        )]
    );
}

/// `scale` is the length of a unit of the file, as a number in metres or with a unit.
#[test]
fn the_unit_of_a_mesh_file_may_be_named() {
    let plan_of = |scale: &str| {
        let (_folder, text) = scene(true, "", 7.0, "");
        let text = text.replace("scale = 7.0", &format!("scale = {scale}"));
        planned_with(&text, &[]).unwrap_or_else(|errors| panic!("{errors}"))
    };
    for (typed, size) in [("\"10 cm\"", 0.1), ("0.1", 0.1), ("\"1 m\"", 1.0)] {
        let plan = plan_of(typed);
        let (low, high) = plan.physics().walls[0].shape.bounds();
        assert_eq!((low.x, high.x), (-size, size), "{typed}");
        let [file] = plan.outputs().mesh_files() else {
            panic!("one mesh")
        };
        assert_eq!((file.wall, file.scale), (0, size), "{typed}");
    }
}

#[test]
fn meshes_are_not_met_in_closed_form() {
    for (mesh, expected) in [
        (true, "with the triangles of meshes, 1 at rest"),
        (false, "in closed form, 1 at rest"),
    ] {
        let (_folder, text) = scene(mesh, "", 1.0, "");
        let plan = planned_with(&text, &[]).unwrap_or_else(|errors| panic!("{errors}"));
        let all = passes(&plan);
        let pass = all.iter().find(|pass| pass.name == "wall contacts");
        assert_eq!(pass.map(|pass| pass.reason.as_str()), Some(expected));
    }
}

/// A pipe along a periodic axis and its images are one surface without ends, unless it is shorter than the period or turns away.
#[test]
fn a_cylinder_of_a_period_goes_on_and_says_so() {
    let head = HEAD.replace("max = [1, 1, 1]\n", "max = [1, 1, 1]\nperiodic = [\"y\"]\n");
    let endless = |axis: &str, along: &str, motion: &str| {
        let pipe = format!(
            "[[walls]]\nname = \"pipe\"\nshape = \"cylinder\"\nmaterial = \"ball\"\norigin = [0, -1, 0]\nradius = 0.9\n\
             side = \"inside\"\naxis = {axis}\nalong = {along}\n{motion}"
        );
        let text = format!("{head}{BALL}{pipe}{}", two("ball", 0.1));
        let plan = planned_with(&text, &[]).unwrap_or_else(|errors| panic!("{errors}"));
        let said =
            "walls.pipe: the cylinder spans the periodic axis y and goes on for ever along it";
        let is_said = plan.notes().remarks().iter().any(|note| note == said);
        let (low, high) = plan.physics().walls[0].shape.bounds();
        assert_eq!(is_said, !(high - low).is_finite(), "{axis} {along}");
        is_said
    };
    assert!(endless("[0, 1, 0]", "[0, 2]", ""));
    assert!(endless("[0, -3, 0]", "[-2.5, 0.1]", ""));
    assert!(!endless("[0, 1, 0]", "[0, 1.99]", ""));
    assert!(!endless("[0.1, 1, 0]", "[0, 2]", ""));
    let turn = |axis: &str| {
        format!(
            "motion = [{{ kind = \"rotation\", axis = {axis}, origin = [0, 0, 0], angular_velocity = 1.0 }}]\n"
        )
    };
    assert!(endless("[0, 1, 0]", "[0, 2]", &turn("[0, 1, 0]")));
    assert!(!endless("[0, 1, 0]", "[0, 2]", &turn("[1, 0, 0]")));
}

/// Warnings and notes about a floor of two triangles, from -1 to 1 in x and y, and more triangles beside it, in a file of this name.
fn said_of(name: &str, bytes: &[u8], placed: &str) -> (usize, Vec<String>) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(name);
    std::fs::write(&file, bytes).unwrap();
    let text = format!(
        "{HEAD}{BALL}[[walls]]\nname = \"floor\"\nmaterial = \"ball\"\nshape = \"mesh\"\nfile = '{}'\n{placed}{}",
        file.display(),
        two("ball", 0.1)
    );
    let plan = planned_with(&text, &[]).unwrap_or_else(|errors| panic!("{errors}"));
    let Shape::Mesh(mesh) = &plan.physics().walls[0].shape else {
        panic!("a mesh")
    };
    let folder = format!("{}/", folder.path().display());
    let notes = plan.notes();
    let said = notes.warnings().iter().chain(notes.remarks());
    let of_file = said.map(|text| text.replace(&folder, ""));
    let of_file = of_file.filter(|text| text.contains("floor") || text.contains(name));
    (mesh.len(), of_file.collect())
}

fn facet([a, b, c]: [[f64; 3]; 3]) -> String {
    let vertex = |[x, y, z]: [f64; 3]| format!("vertex {x} {y} {z}\n");
    let corners = [a, b, c].map(vertex).concat();
    format!("facet normal 0 0 1\nouter loop\n{corners}endloop\nendfacet\n")
}

/// The floor with its middle at (x, y, z).
fn square([x, y, z]: [f64; 3]) -> [[[f64; 3]; 3]; 2] {
    let corner = |i: f64, j: f64| [x + i, y + j, z];
    let [a, b, c, d] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    [[a, b, c], [a, c, d]].map(|three| three.map(|[i, j]| corner(i, j)))
}

#[test]
fn a_floor_in_map_coordinates_has_all_triangles_as_text_and_names_what_it_lost_in_single_precision()
{
    let place = "offset = [-500000, -4600000, -100.9]\n";
    let floor = square([5e5, 4.6e6, 100.0]);
    let text = |facets: &[[[f64; 3]; 3]]| {
        let facets: String = facets.iter().map(|&three| facet(three)).collect();
        format!("solid terrain\n{facets}endsolid terrain\n")
    };
    let nothing: Vec<String> = Vec::new();
    let said = said_of("terrain.stl", text(&floor).as_bytes(), place);
    assert_eq!(said, (2, nothing));
    // Numbers of a binary file are known to half a metre there.
    let large = square([5e5, 4.6e6, 100.0])
        .map(|three| three.map(|[x, y, z]| [5e5 + 8.0 * (x - 5e5), 4.6e6 + 8.0 * (y - 4.6e6), z]));
    let all = [floor, large].concat();
    let all: Vec<[glam::DVec3; 3]> = all
        .iter()
        .map(|three| three.map(glam::DVec3::from_array))
        .collect();
    let mesh = mercury_common::formats::mesh::TriangleMesh::from_corners(&all);
    let mut binary = Vec::new();
    mercury_common::formats::mesh::push_binary_stl(&mesh, &mut binary).unwrap();
    // 4 times 2^-23 of 4600008.
    assert_eq!(
        said_of("terrain.stl", &binary, place),
        (
            2,
            vec!["walls.floor: 2 triangles have no area and are left out: they are thinner than 2.19345 m, 4 units of single precision of the coordinate 4.60001e6 of the file".to_owned()]
        )
    );
}

#[test]
fn what_is_odd_about_the_file_of_a_mesh_is_a_warning() {
    let floor = square([0.0, 0.0, -0.9]).map(facet).concat();
    let cut = format!("solid floor\n{floor}");
    assert_eq!(
        said_of("floor.stl", cut.as_bytes(), ""),
        (
            2,
            vec!["floor.stl: it ends without endsolid, so it may be cut".to_owned()]
        )
    );
    let far = facet([[1e30, 0.0, 0.0], [1e30, 1e28, 0.0], [1e30, 0.0, 1e28]]);
    let stray = format!("solid floor\n{floor}endsolid floor\nsolid far\n{far}endsolid far\n");
    assert_eq!(
        said_of("floor.stl", stray.as_bytes(), ""),
        (
            2,
            vec!["walls.floor: 1 triangle is left out, with a corner more than 1e15 m away: the mesh of floor.stl may be damaged".to_owned()]
        )
    );
}

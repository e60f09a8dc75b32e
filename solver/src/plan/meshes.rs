//! Mesh walls: read, placed, and looked over.

use std::path::PathBuf;
use std::sync::Arc;

use glam::DVec3;
use mercury_common::error::FormatError;
use mercury_common::formats::mesh::{TriangleMesh, read_mesh};
use mercury_common::scene::{
    Domain, Located, MeshSide, MeshSource, Scene, SceneError, Shape as SceneShape, Switches, Wear,
};
use mercury_common::turns::about_axis;

use super::MeshFile;
use mercury_engine::boundaries::Solid;
use mercury_engine::contact::parameter::short;
use mercury_engine::neighbours::Skin;
use mercury_engine::walls::{Mesh, Shape, Wall};

/// Reads the triangles of a wall; `then` moves a corner to where the wall begins.
pub(super) fn mesh(
    source: &MeshSource,
    side: MeshSide,
    then: impl Fn(DVec3) -> DVec3,
    warnings: &mut Vec<String>,
) -> Result<Shape, SceneError> {
    let triangles = triangles(&source.file, read_mesh, warnings)?;
    let place = placement(source);
    Mesh::new(&triangles, |x| then(place(x)), side == MeshSide::Front)
        .map(|mesh| Shape::Mesh(Arc::new(mesh)))
        .map_err(|error| {
            let message = error.to_string();
            // The scene's key already precedes the message; the error is in the file.
            let message = message.strip_prefix("file: ").unwrap_or(&message);
            let file = source.file.value.display();
            source.file.error(format!("{file}: {message}"))
        })
}

/// Refuses a mesh that is to wear and has triangles turned the other way than their neighbours: there one side would gain what the other loses.
pub(super) fn fit_to_wear(
    source: &MeshSource,
    wear: Option<&Wear>,
    shape: Shape,
) -> Result<Shape, SceneError> {
    let mesh = shape.mesh().filter(|_| wear.is_some());
    let Some((found, left_out)) = mesh.and_then(|mesh| Some((mesh.turned()?, mesh.left_out())))
    else {
        return Ok(shape);
    };
    let left_out = if left_out.thin + left_out.far > 0 {
        ", without those that are left out"
    } else {
        ""
    };
    let message = format!(
        "{}: triangle {} is turned the other way than its neighbour, triangle {} (counted from 0{left_out}; their common edge is at {} m): a wall that wears needs all normals on one side, and {} of its edges have them on both",
        source.file.value.display(),
        found.triangle,
        found.neighbour,
        point(found.place),
        found.pairs
    );
    let error = source.file.error(message);
    Err(error.with_help("let the program that made the mesh orient its triangles (Blender: Recalculate Outside; MeshLab: Re-Orient all faces coherently), or leave `wear` out"))
}

/// Reads the closed mesh of a region.
pub(crate) fn solid(source: &MeshSource, warnings: &mut Vec<String>) -> Result<Solid, SceneError> {
    let triangles = triangles(&source.file, read_mesh, warnings)?;
    let place = placement(source);
    let corners: Vec<DVec3> = triangles.vertices.iter().map(|&x| place(x)).collect();
    Solid::new(&corners, &triangles.triangles).map_err(|error| {
        let file = source.file.value.display();
        let error = source.file.error(format!("{file}: {error}"));
        error.with_help("a region is what lies inside a closed surface: close it, or describe the region by other shapes")
    })
}

/// Reads the triangles of a file by `read`, with what is odd about it.
pub(crate) fn triangles<'a>(
    file: &'a Located<PathBuf>,
    read: impl Fn(&'a PathBuf) -> Result<TriangleMesh, FormatError>,
    warnings: &mut Vec<String>,
) -> Result<TriangleMesh, SceneError> {
    let mesh = read(&file.value).map_err(|error| file.error(error.to_string()))?;
    let odd = mesh.warnings.iter();
    warnings.extend(odd.map(|warning| format!("{}: {warning}", file.value.display())));
    Ok(mesh)
}

/// Where a corner of the file comes to stand, m: scaled, then turned about the origin, then moved.
pub(crate) fn placement(source: &MeshSource) -> impl Fn(DVec3) -> DVec3 {
    let turn = source
        .rotate
        .as_ref()
        .map(|turn| about_axis(turn.axis.normalize(), turn.degrees.to_radians()));
    let (scale, offset) = (*source.scale, *source.offset);
    move |x: DVec3| {
        let scaled = x * scale;
        // Without a turn coordinates stay exactly what they are.
        turn.map_or(scaled, |turn| turn * scaled) + offset
    }
}

/// The files of mesh walls.
pub(super) fn files(scene: &Scene, walls: &[Wall]) -> Vec<MeshFile> {
    let file = |(index, wall): (usize, &Wall)| {
        let mut of_scene = scene.walls.iter();
        let found = of_scene.find(|other| other.name.value == wall.name)?;
        let SceneShape::Mesh { mesh: source, .. } = &found.shape else {
            return None;
        };
        let turn = source.rotate.as_ref();
        Some(MeshFile {
            wall: index,
            path: source.file.value.clone(),
            scale: *source.scale,
            rotate: turn.map(|turn| (*turn.axis, *turn.degrees)),
            offset: *source.offset,
        })
    };
    walls.iter().enumerate().filter_map(file).collect()
}

/// How far beyond its faces a mesh that goes on for ever is queried, in largest radii: one radius and the widest skin, and a twentieth more, as
/// far as its corners may move.
const REACH: f64 = 1.05 * (1.0 + Skin::widest(1.0));
/// Meshes that miss a period by less than this part of it may have been intended to span it.
const NEARLY: f64 = 0.01;

/// Continues meshes along the periodic axes that they span, as far as spheres of the largest radius (m) see.
pub(super) fn continue_periodically(
    walls: &mut [Wall],
    domain: &Domain,
    largest_radius: f64,
    notes: &mut Vec<String>,
) {
    let (min, max) = (*domain.min, *domain.max);
    for wall in walls {
        let Shape::Mesh(mesh) = &wall.shape else {
            continue;
        };
        let periods: Vec<(usize, f64, f64)> = (0..3)
            .filter(|&axis| domain.periodic[axis] && wall.motion.keeps_axis(axis))
            .map(|axis| (axis, min[axis], max[axis] - min[axis]))
            .collect();
        let (low, high) = mesh.bounds();
        let continued = mesh.continued(&periods, REACH * largest_radius);
        let goes_on = |axis: usize| {
            let mesh = continued.as_ref();
            mesh.is_some_and(|mesh| mesh.periods().iter().any(|period| period.axis == axis))
        };
        for &(axis, _, length) in &periods {
            let (extent, letter) = (high[axis] - low[axis], ["x", "y", "z"][axis]);
            let is_longer = extent - length > NEARLY * length;
            if goes_on(axis) && !is_longer && (extent - length).abs() <= 2e-6 * length {
                notes.push(format!(
                    "walls.{}: the mesh spans the periodic axis {letter} and goes on for ever along it",
                    wall.name
                ));
            } else if goes_on(axis) {
                let meant = if is_longer {
                    ""
                } else {
                    "; a mesh of just one period would go on without a seam"
                };
                notes.push(format!(
                    "walls.{}: the mesh is {} m long along the periodic axis {letter}, whose period is {} m: it acts with its images{meant}",
                    wall.name,
                    short(extent),
                    short(length)
                ));
            } else if (extent - length).abs() < NEARLY * length {
                notes.push(format!(
                    "walls.{}: the mesh is {} m long along the periodic axis {letter}, whose period is {} m: it ends there; a mesh of just one period goes on for ever",
                    wall.name,
                    short(extent),
                    short(length)
                ));
            }
        }
        if let Some(mesh) = continued {
            wall.shape = Shape::Mesh(Arc::new(mesh));
        }
    }
}

/// A mesh whose extents have a diagonal of more than this many of the domain's is taken for one in the wrong unit.
const HUGE: f64 = 10.0;

/// A mesh that is smaller than the smallest particle is taken for one in the wrong unit; so is one of less than this many of its diameters that is
/// this much smaller than the domain.
const TINY: [f64; 2] = [5.0, 500.0];

/// Possible errors of the meshes (warnings), and other facts about them (notes).
pub(super) fn remarks(
    scene: &Scene,
    walls: &[Wall],
    (min, max): (DVec3, DVec3),
    smallest_radius: f64,
    warnings: &mut Vec<String>,
    notes: &mut Vec<String>,
) {
    let mut reported = 0;
    for wall in walls {
        let Shape::Mesh(mesh) = &wall.shape else {
            continue;
        };
        let name = &wall.name;
        let left_out = mesh.left_out();
        let precision = mesh.precision();
        match left_out.thin {
            0 => {}
            1 => notes.push(format!(
                "walls.{name}: 1 triangle has no area and is left out: it is thinner than {precision}"
            )),
            count => notes.push(format!(
                "walls.{name}: {count} triangles have no area and are left out: they are thinner than {precision}"
            )),
        }
        if left_out.far > 0 {
            let triangles = match left_out.far {
                1 => "1 triangle is".to_owned(),
                count => format!("{count} triangles are"),
            };
            warnings.push(format!(
                "walls.{name}: {triangles} left out, with a corner more than {} m away: the mesh{} may be damaged",
                short(Mesh::FARTHEST),
                file_of(scene, name)
            ));
        }
        let (low, high) = mesh.bounds();
        let outside = low.cmpgt(max).any() || high.cmplt(min).any();
        let size = (high - low).length();
        let is_huge = size > HUGE * (max - min).length();
        let diameter = 2.0 * smallest_radius;
        let is_tiny = smallest_radius.is_finite()
            && (size < diameter
                || size < TINY[0] * diameter && TINY[1] * size < (max - min).length());
        let what = if outside && wall.motion.is_static() {
            "lies wholly outside the domain".to_owned()
        } else if is_huge {
            "is more than 10 times as large as the domain".to_owned()
        } else if is_tiny {
            let diameter = short(diameter);
            format!("is very small beside the smallest particle, whose diameter is {diameter} m")
        } else {
            continue;
        };
        // In front, as other errors may follow from it.
        let at = reported.min(warnings.len());
        reported += 1;
        warnings.insert(at, format!(
            "walls.{name}: the mesh{} {what}: it reaches from {} to {} m, the domain from {} to {} m; correct its unit by scale (\"1 mm\" for a file in millimetres, 1 for one in metres) and its place by offset",
            file_of(scene, name),
            point(low),
            point(high),
            point(min),
            point(max)
        ));
    }
}

/// The file of a mesh wall, to stand behind "the mesh".
fn file_of(scene: &Scene, name: &str) -> String {
    let mut walls = scene.walls.iter();
    match walls
        .find(|wall| wall.name.value == name)
        .map(|wall| &wall.shape)
    {
        Some(SceneShape::Mesh { mesh: source, .. }) => {
            format!(" of {}", source.file.value.display())
        }
        _ => String::new(),
    }
}

/// Whether the loads on triangles are summed up: if requested, if there are any, and if an output holds them.
pub(super) fn has_triangle_loads(
    walls: &[Wall],
    files: &Switches,
    warnings: &mut Vec<String>,
) -> bool {
    let has_meshes = walls
        .iter()
        .any(|wall| matches!(wall.shape, Shape::Mesh(_)));
    let has_files = files.frames || files.vtk;
    if files.triangle_loads && !has_meshes {
        warnings
            .push("output.triangle_loads: no wall is a mesh, so there are no triangles".to_owned());
    } else if files.triangle_loads && !has_files {
        warnings.push(
            "output.triangle_loads: nothing would hold them, as output.frames and output.vtk are false".to_owned(),
        );
    }
    files.triangle_loads && has_meshes && has_files
}

/// Triangles, edges and extent of a mesh, for the report.
pub(super) fn describe(mesh: &Mesh) -> String {
    let [rims, shared, seams] = mesh.edge_counts();
    let (low, high) = mesh.bounds();
    let triangles = match mesh.len() {
        1 => "1 triangle".to_owned(),
        count => format!("{count} triangles"),
    };
    let mut edges = match (rims, seams) {
        (0, 0) => format!("{shared} shared edges, closed"),
        (rims, _) => format!("{shared} shared edges, {rims} on the rim"),
    };
    if seams > 0 {
        edges.push_str(&format!(", {seams} with more than two triangles"));
    }
    format!("{triangles}, {edges}, {} to {}", point(low), point(high))
}

fn point(x: DVec3) -> String {
    format!("({}, {}, {})", short(x.x), short(x.y), short(x.z))
}

//! Mesh walls: read, placed, and looked over.

use std::sync::Arc;

use glam::DVec3;
use mercury_common::formats::mesh::{TriangleMesh, read_mesh};
use mercury_common::scene::{
    Domain, MeshSide, MeshSource, Scene, SceneError, Shape as SceneShape, Switches,
};
use mercury_common::turns::about_axis;

use mercury_engine::boundaries::Solid;
use mercury_engine::contact::parameter::short;
use mercury_engine::neighbours::Skin;
use mercury_engine::walls::{Mesh, Shape, Wall};

/// Reads the triangles of a wall; `then` moves a corner to where the wall begins.
pub(super) fn mesh(
    source: &MeshSource,
    side: MeshSide,
    then: impl Fn(DVec3) -> DVec3,
) -> Result<Shape, SceneError> {
    let triangles = triangles(source)?;
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

/// Reads the closed mesh of a region.
pub(super) fn solid(source: &MeshSource) -> Result<Solid, SceneError> {
    let triangles = triangles(source)?;
    let place = placement(source);
    let corners: Vec<DVec3> = triangles.vertices.iter().map(|&x| place(x)).collect();
    Solid::new(&corners, &triangles.triangles).map_err(|error| {
        let file = source.file.value.display();
        let error = source.file.error(format!("{file}: {error}"));
        error.with_help("a region is what lies inside a closed surface: close it, or describe the region by other shapes")
    })
}

pub(super) fn triangles(source: &MeshSource) -> Result<TriangleMesh, SceneError> {
    read_mesh(&source.file.value).map_err(|error| source.file.error(error.to_string()))
}

/// Where a corner of the file comes to stand, m: scaled, then turned about the origin, then moved.
pub(super) fn placement(source: &MeshSource) -> impl Fn(DVec3) -> DVec3 {
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

/// Possible errors of the meshes (warnings), and other facts about them (notes).
pub(super) fn remarks(
    scene: &Scene,
    walls: &[Wall],
    (min, max): (DVec3, DVec3),
    warnings: &mut Vec<String>,
    notes: &mut Vec<String>,
) {
    let mut reported = 0;
    for wall in walls {
        let Shape::Mesh(mesh) = &wall.shape else {
            continue;
        };
        let name = &wall.name;
        match mesh.dropped() {
            0 => {}
            1 => notes.push(format!(
                "walls.{name}: 1 triangle has no area and is left out"
            )),
            count => notes.push(format!(
                "walls.{name}: {count} triangles have no area and are left out"
            )),
        }
        let (low, high) = mesh.bounds();
        let outside = low.cmpgt(max).any() || high.cmplt(min).any();
        let is_huge = (high - low).length() > HUGE * (max - min).length();
        let what = match (outside && wall.motion.is_static(), is_huge) {
            (true, _) => "lies wholly outside the domain",
            (_, true) => "is more than 10 times as large as the domain",
            _ => continue,
        };
        // In front, as other errors may follow from it.
        let at = reported.min(warnings.len());
        reported += 1;
        warnings.insert(at, format!(
            "walls.{name}: the mesh{} {what}: it reaches from {} to {} m, the domain from {} to {} m; correct its unit by scale (0.001 for a file in millimetres) and its place by offset",
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

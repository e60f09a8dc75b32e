//! Particles, contacts and walls of one instant as grids.

use std::collections::HashMap;
use std::ops::Range;

use glam::DVec3;

use super::columns::{Group, groups, take_values, vectors};
use crate::formats::vtu::{VtuArray, VtuCells, VtuGrid, VtuValues};
use crate::frames::{
    BondFrame, Column, ColumnSpec, Frame, MembraneFrame, MembraneTriangleFrame, TriangleLoadFrame,
    WallFrame, WearFrame, sheets,
};
use crate::surfaces::{Surface, faces_of_one_box};

/// Particles as points, with every column of the frame, and `diameter` and `speed` for glyphs.
///
/// # Errors
/// When the frame has no positions `x`, `y`, `z`.
pub fn particles(specs: &[ColumnSpec], mut frame: Frame) -> Result<VtuGrid<'static>, String> {
    let groups = groups(specs);
    let vector = |name: &str| {
        groups.iter().find_map(|(found, group)| match group {
            Group::Vector(places) if found == name => vectors(&frame.columns, *places),
            _ => None,
        })
    };
    let points = vector("position").ok_or("no columns x, y, z of positions")?;
    let mut arrays = Vec::new();
    let radius = specs.iter().position(|spec| spec.name == "radius");
    if let Some(radius) = radius.and_then(|k| frame.columns[k].as_f64()) {
        let diameter: Vec<f64> = radius.iter().map(|r| 2.0 * r).collect();
        arrays.push(VtuArray::new("diameter", diameter));
    }
    if let Some(velocity) = vector("velocity") {
        let speed: Vec<f64> = velocity.iter().map(|v| v.length()).collect();
        arrays.push(VtuArray::new("speed", speed));
    }
    push_groups(&mut arrays, &groups, &mut frame.columns, &["position"]);
    Ok(VtuGrid {
        time: Some(frame.time),
        points: points.into(),
        cells: VtuCells::Vertices,
        point_data: arrays,
        cell_data: Vec::new(),
    })
}

fn push_groups(
    arrays: &mut Vec<VtuArray<'static>>,
    groups: &[(String, Group)],
    columns: &mut [Column],
    without: &[&str],
) {
    for (name, group) in groups {
        let taken = arrays.iter().any(|array| array.name == *name);
        if taken || without.contains(&name.as_str()) {
            continue;
        }
        if let Some(values) = take_values(columns, group) {
            arrays.push(VtuArray::new(name.clone(), values));
        }
    }
}

/// Contacts as lines along their branch vectors, with every column of the frame, and `force_magnitude`, `normal_force`
/// (positive where the partners repel each other) and `tangential_force` for tubes. `centre` gives the position of a
/// particle by its id; where the id is not known, the line is laid centrally through the contact point.
///
/// # Errors
/// When a column of a table of contacts is missing.
pub fn contacts(
    specs: &[ColumnSpec],
    mut frame: Frame,
    centre: &HashMap<u32, DVec3>,
) -> Result<VtuGrid<'static>, String> {
    let groups = groups(specs);
    let vector = |name: &str| {
        let found = groups.iter().find_map(|(found, group)| match group {
            Group::Vector(places) if found == name => vectors(&frame.columns, *places),
            _ => None,
        });
        found.ok_or_else(|| format!("no vector {name}"))
    };
    let column = |name: &str| {
        let place = specs.iter().position(|spec| spec.name == name);
        let found = place.and_then(|k| frame.columns.get(k));
        found.ok_or_else(|| format!("no column `{name}`"))
    };
    let (point, branch) = (vector("contact_point")?, vector("branch")?);
    let (normal, force) = (vector("normal")?, vector("force")?);
    let i = column("i")?.as_u32().ok_or("column `i` holds no ids")?;
    let Column::OptionalU32(wall) = column("wall")? else {
        return Err("column `wall` holds no optional indices".to_owned());
    };
    let mut points = Vec::with_capacity(2 * point.len());
    for (k, id) in i.iter().enumerate() {
        let begin = match (wall[k], centre.get(id)) {
            // The branch of a wall contact begins at the contact point.
            (Some(_), _) => point[k] + branch[k],
            (None, Some(&centre)) => centre,
            (None, None) => point[k] + 0.5 * branch[k],
        };
        points.extend([begin, begin - branch[k]]);
    }
    let pairs = || normal.iter().zip(&force);
    let magnitude: Vec<f64> = force.iter().map(|f| f.length()).collect();
    let along: Vec<f64> = pairs().map(|(n, f)| f.dot(*n)).collect();
    let across: Vec<f64> = pairs()
        .map(|(n, f)| (*f - *n * f.dot(*n)).length())
        .collect();
    let both_ends: Vec<f64> = magnitude.iter().flat_map(|&f| [f, f]).collect();
    let mut arrays = vec![
        VtuArray::new("force_magnitude", magnitude),
        VtuArray::new("normal_force", along),
        VtuArray::new("tangential_force", across),
    ];
    let count = i.len() as u32;
    push_groups(&mut arrays, &groups, &mut frame.columns, &[]);
    let lines = (0..count).map(|k| [2 * k, 2 * k + 1]);
    Ok(VtuGrid {
        time: Some(frame.time),
        points: points.into(),
        cells: VtuCells::Lines(lines.collect()),
        // The tube filter takes its radius from points.
        point_data: vec![VtuArray::new("force_magnitude", both_ends)],
        cell_data: arrays,
    })
}

/// Bonds as lines between their ends, with `i`, `j` and `wall` (-1 for none), `bond`, `length`, `force`, `couple`, `tension`, `shear`, and
/// `stress`, the larger of these two.
#[must_use]
pub fn bonds(frame: &BondFrame) -> VtuGrid<'static> {
    let rows = 0..frame.len();
    let or_none = |ids: &[Option<u32>]| -> Vec<i64> {
        let ids = ids.iter().map(|id| id.map_or(-1, i64::from));
        ids.collect()
    };
    let both = frame.tension.iter().zip(&frame.shear);
    let stress: Vec<f64> = both.map(|(tension, shear)| tension.max(*shear)).collect();
    let both_ends: Vec<f64> = stress.iter().flat_map(|&stress| [stress, stress]).collect();
    let length: Vec<f64> = frame.branch.iter().map(|branch| branch.length()).collect();
    let lines: Vec<[u32; 2]> = (rows.clone().map(|row| row as u32))
        .map(|row| [2 * row, 2 * row + 1])
        .collect();
    let points: Vec<DVec3> = rows.flat_map(|row| frame.ends(row)).collect();
    VtuGrid {
        time: Some(frame.time),
        points: points.into(),
        cells: VtuCells::Lines(lines.into()),
        // The tube filter takes its radius from points.
        point_data: vec![VtuArray::new("stress", both_ends)],
        cell_data: vec![
            VtuArray::new("stress", stress),
            VtuArray::new("tension", frame.tension.clone()),
            VtuArray::new("shear", frame.shear.clone()),
            VtuArray::new("i", VtuValues::from(frame.i.clone())),
            VtuArray::new("j", or_none(&frame.j)),
            VtuArray::new("wall", or_none(&frame.wall)),
            VtuArray::new("bond", VtuValues::from(frame.bond.clone())),
            VtuArray::new("length", length),
            VtuArray::new("force", frame.force.clone()),
            VtuArray::new("couple", frame.couple.clone()),
        ],
    }
}

/// The walls of a run, ready to be put where they stand.
#[derive(Debug, Clone)]
pub struct WallScene<'a> {
    /// Names in the order of indices; faces of a box end each other.
    pub names: &'a [String],
    /// One per name.
    pub surfaces: &'a [Surface],
    /// Lower and upper corner of the domain, m.
    pub domain: (DVec3, DVec3),
}

/// Walls as triangles where they stand, with the index of the wall on every triangle; those that are not there are left out. With
/// `loads` each triangle has `pressure`, `shear`, `force` and `slip_power`, which are 0 where there is none. With `wear` meshes are as they
/// are worn, and each point has its `depth`.
///
/// # Errors
/// When `loads` names a triangle that is not there.
pub fn walls(
    scene: &WallScene,
    frame: &WallFrame,
    loads: Option<&TriangleLoadFrame>,
    wear: Option<&WearFrame>,
) -> Result<VtuGrid<'static>, String> {
    let ends = faces_of_one_box(scene.names);
    // Of each wall: where its triangles begin and end.
    let mut spans = Vec::with_capacity(scene.surfaces.len());
    let mut points = Vec::new();
    let mut triangles = Vec::new();
    let mut wall = Vec::new();
    let mut depths = Vec::new();
    let placed = |k: usize| frame.placement.get(k).copied().unwrap_or_default();
    for (k, surface) in scene.surfaces.iter().enumerate() {
        if !frame.present.get(k).copied().unwrap_or(false) {
            spans.push(None);
            continue;
        }
        let ends = ends.get(k).map_or(&[][..], Vec::as_slice);
        let cuts = ends.iter().filter_map(|&other| {
            let present = frame.present.get(other).copied().unwrap_or(false);
            let surface = scene.surfaces.get(other).filter(|_| present)?;
            surface.half_space(&placed(other))
        });
        let cuts: Vec<_> = cuts.collect();
        let worn = match (wear, surface) {
            (Some(wear), Surface::Mesh(mesh)) => Some(wear.worn(k as u32, mesh)),
            _ => None,
        };
        let mesh = match worn {
            Some((mesh, of_mesh)) => {
                depths.extend(of_mesh);
                Surface::Mesh(mesh).triangles(&placed(k), scene.domain, &cuts)
            }
            None => surface.triangles(&placed(k), scene.domain, &cuts),
        };
        let first = points.len() as u32;
        points.extend(mesh.vertices);
        depths.resize(points.len(), 0.0);
        let moved = mesh
            .triangles
            .iter()
            .map(|t| t.map(|corner| first + corner));
        let begin = triangles.len();
        triangles.extend(moved);
        spans.push(Some(begin..triangles.len()));
        wall.resize(triangles.len(), k as u32);
    }
    let mut cell_data = vec![VtuArray::new("wall", VtuValues::from(wall))];
    if let Some(loads) = loads {
        cell_data.extend(load_arrays(loads, &spans, triangles.len())?);
    }
    Ok(VtuGrid {
        time: Some(frame.time),
        points: points.into(),
        cells: VtuCells::Triangles(triangles.into()),
        point_data: (wear.map(|_| VtuArray::new("depth", depths)))
            .into_iter()
            .collect(),
        cell_data,
    })
}

/// Elastic sheets as triangles, with the columns of both frames: `velocity`, `force`, `mass`, `state` and `vertex` at the points; `membrane`,
/// `triangle`, `area`, `tension_1`, `tension_2` and `load` of the triangles.
///
/// # Errors
/// When a triangle has a vertex that is not there.
pub fn membranes(
    vertices: &MembraneFrame,
    triangles: &MembraneTriangleFrame,
) -> Result<VtuGrid<'static>, String> {
    let mut cells = Vec::with_capacity(triangles.membrane.len());
    let mut rows = Vec::with_capacity(triangles.membrane.len());
    for sheet in sheets(vertices, triangles)? {
        // Rows of a sheet follow each other.
        let first = sheet.vertex_rows.first().map_or(0, |&row| row as u32);
        let of_sheet = sheet.mesh.triangles.iter();
        cells.extend(of_sheet.map(|corners| corners.map(|corner| first + corner)));
        rows.extend(sheet.triangle_rows);
    }
    let numbers = |values: &[u32]| -> Vec<u32> { rows.iter().map(|&row| values[row]).collect() };
    let reals = |values: &[f64]| -> Vec<f64> { rows.iter().map(|&row| values[row]).collect() };
    let load: Vec<DVec3> = rows.iter().map(|&row| triangles.load[row]).collect();
    Ok(VtuGrid {
        time: Some(vertices.time),
        points: vertices.position.clone().into(),
        cells: VtuCells::Triangles(cells.into()),
        point_data: vec![
            VtuArray::new("velocity", vertices.velocity.clone()),
            VtuArray::new("force", vertices.force.clone()),
            VtuArray::new("mass", vertices.mass.clone()),
            VtuArray::new("state", VtuValues::from(vertices.state.clone())),
            VtuArray::new("vertex", VtuValues::from(vertices.vertex.clone())),
        ],
        cell_data: vec![
            VtuArray::new("membrane", VtuValues::from(numbers(&triangles.membrane))),
            VtuArray::new("triangle", VtuValues::from(numbers(&triangles.triangle))),
            VtuArray::new("area", reals(&triangles.area)),
            VtuArray::new("tension_1", reals(&triangles.tensions[0])),
            VtuArray::new("tension_2", reals(&triangles.tensions[1])),
            VtuArray::new("load", load),
        ],
    })
}

/// Loads put to the triangles of a grid; `spans` holds the rows of each wall that is there.
fn load_arrays(
    loads: &TriangleLoadFrame,
    spans: &[Option<Range<usize>>],
    count: usize,
) -> Result<[VtuArray<'static>; 4], String> {
    let (mut pressure, mut slip_power) = (vec![0.0; count], vec![0.0; count]);
    let (mut shear, mut force) = (vec![DVec3::ZERO; count], vec![DVec3::ZERO; count]);
    for (row, (&wall, &triangle)) in loads.wall.iter().zip(&loads.triangle).enumerate() {
        let place = match spans.get(wall as usize) {
            // A wall that was removed since the frame before is not drawn.
            Some(None) => continue,
            Some(Some(span)) => Some(span.start + triangle as usize).filter(|k| span.contains(k)),
            None => None,
        };
        let place = place.ok_or_else(|| format!("no triangle {triangle} of wall {wall}"))?;
        pressure[place] = loads.pressure[row];
        shear[place] = loads.shear[row];
        force[place] = loads.force[row];
        slip_power[place] = loads.slip_power[row];
    }
    Ok([
        VtuArray::new("pressure", pressure),
        VtuArray::new("shear", shear),
        VtuArray::new("force", force),
        VtuArray::new("slip_power", slip_power),
    ])
}

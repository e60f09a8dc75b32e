//! Shapes of sheets, in the run and at rest.

use glam::DVec3;
use mercury_common::formats::mesh::{TriangleMesh, read_mesh, read_mesh_in_order};
use mercury_common::scene::{Located, Membrane, MembraneShape, SceneError, SourceSpan};

use crate::plan::meshes::{placement, triangles};
use mercury_engine::membrane::{about_triangles, cylinder, disc, rectangle, sphere};

/// Most triangles of a sheet that is built in.
const MOST_TRIANGLES: f64 = 4e6;

/// Where the mesh is described.
pub(super) fn mesh_place(shape: &MembraneShape) -> &SourceSpan {
    match shape {
        MembraneShape::File(source) => &source.file.place,
        MembraneShape::Rectangle { edge, .. }
        | MembraneShape::Disc { edge, .. }
        | MembraneShape::Cylinder { edge, .. }
        | MembraneShape::Sphere { edge, .. } => &edge.place,
    }
}

pub(super) fn file_of(shape: &MembraneShape) -> String {
    match shape {
        MembraneShape::File(source) => format!("{}: ", source.file.value.display()),
        _ => String::new(),
    }
}

pub(super) fn shape(
    shape: &MembraneShape,
    warnings: &mut Vec<String>,
) -> Result<TriangleMesh, SceneError> {
    use std::f64::consts::{PI, TAU};
    let few = |area: f64, edge: &Located<f64>| {
        let count = about_triangles(area, **edge);
        // Also where it is no number.
        let is_few = count <= MOST_TRIANGLES;
        if is_few {
            return Ok(());
        }
        let error = edge.error(format!(
            "makes about {count:.0} triangles; {MOST_TRIANGLES:.0} are the most"
        ));
        Err(error.with_help("lengths are in metres: make `edge` longer"))
    };
    Ok(match shape {
        MembraneShape::File(source) => {
            let mut mesh = triangles(&source.file, read_mesh_in_order, warnings)?;
            let place = placement(source);
            for vertex in &mut mesh.vertices {
                *vertex = place(*vertex);
            }
            mesh
        }
        MembraneShape::Rectangle {
            corner,
            along,
            across,
            edge,
        } => {
            few(along.length() * across.length(), edge)?;
            rectangle(**corner, **along, **across, **edge)
        }
        MembraneShape::Disc {
            axis,
            origin,
            radius,
            edge,
        } => {
            few(PI * **radius * **radius, edge)?;
            disc(**axis, **origin, **radius, **edge)
        }
        MembraneShape::Cylinder {
            axis,
            origin,
            radius,
            along,
            edge,
        } => {
            few(TAU * **radius * (along[1] - along[0]), edge)?;
            cylinder(**axis, **origin, **radius, **along, **edge)
        }
        MembraneShape::Sphere {
            origin,
            radius,
            edge,
        } => {
            few(2.0 * TAU * **radius * **radius, edge)?;
            sphere(**origin, **radius, **edge)
        }
    })
}

/// Corners of the stress-free triangles.
pub(super) fn rest_of(
    membrane: &Membrane,
    own: Vec<[DVec3; 3]>,
    warnings: &mut Vec<String>,
) -> Result<Vec<[DVec3; 3]>, SceneError> {
    let Some(file) = &membrane.rest else {
        return Ok(own);
    };
    let mesh = triangles(file, read_mesh, warnings)?;
    if mesh.triangles.len() != own.len() {
        let error = file.error(format!(
            "{} has {} triangles, the sheet {}",
            file.value.display(),
            mesh.triangles.len(),
            own.len()
        ));
        return Err(error
            .with_help("the rest shape must have the triangles of the sheet, in the same order"));
    }
    let corners = |place: &dyn Fn(DVec3) -> DVec3| {
        (0..own.len())
            .map(|k| mesh.corners(k).map(place))
            .collect::<Vec<_>>()
    };
    Ok(match &membrane.shape {
        MembraneShape::File(source) => corners(&placement(source)),
        _ => corners(&|x| x),
    })
}

//! The particle table that scenes read, so that a run can begin where another one ended.

use glam::DVec3;
use mercury_common::formats::number::NumberStyle;
use mercury_common::formats::particle_csv::{ParticleRow, push_particle_csv};
use mercury_common::frames::Column;

use super::{Encode, FilePerFrame};
use crate::output::Output;
use crate::{ExportError, Snapshot};

/// The rows of a frame.
///
/// # Errors
/// When it has no positions or radii, or a sphere belongs to a body: the table knows spheres only.
pub fn particle_rows(snapshot: &Snapshot) -> Result<Vec<ParticleRow>, ExportError> {
    let input = |found: String| ExportError::Input(format!("{}: {found}", snapshot.path.display()));
    if let Some(Column::OptionalU32(bodies)) = snapshot.column("body")
        && let Some(body) = bodies.iter().flatten().next()
    {
        return Err(input(format!(
            "the frame has clumps (body {body}), which a table of spheres cannot hold"
        )));
    }
    let radius = snapshot.numbers("radius")?;
    let position = snapshot.vectors(["x", "y", "z"]);
    let position = position.ok_or_else(|| input("no positions x, y, z".to_owned()))?;
    let none = || vec![DVec3::ZERO; radius.len()];
    let velocity = snapshot.vectors(["vx", "vy", "vz"]).unwrap_or_else(none);
    let spin = snapshot.vectors(["wx", "wy", "wz"]).unwrap_or_else(none);
    let film = snapshot.numbers("film_volume").ok();
    let material = snapshot.column("material").and_then(Column::as_u32);
    let name = |row: usize| {
        let index = material?.get(row)?;
        snapshot.header.materials.get(*index as usize).cloned()
    };
    let row = |row: usize| ParticleRow {
        position: position[row],
        radius: radius[row],
        material: name(row),
        velocity: velocity[row],
        angular_velocity: spin[row],
        film_volume: film.map_or(0.0, |film| film[row]),
        line: 0,
    };
    Ok((0..radius.len()).map(row).collect())
}

/// `<prefix>.0000.csv`, ...: the table of every selected frame. A frame without positions or radii, or with clumps, is refused.
pub fn particle_tables(output: &Output) -> FilePerFrame<'_, impl Encode> {
    let encode = |snapshot: &Snapshot, out: &mut Vec<u8>| {
        let rows = particle_rows(snapshot)?;
        push_particle_csv(&rows, NumberStyle::Shortest, out)
            .map_err(|found| ExportError::Input(format!("{}: {found}", snapshot.path.display())))
    };
    FilePerFrame::new(output, "csv", encode)
}

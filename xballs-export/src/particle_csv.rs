//! The particle table that scenes read, so that a run can begin where another one ended.

use std::path::PathBuf;

use glam::DVec3;
use mercury_common::formats::number::NumberStyle;
use mercury_common::formats::particle_csv::{ParticleRow, push_particle_csv};
use mercury_common::frames::Column;

use crate::output::Output;
use crate::{ExportError, Selection, Snapshot, Source, Told, for_each_snapshot};

/// The rows of a frame.
///
/// # Errors
/// When it has no positions or radii, or a sphere belongs to a body: the table knows spheres only.
pub fn rows(snapshot: &Snapshot) -> Result<Vec<ParticleRow>, ExportError> {
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

/// Writes `<prefix>.0000.csv` for every selected frame.
///
/// # Errors
/// As [`rows`], and when the input cannot be read, a file of an earlier export is in the way, or a file cannot be written.
pub fn export(
    source: &Source,
    selection: &Selection,
    output: &Output,
    mut progress: impl FnMut(&Snapshot),
) -> Result<(Told, Vec<PathBuf>), ExportError> {
    let mut files = Vec::new();
    let told = for_each_snapshot(source, selection, |snapshot| {
        progress(&snapshot);
        let mut out = Vec::new();
        push_particle_csv(&rows(&snapshot)?, NumberStyle::Shortest, &mut out)
            .map_err(|found| ExportError::Input(format!("{}: {found}", snapshot.path.display())))?;
        let path = output.path(&format!("{:04}.csv", snapshot.number));
        output.write(&path, &out)?;
        files.push(path);
        Ok(())
    })?;
    Ok((told, files))
}

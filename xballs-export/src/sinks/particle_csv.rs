//! The particle table that scenes read, so that a run can begin where another one ended.

use std::fmt::Write as _;
use std::path::PathBuf;

use glam::DVec3;
use mercury_common::formats::number::NumberStyle;
use mercury_common::formats::particle_csv::{ParticleRow, push_particle_csv};
use mercury_common::frames::Column;
use mercury_common::particle_properties::{FILM_VOLUME, LIQUID_VOLUME, ParticleProperty};

use super::density::Digits;
use super::{Encode, FilePerFrame};
use crate::output::Output;
use crate::{ExportError, Outcome, Sink, Snapshot};

/// How a scene starts from a run with all that a table lacks.
const FROM_RUN: &str = "`[[particles]]` with `run = \"FOLDER\"` starts from the last state of a run of mercury-solve, with its clumps and contacts";

/// The column of frames with what each particle holds in its film and in bridges, m^3.
const WITH_BRIDGES: &str = LIQUID_VOLUME.name;

/// The rows of a frame, with the liquid of bridges in the films.
///
/// # Errors
/// When it has no positions or radii, or a sphere belongs to a body: the table knows spheres only.
pub fn particle_rows(snapshot: &Snapshot) -> Result<Vec<ParticleRow>, ExportError> {
    let input = |found: String| ExportError::Input(format!("{}: {found}", snapshot.path.display()));
    if let Some(Column::OptionalU32(bodies)) = snapshot.column("body")
        && let Some(body) = bodies.iter().flatten().next()
    {
        return Err(input(format!(
            "the frame has clumps (body {body}), which a table of spheres cannot hold\nhelp: {FROM_RUN}"
        )));
    }
    let radius = snapshot.numbers("radius")?;
    let position = snapshot.vectors(["x", "y", "z"]);
    let position = position.ok_or_else(|| input("no positions x, y, z".to_owned()))?;
    let none = || vec![DVec3::ZERO; radius.len()];
    let velocity = snapshot.vectors(["vx", "vy", "vz"]).unwrap_or_else(none);
    let spin = snapshot.vectors(["wx", "wy", "wz"]).unwrap_or_else(none);
    // A table has no bridges: their liquid comes with the films of the particles.
    let column = |property: &'static ParticleProperty| {
        let whole = (*property == FILM_VOLUME).then(|| snapshot.numbers(WITH_BRIDGES).ok());
        let values = whole.flatten();
        Some((
            property,
            values.or_else(|| snapshot.numbers(property.name).ok())?,
        ))
    };
    let properties: Vec<_> = ParticleProperty::given().filter_map(column).collect();
    let material = snapshot.column("material").and_then(Column::as_u32);
    let name = |row: usize| {
        let index = material?.get(row)?;
        snapshot.header.materials.get(*index as usize).cloned()
    };
    let row = |row: usize| ParticleRow {
        position: position[row],
        clump: None,
        radius: radius[row],
        material: name(row),
        velocity: velocity[row],
        angular_velocity: spin[row],
        properties: (properties.iter())
            .map(|(property, values)| (*property, values[row]))
            .filter(|(property, value)| property.differs(*value))
            .collect(),
        line: 0,
    };
    Ok((0..radius.len()).map(row).collect())
}

/// `<prefix>.0000.csv`, ...: the table of every selected frame, and the lines of a scene that starts from the last of them. A
/// frame without positions or radii, or with clumps, is refused.
pub fn particle_tables(output: &Output) -> impl Sink + '_ {
    ParticleTables {
        tables: tables(output),
        scene: String::new(),
    }
}

struct ParticleTables<S> {
    tables: S,
    /// Scene of the last frame, all but the name of its table.
    scene: String,
}

impl<S: Sink> Sink for ParticleTables<S> {
    fn write(&mut self, snapshot: Snapshot) -> Result<(), ExportError> {
        self.scene = scene_lines(&snapshot)?;
        self.tables.write(snapshot)
    }

    fn finish(self: Box<Self>, outcome: &mut Outcome) -> Result<Vec<PathBuf>, ExportError> {
        let files = Box::new(self.tables).finish(outcome)?;
        if let Some(name) = files.last().and_then(|file| file.file_name()) {
            let name = name
                .to_string_lossy()
                .replace('\\', "\\\\")
                .replace('"', "\\\"");
            outcome.to_copy = format!(
                "for a scene beside {name}:\n\n{}file = \"{name}\"\n",
                self.scene
            );
        }
        Ok(files)
    }
}

/// Lines of a scene besides its time and output: the domain, a material for each that occurs, and the particles up to the name of
/// their table.
fn scene_lines(snapshot: &Snapshot) -> Result<String, ExportError> {
    let (min, max) = snapshot.domain()?;
    let mut text = format!(
        "[domain]\nmin = {:?}\nmax = {:?}\n",
        min.to_array(),
        max.to_array()
    );
    let axes = ["x", "y", "z"].into_iter().zip(snapshot.header.periodic);
    let periodic: Vec<&str> = axes.filter(|axis| axis.1).map(|axis| axis.0).collect();
    if !periodic.is_empty() {
        let _ = writeln!(text, "periodic = {periodic:?}");
    }
    let material = snapshot
        .column("material")
        .and_then(Column::as_u32)
        .unwrap_or(&[]);
    let names = &snapshot.header.materials;
    let mut used: Vec<u32> = material.to_vec();
    used.sort_unstable();
    used.dedup();
    // A table names materials only where the input does.
    used.retain(|index| (*index as usize) < names.len());
    let digits = Digits::of(snapshot);
    let density = |index: Option<u32>| {
        let row = match index {
            Some(index) => material.iter().position(|of| *of == index)?,
            None => 0,
        };
        let of = |name: &str| snapshot.numbers(name).ok()?.get(row).copied();
        let density = digits.density(of("mass")?, of("volume")?);
        (density > 0.0 && density.is_finite()).then_some(density)
    };
    let mut entry = |name: &str, density: Option<f64>| {
        let (density, remark) = match density {
            Some(density) => (density, ""),
            None => (2500.0, ": the input does not say"),
        };
        let _ = write!(
            text,
            "\n[materials.{name:?}]\ndensity = {density:?}   # kg/m3{remark}\n\
             normal = {{ law = \"hertz\", youngs_modulus = 1e7, poisson_ratio = 0.3, restitution = 0.8 }}   # Pa: choose\n\
             tangential = {{ law = \"mindlin\", friction = 0.5 }}\n"
        );
    };
    for &index in &used {
        entry(&names[index as usize], density(Some(index)));
    }
    if used.is_empty() {
        entry("grain", density(None));
    }
    text += "\n[[particles]]\n";
    let name = snapshot.path.to_string_lossy();
    if name.ends_with(".particles.arrow") {
        text += "# The laws above are made up. With the materials of the run's own scene, and instead of the table, this starts\n\
                 # from the last state of the run with its contacts: run = \"FOLDER\"\n";
    }
    if used.is_empty() {
        text += "material = \"grain\"\n";
    }
    if snapshot.column(FILM_VOLUME.name).is_some() && snapshot.column(WITH_BRIDGES).is_none() {
        text += "# The column film_volume is that of the films alone: this frame has no column liquid_volume, with what bridges hold.\n";
    }
    Ok(text)
}

fn tables(output: &Output) -> FilePerFrame<'_, impl Encode> {
    let encode = |snapshot: &Snapshot, out: &mut Vec<u8>| {
        let rows = particle_rows(snapshot)?;
        push_particle_csv(&rows, NumberStyle::Shortest, out)
            .map_err(|found| ExportError::Input(format!("{}: {found}", snapshot.path.display())))
    };
    FilePerFrame::new(output, "csv", encode)
}

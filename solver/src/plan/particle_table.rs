//! A table of `[[particles]]`: row by row from its file to particles and bodies, so that a large one is never held twice.

use std::path::PathBuf;

use glam::{DQuat, DVec3};
use mercury_common::error::FormatError;
use mercury_common::formats::particle_csv::{ClumpCells, ParticleRow, ParticleTableReader};
use mercury_common::readable::counted;
use mercury_common::scene::{Located, MaterialIndex, Scene, SceneError, nearest};

use super::particles::{StartingParticles, Typed};
use super::{NewBody, NewParticle};
use mercury_engine::cell::Cell;

/// Facts of an entry about its table.
pub(super) struct Table<'a> {
    pub scene: &'a Scene,
    /// Row in [`Scene::particles`].
    pub entry: usize,
    pub file: &'a Located<PathBuf>,
    /// Material of rows without one.
    pub material: Option<&'a Located<MaterialIndex>>,
    pub fixed: bool,
    /// Length of one unit of its lengths, m.
    pub scale: Option<&'a Located<f64>>,
}

/// Rows that are wrong and reported at once.
const MOST_WRONG: usize = 10;

/// Grain of a row.
enum Grain {
    Sphere(NewParticle),
    Clump(NewBody),
}

impl StartingParticles {
    /// Adds the grains of a table, as far as they are right; all that are wrong are reported, and those beyond [`MOST_WRONG`] counted.
    pub(super) fn read(&mut self, table: &Table<'_>, cell: &Cell) -> Result<(), Vec<SceneError>> {
        let file = table.file;
        let of_reader = |mut error: FormatError| {
            // The reader's advice comes behind the line of the scene, as all advice does.
            let help = error.help.take();
            let error = file.error(error.to_string());
            match help {
                Some(help) => error.with_help(help),
                None => error,
            }
        };
        let mut rows = ParticleTableReader::open(&file.value)
            .map_err(|errors| errors.into_iter().map(of_reader).collect::<Vec<_>>())?;
        if let Some(scale) = table.scale {
            let named = file.display();
            if rows.scale_lengths(scale.value) == 0 {
                let message = format!(
                    "has nothing to scale: the lengths of {named} have units in their header"
                );
                return Err(vec![scale.error(message)]);
            }
            if rows.has_plain_velocities() {
                self.remarks.push(format!(
                    "{named}: velocities are in m/s, as `scale` is for x, y, z and radius; another unit goes into the header, as vx [mm/s]"
                ));
            }
        }
        let ignored: Vec<&str> = rows.ignored().collect();
        if !ignored.is_empty() {
            self.remarks.push(format!(
                "{}: not needed and not read: {}",
                file.display(),
                ignored.join(", ")
            ));
        }
        let before = self.grains();
        let mut errors = Vec::new();
        let mut more = 0;
        for row in rows {
            let grain = row.map_err(of_reader).and_then(|row| {
                let grain = table.grain(&row)?;
                Ok((row, grain))
            });
            let (row, grain) = match grain {
                Ok(right) => right,
                Err(error) if errors.len() < MOST_WRONG => {
                    errors.push(error);
                    continue;
                }
                Err(_) => {
                    more += 1;
                    continue;
                }
            };
            let typed = Typed {
                entry: table.entry,
                line: Some(row.line),
            };
            match grain {
                Grain::Sphere(particle) => self.add(particle, &row.properties, cell, typed),
                Grain::Clump(body) => self.add_body(body, &row.properties, cell, typed),
            }
        }
        if more > 0 {
            let rows = counted(more, "more row");
            let verb = if more == 1 { "is" } else { "are" };
            errors.push(file.error(format!("{}: {rows} {verb} wrong", file.display())));
        }
        if !errors.is_empty() {
            return Err(errors);
        }
        if self.grains() == before {
            let error = file.error(format!("{} has a header and no particle", file.display()));
            let help = "is it the right file? A scene without particles names no table";
            return Err(vec![error.with_help(help)]);
        }
        Ok(())
    }
}

impl Table<'_> {
    fn grain(&self, row: &ParticleRow) -> Result<Grain, SceneError> {
        let place = || format!("{}:{}", self.file.display(), row.line);
        let wrong = |message: String| self.file.error(format!("{}: {message}", place()));
        let moves = row.velocity != DVec3::ZERO || row.angular_velocity != DVec3::ZERO;
        if self.fixed && moves {
            return Err(wrong("a fixed particle has a velocity".to_owned()));
        }
        if let Some(cells) = &row.clump {
            let body = clump_of_row(self.scene, cells, row.material.as_deref()).map_err(wrong)?;
            return Ok(Grain::Clump(NewBody {
                position: row.position,
                velocity: row.velocity,
                angular_velocity: row.angular_velocity,
                fixed: self.fixed,
                ..body
            }));
        }
        let material = self.material_of(row.material.as_deref()).map_err(wrong)?;
        let material = mercury_engine::state::MaterialIndex::new(material.0 as u32);
        Ok(Grain::Sphere(NewParticle {
            velocity: row.velocity,
            angular_velocity: row.angular_velocity,
            fixed: self.fixed,
            ..NewParticle::at(row.position, row.radius, material)
        }))
    }

    fn material_of(&self, name: Option<&str>) -> Result<MaterialIndex, String> {
        let Some(name) = name else {
            let none = "no material: give the column or `material` beside the file";
            return self
                .material
                .map(|material| material.value)
                .ok_or(none.to_owned());
        };
        let mut materials = self.scene.materials.iter();
        let place = materials.position(|material| material.name.value == name);
        place
            .map(MaterialIndex)
            .ok_or_else(|| format!("there is no material named `{name}`"))
    }
}

/// The clump of a row of a table, at rest at the origin.
fn clump_of_row(
    scene: &Scene,
    cells: &ClumpCells,
    material: Option<&str>,
) -> Result<NewBody, String> {
    let name = &cells.name;
    let index = scene.clumps.iter().position(|clump| *clump.name == **name);
    let index = index.ok_or_else(|| {
        let known = scene.clumps.iter().map(|clump| clump.name.as_str());
        match nearest(name, known) {
            Some(near) => format!("there is no clump named `{name}`; did you mean `{near}`?"),
            None => format!("there is no clump named `{name}`: a table [clumps.{name}] makes one"),
        }
    })?;
    if let Some(material) = material {
        return Err(format!(
            "the clump `{name}` has the material `{material}` here: leave the cell empty, [clumps.{name}] names it"
        ));
    }
    let largest = cells
        .orientation
        .iter()
        .fold(0.0_f64, |most, part| most.max(part.abs()));
    let [w, x, y, z] = cells.orientation.map(|part| part / largest);
    Ok(NewBody {
        orientation: DQuat::from_xyzw(x, y, z, w).normalize(),
        scale: cells.scale,
        ..NewBody::at(DVec3::ZERO, index as u32)
    })
}

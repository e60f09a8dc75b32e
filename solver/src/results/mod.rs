//! Numbers of a run by name: `torque = "mean(walls.drum.ty, 1..2)"`.
//!
//! The requested results are checked against the plan before a run ([`NamedResult::check`]), and read from the files of the run
//! when it is over, with their errors where one run has them.

mod estimate;
mod grammar;
mod planned_rows;
mod reading;
mod until;
mod values;

pub use planned_rows::PlannedRows;
pub(crate) use reading::lost;
pub use until::{Aims, Wanted, requested};

use crate::output::{counted_materials, particle_columns};
use crate::plan::Plan;
use grammar::{Function, Source, Window};
use mercury_common::frames::{ParticleColumns, ParticleFrame, Table as _};
use mercury_common::particle_properties::{LIQUID_VOLUME, PARTICLE_PROPERTIES};
use mercury_common::run_tables::{ENERGIES, TableSpec};
use mercury_common::scene::{listed, nearest};

/// A number to report of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedResult {
    /// Its name, that of its column.
    pub name: String,
    text: String,
    function: Function,
    source: Source,
    /// Denominator of a ratio.
    over: Option<Source>,
    window: Window,
}

impl NamedResult {
    /// Definition of the result, as it was written.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The SI unit of its values; `1` where they have none.
    #[must_use]
    pub fn unit(&self) -> String {
        let of_column = |table: &TableSpec, column: &str| {
            let known = table.column(column);
            known.map_or("1", |column| column.unit)
        };
        let unit = match &self.source {
            _ if matches!(self.function, Function::Slope | Function::Tilt) => "deg",
            _ if self.function == Function::Ratio => {
                let units = [Some(&self.source), self.over.as_ref()].map(|source| match source {
                    Some(Source::Rows { table, column, .. }) => of_column(table, column),
                    Some(Source::Energy { column }) => of_column(&ENERGIES, column),
                    _ => "1",
                });
                return match units {
                    [above, below] if above == below => "1".to_owned(),
                    [above, "1"] => above.to_owned(),
                    [above, below] if below.contains([' ', '/']) => format!("{above}/({below})"),
                    [above, below] => format!("{above}/{below}"),
                };
            }
            Source::Rows { table, column, .. } => of_column(table, column),
            Source::Energy { column } => of_column(&ENERGIES, column),
            Source::Particles { column } if column == "speed" => "m/s",
            Source::Particles { column } => {
                return particle_unit(column).unwrap_or_else(|| "1".to_owned());
            }
        };
        match (self.function, unit) {
            (Function::Rate, "1") => "1/s".to_owned(),
            (Function::Rate, "s") => "1".to_owned(),
            (Function::Rate, unit) => format!("{unit}/s"),
            (_, unit) => unit.to_owned(),
        }
    }

    /// Whether the outputs of this plan contain what the result needs.
    ///
    /// # Errors
    /// The run does not write the file or the column; the message lists those that it writes.
    pub fn check(&self, plan: &Plan) -> Result<(), String> {
        let files = plan.outputs().files();
        let off = |key: &str, file: &str| {
            format!(
                "{} needs {file}, and output.{key} = false leaves it out\nhelp: set output.{key} = true, or leave the key out",
                self.text
            )
        };
        if self.function == Function::Tilt {
            for (key, file, is_there) in [
                ("ene", ".ene", files.ene),
                ("frames", ".particles.arrow", files.frames),
            ] {
                if !is_there {
                    return Err(off(key, file));
                }
            }
        }
        match &self.source {
            Source::Rows {
                table,
                name,
                material,
                ..
            } => {
                let tracks = files.track_names();
                let names: Vec<&str> = match table.name() {
                    "track" => tracks.iter().map(String::as_str).collect(),
                    "walls" => (plan.physics().walls.iter())
                        .map(|wall| wall.name.as_str())
                        .collect(),
                    "regions" => (plan.outputs().regions().iter())
                        .map(|region| region.name.as_str())
                        .collect(),
                    _ => (plan.outputs().fluxes().iter())
                        .map(|flux| flux.name.as_str())
                        .collect(),
                };
                there_is(table.row_of, name, &names)?;
                if table.name() == "track" {
                    return Ok(());
                }
                if table.name() == "walls" {
                    return match files.walls {
                        true => Ok(()),
                        false => Err(off("walls", ".walls.csv")),
                    };
                }
                let materials = counted_materials(plan);
                let materials: Vec<&str> =
                    materials.iter().map(|(_, name)| name.as_str()).collect();
                match material {
                    Some(material) => there_is("material of particles", material, &materials),
                    None if materials.len() > 1 => Err(format!(
                        "`{name}` has rows of several materials\nhelp: name one of them: {}.{name}.MATERIAL.COLUMN; there are: {}",
                        table.name(),
                        listed(materials)
                    )),
                    None => Ok(()),
                }
            }
            Source::Energy { .. } if !files.ene => Err(off("ene", ".ene")),
            Source::Energy { .. } => Ok(()),
            Source::Particles { .. } if !files.frames => Err(off("frames", ".particles.arrow")),
            Source::Particles { column } if column == "speed" => Ok(()),
            Source::Particles { column } => {
                let columns = particle_columns(plan);
                let names: Vec<&str> = columns.iter().map(|spec| spec.name.as_str()).collect();
                there_is("column of particles", column, &names)
            }
        }
    }
}

/// The unit of a column of frames of particles.
fn particle_unit(column: &str) -> Option<String> {
    let properties = PARTICLE_PROPERTIES.iter().chain([&LIQUID_VOLUME]);
    let all = ParticleColumns::all().with_properties(properties);
    let specs = ParticleFrame::specs(&all);
    let spec = specs.into_iter().find(|spec| spec.name == column)?;
    // As the other tables write it.
    Some(spec.unit.replace('^', ""))
}

/// Whether a name is among those of its kind.
fn there_is(what: &str, name: &str, names: &[&str]) -> Result<(), String> {
    if names.contains(&name) {
        return Ok(());
    }
    let help = match nearest(name, names.iter().copied()) {
        Some(near) => format!("\nhelp: did you mean `{near}`?"),
        None if names.is_empty() => String::new(),
        None => format!("\nhelp: there are: {}", listed(names.iter().copied())),
    };
    Err(format!("there is no {what} `{name}`{help}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_those_of_the_columns() {
        for (text, unit) in [
            ("mean(walls.drum.ty)", "N m"),
            ("std(walls.drum.wz)", "rad/s"),
            ("max(regions.bed.solid_fraction)", "1"),
            ("sum(flux.out.mass)", "kg"),
            ("rate(flux.out.mass, 1.0..)", "kg/s"),
            ("rate(flux.out.forward)", "1/s"),
            ("rate(walls.lid.z)", "m/s"),
            ("max(track.ball.fz)", "N"),
            ("last(energy.traKineticEnergy)", "J"),
            ("rate(energy.elasticEnergy)", "J/s"),
            ("max(particles.z)", "m"),
            ("max(particles.volume)", "m3"),
            ("mean(particles.speed)", "m/s"),
            ("slope(particles)", "deg"),
            ("tilt(walls.drum, steady..)", "deg"),
            ("ratio(walls.lid.fx, walls.lid.fz, 1..)", "1"),
            ("ratio(walls.lid.power, walls.lid.vx)", "W/(m/s)"),
        ] {
            assert_eq!(NamedResult::new("x", text).unwrap().unit(), unit, "{text}");
        }
    }
}

//! Writing particle tables.

use std::path::Path;

use super::{CLUMP, COLUMNS, MATERIAL, ParticleRow};
use crate::error::FormatError;
use crate::formats::delimited::push_cell;
use crate::formats::number::{NumberStyle, push_number};
use crate::particle_properties::ParticleProperty;

/// Writes a particle table that reads back exactly (but for [`ParticleRow::line`]).
///
/// # Errors
/// If the file cannot be written, or the name of a material cannot stand in a table.
pub fn write_particle_csv(
    path: impl AsRef<Path>,
    particles: &[ParticleRow],
) -> Result<(), FormatError> {
    let path = path.as_ref();
    let mut out = Vec::new();
    push_particle_csv(particles, NumberStyle::Shortest, &mut out)
        .map_err(|found| FormatError::of_file(path, found))?;
    crate::formats::write_bytes(path, &out)
}

/// Appends a table. The columns material and those of properties are left out if no particle uses them.
///
/// # Errors
/// A message if there is a clump among them, or the name of a material is empty or has a quote, a line end, or blanks at its ends: such a name would not
/// read back.
pub fn push_particle_csv(
    particles: &[ParticleRow],
    style: NumberStyle,
    out: &mut Vec<u8>,
) -> Result<(), String> {
    let with_material = particles.iter().any(|particle| particle.material.is_some());
    let used = |index: usize| match COLUMNS[index] {
        "material" => with_material,
        // It writes spheres only.
        _ => index < CLUMP,
    };
    let columns: Vec<usize> = (0..COLUMNS.len()).filter(|&index| used(index)).collect();

    let value = |particle: &ParticleRow, property: &ParticleProperty| {
        let mut given = particle.properties.iter();
        let found = given.find(|(known, _)| known.name == property.name);
        found.map_or(property.default, |(_, value)| *value)
    };
    let is_used = |property: &&ParticleProperty| {
        let mut particles = particles.iter();
        particles.any(|particle| property.differs(value(particle, property)))
    };
    let properties: Vec<_> = ParticleProperty::given().filter(is_used).collect();
    let names = columns.iter().map(|&index| COLUMNS[index]);
    let names: Vec<&str> = names
        .chain(properties.iter().map(|property| property.name))
        .collect();
    out.extend_from_slice(names.join(",").as_bytes());
    out.push(b'\n');
    out.reserve(particles.len() * 200);
    for particle in particles {
        if particle.clump.is_some() {
            return Err("a table of spheres cannot hold a clump".to_owned());
        }
        let (x, v, w) = (
            particle.position,
            particle.velocity,
            particle.angular_velocity,
        );
        let values = [
            x.x,
            x.y,
            x.z,
            particle.radius,
            0.0,
            v.x,
            v.y,
            v.z,
            w.x,
            w.y,
            w.z,
        ];
        for (place, &index) in columns.iter().enumerate() {
            if place > 0 {
                out.push(b',');
            }
            if index == MATERIAL {
                push_material(out, particle.material.as_deref())?;
            } else {
                let style = if index < 3 {
                    style.for_positions()
                } else {
                    style
                };
                push_number(out, values[index], style);
            }
        }
        for property in &properties {
            out.push(b',');
            push_number(out, value(particle, property), style);
        }
        out.push(b'\n');
    }
    Ok(())
}

fn push_material(out: &mut Vec<u8>, material: Option<&str>) -> Result<(), String> {
    let Some(name) = material else { return Ok(()) };
    if name.is_empty() || name.trim() != name || name.contains(['"', '\n', '\r']) {
        return Err(format!(
            "the name of the material {name:?} cannot be written to a table"
        ));
    }
    push_cell(out, name);
    Ok(())
}

//! Numbers of particles beyond place, motion, size and material: the one table of them.
//!
//! Its entries are the keys of `[[particles]]` and `[[insertions]]`, the columns of particle tables and of frames, and the columns of the
//! engine. `docs/how-to/add-a-column.md` describes how to add one.

use crate::scene::Range;

/// A number that each particle may have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParticleProperty {
    /// Its name everywhere: key, column.
    pub name: &'static str,
    /// SI unit as scenes write it: `m3`, `W/m2`.
    pub unit: &'static str,
    /// Meaning of the property, as frames describe it.
    pub meaning: &'static str,
    /// The value of a particle for which none is given.
    pub default: f64,
    /// How scenes and tables give it; `None`: it is computed.
    pub given: Option<GivenProperty>,
    /// Value of a clump, from those of its pebbles.
    pub of_clump: OfClump,
}

/// How a scene gives a property.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GivenProperty {
    /// Permitted values.
    pub range: Range,
    /// A value to copy.
    pub example: &'static str,
    /// Meaning of the key, for the users' page.
    pub text: &'static str,
}

/// Relation between the value of a clump and those of its pebbles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OfClump {
    /// Their sum, spread over them by their surfaces.
    Sum,
    /// Their mean; each begins with it.
    Mean,
}

/// Volume of the liquid film.
pub const FILM_VOLUME: ParticleProperty = ParticleProperty {
    name: "film_volume",
    unit: "m3",
    meaning: "volume of the liquid film",
    default: 0.0,
    given: Some(GivenProperty {
        range: Range::NonNegative,
        example: "1e-12",
        text: "liquid on its surface; for a clump that of all its pebbles, equal on each",
    }),
    of_clump: OfClump::Sum,
};

/// Volume of the liquid that the particle holds in its film and in bridges. It follows from the state when a frame is written: the engine has no
/// column of it.
pub const LIQUID_VOLUME: ParticleProperty = ParticleProperty {
    name: "liquid_volume",
    unit: "m3",
    meaning: "volume of the liquid: film, half of each bridge to a particle, all of each to a wall",
    default: 0.0,
    given: None,
    of_clump: OfClump::Sum,
};

/// All that the engine keeps, in the order of files.
pub const PARTICLE_PROPERTIES: &[ParticleProperty] = &[FILM_VOLUME];

/// A property and its value, SI.
pub type PropertyValue = (&'static ParticleProperty, f64);

impl ParticleProperty {
    /// The property of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        PARTICLE_PROPERTIES.iter().find(|known| known.name == name)
    }

    /// Properties that scenes and tables give.
    pub fn given() -> impl Iterator<Item = &'static Self> {
        PARTICLE_PROPERTIES
            .iter()
            .filter(|property| property.given.is_some())
    }

    /// Its unit as frames write it: `m^3`.
    ///
    /// ```
    /// use mercury_common::particle_properties::FILM_VOLUME;
    ///
    /// assert_eq!(FILM_VOLUME.unit_of_frames(), "m^3");
    /// ```
    #[must_use]
    pub fn unit_of_frames(&self) -> String {
        let mut unit = String::new();
        for symbol in self.unit.chars() {
            let begins_power = symbol.is_ascii_digit() || symbol == '-';
            if begins_power && unit.ends_with(|last: char| last.is_ascii_alphabetic()) {
                unit.push('^');
            }
            unit.push(symbol);
        }
        unit
    }

    /// Whether a value is another than the default, so that it has to be kept.
    #[must_use]
    pub fn differs(&self, value: f64) -> bool {
        value.to_bits() != self.default.to_bits()
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// The page of frames has a row for each property, in the order of files, between the torque and the liquid.
    #[test]
    fn the_page_of_frames_has_the_properties() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/formats/frames.md");
        let page = std::fs::read_to_string(&path).expect("the page can be read");
        let begin = page.find("| `tx ty tz`").expect("the torque has a row");
        let begin = begin + page[begin..].find('\n').expect("the row ends") + 1;
        let end = page
            .find("| `liquid_volume`")
            .expect("the liquid has a row");
        let row = |property: &ParticleProperty| {
            let (name, unit) = (property.name, property.unit_of_frames());
            format!(
                "| `{name}` (optional) | float64 | {unit} | {} |\n",
                property.meaning
            )
        };
        let rows: String = PARTICLE_PROPERTIES.iter().map(row).collect();
        if std::env::var_os("MERCURY_BLESS").is_some() {
            let written = format!("{}{rows}{}", &page[..begin], &page[end..]);
            std::fs::write(&path, written).expect("the page can be written");
        } else {
            assert_eq!(
                page[begin..end],
                rows,
                "{} is behind the properties; MERCURY_BLESS=1 cargo test -p common --lib particle_properties writes them",
                path.display()
            );
        }
    }
}

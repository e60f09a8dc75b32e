//! Numbers of particles beyond the record, each in a column that exists only where the plan has it.
//!
//! New particles get the default, the sort moves values along, and checkpoints hold them. A column that scenes give and frames
//! write is a [property](mercury_common::particle_properties), whose column is there where the [`Inputs`](crate::physics::Inputs)
//! name it; a part of the step may add others for itself (`docs/how-to/add-a-column.md`).

use mercury_common::particle_properties::{OfClump, ParticleProperty};

use super::{Particle, Particles, Plain};

/// One number of each particle.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its name in frames and tables.
    pub name: String,
    /// The value of a new particle.
    pub default: f64,
    /// Row by row.
    pub values: Vec<f64>,
}

crate::state::plain!(Column {
    name,
    default,
    values
});

/// All such columns of a run, in a fixed order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Columns(Vec<Column>);

impl Columns {
    /// Adds a column for rows that are there, filled with the default.
    pub fn add(&mut self, name: &str, default: f64, rows: usize) {
        self.0.push(Column {
            name: name.to_owned(),
            default,
            values: vec![default; rows],
        });
    }

    /// The column of this name, row by row.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&[f64]> {
        let column = self.0.iter().find(|column| column.name == name)?;
        Some(&column.values)
    }

    /// The column of this name, to be changed.
    #[must_use]
    pub fn get_mut(&mut self, name: &str) -> Option<&mut [f64]> {
        let column = self.0.iter_mut().find(|column| column.name == name)?;
        Some(&mut column.values)
    }

    /// Names, in order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|column| column.name.as_str())
    }

    /// Whether these have the names of the others.
    ///
    /// # Errors
    /// If not: both lists.
    pub fn check_names(&self, planned: &Self) -> Result<(), String> {
        if self.names().eq(planned.names()) {
            return Ok(());
        }
        let list = |columns: &Self| match columns.names().collect::<Vec<_>>().as_slice() {
            [] => "none".to_owned(),
            some => some.join(", "),
        };
        Err(format!(
            "its particles have these further columns: {}; those of the plan: {}",
            list(self),
            list(planned)
        ))
    }

    /// Number of columns.
    #[must_use]
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// A particle more.
    pub(super) fn push(&mut self) {
        for column in &mut self.0 {
            column.values.push(column.default);
        }
    }

    /// Does the same to all columns.
    pub(super) fn for_each(&mut self, change: impl FnMut(&mut Vec<f64>)) {
        self.0
            .iter_mut()
            .map(|column| &mut column.values)
            .for_each(change);
    }

    /// Whether each has an entry for each row.
    pub(super) fn have(&self, rows: usize) -> bool {
        self.0.iter().all(|column| column.values.len() == rows)
    }
}

impl Plain for Columns {
    fn put(&self, bytes: &mut Vec<u8>) {
        self.0.put(bytes);
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        Plain::take(bytes).map(Self)
    }
}

/// Values of a property at the start that are not the default.
#[derive(Debug, Clone, PartialEq)]
pub struct StartValues {
    /// Property of the values.
    pub property: &'static ParticleProperty,
    /// Number of the particle, in the order of the start, and value, SI.
    pub particles: Vec<(usize, f64)>,
    /// Number of the body, in the order of the start, and value, SI.
    pub bodies: Vec<(usize, f64)>,
}

impl StartValues {
    /// None yet.
    #[must_use]
    pub fn new(property: &'static ParticleProperty) -> Self {
        Self {
            property,
            particles: Vec::new(),
            bodies: Vec::new(),
        }
    }
}

impl Particles {
    /// Adds the column of a property, where rows are particles and bodies of the start in their order.
    pub(crate) fn begin(&mut self, property: &ParticleProperty, start: Option<&StartValues>) {
        let rows = self.len();
        self.columns.add(property.name, property.default, rows);
        for &(row, value) in start.iter().flat_map(|start| &start.particles) {
            self.give(property, &[row], value);
        }
        for &(body, value) in start.iter().flat_map(|start| &start.bodies) {
            let rows: Vec<usize> = match &self.bodies {
                Some(bodies) => {
                    let pebbles = &bodies.pebbles[bodies.all[body].pebbles()];
                    pebbles.iter().map(|pebble| pebble.row.index()).collect()
                }
                None => continue,
            };
            self.give(property, &rows, value);
        }
    }

    /// Gives a grain a value: a particle, or a body with the rows of all its pebbles.
    pub(crate) fn give(&mut self, property: &ParticleProperty, rows: &[usize], value: f64) {
        let Some(values) = self.columns.get_mut(property.name) else {
            return;
        };
        match property.of_clump {
            OfClump::Sum => spread(value, rows, &self.records, values),
            OfClump::Mean => rows.iter().for_each(|&row| values[row] = value),
        }
    }
}

/// Spreads an amount over spheres by their surfaces.
fn spread(amount: f64, rows: &[usize], records: &[Particle], values: &mut [f64]) {
    let surface = |row: usize| records[row].radius * records[row].radius;
    let mut whole: f64 = rows.iter().map(|&row| surface(row)).sum();
    let mut rest = amount;
    for &row in rows {
        let share = if surface(row) < whole {
            rest * (surface(row) / whole)
        } else {
            rest
        };
        whole -= surface(row);
        values[row] = share;
        rest -= share;
    }
    if let Some(&first) = rows.first() {
        values[first] += rest;
    }
}

#[cfg(test)]
mod tests {
    use mercury_common::particle_properties::FILM_VOLUME;
    use proptest::prelude::*;

    use super::*;
    use crate::state::{Material, MaterialIndex, NewParticle};

    proptest! {
        /// Sums of an amount are kept to round-off, and no share is negative; of other numbers each row has the value.
        #[test]
        fn values_of_a_grain_of_several_rows(
            radii in prop::collection::vec(1e-4..1e-2_f64, 1..20),
            value in 0.0..1e-9_f64,
        ) {
            let temperature = ParticleProperty {
                name: "temperature",
                default: 293.15,
                of_clump: OfClump::Mean,
                ..FILM_VOLUME
            };
            let mut particles = Particles::default();
            let material = Material { name: "m".to_owned(), density: 1.0 };
            for &radius in &radii {
                let new = NewParticle::at(glam::DVec3::ZERO, radius, MaterialIndex::new(0));
                let (record, mass, _) = new.build(std::slice::from_ref(&material), 3);
                particles.push(record, mass, None);
            }
            particles.begin(&FILM_VOLUME, None);
            particles.begin(&temperature, None);
            let rows: Vec<usize> = (1..radii.len()).collect();
            particles.give(&FILM_VOLUME, &rows, value);
            particles.give(&temperature, &rows, value);
            let films = particles.columns.get(FILM_VOLUME.name).unwrap();
            let sum: f64 = films.iter().sum();
            let expected = if rows.is_empty() { 0.0 } else { value };
            prop_assert!((sum - expected).abs() <= 20.0 * f64::EPSILON * value);
            prop_assert!(films.iter().all(|&film| film >= 0.0) && films[0] == 0.0);
            let temperatures = particles.columns.get("temperature").unwrap();
            prop_assert_eq!(temperatures[0], 293.15);
            prop_assert!(temperatures[1..].iter().all(|&given| given == value));
        }
    }
}

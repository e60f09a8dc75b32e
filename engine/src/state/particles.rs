//! All particles of a run, row by row.

use glam::{DQuat, DVec3};
use rayon::prelude::*;

use super::{
    Bodies, Body, BodyIndex, BodyPebble, Columns, FIXED, Id, Load, PEBBLE, PRESCRIBED, Particle,
    PebbleIndex, PrescribedBody, Row, Unpaired,
};

/// Components of motion that a scene prescribes for one particle; `None` is free.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prescribed {
    /// Row of the particle, kept up to date by [`Particles::keep`].
    pub row: Row,
    /// Velocity components, m/s.
    pub velocity: [Option<f64>; 3],
    /// Angular velocity components, rad/s.
    pub angular_velocity: [Option<f64>; 3],
}

/// A new row, from which its columns take their values.
struct NewRow {
    record: Particle,
    /// kg
    mass: f64,
    id: u32,
}

/// A column of rows, which may be absent.
trait RowColumn {
    type Value;
    /// Bytes of a row in a column that all scenes have.
    const ALWAYS: usize;
    fn push_row(&mut self, value: impl FnOnce() -> Self::Value);
    /// Row `order[k]` becomes row `k`.
    fn gather(&mut self, order: &[u32], parallel: bool);
    /// Whether it has so many entries, if it is there.
    fn has(&self, rows: usize) -> bool;
}

impl<T: Copy + Send + Sync> RowColumn for Vec<T> {
    type Value = T;
    const ALWAYS: usize = size_of::<T>();

    fn push_row(&mut self, value: impl FnOnce() -> T) {
        self.push(value());
    }

    fn gather(&mut self, order: &[u32], parallel: bool) {
        gather(self, order, parallel);
    }

    fn has(&self, rows: usize) -> bool {
        self.len() == rows
    }
}

impl<C: RowColumn> RowColumn for Option<C> {
    type Value = C::Value;
    const ALWAYS: usize = 0;

    fn push_row(&mut self, value: impl FnOnce() -> C::Value) {
        if let Some(column) = self {
            column.push_row(value);
        }
    }

    fn gather(&mut self, order: &[u32], parallel: bool) {
        if let Some(column) = self {
            column.gather(order, parallel);
        }
    }

    fn has(&self, rows: usize) -> bool {
        self.as_ref().is_none_or(|column| column.has(rows))
    }
}

/// Makes [`Particles`] from the table of its columns. Of each: name, type (a `Vec`, or an `Option` of one for a column that some scenes have), the value
/// of a new row, and whether a sort of the rows gathers it or leaves it to the list that is made for the new order. Checkpoints hold the columns under
/// `saved`; those under `derived` are absent until they are computed again. All that happens to every column is made from this table.
macro_rules! row_columns {
    (
        saved { $($(#[$doc:meta])* $name:ident: $column:ty, $new:expr, gathered: $gathered:literal;)* }
        derived { $($(#[$derived_doc:meta])* $derived:ident: $derived_column:ty, $derived_new:expr;)* }
    ) => {
        /// All particles of a run. Every column that is present has one entry per row.
        #[derive(Debug, Clone, PartialEq, Default)]
        pub struct Particles {
            $($(#[$doc])* pub $name: $column,)*
            $($(#[$derived_doc])* pub $derived: $derived_column,)*
            /// Further numbers of each particle, where the plan has any.
            pub columns: Columns,
            /// Particles with prescribed components, in no particular order; few.
            pub prescribed: Vec<Prescribed>,
            /// Rigid bodies, whose pebbles are rows; only in scenes with clumps.
            pub bodies: Option<Bodies>,
            /// Pairs without contact, beside the pebbles of one body: named anew by what excludes them when a state is taken back.
            pub unpaired: Unpaired,
            /// The id of the next particle.
            pub next_id: u32,
        }

        impl Particles {
            /// Bytes of a row in the columns that all scenes have.
            const ROW: usize = 0 $(+ <$column as RowColumn>::ALWAYS)*;

            fn push_row(&mut self, row: &NewRow) {
                $(self.$name.push_row(|| ($new)(row));)*
                $(self.$derived.push_row(|| ($derived_new)(row));)*
                self.columns.push();
            }

            /// Row `order[k]` becomes row `k`. `all`: also in the columns that a sort leaves to the new list.
            fn gather_rows(&mut self, order: &[u32], all: bool, parallel: bool) {
                $(if all || $gathered {
                    self.$name.gather(order, parallel);
                })*
                $(self.$derived.gather(order, parallel);)*
                self.columns.for_each(|column| gather(column, order, parallel));
            }

            /// Whether every column has so many entries.
            fn columns_have(&self, rows: usize) -> bool {
                $(self.$name.has(rows) &&)* $(self.$derived.has(rows) &&)* self.columns.have(rows)
            }
        }

        crate::state::plain!(Particles {
            $($name,)*
            columns,
            prescribed,
            bodies,
            next_id;
            unpaired, $($derived),*
        });
    };
}

row_columns! {
    saved {
        /// The records that the contact loop reads.
        records: Vec<Particle>, |row: &NewRow| row.record, gathered: true;
        /// The loads of the contacts in the last force evaluation.
        loads: Vec<Load>, |_: &NewRow| Load::default(), gathered: false;
        /// The number by which users identify the particle: 0, 1, 2 ... in order of creation, never reused.
        ids: Vec<Id>, |row: &NewRow| Id::new(row.id), gathered: true;
        /// Mass, kg (per unit length in 2D); also of fixed particles. A pebble has its share of the body's mass here
        /// ([`crate::bodies::Clump::shares`]), so that sums over rows are right; contacts take the mass from the record.
        masses: Vec<f64>, |row: &NewRow| row.mass, gathered: true;
        /// Position when the neighbour list was built, m.
        listed_at: Vec<DVec3>, |row: &NewRow| row.record.position, gathered: false;
        /// Rotation since creation, only when an output needs it.
        orientations: Option<Vec<DQuat>>, |_: &NewRow| DQuat::IDENTITY, gathered: true;
    }
    derived {
        /// Thickness (m) and volume (m^3) of the liquid film in this step, where bridges form as films meet.
        films: Option<Vec<[f64; 2]>>, |_: &NewRow| [0.0; 2];
    }
}

impl Particles {
    /// No particles yet; `with_orientation` decides whether rotations are integrated.
    #[must_use]
    pub fn new(with_orientation: bool) -> Self {
        Self {
            orientations: with_orientation.then(Vec::new),
            ..Self::default()
        }
    }

    /// Bytes of a row in all columns, for estimates of memory.
    #[must_use]
    pub fn bytes_per_row(with_orientation: bool) -> usize {
        let orientation = if with_orientation {
            size_of::<DQuat>()
        } else {
            0
        };
        Self::ROW + orientation
    }

    /// Bytes of all columns and bodies.
    #[must_use]
    pub fn bytes(&self) -> f64 {
        let rows = self.len() as f64;
        let bodies = self.bodies.as_ref().map_or(0.0, |bodies| {
            Bodies::bytes(bodies.all.len() as f64, bodies.pebbles.len() as f64, rows)
        });
        let columns = (self.columns.len() * size_of::<f64>()) as f64;
        rows * (Self::bytes_per_row(self.orientations.is_some()) as f64 + columns) + bodies
    }

    /// Number of particles.
    #[must_use]
    pub fn len(&self) -> usize {
        self.records.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.records.is_empty()
    }

    /// Appends a particle of the given mass (kg) and returns its id.
    pub fn push(&mut self, record: Particle, mass: f64, prescribed: Option<Prescribed>) -> u32 {
        let id = self.next_id;
        self.next_id += 1;
        if let Some(prescribed) = prescribed {
            self.prescribed.push(Prescribed {
                row: Row::new(self.records.len()),
                ..prescribed
            });
        }
        if let Some(bodies) = &mut self.bodies {
            bodies.of_row.push(None);
        }
        self.push_row(&NewRow { record, mass, id });
        id
    }

    /// Appends a body, its pebbles as rows: records and shares of the body's mass (kg), and where the body has them (principal
    /// frame, m). Places in [`Bodies`], ids and rows are filled in here. Returns the id of the body.
    pub fn push_body(
        &mut self,
        body: Body,
        pebbles: impl Iterator<Item = (Particle, f64, DVec3)>,
        prescribed: Option<PrescribedBody>,
    ) -> u32 {
        let mut bodies = self.bodies.take().unwrap_or_default();
        bodies.of_row.resize(self.len(), None);
        let (index, first) = (
            BodyIndex::new(bodies.all.len()),
            bodies.pebbles.len() as u32,
        );
        let id = self.next_id;
        for (record, mass, offset) in pebbles {
            let pebble = PebbleIndex::new(bodies.pebbles.len());
            bodies.of_row.push(Some(pebble));
            bodies.pebbles.push(BodyPebble {
                body: index,
                row: Row::new(self.len()),
                offset,
                // Until the first list every pebble is at its place in the body.
                shift: DVec3::ZERO,
            });
            self.push(record, mass, None);
        }
        let count = bodies.pebbles.len() as u32 - first;
        bodies.extra_ids += count.saturating_sub(1);
        bodies.all.push(Body {
            id: Id::new(id),
            first,
            count,
            ..body
        });
        bodies
            .prescribed
            .extend(prescribed.map(|prescribed| PrescribedBody {
                body: index,
                ..prescribed
            }));
        self.bodies = Some(bodies);
        id
    }

    /// Keeps the rows that `stay` names, in that order.
    pub fn keep(&mut self, stay: &[u32]) {
        self.follow(stay);
        self.gather_rows(stay, true, false);
    }

    /// Puts the row `order[k]` into row `k`, but for the loads and the listed positions: the list that is made for the new order
    /// brings new ones. `parallel`: with the threads of the pool from within which it is called.
    pub(crate) fn reorder(&mut self, order: &[u32], parallel: bool) {
        self.follow(order);
        self.gather_rows(order, false, parallel);
    }

    /// Lets what names rows follow them to their new places.
    fn follow(&mut self, order: &[u32]) {
        if !self.prescribed.is_empty() || self.bodies.is_some() || !self.unpaired.is_empty() {
            let mut new_row = vec![None; self.len()];
            for (new, &old) in order.iter().enumerate() {
                new_row[old as usize] = Some(Row::new(new));
            }
            if let Some(bodies) = &mut self.bodies {
                bodies.follow(&new_row, order.len());
            }
            self.unpaired.follow(&new_row);
            self.prescribed = (self.prescribed.iter())
                .filter_map(|prescribed| {
                    let row = new_row[prescribed.row.index()]?;
                    Some(Prescribed { row, ..*prescribed })
                })
                .collect();
        }
    }

    /// Whether the particle in `row` is fixed.
    #[must_use]
    pub fn is_fixed(&self, row: usize) -> bool {
        self.records[row].flags & FIXED != 0
    }

    /// Whether some of the particle's motion is prescribed.
    #[must_use]
    pub fn is_prescribed(&self, row: usize) -> bool {
        self.records[row].flags & PRESCRIBED != 0
    }

    /// Whether the row is a pebble of a body.
    #[must_use]
    pub fn is_pebble(&self, row: usize) -> bool {
        self.records[row].flags & PEBBLE != 0
    }

    /// The bodies, none in scenes without clumps.
    #[must_use]
    pub fn bodies(&self) -> &[Body] {
        self.bodies
            .as_ref()
            .map_or(&[], |bodies| bodies.all.as_slice())
    }

    /// Grains: spheres of their own and bodies.
    #[must_use]
    pub fn grains(&self) -> usize {
        match &self.bodies {
            None => self.len(),
            Some(bodies) => self.len() - bodies.pebbles.len() + bodies.all.len(),
        }
    }

    /// The number of grains ever made.
    #[must_use]
    pub fn grains_created(&self) -> u64 {
        let extra = self.bodies.as_ref().map_or(0, |bodies| bodies.extra_ids);
        u64::from(self.next_id - extra)
    }

    /// Whether every column has an entry for each row, and every reference to a row or a body is valid.
    #[must_use]
    pub fn is_consistent(&self) -> bool {
        let rows = self.len();
        let mut prescribed = self.prescribed.iter();
        self.columns_have(rows)
            && prescribed.all(|prescribed| prescribed.row.index() < rows)
            && (self.bodies.as_ref()).is_none_or(|bodies| bodies.is_consistent(rows))
    }

    /// Whether it can be of a run with so many materials.
    ///
    /// # Errors
    /// Columns differ in length, or an index is out of range.
    pub fn check(&self, materials: usize) -> Result<(), String> {
        if !self.is_consistent() {
            return Err("columns differ in length, or a row index is out of range".to_owned());
        }
        let is_there = |record: &Particle| record.material.index() < materials;
        if !self.records.iter().all(is_there) {
            return Err("it has particles of materials that are not there".to_owned());
        }
        let records = self.records.iter().map(|record| record.flags);
        let bodies = self.bodies().iter().map(|body| body.flags);
        let is_known = |flags: u32| flags & !(FIXED | PRESCRIBED | PEBBLE) == 0;
        if !records.chain(bodies).all(is_known) {
            return Err("it has particles with flags that are not known".to_owned());
        }
        Ok(())
    }

    /// Rows in order of their ids: the order of every output.
    #[must_use]
    pub fn rows_by_id(&self) -> Vec<u32> {
        let mut rows: Vec<u32> = (0..self.len() as u32).collect();
        rows.sort_unstable_by_key(|&row| self.ids[row as usize]);
        rows
    }
}

/// Row `order[k]` of a column becomes row `k`.
fn gather<T: Copy + Send + Sync>(column: &mut Vec<T>, order: &[u32], parallel: bool) {
    let row = |&row: &u32| column[row as usize];
    *column = if parallel {
        order.par_iter().with_min_len(1024).map(row).collect()
    } else {
        order.iter().map(row).collect()
    };
}

crate::state::plain!(Prescribed {
    row,
    velocity,
    angular_velocity
});

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::{Material, MaterialIndex, NewParticle, Plain};

    /// A derived column goes along with the rows and is left out of what is saved.
    #[test]
    fn derived_columns_follow_rows_and_are_not_saved() {
        let material = Material {
            name: "m".to_owned(),
            density: 1.0,
        };
        let mut particles = Particles::new(true);
        let push = |particles: &mut Particles, x: f64| {
            let new = NewParticle::at(DVec3::X * x, 1.0, MaterialIndex::new(0));
            let (record, mass, _) = new.build(std::slice::from_ref(&material), 3);
            particles.push(record, mass, None);
        };
        for x in [0.0, 3.0, 6.0] {
            push(&mut particles, x);
        }
        particles.films = Some(vec![[1.0; 2], [2.0; 2], [3.0; 2]]);
        particles.keep(&[2, 0]);
        push(&mut particles, 9.0);
        assert_eq!(particles.films, Some(vec![[3.0; 2], [1.0; 2], [0.0; 2]]));
        assert!(particles.is_consistent());
        let mut bytes = Vec::new();
        particles.put(&mut bytes);
        let saved = Particles::take(&mut &bytes[..]).unwrap();
        particles.films = None;
        assert_eq!(saved, particles);
    }
}

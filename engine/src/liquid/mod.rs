//! Liquid of a run: films on particles, bridges between them, and the rules by which it moves.
//!
//! Films are a column of the particles ([`FILM_VOLUME`]); bridges are kept in the slots of contacts. After each force evaluation the
//! events of contacts are answered in a fixed order ([`Liquids::answer`]): a bridge that forms there first acts in the next step. Every
//! volume that is handed on is what is left after a subtraction, so that the sum of all volumes is kept to round-off.

mod balance;
mod evaporation;
mod migration;
mod part;
mod sum;
#[cfg(test)]
mod tests;
mod weight;

pub use balance::{LiquidBalance, LiquidRow};
pub use evaporation::EVERY as EVAPORATES_EVERY;
pub use migration::MigrationContext;
pub use sum::Sum;
pub use weight::{Weighed, Weight};

use crate::contact::Bridge;
use crate::forces::{ContactForces, ContactMemory};
use crate::state::Particles;
use crate::walls::{WallFilmPlan, WallFilms};
use mercury_common::particle_properties::FILM_VOLUME;

pub use mercury_common::scene::{BridgesForm, LiquidNeighbours};

/// A contact with its liquid bridge.
pub type BridgeSite = ContactMemory<Bridge>;

/// Plan of the liquid beside the laws of contacts and the films of particles, which are a property of theirs.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LiquidPlan {
    /// Which bridges take the liquid of one that breaks.
    pub neighbours: LiquidNeighbours,
    /// Where bridges form.
    pub bridges_form: BridgesForm,
    /// Volume lost per area and second, m/s.
    pub evaporation: f64,
    /// The mass of liquid, where it has any.
    pub weight: Option<Weight>,
    /// Films of walls, in the order of the walls; may be shorter where no further wall has one.
    pub wall_films: Vec<Option<WallFilmPlan>>,
}

/// The step part that moves liquid.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Liquids {
    neighbours: LiquidNeighbours,
    bridges_form: BridgesForm,
    /// Volume lost per area and second, m/s.
    evaporation: f64,
    weight: Option<Weight>,
    /// Liquid that came and went since the start.
    pub balance: LiquidBalance,
}

/// State of the liquid in a checkpoint beside films and bridges.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SavedLiquid {
    /// Balance since the start.
    pub balance: LiquidBalance,
    /// Volumes on walls, m^3: of each wall those of its triangles.
    pub walls: Vec<Vec<f64>>,
}

crate::state::plain!(SavedLiquid { balance, walls });

impl Liquids {
    /// State in a checkpoint.
    #[must_use]
    pub fn save(&self, films: &WallFilms) -> SavedLiquid {
        SavedLiquid {
            balance: self.balance,
            walls: films.save(),
        }
    }

    /// Goes on from a checkpoint.
    ///
    /// # Errors
    /// If its walls are not those of the plan.
    pub fn restore(&mut self, saved: &SavedLiquid, films: &mut WallFilms) -> Result<(), String> {
        self.balance = saved.balance;
        if films.restore(&saved.walls) {
            return Ok(());
        }
        Err("its films on walls are not those of the plan".to_owned())
    }

    /// Counts the films of particles that were inserted: those of the rows from `first` on.
    pub fn note_inserted(&mut self, first: usize, particles: &mut Particles) {
        let films = particles.columns.get(FILM_VOLUME.name).unwrap_or_default();
        for &film in &films[first.min(films.len())..] {
            self.balance.inserted.add(film);
        }
        self.weigh_films(first, particles);
    }

    /// Liquid at the start, that in bridges of another run included, begins the balance.
    pub fn note_first(
        &mut self,
        contacts: &dyn ContactForces,
        particles: &mut Particles,
        films: &WallFilms,
    ) {
        let row = self.row(particles, contacts, films, [0.0; 5]);
        self.balance.initial = row.films + row.bridges + row.wall_films;
        self.weigh_films(0, particles);
        self.weigh_bridges(&contacts.memories_of::<Bridge>(&|_| true), particles);
    }

    /// Finds how thick the films of some rows are, where bridges form as films meet.
    pub fn measure_films(&self, particles: &mut Particles, rows: impl Iterator<Item = usize>) {
        let Some(volumes) = particles.columns.get(FILM_VOLUME.name) else {
            return;
        };
        let films = particles.films.get_or_insert_default();
        films.resize(volumes.len(), [0.0; 2]);
        for row in rows {
            let film = volumes[row];
            films[row] = [film_thickness(film, particles.records[row].radius), film];
        }
    }

    /// Without liquid yet.
    #[must_use]
    pub fn new(plan: &LiquidPlan) -> Self {
        Self {
            neighbours: plan.neighbours,
            bridges_form: plan.bridges_form,
            evaporation: plan.evaporation,
            weight: plan.weight,
            balance: LiquidBalance::default(),
        }
    }

    /// Where all liquid is now; `sprayed` is that of droplets ([`LiquidRow::sprayed`]).
    #[must_use]
    pub fn row(
        &self,
        particles: &Particles,
        contacts: &dyn ContactForces,
        wall_films: &WallFilms,
        sprayed: [f64; 5],
    ) -> LiquidRow {
        let films = particles.columns.get(FILM_VOLUME.name).unwrap_or_default();
        let bridges = contacts.memories_of::<Bridge>(&|_| true);
        LiquidRow::new(
            &self.balance,
            films,
            bridges.iter().map(|site| site.memory.volume),
            wall_films.all(),
            sprayed,
        )
    }
}

/// Thickness h of a film (volume V, m^3) on a sphere (radius R, m), m: (R + h)^3 - R^3 = 3 V/(4 pi), without loss of digits.
#[must_use]
pub fn film_thickness(volume: f64, radius: f64) -> f64 {
    let more = 0.75 / std::f64::consts::PI * volume;
    let outer = libm::cbrt(radius * radius * radius + more);
    more / (outer * outer + outer * radius + radius * radius)
}

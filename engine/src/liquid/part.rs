//! Liquid in a step: films and bridges after each force evaluation.

use std::collections::HashMap;
use std::sync::Arc;

use mercury_common::particle_properties::{FILM_VOLUME, ParticleProperty};

use super::{BridgesForm, EVAPORATES_EVERY, LiquidPlan, LiquidRow, Liquids, MigrationContext};
use crate::cell::opposite;
use crate::contact::Bridge;
use crate::forces::{Needs, Observation, Partner};
use crate::physics::{FeaturePlan, Physics, Setup};
use crate::spray::Sprays;
use crate::state::{Id, Pieces, Plain};
use crate::step::{Core, Engine, Exchanged, Leaving, Part, RunError, SizeEstimate};
use crate::walls::WallFilms;

impl FeaturePlan for LiquidPlan {
    fn properties(&self) -> Vec<&'static ParticleProperty> {
        vec![&FILM_VOLUME]
    }
}

impl LiquidPlan {
    /// That of a simulation with films on particles, where the default holds if there is none; `None` without liquid.
    fn of(physics: &Physics) -> Option<Self> {
        let plan = || physics.plans.get().cloned().unwrap_or_default();
        physics.has_property(&FILM_VOLUME).then(plan)
    }
}

impl Part for Liquids {
    fn name(&self) -> &str {
        "liquid"
    }

    fn of(core: &mut Core) -> Option<Self> {
        let plan = LiquidPlan::of(core.physics())?;
        core.domain.wall_films = WallFilms::start(&plan.wall_films);
        Some(Self::new(&plan))
    }

    fn bytes(setup: &Setup, crowd: &SizeEstimate) -> f64 {
        let Some(plan) = LiquidPlan::of(&setup.physics) else {
            return 0.0;
        };
        // The column of films and, where bridges form as films meet, their thickness and volume.
        let measured = f64::from(u8::from(plan.bridges_form != BridgesForm::Contact));
        // Areas of the plan, areas and volumes of the films.
        let walls = plan.wall_films.iter().flatten();
        let places: usize = walls.map(|film| film.areas.len()).sum();
        (crowd.rows * (1.0 + 2.0 * measured) + 3.0 * places as f64) * size_of::<f64>() as f64
    }

    fn needs(&self) -> Needs {
        // Liquid with mass changes masses after the forces.
        Needs {
            whole_steps: self.has_mass(),
            events: true,
            ..Needs::default()
        }
    }

    fn start(&mut self, core: &mut Core) {
        self.note_first(
            core.contacts.as_ref(),
            &mut core.particles,
            &core.domain.wall_films,
        );
    }

    fn before_leaving(&mut self, at: &mut Leaving<'_>) {
        let mut around = MigrationContext {
            laws: &at.physics.laws,
            walls: at.walls,
            films: at.wall_films,
        };
        self.release(at.leavers, &mut at.contacts, at.particles, &mut around);
    }

    fn after_exchange(&mut self, core: &mut Core, exchanged: &Exchanged) {
        if let Some(first) = exchanged.arrivals.first() {
            self.note_inserted(first.rows.start, &mut core.particles);
        }
    }

    fn before_forces(&mut self, core: &mut Core) -> Result<(), RunError> {
        if self.bridges_form == BridgesForm::Films {
            let others = core.rows_of_others();
            let rows = core
                .own_rows()
                .chain(others.iter().map(|&row| row as usize));
            self.measure_films(&mut core.particles, rows);
        }
        Ok(())
    }

    fn after_forces(&mut self, core: &mut Core, _: Option<&Observation>) {
        let physics = Arc::clone(core.physics());
        let is_due = core.steps() > 0 && core.steps().is_multiple_of(EVAPORATES_EVERY);
        let time = EVAPORATES_EVERY as f64 * physics.time_step;
        let (mut contacts, particles, domain) = core.lend();
        let mut around = MigrationContext {
            laws: &physics.laws,
            walls: &domain.walls,
            films: &mut domain.wall_films,
        };
        self.answer(&mut contacts, particles, &mut around);
        if is_due {
            self.evaporate(time, &mut contacts, particles, &mut around);
        }
    }

    /// Every rank has all films and makes the same moves, by the events of all ranks.
    fn works_on_ranks(&self) -> bool {
        true
    }

    /// Bridges lie in the slots of contacts.
    fn collect_from_ranks(&mut self, core: &mut Core) {
        core.collect_contacts();
    }

    /// Records of contacts hold the bridges of the force evaluation; what formed, broke and dried since is put right, so that records and
    /// films are of one moment.
    fn observe(&self, core: &Core, observation: &mut Observation) {
        if observation.records.is_empty() {
            return;
        }
        let ids = &core.particles.ids;
        let bridges = core.contacts.memories_of::<Bridge>(&|_| true);
        let bridges = bridges.iter().map(|site| {
            let seen = seen_from_lower(ids, site.row, site.partner);
            ((seen, site.feature), site.memory.volume)
        });
        let volumes: HashMap<_, _> = bridges.collect();
        for record in &mut observation.records {
            let key = (record.row, record.partner);
            let volume = volumes.get(&(key, record.feature));
            record.bridge_volume = volume.copied().unwrap_or(0.0);
        }
    }

    /// Energy that bridges have set free.
    fn dissipated(&self) -> Option<f64> {
        Some(self.balance.set_free)
    }

    fn put(&self, core: &Core, pieces: &mut Pieces) {
        self.save(&core.domain.wall_films).put(pieces.end());
    }

    fn take(&mut self, core: &mut Core, bytes: &mut &[u8]) -> Result<(), String> {
        self.restore(&Plain::take(bytes)?, &mut core.domain.wall_films)
    }
}

/// The row and the partner of a contact as records have them: of two particles the one with the lower id first.
fn seen_from_lower(ids: &[Id], row: u32, partner: Partner) -> (u32, Partner) {
    match partner {
        Partner::Particle { row: other, image } if ids[other as usize] < ids[row as usize] => {
            let image = opposite(image);
            (other, Partner::Particle { row, image })
        }
        _ => (row, partner),
    }
}

impl Engine {
    /// The liquid that each particle holds, m^3, row by row, in scenes with liquid: its film, half of each bridge to another particle, all of
    /// each to a wall. The sum is that of all films of particles and all bridges.
    #[must_use]
    pub fn liquid_volumes(&self) -> Option<Vec<f64>> {
        self.part::<Liquids>()?;
        let films = self.particles.columns.get(FILM_VOLUME.name);
        let mut volumes = films.unwrap_or_default().to_vec();
        volumes.resize(self.particles.len(), 0.0);
        for site in self.contacts.memories_of::<Bridge>(&|_| true) {
            let volume = site.memory.volume;
            match site.partner {
                Partner::Particle { row, .. } => {
                    volumes[site.row as usize] += 0.5 * volume;
                    volumes[row as usize] += 0.5 * volume;
                }
                Partner::Wall { .. } => volumes[site.row as usize] += volume,
            }
        }
        Some(volumes)
    }

    /// Where the liquid is, in scenes that have any.
    #[must_use]
    pub fn liquid(&self) -> Option<LiquidRow> {
        let liquid = self.part::<Liquids>()?;
        let sprayed = self.part().map_or([0.0; 5], Sprays::volumes);
        let contacts = self.contacts.as_ref();
        Some(liquid.row(&self.particles, contacts, &self.domain.wall_films, sprayed))
    }

    /// Contribution of liquid from outside to the particles since the start: mass (kg, where it has any) and energy (J), by the
    /// rules of migration and evaporation, and by droplets.
    #[must_use]
    pub fn liquid_brought(&self) -> [[f64; 2]; 2] {
        let liquid = self.part().map_or([0.0; 2], |liquid: &Liquids| {
            [liquid.gained_mass(), liquid.balance.weighed.energy]
        });
        let sprays = self.part().map_or([0.0; 2], |sprays: &Sprays| {
            let balance = &sprays.state.balance;
            [balance.mass.value(), balance.energy]
        });
        [liquid, sprays]
    }
}

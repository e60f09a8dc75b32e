//! The state of a run as one plain value.

use std::sync::Arc;

use super::guard::Guard;
use super::{Audit, AuditedContact, Engine, Lists, LoadSeries, RunError, SavedSleep, StartOptions};
use crate::boundaries::BoundaryState;
use crate::forces::{SavedLoads, SavedSlot, SavedSlots};
use crate::liquid::{Liquids, SavedLiquid};
use crate::membrane::SavedMembrane;
use crate::neighbours::Images;
use crate::plan::Plan;
use crate::spray::{Droplet, SprayState, Sprays};
use crate::state::{DecodeError, Decoder, Encoder, Particles};
use crate::surface::SavedSurface;
use crate::walls::{SavedWall, WallNow};
use crate::wear::{SavedWear, Wear};

/// Everything that a run needs to go on bit for bit, beside its plan: also the candidate list, the skin and the count of
/// steps since the list was built, which decide the order of summation in the steps to come.
///
/// Two runs of one plan whose snapshots are equal stay equal.
#[derive(Debug, Clone, PartialEq)]
pub struct Snapshot {
    /// Steps made.
    pub step: u64,
    /// All particles with their last loads, row by row.
    pub particles: Particles,
    /// The listed pairs in order, with their histories.
    pub pairs: SavedSlots,
    /// The particles near walls in order, with their histories.
    pub near_walls: SavedSlots,
    /// What the forces beside the contacts remember, by their names.
    pub other_forces: Vec<(String, Vec<u8>)>,
    /// What is known of the lists.
    pub lists: Lists,
    /// What of the walls does not follow from the time, in the order of the plan.
    pub walls: Vec<SavedWall>,
    /// The second half kick of the last step is still to be made.
    pub kick_due: bool,
    /// Insertions and deletions, and what they counted.
    pub boundaries: BoundaryState,
    /// Running sums of the energy audit.
    pub audit: Audit,
    /// The contacts of the last forces, in audited runs.
    pub audited: Vec<AuditedContact>,
    /// What the guard has counted.
    pub guard: Vec<(u64, Vec<f64>)>,
    /// Loads on features of meshes as they lie in the blocks, and the sums taken from there.
    pub feature_loads: (Vec<SavedLoads>, LoadSeries),
    /// The state of sleeping particles, if the plan enables sleeping.
    pub sleep: Option<SavedSleep>,
    /// What came and went of liquid, in scenes that have any.
    pub liquid: Option<SavedLiquid>,
    /// Droplets in flight and where others went, in scenes with sprays.
    pub sprays: Option<SprayState>,
    /// Walls that wear, in scenes that have any.
    pub wear: Option<SavedWear>,
    /// Sheets, in scenes that have any.
    pub surfaces: Vec<SavedSurface>,
    /// Their mechanics.
    pub membranes: Vec<SavedMembrane>,
    /// Contacts of their vertices with walls, sheet by sheet.
    pub vertices_at_walls: Vec<SavedSlots>,
}

/// Section of [`Snapshot::surfaces`].
const SURFACES: &str = "surfaces";
/// Section of [`Snapshot::membranes`].
const MEMBRANES: &str = "membranes";

/// Section of [`Snapshot::vertices_at_walls`].
const VERTICES: &str = "vertices at walls";

/// Section of [`Snapshot::sprays`].
const SPRAYS: &str = "sprays";

/// Section of [`Snapshot::wear`].
const WEAR: &str = "wear";

/// Section of [`Snapshot::liquid`].
const LIQUID: &str = "liquid";

/// Section of [`Snapshot::sleep`]: only where the plan enables sleeping.
const SLEEP: &str = "sleep";

/// Section of [`Snapshot::audited`]: only where there are any.
const AUDITED: &str = "audited contacts";

/// More steps have no time of their own: above it not every whole number is an `f64`.
const MOST_STEPS: u64 = 1 << 53;

impl Snapshot {
    /// As bytes, with a version and checksums.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        let mut encoder = Encoder::new();
        self.add_to(&mut encoder);
        encoder.finish()
    }

    fn add_to(&self, encoder: &mut Encoder) {
        encoder.section("clock", &(self.step, self.kick_due));
        encoder.section("particles", &self.particles);
        encoder.section("pairs", &self.pairs);
        encoder.section("near walls", &self.near_walls);
        encoder.section("other forces", &self.other_forces);
        encoder.section("lists", &self.lists);
        encoder.section("walls", &self.walls);
        encoder.section("boundaries", &self.boundaries);
        encoder.section("audit", &self.audit);
        if !self.audited.is_empty() {
            encoder.section(AUDITED, &self.audited);
        }
        encoder.section("guard", &self.guard);
        encoder.section("feature loads", &self.feature_loads);
        if let Some(sleep) = &self.sleep {
            encoder.section(SLEEP, sleep);
        }
        if let Some(liquid) = &self.liquid {
            encoder.section(LIQUID, liquid);
        }
        if let Some(sprays) = &self.sprays {
            encoder.section(SPRAYS, sprays);
        }
        if let Some(wear) = &self.wear {
            encoder.section(WEAR, wear);
        }
        if !self.surfaces.is_empty() {
            encoder.section(SURFACES, &self.surfaces);
            encoder.section(VERTICES, &self.vertices_at_walls);
        }
        if !self.membranes.is_empty() {
            encoder.section(MEMBRANES, &self.membranes);
        }
    }

    /// From the bytes of [`Snapshot::encode`], the same to the bit.
    ///
    /// # Errors
    /// If the bytes are no state, of another version, cut or damaged, or contradict each other.
    pub fn decode(bytes: &[u8]) -> Result<Self, DecodeError> {
        let mut decoder = Decoder::new(bytes)?;
        let snapshot = Self::take_from(&mut decoder)?;
        decoder.finish()?;
        Ok(snapshot)
    }

    /// From the sections of [`Engine::add_state_to`].
    ///
    /// # Errors
    /// Those of [`Snapshot::decode`].
    pub fn take_from(decoder: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        let (step, kick_due) = decoder.section("clock")?;
        let snapshot = Self {
            step,
            particles: decoder.section("particles")?,
            pairs: decoder.section("pairs")?,
            near_walls: decoder.section("near walls")?,
            other_forces: decoder.section("other forces")?,
            lists: decoder.section("lists")?,
            walls: decoder.section("walls")?,
            kick_due,
            boundaries: decoder.section("boundaries")?,
            audit: decoder.section("audit")?,
            audited: decoder.optional_section(AUDITED)?.unwrap_or_default(),
            guard: decoder.section("guard")?,
            feature_loads: decoder.section("feature loads")?,
            sleep: decoder.optional_section(SLEEP)?,
            liquid: decoder.optional_section(LIQUID)?,
            sprays: decoder.optional_section(SPRAYS)?,
            wear: decoder.optional_section(WEAR)?,
            surfaces: decoder.optional_section(SURFACES)?.unwrap_or_default(),
            vertices_at_walls: decoder.optional_section(VERTICES)?.unwrap_or_default(),
            membranes: decoder.optional_section(MEMBRANES)?.unwrap_or_default(),
        };
        snapshot.check()?;
        Ok(snapshot)
    }

    /// Whether columns have the same length and indices lead somewhere.
    fn check(&self) -> Result<(), DecodeError> {
        let wrong = |section: &str, reason: &str| DecodeError::Wrong {
            section: section.to_owned(),
            reason: reason.to_owned(),
        };
        if !self.particles.is_consistent() {
            return Err(wrong(
                "particles",
                "columns differ in length, or a row index is out of range",
            ));
        }
        let rows = self.particles.len();
        let is_row = |row: u32| (row as usize) < rows;
        let listed = |slot: SavedSlot<'_>| is_row(slot.row) && is_row(slot.partner);
        if !self.pairs.iter().all(listed) {
            return Err(wrong("pairs", "a listed pair names a missing particle"));
        }
        if !self.near_walls.iter().all(|slot| is_row(slot.row)) {
            return Err(wrong(
                "near walls",
                "a listed wall names a missing particle",
            ));
        }
        let image = |slot: SavedSlot<'_>| slot.image < Images::NEIGHBOURS;
        if !self.pairs.iter().all(image) {
            return Err(wrong("pairs", "a listed pair names a missing image"));
        }
        if !(self.lists.skin.is_possible() && self.lists.half_skins.is_possible()) {
            return Err(wrong("lists", "a skin that cannot be"));
        }
        let counts = [
            ("clock", self.step),
            ("lists", self.lists.rebuilds),
            ("lists", self.lists.validity.steps),
            ("feature loads", self.feature_loads.1.most_evaluations()),
        ];
        if let Some((section, _)) = counts.iter().find(|(_, count)| *count > MOST_STEPS) {
            return Err(wrong(section, "more steps than a run can make"));
        }
        if ![0, rows].contains(&self.lists.extra_skin.len()) {
            return Err(wrong("lists", "the extra skins do not match the particles"));
        }
        if (self.sleep.as_ref()).is_some_and(|sleep| !sleep.fits(rows)) {
            return Err(wrong(
                SLEEP,
                "the positions of sleepers do not match the particles",
            ));
        }
        if !self.particles.may_sleep_so(self.sleep.is_some()) {
            return Err(wrong("particles", "a particle sleeps that cannot sleep"));
        }
        Ok(())
    }
}

impl Engine {
    /// Appends the sections of [`Engine::snapshot`] without making one: the particles are as large as all the rest.
    pub fn add_state_to(&self, encoder: &mut Encoder) {
        let contacts = &self.forces.contacts;
        let pool = self.pool.as_deref();
        encoder.section("clock", &(self.step, self.kick_due));
        encoder.section_by("particles", |pieces| {
            self.particles.put_pieces(pieces, pool)
        });
        encoder.section_by("pairs", |pieces| contacts.put_pairs(pieces, pool));
        encoder.section_by("near walls", |pieces| contacts.put_near_walls(pieces));
        encoder.section("other forces", &self.saved_others());
        encoder.section("lists", &self.lists);
        encoder.section("walls", &self.saved_walls());
        encoder.section("boundaries", &self.boundaries.state());
        encoder.section("audit", &self.audit);
        if !self.audited.is_empty() {
            encoder.section(AUDITED, &self.audited);
        }
        encoder.section("guard", &self.guard.save());
        encoder.section("feature loads", &self.saved_feature_loads());
        if let Some(sleep) = self.saved_sleep() {
            encoder.section(SLEEP, &sleep);
        }
        if let Some(liquid) = &self.liquid {
            encoder.section(LIQUID, &liquid.save());
        }
        if let Some(sprays) = &self.sprays {
            encoder.section(SPRAYS, &sprays.state);
        }
        if let Some(wear) = &self.wear {
            encoder.section(WEAR, &wear.save());
        }
        if !self.surfaces.is_empty() {
            encoder.section(SURFACES, &self.saved_surfaces());
            encoder.section(VERTICES, &self.forces.contacts.save_vertices());
        }
        if !self.membranes.is_empty() {
            encoder.section(MEMBRANES, &self.saved_membranes());
        }
    }

    fn saved_others(&self) -> Vec<(String, Vec<u8>)> {
        (self.forces.others().iter())
            .map(|pass| (pass.name().to_owned(), pass.save()))
            .collect()
    }

    fn saved_walls(&self) -> Vec<SavedWall> {
        self.walls().iter().map(WallNow::save).collect()
    }

    fn saved_feature_loads(&self) -> (Vec<SavedLoads>, LoadSeries) {
        (
            self.forces.contacts.save_feature_loads(),
            self.load_series.clone(),
        )
    }

    /// The present state.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        let (pairs, near_walls) = self.forces.contacts.save();
        Snapshot {
            step: self.step,
            particles: self.particles.clone(),
            pairs,
            near_walls,
            other_forces: self.saved_others(),
            lists: self.lists.clone(),
            walls: self.saved_walls(),
            kick_due: self.kick_due,
            boundaries: self.boundaries.state(),
            audit: self.audit,
            audited: self.audited.clone(),
            guard: self.guard.save(),
            feature_loads: self.saved_feature_loads(),
            sleep: self.saved_sleep(),
            liquid: self.liquid.as_ref().map(Liquids::save),
            sprays: self.sprays.as_ref().map(|sprays| sprays.state.clone()),
            wear: self.wear.as_ref().map(Wear::save),
            surfaces: self.saved_surfaces(),
            membranes: self.saved_membranes(),
            vertices_at_walls: self.forces.contacts.save_vertices(),
        }
    }

    /// A run of `plan` that goes on from `snapshot`, which must come from a run of the same plan; the number of threads may
    /// differ. [`Engine::observation`] is empty until the next watched step.
    ///
    /// # Errors
    /// If threads cannot be started, or the snapshot cannot have come from a run of this plan.
    pub fn restore(plan: Arc<Plan>, snapshot: Snapshot, threads: usize) -> Result<Self, RunError> {
        Self::resume(plan, snapshot, StartOptions::threads(threads))
    }

    /// The same for a run that was started with [`Engine::start`], with the same contacts and forces.
    ///
    /// # Errors
    /// Also if these are not the forces of the snapshot.
    pub fn resume(
        plan: Arc<Plan>,
        snapshot: Snapshot,
        options: StartOptions,
    ) -> Result<Self, RunError> {
        Self::unstarted(plan, options)?.restored(snapshot)
    }

    /// Whether a snapshot can have come from a run of this engine's plan: as many of everything, and histories of the same length.
    fn fits(&self, snapshot: &Snapshot) -> Result<(), RunError> {
        let plan = &self.plan;
        let counts = [
            ("walls", snapshot.walls.len(), plan.physics().walls().len()),
            (
                "insertions",
                snapshot.boundaries.insertions.len(),
                plan.physics().insertions().len(),
            ),
            (
                "deletions",
                snapshot.boundaries.deletions.len(),
                plan.physics().deletions().len(),
            ),
            (
                "flux planes times materials",
                snapshot.boundaries.crossed.len(),
                plan.outputs().fluxes().len() * plan.physics().materials().len(),
            ),
        ];
        let unlike = counts.iter().find(|(_, found, planned)| found != planned);
        if let Some((what, found, planned)) = unlike {
            let reason = format!("it has {found} {what}, the plan {planned}");
            return Err(RunError::OtherPlan(reason));
        }
        if snapshot.sleep.is_some() != plan.physics().sleeping().is_some() {
            let reason =
                "`[sleeping]` is set in the checkpoint or in the scene, but not in both".to_owned();
            return Err(RunError::OtherPlan(reason));
        }
        let columns =
            |particles: &Particles| particles.columns.names().map(str::to_owned).collect();
        let (found, planned): (Vec<String>, Vec<String>) =
            (columns(&snapshot.particles), columns(&self.particles));
        if found != planned || snapshot.liquid.is_some() != self.liquid.is_some() {
            let list = |names: &[String]| match names {
                [] => "none".to_owned(),
                some => some.join(", "),
            };
            let reason = format!(
                "its particles have these further columns: {}; those of the plan: {}",
                list(&found),
                list(&planned)
            );
            return Err(RunError::OtherPlan(reason));
        }
        let nozzles = (plan.physics().sprays().as_ref()).map(|sprays| sprays.nozzles.len());
        let found = snapshot.sprays.as_ref().map(|sprays| sprays.nozzles.len());
        let fits = |sprays: &SprayState| {
            let nozzle = |droplet: &Droplet| (droplet.nozzle as usize) < sprays.nozzles.len();
            sprays.droplets.iter().all(nozzle)
        };
        if found != nozzles || !snapshot.sprays.as_ref().is_none_or(fits) {
            let reason = "its sprays are not those of the plan".to_owned();
            return Err(RunError::OtherPlan(reason));
        }
        let numbers = self.forces.contacts.saved_numbers();
        let found = snapshot.pairs.numbers();
        if found != numbers || snapshot.near_walls.numbers() != numbers {
            let reason = format!(
                "its contacts remember {found} numbers each, those of the plan's laws {numbers}"
            );
            return Err(RunError::OtherPlan(reason));
        }
        let is_wall = |slot: SavedSlot<'_>| (slot.partner as usize) < self.walls.len();
        if !snapshot.near_walls.iter().all(is_wall) {
            let reason = "it has contacts with walls that are not there".to_owned();
            return Err(RunError::OtherPlan(reason));
        }
        let planned = plan.physics().walls().len();
        let at_walls = snapshot.vertices_at_walls.iter().zip(&self.surfaces);
        let mut slots = at_walls.flat_map(|(slots, surface)| {
            let vertices = surface.positions.len();
            slots.iter().map(move |slot| {
                (slot.row as usize) < vertices && (slot.partner as usize) < planned
            })
        });
        let fitting = slots.all(|fits| fits)
            && snapshot.vertices_at_walls.len() <= self.surfaces.len()
            && (snapshot.vertices_at_walls.iter()).all(|slots| slots.numbers() == numbers);
        if !fitting {
            let reason = "it has contacts of vertices or walls that are not there".to_owned();
            return Err(RunError::OtherPlan(reason));
        }
        let (rows, walls) = (snapshot.particles.len(), self.walls.len());
        let leads_somewhere = |contact: &AuditedContact| contact.leads_somewhere(rows, walls);
        if !snapshot.audited.iter().all(leads_somewhere) {
            let reason = "it has audited contacts of particles or walls that are not there";
            return Err(RunError::OtherPlan(reason.to_owned()));
        }
        let records = &snapshot.particles.records;
        let is_material = |index: u32| (index as usize) < plan.physics().materials().len();
        if !records
            .iter()
            .all(|record| is_material(record.material.number()))
        {
            let reason = "it has particles of materials that are not there".to_owned();
            return Err(RunError::OtherPlan(reason));
        }
        Ok(())
    }

    /// An engine that is not started yet, in the state of a snapshot.
    fn restored(self, snapshot: Snapshot) -> Result<Self, RunError> {
        self.fits(&snapshot)?;
        let mut engine = self;
        let rows = snapshot.particles.len();
        engine
            .forces
            .contacts
            .restore(rows, &snapshot.pairs, &snapshot.near_walls);
        let (in_blocks, taken) = snapshot.feature_loads;
        engine.forces.contacts.restore_feature_loads(&in_blocks);
        engine.load_series = taken;
        engine.step = snapshot.step;
        engine.particles = snapshot.particles;
        engine
            .forces
            .restore_others(&engine.particles, &snapshot.other_forces)
            .map_err(RunError::Forces)?;
        engine.lists = snapshot.lists;
        engine.kick_due = snapshot.kick_due;
        engine
            .boundaries
            .restore(&snapshot.boundaries, &engine.particles);
        engine.audit = snapshot.audit;
        engine.audited = snapshot.audited;
        engine.guard = Guard::restored(&snapshot.guard);
        let (time, dt) = (engine.time(), engine.plan.physics().time_step());
        let walls = engine.plan.physics().walls().iter().zip(&mut engine.walls);
        for ((wall, now), saved) in walls.zip(&snapshot.walls) {
            now.restore(wall, saved, (time, dt), &engine.images)
                .map_err(|error| RunError::Wall {
                    wall: wall.name.clone(),
                    error,
                })?;
        }
        engine.restore_surfaces(&snapshot.surfaces)?;
        engine.restore_membranes(&snapshot.membranes)?;
        engine
            .forces
            .contacts
            .restore_vertices(&snapshot.vertices_at_walls);
        if let Some(sleep) = snapshot.sleep {
            engine.restore_sleep(sleep);
        }
        if let (Some(liquid), Some(saved)) = (&mut engine.liquid, &snapshot.liquid)
            && !liquid.restore(saved)
        {
            let reason = "its films on walls are not those of the plan".to_owned();
            return Err(RunError::OtherPlan(reason));
        }
        if let Some(state) = snapshot.sprays {
            engine.sprays = Some(Sprays::restored(state));
        }
        match (&mut engine.wear, &snapshot.wear) {
            (Some(wear), Some(saved)) => wear.restore(saved).map_err(RunError::OtherPlan)?,
            (None, None) => {}
            _ => {
                let reason =
                    "walls wear in the checkpoint or in the scene, but not in both".to_owned();
                return Err(RunError::OtherPlan(reason));
            }
        }
        Ok(engine)
    }
}

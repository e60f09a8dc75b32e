//! Interface of a contact loop to the step, whatever its laws: computing, observing and saving contacts, each a trait.

use super::{
    Alarms, Bond, BondPlace, ContactEvent, ContactRecord, FeatureKey, FeatureLoad, Finish,
    MotionBound, NearWall, Needs, Observation, Rub, SavedLoads, SavedSlots, StepContext,
};
use crate::contact::{Bridge, FrictionNow, HistoryNumber};
use crate::neighbours::CandidateList;
use crate::state::{Load, Particle, Particles, Pieces, Row, WallIndex};
use crate::surface::SurfaceLoad;

/// A contact loop with its slots: lists and loads.
pub trait ContactForces: ObservesContacts + SavesContacts + Send {
    /// Needs of the loop in the step.
    fn needs(&self) -> Needs {
        Needs::default()
    }

    /// How far beyond contact forces of each material reach at most, with any other, m; empty if none does.
    fn ranges(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Takes a new candidate list. Histories of pairs that touch or are bonded are carried over: `new_row[old]` is where each
    /// row of the last list went, `None` for rows that were removed. `parallel`: with the threads of the pool from within which
    /// it is called.
    fn adopt(
        &mut self,
        list: &CandidateList,
        near_walls: &[NearWall],
        new_row: &[Option<Row>],
        parallel: bool,
    );

    /// Takes note of which vertices of each sheet are near which walls; contacts that last keep what they remember.
    fn adopt_vertices(&mut self, near_walls: &[Vec<NearWall>]);

    /// Renames the images by which particles meet walls before a list is built: `new_name` of row, wall and image.
    fn rename_images(&mut self, new_name: &dyn Fn(u32, WallIndex, u32) -> u32);

    /// Computes all loads on `particles`; with a pool, in parallel. `finish` is called for each block of rows as soon as its
    /// loads are complete, while it is still in the cache; the answers are merged.
    fn compute(
        &mut self,
        particles: &mut Particles,
        context: &StepContext<'_>,
        pool: Option<&rayon::ThreadPool>,
        finish: &Finish<'_>,
    ) -> MotionBound;

    /// Computes the loads of walls on the vertices of a sheet, which count as spheres without spin. Loads on walls and energies are part of the
    /// observation; rows of exchanges begin at [`FIRST_VERTEX`](super::FIRST_VERTEX). `sheet`: its number, and that of its first vertex among those of
    /// all sheets.
    fn compute_vertices(
        &mut self,
        sheet: (usize, usize),
        vertices: &[Particle],
        context: &StepContext<'_>,
        pool: Option<&rayon::ThreadPool>,
        loads: &mut [Load],
    );

    /// Replaces a bridge.
    fn set_bridge(&mut self, place: &BondPlace, bridge: Bridge);
}

/// Observation of contacts, and the data handed over from step to step.
pub trait ObservesContacts {
    /// Listed pairs.
    fn listed(&self) -> usize;

    /// Pairs that touched or were bonded in the last evaluation.
    fn touching(&self) -> usize;

    /// The last observation; `records`: with those of the contacts, of which there are more than particles.
    fn observation(&self, walls: usize, records: bool) -> Observation;

    /// The records of contacts of the last observation; they are removed from here.
    fn take_records(&mut self) -> Vec<ContactRecord>;

    /// The events of contacts since the last call, block by block; they are removed from here. None where no law requests them.
    fn take_events(&mut self) -> Vec<ContactEvent>;

    /// The bridges that hold liquid at rows that `wanted` names, at either end, in the order of their slots.
    fn bonds(&self, wanted: &dyn Fn(usize) -> bool) -> Vec<Bond>;

    /// The contacts of the last evaluation that are beyond a limit; they are removed from here.
    fn take_alarms(&mut self) -> Alarms;

    /// The loads on features of mesh walls since they were taken last, in order; empties them.
    fn take_feature_loads(&mut self) -> Vec<(FeatureKey, FeatureLoad)>;

    /// Appends the contacts with walls that wear of the last evaluation, block by block; they are removed from here.
    fn take_rubs(&mut self, all: &mut Vec<Rub>);

    /// Shows what the contacts of the last evaluation did to sheets, block by block, in the order of the rows.
    fn visit_surface_loads(&self, visit: &mut dyn FnMut(&SurfaceLoad));
}

/// The state of contacts, for checkpoints.
pub trait SavesContacts {
    /// How much memory the slots and their histories take, and what histories are.
    fn layout(&self) -> HistoryLayout;

    /// Begins with these pairs of `rows` particles, and these particles near walls.
    fn restore(&mut self, rows: usize, pairs: &SavedSlots, walls: &SavedSlots);

    /// Appends the listed pairs in order, as the bytes of [`SavedSlots`], with the threads of a pool.
    fn put_pairs(&self, pieces: &mut Pieces, pool: Option<&rayon::ThreadPool>);

    /// Takes back what [`SavesContacts::put_pairs`] wrote for so many rows.
    ///
    /// # Errors
    /// If it cannot be of these rows and laws.
    fn take_pairs(&mut self, rows: usize, bytes: &mut &[u8]) -> Result<(), String>;

    /// Appends the particles near walls in order, likewise.
    fn put_near_walls(&self, pieces: &mut Pieces);

    /// Takes back what [`SavesContacts::put_near_walls`] wrote for so many rows and walls, behind the pairs.
    ///
    /// # Errors
    /// If it cannot be of these rows, walls and laws.
    fn take_near_walls(&mut self, counts: (usize, usize), bytes: &mut &[u8]) -> Result<(), String>;

    /// Appends what contacts of vertices with walls remember, sheet by sheet.
    fn put_vertices(&self, pieces: &mut Pieces);

    /// Takes back what [`SavesContacts::put_vertices`] wrote, for sheets of so many vertices among so many walls.
    ///
    /// # Errors
    /// If it cannot be of these.
    fn take_vertices(&mut self, counts: (&[usize], usize), bytes: &mut &[u8])
    -> Result<(), String>;

    /// Friction at walls in the last evaluation, by the places of the contacts among the slots at walls; of walls alone that wear, or whose triangles'
    /// loads are summed up.
    fn friction_at_walls(&self) -> Vec<(u32, FrictionNow)>;

    /// Restores what [`SavesContacts::friction_at_walls`] returned; called when the slots at walls are restored.
    fn restore_friction_at_walls(&mut self, saved: &[(u32, FrictionNow)]);

    /// The loads on features of mesh walls as they lie in the blocks.
    fn feature_loads(&self) -> Vec<SavedLoads>;

    /// Restores what [`SavesContacts::feature_loads`] returned; called when pairs are restored.
    fn restore_feature_loads(&mut self, saved: &[SavedLoads]);
}

/// How contacts lie in memory and in a checkpoint.
#[derive(Debug, Clone, PartialEq)]
pub struct HistoryLayout {
    /// The length of [`SavedSlot::history`](super::SavedSlot::history). A loop that chooses the law at each contact saves more
    /// than it shows.
    pub numbers: usize,
    /// Unit and meaning of the numbers in [`ContactRecord::history`].
    pub columns: Vec<HistoryNumber>,
    /// Bytes of the slot of a listed pair.
    pub slot: usize,
    /// Bytes of its history while it is carried over to a new list.
    pub carried: usize,
}

impl HistoryLayout {
    /// An upper estimate of the bytes of pairs and particles near walls in a checkpoint, for this many slots of this many rows, of
    /// which `remembering` have a history.
    #[must_use]
    pub fn saved_bytes(&self, rows: f64, slots: f64, remembering: f64) -> f64 {
        let history = self.numbers * size_of::<f64>();
        let heads = super::saved::most_bytes_of_pairs(slots as usize, rows as usize);
        heads as f64 + remembering * history as f64
    }
}

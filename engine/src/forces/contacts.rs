//! Interface of a contact loop to the step, whatever its laws.

use std::any::Any;
use std::ops::Range;

use super::{
    Finish, MotionBound, NearWall, Reports, SavedSlots, SlotPlace, StepContext, ToAllRanks,
};
use crate::contact::{FrictionNow, HistoryNumber};
use crate::neighbours::CandidateList;
use crate::ranks::Across;
use crate::state::{Load, Particle, Particles, Pieces, Plain, Row, WallIndex};

/// A contact loop with its slots. What is derived from these functions stands beside what it yields: events and memories
/// ([`ContactMemory`](super::ContactMemory)), reports ([`Reports`]), sections of a checkpoint ([`ContactSection`]).
pub trait ContactForces: Send {
    /// How far beyond contact forces of each material reach at most, with any other, m; empty if none does.
    fn ranges(&self) -> Vec<f64>;

    /// How much memory the slots and their histories take, and what histories are.
    fn layout(&self) -> HistoryLayout;

    /// Takes a new candidate list. Histories of pairs that touch or adhere are carried over: `new_row[old]` says where each
    /// row of the last list went, `None` for rows that were removed. `parallel`: with the threads of the pool from within which
    /// it is called. `across`: the way to other ranks, which keep the contacts of their rows.
    fn adopt(
        &mut self,
        list: &CandidateList,
        near_walls: &[NearWall],
        new_row: &[Option<Row>],
        across: Option<Across<'_>>,
        parallel: bool,
    );

    /// Keeps the contacts of the rows of this rank alone.
    fn keep_own(&mut self, across: Across<'_>);

    /// Rows of later ranks that contacts of this one read, ascending.
    fn read_rows(&self) -> Vec<u32>;

    /// Appends what the blocks of this rank have.
    fn put_own(&self, what: OfBlocks, bytes: &mut Vec<u8>);

    /// Takes what another rank, of these blocks, has appended.
    ///
    /// # Errors
    /// If the bytes are not of this program.
    fn take_others(
        &mut self,
        what: OfBlocks,
        blocks: Range<usize>,
        bytes: &mut &[u8],
    ) -> Result<(), String>;

    /// Forgets the contacts of other ranks, which were taken for a look or a checkpoint.
    fn forget_others(&mut self);

    /// Reports of the blocks that are computed here; `vertices`: and of the vertices of sheets, which every rank computes.
    fn own_reports(&self, vertices: bool) -> Vec<&Reports>;

    /// Takes note of which vertices of each sheet are near which walls; contacts that last keep what they remember.
    fn adopt_vertices(&mut self, near_walls: &[Vec<NearWall>]);

    /// Renames the images by which particles meet walls before a list is built: `new_name` of row, wall and image.
    fn rename_images(&mut self, new_name: &dyn Fn(u32, WallIndex, u32) -> u32);

    /// Computes all loads on `particles`; with a pool, in parallel. `finish` is called for each block of rows as soon as its
    /// loads are complete, while it is still in the cache; the answers are merged. `across`: the way to other ranks, which have shares for rows
    /// of this one.
    fn compute(
        &mut self,
        particles: &mut Particles,
        context: &StepContext<'_>,
        pool: Option<&rayon::ThreadPool>,
        finish: &Finish<'_>,
        across: Option<Across<'_>>,
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

    /// Listed pairs, and those of them that touched or adhered in the last evaluation.
    fn count(&self) -> [usize; 2];

    /// The log of events of the last force evaluation, a `Vec<ContactEvent<E, M>>`: `events_of` reads it.
    fn events(&self) -> &dyn Any;

    /// Puts the events of all ranks in place of those of this one.
    fn join_events(&mut self, to_all: &mut ToAllRanks<'_>);

    /// The memories that the adhesion law shares, a `Vec<ContactMemory<M>>`: `memories_of` reads them. `to_all`: and those of all ranks.
    fn memories(
        &self,
        wanted: &dyn Fn(usize) -> bool,
        to_all: Option<&mut ToAllRanks<'_>>,
    ) -> Box<dyn Any>;

    /// Replaces the memory that the adhesion law shares of a contact; nothing happens if it shares none of this kind, or another rank has the
    /// contact.
    fn set_memory(&mut self, place: &SlotPlace, memory: &dyn Any);

    /// Reports of blocks that lists have replaced, then of each block in the order of the rows, then of the vertices of sheets.
    fn reports(&self) -> Vec<&Reports>;

    /// Mutable reports, to be taken from.
    fn reports_mut(&mut self) -> Vec<&mut Reports>;

    /// Appends a section of the state, with the threads of a pool.
    fn put(&self, section: ContactSection, pieces: &mut Pieces, pool: Option<&rayon::ThreadPool>);

    /// Begins with saved contacts that were checked: pairs first.
    fn restore(&mut self, saved: &SavedContacts<'_>);
}

/// Data of blocks that the first rank gets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OfBlocks {
    /// All contacts.
    Contacts,
    /// Observations of the last evaluation that was observed.
    Observations,
    /// Loads on features of mesh walls since they were taken last.
    FeatureLoads,
}

/// A section of a checkpoint with the state of contacts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactSection {
    /// Listed pairs, in order.
    Pairs,
    /// Particles near walls, in order.
    NearWalls,
    /// Friction at walls in the last evaluation; of walls alone that wear, or whose triangles' loads are summed up.
    Friction,
    /// Contacts of the vertices of sheets with walls, sheet by sheet.
    Vertices,
}

/// Contacts to begin with.
#[derive(Debug, Clone, Copy)]
pub enum SavedContacts<'a> {
    /// The pairs of so many rows.
    Pairs(usize, &'a SavedSlots),
    /// Particles near walls.
    NearWalls(&'a SavedSlots),
    /// Friction by the places of contacts among the slots at walls.
    Friction(&'a [(u32, FrictionNow)]),
    /// Vertices near walls, of each sheet.
    Vertices(&'a [SavedSlots]),
}

/// Numbers of rows, walls and vertices of each sheet with which saved contacts must agree.
#[derive(Debug, Clone, Default)]
pub struct ContactCounts {
    /// Particles and pebbles.
    pub rows: usize,
    /// Walls that particles can touch.
    pub walls: usize,
    /// Walls that vertices of sheets can touch.
    pub walls_of_vertices: usize,
    /// Vertices of each sheet.
    pub vertices: Vec<usize>,
}

impl dyn ContactForces + '_ {
    /// Takes back a section that [`ContactForces::put`] wrote, pairs first.
    ///
    /// # Errors
    /// If it cannot be of these rows, walls, sheets and laws.
    pub fn take(
        &mut self,
        section: ContactSection,
        counts: &ContactCounts,
        bytes: &mut &[u8],
    ) -> Result<(), String> {
        let numbers = self.layout().numbers;
        match section {
            ContactSection::Pairs => {
                let pairs = SavedSlots::take(bytes)?;
                pairs.check_pairs(numbers, counts.rows)?;
                self.restore(&SavedContacts::Pairs(counts.rows, &pairs));
            }
            ContactSection::NearWalls => {
                let near_walls = SavedSlots::take(bytes)?;
                near_walls.check_at_walls(numbers, counts.rows, counts.walls)?;
                self.restore(&SavedContacts::NearWalls(&near_walls));
            }
            ContactSection::Friction => {
                let saved: Vec<_> = Plain::take(bytes)?;
                self.restore(&SavedContacts::Friction(&saved));
            }
            ContactSection::Vertices => {
                let saved: Vec<SavedSlots> = Plain::take(bytes)?;
                if saved.len() > counts.vertices.len() {
                    return Err("it has contacts of sheets that are not there".to_owned());
                }
                for (slots, &vertices) in saved.iter().zip(&counts.vertices) {
                    slots.check_at_walls(numbers, vertices, counts.walls_of_vertices)?;
                }
                self.restore(&SavedContacts::Vertices(&saved));
            }
        }
        Ok(())
    }
}

/// How contacts lie in memory and in a checkpoint.
#[derive(Debug, Clone, PartialEq)]
pub struct HistoryLayout {
    /// The length of [`SavedSlot::history`](super::SavedSlot::history). A loop that chooses the law at each contact saves more
    /// than it shows.
    pub numbers: usize,
    /// Unit and meaning of the numbers in [`ContactRecord::history`](super::ContactRecord::history).
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

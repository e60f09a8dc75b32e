//! Forces: the one contact loop, generic over the laws, and the observation of contacts.
//!
//! The sorted rows are cut into blocks whose size depends on the number of particles alone. A contact inside a block adds to
//! both its particles at once. A contact that reaches into a later block is computed once, by the block of its first row,
//! which parks the partner's share in an outbox; a second pass adds what was parked, in fixed order. So the sum on every
//! particle has one order, whatever the number of threads.

mod alarms;
mod blocks;
mod compiled;
mod contact_loop;
mod events;
mod feature_loads;
mod near_walls;
mod observation;
mod passes;
mod rubs;
mod saved;

pub use alarms::{Alarm, AlarmKind, Alarms, Other};
pub use blocks::{block_size, parked_bytes};
pub use compiled::{contact_loop, dispatching_loop};
pub use contact_loop::ContactLoop;
pub use events::{Bond, BondPlace, ContactEvent};
pub use feature_loads::{FeatureKey, FeatureLoad, FeatureLoads, LoadSums};
pub use near_walls::{NearWall, find_near_walls, near_walls_of_vertices};
pub use observation::{ContactRecord, Exchange, Observation, Partner, SpringEnergy, Watch};
pub use passes::{ForcePass, Forces, Needs, NewList};
pub use rubs::{Impact, Rub};
pub use saved::{SavedSlot, SavedSlots};

use crate::contact::{Bridge, HistoryNumber, SlidingNormal};
use crate::lanes::Width;
use crate::neighbours::{CandidateList, HalfSkins, Images};
use crate::state::{Load, Particle, Particles, Pieces, Row, WallIndex};
use crate::surface::{Surface, SurfaceLoad};
use crate::walls::{WallFilms, WallNow};

/// The inputs of the force evaluation of one step.
pub struct StepContext<'a> {
    /// The time by which springs are stretched: the time step, or 0 in the evaluation before the first step, s.
    pub spring_time: f64,
    /// The time by which the velocities are earlier than the positions: half a step, 0 in the evaluation before the first step,
    /// s.
    pub velocity_lag: f64,
    /// The normal for the velocities of sliding, rolling and torsion.
    pub sliding_normal: SlidingNormal,
    /// Periodic images.
    pub images: &'a Images,
    /// Walls as they are now.
    pub walls: &'a [WallNow],
    /// Sheets as they are now.
    pub surfaces: &'a [Surface],
    /// The liquid film on each row, where bridges form as films meet: thickness, m, and volume, m^3.
    pub films: Option<&'a [[f64; 2]]>,
    /// Films of walls, likewise.
    pub wall_films: Option<&'a WallFilms>,
    /// Whether R* includes the curvature of walls.
    pub wall_curvature: bool,
    /// Whether contacts of clumps are damped by the mass at the contact point.
    pub contact_point_mass: bool,
    /// Whether the loads on features of mesh walls are summed up.
    pub feature_loads: bool,
    /// Overlap over the smaller radius beyond which contacts are named; infinite where none is.
    pub overlap_limit: f64,
    /// Overlap with a wall over the radius beyond which the centre may go through the wall; infinite if this is not checked.
    pub deep: f64,
    /// What to observe of the contacts; `None` in most steps.
    pub watch: Option<Watch>,
    /// Whether contacts among sleepers are observed too.
    pub sees_sleepers: bool,
    /// The number of contacts that are evaluated side by side; changes no bit.
    pub width: Width,
}

impl StepContext<'_> {
    /// The time between the normal for velocities of sliding, rolling and torsion and the positions, s.
    #[must_use]
    pub fn sliding_lag(&self) -> f64 {
        match self.sliding_normal {
            SlidingNormal::HalfStep => self.velocity_lag,
            SlidingNormal::Step => 0.0,
        }
    }
}

/// Rows of exchanges from here on are of vertices of sheets, all sheets one behind the other.
pub const FIRST_VERTEX: u32 = 1 << 31;

/// Loads summed up by one block of rows: index of the block, those of earlier lists first as `None`.
pub type SavedLoads = (Option<u32>, Vec<(FeatureKey, FeatureLoad)>);

/// The function that is called for a block of particles, by its number, once the loads on them are known.
pub type Finish<'a> = dyn Fn(usize, &mut [Particle], &[Load]) -> MotionBound + Sync + 'a;

/// The largest squared speed of some particles, the largest part of their skin that they use up, and the sum of their squared speeds, which is not finite if any of them is not.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MotionBound {
    /// Largest v^2, m^2/s^2.
    pub squared_speed: f64,
    /// Largest square of the speed over half the own skin, 1/s^2 ([`HalfSkins`]).
    pub squared_part: f64,
    /// Sum of v^2 and w^2 without regard to units: a test for numbers.
    pub sum_of_squares: f64,
}

impl MotionBound {
    /// Of a particle that moves with its velocity.
    #[must_use]
    pub fn of(record: &Particle, skins: &HalfSkins) -> Self {
        let squared_speed = record.velocity.length_squared();
        Self {
            squared_speed,
            squared_part: skins.squared_part(record.radius, squared_speed),
            sum_of_squares: squared_speed + record.angular_velocity.length_squared(),
        }
    }

    /// Of both groups.
    #[must_use]
    pub fn merge(self, other: Self) -> Self {
        Self {
            squared_speed: self.squared_speed.max(other.squared_speed),
            squared_part: self.squared_part.max(other.squared_part),
            sum_of_squares: self.sum_of_squares + other.sum_of_squares,
        }
    }
}

/// The state of a listed pair, or of a particle and a feature of a wall.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SlotState {
    /// Listed: they may touch before the list is built again; there is no history.
    Near,
    /// They overlap.
    Touching,
    /// They are apart, and adhesion holds them together: a bond across the gap.
    Bonded,
    /// A wall that acts on one side is touched from behind.
    Behind,
    /// It is touched from the front, by a particle whose centre has gone through.
    Through,
    /// They overlap where a sheet bends, beside a nearer contact that this one joins.
    Joined,
}

/// A contact loop with its slots, whatever its laws.
pub trait ContactForces: Send {
    /// What the loop needs of the step.
    fn needs(&self) -> Needs {
        Needs::default()
    }

    /// Takes a new candidate list. Histories of pairs that touch or are bonded are carried over: `new_row[old]` says where each
    /// row of the last list went, `None` for rows that were removed. `parallel`: with the threads of the pool from within which
    /// it is called.
    fn adopt(
        &mut self,
        list: &CandidateList,
        near_walls: &[NearWall],
        new_row: &[Option<Row>],
        parallel: bool,
    );

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

    /// Registers which particles sleep: the loads among sleepers are held from now on. `roused`: the rows that were woken since
    /// the last call ([`ROUSED`](crate::state::ROUSED)), where nothing else changed; `None` where a particle fell asleep or the
    /// list is a new one. `context` must not request an observation.
    fn settle(
        &mut self,
        particles: &Particles,
        context: &StepContext<'_>,
        pool: Option<&rayon::ThreadPool>,
        roused: Option<&[u32]>,
    );

    /// Passes to its argument the rows of sleepers that are listed with an awake particle, block by block: loads of others do not
    /// change.
    fn visit_borders(&self, visit: &mut dyn FnMut(usize));

    /// Marks, by row, the particles listed near one of these walls (yes or no for each), or with a particle whose motion is
    /// prescribed.
    fn mark_disturbed(&self, particles: &Particles, walls: &[bool], disturbed: &mut [bool]);

    /// The held load of each row.
    fn save_held(&self) -> Vec<Load>;

    /// Restores what [`ContactForces::save_held`] returned; called after [`ContactForces::restore`].
    fn restore_held(&mut self, particles: &Particles, held: &[Load]);

    /// The events of contacts since the last call, block by block; they are removed from here. None where no law requests them.
    fn take_events(&mut self) -> Vec<ContactEvent>;

    /// The bridges that hold liquid at rows that `wanted` names, at either end, in the order of their slots.
    fn bonds(&self, wanted: &dyn Fn(usize) -> bool) -> Vec<Bond>;

    /// Replaces a bridge.
    fn set_bridge(&mut self, place: &BondPlace, bridge: Bridge);

    /// The contacts of the last evaluation that are beyond a limit; they are removed from here.
    fn take_alarms(&mut self) -> Alarms;

    /// The last observation.
    fn observation(&self, walls: usize) -> Observation;

    /// The same without the records of contacts, for callers in every step.
    fn sums(&self, walls: usize) -> Observation;

    /// The same, with the records of contacts moved out: there are more of them than particles.
    fn take_observation(&mut self, walls: usize) -> Observation;

    /// The loads on features of mesh walls since they were taken last, in order; empties them.
    fn take_feature_loads(&mut self) -> Vec<(FeatureKey, FeatureLoad)>;

    /// The same as they lie in the blocks, for restarts.
    fn save_feature_loads(&self) -> Vec<SavedLoads>;

    /// Restores what [`ContactForces::save_feature_loads`] returned; called after [`ContactForces::restore`].
    fn restore_feature_loads(&mut self, saved: &[SavedLoads]);

    /// Appends the contacts with walls that wear of the last evaluation, block by block; they are removed from here.
    fn take_rubs(&mut self, all: &mut Vec<Rub>);

    /// Shows what the contacts of the last evaluation did to sheets, block by block, in the order of the rows.
    fn visit_surface_loads(&self, visit: &mut dyn FnMut(&SurfaceLoad));

    /// Takes note of which vertices of each sheet are near which walls; contacts that last keep what they remember.
    fn adopt_vertices(&mut self, near_walls: &[Vec<NearWall>]);

    /// Computes the loads of walls on the vertices of a sheet, which count as spheres without spin. Loads on walls and energies are part of the
    /// observation; rows of exchanges begin at [`FIRST_VERTEX`]. `sheet`: its number, and that of its first vertex among those of all sheets.
    fn compute_vertices(
        &mut self,
        sheet: (usize, usize),
        vertices: &[Particle],
        context: &StepContext<'_>,
        pool: Option<&rayon::ThreadPool>,
        loads: &mut [Load],
    );

    /// What contacts of vertices with walls remember, sheet by sheet.
    fn save_vertices(&self) -> Vec<SavedSlots>;

    /// Takes back what [`ContactForces::save_vertices`] gave.
    fn restore_vertices(&mut self, saved: &[SavedSlots]);

    /// Listed pairs.
    fn listed(&self) -> usize;

    /// Pairs that touched or were bonded in the last evaluation.
    fn touching(&self) -> usize;

    /// Every slot in order, pairs first, then walls: the state that a restart needs.
    fn save(&self) -> (SavedSlots, SavedSlots);

    /// Appends the bytes of the first of [`ContactForces::save`], without making it, with the threads of a pool.
    fn put_pairs(&self, pieces: &mut Pieces, pool: Option<&rayon::ThreadPool>);

    /// Appends the bytes of the second.
    fn put_near_walls(&self, pieces: &mut Pieces);

    /// An upper estimate of the bytes of both, for this many slots of this many rows, of which `remembering` have a history.
    fn saved_bytes(&self, rows: f64, slots: f64, remembering: f64) -> f64;

    /// Slots of particles near walls.
    fn listed_at_walls(&self) -> usize;

    /// Restores what [`ContactForces::save`] returned for `rows` particles.
    fn restore(&mut self, rows: usize, pairs: &SavedSlots, walls: &SavedSlots);

    /// The length of [`SavedSlot::history`]. A loop that chooses the law at each contact saves more than it shows.
    fn saved_numbers(&self) -> usize;

    /// Unit and meaning of the numbers in [`ContactRecord::history`].
    fn history_columns(&self) -> Vec<HistoryNumber>;

    /// Bytes of the slot of a listed pair, and of its history while it is carried over to a new list: for estimates of memory.
    fn pair_bytes(&self) -> [usize; 2];
}

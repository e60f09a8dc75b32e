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
mod contacts;
mod events;
mod feature_loads;
mod near_walls;
mod needs;
mod observation;
mod offsets;
mod reports;
mod rubs;
mod saved;

pub use alarms::{Alarm, AlarmKind, Alarms, Other, Subject};
pub use blocks::{block_size, fix_block_size, parked_bytes};
pub use compiled::{contact_loop, dispatching_loop};
pub use contact_loop::ContactLoop;
pub use contacts::{
    ContactCounts, ContactForces, ContactSection, HistoryLayout, OfBlocks, SavedContacts,
};
pub use events::{ContactEvent, ContactMemory, SharedContacts, SlotPlace, ToAllRanks};
pub use feature_loads::{FeatureKey, FeatureLoad, FeatureLoads, LoadSums};
pub use near_walls::{NearWall, find_near_walls, near_walls_of_vertices};
pub use needs::{Needs, NewList};
pub use observation::{ContactRecord, Exchange, Observation, Partner, SpringEnergy, Watch};
pub use offsets::OverlapOffsets;
pub use reports::Reports;
pub use rubs::{Impact, Rub};
pub use saved::{SavedSlot, SavedSlots};

use crate::cell::Cell;
use crate::contact::SlidingNormal;
use crate::lanes::Width;
use crate::state::{Load, Particle};
use crate::surface::Surface;
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
    pub cell: &'a Cell,
    /// Walls as they are now.
    pub walls: &'a [WallNow],
    /// Sheets as they are now.
    pub surfaces: &'a [Surface],
    /// Whether each row may come near a sheet before the next list, where there are sheets: these separate pairs.
    pub beside_sheets: Option<&'a [bool]>,
    /// Overlaps that contacts of glued pairs do not count, where there are any.
    pub offsets: Option<&'a OverlapOffsets>,
    /// Films of walls, where bridges form as films meet.
    pub wall_films: Option<&'a WallFilms>,
    /// Whether R* includes the curvature of walls.
    pub wall_curvature: bool,
    /// Whether contacts of clumps are damped by the mass at the contact point.
    pub contact_point_mass: bool,
    /// Whether the loads on features of mesh walls are summed up.
    pub feature_loads: bool,
    /// Whether the loads on walls are summed up.
    pub wall_loads: bool,
    /// Overlap over the smaller radius beyond which contacts are named; infinite where none is.
    pub overlap_limit: f64,
    /// Overlap with a wall over the radius beyond which the centre may go through the wall; infinite if this is not checked.
    pub deep: f64,
    /// Observation to make of the contacts; `None` in most steps.
    pub watch: Option<Watch>,
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

/// The largest squared speed of some particles, and the sum of their squared speeds, which is not finite if any of them is not.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MotionBound {
    /// Largest v^2, m^2/s^2.
    pub squared_speed: f64,
    /// Sum of v^2 and w^2 without regard to units: a test for numbers.
    pub sum_of_squares: f64,
}

impl MotionBound {
    /// Of a particle that moves with its velocity.
    #[must_use]
    pub fn of(record: &Particle) -> Self {
        let squared_speed = record.velocity.length_squared();
        Self {
            squared_speed,
            sum_of_squares: squared_speed + record.angular_velocity.length_squared(),
        }
    }

    /// Of both groups.
    #[must_use]
    pub fn merge(self, other: Self) -> Self {
        Self {
            squared_speed: self.squared_speed.max(other.squared_speed),
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
    /// They are apart, and adhesion holds them together across the gap.
    Adhering,
    /// A wall that acts on one side is touched from behind.
    Behind,
    /// It is touched from the front, by a particle whose centre has gone through.
    Through,
    /// They overlap where a sheet bends, beside a nearer contact that this one joins.
    Joined,
}

//! The guard: what is not to be trusted stops the run, or is counted, and is named in either case.
//!
//! A contact may overlap by part of the smaller radius, and a particle may move by part of its radius in a step. Together the two
//! limits keep every particle in front of every wall at rest: one that overlaps by half its radius and moves by half its radius
//! has its centre at the wall, and no farther. The limits cost a comparison for each contact; of the displacements in a step only
//! the longest is checked, unless it is too long for some particle.

mod finding;
mod limits;
mod part;

pub use limits::{Guard, GuardPolicy};
pub(crate) use part::GuardPart;

/// By this part of its radius a centre may move against a wall in a step so that the contact loop sees it go through: before and after it, it
/// touches the wall.
pub(crate) const SEEN: f64 = 0.5;

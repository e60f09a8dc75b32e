//! Bonds: grains that are glued, to each other and to walls.
//!
//! A bond is a massless element from centre to centre of two particles, or from a centre to a point of a wall: Timoshenko's beam, or the parallel bond
//! of Potyondy & Cundall (2004). It acts beside the contacts, is kept by the ids of its ends, and breaks where its stress reaches its strength.
//!
//! | file | holds |
//! |---|---|
//! | `element` | the element: its law and its constants |
//! | `evaluation` | forces, couples, energy and stresses from positions and rotations of the ends: pure functions, in lanes |
//! | `bond` | a bond of a run: its element and its ends |
//! | `groups` | all bonds, column by column: what each step reads and writes |
//! | `gluing` | which pairs are glued, at the start and at touches |
//! | `critical` | the largest stable step |
//! | `part` | the bonds in a step, also those of one of several ranks |

mod bond;
mod critical;
mod element;
mod evaluation;
mod gluing;
mod groups;
mod part;
#[cfg(test)]
mod tests;

pub use bond::{Bond, Break, BreakMode};
pub use critical::{BondedStart, LeastStep, SmallestGrain, look_ahead};
pub use element::{Action, Element, Ends, LawOfBonds, Mobility, Modes, Section};
pub use gluing::StartOfBonds;
pub use part::{BondCounts, Bonds};

use crate::boundaries::Region;
use crate::state::MaterialIndex;

/// Reach of glue at the start over the smaller radius, where none is given.
pub const DEFAULT_REACH: f64 = 1e-3;

/// An entry of bonds, resolved.
#[derive(Debug, Clone, PartialEq)]
pub struct BondPlan {
    /// Unique among the entries.
    pub name: String,
    /// Materials that are glued, in either order; `None`: any. A wall is glued to particles of both.
    pub between: Option<[MaterialIndex; 2]>,
    /// When pairs are glued.
    pub when: Gluing,
    /// The region in which both centres lie; `None`: everywhere.
    pub within: Option<Region>,
    /// Walls to which particles are glued too, by index.
    pub walls: Vec<usize>,
    /// Law of the element.
    pub law: LawOfBonds,
    /// Radius of the section over the smaller radius of both ends.
    pub radius_ratio: f64,
    /// Damping, as a fraction of critical, of each mode.
    pub damping: f64,
    /// Tension and shear (Pa) at which it breaks; infinite: never.
    pub strengths: [f64; 2],
    /// Coefficient of variation of both strengths.
    pub strength_spread: f64,
    /// Whether the contact law acts where the pair overlaps more than when it was glued; false: not at all until the bond breaks.
    pub contact: bool,
}

/// When pairs are glued.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Gluing {
    /// At the start, with gaps up to this reach, m; `None`: [`DEFAULT_REACH`] of the smaller radius.
    Start(Option<f64>),
    /// At their first touch within this time, s.
    Contact {
        /// Start, s.
        from: f64,
        /// End, s; infinite: never.
        until: f64,
    },
}

impl BondPlan {
    /// Whether particles of these materials are glued.
    fn glues(&self, pair: [MaterialIndex; 2]) -> bool {
        let [a, b] = pair;
        self.between
            .is_none_or(|between| between == [a, b] || between == [b, a])
    }

    /// Whether particles of this material are glued to walls.
    fn glues_to_walls(&self, material: MaterialIndex) -> bool {
        self.between
            .is_none_or(|between| between.contains(&material))
    }
}

//! The law of a pair of materials with all its numbers.

use mercury_engine::contact::parameter::Parameter;
use mercury_engine::contact::registry::AnyPairLaw;
use mercury_engine::state::MaterialIndex;

/// The law of two materials with all its numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct PairPlan {
    /// Rows of the two materials, ascending.
    pub materials: [MaterialIndex; 2],
    /// Their names.
    pub names: [String; 2],
    /// Whether particles of the two can meet.
    pub between_particles: bool,
    /// Whether particles of one can meet walls of the other.
    pub at_walls: bool,
    /// The law.
    pub law: AnyPairLaw,
    /// Every resolved number.
    pub parameters: Vec<Parameter>,
}

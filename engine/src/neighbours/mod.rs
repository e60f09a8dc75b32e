//! Finding neighbours: cells, the sort, and the list of candidate pairs.
//!
//! The list holds every pair whose surfaces are closer than a skin. It stays valid until a particle has moved half the
//! skin, or its extra skin more; then the particles are sorted into cells and the list is built anew. `validity` keeps that account.

mod boxes;
mod bricks;
mod cells;
mod exclusions;
mod extra_skin;
mod grid;
mod hilbert;
mod levels;
mod list;
mod margin;
mod other_pairs;
mod skin;
mod validity;

pub use boxes::{Block, Boxes};
pub use cells::Cells;
pub use exclusions::Exclusions;
pub use extra_skin::extra_skins;
pub use grid::Grid;
pub use levels::Levels;
pub use list::{Built, Candidate, CandidateList, Common, build, build_bytes, list_bytes};
pub use margin::Margin;
pub use skin::Skin;
pub use validity::{Validity, used};

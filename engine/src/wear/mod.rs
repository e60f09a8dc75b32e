//! Wear: walls lose volume where particles slide along them or hit them, and their surfaces follow.
//!
//! The contact loop notes each contact with a wall that wears ([`Rub`]). After the forces [`Wear::note`] turns them into volumes
//! ([`WearLaw`]), which are owed by the vertices of the triangle. Now and then [`Worn`] makes displacements of what is owed, so that the signed
//! volume between the first surface and the present one is what was owed. See `docs/theory/wear.md`.

mod law;
mod moves;
mod part;
mod saved;
mod skin;
#[cfg(test)]
mod tests;
mod worn;

pub use law::{WearBasis, WearLaw, WearPlan};
pub use saved::{SavedWear, SavedWorn};
pub use worn::{WearRow, Worn, WornThrough, WornVertex};

use crate::forces::Rub;
use crate::walls::WallNow;

/// The step part that wears walls.
#[derive(Debug, Clone, PartialEq)]
pub struct Wear {
    /// The walls that wear, in the order of the plan.
    pub walls: Vec<Worn>,
    /// Place in `walls` of each wall of the plan, if it wears.
    place_of: Vec<Option<usize>>,
    /// Contacts of the last evaluation; kept for its memory.
    rubs: Vec<Rub>,
    /// Whether a wall has reached its `until_depth`.
    is_worn: bool,
}

impl Wear {
    /// Unworn walls, or `None` where none wears.
    #[must_use]
    pub fn new(plans: &[WearPlan], walls: &[WallNow]) -> Option<Self> {
        let worn: Vec<Worn> = plans
            .iter()
            .filter_map(|plan| Some(Worn::new(*plan, walls.get(plan.wall)?.shape().mesh()?)))
            .collect();
        let mut place_of = vec![None; walls.len()];
        for (place, wall) in worn.iter().enumerate() {
            place_of[wall.plan().wall] = Some(place);
        }
        (!worn.is_empty()).then_some(Self {
            walls: worn,
            place_of,
            rubs: Vec::new(),
            is_worn: false,
        })
    }

    /// The list for the contacts of an evaluation, empty.
    pub fn rubs(&mut self) -> &mut Vec<Rub> {
        self.rubs.clear();
        &mut self.rubs
    }

    /// Adds the wear by the contacts of the list. Afterwards [`Worn::is_due`] marks the surfaces to move.
    pub fn note(&mut self, walls: &[WallNow]) {
        for rub in &self.rubs {
            let index = usize::from(rub.wall);
            let place = self.place_of.get(index).copied().flatten();
            let mesh = walls.get(index).and_then(|wall| wall.shape().mesh());
            if let (Some(place), Some(mesh)) = (place, mesh) {
                self.walls[place].note(rub, mesh);
            }
        }
        self.is_worn |= self.walls.iter().any(Worn::is_worn);
    }

    /// A surface has moved: looks again whether one is worn.
    pub fn note_move(&mut self) {
        self.is_worn |= self.walls.iter().any(Worn::is_worn);
    }

    /// Whether a wall has reached the depth at which the run ends.
    #[must_use]
    pub fn is_worn(&self) -> bool {
        self.is_worn
    }
}

//! Walls that wear: what the contacts of a step wear, and surfaces that follow.

use mercury_common::readable::rounded;

use super::{Engine, RunError};
use crate::contact::parameter::short;
use crate::plan::GuardPolicy;
use crate::state::WallIndex;
use crate::wear::{Wear, Worn};

impl Engine {
    /// Adds what the contacts of this step wear. Surfaces that are due move; in the last step of the plan all that owe something.
    pub(super) fn wear_walls(&mut self) -> Result<(), RunError> {
        let Some(mut wear) = self.wear.take() else {
            return Ok(());
        };
        self.forces.contacts.take_rubs(wear.rubs());
        wear.note(&self.walls);
        let is_last = self.step == self.plan.physics().steps();
        let moved = self.move_surfaces(&mut wear, |worn| worn.is_due() || is_last);
        self.wear = Some(wear);
        moved
    }

    /// Moves the surfaces of all walls that owe something: at the end of a run that ends before its time.
    ///
    /// # Errors
    /// If a thin wall is worn through, and the guard is strict.
    pub fn settle_wear(&mut self) -> Result<(), RunError> {
        let Some(mut wear) = self.wear.take() else {
            return Ok(());
        };
        let moved = self.move_surfaces(&mut wear, |_| true);
        self.wear = Some(wear);
        moved
    }

    fn move_surfaces(
        &mut self,
        wear: &mut Wear,
        is_wanted: impl Fn(&Worn) -> bool,
    ) -> Result<(), RunError> {
        for worn in &mut wear.walls {
            if !(worn.is_owing() && is_wanted(worn)) {
                continue;
            }
            let index = worn.plan().wall;
            worn.advance();
            let changed = self.walls[index].reshape(&worn.corners(), &self.images);
            changed.map_err(|error| self.wall_error(WallIndex::new(index as u16), error))?;
            let mesh = self.walls[index].shape().mesh();
            if mesh.is_some_and(|mesh| worn.find_worn_through(mesh)) {
                self.guard_worn_through(worn)?;
            }
        }
        wear.note_move();
        Ok(())
    }

    /// A thin wall is worn through for the first time.
    fn guard_worn_through(&self, worn: &Worn) -> Result<(), RunError> {
        match self.plan.physics().guard().policy {
            GuardPolicy::Warn | GuardPolicy::Off => Ok(()),
            GuardPolicy::Strict => Err(RunError::Guarded {
                step: self.step,
                time: self.time(),
                what: self.worn_through(worn).unwrap_or_default(),
                help: "end the run before with until_depth, lower the acceleration, or go on with guard.policy = \"warn\": there the surface stays then"
                    .to_owned(),
            }),
        }
    }

    /// Where a wall is worn through, in words.
    fn worn_through(&self, worn: &Worn) -> Option<String> {
        let found = worn.worn_through()?;
        let name = &self.plan.physics().walls()[worn.plan().wall].name;
        let [x, y, z] = found.place.to_array().map(short);
        Some(format!(
            "wall `{name}` is worn through at [{x}, {y}, {z}] m (its own frame), in move {} of its surface: its two faces came closer than a thousandth of an edge",
            found.moves
        ))
    }

    /// Contacts of the start are no impacts.
    pub(super) fn forget_rubs(&mut self) {
        if let Some(wear) = &mut self.wear {
            self.forces.contacts.take_rubs(wear.rubs());
            wear.rubs();
        }
    }

    /// Whether a wall is worn to the depth at which the run ends.
    #[must_use]
    pub fn is_worn(&self) -> bool {
        self.wear.as_ref().is_some_and(Wear::is_worn)
    }

    /// The walls that wear, in scenes that have any.
    #[must_use]
    pub fn wear(&self) -> Option<&Wear> {
        self.wear.as_ref()
    }

    /// What a user should know of worn walls, a line each.
    #[must_use]
    pub fn wear_warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        let guard = self.plan.physics().guard().policy;
        for worn in self.wear.iter().flat_map(|wear| &wear.walls) {
            let name = &self.plan.physics().walls()[worn.plan().wall].name;
            let row = worn.row();
            if let Some(through) = self
                .worn_through(worn)
                .filter(|_| guard != GuardPolicy::Off)
            {
                warnings.push(format!(
                    "{through}; there it stays as it is, and what it owes is pending"
                ));
            }
            if row.blocked > 0 {
                warnings.push(format!(
                    "walls.{name}: {} vertices cannot move as far as they are worn, as triangles there would turn by more than 60 degrees, lose 99 % of their area or meet the other face: {:.3e} of {:.3e} m3 are pending; refine the mesh there, or end the run before",
                    row.blocked, row.pending, row.owed
                ));
            }
            if row.front > 0.0 && row.back > 0.0 && worn.plan().moves {
                warnings.push(format!(
                    "walls.{name}: it is worn from both sides, by {:.3e} and {:.3e} m3; a sheet has no thickness, so its surface moves by the difference: give the wall two faces",
                    row.front, row.back
                ));
            }
            if worn.largest_move() > 10.0 {
                warnings.push(format!(
                    "walls.{name}: a vertex moved at once by {} times what `step` allows: lower the acceleration",
                    rounded(worn.largest_move(), 3)
                ));
            }
        }
        warnings
    }
}

//! Walls that wear in a step: what the contacts wear, and surfaces that follow.

use mercury_common::readable::rounded;

use super::{Wear, WearPlan, Worn};
use crate::contact::parameter::short;
use crate::forces::Observation;
use crate::guard::GuardPolicy;
use crate::physics::{FeaturePlan, InputError, Inputs, Setup, number, present};
use crate::state::{Pieces, Plain, WallIndex};
use crate::step::{Core, Engine, Part, RunError, SizeEstimate};
use crate::walls::Shape;

impl FeaturePlan for WearPlan {
    /// At most one for each wall, of meshes alone, in their order.
    fn check(plans: &[Self], inputs: &Inputs) -> Result<(), InputError> {
        for (index, wear) in plans.iter().enumerate() {
            present("wear", index, "wall", wear.wall as u32, inputs.walls.len())?;
            let is_mesh = matches!(inputs.walls[wear.wall].shape, Shape::Mesh(_));
            let is_next = index == 0 || plans[index - 1].wall < wear.wall;
            if !(is_mesh && is_next) {
                let what = format!("the wall of wear {index}");
                return Err(number(&what, "a mesh, each once and in order", wear.wall));
            }
        }
        Ok(())
    }
}

impl Part for Wear {
    fn name(&self) -> &str {
        "wear"
    }

    fn of(core: &mut Core) -> Option<Self> {
        let wear = Self::new(core.physics().plans.all(), &core.domain.walls)?;
        for wall in &wear.walls {
            core.domain.walls[wall.plan().wall].set_wearing();
        }
        Some(wear)
    }

    fn bytes(setup: &Setup, _: &SizeEstimate) -> f64 {
        let walls = &setup.physics.walls;
        let plans = setup.physics.plans.all::<WearPlan>().iter();
        let meshes = plans.filter_map(|plan| Some((plan, walls[plan.wall].shape.mesh()?)));
        meshes
            .map(|(plan, mesh)| {
                // The wall has a mesh of its own as soon as it moves.
                let own = if plan.moves { mesh.bytes() } else { 0 };
                own as f64 + Worn::bytes_of(mesh)
            })
            .sum()
    }

    fn after_forces(&mut self, core: &mut Core, _: Option<&Observation>) {
        core.contacts.take_rubs(self.rubs());
        core.join_ranks(&mut self.rubs);
        if core.steps() == 0 {
            // Contacts of the start are no impacts.
            self.rubs();
        }
    }

    /// Adds what the contacts of this step wear. Surfaces that are due move; in the last step of the plan all that owe something.
    fn end_step(&mut self, core: &mut Core) -> Result<(), RunError> {
        self.note(&core.domain.walls);
        let is_last = core.steps() == core.physics().steps;
        self.move_surfaces(core, |worn| worn.is_due() || is_last)
    }

    /// Every rank wears its own copy of the walls by the contacts of all.
    fn works_on_ranks(&self) -> bool {
        true
    }

    fn ends_run(&self) -> bool {
        self.is_worn()
    }

    fn warnings(&self, core: &Core) -> Vec<String> {
        let mut warnings = Vec::new();
        let guard = core.physics().guard.policy;
        for worn in &self.walls {
            let name = &core.physics().walls[worn.plan().wall].name;
            let row = worn.row();
            if let Some(through) = worn_through(core, worn).filter(|_| guard != GuardPolicy::Off) {
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

    fn put(&self, _: &Core, pieces: &mut Pieces) {
        self.save().put(pieces.end());
    }

    fn take(&mut self, _: &mut Core, bytes: &mut &[u8]) -> Result<(), String> {
        self.restore(&Plain::take(bytes)?)
    }
}

impl Engine {
    /// Moves the surfaces of all walls that owe something: at the end of a run that ends before its time.
    ///
    /// # Errors
    /// If a thin wall is worn through, and the guard is strict.
    pub fn settle_wear(&mut self) -> Result<(), RunError> {
        match self.part_and_core::<Wear>() {
            Some((wear, core)) => wear.move_surfaces(core, |_| true),
            None => Ok(()),
        }
    }

    /// The walls that wear, in scenes that have any.
    #[must_use]
    pub fn wear(&self) -> Option<&Wear> {
        self.part()
    }
}

impl Wear {
    fn move_surfaces(
        &mut self,
        core: &mut Core,
        is_wanted: impl Fn(&Worn) -> bool,
    ) -> Result<(), RunError> {
        for worn in &mut self.walls {
            if !(worn.is_owing() && is_wanted(worn)) {
                continue;
            }
            let index = worn.plan().wall;
            if let Some(mesh) = core.domain.walls[index].shape().mesh() {
                worn.advance(mesh);
            }
            core.reshape_wall(WallIndex::new(index as u16), &worn.corners())?;
            let mesh = core.domain.walls[index].shape().mesh();
            if mesh.is_some_and(|mesh| worn.find_worn_through(mesh)) {
                guard_worn_through(core, worn)?;
            }
        }
        self.note_move();
        Ok(())
    }
}

/// A thin wall is worn through for the first time.
fn guard_worn_through(core: &Core, worn: &Worn) -> Result<(), RunError> {
    match core.physics().guard.policy {
        GuardPolicy::Warn | GuardPolicy::Off => Ok(()),
        GuardPolicy::Strict => Err(RunError::Guarded {
            step: core.steps(),
            time: core.time(),
            what: worn_through(core, worn).unwrap_or_default(),
            help: "end the run before with until_depth, lower the acceleration, or go on with guard.policy = \"warn\": there the surface stays then"
                .to_owned(),
        }),
    }
}

/// Where a wall is worn through, in words.
fn worn_through(core: &Core, worn: &Worn) -> Option<String> {
    let found = worn.worn_through()?;
    let name = &core.physics().walls[worn.plan().wall].name;
    let [x, y, z] = found.place.to_array().map(short);
    Some(format!(
        "wall `{name}` is worn through at [{x}, {y}, {z}] m (its own frame), in move {} of its surface: its two faces came closer than a thousandth of an edge",
        found.moves
    ))
}

//! Droplets in a step.

use super::{Sprays, Surroundings};
use crate::forces::Needs;
use crate::state::{Pieces, Plain};
use crate::step::{Core, Engine, Part, RunError};

impl Part for Sprays {
    fn name(&self) -> &str {
        "sprays"
    }

    fn needs(&self) -> Needs {
        Needs {
            all_walls: true,
            ..Needs::default()
        }
    }

    /// Releases droplets and moves them to the end of the step.
    fn before_forces(&mut self, core: &mut Core) -> Result<(), RunError> {
        // The forces before the first step are those of its beginning.
        if core.step == 0 {
            return Ok(());
        }
        let time = core.time();
        let physics = &core.physics;
        let Some(plan) = &physics.sprays else {
            return Ok(());
        };
        let around = Surroundings {
            time,
            dt: physics.time_step,
            gravity: physics.gravity,
            walls: &core.walls,
            images: &core.images,
            fastest: core.fastest(),
            rebuilds: core.lists.rebuilds,
        };
        let advanced = self.advance(plan, &mut core.particles, &mut core.wall_films, &around);
        advanced.map_err(|error| RunError::Droplets { time, error })
    }

    fn put(&self, _: &Core, pieces: &mut Pieces) {
        self.state.put(pieces.end());
    }

    fn take(&mut self, _: &mut Core, bytes: &mut &[u8]) -> Result<(), String> {
        self.restore(Plain::take(bytes)?)
    }
}

impl Sprays {
    /// In scenes with sprays.
    pub(crate) fn of(core: &Core) -> Option<Self> {
        core.physics.sprays.as_ref().map(Self::new)
    }
}

impl Engine {
    /// The droplets in flight and where their liquid went, in scenes with sprays.
    #[must_use]
    pub fn sprays(&self) -> Option<&Sprays> {
        self.part()
    }
}

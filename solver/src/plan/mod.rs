//! The plan: the meaning of a scene. Everything is resolved, checked and decided here, so that the kernels can trust it.

mod checkpoint_identity;
mod checks;
mod closing;
mod clumps;
mod disk;
mod document;
pub(crate) mod doubtful;
mod draft;
mod expected;
mod fields;
mod files;
mod largest;
mod levels;
mod magnitudes;
mod memory;
pub(crate) mod meshes;
mod mistakes;
pub(crate) mod motions;
mod notes;
mod outputs;
mod pair;
mod particle_table;
pub(crate) mod particles;
mod passes;
mod reading;
mod refusal;
mod report;
mod requests;
mod schema;
mod settled;
mod stages;
mod start_from_frame;
mod start_from_run;
mod sums;
#[cfg(test)]
mod tests;
mod time_step;
pub(crate) mod usage;
pub(crate) mod wall_shapes;
pub(crate) mod walls;
mod workload;

pub use checkpoint_identity::{Head, POSITIONS, checkpoint_paths};
pub use disk::Disk;
pub use document::{document, document_as_json};
pub use draft::Draft;
pub use expected::{Counted, Expected, LeftOut, expected};
pub use fields::{FieldPlan, MOST_FIELDS};
pub use files::{SceneFile, files};
pub use largest::{Largest, largest, lattice_grains};
pub use memory::{Memory, StartBytes};
pub use mercury_engine::contact::parameter::{Origin, Parameter, Value};
pub use mistakes::read_all;
pub use notes::Notes;
pub use outputs::{MeshFile, OutputPlan, Outputs};
pub use pair::PairPlan;
pub use passes::{Pass, passes};
pub use reading::{parse_scene, read_scene};
pub use refusal::refusal;
pub use report::report;
pub use schema::schema;
pub use settled::Settled;
pub use stages::{plan, sketch};
pub use start_from_run::StartedFrom;
pub use sums::{FileSum, hex, sha256, summed};
pub use time_step::{Limit, Meeting, StepPlan};
pub use workload::{Ahead, Here, Workload};

use std::sync::Arc;

use mercury_common::scene::Domain;
pub use mercury_engine::bodies::NewBody;
use mercury_engine::cell::Cell;
pub use mercury_engine::guard::{Guard, GuardPolicy};
pub use mercury_engine::physics::{Carried, Physics, ScheduledChange};
use mercury_engine::physics::{Setup, ToSetup, Watched};
pub use mercury_engine::state::{Material, NewParticle, PrescribedMotion};

/// Reading methods of private fields, each with its documentation; `copy` by value, `borrow` by reference.
macro_rules! getters {
    ($($(#[$doc:meta])* $kind:ident $name:ident: $type:ty;)*) => {
        $(getters!(@$kind $(#[$doc])* $name: $type);)*
    };
    (@copy $(#[$doc:meta])* $name:ident: $type:ty) => {
        $(#[$doc])*
        #[must_use]
        pub fn $name(&self) -> $type {
            self.$name
        }
    };
    (@borrow $(#[$doc:meta])* $name:ident: $type:ty) => {
        $(#[$doc])*
        #[must_use]
        pub fn $name(&self) -> &$type {
            &self.$name
        }
    };
}
use getters;

/// The periodic box of a scene.
pub(crate) fn cell_of(domain: &Domain) -> Cell {
    Cell::new(*domain.min, *domain.max, domain.periodic)
}

/// A run, resolved and checked: made once, by [`plan`] from a scene or by [`Draft::plan`] by hand, and never changed.
#[derive(Debug, Clone)]
pub struct Plan {
    physics: Arc<Physics>,
    outputs: Outputs,
    notes: Notes,
}

impl Plan {
    /// Physics that the run simulates.
    #[must_use]
    pub fn physics(&self) -> &Physics {
        &self.physics
    }

    /// The first wall that another program drives.
    #[must_use]
    pub fn driven_wall(&self) -> Option<&str> {
        let mut walls = self.physics.walls.iter();
        let driven = walls.find(|wall| wall.motion.is_external());
        driven.map(|wall| wall.name.as_str())
    }

    /// Files that the run writes.
    #[must_use]
    pub fn outputs(&self) -> &Outputs {
        &self.outputs
    }

    /// Notes for the user.
    #[must_use]
    pub fn notes(&self) -> &Notes {
        &self.notes
    }
}

impl ToSetup for Plan {
    fn to_setup(&self) -> Setup {
        let files = self.outputs.files();
        Setup {
            physics: Arc::clone(&self.physics),
            watched: Watched {
                fluxes: self.outputs.fluxes().to_vec(),
                passages: files.left,
                triangle_loads: files.triangle_loads,
                load_sums: [files.frames, files.vtk],
                tracking: files.tracking(),
            },
        }
    }
}

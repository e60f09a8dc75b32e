//! The plan: the meaning of a scene. Everything is resolved, checked and decided here, so that the kernels can trust it.

mod bridges;
mod build;
mod checkpoint_identity;
mod checks;
mod closing;
mod clumps;
mod disk;
mod document;
mod doubtful;
mod draft;
mod event;
mod expected;
mod fields;
mod files;
mod fluxes;
mod guard;
mod insertions;
mod largest;
mod magnitudes;
mod membranes;
mod memory;
mod meshes;
mod motions;
mod notes;
mod number_table;
mod outputs;
mod pair;
mod particle_table;
mod particles;
mod passes;
mod physics;
mod reading;
mod refusal;
mod regions;
mod report;
mod requests;
mod schema;
mod sizes;
mod sleeping;
mod sprays;
mod start_from_run;
#[cfg(test)]
mod tests;
mod time_step;
mod usage;
mod wall_films;
mod walls;
mod wear;
mod workload;

pub use crate::contact::parameter::{Origin, Parameter, Value};
pub use build::{plan, sketch};
pub use checkpoint_identity::{Head, checkpoint_paths};
pub use disk::Disk;
pub use document::{document, document_as_json};
pub use draft::{Draft, DraftError};
pub use event::Event;
pub use expected::{Counted, Expected, LeftOut, expected};
pub use fields::{FieldPlan, MOST_FIELDS};
pub use files::{SceneFile, files};
pub use guard::{Guard, GuardPolicy};
pub use insertions::expected_number;
pub(crate) use insertions::mean_volume;
pub use largest::{Largest, largest, lattice_grains};
pub use memory::{Memory, StartBytes};
pub use notes::Notes;
pub use outputs::{OutputPlan, Outputs};
pub use pair::PairPlan;
pub use passes::{Pass, passes};
pub use physics::Physics;
pub use reading::{parse_scene, read_scene};
pub use refusal::refusal;
pub use report::report;
pub use schema::schema;
pub use start_from_run::{Carried, StartedFrom};
pub use time_step::{Limit, Meeting, StepPlan};
pub use workload::{Ahead, Here, Workload};

pub use crate::bodies::NewBody;
pub use crate::state::{Material, NewParticle, PrescribedMotion};

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

/// A run, resolved and checked: made once, by [`plan`] from a scene or by [`Draft::plan`] by hand, and never changed.
#[derive(Debug, Clone)]
pub struct Plan {
    physics: Physics,
    outputs: Outputs,
    notes: Notes,
}

impl Plan {
    getters! {
        /// What the run simulates.
        borrow physics: Physics;
        /// What it writes.
        borrow outputs: Outputs;
        /// What its user should know.
        borrow notes: Notes;
    }
}

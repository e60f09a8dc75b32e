//! Plans by hand, for library users and tests.

use std::ops::{Deref, DerefMut};
use std::sync::Arc;

use glam::DVec3;

use super::{Notes, OutputPlan, Outputs, Plan};
use mercury_engine::bodies::{Clump, NewBody};
use mercury_engine::boundaries::{CountedRegion, FluxPlan};
use mercury_engine::contact::registry::AnyPairLaw;
use mercury_engine::physics::{InputError, Inputs};
use mercury_engine::state::NewParticle;

/// A plan to be filled in: set the fields, those of [`Inputs`] among them, then [`Draft::plan`] makes a consistent plan of it.
///
/// [`Draft::new`] has one material, an empty domain, no gravity and no output.
#[derive(Debug, Clone)]
pub struct Draft {
    /// Title.
    pub title: String,
    /// Prefix of all output files.
    pub prefix: String,
    /// Inputs of the simulation.
    pub inputs: Inputs,
    /// Regions whose content is counted.
    pub regions: Vec<CountedRegion>,
    /// Planes that count what crosses them.
    pub fluxes: Vec<FluxPlan>,
    /// Output files, and the times at which they are written.
    pub output: OutputPlan,
}

impl Deref for Draft {
    type Target = Inputs;

    fn deref(&self) -> &Inputs {
        &self.inputs
    }
}

impl DerefMut for Draft {
    fn deref_mut(&mut self) -> &mut Inputs {
        &mut self.inputs
    }
}

impl Draft {
    /// As [`Inputs::new`].
    #[must_use]
    pub fn new(time_step: f64, domain: (DVec3, DVec3), density: f64, law: AnyPairLaw) -> Self {
        Self {
            title: String::new(),
            prefix: String::new(),
            inputs: Inputs::new(time_step, domain, density, law),
            regions: Vec::new(),
            fluxes: Vec::new(),
            output: OutputPlan::default(),
        }
    }

    /// With these particles instead of the present ones.
    #[must_use]
    pub fn with_particles(mut self, particles: Vec<NewParticle>) -> Self {
        self.inputs = self.inputs.with_particles(particles);
        self
    }

    /// With these clumps and bodies instead of the present ones.
    #[must_use]
    pub fn with_bodies(mut self, clumps: Vec<Clump>, bodies: Vec<NewBody>) -> Self {
        self.inputs = self.inputs.with_bodies(clumps, bodies);
        self
    }

    /// The plan.
    ///
    /// # Errors
    /// If a number is not valid, or a material, wall or clump does not exist.
    pub fn plan(self) -> Result<Plan, InputError> {
        Ok(Plan {
            physics: Arc::new(self.inputs.physics()?),
            outputs: Outputs {
                title: self.title,
                prefix: self.prefix,
                files: self.output,
                regions: self.regions,
                fluxes: self.fluxes,
                mesh_files: Vec::new(),
            },
            notes: Notes::default(),
        })
    }
}

impl Plan {
    /// The inputs of a plan, to be changed and planned again; its notes are left out.
    #[must_use]
    pub fn draft(&self) -> Draft {
        let outputs = self.outputs.clone();
        Draft {
            title: outputs.title,
            prefix: outputs.prefix,
            inputs: self.physics.inputs().clone(),
            regions: outputs.regions,
            fluxes: outputs.fluxes,
            output: outputs.files,
        }
    }
}

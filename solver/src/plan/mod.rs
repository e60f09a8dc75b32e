//! The plan: what a scene means. Everything is resolved, checked and decided here, so that the kernels can trust it.

mod build;
mod checks;
mod clumps;
mod document;
mod expected;
mod insertions;
mod memory;
mod meshes;
mod pair;
mod particles;
mod passes;
mod reading;
mod refusal;
mod regions;
mod report;
mod sizes;
#[cfg(test)]
mod tests;
mod time_step;
mod unsupported;
mod usage;
mod walls;

pub use crate::contact::mixing::harmonic_mean;
pub use crate::contact::parameter::{Origin, Parameter, Value};
pub use build::plan;
pub use document::document;
pub use expected::{Counted, Expected, expected};
pub use insertions::expected_number;
pub use memory::{Memory, StartBytes};
pub use pair::PairPlan;
pub use passes::{Pass, passes};
pub use reading::{parse_scene, read_scene};
pub use refusal::refusal;
pub use report::report;
pub use time_step::{Limit, Meeting, StepPlan};

pub use crate::bodies::NewBody;
pub use crate::state::{Material, NewParticle};

use glam::DVec3;
use mercury_common::formats::number::NumberStyle;

use crate::bodies::Clump;
use crate::boundaries::{CountedRegion, DeletionPlan, InsertionPlan, Setting};
use crate::contact::registry::{AnyPairLaw, LawTable};
use crate::walls::Wall;

/// A run, resolved and checked.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Title of the scene.
    pub title: String,
    /// Prefix of all output files: the stem of the scene file.
    pub prefix: String,
    /// Seed of every random choice.
    pub seed: u64,
    /// Gravity, m/s^2.
    pub gravity: DVec3,
    /// 3, or 2 for discs.
    pub dimensions: u8,
    /// Time step, s.
    pub time_step: f64,
    /// Steps to make.
    pub steps: u64,
    /// Also ends when the particles have come to rest.
    pub until_at_rest: bool,
    /// Lower corner of the domain, m.
    pub domain_min: DVec3,
    /// Upper corner of the domain, m.
    pub domain_max: DVec3,
    /// Periodic axes.
    pub periodic: [bool; 3],
    /// Materials in the order of the file.
    pub materials: Vec<Material>,
    /// Laws of all pairs of materials.
    pub laws: LawTable,
    /// R* includes the curvature of walls.
    pub wall_curvature: bool,
    /// Springs advance in the force evaluation before the first step.
    pub startup_increment: bool,
    /// Contacts of clumps are damped by the mass at the contact point instead of that of the whole body.
    pub contact_point_mass: bool,
    /// Walls.
    pub walls: Vec<Wall>,
    /// Particles of the start, in the order of their ids.
    pub particles: Vec<NewParticle>,
    /// Templates of rigid bodies, in the order of the file.
    pub clumps: Vec<Clump>,
    /// Bodies of the start, in the order of their ids, which follow those of `particles`.
    pub bodies: Vec<NewBody>,
    /// Insertions.
    pub insertions: Vec<InsertionPlan>,
    /// Deletions.
    pub deletions: Vec<DeletionPlan>,
    /// Regions whose content is counted.
    pub regions: Vec<CountedRegion>,
    /// Smallest radius that can occur, m.
    pub smallest_radius: f64,
    /// Mean radius expected, m.
    pub mean_radius: f64,
    /// Largest radius that can occur, m.
    pub largest_radius: f64,
    /// Whether rotations are integrated: something writes them.
    pub orientations: bool,
    /// Whether the energy is audited in every step.
    pub energy_budget: bool,
    /// What is written, and when.
    pub output: OutputPlan,
    /// What was counted while the start was read and looked over.
    pub counted: Counted,
    /// Every pair of materials that can meet, with all its numbers and where they came from.
    pub pairs: Vec<PairPlan>,
    /// Why the time step is what it is.
    pub step: StepPlan,
    /// What may be wrong with the run.
    pub warnings: Vec<String>,
    /// What else its user should know.
    pub notes: Vec<String>,
}

impl Plan {
    /// A plan for library users to fill in: one material of the given density (kg/m^3) whose contacts with itself follow
    /// `law`, an empty domain, no gravity, no output. Radii must be set before particles are added by hand.
    #[must_use]
    pub fn bare(time_step: f64, domain: (DVec3, DVec3), density: f64, law: AnyPairLaw) -> Self {
        Self {
            title: String::new(),
            prefix: String::new(),
            seed: 0,
            gravity: DVec3::ZERO,
            dimensions: 3,
            time_step,
            steps: 0,
            until_at_rest: false,
            domain_min: domain.0,
            domain_max: domain.1,
            periodic: [false; 3],
            materials: vec![Material {
                name: "material".to_owned(),
                density,
            }],
            laws: LawTable {
                materials: 1,
                laws: vec![Some(law)],
            },
            wall_curvature: false,
            startup_increment: false,
            contact_point_mass: false,
            walls: Vec::new(),
            particles: Vec::new(),
            clumps: Vec::new(),
            bodies: Vec::new(),
            insertions: Vec::new(),
            deletions: Vec::new(),
            regions: Vec::new(),
            smallest_radius: 0.0,
            mean_radius: 0.0,
            largest_radius: 0.0,
            orientations: false,
            energy_budget: false,
            output: OutputPlan {
                interval: f64::INFINITY,
                fstat_interval: f64::INFINITY,
                vtk_interval: f64::INFINITY,
                data: false,
                ene: false,
                fstat: false,
                vtk: false,
                frames: false,
                walls: false,
                triangle_loads: false,
                pictures: false,
                pebbles: false,
                track: Vec::new(),
                digits: None,
            },
            counted: Counted::default(),
            pairs: Vec::new(),
            step: StepPlan::default(),
            warnings: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// Adds particles and takes their radii into account.
    #[must_use]
    pub fn with_particles(mut self, particles: Vec<NewParticle>) -> Self {
        self.particles = particles;
        self.take_radii_in();
        self
    }

    /// Adds bodies of these clumps and takes the radii of their pebbles into account.
    #[must_use]
    pub fn with_bodies(mut self, clumps: Vec<Clump>, bodies: Vec<NewBody>) -> Self {
        (self.clumps, self.bodies) = (clumps, bodies);
        self.take_radii_in();
        self
    }

    /// Whether rigid bodies are there or come.
    #[must_use]
    pub fn has_bodies(&self) -> bool {
        let mut mixtures = self.insertions.iter().flat_map(|plan| &plan.mixture);
        !self.bodies.is_empty() || mixtures.any(|part| part.clump.is_some())
    }

    /// What its boundaries need to know beside the insertions and deletions.
    #[must_use]
    pub fn setting(&self) -> Setting<'_> {
        Setting {
            domain: (self.domain_min, self.domain_max),
            periodic: self.periodic,
            dimensions: self.dimensions,
            materials: &self.materials,
            clumps: &self.clumps,
            time_step: self.time_step,
            seed: self.seed,
        }
    }

    fn take_radii_in(&mut self) {
        let of_spheres = self.particles.iter().map(|particle| particle.radius);
        let of_pebbles = self.bodies.iter().flat_map(|body| {
            let pebbles = body.clump(&self.clumps).pebbles.iter();
            pebbles.map(|pebble| pebble.radius * body.scale)
        });
        let radii: Vec<f64> = of_spheres.chain(of_pebbles).collect();
        self.smallest_radius = radii.iter().copied().fold(f64::INFINITY, f64::min);
        self.largest_radius = radii.iter().copied().fold(0.0, f64::max);
        self.mean_radius = radii.iter().sum::<f64>() / radii.len().max(1) as f64;
    }
}

/// What is written, and when.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputPlan {
    /// Time between frames, s.
    pub interval: f64,
    /// Time between contact frames, s.
    pub fstat_interval: f64,
    /// Time between files for ParaView, s.
    pub vtk_interval: f64,
    /// `.data`.
    pub data: bool,
    /// `.ene`.
    pub ene: bool,
    /// `.fstat` and `.contacts.arrow`.
    pub fstat: bool,
    /// `vtk/<prefix>.*.vtu` and their lists.
    pub vtk: bool,
    /// `.particles.arrow` and `.walls.arrow`.
    pub frames: bool,
    /// `.walls.csv`.
    pub walls: bool,
    /// `.triangle_loads.arrow`, and arrays of the walls in `vtk/`: loads on the triangles of meshes.
    pub triangle_loads: bool,
    /// Pictures at the end.
    pub pictures: bool,
    /// Rows of `.data`, which `.fstat` refers to, are pebbles instead of bodies.
    pub pebbles: bool,
    /// Particles and bodies to follow: name and id.
    pub track: Vec<(String, u32)>,
    /// Significant digits of `.data`, `.fstat` and `.ene`; `None` writes the shortest that read back exactly.
    pub digits: Option<u8>,
}

impl OutputPlan {
    /// How `.data`, `.fstat` and `.ene` print numbers.
    #[must_use]
    pub fn number_style(&self) -> NumberStyle {
        self.digits
            .map_or(NumberStyle::Shortest, NumberStyle::Digits)
    }
}

//! Plans by hand, for library users and tests.

use std::fmt;
use std::sync::Arc;

use glam::DVec3;

use super::sizes::Sizes;
use super::{Carried, Guard, Notes, OutputPlan, Outputs, Physics, Plan};
use crate::bodies::{Clump, NewBody};
use crate::boundaries::{CountedRegion, DeletionPlan, FluxPlan, InsertionPlan};
use crate::contact::SlidingNormal;
use crate::contact::adhesion::liquid::Tables;
use crate::contact::registry::{AnyPairLaw, LawTable};
use crate::liquid::LiquidPlan;
use crate::membrane::MembranePlan;
use crate::spray::SprayPlan;
use crate::state::{Material, NewParticle};
use crate::surface::SurfacePlan;
use crate::walls::{Shape, Wall};
use crate::wear::WearPlan;

/// Why a draft is no plan.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DraftError {
    /// A number that cannot be computed with.
    #[error("{what} must be {expected}, got {found}")]
    Number {
        /// Which.
        what: String,
        /// What it has to be.
        expected: &'static str,
        /// What it is.
        found: String,
    },
    /// Something names what is not there.
    #[error("{what} is of {kind} {index}; there are {count}")]
    Missing {
        /// What names it.
        what: String,
        /// What is missing.
        kind: &'static str,
        /// Its index.
        index: u32,
        /// How many there are.
        count: usize,
    },
}

/// A plan to be filled in: set the fields, then [`Draft::plan`] makes a consistent plan of it.
///
/// [`Draft::new`] has one material, an empty domain, no gravity and no output. Radii, and all else that follows from the particles and
/// insertions, is found when the plan is made.
#[derive(Debug, Clone)]
pub struct Draft {
    /// Title.
    pub title: String,
    /// Prefix of all output files.
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
    /// Also ends when the particles are at rest.
    pub until_at_rest: bool,
    /// Lower corner of the domain, m.
    pub domain_min: DVec3,
    /// Upper corner of the domain, m.
    pub domain_max: DVec3,
    /// Periodic axes.
    pub periodic: [bool; 3],
    /// Materials.
    pub materials: Vec<Material>,
    /// Laws of all pairs of materials.
    pub laws: LawTable,
    /// The normal for the velocities of sliding, rolling and torsion.
    pub sliding_normal: SlidingNormal,
    /// R* includes the curvature of walls.
    pub wall_curvature: bool,
    /// Springs advance in the force evaluation before the first step.
    pub startup_increment: bool,
    /// Contacts of clumps are damped by the mass at the contact point instead of that of the whole body.
    pub contact_point_mass: bool,
    /// What a run may not do in silence; off.
    pub guard: Guard,
    /// Films at the start and rules for liquid. Where laws have liquid and this is `None`, the default holds.
    pub liquid: Option<LiquidPlan>,
    /// Nozzles; films need `liquid`.
    pub sprays: Option<SprayPlan>,
    /// Walls.
    pub walls: Vec<Wall>,
    /// How walls wear: at most one entry for each, of meshes alone, in their order.
    pub wear: Vec<WearPlan>,
    /// Sheets.
    pub surfaces: Vec<SurfacePlan>,
    /// Their mechanics, one for each, or none at all.
    pub membranes: Vec<MembranePlan>,
    /// Particles of the start, in the order of their ids.
    pub particles: Vec<NewParticle>,
    /// Templates of rigid bodies.
    pub clumps: Vec<Clump>,
    /// Bodies of the start, in the order of their ids, which follow those of `particles`.
    pub bodies: Vec<NewBody>,
    /// Contacts of the start that continue from other runs.
    pub carried: Option<Arc<Carried>>,
    /// Insertions.
    pub insertions: Vec<InsertionPlan>,
    /// Deletions.
    pub deletions: Vec<DeletionPlan>,
    /// Regions whose content is counted.
    pub regions: Vec<CountedRegion>,
    /// Planes that count what crosses them.
    pub fluxes: Vec<FluxPlan>,
    /// Whether rotations are integrated.
    pub orientations: bool,
    /// Whether the energy is audited in every step.
    pub energy_budget: bool,
    /// What is written, and when.
    pub output: OutputPlan,
}

impl Draft {
    /// One material of the given density (kg/m^3) whose contacts with itself follow `law`, in an empty domain (lower and upper
    /// corner, m), with steps of `time_step` (s).
    #[must_use]
    pub fn new(time_step: f64, domain: (DVec3, DVec3), density: f64, law: AnyPairLaw) -> Self {
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
                tables: Tables::default(),
            },
            sliding_normal: SlidingNormal::default(),
            wall_curvature: false,
            startup_increment: false,
            contact_point_mass: false,
            guard: Guard::OFF,
            liquid: None,
            sprays: None,
            walls: Vec::new(),
            wear: Vec::new(),
            surfaces: Vec::new(),
            membranes: Vec::new(),
            particles: Vec::new(),
            clumps: Vec::new(),
            bodies: Vec::new(),
            carried: None,
            insertions: Vec::new(),
            deletions: Vec::new(),
            regions: Vec::new(),
            fluxes: Vec::new(),
            orientations: false,
            energy_budget: false,
            output: OutputPlan::default(),
        }
    }

    /// With these particles instead of the present ones.
    #[must_use]
    pub fn with_particles(mut self, particles: Vec<NewParticle>) -> Self {
        self.particles = particles;
        self
    }

    /// With these clumps and bodies instead of the present ones.
    #[must_use]
    pub fn with_bodies(mut self, clumps: Vec<Clump>, bodies: Vec<NewBody>) -> Self {
        (self.clumps, self.bodies) = (clumps, bodies);
        self
    }

    /// The plan.
    ///
    /// # Errors If a number is not valid, or a material or clump does not exist.
    pub fn plan(self) -> Result<Plan, DraftError> {
        self.check()?;
        let densities: Vec<f64> = self.materials.iter().map(|m| m.density).collect();
        let sizes = Sizes::of(
            &densities,
            (&self.particles, &self.bodies),
            &self.clumps,
            &self.insertions,
            self.dimensions,
        );
        let mut parts = self.insertions.iter().flat_map(|feed| &feed.mixture);
        let has_liquid = self.laws.has_liquid()
            || self.sprays.is_some()
            || parts.any(|part| part.film_volume > 0.0);
        let liquid = has_liquid.then(LiquidPlan::default);
        let liquid = self.liquid.or(liquid);
        Ok(Plan {
            physics: Physics {
                seed: self.seed,
                gravity: self.gravity,
                dimensions: self.dimensions,
                time_step: self.time_step,
                steps: self.steps,
                until_at_rest: self.until_at_rest,
                domain_min: self.domain_min,
                domain_max: self.domain_max,
                periodic: self.periodic,
                materials: self.materials,
                laws: self.laws,
                sliding_normal: self.sliding_normal,
                wall_curvature: self.wall_curvature,
                startup_increment: self.startup_increment,
                contact_point_mass: self.contact_point_mass,
                guard: self.guard,
                liquid,
                sprays: self.sprays,
                walls: self.walls,
                wear: self.wear,
                surfaces: self.surfaces,
                membranes: self.membranes,
                particles: self.particles,
                clumps: self.clumps,
                bodies: self.bodies,
                carried: self.carried,
                insertions: self.insertions,
                deletions: self.deletions,
                smallest_radius: sizes.smallest,
                mean_radius: sizes.mean,
                largest_radius: sizes.largest,
                orientations: self.orientations,
                energy_budget: self.energy_budget,
            },
            outputs: Outputs {
                title: self.title,
                prefix: self.prefix,
                files: self.output,
                regions: self.regions,
                fluxes: self.fluxes,
            },
            notes: Notes::default(),
        })
    }

    fn check(&self) -> Result<(), DraftError> {
        positive("the time step", self.time_step)?;
        if !(2..=3).contains(&self.dimensions) {
            return Err(number("dimensions", "2 or 3", self.dimensions));
        }
        let (min, max) = (self.domain_min, self.domain_max);
        if !(min.is_finite() && max.is_finite() && min.cmple(max).all()) {
            let found = format!("{min} to {max}");
            return Err(number(
                "the domain",
                "from a lower to an upper corner",
                found,
            ));
        }
        let count = self.materials.len();
        if self.laws.materials != count || self.laws.laws.len() != count * count {
            let found = self.laws.laws.len();
            return Err(number("the laws", "one for each pair of materials", found));
        }
        for material in &self.materials {
            positive(
                &format!("the density of {}", material.name),
                material.density,
            )?;
        }
        for (id, particle) in self.particles.iter().enumerate() {
            positive_of("the radius of particle", id, particle.radius)?;
            present(
                "particle",
                id,
                "material",
                particle.material.number(),
                count,
            )?;
        }
        for (index, wall) in self.walls.iter().enumerate() {
            present("wall", index, "material", wall.material.number(), count)?;
        }
        for (index, wear) in self.wear.iter().enumerate() {
            present("wear", index, "wall", wear.wall as u32, self.walls.len())?;
            let is_mesh = matches!(self.walls[wear.wall].shape, Shape::Mesh(_));
            let is_next = index == 0 || self.wear[index - 1].wall < wear.wall;
            if !(is_mesh && is_next) {
                let what = format!("the wall of wear {index}");
                return Err(number(&what, "a mesh, each once and in order", wear.wall));
            }
        }
        self.check_surfaces()?;
        for (index, clump) in self.clumps.iter().enumerate() {
            present("clump", index, "material", clump.material.number(), count)?;
        }
        for (index, body) in self.bodies.iter().enumerate() {
            positive_of("the scale of body", index, body.scale)?;
            present("body", index, "clump", body.clump, self.clumps.len())?;
        }
        if let Some(carried) = &self.carried {
            let pebbles = |body: &NewBody| self.clumps[body.clump as usize].pebbles.len();
            let rows = self.particles.len() + self.bodies.iter().map(pebbles).sum::<usize>();
            let pairs = (carried.pairs.iter()).map(|slot| slot.row.max(slot.partner));
            let walls = carried.near_walls.iter().map(|slot| slot.row);
            for row in pairs.chain(walls) {
                present("contact", 0, "particle", row, rows)?;
            }
            for wall in carried.near_walls.iter().map(|slot| slot.partner) {
                present("contact", 0, "wall", wall, self.walls.len())?;
            }
        }
        for (index, insertion) in self.insertions.iter().enumerate() {
            for part in &insertion.mixture {
                present(
                    "insertion",
                    index,
                    "material",
                    part.material.number(),
                    count,
                )?;
                if let Some(clump) = part.clump {
                    present("insertion", index, "clump", clump, self.clumps.len())?;
                }
            }
        }
        Ok(())
    }
}

impl Draft {
    fn check_surfaces(&self) -> Result<(), DraftError> {
        let count = self.materials.len();
        for (index, surface) in self.surfaces.iter().enumerate() {
            let name = &surface.name;
            let material = surface.material.number();
            present("surface", index, "material", material, count)?;
            positive(&format!("the thickness of {name}"), surface.thickness)?;
            for &vertex in surface.triangles.iter().flatten() {
                let vertices = surface.vertices.len();
                present(
                    &format!("{name}, surface"),
                    index,
                    "vertex",
                    vertex,
                    vertices,
                )?;
            }
            if surface.masses.len() != surface.vertices.len() {
                let (what, found) = (format!("the masses of {name}"), surface.masses.len());
                return Err(number(&what, "one for each vertex", found));
            }
            // Those that are held have an infinite one.
            if let Some(mass) = surface
                .masses
                .iter()
                .find(|&&mass| mass.is_nan() || mass <= 0.0)
            {
                let what = format!("a mass of {name}");
                return Err(number(&what, "a number above 0", mass));
            }
        }
        let mut touching = self.surfaces.iter().filter(|surface| surface.touches_walls);
        if self.laws.has_liquid()
            && let Some(surface) = touching.next()
        {
            let what = format!("walls of {}", surface.name);
            return Err(number(&what, "off in scenes with liquid", "on"));
        }
        if self.sprays.is_some() && !self.surfaces.is_empty() {
            return Err(number("sprays", "none in scenes with surfaces", "some"));
        }
        Ok(())
    }
}

impl Plan {
    /// The inputs of a plan, to be changed and planned again; its notes are left out.
    #[must_use]
    pub fn draft(&self) -> Draft {
        let (physics, outputs) = (self.physics.clone(), self.outputs.clone());
        Draft {
            title: outputs.title,
            prefix: outputs.prefix,
            seed: physics.seed,
            gravity: physics.gravity,
            dimensions: physics.dimensions,
            time_step: physics.time_step,
            steps: physics.steps,
            until_at_rest: physics.until_at_rest,
            domain_min: physics.domain_min,
            domain_max: physics.domain_max,
            periodic: physics.periodic,
            materials: physics.materials,
            laws: physics.laws,
            sliding_normal: physics.sliding_normal,
            wall_curvature: physics.wall_curvature,
            startup_increment: physics.startup_increment,
            contact_point_mass: physics.contact_point_mass,
            guard: physics.guard,
            liquid: physics.liquid,
            sprays: physics.sprays,
            walls: physics.walls,
            wear: physics.wear,
            surfaces: physics.surfaces,
            membranes: physics.membranes,
            particles: physics.particles,
            clumps: physics.clumps,
            bodies: physics.bodies,
            carried: physics.carried,
            insertions: physics.insertions,
            deletions: physics.deletions,
            regions: outputs.regions,
            fluxes: outputs.fluxes,
            orientations: physics.orientations,
            energy_budget: physics.energy_budget,
            output: outputs.files,
        }
    }
}

fn number(what: &str, expected: &'static str, found: impl fmt::Display) -> DraftError {
    DraftError::Number {
        what: what.to_owned(),
        expected,
        found: found.to_string(),
    }
}

fn positive(what: &str, value: f64) -> Result<(), DraftError> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(number(what, "a number above 0", value))
    }
}

/// The same for one of many entries, whose name is made only for an error.
fn positive_of(what: &str, index: usize, value: f64) -> Result<(), DraftError> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        positive(&format!("{what} {index}"), value)
    }
}

fn present(
    what: &str,
    number: usize,
    kind: &'static str,
    index: u32,
    count: usize,
) -> Result<(), DraftError> {
    if (index as usize) < count {
        return Ok(());
    }
    Err(DraftError::Missing {
        what: format!("{what} {number}"),
        kind,
        index,
        count,
    })
}

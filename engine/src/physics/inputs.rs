//! Inputs of a simulation, to be filled in.

use std::fmt;
use std::sync::Arc;

use glam::DVec3;
use mercury_common::particle_properties::{FILM_VOLUME, PARTICLE_PROPERTIES, ParticleProperty};

use super::sizes::Sizes;
use super::{Carried, FeaturePlan, Physics, Plans, Setup};
use crate::bodies::{Clump, NewBody};
use crate::boundaries::{DeletionPlan, InsertionPlan};
use crate::cell::Cell;
use crate::contact::SlidingNormal;
use crate::contact::adhesion::liquid::Tables;
use crate::contact::registry::{AnyPairLaw, LawTable};
use crate::guard::Guard;
use crate::state::{Material, NewParticle, StartValues};
use crate::walls::Wall;

/// Why inputs are no physics.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum InputError {
    /// A number that cannot be computed with.
    #[error("{what} must be {expected}, got {found}")]
    Number {
        /// Name of the number.
        what: String,
        /// Range of permitted values.
        expected: &'static str,
        /// Value that was given.
        found: String,
    },
    /// Something names what is not there.
    #[error("{what} is of {kind} {index}; there are {count}")]
    Missing {
        /// Name of the object with the index.
        what: String,
        /// Kind of the missing object.
        kind: &'static str,
        /// Its index.
        index: u32,
        /// Number of such objects.
        count: usize,
    },
}

/// Inputs of a simulation, to be filled in: set the fields, then [`Inputs::physics`] makes consistent [`Physics`] of them.
///
/// [`Inputs::new`] has one material, an empty domain and no gravity. Radii, and all else that follows from the particles and insertions, are
/// found when the physics are made.
#[derive(Debug, Clone)]
pub struct Inputs {
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
    /// Whether the run also ends when the particles are at rest.
    pub until_at_rest: bool,
    /// The periodic box at the start.
    pub cell: Cell,
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
    /// Limits beyond which a run may not go in silence; off.
    pub guard: Guard,
    /// Walls.
    pub walls: Vec<Wall>,
    /// Plans of features, each of which has its folder: liquid, sprays, wear, sheets, bonds.
    pub plans: Plans,
    /// Particles of the start, in the order of their ids.
    pub particles: Vec<NewParticle>,
    /// Templates of rigid bodies.
    pub clumps: Vec<Clump>,
    /// Bodies of the start, in the order of their ids, which follow those of `particles`.
    pub bodies: Vec<NewBody>,
    /// Contacts of the start that continue from other runs.
    pub carried: Option<Arc<Carried>>,
    /// Properties that all particles have; [`Inputs::physics`] adds those that values are given of.
    pub properties: Vec<&'static ParticleProperty>,
    /// Values of properties at the start, one entry for each property.
    pub start_values: Vec<StartValues>,
    /// Insertions.
    pub insertions: Vec<InsertionPlan>,
    /// Deletions.
    pub deletions: Vec<DeletionPlan>,
    /// Whether rotations are integrated.
    pub orientations: bool,
    /// Whether the energy is audited in every step.
    pub energy_budget: bool,
}

impl Inputs {
    /// One material of the given density (kg/m^3) whose contacts with itself follow `law`, in an empty domain (lower and upper
    /// corner, m), with steps of `time_step` (s).
    #[must_use]
    pub fn new(time_step: f64, domain: (DVec3, DVec3), density: f64, law: AnyPairLaw) -> Self {
        Self {
            seed: 0,
            gravity: DVec3::ZERO,
            dimensions: 3,
            time_step,
            steps: 0,
            until_at_rest: false,
            cell: Cell::new(domain.0, domain.1, [false; 3]),
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
            walls: Vec::new(),
            plans: Plans::default(),
            particles: Vec::new(),
            clumps: Vec::new(),
            bodies: Vec::new(),
            carried: None,
            properties: Vec::new(),
            start_values: Vec::new(),
            insertions: Vec::new(),
            deletions: Vec::new(),
            orientations: false,
            energy_budget: false,
        }
    }

    /// The physics.
    ///
    /// # Errors
    /// If a number is not valid, or a material, wall or clump does not exist.
    pub fn physics(mut self) -> Result<Physics, InputError> {
        self.check()?;
        let densities: Vec<f64> = self.materials.iter().map(|m| m.density).collect();
        let sizes = Sizes::of(
            &densities,
            (&self.particles, &self.bodies),
            &self.clumps,
            &self.insertions,
            self.dimensions,
        );
        if self.laws.has_liquid() {
            self.properties.push(&FILM_VOLUME);
        }
        self.properties.extend(self.plans.properties());
        self.properties = self.all_properties();
        Ok(Physics {
            inputs: self,
            sizes,
        })
    }

    /// Properties with values, some more than once.
    fn given(&self) -> impl Iterator<Item = &'static ParticleProperty> + '_ {
        let start = self.start_values.iter().map(|values| values.property);
        let mixtures = self.insertions.iter().flat_map(|feed| &feed.mixture);
        start.chain(mixtures.flat_map(|part| part.properties.iter().map(|(given, _)| *given)))
    }

    /// All properties of the particles: those of the table in its order, then others.
    fn all_properties(&self) -> Vec<&'static ParticleProperty> {
        let mut all = Vec::new();
        for property in self.properties.iter().copied().chain(self.given()) {
            if !all.contains(&property) {
                all.push(property);
            }
        }
        let place = |property: &&ParticleProperty| {
            let mut known = PARTICLE_PROPERTIES.iter();
            known
                .position(|known| known == *property)
                .unwrap_or(usize::MAX)
        };
        all.sort_by_key(place);
        all
    }

    /// Setup of an engine that watches nothing.
    ///
    /// # Errors
    /// As [`Inputs::physics`].
    pub fn setup(self) -> Result<Setup, InputError> {
        Ok(Setup::unwatched(Arc::new(self.physics()?)))
    }

    /// With these clumps and bodies instead of the present ones.
    #[must_use]
    pub fn with_bodies(mut self, clumps: Vec<Clump>, bodies: Vec<NewBody>) -> Self {
        (self.clumps, self.bodies) = (clumps, bodies);
        self
    }

    /// With another plan of a feature.
    #[must_use]
    pub fn with_plan(mut self, plan: impl FeaturePlan) -> Self {
        self.plans.insert(plan);
        self
    }

    /// With these particles instead of the present ones.
    #[must_use]
    pub fn with_particles(mut self, particles: Vec<NewParticle>) -> Self {
        self.particles = particles;
        self
    }

    fn check(&self) -> Result<(), InputError> {
        positive("the time step", self.time_step)?;
        if !(2..=3).contains(&self.dimensions) {
            return Err(number("dimensions", "2 or 3", self.dimensions));
        }
        let (min, max) = self.cell.corners();
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
        self.plans.check(self)?;
        for (index, clump) in self.clumps.iter().enumerate() {
            present("clump", index, "material", clump.material.number(), count)?;
        }
        for (index, body) in self.bodies.iter().enumerate() {
            positive_of("the scale of body", index, body.scale)?;
            present("body", index, "clump", body.clump, self.clumps.len())?;
        }
        for values in &self.start_values {
            let what = format!("{} of particle", values.property.name);
            for &(particle, value) in &values.particles {
                present(
                    &what,
                    particle,
                    "particle",
                    particle as u32,
                    self.particles.len(),
                )?;
                finite(&what, particle, value)?;
            }
            let what = format!("{} of body", values.property.name);
            for &(body, value) in &values.bodies {
                present(&what, body, "body", body as u32, self.bodies.len())?;
                finite(&what, body, value)?;
            }
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

pub(crate) fn number(what: &str, expected: &'static str, found: impl fmt::Display) -> InputError {
    InputError::Number {
        what: what.to_owned(),
        expected,
        found: found.to_string(),
    }
}

pub(crate) fn positive(what: &str, value: f64) -> Result<(), InputError> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(number(what, "a number above 0", value))
    }
}

/// Check of one of many entries, whose name is made only for an error.
fn positive_of(what: &str, index: usize, value: f64) -> Result<(), InputError> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        positive(&format!("{what} {index}"), value)
    }
}

fn finite(what: &str, index: usize, value: f64) -> Result<(), InputError> {
    if value.is_finite() {
        return Ok(());
    }
    Err(number(&format!("{what} {index}"), "a finite number", value))
}

pub(crate) fn present(
    what: &str,
    number: usize,
    kind: &'static str,
    index: u32,
    count: usize,
) -> Result<(), InputError> {
    if (index as usize) < count {
        return Ok(());
    }
    Err(InputError::Missing {
        what: format!("{what} {number}"),
        kind,
        index,
        count,
    })
}

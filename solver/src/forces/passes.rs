//! The forces of a run as a list: the contact loop first, other forces after it. the contact loop first, others beside it. Each
//! states its needs, and only these decide how the step is made: whether the kick is fused with the contact loop, how far pairs
//! are listed, whether shapes of walls are refitted, which columns exist.

use glam::DVec3;

use super::{ContactForces, Finish, MotionBound, NearWall, Observation, StepContext};
use crate::neighbours::CandidateList;
use crate::state::{Particles, Row};

/// What a force pass needs of the step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Needs {
    /// Largest gap between the surfaces of two particles, or of a particle and a wall, across which it acts, m. Pairs are listed
    /// that much farther out.
    pub range: f64,
    /// It reads the orientations of both particles, so they are integrated.
    pub orientations: bool,
    /// It adds loads once those of the contacts are known, so the kick has to wait for it.
    pub after_contacts: bool,
    /// It may change the surfaces of walls, so it runs before the lists are checked, and what it changes is refitted.
    pub reshapes_walls: bool,
}

impl Needs {
    /// What two passes need together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            range: self.range.max(other.range),
            orientations: self.orientations || other.orientations,
            after_contacts: self.after_contacts || other.after_contacts,
            reshapes_walls: self.reshapes_walls || other.reshapes_walls,
        }
    }
}

/// A new candidate list, as a pass receives it.
pub struct NewList<'a> {
    /// Particles in their new order.
    pub particles: &'a Particles,
    /// All pairs closer than their radii, the skin and the range of the pass that reaches farthest.
    pub pairs: &'a CandidateList,
    /// All particles that are near a wall by the same measure.
    pub near_walls: &'a [NearWall],
    /// Where each row of the last list went, `None` for rows that were removed.
    pub new_row: &'a [Option<Row>],
    /// The list was made with the threads of the pool from which this is called.
    pub parallel: bool,
}

/// A force beside the contacts: gravity between grains, drag, bonds, bridges.
///
/// Passes run in the order of the list and get the same numbers whatever the number of threads; their results must not depend on
/// it either.
pub trait ForcePass: Send {
    /// A name for it, unique in the run.
    fn name(&self) -> &str;

    /// What it needs; the same during a whole run.
    fn needs(&self) -> Needs;

    /// Takes a new candidate list.
    fn adopt(&mut self, list: &NewList<'_>);

    /// The meshes that it changes in the step that ends at `time` (s), if it [`needs`](Self::needs) to: the number of the wall in
    /// the plan, and the new positions of its corners in the wall's own frame, m.
    fn reshape_walls(&mut self, particles: &Particles, time: f64) -> Vec<(usize, Vec<DVec3>)> {
        let _ = (particles, time);
        Vec::new()
    }

    /// Adds its loads to those of the contacts, if it [`needs`](Self::needs) to come after them.
    fn add_loads(&mut self, particles: &mut Particles, context: &StepContext<'_>);

    /// Adds its part to the last observation: energy stored and dissipated, its loads on walls.
    fn observe(&self, observation: &mut Observation);

    /// Its whole state, by ids that survive sorting, so that [`ForcePass::restore`] can continue with the same numbers.
    fn save(&self) -> Vec<u8>;

    /// Restores what [`ForcePass::save`] returned; called after the contact loop has its lists back.
    ///
    /// # Errors If these bytes are not of this pass, with the reason.
    fn restore(&mut self, particles: &Particles, saved: &[u8]) -> Result<(), String>;
}

/// All forces of a run.
pub struct Forces {
    /// The contact loop, with which the kick may be fused.
    pub contacts: Box<dyn ContactForces>,
    others: Vec<Box<dyn ForcePass>>,
    needs: Needs,
}

impl Forces {
    /// The contact loop and the passes beside it.
    #[must_use]
    pub fn new(contacts: Box<dyn ContactForces>, others: Vec<Box<dyn ForcePass>>) -> Self {
        let needs = others.iter().map(|pass| pass.needs());
        let needs = needs.fold(contacts.needs(), Needs::and);
        Self {
            contacts,
            others,
            needs,
        }
    }

    /// The needs of all of them together.
    #[must_use]
    pub fn needs(&self) -> Needs {
        self.needs
    }

    /// The passes beside the contact loop.
    #[must_use]
    pub fn others(&self) -> &[Box<dyn ForcePass>] {
        &self.others
    }

    /// What the passes beside the contact loop remember, by their names.
    #[must_use]
    pub fn saved_others(&self) -> Vec<(String, Vec<u8>)> {
        (self.others.iter())
            .map(|pass| (pass.name().to_owned(), pass.save()))
            .collect()
    }

    /// Restores the passes beside the contact loop from their saved bytes, by their names.
    ///
    /// # Errors If these are not the same passes, or one of them cannot read its bytes.
    pub fn restore_others(
        &mut self,
        particles: &Particles,
        saved: &[(String, Vec<u8>)],
    ) -> Result<(), String> {
        let names = |names: Vec<&str>| match names.as_slice() {
            [] => "none".to_owned(),
            some => some.join(", "),
        };
        let mine: Vec<&str> = self.others.iter().map(|pass| pass.name()).collect();
        let theirs: Vec<&str> = saved.iter().map(|(name, _)| name.as_str()).collect();
        if mine != theirs {
            return Err(format!(
                "it has these beside the contacts: {}; the run: {}",
                names(theirs),
                names(mine)
            ));
        }
        for (pass, (name, bytes)) in self.others.iter_mut().zip(saved) {
            pass.restore(particles, bytes)
                .map_err(|reason| format!("{name}: {reason}"))?;
        }
        Ok(())
    }

    /// Passes a new candidate list to all.
    pub fn adopt(&mut self, list: &NewList<'_>) {
        self.contacts
            .adopt(list.pairs, list.near_walls, list.new_row, list.parallel);
        for pass in &mut self.others {
            pass.adopt(list);
        }
    }

    /// Computes all loads. `finish` as for [`ContactForces::compute`]; only where no pass comes after the contacts.
    pub fn compute(
        &mut self,
        particles: &mut Particles,
        context: &StepContext<'_>,
        pool: Option<&rayon::ThreadPool>,
        finish: &Finish<'_>,
    ) -> MotionBound {
        let bound = self.contacts.compute(particles, context, pool, finish);
        for pass in &mut self.others {
            if pass.needs().after_contacts {
                pass.add_loads(particles, context);
            }
        }
        bound
    }

    /// The meshes that change in the step that ends at `time` (s), as [`ForcePass::reshape_walls`] says; none where no pass needs it.
    pub fn reshaped_walls(&mut self, particles: &Particles, time: f64) -> Vec<(usize, Vec<DVec3>)> {
        let reshaping = self
            .others
            .iter_mut()
            .filter(|pass| pass.needs().reshapes_walls);
        reshaping
            .flat_map(|pass| pass.reshape_walls(particles, time))
            .collect()
    }

    /// The last observation.
    #[must_use]
    pub fn observation(&self, walls: usize) -> Observation {
        let mut observation = self.contacts.observation(walls);
        for pass in &self.others {
            pass.observe(&mut observation);
        }
        observation
    }

    /// The same without the records of contacts.
    #[must_use]
    pub fn sums(&self, walls: usize) -> Observation {
        let mut sums = self.contacts.sums(walls);
        for pass in &self.others {
            pass.observe(&mut sums);
        }
        sums
    }

    /// The same, with the records of contacts moved out of the contact loop.
    pub fn take_observation(&mut self, walls: usize) -> Observation {
        let mut observation = self.contacts.take_observation(walls);
        for pass in &self.others {
            pass.observe(&mut observation);
        }
        observation
    }
}

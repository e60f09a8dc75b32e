//! Boundaries: they count, insert and remove particles.
//!
//! In every step, after the drift and before the candidate lists, [`Boundaries::exchange`] counts the crossings of flux planes,
//! removes the particles and bodies whose centre is in a deletion region or beyond a face of the domain, and inserts what is due.
//! The time of an event is the end of the drift. Both are exact in every step, yet a step checks only particles that the last
//! list build found near an exit ([`Boundaries::listed`]): no particle is missed as long as none moves, in a single step, more
//! than half a skin and more than twice as far as any particle did when the list was built.
//!
//! Insertion follows random sequential addition: a particle is drawn, tried at uniform places until it overlaps nothing, and
//! waits if `attempts` consecutive places fail: for the next step at first, for up to 64 steps while no place is found (`wait`). It is
//! never exchanged for one that fits, which keeps sizes unbiased. By quota, sizes are fixed in advance (`quota`).

mod behind;
mod blocked;
mod context;
mod counts;
mod deletion;
mod domain_volume;
mod expected;
mod flux;
mod insertion;
mod occupied;
mod passage;
mod placed_sizes;
mod placement;
mod plans;
mod quota;
mod region;
mod row_map;
mod schedule;
mod solid;
mod tally;
#[cfg(test)]
mod tests;
mod wait;

pub use blocked::{Blocked, PLACES as PLACES_AMONG_WALLS, blocked, places};
pub use context::BoundaryContext;
pub use counts::Event;
pub use domain_volume::volume_within;
pub use expected::{expected_number, mean_volume};
pub use flux::Crossed;
pub use insertion::{InsertionState, Limit, Pending};
pub use passage::{Gate, OwnGrains, Passage};
pub use placed_sizes::PlacedSizes;
pub use placement::{Space, may_hold, overlaps_wall};
pub use plans::{CountedRegion, DeletionPlan, FluxPart, FluxPlan, Ingredient, InsertionPlan, Rate};
pub use quota::MOST as MOST_OF_QUOTA;
pub use region::Region;
pub use solid::{Solid, SolidError};
pub use tally::Tally;
pub use wait::Wait;

pub use mercury_common::scene::{Quantity, Total};

use std::sync::Arc;

use counts::Counts;
use deletion::Deletion;
use flux::Fluxes;
use insertion::{Insertion, InsertionContext};
use occupied::Occupied;
use row_map::RowMap;

use crate::cell::Cell;
use crate::neighbours::Cells;
use crate::state::{Id, Particle, Particles, Row};
use crate::task::TaskProgress;
use crate::walls::WallNow;

/// The complete state of the boundaries: a run continues from it with the same numbers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BoundaryState {
    /// Insertions, in the order of the plan.
    pub insertions: Vec<InsertionState>,
    /// The particles removed by each deletion region, in the order of the plan.
    pub deletions: Vec<Tally>,
    /// The particles that left through the faces of the domain, in the order -x, +x, -y, +y, -z, +z.
    pub faces: [Tally; 6],
    /// The largest distance of a particle from its listed position, m.
    pub margin: f64,
    /// Amounts that crossed the flux planes since the last reading: plane by plane, each material by material.
    pub crossed: Vec<Crossed>,
}

crate::state::plain!(BoundaryState {
    insertions,
    deletions,
    faces,
    margin,
    crossed
});

/// The function that is called before rows are removed, with each of them, and whether it leaves through a face of the domain.
pub type Leaving<'a> = dyn FnMut(&mut Particles, &[(u32, bool)]) + 'a;

/// The function that is called after an insertion has placed grains: with its index, the first of their rows, and how many it had
/// placed before.
pub type Brought<'a> = dyn FnMut(usize, usize, u64, &mut Particles) + 'a;

/// Insertions, deletions and flux planes of a run, and what they counted.
#[derive(Debug, Clone)]
pub struct Boundaries {
    fluxes: Fluxes,
    insertions: Vec<Insertion>,
    occupied: Occupied,
    deletion: Deletion,
    counts: Counts,
    /// Particles, and pebbles of bodies, that left through a face in the present step, as they were then.
    left_by_face: Vec<(Id, Particle)>,
    rows: RowMap,
    /// The largest distance of a particle from its listed position, m.
    margin: f64,
    time_step: f64,
    /// The progress to which long insertions report; it decides whether they go on.
    task_progress: Arc<TaskProgress>,
}

impl Boundaries {
    /// The state before the first step.
    #[must_use]
    pub fn new(
        insertions: &[InsertionPlan],
        deletions: &[DeletionPlan],
        fluxes: &[FluxPlan],
        setting: &BoundaryContext<'_>,
    ) -> Self {
        let materials = setting.materials.len();
        Self {
            fluxes: Fluxes::new(fluxes, setting.dimensions, setting.cell),
            insertions: insertions
                .iter()
                .map(|insertion| Insertion::new(insertion, setting))
                .collect(),
            occupied: Occupied::default(),
            deletion: Deletion::new(deletions, setting),
            counts: Counts::new(deletions.len(), fluxes.len(), materials),
            left_by_face: Vec::new(),
            rows: RowMap::default(),
            margin: 0.0,
            time_step: setting.time_step,
            task_progress: Arc::default(),
        }
    }

    /// Sets the progress to which insertions report; an insertion that it [gives up](TaskProgress::is_given_up) ends at once.
    pub fn report_to(&mut self, task_progress: Arc<TaskProgress>) {
        self.task_progress = task_progress;
    }

    /// Finds which of some grains have crossed a plane or left at this time (s).
    pub fn find(
        &mut self,
        particles: &Particles,
        setting: &BoundaryContext<'_>,
        time: f64,
        own: &OwnGrains,
    ) -> Vec<Event> {
        let (cell, mut events) = (setting.cell, Vec::new());
        self.fluxes.find(particles, cell, time, own, &mut events);
        let gone = self.deletion.find(particles, cell, own).into_iter();
        events.extend(gone.map(|gone| Event::of(time, gone, particles, setting.dimensions)));
        events
    }

    /// Whether any grain may cross a plane or leave before the next list.
    #[must_use]
    pub fn are_watching(&self, particles: &Particles) -> bool {
        self.fluxes.are_watching() || self.deletion.is_watching(particles)
    }

    /// Whether an insertion looks for places at this time (s).
    #[must_use]
    pub fn are_inserting(&self, insertions: &[InsertionPlan], time: f64) -> bool {
        let mut pairs = self.insertions.iter().zip(insertions);
        pairs.any(|(insertion, of_plan)| insertion.is_due(of_plan, time, self.time_step))
    }

    /// Counts what was found at this time (s), removes what has left and inserts particles; returns whether rows changed. Inserted ones are
    /// appended. `insertions` are those of [`Boundaries::new`], `setting` is the present one. `leaving` is called before anything is removed.
    pub fn exchange(
        &mut self,
        events: &[Event],
        particles: &mut Particles,
        insertions: &[InsertionPlan],
        setting: &BoundaryContext<'_>,
        walls: &[WallNow],
        time: f64,
        leaving: &mut Leaving<'_>,
        brought: &mut Brought<'_>,
    ) -> bool {
        self.counts.count(events, setting.cell);
        let crossed = events.partition_point(|event| !event.is_exit());
        let mut changed = self.delete(particles, &events[crossed..], leaving);
        let around = InsertionContext {
            setting,
            walls,
            margin: self.margin,
            time,
            task_progress: &self.task_progress,
        };
        for (index, (insertion, of_plan)) in self.insertions.iter_mut().zip(insertions).enumerate()
        {
            let (first, before) = (particles.len(), insertion.number_inserted());
            let has_brought = insertion.insert(of_plan, particles, &mut self.occupied, &around);
            if has_brought {
                brought(index, first, before, particles);
            }
            changed |= has_brought;
        }
        if changed {
            self.deletion.forget_near();
        }
        changed
    }

    /// Removes what has left; returns whether that was anything.
    fn delete(
        &mut self,
        particles: &mut Particles,
        gone: &[Event],
        leaving: &mut Leaving<'_>,
    ) -> bool {
        self.left_by_face.clear();
        if gone.is_empty() {
            return false;
        }
        let rows_of = |event: &Event| {
            let by_face = matches!(event.gate, Gate::Face(_));
            let rows = event.grain.rows(particles).into_iter();
            rows.map(move |row| (row, by_face))
        };
        let leavers: Vec<(u32, bool)> = gone.iter().flat_map(rows_of).collect();
        let by_face = leavers.iter().filter(|(_, by_face)| *by_face);
        self.left_by_face.extend(by_face.map(|&(row, _)| {
            let row = row as usize;
            (particles.ids[row], particles.records[row])
        }));
        leaving(particles, &leavers);
        let rows = particles.len();
        let stay = deletion::remove(particles, &leavers);
        self.rows.keep(&stay, rows);
        // The candidate list is built anew in this step, with cells of its own.
        self.occupied.forget();
        true
    }

    /// Particles, and pebbles of bodies, that left through a face of the domain in the present step, as they were then.
    #[must_use]
    pub fn left_by_face(&self) -> &[(Id, Particle)] {
        &self.left_by_face
    }

    /// From now on, passages are listed grain by grain, and must be [taken](Self::take_passages) from time to time.
    pub fn list_passages(&mut self) {
        self.counts.passages.are_listed = true;
    }

    /// The grains that crossed a plane or left since the last call, in the order of time, boundary and id.
    pub fn take_passages(&mut self) -> Vec<Passage> {
        self.counts.passages.take()
    }

    /// Passages in the order in which they came, for a checkpoint.
    #[must_use]
    pub fn passages(&self) -> &[Passage] {
        self.counts.passages.all()
    }

    /// Goes on from those of a checkpoint.
    pub fn restore_passages(&mut self, passages: Vec<Passage>) {
        self.counts.passages.restore(passages);
    }

    /// A list of `rows` rows was built, with all rows in place.
    pub fn go_on_from_list(&mut self, rows: usize) {
        self.rows = RowMap::of_list(rows);
    }

    /// Whether the particle of this row of the last list was removed since.
    #[must_use]
    pub fn is_removed(&self, row: u32) -> bool {
        self.rows.is_removed(row as usize)
    }

    /// For each row of the last list its present row, `None` if it was removed. The list must be built anew at once, from
    /// all `rows` present ones.
    pub fn take_row_map(&mut self, rows: usize) -> Vec<Option<Row>> {
        self.rows.take(rows)
    }

    /// The list was built with this skin (m), the particles sorted: finds those that may reach an exit before the next build.
    pub fn listed(&mut self, particles: &Particles, cell: &Cell, skin: f64) {
        self.occupied.forget();
        // Particles move up to half a skin while the list is valid, and then make the step that ends its validity: at most twice
        // as fast as now, as a particle that accelerates more is slow now.
        let fastest = particles
            .records
            .iter()
            .fold(0.0f64, |most, record| {
                most.max(record.velocity.length_squared())
            })
            .sqrt();
        self.margin = skin.max(0.5 * skin + 2.0 * fastest * self.time_step);
        self.deletion.listed(particles, cell, self.margin);
        self.fluxes.listed(particles, cell, self.margin);
    }

    /// The particles in the cells of the list that was just built, where insertions find them until the next one.
    pub fn take_cells(&mut self, rows: usize, cells: Cells) {
        self.occupied.listed(rows, cells);
    }

    /// Whether each insertion that waits for space has a place for its next particle now, in the order of the plan. A region is full where it has
    /// none; the last round of tries may be some steps ago.
    #[must_use]
    pub fn have_places(
        &self,
        particles: &Particles,
        insertions: &[InsertionPlan],
        setting: &BoundaryContext<'_>,
        walls: &[WallNow],
        time: f64,
    ) -> Vec<bool> {
        let around = InsertionContext {
            setting,
            walls,
            margin: self.margin,
            time,
            task_progress: &self.task_progress,
        };
        let pairs = self.insertions.iter().zip(insertions);
        pairs
            .map(|(insertion, of_plan)| insertion.has_place(of_plan, particles, &around))
            .collect()
    }

    /// The complete state, for a later continuation.
    #[must_use]
    pub fn state(&self) -> BoundaryState {
        BoundaryState {
            insertions: self.insertions.iter().map(Insertion::state).collect(),
            deletions: self.counts.regions.clone(),
            faces: self.counts.faces,
            margin: self.margin,
            crossed: self.counts.crossed.clone(),
        }
    }

    /// Continues from a state of the same plan that was taken after a step, when there were these particles, all listed.
    ///
    /// # Errors
    /// If the plan has another number of insertions, deletions or flux planes.
    pub fn restore(
        &mut self,
        state: &BoundaryState,
        particles: &Particles,
        cell: &Cell,
    ) -> Result<(), String> {
        let (found, planned) = (state, self.state());
        let counts = [
            (
                "insertions",
                found.insertions.len(),
                planned.insertions.len(),
            ),
            ("deletions", found.deletions.len(), planned.deletions.len()),
            (
                "flux planes times materials",
                found.crossed.len(),
                planned.crossed.len(),
            ),
        ];
        if let Some((what, found, planned)) = counts.iter().find(|(_, a, b)| a != b) {
            return Err(format!("it has {found} {what}, the plan {planned}"));
        }
        for (insertion, state) in self.insertions.iter_mut().zip(&state.insertions) {
            insertion.restore(state.clone());
        }
        self.counts.regions.clone_from(&state.deletions);
        self.counts.faces = state.faces;
        self.counts.crossed.clone_from(&state.crossed);
        self.occupied.forget();
        self.rows = RowMap::of_list(particles.len());
        self.margin = state.margin;
        self.deletion.forget_near();
        self.fluxes.restore(particles, cell);
        Ok(())
    }

    /// The state of each insertion, in the order of the plan.
    pub fn insertions(&self) -> impl ExactSizeIterator<Item = &InsertionState> {
        self.insertions.iter().map(|insertion| &insertion.state)
    }

    /// The particles removed by each deletion region, in the order of the plan.
    #[must_use]
    pub fn deletions(&self) -> &[Tally] {
        &self.counts.regions
    }

    /// Amounts that crossed the flux planes since the last call: plane by plane, in the order of the plan, each material by
    /// material.
    pub fn take_crossed(&mut self) -> Vec<Crossed> {
        self.counts.take_crossed()
    }

    /// The particles that left through the faces of the domain, in the order -x, +x, -y, +y, -z, +z.
    #[must_use]
    pub fn faces(&self) -> &[Tally; 6] {
        &self.counts.faces
    }

    /// The sum over all inserted particles.
    #[must_use]
    pub fn inserted(&self) -> Tally {
        sum(self.insertions.iter().map(|each| &each.state.inserted))
    }

    /// The sum over all removed particles.
    #[must_use]
    pub fn removed(&self) -> Tally {
        sum(self.counts.regions.iter().chain(&self.counts.faces))
    }

    /// Whether particles may still be inserted: the run does not end when the present ones are at rest.
    #[must_use]
    pub fn expects_more(&self) -> bool {
        self.insertions
            .iter()
            .any(|insertion| !insertion.state.is_finished())
    }
}

fn sum<'a>(tallies: impl Iterator<Item = &'a Tally>) -> Tally {
    tallies.fold(Tally::default(), |mut sum, tally| {
        sum.add(tally);
        sum
    })
}

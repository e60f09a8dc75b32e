//! One pass over the contacts of all blocks, and what it works on.

use std::ops::Range;

use super::across::{parked_for_ranks, take_parked};
use super::block::Block;
use super::contact_batch::BatchColumns;
use super::memory::Memory;
use super::pairs::Pairs;
use super::prefetch::BEYOND_CACHE;
use super::sheets::Joined;
use crate::contact::{AdhesionLaw, Histories, NormalLaw, PairLaw, RollingLaw, TangentialLaw};
use crate::forces::blocks::Source;
use crate::forces::{Finish, MotionBound, Observation, Partner, StepContext};
use crate::lanes::Task;
use crate::ranks::Across;
use crate::state::{Bodies, Id, Load, Particle};
use crate::surface::SurfacePoint;

/// Thickness (m) and volume (m^3) of the film on each row, where films are measured.
type Films<'a> = Option<&'a [[f64; 2]]>;

/// The data that all blocks of one force evaluation share.
pub(super) struct Pass<'a, N, T, R, A> {
    pub(super) laws: &'a [PairLaw<N, T, R, A>],
    pub(super) materials: usize,
    pub(super) memory: &'a Memory,
    /// Whether the memory of contacts is prefetched.
    pub(super) asks_ahead: bool,
    pub(super) ids: &'a [Id],
    /// The bodies, in scenes that damp contacts of clumps by the mass at the contact point.
    pub(super) bodies: Option<&'a Bodies>,
    /// The liquid film on each row, where bridges form as films meet: thickness, m, and volume, m^3.
    pub(super) films: Films<'a>,
    /// The sheet whose vertices the rows are, if they are no particles.
    pub(super) sheet: Option<u16>,
    pub(super) context: &'a StepContext<'a>,
}

impl<'a, N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> Pass<'a, N, T, R, A> {
    /// With the laws of a loop, for particles with these identifiers, bodies and films.
    pub(super) fn new(
        (laws, materials): (&'a [PairLaw<N, T, R, A>], usize),
        memory: &'a Memory,
        (ids, bodies, films): (&'a [Id], Option<&'a Bodies>, Films<'a>),
        context: &'a StepContext<'a>,
    ) -> Self {
        Self {
            laws,
            materials,
            memory,
            asks_ahead: ids.len() > BEYOND_CACHE,
            ids,
            bodies: bodies.filter(|_| context.contact_point_mass),
            films,
            sheet: None,
            context,
        }
    }
}

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> Pass<'_, N, T, R, A> {
    /// The blocks of this rank, one after the other, on this thread.
    pub(super) fn in_turn(
        &self,
        blocks: &mut [Block<Histories<N, T, R, A>>],
        own: Range<usize>,
        sources: &[Vec<Source>],
        records: &mut [Particle],
        loads: &mut [Load],
        finish: &Finish<'_>,
        across: Option<Across<'_>>,
        numbers: &mut BatchColumns,
    ) -> MotionBound {
        let mut fastest = MotionBound::default();
        let mut waiting = Vec::new();
        for index in own.clone() {
            let sources = &sources[index];
            let (earlier, rest) = blocks.split_at_mut(index);
            let block = &mut rest[0];
            let loads = &mut loads[block.rows.clone()];
            // Later blocks read neither the records nor the loads of earlier ones, so a block can be finished at once.
            let rows = Rows::together(&records[block.rows.start..]);
            self.compute(block, &rows, loads, numbers);
            if waits(sources, &own) {
                waiting.push(index);
                continue;
            }
            for source in sources {
                earlier[source.block].outbox.deliver(source.target, loads);
            }
            fastest = fastest.merge(finish(index, &mut records[block.rows.clone()], loads));
        }
        if let Some(across) = across {
            let parked = parked_for_ranks(&across, blocks[own].iter());
            let came = (across.exchange)(parked);
            for (rank, bytes) in came.iter().enumerate().take(across.rank) {
                take_parked(
                    blocks[across.cut[rank]..across.cut[rank + 1]].iter_mut(),
                    bytes,
                );
            }
        }
        for index in waiting {
            let rows = blocks[index].rows.clone();
            let loads = &mut loads[rows.clone()];
            for source in &sources[index] {
                blocks[source.block].outbox.deliver(source.target, loads);
            }
            fastest = fastest.merge(finish(index, &mut records[rows], loads));
        }
        fastest
    }

    /// The work on all listed pairs of a block.
    pub(super) fn pairs<'p, const PERIODIC: bool, const WATCHED: bool>(
        &'p self,
        block: &'p mut Block<Histories<N, T, R, A>>,
        rows: &'p Rows<'p>,
        loads: &'p mut [Load],
        numbers: &'p mut BatchColumns,
    ) -> Pairs<'p, 'p, N, T, R, A, Histories<N, T, R, A>, PERIODIC, WATCHED> {
        Pairs {
            pass: self,
            block,
            rows,
            loads,
            numbers,
        }
    }

    /// The contacts of one block: loads on its own rows are added at once, those on later blocks go into its outbox.
    pub(super) fn compute(
        &self,
        block: &mut Block<Histories<N, T, R, A>>,
        rows: &Rows<'_>,
        loads: &mut [Load],
        numbers: &mut BatchColumns,
    ) {
        loads.fill(Load::default());
        block.outbox.clear();
        block.reports.surface_loads.clear();
        block.reports.begin_wall_loads(self.context);
        if self.context.watch.is_some() {
            block.reports.observation = Observation::empty(self.context.walls.len());
        }
        let width = self.context.width;
        match (self.context.watch, self.context.cell.has_images()) {
            (None, false) => width.run(self.pairs::<false, false>(block, rows, loads, numbers)),
            (None, true) => width.run(self.pairs::<true, false>(block, rows, loads, numbers)),
            // Observed steps are few: a shift of zero, which changes no bit, is cheaper there than one more copy of the loop.
            // Observed contacts are recorded one by one. Not through `Width::run`, with which the loop is compiled in all widths.
            (Some(_), _) => (self.pairs::<true, true>(block, rows, loads, numbers)).run::<f64>(),
        }
        self.walls(block, rows, loads);
    }
}

/// Whether blocks of earlier ranks reach into a block.
pub(super) fn waits(sources: &[Source], own: &Range<usize>) -> bool {
    sources.first().is_some_and(|first| first.block < own.start)
}

/// The records that one block reads: its own, and those of the later blocks that it reaches.
pub(super) struct Rows<'a> {
    /// From the first row of the block on, to its end or beyond.
    pub(super) own: &'a [Particle],
    /// Of each later block that the block reaches, ascending, without those in `own`; with the number of rows from the first one of the
    /// block to its first.
    targets: Vec<(usize, &'a [Particle])>,
}

impl<'a> Rows<'a> {
    /// All rows from the first one of the block on lie together.
    pub(super) fn together(own: &'a [Particle]) -> Self {
        Self {
            own,
            targets: Vec::new(),
        }
    }

    /// The records of the block, and of those that it reaches.
    pub(super) fn apart(own: &'a [Particle], targets: Vec<(usize, &'a [Particle])>) -> Self {
        Self { own, targets }
    }

    /// The record that lies `ahead` rows behind the first one of the block.
    #[inline(always)]
    pub(super) fn ahead(&self, ahead: usize) -> &'a Particle {
        if let Some(record) = self.own.get(ahead) {
            return record;
        }
        // Mostly in the first or the second target: the test is faster than a division.
        for (start, records) in &self.targets {
            if let Some(record) = records.get(ahead - start) {
                return record;
            }
        }
        unreachable!("a listed partner lies in a block that is reached")
    }
}

/// A contact that is being observed.
pub(super) struct ContactSite<'a> {
    /// Index of its law.
    pub(super) pair: usize,
    pub(super) row: usize,
    pub(super) partner: Partner,
    /// The partner, if it is a particle.
    pub(super) b: Option<&'a Particle>,
    /// The number of the sheet and the point of it, if it is one.
    pub(super) sheet: Option<(u16, SurfacePoint)>,
    /// Whether it joins a nearer contact of the particle with the sheet.
    pub(super) joined: Option<Joined>,
    /// Feature of the wall.
    pub(super) feature: u32,
    /// R_A - overlap/2, at a sheet the distance from it, m.
    pub(super) lever: f64,
    /// Overlap over the smaller radius.
    pub(super) depth: f64,
    /// Whether the two overlap; else adhesion acts across a gap.
    pub(super) touches: bool,
}

//! Runs on ranks that are threads, compared with those of one process: states, observations, and what outputs read beside these.

use std::sync::{Arc, Once};
use std::thread;

use mercury_engine::audit::Audit;
use mercury_engine::bonds::Bonds;
use mercury_engine::forces::{
    LoadSums, Observation, Partner, SavedSlots, SlotState, Watch, fix_block_size,
};
use mercury_engine::liquid::LiquidRow;
use mercury_engine::ranks::{Share, Threads};
use mercury_engine::state::{Id, Plain};
use mercury_engine::step::{Engine, RunError, Snapshot, StartOptions};
use mercury_solver::plan::Plan;
use mercury_tests::scene_checks::planned;

/// Rows of a block.
pub(crate) const ROWS: usize = 64;

static SMALL_BLOCKS: Once = Once::new();

/// States of a run as bytes, and observations.
#[derive(PartialEq, Default)]
pub(crate) struct Seen {
    pub(crate) counts: Counts,
    pub(crate) states: Vec<Vec<u8>>,
    pub(crate) observations: Vec<Observation>,
    pub(crate) looks: Vec<Look>,
}

/// Numbers that outputs read of an engine beside rows and observations.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Look {
    pub(crate) liquid: Option<LiquidRow>,
    pub(crate) volumes: Option<Vec<f64>>,
    pub(crate) audit: Audit,
    /// Since the last look.
    pub(crate) loads: Option<LoadSums>,
    /// Ids of the ends of each liquid bridge, and whether the rows of its lower end are in the second half of all.
    pub(crate) bridges: Vec<([Option<Id>; 2], bool)>,
}

impl Look {
    fn at(engine: &mut Engine, takes_loads: bool) -> Self {
        let [loads, _] = engine.take_load_sums(takes_loads, false);
        let ids = &engine.particles.ids;
        let bridges = engine.bridges();
        let bridges = bridges.iter().map(|site| {
            let other = match site.partner {
                Partner::Particle { row, .. } => Some(ids[row as usize]),
                Partner::Wall { .. } => None,
            };
            let mut ends = [Some(ids[site.row as usize]), other];
            ends.sort();
            (ends, site.row as usize >= ids.len() / 2)
        });
        Self {
            bridges: bridges.collect(),
            liquid: engine.liquid(),
            volumes: engine.liquid_volumes(),
            audit: engine.audit(),
            loads,
        }
    }
}

/// Counts since the start.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Counts {
    pub(crate) lists: u64,
    pub(crate) inserted: u64,
    pub(crate) removed: u64,
    /// Bonds.
    pub(crate) glued: u64,
    /// Bonds that broke since the engine began.
    pub(crate) broken: InBlocks,
    /// Contacts of grains with sheets.
    pub(crate) at_sheets: InBlocks,
    /// Contacts of vertices with walls.
    pub(crate) of_vertices: u64,
}

/// Number of events at grains, and of the blocks of these: with seven ranks nearly each block has its own.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct InBlocks {
    number: usize,
    blocks: usize,
}

impl InBlocks {
    fn of(rows: impl Iterator<Item = usize>) -> Self {
        let mut blocks: Vec<usize> = rows.map(|row| row / ROWS).collect();
        let number = blocks.len();
        blocks.sort_unstable();
        blocks.dedup();
        Self {
            number,
            blocks: blocks.len(),
        }
    }

    pub(crate) fn are_spread(&self) -> bool {
        self.number > 10 && self.blocks > 2
    }
}

impl Counts {
    fn of(engine: &mut Engine, begun: f64) -> Self {
        let boundaries = engine.boundaries();
        let mut counts = Self {
            lists: engine.lists().rebuilds,
            inserted: boundaries.inserted().number,
            removed: boundaries.removed().number,
            ..Self::default()
        };
        let walls = engine.walls().len();
        let state = engine.snapshot();
        let near_walls = state.near_walls().unwrap();
        let touching = near_walls
            .iter()
            .filter(|near| near.state == SlotState::Touching && near.partner as usize >= walls);
        counts.at_sheets = InBlocks::of(touching.map(|near| near.row as usize));
        let mut sections = state.sections().iter();
        if let Some((_, mut bytes)) = sections.find(|(name, _)| *name == "vertices at walls") {
            for of_sheet in <Vec<SavedSlots>>::take(&mut bytes).unwrap() {
                let touch = of_sheet
                    .iter()
                    .filter(|slot| slot.state == SlotState::Touching);
                counts.of_vertices += touch.count() as u64;
            }
        }
        let Some((bonds, core)) = engine.part_and_core::<Bonds>() else {
            return counts;
        };
        counts.glued = bonds.counts().iter().map(|of_entry| of_entry.made).sum();
        let ids = &core.particles.ids;
        let row = |id: u32| ids.iter().position(|other| other.number() == id);
        let breaks = bonds.take_breaks().into_iter();
        let breaks = breaks.filter(|broken| broken.time > begun);
        counts.broken = InBlocks::of(breaks.map(|broken| row(broken.ids[0]).unwrap_or(0)));
        counts
    }
}

pub(crate) fn scene(name: &str, set: &[&str]) -> Arc<Plan> {
    SMALL_BLOCKS.call_once(|| fix_block_size(ROWS));
    let set: Vec<String> = set.iter().map(ToString::to_string).collect();
    Arc::new(planned(name, &set).unwrap())
}

pub(crate) fn options(threads: usize, ranks: Option<Share>) -> StartOptions {
    StartOptions::threads(threads).ranks(ranks)
}

/// The steps between looks.
pub(crate) const PIECES: [u64; 4] = [1, 40, 7, 100];

/// Makes some pieces of a run; a look, the end of a step and a checkpoint behind each.
pub(crate) fn advance(
    engine: &mut Engine,
    seen: &mut Seen,
    pieces: &[u64],
) -> Result<(), RunError> {
    for (number, &steps) in pieces.iter().enumerate() {
        let records = number % 2 == 0;
        engine.steps_at_once(
            steps,
            Some(Watch {
                records,
                audit: None,
            }),
        )?;
        seen.observations.push(engine.observation());
        // Loads on triangles go on being summed up over some looks.
        seen.looks.push(Look::at(engine, number % 2 == 1));
        // In the middle of its kicks, as checkpoints of a run are, and at the end of the step.
        engine.collect(true);
        seen.states.push(engine.snapshot().encode());
        engine.complete_step()?;
        seen.looks.push(Look::at(engine, false));
        engine.collect(true);
        seen.states.push(engine.snapshot().encode());
    }
    Ok(())
}

/// Makes a run on so many ranks, from the start or from a state.
pub(crate) fn on_ranks(
    plan: &Arc<Plan>,
    ranks: usize,
    threads: usize,
    from: Option<&[u8]>,
    pieces: &[u64],
) -> Seen {
    let mut team = Threads::team(ranks).into_iter();
    let first = team.next().unwrap();
    thread::scope(|scope| {
        for rank in team {
            let plan = Arc::clone(plan);
            scope.spawn(move || {
                let share = Share::new(Box::new(rank));
                Engine::follow(plan, options(threads, Some(share))).unwrap();
            });
        }
        let share = (ranks > 1).then(|| Share::new(Box::new(first)));
        let options = options(threads, share);
        let mut engine = match from {
            None => Engine::start(Arc::clone(plan), options),
            Some(state) => {
                Engine::resume(Arc::clone(plan), Snapshot::decode(state).unwrap(), options)
            }
        }
        .unwrap();
        let begun = engine.time();
        let mut seen = Seen::default();
        if from.is_none() {
            seen.observations.push(engine.observation());
        }
        advance(&mut engine, &mut seen, pieces).unwrap();
        seen.counts = Counts::of(&mut engine, begun);
        seen
    })
}

/// Where two runs differ first.
pub(crate) fn assert_same(seen: &Seen, expected: &Seen, of: &str) {
    for (k, (a, b)) in seen
        .observations
        .iter()
        .zip(&expected.observations)
        .enumerate()
    {
        assert_eq!(a, b, "{of}: observation {k}");
    }
    for (k, (a, b)) in seen.looks.iter().zip(&expected.looks).enumerate() {
        assert_eq!(a, b, "{of}: look {k}");
    }
    for (k, (a, b)) in seen.states.iter().zip(&expected.states).enumerate() {
        if a != b {
            let [a, b] = [a, b].map(|bytes| Snapshot::decode(bytes).unwrap());
            let sections = a.sections().iter().zip(b.sections().iter());
            let differ: Vec<&str> = sections
                .filter(|((_, a), (_, b))| a != b)
                .map(|((name, _), _)| name)
                .collect();
            panic!("{of}: state {k} differs in {differ:?}");
        }
    }
    assert!(seen == expected, "{of}");
}

/// The scene gives the same bytes on any number of ranks, with one and two threads each: from the start, and from a state that one process has
/// made `ahead` steps later. Returns what happened in the steps compared.
pub(crate) fn same_on_any_ranks(plan: &Arc<Plan>, ahead: u64) -> Counts {
    compared(plan, ahead).0
}

/// Likewise, with all looks: that before the steps compared, then those of them.
pub(crate) fn compared(plan: &Arc<Plan>, ahead: u64) -> (Counts, Vec<Look>) {
    let name = plan.outputs().prefix();
    let start = on_ranks(plan, 1, 1, None, &[ahead.max(1)]);
    let state = start.states.last().unwrap();
    let expected = on_ranks(plan, 1, 1, Some(state), &PIECES);
    for (ranks, threads) in [(2, 1), (3, 2), (4, 1), (7, 1)] {
        let seen = on_ranks(plan, ranks, threads, Some(state), &PIECES);
        let of = format!("{name}, {ranks} ranks, {threads} threads");
        assert_same(&seen, &expected, &of);
    }
    // The state behind the second piece, on three ranks, is gone on with on two.
    let first = on_ranks(plan, 3, 1, Some(state), &PIECES[..2]);
    let rest = on_ranks(
        plan,
        2,
        1,
        first.states.last().map(Vec::as_slice),
        &PIECES[2..],
    );
    assert!(
        rest.states == expected.states[4..],
        "{name}, three ranks and then two"
    );
    assert!(
        rest.looks == expected.looks[4..],
        "{name}, looks on three ranks and then two"
    );
    let begun = on_ranks(plan, 1, 1, None, &PIECES[..2]);
    let seen = on_ranks(plan, 3, 1, None, &PIECES[..2]);
    assert_same(&seen, &begun, &format!("{name} from the start"));
    let counts = Counts {
        lists: expected.counts.lists - start.counts.lists,
        inserted: expected.counts.inserted - start.counts.inserted,
        removed: expected.counts.removed - start.counts.removed,
        glued: expected.counts.glued - start.counts.glued,
        ..expected.counts
    };
    let before = start.looks.into_iter().next_back();
    (counts, before.into_iter().chain(expected.looks).collect())
}

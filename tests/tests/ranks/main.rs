//! One scene on several ranks: the same bytes as in one process.
//!
//! Ranks are threads here, with blocks of 64 rows, so that small scenes have many. State and observations of the first rank are compared with those
//! of an engine without others: in the middle, at looks, after a checkpoint on other ranks.

use std::sync::{Arc, Once};
use std::thread;

use mercury_engine::forces::{Observation, Watch, fix_block_size};
use mercury_engine::ranks::{Ranks, Share, Threads};
use mercury_engine::step::{Engine, RunError, Snapshot, StartOptions};
use mercury_solver::plan::Plan;
use mercury_tests::scene_checks::planned;

/// Rows of a block.
const ROWS: usize = 64;

static SMALL_BLOCKS: Once = Once::new();

/// States of a run as bytes, and observations.
#[derive(PartialEq, Default)]
struct Seen {
    counts: Counts,
    states: Vec<Vec<u8>>,
    observations: Vec<Observation>,
}

/// Counts since the start.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Counts {
    lists: u64,
    inserted: u64,
    removed: u64,
}

fn scene(name: &str, set: &[&str]) -> Arc<Plan> {
    SMALL_BLOCKS.call_once(|| fix_block_size(ROWS));
    let set: Vec<String> = set.iter().map(ToString::to_string).collect();
    Arc::new(planned(name, &set).unwrap())
}

fn options(threads: usize, ranks: Option<Share>) -> StartOptions {
    StartOptions::threads(threads).ranks(ranks)
}

/// The steps between looks.
const PIECES: [u64; 4] = [1, 40, 7, 100];

/// Makes some pieces of a run; a look, the end of a step and a checkpoint behind each.
fn advance(engine: &mut Engine, seen: &mut Seen, pieces: &[u64]) -> Result<(), RunError> {
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
        // In the middle of its kicks, as checkpoints of a run are, and at the end of the step.
        engine.collect(true);
        seen.states.push(engine.snapshot().encode());
        engine.complete_step()?;
        engine.collect(true);
        seen.states.push(engine.snapshot().encode());
    }
    Ok(())
}

/// Makes a run on so many ranks, from the start or from a state.
fn on_ranks(
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
        let mut seen = Seen::default();
        if from.is_none() {
            seen.observations.push(engine.observation());
        }
        advance(&mut engine, &mut seen, pieces).unwrap();
        let boundaries = engine.boundaries();
        seen.counts = Counts {
            lists: engine.lists().rebuilds,
            inserted: boundaries.inserted().number,
            removed: boundaries.removed().number,
        };
        seen
    })
}

/// Where two runs differ first.
fn assert_same(seen: &Seen, expected: &Seen, of: &str) {
    for (k, (a, b)) in seen
        .observations
        .iter()
        .zip(&expected.observations)
        .enumerate()
    {
        assert_eq!(a, b, "{of}: observation {k}");
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
fn same_on_any_ranks(plan: &Arc<Plan>, ahead: u64) -> Counts {
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
    let begun = on_ranks(plan, 1, 1, None, &PIECES[..2]);
    let seen = on_ranks(plan, 3, 1, None, &PIECES[..2]);
    assert_same(&seen, &begun, &format!("{name} from the start"));
    Counts {
        lists: expected.counts.lists - start.counts.lists,
        inserted: expected.counts.inserted - start.counts.inserted,
        removed: expected.counts.removed - start.counts.removed,
    }
}

#[test]
fn a_dense_bed() {
    same_on_any_ranks(&scene("bench/dense-2k.toml", &[]), 100);
}

/// Grains of three sizes, among them clumps, come and leave, cross planes and a periodic face, are followed, and fall on a plate that moves.
#[test]
fn grains_that_come_and_leave() {
    let busy = |periodic: bool| {
        let periodic = if periodic { "[\"x\", \"y\"]" } else { "[]" };
        let periodic = format!("domain.periodic={periodic}");
        scene(
            "bench/dense-2k.toml",
            &[
                &periodic,
                "title=\"busy\"",
                "deletions=[{ name = \"out\", region = { shape = \"half-space\", point = [0.0, 0.0, 0.003], normal = [0.1, 0.0, -1.0] } }]",
                "fluxes=[{ name = \"low\", plane = { point = [0.0, 0.0, 0.006], normal = [0.0, 0.0, -1.0] } }, { name = \"mid\", plane = { point = [0.024, 0.0, 0.0], normal = [1.0, 0.0, 0.0] } }]",
                "insertions=[{ name = \"feed\", region = { shape = \"box\", min = [0.004, 0.004, 0.07], max = [0.044, 0.044, 0.077] }, material = \"bead\", psd = { kind = \"uniform\", min_diameter = 0.001, max_diameter = 0.004, weighting = \"number\" }, rate = { number = 20000.0 }, total = { number = 5000 }, velocity = { mean = [0.3, 0.1, -1.5], spread = [0.2, 0.2, 0.2] } }]",
                "walls=[{ name = \"plate\", shape = \"disc\", origin = [0.024, 0.024, 0.068], axis = [0.0, 0.02, 1.0], radius = 0.01, material = \"bead\", motion = [{ kind = \"translation\", velocity = [0.1, 0.0, -0.2] }] }]",
                "output.track=[\"feed\"]",
                "output.left=true",
            ],
        )
    };
    for periodic in [false, true] {
        let counts = same_on_any_ranks(&busy(periodic), 60);
        assert!(
            counts.lists > 10 && counts.inserted > 40 && counts.removed > 5,
            "{counts:?}"
        );
    }
}

#[test]
fn sizes_apart() {
    same_on_any_ranks(&scene("bench/poly-20k.toml", &[]), 1);
}

#[test]
fn a_drum_of_a_mesh() {
    let counts = same_on_any_ranks(&scene("bench/mesh-drum-6k.toml", &[]), 300);
    assert!(counts.lists > 1, "{counts:?}");
}

/// Walls that wear do it on each rank, by the contacts of all.
#[test]
fn a_screen_that_wears() {
    // Many small grains, so that those on the bars are of several ranks.
    let plan = scene(
        "wear/screen.toml",
        &[
            "insertions.0.rate={number=20000}",
            "insertions.0.mixture=[{ material = \"small\", psd = { kind = \"uniform\", min_diameter = 0.0015, max_diameter = 0.002, weighting = \"number\" }, share = 1.0 }]",
        ],
    );
    let start = on_ranks(&plan, 1, 1, None, &[12_000]);
    let after = on_ranks(&plan, 1, 1, start.states.last().map(Vec::as_slice), &PIECES);
    let wear = |seen: &Seen| {
        let state = Snapshot::decode(seen.states.last().unwrap()).unwrap();
        let mut sections = state.sections().iter();
        let (_, content) = sections.find(|(name, _)| *name == "wear").unwrap();
        content.to_vec()
    };
    assert!(wear(&start) != wear(&after), "nothing wears in these steps");
    same_on_any_ranks(&plan, 12_000);
}

#[test]
fn a_press_with_a_servo() {
    same_on_any_ranks(&scene("press.toml", &[]), 20_000);
}

#[test]
fn a_triaxial_cell() {
    same_on_any_ranks(&scene("triaxial.toml", &[]), 20_000);
}

#[test]
fn discs() {
    same_on_any_ranks(&scene("discs-2d.toml", &[]), 30_000);
}

#[test]
fn a_drum_of_clumps() {
    let counts = same_on_any_ranks(&scene("clumps/drum.toml", &[]), 6_000);
    assert!(counts.lists > 0, "{counts:?}");
}

#[test]
fn a_gas_of_rods() {
    same_on_any_ranks(&scene("clumps/rod-gas.toml", &[]), 3_000);
}

#[test]
fn two_spheres_are_fewer_than_the_ranks() {
    same_on_any_ranks(&scene("two-spheres.toml", &[]), 1);
}

/// Features that do not work on several ranks are refused by name, and nothing hangs.
#[test]
fn other_features_are_refused() {
    for (name, part) in [
        ("wet-packing.toml", "liquid"),
        ("membrane.toml", "membranes"),
        ("agglomerate.toml", "audit"),
    ] {
        let plan = scene(name, &[]);
        let mut team = Threads::team(2).into_iter();
        let share = |rank: Threads| Some(Share::new(Box::new(rank)));
        let first = options(1, share(team.next().unwrap()));
        let second = options(1, share(team.next().unwrap()));
        let of_second = Arc::clone(&plan);
        let second = thread::spawn(move || Engine::follow(of_second, second).unwrap_err());
        let error = Engine::start(plan, first).err().unwrap();
        assert_eq!(error, second.join().unwrap());
        let RunError::OnRanks { what } = error else {
            panic!("{error}");
        };
        assert_eq!(what, part, "{name}");
    }
}

/// The middle one of three ranks, to which shares of contacts come in reversed order.
struct Reversed(Threads);

/// Bytes of a share: row, force, torque.
const SHARE: usize = 56;

impl Ranks for Reversed {
    fn place(&self) -> (usize, usize) {
        self.0.place()
    }

    fn exchange(&mut self, to: Vec<(usize, Vec<u8>)>, from: &[usize]) -> Vec<Vec<u8>> {
        let mut came = self.0.exchange(to, from);
        // Records come from later ranks, and with new lists something comes from both.
        if from == [0] {
            let mut rest = &mut came[0][..];
            while let Some((count, shares)) = rest.split_first_chunk_mut::<4>() {
                let count = u32::from_le_bytes(*count) as usize;
                let (shares, others) = shares.split_at_mut(count * SHARE);
                let reversed: Vec<u8> = shares.chunks(SHARE).rev().flatten().copied().collect();
                shares.copy_from_slice(&reversed);
                rest = others;
            }
        }
        came
    }

    fn all(&mut self, own: Vec<u8>) -> Vec<Vec<u8>> {
        self.0.all(own)
    }

    fn gather(&mut self, own: Vec<u8>) -> Vec<Vec<u8>> {
        self.0.gather(own)
    }

    fn broadcast(&mut self, own: Vec<u8>) -> Vec<u8> {
        self.0.broadcast(own)
    }

    fn largest(&mut self, numbers: &mut [f64]) {
        self.0.largest(numbers);
    }

    fn add(&mut self, numbers: &mut [i64]) {
        self.0.add(numbers);
    }
}

/// The comparison would see a wrong order of sums: shares that one of three ranks adds in reversed order give other bytes.
#[test]
fn another_order_of_shares_gives_other_bytes() {
    let plan = scene("bench/dense-2k.toml", &[]);
    let run = |is_reversed: bool| {
        let mut team = Threads::team(3).into_iter();
        let [first, middle, last] = std::array::from_fn(|_| team.next().unwrap());
        let middle: Box<dyn Ranks> = match is_reversed {
            true => Box::new(Reversed(middle)),
            false => Box::new(middle),
        };
        let follow = |rank: Box<dyn Ranks>| {
            let plan = Arc::clone(&plan);
            move || Engine::follow(plan, options(1, Some(Share::new(rank)))).unwrap()
        };
        thread::scope(|scope| {
            scope.spawn(follow(middle));
            scope.spawn(follow(Box::new(last)));
            let first = options(1, Some(Share::new(Box::new(first))));
            let mut engine = Engine::start(Arc::clone(&plan), first).unwrap();
            let mut seen = Seen::default();
            advance(&mut engine, &mut seen, &PIECES).unwrap();
            seen
        })
    };
    assert!(run(false).states.last() != run(true).states.last());
}

/// Messages go where they are meant to.
#[test]
fn threads_exchange_bytes() {
    let team = Threads::team(3);
    let work = |mut rank: Threads| {
        let (own, count) = rank.place();
        let to = (0..count).filter(|&to| to != own);
        let to = to.map(|to| (to, vec![own as u8, to as u8])).collect();
        let others: Vec<usize> = (0..count).filter(|&from| from != own).collect();
        let came = rank.exchange(to, &others);
        let expected: Vec<Vec<u8>> = others
            .iter()
            .map(|&from| vec![from as u8, own as u8])
            .collect();
        assert_eq!(came, expected);
        assert_eq!(rank.all(vec![own as u8]), [[0], [1], [2]]);
        let first = rank.gather(vec![own as u8]);
        assert_eq!(first.len(), if own == 0 { 3 } else { 0 });
        assert_eq!(rank.broadcast(vec![own as u8]), [0]);
        let mut numbers = [own as f64, -(own as f64)];
        rank.largest(&mut numbers);
        assert_eq!(numbers, [2.0, 0.0]);
        let mut sums = [own as i64, 1];
        rank.add(&mut sums);
        assert_eq!(sums, [3, 3]);
    };
    let threads: Vec<_> = team
        .into_iter()
        .map(|rank| thread::spawn(move || work(rank)))
        .collect();
    threads
        .into_iter()
        .for_each(|thread| thread.join().unwrap());
}

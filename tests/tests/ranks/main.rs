//! One scene on several ranks: the same bytes as in one process.
//!
//! Ranks are threads here, with blocks of 64 rows, so that small scenes have many. State and observations of the first rank are compared with those
//! of an engine without others: in the middle, at looks, after a checkpoint on other ranks.

use std::sync::{Arc, Once};
use std::thread;

use mercury_engine::bonds::Bonds;
use mercury_engine::forces::{Observation, SavedSlots, SlotState, Watch, fix_block_size};
use mercury_engine::ranks::{Ranks, Share, Threads};
use mercury_engine::state::Plain;
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
    /// Bonds.
    glued: u64,
    /// Bonds that broke since the engine began.
    broken: InBlocks,
    /// Contacts of grains with sheets.
    at_sheets: InBlocks,
    /// Contacts of vertices with walls.
    of_vertices: u64,
}

/// Number of events at grains, and of the blocks of these: with seven ranks nearly each block has its own.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct InBlocks {
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

    fn are_spread(&self) -> bool {
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
        glued: expected.counts.glued - start.counts.glued,
        ..expected.counts
    }
}

#[test]
fn a_dense_bed() {
    same_on_any_ranks(&scene("bench/dense-2k.toml", &[]), 100);
}

/// Grains of several sizes come and leave, cross planes and a periodic face, are followed, and fall on a plate that moves.
fn busy(periodic: bool, set: &[&str]) -> Arc<Plan> {
    let periodic = if periodic { "[\"x\", \"y\"]" } else { "[]" };
    let periodic = format!("domain.periodic={periodic}");
    let mut all = vec![
        periodic.as_str(),
        "title=\"busy\"",
        "deletions=[{ name = \"out\", region = { shape = \"half-space\", point = [0.0, 0.0, 0.003], normal = [0.1, 0.0, -1.0] } }]",
        "fluxes=[{ name = \"low\", plane = { point = [0.0, 0.0, 0.006], normal = [0.0, 0.0, -1.0] } }, { name = \"mid\", plane = { point = [0.024, 0.0, 0.0], normal = [1.0, 0.0, 0.0] } }]",
        "insertions=[{ name = \"feed\", region = { shape = \"box\", min = [0.004, 0.004, 0.07], max = [0.044, 0.044, 0.077] }, material = \"bead\", psd = { kind = \"uniform\", min_diameter = 0.001, max_diameter = 0.004, weighting = \"number\" }, rate = { number = 20000.0 }, total = { number = 5000 }, velocity = { mean = [0.3, 0.1, -1.5], spread = [0.2, 0.2, 0.2] } }]",
        "walls=[{ name = \"plate\", shape = \"disc\", origin = [0.024, 0.024, 0.068], axis = [0.0, 0.02, 1.0], radius = 0.01, material = \"bead\", motion = [{ kind = \"translation\", velocity = [0.1, 0.0, -0.2] }] }]",
        "output.track=[\"feed\"]",
        "output.left=true",
    ];
    all.extend_from_slice(set);
    scene("bench/dense-2k.toml", &all)
}

#[test]
fn grains_that_come_and_leave() {
    for periodic in [false, true] {
        let counts = same_on_any_ranks(&busy(periodic, &[]), 60);
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

/// Two agglomerates, one of which shatters on a plate, with the contacts of glued pairs.
fn agglomerates() -> Arc<Plan> {
    scene("agglomerate.toml", &["output.energy_budget=false"])
}

#[test]
fn agglomerates_that_shatter() {
    let counts = same_on_any_ranks(&agglomerates(), 30);
    assert!(counts.broken.are_spread(), "{counts:?}");
}

/// A block that is glued to floor and lid, and across a periodic face, has no contacts inside, and is torn apart by a servo.
#[test]
fn a_block_that_is_torn_apart() {
    let plan = scene(
        "agglomerate.toml",
        &[
            "output.energy_budget=false",
            "domain={ min = [0.0, -0.02, -0.001], max = [0.016, 0.04, 0.05], periodic = [\"x\"] }",
            "particles=[{ material = \"grain\", radius = 1e-3, lattice = { min = [0.001, 0.0, 0.001], max = [0.0155, 0.0145, 0.0155], spacing = 0.002 } }]",
            "walls=[{ name = \"floor\", shape = \"plane\", point = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0], material = \"grain\" }, { name = \"lid\", shape = \"plane\", point = [0.0, 0.0, 0.016], normal = [0.0, 0.0, -1.0], material = \"grain\", motion = [{ kind = \"servo\", axis = [0.0, 0.0, 1.0], force = 60.0, max_speed = 2.0 }] }]",
            "bonds=[{ name = \"glue\", law = \"beam\", walls = [\"floor\", \"lid\"], youngs_modulus = 1e7, damping = 0.05, tensile_strength = 3e4, shear_strength = 3e4, strength_spread = 0.3, contact = false }]",
        ],
    );
    let counts = same_on_any_ranks(&plan, 1);
    assert!(counts.broken.are_spread(), "{counts:?}");
}

/// Grains that come and leave are glued where they touch, from a time on at which many do, and break.
#[test]
fn grains_that_are_glued_as_they_touch() {
    for (periodic, contact) in [(false, true), (true, false)] {
        let bonds = format!(
            "bonds=[{{ name = \"first\", between = [\"bead\", \"bead\"], when = \"contact\", from = 2.6e-3, until = 4e-3, law = \"beam\", walls = [\"plate\"], youngs_modulus = 1e5, damping = 0.1, tensile_strength = 300.0, strength_spread = 1.0, contact = {contact} }}, {{ name = \"then\", when = \"contact\", from = 3.5e-3, law = \"parallel\", normal_stiffness = 1e8, shear_stiffness = 5e7, contact = true }}]"
        );
        let counts = same_on_any_ranks(&busy(periodic, &[&bonds]), 60);
        let happened = counts.broken.are_spread();
        assert!(
            happened && counts.glued > 100 && counts.removed > 5,
            "{counts:?}"
        );
    }
}

/// Rods that stick where they touch.
#[test]
fn a_gas_of_rods_that_stick() {
    let plan = scene(
        "clumps/rod-gas.toml",
        &[
            "bonds=[{ name = \"glue\", when = \"contact\", law = \"beam\", youngs_modulus = 3e3, tensile_strength = 50.0 }]",
        ],
    );
    let counts = same_on_any_ranks(&plan, 3_000);
    assert!(counts.glued > 0, "{counts:?}");
}

/// Balls lie on a sheet that a plate with a servo presses from below.
fn balls_on_sheet() -> Arc<Plan> {
    scene(
        "membrane.toml",
        &[
            "particles=[{ material = \"ball\", radius = 1e-3, lattice = { min = [-0.02, -0.02, 0.0012], max = [0.02, 0.02, 0.0036], spacing = 0.0022 }, velocity = [0.05, 0.0, -0.2] }]",
            "walls=[{ name = \"plate\", shape = \"disc\", origin = [0.0, 0.0, -0.0002], axis = [0.0, 0.0, 1.0], radius = 0.025, material = \"ball\", motion = [{ kind = \"servo\", axis = [0.0, 0.0, 1.0], force = 0.2, max_speed = 0.1 }] }]",
            "membranes.0.walls=true",
            "guard={ policy = \"warn\" }",
        ],
    )
}

#[test]
fn balls_on_a_sheet_on_a_plate() {
    let counts = same_on_any_ranks(&balls_on_sheet(), 500);
    let happened = counts.at_sheets.are_spread();
    assert!(happened && counts.of_vertices > 3, "{counts:?}");
}

/// A sleeve under pressure, held by a wall with a servo.
#[test]
fn a_sample_in_a_sleeve() {
    let counts = same_on_any_ranks(&scene("sleeve.toml", &[]), 20_500);
    let happened = counts.at_sheets.are_spread();
    assert!(happened, "{counts:?}");
}

/// Features that do not work on several ranks are refused by name, and nothing hangs.
#[test]
fn other_features_are_refused() {
    for (name, part) in [
        ("wet-packing.toml", "liquid"),
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

/// A rank that makes a mistake in what comes from others.
struct Mistaken {
    ranks: Threads,
    mistake: Mistake,
}

/// Mistakes.
#[derive(Clone, Copy, PartialEq)]
enum Mistake {
    None,
    /// The middle one of three ranks adds shares of contacts in reversed order.
    Order,
    /// No rank takes the messages of parts.
    NoMessages,
    /// No rank takes the first load on a sheet of the middle one of three ranks.
    NoLoad,
}

/// Bytes of a share: row, force, torque.
const SHARE: usize = 56;
/// Bytes of a load on a sheet: sheet, triangle, three forces.
const LOAD: usize = 78;

impl Ranks for Mistaken {
    fn place(&self) -> (usize, usize) {
        self.ranks.place()
    }

    fn exchange(&mut self, to: Vec<(usize, Vec<u8>)>, from: &[usize]) -> Vec<Vec<u8>> {
        let mut came = self.ranks.exchange(to, from);
        // Records come from later ranks, and with new lists something comes from both.
        if self.mistake == Mistake::Order && from == [0] {
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
        let mut all = self.ranks.all(own);
        if self.mistake == Mistake::NoLoad {
            let is_load = |mut bytes: &[u8]| {
                let (sheet, triangle) = <(u16, u32)>::take(&mut bytes).unwrap();
                sheet == 0 && triangle < 10_000
            };
            let (loads, rest) = all[1].as_chunks::<LOAD>();
            if !loads.is_empty() && rest.is_empty() && loads.iter().all(|load| is_load(load)) {
                all[1].drain(..LOAD);
            }
        }
        all
    }

    fn gather(&mut self, own: Vec<u8>) -> Vec<Vec<u8>> {
        self.ranks.gather(own)
    }

    fn broadcast(&mut self, own: Vec<u8>) -> Vec<u8> {
        self.ranks.broadcast(own)
    }

    fn largest(&mut self, numbers: &mut [f64]) {
        self.ranks.largest(numbers);
        // Whether a part has a message.
        if self.mistake == Mistake::NoMessages && numbers[0] == 1.0 {
            numbers[0] = 0.0;
        }
    }

    fn add(&mut self, numbers: &mut [i64]) {
        self.ranks.add(numbers);
    }
}

/// The last state of a run on three ranks, from the start or from a state, one or all of which make a mistake.
fn on_three_ranks(plan: &Arc<Plan>, from: Option<&[u8]>, mistake: Mistake) -> Vec<u8> {
    let team = Threads::team(3).into_iter().enumerate();
    let mut team = team.map(|(rank, ranks)| {
        let mistake = match mistake {
            Mistake::Order if rank != 1 => Mistake::None,
            mistake => mistake,
        };
        Box::new(Mistaken { ranks, mistake })
    });
    let first = team.next().unwrap();
    thread::scope(|scope| {
        for rank in team {
            let plan = Arc::clone(plan);
            let options = options(1, Some(Share::new(rank)));
            scope.spawn(move || Engine::follow(plan, options).unwrap());
        }
        let first = options(1, Some(Share::new(first)));
        let begun = match from {
            None => Engine::start(Arc::clone(plan), first),
            Some(state) => {
                Engine::resume(Arc::clone(plan), Snapshot::decode(state).unwrap(), first)
            }
        };
        let mut engine = begun.unwrap();
        let mut seen = Seen::default();
        advance(&mut engine, &mut seen, &PIECES).unwrap();
        seen.states.pop().unwrap()
    })
}

/// The comparison would see what a rank leaves out, or adds in another order.
#[test]
fn mistakes_of_a_rank_give_other_bytes() {
    let differs = |plan: &Arc<Plan>, ahead: u64, mistake: Mistake| {
        let start = (ahead > 0).then(|| on_ranks(plan, 1, 1, None, &[ahead]));
        let state = start.as_ref().and_then(|start| start.states.last());
        let run = |mistake| on_three_ranks(plan, state.map(Vec::as_slice), mistake);
        run(Mistake::None) != run(mistake)
    };
    let bed = scene("bench/dense-2k.toml", &[]);
    assert!(differs(&bed, 0, Mistake::Order));
    assert!(differs(&agglomerates(), 30, Mistake::NoMessages));
    assert!(differs(&balls_on_sheet(), 500, Mistake::NoLoad));
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

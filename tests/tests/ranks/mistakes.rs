//! Ranks that make a mistake: the comparison sees it.

use std::sync::Arc;
use std::thread;

use mercury_engine::ranks::{Ranks, Share, Threads};
use mercury_engine::state::Plain;
use mercury_engine::step::{Engine, Snapshot};
use mercury_solver::plan::Plan;

use super::compare::{PIECES, Seen, advance, on_ranks, options, scene};
use super::{agglomerates, balls_on_sheet, wet_bed};

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
    /// The middle one keeps events of its contacts to itself: of those steps in which their bytes are no whole number of words, as all other
    /// messages are.
    Events,
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
        let is_kept = self.mistake == Mistake::Events && !own.len().is_multiple_of(8);
        let mut all = self.ranks.all(if is_kept { Vec::new() } else { own });
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
            Mistake::Order | Mistake::Events if rank != 1 => Mistake::None,
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
    assert!(differs(&wet_bed(&[]), 0, Mistake::Events));
    assert!(differs(&agglomerates(), 30, Mistake::NoMessages));
    assert!(differs(&balls_on_sheet(), 500, Mistake::NoLoad));
}

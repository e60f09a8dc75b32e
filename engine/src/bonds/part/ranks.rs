//! Bonds that are divided among ranks ([`crate::ranks`]).
//!
//! A rank has the bonds with an end among its own rows, in the order of all, and adds their loads to its own rows: a bond between rows of two ranks is
//! computed by both, to the same bits. The rank of end A has it as its *own*, and says what becomes of it. Bonds to walls are on every rank where
//! walls follow loads.

use std::collections::BTreeSet;

use super::{Bonds, Candidate};
use crate::bonds::bond::{Bond, Break};
use crate::bonds::groups::Groups;
use crate::state::Plain;
use crate::step::{Core, RunError};

/// The occasions at which bonds break, in the order of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Occasion {
    Leaving,
    WallGone,
    Strength,
}

/// A bond that broke.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Broken {
    pub(super) occasion: Occasion,
    /// Its number among the bonds of this rank; in news among all.
    pub(super) number: u32,
    pub(super) rows: [u32; 2],
    pub(super) its: Break,
}

/// A bond of a rank.
#[derive(Debug, Clone, Copy)]
struct Place {
    /// Bonds that were glued before it, since the run or the process began.
    number: u32,
    is_own: bool,
}

/// The pair of an offset: whether the second is a wall, and ids.
type Pair = (bool, [u32; 2]);

/// The share of a rank in all bonds.
#[derive(Debug, Default)]
pub(super) struct BondShare {
    /// Of each bond of this rank.
    places: Vec<Place>,
    /// Number of the next bond that is glued.
    next: u32,
    /// Own bonds that broke since the last message.
    broken: Vec<Broken>,
    /// Pairs that have parted since the last message: their offsets are forgotten.
    parted: Vec<Pair>,
    /// Energy that damping took in the last step, J: breaks of that step, of which the ranks learn at its end, come before it.
    last_taken: f64,
    /// All bonds and pairs that may touch, on the first rank after they were collected.
    whole: Option<Whole>,
}

/// Bonds and pairs of all ranks.
#[derive(Debug)]
pub(super) struct Whole {
    pub(super) bonds: Groups,
    pub(super) candidates: Vec<Candidate>,
    pub(super) near_walls: Vec<[u32; 2]>,
}

impl BondShare {
    pub(super) fn whole(&self) -> Option<&Whole> {
        self.whole.as_ref()
    }

    /// Adds the energy that damping takes in a step to that of earlier ones.
    pub(super) fn take(&mut self, energy: f64, before: &mut f64) {
        *before += std::mem::replace(&mut self.last_taken, energy);
    }

    pub(super) fn last_taken(&self) -> f64 {
        self.last_taken
    }

    pub(super) fn forget_whole(&mut self) {
        self.whole = None;
    }

    /// The own bonds of this rank with their numbers.
    fn own<'a>(&'a self, all: &'a Groups) -> impl Iterator<Item = (u32, Bond)> {
        let bonds = self.places.iter().zip(all.iter());
        let own = bonds.filter(|(place, _)| place.is_own);
        own.map(|(place, bond)| (place.number, bond))
    }

    /// Forgets bonds that have broken, and has those of this rank ready for the others.
    pub(super) fn note_broken(&mut self, broken: Vec<Broken>) {
        let gone: BTreeSet<u32> = broken.iter().map(|broken| broken.number).collect();
        for mut broken in broken {
            let Place { number, is_own } = self.places[broken.number as usize];
            if is_own {
                broken.number = number;
                self.broken.push(broken);
            }
        }
        let mut place = 0..;
        (self.places).retain(|_| place.next().is_none_or(|place| !gone.contains(&place)));
    }

    pub(super) fn note_parted(&mut self, parted: Vec<Pair>) {
        self.parted.extend(parted);
    }

    /// News for other ranks; empty without any.
    pub(super) fn send(&mut self) -> Vec<u8> {
        let mut bytes = Vec::new();
        if !self.broken.is_empty() || !self.parted.is_empty() {
            std::mem::take(&mut self.broken).put(&mut bytes);
            std::mem::take(&mut self.parted).put(&mut bytes);
        }
        bytes
    }
}

/// Whether a rank has a bond; to all where walls follow loads.
fn is_of(core: &Core, rank: usize, bond: &Bond) -> bool {
    let is_there = |row: u32| core.rank_of_row(row) == rank;
    let [row, other] = bond.rows;
    is_there(row)
        || match bond.is_wall {
            true => core.has_servos(),
            false => is_there(other),
        }
}

impl Bonds {
    /// Takes the bonds of this rank from other ranks, and gives them those of theirs.
    pub(super) fn divide(&mut self, core: &mut Core) {
        let (rank, count) = (core.rank(), core.rank_count());
        let before = self.share.take();
        let mut bonds: Vec<(u32, Bond)>;
        if let Some(share) = &before {
            let mut out = vec![Vec::new(); count];
            for own in share.own(&self.all) {
                let others = (0..count).filter(|&to| to != rank);
                for to in others.filter(|&to| is_of(core, to, &own.1)) {
                    own.put(&mut out[to]);
                }
            }
            let numbers = share.places.iter().map(|place| place.number);
            bonds = numbers.zip(self.all.iter()).collect();
            for bytes in core.exchange_with_ranks(out) {
                bonds.extend(list_of(&bytes));
            }
            // Those that were here before come again from their own rank.
            bonds.sort_by_key(|(number, _)| *number);
            bonds.dedup_by_key(|(number, _)| *number);
        } else {
            bonds = (0..).zip(self.all.iter()).collect();
        }
        // News of this step stays: bonds of grains that left are broken.
        let mut share = before.unwrap_or_else(|| BondShare {
            next: bonds.len() as u32,
            ..BondShare::default()
        });
        bonds.retain(|(_, bond)| is_of(core, rank, bond));
        let place = |(number, bond): &(u32, Bond)| Place {
            number: *number,
            is_own: core.rank_of_row(bond.rows[0]) == rank,
        };
        share.places = bonds.iter().map(place).collect();
        self.share = Some(share);
        let bonds: Vec<Bond> = bonds.into_iter().map(|(_, bond)| bond).collect();
        self.all = Groups::new(&bonds);
        let own = core.own_rows();
        let is_own = |row: u32| own.contains(&(row as usize));
        self.candidates.retain(|pair| is_own(pair.rows[0]));
        self.near_walls.retain(|pair| is_own(pair[0]));
        if rank > 0 {
            // Files are written by the first rank.
            self.breaks.clear();
        }
        let of_offsets = self.offsets.iter().filter(|offset| !offset.is_wall);
        let of_offsets = of_offsets.map(|offset| offset.rows);
        let read = rows_of_others(&bonds, of_offsets, &is_own);
        core.read_rows(&read);
    }

    /// Takes the bonds that all ranks have glued now into the share of this one.
    pub(super) fn add_to_share(&mut self, bonds: &[Bond], core: &mut Core) {
        let rank = core.rank();
        let Some(share) = &mut self.share else {
            return;
        };
        let of_rank = (share.next..)
            .zip(bonds)
            .filter(|(_, bond)| is_of(core, rank, bond));
        let (numbers, new): (Vec<u32>, Vec<Bond>) =
            of_rank.map(|(number, bond)| (number, bond.clone())).unzip();
        share
            .places
            .extend(numbers.into_iter().zip(&new).map(|(number, bond)| Place {
                number,
                is_own: core.rank_of_row(bond.rows[0]) == rank,
            }));
        share.next += bonds.len() as u32;
        let own = core.own_rows();
        let is_own = |row: u32| own.contains(&(row as usize));
        let read = rows_of_others(&new, std::iter::empty(), &is_own);
        self.all = Groups::new(&self.all.iter().chain(new).collect::<Vec<_>>());
        core.read_rows(&read);
        core.note_readers();
    }

    /// Brings all bonds to the first rank.
    pub(super) fn collect(&mut self, core: &mut Core) {
        let Some(share) = &mut self.share else {
            return;
        };
        let mut bytes = Vec::new();
        let own: Vec<(u32, Bond)> = share.own(&self.all).collect();
        own.put(&mut bytes);
        self.candidates.put(&mut bytes);
        self.near_walls.put(&mut bytes);
        let came = core.gather_from_ranks(bytes);
        if came.is_empty() {
            return;
        }
        let (mut bonds, mut candidates, mut near_walls) = (Vec::new(), Vec::new(), Vec::new());
        for bytes in &came {
            let mut bytes = &bytes[..];
            let of_rank: Result<Vec<(u32, Bond)>, _> = Plain::take(&mut bytes);
            bonds.extend(of_rank.unwrap_or_default());
            let of_rank: Result<Vec<Candidate>, _> = Plain::take(&mut bytes);
            candidates.extend(of_rank.unwrap_or_default());
            let of_rank: Result<Vec<[u32; 2]>, _> = Plain::take(&mut bytes);
            near_walls.extend(of_rank.unwrap_or_default());
        }
        bonds.sort_by_key(|(number, _)| *number);
        let bonds: Vec<Bond> = bonds.into_iter().map(|(_, bond)| bond).collect();
        share.whole = Some(Whole {
            bonds: Groups::new(&bonds),
            candidates,
            near_walls,
        });
    }

    /// Sums of numbers that each rank has of its own bonds, in the order of all bonds: on the first rank, 0 on the others.
    pub(super) fn sum_of_own(&self, core: &mut Core, of: &[[f64; 3]]) -> [f64; 3] {
        let Some(share) = &self.share else {
            return sum(of.iter().copied());
        };
        let of_bonds = share.places.iter().zip(of);
        let own = of_bonds.filter(|(place, _)| place.is_own);
        let mut bytes = Vec::new();
        own.for_each(|(place, numbers)| (place.number, *numbers).put(&mut bytes));
        let came = core.gather_from_ranks(bytes);
        let mut all: Vec<(u32, [f64; 3])> = came.iter().flat_map(|bytes| list_of(bytes)).collect();
        all.sort_by_key(|(number, _)| *number);
        sum(all.into_iter().map(|(_, numbers)| numbers))
    }

    /// Takes the news of all ranks.
    pub(super) fn receive(
        &mut self,
        core: &mut Core,
        messages: &[Vec<u8>],
    ) -> Result<(), RunError> {
        let (mut broken, mut parted) = (Vec::new(), Vec::new());
        for mut bytes in messages.iter().map(|bytes| &bytes[..]) {
            let of_rank: Result<Vec<Broken>, _> = Plain::take(&mut bytes);
            broken.extend(of_rank.unwrap_or_default());
            let of_rank: Result<Vec<Pair>, _> = Plain::take(&mut bytes);
            parted.extend(of_rank.unwrap_or_default());
        }
        broken.sort_by_key(|broken| (broken.occasion, broken.number));
        for at_once in broken.chunk_by(|one, other| one.occasion == other.occasion) {
            let breaks: Vec<Break> = at_once.iter().map(|broken| broken.its.clone()).collect();
            self.loosen_offsets(&breaks);
            self.count(&breaks);
        }
        if core.rank() > 0 {
            self.breaks.clear();
        }
        // Rows that left are no longer among the pairs without contact.
        for broken in broken
            .iter()
            .filter(|broken| broken.occasion != Occasion::Leaving)
        {
            if self.is_alone(core, broken.its.plan) {
                (core.particles.unpaired).remove(broken.rows, broken.its.is_wall);
                core.lists_are_stale();
            }
        }
        if !parted.is_empty() {
            let parted: BTreeSet<Pair> = parted.into_iter().collect();
            (self.offsets).retain(|offset| !parted.contains(&(offset.is_wall, offset.ids)));
            self.inform_contacts(core.particles.len());
        }
        Ok(())
    }
}

fn sum(numbers: impl Iterator<Item = [f64; 3]>) -> [f64; 3] {
    numbers.fold([0.0; 3], |sum, one| {
        std::array::from_fn(|k| sum[k] + one[k])
    })
}

/// Values one after the other.
fn list_of<T: Plain>(mut bytes: &[u8]) -> Vec<T> {
    let mut list = Vec::new();
    while !bytes.is_empty()
        && let Ok(one) = T::take(&mut bytes)
    {
        list.push(one);
    }
    list
}

/// Rows of other ranks that bonds read, and those of pairs that have a row here.
fn rows_of_others(
    bonds: &[Bond],
    pairs: impl Iterator<Item = [u32; 2]>,
    is_own: &impl Fn(u32) -> bool,
) -> Vec<u32> {
    let of_bonds = bonds.iter().flat_map(|bond| {
        let ends = if bond.is_wall { 1 } else { 2 };
        bond.rows[..ends].iter().copied()
    });
    let of_pairs = pairs.filter(|rows| rows.iter().any(|&row| is_own(row)));
    let rows = of_bonds.chain(of_pairs.flatten());
    rows.filter(|&row| !is_own(row)).collect()
}

impl Plain for Occasion {
    fn put(&self, bytes: &mut Vec<u8>) {
        (*self as u8).put(bytes);
    }

    fn take(bytes: &mut &[u8]) -> Result<Self, String> {
        match u8::take(bytes)? {
            0 => Ok(Self::Leaving),
            1 => Ok(Self::WallGone),
            2 => Ok(Self::Strength),
            other => Err(format!("{other} is no occasion at which bonds break")),
        }
    }
}

crate::state::plain!(Broken {
    occasion,
    number,
    rows,
    its
});

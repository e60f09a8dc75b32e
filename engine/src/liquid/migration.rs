//! How liquid moves when bridges form and break.
//!
//! The rules are those of Mani et al. (2013), *Granular Matter* 15, 447, and Roy et al. (2018), *Phys. Rev. E* 98, 052906, with what
//! they leave open decided by the [theory page](../../docs/theory/liquid.md):
//!
//! - *A touch.* The films of both sides hold T together. If T > 0 and T >= the least volume, a bridge of min(T, largest volume) forms;
//!   each film gives in proportion. A pair that touches without enough liquid stays dry until it has parted.
//!   With [`BridgesForm::Films`] it forms as soon as the films meet, where it reaches across the gap.
//! - *A break.* Each end takes half (a particle at a wall all but the share that a wall with a film keeps), and hands the share
//!   `distribution` of it on to its other bridges in equal parts, each up to its own largest volume. The rest goes to the film of
//!   that end.
//!
//! A wall with a film takes part like a particle, with what the shadow of the grain covers of the triangle.
//!
//! Events of one step are answered in ascending order of (lower id, higher id); those of a particle at walls come after those with
//! its partners.

use std::collections::HashMap;

use super::weight::End;
use super::{BridgeSite, BridgesForm, LiquidNeighbours, Liquids};
use crate::contact::registry::LawTable;
use crate::contact::{Bridge, BridgeEvent, Liquid};
use crate::forces::{ContactEvent, Partner, SharedContacts, SlotPlace};
use crate::state::Particles;
use crate::walls::{WallFilms, WallNow, WallPlace};
use mercury_common::particle_properties::FILM_VOLUME;

/// Data that the rules read beside the particles, and the films of walls.
pub struct MigrationContext<'a> {
    /// The laws of all pairs of materials.
    pub laws: &'a LawTable,
    /// The walls as they are.
    pub walls: &'a [WallNow],
    /// Films of walls.
    pub films: &'a mut WallFilms,
}

/// Order of events and bridges: pairs by their ids, then walls.
type Order = (u32, bool, u32, u32, u32);

impl Liquids {
    /// Answers the events of the last force evaluation.
    pub fn answer(
        &mut self,
        contacts: &mut SharedContacts<'_>,
        particles: &mut Particles,
        around: &mut MigrationContext<'_>,
    ) {
        self.balance.set_free += std::mem::take(&mut self.balance.next_set_free);
        let mut events: Vec<ContactEvent<BridgeEvent, Bridge>> = contacts.events_of().to_vec();
        if events.is_empty() {
            return;
        }
        events.sort_by_cached_key(|event| order(particles, &event.contact));
        // Bridges at the ends of those that break may take their liquid.
        let breaking = events
            .iter()
            .filter(|event| event.event == BridgeEvent::End && event.contact.memory.volume > 0.0);
        let ends: Vec<u32> = breaking
            .flat_map(|event| rows_of(&event.contact))
            .flatten()
            .collect();
        let mut net = BridgeGraph::around(&ends, contacts, particles);
        if self.has_mass() {
            let of_events = events.iter().map(|event| &event.contact);
            let sites = of_events.chain(&net.bridges);
            contacts.complete(particles, sites.flat_map(rows_of).flatten());
        }
        for event in &events {
            match event.event {
                BridgeEvent::Touch => self.touch(&event.contact, &mut net, particles, around),
                BridgeEvent::End => {
                    let index = net.index_of(&event.contact);
                    let bridge = net.bridges[index].memory;
                    // What an earlier event gave may keep it.
                    let holds = event.contact.place.is_some()
                        && bridge.volume > 0.0
                        && bridge.gap < bridge.end;
                    if !holds {
                        self.rupture(index, &mut net, particles, around);
                    }
                }
            }
        }
        net.write_back(contacts);
    }

    /// Breaks the bridges of particles that are about to be removed, and counts the films that they take along; `by_face`: whether
    /// a row leaves through a face of the domain.
    pub fn release(
        &mut self,
        leavers: &[(u32, bool)],
        contacts: &mut SharedContacts<'_>,
        particles: &mut Particles,
        around: &mut MigrationContext<'_>,
    ) {
        let mut leaves = vec![false; particles.len()];
        for &(row, _) in leavers {
            leaves[row as usize] = true;
        }
        let mut breaking = contacts.memories_of::<Bridge>(&|row| leaves[row]);
        breaking.sort_by_cached_key(|site| order(particles, site));
        let ends: Vec<u32> = breaking.iter().flat_map(rows_of).flatten().collect();
        let mut net = BridgeGraph::around(&ends, contacts, particles);
        for site in &breaking {
            let index = net.index_of(site);
            self.rupture(index, &mut net, particles, around);
        }
        net.write_back(contacts);
        let Some(films) = particles.columns.get_mut(FILM_VOLUME.name) else {
            return;
        };
        for &(row, by_face) in leavers {
            let film = std::mem::take(&mut films[row as usize]);
            if by_face {
                self.balance.left.add(film);
            } else {
                self.balance.deleted.add(film);
            }
        }
    }

    /// A bridge forms, if there is liquid for it.
    fn touch(
        &mut self,
        site: &BridgeSite,
        net: &mut BridgeGraph,
        particles: &mut Particles,
        around: &mut MigrationContext<'_>,
    ) {
        let liquid = liquid_of(particles, around, site);
        let radii = radii_of(particles, site);
        let mut bridge = Bridge {
            wet: 1.0,
            ..site.memory
        };
        let Some(films) = particles.columns.get_mut(FILM_VOLUME.name) else {
            return;
        };
        let [a, b] = rows_of(site);
        let wall = self.wall_place(site, around);
        let film = |row: Option<u32>| row.map_or(0.0, |row| films[row as usize]);
        let of_wall = wall.map_or(0.0, |wall| around.films.within_reach(wall, radii[0]));
        let (of_a, of_b) = (film(a), film(b) + of_wall);
        let there = of_a + of_b;
        let gap = site.memory.gap;
        // Films that meet form a bridge that reaches across the gap, or none yet; a touch is remembered even if it stays dry.
        let is_apart = !site.touches;
        if is_apart {
            bridge = Bridge::default();
        }
        let reaches = !is_apart
            || (self.bridges_form == BridgesForm::Films
                && gap < liquid.end(there.min(liquid.max_volume), radii, &around.laws.tables));
        if there > 0.0 && there >= liquid.min_volume && reaches {
            let volume = there.min(liquid.max_volume);
            let [from_a, from_b] = if there <= liquid.max_volume {
                [of_a, of_b]
            } else {
                let from_a = volume * (of_a / there);
                [from_a, (volume - from_a).min(of_b)]
            };
            // The sum of both may be larger by round-off.
            let volume = (from_a + from_b).min(liquid.max_volume);
            if let Some(row) = a {
                films[row as usize] = of_a - from_a;
            }
            if let Some(row) = b {
                films[row as usize] = of_b - from_b;
            }
            if let Some(wall) = wall {
                around.films.set(wall, around.films.volume(wall) - from_b);
            }
            let to_a = if b.is_some() { 0.5 * volume } else { volume } - from_a;
            let (a, b) = (End::Row(site.row), b.map_or(End::Outside, End::Row));
            let (from, to) = if to_a > 0.0 { (b, a) } else { (a, b) };
            self.carry(particles, from, to, to_a.abs());
            bridge = liquid.fill(
                &Bridge { gap, ..bridge },
                volume,
                radii,
                &around.laws.tables,
            );
            self.note_clamped(&liquid, volume, radii, around);
            self.balance.formed += 1;
            self.balance.next_set_free -= liquid.energy_of(&bridge);
        }
        net.insert(
            BridgeSite {
                memory: bridge,
                ..*site
            },
            particles,
        );
    }

    /// Where a wall with a film holds the liquid of a bridge.
    fn wall_place(&self, site: &BridgeSite, around: &MigrationContext<'_>) -> Option<WallPlace> {
        match site.partner {
            Partner::Wall { wall, .. } => {
                around.films.place(wall.index(), site.feature, around.walls)
            }
            Partner::Particle { .. } => None,
        }
    }

    /// Counts a bridge that formed or took liquid and lies outside of the table of its law.
    pub(super) fn note_clamped(
        &mut self,
        liquid: &Liquid,
        volume: f64,
        radii: [f64; 2],
        around: &MigrationContext<'_>,
    ) {
        if liquid.is_clamped(volume, radii, &around.laws.tables) {
            self.balance.clamped += 1;
        }
    }

    /// A bridge breaks; it is forgotten.
    fn rupture(
        &mut self,
        index: usize,
        net: &mut BridgeGraph,
        particles: &mut Particles,
        around: &mut MigrationContext<'_>,
    ) {
        let site = net.bridges[index];
        net.set(index, Bridge::default());
        let volume = site.memory.volume;
        if volume <= 0.0 {
            return;
        }
        self.balance.ruptured += 1;
        let at_wall = matches!(site.partner, Partner::Wall { .. });
        let share = liquid_of(particles, around, &site).distribution;
        let mut half = if at_wall { volume } else { 0.5 * volume };
        let mut rest = volume - half;
        if let Some(wall) = self.wall_place(&site, around) {
            let held = around.films.volume(wall);
            let holds = held + around.films.keeps(wall) * volume;
            around.films.set(wall, holds);
            // Round-off of the addition stays with the particle.
            (half, rest) = (volume - (holds - held), 0.0);
            self.carry(particles, End::Row(site.row), End::Outside, holds - held);
        }
        for (end, part) in rows_of(&site).into_iter().zip([half, rest]) {
            if let Some(row) = end {
                self.hand_on(row, part, share, at_wall, index, net, particles, around);
            }
        }
    }

    /// One end of a broken bridge hands its part on.
    fn hand_on(
        &mut self,
        row: u32,
        part: f64,
        share: f64,
        at_wall: bool,
        index: usize,
        net: &mut BridgeGraph,
        particles: &mut Particles,
        around: &MigrationContext<'_>,
    ) {
        let same_kind = self.neighbours == LiquidNeighbours::SameKind && !at_wall;
        let takers: Vec<usize> = (net.at_row.get(&row).into_iter().flatten().copied())
            .filter(|&other| {
                let site = &net.bridges[other];
                other != index
                    && site.memory.volume > 0.0
                    && !(same_kind && matches!(site.partner, Partner::Wall { .. }))
            })
            .collect();
        let (mut rest, mut held_by_all) = (part, 0.0);
        let portion = share * part / takers.len().max(1) as f64;
        for other in takers {
            let site = net.bridges[other];
            let liquid = liquid_of(particles, around, &site);
            let held = site.memory.volume;
            let volume = (held + portion.min(rest)).min(liquid.max_volume).max(held);
            rest -= volume - held;
            held_by_all += volume;
            let radii = radii_of(particles, &site);
            let bridge = liquid.fill(&site.memory, volume, radii, &around.laws.tables);
            self.note_clamped(&liquid, volume, radii, around);
            if let Partner::Particle { row: partner, .. } = site.partner {
                let far = if partner == row { site.row } else { partner };
                let half = 0.5 * (volume - held);
                self.carry(particles, End::Row(row), End::Row(far), half);
            }
            self.balance.next_set_free +=
                liquid.energy_of(&site.memory) - liquid.energy_of(&bridge);
            net.set(other, bridge);
        }
        // Round-off of the sums is no liquid: a film of it would form bridges that hold nothing.
        if rest > f64::EPSILON * held_by_all
            && let Some(films) = particles.columns.get_mut(FILM_VOLUME.name)
        {
            films[row as usize] += rest;
        }
    }
}

/// The bridges that a step may change, and where they end.
struct BridgeGraph {
    bridges: Vec<BridgeSite>,
    changed: Vec<bool>,
    of_place: HashMap<(u32, u32, bool), usize>,
    /// Bridges of each row that matters, in order.
    at_row: HashMap<u32, Vec<usize>>,
}

impl BridgeGraph {
    /// The bridges at these rows.
    fn around(rows: &[u32], contacts: &mut SharedContacts<'_>, particles: &Particles) -> Self {
        let mut net = Self {
            bridges: Vec::new(),
            changed: Vec::new(),
            of_place: HashMap::new(),
            at_row: HashMap::new(),
        };
        if rows.is_empty() {
            return net;
        }
        let mut wanted = vec![false; particles.len()];
        for &row in rows {
            wanted[row as usize] = true;
        }
        let mut bridges = contacts.memories_of::<Bridge>(&|row| wanted[row]);
        bridges.sort_by_cached_key(|site| order(particles, site));
        for site in bridges {
            net.append(site);
        }
        net
    }

    fn append(&mut self, site: BridgeSite) -> usize {
        let index = self.bridges.len();
        if let Some(place) = site.place {
            self.of_place.insert(key(&place), index);
        }
        for row in rows_of(&site).into_iter().flatten() {
            self.at_row.entry(row).or_default().push(index);
        }
        self.bridges.push(site);
        self.changed.push(false);
        index
    }

    /// A bridge that has formed, at its place in the order of its ends.
    fn insert(&mut self, site: BridgeSite, particles: &Particles) {
        let index = self.append(site);
        self.changed[index] = true;
        for row in rows_of(&site).into_iter().flatten() {
            let bridges = &self.bridges;
            if let Some(at_row) = self.at_row.get_mut(&row) {
                at_row.sort_by_cached_key(|&other| order(particles, &bridges[other]));
            }
        }
    }

    /// The number of a bridge; it is taken in where it was not known.
    fn index_of(&mut self, site: &BridgeSite) -> usize {
        let known = site.place.and_then(|place| self.of_place.get(&key(&place)));
        match known {
            Some(&index) => index,
            None => self.append(*site),
        }
    }

    fn set(&mut self, index: usize, bridge: Bridge) {
        self.bridges[index].memory = bridge;
        self.changed[index] = true;
    }

    fn write_back(&self, contacts: &mut SharedContacts<'_>) {
        for (site, _) in self
            .bridges
            .iter()
            .zip(&self.changed)
            .filter(|(_, changed)| **changed)
        {
            if let Some(place) = &site.place {
                contacts.set_memory(place, &site.memory);
            }
        }
    }
}

fn key(place: &SlotPlace) -> (u32, u32, bool) {
    place.numbers()
}

/// The rows at both ends; `None` for a wall.
fn rows_of(site: &BridgeSite) -> [Option<u32>; 2] {
    match site.partner {
        Partner::Particle { row, .. } => [Some(site.row), Some(row)],
        Partner::Wall { .. } => [Some(site.row), None],
    }
}

/// Radii of both sides, m; infinite for a wall.
pub(super) fn radii_of(particles: &Particles, site: &BridgeSite) -> [f64; 2] {
    rows_of(site).map(|row| row.map_or(f64::INFINITY, |row| particles.records[row as usize].radius))
}

/// The law of the bridge.
pub(super) fn liquid_of(
    particles: &Particles,
    around: &MigrationContext<'_>,
    site: &BridgeSite,
) -> Liquid {
    let material = |row: u32| particles.records[row as usize].material.number();
    let other = match site.partner {
        Partner::Particle { row, .. } => material(row),
        Partner::Wall { wall, .. } => around.walls[wall.index()].material.number(),
    };
    let law = around.laws.get(material(site.row), other);
    law.and_then(|law| law.adhesion.liquid().copied())
        .unwrap_or(Liquid::NONE)
}

fn order(particles: &Particles, site: &BridgeSite) -> Order {
    let id = |row: u32| particles.ids[row as usize].number();
    let slot = site.place.map_or(0, |place| place.numbers().1);
    match site.partner {
        Partner::Particle { row, image } => {
            let (a, b) = (id(site.row), id(row));
            (a.min(b), false, a.max(b), image, 0)
        }
        // Slots of one particle at one wall stand in the order in which features were met.
        Partner::Wall { wall, image } => {
            (id(site.row), true, u32::from(wall.number()), image, slot)
        }
    }
}

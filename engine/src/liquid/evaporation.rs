//! Liquid that evaporates.

use std::f64::consts::PI;

use super::migration::{liquid_of, radii_of};
use super::weight::{End, shares};
use super::{Liquids, MigrationContext, film_thickness};
use crate::contact::Bridge;
use crate::forces::SharedContacts;
use crate::state::Particles;
use mercury_common::particle_properties::FILM_VOLUME;

/// Liquid evaporates once in so many steps, for all of them: what goes in one of them is far below what a film holds.
pub const EVERY: u64 = 32;

impl Liquids {
    /// Lets liquid evaporate for `time` (s), by its free surface: films over 4 pi (R + h)^2, bridges over their lateral area at the gap of the
    /// last force evaluation, films on walls over their triangles. A bridge that dries up is gone; two that still touch stay dry until
    /// they have parted.
    pub fn evaporate(
        &mut self,
        time: f64,
        contacts: &mut SharedContacts<'_>,
        particles: &mut Particles,
        around: &mut MigrationContext<'_>,
    ) {
        let depth = self.evaporation * time;
        if depth <= 0.0 {
            return;
        }
        if self.has_mass() {
            contacts.complete_all(particles);
        }
        for row in 0..particles.len() {
            let radius = particles.records[row].radius;
            let films = particles
                .columns
                .get_mut(FILM_VOLUME.name)
                .unwrap_or_default();
            let Some(film) = films.get_mut(row).filter(|film| **film > 0.0) else {
                continue;
            };
            let (before, outer) = (*film, radius + film_thickness(*film, radius));
            *film = (before - 4.0 * PI * outer * outer * depth).max(0.0);
            let lost = before - *film;
            self.balance.evaporated.add(lost);
            self.carry(particles, End::Row(row as u32), End::Outside, lost);
        }
        let gone = &mut self.balance.evaporated;
        around.films.shrink(depth, |volume| gone.add(volume));
        let tables = &around.laws.tables;
        for site in contacts.memories_of::<Bridge>(&|_| true) {
            let Some(place) = site.place else {
                continue;
            };
            let liquid = liquid_of(particles, around, &site);
            let radii = radii_of(particles, &site);
            let before = site.memory.volume;
            let left = before - liquid.area(&site.memory, radii, tables) * depth;
            let bridge = if left > 0.0 {
                self.note_clamped(&liquid, left, radii, around);
                liquid.fill(&site.memory, left, radii, tables)
            } else if site.touches {
                Bridge {
                    wet: 1.0,
                    gap: site.memory.gap,
                    ..Bridge::default()
                }
            } else {
                Bridge::default()
            };
            self.balance.evaporated.add(before - bridge.volume);
            let ends = shares(&site, &site.memory)
                .into_iter()
                .zip(shares(&site, &bridge));
            for ((end, held), (_, holds)) in ends {
                self.carry(particles, end, End::Outside, held - holds);
            }
            self.balance.next_set_free +=
                liquid.energy_of(&site.memory) - liquid.energy_of(&bridge);
            self.balance.dried += u64::from(bridge.volume == 0.0);
            contacts.set_memory(&place, &bridge);
        }
    }
}

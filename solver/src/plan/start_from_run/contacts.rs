//! Contacts of other runs in this scene, and the liquid of those that do not go on.

use std::collections::BTreeMap;

use mercury_common::readable::{printable, rounded};

use super::{Earlier, Grain};
use crate::plan::NewBody;
use crate::plan::particles::StartingParticles;
use mercury_engine::bodies::Clump;
use mercury_engine::contact::adhesion::liquid::{saved_numbers, saved_volume};
use mercury_engine::contact::parameter::short;
use mercury_engine::contact::registry::LawTable;
use mercury_engine::forces::{SavedSlot, SavedSlots, SlotState, contact_loop};
use mercury_engine::liquid::Sum;
use mercury_engine::physics::Carried;
use mercury_engine::walls::{Wall, WallFilmPlan, film_at};

/// The data that the translation of a scene's contacts needs.
pub(in crate::plan) struct Here<'a> {
    /// Particles of this scene.
    pub(in crate::plan) particles: usize,
    /// Its bodies.
    pub(in crate::plan) bodies: &'a [NewBody],
    pub(in crate::plan) clumps: &'a [Clump],
    pub(in crate::plan) walls: &'a [Wall],
    /// Films of its walls.
    pub(in crate::plan) wall_films: &'a [Option<WallFilmPlan>],
    pub(in crate::plan) laws: &'a LawTable,
}

impl Here<'_> {
    /// The first id of each body: they follow those of the particles.
    fn first_pebbles(&self) -> Vec<usize> {
        let mut next = self.particles;
        let first = |body: &NewBody| {
            let first = next;
            next += self.clumps[body.clump as usize].pebbles.len();
            first
        };
        self.bodies.iter().map(first).collect()
    }
}

/// Liquid of bridges that do not go on.
#[derive(Debug, Default)]
pub(in crate::plan) struct Released {
    /// By the number of the particle in this scene, m^3.
    particles: BTreeMap<usize, Sum>,
    /// By that of the body.
    bodies: BTreeMap<usize, Sum>,
    /// By the wall and the place on it.
    walls: BTreeMap<(usize, usize), Sum>,
}

impl Released {
    fn give_grain(&mut self, run: &Earlier, row: u32, volume: f64) {
        let sum = match run.rows[row as usize].grain {
            Grain::Particle(index) => self.particles.entry(run.first.0 + index),
            Grain::Pebble(body, _) => self.bodies.entry(run.first.1 + body),
        };
        sum.or_default().add(volume);
    }

    /// A grain at a wall takes all but what a film of the wall keeps.
    fn at_wall(
        &mut self,
        run: &Earlier,
        here: &Here<'_>,
        slot: &SavedSlot<'_>,
        wall: Option<usize>,
        volume: f64,
    ) {
        let film = wall.and_then(|wall| {
            let film = here.wall_films.get(wall)?.as_ref()?;
            let place = film_at(&here.walls[wall].shape, slot.feature)?;
            (place < film.volumes.len()).then_some((wall, place, film.keeps))
        });
        let kept = film.map_or(0.0, |(.., keeps)| keeps * volume);
        if let Some((wall, place, _)) = film {
            self.walls.entry((wall, place)).or_default().add(kept);
        }
        self.give_grain(run, slot.row, volume - kept);
    }

    /// Adds it to the films of the start.
    pub(in crate::plan) fn pour(
        self,
        start: &mut StartingParticles,
        wall_films: &mut [Option<WallFilmPlan>],
    ) {
        let grains = |sums: BTreeMap<usize, Sum>| {
            let values = sums.into_iter();
            values.map(|(number, sum)| (number, sum.value()))
        };
        start.add_films(grains(self.particles), grains(self.bodies));
        for ((wall, place), sum) in self.walls {
            if let Some(Some(film)) = wall_films.get_mut(wall) {
                film.volumes[place] += sum.value();
            }
        }
    }
}

/// The contacts of all runs in `earlier` in this scene, and the liquid of those that do not go on; a remark on each run, and a warning of
/// liquid that is lost. No contacts if there is no such run.
pub(in crate::plan) fn carried(
    earlier: &[Earlier],
    here: &Here<'_>,
    remarks: &mut Vec<String>,
    warnings: &mut Vec<String>,
) -> (Option<Carried>, Released) {
    let mut released = Released::default();
    if earlier.is_empty() {
        return (None, released);
    }
    let numbers = contact_loop(here.laws).0.layout().numbers;
    let first_pebbles = here.first_pebbles();
    let names = here.laws.names_of_pairs();
    let (mut pairs, mut near_walls): (Vec<SavedSlot<'_>>, Vec<SavedSlot<'_>>) =
        (Vec::new(), Vec::new());
    for run in earlier {
        let row = |row: u32| match run.rows[row as usize].grain {
            Grain::Particle(index) => run.first.0 + index,
            Grain::Pebble(body, pebble) => first_pebbles[run.first.1 + body] + pebble,
        } as u32;
        // Histories go on under laws of the same names; the numbers in these may be others.
        let is_alike = |[a, b]: [usize; 2], [here_a, here_b]: [usize; 2]| {
            let then = &run.head.laws[a * run.head.materials.len() + b];
            !then.is_empty() && names[here_a * here.laws.materials + here_b] == *then
        };
        let (mut kept, mut anew) = (0u64, 0u64);
        let of_bridge = saved_numbers(run.head.laws.iter().map(String::as_str));
        let (mut bridges, mut liquid) = (0u64, Sum::default());
        let mut ended = |slot: &SavedSlot<'_>| {
            let volume = saved_volume(slot.history, of_bridge);
            bridges += u64::from(volume > 0.0);
            liquid.add(volume);
            volume
        };
        for slot in run
            .pairs
            .iter()
            .filter(|slot| slot.state != SlotState::Near)
        {
            let [a, b] = [slot.row, slot.partner].map(|row| run.rows[row as usize].material);
            if run.pairs.numbers() != numbers || !is_alike([a[0], b[0]], [a[1], b[1]]) {
                anew += 1;
                let volume = ended(&slot);
                if volume > 0.0 {
                    let half = 0.5 * volume;
                    released.give_grain(run, slot.row, half);
                    released.give_grain(run, slot.partner, volume - half);
                }
                continue;
            }
            kept += 1;
            pairs.push(SavedSlot {
                row: row(slot.row),
                partner: row(slot.partner),
                ..slot
            });
        }
        let walls: Vec<Option<usize>> = (run.head.walls.iter())
            .map(|(name, numbering)| {
                here.walls.iter().position(|wall| {
                    wall.name == *name && wall.shape.feature_numbering() == *numbering
                })
            })
            .collect();
        for slot in (run.near_walls.iter()).filter(|slot| slot.state != SlotState::Near) {
            let [material, here_material] = run.rows[slot.row as usize].material;
            // Behind the walls come membranes, which are others here.
            let found = walls.get(slot.partner as usize).copied().flatten();
            let wall = found.filter(|&wall| {
                let of_wall = here.walls[wall].material.index();
                let there = run.head.wall_materials[slot.partner as usize] as usize;
                run.near_walls.numbers() == numbers
                    && is_alike([material, there], [here_material, of_wall])
            });
            let Some(wall) = wall else {
                anew += 1;
                let volume = ended(&slot);
                if volume > 0.0 {
                    released.at_wall(run, here, &slot, found, volume);
                }
                continue;
            };
            kept += 1;
            near_walls.push(SavedSlot {
                row: row(slot.row),
                partner: wall as u32,
                ..slot
            });
        }
        let mut remark = format!(
            "{}: {} particles and {} bodies of `{}` at t = {} s, {kept} contacts go on",
            run.key,
            run.particles.len(),
            run.bodies.len(),
            printable(&run.head.title),
            rounded(run.head.time(), 12)
        );
        if anew > 0 {
            remark += &format!(", {anew} begin anew: their law or their wall is another one here");
        }
        if bridges > 0 {
            remark += &format!(
                "; the liquid of {bridges} bridges among these, {} m3, goes to the films of their grains and walls",
                short(liquid.value())
            );
        }
        if run.is_frame {
            remark += "; a frame has no contacts, all begin anew";
        }
        remarks.push(remark);
        warnings.extend(run.liquid_left.warning(&run.key));
    }
    let sorted = |mut slots: Vec<SavedSlot<'_>>, like: &SavedSlots| {
        slots.sort_by_key(|slot| (slot.row, slot.partner, slot.image));
        let mut all = like.emptied();
        all.reserve(slots.len());
        for slot in slots {
            all.push_whole(slot);
        }
        all
    };
    // All that were kept have histories of the same length.
    let like = (earlier.iter()).find(|run| run.pairs.numbers() == numbers);
    let carried = like.map(|like| Carried {
        pairs: sorted(pairs, &like.pairs),
        near_walls: sorted(near_walls, &like.near_walls),
    });
    (carried, released)
}

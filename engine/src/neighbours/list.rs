//! The candidate list: every pair that may touch before the list is built again.

use std::ops::Range;

use bytemuck::Zeroable;
use bytemuck::allocation::zeroed_vec;
use glam::DVec3;

use super::grid::{LaterLines, MOST_RUNS, bounds};
use super::other_pairs::OtherPairs;
use super::{Exclusions, Grid, Levels, Margin};
use crate::cell::{Cell, NO_SHIFT};
use crate::memory::GROWTH;
use crate::parallel::{change_each, each, each_part, map_parts};
use crate::state::{Particle, Particles, Row};

/// A listed partner of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable)]
pub struct Candidate {
    /// Row of the partner; larger than the row that owns the entry.
    pub partner: u32,
    /// Code of the partner's image that is near ([`Cell::shift`]).
    pub image: u32,
}

/// Half list in rows: `entries[start[i]..start[i + 1]]` are the partners of row `i`, each pair once.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct CandidateList {
    /// First entry of each row, and the number of entries at the end.
    pub start: Vec<u32>,
    /// Partners.
    pub entries: Vec<Candidate>,
}

impl CandidateList {
    /// Drops the pairs that have no contact.
    fn leave_out(&mut self, exclusions: &Exclusions<'_>) {
        if exclusions.is_empty() {
            return;
        }
        let (mut kept, mut begin) = (0, 0);
        for row in 0..self.start.len() - 1 {
            let end = self.start[row + 1] as usize;
            for k in begin..end {
                let entry = self.entries[k];
                if !exclusions.excludes(row, entry.partner as usize) {
                    self.entries[kept] = entry;
                    kept += 1;
                }
            }
            begin = end;
            self.start[row + 1] = kept as u32;
        }
        self.entries.truncate(kept);
    }
}

/// The result of building a list.
pub struct Built {
    /// The pairs.
    pub list: CandidateList,
    /// The new place of each old row: `new_row[old]`.
    pub new_row: Vec<Row>,
    /// The cells by which the rows are sorted now.
    pub grid: Grid,
}

/// Sorts the particles into cells (in place, wrapped into periodic domains) and lists every pair closer than
/// R_i + R_j + s_i + s_j + l_i + l_j (m), s the shares of `margin`, except pairs that contacts cannot move and those that [`Exclusions`] name. `extra`: l of
/// each row, or empty if all are 0; put into the new order. `levels`: which particles are sought together; the
/// list is the same with any. `parallel`: with the threads of the pool from within which it is called; the list is the same.
///
/// Requires finite positions, and periodic edges of at least twice the largest listing distance.
#[must_use]
pub fn build(
    particles: &mut Particles,
    extra: &mut Vec<f64>,
    levels: &Levels,
    margin: &Margin,
    domain: &Cell,
    parallel: bool,
) -> Built {
    let common = Common::find(particles, extra, levels, margin, domain, parallel);
    let (grid, new_row) = common.order(particles, extra);
    Built {
        list: common.list(particles, extra, &grid, 0..particles.len()),
        new_row,
        grid,
    }
}

/// Numbers of all particles together, from which the order of the rows and the search for pairs follow.
pub struct Common<'a> {
    levels: &'a Levels,
    margin: &'a Margin,
    domain: &'a Cell,
    parallel: bool,
    /// The smallest box along the axes that holds all positions, m.
    bounds: [DVec3; 2],
    /// Largest listing radius of the particles with extra skin, m.
    most_of_few: Option<f64>,
}

impl<'a> Common<'a> {
    /// Puts all particles into the periodic domain, and finds the numbers. Arguments as of [`build`].
    pub fn find(
        particles: &mut Particles,
        extra: &[f64],
        levels: &'a Levels,
        margin: &'a Margin,
        domain: &'a Cell,
        parallel: bool,
    ) -> Self {
        change_each(&mut particles.records, parallel, |_, record| {
            record.position = domain.wrap(record.position);
        });
        let records = &particles.records;
        let few = (0..extra.len()).filter(|&row| extra[row] > 0.0);
        let reach = |row: usize| records[row].radius + (margin.share(&records[row]) + extra[row]);
        Self {
            levels,
            margin,
            domain,
            parallel,
            bounds: bounds(records.len(), &|row| records[row].position, parallel),
            most_of_few: few.map(reach).reduce(f64::max),
        }
    }

    /// Sorts the particles into cells; returns the cells and the new place of each old row.
    pub fn order(&self, particles: &mut Particles, extra: &mut Vec<f64>) -> (Grid, Vec<Row>) {
        let cell = 2.0 * (self.levels.largest[0] + 0.5 * self.margin.largest());
        let records = &particles.records;
        let position = |row: usize| records[row].position;
        let (count, bounds) = (records.len(), self.bounds);
        let (grid, order) =
            Grid::sort_within(count, position, bounds, cell, self.domain, self.parallel);
        particles.reorder(&order, self.parallel);
        let mut new_row = vec![Row::new(0); order.len()];
        for (new, &old) in order.iter().enumerate() {
            new_row[old as usize] = Row::new(new);
        }
        let records = &particles.records;
        change_each(&mut particles.listed_at, self.parallel, |row, listed| {
            *listed = records[row].position;
        });
        if !extra.is_empty() {
            *extra = each(order.len(), self.parallel, |new| extra[order[new] as usize]);
        }
        (grid, new_row)
    }

    /// Lists the pairs of sorted particles whose lower row is one of `rows`, and perhaps of some beside these.
    #[must_use]
    pub fn list(
        &self,
        particles: &Particles,
        extra: &[f64],
        grid: &Grid,
        rows: Range<usize>,
    ) -> CandidateList {
        let members = Members::about(&rows, grid, &particles.records, extra, self);
        let mut list = list(&members, grid, self.domain, &rows, self.parallel);
        list.leave_out(&Exclusions::of(particles));
        list
    }
}

/// Bytes of a candidate list of this many pairs, for estimates of memory.
#[must_use]
pub fn list_bytes(rows: f64, pairs: f64) -> f64 {
    rows * size_of::<u32>() as f64 + pairs * size_of::<Candidate>() as f64
}

/// Bytes that [`build`] needs at most beside the particles, its result among them.
#[must_use]
pub fn build_bytes(rows: f64, pairs: f64) -> f64 {
    // The search: members and their level, those of the lowest level alone, old and new rows, about one cell for each row.
    let search = 2 * size_of::<Spot>() + size_of::<u8>() + 3 * size_of::<u32>();
    // The layers grow apart, each to its own length, and are put together.
    rows * search as f64 + (1.0 + GROWTH) * list_bytes(rows, pairs)
}

/// The particles in the form that the search needs.
pub(super) struct Members {
    /// Runs of the rows that are filled in, ascending: those that may be in pairs of the rows whose list is made, and some beside them.
    pub(super) rows: Vec<Range<usize>>,
    /// All of them, with radii that include their shares of the margin.
    pub(super) all: Vec<Spot>,
    /// The level of each. Particles with extra skin have a level of their own, the highest: they are few, and
    /// their reach must not widen the cells of all others.
    pub(super) level: Vec<u8>,
    /// Largest radius of each level, m, shares included.
    pub(super) largest: Vec<f64>,
}

impl Members {
    /// Those that may be near some of the sorted rows, directly or through periodic faces.
    fn about(
        own_rows: &Range<usize>,
        grid: &Grid,
        records: &[Particle],
        extra: &[f64],
        common: &Common<'_>,
    ) -> Self {
        let Common {
            levels,
            margin,
            domain,
            parallel,
            ..
        } = *common;
        let own = levels.largest.len();
        let extra = |row: usize| extra.get(row).copied().unwrap_or_default();
        let reach = |row: usize| records[row].radius + (margin.share(&records[row]) + extra(row));
        let level = |row: usize| {
            if extra(row) > 0.0 {
                own
            } else {
                levels.of(records[row].radius)
            }
        };
        let spot = |row: usize| {
            let fixed = records[row].inverse_mass == 0.0;
            Spot {
                position: records[row].position.to_array(),
                radius: if fixed { -reach(row) } else { reach(row) },
            }
        };
        let of_levels = levels.largest.iter();
        let mut largest: Vec<f64> = of_levels
            .map(|radius| radius + 0.5 * margin.largest())
            .collect();
        largest.extend(common.most_of_few);
        let count = records.len();
        let rows = if *own_rows == (0..count) {
            std::iter::once(0..count).collect()
        } else {
            let place = |k: usize| records[own_rows.start + k].position;
            let bounds = bounds(own_rows.len(), &place, parallel);
            let reach = 2.0 * largest.iter().copied().fold(0.0, f64::max);
            let images = [NO_SHIFT].into_iter().chain(domain.images());
            let mut runs: Vec<Range<usize>> = images
                .filter(|_| !own_rows.is_empty())
                .map(|image| bounds.map(|corner| corner + domain.shift(image)))
                .flat_map(|bounds| grid.rows_about(bounds, reach))
                .collect();
            runs.sort_unstable_by_key(|run| run.start);
            runs.dedup();
            joined(runs)
        };
        let mut members = Self {
            all: zeroed_vec(count),
            level: zeroed_vec(count),
            largest,
            rows,
        };
        for run in &members.rows {
            change_each(&mut members.all[run.clone()], parallel, |k, one| {
                *one = spot(run.start + k);
            });
            change_each(&mut members.level[run.clone()], parallel, |k, one| {
                *one = level(run.start + k) as u8;
            });
        }
        members
    }

    /// The members of the lowest level; those of higher ones are near nothing here: NaN compares false.
    fn of_lowest_level(&self, parallel: bool) -> Vec<Spot> {
        let mut spots: Vec<Spot> = zeroed_vec(self.all.len());
        for run in &self.rows {
            change_each(&mut spots[run.clone()], parallel, |k, spot| {
                let row = run.start + k;
                *spot = self.all[row];
                if self.level[row] != 0 {
                    spot.radius = f64::NAN;
                }
            });
        }
        spots
    }
}

/// Runs of rows, ascending and apart, with those in one that follow each other.
fn joined(runs: Vec<Range<usize>>) -> Vec<Range<usize>> {
    let mut all: Vec<Range<usize>> = Vec::new();
    for run in runs {
        match all.last_mut() {
            Some(last) if last.end == run.start => last.end = run.end,
            _ => all.push(run),
        }
    }
    all
}

/// Lists the pairs of sorted particles.
///
/// The partners of a row in later cells lie in a few runs of rows: the rest of its own cell with the next one, and three
/// neighbouring cells in each later one of the neighbouring lines of cells. That is for particles of the lowest level; the others are few.
fn list(
    members: &Members,
    grid: &Grid,
    domain: &Cell,
    rows: &Range<usize>,
    parallel: bool,
) -> CandidateList {
    let spots = members.of_lowest_level(parallel);
    let through = OtherPairs::find(members, grid, domain, parallel);
    let parts = grid.parts();
    let of_part = |(brick, layers): &(usize, Range<usize>)| {
        let of_part = grid.rows_of_part(*brick, layers);
        if of_part.end <= rows.start || of_part.start >= rows.end {
            return CandidateList {
                start: vec![0; of_part.len()],
                entries: Vec::new(),
            };
        }
        list_of_part(&spots, grid, *brick, layers.clone(), &through)
    };
    put_together(map_parts(parallel, &parts, of_part), parallel)
}

/// The lists of parts of the grid, one behind the other; the `start` of each holds the ends of its rows alone.
fn put_together(parts: Vec<CandidateList>, parallel: bool) -> CandidateList {
    let rows: usize = parts.iter().map(|part| part.start.len()).sum();
    let entries = parts.iter().map(|part| part.entries.len()).sum();
    let mut whole = CandidateList {
        start: vec![0; rows + 1],
        entries: zeroed_vec(entries),
    };
    let (mut starts, mut entries, mut before) = (&mut whole.start[1..], &mut whole.entries[..], 0);
    let mut places = Vec::with_capacity(parts.len());
    for part in parts {
        let (own_starts, own_entries);
        (own_starts, starts) = starts.split_at_mut(part.start.len());
        (own_entries, entries) = entries.split_at_mut(part.entries.len());
        let first = before;
        before += part.entries.len() as u32;
        places.push((part, first, own_starts, own_entries));
    }
    let put =
        |(part, first, starts, entries): (CandidateList, u32, &mut [u32], &mut [Candidate])| {
            for (start, end) in starts.iter_mut().zip(&part.start) {
                *start = first + end;
            }
            entries.copy_from_slice(&part.entries);
        };
    each_part(parallel, places, put);
    whole
}

/// The part of the list that belongs to the rows of some layers of a brick; `start` holds the ends of the rows alone.
fn list_of_part(
    spots: &[Spot],
    grid: &Grid,
    brick: usize,
    layers: Range<usize>,
    through: &OtherPairs,
) -> CandidateList {
    let [fast, lines, _] = grid.cells_of_brick();
    let (mut start, mut list) = (Vec::new(), Growing::default());
    let first = grid.line(brick, 0, layers.start);
    let mut through = through.from(grid.rows(first, first).start as u32);
    let around = grid.around(brick);
    let mut later = LaterLines::default();
    for (c, b) in layers.flat_map(|c| (0..lines).map(move |b| (c, b))) {
        let line = grid.line(brick, b, c);
        grid.later_lines(brick, &around, (b, c), &mut later);
        for a in 0..fast {
            let cell = a + line;
            let own = grid.rows(cell, cell);
            if own.is_empty() {
                continue;
            }
            let (left, right) = (a.saturating_sub(1), (a + 1).min(fast - 1));
            let (mut runs, mut count) = ([const { 0..0 }; MOST_RUNS], 0);
            let mut add = |run: Range<usize>| {
                runs[count] = run;
                count += usize::from(!runs[count].is_empty());
            };
            for line in &later.lines {
                add(grid.rows(line + left, line + right));
            }
            if a == 0 {
                later
                    .before
                    .iter()
                    .for_each(|&cell| add(grid.rows(cell, cell)));
            }
            if a + 1 == fast {
                later
                    .behind
                    .iter()
                    .for_each(|&cell| add(grid.rows(cell, cell)));
            }
            let end = grid.rows(cell, cell + right - a).end;
            for row in own {
                let spot = spots[row];
                list.scan(spots, spot, row + 1..end);
                for run in &runs[..count] {
                    list.scan(spots, spot, run.clone());
                }
                while let Some(&(_, candidate)) =
                    through.first().filter(|pair| pair.0 == row as u32)
                {
                    list.push(candidate);
                    through = &through[1..];
                }
                start.push(list.count as u32);
            }
        }
    }
    let mut entries = list.entries;
    entries.truncate(list.count);
    CandidateList { start, entries }
}

/// Position and radius; the radius of a particle that contacts cannot move is negated.
#[derive(Clone, Copy, Zeroable)]
pub(super) struct Spot {
    pub(super) position: [f64; 3],
    pub(super) radius: f64,
}

/// Entries of a list that grows without a branch for each: entries behind `count` are scratch space.
#[derive(Default)]
struct Growing {
    entries: Vec<Candidate>,
    count: usize,
}

impl Growing {
    /// Reserves memory for `more` entries at once.
    #[inline]
    fn reserve(&mut self, more: usize) -> &mut [Candidate] {
        let needed = self.count + more;
        if self.entries.len() < needed {
            let nothing = Candidate {
                partner: 0,
                image: NO_SHIFT,
            };
            self.entries
                .resize(needed.max(2 * self.entries.len()), nothing);
        }
        &mut self.entries[self.count..needed]
    }

    /// Appends the partners among the rows `run`. Few of the tested rows are near, in no predictable order: each is written, and
    /// overwritten by the next if it is not near.
    #[inline]
    fn scan(&mut self, spots: &[Spot], spot: Spot, run: Range<usize>) {
        let (first, others) = (run.start, &spots[run]);
        let room = self.reserve(others.len());
        let mut found = 0;
        for (k, other) in others.iter().enumerate() {
            room[found] = Candidate {
                partner: (first + k) as u32,
                image: NO_SHIFT,
            };
            found += usize::from(near(spot, other.position, other.radius));
        }
        self.count += found;
    }

    fn push(&mut self, candidate: Candidate) {
        self.reserve(1)[0] = candidate;
        self.count += 1;
    }
}

/// Whether two particles are closer than the sum of their radii, which include the skin, and can be moved.
#[inline]
pub(super) fn near(spot: Spot, position: [f64; 3], radius: f64) -> bool {
    let [x, y, z] = [
        spot.position[0] - position[0],
        spot.position[1] - position[1],
        spot.position[2] - position[2],
    ];
    let distance = spot.radius.abs() + radius.abs();
    (x * x + y * y + z * z < distance * distance) & ((spot.radius > 0.0) | (radius > 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::{FIXED, MaterialIndex};
    use proptest::prelude::*;

    fn cloud(seed: u64, count: usize, size: DVec3, ratio: f64, fixed_every: usize) -> Particles {
        let mut random = mercury_common::random::Stream::new(seed, "list test", 0);
        let mut particles = Particles::new(false);
        for k in 0..count {
            let position = DVec3::new(random.uniform(), random.uniform(), random.uniform()) * size;
            // the largest as large as the periodic domain allows
            let radius = 0.01 * ratio.min(10.0) * ratio.powf(-random.uniform());
            let fixed = fixed_every > 0 && k % fixed_every == 0;
            let record = Particle {
                position,
                radius,
                velocity: DVec3::ZERO,
                inverse_mass: f64::from(!fixed),
                angular_velocity: DVec3::ZERO,
                material: MaterialIndex::new(0),
                flags: u32::from(fixed),
            };
            particles.push(record, 1.0, None);
        }
        particles
    }

    #[test]
    fn wide_sizes_are_searched_level_by_level() {
        let particles = cloud(1, 400, DVec3::new(0.5, 0.7, 1.3), 300.0, 0);
        let levels = Levels::choose(&particles.records, 1e-3);
        assert!(
            levels.largest.len() > 1,
            "else the property below says little"
        );
    }

    /// The fast are searched for at a level of their own, and may all be smaller than a slow particle that they meet across a
    /// periodic face: the search distance beyond it follows from the largest of all.
    #[test]
    fn a_small_fast_particle_is_near_a_large_slow_one_across_a_face() {
        let domain = Cell::new(DVec3::ZERO, DVec3::ONE, [true, false, false]);
        let (large, small, extra, skin) = (0.1, 0.001, 0.002, 0.005);
        for (x_small, x_large, gap) in [(0.06, 0.98, 0.08), (0.94, 0.02, 0.08), (0.06, 0.94, 0.12)]
        {
            let mut particles = cloud(1, 2, DVec3::ONE, 1.0, 0);
            for (record, (x, radius)) in
                (particles.records.iter_mut()).zip([(x_small, small), (x_large, large)])
            {
                (record.position, record.radius) = (DVec3::new(x, 0.5, 0.5), radius);
            }
            let levels = Levels::choose(&particles.records, skin);
            let mut extra_skins = vec![extra, 0.0];
            let Built { list, .. } = build(
                &mut particles,
                &mut extra_skins,
                &levels,
                &Margin::of_skin(skin),
                &domain,
                false,
            );
            let is_near = gap < large + small + extra + skin;
            assert_eq!(
                list.entries.len(),
                usize::from(is_near),
                "{x_small} {x_large}"
            );
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(96))]

        /// The list is the brute-force set of pairs: every pair once, with the right image, none that is not near.
        #[test]
        fn lists_exactly_the_pairs_that_are_near(
            seed in any::<u64>(),
            count in 0usize..400,
            flat in any::<bool>(),
            ratio in prop_oneof![Just(1.0), 1.0..10.0f64, 10.0..1000.0f64],
            periodic in any::<[bool; 3]>(),
            skin in 0.0..0.02f64,
            range in 0.0..0.02f64,
            fixed_every in 0usize..5,
            outside in any::<bool>(),
            extra_skin_every in 0usize..8,
        ) {
            let size = DVec3::new(0.5, 0.7, if flat { 0.45 } else { 1.3 });
            let mut particles = cloud(seed, count, size, ratio, fixed_every);
            if outside {
                // particles may stand outside a domain's faces, far or near
                for (k, record) in particles.records.iter_mut().enumerate() {
                    record.position += DVec3::new(0.1, -0.3, 0.2) * (k % 4) as f64;
                }
            }
            for (k, record) in particles.records.iter_mut().enumerate() {
                record.material = MaterialIndex::new((k % 2) as u32);
            }
            let domain = Cell::new(DVec3::ZERO, size, periodic);
            // As much as the periodic domain leaves; also for small ones alone, which are then beside larger ones without.
            let largest = particles.records.iter().fold(0.0f64, |r, p| r.max(p.radius));
            let ahead = |k: usize| {
                let small = particles.records[k].radius < 0.2 * largest;
                match (k.is_multiple_of(extra_skin_every), seed % 3 > 0) {
                    (true, true) => 0.01 * (k % 3) as f64,
                    (true, false) if small => 0.002,
                    _ => 0.0,
                }
            };
            let with_extra_skin = if extra_skin_every > 0 { count } else { 0 };
            let given: Vec<f64> = (0..with_extra_skin).map(ahead).collect();
            // The levels that are chosen, one level for all, and some that are never chosen.
            let levels = match seed % 3 {
                0 => Levels { largest: vec![largest] },
                1 => Levels { largest: vec![0.3 * largest, 0.5 * largest, largest] },
                _ => Levels::choose(&particles.records, skin),
            };
            let ranges = if seed % 4 < 2 { vec![0.0, range] } else { Vec::new() };
            let margin = Margin { skin, ranges };
            let mut extra = given.clone();
            let parallel = seed % 2 == 0;
            let Built { list, new_row, grid } =
                build(&mut particles, &mut extra, &levels, &margin, &domain, parallel);
            // The lists of parts of the rows, as ranks make them, are together that of all.
            let common = Common::find(&mut particles, &extra, &levels, &margin, &domain, parallel);
            let cuts = [0, count / 5, count / 2, count / 2, count];
            for cut in cuts.windows(2) {
                let rows = cut[0]..cut[1];
                let of_part = common.list(&particles, &extra, &grid, rows.clone());
                for row in rows {
                    let entries = |list: &CandidateList| {
                        list.entries[list.start[row] as usize..list.start[row + 1] as usize].to_vec()
                    };
                    prop_assert_eq!(entries(&of_part), entries(&list));
                }
            }
            let extra_skin = extra;
            for (old, extra_skin_then) in given.iter().enumerate() {
                prop_assert_eq!(extra_skin[new_row[old].index()], *extra_skin_then);
            }
            let extra_skin = |row: usize| extra_skin.get(row).copied().unwrap_or_default();

            let mut moved = new_row.clone();
            moved.sort_unstable();
            prop_assert!(moved.iter().enumerate().all(|(k, row)| k == row.index()));

            let mut expected = Vec::new();
            for i in 0..count {
                for j in i + 1..count {
                    let (a, b) = (&particles.records[i], &particles.records[j]);
                    if a.flags & b.flags & FIXED != 0 {
                        continue;
                    }
                    for image in 0..27 {
                        let allowed = image == NO_SHIFT || domain.images().any(|c| c == image);
                        let gap = (a.position - b.position - domain.shift(image)).length();
                        let margins = margin.share(a) + margin.share(b);
                        if allowed && gap < a.radius + b.radius + extra_skin(i) + extra_skin(j) + margins {
                            expected.push((i as u32, j as u32, image));
                        }
                    }
                }
            }
            let mut found = Vec::new();
            for i in 0..count {
                for entry in &list.entries[list.start[i] as usize..list.start[i + 1] as usize] {
                    found.push((i as u32, entry.partner, entry.image));
                }
            }
            found.sort_unstable();
            expected.sort_unstable();
            prop_assert_eq!(found, expected);
        }
    }
}

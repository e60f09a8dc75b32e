//! Moves of a worn surface: owed volumes become displacements.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;

use super::worn::{Worn, WornThrough};
use crate::walls::{Mesh, Scratch};

/// A triangle turns by at most this against its first normal: cosine of 60 degrees.
const MOST_TURNED: f64 = 0.5;
/// A triangle keeps at least this part of its first area.
const LEAST_AREA: f64 = 0.01;
/// Least height of a triangle, over the height below which a mesh takes triangles for lines.
const LEAST_HEIGHTS: f64 = 4.0;
/// Share of the space along a periodic axis that is used.
const ROOM_USED: f64 = 0.9;
/// Number of times that a move is shortened by half before its vertices stay where they are.
const HALVINGS: u32 = 8;
/// Number of times that a rest is offered to the neighbours.
const OFFERS: usize = 2;
/// Faces of a thin body that come closer than this part of an edge are worn through.
const THIN: f64 = 1e-3;
/// Share of the way to the nearest other triangle that a vertex may go at once: it may be offered volume three times, and the other triangle may come
/// to meet it.
const MOST_OF_GAP: f64 = 1.0 / 6.0;
/// The factor of a move lies between this and its inverse.
const LEAST_FACTOR: f64 = 0.1;
/// Rounds of the secant method at most; three are enough on smooth surfaces.
const ROUNDS: usize = 12;

/// A node that is to move.
struct Mover {
    node: u32,
    /// m^3
    volume: f64,
    /// Displacement that this volume makes by itself, m.
    way: DVec3,
    /// The part of it that is allowed.
    part: f64,
}

impl Worn {
    /// Makes displacements of all that is owed, as far as the surface allows; the places of the corners are [`Worn::corners`] then. `mesh` is the
    /// surface as it is before.
    pub fn advance(&mut self, mesh: &Mesh) {
        self.is_due = false;
        if !self.is_owing() {
            return;
        }
        let mut owing = std::mem::take(&mut self.owing);
        owing.sort_unstable();
        let mut wanted = BTreeMap::new();
        for node in owing {
            let index = node as usize;
            self.owes[index] = false;
            self.left[index] = 0.0;
            let volume = std::mem::take(&mut self.waiting[index]);
            if volume != 0.0 {
                wanted.insert(node, volume);
            }
        }
        if self.plan.smoothing > 0.0 {
            wanted = self.smoothed(&wanted);
        }
        let mut moved = BTreeSet::new();
        self.last_way = 0.0;
        for offer in 0..=OFFERS {
            let left = self.place(&wanted, &mut moved, mesh);
            wanted.clear();
            for (node, volume) in left {
                let is_free = |other: &&u32| {
                    !self.blocked[**other as usize] && !self.through[**other as usize]
                };
                let free: Vec<u32> = self
                    .skin
                    .beside(node)
                    .iter()
                    .filter(is_free)
                    .copied()
                    .collect();
                if offer == OFFERS || free.is_empty() {
                    self.keep(node, volume);
                    continue;
                }
                let share = volume / free.len() as f64;
                for other in free {
                    *wanted.entry(other).or_insert(0.0) += share;
                }
            }
            if wanted.is_empty() {
                break;
            }
        }
        self.moved = moved.into_iter().collect();
        self.travelled += self.last_way;
        let nodes: BTreeSet<u32> = (self.moved.iter())
            .flat_map(|&triangle| self.skin.nodes_of(triangle))
            .collect();
        for &node in &nodes {
            self.measure(node);
        }
        self.is_worn |= nodes
            .iter()
            .any(|&node| self.depth_along(node).abs() >= self.plan.until_depth);
        self.moves += 1;
    }

    /// A volume stays with a node until the next move.
    fn keep(&mut self, node: u32, volume: f64) {
        let index = node as usize;
        self.waiting[index] += volume;
        self.left[index] = self.waiting[index];
        if !std::mem::replace(&mut self.owes[index], true) {
            self.owing.push(node);
        }
    }

    /// Volumes of which each node has shared a part with its neighbours.
    fn smoothed(&self, wanted: &BTreeMap<u32, f64>) -> BTreeMap<u32, f64> {
        let mut shared = BTreeMap::new();
        for (&node, &volume) in wanted {
            let beside = self.skin.beside(node);
            let share = self.plan.smoothing * volume / beside.len().max(1) as f64;
            let mut rest = volume;
            for &other in beside {
                *shared.entry(other).or_insert(0.0) += share;
                rest -= share;
            }
            *shared.entry(node).or_insert(0.0) += rest;
        }
        shared
    }

    /// Moves nodes by these volumes; returns what could not be placed. Notes the triangles that moved.
    fn place(
        &mut self,
        wanted: &BTreeMap<u32, f64>,
        moved: &mut BTreeSet<u32>,
        mesh: &Mesh,
    ) -> BTreeMap<u32, f64> {
        let mut scratch = Scratch::default();
        let mut movers: Vec<Mover> = (wanted.iter())
            .map(|(&node, &volume)| self.mover(node, volume))
            .collect();
        for mover in &mut movers {
            let way = mover.way.length();
            let most = self.longest_way(mover.node, way, mesh, &mut scratch);
            if way > most {
                mover.part *= most / way;
            }
        }
        let triangles: BTreeSet<u32> = (movers.iter().filter(|mover| mover.part > 0.0))
            .flat_map(|mover| self.skin.around(mover.node).iter().copied())
            .collect();
        let triangles: Vec<u32> = triangles.into_iter().collect();
        let before: f64 = triangles
            .iter()
            .map(|&k| self.skin.swept(k, &self.displacement))
            .sum();
        let missing = self.placed - self.removed_along();
        let old: Vec<DVec3> = movers
            .iter()
            .map(|mover| self.displacement[mover.node as usize])
            .collect();
        let mut round = 0;
        let achieved = loop {
            let volume: f64 = movers.iter().map(|mover| mover.part * mover.volume).sum();
            // Along the normals, as volumes are swept.
            let goal = before - (volume + missing);
            let (factors, swept) = self.factors(&movers, &old, &triangles, goal);
            self.displace(&movers, &old, factors);
            let offenders = self.offenders(&movers, &old, &triangles);
            if offenders.is_empty() {
                self.note_ways(&movers, factors);
                break (swept - before, goal - before, volume);
            }
            round += 1;
            for index in offenders {
                movers[index].part *= if round > HALVINGS { 0.0 } else { 0.5 };
            }
        };
        let (swept, goal, volume) = achieved;
        // A factor at its bounds places more or less than was intended: the books follow what was swept.
        let whole: f64 = movers
            .iter()
            .map(|mover| (mover.part * mover.volume).abs())
            .sum();
        let done = if (swept - goal).abs() <= 1e-12 * whole || volume == 0.0 {
            1.0
        } else {
            (-swept - missing) / volume
        };
        self.placed += done * volume;
        for &triangle in &triangles {
            self.removed[triangle as usize] = self.lost(triangle);
        }
        moved.extend(triangles);
        let mut left = BTreeMap::new();
        for mover in &movers {
            let rest = mover.volume - done * (mover.part * mover.volume);
            self.blocked[mover.node as usize] = mover.part < 1.0;
            if rest != 0.0 && (mover.part < 1.0 || done != 1.0) {
                left.insert(mover.node, rest);
            }
        }
        left
    }

    /// A node with the displacement that its volume makes by itself: along the present normal, weighted by area.
    fn mover(&self, node: u32, volume: f64) -> Mover {
        let mut normal = DVec3::ZERO;
        for &triangle in self.skin.around(node) {
            let [ab, ac, _] = self.skin.sides(triangle, &self.displacement);
            normal += ab.cross(ac);
        }
        let whole = 2.0 * self.areas[node as usize];
        // Where triangles lie back to back there is no direction.
        let is_steady = normal.length() > 1e-6 * whole;
        let mut direction = normal.normalize_or_zero();
        if !self.skin.axes.is_empty() {
            // A surface that goes on along an axis moves across it, unless it faces along it.
            let mut across = direction;
            self.skin.axes.iter().for_each(|&axis| across[axis] = 0.0);
            if across.length() >= 0.5 {
                direction = across.normalize();
            }
        }
        let is_free = is_steady && !self.through[node as usize];
        Mover {
            node,
            volume,
            way: direction * (-3.0 * volume / self.areas[node as usize]),
            part: if is_free { 1.0 } else { 0.0 },
        }
    }

    /// How far a node that should go by `way` (m) may go at once, m: no farther than to a part of the gap behind its triangles,
    /// so that no face passes another one unseen.
    fn longest_way(&self, node: u32, way: f64, mesh: &Mesh, scratch: &mut Scratch) -> f64 {
        let mut most = f64::INFINITY;
        for &triangle in self.skin.around(node) {
            let thin = self.thinnest(triangle);
            if way <= thin {
                continue;
            }
            let corners = self.skin.triangles[triangle as usize];
            let reach = [thin, way / MOST_OF_GAP];
            let (clear, _) = mesh.facing(corners, reach, self.moves_alike(), scratch);
            most = most.min(thin.max(MOST_OF_GAP * clear));
        }
        most
    }

    /// Faces that come as near to a triangle as this are worn through, m: a face that moves by more at once must not pass the other one unseen.
    fn thinnest(&self, triangle: u32) -> f64 {
        let sides = self.skin.sides(triangle, &self.displacement);
        let shortest = sides.map(DVec3::length).into_iter();
        shortest.fold(f64::INFINITY, f64::min) * THIN.max(self.plan.step)
    }

    /// Whether two corners are one node.
    fn moves_alike(&self) -> impl Fn(u32, u32) -> bool + '_ {
        |one, other| self.skin.node_of[one as usize] == self.skin.node_of[other as usize]
    }

    /// Factors on the ways of nodes with positive and with negative volumes, by which the swept volumes of the triangles (m^3) come to `goal`,
    /// and to what they come. The side with more volume is scaled, so that the slope never vanishes.
    fn factors(
        &mut self,
        movers: &[Mover],
        old: &[DVec3],
        triangles: &[u32],
        goal: f64,
    ) -> ([f64; 2], f64) {
        let of_side = |is_front: bool| -> f64 {
            let own = movers
                .iter()
                .filter(|mover| (mover.volume > 0.0) == is_front);
            own.map(|mover| mover.part * mover.volume).sum()
        };
        let (front, back) = (of_side(true), of_side(false));
        let scales_front = front >= -back;
        let factors = |factor: f64| {
            if scales_front {
                [factor, 1.0]
            } else {
                [1.0, factor]
            }
        };
        let mut swept = |factor: f64| -> f64 {
            self.displace(movers, old, factors(factor));
            triangles
                .iter()
                .map(|&k| self.skin.swept(k, &self.displacement))
                .sum()
        };
        let mut slope = -if scales_front { front } else { back };
        let (mut factor, mut value) = (1.0, swept(1.0));
        if slope == 0.0 {
            return (factors(factor), value);
        }
        let mut best = (factor, value);
        for _ in 0..ROUNDS {
            let error = value - goal;
            if error.abs() <= 1e-15 * slope.abs() {
                break;
            }
            let next = (factor - error / slope).clamp(LEAST_FACTOR, 1.0 / LEAST_FACTOR);
            if next == factor || !next.is_finite() {
                break;
            }
            let next_value = swept(next);
            let new_slope = (next_value - value) / (next - factor);
            if new_slope.is_finite() && new_slope * slope > 0.0 && error.abs() > 1e-9 * slope.abs()
            {
                slope = new_slope;
            }
            (factor, value) = (next, next_value);
            if (value - goal).abs() >= (best.1 - goal).abs() {
                // Round-off of the sums is reached.
                break;
            }
            best = (factor, value);
        }
        (factors(best.0), best.1)
    }

    /// Puts nodes to where their ways lead.
    fn displace(&mut self, movers: &[Mover], old: &[DVec3], factors: [f64; 2]) {
        for (mover, old) in movers.iter().zip(old) {
            let factor = mover.part
                * if mover.volume > 0.0 {
                    factors[0]
                } else {
                    factors[1]
                };
            self.displacement[mover.node as usize] = *old + mover.way * factor;
        }
    }

    fn note_ways(&mut self, movers: &[Mover], factors: [f64; 2]) {
        let mut farthest = 0.0f64;
        for mover in movers {
            let factor = mover.part
                * if mover.volume > 0.0 {
                    factors[0]
                } else {
                    factors[1]
                };
            farthest = farthest.max(mover.way.length() * factor);
            let index = mover.node as usize;
            let allowed = 3.0 * self.limits[index] / self.areas[index];
            self.largest_move = self.largest_move.max(mover.way.length() * factor / allowed);
        }
        self.last_way += farthest;
    }

    /// Movers, by their place, at triangles that are beyond a limit and have come farther beyond it.
    fn offenders(&self, movers: &[Mover], old: &[DVec3], triangles: &[u32]) -> BTreeSet<usize> {
        let place_of: BTreeMap<u32, usize> = movers
            .iter()
            .enumerate()
            .map(|(place, mover)| (mover.node, place))
            .collect();
        let moving = |node: &u32| {
            place_of
                .get(node)
                .copied()
                .filter(|&place| movers[place].part > 0.0)
        };
        let mut offenders = BTreeSet::new();
        for &triangle in triangles {
            let nodes = self.skin.nodes_of(triangle);
            let before = nodes.map(|node| match place_of.get(&node) {
                Some(&place) => old[place],
                None => self.displacement[node as usize],
            });
            let after = nodes.map(|node| self.displacement[node as usize]);
            if before != after && self.is_beyond(triangle, before, after) {
                offenders.extend(nodes.iter().filter_map(moving));
            }
        }
        for (place, mover) in movers.iter().enumerate() {
            let (now, before) = (self.displacement[mover.node as usize], old[place]);
            let is_off = |&axis: &usize| {
                now[axis].abs() > ROOM_USED * self.skin.room && now[axis].abs() > before[axis].abs()
            };
            if mover.part > 0.0 && self.skin.axes.iter().any(is_off) {
                offenders.insert(place);
            }
        }
        offenders
    }

    /// Whether a triangle is beyond a limit, and farther than before.
    fn is_beyond(&self, triangle: u32, before: [DVec3; 3], after: [DVec3; 3]) -> bool {
        let corners = self.skin.triangles[triangle as usize];
        let [a, b, c] = corners.map(|corner| self.skin.first[corner as usize]);
        let (normal, area) = self.skin.faces[triangle as usize];
        // Cosine of the turn, area, height.
        let measures = |[u, v, w]: [DVec3; 3]| {
            let (ab, ac, bc) = ((b - a) + (v - u), (c - a) + (w - u), (c - b) + (w - v));
            let across = ab.cross(ac);
            let longest = ab.length().max(ac.length()).max(bc.length());
            let length = across.length();
            [across.dot(normal) / length, 0.5 * length, length / longest]
        };
        let (then, now) = (measures(before), measures(after));
        let least = [
            MOST_TURNED,
            LEAST_AREA * area,
            LEAST_HEIGHTS * self.skin.least_height,
        ];
        // Not a number is beyond.
        let is_allowed = |k: usize| now[k] >= least[k] || now[k] >= then[k];
        !(0..3).all(is_allowed)
    }

    /// Looks whether a face of a thin body has come to the opposite one in the last move; `mesh` is the surface as it is now. There nothing moves any
    /// more. Whether this was the first time.
    pub fn find_worn_through(&mut self, mesh: &Mesh) -> bool {
        let mut scratch = Scratch::default();
        let was_whole = self.worn_through.is_none();
        for triangle in std::mem::take(&mut self.moved) {
            let nodes = self.skin.nodes_of(triangle);
            if nodes.iter().all(|&node| self.through[node as usize]) {
                continue;
            }
            let sides = self.skin.sides(triangle, &self.displacement);
            let sides = sides.map(DVec3::length).into_iter();
            let shortest = sides.fold(f64::INFINITY, f64::min);
            let thin = self.thinnest(triangle);
            // Both may have come nearer.
            if self.clear[triangle as usize] - 2.0 * self.travelled > thin {
                continue;
            }
            let corners = self.skin.triangles[triangle as usize];
            let reach = [thin, thin.max(shortest)];
            let (clear, facing) = mesh.facing(corners, reach, self.moves_alike(), &mut scratch);
            self.clear[triangle as usize] = clear + 2.0 * self.travelled;
            let Some(facing) = facing else {
                continue;
            };
            for node in nodes.into_iter().chain(self.skin.nodes_of(facing.triangle)) {
                self.through[node as usize] = true;
            }
            if self.worn_through.is_none() {
                let places = corners.map(|corner| mesh.corners()[corner as usize]);
                self.worn_through = Some(WornThrough {
                    place: (places[0] + places[1] + places[2]) / 3.0,
                    moves: self.moves,
                });
            }
        }
        was_whole && self.worn_through.is_some()
    }
}

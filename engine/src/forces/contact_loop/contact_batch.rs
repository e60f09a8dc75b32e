//! The data of the contacts found in a chunk of slots, in columns, and the order in which they are evaluated.

use crate::contact::{AdhesionLaw, Contact, RollingLaw, TangentialLaw};
use crate::lanes::{MOST_LANES, Mask, Quad, Real, Vector};
use crate::state::Particle;

/// The number of slots that are searched for contacts before the contacts found are evaluated.
pub(super) const CHUNK: usize = 128;

/// Capacity of the buffers of a chunk: more than it needs, so that a `u8` is always a valid index.
pub(super) const ROOM: usize = 256;

const _: () = assert!(CHUNK + MOST_LANES <= ROOM);

/// Kinds that are distinguished when contacts of one law are put side by side: the pairs of eight materials, or of five where those that touch and those
/// that do not are two kinds. Where there are more, groups with several laws are evaluated one by one.
const PAIRS: usize = 64;

/// Each number at its own place.
static IN_ORDER: [u8; ROOM] = {
    let mut places = [0; ROOM];
    let mut k = 0;
    while k < ROOM {
        places[k] = k as u8;
        k += 1;
    }
    places
};

/// A number of each contact found.
#[derive(Debug)]
#[repr(align(64))]
pub(super) struct Column(pub(super) [f64; ROOM]);

impl Column {
    const ZERO: Self = Self([0.0; ROOM]);

    /// The numbers of contact `k` and those behind it.
    #[inline(always)]
    fn at<L: Real>(&self, k: usize) -> L {
        L::load(&self.0[k..])
    }

    #[inline(always)]
    pub(super) fn put<L: Real>(&mut self, k: usize, numbers: L) {
        numbers.store(&mut self.0[k..]);
    }
}

/// The contacts found in a chunk of slots.
pub(super) struct ContactBatch<'a> {
    /// The particles of every slot of the chunk.
    pub(super) a: [&'a Particle; ROOM],
    pub(super) b: [&'a Particle; ROOM],
    pub(super) numbers: &'a mut BatchColumns,
}

/// The numbers of the contacts found in a chunk of slots. One for all blocks of a thread: making it takes as long as some
/// contacts. Each chunk writes every number that it reads; nothing is kept for the next chunk.
#[derive(Debug)]
pub(super) struct BatchColumns {
    // As they were found, in the order of the slots.
    /// x_A - x_B, of the image of B that is listed, m.
    pub(super) offset: [Column; 3],
    /// Its square, m^2.
    pub(super) squared: Column,
    /// R_A + R_B, m.
    pub(super) reach: Column,
    /// Their positions in the columns below, in a chunk whose [`Turn`] is sorted.
    places: [u8; ROOM],

    // In the order of evaluation: those of one law side by side, groups filled up by repetition.
    /// Index among the contacts found, in a chunk whose [`Turn`] is sorted.
    turn: [u8; ROOM],
    /// Slot in the chunk.
    pub(super) slot: [u8; ROOM],
    /// The index of its law.
    pub(super) pair: [u32; ROOM],
    /// Unit normal from B to A.
    pub(super) normal: [Column; 3],
    /// Distance of the centres, m.
    distance: Column,
    /// Overlap, m.
    pub(super) overlap: Column,
    /// Effective radius R*, m.
    radius: Column,
    /// Effective mass m*, kg.
    pub(super) mass: Column,
    /// Relative velocity v_A - v_B, m/s.
    velocity: [Column; 3],
    /// The normal for sliding velocities.
    sliding_normal: [Column; 3],
    /// Distance of the centres at the time of that normal, m.
    sliding_distance: Column,
    /// Force on A, N.
    pub(super) force: [Quad; ROOM],
    /// Torques on A and on B, N m.
    pub(super) torques: [[Quad; ROOM]; 2],
}

impl BatchColumns {
    /// The numbers of no contact.
    pub(super) fn new() -> Self {
        Self {
            offset: [Column::ZERO; 3],
            squared: Column::ZERO,
            reach: Column::ZERO,
            places: [0; ROOM],
            turn: [0; ROOM],
            slot: [0; ROOM],
            pair: [0; ROOM],
            normal: [Column::ZERO; 3],
            distance: Column::ZERO,
            overlap: Column::ZERO,
            radius: Column::ZERO,
            mass: Column::ZERO,
            velocity: [Column::ZERO; 3],
            sliding_normal: [Column::ZERO; 3],
            sliding_distance: Column::ZERO,
            force: [Quad::default(); ROOM],
            torques: [[Quad::default(); ROOM]; 2],
        }
    }
}

impl BatchColumns {
    /// Puts the contact found at `k` to `to`, before it.
    pub(super) fn keep(&mut self, k: usize, to: usize) {
        self.slot[to] = self.slot[k];
        let offset = self.offset.iter_mut();
        for column in offset.chain([&mut self.squared, &mut self.reach]) {
            column.0[to] = column.0[k];
        }
    }
}

/// The order in which the contacts found in one chunk are evaluated. A value of that chunk alone, so that the order of one chunk
/// is never applied to another.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turn {
    /// End of the last group of lanes.
    pub(super) end: usize,
    /// Whether this order differs from that of the slots.
    is_sorted: bool,
}

impl<'a> ContactBatch<'a> {
    /// Nothing yet; `filler` fills all entries.
    pub(super) fn new(filler: &'a Particle, numbers: &'a mut BatchColumns) -> Self {
        Self {
            a: [filler; ROOM],
            b: [filler; ROOM],
            numbers,
        }
    }

    /// Fixes the order in which the first `count` contacts found are evaluated, in groups of `lanes`.
    ///
    /// `by_touch`: those that touch are put apart from those that do not.
    #[inline(always)]
    pub(super) fn put_in_turn(
        &mut self,
        count: usize,
        materials: usize,
        lanes: usize,
        by_touch: bool,
    ) -> Turn {
        if (materials > 1 || by_touch)
            && let Some(end) = self.put_laws_side_by_side(count, materials, lanes, by_touch)
        {
            return Turn {
                end,
                is_sorted: true,
            };
        }
        let end = count.next_multiple_of(lanes);
        for k in count..end {
            let last = count - 1;
            self.numbers.slot[k] = self.numbers.slot[last];
            self.numbers.pair[k] = self.numbers.pair[last];
            for axis in &mut self.numbers.offset {
                axis.0[k] = axis.0[last];
            }
            self.numbers.squared.0[k] = self.numbers.squared.0[last];
            self.numbers.reach.0[k] = self.numbers.reach.0[last];
        }
        Turn {
            end,
            is_sorted: false,
        }
    }

    /// The positions, in the order of evaluation, of the first `count` contacts found.
    #[inline(always)]
    pub(super) fn places(&self, turn: Turn, count: usize) -> &[u8] {
        let places = if turn.is_sorted {
            &self.numbers.places
        } else {
            &IN_ORDER
        };
        &places[..count]
    }

    /// Order of contacts that may follow several laws, whose indices are noted; `None` if they are evaluated in the order of
    /// their slots.
    #[inline(never)]
    fn put_laws_side_by_side(
        &mut self,
        count: usize,
        materials: usize,
        lanes: usize,
        by_touch: bool,
    ) -> Option<usize> {
        let found: [u8; CHUNK] = std::array::from_fn(|k| self.numbers.slot[k]);
        for (pair, &at) in self
            .numbers
            .pair
            .iter_mut()
            .zip(&self.numbers.slot[..count])
        {
            let at = usize::from(at);
            let (a, b) = (self.a[at].material.index(), self.b[at].material.index());
            // The law of two materials is the same in either order.
            *pair = (a.min(b) * materials + a.max(b)) as u32;
        }
        // Contacts of one law stand side by side; those that touch and those that do not are two kinds.
        let mut kinds: [u32; CHUNK] = std::array::from_fn(|k| self.numbers.pair[k]);
        if by_touch {
            let gaps = self.numbers.squared.0.iter().zip(&self.numbers.reach.0);
            for (kind, (squared, reach)) in kinds.iter_mut().zip(gaps) {
                *kind = 2 * *kind + u32::from(reach - squared.sqrt() <= 0.0);
            }
        }
        let kinds = &kinds[..count];
        let least = kinds.iter().copied().min().unwrap_or(0);
        let most = kinds.iter().copied().max().unwrap_or(0);
        if lanes == 1 || least >= most || most as usize >= PAIRS {
            return None;
        }
        // A counting sort without branches: which law comes next can hardly be predicted.
        let mut counts = [0; PAIRS];
        for &kind in kinds {
            counts[kind as usize % PAIRS] += 1;
        }
        let mut next = [0; PAIRS];
        let mut end = 0;
        for (next, count) in next.iter_mut().zip(counts) {
            *next = end;
            end += usize::next_multiple_of(count, lanes);
        }
        if end > ROOM {
            return None;
        }
        for (k, &kind) in kinds.iter().enumerate() {
            let place = &mut next[kind as usize % PAIRS];
            self.numbers.places[k] = *place as u8;
            self.numbers.turn[*place % ROOM] = k as u8;
            self.numbers.pair[*place % ROOM] = if by_touch { kind >> 1 } else { kind };
            *place += 1;
        }
        // Each run is filled up with copies of its last contact, in the same group, which reads one history and writes one.
        for (&filled, count) in next.iter().zip(counts) {
            for k in filled..filled - count + usize::next_multiple_of(count, lanes) {
                self.numbers.turn[k] = self.numbers.turn[filled - 1];
                self.numbers.pair[k] = self.numbers.pair[filled - 1];
            }
        }
        for (slot, &from) in self.numbers.slot[..end].iter_mut().zip(&self.numbers.turn) {
            *slot = found[usize::from(from) % CHUNK];
        }
        Some(end)
    }

    /// The slots of the contacts from `base` on.
    #[inline(always)]
    pub(super) fn slots(&self, base: usize) -> [usize; MOST_LANES] {
        std::array::from_fn(|k| usize::from(self.numbers.slot[(base + k) % ROOM]))
    }

    /// The numbers in a column, for the evaluated contacts from `base` on.
    #[inline(always)]
    fn found<L: Real>(&self, column: &Column, base: usize, is_sorted: bool) -> L {
        if is_sorted {
            L::from_lanes(|k| column.0[usize::from(self.numbers.turn[(base + k) % ROOM])])
        } else {
            column.at(base)
        }
    }

    /// Normals, velocities, masses and radii of the contacts in their order, with the roots and divisions that need nothing else:
    /// all of them at once, before the long dependent chains of each contact. Returns whether one of them may overlap by more
    /// than `limit` of the smaller radius, which is at least R*.
    ///
    /// `lag` (s): the time between the normal for sliding velocities and the positions; `None` where nothing slides or turns.
    #[inline(always)]
    pub(super) fn prepare<L: Real>(&mut self, turn: Turn, limit: f64, lag: Option<f64>) -> bool {
        let Turn { end, is_sorted } = turn;
        let mut is_deep = 0;
        let mut base = 0;
        while base < end {
            let at = self.slots(base);
            let (a, b) = (
                |k: usize| self.a[at[k] % ROOM],
                |k: usize| self.b[at[k] % ROOM],
            );
            let [x, y, z, mobility] = L::differences(|k| &a(k).quads()[1], |k| &b(k).quads()[1]);
            let radii = L::from_lanes(|k| a(k).radius) * L::from_lanes(|k| b(k).radius);
            let distance: L = self
                .found::<L>(&self.numbers.squared, base, is_sorted)
                .sqrt();
            let reach: L = self.found(&self.numbers.reach, base, is_sorted);
            let offset: Vector<L> = Vector::new(
                self.found(&self.numbers.offset[0], base, is_sorted),
                self.found(&self.numbers.offset[1], base, is_sorted),
                self.found(&self.numbers.offset[2], base, is_sorted),
            );
            let mut normal = offset * (L::ONE / distance);
            let apart = L::ZERO.below(distance);
            if !apart.all() {
                // Concentric particles have no normal; any direction will push them apart.
                normal = Vector::select(apart, normal, Vector::X);
            }
            let (radius, overlap) = (radii / reach, reach - distance);
            is_deep |= (radius * limit).below(overlap).bits();
            if let Some(lag) = lag {
                let earlier = offset - Vector::new(x, y, z) * L::splat(lag);
                let distance = earlier.length_squared().sqrt();
                // Particles that were concentric then get the normal 0: nothing slides or turns.
                let earlier = earlier * (L::ONE / distance.max(L::splat(f64::MIN_POSITIVE)));
                self.numbers.sliding_normal[0].put(base, earlier.x);
                self.numbers.sliding_normal[1].put(base, earlier.y);
                self.numbers.sliding_normal[2].put(base, earlier.z);
                self.numbers.sliding_distance.put(base, distance);
            }
            self.numbers.velocity[0].put(base, x);
            self.numbers.velocity[1].put(base, y);
            self.numbers.velocity[2].put(base, z);
            self.numbers.normal[0].put(base, normal.x);
            self.numbers.normal[1].put(base, normal.y);
            self.numbers.normal[2].put(base, normal.z);
            self.numbers.mass.put(base, L::ONE / mobility);
            self.numbers.radius.put(base, radius);
            self.numbers.distance.put(base, distance);
            self.numbers.overlap.put(base, overlap);
            base += L::LANES;
        }
        is_deep != 0
    }

    /// Geometry and kinematics of the contacts from `base` on, whose slots are `at`, and the lever arms R - (R_A + R_B - distance)/2 of both: together the
    /// distance, so that friction keeps angular momentum.
    #[inline(always)]
    pub(super) fn meet<L: Real, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw>(
        &self,
        base: usize,
        at: &[usize; MOST_LANES],
    ) -> (Contact<L>, [L; 2]) {
        let (a, b) = (
            |k: usize| self.a[at[k] % ROOM],
            |k: usize| self.b[at[k] % ROOM],
        );
        let (distance, overlap): (L, L) = (
            self.numbers.distance.at(base),
            self.numbers.overlap.at(base),
        );
        let normal: Vector<L> = columns(&self.numbers.normal, base);
        let radii = [
            L::from_lanes(|k| a(k).radius),
            L::from_lanes(|k| b(k).radius),
        ];
        // Of glued pairs the overlap that counts is less; of all others it is this one, to the bit.
        let half = (radii[0] + radii[1] - distance) * 0.5;
        let levers = [radii[0] - half, radii[1] - half];
        let centre_velocity: Vector<L> = columns(&self.numbers.velocity, base);
        let normal_velocity = centre_velocity.dot(normal);
        let (mut tangential_velocity, mut spin) = (Vector::ZERO, Vector::ZERO);
        let (mut sliding_normal, mut sliding_distance) = (normal, distance);
        if T::ACTIVE || R::ACTIVE || A::SHEARS || A::TWISTS {
            let spin_a: Vector<L> = L::vectors(|k| &a(k).quads()[2]);
            let spin_b: Vector<L> = L::vectors(|k| &b(k).quads()[2]);
            sliding_normal = columns(&self.numbers.sliding_normal, base);
            sliding_distance = self.numbers.sliding_distance.at(base);
            if T::ACTIVE || A::SHEARS {
                // The lever arms of that time, too: half of the approach of the centres since then.
                let closer = (sliding_distance - distance) * 0.5;
                let turning = spin_a * (levers[0] + closer) + spin_b * (levers[1] + closer);
                let along = centre_velocity.dot(sliding_normal);
                let sliding =
                    centre_velocity - sliding_normal * along - turning.cross(sliding_normal);
                tangential_velocity = sliding - normal * sliding.dot(normal);
            }
            if R::ACTIVE || A::TWISTS {
                spin = spin_a - spin_b;
            }
        }
        let contact = Contact {
            normal,
            distance,
            overlap,
            effective_radius: self.numbers.radius.at(base),
            effective_mass: self.numbers.mass.at(base),
            normal_velocity,
            tangential_velocity,
            sliding_normal,
            sliding_distance,
            centre_velocity,
            spin,
        };
        (contact, levers)
    }
}

#[inline(always)]
fn columns<L: Real>(columns: &[Column; 3], k: usize) -> Vector<L> {
    Vector::new(columns[0].at(k), columns[1].at(k), columns[2].at(k))
}

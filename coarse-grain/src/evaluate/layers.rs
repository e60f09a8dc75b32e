//! From particles and contacts to rows of numbers: which particles count, and what each contributes.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::images::Original;
use crate::state::{Contacts, Particles, Partner, State};
use crate::sums::{Layout, SYMMETRIC, Spread, Sum};

/// Rows of numbers and where they sit.
#[derive(Debug, Clone, Default)]
pub(crate) struct Rows {
    pub values: Vec<f64>,
    pub originals: Vec<Original>,
}

impl Rows {
    /// No rows; their memory is kept.
    pub(crate) fn clear(&mut self) {
        self.values.clear();
        self.originals.clear();
    }
}

/// The requested sums of contacts.
struct WantedOfContacts {
    lines: Vec<Sum>,
    moments: bool,
    boundary: Vec<Sum>,
}

/// Fills N lists of rows, of `widths` numbers each, from parts of a list of `length`: how many rows `count` finds in a part, so many does `some`
/// fill. Made by whatever threads there are; what comes out does not depend on them. The memory of what was there before is used again.
fn fill<const N: usize>(
    length: usize,
    widths: [usize; N],
    mut rows: [&mut Rows; N],
    count: impl Fn(Range<usize>) -> [usize; N] + Sync,
    some: impl Fn(Range<usize>, [Part<'_>; N]) + Sync,
) {
    let part = |k: usize| k * CHUNK..((k + 1) * CHUNK).min(length);
    let parts = length.div_ceil(CHUNK);
    let counts: Vec<[usize; N]> = (0..parts).into_par_iter().map(|k| count(part(k))).collect();
    for (n, rows) in rows.iter_mut().enumerate() {
        let total: usize = counts.iter().map(|counts| counts[n]).sum();
        rows.values.resize(total * widths[n], 0.0);
        rows.originals.resize(total, Original::NOWHERE);
    }
    let mut rest = rows.map(|rows| Part {
        values: &mut rows.values,
        originals: &mut rows.originals,
    });
    let mut all = Vec::with_capacity(parts);
    for (k, counts) in counts.iter().enumerate() {
        let own = std::array::from_fn(|n| rest[n].split_off(counts[n], widths[n]));
        all.push((part(k), own));
    }
    all.into_par_iter()
        .with_max_len(1)
        .for_each(|(range, own)| some(range, own));
}

/// Rows that are still to be filled, from the first on.
struct Part<'a> {
    values: &'a mut [f64],
    originals: &'a mut [Original],
}

impl<'a> Part<'a> {
    /// Splits off so many rows of so many numbers from the front.
    fn split_off(&mut self, rows: usize, width: usize) -> Part<'a> {
        let (values, rest) = std::mem::take(&mut self.values).split_at_mut(rows * width);
        self.values = rest;
        let (originals, rest) = std::mem::take(&mut self.originals).split_at_mut(rows);
        self.originals = rest;
        Part { values, originals }
    }

    /// The next number.
    #[inline]
    fn push(&mut self, value: f64) {
        self.append([value]);
    }

    /// The next numbers.
    #[inline]
    fn append<const N: usize>(&mut self, numbers: [f64; N]) {
        // All particles have been counted.
        if let Some((front, rest)) = std::mem::take(&mut self.values).split_first_chunk_mut::<N>() {
            *front = numbers;
            self.values = rest;
        }
    }

    #[inline]
    fn vector(&mut self, v: DVec3) {
        self.append([v.x, v.y, v.z]);
    }

    /// The products of a symmetric tensor, times a factor.
    #[inline]
    fn square(&mut self, factor: f64, v: DVec3) {
        self.append(SYMMETRIC.map(|(a, b)| factor * v[a] * v[b]));
    }

    /// The products of two vectors.
    #[inline]
    fn product(&mut self, a: DVec3, b: DVec3) {
        let [x, y, z] = [a.x * b, a.y * b, a.z * b];
        self.append([x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z]);
    }

    /// Where the row sits.
    #[inline]
    fn place(&mut self, original: Original) {
        if let Some((front, rest)) = std::mem::take(&mut self.originals).split_first_mut() {
            *front = original;
            self.originals = rest;
        }
    }
}

/// Particles or contacts that a thread takes in one go.
const CHUNK: usize = 4096;

/// Role of a particle in the fields.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    /// Part of the fields.
    Own,
    /// Flows, but is of a material that is left out.
    Other,
    /// Fixed or driven: boundary, as walls are.
    Still,
}

/// Sums that equal particles share; they stand first in a layout.
pub(crate) const SIZES: [Sum; 3] = [Sum::Sizes, Sum::Volume, Sum::Mass];

/// The particles that belong to the fields.
pub(crate) struct Roles<'a> {
    particles: &'a Particles,
    material: Option<u32>,
}

impl<'a> Roles<'a> {
    pub(crate) fn new(particles: &'a Particles, material: Option<u32>) -> Self {
        Self {
            particles,
            material,
        }
    }

    fn of(&self, row: u32) -> Role {
        let row = row as usize;
        if !self.particles.flowing[row] {
            Role::Still
        } else if self
            .material
            .is_none_or(|material| self.particles.material[row] == material)
        {
            Role::Own
        } else {
            Role::Other
        }
    }

    fn own(&self, range: Range<usize>) -> impl Iterator<Item = usize> + '_ {
        range.filter(|&row| self.of(row as u32) == Role::Own)
    }

    /// A row for each own particle at its centre, of `width` numbers that `push` appends.
    fn at_centres(
        &self,
        width: usize,
        rows: &mut Rows,
        push: impl Fn(usize, &mut Part<'_>) + Sync,
    ) {
        let count = |range| [self.own(range).count()];
        fill(
            self.particles.len(),
            [width],
            [rows],
            count,
            |range, [mut part]| {
                for row in self.own(range) {
                    push(row, &mut part);
                    part.place(Original {
                        middle: self.particles.position[row],
                        segment: DVec3::ZERO,
                    });
                }
            },
        );
    }

    /// Mass, if it is known.
    fn mass(&self, row: usize) -> f64 {
        self.particles.mass.get(row).copied().unwrap_or(0.0)
    }

    /// Radius powers, volume and mass that the layout needs, if all own particles have the same: then one number, spread for all
    /// of them, is enough.
    pub(crate) fn uniform(&self, layout: &Layout) -> Option<Vec<f64>> {
        let particles = self.particles;
        let sizes = |row: usize| {
            (
                particles.radius[row],
                particles.volume[row],
                particles.mass.get(row),
            )
        };
        let mut rows = self.own(0..particles.len());
        let first = rows.next()?;
        let all_equal = rows.all(|row| sizes(row) == sizes(first));
        let (r, volume, mass) = sizes(first);
        let mut values = Vec::new();
        for sum in SIZES.into_iter().filter(|&sum| layout.has(sum)) {
            match sum {
                Sum::Sizes => {
                    values.extend([1.0, r, r * r, r * r * r, r * r * r * r, r * r * r * r * r])
                }
                Sum::Volume => values.push(volume),
                _ => values.push(*mass?),
            }
        }
        (all_equal && values.len() > 1).then_some(values)
    }

    /// Rows of the own particles with their numbers. With `uniform` a one stands for sizes, volume and mass, see
    /// [`Self::uniform`].
    pub(crate) fn particles(&self, state: &State, layout: &Layout, uniform: bool, rows: &mut Rows) {
        let particles = self.particles;
        let touching = if layout.has(Sum::Touching) {
            touching(state)
        } else {
            Vec::new()
        };
        let is_carried = |sum: &Sum| !(uniform && SIZES.contains(sum));
        let sums: Vec<Sum> = layout.of(Spread::Particles).filter(is_carried).collect();
        let numbers = sums.iter().map(|sum| sum.rank().components());
        let width = usize::from(uniform) + numbers.sum::<usize>();
        let vector = |all: &[DVec3], row: usize| all.get(row).copied().unwrap_or(DVec3::ZERO);
        self.at_centres(width, rows, |row, out| {
            let mass = self.mass(row);
            let (v, r) = (particles.velocity[row], particles.radius[row]);
            let spin = vector(&particles.spin, row);
            let turning = vector(&particles.angular_velocity, row);
            let displacement = known(state, row);
            if uniform {
                out.push(1.0);
            }
            for &sum in &sums {
                match sum {
                    Sum::Sizes => {
                        let mut power = 1.0;
                        for _ in 0..6 {
                            out.push(power);
                            power *= r;
                        }
                    }
                    Sum::Volume => out.push(particles.volume[row]),
                    Sum::Mass => out.push(mass),
                    Sum::Momentum => out.vector(mass * v),
                    Sum::MomentumFlux => out.square(mass, v),
                    Sum::Touching => out.push(f64::from(touching[row])),
                    Sum::AngularVelocity => out.vector(turning),
                    Sum::Spin => out.vector(spin),
                    Sum::SpinFlux => out.product(spin, v),
                    Sum::Liquid => out.push(particles.liquid.get(row).copied().unwrap_or(0.0)),
                    Sum::SpinEnergy => out.push(0.5 * spin.dot(turning)),
                    Sum::DisplacedMass => out.push(if displacement.is_some() { mass } else { 0.0 }),
                    Sum::Displacement => {
                        out.vector(mass * displacement.unwrap_or(DVec3::ZERO));
                    }
                    _ => {}
                }
            }
        });
    }

    /// Rows that are spread by the gradient of the kernel: masses and momenta.
    pub(crate) fn gradients(&self, state: &State, layout: &Layout, rows: &mut Rows) {
        let particles = self.particles;
        let sums: Vec<Sum> = layout.of(Spread::Gradients).collect();
        let numbers = |sum: &Sum| match sum {
            Sum::MassGradient | Sum::DisplacedMassGradient => 1,
            _ => 3,
        };
        let width = sums.iter().map(numbers).sum();
        self.at_centres(width, rows, |row, out| {
            let mass = self.mass(row);
            let displacement = known(state, row);
            for &sum in &sums {
                match sum {
                    Sum::MassGradient => out.push(mass),
                    Sum::MomentumGradient => out.vector(mass * particles.velocity[row]),
                    Sum::DisplacedMassGradient => {
                        out.push(if displacement.is_some() { mass } else { 0.0 })
                    }
                    _ => out.vector(mass * displacement.unwrap_or(DVec3::ZERO)),
                }
            }
        });
    }

    /// Segments that carry stress (and moments) and points where boundaries act.
    pub(crate) fn contacts(&self, contacts: &Contacts, layout: &Layout, rows: [&mut Rows; 3]) {
        let wanted = WantedOfContacts {
            lines: layout.of(Spread::Lines).collect(),
            moments: layout.has(Sum::CoupleSum),
            boundary: layout.of(Spread::Boundary).collect(),
        };
        let widths = [
            layout.stride(Spread::Lines),
            layout.stride(Spread::Moments),
            layout.stride(Spread::Boundary),
        ];
        let [lines, moments, boundary] = [
            !wanted.lines.is_empty(),
            wanted.moments,
            !wanted.boundary.is_empty(),
        ]
        .map(usize::from);
        let count = |range: Range<usize>| {
            let mut counts = [0; 3];
            for k in range {
                let pieces = self.pieces(contacts, k);
                let segments = usize::from(pieces.0) + usize::from(pieces.1);
                counts[0] += lines * segments;
                counts[1] += moments * segments;
                counts[2] += boundary * usize::from(pieces.2);
            }
            counts
        };
        fill(contacts.len(), widths, rows, count, |range, parts| {
            self.some_contacts(contacts, range, &wanted, parts);
        });
    }

    /// Whose sides of a contact are fields, particle and partner.
    fn sides(&self, contacts: &Contacts, k: usize) -> [Role; 2] {
        let partner = match contacts.partner[k] {
            Partner::Particle(row) => self.of(row),
            Partner::Wall(_) => Role::Still,
        };
        [self.of(contacts.particle[k]), partner]
    }

    /// Whether a contact has a first and a second segment, and a point where a boundary acts.
    fn pieces(&self, contacts: &Contacts, k: usize) -> (bool, bool, bool) {
        let own = self.sides(contacts, k).map(|role| role == Role::Own);
        match own {
            [false, false] => (false, false, false),
            [true, true] => (true, !Contact::of(contacts, k).is_straight(), false),
            _ => (true, false, true),
        }
    }

    fn some_contacts(
        &self,
        contacts: &Contacts,
        range: Range<usize>,
        wanted: &WantedOfContacts,
        [mut lines, mut moments, mut boundary]: [Part<'_>; 3],
    ) {
        for k in range {
            let contact = Contact::of(contacts, k);
            let [own, partner] = self.sides(contacts, k);
            // Nearly all contacts are between two flowing particles, and straight.
            let segments = match (own == Role::Own, partner == Role::Own) {
                (false, false) => continue,
                (true, true) if contact.is_straight() => [Some(contact.whole()), None],
                (mine, theirs) => [
                    mine.then(|| contact.upper()),
                    theirs.then(|| contact.lower()),
                ],
            };
            for segment in segments.into_iter().flatten() {
                segment.push(contact.normal, wanted, &mut lines, &mut moments);
            }
            // Two own sides meet each other at the point with opposite forces: nothing remains.
            let (side, beyond) = match (own, partner) {
                (Role::Own, Role::Own) => continue,
                (Role::Own, beyond) => (1.0, beyond),
                (beyond, _) => (-1.0, beyond),
            };
            let still = if beyond == Role::Still { side } else { 0.0 };
            for sum in &wanted.boundary {
                let vector = match sum {
                    Sum::BoundaryForce => still * contact.force,
                    Sum::Drag => (side - still) * contact.force,
                    _ => still * contact.couple,
                };
                boundary.vector(vector);
            }
            boundary.place(Original {
                middle: contact.point,
                segment: DVec3::ZERO,
            });
        }
    }
}

/// The displacement of a particle that was there before.
fn known(state: &State, row: usize) -> Option<DVec3> {
    let all = state.displacement.as_ref()?;
    Some(all[row]).filter(|displacement| displacement.is_finite())
}

/// Number of particles that each particle touches; walls do not count.
fn touching(state: &State) -> Vec<u32> {
    let mut counts = vec![0; state.particles.len()];
    if let Some(contacts) = &state.contacts {
        for (particle, partner) in contacts.particle.iter().zip(&contacts.partner) {
            if let Partner::Particle(other) = partner {
                counts[*particle as usize] += 1;
                counts[*other as usize] += 1;
            }
        }
    }
    counts
}

/// One contact with what it transmits.
struct Contact {
    point: DVec3,
    arm: DVec3,
    partner_arm: DVec3,
    normal: DVec3,
    force: DVec3,
    couple: DVec3,
}

/// A piece of a branch vector: `l` leads to `start + l`, where the force acts, from `start`, where its opposite does.
struct Segment {
    start: DVec3,
    l: DVec3,
    force: DVec3,
    /// Couples on both ends.
    end_couple: DVec3,
    start_couple: DVec3,
}

impl Contact {
    fn of(contacts: &Contacts, k: usize) -> Self {
        Self {
            point: contacts.point[k],
            arm: contacts.arm[k],
            partner_arm: contacts.partner_arm[k],
            normal: contacts.normal[k],
            force: contacts.force[k],
            couple: contacts.couple.get(k).copied().unwrap_or(DVec3::ZERO),
        }
    }

    /// Spheres touch on the line between their centres; clumps do not.
    fn is_straight(&self) -> bool {
        let (a, b) = (self.arm, self.partner_arm);
        a.cross(b).length_squared() <= 1e-18 * a.length_squared() * b.length_squared()
            && a.dot(b) <= 0.0
    }

    fn moment(&self) -> DVec3 {
        self.couple - self.arm.cross(self.force)
    }

    fn partner_moment(&self) -> DVec3 {
        self.partner_arm.cross(self.force) - self.couple
    }

    /// From the centre of the partner to that of the particle.
    fn whole(&self) -> Segment {
        Segment {
            start: self.point + self.partner_arm,
            l: self.arm - self.partner_arm,
            force: self.force,
            end_couple: self.moment(),
            start_couple: self.partner_moment(),
        }
    }

    /// From the contact point to the centre of the particle.
    fn upper(&self) -> Segment {
        Segment {
            start: self.point,
            l: self.arm,
            force: self.force,
            end_couple: self.moment(),
            start_couple: -self.couple,
        }
    }

    /// From the centre of the partner to the contact point.
    fn lower(&self) -> Segment {
        Segment {
            start: self.point + self.partner_arm,
            l: -self.partner_arm,
            force: self.force,
            end_couple: self.couple,
            start_couple: self.partner_moment(),
        }
    }
}

impl Segment {
    fn push(
        &self,
        normal: DVec3,
        wanted: &WantedOfContacts,
        lines: &mut Part<'_>,
        moments: &mut Part<'_>,
    ) {
        let original = Original {
            middle: self.start + 0.5 * self.l,
            segment: self.l,
        };
        for sum in &wanted.lines {
            match sum {
                Sum::Stress => lines.product(self.force, self.l),
                Sum::ContactCount => lines.push(1.0),
                Sum::Fabric => lines.square(1.0, normal),
                _ => lines.product(0.5 * (self.end_couple - self.start_couple), self.l),
            }
        }
        lines.place(original);
        if wanted.moments {
            moments.product(self.end_couple + self.start_couple, self.l);
            moments.place(original);
        }
    }
}

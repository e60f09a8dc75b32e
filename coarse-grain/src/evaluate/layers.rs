//! From particles and contacts to rows of numbers: who counts, and what each of them carries.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::images::Original;
use crate::state::{Contacts, Particles, Partner, State};
use crate::sums::{Layout, SYMMETRIC, Spread, Sum};

/// Rows of numbers and where they sit.
#[derive(Debug, Default)]
pub(crate) struct Rows {
    pub values: Vec<f64>,
    pub originals: Vec<Original>,
}

/// The sums of contacts that are wanted.
struct WantedOfContacts {
    lines: Vec<Sum>,
    /// Numbers of them.
    width: usize,
    moments: bool,
    boundary: Vec<Sum>,
}

/// Rows of parts of a list, made by whatever threads there are.
fn chunks<const N: usize>(
    length: usize,
    some: impl Fn(Range<usize>) -> [Rows; N] + Sync,
) -> Vec<[Rows; N]> {
    let chunk = |k: usize| some(k * CHUNK..((k + 1) * CHUNK).min(length));
    (0..length.div_ceil(CHUNK))
        .into_par_iter()
        .map(chunk)
        .collect()
}

/// The parts one behind the other.
fn together<const N: usize>(parts: Vec<[Rows; N]>) -> [Rows; N] {
    let mut parts = parts.into_iter();
    let Some(mut whole) = parts.next() else {
        return [const { Rows::EMPTY }; N];
    };
    // Room for all, as if all parts were as full as the first.
    for rows in &mut whole {
        rows.values.reserve(parts.len() * rows.values.len());
        rows.originals.reserve(parts.len() * rows.originals.len());
    }
    for part in parts {
        for (whole, mut part) in whole.iter_mut().zip(part) {
            whole.values.append(&mut part.values);
            whole.originals.append(&mut part.originals);
        }
    }
    whole
}

impl Rows {
    const EMPTY: Self = Self {
        values: Vec::new(),
        originals: Vec::new(),
    };

    /// Room for so many rows of so many numbers.
    fn for_some(count: usize, width: usize) -> Self {
        Self {
            values: Vec::with_capacity(count * width),
            originals: Vec::with_capacity(count),
        }
    }
}

/// Appends a vector. (`extend` of an array is a call for every three numbers.)
#[inline]
fn push_vector(out: &mut Vec<f64>, v: DVec3) {
    out.extend_from_slice(&[v.x, v.y, v.z]);
}

/// Appends the products of a symmetric tensor, times a factor.
#[inline]
fn push_square(out: &mut Vec<f64>, factor: f64, v: DVec3) {
    out.extend_from_slice(&SYMMETRIC.map(|(a, b)| factor * v[a] * v[b]));
}

/// Particles or contacts that a thread takes in one go.
const CHUNK: usize = 4096;

/// What a particle is to the fields.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    /// Part of the fields.
    Own,
    /// Flows, but is of a material that is left out.
    Other,
    /// Fixed or driven: boundary, as walls are.
    Still,
}

/// What equal particles have in common; these sums stand first in a layout.
pub(crate) const SIZES: [Sum; 3] = [Sum::Sizes, Sum::Volume, Sum::Mass];

/// Who belongs to the fields.
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

    /// A row for each own particle at its centre, of about `width` numbers that `push` appends; made chunk by chunk and put together in their
    /// order.
    fn at_centres(&self, width: usize, push: impl Fn(usize, &mut Vec<f64>) + Sync) -> Rows {
        let parts = chunks(self.particles.len(), |range| {
            let mut rows = Rows::for_some(range.len(), width);
            for row in self.own(range) {
                push(row, &mut rows.values);
                rows.originals.push(Original {
                    middle: self.particles.position[row],
                    segment: DVec3::ZERO,
                });
            }
            [rows]
        });
        let [whole] = together(parts);
        whole
    }

    /// Mass, if it is known.
    fn mass(&self, row: usize) -> f64 {
        self.particles.mass.get(row).copied().unwrap_or(0.0)
    }

    /// What of radius powers, volume and mass the layout wants, if all own particles have the same of it: then one number, spread for all of
    /// them, is enough.
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

    /// What each own particle carries. With `uniform` a one stands for sizes, volume and mass, see [`Self::uniform`].
    pub(crate) fn particles(&self, state: &State, layout: &Layout, uniform: bool) -> Rows {
        let particles = self.particles;
        let touching = if layout.has(Sum::Touching) {
            touching(state)
        } else {
            Vec::new()
        };
        let sums: Vec<Sum> = layout.of(Spread::Particles).collect();
        let vector = |all: &[DVec3], row: usize| all.get(row).copied().unwrap_or(DVec3::ZERO);
        self.at_centres(layout.stride(Spread::Particles), |row, out| {
            let mass = self.mass(row);
            let (v, r) = (particles.velocity[row], particles.radius[row]);
            let spin = vector(&particles.spin, row);
            let turning = vector(&particles.angular_velocity, row);
            let displacement = known(state, row);
            out.extend(uniform.then_some(1.0));
            for &sum in &sums {
                match sum {
                    sum if uniform && SIZES.contains(&sum) => {}
                    Sum::Sizes => {
                        let mut power = 1.0;
                        for _ in 0..6 {
                            out.push(power);
                            power *= r;
                        }
                    }
                    Sum::Volume => out.push(particles.volume[row]),
                    Sum::Mass => out.push(mass),
                    Sum::Momentum => push_vector(out, mass * v),
                    Sum::MomentumFlux => push_square(out, mass, v),
                    Sum::Touching => out.push(f64::from(touching[row])),
                    Sum::AngularVelocity => push_vector(out, turning),
                    Sum::Spin => push_vector(out, spin),
                    Sum::SpinFlux => push_product(out, spin, v),
                    Sum::SpinEnergy => out.push(0.5 * spin.dot(turning)),
                    Sum::DisplacedMass => out.push(if displacement.is_some() { mass } else { 0.0 }),
                    Sum::Displacement => {
                        push_vector(out, mass * displacement.unwrap_or(DVec3::ZERO));
                    }
                    _ => {}
                }
            }
        })
    }

    /// What is spread by the gradient of the kernel: masses and momenta.
    pub(crate) fn gradients(&self, state: &State, layout: &Layout) -> Rows {
        let particles = self.particles;
        let sums: Vec<Sum> = layout.of(Spread::Gradients).collect();
        self.at_centres(layout.stride(Spread::Gradients), |row, out| {
            let mass = self.mass(row);
            let displacement = known(state, row);
            for &sum in &sums {
                match sum {
                    Sum::MassGradient => out.push(mass),
                    Sum::MomentumGradient => push_vector(out, mass * particles.velocity[row]),
                    Sum::DisplacedMassGradient => {
                        out.push(if displacement.is_some() { mass } else { 0.0 })
                    }
                    Sum::DisplacementGradient => {
                        push_vector(out, mass * displacement.unwrap_or(DVec3::ZERO));
                    }
                    _ => {}
                }
            }
        })
    }

    /// Segments that carry stress and points where boundaries act.
    pub(crate) fn contacts(&self, contacts: &Contacts, layout: &Layout) -> [Rows; 3] {
        let wanted = WantedOfContacts {
            lines: layout.of(Spread::Lines).collect(),
            width: layout.stride(Spread::Lines),
            moments: layout.has(Sum::CoupleSum),
            boundary: layout.of(Spread::Boundary).collect(),
        };
        together(chunks(contacts.len(), |range| {
            self.some_contacts(contacts, range, &wanted)
        }))
    }

    fn some_contacts(
        &self,
        contacts: &Contacts,
        range: Range<usize>,
        wanted: &WantedOfContacts,
    ) -> [Rows; 3] {
        // Nearly all contacts are between two flowing particles, and straight.
        let mut lines = Rows::for_some(range.len(), wanted.width);
        let mut moments = Rows::for_some(if wanted.moments { range.len() } else { 0 }, 9);
        let mut boundary = Rows::default();
        for k in range {
            let contact = Contact::of(contacts, k);
            let own = self.of(contacts.particle[k]);
            let partner = match contacts.partner[k] {
                Partner::Particle(row) => self.of(row),
                Partner::Wall(_) => Role::Still,
            };
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
                push_vector(&mut boundary.values, vector);
            }
            boundary.originals.push(Original {
                middle: contact.point,
                segment: DVec3::ZERO,
            });
        }
        [lines, moments, boundary]
    }
}

/// The displacement of a particle that was there before.
fn known(state: &State, row: usize) -> Option<DVec3> {
    let all = state.displacement.as_ref()?;
    Some(all[row]).filter(|displacement| displacement.is_finite())
}

/// How many particles each particle touches; walls do not count.
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

fn push_product(out: &mut Vec<f64>, a: DVec3, b: DVec3) {
    let [x, y, z] = [a.x * b, a.y * b, a.z * b];
    out.extend_from_slice(&[x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z]);
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
    fn push(&self, normal: DVec3, wanted: &WantedOfContacts, lines: &mut Rows, moments: &mut Rows) {
        let original = Original {
            middle: self.start + 0.5 * self.l,
            segment: self.l,
        };
        for sum in &wanted.lines {
            let out = &mut lines.values;
            match sum {
                Sum::Stress => push_product(out, self.force, self.l),
                Sum::ContactCount => out.push(1.0),
                Sum::Fabric => push_square(out, 1.0, normal),
                _ => push_product(out, 0.5 * (self.end_couple - self.start_couple), self.l),
            }
        }
        lines.originals.push(original);
        if wanted.moments {
            push_product(
                &mut moments.values,
                self.end_couple + self.start_couple,
                self.l,
            );
            moments.originals.push(original);
        }
    }
}

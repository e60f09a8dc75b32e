//! Memory of a contact.

use crate::lanes::{Real, Vector};

/// Unit and meaning of one number of a history.
pub type HistoryNumber = (&'static str, &'static str);

/// The memory of one part of a contact, or of several in lanes. It lives in the neighbour list's slot and starts at its default.
pub trait History<L: Real = f64>:
    Copy + Default + Send + Sync + PartialEq + std::fmt::Debug + 'static
{
    /// The memory of one contact.
    type One: History<f64>;
    /// How many numbers it holds.
    const LENGTH: usize;
    /// Unit and meaning of each of these numbers.
    fn columns() -> Vec<HistoryNumber>;
    /// This memory seen by the pair (B, A).
    #[must_use]
    fn swapped(self) -> Self;
    /// Appends its numbers, for restart files and output.
    fn write(&self, numbers: &mut Vec<L>);
    /// Appends the numbers that [`super::NormalLaw::columns`] and its like describe: of a law that is chosen at run time, those
    /// of the law that was chosen.
    fn show(&self, numbers: &mut Vec<L>) {
        self.write(numbers);
    }
    /// Reads [`History::LENGTH`] numbers.
    #[must_use]
    fn read(numbers: &[L]) -> Self;
    /// That of the contact `one(k)` in lane `k`; all of them by the same law.
    #[must_use]
    fn gather(one: impl Fn(usize) -> Self::One) -> Self;
    /// Gathers the memories from where they are kept: a large memory is not copied for each of its numbers.
    #[must_use]
    #[inline(always)]
    fn gather_from<'a>(one: impl Fn(usize) -> &'a Self::One) -> Self {
        Self::gather(|k| *one(k))
    }
    /// Gathers memories of contacts all of which touch: numbers that only act across a gap may be left out, and [`History::put`]
    /// does not write them.
    #[must_use]
    #[inline(always)]
    fn gather_touching<'a>(one: impl Fn(usize) -> &'a Self::One) -> Self {
        Self::gather_from(one)
    }
    /// That of the contact in lane `k`.
    #[must_use]
    fn lane(&self, k: usize) -> Self::One;
    /// Puts what an evaluation may have changed of the contact in lane `k` into the memory that it was [gathered](History::gather) from.
    #[inline(always)]
    fn put(&self, k: usize, one: &mut Self::One) {
        *one = self.lane(k);
    }
}

impl<L: Real> History<L> for () {
    type One = ();
    const LENGTH: usize = 0;
    fn columns() -> Vec<HistoryNumber> {
        Vec::new()
    }
    fn swapped(self) -> Self {}
    fn write(&self, _: &mut Vec<L>) {}
    fn read(_: &[L]) -> Self {}
    #[inline(always)]
    fn gather(_: impl Fn(usize)) -> Self {}
    #[inline(always)]
    fn lane(&self, _: usize) -> Self {}
}

impl<L: Real, A: History<L>, B: History<L>, C: History<L>, D: History<L>> History<L>
    for (A, B, C, D)
{
    type One = (A::One, B::One, C::One, D::One);
    const LENGTH: usize = A::LENGTH + B::LENGTH + C::LENGTH + D::LENGTH;

    fn columns() -> Vec<HistoryNumber> {
        [A::columns(), B::columns(), C::columns(), D::columns()].concat()
    }

    fn swapped(self) -> Self {
        (
            self.0.swapped(),
            self.1.swapped(),
            self.2.swapped(),
            self.3.swapped(),
        )
    }

    fn write(&self, numbers: &mut Vec<L>) {
        self.0.write(numbers);
        self.1.write(numbers);
        self.2.write(numbers);
        self.3.write(numbers);
    }

    fn read(numbers: &[L]) -> Self {
        let (a, rest) = numbers.split_at(A::LENGTH);
        let (b, rest) = rest.split_at(B::LENGTH);
        let (c, d) = rest.split_at(C::LENGTH);
        (A::read(a), B::read(b), C::read(c), D::read(d))
    }

    #[inline(always)]
    fn gather(one: impl Fn(usize) -> Self::One) -> Self {
        (
            A::gather(|k| one(k).0),
            B::gather(|k| one(k).1),
            C::gather(|k| one(k).2),
            D::gather(|k| one(k).3),
        )
    }

    #[inline(always)]
    fn lane(&self, k: usize) -> Self::One {
        (
            self.0.lane(k),
            self.1.lane(k),
            self.2.lane(k),
            self.3.lane(k),
        )
    }

    #[inline(always)]
    fn gather_from<'a>(one: impl Fn(usize) -> &'a Self::One) -> Self {
        (
            A::gather_from(|k| &one(k).0),
            B::gather_from(|k| &one(k).1),
            C::gather_from(|k| &one(k).2),
            D::gather_from(|k| &one(k).3),
        )
    }

    #[inline(always)]
    fn gather_touching<'a>(one: impl Fn(usize) -> &'a Self::One) -> Self {
        (
            A::gather_touching(|k| &one(k).0),
            B::gather_touching(|k| &one(k).1),
            C::gather_touching(|k| &one(k).2),
            D::gather_touching(|k| &one(k).3),
        )
    }

    #[inline(always)]
    fn put(&self, k: usize, one: &mut Self::One) {
        self.0.put(k, &mut one.0);
        self.1.put(k, &mut one.1);
        self.2.put(k, &mut one.2);
        self.3.put(k, &mut one.3);
    }
}

/// A spring in the tangent plane, stretched by the motion of A relative to B, m.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TangentialSpring<L = f64>(pub Vector<L>);

impl<L: Real> History<L> for TangentialSpring<L> {
    type One = TangentialSpring;
    const LENGTH: usize = 3;

    fn columns() -> Vec<HistoryNumber> {
        vec![
            ("m", "tangential spring x"),
            ("m", "tangential spring y"),
            ("m", "tangential spring z"),
        ]
    }

    fn swapped(self) -> Self {
        Self(-self.0)
    }

    fn write(&self, numbers: &mut Vec<L>) {
        numbers.extend(self.0.to_array());
    }

    fn read(numbers: &[L]) -> Self {
        Self(Vector::from_slice(numbers))
    }

    #[inline(always)]
    fn gather(one: impl Fn(usize) -> TangentialSpring) -> Self {
        Self(Vector::gather(|k| one(k).0))
    }

    #[inline(always)]
    fn lane(&self, k: usize) -> TangentialSpring {
        TangentialSpring(self.0.lane(k))
    }
}

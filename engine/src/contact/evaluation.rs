//! The composition of one contact from its parts.

use glam::DVec3;

use super::{
    AdhesionForce, AdhesionLaw, Contact, NoAdhesion, NormalForce, NormalLaw, RollingLaw,
    TangentialLaw,
};
use crate::lanes::{Real, Vector};

/// The law of one pair of materials.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairLaw<N, T, R, A = NoAdhesion> {
    /// Normal part.
    pub normal: N,
    /// Tangential part.
    pub tangential: T,
    /// Rolling and torsion.
    pub rolling: R,
    /// Adhesion.
    pub adhesion: A,
}

/// Memory of a contact of all parts of a pair's law.
pub type Histories<N, T, R, A = NoAdhesion, L = f64> = (
    <N as NormalLaw>::History<L>,
    <T as TangentialLaw>::History<L>,
    <R as RollingLaw>::History<L>,
    <A as AdhesionLaw>::History<L>,
);

/// Action of a contact on A; B gets the opposite force and couple.
#[derive(Debug, Clone, Copy)]
pub struct Action<L = f64> {
    /// Whole force on A, N.
    pub force: Vector<L>,
    /// Its part in the tangent plane by friction, N.
    pub tangential: Vector<L>,
    /// Couple on A beyond the lever arm of the force, N m.
    pub couple: Vector<L>,
    /// Normal part: elastic and viscous, N.
    pub normal: NormalForce<L>,
    /// Adhesion.
    pub adhesion: AdhesionForce<L>,
}

impl<L: Real> Action<L> {
    /// The force in the tangent plane, which turns the particles, N: friction, and that of adhesion where it `shears`.
    #[inline(always)]
    #[must_use]
    pub fn shear(&self, shears: bool) -> Vector<L> {
        if shears {
            self.tangential + self.adhesion.tangential
        } else {
            self.tangential
        }
    }

    /// Nothing.
    pub const NONE: Self = Self {
        force: Vector::ZERO,
        tangential: Vector::ZERO,
        couple: Vector::ZERO,
        normal: NormalForce::NONE,
        adhesion: AdhesionForce::NONE,
    };

    /// `action(k)` in lane `k`.
    #[inline(always)]
    #[must_use]
    pub fn gather(action: impl Fn(usize) -> Action) -> Self {
        Self {
            force: Vector::gather(|k| action(k).force),
            tangential: Vector::gather(|k| action(k).tangential),
            couple: Vector::gather(|k| action(k).couple),
            normal: NormalForce::gather(|k| action(k).normal),
            adhesion: AdhesionForce::gather(|k| action(k).adhesion),
        }
    }

    /// That of the contact in lane `k`.
    #[inline(always)]
    #[must_use]
    pub fn lane(&self, k: usize) -> Action {
        Action {
            force: self.force.lane(k),
            tangential: self.tangential.lane(k),
            couple: self.couple.lane(k),
            normal: self.normal.lane(k),
            adhesion: self.adhesion.lane(k),
        }
    }
}

impl<N: NormalLaw, T: TangentialLaw, R: RollingLaw, A: AdhesionLaw> PairLaw<N, T, R, A> {
    /// Whether it may turn particles: laws that never do need no angular velocities and give no torques.
    pub const TURNS: bool = T::ACTIVE || R::ACTIVE || A::SHEARS || A::TWISTS;

    /// Force and couple of two that touch, and the history one step `dt` (s) on. `dt` = 0 leaves springs unstretched.
    ///
    /// Order: the normal force; adhesion; friction and rolling, which the whole normal force F_n and the load of adhesion limit, rolling by
    /// the absolute value of their sum.
    #[inline(always)]
    pub fn act<L: Real>(
        &self,
        contact: &Contact<L>,
        dt: f64,
        history: &mut Histories<N, T, R, A, L>,
    ) -> Action<L> {
        let joined;
        let contact = if A::JOINS {
            joined = self.adhesion.as_hertz(contact);
            &joined
        } else {
            contact
        };
        let normal = self.normal.force(contact, &mut history.0);
        let normal_total = normal.total();
        let mut adhesion = AdhesionForce::NONE;
        if A::ACTIVE {
            adhesion = self.adhesion.force(contact, dt, &mut history.3);
        }
        let load = friction_load::<A, L>(normal_total, &adhesion);
        let tangential = (self.tangential).force(contact, load, dt, &mut history.1);
        let mut couple = if R::ACTIVE {
            let stiffness = self.tangential.stiffness(contact);
            self.rolling
                .couple(contact, load.abs(), stiffness, dt, &mut history.2)
        } else {
            Vector::ZERO
        };
        let mut force = contact.normal * normal_total;
        if self.tangential.acts() {
            force += tangential;
        }
        if A::ACTIVE {
            force += adhesion_on_a::<A, L>(contact, &adhesion);
        }
        if A::TWISTS {
            couple += adhesion.couple;
        }
        Action {
            force,
            tangential,
            couple,
            normal,
            adhesion,
        }
    }

    /// Action on two that do not touch: adhesion alone. The memory of the other parts ends with the touch.
    #[inline(always)]
    pub fn act_apart<L: Real>(
        &self,
        contact: &Contact<L>,
        dt: f64,
        history: &mut Histories<N, T, R, A, L>,
    ) -> Action<L> {
        let memory = history.3;
        *history = Default::default();
        history.3 = memory;
        let adhesion = self.adhesion.force(contact, dt, &mut history.3);
        Action {
            force: adhesion_on_a::<A, L>(contact, &adhesion),
            tangential: Vector::ZERO,
            couple: adhesion.couple,
            normal: NormalForce::NONE,
            adhesion,
        }
    }

    /// Whether the two touch: they overlap, or a neck joins them across a gap.
    #[inline(always)]
    #[must_use]
    pub fn touches(&self, contact: &Contact, history: &Histories<N, T, R, A>) -> bool {
        contact.overlap > 0.0 || A::JOINS && self.adhesion.is_joined(contact, &history.3)
    }

    /// Energy that the contact of two that touch could still give back, J.
    pub fn energy<L: Real>(&self, contact: &Contact<L>, history: &Histories<N, T, R, A, L>) -> L {
        let mut energy =
            self.normal_energy(contact, history) + self.friction_energy(contact, history);
        if A::ACTIVE {
            energy = energy + self.adhesion_energy(contact, history);
        }
        energy
    }

    /// The part of it that the normal law stores, J.
    pub fn normal_energy<L: Real>(
        &self,
        contact: &Contact<L>,
        history: &Histories<N, T, R, A, L>,
    ) -> L {
        (self.normal).energy(&self.adhesion.as_hertz(contact), &history.0)
    }

    /// The part of it that adhesion stores, J.
    pub fn adhesion_energy<L: Real>(
        &self,
        contact: &Contact<L>,
        history: &Histories<N, T, R, A, L>,
    ) -> L {
        (self.adhesion).energy(&self.adhesion.as_hertz(contact), &history.3)
    }

    /// Energy that adhesion dissipated since the geometry was `last`, J. Histories: before and after the step. Where the normal force and
    /// adhesion are one force, all of it counts: it jumps where the two touch and where they part.
    #[must_use]
    pub fn adhesion_loss(
        &self,
        contact: &Contact,
        last: &Contact,
        action: &Action,
        [before, after]: [&Histories<N, T, R, A>; 2],
    ) -> f64 {
        let elastic = action.adhesion.normal.elastic;
        if !(A::JOINS && self.adhesion.is_one_with_normal()) {
            return (self.adhesion).loss(contact, last, elastic, [&before.3, &after.3]);
        }
        let stored = |contact: &Contact, history| {
            if self.touches(contact, history) {
                self.normal_energy(contact, history) + self.adhesion_energy(contact, history)
            } else {
                0.0
            }
        };
        let mut both = action.normal.elastic + elastic;
        if self.touches(last, before) {
            let earlier = self.act(last, 0.0, &mut before.clone());
            both += earlier.normal.elastic + earlier.adhesion.normal.elastic;
        }
        let work = 0.5 * both * (contact.overlap - last.overlap);
        work - (stored(contact, after) - stored(last, before))
    }

    /// The part of [`PairLaw::energy`] stored in the tangential, rolling and torsion springs, J.
    pub fn friction_energy<L: Real>(
        &self,
        contact: &Contact<L>,
        history: &Histories<N, T, R, A, L>,
    ) -> L {
        let contact = &self.adhesion.as_hertz(contact);
        let mut energy = self.tangential.energy(contact, &history.1);
        if R::ACTIVE {
            let stiffness = self.tangential.stiffness(contact);
            energy = energy + self.rolling.energy(stiffness, &history.2);
        }
        energy
    }

    /// The way by which a contact has slid in a step of `dt` (s) beyond what its friction spring took up, m. Histories: before and
    /// after the step.
    #[must_use]
    pub fn slip(
        &self,
        contact: &Contact,
        action: &Action,
        before: &Histories<N, T, R, A>,
        after: &Histories<N, T, R, A>,
        dt: f64,
    ) -> f64 {
        let contact = &self.adhesion.as_hertz(contact);
        let load = friction_load::<A, f64>(action.normal.total(), &action.adhesion);
        if load > 0.0 {
            (self.tangential).slip(contact, load, dt, [&before.1, &after.1])
        } else {
            contact.tangential_velocity.length() * dt
        }
    }

    /// State of friction in a contact after an evaluation of it.
    #[must_use]
    pub fn friction_now(
        &self,
        contact: &Contact,
        action: &Action,
        history: &Histories<N, T, R, A>,
    ) -> FrictionNow {
        let contact = &self.adhesion.as_hertz(contact);
        FrictionNow {
            load: friction_load::<A, f64>(action.normal.total(), &action.adhesion),
            force: action.tangential.into(),
            stored: self.tangential.energy(contact, &history.1),
        }
    }
}

/// State of friction in a contact at the time of an evaluation: what sliding dissipates in the next step begins with it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FrictionNow {
    /// Force that limits friction, N; positive where it presses.
    pub load: f64,
    /// Force of friction on A, N.
    pub force: DVec3,
    /// Energy of its spring, J.
    pub stored: f64,
}

impl FrictionNow {
    /// Mean of |F_n| over the step from these forces to those of `next`, N.
    #[must_use]
    pub fn mean_load(&self, next: &Self) -> f64 {
        0.5 * (self.load.abs() + next.load.abs())
    }

    /// Energy that sliding and the tangential dashpot dissipate in the step of `dt` (s) from these forces to those of `next`, J: the work of the mean
    /// tangential force less what the tangential spring gains. `sliding`: tangential velocity of A in that step, m/s.
    ///
    /// Each force acts over half of the step before it and half of the step behind it, as in the energy audit. So the sum over a contact is of second
    /// order in the step. Springs count at the stiffness of their own time: what a change of stiffness takes or gives is part of the dissipation, as
    /// the forces do no work for it.
    #[must_use]
    pub fn loss_until(&self, next: &Self, sliding: DVec3, dt: f64) -> f64 {
        let force = 0.5 * (self.force + next.force);
        -(force.dot(sliding) * dt) - (next.stored - self.stored)
    }
}

crate::state::plain!(FrictionNow {
    load,
    force,
    stored
});

/// The force that limits friction and rolling, N: the normal law's, and what adhesion adds to it.
#[inline(always)]
fn friction_load<A: AdhesionLaw, L: Real>(normal: L, adhesion: &AdhesionForce<L>) -> L {
    if A::PRESSES {
        normal + adhesion.friction_load
    } else {
        normal
    }
}

/// The whole force of adhesion on A, N.
#[inline(always)]
fn adhesion_on_a<A: AdhesionLaw, L: Real>(
    contact: &Contact<L>,
    adhesion: &AdhesionForce<L>,
) -> Vector<L> {
    let along = contact.normal * adhesion.normal.total();
    if A::SHEARS {
        along + adhesion.tangential
    } else {
        along
    }
}

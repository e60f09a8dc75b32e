//! Interface of a law for the plan: its keys in a scene, how it comes from two materials, and how stiff it is at most.

use mercury_common::scene::LawKeys;

use super::mixing::{Friction, Pair};
use super::{AnyNormal, AnyTangential, NormalLaw, RollingLaw, TangentialLaw};

/// A spring with a dashpot beside it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SpringAndDashpot {
    /// N/m.
    pub stiffness: f64,
    /// kg/s.
    pub dissipation: f64,
}

/// The contact for which [`PlannedNormal::examples`] are made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// Stiffness of the laws where they are stiffest, at an overlap of a tenth of the radius, N/m.
    pub stiffness: f64,
    /// R*, m.
    pub radius: f64,
    /// m*, kg.
    pub mass: f64,
}

impl Scale {
    /// Of a dashpot with which a spring of this stiffness is critically damped, 2 sqrt(m* k), kg/s.
    #[must_use]
    pub fn critical_dissipation(&self) -> f64 {
        2.0 * (self.mass * self.stiffness).sqrt()
    }
}

/// A normal law that scenes can name.
pub trait PlannedNormal: NormalLaw {
    /// Keys in scenes that name the law and give its parameters.
    const KEYS: &'static LawKeys;

    /// The law of two materials; errors are recorded in the pair.
    fn of_scene(pair: &mut Pair<'_>) -> Option<Self>;

    /// Duration (s) of a head-on collision at `speed` (m/s), for m* (kg) and R* (m); of an overdamped one, that without damping.
    fn duration(&self, effective_mass: f64, effective_radius: f64, speed: f64) -> f64;

    /// Spring and dashpot where they are stiffest in an impact at `speed` (m/s), for m* (kg) and R* (m); and the contact radius
    /// there, m (0: the law has none).
    fn stiffest(
        &self,
        effective_mass: f64,
        effective_radius: f64,
        speed: f64,
    ) -> (SpringAndDashpot, f64);

    /// Its stiffness (N/m), if that is constant: what `stiffness_ratio` refers to.
    fn spring(&self) -> Option<f64> {
        None
    }

    /// beta of a dashpot beta sqrt(m* k_n), if it has one: what the default of Mindlin's `damping` refers to.
    fn beta(&self) -> Option<f64> {
        None
    }

    /// Laws of this kind, damped, such that each of its branches is taken by one of them: those that all tests of laws run.
    fn examples(scale: &Scale) -> Vec<Self>;
}

/// A tangential law where it is stiffest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StiffestTangential {
    /// Spring and dashpot.
    pub spring: SpringAndDashpot,
    /// k_t that rolling and torsion springs take, N/m.
    pub full: f64,
    /// Whether friction bounds what an unstable spring does, because it never passes an overlap that is an estimate.
    pub is_bounded: bool,
}

/// A tangential law that scenes can name.
pub trait PlannedTangential: TangentialLaw {
    /// Keys in scenes that name the law and give its parameters.
    const KEYS: &'static LawKeys;

    /// The law of two materials beside their normal law; errors are recorded in the pair.
    fn of_scene(
        pair: &mut Pair<'_>,
        normal: &AnyNormal,
        friction: Friction,
    ) -> Option<AnyTangential>;
}

/// A rolling law that scenes can name.
pub trait PlannedRolling: RollingLaw {
    /// Keys in scenes that name the law and give its parameters.
    const KEYS: &'static LawKeys;

    /// Whether the law of two materials takes its stiffness from the tangential one, which then stays even without friction.
    fn needs_tangential_stiffness(pair: &mut Pair<'_>) -> bool;

    /// The law of two materials beside their tangential law: `Some(None)` if they have none; errors are recorded in the pair.
    fn of_scene(pair: &mut Pair<'_>, tangential: &AnyTangential) -> Option<Option<Self>>;

    /// Its springs for R* (m) and k_t (N/m): lever (m), spring and dashpot, and its name.
    fn stiffest(
        &self,
        effective_radius: f64,
        tangential_stiffness: f64,
    ) -> Vec<(f64, SpringAndDashpot, &'static str)>;
}

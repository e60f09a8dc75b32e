//! Coulomb's limit on a spring and a dashpot that act side by side.

use mercury_common::scene::CoulombLimits;

use crate::lanes::{Mask, Real, Vector};

/// Coulomb's limits on the force along the tangent plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slider<L: Real> {
    rule: CoulombLimits,
    /// The force at which it starts to slide, N.
    static_limit: L,
    /// The force while it slides, N.
    dynamic_limit: L,
}

/// Force of a spring and a dashpot after Coulomb's limit.
pub(super) struct Limited<L: Real> {
    /// The force on A, N.
    pub force: Vector<L>,
    /// Part of it that the spring carries from now on where it slides, N; elsewhere the spring stays as it was.
    pub carried: Vector<L>,
    /// Where the spring has to be set back to what it carries.
    pub slides: L::Mask,
}

/// No dashpot is stronger (kg/s): its force must be a number when it is squared. It means Coulomb's friction without a spring.
pub(super) const STRONGEST_DASHPOT: f64 = 1e100;

impl<L: Real> Slider<L> {
    /// From the whole normal force (N; negative: it pulls) and the coefficients of sliding and of holding.
    #[inline(always)]
    pub(super) fn new(
        rule: CoulombLimits,
        normal_force: L,
        friction: f64,
        static_friction: f64,
    ) -> Self {
        let pressure = match rule {
            // A tensile force does not press.
            CoulombLimits::Bounded => normal_force.max(L::ZERO),
            CoulombLimits::Elastic | CoulombLimits::Total => normal_force.abs(),
        };
        Self {
            rule,
            static_limit: pressure * static_friction,
            dynamic_limit: pressure * friction,
        }
    }

    /// Where the law does nothing, and its spring stays as it is: by the rules of other codes where no force presses or pulls.
    /// By ours a spring that nothing presses is let go.
    #[inline(always)]
    pub(super) fn idle(rule: CoulombLimits, normal_force: L) -> L::Mask {
        match rule {
            CoulombLimits::Bounded => L::ZERO.below(L::ZERO),
            CoulombLimits::Elastic | CoulombLimits::Total => normal_force.equals(L::ZERO),
        }
    }

    /// The force of a spring that pulls by `elastic` and a dashpot that brakes by `damping`, N.
    #[inline(always)]
    pub(super) fn limit(&self, elastic: Vector<L>, damping: Vector<L>) -> Limited<L> {
        match self.rule {
            CoulombLimits::Bounded => self.bounded(elastic, damping),
            CoulombLimits::Elastic => {
                let (mut force, slides) = self.cut(elastic);
                let carried = force;
                if !slides.all() {
                    force = Vector::select(slides, force, force - damping);
                }
                Limited {
                    force,
                    carried,
                    slides,
                }
            }
            CoulombLimits::Total => {
                let (force, slides) = self.cut(elastic - damping);
                Limited {
                    force,
                    carried: force + damping,
                    slides,
                }
            }
        }
    }

    /// The elastic force alone decides whether the contact slides: then it is cut, and nothing is viscous. Else the sum is scaled
    /// back to what the contact holds.
    #[inline(always)]
    fn bounded(&self, elastic: Vector<L>, damping: Vector<L>) -> Limited<L> {
        let most = self.static_limit * self.static_limit;
        let elastic_squared = elastic.length_squared();
        let slides = !elastic_squared.at_most(most);
        let mut trial = elastic - damping;
        let mut squared = trial.length_squared();
        let mut limit = self.static_limit;
        if slides.any() {
            trial = Vector::select(slides, elastic, trial);
            squared = L::select(slides, elastic_squared, squared);
            limit = L::select(slides, self.dynamic_limit, limit);
        }
        let cut = !squared.at_most(most);
        let mut force = trial;
        if cut.any() {
            force = Vector::select(cut, trial * (limit / squared.sqrt()), trial);
        }
        Limited {
            force,
            carried: force,
            slides,
        }
    }

    /// A force cut to the limits: at most that at which the contact starts to slide, and that of sliding beyond. Returns the force
    /// and where it slides.
    #[inline(always)]
    pub(super) fn cut(&self, trial: Vector<L>) -> (Vector<L>, L::Mask) {
        let squared = trial.length_squared();
        let slides = !squared.at_most(self.static_limit * self.static_limit);
        let mut force = trial;
        if slides.any() {
            force = Vector::select(slides, trial * (self.dynamic_limit / squared.sqrt()), trial);
        }
        (force, slides)
    }
}

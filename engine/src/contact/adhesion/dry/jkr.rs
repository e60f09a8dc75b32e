//! The contact of Johnson, Kendall & Roberts.

use std::f64::consts::PI;

use libm::cbrt;

use super::super::{AdhesionForce, Contact, NormalForce};
use super::Held;
use crate::contact::SpringAndDashpot;
use crate::lanes::{Mask, Real};

/// δ = a²/R* − √(2π W a/E*), F = 4 E* a³/(3 R*) − √(8π W E* a³), the larger root a (Johnson, Kendall & Roberts 1971, eqs. 18 and 21).
///
/// The first part of F is Hertz' force of a contact with the radius a. So the normal law is evaluated at Hertz' overlap a²/R* of this
/// radius, which also gives the dashpot β √(m* 4/3 E* a) and Mindlin's stiffness 8 G* a, and this law adds the second part.
///
/// A contact begins with the touch, at δ = 0 with the radius a₀³ = 2π W R*²/E* and the force −4/3 π W R*. It holds while the two part,
/// up to δ_f = −3 a_f²/R* with a_f³ = π W R*²/(8 E*) = a₀³/16 and the force −5/6 π W R*. The largest pull is F_c = 3/2 π W R*. The limits of
/// friction and rolling are those of F + 2 F_c (Thornton 1991).
///
/// ```
/// use mercury_engine::contact::adhesion::dry::Jkr;
/// // T28: E* = 1e8/(2 (1 - 0.3²)) Pa, W = 0.05 J/m², R* = 50 µm
/// let law = Jkr::new(0.05, 1e8 / 1.82);
/// let f = |overlap: f64| law.force_at(overlap, 5e-5);
/// assert!((f(1e-7) - 7.517437405e-6).abs() < 1e-14);
/// assert!((f(0.0) + 1.047197551e-5).abs() < 1e-14);
/// assert!((law.end(5e-5) - 5.565601510e-8).abs() < 1e-17);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jkr {
    /// W, J/m^2.
    pub work_of_adhesion: f64,
    /// E*, Pa.
    pub effective_modulus: f64,
    /// Largest gap at which contacts of the scene are evaluated, m.
    pub(super) range: f64,
    /// 2π W/E*, m.
    length: f64,
    /// 8π W E*, N^2/m^3.
    neck: f64,
}

/// δ_f over a₀²/R*: −3/16^(2/3).
const END: f64 = -0.472_470_393_710_577_5;

/// Steps of Newton's method that give the root of [`Jkr::hertz_overlap`] to round-off from its first guess, everywhere on the curve.
const STEPS: usize = 5;

/// Part of the radius that a contact is evaluated beyond its end, so that the evaluation in which it parts is never left out.
const BEYOND: f64 = 0.01;

/// At a concave wall R* is at most so many radii.
const CONFORMING: f64 = 10.0;

impl Jkr {
    /// From W (J/m^2) and E* (Pa).
    #[must_use]
    pub fn new(work_of_adhesion: f64, effective_modulus: f64) -> Self {
        Self {
            work_of_adhesion,
            effective_modulus,
            range: 0.0,
            length: 2.0 * PI * work_of_adhesion / effective_modulus,
            neck: 8.0 * PI * work_of_adhesion * effective_modulus,
        }
    }

    /// The law with its range between particles of radii up to this one (m).
    pub(super) fn reaching(self, largest_radius: f64) -> Self {
        let range = self.end(CONFORMING * largest_radius) + BEYOND * largest_radius;
        Self { range, ..self }
    }

    /// a₀²/R*, m: the unit of overlaps, for R* (m).
    #[inline(always)]
    fn unit(&self, effective_radius: f64) -> f64 {
        let radius = self.zero_radius(effective_radius);
        radius * radius / effective_radius
    }

    /// a₀, m: the radius at δ = 0, for R* (m).
    #[inline(always)]
    fn zero_radius(&self, effective_radius: f64) -> f64 {
        cbrt(self.length * (effective_radius * effective_radius))
    }

    /// −δ_f, m: the gap at which a contact ends, for R* (m).
    #[inline(always)]
    #[must_use]
    pub fn end(&self, effective_radius: f64) -> f64 {
        -END * self.unit(effective_radius)
    }

    /// a²/R*, m: the overlap at which Hertz' contact has the radius of this one.
    ///
    /// With a = a₀ t² and d = δ R*/a₀² the radius is the largest root of t⁴ − t = d. Ferrari's factors of t⁴ − t − d are t² ± α t + ..,
    /// with u = α² the root of u³ + 4 d u = 1, which is simple on the whole curve, also at its end, where t is a double root. Newton's
    /// method takes a fixed number of steps, so that the bits do not depend on other lanes.
    #[inline(always)]
    fn hertz_overlap<L: Real>(&self, overlap: L, effective_radius: L) -> L {
        let unit = L::from_lanes(|k| self.unit(effective_radius.lane(k)));
        let d = (overlap / unit).max(L::splat(END));
        // The tangent at d = 0 on the left; on the right the smaller of two bounds.
        let left = d * (-4.0 / 3.0) + 1.0;
        let right = (L::splat(0.25) / d).min(L::ONE);
        let mut u = L::select(L::ZERO.below(d), right, left);
        for _ in 0..STEPS {
            let square = u * u;
            u = (square * u * 2.0 + 1.0) / (square * 3.0 + d * 4.0);
        }
        let alpha = u.sqrt();
        let root = (L::splat(2.0) / alpha - u).max(L::ZERO).sqrt();
        let t = (alpha + root) * 0.5;
        let square = t * t;
        square * square * unit
    }

    /// The contact by Hertz with the same radius.
    #[inline(always)]
    pub(super) fn as_hertz<L: Real>(&self, contact: &Contact<L>) -> Contact<L> {
        Contact {
            overlap: self.hertz_overlap(contact.overlap, contact.effective_radius),
            ..*contact
        }
    }

    /// The second part of the force, for a contact as [`Jkr::as_hertz`] shows it; none where the two are apart.
    #[inline(always)]
    pub(super) fn force<L: Real>(
        &self,
        contact: &Contact<L>,
        held: &mut Held<L>,
    ) -> AdhesionForce<L> {
        let touches = L::ZERO.below(contact.overlap);
        held.0 = L::select(touches, L::ONE, L::ZERO);
        if !touches.any() {
            return AdhesionForce::NONE;
        }
        let radius = contact.contact_radius();
        let pull = (radius * self.neck).sqrt() * radius;
        let pull = L::select(touches, pull, L::ZERO);
        let most = contact.effective_radius * (3.0 * PI * self.work_of_adhesion);
        AdhesionForce {
            friction_load: most - pull,
            ..AdhesionForce::along(NormalForce {
                elastic: -pull,
                viscous: L::ZERO,
            })
        }
    }

    /// Energy of the whole contact less that of Hertz' contact with the same radius, J: π W a² − 4/3 √(2π W E* a) a³/R*.
    ///
    /// Elastic energy of the contact: E* a (δ² − 2/3 δ a²/R* + 1/5 a⁴/R*²) (Johnson 1985, eq. 5.47); energy of its surfaces: −π W a².
    pub(super) fn energy<L: Real>(&self, contact: &Contact<L>) -> L {
        let radius = contact.contact_radius();
        let square = radius * radius;
        let neck = (radius * (0.25 * self.neck)).sqrt() * radius * square;
        let energy =
            square * (PI * self.work_of_adhesion) - neck / contact.effective_radius * (4.0 / 3.0);
        L::select(L::ZERO.below(contact.overlap), energy, L::ZERO)
    }

    /// F, N, of two that are joined, for δ and R* (m).
    #[must_use]
    pub fn force_at(&self, overlap: f64, effective_radius: f64) -> f64 {
        let hertz = self.hertz_overlap(overlap, effective_radius);
        let radius = (hertz * effective_radius).sqrt();
        4.0 / 3.0 * self.effective_modulus * radius * hertz - (radius * self.neck).sqrt() * radius
    }

    /// Spring and dashpot where the contact is stiffest in an impact at `speed` (m/s), and the contact radius there (m).
    ///
    /// With a = a₀ t²: dF/dδ = 2 E* a (4t³ − 3)/(4t³ − 1), largest at the deepest point of the impact, whose energy
    /// E* a₀⁵/R*² (8/15 t¹⁰ + t⁴/2 − 4/3 t⁷) is 1/2 m* v². Between the largest pull (t³ = 3/4) and the end (t³ = 1/4) the slope is
    /// negative and grows beyond all bounds. It acts for a moment only, and what counts is how much the force changes there: the neck
    /// enters with the slope of the chord over this branch, (2/3 π W R*)/(δ_c − δ_f) = 1.3587 E* a₀.
    pub(super) fn stiffest(
        &self,
        beta: f64,
        effective_mass: f64,
        effective_radius: f64,
        speed: f64,
    ) -> (SpringAndDashpot, f64) {
        let zero_radius = self.zero_radius(effective_radius);
        let overlap = zero_radius * zero_radius / effective_radius;
        let unit = self.effective_modulus * zero_radius * overlap * overlap;
        let energy = 0.5 * effective_mass * speed * speed / unit;
        let stored = |t: f64| {
            let (t3, t4) = (t * t * t, t * t * t * t);
            t4 * (0.5 - 4.0 / 3.0 * t3 + 8.0 / 15.0 * t3 * t3)
        };
        // Beyond the largest energy the first term alone is a bound.
        let (mut low, mut high) = (cbrt(1.5), 2.0 + libm::pow(2.0 * energy, 0.1));
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if stored(middle) < energy {
                low = middle;
            } else {
                high = middle;
            }
        }
        let t3 = high * high * high;
        let radius = zero_radius * high * high;
        let slope = (4.0 * t3 - 3.0) / (4.0 * t3 - 1.0);
        let tangent = 2.0 * self.effective_modulus * radius * slope;
        let chord = CHORD * self.effective_modulus * zero_radius;
        let secant = 4.0 / 3.0 * self.effective_modulus * radius;
        let spring = SpringAndDashpot {
            stiffness: tangent.max(chord),
            dissipation: beta * (effective_mass * secant).sqrt(),
        };
        (spring, radius)
    }
}

/// (1/3)/(d_c − d_f): the chord of the branch between the largest pull, d_c = −1/4 (3/4)^(1/3), and the end, over E* a₀.
const CHORD: f64 = 1.358_712_342_884_912;

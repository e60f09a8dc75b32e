//! Kernels: how a particle is spread over space, and the line integrals of the same along a segment.
//!
//! A kernel `phi` is a function of the distance in the resolved coordinates that integrates to 1 over them. Its line
//! integral `psi(r) = int_0^1 phi(r - x - s l) ds` spreads what a contact carries along its branch vector `l`
//! (Goldhirsch, *Granular Matter* 12, 239, 2010). Formulas and their conventions: `docs/theory/coarse-graining.md`.

pub(crate) mod exponential;
mod line_norm;
mod polynomial;
pub mod quadrature;
#[cfg(test)]
mod tests;

use std::f64::consts::{PI, SQRT_2};

use glam::DVec3;

use line_norm::LineNorm;
use polynomial::Polynomial;
use quadrature::LineRules;

/// The function of distance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum KernelShape {
    /// `exp(-r^2 / (2 w^2))`, cut where it is small; the width is the standard deviation in each direction.
    #[default]
    Gaussian,
    /// `(1 + 3 r/w) (1 - r/w)^3` (Lucy, *Astronomical Journal* 82, 1013, 1977); the width is the radius.
    Lucy,
    /// `1 - r/w`; the width is the radius.
    Linear,
    /// Constant inside the radius, which is the width.
    Heaviside,
}

impl KernelShape {
    /// The name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Gaussian => "gaussian",
            Self::Lucy => "lucy",
            Self::Linear => "linear",
            Self::Heaviside => "heaviside",
        }
    }
}

/// Where the line integral of a cut Gaussian ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LineCut {
    /// On the ellipsoid around the segment with half axes cut-off + L/2 and cut-off.
    #[default]
    Ellipsoid,
    /// On the cylinder of MercuryCG: the cut-off around the segment and beyond its ends.
    Cylinder,
}

/// Definition of a kernel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KernelChoice {
    /// The function.
    pub shape: KernelShape,
    /// Standard deviation (Gaussian) or radius (polynomials), in m.
    pub width: f64,
    /// Where a Gaussian is cut, in widths.
    pub cutoff: f64,
    /// Error of line integrals of a Gaussian on grids, relative to their largest value.
    pub tolerance: f64,
    /// Where line integrals of a Gaussian are cut.
    pub line_cut: LineCut,
}

/// The default cut-off of a Gaussian, in widths.
pub const DEFAULT_CUTOFF: f64 = 4.0;
/// The default tolerance of line integrals.
pub const DEFAULT_TOLERANCE: f64 = 1e-3;
/// The cut-off of coarse answers, in widths.
pub const FAST_CUTOFF: f64 = 2.5;
/// The tolerance of coarse answers.
pub const FAST_TOLERANCE: f64 = 5e-2;

impl KernelChoice {
    /// A kernel of this shape and width with the usual cut-off and tolerance.
    #[must_use]
    pub fn new(shape: KernelShape, width: f64) -> Self {
        Self {
            shape,
            width,
            cutoff: DEFAULT_CUTOFF,
            tolerance: DEFAULT_TOLERANCE,
            line_cut: LineCut::default(),
        }
    }
}

/// A kernel in a space of as many dimensions as coordinates are resolved.
#[derive(Debug, Clone)]
pub struct Kernel {
    choice: KernelChoice,
    dimensions: usize,
    /// Factor of the Gaussian or of the polynomial, 1/m^dimensions.
    norm: f64,
    reach: f64,
    polynomial: Option<Polynomial>,
    line_norm: LineNorm,
    rules: LineRules,
}

impl Kernel {
    /// The kernel for so many resolved coordinates (0 to 3). Without any, kernel and line integral are 1.
    #[must_use]
    pub fn new(choice: KernelChoice, dimensions: usize) -> Self {
        let KernelChoice {
            shape,
            width: w,
            cutoff,
            ..
        } = choice;
        let polynomial = Polynomial::of(shape);
        let (norm, reach) = match &polynomial {
            Some(polynomial) => (polynomial.norm(dimensions, w), w),
            None => (gaussian_norm(dimensions, w, cutoff), cutoff * w),
        };
        let line_norm = match polynomial {
            Some(_) => LineNorm::none(),
            None => LineNorm::new(dimensions, w, reach, choice.line_cut),
        };
        Self {
            choice,
            dimensions,
            norm,
            reach,
            polynomial,
            line_norm,
            rules: LineRules::new(choice.tolerance),
        }
    }

    /// Definition of the kernel.
    #[must_use]
    pub fn choice(&self) -> &KernelChoice {
        &self.choice
    }

    /// The number of resolved coordinates.
    #[must_use]
    pub fn dimensions(&self) -> usize {
        self.dimensions
    }

    /// The distance beyond which the kernel is zero, in m.
    #[must_use]
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// The value where the distance is zero.
    #[must_use]
    pub fn peak(&self) -> f64 {
        self.norm
    }

    pub(crate) fn rules(&self) -> &LineRules {
        &self.rules
    }

    pub(crate) fn polynomial(&self) -> Option<&Polynomial> {
        self.polynomial.as_ref()
    }

    /// Factor that makes the cut line integral of a Gaussian over a segment of this length integrate to 1.
    pub(crate) fn line_factor(&self, length: f64) -> f64 {
        self.line_norm.factor(length)
    }

    /// The factor of an uncut Gaussian, 1/m^dimensions.
    pub(crate) fn uncut_norm(&self) -> f64 {
        uncut_norm(self.dimensions, self.choice.width)
    }

    /// The kernel at a squared distance, 1/m^dimensions.
    #[must_use]
    pub fn phi(&self, distance_squared: f64) -> f64 {
        if self.dimensions == 0 {
            return 1.0;
        }
        if distance_squared > self.reach * self.reach {
            return 0.0;
        }
        let w = self.choice.width;
        match &self.polynomial {
            Some(polynomial) => self.norm * polynomial.at(distance_squared.sqrt() / w),
            None => self.norm * libm::exp(-0.5 * distance_squared / (w * w)),
        }
    }

    /// `phi'(r) / r`: times the vector from the particle to the point it is the gradient. The jump at the edge is left out.
    #[must_use]
    pub fn slope(&self, distance_squared: f64) -> f64 {
        if self.dimensions == 0 || distance_squared > self.reach * self.reach {
            return 0.0;
        }
        let w = self.choice.width;
        match &self.polynomial {
            Some(polynomial) => {
                self.norm / (w * w) * polynomial.slope_at(distance_squared.sqrt() / w)
            }
            None => -self.norm / (w * w) * libm::exp(-0.5 * distance_squared / (w * w)),
        }
    }

    /// The line integral `psi` and its first moment `int_0^1 (s - 1/2) phi(r - start - s l) ds` at a point `r`.
    ///
    /// All vectors have zeros in the directions that are not resolved.
    #[must_use]
    pub fn line(&self, start: DVec3, l: DVec3, r: DVec3) -> [f64; 2] {
        if self.dimensions == 0 {
            return [1.0, 0.0];
        }
        let w = self.choice.width;
        let length = l.length();
        if length <= 1e-10 * w {
            return [self.phi((r - start - 0.5 * l).length_squared()), 0.0];
        }
        let n = l / length;
        let from_point = start - r;
        let i = from_point.dot(n);
        let p = i + length;
        let t_squared = (from_point - i * n).length_squared();
        match &self.polynomial {
            Some(polynomial) => {
                let [psi, moment] = polynomial.line(t_squared / (w * w), i / w, p / w);
                [self.norm * psi, self.norm * moment]
            }
            None => self.gaussian_line(t_squared, i, p, length),
        }
    }

    /// Whether the cut line integral of a Gaussian is not zero at distance `t` from the line and `u` from the middle along it.
    fn within(&self, t_squared: f64, u: f64, length: f64) -> bool {
        let c = self.reach;
        let half = c + 0.5 * length;
        match self.choice.line_cut {
            LineCut::Ellipsoid => t_squared / (c * c) + u * u / (half * half) <= 1.0,
            LineCut::Cylinder => t_squared <= c * c && u.abs() <= half,
        }
    }

    fn gaussian_line(&self, t_squared: f64, i: f64, p: f64, length: f64) -> [f64; 2] {
        if !self.within(t_squared, 0.5 * (i + p), length) {
            return [0.0; 2];
        }
        let w = self.choice.width;
        let across =
            self.uncut_norm() * self.line_factor(length) * libm::exp(-0.5 * t_squared / (w * w));
        let gauss = |x: f64| libm::exp(-0.5 * (x / w) * (x / w));
        if length > 1e-2 * w {
            // int exp(-u^2 / (2 w^2)) du = sqrt(pi/2) w erf; where both ends lie on one side, the complements differ by less.
            let (a, b) = (i / (SQRT_2 * w), p / (SQRT_2 * w));
            let difference = if a > 0.0 {
                libm::erfc(a) - libm::erfc(b)
            } else if b < 0.0 {
                libm::erfc(-b) - libm::erfc(-a)
            } else {
                libm::erf(b) - libm::erf(a)
            };
            let psi = (0.5 * PI).sqrt() * w / length * difference;
            let ratio = w / length;
            let moment = ratio * ratio * (gauss(i) - gauss(p)) - 0.5 * (p + i) / length * psi;
            return [across * psi, across * moment];
        }
        // Short segments: differences of nearly equal numbers are avoided by four nodes, exact to 1e-20 here.
        let rule = [
            (0.861_136_311_594_052_6, 0.347_854_845_137_453_86),
            (0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
        ];
        let mut sums = [0.0; 2];
        for (node, weight) in rule {
            for s in [-0.5 * node, 0.5 * node] {
                let value = 0.5 * weight * gauss(0.5 * (i + p) + s * length);
                sums[0] += value;
                sums[1] += s * value;
            }
        }
        [across * sums[0], across * sums[1]]
    }
}

/// 1 over the integral of an uncut Gaussian.
fn uncut_norm(dimensions: usize, w: f64) -> f64 {
    let one = 1.0 / ((2.0 * PI).sqrt() * w);
    (0..dimensions).fold(1.0, |norm, _| norm * one)
}

/// 1 over the integral of a Gaussian inside a ball of `cutoff` widths.
fn gaussian_norm(dimensions: usize, w: f64, cutoff: f64) -> f64 {
    let x = cutoff;
    let edge = libm::exp(-0.5 * x * x);
    let inside = match dimensions {
        0 => 1.0,
        1 => libm::erf(x / SQRT_2),
        2 => 1.0 - edge,
        _ => libm::erf(x / SQRT_2) - (2.0 / PI).sqrt() * x * edge,
    };
    uncut_norm(dimensions, w) / inside
}

//! The formulas of the fields.

use crate::sums::{SYMMETRIC, Sum, Sums};

/// The sums at one point.
pub(super) struct Point<'a> {
    pub sums: &'a Sums,
    pub point: usize,
    /// 2 or 3.
    pub dimensions: f64,
}

type Matrix = [[f64; 3]; 3];

fn over(value: f64, by: f64) -> f64 {
    if by > 0.0 { value / by } else { 0.0 }
}

impl Point<'_> {
    fn at(&self, sum: Sum) -> &[f64] {
        self.sums.at(sum, self.point)
    }

    fn number(&self, sum: Sum) -> f64 {
        self.at(sum).first().copied().unwrap_or(0.0)
    }

    fn vector(&self, sum: Sum) -> [f64; 3] {
        self.at(sum).try_into().unwrap_or_default()
    }

    fn tensor(&self, sum: Sum) -> Matrix {
        let values = self.at(sum);
        let mut out = Matrix::default();
        for (k, value) in values.iter().enumerate().take(9) {
            out[k / 3][k % 3] = *value;
        }
        out
    }

    fn velocity(&self) -> [f64; 3] {
        let density = self.number(Sum::Mass);
        self.vector(Sum::Momentum).map(|j| over(j, density))
    }

    fn kinetic(&self) -> [f64; 6] {
        let (j, v) = (self.vector(Sum::Momentum), self.velocity());
        let flux: [f64; 6] = self.at(Sum::MomentumFlux).try_into().unwrap_or_default();
        let mut out = flux;
        for (out, (a, b)) in out.iter_mut().zip(SYMMETRIC) {
            *out -= j[a] * v[b];
        }
        out
    }

    /// A third of the trace; in two dimensions half of that in the plane.
    fn mean(&self, diagonal: [f64; 3]) -> f64 {
        if self.dimensions < 3.0 {
            0.5 * (diagonal[0] + diagonal[1])
        } else {
            (diagonal[0] + diagonal[1] + diagonal[2]) / 3.0
        }
    }

    fn kinetic_pressure(&self) -> f64 {
        let k = self.kinetic();
        self.mean([k[0], k[3], k[5]])
    }

    fn total(&self) -> Matrix {
        let mut out = self.tensor(Sum::Stress);
        for (value, (a, b)) in self.kinetic().into_iter().zip(SYMMETRIC) {
            out[a][b] += value;
            if a != b {
                out[b][a] += value;
            }
        }
        out
    }

    fn pressure(&self) -> f64 {
        let s = self.total();
        self.mean([s[0][0], s[1][1], s[2][2]])
    }

    /// sqrt(factor s:s) of the symmetric part without its trace.
    fn deviator(&self, tensor: &Matrix, factor: f64) -> f64 {
        let mean = self.mean([tensor[0][0], tensor[1][1], tensor[2][2]]);
        let axes = self.dimensions as usize;
        let mut sum = 0.0;
        for (a, row) in tensor.iter().enumerate().take(axes) {
            for (b, entry) in row.iter().enumerate().take(axes) {
                let s = 0.5 * (entry + tensor[b][a]) - if a == b { mean } else { 0.0 };
                sum += s * s;
            }
        }
        (factor * sum).sqrt()
    }

    /// d(a)/dx_b by the quotient rule.
    fn quotient(&self, weight: Sum, flow: Sum, weight_gradient: Sum, flow_gradient: Sum) -> Matrix {
        let mass = self.number(weight);
        let value = self.vector(flow).map(|j| over(j, mass));
        let (slope, mut out) = (self.vector(weight_gradient), self.tensor(flow_gradient));
        for (row, value) in out.iter_mut().zip(value) {
            for (entry, slope) in row.iter_mut().zip(slope) {
                *entry = over(*entry - value * slope, mass);
            }
        }
        out
    }

    fn velocity_gradient(&self) -> Matrix {
        self.quotient(
            Sum::Mass,
            Sum::Momentum,
            Sum::MassGradient,
            Sum::MomentumGradient,
        )
    }

    fn shear_rate(&self) -> f64 {
        self.deviator(&self.velocity_gradient(), 2.0)
    }

    /// Moments of the radii about 0: M1 to M4.
    fn radii(&self) -> [f64; 4] {
        let sizes = self.at(Sum::Sizes);
        [1, 2, 3, 4].map(|q| over(sizes[q], sizes[0]))
    }

    fn radius_variance(&self) -> f64 {
        let [m1, m2, ..] = self.radii();
        let variance = m2 - m1 * m1;
        // Equal radii leave rounding errors, which higher moments would blow up.
        if variance > 1e-12 * m2 { variance } else { 0.0 }
    }
}

fn symmetric(tensor: &Matrix, out: &mut [f64]) {
    for (out, (a, b)) in out.iter_mut().zip(SYMMETRIC) {
        *out = 0.5 * (tensor[a][b] + tensor[b][a]);
    }
}

fn flat(tensor: &Matrix, out: &mut [f64]) {
    out.copy_from_slice(tensor.as_flattened());
}

macro_rules! straight {
    ($($name:ident $sum:ident;)*) => {$(
        pub(super) fn $name(p: &Point, out: &mut [f64]) {
            out.copy_from_slice(&p.at(Sum::$sum)[..out.len()]);
        }
    )*};
}

straight! {
    number_density Sizes;
    size_moments Sizes;
    volume_fraction Volume;
    liquid_fraction Liquid;
    density Mass;
    momentum Momentum;
    momentum_flux MomentumFlux;
    contact_stress Stress;
    rotational_energy SpinEnergy;
    boundary_force BoundaryForce;
    drag Drag;
    contact_density ContactCount;
    spin Spin;
    spin_flux SpinFlux;
    boundary_couple BoundaryCouple;
}

pub(super) fn mean_radius(p: &Point, out: &mut [f64]) {
    out[0] = p.radii()[0];
}

pub(super) fn radius_variance(p: &Point, out: &mut [f64]) {
    out[0] = p.radius_variance();
}

pub(super) fn radius_skewness(p: &Point, out: &mut [f64]) {
    let ([a, m2, m3, _], variance) = (p.radii(), p.radius_variance());
    out[0] = over(
        m3 - 3.0 * a * m2 + 2.0 * a * a * a,
        variance * variance.sqrt(),
    );
}

pub(super) fn radius_kurtosis(p: &Point, out: &mut [f64]) {
    let ([a, m2, m3, m4], variance) = (p.radii(), p.radius_variance());
    let central = m4 - 4.0 * a * m3 + 6.0 * a * a * m2 - 3.0 * a * a * a * a;
    out[0] = over(central, variance * variance);
}

pub(super) fn velocity(p: &Point, out: &mut [f64]) {
    out.copy_from_slice(&p.velocity());
}

pub(super) fn kinetic_stress(p: &Point, out: &mut [f64]) {
    out.copy_from_slice(&p.kinetic());
}

pub(super) fn stress(p: &Point, out: &mut [f64]) {
    flat(&p.total(), out);
}

pub(super) fn pressure(p: &Point, out: &mut [f64]) {
    out[0] = p.pressure();
}

pub(super) fn contact_pressure(p: &Point, out: &mut [f64]) {
    let s = p.tensor(Sum::Stress);
    out[0] = p.mean([s[0][0], s[1][1], s[2][2]]);
}

pub(super) fn kinetic_pressure(p: &Point, out: &mut [f64]) {
    out[0] = p.kinetic_pressure();
}

pub(super) fn deviatoric_stress(p: &Point, out: &mut [f64]) {
    out[0] = p.deviator(&p.total(), 0.5);
}

pub(super) fn stress_ratio(p: &Point, out: &mut [f64]) {
    out[0] = over(p.deviator(&p.total(), 0.5), p.pressure());
}

pub(super) fn granular_temperature(p: &Point, out: &mut [f64]) {
    out[0] = over(p.kinetic_pressure(), p.number(Sum::Mass));
}

pub(super) fn kinetic_energy(p: &Point, out: &mut [f64]) {
    let k = p.at(Sum::MomentumFlux);
    out[0] = 0.5 * (k[0] + k[3] + k[5]);
}

pub(super) fn fluctuation_energy(p: &Point, out: &mut [f64]) {
    let k = p.kinetic();
    out[0] = 0.5 * (k[0] + k[3] + k[5]);
}

pub(super) fn coordination(p: &Point, out: &mut [f64]) {
    out[0] = over(p.number(Sum::Touching), p.number(Sum::Sizes));
}

pub(super) fn fabric(p: &Point, out: &mut [f64]) {
    let count = p.number(Sum::ContactCount);
    for (out, value) in out.iter_mut().zip(p.at(Sum::Fabric)) {
        *out = over(*value, count);
    }
}

pub(super) fn velocity_gradient(p: &Point, out: &mut [f64]) {
    flat(&p.velocity_gradient(), out);
}

pub(super) fn strain_rate(p: &Point, out: &mut [f64]) {
    symmetric(&p.velocity_gradient(), out);
}

pub(super) fn vorticity(p: &Point, out: &mut [f64]) {
    let g = p.velocity_gradient();
    out.copy_from_slice(&[g[2][1] - g[1][2], g[0][2] - g[2][0], g[1][0] - g[0][1]]);
}

pub(super) fn shear_rate(p: &Point, out: &mut [f64]) {
    out[0] = p.shear_rate();
}

pub(super) fn inertial_number(p: &Point, out: &mut [f64]) {
    let diameter = 2.0 * p.radii()[0];
    let solid = over(p.number(Sum::Mass), p.number(Sum::Volume));
    out[0] = p.shear_rate() * diameter * over(solid, p.pressure()).sqrt();
}

pub(super) fn angular_velocity(p: &Point, out: &mut [f64]) {
    let number = p.number(Sum::Sizes);
    out.copy_from_slice(&p.vector(Sum::AngularVelocity).map(|w| over(w, number)));
}

pub(super) fn couple_stress(p: &Point, out: &mut [f64]) {
    for ((out, a), b) in out
        .iter_mut()
        .zip(p.at(Sum::CoupleDifference))
        .zip(p.at(Sum::CoupleSum))
    {
        *out = a + b;
    }
}

pub(super) fn displacement(p: &Point, out: &mut [f64]) {
    let mass = p.number(Sum::DisplacedMass);
    out.copy_from_slice(&p.vector(Sum::Displacement).map(|u| over(u, mass)));
}

pub(super) fn strain(p: &Point, out: &mut [f64]) {
    let gradient = p.quotient(
        Sum::DisplacedMass,
        Sum::Displacement,
        Sum::DisplacedMassGradient,
        Sum::DisplacementGradient,
    );
    symmetric(&gradient, out);
}

//! Wear of a contact.

use crate::forces::{Impact, Rub};

pub use mercury_common::scene::WearBasis;

/// Plan of a wall that wears.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WearPlan {
    /// Index of the wall in the plan.
    pub wall: usize,
    /// The law.
    pub law: WearLaw,
    /// Factor on all volumes.
    pub acceleration: f64,
    /// Whether the surface follows.
    pub moves: bool,
    /// Part of its shortest edge by which a vertex may be due to move before the surface follows.
    pub step: f64,
    /// Part of its volume that a vertex shares with its neighbours at each move.
    pub smoothing: f64,
    /// The run ends when a vertex is so deep, m; infinite: never.
    pub until_depth: f64,
}

/// A law of wear with its parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum WearLaw {
    /// Reye (1860), Archard (1953), Khrushchov (1974): V = K/H times load and way, or their product by `basis`.
    Archard {
        /// K/H, 1/Pa.
        rate: f64,
        /// Quantity that the volume is proportional to.
        basis: WearBasis,
    },
    /// Finnie (1960), Wear 3, 87: V = c m v^2 f(a), f = sin 2a - 3 sin^2 a where tan a is below 1/3, else cos^2 a / 3.
    Finnie {
        /// c, m^3/J.
        constant: f64,
    },
    /// Oka, Okamura & Yoshida (2005), Wear 259, 95: V = m E90 sin^n1 a (1 + H (1 - sin a))^n2 with H in GPa and
    /// E90 = E' (v/v')^k2 (D/D')^k3.
    Oka {
        /// H, GPa.
        hardness: f64,
        /// E', m^3/kg.
        erosion: f64,
        /// v', m/s.
        speed: f64,
        /// D', m.
        diameter: f64,
        /// k2.
        speed_exponent: f64,
        /// k3.
        diameter_exponent: f64,
        /// n1.
        n1: f64,
        /// n2.
        n2: f64,
    },
}

impl WearLaw {
    /// The volume that a contact wears in one evaluation, m^3.
    #[must_use]
    pub fn volume(&self, rub: &Rub) -> f64 {
        match *self {
            Self::Archard { rate, basis } => {
                rate * match basis {
                    WearBasis::NormalLoad => rub.load * rub.way,
                    WearBasis::Sliding => rub.load * rub.slip,
                    WearBasis::FrictionWork => rub.work,
                }
            }
            Self::Finnie { .. } | Self::Oka { .. } => {
                rub.impact.map_or(0.0, |impact| self.eroded(&impact))
            }
        }
    }

    /// The volume that an impact wears by a law of erosion, m^3; 0 by Archard's law, and where nothing comes nearer.
    #[must_use]
    pub fn eroded(&self, impact: &Impact) -> f64 {
        let Impact {
            mass,
            diameter,
            speed,
            approach,
        } = *impact;
        if !(approach > 0.0 && speed > 0.0) {
            return 0.0;
        }
        let sine = (approach / speed).min(1.0);
        match *self {
            Self::Archard { .. } => 0.0,
            Self::Finnie { constant } => {
                let cosine = ((1.0 - sine) * (1.0 + sine)).sqrt();
                let f = if 3.0 * sine < cosine {
                    2.0 * sine * cosine - 3.0 * sine * sine
                } else {
                    cosine * cosine / 3.0
                };
                constant * mass * speed * speed * f
            }
            Self::Oka {
                hardness,
                erosion,
                speed: reference_speed,
                diameter: reference_diameter,
                speed_exponent,
                diameter_exponent,
                n1,
                n2,
            } => {
                let by_speed = libm::pow(speed / reference_speed, speed_exponent);
                let by_size = libm::pow(diameter / reference_diameter, diameter_exponent);
                let by_angle = libm::pow(sine, n1) * libm::pow(1.0 + hardness * (1.0 - sine), n2);
                mass * (erosion * by_speed * by_size) * by_angle
            }
        }
    }
}

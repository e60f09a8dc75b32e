//! The element of a bond: its law and its constants.
//!
//! Both laws are one element with four stiffnesses. Its frame turns along: its axis t leads from end to end, and about t it turns as the mean of both
//! ends. With the rotations a and b of the ends against that frame (a rotation vector each, from what they were at the gluing), m = (a + b)/2 across t
//! and d = b - a:
//!
//! ```text
//! tension N = k_n (L - L0),  torsion M_t = k_t d.t,  bending couple k_b d across t,  shear force V = k_s L0 m
//! ```
//!
//! The ends feel couples k_b d - k_s L0^2 m/2 and -k_b d - k_s L0^2 m/2 across t, and the forces that balance them, so that momentum and angular
//! momentum are kept. With k_s = 12 E I/(L0^3 (1 + Phi)) and k_b = E I/L0 this is Timoshenko's exact element (Przemieniecki 1968, section 5.6):
//! M_A = k [(4 + Phi) a + (2 - Phi) b], k = E I/(L0 (1 + Phi)). Rotations are measured and never summed up, so that nothing drifts.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};

use super::evaluation::{Motion, Rotation};
use crate::lanes::Vector;

/// Law of the stiffnesses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LawOfBonds {
    /// Timoshenko's beam of round section.
    Beam {
        /// Pa
        youngs_modulus: f64,
        /// `None`: rigid in shear, the beam of Euler and Bernoulli.
        poisson_ratio: Option<f64>,
    },
    /// Springs over the area of the section, at the middle (Potyondy & Cundall 2004).
    Parallel {
        /// Of tension and bending, N/m^3.
        normal_stiffness: f64,
        /// Of shear and twist, N/m^3.
        shear_stiffness: f64,
    },
}

/// Round section of an element.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    /// Radius, m.
    pub radius: f64,
}

impl Section {
    /// Area, m^2.
    #[must_use]
    pub fn area(self) -> f64 {
        PI * self.radius * self.radius
    }

    /// Second moment of area I about a diameter, m^4. The polar one is J = 2 I.
    #[must_use]
    pub fn moment(self) -> f64 {
        0.25 * PI * (self.radius * self.radius) * (self.radius * self.radius)
    }
}

/// A number of each mode: tension, shear, twist, bending.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Modes<T = f64> {
    /// Tension: N/m, N s/m.
    pub normal: T,
    /// Shear: of stiffness, force over the shift of the ends across the axis, N/m; of damping, couple over the rate of rotation, N m s.
    pub shear: T,
    /// Twist: N m, N m s.
    pub twist: T,
    /// Bending: N m, N m s.
    pub bending: T,
}

/// The constants of a bond, or of several side by side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Element<T = f64> {
    /// Length at the gluing L0, m.
    pub length: T,
    /// Radius of the section, m.
    pub radius: T,
    /// Stiffness of each mode.
    pub stiffness: Modes<T>,
    /// Damping of each mode.
    pub damping: Modes<T>,
}

/// How easily an end moves.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Mobility {
    /// 1/kg; 0 where nothing moves it.
    pub inverse_mass: f64,
    /// 1/(kg m^2)
    pub inverse_inertia: f64,
}

/// Both ends of a bond.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ends {
    /// From end A to end B, m.
    pub branch: DVec3,
    /// Velocity of B less that of A, m/s.
    pub velocity: DVec3,
    /// Rotations of both ends, from the frame of the gluing, whose first axis leads from A to B, to what has become of it.
    pub rotations: [DQuat; 2],
    /// Angular velocities of both ends, rad/s.
    pub spins: [DVec3; 2],
}

/// Loads of a bond on its ends.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Action {
    /// Force on A, N; that on B is its opposite.
    pub force: DVec3,
    /// Couples on A and B, N m.
    pub couples: [DVec3; 2],
    /// Tension and shear stress, without damping, Pa.
    pub stresses: [f64; 2],
    /// Elastic energy, J.
    pub energy: f64,
}

impl LawOfBonds {
    /// Stiffnesses of an element of this length (m).
    #[must_use]
    pub fn stiffness(self, length: f64, section: Section) -> Modes {
        let (area, moment) = (section.area(), section.moment());
        match self {
            Self::Beam {
                youngs_modulus,
                poisson_ratio,
            } => {
                let bending = youngs_modulus * moment / length;
                let squared = length * length;
                // Cowper (1966): shear coefficient of a round section.
                let phi = poisson_ratio.map_or(0.0, |nu| {
                    let kappa = 6.0 * (1.0 + nu) / (7.0 + 6.0 * nu);
                    24.0 * (1.0 + nu) * moment / (kappa * area * squared)
                });
                let nu = poisson_ratio.unwrap_or(0.0);
                Modes {
                    normal: youngs_modulus * area / length,
                    shear: 12.0 * bending / (squared * (1.0 + phi)),
                    twist: bending / (1.0 + nu),
                    bending,
                }
            }
            Self::Parallel {
                normal_stiffness,
                shear_stiffness,
            } => Modes {
                normal: normal_stiffness * area,
                shear: shear_stiffness * area,
                twist: 2.0 * shear_stiffness * moment,
                bending: normal_stiffness * moment,
            },
        }
    }
}

impl Element {
    /// Element between ends of these mobilities, `length` (m) apart; `damping`: fraction of critical.
    #[must_use]
    pub fn new(
        law: LawOfBonds,
        length: f64,
        section: Section,
        damping: f64,
        ends: [Mobility; 2],
    ) -> Self {
        let stiffness = law.stiffness(length, section);
        let [a, b] = ends;
        let inverse_mass = a.inverse_mass + b.inverse_mass;
        let inverse_inertia = a.inverse_inertia + b.inverse_inertia;
        let squared = length * length;
        let critical = |stiffness: f64, inverse: f64| match inverse > 0.0 {
            true => 2.0 * damping * (stiffness / inverse).sqrt(),
            false => 0.0,
        };
        let damping = Modes {
            normal: critical(stiffness.normal, inverse_mass),
            shear: critical(
                stiffness.shear * squared,
                0.25 * inverse_inertia + inverse_mass / squared,
            ),
            twist: critical(stiffness.twist, inverse_inertia),
            bending: critical(stiffness.bending, inverse_inertia),
        };
        Self {
            length,
            radius: section.radius,
            stiffness,
            damping,
        }
    }

    /// Stiffness (N/m) and damping (N s/m) of this branch (m) where one end moves along a unit vector and does not turn.
    pub(super) fn along(&self, branch: DVec3, axis: DVec3) -> [f64; 2] {
        let cosine = branch.normalize().dot(axis);
        let squared = cosine * cosine;
        let share = |along: f64, across: f64| squared * along + (1.0 - squared) * across;
        let across = self.damping.shear / (self.length * self.length);
        [
            share(self.stiffness.normal, self.stiffness.shear),
            share(self.damping.normal, across),
        ]
    }

    /// Whether the motion of its ends is damped.
    pub(super) fn is_damped(&self) -> bool {
        self.damping != Modes::default()
    }

    /// Loads on the ends.
    #[must_use]
    pub fn act(&self, ends: &Ends) -> Action {
        let rotations = ends.rotations.map(Rotation::from);
        let motion = Motion {
            velocity: ends.velocity.into(),
            spins: ends.spins.map(Vector::from),
        };
        let motion = self.is_damped().then_some(&motion);
        let loads = self.loads(ends.branch.into(), rotations, motion);
        Action {
            force: loads.force.into(),
            couples: loads.couples.map(DVec3::from),
            stresses: loads.stresses,
            energy: loads.energy,
        }
    }
}

crate::state::plain!(Modes {
    normal,
    shear,
    twist,
    bending
});
crate::state::plain!(Element {
    length,
    radius,
    stiffness,
    damping
});
crate::state::plain!(Action {
    force,
    couples,
    stresses,
    energy
});

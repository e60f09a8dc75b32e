//! The element of a bond: forces, couples, energy and stresses as functions of positions and rotations of its ends.
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
pub struct Modes {
    /// Tension: N/m, N s/m.
    pub normal: f64,
    /// Shear: of stiffness, force over the shift of the ends across the axis, N/m; of damping, couple over the rate of rotation, N m s.
    pub shear: f64,
    /// Twist: N m, N m s.
    pub twist: f64,
    /// Bending: N m, N m s.
    pub bending: f64,
}

/// The constants of a bond.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Element {
    /// Length at the gluing L0, m.
    pub length: f64,
    /// Radius of the section, m.
    pub radius: f64,
    /// Stiffness of each mode.
    pub stiffness: Modes,
    /// Damping of each mode.
    pub damping: Modes,
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

/// Rates of the four modes.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Rates {
    /// m/s
    normal: f64,
    /// rad/s
    twist: f64,
    /// rad/s
    bending: DVec3,
    /// rad/s
    shear: DVec3,
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

    /// Loads on the ends.
    #[inline]
    #[must_use]
    pub fn act(&self, ends: &Ends) -> Action {
        let length = ends.branch.length();
        let per_length = 1.0 / length;
        let axis = ends.branch * per_length;
        let [a, b] = rotations_in_frame(axis, ends.rotations);
        let Modes {
            normal,
            shear,
            twist,
            bending,
        } = self.stiffness;
        let stretch = length - self.length;
        let difference = b - a;
        let turn = difference.dot(axis);
        let bent = difference - axis * turn;
        let mean = 0.5 * (a + b);
        let sheared = mean - axis * mean.dot(axis);
        let squared = self.length * self.length;
        let (tension, torque) = (normal * stretch, twist * turn);
        let (couple, balance) = (bent * bending, sheared * (-shear * squared));
        // The larger end.
        let half = 0.5 * balance;
        let bending_moment = (couple + half)
            .length_squared()
            .max((half - couple).length_squared())
            .sqrt();
        let section = Section {
            radius: self.radius,
        };
        // r/I = 4/(A r).
        let per_area = 1.0 / section.area();
        let per_moment = per_area * (4.0 / self.radius);
        let stresses = [
            tension * per_area + bending_moment * per_moment,
            balance.length() * (per_length * per_area) + torque.abs() * (0.5 * per_moment),
        ];
        let energy = 0.5
            * (normal * stretch * stretch
                + twist * turn * turn
                + bending * bent.length_squared()
                + shear * squared * sheared.length_squared());
        let mut action = assemble((axis, length), (tension, torque), (couple, balance));
        if self.damping != Modes::default() {
            let rates = Rates::of((axis, length), ends.velocity, ends.spins);
            let damped = self.damped(&rates, (axis, length));
            action.force += damped.force;
            for (couple, more) in action.couples.iter_mut().zip(damped.couples) {
                *couple += more;
            }
        }
        Action {
            stresses,
            energy,
            ..action
        }
    }

    /// Loads of the damping.
    fn damped(&self, rates: &Rates, along: (DVec3, f64)) -> Action {
        let Modes {
            normal,
            shear,
            twist,
            bending,
        } = self.damping;
        assemble(
            along,
            (normal * rates.normal, twist * rates.twist),
            (rates.bending * bending, rates.shear * -shear),
        )
    }

    /// Power that the damping takes, W: its forces are of the velocities that the bond saw, `now` are those at the time of the forces.
    #[must_use]
    pub fn damping_power(&self, seen: &Ends, now: &Ends) -> f64 {
        let length = seen.branch.length();
        let along = (seen.branch / length, length);
        let forces = Rates::of(along, seen.velocity, seen.spins);
        let rates = Rates::of(along, now.velocity, now.spins);
        let Modes {
            normal,
            shear,
            twist,
            bending,
        } = self.damping;
        normal * forces.normal * rates.normal
            + twist * forces.twist * rates.twist
            + bending * forces.bending.dot(rates.bending)
            + shear * forces.shear.dot(rates.shear)
    }
}

impl Rates {
    fn of((axis, length): (DVec3, f64), velocity: DVec3, spins: [DVec3; 2]) -> Self {
        let across = |spin: DVec3| spin - axis * spin.dot(axis);
        let relative = spins[1] - spins[0];
        // The line of centres turns by axis x velocity/length.
        let turning = axis.cross(velocity) / length;
        Self {
            normal: velocity.dot(axis),
            twist: relative.dot(axis),
            bending: across(relative),
            shear: across(0.5 * (spins[0] + spins[1])) - turning,
        }
    }
}

/// Loads of a tension (N), a torsion (N m), a bending couple on A, and the sum of the couples on both ends across the axis, which forces balance.
#[inline]
fn assemble(
    (axis, length): (DVec3, f64),
    (tension, torque): (f64, f64),
    (couple, balance): (DVec3, DVec3),
) -> Action {
    let half = 0.5 * balance;
    Action {
        force: axis * tension - axis.cross(balance) / length,
        couples: [half + couple + axis * torque, half - couple - axis * torque],
        ..Action::default()
    }
}

/// Rotation vectors of both ends against the frame of the element, rad.
///
/// The mean of two rotations p and q is the middle of the turn from one to the other: with r the half of that turn, p is the mean turned back by r, q the
/// mean turned on by r. The frame of the mean is turned the shortest way, o, onto the axis; against it the ends are r* o* and r o*, whose parts are
/// computed once.
#[inline]
fn rotations_in_frame(axis: DVec3, [first, second]: [DQuat; 2]) -> [DVec3; 2] {
    // A rotation is two quaternions: those on one side.
    let cosine = first.dot(second);
    let side = if cosine < 0.0 { -1.0 } else { 1.0 };
    let (cosine, second) = (cosine * side, second * side);
    let turn = second * first.conjugate();
    // cos of the half of the half turn, from that of the half.
    let half = (0.5 * (1.0 + cosine)).sqrt();
    let r = DVec3::new(turn.x, turn.y, turn.z) * (0.5 / half);
    // The first axis turned by the mean, whose square is 2 + 2 cosine before it is divided by its length.
    let DQuat { x, y, z, w } = first + second;
    let carried = DVec3::new(
        (w * w - z * z) + (x * x - y * y),
        2.0 * (x * y + w * z),
        2.0 * (x * z - w * y),
    ) * (0.5 / (1.0 + cosine));
    // Bent by half a turn, no way is the shortest: any is as good.
    let real = (1.0 + carried.dot(axis)).max(1e-12);
    let scale = 1.0 / (2.0 * real).sqrt();
    let (o, real) = (carried.cross(axis) * scale, real * scale);
    let along = r.dot(o);
    let (common, own) = (o * half, r * real - r.cross(o));
    [
        rotation_vector(half * real - along, -own - common),
        rotation_vector(half * real + along, own - common),
    ]
}

/// Rotation vector (rad) of a quaternion: 2 asin(s)/s times its vector of length s, by its series.
/// Off by 1e-7 of itself for turns of 0.7 rad, by 1e-4 of 1.7 rad.
#[inline]
fn rotation_vector(real: f64, vector: DVec3) -> DVec3 {
    let s = vector.length_squared();
    let factor = 2.0 + s * (1.0 / 3.0 + s * (3.0 / 20.0 + s * (5.0 / 56.0 + s * (35.0 / 576.0))));
    vector * if real < 0.0 { -factor } else { factor }
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

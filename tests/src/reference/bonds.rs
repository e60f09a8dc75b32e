//! Bonds: glued pairs as elastic beams in a frame that turns along.
//!
//! The frame of a bond is a triad. At the gluing its first axis leads from A to B. Afterwards it is turned by the mean rotation of both ends, and then the
//! shortest way onto the line of centres. Small displacements in it give the loads by the stiffness matrix of a beam, or by springs at the middle.

use glam::{DMat3, DQuat, DVec3};

use super::Simulation;
use crate::closed_forms::Beam;

/// Law of the elastic loads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BondLaw {
    /// Timoshenko's beam of round section (Przemieniecki 1968, eq. 5.116).
    Beam {
        /// E \[Pa\].
        youngs_modulus: f64,
        /// ν.
        poisson_ratio: f64,
    },
    /// Springs per area of the section, at the middle (Potyondy & Cundall 2004).
    Parallel {
        /// \[N/m³\]
        normal_stiffness: f64,
        /// \[N/m³\]
        shear_stiffness: f64,
    },
}

/// A bond of two particles.
#[derive(Debug, Clone)]
pub struct Bond {
    /// A and B.
    pub particles: [usize; 2],
    /// Law of the elastic loads.
    pub law: BondLaw,
    /// Radius of the section \[m\].
    pub radius: f64,
    /// Fraction of critical damping of each mode.
    pub damping: f64,
    /// Tension and shear at which it breaks \[Pa\].
    pub strengths: [f64; 2],
    /// Whether the pair keeps its contact, which then counts what it overlaps more than at the gluing.
    pub contact: bool,
    /// Length at the gluing \[m\].
    pub length: f64,
    /// From A to B \[m\], beyond half a period, too.
    pub branch: DVec3,
    /// Frame of the gluing: its columns are the axes.
    pub frame: DMat3,
    /// Orientations of both ends at the gluing.
    pub glued: [DQuat; 2],
}

/// Loads of a bond.
#[derive(Debug, Clone, Copy, Default)]
pub struct BondLoads {
    /// Force on A; B feels the opposite \[N\].
    pub force: DVec3,
    /// Couples on A and B \[N m\].
    pub couples: [DVec3; 2],
    /// Tension and shear stress without damping \[Pa\].
    pub stresses: [f64; 2],
    /// Elastic energy \[J\].
    pub energy: f64,
}

/// Ends of a bond at an instant.
#[derive(Debug, Clone, Copy)]
pub struct BondEnds {
    /// From A to B \[m\].
    pub branch: DVec3,
    /// Rotations since the gluing.
    pub rotations: [DQuat; 2],
    /// Velocities \[m/s\].
    pub velocities: [DVec3; 2],
    /// Angular velocities \[rad/s\].
    pub spins: [DVec3; 2],
    /// 1/m \[1/kg\].
    pub inverse_masses: [f64; 2],
    /// 1/I \[1/(kg m²)\].
    pub inverse_inertias: [f64; 2],
}

/// A pair whose contact does not count all of its overlap.
#[derive(Debug, Clone, Copy)]
pub struct Shortened {
    /// The lower index first.
    pub pair: [usize; 2],
    /// Overlap that does not count \[m\].
    pub overlap: f64,
    /// Whether the bond holds; else it lasts until the two part.
    pub is_glued: bool,
}

/// Rotation vector by the half angle, exact to round-off for small turns too.
fn rotation_vector(turn: DQuat) -> DVec3 {
    let turn = if turn.w < 0.0 { -turn } else { turn };
    let sine = turn.xyz().length();
    if sine == 0.0 {
        return DVec3::ZERO;
    }
    turn.xyz() * (2.0 * sine.atan2(turn.w) / sine)
}

/// The shortest turn of one unit vector onto another.
fn shortest(from: DVec3, onto: DVec3) -> DQuat {
    let across = from.cross(onto);
    let sine = across.length();
    if sine == 0.0 {
        return DQuat::IDENTITY;
    }
    DQuat::from_axis_angle(across / sine, sine.atan2(from.dot(onto)))
}

impl Bond {
    /// Loads on the ends.
    pub fn loads(&self, ends: &BondEnds) -> BondLoads {
        let now = ends.branch.length();
        let axis = ends.branch / now;
        let [p, q] = ends.rotations;
        let half = DQuat::from_scaled_axis(0.5 * rotation_vector(q * p.inverse()));
        let mean = half * p;
        let turned = mean * self.frame.x_axis;
        let frame_turn = shortest(turned, axis) * mean;
        let frame = DMat3::from_quat(frame_turn) * self.frame;
        // Rotations of the ends against the frame, along its axes.
        let [a, b] = [p, q].map(|end| {
            let against = rotation_vector(end * frame_turn.inverse());
            frame.transpose() * against
        });
        let stretch = now - self.length;
        // Forces and couples on A and B along the axes of the frame.
        let (tension, couple_a, couple_b, energy) = match self.law {
            BondLaw::Beam {
                youngs_modulus,
                poisson_ratio,
            } => {
                let beam = Beam {
                    radius: self.radius,
                    length: self.length,
                    youngs_modulus,
                    poisson_ratio,
                };
                let shifts = [
                    0.0, 0.0, 0.0, a.x, a.y, a.z, stretch, 0.0, 0.0, b.x, b.y, b.z,
                ];
                let loads = beam.loads(&shifts);
                let work: f64 = loads.iter().zip(&shifts).map(|(f, x)| f * x).sum();
                (
                    loads[0],
                    DVec3::new(loads[3], loads[4], loads[5]),
                    DVec3::new(loads[9], loads[10], loads[11]),
                    -0.5 * work,
                )
            }
            BondLaw::Parallel {
                normal_stiffness,
                shear_stiffness,
            } => {
                let area = std::f64::consts::PI * self.radius * self.radius;
                let inertia = 0.25 * area * self.radius * self.radius;
                let lever = 0.5 * self.length * DVec3::X;
                // Shift of B's side of the middle against A's.
                let across = b.cross(-lever) - a.cross(lever);
                let shear = shear_stiffness * area * across;
                let bend = DVec3::new(
                    shear_stiffness * 2.0 * inertia,
                    normal_stiffness * inertia,
                    normal_stiffness * inertia,
                ) * (b - a);
                let tension = normal_stiffness * area * stretch;
                let energy = 0.5 * (tension * stretch + shear.dot(across) + bend.dot(b - a));
                (
                    tension,
                    bend + lever.cross(shear),
                    -bend + lever.cross(shear),
                    energy,
                )
            }
        };
        // L t x V_B is the opposite of the couples across t; V_A is the opposite of V_B.
        let across = DVec3::new(0.0, couple_a.y + couple_b.y, couple_a.z + couple_b.z);
        let shear_on_a = -DVec3::X.cross(across) / now;
        let area = std::f64::consts::PI * self.radius * self.radius;
        let [inertia, polar] = [0.25, 0.5].map(|part| part * area * self.radius * self.radius);
        let bending = [couple_a, couple_b].map(|m| m.y.hypot(m.z));
        let stresses = [
            tension / area + bending[0].max(bending[1]) * self.radius / inertia,
            shear_on_a.length() / area + couple_a.x.abs() * self.radius / polar,
        ];
        let damped = self.dashpots(ends, axis, now);
        BondLoads {
            force: frame * (DVec3::X * tension + shear_on_a) + damped.force,
            couples: [
                frame * couple_a + damped.couples[0],
                frame * couple_b + damped.couples[1],
            ],
            stresses,
            energy,
        }
    }

    /// 2ζ √(k m*) on the rates of stretch, twist, bending, and of the mean spin against the line of centres.
    fn dashpots(&self, ends: &BondEnds, axis: DVec3, now: f64) -> BondLoads {
        let [stretch, shear, twist, bend] = self.stiffnesses();
        let inverse_mass: f64 = ends.inverse_masses.iter().sum();
        let inverse_inertia: f64 = ends.inverse_inertias.iter().sum();
        let dashpot = |stiffness: f64, inverse: f64| {
            if inverse == 0.0 {
                return 0.0;
            }
            2.0 * self.damping * (stiffness / inverse).sqrt()
        };
        let square = self.length * self.length;
        let relative = ends.spins[1] - ends.spins[0];
        let way = ends.velocities[1] - ends.velocities[0];
        let line = axis.cross(way) / now;
        let mean = 0.5 * (ends.spins[0] + ends.spins[1]);
        let spin = mean - mean.dot(axis) * axis - line;
        // Against the mean spin both ends feel half of one couple.
        let against = -spin
            * dashpot(
                shear * square,
                0.25 * inverse_inertia + inverse_mass / square,
            );
        let twisting = relative.dot(axis) * dashpot(twist, inverse_inertia) * axis;
        let bending = (relative - relative.dot(axis) * axis) * dashpot(bend, inverse_inertia);
        let pull = way.dot(axis) * dashpot(stretch, inverse_mass) * axis;
        BondLoads {
            force: pull - axis.cross(against) / now,
            couples: [
                0.5 * against + twisting + bending,
                0.5 * against - twisting - bending,
            ],
            ..BondLoads::default()
        }
    }

    /// Of stretch, of the ends across the axis \[N/m\], of twist and of bending \[N m\].
    fn stiffnesses(&self) -> [f64; 4] {
        match self.law {
            BondLaw::Beam {
                youngs_modulus,
                poisson_ratio,
            } => {
                let beam = Beam {
                    radius: self.radius,
                    length: self.length,
                    youngs_modulus,
                    poisson_ratio,
                };
                let [along, across, _, near, far, twist] = beam.stiffnesses();
                // Ends turned against each other by ±1/2: pure bending.
                [along, across, twist, 0.5 * (near - far)]
            }
            BondLaw::Parallel {
                normal_stiffness,
                shear_stiffness,
            } => {
                let area = std::f64::consts::PI * self.radius * self.radius;
                let inertia = 0.25 * area * self.radius * self.radius;
                [
                    normal_stiffness * area,
                    shear_stiffness * area,
                    2.0 * shear_stiffness * inertia,
                    normal_stiffness * inertia,
                ]
            }
        }
    }
}

impl Simulation {
    /// Glues two particles.
    pub fn glue(
        &mut self,
        particles: [usize; 2],
        law: BondLaw,
        radius_ratio: f64,
        damping: f64,
        strengths: [f64; 2],
        contact: bool,
    ) {
        let [a, b] = particles.map(|index| &self.particles[index]);
        let branch = self.periodic_box.minimum_image(b.position - a.position);
        let overlap = a.radius + b.radius - branch.length();
        let axis = branch.normalize();
        let second = axis.any_orthonormal_vector();
        let bond = Bond {
            particles,
            law,
            radius: radius_ratio * a.radius.min(b.radius),
            damping,
            strengths,
            contact,
            length: branch.length(),
            branch,
            frame: DMat3::from_cols(axis, second, axis.cross(second)),
            glued: particles.map(|index| self.orientation(index)),
        };
        if contact && overlap > 0.0 {
            self.shortened.push(Shortened {
                pair: particles,
                overlap,
                is_glued: true,
            });
        }
        self.bonds.push(bond);
    }

    /// Orientation of a particle, or of the body of a pebble.
    fn orientation(&self, index: usize) -> DQuat {
        let particle = &self.particles[index];
        match particle.body {
            Some((body, _)) => DQuat::from_mat3(&self.bodies[body].rotation),
            None => particle.orientation,
        }
    }

    /// Adds the loads of all bonds; those whose stress has reached the strength break, and exert nothing.
    pub(super) fn evaluate_bonds(&mut self) {
        let mut bonds = std::mem::take(&mut self.bonds);
        bonds.retain_mut(|bond| {
            let [a, b] = bond.particles.map(|index| &self.particles[index]);
            let way = b.position - a.position - bond.branch;
            bond.branch += self.periodic_box.minimum_image(way);
            let turned = |k: usize| self.orientation(bond.particles[k]) * bond.glued[k].inverse();
            let inverse_inertia = |particle: &super::Particle| match particle.fixed {
                true => 0.0,
                false => 1.0 / particle.inertia,
            };
            let loads = bond.loads(&BondEnds {
                branch: bond.branch,
                rotations: [turned(0), turned(1)],
                velocities: [a.velocity, b.velocity],
                spins: [a.angular_velocity, b.angular_velocity],
                inverse_masses: [a.inverse_mass(), b.inverse_mass()],
                inverse_inertias: [inverse_inertia(a), inverse_inertia(b)],
            });
            if (0..2).any(|k| loads.stresses[k] >= bond.strengths[k]) {
                let gone = |pair: &&mut Shortened| pair.pair == bond.particles;
                if let Some(pair) = self.shortened.iter_mut().find(gone) {
                    pair.is_glued = false;
                }
                return false;
            }
            for (k, sign) in [(0, 1.0), (1, -1.0)] {
                let particle = &mut self.particles[bond.particles[k]];
                particle.force += sign * loads.force;
                particle.torque += loads.couples[k];
            }
            true
        });
        self.bonds = bonds;
        let particles = &self.particles;
        let periodic_box = &self.periodic_box;
        self.shortened.retain(|shortened| {
            let [a, b] = shortened.pair.map(|index| &particles[index]);
            let apart = periodic_box.minimum_image(a.position - b.position).length();
            shortened.is_glued || apart < a.radius + b.radius
        });
    }

    /// Overlap of a pair that its contact does not count \[m\]; `None`: it has no contact.
    pub(super) fn uncounted_overlap(&self, a: usize, b: usize) -> Option<f64> {
        let pair = [a, b];
        let without = |bond: &Bond| bond.particles == pair && !bond.contact;
        if self.bonds.iter().any(without) {
            return None;
        }
        let found = self
            .shortened
            .iter()
            .find(|shortened| shortened.pair == pair);
        Some(found.map_or(0.0, |shortened| shortened.overlap))
    }
}

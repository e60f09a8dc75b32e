//! Luding's virtual springs against rolling and torsion.

use glam::DVec3;

use super::super::{Contact, History, HistoryNumber, SpringRotation, follow};
use super::RollingLaw;

/// One spring of the law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionSpring {
    /// Stiffness, N/m; `None` takes k_t of the contact.
    pub stiffness: Option<f64>,
    /// Dissipation, kg/s.
    pub dissipation: f64,
    /// mu while it yields; 0 switches the spring off.
    pub friction: f64,
    /// mu while it holds.
    pub static_friction: f64,
}

/// Rolling velocity u_r = -l n x dw and torsion velocity u_o = l (n.dw) n stretch springs whose force, cut at mu N, acts as a
/// couple through the lever l (Luding 2008, eqs. 29-34): tau = l n x f_r + l f_o. l = R* (or 2R* for comparisons with older codes).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Luding {
    /// Against rolling.
    pub rolling: FrictionSpring,
    /// Against torsion (twisting about the normal).
    pub torsion: FrictionSpring,
    /// l / R*: 1 or 2.
    pub lever: f64,
    /// How the rolling spring turns with the contact.
    pub rotation: SpringRotation,
}

/// The two springs, m.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RollingSprings {
    /// In the tangent plane.
    pub rolling: DVec3,
    /// Along the normal.
    pub torsion: DVec3,
}

impl History for RollingSprings {
    const LENGTH: usize = 6;

    fn columns() -> Vec<HistoryNumber> {
        vec![
            ("m", "rolling spring x"),
            ("m", "rolling spring y"),
            ("m", "rolling spring z"),
            ("m", "torsion spring x"),
            ("m", "torsion spring y"),
            ("m", "torsion spring z"),
        ]
    }

    /// u_r keeps its sign under the swap (both n and dw turn round), u_o changes it.
    fn swapped(self) -> Self {
        Self {
            rolling: self.rolling,
            torsion: -self.torsion,
        }
    }

    fn write(&self, numbers: &mut Vec<f64>) {
        numbers.extend(self.rolling.to_array());
        numbers.extend(self.torsion.to_array());
    }

    fn read(numbers: &[f64]) -> Self {
        Self {
            rolling: DVec3::from_slice(numbers),
            torsion: DVec3::from_slice(&numbers[3..]),
        }
    }
}

impl FrictionSpring {
    /// Force of the spring and its new length, from the length after this step's motion and its velocity.
    #[inline(always)]
    fn force(
        &self,
        spring: DVec3,
        velocity: DVec3,
        normal_force: f64,
        stiffness: f64,
    ) -> (DVec3, DVec3) {
        let damping = velocity * self.dissipation;
        let trial = -(spring * stiffness) - damping;
        let limit = self.static_friction * normal_force;
        let squared = trial.length_squared();
        if squared <= limit * limit {
            return (trial, spring);
        }
        let force = trial * (self.friction * normal_force / squared.sqrt());
        // Without stiffness there is no spring to set back, only the dashpot.
        let spring = if stiffness > 0.0 {
            -(force + damping) / stiffness
        } else {
            DVec3::ZERO
        };
        (force, spring)
    }
}

impl RollingLaw for Luding {
    type History = RollingSprings;
    const ACTIVE: bool = true;

    #[inline(always)]
    fn couple(
        &self,
        contact: &Contact,
        normal_force: f64,
        tangential_stiffness: f64,
        dt: f64,
        history: &mut RollingSprings,
    ) -> DVec3 {
        let mut couple = DVec3::ZERO;
        if normal_force == 0.0 {
            return couple;
        }
        let lever = self.lever * contact.effective_radius;
        let normal = contact.normal;
        if self.rolling.friction > 0.0 {
            let velocity = normal.cross(contact.spin) * -lever;
            let spring = follow(self.rotation, history.rolling, contact, dt) + velocity * dt;
            let stiffness = self.rolling.stiffness.unwrap_or(tangential_stiffness);
            let (force, spring) = self
                .rolling
                .force(spring, velocity, normal_force, stiffness);
            history.rolling = spring;
            couple += normal.cross(force) * lever;
        }
        if self.torsion.friction > 0.0 {
            let velocity = normal * (lever * normal.dot(contact.spin));
            let spring = normal * (history.torsion + velocity * dt).dot(normal);
            let stiffness = self.torsion.stiffness.unwrap_or(tangential_stiffness);
            let (force, spring) = self
                .torsion
                .force(spring, velocity, normal_force, stiffness);
            history.torsion = spring;
            couple += force * lever;
        }
        couple
    }

    fn energy(&self, tangential_stiffness: f64, history: &RollingSprings) -> f64 {
        let part = |spring: &FrictionSpring, length: DVec3| {
            0.5 * spring.stiffness.unwrap_or(tangential_stiffness) * length.length_squared()
        };
        part(&self.rolling, history.rolling) + part(&self.torsion, history.torsion)
    }
}

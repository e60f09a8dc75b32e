//! Rolling and torsion resistance: couples from springs that look just like the sliding one
//! (Luding 2008).
//!
//! A lever turns relative rotation into a displacement, the spring-dashpot-slider turns that into a
//! virtual force, and the same lever turns the force into a couple. No force acts on the bodies.

use glam::DVec3;

use super::tangential::{Slider, grown_spring, half_turn};
use super::{Kinematics, TangentialHistory};

/// Parameters of rolling or torsion resistance.
#[derive(Debug, Clone, Copy)]
pub struct Resistance {
    /// Spring stiffness.
    pub stiffness: ResistanceStiffness,
    /// Dashpot \[kg/s\].
    pub dissipation: f64,
    /// Coefficient while it yields; the largest couple is lever · friction · N.
    pub friction: f64,
    /// Coefficient at which it starts to yield.
    pub static_friction: f64,
}

/// Where the stiffness of a rolling or torsion spring comes from.
#[derive(Debug, Clone, Copy)]
pub enum ResistanceStiffness {
    /// A value \[N/m\].
    Fixed(f64),
    /// k_t of the contact: that of the linear law, or 8 G* √(R* δ) of the Mindlin law.
    Sliding,
}

impl Resistance {
    fn stiffness(&self, sliding_stiffness: f64) -> f64 {
        match self.stiffness {
            ResistanceStiffness::Fixed(stiffness) => stiffness,
            ResistanceStiffness::Sliding => sliding_stiffness,
        }
    }

    /// Couple on A against rolling \[N m\] and stored energy \[J\].
    pub(super) fn rolling_couple(
        &self,
        kinematics: &Kinematics,
        follows: TangentialHistory,
        lever: f64,
        sliding_stiffness: f64,
        pressure: f64,
        spring: &mut DVec3,
        spring_time: f64,
    ) -> (DVec3, f64) {
        if self.friction == 0.0 {
            return (DVec3::ZERO, 0.0);
        }
        let velocity = -lever * kinematics.sliding_normal.cross(kinematics.relative_spin);
        let velocity = kinematics.laid_into_plane(velocity);
        let grown = grown_spring(*spring, velocity, kinematics, follows, spring_time);
        let (force, energy) = self.respond(grown, velocity, sliding_stiffness, pressure, spring);
        (lever * kinematics.normal.cross(force), energy)
    }

    /// Couple on A against spinning about the normal \[N m\] and stored energy \[J\].
    pub(super) fn torsion_couple(
        &self,
        kinematics: &Kinematics,
        lever: f64,
        sliding_stiffness: f64,
        pressure: f64,
        spring: &mut DVec3,
        spring_time: f64,
    ) -> (DVec3, f64) {
        if self.friction == 0.0 {
            return (DVec3::ZERO, 0.0);
        }
        let normal = kinematics.normal;
        let half = kinematics.sliding_normal;
        let velocity = lever * half.dot(kinematics.relative_spin) * normal;
        let grown = (half_turn(*spring, half) + velocity * spring_time).dot(normal) * normal;
        let (force, energy) = self.respond(grown, velocity, sliding_stiffness, pressure, spring);
        (lever * force, energy)
    }

    /// The virtual force \[N\] and the stored energy \[J\]; keeps the spring.
    fn respond(
        &self,
        grown: DVec3,
        velocity: DVec3,
        sliding_stiffness: f64,
        pressure: f64,
        spring: &mut DVec3,
    ) -> (DVec3, f64) {
        let stiffness = self.stiffness(sliding_stiffness);
        let slider = Slider::new(pressure, self.friction, self.static_friction);
        let (force, kept) = slider.limit_total(grown, stiffness, self.dissipation, velocity);
        *spring = kept;
        (force, 0.5 * stiffness * kept.length_squared())
    }
}

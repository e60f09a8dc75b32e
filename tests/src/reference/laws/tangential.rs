//! Sliding friction: a spring and a dashpot that hold until Coulomb's limit is reached.

use glam::DVec3;

use super::{Conventions, CoulombLimits, History, Kinematics, TangentialHistory};

/// A law of sliding friction.
#[derive(Debug, Clone, Copy)]
pub enum Tangential {
    /// Smooth bodies.
    None,
    /// f = −k_t ξ − γ_t u_t, |f| ≤ μ N (Cundall & Strack 1979).
    Linear {
        /// k_t \[N/m\].
        stiffness: f64,
        /// γ_t \[kg/s\].
        dissipation: f64,
        /// μ, in sliding.
        friction: f64,
        /// μ_s, what it takes to start sliding.
        static_friction: f64,
    },
    /// Friction of elastic spheres: f = −c k_t ξ with k_t = 8 G* √(R* δ) and damping
    /// β_t √(m* k_t) u_t (Mindlin 1949; the factor c: Di Renzo & Di Maio 2005).
    Mindlin {
        /// G* \[Pa\].
        effective_shear_modulus: f64,
        /// β_t.
        damping: f64,
        /// μ, in sliding.
        friction: f64,
        /// μ_s, what it takes to start sliding.
        static_friction: f64,
        /// c: 2/3 by default, 1 for Mindlin's solution at constant load.
        stiffness_factor: f64,
        /// Effect of a changing normal load on the stored force.
        load_history: LoadHistory,
    },
}

/// Effect of a changing normal load on the force of the Mindlin law.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LoadHistory {
    /// The displacement is remembered and the present stiffness applied to all of it.
    #[default]
    Secant,
    /// The force is remembered. In a step it is turned to the new tangent plane (length kept);
    /// when the contact radius a has decreased, multiplied by a_new/a_old; then it grows by
    /// −c k_t u_t dt; then Coulomb's limit applies (Thornton, Cummins & Cleary 2013).
    Rescale,
}

impl Tangential {
    /// Stiffness k_t of a contact without the Mindlin factor; zero without friction law \[N/m\].
    pub(super) fn stiffness(&self, kinematics: &Kinematics) -> f64 {
        match *self {
            Tangential::None => 0.0,
            Tangential::Linear { stiffness, .. } => stiffness,
            Tangential::Mindlin {
                effective_shear_modulus,
                ..
            } => 8.0 * effective_shear_modulus * kinematics.contact_radius(),
        }
    }

    /// How the springs of this law, and of the rolling law beside it, follow the contact.
    pub(super) fn history_of_springs(&self, conventions: &Conventions) -> TangentialHistory {
        match self {
            Tangential::Mindlin { .. } => TangentialHistory::Project,
            _ => conventions.tangential_history,
        }
    }

    /// Friction force on A \[N\] and stored energy \[J\] under the normal force \[N\].
    pub(super) fn evaluate(
        &self,
        kinematics: &Kinematics,
        conventions: &Conventions,
        normal_force: f64,
        history: &mut History,
        spring_time: f64,
    ) -> (DVec3, f64) {
        let velocity = kinematics.tangential_velocity();
        let follows = self.history_of_springs(conventions);
        let limits = conventions.coulomb_limits;
        let pressure = match limits {
            CoulombLimits::Bounded => normal_force.max(0.0),
            CoulombLimits::Elastic | CoulombLimits::Total => {
                if normal_force == 0.0 {
                    return (DVec3::ZERO, 0.0); // nothing happens to the spring
                }
                normal_force.abs()
            }
        };
        match *self {
            Tangential::None => (DVec3::ZERO, 0.0),
            Tangential::Linear { friction, .. } | Tangential::Mindlin { friction, .. }
                if friction == 0.0 =>
            {
                (DVec3::ZERO, 0.0)
            }
            Tangential::Linear {
                stiffness,
                dissipation,
                friction,
                static_friction,
            } => {
                let slider = Slider::new(pressure, friction, static_friction);
                let spring =
                    grown_spring(history.sliding, velocity, kinematics, follows, spring_time);
                let (force, spring) = match limits {
                    CoulombLimits::Bounded if stiffness > 0.0 => {
                        slider.limit_bounded(spring, stiffness, dissipation, velocity)
                    }
                    _ => slider.limit_total(spring, stiffness, dissipation, velocity),
                };
                history.sliding = spring;
                (force, 0.5 * stiffness * spring.length_squared())
            }
            Tangential::Mindlin {
                damping,
                friction,
                static_friction,
                stiffness_factor,
                load_history,
                ..
            } => {
                let slider = Slider::new(pressure, friction, static_friction);
                let full_stiffness = self.stiffness(kinematics);
                let stiffness = stiffness_factor * full_stiffness;
                let dissipation = damping * (kinematics.effective_mass * full_stiffness).sqrt();
                // Both variants meet in a spring of the present stiffness: what they do next,
                // sticking or sliding, is the same.
                let spring = match load_history {
                    LoadHistory::Secant => {
                        grown_spring(history.sliding, velocity, kinematics, follows, spring_time)
                    }
                    LoadHistory::Rescale => {
                        let before = history.contact_radius;
                        let stored = rescaled_force(history, kinematics);
                        // The stiffness in the middle of the step, and the shrinking of its second half.
                        let now = kinematics.contact_radius();
                        let middle = if before > 0.0 {
                            stiffness * now.min(0.5 * (before + now)) / now
                        } else {
                            stiffness
                        };
                        (middle * velocity * spring_time - stored) / stiffness
                    }
                };
                let (force, spring) = match limits {
                    CoulombLimits::Bounded => {
                        slider.limit_bounded(spring, stiffness, dissipation, velocity)
                    }
                    CoulombLimits::Elastic => {
                        slider.limit_elastic(spring, stiffness, dissipation, velocity)
                    }
                    CoulombLimits::Total => {
                        slider.limit_total(spring, stiffness, dissipation, velocity)
                    }
                };
                history.sliding = match load_history {
                    LoadHistory::Secant => spring,
                    LoadHistory::Rescale => -stiffness * spring,
                };
                (force, 0.5 * stiffness * spring.length_squared())
            }
        }
    }
}

/// The stored force, turned into the tangent plane and reduced if the contact area has shrunk.
fn rescaled_force(history: &mut History, kinematics: &Kinematics) -> DVec3 {
    let mut stored = turned(history.sliding, kinematics);
    let contact_radius = kinematics.contact_radius();
    if contact_radius < history.contact_radius {
        stored *= contact_radius / history.contact_radius;
    }
    history.contact_radius = contact_radius;
    stored
}

/// Coulomb's limits of a contact \[N\].
pub(super) struct Slider {
    /// The force at which it starts to slide.
    static_limit: f64,
    /// The force while it slides.
    dynamic_limit: f64,
}

impl Slider {
    pub(super) fn new(pressure: f64, friction: f64, static_friction: f64) -> Self {
        Self {
            static_limit: static_friction * pressure,
            dynamic_limit: friction * pressure,
        }
    }

    /// Spring and dashpot in parallel, their sum limited. Returns the force and the spring, which
    /// in sliding is set so that spring plus dashpot give just the limit.
    pub(super) fn limit_total(
        &self,
        spring: DVec3,
        stiffness: f64,
        dissipation: f64,
        velocity: DVec3,
    ) -> (DVec3, DVec3) {
        let trial = -stiffness * spring - dissipation * velocity;
        if trial.length() <= self.static_limit {
            return (trial, spring);
        }
        let force = trial * (self.dynamic_limit / trial.length());
        if stiffness == 0.0 {
            return (force, spring); // a dashpot alone has nothing to reset
        }
        (force, -(force + dissipation * velocity) / stiffness)
    }

    /// The spring limited; while it sticks spring and dashpot together, which leaves the spring as it is.
    fn limit_bounded(
        &self,
        spring: DVec3,
        stiffness: f64,
        dissipation: f64,
        velocity: DVec3,
    ) -> (DVec3, DVec3) {
        let elastic = -stiffness * spring;
        if elastic.length() > self.static_limit {
            let force = elastic * (self.dynamic_limit / elastic.length());
            return (force, -force / stiffness);
        }
        let sum = elastic - dissipation * velocity;
        (sum.clamp_length_max(self.static_limit), spring)
    }

    /// The spring limited, the dashpot acting only while it sticks.
    fn limit_elastic(
        &self,
        spring: DVec3,
        stiffness: f64,
        dissipation: f64,
        velocity: DVec3,
    ) -> (DVec3, DVec3) {
        let trial = -stiffness * spring;
        if trial.length() < self.static_limit {
            return (trial - dissipation * velocity, spring);
        }
        let force = trial * (self.dynamic_limit / trial.length());
        (force, -force / stiffness)
    }
}

/// A spring after the contact has turned and its ends have moved apart for `spring_time`.
pub(super) fn grown_spring(
    spring: DVec3,
    velocity: DVec3,
    kinematics: &Kinematics,
    follows: TangentialHistory,
    spring_time: f64,
) -> DVec3 {
    match (follows, kinematics.pair) {
        (TangentialHistory::Project, _) => turned(spring, kinematics) + velocity * spring_time,
        (TangentialHistory::Incremental, Some(centre_velocity)) => {
            let turning = spring.dot(centre_velocity) / kinematics.sliding_distance
                * kinematics.sliding_normal;
            spring + (velocity - turning) * spring_time
        }
        (TangentialHistory::Incremental, None) => spring + velocity * spring_time,
    }
}

/// A vector of the old tangent plane in the new one.
fn turned(vector: DVec3, kinematics: &Kinematics) -> DVec3 {
    // The half turn about the normal of the middle takes the old normal to the new one. It takes the vector to the opposite of
    // what the short rotation does. By the rule of the step that normal is the new one, and this is a projection.
    let turned = -half_turn(vector, kinematics.sliding_normal);
    let along = turned.dot(kinematics.normal).abs();
    if along > 1e-8 * turned.length() {
        return projected(turned, kinematics.normal);
    }
    kinematics.laid_into_plane(turned)
}

/// A vector after half a turn about an axis of length 1.
pub(super) fn half_turn(vector: DVec3, axis: DVec3) -> DVec3 {
    2.0 * vector.dot(axis) * axis - vector
}

/// A vector projected on the plane normal to `normal`, with its old length; one along the normal has no direction in the plane.
fn projected(vector: DVec3, normal: DVec3) -> DVec3 {
    let length = vector.length();
    let in_plane = vector - vector.dot(normal) * normal;
    if in_plane.length() <= 1e-12 * length {
        return in_plane;
    }
    in_plane * (length / in_plane.length())
}

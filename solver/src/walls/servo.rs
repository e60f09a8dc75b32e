//! Servo motion: a wall that is driven to a force.
//!
//! The wall moves as a plate without mass would that is pushed by the target force through a dashpot,
//!
//! ```text
//! c v = F_target - F,     |v| <= max_speed,
//! ```
//!
//! where F is the force of the wall on the particles along the axis in the last step. It rests only where F is the target, and
//! as a dashpot only takes energy, it excites no bed. The coefficient follows the contacts that the wall has at the time,
//!
//! ```text
//! c = sum over contacts of 4 sqrt(m k) + 2 gamma + 4 k dt,
//! ```
//!
//! with the mass m of the particle, the stiffness k and the viscous coefficient gamma of its contact. It acts one step late.
//! Against particles that cannot move the overlap d follows d' = d + v dt, v' = (F_target - k d' - gamma v)/c, whose roots obey
//! z^2 - (1 - a - b) z - b = 0 with a = k dt/c <= 1/4 and b = gamma/c <= 1/2. Jury's conditions (Jury 1964) |b| < 1, a > 0 and
//! a + 2 b < 2 hold for any number of contacts, any damping and any step. Without damping the error shrinks by 1 - a in every
//! step and keeps its sign: no overshoot.

use glam::DVec3;

use super::pose::{Pose, RigidVelocity};

/// What a servo is to do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Servo {
    /// Direction; later motions of the wall turn it along.
    pub axis: DVec3,
    /// Force of the wall on the particles along the axis, N.
    pub force: f64,
    /// Never faster than this, m/s.
    pub max_speed: f64,
    /// Begins, in s.
    pub from: f64,
    /// Ends, in s; may be infinite.
    pub until: f64,
}

/// How far a servo has come. At rest for walls without one.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ServoState {
    /// Along the axis, m.
    pub displacement: f64,
    /// Velocity along the axis in the last step, m/s.
    pub velocity: f64,
    /// Velocity along the axis for the next step, m/s.
    pub next_velocity: f64,
}

/// What the contacts of a wall answer to its motion: the sums from which a servo takes its coefficient.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WallStiffness {
    /// Sum of the normal stiffnesses k, N/m.
    pub stiffness: f64,
    /// Sum of 4 sqrt(m k) + 2 gamma, N s/m.
    pub damping: f64,
}

impl WallStiffness {
    /// Adds a contact with a particle of `mass` (kg; infinite if it is fixed): elastic and viscous normal force (N) at `overlap`
    /// (m) and normal velocity (m/s).
    ///
    /// The stiffness is 3/2 of the secant one: exact for Hertz' law, above that of linear ones.
    #[inline]
    pub fn add_contact(
        &mut self,
        mass: f64,
        (elastic, overlap): (f64, f64),
        (viscous, velocity): (f64, f64),
    ) {
        if overlap > 0.0 {
            let stiffness = (1.5 * elastic / overlap).max(0.0);
            self.stiffness += stiffness;
            if mass.is_finite() {
                self.damping += 4.0 * (mass * stiffness).sqrt();
            }
        }
        if velocity != 0.0 {
            self.damping += 2.0 * (viscous / velocity).abs();
        }
    }

    /// Adds the contacts of another part.
    pub fn add(&mut self, other: &Self) {
        self.stiffness += other.stiffness;
        self.damping += other.damping;
    }
}

impl Servo {
    /// Moves on by a step of `dt` (s) that ends at `time` (s).
    #[must_use]
    pub fn advance(&self, state: ServoState, time: f64, dt: f64) -> ServoState {
        let middle = time - 0.5 * dt;
        let velocity = if middle >= self.from && middle < self.until {
            state.next_velocity
        } else {
            0.0
        };
        ServoState {
            displacement: state.displacement + velocity * dt,
            velocity,
            ..state
        }
    }

    /// The velocity for the next step, m/s, after `force` (N) of the wall on the particles along the axis.
    #[must_use]
    pub fn answer(&self, force: f64, wall: &WallStiffness, dt: f64) -> f64 {
        let missing = self.force - force;
        let coefficient = wall.damping + 4.0 * wall.stiffness * dt;
        // Nothing touches: as fast as it may.
        if coefficient == 0.0 {
            return if missing == 0.0 {
                0.0
            } else {
                self.max_speed.copysign(missing)
            };
        }
        (missing / coefficient).clamp(-self.max_speed, self.max_speed)
    }

    pub(super) fn pose(&self, state: &ServoState) -> Pose {
        Pose {
            translation: self.axis * state.displacement,
            ..Pose::IDENTITY
        }
    }

    pub(super) fn velocity(&self, state: &ServoState) -> RigidVelocity {
        RigidVelocity {
            velocity: self.axis * state.velocity,
            ..RigidVelocity::REST
        }
    }
}

crate::state::plain!(ServoState {
    displacement,
    velocity,
    next_velocity
});

#[cfg(test)]
mod tests {
    use super::*;

    const SERVO: Servo = Servo {
        axis: DVec3::Z,
        force: -3.0,
        max_speed: 0.5,
        from: 0.0,
        until: f64::INFINITY,
    };

    /// Pushes `springs` fixed springs with dashpots to the target; returns the forces (N).
    fn press(springs: u32, stiffness: f64, damping: f64, dt: f64) -> Vec<f64> {
        let (mut state, mut forces) = (ServoState::default(), Vec::new());
        for step in 1..=40_000 {
            state = SERVO.advance(state, f64::from(step) * dt, dt);
            // The springs begin 1e-3 m below the wall.
            let overlap = -state.displacement - 1e-3;
            let (mut wall, mut force) = (WallStiffness::default(), 0.0);
            if overlap > 0.0 {
                for _ in 0..springs {
                    let viscous = damping * -state.velocity;
                    let elastic = stiffness * overlap;
                    let contact = (viscous, state.velocity);
                    wall.add_contact(f64::INFINITY, (elastic, overlap), contact);
                    force -= elastic + viscous;
                }
            }
            state.next_velocity = SERVO.answer(force, &wall, dt);
            assert!(state.next_velocity.abs() <= SERVO.max_speed);
            forces.push(force);
        }
        forces
    }

    #[test]
    fn it_settles_on_any_springs_with_any_damping() {
        for springs in [1, 7, 1000] {
            for damping in [0.0, 1.0, 50.0] {
                let forces = press(springs, 1e4, damping, 1e-5);
                let last = forces.last().copied().unwrap();
                assert!((last + 3.0).abs() < 1e-6, "{springs}, {damping}: {last}");
            }
        }
    }

    #[test]
    fn without_damping_it_never_presses_more_than_it_should() {
        // In the first step that touches it presses at most by k max_speed dt = 0.05 N.
        let forces = press(1, 1e4, 0.0, 1e-5);
        let most = forces.iter().fold(0.0, |most: f64, force| most.min(*force));
        assert!(most >= -3.0 * (1.0 + 1e-12), "{most}");
    }

    #[test]
    fn its_coefficient_is_the_sum_over_the_contacts() {
        let mut wall = WallStiffness::default();
        // k = 3/2 of 6 N / 1 mm = 9000 N/m, gamma = 3 N / 0.5 m/s = 6 N s/m, m = 2 kg; the other, fixed, has no mass.
        wall.add_contact(2.0, (6.0, 1e-3), (3.0, -0.5));
        wall.add_contact(f64::INFINITY, (6.0, 1e-3), (-3.0, 0.5));
        let dt = 1e-4;
        let coefficient = 4.0 * 18_000.0_f64.sqrt() + 2.0 * (2.0 * 6.0) + 4.0 * 18_000.0 * dt;
        let answer = SERVO.answer(4.0, &wall, dt);
        assert!((answer * coefficient + 7.0).abs() < 7e-15, "{answer}");
    }

    #[test]
    fn it_rests_before_and_after_its_time() {
        let servo = Servo {
            from: 1.0,
            until: 2.0,
            ..SERVO
        };
        let state = ServoState {
            next_velocity: 0.5,
            ..ServoState::default()
        };
        assert_eq!(servo.advance(state, 1.0, 0.1).displacement, 0.0);
        assert_eq!(servo.advance(state, 1.1, 0.1).displacement, 0.05);
        // The step that ends with its time is its last.
        assert_eq!(servo.advance(state, 2.0, 0.1).velocity, 0.5);
        assert_eq!(servo.advance(state, 2.1, 0.1).velocity, 0.0);
    }
}

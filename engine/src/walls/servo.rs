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
//! with the mass m of the particle, the stiffness k and the viscous coefficient gamma of its contact. Of a sheet whose vertices the wall holds each
//! triangle, edge and hinge between a held and another vertex counts like a contact, with the mass of the free vertices that it moves. The servo acts
//! one step late.
//! Against particles that cannot move the overlap d follows d' = d + v dt, v' = (F_target - k d' - gamma v)/c, whose roots obey
//! z^2 - (1 - a - b) z - b = 0 with a = k dt/c <= 1/4 and b = gamma/c <= 1/2. Jury's conditions (Jury 1964) |b| < 1, a > 0 and
//! a + 2 b < 2 hold for any number of contacts, any damping and any step. Without damping the error shrinks by 1 - a in every
//! step and keeps its sign: no overshoot.

use glam::DVec3;

use super::pose::{Pose, RigidVelocity};
use super::target::{Area, Target};

/// Windows of the means in the time for which a servo has acted.
const WINDOWS: f64 = 20.0;

/// Servo: its direction, target and limits.
#[derive(Debug, Clone, PartialEq)]
pub struct Servo {
    /// Direction; later motions of the wall turn it along.
    pub axis: DVec3,
    /// Force of the wall on the particles along the axis, or pressure.
    pub target: Target,
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
    /// How well it has followed its target so far.
    pub followed: Followed,
}

/// How well a servo has followed its target: means over a [window](Servo::window_of_means) of physical time in which older steps count less and
/// less, whatever the step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Followed {
    /// Sums of the actual and the target values, N or Pa, with the weights of their steps.
    sums: [f64; 2],
    /// Sum of the squares of the actual less the target values, with the weights of their steps, N^2 or Pa^2.
    squares: f64,
    /// Sum of the weights: 1 after a time that is long beside the window.
    weight: f64,
    /// Largest magnitude of the target so far, N or Pa.
    largest: f64,
    /// When the mean came near the target first, s; none: never.
    reached_at: Option<f64>,
    /// The area at the end, m^2.
    area: f64,
}

impl Followed {
    /// Largest distance of the mean from the target, over the largest target so far, to count as there.
    pub const NEAR: f64 = 0.05;

    /// Adds the actual and the target value (N or Pa) of a step that ends at `time` (s) and is this share of the window.
    fn take_in(&mut self, [actual, asked]: [f64; 2], area: f64, time: f64, share: f64) {
        let share = share.min(1.0);
        for (sum, value) in self.sums.iter_mut().zip([actual, asked]) {
            *sum += (value - *sum) * share;
        }
        let missed = actual - asked;
        self.squares += (missed * missed - self.squares) * share;
        self.weight += (1.0 - self.weight) * share;
        self.largest = self.largest.max(asked.abs());
        self.area = area;
        if self.reached_at.is_none() && self.is_near() {
            self.reached_at = Some(time);
        }
    }

    /// The means of the actual and the target values, N or Pa; `None` before its first step.
    #[must_use]
    pub fn means(&self) -> Option<[f64; 2]> {
        (self.weight > 0.0).then(|| self.sums.map(|sum| sum / self.weight))
    }

    /// Standard deviation of the actual less the target values, N or Pa; `None` before its first step.
    #[must_use]
    pub fn scatter(&self) -> Option<f64> {
        let [actual, asked] = self.means()?;
        let missed = actual - asked;
        Some(
            (self.squares / self.weight - missed * missed)
                .max(0.0)
                .sqrt(),
        )
    }

    /// Whether the mean is near its target now. If the target was always 0 there is no measure of near: then it is.
    #[must_use]
    pub fn is_near(&self) -> bool {
        let Some([actual, asked]) = self.means() else {
            return false;
        };
        self.largest == 0.0 || (actual - asked).abs() <= Self::NEAR * self.largest
    }

    /// When the mean came near the target first, s.
    #[must_use]
    pub fn reached_at(&self) -> Option<f64> {
        self.reached_at
    }

    /// The area over which a pressure acted at the end, m^2.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Largest magnitude of the target, N or Pa.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.largest
    }
}

/// Stiffness and damping of the contacts of a wall, and of sheets that it holds, against its motion: the sums from which a servo takes its coefficient.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WallStiffness {
    /// Sum of the normal stiffnesses k, N/m.
    pub stiffness: f64,
    /// Sum of 4 sqrt(m k) + 2 gamma, N s/m.
    pub damping: f64,
}

crate::state::plain!(WallStiffness { stiffness, damping });

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
        let stiffness = if overlap > 0.0 {
            (1.5 * elastic / overlap).max(0.0)
        } else {
            0.0
        };
        let dashpot = if velocity == 0.0 {
            0.0
        } else {
            (viscous / velocity).abs()
        };
        self.add_spring(mass, stiffness, dashpot);
    }

    /// Adds a spring (N/m) and a dashpot (N s/m) between the wall and something of `mass` (kg; infinite if it is held).
    #[inline]
    pub fn add_spring(&mut self, mass: f64, stiffness: f64, dashpot: f64) {
        self.stiffness += stiffness;
        if mass.is_finite() {
            self.damping += 4.0 * (mass * stiffness).sqrt();
        }
        self.damping += 2.0 * dashpot;
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
        let velocity = if self.is_acting(time, dt) {
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

    /// When it begins and ends, s.
    #[must_use]
    pub fn window(&self) -> [f64; 2] {
        [self.from, self.until]
    }

    /// The window (s) of the means of [`Followed`] at `time` (s): a twentieth of the time for which the servo has acted.
    ///
    /// It grows with that time: the weight of a step of age a, when the servo has acted for t, is (1 - a/t)^19, about exp(-20 a/t).
    #[must_use]
    pub fn window_of_means(&self, time: f64) -> f64 {
        (time.min(self.until) - self.from.max(0.0)).max(0.0) / WINDOWS
    }

    /// Whether it moves the wall in the step of `dt` (s) that ends at `time` (s).
    fn is_acting(&self, time: f64, dt: f64) -> bool {
        let middle = time - 0.5 * dt;
        middle >= self.from && middle < self.until
    }

    /// The area that a pressure acts over, m^2: a given one, or the wall's `own`. 1 of a force.
    #[must_use]
    pub fn area(&self, own: impl FnOnce() -> f64) -> f64 {
        match self.target {
            Target::Force(_) => 1.0,
            Target::Pressure(_, Area::Given(area)) => area,
            Target::Pressure(_, Area::OfWall) => own(),
        }
    }

    /// Answers to `force` (N) of the wall on the particles along the axis, over `area` ([`Servo::area`]), in the step of `dt` (s) that ends at `time`
    /// (s): with the velocity for the next step.
    pub fn follow(
        &self,
        state: &mut ServoState,
        (force, area): (f64, f64),
        wall: &WallStiffness,
        (time, dt): (f64, f64),
    ) {
        let asked = self.target.curve().at(time);
        state.next_velocity = self.answer(asked * area - force, wall, dt);
        if self.is_acting(time, dt) {
            let actual = if area > 0.0 { force / area } else { 0.0 };
            let share = dt / self.window_of_means(time);
            let loads = [actual, asked];
            state.followed.take_in(loads, area, time, share);
        }
    }

    /// The velocity for the next step, m/s, where `missing` (N) is what the force of the wall on the particles along the axis lacks.
    #[must_use]
    pub fn answer(&self, missing: f64, wall: &WallStiffness, dt: f64) -> f64 {
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
    next_velocity,
    followed
});

crate::state::plain!(Followed {
    sums,
    squares,
    weight,
    largest,
    reached_at,
    area
});

#[cfg(test)]
mod tests {
    use mercury_common::curve::Curve;

    use super::*;

    const MAX_SPEED: f64 = 0.5;

    fn servo() -> Servo {
        Servo {
            axis: DVec3::Z,
            target: Target::Force(Curve::constant(-3.0).unwrap()),
            max_speed: MAX_SPEED,
            from: 0.0,
            until: f64::INFINITY,
        }
    }

    /// Pushes `springs` fixed springs with dashpots to the target; returns the forces (N).
    fn press(springs: u32, stiffness: f64, damping: f64, dt: f64) -> Vec<f64> {
        let (servo, mut state, mut forces) = (servo(), ServoState::default(), Vec::new());
        for step in 1..=40_000 {
            let time = f64::from(step) * dt;
            state = servo.advance(state, time, dt);
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
            servo.follow(&mut state, (force, 1.0), &wall, (time, dt));
            assert!(state.next_velocity.abs() <= MAX_SPEED);
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
        let answer = servo().answer(-3.0 - 4.0, &wall, dt);
        assert!((answer * coefficient + 7.0).abs() < 7e-15, "{answer}");
    }

    #[test]
    fn it_rests_before_and_after_its_time() {
        let servo = Servo {
            from: 1.0,
            until: 2.0,
            ..servo()
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

    #[test]
    fn a_mean_over_a_window_says_whether_it_is_there() {
        let mut followed = Followed::default();
        assert_eq!(followed.means(), None);
        assert_eq!(followed.scatter(), None);
        assert!(!followed.is_near());
        // One blow is no arrival: after n steps at 10 % and one at 200 % the mean of few is far from the target.
        for step in 0..3000 {
            let actual = if step == 50 { 6.0 } else { 0.3 };
            followed.take_in([actual, 3.0], 1.0, 0.1, 1e-3);
        }
        assert!(!followed.is_near() && followed.reached_at().is_none());
        // It forgets by exp(-n/1000): 0.9 of the target is missing, 0.05 are allowed, after 1000 ln(18) = 2890 steps.
        for step in 0..4000 {
            followed.take_in([3.0, 3.0], 1.0, f64::from(step), 1e-3);
        }
        assert!(followed.is_near());
        let reached = followed.reached_at().unwrap();
        assert!((reached - 2890.0).abs() < 100.0, "{reached}");
        let mut idle = Followed::default();
        idle.take_in([0.2, 0.0], 1.0, 0.0, 1e-3);
        assert!(idle.is_near());
    }

    /// A load of 1000 Pa that swings by 30 % and slowly, such that it is far off when it ends: mean and scatter are those of the swing, at any step.
    #[test]
    fn a_load_that_swings_about_its_target_is_there() {
        let servo = Servo {
            target: Target::Pressure(Curve::constant(1000.0).unwrap(), Area::Given(1.0)),
            ..servo()
        };
        // 100 swings in a run of 10 s and five in a window of 0.5 s; it ends in the lowest point.
        let (end, omega) = (10.0_f64, std::f64::consts::TAU * 100.75 / 10.0);
        let found = [1e-3, 1e-4].map(|dt| {
            let (mut state, wall) = (ServoState::default(), WallStiffness::default());
            let steps = (end / dt).round() as u32;
            for step in 1..=steps {
                let time = f64::from(step) * dt;
                let load = 1000.0 + 300.0 * libm::sin(omega * time);
                servo.follow(&mut state, (load, 1.0), &wall, (time, dt));
            }
            let last = 1000.0 + 300.0 * libm::sin(omega * end);
            assert!(last < 701.0, "{last}");
            let followed = state.followed;
            assert!(followed.is_near());
            let [actual, asked] = followed.means().unwrap();
            assert_eq!(asked.round(), 1000.0);
            // A sine of omega seen through exp(-t/T) has 1/sqrt(1 + (omega T)^2) of its amplitude: 300/31.6.
            assert!((actual - 1000.0).abs() < 300.0 / (omega * 0.5), "{actual}");
            let scatter = followed.scatter().unwrap();
            // sqrt(1/2) of the amplitude, to a part in 2 omega T.
            let expected = 300.0 * 0.5_f64.sqrt();
            assert!(
                (scatter / expected - 1.0).abs() < 1.0 / (omega * 0.5),
                "{scatter}"
            );
            [actual, scatter]
        });
        // A hundredth of a swing's period in the longer step.
        let [coarse, fine] = found;
        for (coarse, fine) in coarse.into_iter().zip(fine) {
            assert!(
                (coarse - fine).abs() < 300.0 * omega * 1e-3,
                "{coarse} {fine}"
            );
        }
    }

    #[test]
    fn a_pressure_is_a_force_over_the_area() {
        let target = |area| Target::Pressure(Curve::constant(100.0).unwrap(), area);
        let over = |area| Servo {
            target: target(area),
            ..servo()
        };
        assert_eq!(over(Area::Given(0.25)).area(|| 7.0), 0.25);
        assert_eq!(over(Area::OfWall).area(|| 7.0), 7.0);
        assert_eq!(servo().area(|| 7.0), 1.0);
        let wall = WallStiffness {
            stiffness: 0.0,
            damping: 100.0,
        };
        let mut state = ServoState::default();
        over(Area::OfWall).follow(&mut state, (5.0, 0.25), &wall, (1.0, 0.1));
        // The target is 25 N, 20 N are missing.
        assert_eq!(state.next_velocity, 0.2);
        assert_eq!(
            state.followed.means().map(|m| m.map(f64::round)),
            Some([20.0, 100.0])
        );
    }
}

//! Motion of rigid walls: prescribed, in closed form in time, or driven to a force.

use super::error::{WallError, direction, finite, finite_vector, not_negative};
use super::motion_table::MotionTable;
use super::pose::{Pose, RigidVelocity};
use super::servo::{Servo, ServoState};
use glam::{DQuat, DVec3};
use mercury_common::turns::{about_axis, by_vector};
use std::f64::consts::TAU;

/// One motion. Before `from` (s) it has moved nothing, after `until` (s) it stays as it was then.
#[derive(Debug, Clone, PartialEq)]
pub enum Component {
    /// A shift with constant velocity.
    Translation {
        /// In m/s.
        velocity: DVec3,
        /// Begins, in s.
        from: f64,
        /// Ends, in s; may be infinite.
        until: f64,
    },
    /// A right-handed turn with constant angular velocity.
    Rotation {
        /// Direction of the axis, of any length.
        axis: DVec3,
        /// A point of the axis in m, in the coordinates of the scene; later motions carry it along.
        origin: DVec3,
        /// In rad/s.
        angular_velocity: f64,
        /// Begins, in s.
        from: f64,
        /// Ends, in s; may be infinite.
        until: f64,
    },
    /// The shift `amplitude (sin(2 pi frequency (t - from) + phase) - sin(phase))`.
    ///
    /// The constant makes the wall start where the scene puts it, for any phase, without a jump; at
    /// phase pi/2 it starts from rest, at the end of its stroke.
    Oscillation {
        /// In m.
        amplitude: DVec3,
        /// In 1/s.
        frequency: f64,
        /// In rad.
        phase: f64,
        /// Begins, in s.
        from: f64,
        /// Ends, in s; may be infinite.
        until: f64,
    },
    /// A motion read from a file: a turn about `origin`, and then a shift.
    Table {
        /// The rows.
        table: MotionTable,
        /// The point about which the rotation vectors turn, in m.
        origin: DVec3,
    },
    /// A shift that follows a force.
    Servo(Servo),
    /// As another program drives it, window by window; it has no other motion then.
    External,
}

impl Component {
    /// Checks the numbers and gives axes unit length.
    fn checked(mut self) -> Result<Self, WallError> {
        let mut period = None;
        match &mut self {
            Self::Translation {
                velocity,
                from,
                until,
            } => {
                finite_vector("velocity", *velocity)?;
                period = Some((*from, *until));
            }
            Self::Rotation {
                axis,
                origin,
                angular_velocity,
                from,
                until,
            } => {
                *axis = direction("axis", *axis)?;
                finite_vector("origin", *origin)?;
                finite("angular_velocity", *angular_velocity)?;
                period = Some((*from, *until));
            }
            Self::Oscillation {
                amplitude,
                frequency,
                phase,
                from,
                until,
            } => {
                finite_vector("amplitude", *amplitude)?;
                not_negative("frequency", *frequency)?;
                finite("phase", *phase)?;
                period = Some((*from, *until));
            }
            Self::Table { origin, .. } => {
                finite_vector("origin", *origin)?;
            }
            Self::Servo(servo) => {
                servo.axis = direction("axis", servo.axis)?;
                not_negative("max_speed", servo.max_speed)?;
                period = Some((servo.from, servo.until));
            }
            Self::External => {}
        }
        if let Some((from, until)) = period {
            finite("from", from)?;
            if until.is_nan() || until < from {
                return Err(WallError::NotIncreasing {
                    key: "until",
                    from,
                    to: until,
                });
            }
        }
        Ok(self)
    }

    fn is_static(&self) -> bool {
        match self {
            Self::Translation {
                velocity,
                from,
                until,
            } => *velocity == DVec3::ZERO || from == until,
            Self::Rotation {
                angular_velocity,
                from,
                until,
                ..
            } => *angular_velocity == 0.0 || from == until,
            Self::Oscillation {
                amplitude,
                frequency,
                from,
                until,
                ..
            } => *amplitude == DVec3::ZERO || *frequency == 0.0 || from == until,
            Self::Table { table, .. } => table.is_zero(),
            Self::Servo(servo) => servo.max_speed == 0.0 || servo.from == servo.until,
            Self::External => false,
        }
    }

    /// When it begins and ends, s.
    fn window(&self) -> [f64; 2] {
        match self {
            Self::Translation { from, until, .. }
            | Self::Rotation { from, until, .. }
            | Self::Oscillation { from, until, .. } => [*from, *until],
            Self::Table { table, .. } => table.displacement().ends(),
            Self::Servo(servo) => servo.window(),
            Self::External => [0.0, f64::INFINITY],
        }
    }

    fn pose(&self, time: f64, driven: &ServoState) -> Pose {
        match self {
            Self::Translation {
                velocity,
                from,
                until,
            } => shift(*velocity * elapsed(time, *from, *until)),
            Self::Rotation {
                axis,
                origin,
                angular_velocity,
                from,
                until,
            } => {
                let angle = angular_velocity * elapsed(time, *from, *until);
                Pose::about(*origin, about_axis(*axis, angle), DVec3::ZERO)
            }
            Self::Oscillation {
                amplitude,
                frequency,
                phase,
                from,
                until,
            } => {
                let angle = TAU * frequency * elapsed(time, *from, *until) + phase;
                shift(*amplitude * (libm::sin(angle) - libm::sin(*phase)))
            }
            Self::Table { table, origin } => {
                let displacement = table.displacement().at(time);
                let rotation_vector = table.rotation_vector().at(time);
                Pose::about(*origin, by_vector(rotation_vector), displacement)
            }
            Self::Servo(servo) => servo.pose(driven),
            Self::External => Pose::IDENTITY,
        }
    }

    /// Velocity field of the moved body due to this motion alone. At kinks: the one of the time after.
    fn velocity(&self, time: f64, driven: &ServoState) -> RigidVelocity {
        match self {
            Self::Translation {
                velocity,
                from,
                until,
            } => RigidVelocity {
                velocity: *velocity * running(time, *from, *until),
                ..RigidVelocity::REST
            },
            Self::Rotation {
                axis,
                origin,
                angular_velocity,
                from,
                until,
            } => RigidVelocity {
                velocity: DVec3::ZERO,
                angular_velocity: *axis * (angular_velocity * running(time, *from, *until)),
                origin: *origin,
            },
            Self::Oscillation {
                amplitude,
                frequency,
                phase,
                from,
                until,
            } => {
                let angle = TAU * frequency * elapsed(time, *from, *until) + phase;
                let rate = TAU * frequency * libm::cos(angle) * running(time, *from, *until);
                RigidVelocity {
                    velocity: *amplitude * rate,
                    ..RigidVelocity::REST
                }
            }
            Self::Table { table, origin } => {
                let displacement = table.displacement().at(time);
                let (velocity, angular_velocity) = table.velocity(time);
                RigidVelocity {
                    velocity,
                    angular_velocity,
                    origin: *origin + displacement,
                }
            }
            Self::Servo(servo) => servo.velocity(driven),
            Self::External => RigidVelocity::REST,
        }
    }

    /// Upper bound of the speed that this motion alone gives to points of the ball until `end`, and the
    /// ball in which they are then at any time.
    fn sweep(&self, ball: Ball, end: f64) -> (f64, Ball) {
        match self {
            Self::Translation {
                velocity,
                from,
                until,
            } => {
                let duration = elapsed(end, *from, *until);
                if duration == 0.0 {
                    return (0.0, ball);
                }
                (velocity.length(), ball.grown(velocity.length() * duration))
            }
            Self::Rotation {
                axis,
                origin,
                angular_velocity,
                from,
                until,
            } => {
                if elapsed(end, *from, *until) == 0.0 || *angular_velocity == 0.0 {
                    return (0.0, ball);
                }
                let arm = (ball.centre - *origin).reject_from_normalized(*axis);
                let swept = Ball {
                    centre: ball.centre - arm,
                    radius: arm.length() + ball.radius,
                };
                (angular_velocity.abs() * swept.radius, swept)
            }
            Self::Oscillation {
                amplitude,
                frequency,
                phase,
                from,
                until,
            } => {
                let duration = elapsed(end, *from, *until);
                if duration == 0.0 || *frequency == 0.0 {
                    return (0.0, ball);
                }
                let stroke = amplitude.length() * (1.0 + libm::sin(*phase).abs());
                (TAU * frequency * amplitude.length(), ball.grown(stroke))
            }
            Self::Table { table, origin } => {
                let limits = table.limits(end);
                if !limits.turns {
                    return (limits.speed, ball.grown(limits.displacement));
                }
                let turned = Ball {
                    centre: *origin,
                    radius: (ball.centre - *origin).length() + ball.radius,
                };
                let speed = limits.speed + limits.angular_speed * turned.radius;
                (speed, turned.grown(limits.displacement))
            }
            Self::Servo(servo) => {
                let duration = elapsed(end, servo.from, servo.until);
                if duration == 0.0 {
                    return (0.0, ball);
                }
                (servo.max_speed, ball.grown(servo.max_speed * duration))
            }
            // Not known before the run.
            Self::External => (0.0, ball),
        }
    }
}

/// Seconds for which a motion has run.
fn elapsed(time: f64, from: f64, until: f64) -> f64 {
    time.clamp(from, until) - from
}

/// 1 while the motion runs, 0 otherwise.
fn running(time: f64, from: f64, until: f64) -> f64 {
    if time >= from && time < until {
        1.0
    } else {
        0.0
    }
}

fn shift(displacement: DVec3) -> Pose {
    Pose {
        rotation: DQuat::IDENTITY,
        translation: displacement,
    }
}

#[derive(Debug, Clone, Copy)]
struct Ball {
    centre: DVec3,
    radius: f64,
}

impl Ball {
    fn grown(self, by: f64) -> Self {
        Self {
            radius: self.radius + by,
            ..self
        }
    }
}

/// The motion of a wall: components applied in the order of the list, each to the result of those
/// before it. Every origin is given where the scene puts it, and is carried along by the later
/// components only: a drum that turns and then travels keeps turning about its own axis.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Motion {
    components: Vec<Component>,
}

impl Motion {
    /// A motion composed of `components`; none of them means a wall at rest.
    ///
    /// # Errors
    /// If a number is not finite (only `until` may be infinite), an axis is no direction, a frequency
    /// is negative, `until` lies before `from`, or two servos act at the same time.
    pub fn new(components: Vec<Component>) -> Result<Self, WallError> {
        let components: Vec<Component> = components
            .into_iter()
            .map(Component::checked)
            .collect::<Result<_, _>>()?;
        let motion = Self { components };
        let mut windows: Vec<[f64; 2]> = motion.all_servos().map(Servo::window).collect();
        windows.sort_by(|a, b| a[0].total_cmp(&b[0]));
        match windows.windows(2).find(|pair| pair[0][1] > pair[1][0]) {
            Some(pair) => Err(WallError::ServosAtOnce {
                first: pair[0],
                begins: pair[1][0],
            }),
            None => Ok(motion),
        }
    }

    /// Whether another program drives the wall.
    #[must_use]
    pub fn is_external(&self) -> bool {
        self.components.contains(&Component::External)
    }

    /// Whether the wall stays where the scene puts it, for ever.
    #[must_use]
    pub fn is_static(&self) -> bool {
        self.components.iter().all(Component::is_static)
    }

    /// When each of its parts that move begins and ends, s; the end may be infinite.
    pub fn windows(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        let moving = self.components.iter().filter(|part| !part.is_static());
        moving.map(Component::window)
    }

    /// Whether all turns leave the direction of the coordinate axis 0, 1 or 2 as it is.
    #[must_use]
    pub fn keeps_axis(&self, axis: usize) -> bool {
        let direction = DVec3::AXES[axis];
        let is_along = |turn: DVec3| turn.cross(direction) == DVec3::ZERO;
        self.components.iter().all(|component| match component {
            Component::Rotation { axis, .. } => is_along(*axis),
            Component::Table { table, .. } => {
                let mut turns = table.rotation_vector().rows().iter();
                turns.all(|row| is_along(row.1))
            }
            Component::External => false,
            _ => true,
        })
    }

    /// Its components, each with the state of its own servo. Servos beyond the end of `driven` stand where they do at the start.
    fn with_states<'a>(
        &'a self,
        driven: &'a [ServoState],
    ) -> impl Iterator<Item = (&'a Component, ServoState)> {
        let mut states = driven.iter();
        self.components.iter().map(move |component| {
            let own = match component {
                Component::Servo(_) => states.next().copied(),
                _ => None,
            };
            (component, own.unwrap_or_default())
        })
    }

    /// Where the wall is at `time` (s), its servos where they stand at the start: a function of time alone.
    #[must_use]
    pub fn pose(&self, time: f64) -> Pose {
        self.driven_pose(time, &[])
    }

    /// Pose of the wall at `time` (s), its servos, in the order of the list, as in `driven`.
    #[must_use]
    pub fn driven_pose(&self, time: f64, driven: &[ServoState]) -> Pose {
        let components = self.with_states(driven);
        components.fold(Pose::IDENTITY, |pose, (next, own)| {
            pose.then(&next.pose(time, &own))
        })
    }

    /// The time derivative of [`Motion::pose`] at `time` (s); where a motion begins, ends or has a kink,
    /// the derivative of what follows.
    #[must_use]
    pub fn velocity(&self, time: f64) -> RigidVelocity {
        self.driven_velocity(time, &[])
    }

    /// The time derivative of [`Motion::driven_pose`] at `time` (s).
    #[must_use]
    pub fn driven_velocity(&self, time: f64, driven: &[ServoState]) -> RigidVelocity {
        let components = self.with_states(driven);
        components.fold(RigidVelocity::REST, |inner, (next, own)| {
            let pose = next.pose(time, &own);
            let outer = next.velocity(time, &own);
            let origin = pose.to_global(inner.origin);
            RigidVelocity {
                velocity: pose.rotation * inner.velocity + outer.at(origin),
                angular_velocity: pose.rotation * inner.angular_velocity + outer.angular_velocity,
                origin,
            }
        })
    }

    /// Its parts, in the order of the list.
    #[must_use]
    pub fn components(&self) -> &[Component] {
        &self.components
    }

    /// Its servos, in the order of the list; of those one acts at a time.
    pub fn all_servos(&self) -> impl Iterator<Item = &Servo> {
        self.components
            .iter()
            .filter_map(|component| match component {
                Component::Servo(servo) => Some(servo),
                _ => None,
            })
    }

    /// Its servos, in the order of the list, and their axes as the later motions have turned them at `time` (s).
    pub fn servos(&self, time: f64) -> impl Iterator<Item = (&Servo, DVec3)> {
        let components = self.components.iter().enumerate();
        components.filter_map(move |(index, component)| {
            let Component::Servo(servo) = component else {
                return None;
            };
            let later = self.components[index + 1..].iter();
            let axis = later.fold(servo.axis, |axis, next| match next {
                // Servos shift only.
                Component::Servo(_) => axis,
                turning => turning.pose(time, &ServoState::default()).rotation * axis,
            });
            Some((servo, axis))
        })
    }

    /// Finite times at which a part of the motion begins, ends, or has a kink in a servo's table, s.
    pub fn events(&self) -> impl Iterator<Item = f64> + '_ {
        let kinks = self.all_servos().filter(|servo| servo.max_speed > 0.0);
        let kinks = kinks.filter_map(|servo| {
            let [_, time] = servo.target.curve().ends();
            (time < servo.until).then_some(time)
        });
        let times = self.windows().flatten().chain(kinks);
        times.filter(|time| time.is_finite())
    }

    /// Upper bound, over all times before `end` (s), of the speed in m/s of the material points of the
    /// wall that are within `reach` (m) of `about` in the initial frame.
    #[must_use]
    pub fn max_speed(&self, about: DVec3, reach: f64, end: f64) -> f64 {
        let mut ball = Ball {
            centre: about,
            radius: reach,
        };
        let mut speed = 0.0;
        for component in &self.components {
            let (own, swept) = component.sweep(ball, end);
            speed += own;
            ball = swept;
        }
        speed
    }
}

//! Prescribed motions of walls.

use std::path::PathBuf;

use glam::DVec3;

use super::item::Item;
use super::source::{Located, Place};
use super::walls::interval;

/// A motion and when it acts.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Where the entry stands.
    pub place: Place,
    /// What moves.
    pub kind: MotionKind,
    /// Start, s; default 0.
    pub from: Located<f64>,
    /// End, s; none: never.
    pub until: Option<Located<f64>>,
}

/// The kinds of motion.
#[derive(Debug, Clone, PartialEq)]
pub enum MotionKind {
    /// With a constant velocity.
    Translation {
        /// m/s.
        velocity: Located<DVec3>,
    },
    /// About an axis, right-handed.
    Rotation {
        /// Direction of the axis, length 1.
        axis: Located<DVec3>,
        /// A point on the axis, m.
        origin: Located<DVec3>,
        /// rad/s.
        angular_velocity: Located<f64>,
    },
    /// Harmonic: amplitude sin(2 pi frequency t + phase).
    Oscillation {
        /// m.
        amplitude: Located<DVec3>,
        /// Hz.
        frequency: Located<f64>,
        /// degrees; default 0.
        phase_degrees: Located<f64>,
    },
    /// From a table: columns t,x,y,z and optionally angle_x,angle_y,angle_z, linear between rows.
    Table {
        /// Resolved against the folder of the scene.
        file: Located<PathBuf>,
    },
    /// Follows a target force along an axis.
    Servo {
        /// Direction, length 1.
        axis: Located<DVec3>,
        /// Force of the wall on the particles along the axis, N.
        force: Located<f64>,
        /// m/s.
        max_speed: Located<f64>,
    },
}

#[derive(Clone, Copy)]
enum Kind {
    Translation,
    Rotation,
    Oscillation,
    Table,
    Servo,
}

const KINDS: [(&str, Kind); 5] = [
    ("translation", Kind::Translation),
    ("rotation", Kind::Rotation),
    ("oscillation", Kind::Oscillation),
    ("table", Kind::Table),
    ("servo", Kind::Servo),
];

/// Reads the list of motions of a wall.
pub(super) fn read_all(item: &Item<'_>) -> Option<Vec<Motion>> {
    let read: Vec<Option<Motion>> = item.list()?.iter().map(read).collect();
    read.into_iter().collect()
}

fn read(item: &Item<'_>) -> Option<Motion> {
    let fields = item.table()?;
    let (from, until) = interval(&fields);
    let kind = fields.need("kind")?.word("motion", &KINDS)?;
    let direction = |key| fields.need(key).and_then(|item| item.direction());
    let vector = |key| fields.need(key).and_then(|item| item.vector());
    let number = |key| fields.need(key).and_then(|item| item.number());
    let kind =
        match kind {
            Kind::Translation => {
                vector("velocity").map(|velocity| MotionKind::Translation { velocity })
            }
            Kind::Rotation => {
                let (axis, origin, speed) = (
                    direction("axis"),
                    vector("origin"),
                    number("angular_velocity"),
                );
                axis.zip(origin)
                    .zip(speed)
                    .map(|((axis, origin), angular_velocity)| MotionKind::Rotation {
                        axis,
                        origin,
                        angular_velocity,
                    })
            }
            Kind::Oscillation => {
                let amplitude = vector("amplitude");
                let frequency = fields
                    .need("frequency")
                    .and_then(|item| item.non_negative());
                let phase = match fields.get("phase_degrees") {
                    Some(item) => item.number(),
                    None => Some(fields.default("phase_degrees", 0.0)),
                };
                amplitude.zip(frequency).zip(phase).map(
                    |((amplitude, frequency), phase_degrees)| MotionKind::Oscillation {
                        amplitude,
                        frequency,
                        phase_degrees,
                    },
                )
            }
            Kind::Table => fields
                .need("file")
                .and_then(|item| item.file())
                .map(|file| MotionKind::Table { file }),
            Kind::Servo => {
                let (axis, force) = (direction("axis"), number("force"));
                let speed = fields.need("max_speed").and_then(|item| item.positive());
                axis.zip(force)
                    .zip(speed)
                    .map(|((axis, force), max_speed)| MotionKind::Servo {
                        axis,
                        force,
                        max_speed,
                    })
            }
        };
    fields.finish();
    Some(Motion {
        place: item.place.clone(),
        kind: kind?,
        from: from?,
        until,
    })
}

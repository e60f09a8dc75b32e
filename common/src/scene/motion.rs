//! Prescribed motions of walls.

use std::path::PathBuf;

use glam::DVec3;

use super::cursor::Fields;
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
        /// What it aims at.
        target: ServoTarget,
        /// m/s.
        max_speed: Located<f64>,
    },
}

/// What a servo aims at.
#[derive(Debug, Clone, PartialEq)]
pub enum ServoTarget {
    /// Force of the wall on the particles along the axis, N.
    Force(Load),
    /// The same over an area, Pa; positive where the wall presses along the axis.
    Pressure {
        /// Pa.
        load: Load,
        /// m^2; none: that of the wall.
        area: Option<Located<f64>>,
    },
}

/// A load, perhaps one that changes in time.
#[derive(Debug, Clone, PartialEq)]
pub enum Load {
    /// Always the same.
    Constant(Located<f64>),
    /// Rows of time (s) and load, linear between them.
    Rows(Located<Vec<[f64; 2]>>),
    /// A table of the same, resolved against the folder of the scene.
    Table(Located<PathBuf>),
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
                let (axis, target) = (direction("axis"), read_target(&fields));
                let speed = fields.need("max_speed").and_then(|item| item.positive());
                axis.zip(target)
                    .zip(speed)
                    .map(|((axis, target), max_speed)| MotionKind::Servo {
                        axis,
                        target,
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

fn read_target(fields: &Fields<'_>) -> Option<ServoTarget> {
    if fields.has("pressure") {
        fields.excluded("force", "pressure");
        let area = fields.get("area").map(|item| item.positive());
        let load = fields.get("pressure").and_then(|item| read_load(&item));
        // Known, so that it is reported only once.
        let is_one = fields.get("force").is_none();
        return match area {
            Some(None) => None,
            area => load.filter(|_| is_one).map(|load| ServoTarget::Pressure {
                load,
                area: area.flatten(),
            }),
        };
    }
    fields.excluded("area", "force");
    fields.get("area");
    let force = fields.need("force")?;
    read_load(&force).map(ServoTarget::Force)
}

pub(super) fn read_load(item: &Item<'_>) -> Option<Load> {
    if item.is_table() {
        let fields = item.table()?;
        let file = fields.need("table").and_then(|item| item.file());
        fields.finish();
        return file.map(Load::Table);
    }
    if !item.is_list() {
        return item.number().map(Load::Constant);
    }
    let rows: Option<Vec<[f64; 2]>> = (item.list()?.iter())
        .map(|row| row.numbers::<2>().map(|row| row.value))
        .collect();
    let rows = rows?;
    if rows.is_empty() {
        item.report("needs at least one row [t, load]");
        return None;
    }
    if let Some(pair) = rows.windows(2).find(|pair| pair[1][0] <= pair[0][0]) {
        let [before, after] = [pair[0][0], pair[1][0]];
        item.report(format!(
            "the times of its rows must increase, got {before} and then {after}"
        ));
        return None;
    }
    Some(Load::Rows(item.located(rows)))
}

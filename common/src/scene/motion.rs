//! Prescribed motions of walls.

use std::path::PathBuf;

use glam::DVec3;

use super::cursor::Fields;
use super::from_item::{FromItem, FromKey};
use super::item::Item;
use super::keys::{
    Kind, TableKeys, Variants, key, non_negative, number, positive, variant, vector,
};
use super::shapes::AXIS;
use super::source::{Located, SourceSpan};
use super::walls::{INTERVAL, interval};

/// A motion and when it acts.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Where the entry stands.
    pub place: SourceSpan,
    /// Kind of motion.
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
        /// Target of the servo.
        target: ServoTarget,
        /// m/s.
        max_speed: Located<f64>,
    },
    /// As another program drives the wall.
    External,
}

impl Motion {
    /// That of `motion = "external"`.
    pub(super) fn external(item: &Item<'_>) -> Self {
        Self {
            place: item.place.clone(),
            kind: MotionKind::External,
            from: item.located(0.0),
            until: None,
        }
    }
}

/// Target of a servo.
#[derive(Debug, Clone, PartialEq)]
pub enum ServoTarget {
    /// Force of the wall on the particles along the axis, N.
    Force(Load),
    /// Force of the wall over an area, Pa; positive where the wall presses along the axis.
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

#[rustfmt::skip]
static LOAD: TableKeys = TableKeys::new(&[&[
    key("table", Kind::File(""), "\"load.csv\"   # t and the load", "a file with columns t and the load"),
]]);

/// A motion.
#[rustfmt::skip]
pub(super) static MOTION: TableKeys = TableKeys::new(&[INTERVAL]).with_variants(Variants::Word {
    key: "kind",
    what: "motion",
    example: "\"rotation\"   # or translation, oscillation, table, servo",
    text: "which further keys there are",
    absent: None,
    of: &[
        variant("translation", &[&[
            key("velocity", vector("m/s"), "[0, 0, -0.01]", "constant"),
        ]], "with a constant velocity"),
        variant("rotation", &[&[
            AXIS,
            key("origin", vector("m"), "[0, 0, 0]", "a point on the axis"),
            key("angular_velocity", number("rad/s"), "3.0", "right-handed about the axis"),
        ]], "about an axis"),
        variant("oscillation", &[&[
            key("amplitude", vector("m"), "[0, 0, 1e-3]", "A"),
            key("frequency", non_negative("Hz"), "50.0", "f"),
            key("phase_degrees", number("degrees"), "90.0", "φ").or(0.0),
        ]], "harmonic"),
        variant("table", &[&[
            key("file", Kind::File(""), "\"motion.csv\"", "columns `t,x,y,z[,angle_x,angle_y,angle_z]`: displacement and rotation vector, linear between rows"),
        ]], "from a table"),
        variant("servo", &[&[
            AXIS,
            key("force", Kind::OneOf(&[number("N"), Kind::List("", &Kind::Row(&["s", "N"])), Kind::Table(&LOAD)]), "-10.0   # N of the wall on the particles, along the axis; or pressure in Pa", "of the wall on the particles along the axis; a number, rows `[[t, F], ...]`, linear between them, or `{ table }`").needed("without `pressure`"),
            key("pressure", Kind::OneOf(&[number("Pa"), Kind::List("", &Kind::Row(&["s", "Pa"])), Kind::Table(&LOAD)]), "-1e4", "in place of `force`: force over `area`, positive where the wall presses along the axis").or_open("none"),
            key("area", positive("m2"), "1e-2", "of `pressure`").or_open("that of the wall, for planes, boxes and discs"),
            key("max_speed", positive("m/s"), "0.1", "the wall is never faster"),
        ]], "follows a force or pressure along an axis"),
    ],
});

impl FromItem for Motion {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        let fields = item.fields(kind)?;
        let (from, until) = interval(&fields);
        let kind = match fields.variant()? {
            "translation" => MotionKind::Translation {
                velocity: fields.read("velocity"),
            },
            "rotation" => MotionKind::Rotation {
                axis: fields.read("axis"),
                origin: fields.read("origin"),
                angular_velocity: fields.read("angular_velocity"),
            },
            "oscillation" => MotionKind::Oscillation {
                amplitude: fields.read("amplitude"),
                frequency: fields.read("frequency"),
                phase_degrees: fields.read("phase_degrees"),
            },
            "table" => MotionKind::Table {
                file: fields.read("file"),
            },
            "servo" => MotionKind::Servo {
                axis: fields.read("axis"),
                target: read_target(&fields),
                max_speed: fields.read("max_speed"),
            },
            _ => return None,
        };
        Some(Motion {
            place: item.place.clone(),
            kind,
            from,
            until,
        })
    }
}

fn read_target(fields: &Fields<'_>) -> ServoTarget {
    if fields.has("pressure") {
        fields.excluded("force", "pressure");
        return ServoTarget::Pressure {
            load: fields.require("pressure"),
            area: fields.read("area"),
        };
    }
    fields.excluded("area", "force");
    ServoTarget::Force(fields.require("force"))
}

impl FromItem for Load {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        if item.is_table() {
            return Some(Load::Table(item.fields(kind)?.read("table")));
        }
        if !item.is_list() {
            return Located::from_item(item, kind).map(Load::Constant);
        }
        let rows: Vec<[f64; 2]> = FromItem::from_item(item, kind)?;
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
}

impl FromKey for Load {
    fn placeholder(place: &SourceSpan) -> Self {
        Load::Constant(FromKey::placeholder(place))
    }
}

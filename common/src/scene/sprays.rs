//! `[[sprays]]`: nozzles whose droplets wet the particles.

use std::path::PathBuf;

use glam::DVec3;

use super::cursor::Fields;
use super::from_item::FromItem;
use super::item::Item;
use super::keys::{
    Absent, Kind, TableKeys, Variants, Word, key, non_negative, positive, variant, vector, word,
};
use super::laws::Range;
use super::psd::{PSD, Psd};
use super::source::{Located, SourceSpan};
use super::walls::{INTERVAL, interval};

/// A nozzle, or a list of droplets.
#[derive(Debug, Clone, PartialEq)]
pub struct Spray {
    /// Unique among sprays; random choices follow from it and the seed.
    pub name: Located<String>,
    /// Where the entry stands.
    pub place: SourceSpan,
    /// Where droplets come from.
    pub source: SpraySource,
    /// kg/m3
    pub liquid_density: Located<f64>,
    /// Whether gravity acts on droplets; default true.
    pub gravity: bool,
    /// Drag of the air; default none.
    pub drag: Option<SprayDrag>,
    /// Effect of walls on droplets; default [`AtWalls::Lost`].
    pub at_walls: AtWalls,
    /// Restitution of bounces; needed where droplets bounce.
    pub restitution: Option<Located<f64>>,
    /// Whether a particle gets the momentum of the droplets that it catches; default false.
    pub momentum: bool,
    /// Whether liquid has mass; default false.
    pub mass: Located<bool>,
    /// Most droplets in flight; default 1,000,000.
    pub max_droplets: Located<u64>,
    /// Start, s; default 0.
    pub from: Located<f64>,
    /// End, s; none: never.
    pub until: Option<Located<f64>>,
}

/// Where droplets come from.
#[derive(Debug, Clone, PartialEq)]
pub enum SpraySource {
    /// A nozzle.
    Nozzle(Box<Nozzle>),
    /// A table of droplets: `t,x,y,z,vx,vy,vz,diameter`; resolved against the folder of the scene.
    Points(Located<PathBuf>),
}

/// A nozzle.
#[derive(Debug, Clone, PartialEq)]
pub struct Nozzle {
    /// The orifice, m.
    pub position: Located<DVec3>,
    /// Mean direction of the droplets, length 1.
    pub axis: Located<DVec3>,
    /// How directions spread about the axis.
    pub pattern: SprayPattern,
    /// Radius of the disc across the axis where droplets start, m; default 0.
    pub orifice: Located<f64>,
    /// Volume per time.
    pub flow_rate: SprayFlow,
    /// Mean speed of the droplets, m/s.
    pub speed: Located<f64>,
    /// Uniform deviation of the speed, +-, m/s; default 0.
    pub speed_spread: f64,
    /// Sizes of the droplets.
    pub droplets: Located<Psd>,
    /// The wall with which the nozzle moves.
    pub carrier: Option<Located<String>>,
}

/// Volume per time.
#[derive(Debug, Clone, PartialEq)]
pub enum SprayFlow {
    /// m3/s
    Constant(Located<f64>),
    /// A table `t,rate` (s, m3/s), linear between its rows; resolved against the folder of the scene.
    Table(Located<PathBuf>),
}

/// How directions spread.
#[derive(Debug, Clone, PartialEq)]
pub enum SprayPattern {
    /// A fan, even in both angles.
    FlatFan {
        /// Direction in which the fan is wide, length 1, not along the axis.
        wide_axis: Located<DVec3>,
        /// Half angles in the wide and the narrow direction, degrees, in [0, 90).
        half_angles_degrees: Located<[f64; 2]>,
    },
    /// A cone, even in the solid angle between two half angles, degrees; the inner one of a full cone is 0.
    Cone {
        /// Inner and outer half angle, degrees, 0 <= inner < outer < 90.
        half_angles_degrees: Located<[f64; 2]>,
    },
}

/// Drag by Schiller & Naumann (1933).
#[derive(Debug, Clone, PartialEq)]
pub struct SprayDrag {
    /// kg/m3
    pub gas_density: f64,
    /// Pa s
    pub gas_viscosity: f64,
    /// m/s
    pub gas_velocity: DVec3,
}

/// Effect of walls on droplets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum AtWalls {
    /// Droplets are lost.
    #[default]
    Lost,
    /// A wall with `film` keeps them; elsewhere they are lost.
    Film,
    /// Droplets bounce.
    Bounce,
}

impl Word for AtWalls {
    const WHAT: &'static str = "rule for droplets at walls";
    const WORDS: &'static [(&'static str, Self)] = &[
        ("lost", Self::Lost),
        ("film", Self::Film),
        ("bounce", Self::Bounce),
    ];
}

/// `[[sprays]]`
#[rustfmt::skip]
pub(super) static SPRAY: TableKeys = TableKeys::new(&[&[
    key("name", Kind::Name, "\"nozzle\"", "unique; random choices follow from it and the seed"),
    key("position", vector("m"), "[0.05, 0.05, 0.2]", "middle of the orifice").needed("but for `points`"),
    key("axis", Kind::Direction, "[0, 0, -1]   # mean direction", "mean direction").needed("but for `points`"),
    key("pattern", Kind::Table(&PATTERN), "{ kind = \"full-cone\", half_angle_degrees = 20.0 }", "how directions spread about the axis, or a list of droplets"),
    key("orifice", non_negative("m"), "1e-3", "radius of the disc across the axis where droplets start, evenly by area").or(0.0),
    key("flow_rate", Kind::OneOf(&[non_negative("m3/s"), Kind::Table(&FLOW)]), "1e-6", "volume per time: a number, or `{ table }`").needed("but for `points`"),
    key("speed", Kind::OneOf(&[non_negative("m/s"), Kind::Table(&SPEED)]), "{ mean = 2.0, spread = 0.2 }   # m/s", "of the droplets: a number, or `{ mean, spread }`: uniform between mean - spread and mean + spread").needed("but for `points`"),
    key("droplets", Kind::Table(&PSD), "{ kind = \"monodisperse\", diameter = 1e-3 }   # m", "a [size distribution](#size-distributions)").needed("but for `points`"),
    key("liquid_density", positive("kg/m3"), "1000.0", "of the liquid"),
    key("carrier", Kind::Name, "\"plate\"", "name of a wall: `position`, `axis` and `wide_axis` move with it, and its velocity is added").or_open("none"),
    key("gravity", Kind::Flag, "false", "whether gravity acts on droplets").or_flag(true),
    key("drag", Kind::Table(&DRAG), "{ law = \"schiller-naumann\", gas_density = 1.2, gas_viscosity = 1.8e-5 }", "drag of the air").or_open("none"),
    key("at_walls", word::<AtWalls>(), "\"film\"", "`\"film\"`: walls with a `film` keep it, at others it is lost; `\"bounce\"`: with `restitution`").or_word("lost"),
    key("restitution", Kind::Number("", Range::Fraction), "0.5   # the part of its normal speed that a droplet keeps", "of the normal speed").needed("with `\"bounce\"`"),
    key("momentum", Kind::Flag, "true", "a particle that catches a droplet gets its momentum").or_flag(false),
    key("mass", Kind::Flag, "true", "liquid has mass, and `momentum` too: particles weigh what they hold, and liquid that moves takes its momentum along; all sprays alike ([how](../theory/sprays.md#liquid-with-mass))").or_flag(false),
    key("max_droplets", Kind::Whole(1, u64::MAX), "1000000", "in flight; one more ends the run").or(1e6),
], INTERVAL]);

#[rustfmt::skip]
static PATTERN: TableKeys = TableKeys::new(&[]).with_variants(Variants::Word {
    key: "kind",
    what: "spray pattern",
    example: "\"full-cone\"   # or flat-fan, hollow-cone, points",
    text: "which further keys there are",
    absent: None,
    of: &[
        variant("flat-fan", &[&[
            key("wide_axis", Kind::Direction, "[1, 0, 0]", "direction in which the fan is wide"),
            key("half_angles_degrees", Kind::Numbers("degrees", 2, Range::Below(0.0, 90.0)), "[25.0, 2.0]", "`[wide, narrow]`"),
        ]], "even in both angles"),
        variant("full-cone", &[&[
            key("half_angle_degrees", Kind::Number("degrees", Range::Inside(0.0, 90.0)), "20.0", "half of the angle of the cone"),
        ]], "even in the solid angle"),
        variant("hollow-cone", &[&[
            key("half_angles_degrees", Kind::Numbers("degrees", 2, Range::Below(0.0, 90.0)), "[10.0, 20.0]", "`[inner, outer]`"),
        ]], "even in the solid angle between two cones"),
        variant("points", &[&[
            key("file", Kind::File("a table t,x,y,z,vx,vy,vz,diameter: a row for each droplet"), "\"droplets.csv\"", "a table `t,x,y,z,vx,vy,vz,diameter` with a row for each droplet"),
        ]], "a list of droplets, in place of `position`, `axis`, `flow_rate`, `speed`, `droplets`, `orifice` and `carrier`"),
    ],
});

#[rustfmt::skip]
static FLOW: TableKeys = TableKeys::new(&[&[
    key("table", Kind::File(""), "\"flow.csv\"   # t,rate", "columns `t,rate`, linear between its rows, none outside of them"),
]]);

#[rustfmt::skip]
static SPEED: TableKeys = TableKeys::new(&[&[
    key("mean", non_negative("m/s"), "2.0", "mean speed"),
    key("spread", non_negative("m/s"), "0.2", "at most the mean"),
]]);

#[rustfmt::skip]
static DRAG: TableKeys = TableKeys::new(&[]).with_variants(Variants::Word {
    key: "law",
    what: "law of drag",
    example: "\"schiller-naumann\"",
    text: "the law",
    absent: None,
    of: &[variant("schiller-naumann", &[&[
        key("gas_density", positive("kg/m3"), "1.2", "of the air"),
        key("gas_viscosity", positive("Pa s"), "1.8e-5", "dynamic, of the air"),
        key("gas_velocity", vector("m/s"), "[0, 0, 1.0]", "of the air").absent(Absent::Zero),
    ]], "Schiller & Naumann (1933)")],
});

/// Reads an entry of `[[sprays]]`.
pub(super) fn read(item: &Item<'_>) -> Option<Spray> {
    let fields = item.open(&SPRAY)?;
    let source = read_source(&fields);
    let at_walls = fields.read("at_walls");
    let restitution = match at_walls {
        AtWalls::Bounce => fields.require("restitution"),
        _ => fields.read("restitution"),
    };
    let (from, until) = interval(&fields);
    Some(Spray {
        name: fields.read("name"),
        place: item.place.clone(),
        liquid_density: fields.read("liquid_density"),
        gravity: fields.read("gravity"),
        drag: fields.read("drag"),
        at_walls,
        restitution,
        momentum: fields.read("momentum"),
        mass: fields.read("mass"),
        max_droplets: fields.read("max_droplets"),
        from,
        until,
        // At last, so that all else has been read.
        source: source?,
    })
}

/// Keys that a list of droplets takes the place of.
const OF_NOZZLES: [&str; 7] = [
    "position",
    "axis",
    "flow_rate",
    "speed",
    "droplets",
    "orifice",
    "carrier",
];

fn read_source(fields: &Fields<'_>) -> Option<SpraySource> {
    let pattern: Option<Read> = fields.read("pattern");
    if let Some(Read::Points(file)) = pattern {
        for key in OF_NOZZLES {
            fields.excluded(key, "pattern.file");
        }
        return Some(SpraySource::Points(file));
    }
    let axis: Located<DVec3> = fields.require("axis");
    if let Some(Read::Pattern(SprayPattern::FlatFan { wide_axis, .. })) = &pattern
        // Parallel to round-off: the fan would have no plane.
        && axis.cross(**wide_axis).length() < 1e-9
    {
        let error = wide_axis.error("must not be parallel to the axis of the spray");
        fields.context.report(error);
    }
    let speed: Option<Speed> = fields.require("speed");
    let flow_rate: Option<SprayFlow> = fields.require("flow_rate");
    let droplets: Option<Located<Psd>> = fields.require("droplets");
    let position = fields.require("position");
    let (orifice, carrier) = (fields.read("orifice"), fields.read("carrier"));
    let Speed { speed, spread } = speed?;
    Some(SpraySource::Nozzle(Box::new(Nozzle {
        position,
        axis,
        orifice,
        carrier,
        flow_rate: flow_rate?,
        speed,
        speed_spread: spread,
        droplets: droplets?,
        pattern: match pattern? {
            Read::Pattern(pattern) => pattern,
            Read::Points(_) => return None,
        },
    })))
}

struct Speed {
    speed: Located<f64>,
    spread: f64,
}

impl FromItem for Speed {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        if !item.is_table() {
            let speed = Located::from_item(item, kind)?;
            return Some(Self { speed, spread: 0.0 });
        }
        let fields = item.fields(kind)?;
        let (speed, spread): (Located<f64>, f64) = (fields.read("mean"), fields.read("spread"));
        if spread > *speed {
            item.report(format!(
                "the spread of {spread} m/s is above the mean of {} m/s: droplets would fly backwards",
                *speed
            ));
            return None;
        }
        Some(Self { speed, spread })
    }
}

impl FromItem for SprayFlow {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        match item.is_table() {
            true => Some(Self::Table(item.fields(kind)?.read("table"))),
            false => Located::from_item(item, kind).map(Self::Constant),
        }
    }
}

enum Read {
    Pattern(SprayPattern),
    Points(Located<PathBuf>),
}

impl FromItem for Read {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        let fields = item.fields(kind)?;
        Some(match fields.variant()? {
            "flat-fan" => Self::Pattern(SprayPattern::FlatFan {
                wide_axis: fields.read("wide_axis"),
                half_angles_degrees: fields.read("half_angles_degrees"),
            }),
            "full-cone" => {
                let outer: Located<f64> = fields.read("half_angle_degrees");
                let half_angles_degrees = outer.map(|outer| [0.0, outer]);
                Self::Pattern(SprayPattern::Cone {
                    half_angles_degrees,
                })
            }
            "hollow-cone" => {
                let half_angles_degrees: Located<[f64; 2]> = fields.read("half_angles_degrees");
                if half_angles_degrees[0] >= half_angles_degrees[1] {
                    fields.context.report(half_angles_degrees.error(format!(
                        "must be the inner and the outer half angle, 0 <= inner < outer < 90, got {}",
                        half_angles_degrees.place.text()
                    )));
                }
                Self::Pattern(SprayPattern::Cone {
                    half_angles_degrees,
                })
            }
            _ => Self::Points(fields.read("file")),
        })
    }
}

impl FromItem for SprayDrag {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        let fields = item.fields(kind)?;
        fields.variant()?;
        Some(SprayDrag {
            gas_density: fields.read("gas_density"),
            gas_viscosity: fields.read("gas_viscosity"),
            gas_velocity: fields.read("gas_velocity"),
        })
    }
}

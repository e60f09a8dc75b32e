//! `[[sprays]]`: nozzles whose droplets wet the particles.

use std::path::PathBuf;

use glam::DVec3;

use super::cursor::Fields;
use super::item::Item;
use super::psd::{self, Psd};
use super::settings::flag;
use super::source::{Located, Place};
use super::walls::interval;

/// A nozzle, or a list of droplets.
#[derive(Debug, Clone, PartialEq)]
pub struct Spray {
    /// Unique among sprays; random choices follow from it and the seed.
    pub name: Located<String>,
    /// Where the entry stands.
    pub place: Place,
    /// Where droplets come from.
    pub source: SpraySource,
    /// kg/m3
    pub liquid_density: Located<f64>,
    /// Whether gravity acts on droplets; default true.
    pub gravity: bool,
    /// Drag of the air; default none.
    pub drag: Option<SprayDrag>,
    /// What walls do with droplets; default [`AtWalls::Lost`].
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

/// What walls do with droplets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum AtWalls {
    /// They are lost.
    #[default]
    Lost,
    /// A wall with `film` keeps them; elsewhere they are lost.
    Film,
    /// They bounce.
    Bounce,
}

/// Reads an entry of `[[sprays]]`.
pub(super) fn read(item: &Item<'_>) -> Option<Spray> {
    let fields = item.table()?;
    let name = fields.need("name").and_then(|item| item.name());
    let source = read_source(&fields);
    let liquid_density = fields
        .need("liquid_density")
        .and_then(|item| item.positive());
    let gravity = flag(&fields, "gravity", true);
    let drag = fields.get("drag").map(|item| read_drag(&item));
    let at_walls = fields.get("at_walls").map(|item| {
        item.word(
            "rule for droplets at walls",
            &[
                ("lost", AtWalls::Lost),
                ("film", AtWalls::Film),
                ("bounce", AtWalls::Bounce),
            ],
        )
    });
    let at_walls = at_walls.unwrap_or(Some(AtWalls::Lost));
    let restitution = match at_walls {
        Some(AtWalls::Bounce) => {
            let help = "restitution = 0.5: the part of its normal speed that a droplet keeps";
            let item = fields.need_or_help("restitution", Some(help));
            Some(item.and_then(|item| item.fraction()))
        }
        _ => fields.get("restitution").map(|item| item.fraction()),
    };
    let momentum = flag(&fields, "momentum", false);
    let mass = match fields.get("mass") {
        Some(item) => item.boolean().map(|value| item.located(value)),
        None => Some(fields.default("mass", false)),
    };
    let max_droplets = match fields.get("max_droplets") {
        Some(item) => item.whole(1),
        None => Some(fields.default("max_droplets", 1_000_000)),
    };
    let (from, until) = interval(&fields);
    fields.finish();
    Some(Spray {
        name: name?,
        place: item.place.clone(),
        source: source?,
        liquid_density: liquid_density?,
        gravity,
        drag: drag.map_or(Some(None), |drag| drag.map(Some))?,
        at_walls: at_walls?,
        restitution: restitution.map_or(Some(None), |value| value.map(Some))?,
        momentum,
        mass: mass?,
        max_droplets: max_droplets?,
        from: from?,
        until,
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
    let given = fields.get("axis");
    let axis = given.as_ref().and_then(|item| item.direction());
    let read = fields
        .need("pattern")
        .and_then(|item| read_pattern(&item, axis.as_ref()));
    let pattern = match read {
        Some(Read::Points(file)) => {
            for key in OF_NOZZLES {
                if fields.get(key).is_some() {
                    fields.excluded(key, "pattern.file");
                }
            }
            return Some(SpraySource::Points(file));
        }
        Some(Read::Pattern(pattern)) => Some(pattern),
        None => None,
    };
    let position = fields.need("position").and_then(|item| item.vector());
    if given.is_none() {
        // Reports that it is missing.
        fields.need("axis");
    }
    let orifice = match fields.get("orifice") {
        Some(item) => item.non_negative(),
        None => Some(fields.default("orifice", 0.0)),
    };
    let flow_rate = fields.need("flow_rate").and_then(|item| {
        if !item.is_table() {
            return item.non_negative().map(SprayFlow::Constant);
        }
        let table = item.table()?;
        let file = table.need("table").and_then(|item| item.file());
        table.finish();
        file.map(SprayFlow::Table)
    });
    let speed = fields.need("speed").and_then(|item| {
        if !item.is_table() {
            return item.non_negative().map(|speed| (speed, 0.0));
        }
        let table = item.table()?;
        let mean = table.need("mean").and_then(|item| item.non_negative());
        let spread = table.need("spread").and_then(|item| item.non_negative());
        table.finish();
        let (mean, spread) = (mean?, spread?);
        if *spread > *mean {
            item.report(format!(
                "the spread of {} m/s is above the mean of {} m/s: droplets would fly backwards",
                *spread, *mean
            ));
            return None;
        }
        Some((mean, *spread))
    });
    let droplets = fields.need("droplets").and_then(|item| psd::read(&item));
    let carrier = fields.get("carrier").map(|item| item.name());
    let (speed, speed_spread) = speed?;
    Some(SpraySource::Nozzle(Box::new(Nozzle {
        position: position?,
        axis: axis?,
        pattern: pattern?,
        orifice: orifice?,
        flow_rate: flow_rate?,
        speed,
        speed_spread,
        droplets: droplets?,
        carrier: carrier.map_or(Some(None), |name| name.map(Some))?,
    })))
}

enum Read {
    Pattern(SprayPattern),
    Points(Located<PathBuf>),
}

#[derive(Clone, Copy)]
enum Kind {
    FlatFan,
    FullCone,
    HollowCone,
    Points,
}

fn read_pattern(item: &Item<'_>, axis: Option<&Located<DVec3>>) -> Option<Read> {
    let fields = item.table()?;
    let kind = fields.need("kind")?.word(
        "spray pattern",
        &[
            ("flat-fan", Kind::FlatFan),
            ("full-cone", Kind::FullCone),
            ("hollow-cone", Kind::HollowCone),
            ("points", Kind::Points),
        ],
    )?;
    let read = match kind {
        Kind::FlatFan => read_fan(&fields, axis).map(Read::Pattern),
        Kind::FullCone => fields.need("half_angle_degrees").and_then(|item| {
            let angle = item.number()?;
            if !(*angle > 0.0 && *angle < 90.0) {
                item.report(format!("must lie between 0 and 90, got {}", *angle));
                return None;
            }
            let half_angles_degrees = Located {
                value: [0.0, *angle],
                place: angle.place,
            };
            Some(Read::Pattern(SprayPattern::Cone {
                half_angles_degrees,
            }))
        }),
        Kind::HollowCone => fields.need("half_angles_degrees").and_then(|item| {
            let angles = item.numbers::<2>()?;
            let [inner, outer] = *angles;
            if !(0.0 <= inner && inner < outer && outer < 90.0) {
                item.report(format!(
                    "must be the inner and the outer half angle, 0 <= inner < outer < 90, got {}",
                    item.place.text()
                ));
                return None;
            }
            Some(Read::Pattern(SprayPattern::Cone {
                half_angles_degrees: angles,
            }))
        }),
        Kind::Points => {
            let help = "a table t,x,y,z,vx,vy,vz,diameter: a row for each droplet";
            let item = fields.need("file").and_then(|item| item.file_or(help));
            item.map(Read::Points)
        }
    };
    fields.finish();
    read
}

fn read_fan(fields: &Fields<'_>, axis: Option<&Located<DVec3>>) -> Option<SprayPattern> {
    let wide_axis = fields.need("wide_axis").and_then(|item| {
        let wide = item.direction()?;
        // Parallel to round-off: the fan would have no plane.
        if axis.is_some_and(|axis| axis.cross(*wide).length() < 1e-9) {
            item.report("must not be parallel to the axis of the spray");
            return None;
        }
        Some(wide)
    });
    let half_angles = fields.need("half_angles_degrees").and_then(|item| {
        let angles = item.numbers::<2>()?;
        if angles.iter().any(|angle| !(0.0..90.0).contains(angle)) {
            item.report(format!("must lie in [0, 90), got {}", item.place.text()));
            return None;
        }
        Some(angles)
    });
    Some(SprayPattern::FlatFan {
        wide_axis: wide_axis?,
        half_angles_degrees: half_angles?,
    })
}

fn read_drag(item: &Item<'_>) -> Option<SprayDrag> {
    let fields = item.table()?;
    fields
        .need("law")?
        .word("law of drag", &[("schiller-naumann", ())])?;
    let density = fields.need("gas_density").and_then(|item| item.positive());
    let viscosity = fields
        .need("gas_viscosity")
        .and_then(|item| item.positive());
    let velocity = match fields.get("gas_velocity") {
        Some(item) => item.vector(),
        None => Some(fields.default("gas_velocity", DVec3::ZERO)),
    };
    fields.finish();
    Some(SprayDrag {
        gas_density: *density?,
        gas_viscosity: *viscosity?,
        gas_velocity: *velocity?,
    })
}

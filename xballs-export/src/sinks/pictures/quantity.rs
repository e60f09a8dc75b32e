//! Quantity that the colours of the particles show.

use mercury_common::frames::Column;
use mercury_common::paraview::{Group, groups};
use mercury_common::particle_properties::{FILM_VOLUME, LIQUID_VOLUME};
use mercury_pictures::{ColourBy, upwards};

use crate::{ExportError, Snapshot};

/// The kind of clump of a pebble, or of a body.
pub(super) const CLUMP: &str = "clump";

/// Something that each particle has one of.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Quantity {
    /// Nothing.
    None,
    /// Place against gravity, or along z.
    Height,
    /// Twice the radius.
    Diameter,
    /// Index of the material.
    Material,
    /// The body that a sphere is a part of.
    Body,
    /// The kind of clump that a sphere is a part of.
    Clump {
        /// Names of the kinds.
        names: Vec<String>,
    },
    /// Depth of worn walls; particles have none.
    Depth,
    /// Something of the triangles of elastic sheets; particles have none.
    Sheet(SheetQuantity),
    /// A column of numbers.
    Column { name: String, unit: String },
    /// The length of a vector of three columns.
    Length {
        name: String,
        columns: [String; 3],
        unit: String,
    },
}

/// Tables of a run beside its particles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct OfRun {
    /// Walls that wear.
    pub(super) wears: bool,
    /// Elastic sheets.
    pub(super) has_sheets: bool,
}

/// Quantity that the colours of the triangles of elastic sheets show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SheetQuantity {
    /// The larger principal tension.
    LargerTension,
    /// The smaller principal tension.
    SmallerTension,
    /// Root of the area over that of the first frame.
    Stretch,
    /// Force of the grains along the normal over the area.
    Pressure,
}

impl SheetQuantity {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "tension_1" => Self::LargerTension,
            "tension_2" => Self::SmallerTension,
            "stretch" => Self::Stretch,
            "pressure" => Self::Pressure,
            _ => return None,
        })
    }

    fn colour(self) -> ColourBy {
        match self {
            Self::LargerTension => ColourBy::scalar("larger tension", "N/m"),
            Self::SmallerTension => ColourBy::scalar("smaller tension", "N/m"),
            Self::Stretch => ColourBy::scalar("stretch", ""),
            Self::Pressure => ColourBy::scalar("pressure", "Pa"),
        }
    }
}

impl Quantity {
    /// Possible meanings of `wanted`: one quantity, or for `auto` one if something moves and one if nothing does. `clumps`: names
    /// of the kinds of clumps that the run has; `of_run`: what else it has.
    pub(super) fn candidates(
        wanted: &str,
        snapshot: &Snapshot,
        clumps: &[String],
        of_run: OfRun,
    ) -> Result<Vec<Self>, ExportError> {
        let speed = || Self::vector("velocity", "speed", snapshot);
        Ok(match wanted {
            "auto" => match speed() {
                Some(speed) => vec![speed, Self::Height],
                None => vec![Self::Height],
            },
            "none" => vec![Self::None],
            "height" => vec![Self::Height],
            "diameter" if has(snapshot, "radius") => vec![Self::Diameter],
            "material" if has(snapshot, "material") => vec![Self::Material],
            "body" if has(snapshot, "body") => vec![Self::Body],
            CLUMP if has(snapshot, CLUMP) => vec![Self::Clump {
                names: clumps.to_vec(),
            }],
            "film" if has(snapshot, FILM_VOLUME.name) => {
                (Self::column(FILM_VOLUME.name, snapshot).into_iter()).collect()
            }
            "liquid" if has(snapshot, LIQUID_VOLUME.name) => {
                (Self::column(LIQUID_VOLUME.name, snapshot).into_iter()).collect()
            }
            "depth" if of_run.wears => vec![Self::Depth],
            _ if of_run.has_sheets && SheetQuantity::named(wanted).is_some() => {
                SheetQuantity::named(wanted)
                    .into_iter()
                    .map(Self::Sheet)
                    .collect()
            }
            "speed" if speed().is_some() => speed().into_iter().collect(),
            _ => {
                let found = Self::column(wanted, snapshot);
                let found = found.or_else(|| Self::vector(wanted, wanted, snapshot));
                vec![found.ok_or_else(|| unknown(wanted, snapshot))?]
            }
        })
    }

    fn column(name: &str, snapshot: &Snapshot) -> Option<Self> {
        let spec = snapshot.specs.iter().find(|spec| spec.name == name)?;
        let known = snapshot
            .column(name)
            .filter(|column| !matches!(column, Column::Text(_)));
        known.map(|_| Self::Column {
            name: spec.name.clone(),
            unit: shown(&spec.unit),
        })
    }

    fn vector(group: &str, name: &str, snapshot: &Snapshot) -> Option<Self> {
        let places =
            groups(&snapshot.specs)
                .into_iter()
                .find_map(|(found, places)| match places {
                    Group::Vector(places) if found == group => Some(places),
                    _ => None,
                })?;
        Some(Self::Length {
            name: name.replace('_', " "),
            columns: places.map(|place| snapshot.specs[place].name.clone()),
            unit: shown(&snapshot.specs[places[0]].unit),
        })
    }

    /// How the picture shows it.
    pub(super) fn colour(&self, snapshot: &Snapshot) -> ColourBy {
        match self {
            Self::None => ColourBy::Plain,
            Self::Height => ColourBy::scalar("height", "m"),
            Self::Diameter => ColourBy::scalar("diameter", "m"),
            Self::Material => ColourBy::Category {
                label: "material".into(),
                names: snapshot.header.materials.clone(),
            },
            Self::Body => ColourBy::Category {
                label: "body".into(),
                names: Vec::new(),
            },
            Self::Clump { names } => ColourBy::Category {
                label: CLUMP.into(),
                names: names.clone(),
            },
            Self::Depth => ColourBy::scalar("depth", "m"),
            Self::Sheet(quantity) => quantity.colour(),
            Self::Column { name, unit } => ColourBy::scalar(&name.replace('_', " "), unit),
            Self::Length { name, unit, .. } => ColourBy::scalar(name, unit),
        }
    }

    /// Whether a table has what it takes.
    pub(super) fn is_of(&self, snapshot: &Snapshot) -> bool {
        match self {
            Self::None | Self::Height | Self::Depth | Self::Sheet(_) => true,
            Self::Diameter => has(snapshot, "radius"),
            Self::Material => has(snapshot, "material"),
            Self::Body => has(snapshot, "body"),
            Self::Clump { .. } => has(snapshot, CLUMP),
            Self::Column { name, .. } => snapshot.column(name).and_then(numbers).is_some(),
            Self::Length { columns, .. } => columns.iter().all(|name| has(snapshot, name)),
        }
    }

    /// The value of each particle.
    pub(super) fn values(&self, snapshot: &Snapshot) -> Result<Vec<f64>, ExportError> {
        let named = |name: &str| {
            let column = snapshot.column(name);
            column
                .and_then(numbers)
                .ok_or_else(|| unknown(name, snapshot))
        };
        Ok(match self {
            Self::None => vec![0.0; snapshot.frame.rows()],
            Self::Depth | Self::Sheet(_) => vec![f64::NAN; snapshot.frame.rows()],
            Self::Height => {
                let gravity = snapshot.header.gravity.unwrap_or_default();
                let up = upwards(gravity, snapshot.dimensions() == 2);
                super::scene::centres(snapshot)?
                    .iter()
                    .map(|centre| centre.dot(up))
                    .collect()
            }
            Self::Diameter => named("radius")?.iter().map(|radius| 2.0 * radius).collect(),
            Self::Material => named("material")?,
            Self::Body => named("body")?,
            Self::Clump { .. } => named(CLUMP)?,
            Self::Column { name, .. } => named(name)?,
            Self::Length { columns, .. } => {
                let names = columns.each_ref().map(String::as_str);
                let vectors = snapshot.vectors(names);
                let vectors = vectors.ok_or_else(|| unknown(names[0], snapshot))?;
                vectors.iter().map(|vector| vector.length()).collect()
            }
        })
    }
}

/// Whether some particle moves.
pub(super) fn moves(snapshot: &Snapshot) -> bool {
    let (Some(velocities), Ok(radii)) = (
        snapshot.vectors(["vx", "vy", "vz"]),
        snapshot.numbers("radius"),
    ) else {
        return false;
    };
    let gravity = snapshot.header.gravity.unwrap_or_default();
    let grains = radii.iter().copied().zip(velocities);
    mercury_pictures::moves(gravity, snapshot.frame.time, grains)
}

fn has(snapshot: &Snapshot, name: &str) -> bool {
    snapshot.column(name).is_some()
}

/// A unit as people write it; none for pure numbers.
fn shown(unit: &str) -> String {
    match unit {
        "1" => String::new(),
        _ => unit.replace("^2", "²").replace("^3", "³"),
    }
}

/// Any column of numbers; what is missing has no value.
fn numbers(column: &Column) -> Option<Vec<f64>> {
    Some(match column {
        Column::F64(values) => values.clone(),
        Column::I32(values) => values.iter().map(|v| f64::from(*v)).collect(),
        Column::U8(values) => values.iter().map(|v| f64::from(*v)).collect(),
        Column::U32(values) => values.iter().map(|v| f64::from(*v)).collect(),
        Column::U64(values) => values.iter().map(|v| *v as f64).collect(),
        Column::OptionalU32(values) => values
            .iter()
            .map(|v| v.map_or(f64::NAN, f64::from))
            .collect(),
        Column::Text(_) => return None,
    })
}

fn unknown(wanted: &str, snapshot: &Snapshot) -> ExportError {
    let mut known: Vec<String> = ["auto", "none", "height"].map(str::to_owned).into();
    let further = [
        ("diameter", "radius"),
        ("film", FILM_VOLUME.name),
        ("liquid", LIQUID_VOLUME.name),
    ];
    let further = further.iter().filter(|(_, column)| has(snapshot, column));
    known.extend(further.map(|(name, _)| (*name).to_owned()));
    for (name, group) in groups(&snapshot.specs) {
        match group {
            Group::Vector(_) if name == "velocity" => known.push("speed".into()),
            Group::Vector(_) if name != "position" => known.push(name),
            Group::Single(place) if !matches!(snapshot.frame.columns[place], Column::Text(_)) => {
                known.push(name);
            }
            _ => {}
        }
    }
    let path = snapshot.path.display();
    ExportError::Input(format!(
        "--colour {wanted}: {path} has nothing of that name\nhelp: it has {}, and the components of vectors",
        known.join(", ")
    ))
}

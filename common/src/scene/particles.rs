//! `[[particles]]` and `[clumps.NAME]`: what is there at the start.

use std::path::PathBuf;

use glam::{DQuat, DVec3};

use super::cursor::Fields;
use super::from_item::FromItem;
use super::item::Item;
use super::keys::{
    Absent, Kind, SceneKey, TableKeys, Variants, key, non_negative, positive, variant, vector,
};
use super::laws::Range;
use super::properties::{self, PROPERTIES};
use super::region::read_corners;
use super::source::{Located, SourceSpan};
use super::{ClumpIndex, MaterialIndex};
use crate::particle_properties::PropertyValue;

/// A rigid body made of overlapping spheres, as a template.
#[derive(Debug, Clone, PartialEq)]
pub struct Clump {
    /// The name, from the head of the table.
    pub name: Located<String>,
    /// The clump file, resolved against the folder of the scene.
    pub file: Located<PathBuf>,
    /// The material of its surface.
    pub material: Located<MaterialIndex>,
}

/// An entry of `[[particles]]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Particles {
    /// Unique among entries that have one.
    pub name: Option<Located<String>>,
    /// Where the entry stands.
    pub place: SourceSpan,
    /// Source of the particles: which they are and where they lie.
    pub source: ParticleSource,
}

/// Particles that an entry of `[[particles]]` stands for.
#[derive(Debug, Clone, PartialEq)]
pub enum ParticleSource {
    /// One particle.
    One {
        /// Material, size and start.
        particle: ParticleValues,
        /// Centre, m.
        position: Located<DVec3>,
    },
    /// Equal particles on a lattice.
    Lattice {
        /// Material, size and start of each.
        particle: ParticleValues,
        /// The sites.
        lattice: Lattice,
    },
    /// A table: columns by header x,y,z,radiusand optionally
    /// material,vx,vy,vz,wx,wy,wz, properties.
    Table {
        /// Resolved against the folder of the scene.
        file: Located<PathBuf>,
        /// Material of rows without one.
        material: Option<Located<MaterialIndex>>,
        /// Whether they never move; default false.
        fixed: bool,
        /// Length of one unit of `x`, `y`, `z` and `radius` where their columns name none, m; default 1.
        scale: Option<Located<f64>>,
    },
    /// A state of another run.
    Run {
        /// The folder of that run, resolved against the folder of the scene.
        folder: Located<PathBuf>,
        /// The time of that run, s; none: its last state, with the walls of this scene.
        at: Option<Located<f64>>,
    },
    /// One clump, or equal ones on a lattice.
    Clump {
        /// The template.
        clump: Located<ClumpIndex>,
        /// Where the centre of mass is.
        at: ClumpPlace,
        /// Default the identity.
        orientation: Located<Orientation>,
        /// Factor on all lengths; default 1.
        scale: Located<f64>,
        /// How it starts and what of it is prescribed.
        start: Start,
    },
}

/// Where clumps are put.
#[derive(Debug, Clone, PartialEq)]
pub enum ClumpPlace {
    /// One, its centre of mass here, m.
    Position(Located<DVec3>),
    /// One on each site.
    Lattice(Lattice),
}

/// How a clump is turned at the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Orientation {
    /// From the principal frame to the global one, of length 1.
    Given(DQuat),
    /// Uniform over all orientations, for each clump by itself.
    Random,
}

/// Material, size and start of a particle.
#[derive(Debug, Clone, PartialEq)]
pub struct ParticleValues {
    /// Material.
    pub material: Located<MaterialIndex>,
    /// Radius, m.
    pub radius: Located<f64>,
    /// Velocities, liquid, what is prescribed.
    pub start: Start,
}

/// How a particle or clump starts, and what of its motion is not free.
#[derive(Debug, Clone, PartialEq)]
pub struct Start {
    /// m/s; default 0.
    pub velocity: Located<DVec3>,
    /// rad/s, global frame; default 0.
    pub angular_velocity: Located<DVec3>,
    /// Properties that differ from the default, SI.
    pub properties: Vec<PropertyValue>,
    /// Whether it never moves; default false.
    pub fixed: bool,
    /// Components with a given value.
    pub prescribed: Option<Located<Prescribed>>,
}

/// Components of motion: a number is kept, `None` is free.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prescribed {
    /// m/s.
    pub velocity: [Option<f64>; 3],
    /// rad/s.
    pub angular_velocity: [Option<f64>; 3],
}

/// Sites min + i spacing up to max, both ends included (to 1e-9 of the spacing).
#[derive(Debug, Clone, PartialEq)]
pub struct Lattice {
    /// Where the table stands.
    pub place: SourceSpan,
    /// First site, m.
    pub min: Located<DVec3>,
    /// Bound of the last, m.
    pub max: Located<DVec3>,
    /// Distance of neighbours along each axis, m.
    pub spacing: Located<f64>,
    /// Largest random displacement, m, along each axis with more than one site; default 0.
    pub jitter: Located<f64>,
}

impl Lattice {
    /// The number of sites along x, y, z: floor((max - min) / spacing + 1e-9) + 1.
    ///
    /// ```
    /// # use std::path::Path;
    /// # use mercury_common::scene::{Files, ParticleSource, parse_scene};
    /// # let text = "[time]\nend = 1.0\nstep = 0.1\n[domain]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n[output]\ninterval = 0.1\n\
    /// # [materials.m]\ndensity = 1.0\nnormal = { law = \"linear\", stiffness = 1.0, dissipation = 0.0 }\n\
    /// # [[particles]]\nmaterial = \"m\"\nradius = 0.01\nlattice = { min = [0.1, 0.1, 0.1], max = [0.4, 0.25, 0.1], spacing = 0.1 }\n";
    /// let scene = parse_scene(Path::new("box.toml"), text, &[], Files::Unchecked)?;
    /// let ParticleSource::Lattice { lattice, .. } = &scene.particles[0].source else { panic!() };
    /// // 0.1, 0.2, 0.3, 0.4 along x, 0.1 and 0.2 along y, 0.1 along z
    /// assert_eq!(lattice.sites(), [4.0, 2.0, 1.0]);
    /// # Ok::<(), mercury_common::scene::SceneErrors>(())
    /// ```
    #[must_use]
    pub fn sites(&self) -> [f64; 3] {
        let counts = (*self.max - *self.min) / *self.spacing + DVec3::splat(1e-9);
        (counts.floor() + DVec3::ONE).to_array()
    }
}

#[rustfmt::skip]
const MATERIAL: SceneKey = key("material", Kind::Material, "\"glass\"   # the name of a table [materials.glass]", "its material");

/// `[clumps.NAME]`
#[rustfmt::skip]
pub(super) static CLUMP: TableKeys = TableKeys::new(&[&[
    key("file", Kind::File("make it with mclump, for example: mclump SHAPE.stl PEBBLES.csv -o NAME.clump.toml"), "\"rod.clump.toml\"", "a [clump file](clump-file.md) as mclump writes it"),
    MATERIAL,
]]);

/// How particles and clumps start.
#[rustfmt::skip]
const START: &[SceneKey] = &[
    key("velocity", vector("m/s"), "[0, 0, -0.1]", "at the start").absent(Absent::Zero),
    key("angular_velocity", vector("rad/s"), "[0, 0, 3.0]", "at the start, in the global frame").absent(Absent::Zero),
];
#[rustfmt::skip]
const HELD: &[SceneKey] = &[
    FIXED,
    key("prescribed", Kind::Table(&PRESCRIBED), "{ velocity = [0.0, \"free\", \"free\"] }", "components that keep a value; all others are free").or_open("none"),
];
#[rustfmt::skip]
const FIXED: SceneKey = key("fixed", Kind::Flag, "true", "true: it never moves").or_flag(false);
#[rustfmt::skip]
const LATTICE_KEY: SceneKey = key("lattice", Kind::Table(&LATTICE), "{ min = [0.01, 0.01, 0.01], max = [0.09, 0.09, 0.05], spacing = 2.1e-3 }   # m", "sites from `min` to `max`, both ends included (to 1e-9 of the spacing)");
#[rustfmt::skip]
const POSITION: SceneKey = key("position", vector("m"), "[0.05, 0.05, 0.01]", "its centre");
const SPHERE: &[SceneKey] = &[MATERIAL, key("radius", positive("m"), "1e-3", "its radius")];

/// `[[particles]]`
#[rustfmt::skip]
pub(super) static PARTICLES: TableKeys = TableKeys::new(&[&[
    key("name", Kind::Name, "\"ball\"", "unique among entries that have one; needed for `track`").or_open("none"),
]]).with_variants(Variants::Key {
    of: &[
        variant("run", &[&[
            key("run", Kind::Folder, "\"settle\"", "the folder of the other run"),
            key("at", non_negative("s"), "1.2", "the checkpoint or frame nearest to this time of that run, and the walls where they were then: [how](../how-to/stop-and-resume.md#from-a-time-in-between)").or_open("the last state, and the walls where this scene has them"),
        ]], "a state of another run: all grains that it had, with velocities and contacts"),
        variant("file", &[&[
            key("file", Kind::File(""), "\"particles.csv\"", "[columns](particle-csv.md) by header: `x,y,z,radius`, optionally `material,vx,vy,vz,wx,wy,wz` and properties as `film_volume`, of clumps `clump[,scale,qw,qx,qy,qz]`"),
            key("material", Kind::Material, "\"glass\"", "of rows without one").or_open("none"),
            FIXED,
            key("scale", positive("m"), "1e-3   # m, or \"1 mm\"", "length of one unit of `x`, `y`, `z` and `radius`, where the header names no unit as in `x [mm]`").or_open("1 m"),
        ]], "a table"),
        variant("clump", &[&[
            key("clump", Kind::Clump, "\"rod\"   # the name of a table [clumps.rod]", "a template `[clumps.NAME]`"),
            POSITION.needed("without `lattice`"),
            LATTICE_KEY.or_open("none"),
            key("orientation", Kind::OneOf(&[Kind::Numbers("", 4, Range::Any), Kind::Keyword("random")]), "\"random\"", "`[w, x, y, z]` from the principal frame to the global one, or `\"random\"`, for each clump by itself").or_open("`[1, 0, 0, 0]`"),
            key("scale", positive(""), "0.5", "factor on all lengths").or(1.0),
        ], START, PROPERTIES, HELD], "a clump, or equal ones on a lattice; positions are those of the centre of mass"),
        variant("lattice", &[&[LATTICE_KEY], SPHERE, START, PROPERTIES, HELD], "equal particles on a lattice"),
        variant("position", &[&[POSITION], SPHERE, START, PROPERTIES, HELD], "one particle"),
    ],
    alone: false,
});

#[rustfmt::skip]
static LATTICE: TableKeys = TableKeys::new(&[&[
    key("min", vector("m"), "[0.01, 0.01, 0.01]   # m, the first site", "the first site"),
    key("max", vector("m"), "[0.09, 0.09, 0.05]   # m, bound of the last site", "bound of the last site"),
    key("spacing", positive("m"), "2.1e-3", "between neighbours along each axis"),
    key("jitter", non_negative("m"), "1e-4", "largest random displacement along each axis with more than one site").or(0.0),
]]);

#[rustfmt::skip]
static PRESCRIBED: TableKeys = TableKeys::new(&[&[
    key("velocity", Kind::Components("m/s"), "[0.0, \"free\", \"free\"]", "a number is kept").or_open("free"),
    key("angular_velocity", Kind::Components("rad/s"), "[0.0, \"free\", \"free\"]", "a number is kept").or_open("free"),
]]);

/// Reads `[clumps.NAME]`.
pub(super) fn read_clump(name: Located<String>, item: &Item<'_>) -> Option<Clump> {
    let fields = item.open(&CLUMP)?;
    Some(Clump {
        name,
        file: fields.read("file"),
        material: fields.read("material"),
    })
}

/// Reads an entry of `[[particles]]`.
pub(super) fn read(item: &Item<'_>) -> Option<Particles> {
    let entry = item.table()?;
    let kinds = ["run", "file", "clump", "lattice", "position"];
    // A clump has a position or a lattice; everything else here excludes everything else.
    let is_one = if entry.has("clump") {
        entry.exactly_one(&kinds[..3], true) && entry.exactly_one(&kinds[3..], true)
    } else {
        entry.exactly_one(&kinds, true)
    };
    if !is_one {
        return None;
    }
    let fields = item.open(&PARTICLES)?;
    let source = match fields.variant()? {
        "run" => ParticleSource::Run {
            folder: fields.read("run"),
            at: fields.read("at"),
        },
        "file" => ParticleSource::Table {
            file: fields.read("file"),
            material: fields.read("material"),
            fixed: fields.read("fixed"),
            scale: fields.read("scale"),
        },
        "clump" => {
            let orientation: Option<_> = fields.read("orientation");
            ParticleSource::Clump {
                clump: fields.read("clump"),
                at: match fields.has("lattice") {
                    true => ClumpPlace::Lattice(fields.read::<Option<_>>("lattice")?),
                    false => ClumpPlace::Position(fields.require("position")),
                },
                orientation: orientation.unwrap_or_else(|| {
                    fields.default("orientation", Orientation::Given(DQuat::IDENTITY))
                }),
                scale: fields.read("scale"),
                start: read_start(&fields),
            }
        }
        "lattice" => {
            let particle = read_values(&fields);
            let lattice: Option<_> = fields.read("lattice");
            ParticleSource::Lattice {
                particle,
                lattice: lattice?,
            }
        }
        _ => ParticleSource::One {
            particle: read_values(&fields),
            position: fields.read("position"),
        },
    };
    Some(Particles {
        name: fields.read("name"),
        place: item.place.clone(),
        source,
    })
}

/// [w, x, y, z], scaled to length 1, or "random".
impl FromItem for Orientation {
    fn from_item(item: &Item<'_>, _: &'static Kind) -> Option<Self> {
        if item.is_text() {
            return item.keyword("random").map(|()| Orientation::Random);
        }
        let numbers = item.numbers::<4>()?.value;
        let largest = (numbers.iter()).fold(0.0_f64, |largest, n| largest.max(n.abs()));
        if largest == 0.0 {
            item.report("must not be of length 0");
            return None;
        }
        let [w, x, y, z] = numbers.map(|number| number / largest);
        let turn = DQuat::from_xyzw(x, y, z, w).normalize();
        Some(Orientation::Given(turn))
    }
}

fn read_values(fields: &Fields<'_>) -> ParticleValues {
    ParticleValues {
        material: fields.read("material"),
        radius: fields.read("radius"),
        start: read_start(fields),
    }
}

fn read_start(fields: &Fields<'_>) -> Start {
    Start {
        velocity: fields.read("velocity"),
        angular_velocity: fields.read("angular_velocity"),
        properties: properties::not_default(properties::read(fields)),
        fixed: fields.read("fixed"),
        prescribed: fields.read("prescribed"),
    }
}

impl FromItem for Prescribed {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        let fields = item.fields(kind)?;
        let components = |key| -> [Option<f64>; 3] {
            let given: Option<_> = fields.read(key);
            given.unwrap_or_default()
        };
        Some(Prescribed {
            velocity: components("velocity"),
            angular_velocity: components("angular_velocity"),
        })
    }
}

impl FromItem for Lattice {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        let fields = item.fields(kind)?;
        let (min, max) = read_corners(&fields);
        Some(Lattice {
            place: item.place.clone(),
            min,
            max,
            spacing: fields.read("spacing"),
            jitter: fields.read("jitter"),
        })
    }
}

//! `[[particles]]` and `[clumps.NAME]`: what is there at the start.

use std::path::PathBuf;

use glam::{DQuat, DVec3};

use super::cursor::Fields;
use super::item::Item;
use super::settings::flag;
use super::source::{Located, Place};
use super::{ClumpIndex, MaterialIndex};

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
    pub place: Place,
    /// What it puts where.
    pub source: ParticleSource,
}

/// What an entry of `[[particles]]` stands for.
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
    /// material,vx,vy,vz,wx,wy,wz,film_volume.
    Table {
        /// Resolved against the folder of the scene.
        file: Located<PathBuf>,
        /// Of rows without one.
        material: Option<Located<MaterialIndex>>,
        /// Whether they never move; default false.
        fixed: bool,
    },
    /// The last state of another run.
    Run {
        /// The folder of that run, resolved against the folder of the scene.
        folder: Located<PathBuf>,
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
    /// Liquid on its surface, m3; default 0.
    pub film_volume: Located<f64>,
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
    pub place: Place,
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

/// Reads `[clumps.NAME]`.
pub(super) fn read_clump(name: Located<String>, item: &Item<'_>) -> Option<Clump> {
    let fields = item.table()?;
    let file = fields.need("file").and_then(|item| {
        item.file_or(
            "make it with mclump, for example: mclump SHAPE.stl PEBBLES.csv -o NAME.clump.toml",
        )
    });
    let material = fields.need("material").and_then(|item| item.material());
    fields.finish();
    Some(Clump {
        name,
        file: file?,
        material: material?,
    })
}

/// Reads an entry of `[[particles]]`.
pub(super) fn read(item: &Item<'_>) -> Option<Particles> {
    let fields = item.table()?;
    let name = fields.get("name").and_then(|item| item.name());
    let kinds = ["run", "file", "clump", "lattice", "position"];
    // A clump has a position or a lattice; everything else here excludes everything else.
    let is_one = if fields.has("clump") {
        fields.exactly_one(&kinds[..3], true) && fields.exactly_one(&kinds[3..], true)
    } else {
        fields.exactly_one(&kinds, true)
    };
    if !is_one {
        return None;
    }
    let source = if fields.has("run") {
        let folder = fields.need("run").and_then(|item| item.folder());
        folder.map(|folder| ParticleSource::Run { folder })
    } else if fields.has("file") {
        let file = fields.need("file").and_then(|item| item.file());
        let material = fields.get("material").and_then(|item| item.material());
        let fixed = flag(&fields, "fixed", false);
        file.map(|file| ParticleSource::Table {
            file,
            material,
            fixed,
        })
    } else if fields.has("clump") {
        read_placed_clump(&fields)
    } else if fields.has("lattice") {
        let lattice = fields.need("lattice").and_then(|item| read_lattice(&item));
        let particle = read_values(&fields);
        lattice
            .zip(particle)
            .map(|(lattice, particle)| ParticleSource::Lattice { particle, lattice })
    } else {
        let position = fields.need("position").and_then(|item| item.vector());
        let particle = read_values(&fields);
        position
            .zip(particle)
            .map(|(position, particle)| ParticleSource::One { particle, position })
    };
    fields.finish();
    Some(Particles {
        name,
        place: item.place.clone(),
        source: source?,
    })
}

fn read_placed_clump(fields: &Fields<'_>) -> Option<ParticleSource> {
    let clump = fields.need("clump").and_then(|item| item.clump());
    let at = if fields.has("lattice") {
        let lattice = fields.need("lattice").and_then(|item| read_lattice(&item));
        lattice.map(ClumpPlace::Lattice)
    } else {
        let position = fields.need("position").and_then(|item| item.vector());
        position.map(ClumpPlace::Position)
    };
    let orientation = match fields.get("orientation") {
        Some(item) => read_orientation(&item),
        None => Some(fields.default("orientation", Orientation::Given(DQuat::IDENTITY))),
    };
    let scale = match fields.get("scale") {
        Some(item) => item.positive(),
        None => Some(fields.default("scale", 1.0)),
    };
    let start = read_start(fields);
    Some(ParticleSource::Clump {
        clump: clump?,
        at: at?,
        orientation: orientation?,
        scale: scale?,
        start: start?,
    })
}

/// [w, x, y, z], scaled to length 1, or "random".
fn read_orientation(item: &Item<'_>) -> Option<Located<Orientation>> {
    if item.is_text() {
        item.keyword("random")?;
        return Some(Located {
            value: Orientation::Random,
            place: item.place.clone(),
        });
    }
    let numbers = item.numbers::<4>()?;
    let largest = numbers
        .iter()
        .fold(0.0_f64, |largest, number| largest.max(number.abs()));
    if largest == 0.0 {
        item.report("must not be of length 0");
        return None;
    }
    Some(numbers.map(|n| {
        let [w, x, y, z] = n.map(|number| number / largest);
        Orientation::Given(DQuat::from_xyzw(x, y, z, w).normalize())
    }))
}

fn read_values(fields: &Fields<'_>) -> Option<ParticleValues> {
    let material = fields.need("material").and_then(|item| item.material());
    let radius = fields.need("radius").and_then(|item| item.positive());
    let start = read_start(fields);
    Some(ParticleValues {
        material: material?,
        radius: radius?,
        start: start?,
    })
}

fn read_start(fields: &Fields<'_>) -> Option<Start> {
    let vector = |key| match fields.get(key) {
        Some(item) => item.vector(),
        None => Some(fields.default(key, DVec3::ZERO)),
    };
    let velocity = vector("velocity");
    let angular_velocity = vector("angular_velocity");
    let film_volume = match fields.get("film_volume") {
        Some(item) => item.non_negative(),
        None => Some(fields.default("film_volume", 0.0)),
    };
    let fixed = flag(fields, "fixed", false);
    let prescribed = fields
        .get("prescribed")
        .and_then(|item| read_prescribed(&item));
    Some(Start {
        velocity: velocity?,
        angular_velocity: angular_velocity?,
        film_volume: film_volume?,
        fixed,
        prescribed,
    })
}

fn read_prescribed(item: &Item<'_>) -> Option<Located<Prescribed>> {
    let fields = item.table()?;
    let components = |key| match fields.get(key) {
        Some(item) => read_components(&item),
        None => Some([None; 3]),
    };
    let velocity = components("velocity");
    let angular_velocity = components("angular_velocity");
    fields.finish();
    Some(Located {
        value: Prescribed {
            velocity: velocity?,
            angular_velocity: angular_velocity?,
        },
        place: item.place.clone(),
    })
}

fn read_components(item: &Item<'_>) -> Option<[Option<f64>; 3]> {
    let items = item.list()?;
    if items.len() != 3 {
        item.report(format!(
            "expected 3 numbers or \"free\", got {}",
            items.len()
        ));
        return None;
    }
    let mut components = [None; 3];
    for (component, item) in components.iter_mut().zip(items) {
        *component = if item.is_text() {
            item.keyword("free")?;
            None
        } else {
            Some(item.number()?.value)
        };
    }
    Some(components)
}

fn read_lattice(item: &Item<'_>) -> Option<Lattice> {
    let fields = item.table()?;
    let min = fields.need("min").and_then(|item| item.vector());
    let max = fields.need("max").and_then(|item| item.vector());
    let spacing = fields.need("spacing").and_then(|item| item.positive());
    let jitter = match fields.get("jitter") {
        Some(item) => item.non_negative(),
        None => Some(fields.default("jitter", 0.0)),
    };
    fields.finish();
    let (min, max) = min.zip(max)?;
    for axis in 0..3 {
        if min[axis] > max[axis] {
            let name = ["x", "y", "z"][axis];
            let message = format!(
                "must not lie below min: in {name} min = {} and max = {}",
                min[axis], max[axis]
            );
            item.context.report(max.error(message));
        }
    }
    Some(Lattice {
        place: item.place.clone(),
        min,
        max,
        spacing: spacing?,
        jitter: jitter?,
    })
}

//! MercuryDPM's `.restart`, as far as fields need it: species' densities, particles, contacts, the box.

use std::collections::HashMap;
use std::io::BufRead;
use std::path::Path;

use glam::DVec3;
use mercury_common::error::FormatError;
use mercury_common::formats::lines::LineReader;

use super::{ball, open_text, spin_of_ball};
use crate::state::{Contacts, Partner, State};

/// Content of a restart file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Restart {
    /// Particles with their masses, contacts with their forces and torques.
    pub state: State,
    /// Density of each species.
    pub densities: Vec<f64>,
    /// 2: discs, 3: spheres.
    pub particle_dimensions: u8,
    /// Notes of content that the fields do not use, and of values that were taken otherwise than they stand there.
    pub notes: Vec<String>,
}

impl Restart {
    /// Whether the particle with this number is fixed.
    #[must_use]
    pub(super) fn fixed(&self, row: usize) -> bool {
        self.state.particles.flowing.get(row) == Some(&false)
    }
}

/// Whether a file begins as MercuryDPM's restart files do.
pub(super) fn is_of_mercury_dpm(path: &Path) -> bool {
    use std::io::Read as _;
    let mut start = [0; 10];
    let read = std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut start));
    read.is_ok() && &start == b"MercuryDPM"
}

/// A record: words, some of which are keys followed by numbers.
#[derive(Clone, Copy)]
struct Record<'a> {
    path: &'a Path,
    line: usize,
    text: &'a str,
}

impl<'a> Record<'a> {
    fn words(self) -> impl Iterator<Item = &'a str> {
        self.text.split_ascii_whitespace()
    }

    fn error(self, found: String, expected: &str) -> FormatError {
        FormatError::at(self.path, self.line, None, found, expected)
    }

    fn try_numbers<const N: usize>(self, key: &str) -> Option<Result<[f64; N], FormatError>> {
        let mut words = self.words();
        words.find(|word| *word == key)?;
        let mut out = [0.0; N];
        for out in &mut out {
            match words.next().and_then(|word| word.parse().ok()) {
                Some(value) => *out = value,
                None => {
                    return Some(Err(self.error(
                        format!("the word {key} without its numbers"),
                        "numbers behind it",
                    )));
                }
            }
        }
        Some(Ok(out))
    }

    fn numbers<const N: usize>(self, key: &str) -> Result<[f64; N], FormatError> {
        self.try_numbers(key).unwrap_or_else(|| {
            Err(self.error(
                format!("no word {key}"),
                "a record of MercuryDPM's version 1.0",
            ))
        })
    }

    fn number(self, key: &str) -> Result<f64, FormatError> {
        self.numbers::<1>(key).map(|[value]| value)
    }

    fn vector(self, key: &str) -> Result<DVec3, FormatError> {
        self.numbers(key).map(DVec3::from_array)
    }
}

/// Reads a restart file of version 1.0 (or 0.14, which is laid out alike).
///
/// # Errors
/// When the file cannot be read, is of another version, or lacks what particles and contacts are made of.
pub fn read_restart(path: &Path) -> Result<Restart, FormatError> {
    let mut lines = LineReader::new(open_text(path)?, path);
    let first = next(&mut lines)?;
    if let Some(old) = first.filter(|record| record.words().next() == Some("restart_version")) {
        let found = format!("{}, from before MercuryDPM 1.0", old.text.trim());
        let help = "its .data and .fstat can be read with --density";
        return Err(old.error(found, "version 1.0 or 0.14").with_help(help));
    }
    let first = first.filter(|record| record.words().next() == Some("MercuryDPM"));
    let Some(first) = first else {
        let expected = "a restart file of MercuryDPM, which begins with that word";
        return Err(FormatError {
            expected: expected.to_owned(),
            ..FormatError::of_file(path, "another kind of file")
        });
    };
    let version = first.words().nth(1).unwrap_or_default();
    if !["1.0", "0.14"].contains(&version) {
        let found = format!("version {version}");
        return Err(first.error(found, "version 1.0 or 0.14"));
    }
    let mut restart = Restart {
        particle_dimensions: 3,
        ..Restart::default()
    };
    // The row of each particle's number; of particles with the same number the first.
    let mut rows: HashMap<u64, usize> = HashMap::new();
    while let Some(record) = next(&mut lines)? {
        let word = record.words().next().unwrap_or_default();
        let line = record.line;
        let count = || -> Result<usize, FormatError> {
            let number = record.words().nth(1).and_then(|word| word.parse().ok());
            number.ok_or_else(|| {
                record.error(
                    format!("the word {word} without a number"),
                    "the number of records",
                )
            })
        };
        match word {
            "xMin" => {
                let part = |key: &str| record.number(key);
                restart.state.space.min = DVec3::new(part("xMin")?, part("yMin")?, part("zMin")?);
                restart.state.space.max = DVec3::new(part("xMax")?, part("yMax")?, part("zMax")?);
            }
            "timeStep" => restart.state.time = record.number("time")?,
            "systemDimensions" => {
                let dimensions = |key: &str| {
                    record
                        .number(key)
                        .map(|value| if value < 3.0 { 2 } else { 3 })
                };
                restart.state.space.dimensions = dimensions("systemDimensions")?;
                restart.particle_dimensions = dimensions("particleDimensions")?;
            }
            "Species" => {
                let mut left = count()?;
                while left > 0 {
                    let Some(record) = next(&mut lines)? else {
                        return Err(cut(path, line, "species"));
                    };
                    // Mixed species stand between and have no density.
                    if let Some(density) = record.try_numbers::<1>("density") {
                        restart.densities.push(density?[0]);
                        left -= 1;
                    }
                }
            }
            "Boundaries" => {
                for _ in 0..count()? {
                    let Some(record) = next(&mut lines)? else {
                        break;
                    };
                    let name = record.words().next().unwrap_or_default();
                    if name == "PeriodicBoundary" {
                        push_periodic(&mut restart, record)?;
                    } else if OTHER_PERIODS.contains(&name) {
                        restart.notes.push(format!(
                            "{}:{}: fields do not go on through this {name}",
                            path.display(),
                            record.line
                        ));
                    }
                }
            }
            "Particles" => {
                for _ in 0..count()? {
                    let Some(record) = next(&mut lines)? else {
                        return Err(cut(path, line, "particles"));
                    };
                    let row = restart.state.particles.len();
                    let id = push_particle(&mut restart, record)?;
                    rows.entry(id).or_insert(row);
                }
            }
            "Interactions" => {
                let mut contacts = Contacts::default();
                for _ in 0..count()? {
                    let Some(record) = next(&mut lines)? else {
                        return Err(cut(path, line, "interactions"));
                    };
                    push_contact(&restart, &rows, record, &mut contacts)?;
                }
                restart.state.contacts = Some(contacts);
            }
            _ => {}
        }
    }
    if restart.state.contacts.is_none() {
        let expected = "sections up to Interactions";
        return Err(FormatError {
            expected: expected.to_owned(),
            ..FormatError::of_file(path, "a file that is cut")
        });
    }
    Ok(restart)
}

/// The next line that is not blank.
fn next<R: BufRead>(lines: &mut LineReader<R>) -> Result<Option<Record<'_>>, FormatError> {
    Ok(lines.advance()?.then(|| Record {
        path: lines.path(),
        line: lines.line_number(),
        text: lines.line(),
    }))
}

/// The file ends within the records that the line announces.
fn cut(path: &Path, line: usize, what: &str) -> FormatError {
    let found = format!("the file ends within the {what}");
    FormatError::at(path, line, None, found, "a line for each")
}

/// Boundaries that let particles through to somewhere else in other ways than by a shift along an axis.
const OTHER_PERIODS: [&str; 6] = [
    "AngledPeriodicBoundary",
    "CircularPeriodicBoundary",
    "LeesEdwardsBoundary",
    "TimeDependentPeriodicBoundary",
    "ConstantMassFlowMaserBoundary",
    "SubcriticalMaserBoundary",
];

/// The domain repeats from where the boundary is to where its other side is, wherever the box ends.
fn push_periodic(restart: &mut Restart, record: Record<'_>) -> Result<(), FormatError> {
    let (path, line) = (record.path.display(), record.line);
    let normal = record.vector("normal")?;
    let place = |names: [&str; 2]| {
        let found = names
            .into_iter()
            .find_map(|name| record.try_numbers::<1>(name));
        found.unwrap_or_else(|| record.numbers(names[0]))
    };
    let [left] = place(["distanceLeft", "position_left"])?;
    let [right] = place(["distanceRight", "position_right"])?;
    let Some(axis) = (0..3).find(|&axis| normal[axis].abs() > 1.0 - 1e-9) else {
        restart.notes.push(format!(
            "{path}:{line}: fields do not go on through a periodic boundary with the normal {normal}, along none of the axes"
        ));
        return Ok(());
    };
    let (low, high) = if normal[axis] > 0.0 {
        (left, right)
    } else {
        (-right, -left)
    };
    let length = high - low;
    if !(length > 0.0 && length.is_finite()) {
        return Err(record.error(
            format!("a period from {left} to {right}"),
            "a length above 0",
        ));
    }
    let space = &mut restart.state.space;
    let name = ["x", "y", "z"][axis];
    if (space.min[axis] - low)
        .abs()
        .max((space.max[axis] - high).abs())
        > 1e-6 * length
    {
        restart.notes.push(format!(
            "{path}:{line}: the domain is periodic along {name} from {low} to {high}, and is taken to end there"
        ));
    }
    (space.min[axis], space.max[axis]) = (low, high);
    space.periodic[axis] = true;
    Ok(())
}

fn push_particle(restart: &mut Restart, record: Record<'_>) -> Result<u64, FormatError> {
    let (radius, inverse_mass) = (record.number("radius")?, record.number("invMass")?);
    let species = record.number("indSpecies")? as usize;
    let angular_velocity = record.vector("angularVelocity")?;
    let dimensions = restart.particle_dimensions;
    let volume = ball(radius, dimensions);
    let density = restart.densities.get(species).copied();
    let density = density
        .ok_or_else(|| record.error(format!("species {species}"), "one of the species before"))?;
    // The file leaves out the mass of fixed particles; it is never used.
    let mass = if inverse_mass > 0.0 {
        1.0 / inverse_mass
    } else {
        density * volume
    };
    let particles = &mut restart.state.particles;
    particles.id.push(record.number("id")? as u32);
    particles.material.push(species as u32);
    particles.flowing.push(inverse_mass > 0.0);
    particles.position.push(record.vector("position")?);
    particles.velocity.push(record.vector("velocity")?);
    particles.mass.push(mass);
    particles.volume.push(volume);
    particles.radius.push(radius);
    particles.angular_velocity.push(angular_velocity);
    particles
        .spin
        .push(spin_of_ball(mass, radius, angular_velocity, dimensions));
    Ok(record.number("id")? as u64)
}

fn push_contact(
    restart: &Restart,
    rows: &HashMap<u64, usize>,
    record: Record<'_>,
    out: &mut Contacts,
) -> Result<(), FormatError> {
    let row = |id: f64| {
        let row = rows.get(&(id as u64)).copied();
        row.ok_or_else(|| record.error(format!("particle {id}"), "one of the particles before"))
    };
    let (point, normal) = (record.vector("contactPoint")?, record.vector("normal")?);
    let (particle, partner, partner_arm) = match record.try_numbers::<2>("particleIds") {
        Some(ids) => {
            let [p, i] = ids?;
            let (p, i) = (row(p)?, row(i)?);
            let arm = restart
                .state
                .space
                .nearest(restart.state.particles.position[p] - point);
            (
                p,
                Partner::Particle(i as u32),
                arm - record.number("distance")? * normal,
            )
        }
        None => {
            let [p, wall] = record.numbers::<2>("particleWallIds")?;
            (row(p)?, Partner::Wall(wall as u32), DVec3::ZERO)
        }
    };
    out.particle.push(particle as u32);
    out.partner.push(partner);
    out.point.push(point);
    out.arm.push(
        restart
            .state
            .space
            .nearest(restart.state.particles.position[particle] - point),
    );
    out.partner_arm.push(partner_arm);
    out.normal.push(normal);
    out.force.push(record.vector("force")?);
    // Rolling and torsion resistance; the lever arm of the force comes on top.
    out.couple.push(record.vector("torque")?);
    Ok(())
}

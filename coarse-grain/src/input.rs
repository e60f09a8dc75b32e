//! Where states come from: run folders, `.data` with `.fstat`, MercuryDPM's `.restart`.

mod data;
mod fstat;
mod packed;
mod restart;
mod run;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use glam::DVec3;
use mercury_common::error::FormatError;
use mercury_common::run_files::{self, FRAMES, particles_in, plain_name, series_number};

use crate::CgError;
use crate::state::State;
pub use data::DataSource;
pub use mercury_common::frames::FrameChoice;
use packed::open_text;
pub use restart::{Restart, read_restart};
pub use run::{RunSource, equal_ball, state_of};

/// From one look for new frames to the next.
pub const PAUSE: Duration = Duration::from_millis(500);

/// Facts that the user gives and files lack.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Given {
    /// Density of all materials, kg/m^3 (2D: kg/m^2).
    pub density: Option<f64>,
    /// Densities by index of material.
    pub densities: BTreeMap<u32, f64>,
    /// Numbers of fixed particles, as ranges with both ends.
    pub fixed: Vec<(u32, u32)>,
    /// The file of contacts, if it does not lie beside the particles.
    pub fstat: Option<PathBuf>,
}

/// Parts of the input that are needed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Needs {
    /// Masses.
    pub mass: bool,
    /// Contacts.
    pub contacts: bool,
    /// Couples of contacts.
    pub couples: bool,
    /// Angular velocities.
    pub rotation: bool,
    /// The liquid of particles.
    pub liquid: bool,
    /// The identity of particles from frame to frame.
    pub identity: bool,
}

/// Frames of particles of whose time there are no contacts: their times as bits, each once however often the input is read, and
/// the note of the first.
#[derive(Debug, Default)]
pub struct Skipped(Mutex<(BTreeSet<u64>, Option<String>)>);

impl Skipped {
    /// One more: at which time, and at which time contacts were found instead.
    fn add(&self, time: f64, contacts: Option<f64>) {
        let mut found = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        found.0.insert(time.to_bits());
        found.1.get_or_insert_with(|| match contacts {
            Some(other) => format!("particles at t = {time}, contacts at t = {other}"),
            None => format!("particles at t = {time}, no contacts at all"),
        });
    }

    /// Number of skipped frames, and the times of the first.
    #[must_use]
    pub fn found(&self) -> (usize, Option<String>) {
        let found = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        (found.0.len(), found.1.clone())
    }
}

/// An input, opened.
#[derive(Debug)]
pub enum Source {
    /// Native frames of a run.
    Run(Box<RunSource>),
    /// `.data`, with `.fstat` if contacts are needed.
    Data(Box<DataSource>),
    /// One state of MercuryDPM.
    Restart(PathBuf, Box<Restart>),
}

/// States, and what is wrong with the rest.
pub type States<'a> = Box<dyn Iterator<Item = Result<State, CgError>> + Send + 'a>;

impl Source {
    /// Opens a run folder, `<prefix>.particles.arrow`, `.data` (also the first of a series, `.data.0000`) or a `.restart` of MercuryDPM; the text files may be packed as
    /// [`Packing`](mercury_common::run_files::Packing) lists.
    ///
    /// # Errors
    /// When there is nothing of this kind, several runs lie in the folder, or the file lacks what is needed.
    pub fn open(path: &Path, given: &Given, needs: Needs) -> Result<Self, CgError> {
        if path.is_dir() {
            return Self::open(&particles_in(path)?, given, needs);
        }
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        if name.ends_with(FRAMES) {
            return Ok(Self::Run(Box::new(RunSource::open(path, needs)?)));
        }
        // `.restart` and `.data` may be packed.
        let (plain, _) = plain_name(&name);
        if needs.liquid && path.exists() {
            return Err(CgError::Input(format!(
                "{}: this file does not say which particle holds how much liquid\nhelp: the .particles.arrow of a run with liquid does",
                path.display()
            )));
        }
        if plain.ends_with(".data") || series_number(&name).is_some() {
            return Ok(Self::Data(Box::new(DataSource::open(path, given, needs)?)));
        }
        if plain.ends_with(".restart") {
            let restart = read_restart(path)?;
            check(&restart.state, &path.display().to_string())?;
            return Ok(Self::Restart(path.to_owned(), Box::new(restart)));
        }
        let found = if path.exists() {
            "neither a run folder nor a file of particles"
        } else {
            "there is no such file or folder"
        };
        let error = FormatError {
            expected:
                "a folder of mercury-solve, a .particles.arrow, .data or .restart file (text also as .gz, .zst, .xz, .bz2)"
                    .to_owned(),
            ..FormatError::of_file(path, found)
        };
        Err(error.into())
    }

    /// The file of particles.
    #[must_use]
    pub fn path(&self) -> &Path {
        match self {
            Self::Run(run) => run.path(),
            Self::Data(data) => data.path(),
            Self::Restart(path, _) => path,
        }
    }

    /// Beginning of the names of the run's files.
    #[must_use]
    pub fn prefix(&self) -> String {
        run_files::prefix(self.path())
    }

    /// Names of materials by index, as far as the input has any.
    #[must_use]
    pub fn materials(&self) -> &[String] {
        match self {
            Self::Run(run) => run.materials(),
            _ => &[],
        }
    }

    /// Whether contacts are at hand.
    #[must_use]
    pub fn has_contacts(&self) -> bool {
        match self {
            Self::Run(run) => run.has_contacts(),
            Self::Data(data) => data.has_contacts(),
            Self::Restart(..) => true,
        }
    }

    /// Notes on the input, for the user before anything is computed.
    #[must_use]
    pub fn notes(&self) -> &[String] {
        match self {
            Self::Run(_) => &[],
            Self::Data(data) => data.notes(),
            Self::Restart(_, restart) => &restart.notes,
        }
    }

    /// Number of frames that were left out so far because there are no contacts of their time, and the times of the first.
    #[must_use]
    pub fn skipped(&self) -> (usize, Option<String>) {
        match self {
            Self::Run(run) => run.skipped().found(),
            Self::Data(data) => data.skipped().found(),
            Self::Restart(..) => (0, None),
        }
    }

    /// The chosen states, one in memory at a time; after an error nothing follows.
    #[must_use]
    pub fn states(&self, choice: FrameChoice) -> States<'_> {
        match self {
            Self::Run(run) => run.states(choice),
            Self::Data(data) => data.states(choice),
            Self::Restart(_, restart) => {
                let wanted = choice == FrameChoice::Last || choice.has(0);
                Box::new(wanted.then(|| Ok(restart.state.clone())).into_iter())
            }
        }
    }
}

/// Refuses numbers that no field can be made of.
///
/// # Errors
/// When a position, velocity, radius, mass or force is not finite, or a size is negative.
pub fn check(state: &State, origin: &str) -> Result<(), CgError> {
    let time = state.time;
    let wrong = |what: &str, row: usize, value: String| {
        CgError::Input(format!(
            "{origin}: frame at t = {time}: {what} {row} {value}"
        ))
    };
    if !time.is_finite() {
        return Err(CgError::Input(format!(
            "{origin}: a frame at the time {time}"
        )));
    }
    let p = &state.particles;
    for row in 0..p.len() {
        for (name, vector) in [("position", p.position[row]), ("velocity", p.velocity[row])] {
            if !vector.is_finite() {
                return Err(wrong("particle", row, format!("has the {name} {vector}")));
            }
        }
        let turning = p.angular_velocity.get(row).copied().unwrap_or_default();
        let spin = p.spin.get(row).copied().unwrap_or_default();
        for (name, vector) in [("angular velocity", turning), ("spin", spin)] {
            if !vector.is_finite() {
                return Err(wrong("particle", row, format!("has the {name} {vector}")));
            }
        }
        let mass = p.mass.get(row).copied().unwrap_or(0.0);
        let liquid = p.liquid.get(row).copied().unwrap_or(0.0);
        for (name, size) in [
            ("radius", p.radius[row]),
            ("volume", p.volume[row]),
            ("mass", mass),
            ("liquid volume", liquid),
        ] {
            if !(size >= 0.0 && size.is_finite()) {
                return Err(wrong("particle", row, format!("has the {name} {size}")));
            }
        }
    }
    if let Some(contacts) = &state.contacts {
        for row in 0..contacts.len() {
            let couple = contacts.couple.get(row).copied().unwrap_or_default();
            let vectors = [
                ("force", contacts.force[row]),
                ("contact point", contacts.point[row]),
                ("normal", contacts.normal[row]),
                ("way to its particle", contacts.arm[row]),
                ("way to its partner", contacts.partner_arm[row]),
                ("couple", couple),
            ];
            if let Some((name, vector)) = vectors.iter().find(|(_, vector)| !vector.is_finite()) {
                return Err(wrong("contact", row, format!("has the {name} {vector}")));
            }
        }
    }
    Ok(())
}

/// Volume of a sphere, or area of a disc.
fn ball(radius: f64, dimensions: u8) -> f64 {
    let area = std::f64::consts::PI * radius * radius;
    if dimensions == 2 {
        area
    } else {
        4.0 / 3.0 * area * radius
    }
}

/// Angular momentum of a sphere or a disc.
fn spin_of_ball(mass: f64, radius: f64, angular_velocity: DVec3, dimensions: u8) -> DVec3 {
    let factor = if dimensions == 2 { 0.5 } else { 0.4 };
    factor * mass * radius * radius * angular_velocity
}

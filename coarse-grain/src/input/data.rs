//! `.data` of MercuryDPM and of our own, with `.fstat` and `.restart` beside it.

use std::path::{Path, PathBuf};

use mercury_common::error::FormatError;
use mercury_common::formats::data::{DataFrame, DataReader};
use mercury_common::formats::fstat::{FstatFrame, FstatReader};
use mercury_common::run_files::{Packing, plain_name, series_from};

use super::restart::{Restart, read_restart};
use super::{
    FrameChoice, Given, Needs, Skipped, States, ball, check, fstat, open_text, spin_of_ball,
};
use crate::CgError;
use crate::state::{Particles, Space, State};

/// `.data` files, one or a numbered series, and the `.fstat` files of the same numbers.
#[derive(Debug)]
pub struct DataSource {
    paths: Vec<PathBuf>,
    contacts: Vec<PathBuf>,
    restart: Option<Restart>,
    given: Given,
    needs: Needs,
    skipped: Skipped,
    notes: Vec<String>,
}

/// Relative difference of times that print the same in MercuryDPM's ten digits.
const SAME_TIME: f64 = 1e-8;

impl DataSource {
    pub(super) fn open(path: &Path, given: &Given, needs: Needs) -> Result<Self, CgError> {
        // Says at once what is wrong with the name.
        open_text(path)?;
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let paths = series_from(path);
        let beside = |ending: &str| -> PathBuf {
            let place = name.rfind(".data").unwrap_or(name.len());
            path.with_file_name(format!("{}{ending}", &name[..place]))
        };
        let mut notes = Vec::new();
        let restart = Some(beside(".restart"))
            .filter(|path| path.exists() && super::restart::is_of_mercury_dpm(path))
            .map(|path| read_restart(&path));
        let restart = match restart {
            Some(Ok(restart)) => {
                notes.extend(restart.notes.iter().cloned());
                Some(restart)
            }
            // The restart file is not needed where densities are given.
            Some(Err(error)) if given.density.is_some() || !given.densities.is_empty() => {
                notes.push(format!(
                    "fixed particles and periodic faces are not known: {error}"
                ));
                None
            }
            Some(Err(error)) => return Err(error.into()),
            None => None,
        };
        let mut contacts = Vec::new();
        if let Some(fstat) = &given.fstat {
            open_text(fstat)?;
            contacts.push(fstat.clone());
        } else {
            for path in &paths {
                contacts.extend(twin_of(path));
            }
        }
        let source = Self {
            paths,
            contacts,
            restart,
            given: given.clone(),
            needs,
            skipped: Skipped::default(),
            notes,
        };
        source.refuse_what_is_missing(&beside(".fstat"))?;
        Ok(source)
    }

    fn refuse_what_is_missing(&self, fstat: &Path) -> Result<(), CgError> {
        let path = self.path().display();
        if self.needs.couples {
            return Err(CgError::Input(format!(
                "{path}: .fstat files have no torques, so couples of contacts cannot be known\nhelp: the Arrow frames of a run have them"
            )));
        }
        if self.needs.mass
            && self.given.density.is_none()
            && self.given.densities.is_empty()
            && self.restart.is_none()
        {
            return Err(CgError::Input(format!(
                "{path}: .data files have no masses\nhelp: --density 2500 gives them (kg/m^3; discs of two dimensions: kg/m^2), or --density INDEX=RHO for each material"
            )));
        }
        if self.needs.contacts && self.contacts.is_empty() {
            let fstat = fstat.display();
            return Err(CgError::Input(format!(
                "{fstat}: there is no such file; fields of contacts need it\nhelp: --fstat FILE names it, --fields chooses fields without contacts"
            )));
        }
        Ok(())
    }

    pub(super) fn path(&self) -> &Path {
        self.paths.first().map_or(Path::new(""), PathBuf::as_path)
    }

    pub(super) fn has_contacts(&self) -> bool {
        !self.contacts.is_empty()
    }

    pub(super) fn notes(&self) -> &[String] {
        &self.notes
    }

    pub(super) fn skipped(&self) -> &Skipped {
        &self.skipped
    }

    pub(super) fn states(&self, choice: FrameChoice) -> States<'_> {
        let numbered = self.frames().enumerate();
        let mut twin = Twin::new(if self.needs.contacts {
            self.contacts.clone()
        } else {
            Vec::new()
        });
        if choice == FrameChoice::Last {
            let last = move || {
                let (mut last, mut damage) = (None, None);
                for (number, item) in numbered {
                    match item {
                        // The contacts are read along: they cannot be found from the end.
                        Ok(frame) => match self.state(number, frame, &mut twin) {
                            Ok(Some(state)) => last = Some(Ok(state)),
                            Ok(None) => {}
                            Err(error) => damage = Some(Err(error)),
                        },
                        Err(error) => damage = Some(Err(error.into())),
                    }
                }
                last.into_iter().chain(damage)
            };
            return Box::new(std::iter::once_with(last).flatten());
        }
        let mut stopped = false;
        let wanted = numbered.take_while(move |(number, _)| !choice.ends_before(*number));
        let states = wanted.filter_map(move |(number, item)| match item {
            Ok(frame) if choice.has(number) => self.state(number, frame, &mut twin).transpose(),
            Ok(_) => None,
            Err(error) => Some(Err(error.into())),
        });
        Box::new(states.take_while(move |item| !std::mem::replace(&mut stopped, item.is_err())))
    }

    fn frames(&self) -> impl Iterator<Item = Result<DataFrame, FormatError>> + Send + '_ {
        let mut stopped = false;
        self.paths
            .iter()
            .flat_map(|path| {
                let (reader, failed) = match open_text(path) {
                    Ok(input) => (Some(DataReader::new(input, path)), None),
                    Err(error) => (None, Some(Err(error))),
                };
                reader.into_iter().flatten().chain(failed)
            })
            .take_while(move |item| !std::mem::replace(&mut stopped, item.is_err()))
    }

    fn density(&self, material: u32) -> Option<f64> {
        let of_restart = |restart: &Restart| restart.densities.get(material as usize).copied();
        self.given
            .densities
            .get(&material)
            .copied()
            .or(self.given.density)
            .or_else(|| self.restart.as_ref().and_then(of_restart))
    }

    fn state(
        &self,
        number: usize,
        frame: DataFrame,
        twin: &mut Twin,
    ) -> Result<Option<State>, CgError> {
        let path = self.path().display().to_string();
        let wrong = |found: String| {
            CgError::Input(format!(
                "{path}: frame {number} at t = {}: {found}",
                frame.time
            ))
        };
        let dimensions = self
            .restart
            .as_ref()
            .map_or(frame.dimensions, |restart| restart.particle_dimensions);
        let mut space = Space {
            min: frame.min,
            max: frame.max,
            periodic: [false; 3],
            dimensions: frame.dimensions,
        };
        if let Some(Restart { state, .. }) = &self.restart {
            for axis in (0..3).filter(|&axis| state.space.periodic[axis]) {
                space.periodic[axis] = true;
                (space.min[axis], space.max[axis]) = (state.space.min[axis], state.space.max[axis]);
            }
        }
        let rows = &frame.particles;
        let before = twin.particles.replace(rows.len());
        if let Some(before) = before.filter(|&before| self.needs.identity && rows.len() < before) {
            return Err(wrong(format!(
                "{} particles, {before} in the frame before: .data files do not say which particles are missing, so \
                displacements cannot be known\nhelp: the Arrow frames of a run say it",
                rows.len()
            )));
        }
        let mut particles = Particles::default();
        for (k, row) in rows.iter().enumerate() {
            let whole =
                row.info >= 0.0 && row.info.fract() == 0.0 && row.info <= f64::from(u32::MAX);
            let material = if whole { row.info as u32 } else { 0 };
            let id = k as u32;
            let fixed = self
                .given
                .fixed
                .iter()
                .any(|&(from, to)| (from..=to).contains(&id))
                || self
                    .restart
                    .as_ref()
                    .is_some_and(|restart| restart.fixed(k));
            let volume = ball(row.radius, dimensions);
            particles.id.push(id);
            particles.material.push(material);
            particles.flowing.push(!fixed);
            particles.position.push(row.position);
            particles.velocity.push(row.velocity);
            particles.volume.push(volume);
            particles.radius.push(row.radius);
            particles.angular_velocity.push(row.angular_velocity);
            if let Some(density) = self.density(material) {
                let mass = density * volume;
                particles.mass.push(mass);
                particles.spin.push(spin_of_ball(
                    mass,
                    row.radius,
                    row.angular_velocity,
                    dimensions,
                ));
            } else if self.needs.mass {
                let help = format!("help: --density {material}=RHO, or --density RHO for all");
                return Err(wrong(format!(
                    "no density of material {material} (particle {k})\n{help}"
                )));
            }
        }
        if particles.mass.len() < rows.len() {
            particles.mass.clear();
            particles.spin.clear();
        }
        let contacts = match twin.at(frame.time) {
            Ok(Some(contacts)) => Some(fstat::contacts(contacts, &particles).map_err(&wrong)?),
            Ok(None) if self.needs.contacts => {
                self.skipped.add(frame.time, twin.last_time);
                return Ok(None);
            }
            Ok(None) => None,
            Err(error) if self.needs.contacts => return Err(error.into()),
            Err(_) => None,
        };
        let state = State {
            time: frame.time,
            space,
            particles,
            contacts,
            displacement: None,
        };
        check(&state, &path)?;
        Ok(Some(state))
    }
}

/// The file of contacts beside one of particles: packed alike, plain, or packed in another way.
fn twin_of(path: &Path) -> Option<PathBuf> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let (plain, packing) = plain_name(&name);
    let (stem, ending) = plain.split_at(plain.rfind(".data")?);
    let number = ending.strip_prefix(".data")?;
    let endings = Packing::ALL.map(Packing::ending);
    [packing, ""]
        .into_iter()
        .chain(endings)
        .map(|packing| path.with_file_name(format!("{stem}.fstat{number}{packing}")))
        .find(|path| path.exists())
}

/// The file of contacts, read as far as the particles have come.
struct Twin {
    paths: std::vec::IntoIter<PathBuf>,
    reader: Option<FstatReader<Box<dyn std::io::BufRead + Send>>>,
    current: Option<FstatFrame>,
    last_time: Option<f64>,
    /// Number of particles of the frame before.
    particles: Option<usize>,
}

impl Twin {
    fn new(paths: Vec<PathBuf>) -> Self {
        Self {
            paths: paths.into_iter(),
            reader: None,
            current: None,
            last_time: None,
            particles: None,
        }
    }

    fn next(&mut self) -> Option<Result<FstatFrame, FormatError>> {
        loop {
            if let Some(item) = self.reader.as_mut().and_then(Iterator::next) {
                return Some(item);
            }
            let path = self.paths.next()?;
            match open_text(&path) {
                Ok(input) => self.reader = Some(FstatReader::new(input, path)),
                Err(error) => return Some(Err(error)),
            }
        }
    }

    /// The contacts of a time, if there are any; times only go forward.
    fn at(&mut self, time: f64) -> Result<Option<&FstatFrame>, FormatError> {
        let tolerance = SAME_TIME * time.abs().max(f64::MIN_POSITIVE);
        while self
            .current
            .as_ref()
            .is_none_or(|frame| frame.time < time - tolerance)
        {
            match self.next() {
                Some(frame) => {
                    let frame = frame?;
                    self.last_time = Some(frame.time);
                    self.current = Some(frame);
                }
                None => return Ok(None),
            }
        }
        Ok(self
            .current
            .as_ref()
            .filter(|frame| (frame.time - time).abs() <= tolerance))
    }
}

//! Checkpoints of another run: which there are, and whether they are whole.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use mercury_common::particle_properties::PARTICLE_PROPERTIES;
use mercury_common::scene::{Located, SceneError};

use crate::plan::checkpoint_identity::{Head, POSITIONS, checkpoint_paths};
use mercury_engine::bodies::BodyStep;
use mercury_engine::contact::parameter::short;
use mercury_engine::forces::SavedSlots;
use mercury_engine::liquid::{SavedLiquid, Sum};
use mercury_engine::spray::SprayState;
use mercury_engine::state::{
    DecodeError, Decoder, FIXED, PEBBLE, Particles, Sections, inverse_inertia_factor,
};

/// The state that a run left.
pub(super) struct State {
    pub(super) path: PathBuf,
    pub(super) head: Head,
    pub(super) checksum: u32,
    pub(super) kick_due: bool,
    pub(super) particles: Particles,
    pub(super) pairs: SavedSlots,
    pub(super) near_walls: SavedSlots,
    pub(super) liquid_left: LiquidLeft,
}

/// Liquid of another run that is neither on its grains nor in its bridges, m^3: it does not go on.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LiquidLeft {
    on_walls: f64,
    in_flight: f64,
}

impl LiquidLeft {
    /// From the sections of a state behind its contacts.
    fn of(sections: &Sections) -> Result<Self, DecodeError> {
        let has = |name: &str| sections.iter().any(|(found, _)| found == name);
        let mut left = Self::default();
        if has("liquid") {
            let saved: SavedLiquid = sections.get("liquid")?;
            left.on_walls = summed(saved.walls.iter().flatten().copied());
        }
        if has("sprays") {
            let saved: SprayState = sections.get("sprays")?;
            left.in_flight = summed(saved.droplets.iter().map(|droplet| droplet.volume));
        }
        Ok(left)
    }

    /// Warning of it, if there is any.
    pub(super) fn warning(&self, key: &str) -> Option<String> {
        let Self {
            on_walls,
            in_flight,
        } = *self;
        let parts = [
            (
                on_walls,
                "on walls",
                "walls begin with the `film` of this scene",
            ),
            (in_flight, "in droplets", "sprays begin without droplets"),
        ];
        let there: Vec<_> = parts.iter().filter(|(volume, ..)| *volume > 0.0).collect();
        let volumes: Vec<String> = (there.iter())
            .map(|(volume, place, _)| format!("{} m3 {place}", short(*volume)))
            .collect();
        let begins: Vec<&str> = there.iter().map(|(.., begin)| *begin).collect();
        (!there.is_empty()).then(|| {
            format!(
                "{key}: liquid of that run does not go on: {}; {}",
                volumes.join(", "),
                begins.join(", ")
            )
        })
    }
}

fn summed(volumes: impl Iterator<Item = f64>) -> f64 {
    let mut sum = Sum::default();
    volumes.for_each(|volume| sum.add(volume));
    sum.value()
}

/// The newest whole checkpoint in a folder; what is damaged draws a warning.
pub(super) fn newest(
    folder: &Located<PathBuf>,
    warnings: &mut Vec<String>,
) -> Result<State, SceneError> {
    let Some(prefix) = prefix(folder)? else {
        return Err(folder
            .error(format!("there is no checkpoint in {}", folder.display()))
            .with_help(
                "a run writes one at its end and when it is stopped, but for --checkpoint-every never; `at` starts from a frame",
            ));
    };
    let (states, damaged) = checkpoints(folder, &prefix)?;
    let Some(newest) = states.into_iter().max_by_key(|state| state.head.step) else {
        let message = format!(
            "no checkpoint of that run can be used: {}",
            damaged.join("; ")
        );
        return Err(folder.error(message));
    };
    warn_of_damaged(folder, &damaged, warnings);
    Ok(newest)
}

/// The whole checkpoints in a folder, none if there are none; what is damaged draws a warning.
pub(super) fn all_states(
    folder: &Located<PathBuf>,
    warnings: &mut Vec<String>,
) -> Result<Vec<State>, SceneError> {
    let Some(prefix) = prefix(folder)? else {
        return Ok(Vec::new());
    };
    let (states, damaged) = checkpoints(folder, &prefix)?;
    warn_of_damaged(folder, &damaged, warnings);
    Ok(states)
}

fn warn_of_damaged(folder: &Located<PathBuf>, damaged: &[String], warnings: &mut Vec<String>) {
    let key = folder.place.key();
    warnings.extend(
        damaged
            .iter()
            .map(|what| format!("{key}: not used: {what}")),
    );
}

/// Prefix of the checkpoints in a folder; `None` if there are none.
fn prefix(folder: &Located<PathBuf>) -> Result<Option<String>, SceneError> {
    let failed = |error: std::io::Error| folder.error(format!("cannot be read: {error}"));
    let mut prefixes = BTreeSet::new();
    for entry in std::fs::read_dir(&folder.value).map_err(failed)? {
        let name = entry.map_err(failed)?.file_name();
        let name = name.to_string_lossy();
        let prefix = [".0.restart", ".1.restart"]
            .iter()
            .find_map(|end| name.strip_suffix(end));
        prefixes.extend(prefix.map(str::to_owned));
    }
    match Vec::from_iter(prefixes).as_slice() {
        [] => Ok(None),
        [prefix] => Ok(Some(prefix.clone())),
        several => Err(folder.error(format!(
            "there are checkpoints of several runs in {}: {}",
            folder.display(),
            several.join(", ")
        ))),
    }
}

/// The whole checkpoints of a run, and what is wrong with the others.
fn checkpoints(
    folder: &Located<PathBuf>,
    prefix: &str,
) -> Result<(Vec<State>, Vec<String>), SceneError> {
    let (mut states, mut damaged) = (Vec::new(), Vec::new());
    for path in checkpoint_paths(&folder.value, prefix) {
        if path.symlink_metadata().is_err() {
            continue;
        }
        folder.place.may_read(&path)?;
        match read(&path) {
            Ok(state) => states.push(state),
            Err(message) => damaged.push(format!("{}: {message}", path.display())),
        }
    }
    Ok((states, damaged))
}

/// Reads the part of a checkpoint that another run can start from.
fn read(path: &Path) -> Result<State, String> {
    let bytes = std::fs::read(path).map_err(|error| error.to_string())?;
    let checksum = crc32fast::hash(&bytes);
    let decode = || {
        let sections = Sections::take_from(&mut Decoder::new(&bytes)?, POSITIONS)?;
        drop(bytes);
        let (_, kick_due): (u64, bool) = sections.get("clock")?;
        Ok(State {
            path: path.to_owned(),
            head: sections.get("head")?,
            checksum,
            kick_due,
            particles: sections.get("particles")?,
            pairs: sections.get("pairs")?,
            near_walls: sections.get("near walls")?,
            liquid_left: LiquidLeft::of(&sections)?,
        })
    };
    let state: State = decode().map_err(|error: DecodeError| error.to_string())?;
    if is_consistent(&state) {
        Ok(state)
    } else {
        Err("its parts contradict each other".to_owned())
    }
}

/// Whether all indices lead somewhere.
fn is_consistent(state: &State) -> bool {
    let (head, particles) = (&state.head, &state.particles);
    let rows = particles.len();
    let is_row = |row: u32| (row as usize) < rows;
    let materials = head.materials.len();
    let mut records = particles.records.iter();
    let mut bodies = particles.bodies().iter();
    particles.is_consistent()
        && head.laws.len() == materials * materials
        && head.wall_materials.len() == head.walls.len()
        && (head.wall_materials.iter()).all(|&material| (material as usize) < materials)
        && records.all(|record| record.material.index() < materials)
        && bodies.all(|body| {
            (body.clump as usize) < head.clumps.len() && body.material.index() < materials
        })
        && (state.pairs.iter()).all(|slot| is_row(slot.row) && is_row(slot.partner))
        && state.near_walls.iter().all(|slot| is_row(slot.row))
}

/// Whether the values that a scene takes over for grains are valid, by the same rules as typed ones.
pub(super) fn is_finite(particles: &Particles) -> bool {
    let finite = |values: &[Option<f64>; 3]| values.iter().flatten().all(|value| value.is_finite());
    let is_size = |radius: f64| radius > 0.0 && radius.is_finite();
    let mut prescribed = particles.prescribed.iter();
    let mut prescribed_bodies = particles.bodies.iter().flat_map(|all| &all.prescribed);
    let values = PARTICLE_PROPERTIES
        .iter()
        .flat_map(|property| particles.columns.get(property.name));
    particles.records.iter().all(|record| {
        is_size(record.radius)
            && record.position.is_finite()
            && record.velocity.is_finite()
            && record.angular_velocity.is_finite()
    }) && particles.bodies().iter().all(|body| {
        is_size(body.radius)
            && body.position.is_finite()
            && body.velocity.is_finite()
            && body.orientation.is_finite()
            && body.angular_velocity.is_finite()
    }) && values.flatten().all(|value| value.is_finite())
        && prescribed.all(|one| finite(&one.velocity) && finite(&one.angular_velocity))
        && prescribed_bodies.all(|one| finite(&one.velocity) && finite(&one.angular_velocity))
}

/// Makes the second half kick of the last step, if it is still due: velocities then belong to the time of the positions.
pub(super) fn complete(state: &mut State) {
    if !std::mem::take(&mut state.kick_due) {
        return;
    }
    let (half, gravity) = (0.5 * state.head.time_step, state.head.gravity);
    let factor = inverse_inertia_factor(state.head.dimensions);
    let Particles {
        records,
        loads,
        bodies,
        prescribed,
        ..
    } = &mut state.particles;
    for (record, load) in records.iter_mut().zip(loads) {
        if record.flags & (FIXED | PEBBLE) == 0 {
            let per_torque = factor * record.inverse_mass / (record.radius * record.radius);
            record.velocity += (load.force * record.inverse_mass + gravity) * half;
            record.angular_velocity += load.torque * (per_torque * half);
        }
    }
    for prescribed in prescribed {
        let record = &mut records[prescribed.row.index()];
        for axis in 0..3 {
            if let Some(velocity) = prescribed.velocity[axis] {
                record.velocity[axis] = velocity;
            }
            if let Some(spin) = prescribed.angular_velocity[axis] {
                record.angular_velocity[axis] = spin;
            }
        }
    }
    if let Some(bodies) = bodies {
        let step = BodyStep {
            half,
            drift: 0.0,
            kicks: 1,
            gravity,
        };
        bodies.advance(records, &step, None);
    }
}

//! Starts from a state of another run: `[[particles]] run`, the last one or that of a time `at`.
//!
//! Grains keep their velocities and prescribed motion, contacts keep their histories: those between the grains of one run, and
//! those with walls that have the same name and number their features alike. The liquid of bridges that cannot go on goes to the films
//! of their grains and walls; films of walls and droplets begin as this scene says, and what that run had of them is named. Grains are numbered anew, particles before bodies,
//! so the slots of the other run are translated row by row; the first candidate list carries their histories over as every later
//! one does.

mod contacts;
mod grains;
mod state;

use std::path::PathBuf;

use mercury_common::particle_properties::PropertyValue;
use mercury_common::readable::rounded;
use mercury_common::scene::{Located, Scene, SceneError};

use super::checkpoint_identity::Head;
use super::start_from_frame::{EarlierWalls, Frames, Grains};
use super::{NewBody, NewParticle};
use mercury_engine::bodies::Clump;
use mercury_engine::forces::SavedSlots;

pub(super) use contacts::{Here, carried};
use grains::of_state;
use state::{LiquidLeft, State, all_states, newest};

/// A run from which this one starts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StartedFrom {
    /// Its folder.
    pub folder: PathBuf,
    /// Its files that are used.
    pub files: Vec<PathBuf>,
    /// The key of the scene that names it.
    pub key: String,
    /// Its name, and a checksum of its state: as [`Statement::entries`](mercury_common::scene::Statement::entries) gives for
    /// files.
    pub statement: (String, String),
}

/// A state of a run, as particles of this scene.
pub(super) struct Earlier {
    folder: PathBuf,
    files: Vec<PathBuf>,
    /// Whether it is a frame, which has no contacts.
    is_frame: bool,
    /// The key in this scene.
    key: String,
    /// Of the whole file.
    checksum: u32,
    head: Head,
    /// Of each row there.
    rows: Vec<EarlierRow>,
    pairs: SavedSlots,
    near_walls: SavedSlots,
    liquid_left: LiquidLeft,
    /// Particles, in the order of their ids there, with the properties that are not the default.
    pub(super) particles: Vec<(NewParticle, Vec<PropertyValue>)>,
    /// Bodies, in the order of their ids there, with theirs.
    pub(super) bodies: Vec<(NewBody, Vec<PropertyValue>)>,
    /// Where the first of each begin among those of this scene.
    pub(super) first: (usize, usize),
}

/// A row of another run.
#[derive(Debug, Clone, Copy)]
struct EarlierRow {
    grain: Grain,
    /// Its material there, and here.
    material: [usize; 2],
}

/// A particle of [`Earlier::particles`], or a pebble of one of [`Earlier::bodies`].
#[derive(Debug, Clone, Copy)]
enum Grain {
    Particle(usize),
    Pebble(usize, usize),
}

/// Reads the last state of the run in `folder`, or the state nearest to the time `at` (s) with the walls of then. `clumps`: the templates
/// of this scene.
pub(super) fn take_up(
    folder: &Located<PathBuf>,
    at: Option<&Located<f64>>,
    scene: &Scene,
    clumps: &[Clump],
    warnings: &mut Vec<String>,
) -> Result<(Earlier, EarlierWalls), SceneError> {
    match at {
        None => {
            let state = newest(folder, warnings)?;
            let earlier = of_state(state, folder, scene, clumps)?;
            Ok((earlier, EarlierWalls::default()))
        }
        Some(at) => nearest(folder, at, scene, clumps, warnings),
    }
}

/// The state of the run in `folder` that is nearest to a time. A checkpoint goes before a frame where it is as near, as it has contacts;
/// but only where a frame says where the walls were then.
fn nearest(
    folder: &Located<PathBuf>,
    at: &Located<f64>,
    scene: &Scene,
    clumps: &[Clump],
    warnings: &mut Vec<String>,
) -> Result<(Earlier, EarlierWalls), SceneError> {
    let frames = Frames::nearest(folder, **at)?;
    let states = all_states(folder, warnings)?;
    let far = |time: f64| (time - **at).abs();
    let nearest = |a: &State, b: &State| far(a.head.time()).total_cmp(&far(b.head.time()));
    let of_states = states.iter().map(|state| state.head.time());
    let last_frame = frames.iter().map(|frames| frames.last);
    let latest = of_states
        .chain(last_frame)
        .fold(f64::NEG_INFINITY, f64::max);
    let state = states.into_iter().min_by(nearest);
    let is_wanted = |state: &State, frames: &Frames| {
        state.head.step == frames.step || far(state.head.time()) < far(frames.time)
    };
    let (earlier, walls) = match (frames, state) {
        (None, None) => {
            let message = format!(
                "there is neither a frame nor a checkpoint in {}",
                folder.display()
            );
            return Err(folder.error(message));
        }
        (None, Some(state)) => {
            if !state.head.walls.is_empty() {
                warnings.push(format!(
                    "{}: no frame of that run says where its walls were: they stand where this scene has them",
                    folder.place.key()
                ));
            }
            (
                of_state(state, folder, scene, clumps)?,
                EarlierWalls::default(),
            )
        }
        (Some(frames), Some(state))
            if is_wanted(&state, &frames)
                && let Some((walls, file)) = frames.walls(folder, state.head.step)? =>
        {
            let mut earlier = of_state(state, folder, scene, clumps)?;
            earlier.files.push(file);
            (earlier, walls)
        }
        (Some(frames), Some(state))
            if is_wanted(&state, &frames) && state.head.walls.is_empty() =>
        {
            (
                of_state(state, folder, scene, clumps)?,
                EarlierWalls::default(),
            )
        }
        (Some(frames), _) => {
            let grains = frames.grains(folder, scene, clumps, warnings)?;
            let mut earlier = Earlier::of_frame(grains, folder);
            let walls = frames.walls(folder, frames.step)?;
            let (walls, file) = walls.unzip();
            earlier.files.extend(file);
            (earlier, walls.unwrap_or_default())
        }
    };
    let time = earlier.head.time();
    // Times are sums of steps.
    if **at > latest * (1.0 + 1e-9) {
        warnings.push(format!(
            "{}: that run has no state behind t = {} s, from which this one starts",
            at.place.key(),
            rounded(time, 12)
        ));
    }
    Ok((earlier, walls))
}

impl Earlier {
    /// Of a frame.
    fn of_frame(grains: Grains, folder: &Located<PathBuf>) -> Self {
        let Grains {
            files,
            title,
            time,
            step,
            checksum,
            particles,
            bodies,
        } = grains;
        let head = Head {
            title,
            step,
            time_step: if step > 0 { time / step as f64 } else { 0.0 },
            ..Head::default()
        };
        Self {
            folder: folder.value.clone(),
            files,
            is_frame: true,
            key: folder.place.key().to_owned(),
            checksum,
            head,
            rows: Vec::new(),
            pairs: SavedSlots::new(Vec::new()),
            near_walls: SavedSlots::new(Vec::new()),
            particles,
            bodies,
            first: (0, 0),
            liquid_left: LiquidLeft::default(),
        }
    }

    /// For the statement of the scene: so that a run that goes on finds the same start.
    pub(super) fn started_from(&self) -> StartedFrom {
        let state = format!("step {}, checksum {:08x}", self.head.step, self.checksum);
        StartedFrom {
            folder: self.folder.clone(),
            files: self.files.clone(),
            key: self.key.clone(),
            statement: (format!("state of {}", self.key), state),
        }
    }
}

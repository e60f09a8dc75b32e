//! Starts from a state of another run: `[[particles]] run`, the last one or that of a time `at`.
//!
//! Grains keep their velocities and prescribed motion, contacts keep their histories: those between the grains of one run, and
//! those with walls that have the same name and number their features alike. The liquid of bridges that cannot go on goes to the films
//! of their grains and walls; films of walls and droplets begin as this scene says, and what that run had of them is named. Grains are numbered anew, particles before bodies,
//! so the slots of the other run are translated row by row; the first candidate list carries their histories over as every later
//! one does.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use mercury_common::formats::clump::Pebble;
use mercury_common::particle_properties::{
    OfClump, PARTICLE_PROPERTIES, ParticleProperty, PropertyValue,
};
use mercury_common::readable::{printable, rounded};
use mercury_common::scene::{Dimensions, Located, Scene, SceneError};

use super::checkpoint_identity::{Head, POSITIONS, checkpoint_paths};
use super::particles::StartingParticles;
use super::start_from_frame::{EarlierWalls, Frames, Grains};
use super::{NewBody, NewParticle, PrescribedMotion};
use mercury_engine::bodies::{BodyStep, Clump};
use mercury_engine::contact::adhesion::liquid::{saved_numbers, saved_volume};
use mercury_engine::contact::parameter::short;
use mercury_engine::contact::registry::LawTable;
use mercury_engine::forces::{SavedSlot, SavedSlots, SlotState, contact_loop};
use mercury_engine::liquid::{SavedLiquid, Sum};
use mercury_engine::spray::SprayState;
use mercury_engine::state::{
    BodyPebble, DecodeError, Decoder, FIXED, MaterialIndex, PEBBLE, Particles, Prescribed,
    PrescribedBody, Sections, inverse_inertia_factor,
};
use mercury_engine::walls::{Wall, WallFilmPlan, film_at};

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

/// The state that a run left.
struct State {
    path: PathBuf,
    head: Head,
    checksum: u32,
    kick_due: bool,
    particles: Particles,
    pairs: SavedSlots,
    near_walls: SavedSlots,
    liquid_left: LiquidLeft,
}

/// Liquid of another run that is neither on its grains nor in its bridges, m^3: it does not go on.
#[derive(Debug, Clone, Copy, Default)]
struct LiquidLeft {
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
    fn warning(&self, key: &str) -> Option<String> {
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
    let (states, damaged) = match prefix(folder)? {
        Some(prefix) => checkpoints(folder, &prefix)?,
        None => (Vec::new(), Vec::new()),
    };
    warn_of_damaged(folder, &damaged, warnings);
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

/// A checkpoint as particles of this scene.
fn of_state(
    mut state: State,
    folder: &Located<PathBuf>,
    scene: &Scene,
    clumps: &[Clump],
) -> Result<Earlier, SceneError> {
    let dimensions = match scene.domain.dimensions {
        Dimensions::Two => 2,
        Dimensions::Three => 3,
    };
    if state.head.dimensions != dimensions {
        return Err(folder.error(format!(
            "that run has {} dimensions, this scene {dimensions}",
            state.head.dimensions
        )));
    }
    complete(&mut state);
    if !is_finite(&state.particles) {
        let error = folder.error(
            "a position, size, velocity or property in the last state of that run is not a finite number",
        );
        return Err(
            error.with_help("it went wrong before its end: stop it earlier, and start from there")
        );
    }
    let State {
        path,
        head,
        checksum,
        particles: state,
        pairs,
        near_walls,
        liquid_left,
        ..
    } = state;
    let material = |name: &String| {
        let mut known = scene.materials.iter();
        let found = known.position(|material| material.name.value == *name);
        found.ok_or_else(|| {
            let message = format!("there are particles of the material `{name}` in that run, and no such material in this scene");
            folder.error(message).with_help(format!("add [materials.{name}]"))
        })
    };
    // Only the materials of particles: walls may have had others, and bodies follow their clump in this scene.
    let spheres = state.records.iter();
    let used: BTreeSet<usize> = spheres
        .filter(|record| record.flags & PEBBLE == 0)
        .map(|record| record.material.index())
        .collect();
    let materials = (head.materials.iter().enumerate())
        .map(|(index, name)| match used.contains(&index) {
            true => material(name),
            false => Ok(usize::MAX),
        })
        .collect::<Result<Vec<usize>, SceneError>>()?;

    let prescribed = state.prescribed.iter();
    let prescribed: HashMap<usize, &Prescribed> =
        prescribed.map(|one| (one.row.index(), one)).collect();
    let mut rows = vec![None; state.len()];
    let mut particles = Vec::new();
    for row in state.rows_by_id() {
        let row = row as usize;
        let record = &state.records[row];
        if record.flags & PEBBLE != 0 {
            continue;
        }
        let there = record.material.index();
        rows[row] = Some(EarlierRow {
            grain: Grain::Particle(particles.len()),
            material: [there, materials[there]],
        });
        let prescribed = prescribed.get(&row);
        let particle = NewParticle {
            velocity: record.velocity,
            angular_velocity: record.angular_velocity,
            fixed: record.flags & FIXED != 0,
            prescribed: prescribed
                .and_then(|one| PrescribedMotion::boxed(one.velocity, one.angular_velocity)),
            ..NewParticle::at(
                record.position,
                record.radius,
                MaterialIndex::new(materials[there] as u32),
            )
        };
        particles.push((particle, properties(&state, &[row])));
    }
    let mut bodies = Vec::new();
    let prescribed_bodies = state.bodies.iter().flat_map(|all| &all.prescribed);
    let prescribed_bodies: HashMap<usize, &PrescribedBody> = prescribed_bodies
        .map(|one| (one.body.index(), one))
        .collect();
    for (index, body) in state.bodies().iter().enumerate() {
        // There are bodies.
        let Some(all) = &state.bodies else { break };
        let pebbles = &all.pebbles[body.pebbles()];
        let name = &head.clumps[body.clump as usize];
        let Some(clump) = clumps.iter().position(|clump| clump.name == *name) else {
            let message = format!(
                "there are bodies of the clump `{name}` in that run, and no such clump in this scene"
            );
            return Err(folder
                .error(message)
                .with_help(format!("add [clumps.{name}]")));
        };
        let template = &clumps[clump];
        let mut scale = body.radius / template.radius;
        if (scale - 1.0).abs() < 1e-12 {
            // But for round-off of the division.
            scale = 1.0;
        }
        let same = |(here, there): (&Pebble, &BodyPebble)| {
            let radius = state.records[there.row.index()].radius;
            let off = (here.position * scale - there.offset).length();
            (here.radius * scale - radius).abs().max(off) <= 1e-9 * body.radius
        };
        if pebbles.len() != template.pebbles.len()
            || !template.pebbles.iter().zip(pebbles).all(same)
        {
            return Err(folder.error(format!("the clump `{name}` has other pebbles in that run")));
        }
        for (number, pebble) in pebbles.iter().enumerate() {
            rows[pebble.row.index()] = Some(EarlierRow {
                grain: Grain::Pebble(index, number),
                material: [body.material.index(), template.material.index()],
            });
        }
        let prescribed = prescribed_bodies.get(&index);
        let of_body: Vec<usize> = pebbles.iter().map(|pebble| pebble.row.index()).collect();
        let body = NewBody {
            scale,
            orientation: body.orientation,
            velocity: body.velocity,
            angular_velocity: body.angular_velocity,
            fixed: body.is_fixed(),
            prescribed_velocity: prescribed.map_or([None; 3], |one| one.velocity),
            prescribed_angular_velocity: prescribed.map_or([None; 3], |one| one.angular_velocity),
            ..NewBody::at(body.position, clump as u32)
        };
        bodies.push((body, properties(&state, &of_body)));
    }
    let rows: Option<Vec<EarlierRow>> = rows.into_iter().collect();
    Ok(Earlier {
        folder: folder.value.clone(),
        files: vec![path],
        is_frame: false,
        key: folder.place.key().to_owned(),
        checksum,
        head,
        rows: rows.ok_or_else(|| folder.error("a pebble of that run is of no body"))?,
        pairs,
        near_walls,
        liquid_left,
        particles,
        bodies,
        first: (0, 0),
    })
}

/// Properties of a particle, or of a body with these rows, that are not the default.
fn properties(state: &Particles, rows: &[usize]) -> Vec<PropertyValue> {
    let value = |property: &'static ParticleProperty| {
        let column = state.columns.get(property.name)?;
        let sum: f64 = rows.iter().map(|&row| column[row]).sum();
        let value = match property.of_clump {
            OfClump::Sum => sum,
            OfClump::Mean => sum / rows.len() as f64,
        };
        property.differs(value).then_some((property, value))
    };
    PARTICLE_PROPERTIES.iter().filter_map(value).collect()
}

/// The newest whole checkpoint in a folder; what is damaged draws a warning.
fn newest(folder: &Located<PathBuf>, warnings: &mut Vec<String>) -> Result<State, SceneError> {
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
    let decode = || {
        let mut decoder = Decoder::new(&bytes)?;
        let head = decoder.section("head")?;
        decoder.skip("run")?;
        let (_, kick_due): (u64, bool) = decoder.section("clock")?;
        decoder.skip("cell")?;
        Ok(State {
            path: path.to_owned(),
            head,
            checksum: crc32fast::hash(&bytes),
            kick_due,
            particles: decoder.section("particles")?,
            pairs: {
                decoder.skip("walls")?;
                decoder.section("pairs")?
            },
            near_walls: decoder.section("near walls")?,
            liquid_left: LiquidLeft::of(&Sections::take_from(&mut decoder, POSITIONS)?)?,
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
fn is_finite(particles: &Particles) -> bool {
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
fn complete(state: &mut State) {
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

/// The data that the translation of a scene's contacts needs.
pub(super) struct Here<'a> {
    /// Particles of this scene.
    pub(super) particles: usize,
    /// Its bodies.
    pub(super) bodies: &'a [NewBody],
    pub(super) clumps: &'a [Clump],
    pub(super) walls: &'a [Wall],
    /// Films of its walls.
    pub(super) wall_films: &'a [Option<WallFilmPlan>],
    pub(super) laws: &'a LawTable,
}

impl Here<'_> {
    /// The first id of each body: they follow those of the particles.
    fn first_pebbles(&self) -> Vec<usize> {
        let mut next = self.particles;
        let first = |body: &NewBody| {
            let first = next;
            next += self.clumps[body.clump as usize].pebbles.len();
            first
        };
        self.bodies.iter().map(first).collect()
    }
}

/// Liquid of bridges that do not go on.
#[derive(Debug, Default)]
pub(super) struct Released {
    /// By the number of the particle in this scene, m^3.
    particles: BTreeMap<usize, Sum>,
    /// By that of the body.
    bodies: BTreeMap<usize, Sum>,
    /// By the wall and the place on it.
    walls: BTreeMap<(usize, usize), Sum>,
}

impl Released {
    fn give_grain(&mut self, run: &Earlier, row: u32, volume: f64) {
        let sum = match run.rows[row as usize].grain {
            Grain::Particle(index) => self.particles.entry(run.first.0 + index),
            Grain::Pebble(body, _) => self.bodies.entry(run.first.1 + body),
        };
        sum.or_default().add(volume);
    }

    /// A grain at a wall takes all but what a film of the wall keeps.
    fn at_wall(
        &mut self,
        run: &Earlier,
        here: &Here<'_>,
        slot: &SavedSlot<'_>,
        wall: Option<usize>,
        volume: f64,
    ) {
        let film = wall.and_then(|wall| {
            let film = here.wall_films.get(wall)?.as_ref()?;
            let place = film_at(&here.walls[wall].shape, slot.feature)?;
            (place < film.volumes.len()).then_some((wall, place, film.keeps))
        });
        let kept = film.map_or(0.0, |(.., keeps)| keeps * volume);
        if let Some((wall, place, _)) = film {
            self.walls.entry((wall, place)).or_default().add(kept);
        }
        self.give_grain(run, slot.row, volume - kept);
    }

    /// Adds it to the films of the start.
    pub(super) fn pour(
        self,
        start: &mut StartingParticles,
        wall_films: &mut [Option<WallFilmPlan>],
    ) {
        let grains = |sums: BTreeMap<usize, Sum>| {
            let values = sums.into_iter();
            values.map(|(number, sum)| (number, sum.value()))
        };
        start.add_films(grains(self.particles), grains(self.bodies));
        for ((wall, place), sum) in self.walls {
            if let Some(Some(film)) = wall_films.get_mut(wall) {
                film.volumes[place] += sum.value();
            }
        }
    }
}

/// The contacts of all runs in `earlier` in this scene, and the liquid of those that do not go on; a remark on each run, and a warning of
/// liquid that is lost. No contacts if there is no such run.
pub(super) fn carried(
    earlier: &[Earlier],
    here: &Here<'_>,
    remarks: &mut Vec<String>,
    warnings: &mut Vec<String>,
) -> (Option<mercury_engine::physics::Carried>, Released) {
    let mut released = Released::default();
    if earlier.is_empty() {
        return (None, released);
    }
    let numbers = contact_loop(here.laws).0.layout().numbers;
    let first_pebbles = here.first_pebbles();
    let names = here.laws.names_of_pairs();
    let (mut pairs, mut near_walls): (Vec<SavedSlot<'_>>, Vec<SavedSlot<'_>>) =
        (Vec::new(), Vec::new());
    for run in earlier {
        let row = |row: u32| match run.rows[row as usize].grain {
            Grain::Particle(index) => run.first.0 + index,
            Grain::Pebble(body, pebble) => first_pebbles[run.first.1 + body] + pebble,
        } as u32;
        // Histories go on under laws of the same names; the numbers in these may be others.
        let is_alike = |[a, b]: [usize; 2], [here_a, here_b]: [usize; 2]| {
            let then = &run.head.laws[a * run.head.materials.len() + b];
            !then.is_empty() && names[here_a * here.laws.materials + here_b] == *then
        };
        let (mut kept, mut anew) = (0u64, 0u64);
        let of_bridge = saved_numbers(run.head.laws.iter().map(String::as_str));
        let (mut bridges, mut liquid) = (0u64, Sum::default());
        let mut ended = |slot: &SavedSlot<'_>| {
            let volume = saved_volume(slot.history, of_bridge);
            bridges += u64::from(volume > 0.0);
            liquid.add(volume);
            volume
        };
        for slot in run
            .pairs
            .iter()
            .filter(|slot| slot.state != SlotState::Near)
        {
            let [a, b] = [slot.row, slot.partner].map(|row| run.rows[row as usize].material);
            if run.pairs.numbers() != numbers || !is_alike([a[0], b[0]], [a[1], b[1]]) {
                anew += 1;
                let volume = ended(&slot);
                if volume > 0.0 {
                    let half = 0.5 * volume;
                    released.give_grain(run, slot.row, half);
                    released.give_grain(run, slot.partner, volume - half);
                }
                continue;
            }
            kept += 1;
            pairs.push(SavedSlot {
                row: row(slot.row),
                partner: row(slot.partner),
                ..slot
            });
        }
        let walls: Vec<Option<usize>> = (run.head.walls.iter())
            .map(|(name, numbering)| {
                here.walls.iter().position(|wall| {
                    wall.name == *name && wall.shape.feature_numbering() == *numbering
                })
            })
            .collect();
        for slot in (run.near_walls.iter()).filter(|slot| slot.state != SlotState::Near) {
            let [material, here_material] = run.rows[slot.row as usize].material;
            // Behind the walls come membranes, which are others here.
            let found = walls.get(slot.partner as usize).copied().flatten();
            let wall = found.filter(|&wall| {
                let of_wall = here.walls[wall].material.index();
                let there = run.head.wall_materials[slot.partner as usize] as usize;
                run.near_walls.numbers() == numbers
                    && is_alike([material, there], [here_material, of_wall])
            });
            let Some(wall) = wall else {
                anew += 1;
                let volume = ended(&slot);
                if volume > 0.0 {
                    released.at_wall(run, here, &slot, found, volume);
                }
                continue;
            };
            kept += 1;
            near_walls.push(SavedSlot {
                row: row(slot.row),
                partner: wall as u32,
                ..slot
            });
        }
        let mut remark = format!(
            "{}: {} particles and {} bodies of `{}` at t = {} s, {kept} contacts go on",
            run.key,
            run.particles.len(),
            run.bodies.len(),
            printable(&run.head.title),
            rounded(run.head.time(), 12)
        );
        if anew > 0 {
            remark += &format!(", {anew} begin anew: their law or their wall is another one here");
        }
        if bridges > 0 {
            remark += &format!(
                "; the liquid of {bridges} bridges among these, {} m3, goes to the films of their grains and walls",
                short(liquid.value())
            );
        }
        if run.is_frame {
            remark += "; a frame has no contacts, all begin anew";
        }
        remarks.push(remark);
        warnings.extend(run.liquid_left.warning(&run.key));
    }
    let sorted = |mut slots: Vec<SavedSlot<'_>>, like: &SavedSlots| {
        slots.sort_by_key(|slot| (slot.row, slot.partner, slot.image));
        let mut all = like.emptied();
        all.reserve(slots.len());
        for slot in slots {
            all.push_whole(slot);
        }
        all
    };
    // All that were kept have histories of the same length.
    let like = (earlier.iter()).find(|run| run.pairs.numbers() == numbers);
    let carried = like.map(|like| mercury_engine::physics::Carried {
        pairs: sorted(pairs, &like.pairs),
        near_walls: sorted(near_walls, &like.near_walls),
    });
    (carried, released)
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

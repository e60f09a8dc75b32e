//! Native frames of a run.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use glam::{DQuat, DVec3};
use mercury_common::error::FormatError;
use mercury_common::folder_owner::is_written;
use mercury_common::frames::{
    BodyFrame, BodyReader, ContactFrame, ContactReader, FLAG_FIXED, FLAG_PRESCRIBED, FrameReader,
    FramesHeader, ParticleColumns, ParticleFrame, ParticleReader,
};
use mercury_common::particle_properties::LIQUID_VOLUME;

use super::{FrameChoice, Needs, PAUSE, Skipped, States, check, spin_of_ball};
use crate::CgError;
use crate::state::{Contacts, Particles, Partner, Space, State};

/// Time for which a followed run may be without a process that writes it: a run that is resumed has none for a moment.
const PATIENCE: Duration = Duration::from_secs(if cfg!(test) { 1 } else { 10 });

/// A run: particles, and contacts and bodies beside them.
#[derive(Debug)]
pub struct RunSource {
    path: PathBuf,
    particles: ParticleReader,
    /// Whether the run wrote contacts; they are only opened where they are needed.
    has_contacts: bool,
    contacts: Option<ContactReader>,
    bodies: Option<BodyReader>,
    skipped: Skipped,
    /// Whether the run was followed until its writer stopped without marking the end.
    broke_off: AtomicBool,
}

impl RunSource {
    pub(super) fn open(path: &Path, needs: Needs) -> Result<Self, CgError> {
        let particles = ParticleReader::open(path)?;
        let name = path.to_string_lossy().into_owned();
        let prefix = name
            .strip_suffix(".particles.arrow")
            .unwrap_or(&name)
            .to_owned();
        let beside = |kind: &str| PathBuf::from(format!("{prefix}.{kind}.arrow"));
        let contacts = beside("contacts");
        let has_contacts = contacts.exists();
        if needs.contacts && !has_contacts {
            return Err(CgError::Input(format!(
                "{}: there is no such file; fields of contacts need it\nhelp: `fstat = true` in [output] of the scene makes it, --fields chooses fields without contacts",
                contacts.display()
            )));
        }
        let contacts = if needs.contacts {
            Some(ContactReader::open(contacts)?)
        } else {
            None
        };
        let bodies = if particles.layout().body {
            Some(BodyReader::open_alone(beside("bodies"))?)
        } else {
            None
        };
        if needs.rotation && !particles.layout().angular_velocity {
            return Err(CgError::Input(format!(
                "{name}: no angular velocities: nothing turns in this run, so there are no fields of rotation"
            )));
        }
        let has_liquid =
            (particles.layout().more.iter()).any(|spec| spec.name == LIQUID_VOLUME.name);
        if needs.liquid && !has_liquid {
            return Err(CgError::Input(format!(
                "{name}: no column {}: no liquid is in this run, or it was written by a version before that column",
                LIQUID_VOLUME.name
            )));
        }
        Ok(Self {
            path: path.to_owned(),
            particles,
            has_contacts,
            contacts,
            bodies,
            skipped: Skipped::default(),
            broke_off: AtomicBool::new(false),
        })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    pub(super) fn materials(&self) -> &[String] {
        &self.particles.header().materials
    }

    pub(super) fn has_contacts(&self) -> bool {
        self.has_contacts
    }

    pub(super) fn skipped(&self) -> &Skipped {
        &self.skipped
    }

    /// Whether the run was followed until its writer stopped without marking the end: it was stopped, or killed.
    #[must_use]
    pub fn broke_off(&self) -> bool {
        self.broke_off.load(Ordering::Relaxed)
    }

    /// The number of frames.
    #[must_use]
    pub fn len(&self) -> usize {
        self.particles.frames().len()
    }

    /// Whether there are no frames.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Looks for frames that were added since; returns how many there are.
    pub fn refresh(&mut self) -> usize {
        if let Some(contacts) = &mut self.contacts {
            contacts.refresh();
        }
        if let Some(bodies) = &mut self.bodies {
            bodies.refresh();
        }
        self.particles.refresh()
    }

    /// Damage behind the last frame of one of the files.
    fn damage(&self) -> Option<CgError> {
        let bodies = self.bodies.as_ref().map(BodyReader::frames);
        let contacts = self.contacts.as_ref().map(ContactReader::frames);
        let mut files = [Some(self.particles.frames()), bodies, contacts]
            .into_iter()
            .flatten();
        let damage = files.find_map(FrameReader::damage)?;
        Some(damage.clone().into())
    }

    /// The chosen states, see [`Source::states`](super::Source::states).
    #[must_use]
    pub fn states(&self, choice: FrameChoice) -> States<'_> {
        let damage = self.damage().map(Err);
        let count = self.len();
        if choice == FrameChoice::Last {
            // The last frame that is whole and has contacts, if they are needed; damage behind it is reported.
            let mut wrong = None;
            let mut last = None;
            for k in (0..count).rev() {
                match self.state(k) {
                    Ok(Some(state)) => {
                        last = Some(Ok(state));
                        break;
                    }
                    Ok(None) => {}
                    Err(error) => {
                        wrong.get_or_insert(Err(error));
                    }
                }
            }
            return Box::new(last.into_iter().chain(wrong.or(damage)));
        }
        let wanted = (0..count).filter(move |&k| choice.has(k));
        let mut stopped = false;
        let states = wanted
            .filter_map(|k| self.state(k).transpose())
            .chain(damage);
        Box::new(states.take_while(move |item| !std::mem::replace(&mut stopped, item.is_err())))
    }

    /// The chosen states as they come, until the file `end` marks the run as over, or no process has written into its folder for
    /// ten seconds ([`Self::broke_off`]), and all that is there has been given. After an error nothing follows.
    pub fn follow(
        &mut self,
        choice: FrameChoice,
        end: PathBuf,
    ) -> impl Iterator<Item = Result<State, CgError>> + Send + '_ {
        let folder = match end.parent() {
            Some(parent) if parent != Path::new("") => parent.to_owned(),
            _ => PathBuf::from("."),
        };
        let mut next = 0;
        let mut stopped = false;
        let mut last_sign = Instant::now();
        std::iter::from_fn(move || {
            while !stopped {
                // Checked first: frames that were written before the end was marked are found by the read that follows.
                let ended = end.exists();
                if ended || is_written(&folder) {
                    last_sign = Instant::now();
                }
                let broke_off = last_sign.elapsed() > PATIENCE;
                let over = ended || broke_off;
                self.refresh();
                // Contacts and bodies of a frame are written after its particles.
                while next < self.len()
                    && !choice.ends_before(next)
                    && (over || !self.is_behind(next))
                {
                    let k = next;
                    next += 1;
                    if choice.has(k)
                        && let Some(state) = self.state(k).transpose()
                    {
                        stopped = state.is_err();
                        return Some(state);
                    }
                }
                if choice.ends_before(next) || (over && next >= self.len()) {
                    stopped = true;
                    self.broke_off.fetch_or(broke_off, Ordering::Relaxed);
                    return self.damage().filter(|_| over).map(Err);
                }
                std::thread::sleep(PAUSE);
            }
            None
        })
    }

    /// Whether contacts or bodies may still come for a frame.
    fn is_behind(&self, k: usize) -> bool {
        let bodies = self.bodies.as_ref().map(BodyReader::frames);
        let contacts = self.contacts.as_ref().map(ContactReader::frames);
        let step = self.particles.frames().info(k).map(|info| info.step);
        step.is_some_and(|step| {
            let mut beside = [bodies, contacts].into_iter().flatten();
            beside.any(|frames| ends_before(frames, step))
        })
    }

    /// Frame `k`; nothing if contacts are needed and there are none of its time.
    ///
    /// # Errors
    /// When the frames are damaged or do not fit together, or the file of contacts or bodies is cut before this frame.
    pub fn state(&self, k: usize) -> Result<Option<State>, CgError> {
        let frame = self.particles.frame(k)?;
        let contacts = match &self.contacts {
            None => None,
            Some(contacts) => {
                let Some(same) = frame_of(contacts.frames(), frame.step)? else {
                    let times = || contacts.frames().infos().map(|info| info.time);
                    let nearest = times().find(|&time| time >= frame.time);
                    self.skipped.add(frame.time, nearest.or(times().last()));
                    return Ok(None);
                };
                Some(contacts.frame(same)?)
            }
        };
        let bodies = match &self.bodies {
            None => None,
            Some(bodies) => {
                let same = frame_of(bodies.frames(), frame.step)?;
                let missing = || {
                    FormatError::of_file(
                        bodies.frames().path(),
                        format!("no frame of step {}", frame.step),
                    )
                };
                Some(bodies.frame(same.ok_or_else(missing)?)?)
            }
        };
        let header = self.particles.header();
        let columns = self.particles.layout();
        let state = state_of(
            header,
            (columns, &frame),
            bodies.as_ref(),
            contacts.as_ref(),
        )
        .map_err(|found| CgError::Input(format!("{}: frame {k}: {found}", self.path.display())))?;
        check(&state, &self.path.display().to_string())?;
        Ok(Some(state))
    }
}

/// Whether a file has no frame of this step or a later one.
fn ends_before(frames: &FrameReader, step: u64) -> bool {
    frames.infos().last().is_none_or(|last| last.step < step)
}

/// The number of the frame of a step, if there is one.
///
/// # Errors
/// When the file is cut before it: the frame was there.
fn frame_of(frames: &FrameReader, step: u64) -> Result<Option<usize>, FormatError> {
    let found = frames.infos().position(|info| info.step == step);
    match frames.damage() {
        Some(damage) if found.is_none() && ends_before(frames, step) => Err(damage.clone()),
        _ => Ok(found),
    }
}

fn space_of(header: &FramesHeader, frame: &ParticleFrame) -> Space {
    let spheres = || frame.position.iter().zip(&frame.radius);
    let (min, max) = header.domain.unwrap_or_else(|| {
        let min = spheres().fold(DVec3::INFINITY, |low, (x, r)| low.min(*x - *r));
        let max = spheres().fold(DVec3::NEG_INFINITY, |high, (x, r)| high.max(*x + *r));
        if frame.is_empty() {
            (DVec3::ZERO, DVec3::ZERO)
        } else {
            (min, max)
        }
    });
    Space {
        min,
        max,
        periodic: header.periodic,
        dimensions: header.dimensions.unwrap_or(3),
    }
}

fn moves(flags: u8) -> bool {
    flags & (FLAG_FIXED | FLAG_PRESCRIBED) == 0
}

/// The state of a frame: spheres and bodies as particles; a clump counts as one, at its centre of mass. Contacts are known if they are given.
///
/// # Errors
/// When a contact or a pebble names a particle or body that is not there.
pub fn state_of(
    header: &FramesHeader,
    (columns, frame): (&ParticleColumns, &ParticleFrame),
    bodies: Option<&BodyFrame>,
    contacts: Option<&ContactFrame>,
) -> Result<State, String> {
    let liquid = columns.number(frame, LIQUID_VOLUME.name);
    assemble((frame, liquid), bodies, contacts, space_of(header, frame))
}

fn assemble(
    (frame, liquid): (&ParticleFrame, Option<&[f64]>),
    bodies: Option<&BodyFrame>,
    contacts: Option<&ContactFrame>,
    space: Space,
) -> Result<State, String> {
    let mut particles = Particles::default();
    let mut row_of: HashMap<u32, u32> = HashMap::with_capacity(frame.len());
    let body_of = |k: usize| frame.body.as_ref().and_then(|body| body[k]);
    for k in 0..frame.len() {
        if body_of(k).is_some() {
            continue;
        }
        row_of.insert(frame.id[k], particles.len() as u32);
        particles.liquid.extend(liquid.map(|all| all[k]));
        particles.id.push(frame.id[k]);
        particles.material.push(frame.material[k]);
        particles.flowing.push(moves(frame.flags[k]));
        particles.position.push(frame.position[k]);
        particles.velocity.push(frame.velocity[k]);
        particles.mass.push(frame.mass[k]);
        particles.volume.push(frame.volume[k]);
        particles.radius.push(frame.radius[k]);
        let turning = frame
            .angular_velocity
            .as_ref()
            .map_or(DVec3::ZERO, |all| all[k]);
        particles.angular_velocity.push(turning);
        particles.spin.push(spin_of_ball(
            frame.mass[k],
            frame.radius[k],
            turning,
            space.dimensions,
        ));
    }
    let spheres = particles.len();
    if let Some(bodies) = bodies {
        let first = particles.len() as u32;
        let row_of_body: HashMap<u32, u32> = bodies
            .id
            .iter()
            .zip(first..)
            .map(|(&id, row)| (id, row))
            .collect();
        if liquid.is_some() {
            particles.liquid.resize(spheres + bodies.len(), 0.0);
        }
        for k in 0..bodies.len() {
            particles.id.push(bodies.id[k]);
            particles.material.push(bodies.material[k]);
            particles.flowing.push(moves(bodies.flags[k]));
            particles.position.push(bodies.position[k]);
            particles.velocity.push(bodies.velocity[k]);
            particles.mass.push(bodies.mass[k]);
            particles.volume.push(bodies.volume[k]);
            particles
                .radius
                .push(equal_ball(bodies.volume[k], space.dimensions));
            let turning = bodies.angular_velocity[k];
            particles.angular_velocity.push(turning);
            particles.spin.push(spin_of_body(
                bodies.orientation[k],
                bodies.principal_moments[k],
                turning,
            ));
        }
        for k in 0..frame.len() {
            if let Some(body) = body_of(k) {
                let row = row_of_body.get(&body).ok_or_else(|| {
                    format!(
                        "particle {} is of body {body}, which is not there",
                        frame.id[k]
                    )
                })?;
                row_of.insert(frame.id[k], *row);
                if let Some(liquid) = liquid {
                    particles.liquid[*row as usize] += liquid[k];
                }
            }
        }
    }
    let contacts = match contacts {
        None => None,
        Some(contacts) => {
            let id_to_place: HashMap<u32, usize> = frame
                .id
                .iter()
                .enumerate()
                .map(|(k, &id)| (id, k))
                .collect();
            let mut out = Contacts::default();
            let find = |id: u32| -> Result<(u32, usize), String> {
                let missing = || format!("a contact names particle {id}, which is not there");
                Ok((
                    *row_of.get(&id).ok_or_else(missing)?,
                    *id_to_place.get(&id).ok_or_else(missing)?,
                ))
            };
            for k in 0..contacts.len() {
                let (row, place) = find(contacts.i[k])?;
                let point = contacts.point[k];
                // Where the file has wrapped the particle, its image beside the point.
                let sphere_arm = space.nearest(frame.position[place] - point);
                let arm_to = |row: u32, sphere: DVec3| {
                    if (row as usize) < spheres {
                        sphere
                    } else {
                        space.nearest(particles.position[row as usize] - point)
                    }
                };
                let (partner, partner_arm) = match (contacts.j[k], contacts.wall[k]) {
                    (Some(j), _) => {
                        let (other, _) = find(j)?;
                        if other == row {
                            continue;
                        }
                        (
                            Partner::Particle(other),
                            arm_to(other, sphere_arm - contacts.branch[k]),
                        )
                    }
                    // Membranes count as walls, of which no number is used.
                    (None, wall) => (Partner::Wall(wall.unwrap_or(0)), DVec3::ZERO),
                };
                out.particle.push(row);
                out.partner.push(partner);
                out.point.push(point);
                out.arm.push(arm_to(row, sphere_arm));
                out.partner_arm.push(partner_arm);
                out.normal.push(contacts.normal[k]);
                out.force.push(contacts.force[k]);
                // Laws without rolling and torsion transmit none.
                out.couple
                    .push(contacts.torque.as_ref().map_or(DVec3::ZERO, |all| all[k]));
            }
            Some(out)
        }
    };
    Ok(State {
        time: frame.time,
        space,
        particles,
        contacts,
        displacement: None,
    })
}

/// Radius of the sphere (or disc) of a volume, m.
#[must_use]
pub fn equal_ball(volume: f64, dimensions: u8) -> f64 {
    let area = volume / std::f64::consts::PI;
    if dimensions == 2 {
        area.sqrt()
    } else {
        libm::cbrt(0.75 * area)
    }
}

fn spin_of_body(orientation: DQuat, moments: DVec3, angular_velocity: DVec3) -> DVec3 {
    orientation * (moments * (orientation.inverse() * angular_velocity))
}

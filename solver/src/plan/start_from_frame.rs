//! Starts from a frame of another run: `[[particles]] run` with `at`. A frame has grains and walls; contacts begin anew.

use std::collections::HashMap;
use std::path::PathBuf;

use glam::DVec3;
use mercury_common::error::FormatError;
use mercury_common::formats::mesh::TriangleMesh;
use mercury_common::frames::{
    BodyFrame, BodyReader, FLAG_FIXED, FLAG_PRESCRIBED, FrameReader, ParticleFrame, ParticleReader,
    WallFrame, WallReader,
};
use mercury_common::particle_properties::{
    FILM_VOLUME, LIQUID_VOLUME, OfClump, PARTICLE_PROPERTIES, ParticleProperty, PropertyValue,
};
use mercury_common::run_files::{FRAMES, particles_in};
use mercury_common::scene::{Dimensions, Located, Scene, SceneError};
use mercury_common::surfaces::Surface;

use super::{NewBody, NewParticle};
use mercury_engine::bodies::Clump;
use mercury_engine::state::MaterialIndex;
use mercury_engine::walls::{Pose, Shape};

/// The grains of a frame.
pub(super) struct Grains {
    /// The files that were read.
    pub(super) files: Vec<PathBuf>,
    pub(super) title: String,
    /// s
    pub(super) time: f64,
    pub(super) step: u64,
    /// Checksum of all numbers that were taken.
    pub(super) checksum: u32,
    /// Particles, in the order of their ids there, with the properties that are not the default.
    pub(super) particles: Vec<(NewParticle, Vec<PropertyValue>)>,
    /// Bodies likewise.
    pub(super) bodies: Vec<(NewBody, Vec<PropertyValue>)>,
}

/// Where the walls of another run stood at the instant from which this one starts.
#[derive(Default)]
pub(super) struct EarlierWalls {
    walls: Vec<(String, Surface, Pose)>,
}

impl EarlierWalls {
    /// Where a wall of this scene stood then: one of this name and shape that was there, and elsewhere than where the scene has it.
    pub(super) fn pose_of(&self, name: &str, shape: &Shape) -> Option<&Pose> {
        let (_, surface, pose) = self.walls.iter().find(|(known, ..)| known == name)?;
        (*pose != Pose::IDENTITY && is_alike(surface, &shape.outline())).then_some(pose)
    }

    /// With those of another run.
    pub(super) fn extend(&mut self, more: Self) {
        self.walls.extend(more.walls);
    }
}

/// Whether two surfaces are the same. Of meshes the corners of the triangles count, one after the other; an endless cylinder is the same
/// as one that is continued along a periodic axis later.
fn is_alike(a: &Surface, b: &Surface) -> bool {
    match (a, b) {
        (Surface::Mesh(a), Surface::Mesh(b)) => {
            let corners = |mesh: &TriangleMesh| -> Vec<[DVec3; 3]> {
                (0..mesh.triangles.len()).map(|k| mesh.corners(k)).collect()
            };
            corners(a) == corners(b)
        }
        (
            Surface::Turned {
                origin,
                direction,
                endless,
                ..
            },
            Surface::Turned {
                origin: other_origin,
                direction: other_direction,
                endless: other_endless,
                ..
            },
        ) if endless != other_endless => origin == other_origin && direction == other_direction,
        _ => a == b,
    }
}

/// The frames of a run, of which one is nearest to a time.
pub(super) struct Frames {
    path: PathBuf,
    /// Number of the frame that is nearest.
    nearest: usize,
    /// s
    pub(super) time: f64,
    pub(super) step: u64,
    /// Time of the last of them, s.
    pub(super) last: f64,
}

impl Frames {
    /// Frames of the run in a folder; `None` if it has no native frames.
    pub(super) fn nearest(folder: &Located<PathBuf>, at: f64) -> Result<Option<Self>, SceneError> {
        let is_native = |path: &PathBuf| path.to_string_lossy().ends_with(FRAMES);
        let Some(path) = particles_in(&folder.value).ok().filter(is_native) else {
            return Ok(None);
        };
        folder.place.may_read(&path)?;
        let frames = FrameReader::open(&path).map_err(|error| of_file(folder, &error))?;
        let times = || frames.infos().map(|info| info.time);
        let far = |k: &(usize, f64)| (k.1 - at).abs();
        let nearest = times().enumerate().min_by(|a, b| far(a).total_cmp(&far(b)));
        let Some((nearest, time)) = nearest else {
            return Ok(None);
        };
        let step = frames.infos().nth(nearest).map_or(0, |info| info.step);
        let last = times().last().unwrap_or(time);
        Ok(Some(Self {
            path,
            nearest,
            time,
            step,
            last,
        }))
    }

    /// A file of the run by its ending: `walls.arrow`.
    fn beside(&self, ending: &str) -> PathBuf {
        let name = self.path.file_name().unwrap_or_default().to_string_lossy();
        let prefix = name.strip_suffix(FRAMES).unwrap_or(&name);
        self.path.with_file_name(format!("{prefix}.{ending}"))
    }

    /// Placements of the walls in a step; `None` where no frame has them.
    pub(super) fn walls(
        &self,
        folder: &Located<PathBuf>,
        step: u64,
    ) -> Result<Option<(EarlierWalls, PathBuf)>, SceneError> {
        let path = self.beside("walls.arrow");
        if !path.exists() {
            return Ok(None);
        }
        folder.place.may_read(&path)?;
        let failed = |error: FormatError| of_file(folder, &error);
        let reader = WallReader::open(&path).map_err(failed)?;
        let steps: Vec<u64> = reader.frames().infos().map(|info| info.step).collect();
        let behind = steps.partition_point(|&known| known < step);
        let frame = |k: usize| reader.frame(k).map_err(failed);
        let now = match steps.get(behind) {
            Some(known) if *known == step => frame(behind)?,
            // Between two frames that have all walls in the same places they were there.
            Some(_) if behind > 0 => {
                let (before, after) = (frame(behind - 1)?, frame(behind)?);
                if (&before.placement, &before.present) != (&after.placement, &after.present) {
                    return Ok(None);
                }
                after
            }
            _ => return Ok(None),
        };
        let WallFrame {
            present, placement, ..
        } = now;
        let names = reader.header().walls.iter().zip(reader.layout());
        let places = placement.into_iter().zip(present);
        let walls = names.zip(places).filter(|(_, (_, present))| *present);
        let walls = walls.map(|((name, surface), (placement, _))| {
            let pose = Pose {
                rotation: placement.rotation,
                translation: placement.translation,
            };
            (name.clone(), surface.clone(), pose)
        });
        let walls = EarlierWalls {
            walls: walls.collect(),
        };
        Ok(Some((walls, path)))
    }

    /// The grains of the frame.
    pub(super) fn grains(
        &self,
        folder: &Located<PathBuf>,
        scene: &Scene,
        clumps: &[Clump],
        warnings: &mut Vec<String>,
    ) -> Result<Grains, SceneError> {
        let failed = |error: FormatError| of_file(folder, &error);
        let reader = ParticleReader::open(&self.path).map_err(failed)?;
        let frame = reader.frame(self.nearest).map_err(failed)?;
        let header = reader.header();
        let dimensions = match scene.domain.dimensions {
            Dimensions::Two => 2,
            Dimensions::Three => 3,
        };
        if let Some(there) = header.dimensions.filter(|there| *there != dimensions) {
            return Err(folder.error(format!(
                "that run has {there} dimensions, this scene {dimensions}"
            )));
        }
        let columns = reader.layout();
        let value = |property: &'static ParticleProperty, rows: &[usize]| {
            // No bridge goes on without its contact: its liquid begins in the films.
            let with_bridges = (*property == FILM_VOLUME)
                .then(|| columns.number(&frame, LIQUID_VOLUME.name))
                .flatten();
            let column = match with_bridges {
                Some(column) => column,
                None => columns.number(&frame, property.name)?,
            };
            let sum: f64 = rows.iter().map(|&row| column[row]).sum();
            let value = match property.of_clump {
                OfClump::Sum => sum,
                OfClump::Mean => sum / rows.len() as f64,
            };
            property.differs(value).then_some((property, value))
        };
        let properties = |rows: &[usize]| -> Vec<PropertyValue> {
            let all = PARTICLE_PROPERTIES.iter();
            all.filter_map(|property| value(property, rows)).collect()
        };
        let mut rows: Vec<usize> = (0..frame.id.len()).collect();
        rows.sort_by_key(|&row| frame.id[row]);
        let body_of = |row: usize| frame.body.as_ref().and_then(|bodies| bodies[row]);
        let mut particles = Vec::new();
        for &row in rows.iter().filter(|&&row| body_of(row).is_none()) {
            refuse_prescribed(folder, frame.flags[row])?;
            let material = material(folder, scene, &header.materials, frame.material[row])?;
            let spin = frame.angular_velocity.as_ref().map(|spins| spins[row]);
            let particle = NewParticle {
                velocity: frame.velocity[row],
                angular_velocity: spin.unwrap_or_default(),
                fixed: frame.flags[row] & FLAG_FIXED != 0,
                ..NewParticle::at(frame.position[row], frame.radius[row], material)
            };
            particles.push((particle, properties(&[row])));
        }
        let mut files = vec![self.path.clone()];
        let mut bodies = Vec::new();
        if rows.iter().any(|&row| body_of(row).is_some()) {
            let path = self.beside("bodies.arrow");
            folder.place.may_read(&path)?;
            let reader = BodyReader::open_alone(&path).map_err(failed)?;
            let names: Vec<&str> = reader
                .layout()
                .iter()
                .map(|kind| kind.name.as_str())
                .collect();
            let mut steps = reader.frames().infos().map(|info| info.step);
            let number = steps.position(|step| step == frame.step);
            let number = number.ok_or_else(|| {
                folder.error(format!(
                    "{} lacks the frame of its particles",
                    path.display()
                ))
            })?;
            let there = reader.frame(number).map_err(failed)?;
            let mut order: Vec<usize> = (0..there.len()).collect();
            order.sort_by_key(|&k| there.id[k]);
            let mut pebbles: HashMap<u32, Vec<usize>> = HashMap::new();
            for &row in &rows {
                if let Some(body) = body_of(row) {
                    pebbles.entry(body).or_default().push(row);
                }
            }
            for k in order {
                refuse_prescribed(folder, there.flags[k])?;
                let body = body(folder, clumps, &names, &there, k)?;
                let of_body = pebbles.get(&there.id[k]).map_or(&[][..], Vec::as_slice);
                bodies.push((body, properties(of_body)));
            }
            files.push(path);
        }
        if !is_finite(&frame, &bodies) {
            return Err(folder.error(
                "a position, size or velocity in that frame of the run is not a finite number",
            ));
        }
        let has = |property: &ParticleProperty| columns.number(&frame, property.name).is_some();
        if has(&FILM_VOLUME) && !has(&LIQUID_VOLUME) {
            warnings.push(format!(
                "{}: this frame has the liquid of films, not that of bridges, which is left out; a checkpoint has both",
                folder.place.key()
            ));
        }
        Ok(Grains {
            files,
            title: header.title.clone(),
            time: frame.time,
            step: frame.step,
            checksum: checksum(&particles, &bodies),
            particles,
            bodies,
        })
    }
}

/// A body of a frame.
fn body(
    folder: &Located<PathBuf>,
    clumps: &[Clump],
    names: &[&str],
    there: &BodyFrame,
    k: usize,
) -> Result<NewBody, SceneError> {
    let name = names
        .get(there.clump[k] as usize)
        .copied()
        .unwrap_or_default();
    let Some(clump) = clumps.iter().position(|clump| clump.name == name) else {
        let message = format!(
            "there are bodies of the clump `{name}` in that run, and no such clump in this scene"
        );
        return Err(folder
            .error(message)
            .with_help(format!("add [clumps.{name}]")));
    };
    let is_same =
        (clumps[clump].radius * there.scale[k] - there.radius[k]).abs() <= 1e-9 * there.radius[k];
    if !is_same {
        return Err(folder.error(format!("the clump `{name}` has other pebbles in that run")));
    }
    Ok(NewBody {
        scale: there.scale[k],
        orientation: there.orientation[k],
        velocity: there.velocity[k],
        angular_velocity: there.angular_velocity[k],
        fixed: there.flags[k] & FLAG_FIXED != 0,
        ..NewBody::at(there.position[k], clump as u32)
    })
}

/// No frame holds which components of a motion are prescribed.
fn refuse_prescribed(folder: &Located<PathBuf>, flags: u8) -> Result<(), SceneError> {
    if flags & FLAG_PRESCRIBED == 0 {
        return Ok(());
    }
    let error =
        folder.error("grains of that run have a prescribed motion, which frames do not hold");
    Err(error.with_help("start from a checkpoint: leave `at` out, or choose the time of one"))
}

/// A material of that run in this scene.
fn material(
    folder: &Located<PathBuf>,
    scene: &Scene,
    names: &[String],
    number: u32,
) -> Result<MaterialIndex, SceneError> {
    let name = names.get(number as usize).map_or("", String::as_str);
    let mut known = scene.materials.iter();
    let found = known.position(|material| material.name.value == name);
    found.map(|index| MaterialIndex::new(index as u32)).ok_or_else(|| {
        let message = format!("there are particles of the material `{name}` in that run, and no such material in this scene");
        folder.error(message).with_help(format!("add [materials.{name}]"))
    })
}

fn is_finite(frame: &ParticleFrame, bodies: &[(NewBody, Vec<PropertyValue>)]) -> bool {
    let spins = frame.angular_velocity.iter().flatten();
    let vectors = frame.position.iter().chain(&frame.velocity).chain(spins);
    vectors.into_iter().all(|vector| vector.is_finite())
        && frame
            .radius
            .iter()
            .all(|radius| *radius > 0.0 && radius.is_finite())
        && frame.more.iter().flatten().all(|number| number.is_finite())
        && bodies.iter().all(|(body, _)| {
            body.scale > 0.0
                && body.scale.is_finite()
                && body.position.is_finite()
                && body.orientation.is_finite()
                && body.velocity.is_finite()
                && body.angular_velocity.is_finite()
        })
}

/// So that a run that goes on finds the same start.
fn checksum(
    particles: &[(NewParticle, Vec<PropertyValue>)],
    bodies: &[(NewBody, Vec<PropertyValue>)],
) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    let mut take = |vectors: &[DVec3], number: f64, properties: &[PropertyValue]| {
        let numbers = vectors.iter().flat_map(|vector| vector.to_array());
        let values = properties.iter().map(|(_, value)| *value);
        for number in numbers.chain([number]).chain(values) {
            hasher.update(&number.to_bits().to_le_bytes());
        }
    };
    for (one, properties) in particles {
        let vectors = [one.position, one.velocity, one.angular_velocity];
        take(&vectors, one.radius, properties);
    }
    for (one, properties) in bodies {
        let [x, y, z, w] = one.orientation.to_array();
        let turn = [DVec3::new(x, y, z), DVec3::splat(w)];
        take(&turn, one.scale, properties);
        take(
            &[one.position, one.velocity, one.angular_velocity],
            0.0,
            &[],
        );
    }
    hasher.finalize()
}

fn of_file(folder: &Located<PathBuf>, error: &FormatError) -> SceneError {
    folder.error(error.to_string())
}

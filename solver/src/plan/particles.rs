//! The particles of the start: `[[particles]]` in the order of the file, which is the order of their ids.

use glam::DVec3;
use mercury_common::formats::particle_csv::read_particle_csv;
use mercury_common::random::Stream;
use mercury_common::scene::{
    Lattice, Located, MaterialIndex, ParticleSource, ParticleValues, Place, Scene, SceneError,
};

use super::NewParticle;
use crate::neighbours::Images;

/// Where a particle of the start was typed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Typed {
    /// Row in [`Scene::particles`].
    pub entry: usize,
    /// Line of the table, for particles of a table.
    pub line: Option<usize>,
}

/// The particles of the start, the place of each, and the ids of the tracked ones.
#[derive(Debug, Default)]
pub(super) struct StartingParticles {
    /// By id.
    pub particles: Vec<NewParticle>,
    /// By id.
    pub typed: Vec<Typed>,
    /// Name and id of the entries that are single particles with a name.
    pub named: Vec<(String, u32)>,
}

impl StartingParticles {
    fn add(&mut self, particle: NewParticle, images: &Images, typed: Typed) {
        self.particles.push(NewParticle {
            position: images.wrap(particle.position),
            ..particle
        });
        self.typed.push(typed);
    }
}

/// Most particles of one lattice: more would not fit into the 32 bits of their ids.
const MOST_SITES: f64 = 4e9;

/// Makes the particles of the start; positions on periodic axes are wrapped into the domain.
pub(super) fn starting_particles(scene: &Scene, errors: &mut Vec<SceneError>) -> StartingParticles {
    let images = Images::new(*scene.domain.min, *scene.domain.max, scene.domain.periodic);
    let mut start = StartingParticles::default();
    for (entry, particles) in scene.particles.iter().enumerate() {
        match &particles.source {
            ParticleSource::One { particle, position } => {
                check_start(particle, errors);
                let id = start.particles.len() as u32;
                start
                    .named
                    .extend(particles.name.as_ref().map(|name| (name.value.clone(), id)));
                start.add(
                    one(particle, **position),
                    &images,
                    Typed { entry, line: None },
                );
            }
            ParticleSource::Lattice { particle, lattice } => {
                check_start(particle, errors);
                let count: f64 = lattice.sites().iter().product();
                if count > MOST_SITES {
                    errors.push(lattice.place.error(format!("has {count:e} sites")));
                    continue;
                }
                // Each lattice draws from a stream of its own, so that entries do not disturb one another.
                let mut stream = Stream::new(scene.seed, "lattice", entry as u64);
                for position in sites(lattice, &mut stream) {
                    start.add(
                        one(particle, position),
                        &images,
                        Typed { entry, line: None },
                    );
                }
            }
            ParticleSource::Table {
                file,
                material,
                fixed,
            } => match read_particle_csv(&file.value) {
                Err(mut error) => {
                    // The reader's advice comes behind the line of the scene, as all advice does.
                    let help = error.help.take();
                    let error = file.error(error.to_string());
                    errors.push(match help {
                        Some(help) => error.with_help(help),
                        None => error,
                    });
                }
                Ok(rows) => {
                    for row in rows {
                        let of_row = |message: String| {
                            file.error(format!("{}:{}: {message}", file.display(), row.line))
                        };
                        let index = match row_material(scene, row.material.as_deref(), material) {
                            Ok(index) => index,
                            Err(message) => {
                                errors.push(of_row(message));
                                break;
                            }
                        };
                        let moves =
                            row.velocity != DVec3::ZERO || row.angular_velocity != DVec3::ZERO;
                        if *fixed && moves {
                            errors.push(of_row("a fixed particle has a velocity".to_owned()));
                            break;
                        }
                        if row.film_volume > 0.0 {
                            errors.push(of_row(
                                "liquid films are not in this version of mercury-solve".to_owned(),
                            ));
                            break;
                        }
                        let particle = NewParticle {
                            velocity: row.velocity,
                            angular_velocity: row.angular_velocity,
                            fixed: *fixed,
                            ..NewParticle::at(row.position, row.radius, index.0 as u32)
                        };
                        start.add(
                            particle,
                            &images,
                            Typed {
                                entry,
                                line: Some(row.line),
                            },
                        );
                    }
                }
            },
            // Reported by `unsupported`.
            ParticleSource::Run { .. } | ParticleSource::Clump { .. } => {}
        }
    }
    start
}

fn row_material(
    scene: &Scene,
    name: Option<&str>,
    default: &Option<Located<MaterialIndex>>,
) -> Result<MaterialIndex, String> {
    let Some(name) = name else {
        return match default {
            Some(material) => Ok(material.value),
            None => Err("no material: give the column or `material` beside the file".to_owned()),
        };
    };
    scene
        .materials
        .iter()
        .position(|material| material.name.value == name)
        .map(MaterialIndex)
        .ok_or_else(|| format!("there is no material named `{name}`"))
}

/// A particle at a place, as its entry says.
fn one(values: &ParticleValues, position: DVec3) -> NewParticle {
    let start = &values.start;
    let prescribed = start.prescribed.as_deref();
    let mut particle = NewParticle {
        velocity: *start.velocity,
        angular_velocity: *start.angular_velocity,
        fixed: start.fixed,
        prescribed_velocity: prescribed.map_or([None; 3], |p| p.velocity),
        prescribed_angular_velocity: prescribed.map_or([None; 3], |p| p.angular_velocity),
        ..NewParticle::at(position, *values.radius, values.material.0 as u32)
    };
    for axis in 0..3 {
        if let Some(velocity) = particle.prescribed_velocity[axis] {
            particle.velocity[axis] = velocity;
        }
        if let Some(spin) = particle.prescribed_angular_velocity[axis] {
            particle.angular_velocity[axis] = spin;
        }
    }
    particle
}

fn check_start(values: &ParticleValues, errors: &mut Vec<SceneError>) {
    let start = &values.start;
    if !start.fixed {
        return;
    }
    let mut complain = |place: &Place, what: &str| {
        errors.push(
            place
                .error(format!("a fixed particle has {what}"))
                .with_help(
                    "use `prescribed` instead of `fixed` for particles that move in a given way",
                ),
        );
    };
    if *start.velocity != DVec3::ZERO {
        complain(&start.velocity.place, "a velocity");
    }
    if *start.angular_velocity != DVec3::ZERO {
        complain(&start.angular_velocity.place, "an angular velocity");
    }
    if let Some(prescribed) = &start.prescribed {
        complain(&prescribed.place, "prescribed components");
    }
}

/// The sites of a lattice, x fastest, with their jitter.
fn sites(lattice: &Lattice, stream: &mut Stream) -> Vec<DVec3> {
    let counts = lattice.sites().map(|count| count as u64);
    let mut sites = Vec::with_capacity(counts.iter().product::<u64>() as usize);
    for k in 0..counts[2] {
        for j in 0..counts[1] {
            for i in 0..counts[0] {
                let steps = DVec3::new(i as f64, j as f64, k as f64);
                let mut site = *lattice.min + steps * *lattice.spacing;
                if *lattice.jitter > 0.0 {
                    for axis in 0..3 {
                        if counts[axis] > 1 {
                            site[axis] += stream.uniform_in(-*lattice.jitter, *lattice.jitter);
                        }
                    }
                }
                sites.push(site);
            }
        }
    }
    sites
}

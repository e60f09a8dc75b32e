//! The particles of the start: `[[particles]]` in the order of the file, which is the order of their ids.

use glam::DVec3;
use mercury_common::particle_properties::{FILM_VOLUME, ParticleProperty, PropertyValue};
use mercury_common::random::Stream;
use mercury_common::readable;
use mercury_common::scene::{
    ClumpPlace, Lattice, Orientation, ParticleSource, ParticleValues, Scene, SceneError,
    SourceSpan, Start,
};

use super::expected::LeftOut;
use super::particle_table::Table;
use super::start_from_frame::EarlierWalls;
use super::start_from_run::{Earlier, take_up};
use super::{NewBody, NewParticle, PrescribedMotion, cell_of};
use mercury_engine::bodies::Clump;
use mercury_engine::cell::Cell;
use mercury_engine::contact::parameter::short;
use mercury_engine::state::StartValues;

/// Where a particle of the start was typed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Typed {
    /// Row in [`Scene::particles`].
    pub entry: usize,
    /// Line of the table, for particles of a table.
    pub line: Option<usize>,
}

/// The particles of the start, the place of each, and the ids of the tracked ones.
#[derive(Default)]
pub(crate) struct StartingParticles {
    /// Particles by id.
    pub particles: Vec<NewParticle>,
    /// Sources by id.
    pub typed: Vec<Typed>,
    /// Bodies, in the order of their ids, which follow those of the particles.
    pub bodies: Vec<NewBody>,
    /// Where each body was typed.
    pub typed_bodies: Vec<Typed>,
    /// The number of grains of the scene that were left out.
    pub left_out: LeftOut,
    /// Name and id of the entries that are single particles with a name; of bodies once all ids are known.
    pub named: Vec<(String, u32)>,
    /// Remarks on tables.
    pub remarks: Vec<String>,
    /// Runs whose states are among them.
    pub(super) earlier: Vec<Earlier>,
    /// Where walls were in the states of a time that is given.
    pub(super) walls: EarlierWalls,
    /// Values of their properties.
    pub values: Vec<StartValues>,
}

impl StartingParticles {
    /// Adds a particle with values of properties that are not the default.
    pub(crate) fn add(
        &mut self,
        particle: NewParticle,
        properties: &[PropertyValue],
        cell: &Cell,
        typed: Typed,
    ) {
        for &(property, value) in properties {
            let number = self.particles.len();
            self.values_of(property).particles.push((number, value));
        }
        self.particles.push(NewParticle {
            position: cell.wrap(particle.position),
            ..particle
        });
        self.typed.push(typed);
    }

    /// Adds a body with values of properties that are not the default.
    pub(crate) fn add_body(
        &mut self,
        body: NewBody,
        properties: &[PropertyValue],
        cell: &Cell,
        typed: Typed,
    ) {
        for &(property, value) in properties {
            let number = self.bodies.len();
            self.values_of(property).bodies.push((number, value));
        }
        self.bodies.push(NewBody {
            position: cell.wrap(body.position),
            ..body
        });
        self.typed_bodies.push(typed);
    }

    fn values_of(&mut self, property: &'static ParticleProperty) -> &mut StartValues {
        let known = self.values.iter();
        let place = known
            .take_while(|values| values.property != property)
            .count();
        if place == self.values.len() {
            self.values.push(StartValues::new(property));
        }
        &mut self.values[place]
    }

    /// Adds liquid (m^3) to the films of particles and bodies, each by its number among them.
    pub(crate) fn add_films(
        &mut self,
        particles: impl Iterator<Item = (usize, f64)>,
        bodies: impl Iterator<Item = (usize, f64)>,
    ) {
        let add = |values: &mut Vec<(usize, f64)>, more: &mut dyn Iterator<Item = (usize, f64)>| {
            // The numbers ascend, as grains were added in their order.
            for (number, volume) in more {
                match values.binary_search_by_key(&number, |value| value.0) {
                    Ok(place) => values[place].1 += volume,
                    Err(place) => values.insert(place, (number, volume)),
                }
            }
        };
        let (mut particles, mut bodies) = (particles.peekable(), bodies.peekable());
        if particles.peek().is_none() && bodies.peek().is_none() {
            return;
        }
        let films = self.values_of(&FILM_VOLUME);
        add(&mut films.particles, &mut particles);
        add(&mut films.bodies, &mut bodies);
    }

    /// Adds what another run left.
    fn take_up(&mut self, mut earlier: Earlier, cell: &Cell, typed: Typed) {
        earlier.first = (self.particles.len(), self.bodies.len());
        for (particle, properties) in &earlier.particles {
            self.add(particle.clone(), properties, cell, typed);
        }
        for (body, properties) in &earlier.bodies {
            self.add_body(body.clone(), properties, cell, typed);
        }
        self.earlier.push(earlier);
    }

    /// Spheres that can touch: particles, then the pebbles of bodies, each with the number of its grain (particles, then
    /// bodies).
    pub(crate) fn spheres<'a>(
        &'a self,
        clumps: &'a [Clump],
    ) -> impl Iterator<Item = StartingSphere> + 'a {
        let particles = self.particles.iter().enumerate();
        let particles = particles.map(|(grain, particle)| StartingSphere {
            grain,
            centre: particle.position,
            radius: particle.radius,
            fixed: particle.fixed,
        });
        let first = self.particles.len();
        let pebbles = self.bodies.iter().enumerate().flat_map(move |(k, body)| {
            let spheres = body.spheres(&clumps[body.clump as usize]);
            spheres.map(move |(centre, radius)| StartingSphere {
                grain: first + k,
                centre,
                radius,
                fixed: body.fixed,
            })
        });
        particles.chain(pebbles)
    }
}

impl StartingParticles {
    /// Where the grain of this number was typed: particles, then bodies.
    pub(crate) fn typed(&self, grain: usize) -> Typed {
        match grain.checked_sub(self.particles.len()) {
            None => self.typed[grain],
            Some(body) => self.typed_bodies[body],
        }
    }

    /// Its centre, m.
    pub(crate) fn centre(&self, grain: usize) -> DVec3 {
        match grain.checked_sub(self.particles.len()) {
            None => self.particles[grain].position,
            Some(body) => self.bodies[body].position,
        }
    }

    /// Particles and bodies.
    pub(crate) fn grains(&self) -> usize {
        self.particles.len() + self.bodies.len()
    }
}

/// A particle or a pebble of the start.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StartingSphere {
    /// Number of the particle, or of all particles and that of the body.
    pub grain: usize,
    /// m, not wrapped for pebbles.
    pub centre: DVec3,
    /// m
    pub radius: f64,
    /// Never moves.
    pub fixed: bool,
}

/// Most spheres on lattices: more would not fit into the 32 bits of their ids.
const MOST_SITES: f64 = 4e9;

/// Makes the particles and bodies of the start, of each lattice `most_sites` at most; positions on periodic axes are wrapped into the
/// domain. `clumps`: the templates, if they could be read.
pub(crate) fn starting_particles(
    scene: &Scene,
    clumps: Option<&[Clump]>,
    most_sites: u64,
    warnings: &mut Vec<String>,
    errors: &mut Vec<SceneError>,
) -> StartingParticles {
    let cell = cell_of(&scene.domain);
    let mut start = StartingParticles::default();
    // Name of a single body, and its place among the bodies.
    let mut named_bodies: Vec<(String, usize)> = Vec::new();
    let mut numbers = TakenIds::default();
    for (entry, particles) in scene.particles.iter().enumerate() {
        match &particles.source {
            ParticleSource::One { particle, position } => {
                check_start(&particle.start, errors);
                let id = start.particles.len() as u32;
                start
                    .named
                    .extend(particles.name.as_ref().map(|name| (name.value.clone(), id)));
                start.add(
                    one(particle, **position),
                    &particle.start.properties,
                    &cell,
                    Typed { entry, line: None },
                );
            }
            ParticleSource::Lattice { particle, lattice } => {
                check_start(&particle.start, errors);
                let Some(count) = numbers.take(lattice, 1, errors) else {
                    continue;
                };
                let made = count.min(most_sites);
                start.left_out.particles += (count - made) as f64;
                let room = start.particles.try_reserve(made as usize);
                if room
                    .and_then(|()| start.typed.try_reserve(made as usize))
                    .is_err()
                {
                    errors.push(no_room(lattice, made));
                    continue;
                }
                // Each lattice draws from a stream of its own, so that entries do not disturb one another.
                let mut stream = Stream::new(scene.seed, "lattice", entry as u64);
                for position in sites(lattice, &mut stream).take(made as usize) {
                    start.add(
                        one(particle, position),
                        &particle.start.properties,
                        &cell,
                        Typed { entry, line: None },
                    );
                }
            }
            ParticleSource::Table {
                file,
                material,
                fixed,
                scale,
            } => {
                let table = Table {
                    scene,
                    entry,
                    file,
                    material: material.as_ref(),
                    fixed: *fixed,
                    scale: scale.as_ref(),
                };
                if let Err(wrong) = start.read(&table, &cell) {
                    errors.extend(wrong);
                }
            }
            ParticleSource::Clump {
                clump,
                at,
                orientation,
                scale,
                start: motion,
            } => {
                check_start(motion, errors);
                let mut turns = Stream::new(scene.seed, "orientations", entry as u64);
                let mut put = |start: &mut StartingParticles, position: DVec3| {
                    let orientation = match orientation.value {
                        Orientation::Given(given) => given,
                        Orientation::Random => turns.unit_quaternion(),
                    };
                    let body = NewBody {
                        position,
                        orientation,
                        scale: **scale,
                        ..moving_body(motion, clump.value.0 as u32)
                    };
                    let typed = Typed { entry, line: None };
                    start.add_body(body, &motion.properties, &cell, typed);
                };
                match at {
                    ClumpPlace::Position(position) => {
                        let name = particles.name.as_ref();
                        let place = start.bodies.len();
                        named_bodies.extend(name.map(|name| (name.value.clone(), place)));
                        put(&mut start, position.value);
                    }
                    ClumpPlace::Lattice(lattice) => {
                        let template = clumps.and_then(|clumps| clumps.get(clump.value.0));
                        let pebbles = template.map_or(1, |clump| clump.pebbles.len());
                        let Some(count) = numbers.take(lattice, pebbles, errors) else {
                            continue;
                        };
                        let made = count.min(most_sites);
                        start.left_out.bodies += (count - made) as f64;
                        start.left_out.pebbles += (count - made) as f64 * pebbles as f64;
                        let room = start.bodies.try_reserve(made as usize);
                        if room
                            .and_then(|()| start.typed_bodies.try_reserve(made as usize))
                            .is_err()
                        {
                            errors.push(no_room(lattice, made));
                            continue;
                        }
                        let mut stream = Stream::new(scene.seed, "lattice", entry as u64);
                        for position in sites(lattice, &mut stream).take(made as usize) {
                            put(&mut start, position);
                        }
                    }
                }
            }
            ParticleSource::Run { folder, at } => {
                let clumps = clumps.unwrap_or_default();
                match take_up(folder, at.as_ref(), scene, clumps, warnings) {
                    Ok((earlier, walls)) => {
                        start.take_up(earlier, &cell, Typed { entry, line: None });
                        start.walls.extend(walls);
                    }
                    Err(error) => errors.push(error),
                }
            }
        }
    }
    match clumps {
        Some(clumps) => {
            let mut id = start.particles.len() as u32;
            for (place, body) in start.bodies.iter().enumerate() {
                let named = named_bodies.iter().find(|(_, body)| *body == place);
                start
                    .named
                    .extend(named.map(|(name, _)| (name.clone(), id)));
                id += clumps[body.clump as usize].pebbles.len() as u32;
            }
        }
        // The scene is refused already.
        None => start.bodies.clear(),
    }
    start
}

/// The numbers that lattices take.
#[derive(Debug, Default)]
struct TakenIds {
    taken: f64,
}

impl TakenIds {
    /// The sites of a lattice with so many spheres on each; none, and an error, if all lattices have more spheres than can be numbered.
    fn take(
        &mut self,
        lattice: &Lattice,
        spheres: usize,
        errors: &mut Vec<SceneError>,
    ) -> Option<u64> {
        let count: f64 = lattice.sites().iter().product();
        let with_others = self.taken + count * spheres as f64;
        // Also of what is no number.
        if with_others <= MOST_SITES {
            self.taken = with_others;
            return Some(count as u64);
        }
        let mut message = format!("has {} sites", short(count));
        if with_others > count {
            message += &format!(", {} spheres with those before it", short(with_others));
        }
        message += &format!(": no more than {} can be numbered", short(MOST_SITES));
        errors.push(lattice.place.error(message).with_help(
            "fewer sites: a larger `spacing`, or a smaller box; are the units of lengths right?",
        ));
        None
    }
}

/// The system gives no memory for a lattice.
fn no_room(lattice: &Lattice, count: u64) -> SceneError {
    let each = size_of::<NewParticle>().max(size_of::<NewBody>()) + size_of::<Typed>();
    let error = lattice.place.error(format!(
        "the system gives no memory for its {} sites, about {}",
        readable::count(count),
        readable::bytes(count as f64 * each as f64)
    ));
    error.with_help("fewer sites: a larger `spacing`, or a smaller box")
}

/// A particle at a place, by its entry.
fn one(values: &ParticleValues, position: DVec3) -> NewParticle {
    let motion = Motion::of(&values.start);
    NewParticle {
        velocity: motion.velocity,
        angular_velocity: motion.angular_velocity,
        fixed: values.start.fixed,
        prescribed: PrescribedMotion::boxed(
            motion.prescribed_velocity,
            motion.prescribed_angular_velocity,
        ),
        ..NewParticle::at(
            position,
            *values.radius,
            mercury_engine::state::MaterialIndex::new(values.material.0 as u32),
        )
    }
}

/// A body of a clump at the origin, with the motion of its entry.
fn moving_body(start: &Start, clump: u32) -> NewBody {
    let motion = Motion::of(start);
    NewBody {
        velocity: motion.velocity,
        angular_velocity: motion.angular_velocity,
        fixed: start.fixed,
        prescribed_velocity: motion.prescribed_velocity,
        prescribed_angular_velocity: motion.prescribed_angular_velocity,
        ..NewBody::at(DVec3::ZERO, clump)
    }
}

/// Motion at the start: prescribed components replace given ones.
struct Motion {
    velocity: DVec3,
    angular_velocity: DVec3,
    prescribed_velocity: [Option<f64>; 3],
    prescribed_angular_velocity: [Option<f64>; 3],
}

impl Motion {
    fn of(start: &Start) -> Self {
        let prescribed = start.prescribed.as_deref();
        let mut motion = Self {
            velocity: *start.velocity,
            angular_velocity: *start.angular_velocity,
            prescribed_velocity: prescribed.map_or([None; 3], |p| p.velocity),
            prescribed_angular_velocity: prescribed.map_or([None; 3], |p| p.angular_velocity),
        };
        for axis in 0..3 {
            if let Some(velocity) = motion.prescribed_velocity[axis] {
                motion.velocity[axis] = velocity;
            }
            if let Some(spin) = motion.prescribed_angular_velocity[axis] {
                motion.angular_velocity[axis] = spin;
            }
        }
        motion
    }
}

fn check_start(start: &Start, errors: &mut Vec<SceneError>) {
    if !start.fixed {
        return;
    }
    let mut complain = |place: &SourceSpan, what: &str| {
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
fn sites<'a>(lattice: &'a Lattice, stream: &'a mut Stream) -> impl Iterator<Item = DVec3> + 'a {
    let [nx, ny, nz] = lattice.sites().map(|count| count as u64);
    (0..nx * ny * nz).map(move |site| {
        let steps = [site % nx, site / nx % ny, site / nx / ny].map(|steps| steps as f64);
        let mut position = *lattice.min + DVec3::from_array(steps) * *lattice.spacing;
        if *lattice.jitter > 0.0 {
            for (axis, count) in [nx, ny, nz].into_iter().enumerate() {
                if count > 1 {
                    position[axis] += stream.uniform_in(-*lattice.jitter, *lattice.jitter);
                }
            }
        }
        position
    })
}

//! Twins of a scene: one for the engine and one for the reference path.

use glam::{DMat3, DVec3};
use mercury_engine::contact::adhesion::dry::Dry;
use mercury_engine::contact::registry::AnyPairLaw;
use mercury_engine::contact::rolling::FrictionSpring;
use mercury_engine::contact::{
    self, AnyAdhesion, AnyRolling, AnyTangential, Luding, NormalLaw as _, SpringRotation,
};
use mercury_engine::step::Engine;
use mercury_engine::walls as fast;
use mercury_solver::plan::{Draft, NewParticle};

use crate::reference::bodies::Body;
use crate::reference::laws::{
    Branch, Cohesion, ContactLaw, Conventions, CoulombLimits, LoadHistory, Normal, Resistance,
    ResistanceStiffness, RollingLever, SlidingNormal, Tangential, TangentialHistory,
};
use crate::reference::state::{Particle, PeriodicBox};
use crate::reference::{Simulation, walls as plain};
use crate::scenes;

/// A wall, twice.
#[derive(Debug, Clone)]
pub struct TwinWall {
    /// For the engine.
    pub fast: fast::Wall,
    /// For the reference path.
    pub plain: plain::Wall,
}

/// The law and the conventions of the reference path that mean the same as a law of the engine.
pub fn reference_law(law: &AnyPairLaw) -> (ContactLaw, Conventions) {
    let mut conventions = Conventions {
        clamp_tension: law.normal.clamps_tension(),
        ..Conventions::default()
    };
    let limits = |limits| match limits {
        contact::CoulombLimits::Bounded => CoulombLimits::Bounded,
        contact::CoulombLimits::Elastic => CoulombLimits::Elastic,
        contact::CoulombLimits::Total => CoulombLimits::Total,
    };
    let mut mindlin = |law: contact::Mindlin, load_history| {
        conventions.coulomb_limits = limits(law.limits);
        Tangential::Mindlin {
            effective_shear_modulus: law.effective_shear_modulus,
            damping: law.damping,
            friction: law.friction,
            static_friction: law.static_friction,
            stiffness_factor: law.stiffness_factor,
            load_history,
        }
    };
    let tangential = match law.tangential {
        AnyTangential::None => Tangential::None,
        AnyTangential::Linear(law) => {
            conventions.coulomb_limits = limits(law.limits);
            conventions.tangential_history = match law.rotation {
                SpringRotation::Project => TangentialHistory::Project,
                SpringRotation::Incremental => TangentialHistory::Incremental,
            };
            Tangential::Linear {
                stiffness: law.stiffness,
                dissipation: law.dissipation,
                friction: law.friction,
                static_friction: law.static_friction,
            }
        }
        AnyTangential::Mindlin(law) => mindlin(law, LoadHistory::Secant),
        AnyTangential::MindlinRescaled(law) => mindlin(law.plain, LoadHistory::Rescale),
    };
    let resistance = |spring: FrictionSpring| Resistance {
        stiffness: spring
            .stiffness
            .map_or(ResistanceStiffness::Sliding, ResistanceStiffness::Fixed),
        dissipation: spring.dissipation,
        friction: spring.friction,
        static_friction: spring.static_friction,
    };
    let (mut rolling, mut torsion) = (None, None);
    if let AnyRolling::Luding(Luding {
        rolling: against_rolling,
        torsion: against_torsion,
        lever,
        ..
    }) = law.rolling
    {
        rolling = Some(resistance(against_rolling));
        torsion = Some(resistance(against_torsion));
        if lever == 2.0 {
            conventions.rolling_lever = RollingLever::EffectiveDiameter;
        }
    }
    let law = ContactLaw {
        normal: Normal::of(&law.normal),
        tangential,
        rolling,
        torsion,
        cohesion: cohesion_of(&law.adhesion),
    };
    (law, conventions)
}

/// Dry cohesion with the parameters of a law of the engine.
fn cohesion_of(law: &AnyAdhesion) -> Cohesion {
    match law.dry() {
        None | Some(Dry::None) => Cohesion::None,
        Some(Dry::Jkr(law)) => Cohesion::Jkr {
            work: law.work_of_adhesion,
            modulus: law.effective_modulus,
        },
        Some(Dry::Pull(law)) => Cohesion::Linear {
            branches: law.branches.map(|branch| Branch {
                force: branch.force,
                per_radius: branch.force_per_radius,
                fall: branch.stiffness,
                sign: branch.sign,
            }),
            after_touch: law.forms_on_contact,
        },
        Some(Dry::VanDerWaals(law)) => Cohesion::VanDerWaals {
            hamaker: law.hamaker,
            separation: law.separation,
            range: law.range,
        },
    }
}

/// The particle of the reference path for one of a plan.
fn reference_particle(new: &NewParticle, plan: &Draft) -> Particle {
    let density = plan.materials[new.material.index()].density;
    let particle = if plan.dimensions == 2 {
        Particle::disc(new.radius, density)
    } else {
        Particle::sphere(new.radius, density)
    };
    let mut particle = particle.placed(new.position, new.velocity, new.angular_velocity);
    particle.material = new.material.index();
    particle.fixed = new.fixed;
    let motion = new.prescribed_motion();
    particle.velocity_held = motion.velocity.map(|value| value.is_some());
    particle.angular_velocity_held = motion.angular_velocity.map(|value| value.is_some());
    particle
}

/// The bodies of a plan, whose pebbles follow its particles in the order of their ids.
fn add_bodies(simulation: &mut Simulation, plan: &Draft) {
    for new in &plan.bodies {
        let clump = new.clump(&plan.clumps);
        let mass = new.mass(&plan.clumps);
        let rotation = DMat3::from_quat(new.orientation);
        let moments = clump.moments * new.scale.powi(5);
        let index = simulation.bodies.len();
        let mut body = Body {
            position: new.position,
            velocity: new.velocity,
            rotation,
            angular_momentum: rotation * (moments * (rotation.transpose() * new.angular_velocity)),
            moments,
            mass,
            pebbles: Vec::new(),
            fixed: new.fixed,
            velocity_held: new.prescribed_velocity.map(|value| value.is_some()),
            angular_velocity_held: new.prescribed_angular_velocity,
            force: DVec3::ZERO,
            torque: DVec3::ZERO,
        };
        for (k, pebble) in clump.pebbles.iter().enumerate() {
            let offset = pebble.position * new.scale;
            let lever = rotation * offset;
            let velocity = new.velocity + new.angular_velocity.cross(lever);
            let sphere = Particle::sphere(pebble.radius * new.scale, 1.0);
            let mut particle = sphere.placed(
                simulation.periodic_box.wrap(new.position + lever),
                velocity,
                new.angular_velocity,
            );
            particle.mass = mass;
            particle.material = clump.material.index();
            particle.fixed = new.fixed;
            particle.body = Some((index, k));
            body.pebbles.push((simulation.particles.len(), offset));
            simulation.particles.push(particle);
        }
        simulation.bodies.push(body);
    }
}

/// The reference path on a plan's scene. The walls of the plan are replaced by `walls`; all laws must share their conventions.
pub fn reference_of(plan: &mut Draft, walls: &[TwinWall]) -> Simulation {
    plan.walls = walls.iter().map(|wall| wall.fast.clone()).collect();
    let count = plan.materials.len();
    let laws: Vec<_> = plan.laws.laws.iter().flatten().map(reference_law).collect();
    assert_eq!(
        laws.len(),
        count * count,
        "every pair of materials has a law"
    );
    let mut simulation = Simulation::new(plan.time_step, laws[0].0);
    simulation.conventions = Conventions {
        startup_increment: plan.startup_increment,
        sliding_normal: match plan.sliding_normal {
            contact::SlidingNormal::HalfStep => SlidingNormal::HalfStep,
            contact::SlidingNormal::Step => SlidingNormal::Step,
        },
        ..laws[0].1
    };
    simulation.pair_parameters = Box::new(move |a, b| laws[a * count + b].0);
    simulation.gravity = plan.gravity;
    let period = plan.cell.size();
    simulation.periodic_box = PeriodicBox {
        min: plan.cell.low(),
        period: [0, 1, 2].map(|axis| plan.cell.is_periodic(axis).then_some(period[axis])),
    };
    simulation.walls = walls.iter().map(|wall| wall.plain.clone()).collect();
    simulation.particles = plan
        .particles
        .iter()
        .map(|new| reference_particle(new, plan))
        .collect();
    simulation.contact_point_mass = plan.contact_point_mass;
    add_bodies(&mut simulation, plan);
    simulation
}

/// Largest difference of the forces (and of the torques over the radii) in the last evaluation, over the largest force; on pebbles and
/// on whole bodies.
pub fn force_difference(engine: &Engine, simulation: &Simulation) -> f64 {
    let (mut largest, mut difference) = (0.0f64, 0.0f64);
    for (id, particle) in simulation.particles.iter().enumerate() {
        let load = engine.particles.loads[scenes::row(engine, id as u32)];
        largest = largest.max(particle.force.length());
        difference = difference.max((load.force - particle.force).length());
        difference = difference.max((load.torque - particle.torque).length() / particle.radius);
    }
    for (index, body) in simulation.bodies.iter().enumerate() {
        let found = &engine.particles.bodies()[index];
        difference = difference.max((found.load.force - body.force).length());
        difference = difference.max((found.load.torque - body.torque).length() / found.radius);
    }
    difference / largest
}

/// Largest difference of the positions over the radius, images counting as the same place.
pub fn position_difference(engine: &Engine, simulation: &Simulation) -> f64 {
    let difference = |(id, particle): (usize, &Particle)| {
        let record = scenes::particle(engine, id as u32);
        let apart: DVec3 = record.position - particle.position;
        simulation.periodic_box.minimum_image(apart).length() / particle.radius
    };
    let particles = simulation.particles.iter().enumerate();
    let of_particles = particles.map(difference).fold(0.0, f64::max);
    let bodies = simulation.bodies.iter().zip(engine.particles.bodies());
    let of_bodies = bodies.map(|(body, found)| {
        let apart = simulation
            .periodic_box
            .minimum_image(found.position - body.position);
        apart.length() / found.radius
    });
    of_bodies.fold(of_particles, f64::max)
}

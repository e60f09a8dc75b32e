//! Properties that no balance of a whole run can see: that a law's energy is the work it gives back, limits and signs of single
//! contacts, critical steps against the pair's own frequency.

use glam::{DVec3, dvec3};
use mercury_common::random::Stream;
use mercury_engine::contact::registry::AnyPairLaw;
use mercury_engine::contact::rolling::FrictionSpring;
use mercury_engine::contact::{
    Action, AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, Contact, CoulombLimits, FrictionNow,
    Hertz, Histories, History, Linear, LinearFriction, Luding, Mindlin, MindlinRescaled, PairLaw,
    PlannedNormal as _, Plastic, Scale, SpringRotation, TangentialLaw,
};
use mercury_engine::forces::Partner;
use mercury_engine::lanes::Vector;
use mercury_engine::walls::{Cylinder, Motion, Shape, Side};
use mercury_solver::plan::Meeting;
use mercury_tests::scenes::{contact_at_rest, observed_step, plan, sphere, start, wall};

type Memory = Histories<AnyNormal, AnyTangential, AnyRolling, AnyAdhesion>;

const OVERLAP: f64 = 2e-4;
const RADIUS: f64 = 5e-3;
const MASS: f64 = 1e-3;
const DT: f64 = 1e-5;

fn law(normal: AnyNormal, tangential: AnyTangential, rolling: AnyRolling) -> AnyPairLaw {
    PairLaw {
        normal,
        tangential,
        rolling,
        adhesion: AnyAdhesion::None,
    }
}

fn hertz() -> AnyNormal {
    AnyNormal::Hertz(Hertz::new(5e6, 0.0))
}

fn plastic() -> AnyNormal {
    AnyNormal::Plastic(Plastic {
        loading_stiffness: 1e4,
        unloading_stiffness: 2e4,
        cohesion_stiffness: 5e3,
        penetration_depth: 0.05,
        dissipation: 0.0,
        clamp_tension: false,
    })
}

/// Without dashpot and with so much friction that nothing slides.
fn tangentials() -> [(&'static str, AnyTangential); 4] {
    let mindlin = |factor| Mindlin::new(1.1e6, factor, 0.0, 1e6, 1e6);
    [
        (
            "linear",
            AnyTangential::Linear(friction(3e3, 0.0, 1e6, CoulombLimits::Bounded)),
        ),
        ("mindlin, 2/3", AnyTangential::Mindlin(mindlin(2.0 / 3.0))),
        ("mindlin, 1", AnyTangential::Mindlin(mindlin(1.0))),
        (
            "rescaled",
            AnyTangential::MindlinRescaled(MindlinRescaled {
                plain: mindlin(2.0 / 3.0),
            }),
        ),
    ]
}

fn friction(stiffness: f64, dissipation: f64, mu: f64, limits: CoulombLimits) -> LinearFriction {
    LinearFriction {
        stiffness,
        dissipation,
        friction: mu,
        static_friction: mu,
        rotation: SpringRotation::Project,
        limits,
    }
}

fn luding(stiffness: Option<f64>, dissipation: f64, (slides, holds): (f64, f64)) -> AnyRolling {
    let spring = FrictionSpring {
        stiffness,
        dissipation,
        friction: slides,
        static_friction: holds,
    };
    AnyRolling::Luding(Luding {
        rolling: spring,
        torsion: spring,
        lever: 1.0,
        rotation: SpringRotation::Project,
    })
}

fn at(overlap: f64) -> Contact {
    contact_at_rest(overlap, RADIUS, MASS)
}

/// A normal law's energy at the deepest overlap is what unloading from there gives back, for as long as it pushes.
#[test]
fn normal_laws_give_back_their_energy() {
    let scale = Scale {
        stiffness: 1e4,
        radius: RADIUS,
        mass: MASS,
    };
    for normal in AnyNormal::examples(&scale) {
        let law = law(normal, AnyTangential::None, AnyRolling::None);
        let mut memory = Memory::default();
        let mut force = |overlap: f64| law.act(&at(overlap), DT, &mut memory).normal.elastic;
        let steps = 10_000;
        let step = OVERLAP / f64::from(steps);
        let mut last = 0.0;
        for k in 1..=steps {
            last = force(f64::from(k) * step);
        }
        let energy = law.energy(&at(OVERLAP), &memory);
        let mut work = 0.0;
        let mut unloading = memory;
        for k in (1..steps).rev() {
            let now = law
                .act(&at(f64::from(k) * step), DT, &mut unloading)
                .normal
                .elastic;
            if now <= 0.0 {
                // Where it ends to push within the step.
                work += 0.5 * last * step * last / (last - now);
                last = 0.0;
                break;
            }
            work += 0.5 * (last + now) * step;
            last = now;
        }
        work += 0.5 * last * step;
        // Trapezoidal rule, 1e-4 of the way each: below 1e-6 also where Hertz' curve begins.
        assert!(
            (work / energy - 1.0).abs() < 1e-6,
            "{normal:?}: {work} J of {energy} J"
        );
    }
}

/// Moves a contact by `velocity` and `spin` for `steps` and returns the work that the springs do on the way.
fn go(
    law: &AnyPairLaw,
    memory: &mut Memory,
    (velocity, spin): (Vector, Vector),
    steps: u32,
    last: &mut Action,
) -> f64 {
    let moving = Contact {
        tangential_velocity: velocity,
        spin,
        ..at(OVERLAP)
    };
    let mut work = 0.0;
    for _ in 0..steps {
        let now = law.act(&moving, DT, memory);
        let force = (now.tangential + last.tangential) * 0.5;
        let couple = (now.couple + last.couple) * 0.5;
        work += (force.dot(velocity) + couple.dot(spin)) * DT;
        *last = now;
    }
    work
}

/// A stretched spring's energy is what it gives back on the way to where it was: against sliding, rolling and torsion, with its own
/// stiffness and with that of the contact.
#[test]
fn springs_give_back_their_energy() {
    let still = Vector::ZERO;
    let mut cases = Vec::new();
    for (name, tangential) in tangentials() {
        cases.push((
            format!("{name}, sliding"),
            law(hertz(), tangential, AnyRolling::None),
            (Vector::new(1e-2, 2e-2, 0.0), still),
        ));
        for stiffness in [None, Some(2e3)] {
            let law = law(hertz(), tangential, luding(stiffness, 0.0, (1e6, 1e6)));
            for (how, spin) in [("rolling", Vector::X), ("torsion", Vector::Z)] {
                cases.push((format!("{name}, {how}, {stiffness:?}"), law, (still, spin)));
            }
        }
    }
    for (name, law, (velocity, spin)) in cases {
        let mut memory = Memory::default();
        let mut last = law.act(&at(OVERLAP), 0.0, &mut memory);
        go(&law, &mut memory, (velocity, spin), 100, &mut last);
        let energy = law.friction_energy(&at(OVERLAP), &memory);
        let work = go(&law, &mut memory, (-velocity, -spin), 100, &mut last);
        assert!(energy > 0.0, "{name}");
        assert!(
            (work / energy - 1.0).abs() < 1e-10,
            "{name}: {work} J of {energy} J"
        );
    }
}

/// Losses of friction along a path are the work put in less the energy of the spring at the end, whatever the overlap did on the
/// way: the losses of the steps add up to it, as each step begins where the one before it ended.
#[test]
fn sliding_losses_of_the_steps_add_up_along_a_path() {
    let slips = AnyTangential::Mindlin(Mindlin::new(1.1e6, 1.0, 0.0, 0.3, 0.3));
    for (name, tangential) in tangentials().into_iter().chain([("slips", slips)]) {
        let law = law(hertz(), tangential, AnyRolling::None);
        let overlap = |k: u32| OVERLAP * (1.0 + 0.5 * (0.03 * f64::from(k)).sin());
        let velocity = Vector::new(1e-2, 2e-2, 0.0);
        let mut memory = Memory::default();
        let (mut put_in, mut lost) = (0.0, 0.0);
        let mut last = FrictionNow::default();
        for k in 1..=300 {
            let now = Contact {
                normal_velocity: (overlap(k - 1) - overlap(k)) / DT,
                tangential_velocity: velocity,
                ..at(overlap(k))
            };
            let action = law.act(&now, DT, &mut memory);
            let friction = law.friction_now(&now, &action, &memory);
            // Each force over half of both steps beside it; the last one over the step before it alone.
            let share = if k == 300 { 0.5 } else { 1.0 };
            put_in -= action.tangential.dot(velocity) * share * DT;
            lost += last.loss_until(&friction, velocity.into(), DT);
            last = friction;
        }
        // Round-off of 300 differences.
        assert!(
            (lost - (put_in - last.stored)).abs() < 1e-12 * (put_in + last.stored),
            "{name}: {lost} J of {put_in} J, {} J stored",
            last.stored
        );
    }
}

/// Tension lets slide by our rule; by the rules of other codes it holds as much as pressure.
#[test]
fn what_pulls_holds_by_the_rules_of_other_codes_only() {
    let (mu, pull) = (0.3, 2.0);
    for (limits, share) in [
        (CoulombLimits::Bounded, 0.0),
        (CoulombLimits::Elastic, 1.0),
        (CoulombLimits::Total, 1.0),
    ] {
        let mindlin = Mindlin::new(1.1e6, 1.0, 0.0, mu, mu).with_limits(limits);
        for tangential in [
            AnyTangential::Linear(friction(3e3, 0.0, mu, limits)),
            AnyTangential::Mindlin(mindlin),
            AnyTangential::MindlinRescaled(MindlinRescaled { plain: mindlin }),
        ] {
            let sliding = Contact {
                tangential_velocity: Vector::X,
                ..at(OVERLAP)
            };
            let mut memory = <AnyTangential as TangentialLaw>::History::default();
            let mut force = Vector::ZERO;
            // 2 mm, where a tenth of it is enough to slide.
            for _ in 0..200 {
                force = tangential.force(&sliding, -pull, DT, &mut memory);
            }
            assert!(
                (force.x + share * mu * pull).abs() < 1e-14,
                "{limits:?}, {tangential:?}: {force:?}"
            );
        }
    }
}

/// Where tension is cut the dashpot does not pull; what pulls by cohesion goes on pulling, and what approaches meanwhile is damped.
#[test]
fn cut_tension_leaves_cohesion() {
    let (AnyNormal::Plastic(mut plastic), gamma) = (plastic(), 2.0) else {
        unreachable!("it is plastic")
    };
    (plastic.clamp_tension, plastic.dissipation) = (true, gamma);
    let law = law(
        AnyNormal::Plastic(plastic),
        AnyTangential::None,
        AnyRolling::None,
    );
    let mut loaded = Memory::default();
    law.act(&at(OVERLAP), DT, &mut loaded);
    // k2 = k1 + (k2max - k1) OVERLAP / (1 mm), where 1 mm = k2max/(k2max - k1) phi 2R*.
    let k2 = 1e4 + 1e4 * OVERLAP / 1e-3;
    let rest = (1.0 - 1e4 / k2) * OVERLAP;
    for overlap in [0.5 * OVERLAP, 0.9 * rest] {
        let elastic = k2 * (overlap - rest);
        for velocity in [-0.02, 0.0, 0.02, 1.0] {
            let mut memory = loaded;
            let contact = Contact {
                normal_velocity: velocity,
                ..at(overlap)
            };
            let found = law.act(&contact, DT, &mut memory).normal.total();
            let expected = (elastic - gamma * velocity).max(elastic.min(0.0));
            assert!(
                (found - expected).abs() < 1e-12,
                "{found} N, not {expected} N at {overlap} m, {velocity} m/s"
            );
        }
    }
}

/// A contact seen from the side of B is the same contact: all forces and couples turn round, step after step, whatever the
/// history.
#[test]
fn a_contact_reported_from_the_other_side_is_the_same() {
    for (name, tangential) in tangentials() {
        let law = law(hertz(), tangential, luding(None, 0.05, (0.1, 0.15)));
        let contact = |turned: bool| {
            let sign = if turned { -1.0 } else { 1.0 };
            Contact {
                normal: Vector::Z * sign,
                tangential_velocity: Vector::new(1e-2, 2e-2, 0.0) * sign,
                sliding_normal: Vector::new(6e-3, 8e-3, (1.0 - 1e-4f64).sqrt()) * sign,
                centre_velocity: Vector::new(1e-2, 0.0, 0.0) * sign,
                spin: Vector::new(0.3, -0.2, 0.4) * sign,
                ..at(OVERLAP)
            }
        };
        let (mut memory, mut turned) = (Memory::default(), Memory::default());
        for k in 0..20 {
            let one = law.act(&contact(false), DT, &mut memory);
            let other = law.act(&contact(true), DT, &mut turned);
            for (what, one, other) in [
                ("force", one.force, other.force),
                ("couple", one.couple, other.couple),
            ] {
                let apart = (one + other).length() / one.length();
                assert!(apart < 1e-12, "{name}, step {k}: {what} {apart:e}");
            }
            // In the next step the other side goes on from what this side remembers.
            turned = memory.swapped();
        }
    }
}

/// Cut as a whole, spring and dashpot together still give just the limit at the same velocity.
#[test]
fn a_spring_that_was_set_back_stands_where_the_sum_is_the_limit() {
    let mu = 0.3;
    let mindlin = Mindlin::new(1.1e6, 2.0 / 3.0, 0.4, mu, mu).with_limits(CoulombLimits::Total);
    for tangential in [
        AnyTangential::Linear(friction(3e3, 0.5, mu, CoulombLimits::Total)),
        AnyTangential::Mindlin(mindlin),
        AnyTangential::MindlinRescaled(MindlinRescaled { plain: mindlin }),
    ] {
        let law = law(hertz(), tangential, AnyRolling::None);
        let sliding = Contact {
            tangential_velocity: Vector::X * 0.3,
            ..at(OVERLAP)
        };
        let mut memory = Memory::default();
        for _ in 0..50 {
            law.act(&sliding, DT, &mut memory);
        }
        // No time goes on: the spring does not move, and the sum is what it was left at.
        let mut again = memory;
        let action = law.act(&sliding, 0.0, &mut again);
        let limit = mu * action.normal.total();
        let force = action.tangential.length();
        assert!((force / limit - 1.0).abs() < 1e-12, "{force} of {limit} N");
        // The spring alone is not at the limit.
        let mut again = memory;
        let alone = law.act(&at(OVERLAP), 0.0, &mut again).tangential.length();
        assert!((alone / limit - 1.0).abs() > 1e-3, "{alone} of {limit} N");
    }
}

/// Rolling and torsion hold up to the static coefficient and fall to the other when they yield.
#[test]
fn rolling_holds_up_to_its_static_limit() {
    let (slides, holds) = (0.1, 0.15);
    let law = law(
        hertz(),
        AnyTangential::None,
        luding(Some(2e3), 0.0, (slides, holds)),
    );
    for spin in [Vector::X, Vector::Z] {
        let turning = Contact {
            spin,
            ..at(OVERLAP)
        };
        let mut memory = Memory::default();
        let (mut most, mut after) = (0.0f64, 0.0);
        for _ in 0..200_000 {
            let action = law.act(&turning, DT, &mut memory);
            let ratio = action.couple.length() / (RADIUS * action.normal.total());
            if ratio < most {
                after = ratio;
                break;
            }
            most = ratio;
        }
        // A step stretches the spring by R* dt = 5e-8 m, 1e-4 N.
        let step = 2e3 * RADIUS * DT / law.act(&at(OVERLAP), DT, &mut memory).normal.total();
        assert!(most <= holds && most > holds - 1.1 * step, "holds {most}");
        assert!((after / slides - 1.0).abs() < 1e-12, "slides at {after}");
    }
}

/// In a cylinder R* is the geometric mean of the effective radii in its two principal planes: R along the axis, 1/(1/R - 1/R_c) across
/// (Johnson 1985, eq. 4.28). Across a cylinder that hardly is wider it is bounded.
#[test]
fn a_cylinder_curves_hertz_contacts_by_the_geometric_mean() {
    let (radius, overlap) = (0.01, 1e-5);
    for (side, cylinder, across) in [
        (Side::Inside, 0.04, 1.0 / (1.0 / radius - 1.0 / 0.04)),
        (Side::Outside, 0.04, 1.0 / (1.0 / radius + 1.0 / 0.04)),
        // 21 radii, and ten at the most.
        (Side::Inside, 0.0105, 10.0 * radius),
    ] {
        let mut plan = plan(
            1e-6,
            2500.0,
            law(hertz(), AnyTangential::None, AnyRolling::None),
        );
        plan.wall_curvature = true;
        let shape = Cylinder::new(DVec3::Z, DVec3::ZERO, cylinder, None, side).unwrap();
        plan.walls
            .push(wall(Shape::Cylinder(shape), Motion::default()));
        let x = match side {
            Side::Inside => cylinder - radius + overlap,
            _ => cylinder + radius - overlap,
        };
        let ball = sphere(x * DVec3::X, radius, DVec3::ZERO, DVec3::ZERO);
        let engine = start(plan.with_particles(vec![ball]));
        let effective = (radius * across).sqrt();
        let expected = 4.0 / 3.0 * 5e6 * effective.sqrt() * overlap.powf(1.5);
        let found = engine.particles.loads[0].force.x.abs();
        // The overlap is a difference of lengths a thousand times larger.
        assert!(
            (found / expected - 1.0).abs() < 1e-10,
            "{found} of {expected} N"
        );
    }
}

/// The critical step is 2/w with w^2 the eigenvalue of the pair: what a small displacement of its spring does to the two bodies, measured on
/// the law itself, over their inertias.
#[test]
fn critical_steps_are_those_of_the_pairs_eigenvalue() {
    let (radii, masses): ([f64; 2], [f64; 2]) = ([4e-3, 7e-3], [1e-3, 3e-3]);
    let inertias = [0, 1].map(|k| 0.4 * masses[k] * radii[k] * radii[k]);
    let meeting = Meeting::new((radii[0], masses[0]), (radii[1], masses[1]), 3);
    let soft = AnyNormal::Linear(Linear::new(1.0, 0.0));
    let overlap = 0.1 * meeting.effective_radius;
    let contact = contact_at_rest(overlap, meeting.effective_radius, meeting.effective_mass);
    let small = 1e-9;
    // Against sliding. The contact point of each side moves by F (1/m + R^2/I).
    let mindlin = Mindlin::new(1e6, 2.0 / 3.0, 0.0, 1e9, 1e9);
    let sliding = law(soft, AnyTangential::Mindlin(mindlin), AnyRolling::None);
    let pulled = Contact {
        tangential_velocity: Vector::X * small,
        ..contact
    };
    let action = sliding.act(&pulled, 1.0, &mut Memory::default());
    let mobility: f64 = (0..2)
        .map(|k| 1.0 / masses[k] + radii[k] * radii[k] / inertias[k])
        .sum();
    let squared = action.tangential.length() / small * mobility;
    let (time, part) = meeting.critical_step(&sliding, 0.1, true);
    assert_eq!(part, "tangential");
    assert!((time * squared.sqrt() / 2.0 - 1.0).abs() < 1e-9, "{time}");
    // Against rolling and torsion: couples turn each side by 1/I. With a spring of its own, and with Mindlin's.
    for stiffness in [Some(1e8), None] {
        let tangential = match stiffness {
            Some(_) => AnyTangential::None,
            None => AnyTangential::Mindlin(Mindlin::new(1e6, 1e-9, 0.0, 1e9, 1e9)),
        };
        let turning = law(soft, tangential, luding(stiffness, 0.0, (1e9, 1e9)));
        for (spin, part) in [(Vector::X, "rolling"), (Vector::Z, "torsion")] {
            let turned = Contact {
                spin: spin * small,
                ..contact
            };
            let action = turning.act(&turned, 1.0, &mut Memory::default());
            let rate = 1.0 / inertias[0] + 1.0 / inertias[1];
            let squared = action.couple.length() / small * rate;
            let (time, found) = meeting.critical_step(&turning, 0.1, true);
            assert!(found == "rolling" || found == "torsion", "{found}");
            let ratio = time * squared.sqrt() / 2.0;
            assert!((ratio - 1.0).abs() < 1e-9, "{part}, {stiffness:?}: {ratio}");
        }
    }
}

/// A record of a contact holds the load on the particle of the lower id, whichever comes first in memory: its torque is the
/// couple and the moment of the force at the point, for unequal radii. Pairs far from each other, turned every way, so that some
/// of each kind lie across cells.
#[test]
fn records_tell_of_the_lower_id_wherever_it_lies() {
    let normal = AnyNormal::Linear(Linear::new(1e4, 0.5));
    let tangential = AnyTangential::Linear(friction(3e3, 0.2, 0.5, CoulombLimits::Bounded));
    let law = law(normal, tangential, luding(Some(2e3), 0.1, (0.2, 0.2)));
    let mut random = Stream::new(4, "pairs", 0);
    let mut vector = || dvec3(random.uniform(), random.uniform(), random.uniform()) - 0.5;
    let pairs = (0..64u32).flat_map(|k| {
        let site = dvec3(f64::from(k % 4), f64::from(k / 4 % 4), f64::from(k / 16));
        let middle = 0.05 * site + 0.01 * vector();
        let branch = vector().normalize() * (0.005 + 0.008 - 2e-4);
        // By turns the larger one has the lower id.
        let radii = if k % 2 == 0 {
            [0.005, 0.008]
        } else {
            [0.008, 0.005]
        };
        [0, 1].map(|side| {
            let place = middle + branch * (side as f64 - 0.5);
            sphere(place, radii[side], 0.2 * vector(), 20.0 * vector())
        })
    });
    let plan = plan(1e-5, 2500.0, law).with_particles(pairs.collect());
    let mut engine = start(plan);
    for _ in 0..20 {
        observed_step(&mut engine);
    }
    let records = engine.observation().records;
    assert_eq!(records.len(), 64);
    let mut swapped = [0, 0];
    for record in &records {
        let Partner::Particle { row: other, .. } = record.partner else {
            panic!("no walls")
        };
        let (lower, other) = (record.row as usize, other as usize);
        let ids = &engine.particles.ids;
        assert!(ids[lower] < ids[other]);
        let (particle, load) = (
            engine.particles.records[lower],
            engine.particles.loads[lower],
        );
        let is_larger = particle.radius > engine.particles.records[other].radius;
        swapped[usize::from(is_larger)] += usize::from(lower > other);
        assert!(record.couple.length() > 1e-9 && record.tangential.length() > 1e-4);
        let arm = record.point - particle.position;
        let torque = record.couple + arm.cross(record.force);
        assert!((record.force - load.force).length() < 1e-12 * load.force.length());
        // Places of 0.2 m are known to 3e-17 m, of an arm of 5 mm.
        assert!(
            (torque - load.torque).length() < 1e-12 * load.torque.length(),
            "{torque} and {}",
            load.torque
        );
        // Half of the overlap inside the surface, on the way to the other centre.
        let expected = -(particle.radius - 0.5 * record.overlap) * record.normal;
        assert!((arm - expected).length() < 1e-15);
    }
    assert!(
        swapped[0] > 5 && swapped[1] > 5,
        "{swapped:?} come last in memory"
    );
}

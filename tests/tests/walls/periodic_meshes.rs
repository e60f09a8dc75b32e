//! Mesh walls that span a period of a periodic axis are endless: at the seam a ball feels what it feels anywhere else.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DVec3, dvec3};
use mercury_common::formats::mesh::TriangleMesh;
use mercury_common::random::Stream;
use mercury_engine::contact::registry::AnyPairLaw;
use mercury_engine::contact::{
    AnyAdhesion, AnyNormal, AnyRolling, AnyTangential, Hertz, Linear, Mindlin, PairLaw,
};
use mercury_engine::state::volume;
use mercury_engine::step::Engine;
use mercury_engine::walls::{
    Component, Cylinder, Disc, Mesh, Motion, Plane, Shape, Side, Touches, Wall,
};
use mercury_solver::plan::{Draft, NewParticle, PrescribedMotion};
use mercury_tests::scenes::{advance, frictionless, particle, row, sphere, start, wall};

const RADIUS: f64 = 0.005;
const PERIOD: f64 = 0.04;

/// A square of one period, cut up irregularly, but alike at opposite sides; its lower corner at `low` (m).
fn square(low: DVec3) -> TriangleMesh {
    const CELLS: u32 = 7;
    let mut random = Stream::new(3, "square", 0);
    let mut mesh = TriangleMesh::default();
    let mut at_sides = [[0.0; CELLS as usize + 1]; 2];
    for place in at_sides
        .iter_mut()
        .flat_map(|side| &mut side[1..CELLS as usize])
    {
        *place = 0.8 * (random.uniform() - 0.5);
    }
    for j in 0..=CELLS {
        for i in 0..=CELLS {
            let mut inside = || 0.8 * (random.uniform() - 0.5);
            let is_end = |k: u32| k == 0 || k == CELLS;
            let shift = match (is_end(i), is_end(j)) {
                (true, _) => dvec3(0.0, at_sides[0][j as usize], 0.0),
                (_, true) => dvec3(at_sides[1][i as usize], 0.0, 0.0),
                _ => dvec3(inside(), inside(), 0.0),
            };
            let cell = dvec3(f64::from(i), f64::from(j), 0.0);
            mesh.vertices
                .push(low + (cell + shift) * (PERIOD / f64::from(CELLS)));
        }
    }
    for j in 0..CELLS {
        for i in 0..CELLS {
            let a = j * (CELLS + 1) + i;
            let [b, c, d] = [a + 1, a + CELLS + 2, a + CELLS + 1];
            let at = |k: u32| mesh.vertices[k as usize];
            let area = |p, q, r| (at(q) - at(p)).cross(at(r) - at(p)).z;
            if area(a, b, c) > 0.0 && area(a, c, d) > 0.0 {
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            } else {
                mesh.triangles.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    mesh
}

fn endless(triangles: &TriangleMesh, axes: &[usize], motion: Motion) -> Wall {
    let mesh = Mesh::new(triangles, |x| x, false).unwrap();
    let periods: Vec<_> = axes.iter().map(|&axis| (axis, 0.0, PERIOD)).collect();
    let mesh = mesh.continued(&periods, 2.1 * RADIUS).unwrap();
    assert_eq!(mesh.periods().len(), axes.len());
    wall(Shape::Mesh(Arc::new(mesh)), motion)
}

fn mindlin() -> AnyPairLaw {
    let modulus = 1e5;
    PairLaw {
        normal: AnyNormal::Hertz(Hertz::new(modulus, 0.1)),
        tangential: AnyTangential::Mindlin(Mindlin::new(0.3 * modulus, 1.0, 0.1, 0.3, 0.35)),
        rolling: AnyRolling::None,
        adhesion: AnyAdhesion::None,
    }
}

fn periodic(law: AnyPairLaw, axes: [bool; 3]) -> Draft {
    let domain = (dvec3(0.0, 0.0, -PERIOD), dvec3(PERIOD, PERIOD, PERIOD));
    let mut plan = Draft::new(1e-5, domain, 2500.0, law);
    plan.cell = plan.cell.with_periodic(axes);
    plan
}

fn moved_by(velocity: DVec3, amplitude: DVec3) -> Motion {
    let slide = Component::Translation {
        velocity,
        from: 0.0,
        until: f64::INFINITY,
    };
    let shake = Component::Oscillation {
        amplitude,
        frequency: 15.0,
        phase: 0.3,
        from: 0.0,
        until: f64::INFINITY,
    };
    Motion::new(vec![slide, shake]).unwrap()
}

/// The largest difference of the forces on the balls of two runs over `steps` steps, over the largest force.
fn difference(one: &mut Engine, other: &mut Engine, steps: u32) -> f64 {
    let (mut largest, mut size) = (0.0f64, 0.0f64);
    for _ in 0..steps {
        advance(one, 1);
        advance(other, 1);
        for id in 0..one.particles.len() as u32 {
            let force = |engine: &Engine| engine.particles.loads[row(engine, id)].force;
            size = size.max(force(other).length());
            largest = largest.max((force(one) - force(other)).length());
        }
    }
    largest / size
}

/// Balls slide and roll over both seams and their crossing, on a floor that rests, oscillates, or travels through many periods;
/// the mesh lies in the domain or half a period beside it.
#[test]
fn a_floor_of_one_period_is_an_endless_plane() {
    let (low, fast) = (dvec3(-0.5, 0.3, 0.0) * PERIOD, dvec3(4.0, -1.5, 0.0));
    for (low, periods, velocity, amplitude) in [
        (DVec3::ZERO, 1.0, DVec3::ZERO, DVec3::ZERO),
        (low, 1.0, DVec3::ZERO, DVec3::ZERO),
        (DVec3::ZERO, 1.0, fast, DVec3::ZERO),
        (
            dvec3(-0.5, 0.0, 0.0) * PERIOD,
            1.0,
            dvec3(-0.7, 0.0, 0.0),
            dvec3(0.01, 0.002, 1e-4),
        ),
        (low, 1.6, DVec3::ZERO, DVec3::ZERO),
        (5.0 * low, 2.3, fast, DVec3::ZERO),
    ] {
        let begin = |wall: Wall| {
            let mut plan = periodic(mindlin(), [true, true, false]);
            plan.gravity = dvec3(0.0, 0.0, -9.81);
            plan.walls.push(wall);
            let overlap =
                (0.75 * 2500.0 * volume(RADIUS, 3) * 9.81 / (1e5 * RADIUS.sqrt())).powf(2.0 / 3.0);
            let ball = |x: f64, y: f64, velocity: DVec3, spin: DVec3| {
                sphere(
                    dvec3(x * PERIOD, y * PERIOD, RADIUS - overlap),
                    RADIUS,
                    velocity,
                    spin,
                )
            };
            start(plan.with_particles(vec![
                ball(0.95, 0.97, dvec3(0.6, 0.5, 0.0), dvec3(0.0, 30.0, 50.0)),
                ball(0.02, 0.5, dvec3(-0.5, 0.1, 0.0), dvec3(10.0, -100.0, 0.0)),
                // It rolls slowly along the seam with most of its spring kept.
                ball(0.5, 0.0, dvec3(0.1, 1e-3, 0.0), dvec3(0.0, 20.0, 0.0)),
            ]))
        };
        let motion = || {
            if velocity == DVec3::ZERO {
                Motion::default()
            } else {
                moved_by(velocity, amplitude)
            }
        };
        let plane = Plane::new(DVec3::ZERO, DVec3::Z).unwrap();
        let mut flat = begin(wall(Shape::Plane(plane), motion()));
        let mut floor = square(low);
        for vertex in &mut floor.vertices {
            *vertex = low + periods * (*vertex - low);
        }
        let mut tessellated = begin(endless(&floor, &[0, 1], motion()));
        let worst = difference(&mut tessellated, &mut flat, 4000);
        // Round-off of 1e-17 m beside an overlap of 1e-4 m, grown over 4,000 steps.
        assert!(worst < 1e-9, "{low} {velocity}: {worst}");
        if velocity == DVec3::ZERO {
            let along = particle(&tessellated, 0).position;
            assert!(along.x < 0.6 * PERIOD, "it has crossed the seam: {along}");
        } else {
            // The pose stays within half a period: where the mesh is seen, and where contacts are looked for.
            let pose = tessellated.walls()[0].state.pose.translation;
            let limit = 0.501 * PERIOD;
            assert!(pose.x.abs() < limit && pose.y.abs() < limit, "{pose}");
        }
    }
}

/// A tube of 48 facets along y, of radius 0.4 periods about the middle of the domain in x and z = 0; each ring is turned against the
/// one before by `twist` facets, the last one lies as the first.
fn tube(rings: u32, twist: f64) -> TriangleMesh {
    const FACETS: u32 = 48;
    let (radius, mut mesh) = (0.4 * PERIOD, TriangleMesh::default());
    for ring in 0..=rings {
        for k in 0..FACETS {
            let twist = if ring == rings {
                0.0
            } else {
                twist * f64::from(ring)
            };
            let (sin, cos) = (TAU * (f64::from(k) + twist) / f64::from(FACETS)).sin_cos();
            let place = dvec3(
                radius * cos,
                PERIOD * f64::from(ring) / f64::from(rings),
                radius * sin,
            );
            mesh.vertices.push(place + 0.5 * PERIOD * DVec3::X);
        }
    }
    for ring in 0..rings {
        for k in 0..FACETS {
            let a = ring * FACETS + k;
            let b = ring * FACETS + (k + 1) % FACETS;
            mesh.triangles
                .extend([[a, b, b + FACETS], [a, b + FACETS, a + FACETS]]);
        }
    }
    mesh
}

/// A tube along the periodic axis that turns about it and travels along it. It has facets, so it is compared with itself in the
/// middle: with the same tube, cut apart elsewhere and put together again.
#[test]
fn a_tube_has_no_seam() {
    let shifted = |triangles: &TriangleMesh, by: f64| {
        let mut moved = triangles.clone();
        // Rings are equal, so that the tube cut elsewhere is the same tube.
        for vertex in &mut moved.vertices {
            vertex.y += by;
        }
        moved
    };
    let turn = Component::Rotation {
        axis: -DVec3::Y,
        origin: 0.5 * PERIOD * DVec3::X,
        angular_velocity: 9.0,
        from: 0.0,
        until: f64::INFINITY,
    };
    let slide = Component::Translation {
        velocity: 3.0 * DVec3::Y,
        from: 0.0,
        until: f64::INFINITY,
    };
    let motion = Motion::new(vec![turn, slide]).unwrap();
    assert!(motion.keeps_axis(1) && !motion.keeps_axis(0));
    let begin = |triangles: &TriangleMesh| {
        let mut plan = periodic(mindlin(), [false, true, false]);
        plan.gravity = dvec3(1.0, 0.4, -9.81);
        plan.walls.push(endless(triangles, &[1], motion.clone()));
        start(plan.with_particles(vec![
            sphere(
                dvec3(0.5 * PERIOD, 0.03, -0.27 * PERIOD),
                RADIUS,
                dvec3(0.1, 1.0, 0.0),
                DVec3::ZERO,
            ),
            sphere(
                dvec3(0.6 * PERIOD, 0.01, 0.1 * PERIOD),
                RADIUS,
                dvec3(0.4, -0.6, 0.3),
                DVec3::ZERO,
            ),
        ]))
    };
    let mut one = begin(&tube(5, 0.0));
    let mut other = begin(&shifted(&tube(5, 0.0), 0.4 * PERIOD));
    let worst = difference(&mut one, &mut other, 4000);
    // The balls bounce: round-off grows with every impact.
    assert!(worst < 1e-7, "{worst}");
    // A twisted tube, whose edges run across: its first and last rings are joined all the same.
    let mesh = Mesh::new(&tube(5, 0.3), |x| x, false).unwrap();
    let mesh = mesh.continued(&[(1, 0.0, PERIOD)], 2.1 * RADIUS).unwrap();
    assert_eq!(mesh.edge_counts(), [0, 3 * 48 * 5, 0]);
}

/// An elastic ball between a floor and a ceiling of one period each keeps its energy through hundreds of impacts at the seam.
#[test]
fn energy_is_kept_at_the_seam() {
    let law = frictionless(AnyNormal::Linear(Linear::new(1e4, 0.0)));
    let mut plan = periodic(law, [true, true, false]);
    let lifted = |z: f64| {
        let mut mesh = square(DVec3::ZERO);
        mesh.vertices.iter_mut().for_each(|x| x.z = z);
        endless(&mesh, &[0, 1], Motion::default())
    };
    plan.walls.extend([lifted(0.0), lifted(0.5 * PERIOD)]);
    let ball = sphere(
        dvec3(0.0, 0.0, 0.01),
        RADIUS,
        dvec3(0.03, -0.02, 1.0),
        DVec3::ZERO,
    );
    let mut engine = start(plan.with_particles(vec![ball]));
    let before = particle(&engine, 0).velocity;
    let mut impacts = 0;
    let mut last = before.z;
    for _ in 0..20_000 {
        advance(&mut engine, 1);
        let velocity = particle(&engine, 0).velocity;
        impacts += u32::from(velocity.z * last < 0.0);
        last = velocity.z;
        // The seam gives no push along the floor.
        assert!(
            (velocity - before).abs().truncate().max_element() < 1e-12,
            "{velocity}"
        );
    }
    // 20 mm of height less a diameter are 10 ms of way, and a contact takes pi/2764 s: 18 in 0.2 s.
    assert!(impacts >= 17, "{impacts}");
    let energy = particle(&engine, 0).velocity.length_squared() / before.length_squared();
    // omega = sqrt(1e4 N/m / 1.3 g) = 2764/s: a contact begins and ends within a step, (omega dt)^2/4 = 2e-4 of the energy each time,
    // at random in sign.
    assert!((energy - 1.0).abs() < f64::from(impacts) * 2e-4, "{energy}");
}

/// A ball on a slope is carried by its spring alone, on a belt that goes round every 20 ms.
#[test]
fn springs_survive_the_wrap_of_the_mesh() {
    let speed = 2.0;
    let begin = |wall: Wall| {
        let mut plan = periodic(mindlin(), [true, true, false]);
        plan.gravity = dvec3(1.0, 0.0, -9.81);
        plan.walls.push(wall);
        let ball = NewParticle {
            prescribed: PrescribedMotion::boxed([None; 3], [Some(0.0); 3]),
            ..sphere(
                dvec3(0.01, 0.01, RADIUS - 1e-4),
                RADIUS,
                speed * DVec3::X,
                DVec3::ZERO,
            )
        };
        start(plan.with_particles(vec![ball]))
    };
    let motion = || moved_by(speed * DVec3::X, DVec3::ZERO);
    let plane = Plane::new(DVec3::ZERO, DVec3::Z).unwrap();
    let mut flat = begin(wall(Shape::Plane(plane), motion()));
    let mut belt = begin(endless(&square(DVec3::ZERO), &[0, 1], motion()));
    let worst = difference(&mut belt, &mut flat, 16_000);
    assert!(worst < 1e-9, "{worst}");
    // The slope is below the angle of friction, so the ball stays with the belt.
    let carried = particle(&belt, 0).velocity.x - speed;
    assert!(carried.abs() < 0.01, "{carried}");
}

/// An analytic cylinder for scale: the ball in the tube is where the ball in the cylinder is, to the error of the facets.
#[test]
fn a_tube_is_a_cylinder_to_the_error_of_its_facets() {
    let begin = |wall: Wall| {
        let mut plan = periodic(mindlin(), [false, true, false]);
        plan.gravity = dvec3(0.0, 0.5, -9.81);
        plan.walls.push(wall);
        let ball = sphere(
            dvec3(0.5 * PERIOD, 0.035, -0.27 * PERIOD),
            RADIUS,
            dvec3(0.0, 0.3, 0.0),
            DVec3::ZERO,
        );
        start(plan.with_particles(vec![ball]))
    };
    let middle = dvec3(0.5 * PERIOD, 0.0, 0.0);
    let cylinder = Cylinder::new(DVec3::Y, middle, 0.4 * PERIOD, None, Side::Inside).unwrap();
    let mut round = begin(wall(Shape::Cylinder(cylinder), Motion::default()));
    let mut faceted = begin(endless(&tube(5, 0.0), &[1], Motion::default()));
    advance(&mut round, 10_000);
    advance(&mut faceted, 10_000);
    let [a, b] = [&round, &faceted].map(|engine| particle(engine, 0));
    // 30 mm and more along the axis, through the seam. The facets are up to R (1 - cos pi/48) = 34 micrometres off.
    let sagitta = 0.4 * PERIOD * (1.0 - (0.5 * TAU / 48.0).cos());
    assert!(
        (a.velocity.y - b.velocity.y).abs() < 0.02 * a.velocity.y,
        "{a:?} {b:?}"
    );
    assert!(
        (a.position.z - b.position.z).abs() < 3.0 * sagitta,
        "{a:?} {b:?}"
    );
}

/// A wall that ends inside the domain and lies across the face: the springs of a ball on it go on when the ball is wrapped.
#[test]
fn a_plate_across_the_face_is_a_plate() {
    let begin = |x: f64| {
        let mut plan = periodic(mindlin(), [true, false, false]);
        plan.gravity = dvec3(0.0, 0.0, -9.81);
        let plate = Disc::new(DVec3::Z, dvec3(x, 0.02, 0.0), 0.01).unwrap();
        plan.walls.push(wall(Shape::Disc(plate), Motion::default()));
        let ball = sphere(
            dvec3(x - 0.004, 0.02, RADIUS - 1e-5),
            RADIUS,
            0.1 * DVec3::X,
            DVec3::ZERO,
        );
        start(plan.with_particles(vec![ball]))
    };
    let mut across = begin(0.0);
    let mut inside = begin(0.5 * PERIOD);
    let worst = difference(&mut across, &mut inside, 8000);
    assert!(worst < 1e-9, "{worst}");
    let x = particle(&across, 0).position.x;
    assert!((0.0005..0.006).contains(&x), "it has crossed the face: {x}");
}

/// A mesh that goes on for ever is there beyond its faces as far as was requested, on either side.
#[test]
fn copies_reach_as_far_as_requested() {
    for (plate, centre) in [(0.7, 0.05), (0.3, 0.95)] {
        // A floor of one period, far below, and a plate across it.
        let floor = |x: f64, y: f64| dvec3(x, y, -5.0);
        let upright = |y: f64, z: f64| dvec3(plate, y, z);
        let triangles = [
            [floor(0.0, -1.0), floor(1.0, -1.0), floor(1.0, 1.0)],
            [floor(0.0, -1.0), floor(1.0, 1.0), floor(0.0, 1.0)],
            [upright(-1.0, -1.0), upright(1.0, -1.0), upright(1.0, 1.0)],
            [upright(-1.0, -1.0), upright(1.0, 1.0), upright(-1.0, 1.0)],
        ];
        let mesh = Mesh::new(&TriangleMesh::from_corners(&triangles), |x| x, false).unwrap();
        let endless = mesh.continued(&[(0, 0.0, 1.0)], 0.4).unwrap();
        let mut touches = Touches::new();
        Shape::Mesh(Arc::new(endless)).touches(dvec3(centre, 0.1, 0.2), 0.38, &mut touches);
        assert_eq!(touches.len(), 1, "plate at {plate}");
        let distance = touches.as_slice()[0].distance;
        assert!((distance - 0.35).abs() < 1e-15, "{distance}");
    }
}

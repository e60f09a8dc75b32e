//! T23: walls that wear. Scenes are `scenes/wear/wear-plate.toml` with some keys replaced; its ball of 5 mm is drawn over a plate and presses with its weight.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use glam::{DVec3, dvec3};
use mercury_common::formats::mesh::{TriangleMesh, push_obj};
use mercury_common::formats::number::NumberStyle;
use mercury_engine::forces::Partner;
use mercury_engine::step::Engine;
use mercury_engine::wear::WearRow;
use mercury_solver::plan::{Plan, plan, read_scene};

use super::Case;
use super::Tolerance::{Absolute, Relative};
use crate::scenes::{RECORDS, start_planned};

const RADIUS: f64 = 5e-3;
const DENSITY: f64 = 5000.0;
const GRAVITY: f64 = 9.81;
const FRICTION: f64 = 0.3;
/// a K/H of the scene, 1/Pa.
const RATE: f64 = 1e3 * 1e-3 / 1e6;
/// Way of the ball in the scene, m: 0.05 m/s for 1 s.
const WAY: f64 = 0.05;

fn mass() -> f64 {
    DENSITY * 4.0 / 3.0 * PI * RADIUS * RADIUS * RADIUS
}

fn weight() -> f64 {
    mass() * GRAVITY
}

/// Worn volume of the scene by Archard's law, m^3.
fn archard(way: f64) -> f64 {
    RATE * weight() * way
}

fn scene() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/wear/wear-plate.toml")
}

fn planned(changes: &[String]) -> Plan {
    let scene = read_scene(&scene(), changes).unwrap_or_else(|errors| panic!("{errors}"));
    plan(&scene).unwrap_or_else(|errors| panic!("{errors}"))
}

/// A run to its end.
struct Ran {
    row: WearRow,
    /// Displacements of the vertices by their numbers, m.
    ways: Vec<(u32, DVec3)>,
    engine: Engine,
}

impl Ran {
    /// The scene with these keys replaced.
    fn new(changes: &[&str]) -> Self {
        let changes: Vec<String> = changes.iter().map(|&change| change.to_owned()).collect();
        let plan = planned(&changes);
        let steps = plan.physics().steps;
        let mut engine = start_planned(plan);
        engine
            .steps_at_once(steps, None)
            .expect("the motion stays finite");
        Self::of(engine)
    }

    fn of(engine: Engine) -> Self {
        let worn = &engine.wear().expect("a wall wears").walls[0];
        Self {
            row: worn.row(),
            ways: (worn.vertices())
                .map(|vertex| (vertex.vertex, vertex.displacement))
                .collect(),
            engine,
        }
    }

    /// The largest difference of the lengths of displacements, over the largest depth.
    fn differs_from(&self, other: &Self) -> f64 {
        let length = |all: &[(u32, DVec3)], vertex: u32| {
            let found = all.iter().find(|(other, _)| *other == vertex);
            found.map_or(0.0, |(_, way)| way.length())
        };
        let both = self.ways.iter().chain(&other.ways);
        let differences = both
            .map(|&(vertex, _)| (length(&self.ways, vertex) - length(&other.ways, vertex)).abs());
        differences.fold(0.0, f64::max) / other.row.max_depth
    }

    /// The volume between the plate of the file and the present one by the divergence theorem, whose rim has not moved, m^3.
    fn volume_below(&self) -> f64 {
        let mesh = self.engine.walls()[0].shape().mesh().expect("a mesh");
        let corners = mesh.corners();
        let of_triangle = |triangle: [u32; 3]| {
            let [a, b, c] = triangle.map(|k| corners[k as usize]);
            // About a point in the plane of the plate.
            -a.dot(b.cross(c)) / 6.0
        };
        mesh.triangles().into_iter().map(of_triangle).sum()
    }
}

/// Normal forces at walls by their features, N.
fn loads(engine: &Engine) -> Vec<(u32, f64)> {
    let records = engine.observation().records;
    let at_walls = (records.iter()).filter(|record| matches!(record.partner, Partner::Wall { .. }));
    at_walls
        .map(|record| (record.feature, record.force.dot(record.normal).abs()))
        .collect()
}

/// Owed volume over the run's own sum of |F_n| |v_t| dt over contacts and steps, F_n the mean of the forces at both ends of a step, with these keys
/// replaced; the way of the wall is `wall_velocity` of place and time.
fn own_sum(changes: &[&str], wall_velocity: impl Fn(DVec3, f64) -> DVec3) -> f64 {
    let changes: Vec<String> = changes.iter().map(|&change| change.to_owned()).collect();
    let plan = planned(&changes);
    let (steps, dt) = (plan.physics().steps, plan.physics().time_step);
    let mut engine = start_planned(plan);
    let mut sum = 0.0;
    let mut before = loads(&engine);
    for _ in 0..steps {
        engine.step(RECORDS).expect("the motion stays finite");
        let now = loads(&engine);
        // A contact that is new goes on from one that is gone, if there is one: it has passed to the next triangle.
        let mut gone = before.clone();
        gone.retain(|(feature, _)| !now.iter().any(|(other, _)| other == feature));
        // In the middle of the kicks: the velocity that the contact has seen, half a step before.
        let velocity = engine.particles.records[0].velocity;
        let time = engine.time() - 0.5 * dt;
        for record in &engine.observation().records {
            if !matches!(record.partner, Partner::Wall { .. }) {
                continue;
            }
            let earlier = record.point - velocity * (0.5 * dt);
            let relative = velocity - wall_velocity(earlier, time);
            let normal = record.normal;
            let along = relative - normal * relative.dot(normal);
            let own = (before.iter()).find(|(feature, _)| *feature == record.feature);
            let last = own.copied().or_else(|| gone.pop());
            let load = record.force.dot(normal).abs() + last.map_or(0.0, |(_, load)| load);
            sum += 0.5 * load * along.length() * dt;
        }
        before = now;
    }
    let row = engine.wear().expect("a wall wears").walls[0].row();
    row.owed / (RATE * sum)
}

const AT_REST: &str = "particles.slider.prescribed={ velocity = [0.0, 0.0, \"free\"], angular_velocity = [0.0, 0.0, 0.0] }";
/// The automatic step follows from the domain, which is another one in some scenes.
const STEP: &str = "time.step=3.125e-5";
const STILL: &str = "particles.slider.velocity=[0.0, 0.0, 0.0]";
const FREE: &str = "particles.slider.prescribed={ velocity = [\"free\", \"free\", \"free\"], angular_velocity = [\"free\", \"free\", \"free\"] }";

const BASES: [&str; 3] = ["normal-load", "sliding", "friction-work"];

fn basis(name: &str) -> String {
    format!("walls.plate.wear.basis={name}")
}

/// Owed volumes with nothing that slides, by basis, over that of the scene.
fn idle(changes: &[&str], name: &str) -> f64 {
    let basis = basis(name);
    let mut all = vec![basis.as_str(), "time.end=0.3"];
    all.extend(changes);
    Ran::new(&all).row.owed / archard(WAY)
}

/// Worn volume of a ball that bounces off the plate at an angle: the law of friction work over the energy audit; `part` of the
/// automatic step.
fn oblique_bounce(part: f64) -> f64 {
    let basis = basis("friction-work");
    let mut changes: Vec<String> = [
        FREE,
        &basis,
        "walls.plate.wear.moves=false",
        "particles.slider.position=[0.05, 0.0007, 0.0052]",
        "particles.slider.velocity=[0.1, 0.0, -0.3]",
        "output.energy_budget=true",
        "time.end=0.01",
    ]
    .map(str::to_owned)
    .to_vec();
    let step = part * planned(&changes).physics().time_step;
    changes.push(format!("time.step={step}"));
    let plan = planned(&changes);
    let steps = plan.physics().steps;
    let mut engine = start_planned(plan);
    engine
        .steps_at_once(steps, None)
        .expect("the motion stays finite");
    let lost = engine.audit().losses.of("tangential");
    Ran::of(engine).row.owed / (RATE * lost)
}

/// A ball over a plate that turns about an axis 30 mm beside it, and one over a plate that swings.
const TURNING: [&str; 5] = [
    AT_REST,
    STILL,
    "walls.plate.motion=[{ kind = \"rotation\", axis = [0, 0, 1], origin = [0.05, 0, 0], angular_velocity = 1.0 }]",
    "domain.min=[-0.2, -0.2, -0.02]",
    // Later the ball would leave the plate.
    "time.end=0.6",
];
const SWINGING: [&str; 4] = [
    AT_REST,
    STILL,
    "walls.plate.motion=[{ kind = \"oscillation\", amplitude = [5e-3, 0, 0], frequency = 2.0 }]",
    "particles.slider.position=[0.05, 0.0007, 4.9865e-3]",
];

/// Rows of T23.
pub(super) fn cases() -> Vec<Case> {
    const ARCHARD: &str = "Archard (1953): V = K N s/H";
    const OWN: &str = "sum of |F_n| |v_t| dt over contacts and steps";
    const SAME: &str = "the plate at rest";
    let still = |_: DVec3, _: f64| DVec3::ZERO;
    let mut cases = vec![
        // A sum of 33,500 terms in another order, each of a force with a round-off of 1e-13.
        Case::new(
            "T23 engine: owed by the scene wear-plate, over its own sum",
            1.0,
            Relative(1e-11),
            OWN,
            move || own_sum(&["contact.sliding_normal=step"], still),
        ),
        // The ball settles into its groove.
        Case::new(
            "T23 engine: owed by the scene wear-plate (m3)",
            archard(WAY),
            Relative(1e-3),
            ARCHARD,
            || Ran::new(&[]).row.owed,
        ),
        Case::new(
            "T23 engine: volume between the file and the plate of the scene wear-plate, over what it owed",
            1.0,
            Relative(1e-10),
            "the divergence theorem",
            || {
                let ran = Ran::new(&[]);
                ran.volume_below() / ran.row.owed
            },
        ),
    ];
    let scenes: [(&'static str, Vec<&'static str>); 6] = [
        ("wear-plate", vec![]),
        ("turning plate", TURNING.to_vec()),
        ("swinging plate", SWINGING.to_vec()),
        ("with smoothing", vec!["walls.plate.wear.smoothing=0.5"]),
        (
            "a move in each step",
            vec!["walls.plate.wear.step=1e-9", "time.end=0.02"],
        ),
        ("1 km away", AWAY.to_vec()),
    ];
    for (name, changes) in scenes {
        cases.push(Case::new(
            format!("T23 engine: removed over owed, {name}"),
            1.0,
            Relative(1e-10),
            "displacements are scaled to what is owed",
            move || {
                let row = Ran::new(&changes).row;
                row.removed / row.owed
            },
        ));
    }
    let travelling = [
        STEP,
        AT_REST,
        STILL,
        "walls.plate.motion=[{ kind = \"translation\", velocity = [-0.05, 0, 0] }]",
    ];
    let turned = [
        STEP,
        "walls.plate.rotate={ axis = [1, 0, 0], degrees = 90.0 }",
        "gravity=[0.0, 9.81, 0.0]",
        "domain.min=[-0.01, -0.05, -0.05]",
        "particles.slider.position=[0.02, -4.9865e-3, 0.0007]",
        "particles.slider.prescribed={ velocity = [0.05, \"free\", 0.0], angular_velocity = [0.0, 0.0, 0.0] }",
    ];
    for (name, changes, owed, ways) in [
        ("travelling plate", travelling.to_vec(), 1e-6, 1e-4),
        ("turned by 90 degrees", turned.to_vec(), 1e-6, 1e-4),
        // Places have a round-off of 1e-13 m there, overlaps are 17 micrometres, and moves 5 micrometres.
        ("1 km away", AWAY.to_vec(), 1e-4, 2e-3),
    ] {
        let again = changes.clone();
        cases.push(Case::new(
            format!("T23 engine: owed, {name}, over that of the scene"),
            1.0,
            Relative(owed),
            SAME,
            move || Ran::new(&changes).row.owed / Ran::new(&[STEP]).row.owed,
        ));
        cases.push(Case::new(
            format!("T23 engine: displacements, {name}, largest difference over the depth"),
            0.0,
            Absolute(ways),
            SAME,
            move || Ran::new(&again).differs_from(&Ran::new(&[STEP])),
        ));
    }
    cases.push(Case::new(
        "T23 engine: owed by a plate that turns under the ball, over its own sum",
        1.0,
        Relative(2e-4),
        OWN,
        || {
            let mut changes = TURNING.to_vec();
            changes.push("contact.sliding_normal=step");
            own_sum(&changes, |place, _| {
                DVec3::Z.cross(place - dvec3(0.05, 0.0, 0.0))
            })
        },
    ));
    // The ball leans on the side of its groove.
    let way = 0.6 * dvec3(0.03, 0.0007, 0.0).length();
    cases.push(Case::new(
        "T23 engine: owed by a plate that turns under the ball (m3)",
        archard(way),
        Relative(5e-3),
        ARCHARD,
        || Ran::new(&TURNING).row.owed,
    ));
    cases.push(Case::new(
        "T23 engine: owed by a plate that swings under the ball (m3)",
        archard(4.0 * 5e-3 * 2.0),
        Relative(2e-2),
        ARCHARD,
        || Ran::new(&SWINGING).row.owed,
    ));
    cases.push(Case::new(
        "T23 engine: owed along another track over the same triangles (m3)",
        archard(WAY),
        Relative(5e-3),
        ARCHARD,
        || {
            Ran::new(&["particles.slider.position=[0.02, 0.0063, 4.9865e-3]"])
                .row
                .owed
        },
    ));
    let bounce = [
        FREE,
        STILL,
        "particles.slider.position=[0.05, 0.0007, 0.0075]",
    ];
    let carried = ["walls.plate.motion=[{ kind = \"translation\", velocity = [0.05, 0, 0] }]"];
    let rest = [AT_REST, STILL];
    for name in BASES {
        for (what, changes) in [
            ("rest", rest.to_vec()),
            ("a straight bounce", bounce.to_vec()),
            ("carried along", carried.to_vec()),
        ] {
            cases.push(Case::new(
                format!("T23 engine: {what} by {name}, over sliding"),
                0.0,
                Absolute(1e-13),
                "no slip, no wear",
                move || idle(&changes, name),
            ));
        }
    }
    for name in &BASES[1..] {
        cases.push(Case::new(
            format!("T23 engine: rolling by {name}, over sliding"),
            0.0,
            Absolute(1e-6),
            "no slip, no wear",
            move || {
                let spin = format!(
                    "particles.slider.angular_velocity=[0.0, {}, 0.0]",
                    0.05 / (RADIUS - 0.5 * overlap())
                );
                let changes = [
                    FREE,
                    spin.as_str(),
                    "particles.slider.position=[0.02, 0.0007, 4.98251e-3]",
                ];
                idle(&changes, name)
            },
        ));
    }
    cases.push(Case::new(
        "T23 engine: friction-work over normal-load",
        FRICTION,
        Relative(5e-3),
        "the work of friction is mu N s",
        || Ran::new(&[&basis("friction-work")]).row.owed / Ran::new(&[]).row.owed,
    ));
    // A contact of some fifty automatic steps, known to a step at its ends and between them: errors of a few of (1/50)^2 times the part of the step.
    for part in [1.0, 0.5, 0.25] {
        cases.push(Case::new(
            format!("T23 engine: friction-work of an oblique bounce with {part} of the automatic step, over the audit"),
            1.0,
            Relative(4.0 * (part / 50.0) * (part / 50.0)),
            "tangential dissipation of the energy audit of the same run",
            move || oblique_bounce(part),
        ));
    }
    // Of a wear map, where the ball moves the same way with all bases. It settles meanwhile.
    cases.push(Case::new(
        "T23 engine: way by normal-load less that by sliding (m)",
        first_stretch(),
        Relative(2e-2),
        "first stretch of the spring, mu N/(s k_t) of Mindlin",
        || {
            let map = "walls.plate.wear.moves=false";
            let [all, slid] = BASES[..2]
                .iter()
                .map(|name| Ran::new(&[&basis(name), map]).row.owed)
                .collect::<Vec<f64>>()[..]
            else {
                return f64::NAN;
            };
            (all - slid) / (RATE * weight())
        },
    ));
    cases.extend(grooves());
    cases.extend(impacts());
    cases
}

/// The scene 1 km from the origin.
const AWAY: [&str; 5] = [
    STEP,
    "walls.plate.offset=[1000.0, 0.0, 0.0]",
    "domain.min=[999.99, -0.05, -0.02]",
    "domain.max=[1000.11, 0.05, 0.05]",
    "particles.slider.position=[1000.02, 0.0007, 4.9865e-3]",
];

/// E* of the scene at a wall of the same material, Pa.
fn effective_modulus() -> f64 {
    1e7 / (2.0 * (1.0 - 0.3 * 0.3))
}

/// Overlap of the ball at rest by Hertz, m.
fn overlap() -> f64 {
    (0.75 * weight() / (effective_modulus() * RADIUS.sqrt())).powf(2.0 / 3.0)
}

/// Stretch of Mindlin's spring before it slides, m.
fn first_stretch() -> f64 {
    let shear_modulus = 1e7 / (2.0 * (1.0 + 0.3)) / (2.0 * (2.0 - 0.3));
    let stiffness = 8.0 * shear_modulus * (RADIUS * overlap()).sqrt();
    FRICTION * weight() / (2.0 / 3.0 * stiffness)
}

/// Swings of 5 mm until the groove is much wider than the contact of 0.3 mm, over cells of these sizes. Each swing deepens it by less than a
/// tenth of the overlap.
const CELLS: [f64; 3] = [2e-3, 1e-3, 0.5e-3];
const GROOVE_ACCELERATION: f64 = 1e2;
const GROOVE_FREQUENCY: f64 = 5.0;
const GROOVE_TIME: f64 = 4.0;

/// A plate of 24 by 8 mm of square cells, each of two triangles.
fn plate(cell: f64) -> TriangleMesh {
    let [nx, ny] = [0.024, 0.008].map(|side: f64| (side / cell).round() as u32);
    let mut mesh = TriangleMesh::default();
    for j in 0..=ny {
        for i in 0..=nx {
            let (x, y) = (f64::from(i) * cell - 0.012, f64::from(j) * cell - 0.004);
            mesh.vertices.push(dvec3(x, y, 0.0));
        }
    }
    for j in 0..ny {
        for i in 0..nx {
            let a = j * (nx + 1) + i;
            let [b, c, d] = [a + 1, a + nx + 2, a + nx + 1];
            // Diagonals in turn, so that no direction is better than another.
            if (i + j) % 2 == 0 {
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            } else {
                mesh.triangles.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    mesh
}

/// Owed volume (m^3) and [`section`] of the grooves in cells of 2, 1 and 0.5 mm, made once.
fn groove(place: usize) -> (f64, f64) {
    static GROOVES: OnceLock<[(f64, f64); 3]> = OnceLock::new();
    let made = GROOVES.get_or_init(|| {
        CELLS.map(|cell| {
            let ran = grind(cell);
            (ran.row.owed, section(&ran))
        })
    });
    made[place]
}

/// The groove in cells of this size.
fn grind(cell: f64) -> Ran {
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    let path = folder.path().join("plate.obj");
    let mut bytes = Vec::new();
    push_obj(&plate(cell), NumberStyle::Shortest, &mut bytes);
    std::fs::write(&path, bytes).expect("a writable folder for temporary files");
    let changes = [
        format!("walls.plate.file={:?}", path.display().to_string()),
        format!("walls.plate.wear.acceleration={GROOVE_ACCELERATION}"),
        format!("time.end={GROOVE_TIME}"),
        "walls.plate.motion=[{ kind = \"oscillation\", amplitude = [5e-3, 0, 0], frequency = 5.0 }]".to_owned(),
        "particles.slider.position=[0.0003, 0.0002, 4.9865e-3]".to_owned(),
        AT_REST.to_owned(),
        STILL.to_owned(),
        "domain.min=[-0.05, -0.05, -0.02]".to_owned(),
    ];
    let changes: Vec<&str> = changes.iter().map(String::as_str).collect();
    Ran::new(&changes)
}

/// Mean difference of the section from a circle of the ball's radius through its deepest point, over the mean depth; infinite where the surface folds.
fn section(ran: &Ran) -> f64 {
    let mesh = ran.engine.walls()[0].shape().mesh().expect("a mesh");
    let corners = mesh.corners();
    let is_folded = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|k| corners[k as usize]);
        (b - a).cross(c - a).z <= 0.0
    };
    if mesh.triangles().iter().any(is_folded) {
        return f64::INFINITY;
    }
    // Rows of vertices along the swing, without its ends, where the groove is the same all along.
    let mut rows: BTreeMap<i64, (f64, f64)> = BTreeMap::new();
    for place in corners.iter().filter(|place| place.x.abs() < 3e-3) {
        let row = rows.entry((place.y * 1e6).round() as i64).or_default();
        *row = (row.0 + place.z, row.1 + 1.0);
    }
    let profile: Vec<(f64, f64)> = rows
        .into_iter()
        .map(|(micrometres, (sum, count))| (1e-6 * micrometres as f64, sum / count))
        .collect();
    let deepest = profile.iter().map(|(_, z)| -z).fold(0.0, f64::max);
    let circle = |y: f64| {
        let squared = RADIUS * RADIUS - (y - 0.0002) * (y - 0.0002);
        (squared.max(0.0).sqrt() - (RADIUS - deepest)).max(0.0)
    };
    // Triangles are straight between the rows.
    let (mut difference, mut depth) = (0.0, 0.0);
    for pair in profile.windows(2) {
        let ((y0, z0), (y1, z1)) = (pair[0], pair[1]);
        for k in 0..100 {
            let t = (f64::from(k) + 0.5) / 100.0;
            let (y, z) = (y0 + t * (y1 - y0), z0 + t * (z1 - z0));
            difference += (circle(y) + z).abs() * (y1 - y0);
            depth += circle(y) * (y1 - y0);
        }
    }
    difference / depth
}

fn grooves() -> Vec<Case> {
    const CIRCLE: &str = "a circle of the ball's radius";
    let way = 4.0 * 5e-3 * GROOVE_FREQUENCY * GROOVE_TIME;
    let mut cases: Vec<Case> = Vec::new();
    for (place, cell) in CELLS.into_iter().enumerate() {
        let cell = 1e3 * cell;
        if place < 2 {
            cases.push(Case::new(
                format!("T23 engine: owed by a groove in cells of {cell} mm, over that in cells of 0.5 mm"),
                1.0,
                Relative(1.5e-2),
                "the same groove",
                move || groove(place).0 / groove(2).0,
            ));
        }
        // The ball leans on the sides of its groove, and presses harder where it is fast.
        cases.push(Case::new(
            format!("T23 engine: owed by a groove in cells of {cell} mm (m3)"),
            archard(way) * GROOVE_ACCELERATION / 1e3,
            Relative(6e-2),
            "Archard (1953): V = K m g s/H",
            move || groove(place).0,
        ));
    }
    cases.push(Case::new(
        "T23 engine: section of a groove in cells of 0.5 mm, mean difference from a circle over the mean depth",
        0.0,
        Absolute(0.15),
        CIRCLE,
        || groove(2).1,
    ));
    cases.push(Case::new(
        "T23 engine: sections of grooves in cells of 2, 1, 0.5 mm, how many come nearer to a circle",
        2.0,
        Absolute(0.0),
        CIRCLE,
        || {
            let sections = [0, 1, 2].map(|place| groove(place).1);
            sections.windows(2).filter(|pair| pair[1] < pair[0]).count() as f64
        },
    ));
    cases
}

/// Finnie's f.
fn finnie(angle: f64) -> f64 {
    if angle.tan() < 1.0 / 3.0 {
        (2.0 * angle).sin() - 3.0 * angle.sin() * angle.sin()
    } else {
        angle.cos() * angle.cos() / 3.0
    }
}

/// Oka's volume for 1 kg that hits with 2 m/s, particles of 10 mm: hardness 1.2 GPa, 65 mm^3/kg at 104 m/s with 0.326 mm.
fn oka(angle: f64) -> f64 {
    let normal = 65e-9 * (2.0f64 / 104.0).powf(2.35) * (1e-2f64 / 326e-6).powf(0.19);
    normal * angle.sin().powf(0.8) * (1.0 + 1.2 * (1.0 - angle.sin())).powf(1.3)
}

fn impacts() -> Vec<Case> {
    const SPEED: f64 = 2.0;
    let mut cases = Vec::new();
    for degrees in [15.0f64, 45.0] {
        let angle = degrees.to_radians();
        for (name, law, expected) in [
            (
                "Finnie",
                "{ law = \"finnie\", constant = 1e-12 }",
                1e-12 * mass() * SPEED * SPEED * finnie(angle),
            ),
            (
                "Oka",
                "{ law = \"oka\", hardness = 1.2e9, reference_erosion = 65.0, reference_speed = 104.0, reference_diameter = 326e-6, speed_exponent = 2.35, diameter_exponent = 0.19, n1 = 0.8, n2 = 1.3 }",
                mass() * oka(angle),
            ),
        ] {
            cases.push(Case::new(
                format!("T23 engine: {name}, one impact at {degrees} degrees (m3)"),
                expected,
                Relative(1e-9),
                "closed form",
                move || {
                    let (along, down) = (SPEED * (FRAC_PI_2 - angle).sin(), SPEED * angle.sin());
                    let changes = [
                        format!("walls.plate.wear={law}"),
                        "gravity=[0.0, 0.0, 0.0]".to_owned(),
                        FREE.to_owned(),
                        format!("particles.slider.velocity=[{along}, 0.0, {}]", -down),
                        "particles.slider.position=[0.02, 0.0007, 5.3e-3]".to_owned(),
                        "domain.max=[10.0, 0.05, 5.0]".to_owned(),
                        "time.end=0.02".to_owned(),
                    ];
                    let changes: Vec<&str> = changes.iter().map(String::as_str).collect();
                    Ran::new(&changes).row.owed
                },
            ));
        }
    }
    cases
}

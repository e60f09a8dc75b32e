//! Liquid bridges in whole scenes: forces at every kind of wall, collisions with known outcomes, the energy budget.

use std::path::Path;
use std::sync::Arc;

use mercury_common::particle_properties::FILM_VOLUME;
use mercury_common::scene::Files;
use mercury_engine::contact::adhesion::liquid::Liquid;
use mercury_engine::contact::adhesion::young_laplace::Branch;
use mercury_engine::liquid::film_thickness;
use mercury_engine::step::{Engine, Snapshot, StartOptions};
use mercury_solver::plan::{Plan, parse_scene, plan};
use mercury_tests::scenes::observed_step;

fn planned(text: &str, set: &[&str]) -> Arc<Plan> {
    let set: Vec<String> = set.iter().map(|one| (*one).to_owned()).collect();
    let scene = parse_scene(Path::new("test.toml"), text, &set, Files::MustExist)
        .unwrap_or_else(|errors| panic!("{errors}"));
    Arc::new(plan(&scene).unwrap_or_else(|errors| panic!("{errors}")))
}

fn start(text: &str, set: &[&str]) -> Engine {
    Engine::start(planned(text, set), StartOptions::threads(1)).unwrap()
}

fn liquid_of(engine: &Engine) -> Liquid {
    let law = engine.physics().laws.get(0, 0).unwrap();
    *law.adhesion.liquid().unwrap()
}

/// A wet sphere of 1 mm that touches a wall and is drawn away from it along x, at 0.01 m/s.
const AT_WALL: &str = r#"
[time]
end = 0.1
step = 1e-4
[domain]
min = [-0.1, -0.1, -0.1]
max = [0.1, 0.1, 0.1]
[materials.wet]
density = 2500.0
normal = { law = "linear", stiffness = 100.0, dissipation = 0.0 }
liquid = { law = "bagheri", surface_tension = 0.07, contact_angle_degrees = 20.0, max_bridge_volume = 2e-11 }
[[particles]]
material = "wet"
radius = 1e-3
position = [0.0, 0.0, 0.0]
film_volume = 5e-11
prescribed = { velocity = [0.01, 0.0, 0.0], angular_velocity = [0.0, 0.0, 0.0] }
velocity = [0.01, 0.0, 0.0]
[output]
interval = 0.01
"#;

#[test]
fn the_force_over_the_gap_is_that_of_the_law_at_every_kind_of_wall() {
    // Of each wall: the entry, and the x of the centre of a sphere that just touches it, less 1e-8 m.
    let plate =
        "v 0 -0.05 -0.05\nv 0 0.05 -0.05\nv 0 0.05 0.05\nv 0 -0.05 0.05\nf 1 2 3\nf 1 3 4\n";
    let folder = tempfile::tempdir().unwrap();
    let mesh = folder.path().join("plate.obj");
    std::fs::write(&mesh, plate).unwrap();
    let mesh = format!("shape = \"mesh\"\nfile = {:?}", mesh.display().to_string());
    let r = 1e-3 - 1e-8;
    // The cone has a half angle of 45 degrees, and its generator along y passes through the origin.
    for (wall, x) in [
        (
            "shape = \"plane\"\npoint = [0, 0, 0]\nnormal = [1, 0, 0]",
            r,
        ),
        (
            "shape = \"cylinder\"\naxis = [0, 0, 1]\norigin = [-0.01, 0, 0]\nradius = 0.01\nside = \"outside\"",
            r,
        ),
        (
            "shape = \"sphere\"\norigin = [-0.02, 0, 0]\nradius = 0.02\nside = \"outside\"",
            r,
        ),
        (
            "shape = \"disc\"\naxis = [1, 0, 0]\norigin = [0, 0, 0]\nradius = 0.01",
            r,
        ),
        (
            "shape = \"cone\"\naxis = [-1, 1, 0]\norigin = [0, -0.02, 0]\nalong = [0, 0.06]\nradii = [0, 0.06]\nside = \"outside\"",
            r,
        ),
        (mesh.as_str(), r),
    ] {
        for law in [
            "bagheri",
            "willett-classical",
            "lian-seville",
            "willett",
            "young-laplace",
        ] {
            let text =
                format!("{AT_WALL}\n[[walls]]\nname = \"wall\"\nmaterial = \"wet\"\n{wall}\n");
            let law = format!("materials.wet.liquid.law={law:?}");
            let x = format!("particles[0].position=[{x}, 0.0, 0.0]");
            let mut engine = start(&text, &[&law, &x, "materials.wet.liquid.viscosity=0.0"]);
            let liquid = liquid_of(&engine);
            let bridges = engine.bridges();
            assert_eq!(bridges.len(), 1, "{wall}");
            let bridge = bridges[0].memory;
            assert_eq!(bridge.volume, 2e-11);
            let films = engine.particles.columns.get(FILM_VOLUME.name).unwrap()[0];
            assert_eq!(films, 5e-11 - 2e-11);
            let touch = liquid.force_at(&bridge, 0.0);
            let mut apart = 0;
            loop {
                engine.step(None).unwrap();
                let gap = engine.particles.records[0].position.x - 1e-3;
                let force = engine.particles.loads[0].force;
                if gap >= bridge.end {
                    assert_eq!(force.length(), 0.0);
                    break;
                }
                if gap > 0.0 {
                    apart += 1;
                    assert_eq!(engine.bridges()[0].memory.volume, 2e-11);
                    let expected = -liquid.force_at(&bridge, gap);
                    // A gap is known to 1e-17 m of 1e-3 m, and the force changes by its own size over 1e-6 m at the least.
                    assert!(
                        (force.x - expected).abs() <= 1e-9 * touch,
                        "{wall} {law} {gap}: {} {expected}",
                        force.x
                    );
                    assert!(force.y.abs() + force.z.abs() <= 1e-9 * touch);
                }
            }
            assert!(apart > 100, "{apart}");
            assert!(engine.bridges().is_empty());
            // 5e-11 - 2e-11 + 2e-11, each rounded.
            let film = engine.particles.columns.get(FILM_VOLUME.name).unwrap()[0];
            assert!((film / 5e-11 - 1.0).abs() < 4e-16, "{film}");
        }
    }
}

/// A bridge belongs to the wall: along a hundred triangles it keeps its volume to the bit and its force.
#[test]
fn a_bridge_slides_over_a_hundred_triangles() {
    let mut plate = String::new();
    let columns = 52;
    for i in 0..columns {
        for y in [-0.01, 0.01] {
            plate += &format!("v {} {y} 0\n", -0.0005 + 2e-4 * f64::from(i));
        }
    }
    for i in 0..columns - 1 {
        let k = 2 * i + 1;
        plate += &format!(
            "f {} {} {}\nf {} {} {}\n",
            k,
            k + 2,
            k + 1,
            k + 1,
            k + 2,
            k + 3
        );
    }
    let folder = tempfile::tempdir().unwrap();
    let mesh = folder.path().join("strip.obj");
    std::fs::write(&mesh, plate).unwrap();
    let text = format!(
        "{AT_WALL}\n[[walls]]\nname = \"wall\"\nmaterial = \"wet\"\nshape = \"mesh\"\nfile = {:?}\n",
        mesh.display().to_string()
    );
    let mut engine = start(
        &text,
        &[
            "particles[0].position=[0.0, 1e-4, 0.00099999]",
            "particles[0].velocity=[0.1, 0.0, 0.001]",
            "particles[0].prescribed={ velocity = [0.1, 0.0, \"free\"] }",
            "materials.wet.normal.stiffness=1e-9",
            "materials.wet.density=1e9",
            "time.step=2e-5",
        ],
    );
    // It is so heavy that it rises evenly, to a gap of 9e-5 m.
    let liquid = liquid_of(&engine);
    let mut seen = std::collections::BTreeSet::new();
    for _ in 0..4500 {
        engine.step(None).unwrap();
        let bridges = engine.bridges();
        assert_eq!(
            bridges.len(),
            1,
            "at {:?}",
            engine.particles.records[0].position
        );
        assert_eq!(bridges[0].memory.volume, 2e-11);
        let gap = engine.particles.records[0].position.z - 1e-3;
        if gap > 0.0 {
            let expected = -liquid.force_at(&bridges[0].memory, gap);
            let force = engine.particles.loads[0].force.z;
            assert!(
                (force - expected).abs() <= 1e-9 * expected.abs(),
                "{force} {expected}"
            );
        }
        let near_walls = engine.snapshot().near_walls().unwrap();
        let mut slots = near_walls.iter();
        seen.extend(
            slots
                .find(|slot| slot.feature != u32::MAX)
                .map(|slot| slot.feature),
        );
    }
    assert!(seen.len() > 60, "{}", seen.len());
}

/// Two wet spheres that collide head-on (case T23).
const HEAD_ON: &str = r#"
[time]
end = 3e-3
step = 1e-7
[domain]
min = [-0.02, -0.02, -0.02]
max = [0.02, 0.02, 0.02]
[contact]
lubrication = "clamped"
[materials.wet]
density = 2500.0
normal = { law = "linear", stiffness = 1000.0, dissipation = 0.0 }
liquid = { law = "lian-seville", surface_tension = 0.0, contact_angle_degrees = 10.0, viscosity = 1e-2, max_bridge_volume = 1e-11, rupture = "willett" }
[[particles]]
material = "wet"
radius = 1e-3
position = [-0.0010001, 0.0, 0.0]
velocity = [0.25, 0.0, 0.0]
film_volume = 5e-12
[[particles]]
material = "wet"
radius = 1e-3
position = [0.0010001, 0.0, 0.0]
velocity = [-0.25, 0.0, 0.0]
film_volume = 5e-12
[output]
interval = 1e-3
"#;

/// The relative speed after the bridge has broken.
fn parted(engine: &mut Engine) -> f64 {
    let formed = |engine: &Engine| engine.liquid().unwrap().balance;
    for _ in 0..100_000 {
        engine.step(None).unwrap();
        if formed(engine).ruptured > 0 {
            engine.complete_step().unwrap();
            let [a, b] = [0, 1].map(|row| engine.particles.records[row].velocity.x);
            return (a - b).abs();
        }
    }
    panic!("the bridge does not break");
}

#[test]
fn a_film_takes_the_speed_that_theory_says() {
    // Without tension, from a gap h0 to h1: (6 pi eta R*^2/m*) ln(h1/h0), and once more where the gap counts as the roughness.
    let end = 2.392911023053e-4;
    let take = 9.0e-3;
    let least = 5e-6_f64;
    for (lubrication, tension, speed, tolerance) in [
        ("cut", "0.0", 0.5 - take * 4f64.ln(), 2e-5),
        (
            "clamped",
            "0.0",
            0.5 - take * (1.0 + (end / least).ln()),
            1e-4,
        ),
        // Computed by another integrator.
        ("cut", "0.07", 0.47559, 2e-5),
        ("clamped", "0.07", 0.44358, 1e-4),
    ] {
        let mut engine = start(
            HEAD_ON,
            &[
                &format!("contact.lubrication={lubrication:?}"),
                &format!("materials.wet.liquid.surface_tension={tension}"),
            ],
        );
        let found = parted(&mut engine);
        assert!(
            (found - speed).abs() < tolerance,
            "{lubrication} {tension}: {found}, not {speed}"
        );
        let films = engine.particles.columns.get(FILM_VOLUME.name).unwrap();
        for film in films {
            assert!((film - 5e-12).abs() < 1e-24, "{film}");
        }
    }
}

/// Case T24: the test of MercuryDPM's law of Willett with viscosity.
#[test]
fn a_collision_ends_as_in_mercurydpm() {
    let mut engine = start(
        HEAD_ON,
        &[
            "contact.lubrication=\"cut\"",
            "time.step=3.012689815e-6",
            "materials.wet.normal={ law = \"linear\", stiffness = 1500.0, dissipation = 0.002 }",
            "materials.wet.liquid={ law = \"willett\", surface_tension = 0.0728, contact_angle_degrees = 35.0, viscosity = 1e-3, max_bridge_volume = 1.06e-9 }",
            "particles[0].radius=0.87e-3",
            "particles[1].radius=0.87e-3",
            "particles[0].position=[0.0025, 0.0, 0.0]",
            "particles[1].position=[0.005, 0.0, 0.0]",
            "particles[0].velocity=[0.4, 0.0, 0.0]",
            "particles[1].velocity=[-0.4, 0.0, 0.0]",
            "particles[0].film_volume=1.06e-9",
            "particles[1].film_volume=1.06e-9",
        ],
    );
    let speed = 0.5 * parted(&mut engine);
    // Printed with ten digits.
    assert!((speed / 0.3393433766 - 1.0).abs() < 1e-9, "{speed}");
    for film in engine.particles.columns.get(FILM_VOLUME.name).unwrap() {
        assert!((film / 1.06e-9 - 1.0).abs() < 1e-14);
    }
}

/// The budget of a collision with a bridge closes, and to second order.
#[test]
fn the_energy_of_a_wet_collision_closes() {
    let text = std::fs::read_to_string(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/wet-pair.toml"),
    )
    .unwrap();
    let closure = |law: &str, form: &str, step: &str| {
        let mut engine = start(
            &text,
            &[
                "output.energy_budget=true",
                &format!("time.step={step}"),
                &format!("materials.wet.liquid.law={law:?}"),
                &format!("liquid.bridges_form={form:?}"),
            ],
        );
        let kinetic = |engine: &Engine| {
            let particles = &engine.particles;
            (particles.records.iter().zip(&particles.masses))
                .map(|(record, mass)| 0.5 * mass * record.velocity.length_squared())
                .sum::<f64>()
        };
        let first = kinetic(&engine);
        let mut worst = 0.0f64;
        while engine.time() < 2.9e-3 {
            observed_step(&mut engine);
            let stored = engine.observation().elastic_energy;
            let now = kinetic(&engine) + stored + engine.audit().losses.total();
            worst = worst.max((now - first).abs() / first);
        }
        assert!(engine.liquid().unwrap().balance.ruptured == 1);
        assert!(engine.audit().losses.of("liquid") > 0.01 * first);
        worst
    };
    for (law, form) in [
        ("lian-seville", "contact"),
        ("young-laplace", "contact"),
        ("lian-seville", "films"),
    ] {
        let [coarse, fine] = ["1e-6", "5e-7"].map(|step| closure(law, form, step));
        println!("closure of {law}, {form}: {coarse:e} {fine:e}");
        assert!(coarse < 2e-3, "{law}, {form}: {coarse}");
        assert!(fine < 0.35 * coarse, "{law}, {form}: {fine} {coarse}");
    }
}

/// Wet spheres and rods that fall through a box: some leave through its open sides, the others are deleted at its foot.
const FEED: &str = r#"
gravity = [0.0, 0.0, -9.81]
[time]
end = 1.0
step = 2e-5
[domain]
min = [0.0, 0.0, 0.0]
max = [0.008, 0.008, 0.012]
periodic = ["y"]
[clumps.rod]
file = "rod.clump.toml"
material = "wet"
[materials.wet]
density = 2500.0
normal = { law = "linear", stiffness = 200.0, restitution = 0.5 }
liquid = { law = "bagheri", surface_tension = 0.02, contact_angle_degrees = 20.0, viscosity = 1e-3, max_bridge_volume = 2e-12, distribution = 0.7 }
[[insertions]]
name = "feed"
region = { shape = "box", min = [0.0, 0.0, 0.006], max = [0.008, 0.008, 0.012] }
mixture = [{ material = "wet", psd = { kind = "uniform", min_diameter = 0.8e-3, max_diameter = 1.2e-3, weighting = "number" }, share = 0.7 },
           { clump = "rod", psd = { kind = "monodisperse", diameter = 1.3e-3 }, share = 0.3, film_volume = 4.1e-12 }]
film_volume = 1.7e-12
share_by = "number"
rate = { number = 6000.0 }
until = 0.1
velocity = { mean = [0.0, 0.0, -0.4], spread = [0.3, 0.3, 0.2] }
[[deletions]]
name = "foot"
region = { shape = "half-space", point = [0.0, 0.0, 0.002], normal = [0.0, 0.0, -1.0] }
[output]
interval = 0.01
"#;

/// Number of grains of an ingredient that have come.
fn brought(engine: &Engine, ingredient: usize) -> u64 {
    let mut insertions = engine.boundaries().insertions();
    let brought = &insertions.next().unwrap().brought;
    brought.get(ingredient).map_or(0, |tally| tally.number)
}

#[test]
fn liquid_on_inserted_grains_is_counted_to_round_off() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    let file = format!(
        "clumps.rod.file={:?}",
        scenes.join("rod.clump.toml").display().to_string()
    );
    for (seed, interrupted) in [(1, 37), (2, 1100), (3, 2999)] {
        let plan = planned(FEED, &[&file, &format!("seed={seed}")]);
        let mut engine = Engine::start(Arc::clone(&plan), StartOptions::threads(1)).unwrap();
        let mut other = Engine::start(Arc::clone(&plan), StartOptions::threads(2)).unwrap();
        for step in 0..4000 {
            engine.step(None).unwrap();
            other.step(None).unwrap();
            let row = engine.liquid().unwrap();
            let inserted = row.balance.inserted.value();
            assert!(
                row.error.abs() <= 2e-14 * inserted,
                "{} of {inserted}",
                row.error
            );
            // The fed volume follows from the key of each grain.
            let count = |index: usize| brought(&engine, index) as f64;
            let fed = 1.7e-12 * count(0) + 4.1e-12 * count(1);
            assert!((inserted - fed).abs() <= 1e-13 * fed, "{inserted} {fed}");
            if step == interrupted {
                let bytes = other.snapshot().encode();
                let snapshot = Snapshot::decode(&bytes).unwrap();
                other = Engine::restore(Arc::clone(&plan), snapshot, 1).unwrap();
            }
        }
        assert!(engine.snapshot() == other.snapshot(), "seed {seed}");
        let row = engine.liquid().unwrap();
        let balance = row.balance;
        assert_eq!(balance.initial, 0.0);
        assert!(balance.formed > 100 && balance.ruptured > 50, "{balance:?}");
        assert!(balance.left.value() > 0.0 && balance.deleted.value() > 0.0);
        // Pebbles of one body have films by their surfaces.
        let films = engine.particles.columns.get(FILM_VOLUME.name).unwrap();
        assert!(films.iter().all(|film| *film >= 0.0));
    }
}

/// Without a law of liquid it is a coating, and it is there all the same; of a body it is spread by surface.
#[test]
fn an_inserted_body_has_its_film_on_all_pebbles() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    let file = format!(
        "clumps.rod.file={:?}",
        scenes.join("rod.clump.toml").display().to_string()
    );
    let text = (FEED.lines())
        .filter(|line| !line.starts_with("liquid ="))
        .collect::<Vec<_>>()
        .join("\n");
    let mut engine = start(&text, &[&file]);
    while brought(&engine, 1) == 0 {
        engine.step(None).unwrap();
    }
    let films = engine.particles.columns.get(FILM_VOLUME.name).unwrap();
    let bodies = engine.particles.bodies.as_ref().unwrap();
    let rows = (bodies.pebbles[bodies.all[0].pebbles()].iter()).map(|pebble| pebble.row.index());
    let rows: Vec<usize> = rows.collect();
    assert!(rows.len() > 1);
    let square = |row: usize| engine.particles.records[row].radius.powf(2.0);
    let surface: f64 = rows.iter().map(|&row| square(row)).sum();
    for &row in &rows {
        let share = 4.1e-12 * square(row) / surface;
        assert!((films[row] - share).abs() < 1e-14 * 4.1e-12);
    }
}

/// Two wet grains on their way to each other, or one on its way to a wall (case T30).
fn wet_collision(at_wall: bool, films: bool, tension: f64, speed: f64, gap: f64) -> Engine {
    let form = if films { "films" } else { "contact" };
    let rest = if at_wall {
        "[[walls]]\nname = \"wall\"\nmaterial = \"wet\"\nshape = \"plane\"\npoint = [0, 0, 0]\nnormal = [-1, 0, 0]\n".to_owned()
    } else {
        "[[particles]]\nmaterial = \"wet\"\nradius = 1e-3\nposition = [1e-3, 0.0, 0.0]\nfilm_volume = 6e-11\n".to_owned()
    };
    let text = format!(
        r#"
[time]
end = 1.0
step = 1e-7
[domain]
min = [-0.02, -0.02, -0.02]
max = [0.02, 0.02, 0.02]
[liquid]
bridges_form = "{form}"
[materials.wet]
density = 2500.0
normal = {{ law = "hertz", youngs_modulus = 1e7, poisson_ratio = 0.3, restitution = 0.8 }}
liquid = {{ law = "bagheri", surface_tension = {tension}, contact_angle_degrees = 20.0, viscosity = 0.02, max_bridge_volume = 2e-11, roughness = 1e-6 }}
[[particles]]
material = "wet"
radius = 1e-3
position = [{}, 0.0, 0.0]
velocity = [{speed}, 0.0, 0.0]
film_volume = 6e-11
{rest}
[output]
interval = 0.01
"#,
        -1e-3 - gap
    );
    start(&text, &[])
}

/// Case T32: how thick a film is, and that bridges form at the sum of the thicknesses (at a wall, of the grain alone).
#[test]
fn bridges_form_where_films_meet() {
    let thickness = film_thickness(6e-11, 1e-3);
    assert!((thickness - 4.752030727e-6).abs() < 1e-15, "{thickness:e}");
    // A film of 1e-25 m3 is as thick as on a plane, but for h/R.
    let plane = 1e-25 / (4.0 * std::f64::consts::PI * 1e-6);
    assert!((film_thickness(1e-25, 1e-3) / plane - 1.0).abs() < 1e-13);
    assert_eq!(film_thickness(0.0, 1e-3), 0.0);
    for (at_wall, meet) in [(false, 2.0 * thickness), (true, thickness)] {
        for (films, factor, forms) in [
            (true, 1.0 - 1e-6, 1),
            (true, 1.0 + 1e-6, 0),
            (false, 1.0 - 1e-6, 0),
        ] {
            let engine = wet_collision(at_wall, films, 0.07, 0.0, meet * factor);
            let bridges = engine.bridges();
            assert_eq!(bridges.len(), forms, "{at_wall} {films} {factor}");
            if let Some(bridge) = bridges.first() {
                assert_eq!(bridge.memory.volume, 2e-11);
                assert!((bridge.memory.gap - meet * factor).abs() < 1e-17);
            }
        }
    }
    // Films that reach further than a bridge does form one where it reaches, at 3.2747132e-4 m.
    for (gap, forms) in [(3.274e-4, 1), (3.276e-4, 0)] {
        let mut engine = wet_collision(false, true, 0.0, 0.0, gap);
        engine
            .particles
            .columns
            .get_mut(FILM_VOLUME.name)
            .unwrap()
            .fill(4e-9);
        engine.step(None).unwrap();
        assert_eq!(engine.bridges().len(), forms, "{gap}");
        assert_eq!(engine.liquid().unwrap().balance.ruptured, 0);
    }
}

/// Case T30: restitution of wet collisions, and the speeds below which the two hold together.
#[test]
fn wet_collisions_end_as_specified() {
    let relative = |engine: &Engine| {
        let velocity =
            |row: usize| (engine.particles.records.get(row)).map_or(0.0, |a| a.velocity.x);
        velocity(1) - velocity(0)
    };
    for (at_wall, films, tension, restitution, held_below) in [
        (false, false, 0.0, [0.55551, 0.67775, 0.73888], 0.1528),
        (false, false, 0.07, [0.49789, 0.66513, 0.73568], 0.2918),
        (false, true, 0.0, [0.46186, 0.63093, 0.71547], 0.2113),
        (false, true, 0.07, [0.39509, 0.61798, 0.71230], 0.3485),
        (true, false, 0.07, [0.26031, 0.54984, 0.67767], 0.3977),
        (true, true, 0.07, [0.06010, 0.47511, 0.64078], 0.4891),
    ] {
        let case = format!("at wall: {at_wall}, films: {films}, tension {tension}");
        for (speed, expected) in [0.5, 1.0, 2.0].into_iter().zip(restitution) {
            let mut engine = wet_collision(at_wall, films, tension, speed, 1.2e-5);
            while engine.liquid().unwrap().balance.ruptured == 0 {
                assert!(engine.time() < 0.1, "{case}: does not part");
                engine.step(None).unwrap();
            }
            engine.complete_step().unwrap();
            let found = relative(&engine) / speed;
            assert!(
                (found - expected).abs() < 4e-3,
                "{case}, {speed} m/s: {found}, not {expected}"
            );
        }
        // A pair that hardly parts is the slower the further it comes: without tension it needs about 4 S_r/c, 0.06 s.
        for (factor, parts) in [(0.99, 0), (1.01, 1)] {
            let mut engine = wet_collision(at_wall, films, tension, factor * held_below, 1.2e-5);
            while engine.time() < 0.1 && engine.liquid().unwrap().balance.ruptured == 0 {
                engine.step(None).unwrap();
            }
            let balance = engine.liquid().unwrap().balance;
            assert_eq!(
                balance.ruptured, parts,
                "{case}, {factor} of {held_below} m/s"
            );
            assert!(balance.formed >= 1);
        }
    }
}

/// Case T26: the test of MercuryDPM's law of Willett with migration: a pair, then one of it at a wall.
#[test]
fn a_pair_and_a_wall_hold_as_in_mercurydpm() {
    // Discs of 1.5 kg there, spheres of the same mass here.
    let density = 1.5 / (4.0 / 3.0 * std::f64::consts::PI * 0.125);
    let text = format!(
        r#"
[time]
end = 1.0
step = 1e-4
[domain]
min = [-3.0, -3.0, -3.0]
max = [3.0, 3.0, 3.0]
[materials.wet]
density = {density:?}
normal = {{ law = "linear", stiffness = 2e5, dissipation = 0.0 }}
liquid = {{ law = "willett", surface_tension = 1.0, contact_angle_degrees = 0.0, max_bridge_volume = 1e-9 }}
[[particles]]
material = "wet"
radius = 0.5
position = [0.0, 0.0, 0.0]
film_volume = 1e-9
[[particles]]
material = "wet"
radius = 0.5
position = [0.0, 0.0, -1.005]
velocity = [0.0, 0.0, 0.1]
film_volume = 1e-9
[[walls]]
name = "wall"
material = "wet"
shape = "plane"
point = [0.0, 0.0, 0.505]
normal = [0.0, 0.0, -1.0]
[output]
interval = 0.01
"#
    );
    let mut engine = start(&text, &[]);
    let place = |engine: &Engine, row: usize| engine.particles.records[row].position.z;
    let force = |engine: &Engine, row: usize| engine.particles.loads[row].force.z;
    let mut found = [[0.0; 2]; 2];
    for step in 1..=1069 {
        engine.step(None).unwrap();
        let of_pair = 1.0 - (place(&engine, 0) - place(&engine, 1));
        let of_wall = place(&engine, 0) + 0.5 - 0.505;
        if step == 599 {
            found[0] = [of_pair, force(&engine, 0)];
        } else if step == 1069 {
            found[1] = [of_wall, -force(&engine, 0)];
        }
    }
    // Printed with ten digits; of the pair the force on the first, which is drawn down, and places are known to 1e-15 m.
    for (found, expected) in found.into_iter().zip([
        [-3.451429625e-4, -0.01988247933],
        [2.719912448e-4, 48.11506365],
    ]) {
        for (found, expected) in found.into_iter().zip(expected) {
            assert!(
                (found / expected - 1.0).abs() < 1e-9,
                "{found:e}, not {expected:e}"
            );
        }
    }
}

/// A wet sphere that touches a plate with a film: `plate` is the wall's entry.
fn on_a_wet_plate(plate: &str, set: &[&str]) -> Engine {
    let text = format!(
        "{AT_WALL}\n[[walls]]\nname = \"plate\"\nmaterial = \"wet\"\n{plate}\nfilm = {{ thickness = 2e-6, keeps = 0.25 }}\n"
    );
    let place = format!("particles[0].position=[{}, 0.0, 0.0]", 1e-3 - 1e-8);
    let mut all = vec![place.as_str()];
    all.extend(set);
    start(&text, &all)
}

/// A plate of two triangles, and a disc: the film gives by the share that the shadow of the grain covers, and keeps its share of the bridge
/// that breaks.
#[test]
fn a_wall_with_a_film_gives_and_keeps() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = folder.path().join("plate.obj");
    // The larger triangle lies below the sphere.
    let plate =
        "v 0 -0.02 -0.02\nv 0 0.03 -0.02\nv 0 -0.02 0.03\nv 0 0.03 0.03\nf 1 2 3\nf 2 4 3\n";
    std::fs::write(&mesh, plate).unwrap();
    let mesh = format!("shape = \"mesh\"\nfile = {:?}", mesh.display().to_string());
    let disc = "shape = \"disc\"\naxis = [1, 0, 0]\norigin = [0, 0, 0]\nradius = 0.01";
    let pi = std::f64::consts::PI;
    let films = [
        (mesh.as_str(), 0.5 * 0.05 * 0.05, 2.0),
        (disc, pi * 1e-4, 1.0),
    ];
    for (wall, area, pieces) in films {
        let mut engine = on_a_wet_plate(wall, &[]);
        let reach = 2e-6 * pi * 1e-6;
        // More than a bridge holds: both give in proportion.
        let (there, volume) = (5e-11 + reach, 2e-11);
        let close = |found: f64, expected: f64| {
            assert!(
                (found / expected - 1.0).abs() < 1e-12,
                "{wall}: {found} {expected}"
            );
        };
        let film = |engine: &Engine| engine.particles.columns.get(FILM_VOLUME.name).unwrap()[0];
        close(engine.bridges()[0].memory.volume, volume);
        let initial = 5e-11 + 2e-6 * area * pieces;
        let row = engine.liquid().unwrap();
        close(row.balance.initial, initial);
        close(
            row.wall_films,
            2e-6 * area * pieces - volume * (reach / there),
        );
        let left = film(&engine);
        while !engine.bridges().is_empty() {
            engine.step(None).unwrap();
        }
        let row = engine.liquid().unwrap();
        close(film(&engine), left + 0.75 * volume);
        close(
            row.wall_films,
            2e-6 * area * pieces - volume * (reach / there) + 0.25 * volume,
        );
        assert!(row.error.abs() <= 2e-14 * initial);
    }
}

/// Where bridges form as films meet, the film of a wall counts, too.
#[test]
fn a_bridge_forms_where_the_film_of_a_wall_is_met() {
    let disc = "shape = \"disc\"\naxis = [1, 0, 0]\norigin = [0, 0, 0]\nradius = 0.01";
    let of_grain = film_thickness(1e-11, 1e-3);
    for (gap, forms) in [
        (0.99 * (of_grain + 2e-6), true),
        (1.01 * (of_grain + 2e-6), false),
    ] {
        let place = format!("particles[0].position=[{}, 0.0, 0.0]", 1e-3 + gap);
        let engine = on_a_wet_plate(
            disc,
            &[
                "particles[0].film_volume=1e-11",
                "liquid.bridges_form=\"films\"",
                &place,
            ],
        );
        assert_eq!(engine.bridges().len() == 1, forms, "{gap}");
    }
}

/// Volume that films lose: the outer radius falls by the rate, as dV = 4 pi r^2 dr. Of bridges: by the exact lateral area.
#[test]
fn liquid_evaporates_by_its_surface() {
    let rate = 1e-6;
    let evaporation = format!("liquid.evaporation={rate}");
    let apart = "particles[0].position=[0.05, 0.0, 0.0]";
    let mut engine = start(AT_WALL, &[&evaporation, apart]);
    let before = film_thickness(5e-11, 1e-3);
    let steps = 20 * 32;
    for _ in 0..steps {
        engine.step(None).unwrap();
    }
    let film = engine.particles.columns.get(FILM_VOLUME.name).unwrap()[0];
    let gone = before - film_thickness(film, 1e-3);
    let expected = rate * engine.time();
    assert!(expected < 0.05 * before);
    // Each portion is taken by the area before it: relative to it 2 dr/r = 6.4e-6 too much at the most.
    assert!((gone / expected - 1.0).abs() < 1e-5, "{gone} {expected}");
    let row = engine.liquid().unwrap();
    assert!((row.balance.evaporated.value() - (5e-11 - film)).abs() < 1e-24);
    assert!(row.error.abs() <= 2e-14 * 5e-11);
    // A pair that stays where it is.
    let pair = [
        "particles[0].position=[-0.00102, 0.0, 0.0]",
        "particles[1].position=[0.00102, 0.0, 0.0]",
        "particles[0].velocity=[0.0, 0.0, 0.0]",
        "particles[1].velocity=[0.0, 0.0, 0.0]",
        "liquid.bridges_form=\"films\"",
        "particles[0].film_volume=3e-10",
        "particles[1].film_volume=3e-10",
        "materials.wet.liquid.viscosity=0.0",
        &evaporation,
    ];
    let mut engine = start(HEAD_ON, &pair);
    let volume = engine.bridges()[0].memory.volume;
    assert_eq!(volume, 1e-11);
    for _ in 0..32 {
        engine.step(None).unwrap();
    }
    let angle = liquid_of(&engine).contact_angle;
    let branch = Branch::new(angle, 0.01, 1.0).unwrap();
    let gap = engine.bridges()[0].memory.gap;
    let area = 1e-6 * branch.at(gap / 1e-3).unwrap().area;
    let gone = volume - engine.bridges()[0].memory.volume;
    let expected = rate * engine.time() * area;
    assert!((gone / expected - 1.0).abs() < 1e-2, "{gone} {expected}");
    // It dries up at last, and what is gone is counted.
    let mut fast = pair.to_vec();
    fast.push("liquid.evaporation=0.1");
    let mut engine = start(HEAD_ON, &fast);
    for _ in 0..30_000 {
        engine.step(None).unwrap();
    }
    assert!(engine.bridges().is_empty());
    let row = engine.liquid().unwrap();
    assert_eq!((row.films, row.bridges), (0.0, 0.0));
    assert!(row.balance.dried + row.balance.ruptured > 0);
    assert!(row.error.abs() <= 2e-14 * row.balance.initial);
}

/// Droplets that hit a wall with a film stay on its triangles, and the balance counts them.
#[test]
fn droplets_wet_a_wall_with_a_film() {
    let folder = tempfile::tempdir().unwrap();
    let droplets = folder.path().join("droplets.csv");
    let mut rows = "t,x,y,z,vx,vy,vz,diameter\n".to_owned();
    for k in 0..200 {
        let at = 1e-4 * f64::from(k);
        rows += &format!(
            "{at},0.01,{},{},-1.0,0.0,0.0,1e-4\n",
            1e-5 * f64::from(k),
            2e-4
        );
    }
    std::fs::write(&droplets, rows).unwrap();
    for (film, keeps) in [("film = {}", true), ("", false)] {
        let text = format!(
            "{AT_WALL}\n[[walls]]\nname = \"plate\"\nmaterial = \"wet\"\nshape = \"disc\"\naxis = [1, 0, 0]\norigin = [0, 0, 0]\nradius = 0.01\n{film}\n[[sprays]]\nname = \"list\"\npattern = {{ kind = \"points\", file = {:?} }}\nliquid_density = 1000.0\nat_walls = \"film\"\n",
            droplets.display().to_string()
        );
        let mut engine = start(&text, &["particles[0].position=[0.05, 0.05, 0.05]"]);
        for _ in 0..400 {
            engine.step(None).unwrap();
        }
        let row = engine.liquid().unwrap();
        let [in_flight, emitted, absorbed, lost, left] = row.sprayed;
        let on_walls = if keeps { row.wall_films } else { 0.0 };
        assert_eq!((in_flight, absorbed, left), (0.0, 0.0, 0.0));
        assert!((emitted - 200.0 * std::f64::consts::PI / 6.0 * 1e-12).abs() < 1e-22);
        assert!((emitted - on_walls - lost).abs() <= 1e-13 * emitted);
        assert_eq!(lost > 0.0, !keeps);
        assert!(row.error.abs() <= 1e-13 * emitted);
    }
}

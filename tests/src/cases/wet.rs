//! T24: liquid bridges, films and sprays.

use std::f64::consts::PI;
use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use mercury_common::scene::Files;
use mercury_engine::contact::adhesion::liquid::{Bridge, Fit, Liquid, Rupture, Tables};
use mercury_engine::contact::adhesion::young_laplace::{Branch, Table};
use mercury_engine::liquid::film_thickness;
use mercury_engine::step::{Engine, StartOptions};
use mercury_solver::plan::{parse_scene, plan};

use super::Case;
use super::Tolerance::{Absolute, Relative};
use crate::wet::WetCollision;

const MM: f64 = 1e-3;

fn law(fit: Fit, tension: f64, degrees: f64) -> Liquid {
    Liquid {
        fit,
        surface_tension: tension,
        contact_angle: degrees.to_radians(),
        max_volume: 1.0,
        rupture: if fit == Fit::Willett {
            Rupture::Lian
        } else {
            Rupture::Willett
        },
        ..Liquid::NONE
    }
}

/// Rows of T24.
pub(super) fn cases() -> Vec<Case> {
    let mut cases = forces();
    cases.extend(exact());
    cases.extend(wide_angles());
    cases.extend(collisions());
    cases.extend(migration());
    cases.extend(sprays());
    cases
}

/// Droplets of 0.2 mm at 2 m/s along (1, 2, -2)/3 from a full cone of 20 degrees: evenly in the solid angle, at the speed that was asked for.
fn sprays() -> Vec<Case> {
    const EVEN: &str = "even in the solid angle: the cosine is even between cos(20 degrees) and 1";
    /// Mean place of the cosines between both ends, and the largest difference of a speed from 2 m/s.
    fn measured() -> [f64; 2] {
        let text = r#"
seed = 7
time = { end = 1.0, step = 1e-4 }
domain = { min = [-1, -1, -1], max = [1, 1, 1] }
output = { interval = 0.1 }
[materials.grain]
density = 2500.0
normal = { law = "linear", stiffness = 1.0, dissipation = 0.0 }
[[sprays]]
name = "nozzle"
position = [0, 0, 0]
axis = [1, 2, -2]
pattern = { kind = "full-cone", half_angle_degrees = 20.0 }
flow_rate = 1e-6
speed = 2.0
droplets = { kind = "monodisperse", diameter = 2e-4 }
liquid_density = 1000.0
gravity = false
"#;
        let mut engine = crate::wet::start(text, &[]);
        engine.steps_at_once(100, None).expect("numbers");
        let droplets = engine
            .sprays()
            .map_or(&[][..], |sprays| &sprays.state.droplets);
        let axis = DVec3::new(1.0, 2.0, -2.0) / 3.0;
        let least = 20f64.to_radians().cos();
        let (mut sum, mut worst) = (0.0, 0.0f64);
        for droplet in droplets {
            let speed = droplet.velocity.length();
            sum += (droplet.velocity.dot(axis) / speed - least) / (1.0 - least);
            worst = worst.max((speed - 2.0).abs());
        }
        [sum / droplets.len() as f64, worst]
    }
    vec![
        Case::new(
            "T25 engine: full cone, mean place of the cosines of 2387 droplets between both ends",
            0.5,
            // Four standard deviations of the mean of even numbers.
            Absolute(4.0 / f64::sqrt(12.0 * 2387.0)),
            EVEN,
            || measured()[0],
        ),
        Case::new(
            "T25 engine: full cone, largest difference of a speed from 2 m/s (m/s)",
            0.0,
            Absolute(1e-12),
            "what was asked for",
            || measured()[1],
        ),
    ]
}

/// Forces of the formulas for spheres of 1 mm, V = 1e-11 m3.
fn forces() -> Vec<Case> {
    const PRINTED: &str = "the formula, evaluated by another program";
    let mut cases = Vec::new();
    let rows = [
        (Fit::Willett, 0.0728, 20.0, 1e-5, 3.803808290301e-4),
        (Fit::Willett, 0.0728, 20.0, 2e-4, 3.281147609191e-5),
        (Fit::WillettClassical, 0.0728, 20.0, 1e-5, 3.432702339759e-4),
        (Fit::WillettClassical, 0.0728, 20.0, 2e-4, 4.576941668278e-5),
        (Fit::LianSeville, 0.07, 10.0, 0.0, 3.802091487019e-4),
        (Fit::LianSeville, 0.07, 10.0, 1e-5, 3.443031196430e-4),
    ];
    for (fit, tension, degrees, gap, force) in rows {
        cases.push(Case::new(
            format!("T25 law: {}, force at a gap of {gap} m (N)", fit.name()),
            force,
            // Printed with 13 digits.
            Relative(1e-11),
            PRINTED,
            move || {
                let liquid = law(fit, tension, degrees);
                let bridge = liquid.fill(&Bridge::default(), 1e-11, [MM; 2], &Tables::default());
                liquid.force_at(&bridge, gap)
            },
        ));
    }
    for (fit, energy) in [
        (Fit::Bagheri, -3.121637337e-8),
        (Fit::LianSeville, -3.110171124e-8),
        (Fit::WillettClassical, -3.12564937e-8),
    ] {
        cases.push(Case::new(
            format!("T25 law: {}, energy at the touch (J)", fit.name()),
            energy,
            Relative(1e-8),
            "closed form or quadrature by another program",
            move || {
                let liquid = law(fit, 0.0728, 20.0);
                let bridge = liquid.fill(&Bridge::default(), 1e-11, [MM; 2], &Tables::default());
                liquid.energy_of(&bridge)
            },
        ));
    }
    let viscous = Liquid {
        viscosity: 1e-3,
        roughness: Some(1e-6),
        ..law(Fit::Bagheri, 0.0, 10.0)
    };
    let film = 6.0 * PI * 1e-3 * 0.5 * MM;
    for (part, k, expected) in [
        ("normal", 0, film * 500.0),
        (
            "tangential",
            1,
            film * (8.0 / 15.0 * f64::ln(500.0) + 0.9588),
        ),
    ] {
        cases.push(Case::new(
            format!("T25 law: largest {part} viscous coefficient of a film of 1 um (kg/s)"),
            expected,
            Relative(1e-12),
            "Adams & Perchard (1985); Goldman, Cox & Brenner (1967)",
            move || viscous.most_viscous(0.5 * MM)[k],
        ));
    }
    cases.push(Case::new(
        "T25 law: thickness of a film of 6e-11 m3 on a sphere of 1 mm (m)",
        4.752030727e-6,
        Relative(2e-10),
        "volume of a shell",
        || film_thickness(6e-11, MM),
    ));
    cases
}

/// Exact bridges: forces over gamma R_D at shares of S0 = (1 + theta/2)(V^(1/3) + 0.1 V^(2/3)), and what the table of the law makes of them.
fn exact() -> Vec<Case> {
    const SOURCE: &str = "another program that solves the Young-Laplace equation";
    let mut cases = Vec::new();
    let rows = [
        (
            0.0,
            0.01,
            1.0,
            [5.55685, 4.31894, 2.77803, 1.41253, 0.82154],
        ),
        (
            0.0,
            0.01,
            0.5,
            [5.54382, 4.31560, 2.77888, 1.41245, 0.81853],
        ),
        (
            0.0,
            0.01,
            0.2,
            [5.50476, 4.30550, 2.78146, 1.41227, 0.80953],
        ),
        (
            0.0,
            0.01,
            0.0,
            [5.43973, 4.28849, 2.78585, 1.41218, 0.79464],
        ),
        (
            0.0,
            0.05,
            0.0,
            [4.92864, 4.29778, 3.25866, 1.94187, 1.10165],
        ),
        (
            20.0,
            0.001,
            0.0,
            [5.44892, 3.34219, 1.53641, 0.61166, 0.32660],
        ),
        (
            20.0,
            0.01,
            0.5,
            [5.13278, 3.83749, 2.31544, 1.12821, 0.65259],
        ),
        (
            20.0,
            0.01,
            0.0,
            [5.03551, 3.81932, 2.32324, 1.12478, 0.61688],
        ),
        (
            20.0,
            0.05,
            0.2,
            [4.64335, 3.91564, 2.81288, 1.61014, 0.93980],
        ),
        (
            40.0,
            0.01,
            0.2,
            [3.95634, 2.92656, 1.72750, 0.86298, 0.52146],
        ),
    ];
    for (degrees, volume, ratio, forces) in rows {
        let theta = f64::to_radians(degrees);
        for (share, force) in [0.0, 0.1, 0.25, 0.5, 0.75].into_iter().zip(forces) {
            let root = f64::cbrt(volume);
            let gap = share * (1.0 + 0.5 * theta) * (root + 0.1 * root * root);
            let place = format!(
                "{degrees} degrees, V/R_D^3 = {volume}, radii 1 to {ratio} (0: a plane), gap {share} S0"
            );
            cases.push(Case::new(
                format!("T25 law: exact bridge, {place}: force over gamma R_D"),
                force,
                // Printed with six digits.
                Absolute(6e-6),
                SOURCE,
                move || {
                    let branch = Branch::new(theta, volume, ratio);
                    let bridge = branch.ok().and_then(|branch| branch.at(gap));
                    bridge.map_or(f64::NAN, |bridge| bridge.force)
                },
            ));
            cases.push(Case::new(
                format!("T25 law: young-laplace, {place}: force over gamma R_D"),
                force,
                // Accuracy that the scene requests.
                Relative(1e-3),
                SOURCE,
                move || {
                    let volumes = (0.5 * volume, 2.0 * volume);
                    let table = Table::new(theta, volumes, (ratio, ratio), 1e-3);
                    table.map_or(f64::NAN, |table| table.bind(volume, ratio).bound.force(gap))
                },
            ));
        }
    }
    cases
}

/// Contact angles beyond those of the fits: exact bridges and the table against an integration along the meridian, and the volume from which
/// `bagheri` is refused.
fn wide_angles() -> Vec<Case> {
    const SOURCE: &str = "integration of the Young-Laplace equation along the meridian";
    /// Largest error at four gaps, of the largest force: of the exact solution, and of the table.
    fn worst(degrees: f64, volume: f64) -> [f64; 2] {
        let theta = degrees.to_radians();
        let Ok(branch) = Branch::new(theta, volume, 1.0) else {
            return [f64::NAN; 2];
        };
        let table = Table::new(theta, (1e-3, 0.5), (1.0, 1.0), 1e-3);
        let Ok(table) = table else {
            return [f64::NAN; 2];
        };
        let bound = table.bind(volume, 1.0).bound;
        let (mut largest, mut errors) = (0.0f64, [0.0f64; 2]);
        for share in [0.0, 0.25, 0.5, 0.75] {
            let gap = share * branch.end();
            let Some(exact) = branch.at(gap) else {
                return [f64::NAN; 2];
            };
            let near = [exact.filling[0], 2.0 * exact.curvature];
            let Some(pull) = crate::meridian::pull(theta, volume, gap, near) else {
                return [f64::NAN; 2];
            };
            largest = largest.max(pull.abs());
            for (error, found) in errors.iter_mut().zip([exact.force, bound.force(gap)]) {
                *error = error.max((found - pull).abs());
            }
        }
        errors.map(|error| error / largest)
    }
    let mut cases = Vec::new();
    for degrees in [45.0, 60.0, 75.0, 90.0] {
        for volume in [0.01, 0.1] {
            let place = format!("{degrees} degrees, V/R_D^3 = {volume}, equal spheres");
            cases.push(Case::new(
                format!("T25 law: exact bridge, {place}: largest error, of the largest force"),
                0.0,
                // Both are converged beyond this.
                Absolute(1e-7),
                SOURCE,
                move || worst(degrees, volume)[0],
            ));
            cases.push(Case::new(
                format!("T25 law: young-laplace, {place}: largest error, of the largest force"),
                0.0,
                // Accuracy that the scene requests.
                Absolute(1e-3),
                SOURCE,
                move || worst(degrees, volume)[1],
            ));
        }
    }
    /// Least V/R_D^3 of a `max_bridge_volume` between spheres of 1 mm that a scene with `bagheri` is refused for.
    fn refused(degrees: f64) -> f64 {
        let is_planned = |volume: f64| {
            let text = format!(
                r#"
time = {{ end = 1e-3, step = 1e-6 }}
domain = {{ min = [0, 0, 0], max = [0.01, 0.01, 0.01] }}
output = {{ interval = 1e-3 }}
[materials.wet]
density = 2500.0
normal = {{ law = "linear", stiffness = 1000.0, dissipation = 0.0 }}
liquid = {{ law = "bagheri", surface_tension = 0.07, contact_angle_degrees = {degrees:?}, max_bridge_volume = {:e} }}
[[particles]]
material = "wet"
radius = 1e-3
lattice = {{ min = [0.002, 0.002, 0.002], max = [0.006, 0.003, 0.003], spacing = 0.003 }}
"#,
                volume * 1e-9
            );
            let scene = parse_scene(Path::new("wet.toml"), &text, &[], Files::MustExist);
            scene.and_then(|scene| plan(&scene)).is_ok()
        };
        let (mut low, mut high) = (1e-3, 2.0);
        for _ in 0..30 {
            let middle = 0.5 * (low + high);
            if is_planned(middle) {
                low = middle;
            } else {
                high = middle;
            }
        }
        high
    }
    // Roots of the denominator at the end of the gap, of the formula evaluated by another program.
    for (degrees, root) in [
        (50.0, 0.635_282),
        (60.0, 0.276_924),
        (70.0, 0.085_678_1),
        (80.0, 0.021_474_8),
    ] {
        cases.push(Case::new(
            format!("T25 plan: bagheri, {degrees} degrees: V/R_D^3 from which it is refused"),
            root,
            // Printed with six digits.
            Relative(3e-6),
            "root of the denominator of Bagheri et al. (2024)",
            move || refused(degrees),
        ));
    }
    cases
}

/// Restitution of wet collisions.
fn collisions() -> Vec<Case> {
    const INTEGRATED: &str = "equation of motion, integrated by another program";
    const THEORY: &str = "rigid grains and a film (Davis et al. 1986; Barnocky & Davis 1988)";
    let mut cases = Vec::new();
    for (at_wall, films, tension, restitution) in [
        (false, false, 0.0, [0.55551, 0.67775, 0.73888]),
        (false, false, 0.07, [0.49789, 0.66513, 0.73568]),
        (false, true, 0.0, [0.46186, 0.63093, 0.71547]),
        (false, true, 0.07, [0.39509, 0.61798, 0.71230]),
        (true, false, 0.07, [0.26031, 0.54984, 0.67767]),
        (true, true, 0.07, [0.06010, 0.47511, 0.64078]),
    ] {
        for (speed, expected) in [0.5, 1.0, 2.0].into_iter().zip(restitution) {
            let collision = WetCollision {
                at_wall,
                films,
                tension,
                speed,
            };
            let what = if at_wall {
                "grain and wall"
            } else {
                "two grains"
            };
            let form = if films {
                "as films meet"
            } else {
                "at the touch"
            };
            let set_up =
                format!("{what}, bridge {form}, {tension} N/m, {speed} m/s: wet restitution");
            cases.push(Case::new(
                format!("T25 engine: {set_up}"),
                expected,
                Absolute(4e-3),
                INTEGRATED,
                move || collision.restitution(),
            ));
            if tension == 0.0 {
                cases.push(Case::new(
                    format!("T25 engine: {set_up}, beside the theory"),
                    collision.theory(),
                    // A soft contact lasts; its film acts a little longer than that of rigid grains.
                    Absolute(4e-3),
                    THEORY,
                    move || collision.restitution(),
                ));
            }
        }
    }
    cases
}

/// How liquid moves: films of 3, 1 and 2 (1e-12 m3) on three grains in a row that touch one after the other, then part (largest bridge 2.5, share
/// 0.8).
fn migration() -> Vec<Case> {
    const RULES: &str = "rules of Mani et al. (2013), by hand";
    fn start() -> Engine {
        let text = r#"
time = { end = 1.0, step = 1e-4 }
domain = { min = [-1, -1, -1], max = [1, 1, 1] }
output = { interval = 0.1 }
[materials.wet]
density = 2500.0
normal = { law = "linear", stiffness = 1.0, dissipation = 0.0 }
liquid = { law = "willett", surface_tension = 0.0, contact_angle_degrees = 0.0, max_bridge_volume = 2.5e-12, distribution = 0.8 }
[[particles]]
material = "wet"
radius = 1e-3
position = [-1.99e-3, 0, 0]
velocity = [-1e-3, 0, 0]
film_volume = 3e-12
prescribed = { velocity = [-1e-3, 0, 0], angular_velocity = [0, 0, 0] }
[[particles]]
material = "wet"
radius = 1e-3
position = [0, 0, 0]
film_volume = 1e-12
prescribed = { velocity = [0, 0, 0], angular_velocity = [0, 0, 0] }
[[particles]]
material = "wet"
radius = 1e-3
position = [2.01e-3, 0, 0]
velocity = [-1e-3, 0, 0]
film_volume = 2e-12
prescribed = { velocity = [-1e-3, 0, 0], angular_velocity = [0, 0, 0] }
"#;
        let scene = parse_scene(Path::new("row.toml"), text, &[], Files::MustExist);
        let planned = scene.and_then(|scene| plan(&scene));
        let planned = planned.unwrap_or_else(|errors| panic!("{errors}"));
        let mut engine =
            Engine::start(Arc::new(planned), StartOptions::threads(1)).expect("a start");
        // The first pair parts at a gap of V^(1/3) = 1.36e-4 m, after 0.146 s; the other is 1.4e-4 m deep then.
        engine.steps_at_once(2000, None).expect("numbers");
        engine
    }
    let films: fn(usize) -> f64 = |row| {
        let engine = start();
        let films = engine
            .particles
            .columns
            .get("film_volume")
            .unwrap_or_default();
        films.get(row).copied().unwrap_or(f64::NAN)
    };
    let mut cases = Vec::new();
    for (name, row, expected) in [
        ("first", 0, 2.375e-12),
        ("second", 1, 1.125e-12),
        ("third", 2, 0.0),
    ] {
        cases.push(Case::new(
            format!("T25 engine: film of the {name} of three grains (m3)"),
            expected,
            Absolute(1e-24),
            RULES,
            move || films(row),
        ));
    }
    cases.push(Case::new(
        "T25 engine: bridge of the second and the third of three grains (m3)",
        2.5e-12,
        Absolute(1e-24),
        RULES,
        || {
            start()
                .bridges()
                .first()
                .map_or(f64::NAN, |bridge| bridge.memory.volume)
        },
    ));
    cases
}

//! `[[sprays]]` as the engine's plan.

use glam::DVec3;
use libm::cos;
use mercury_common::curve::Curve;
use mercury_common::formats::time_table::{TimeRow, TimeTable};
use mercury_common::scene::{
    AtWalls, Located, Nozzle, Psd, Scene, SceneError, SizeLaw, Spray, SprayFlow, SprayPattern,
    SpraySource,
};
use mercury_common::sizes::{SizeDistribution, SizeError};

use crate::plan::cell_of;
use mercury_engine::cell::Cell;
use mercury_engine::contact::parameter::short;
use mercury_engine::spray::{Drag, Flow, NozzlePlan, Pattern, Point, SourcePlan, SprayPlan};
use mercury_engine::walls::{Scratch, Wall, WallNow};

/// All sprays, in the order of the file; `None` where there are none.
pub(crate) fn sprays(
    scene: &Scene,
    walls: &[Wall],
    dimensions: u8,
    warnings: &mut Vec<String>,
    errors: &mut Vec<SceneError>,
) -> Option<SprayPlan> {
    let first = scene.sprays.first()?;
    if dimensions == 2 {
        let message = "droplets need three dimensions: a disc has no surface to be wetted";
        errors.push(first.name.place.error(message));
        return None;
    }
    one_density(scene, errors);
    if scene.walls.iter().all(|wall| wall.film.is_none())
        && let Some(spray) = (scene.sprays.iter()).find(|spray| spray.at_walls == AtWalls::Film)
    {
        warnings.push(format!(
            "spray \"{}\": at_walls = \"film\", but no wall has a `film`, so that what hits walls is lost; give one: film = {{}} at a wall",
            spray.name.value
        ));
    }
    let standing = Standing::new(scene, walls);
    let nozzles = (scene.sprays.iter())
        .filter_map(|spray| plan_one(scene, spray, (walls, &standing), warnings, errors))
        .collect();
    Some(SprayPlan {
        nozzles,
        seed: scene.seed,
    })
}

/// Whether all sprays agree where liquid has mass, as films mix.
fn one_density(scene: &Scene, errors: &mut Vec<SceneError>) {
    let Some(first) = scene.sprays.iter().find(|spray| *spray.mass) else {
        return;
    };
    for spray in &scene.sprays {
        let message = if !*spray.mass {
            format!(
                "has no mass, but \"{}\" has: the films of particles hold liquid of both",
                first.name.value
            )
        } else if *spray.liquid_density != *first.liquid_density {
            format!(
                "sprays liquid of {} kg/m3, but \"{}\" of {}: the films of particles hold liquid of both, and all of it needs one density",
                *spray.liquid_density, first.name.value, *first.liquid_density
            )
        } else {
            continue;
        };
        let error = spray.name.place.error(message);
        errors.push(error.with_help(
            "give all sprays `mass = true` and the same liquid_density, or none of them mass",
        ));
    }
}

fn plan_one(
    scene: &Scene,
    spray: &Spray,
    (walls, standing): (&[Wall], &Standing),
    warnings: &mut Vec<String>,
    errors: &mut Vec<SceneError>,
) -> Option<NozzlePlan> {
    let source = match &spray.source {
        SpraySource::Points(file) => match points(scene, standing, file.as_path()) {
            Ok(points) => Some(SourcePlan::Points(points)),
            Err(message) => {
                errors.push(file.error(message));
                None
            }
        },
        SpraySource::Nozzle(nozzle) => source(scene, spray, nozzle, (walls, standing), errors),
    };
    let planned = NozzlePlan {
        name: spray.name.value.clone(),
        source: source?,
        liquid_density: *spray.liquid_density,
        gravity: spray.gravity,
        drag: spray.drag.as_ref().map(|drag| Drag {
            density: drag.gas_density,
            viscosity: drag.gas_viscosity,
            velocity: drag.gas_velocity,
        }),
        at_walls: spray.at_walls,
        restitution: spray.restitution.as_deref().copied().unwrap_or(0.0),
        momentum: spray.momentum || *spray.mass,
        mass: *spray.mass,
        max_droplets: *spray.max_droplets,
        from: *spray.from,
        until: spray.until.as_deref().copied().unwrap_or(f64::INFINITY),
    };
    warnings.extend(too_many(scene, &planned));
    Some(planned)
}

/// Whether a place lies in the domain; along periodic axes it always does.
fn is_inside(scene: &Scene, place: DVec3) -> bool {
    let (min, max) = (*scene.domain.min, *scene.domain.max);
    (0..3).all(|axis| {
        scene.domain.periodic[axis] || (min[axis] <= place[axis] && place[axis] <= max[axis])
    })
}

fn source(
    scene: &Scene,
    spray: &Spray,
    nozzle: &Nozzle,
    (walls, standing): (&[Wall], &Standing),
    errors: &mut Vec<SceneError>,
) -> Option<SourcePlan> {
    let before = errors.len();
    let place = &nozzle.position;
    if !is_inside(scene, **place) {
        let error = place.error("the nozzle is outside of the domain");
        errors.push(error.with_help("move it into the box of domain.min and domain.max"));
    } else if let Some(wall) = standing.hides(**place) {
        let error = place.error(format!("the nozzle is in or behind the wall `{wall}`"));
        let help = "move it to the side on which particles are: each droplet would end at once";
        errors.push(error.with_help(help));
    }
    let carrier = nozzle.carrier.as_ref().and_then(|name| {
        let found = walls.iter().position(|wall| wall.name == name.value);
        if found.is_none() {
            let names: Vec<&str> = walls.iter().map(|wall| wall.name.as_str()).collect();
            let error = name.error(format!("there is no wall \"{}\"", name.value));
            let help = if names.is_empty() {
                "the scene has no walls".to_owned()
            } else {
                format!("the walls are {}", names.join(", "))
            };
            errors.push(error.with_help(help));
        }
        found
    });
    let sizes = match sizes(&nozzle.droplets) {
        Ok(sizes) => Some(sizes),
        Err(error) => {
            errors.push(error);
            None
        }
    };
    if let Some(fines) = sizes.as_ref().and_then(SizeDistribution::warning_of_fines) {
        let message = "has no smallest droplet: a second of the flow holds no number of them";
        errors.push(nozzle.droplets.place.error(message).with_help(fines));
    }
    let flow = match &nozzle.flow_rate {
        SprayFlow::Constant(rate) => Some(Flow::Constant(**rate)),
        SprayFlow::Table(file) => match flow_table(file.as_path()) {
            Ok(rates) => Some(Flow::table(&rates, *spray.from)),
            Err(message) => {
                errors.push(file.error(message));
                None
            }
        },
    };
    let axis = *nozzle.axis;
    let wide = match &nozzle.pattern {
        SprayPattern::FlatFan { wide_axis, .. } => **wide_axis,
        SprayPattern::Cone { .. } => axis.any_orthonormal_vector(),
    };
    let wide = (wide - axis * wide.dot(axis)).normalize();
    let pattern = match &nozzle.pattern {
        SprayPattern::FlatFan {
            half_angles_degrees,
            ..
        } => Pattern::FlatFan((**half_angles_degrees).map(f64::to_radians)),
        SprayPattern::Cone {
            half_angles_degrees,
        } => Pattern::Cone((**half_angles_degrees).map(|angle: f64| cos(angle.to_radians()))),
    };
    let (flow, sizes) = flow.zip(sizes)?;
    (errors.len() == before).then(|| SourcePlan::Nozzle {
        position: **place,
        frame: [axis, wide, axis.cross(wide)],
        pattern,
        orifice: *nozzle.orifice,
        flow,
        speed: [*nozzle.speed, nozzle.speed_spread],
        sizes,
        carrier,
    })
}

/// The walls at the start, for places that must lie in front of them.
struct Standing {
    walls: Vec<WallNow>,
    names: Vec<String>,
    cell: Cell,
}

impl Standing {
    fn new(scene: &Scene, walls: &[Wall]) -> Self {
        let cell = cell_of(&scene.domain);
        let there: Vec<&Wall> = walls.iter().filter(|wall| wall.from <= 0.0).collect();
        // Where they stand at the start does not depend on the step.
        let now = |wall: &&Wall| WallNow::new(wall, 1.0, &cell);
        Self {
            walls: there.iter().map(now).collect(),
            names: there.iter().map(|wall| wall.name.clone()).collect(),
            cell,
        }
    }

    /// The wall behind which a place (m) lies, or in which; of one that acts on both sides there is no such place.
    fn hides(&self, place: DVec3) -> Option<&str> {
        let mut scratch = Scratch::default();
        let behind = |wall: &WallNow| wall.is_behind(&self.cell, place, &mut scratch);
        let index = self.walls.iter().position(behind)?;
        Some(&self.names[index])
    }
}

fn sizes(psd: &Located<Psd>) -> Result<SizeDistribution, SceneError> {
    SizeDistribution::from_scene(psd).map_err(|error| match error {
        SizeError::Improper(error) => error,
        SizeError::File(error) => match &psd.law {
            SizeLaw::File { file } => file.error(error.to_string()),
            _ => psd.error(error.to_string()),
        },
        error @ SizeError::Law(_) => psd.error(error.to_string()),
    })
}

fn flow_table(path: &std::path::Path) -> Result<Curve, String> {
    let table = TimeTable::new(["t", "rate"]);
    let rows = table.read(path).map_err(|error| error.to_string())?;
    let at = |line: usize, message: String| format!("{}:{line}: {message}", path.display());
    if let [row] = rows[..] {
        return Err(at(
            row.line,
            "needs at least two rows: the rate is linear between them".to_owned(),
        ));
    }
    if let Some(row) = rows.iter().find(|row| row.values[1] < 0.0) {
        return Err(at(
            row.line,
            format!("rate = {} is negative", row.values[1]),
        ));
    }
    Ok(Curve::of_table(&rows, |row| row[1]))
}

fn points(
    scene: &Scene,
    standing: &Standing,
    path: &std::path::Path,
) -> Result<Vec<Point>, String> {
    let table = TimeTable {
        equal_times: true,
        ..TimeTable::new(["t", "x", "y", "z", "vx", "vy", "vz", "diameter"])
    };
    let rows = table.read(path).map_err(|error| error.to_string())?;
    let mut points: Vec<Point> = Vec::with_capacity(rows.len());
    for TimeRow { line, values } in rows {
        let [time, x, y, z, vx, vy, vz, diameter] = values;
        let position = DVec3::new(x, y, z);
        let wrong = if diameter <= 0.0 {
            Some(format!("diameter = {diameter} is not above 0"))
        } else if !is_inside(scene, position) {
            Some("the droplet starts outside of the domain".to_owned())
        } else {
            let wall = standing.hides(position);
            wall.map(|wall| format!("the droplet starts in or behind the wall `{wall}`"))
        };
        if let Some(message) = wrong {
            return Err(format!("{}:{line}: {message}", path.display()));
        }
        points.push(Point {
            time,
            position,
            velocity: DVec3::new(vx, vy, vz),
            diameter,
        });
    }
    Ok(points)
}

/// Warns of a nozzle from which more droplets may come to fly at once than allowed.
fn too_many(scene: &Scene, nozzle: &NozzlePlan) -> Option<String> {
    let SourcePlan::Nozzle {
        flow, sizes, speed, ..
    } = &nozzle.source
    else {
        return None;
    };
    let rate = flow.largest() / sizes.mean_volume();
    let time = nozzle.until.min(*scene.time.end) - nozzle.from;
    // No flight is longer than one across the whole domain: straight, or up and down again under gravity.
    let way = (*scene.domain.max - *scene.domain.min).length();
    let gravity = if nozzle.gravity {
        scene.gravity.length()
    } else {
        0.0
    };
    let fastest = speed[0] + speed[1];
    let periodic = scene.domain.periodic.contains(&true);
    let bounces = nozzle.at_walls == AtWalls::Bounce;
    let flight = if periodic || bounces || nozzle.drag.is_some() {
        f64::INFINITY
    } else if gravity > 0.0 {
        (fastest + (fastest * fastest + 2.0 * gravity * way).sqrt()) / gravity
    } else {
        way / (speed[0] - speed[1])
    };
    let most = rate * time.min(flight).max(0.0);
    (most > nozzle.max_droplets as f64).then(|| {
        format!(
            "spray \"{}\": up to {} droplets may be in flight at once, and max_droplets = {} ends the run; raise it, spray larger droplets or less, or check the units of flow and diameter",
            nozzle.name,
            short(most),
            nozzle.max_droplets
        )
    })
}

//! The walls of a scene and their motions as those of the engine; boxes fall apart into their faces.

use glam::DVec3;
use mercury_common::curve::Curve;
use mercury_common::formats::time_table::TimeTable;
use mercury_common::scene::{
    Domain, Face, Load, Motion as SceneMotion, MotionKind, Scene, SceneError, ServoTarget,
    Shape as SceneShape, Wall as SceneWall,
};

use super::start_from_frame::EarlierWalls;
use super::wall_shapes::{ShapeFrame, edge_on, own_origin, shape};
use mercury_engine::cell::image;
use mercury_engine::state::MaterialIndex;
use mercury_engine::walls::{Area, Component, Motion, MotionTable, Servo, Shape, Target, Wall};

/// Most walls: the contact loop numbers them with 16 bits.
const MOST_WALLS: usize = 1 << 16;

/// A cylinder may be shorter than a period by this part of it and still spans it.
const SPANS: f64 = 1e-9;

/// All walls that can be built, in the order of the file, faces of boxes in the order -x +x -y +y -z +z. `then`: where walls of another run
/// stood, from which this one starts.
pub(super) fn walls(
    scene: &Scene,
    then: &EarlierWalls,
    warnings: &mut Vec<String>,
    remarks: &mut Vec<String>,
    errors: &mut Vec<SceneError>,
) -> Vec<Wall> {
    let mut planned = Vec::new();
    for wall in &scene.walls {
        let Some(motion) = motion(wall, errors) else {
            continue;
        };
        let name = &wall.name.value;
        let parts: Vec<(String, Option<Face>)> = match &wall.shape {
            SceneShape::Box { sides } => {
                let part = |face: &Face| (format!("{name}.{}", face.name()), Some(*face));
                sides.iter().map(part).collect()
            }
            _ => vec![(name.clone(), None)],
        };
        for (name, face) in parts {
            let stated = shape(wall, face, &scene.domain, ShapeFrame::AS_STATED, warnings);
            let pose = stated
                .as_ref()
                .ok()
                .and_then(|(shape, _)| then.pose_of(&name, shape));
            let placed = match pose {
                None => stated,
                Some(pose) => {
                    remarks.push(format!("walls.{name}: it stands where it was in that run"));
                    shape(
                        wall,
                        face,
                        &scene.domain,
                        ShapeFrame(Some(pose)),
                        &mut Vec::new(),
                    )
                }
            };
            match placed {
                Ok((shape, _)) if let Some(error) = out_of_reach(wall, &shape, &scene.domain) => {
                    errors.push(error);
                }
                Ok((shape, own)) => planned.push(Wall {
                    name,
                    material: MaterialIndex::new(wall.material.0 as u32),
                    shape,
                    motion: motion.clone(),
                    from: *wall.from,
                    until: wall.until.as_deref().copied().unwrap_or(f64::INFINITY),
                    reference: motion_origin(wall).unwrap_or(own),
                }),
                Err(error) => errors.push(error),
            }
        }
    }
    if planned.len() > MOST_WALLS {
        let message = format!("{} walls; at most {MOST_WALLS} are possible", planned.len());
        errors.push(scene.place.error(message));
    }
    planned
}

/// Gives cylinders that lie along a periodic axis and span it no ends: they and their images are one surface.
pub(super) fn continue_cylinders(walls: &mut [Wall], domain: &Domain, notes: &mut Vec<String>) {
    let size = *domain.max - *domain.min;
    for wall in walls {
        let Shape::Cylinder(cylinder) = &wall.shape else {
            continue;
        };
        let (low, high) = wall.shape.bounds();
        let goes_on = |&axis: &usize| {
            let extent = high[axis] - low[axis];
            domain.periodic[axis]
                && wall.motion.keeps_axis(axis)
                && cylinder.direction().cross(DVec3::AXES[axis]) == DVec3::ZERO
                && extent.is_finite()
                && extent >= size[axis] * (1.0 - SPANS)
        };
        if let Some(axis) = (0..3).find(goes_on) {
            notes.push(format!(
                "walls.{}: the cylinder spans the periodic axis {} and goes on for ever along it",
                wall.name,
                ["x", "y", "z"][axis]
            ));
            wall.shape = Shape::Cylinder(cylinder.endless());
        }
    }
}

/// The message for a wall so far beside a periodic domain that its images have no codes.
fn out_of_reach(wall: &SceneWall, shape: &Shape, domain: &Domain) -> Option<SceneError> {
    let (low, high) = shape.bounds();
    let size = *domain.max - *domain.min;
    let periods = |axis: usize| {
        let below = (domain.min[axis] - low[axis]) / size[axis];
        below.max((high[axis] - domain.max[axis]) / size[axis])
    };
    // One for the particles beyond the faces.
    let most = f64::from(image::MOST_PERIODS - 1);
    let is_far =
        |&axis: &usize| domain.periodic[axis] && periods(axis).is_finite() && periods(axis) > most;
    let axis = (0..3).find(is_far)?;
    let message = format!(
        "it reaches {} periods beyond the periodic axis {}; at most {most} are possible",
        periods(axis).round(),
        ["x", "y", "z"][axis],
    );
    Some(
        wall.place
            .error(message)
            .with_help("move it into the domain"),
    )
}

/// The point about which the torque of a wall is given if its motion has one: the origin of the first rotation.
fn motion_origin(wall: &SceneWall) -> Option<DVec3> {
    wall.motion.iter().find_map(|motion| match &motion.kind {
        MotionKind::Rotation { origin, .. } => Some(**origin),
        _ => None,
    })
}

fn motion(wall: &SceneWall, errors: &mut Vec<SceneError>) -> Option<Motion> {
    let before = errors.len();
    let mut components = Vec::new();
    for motion in &wall.motion {
        match component(wall, motion) {
            Ok(component) => components.push(component),
            Err(error) => errors.push(error),
        }
    }
    if errors.len() > before {
        return None;
    }
    match Motion::new(components) {
        Ok(motion) => Some(motion),
        Err(error) => {
            errors.push(wall.place.error(error.to_string()));
            None
        }
    }
}

/// The engine's form of a motion of a wall.
fn component(wall: &SceneWall, motion: &SceneMotion) -> Result<Component, SceneError> {
    if let MotionKind::Servo {
        axis,
        target: aim,
        max_speed,
    } = &motion.kind
    {
        return Ok(Component::Servo(Servo {
            axis: **axis,
            target: target(wall, **axis, aim)?,
            max_speed: **max_speed,
            from: *motion.from,
            until: motion.until.as_deref().copied().unwrap_or(f64::INFINITY),
        }));
    }
    component_about(own_origin(wall), motion)
}

/// The engine's form of a motion that is no servo; `origin`: the point about which a table turns, m.
pub(crate) fn component_about(
    origin: DVec3,
    motion: &SceneMotion,
) -> Result<Component, SceneError> {
    let own_origin = origin;
    let from = *motion.from;
    let until = motion.until.as_deref().copied().unwrap_or(f64::INFINITY);
    Ok(match &motion.kind {
        MotionKind::External => Component::External,
        MotionKind::Translation { velocity } => Component::Translation {
            velocity: **velocity,
            from,
            until,
        },
        MotionKind::Rotation {
            axis,
            origin,
            angular_velocity,
        } => Component::Rotation {
            axis: **axis,
            origin: **origin,
            angular_velocity: **angular_velocity,
            from,
            until,
        },
        MotionKind::Oscillation {
            amplitude,
            frequency,
            phase_degrees,
        } => Component::Oscillation {
            amplitude: **amplitude,
            frequency: **frequency,
            phase: phase_degrees.to_radians(),
            from,
            until,
        },
        MotionKind::Table { file } => Component::Table {
            table: MotionTable::read(file).map_err(|error| file.error(error.to_string()))?,
            origin: own_origin,
        },
        MotionKind::Servo { .. } => {
            return Err(motion.place.error("only a wall has a servo"));
        }
    })
}

/// Target of a servo along `axis`.
fn target(wall: &SceneWall, axis: DVec3, aim: &ServoTarget) -> Result<Target, SceneError> {
    Ok(match aim {
        ServoTarget::Force(load) => Target::Force(curve(load, "force")?),
        ServoTarget::Pressure {
            load,
            area: Some(area),
        } => Target::Pressure(curve(load, "pressure")?, Area::Given(**area)),
        ServoTarget::Pressure { load, area: None } => {
            let has_one = matches!(
                wall.shape,
                SceneShape::Box { .. } | SceneShape::Plane { .. } | SceneShape::Disc { .. }
            );
            let place = match load {
                Load::Constant(number) => &number.place,
                Load::Rows(rows) => &rows.place,
                Load::Table(file) => &file.place,
            };
            if let Some(what) = edge_on(wall, axis) {
                let message = format!("{what} has no area as seen along the axis of the servo");
                return Err(place.error(message).with_help(
                    "turn the axis to the wall's normal, or give `area`; of a box name the faces that are pressed: sides = [\"+z\"]",
                ));
            }
            if !has_one {
                let error = place.error(
                    "needs an `area`: of planes, boxes and discs it follows from the shape, of this wall it does not",
                );
                return Err(
                    error.with_help("for example: area = 9e-4   # m2, as seen along the axis")
                );
            }
            Target::Pressure(curve(load, "pressure")?, Area::OfWall)
        }
    })
}

/// A load over time; `column` names it in a table.
pub(crate) fn curve(load: &Load, column: &str) -> Result<Curve, SceneError> {
    match load {
        Load::Constant(value) => {
            Curve::constant(**value).map_err(|error| value.error(error.to_string()))
        }
        Load::Rows(rows) => {
            let pairs = rows.iter().map(|&[time, load]| (time, load));
            Curve::new(pairs.collect()).map_err(|error| rows.error(error.to_string()))
        }
        Load::Table(file) => {
            let rows = TimeTable::new(["t", column]).read(file);
            let rows = rows.map_err(|error| file.error(error.to_string()))?;
            Ok(Curve::of_table(&rows, |row| row[1]))
        }
    }
}

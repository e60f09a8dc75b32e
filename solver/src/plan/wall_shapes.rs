//! The shapes of walls of a scene as the engine's shapes: all that depends on which shape a wall has.

use std::f64::consts::PI;

use glam::DVec3;
use mercury_common::scene::{
    Domain, Face, Motion as SceneMotion, MotionKind, SceneError, Shape as SceneShape,
    Side as SceneSide, Wall as SceneWall,
};

use super::meshes;
use mercury_engine::walls::{
    Cone, Cylinder, Disc, Plane, Pose, Revolution, SectionBox, Shape, Side, SphereShell,
    plane_section,
};

/// Where a wall begins: where the scene has it, or elsewhere.
#[derive(Clone, Copy)]
pub(super) struct ShapeFrame<'a>(pub(super) Option<&'a Pose>);

impl ShapeFrame<'_> {
    pub(super) const AS_STATED: Self = Self(None);

    fn point(self, x: DVec3) -> DVec3 {
        self.0.map_or(x, |pose| pose.to_global(x))
    }

    fn direction(self, v: DVec3) -> DVec3 {
        self.0.map_or(v, |pose| pose.rotation * v)
    }
}

/// The surface of a wall, of boxes of one face, and the point about which its torque is given unless it turns.
pub(super) fn shape(
    wall: &SceneWall,
    face: Option<Face>,
    domain: &Domain,
    at: ShapeFrame<'_>,
    warnings: &mut Vec<String>,
) -> Result<(Shape, DVec3), SceneError> {
    let plane = |point, normal| Plane::new(at.point(point), at.direction(normal)).map(Shape::Plane);
    let (shape, own) = match &wall.shape {
        SceneShape::Box { .. } => {
            let (point, normal) = match face {
                Some(face) => face_plane(face, domain),
                None => (DVec3::ZERO, DVec3::ZERO),
            };
            (plane(point, normal), DVec3::ZERO)
        }
        SceneShape::Plane { point, normal } => (plane(**point, **normal), **point),
        SceneShape::Disc {
            axis,
            origin,
            radius,
        } => {
            let shape = Disc::new(at.direction(**axis), at.point(**origin), **radius);
            (shape.map(Shape::Disc), **origin)
        }
        SceneShape::Cylinder {
            axis,
            origin,
            radius,
            along,
            side: inner,
        } => {
            let (axis, place) = (at.direction(**axis), at.point(**origin));
            let along = along.as_deref().copied();
            let shape = Cylinder::new(axis, place, **radius, along, side(*inner));
            (shape.map(Shape::Cylinder), **origin)
        }
        SceneShape::Cone {
            axis,
            origin,
            along,
            radii,
            side: inner,
        } => {
            let (axis, place) = (at.direction(**axis), at.point(**origin));
            let shape = Cone::new(axis, place, **along, **radii, side(*inner));
            (shape.map(Shape::Cone), **origin)
        }
        SceneShape::Sphere {
            origin,
            radius,
            side: inner,
        } => {
            let shape = SphereShell::new(at.point(**origin), **radius, side(*inner));
            (shape.map(Shape::Sphere), **origin)
        }
        SceneShape::Revolution {
            axis,
            origin,
            profile,
            side: inner,
        } => {
            let (axis, place) = (at.direction(**axis), at.point(**origin));
            let shape = Revolution::new(axis, place, profile, side(*inner));
            (shape.map(Shape::Revolution), **origin)
        }
        SceneShape::Mesh { mesh, side } => {
            let shape = meshes::mesh(mesh, *side, |x| at.point(x), warnings)?;
            let shape = meshes::fit_to_wear(mesh, wall.wear.as_ref(), shape)?;
            (Ok(shape), DVec3::ZERO)
        }
    };
    let shape = shape.map_err(|error| wall.place.error(error.to_string()))?;
    Ok((shape, at.point(own)))
}

/// The point about which a table turns the wall.
pub(super) fn own_origin(wall: &SceneWall) -> DVec3 {
    match &wall.shape {
        SceneShape::Plane { point, .. } => **point,
        SceneShape::Disc { origin, .. }
        | SceneShape::Cylinder { origin, .. }
        | SceneShape::Cone { origin, .. }
        | SceneShape::Sphere { origin, .. }
        | SceneShape::Revolution { origin, .. } => **origin,
        SceneShape::Box { .. } | SceneShape::Mesh { .. } => DVec3::ZERO,
    }
}

/// Whether a flat wall is edge-on to a direction, and stays so.
pub(super) fn edge_on(wall: &SceneWall, axis: DVec3) -> Option<String> {
    let turns = |motion: &SceneMotion| {
        matches!(
            motion.kind,
            MotionKind::Rotation { .. } | MotionKind::Table { .. }
        )
    };
    // Less than this is round-off of directions that were meant to be at right angles.
    let is_edge_on =
        |normal: DVec3| normal.dot(axis).abs() <= 1e-9 * normal.length() * axis.length();
    if wall.motion.iter().any(turns) {
        return None;
    }
    match &wall.shape {
        SceneShape::Plane { normal, .. } if is_edge_on(**normal) => Some("the plane".to_owned()),
        SceneShape::Disc { axis: normal, .. } if is_edge_on(**normal) => {
            Some("the disc".to_owned())
        }
        SceneShape::Box { sides } => {
            let face = sides
                .iter()
                .find(|face| is_edge_on(DVec3::AXES[face.axis]))?;
            Some(format!("the face {}", face.name()))
        }
        _ => None,
    }
}

/// Area of a shape that is no mesh, m^2; of one without an end the part within the domain.
pub(crate) fn area(shape: &Shape, typed: &SceneShape, domain: &Domain) -> f64 {
    let (min, max) = (*domain.min, *domain.max);
    match typed {
        SceneShape::Box { .. } | SceneShape::Plane { .. } => match shape {
            Shape::Plane(plane) => {
                let room = SectionBox::new(min, max, 3);
                plane_section(plane.point(), plane.normal(), &room)
            }
            _ => 0.0,
        },
        SceneShape::Disc { radius, .. } => PI * **radius * **radius,
        SceneShape::Cylinder {
            axis,
            origin,
            radius,
            along,
            ..
        } => {
            let length = along.as_deref().map_or_else(
                || length_within(**origin, axis.normalize(), min, max),
                |[from, to]| to - from,
            );
            2.0 * PI * **radius * length
        }
        SceneShape::Cone { along, radii, .. } => {
            frustum([[radii[0], along[0]], [radii[1], along[1]]])
        }
        SceneShape::Sphere { radius, .. } => 4.0 * PI * **radius * **radius,
        SceneShape::Revolution { profile, .. } => profile
            .windows(2)
            .map(|two| frustum([two[0], two[1]]))
            .sum(),
        SceneShape::Mesh { .. } => 0.0,
    }
}

/// Lateral area of a frustum between two points (r, z), m^2.
fn frustum([[r0, z0], [r1, z1]]: [[f64; 2]; 2]) -> f64 {
    PI * (r0 + r1) * libm::hypot(r1 - r0, z1 - z0)
}

/// The length of a line within a box, m.
fn length_within(point: DVec3, direction: DVec3, min: DVec3, max: DVec3) -> f64 {
    let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
    for axis in 0..3 {
        if direction[axis] == 0.0 {
            continue;
        }
        let ends = [min, max].map(|corner| (corner[axis] - point[axis]) / direction[axis]);
        from = from.max(ends[0].min(ends[1]));
        to = to.min(ends[0].max(ends[1]));
    }
    (to - from).max(0.0)
}

fn side(side: SceneSide) -> Side {
    match side {
        SceneSide::Inside => Side::Inside,
        SceneSide::Outside => Side::Outside,
    }
}

/// The middle of a face of the domain and the direction into the domain.
fn face_plane(face: Face, domain: &Domain) -> (DVec3, DVec3) {
    let mut point = 0.5 * (*domain.min + *domain.max);
    let mut normal = DVec3::ZERO;
    if face.is_upper {
        point[face.axis] = domain.max[face.axis];
        normal[face.axis] = -1.0;
    } else {
        point[face.axis] = domain.min[face.axis];
        normal[face.axis] = 1.0;
    }
    (point, normal)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_in_a_box_and_frusta() {
        let (min, max) = (DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0));
        let close = |found: f64, expected: f64| {
            assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
        };
        close(length_within(DVec3::splat(0.5), DVec3::Y, min, max), 2.0);
        close(
            length_within(DVec3::ZERO, max.normalize(), min, max),
            max.length(),
        );
        close(frustum([[1.0, 0.0], [1.0, 2.0]]), 4.0 * PI);
        close(frustum([[0.0, 0.0], [3.0, 4.0]]), 15.0 * PI);
    }
}

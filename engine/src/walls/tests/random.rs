//! Random shapes and poses, with a description of the shapes that owes nothing to the code under test.

use crate::walls::{
    Cone, Cylinder, Disc, Plane, Pose, Revolution, Shape, Side, SphereShell, WallError,
};
use glam::{DQuat, DVec3};
use proptest::prelude::*;

/// A shape before it is put somewhere: axis along z, origin at zero.
#[derive(Debug, Clone)]
pub(super) enum Kind {
    Plane,
    Disc(f64),
    Cylinder(f64, Option<[f64; 2]>),
    Cone([f64; 2], [f64; 2]),
    Sphere(f64),
    Revolution(Vec<[f64; 2]>),
}

impl Kind {
    /// The shape with its z axis along `rotation * z` and its origin at `translation`.
    pub(super) fn build(&self, pose: &Pose, side: Side) -> Result<Shape, WallError> {
        let (axis, origin) = (pose.rotation * DVec3::Z, pose.translation);
        Ok(match self {
            Self::Plane => Shape::Plane(Plane::new(origin, axis)?),
            Self::Disc(radius) => Shape::Disc(Disc::new(axis, origin, *radius)?),
            Self::Cylinder(radius, along) => {
                Shape::Cylinder(Cylinder::new(axis, origin, *radius, *along, side)?)
            }
            Self::Cone(along, radii) => Shape::Cone(Cone::new(axis, origin, *along, *radii, side)?),
            Self::Sphere(radius) => Shape::Sphere(SphereShell::new(origin, *radius, side)?),
            Self::Revolution(profile) => {
                Shape::Revolution(Revolution::new(axis, origin, profile, side)?)
            }
        })
    }

    /// The profile of the shape, if it has one of finite length.
    pub(super) fn profile(&self) -> Option<Vec<[f64; 2]>> {
        match self {
            Self::Disc(radius) => Some(vec![[0.0, 0.0], [*radius, 0.0]]),
            Self::Cylinder(r, Some([a, b])) => Some(vec![[*r, *a], [*r, *b]]),
            Self::Cone([a, b], [r, s]) => Some(vec![[*r, *a], [*s, *b]]),
            Self::Revolution(profile) => Some(profile.clone()),
            Self::Plane | Self::Sphere(_) | Self::Cylinder(_, None) => None,
        }
    }

    /// Points of the surface on an `n` by `n` grid, and the largest distance of any point of the
    /// surface from the nearest of them. Unbounded shapes: the part within about 3 of the origin.
    pub(super) fn samples(&self, n: usize) -> (Vec<DVec3>, f64) {
        let turn = |r: f64, z: f64, angle: f64| DVec3::new(r * angle.cos(), r * angle.sin(), z);
        let step = std::f64::consts::TAU / n as f64;
        let part = |i: usize| i as f64 / (n - 1) as f64;
        let mut points = Vec::new();
        let mut spacing: f64 = 0.0;
        let lines = match self {
            Self::Plane => {
                for i in 0..n * n {
                    let (x, y) = (part(i / n), part(i % n));
                    points.push(DVec3::new(6.0 * x - 3.0, 6.0 * y - 3.0, 0.0));
                }
                return (points, 0.5 * 2.0_f64.sqrt() * 6.0 / (n - 1) as f64);
            }
            Self::Sphere(radius) => {
                for i in 0..n * n {
                    let polar = part(i / n) * std::f64::consts::PI;
                    let (r, z) = (radius * polar.sin(), radius * polar.cos());
                    points.push(turn(r, z, (i % n) as f64 * step));
                }
                return (points, radius * step);
            }
            Self::Cylinder(r, None) => vec![[*r, -3.0], [*r, 3.0]],
            _ => self.profile().expect("only the shapes above have none"),
        };
        for pair in lines.windows(2) {
            let ([r0, z0], [r1, z1]) = (pair[0], pair[1]);
            let length = (r1 - r0).hypot(z1 - z0);
            let diagonal = (length / (n - 1) as f64).hypot(r0.max(r1) * step);
            spacing = spacing.max(0.5 * diagonal);
            for i in 0..n {
                let (r, z) = (r0 + part(i) * (r1 - r0), z0 + part(i) * (z1 - z0));
                points.extend((0..n).map(|j| turn(r, z, j as f64 * step)));
            }
        }
        (points, spacing)
    }
}

pub(super) fn kind() -> impl Strategy<Value = Kind> {
    let length = 0.05..1.0_f64;
    // Heights that increase: such a profile never crosses itself.
    let profile = prop::collection::vec((0.0..1.0_f64, 0.05..0.5_f64), 2..6).prop_map(|steps| {
        let mut z = -0.5;
        let mut points = Vec::new();
        for (r, rise) in steps {
            points.push([r, z]);
            z += rise;
        }
        points
    });
    prop_oneof![
        Just(Kind::Plane),
        length.clone().prop_map(Kind::Disc),
        length.clone().prop_map(|r| Kind::Cylinder(r, None)),
        (length.clone(), length.clone()).prop_map(|(r, l)| Kind::Cylinder(r, Some([-0.3, l]))),
        (length.clone(), 0.0..1.0_f64, length.clone())
            .prop_map(|(r, s, l)| Kind::Cone([-0.3, l], [r, s])),
        length.prop_map(Kind::Sphere),
        profile.prop_map(Kind::Revolution),
    ]
}

pub(super) fn vector(size: f64) -> impl Strategy<Value = DVec3> {
    (-size..size, -size..size, -size..size).prop_map(DVec3::from)
}

/// A pose that turns by at most `angle` about each axis and shifts by at most `shift`.
pub(super) fn pose(angle: f64, shift: f64) -> impl Strategy<Value = Pose> {
    (vector(angle), vector(shift)).prop_map(|(rotation, translation)| Pose {
        rotation: DQuat::from_scaled_axis(rotation),
        translation,
    })
}

pub(super) fn side() -> impl Strategy<Value = Side> {
    prop_oneof![Just(Side::Inside), Just(Side::Outside), Just(Side::Both)]
}

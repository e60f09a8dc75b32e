//! The sheet's side of a contact: a wall whose surface moves as its vertices do.

use glam::DVec3;

use super::walls::WallSide;
use crate::surface::{Place, Surface, SurfaceLoad};
use crate::walls::{Feature, Shape, Touch};

/// A point of a sheet that is touched.
pub(super) struct AtSheet<'a> {
    surface: &'a Surface,
    number: u16,
    feature: Feature,
    place: Place,
    /// Velocity of the point, m/s.
    pub(super) velocity: DVec3,
    /// Over the mass with which it answers a force, 1/kg.
    pub(super) inverse_mass: f64,
}

impl<'a> AtSheet<'a> {
    /// Where `touch` is, if the wall is the shape of a sheet.
    #[inline]
    pub(super) fn of(side: &WallSide<'a>, surfaces: &'a [Surface], touch: &Touch) -> Option<Self> {
        let number = side.wall.surface()?;
        let Shape::Mesh(mesh) = side.wall.shape() else {
            return None;
        };
        let surface = &surfaces[usize::from(number)];
        let foot = side.centre - touch.normal * touch.distance;
        let place = surface.place(mesh, touch.feature, foot);
        Some(Self {
            surface,
            number,
            feature: mesh.feature_of(touch.feature),
            place,
            velocity: surface.velocity_at(&place),
            inverse_mass: surface.inverse_mass_at(&place),
        })
    }

    /// Angular velocity of the triangle there, rad/s.
    pub(super) fn spin(&self) -> DVec3 {
        self.surface.spin(self.place.triangle)
    }

    /// By how much a normal of it turns as the sheet moves, 1/s, apart from what the way of the particle against the point does; `spin`:
    /// [`AtSheet::spin`].
    pub(super) fn turn(&self, normal: DVec3, spin: DVec3) -> DVec3 {
        match self.feature {
            // The rotation that fits velocities best turns the plane of a triangle as they do.
            Feature::Face(_) => spin.cross(normal),
            // The normal stays at a right angle to the edge.
            Feature::Edge(ends) => {
                let [start, end] = ends.map(|corner| self.surface.vertex_at(corner));
                let [from, to] = [start, end].map(|k| self.surface.positions[k]);
                let [first, last] = [start, end].map(|k| self.surface.velocities[k]);
                let along = to - from;
                along * (-(last - first).dot(normal) / along.length_squared())
            }
            Feature::Corner(_) => DVec3::ZERO,
        }
    }

    /// What it gets where the particle gets this force (N) and this couple (N m).
    pub(super) fn load(&self, force: DVec3, couple: DVec3) -> SurfaceLoad {
        SurfaceLoad {
            surface: self.number,
            triangle: self.place.triangle,
            shares: self.surface.shares(&self.place, -force, -couple),
        }
    }

    /// The number of the sheet, and the point.
    pub(super) fn place(&self) -> (u16, Place) {
        (self.number, self.place)
    }
}

//! The one query behind which all wall shapes stand.

mod cone;
mod cylinder;
mod disc;
mod plane;
mod revolution;
mod sphere;

pub use cone::Cone;
pub use cylinder::Cylinder;
pub use disc::Disc;
pub use plane::Plane;
pub use revolution::Revolution;
pub use sphere::SphereShell;

use super::error::WallError;
use super::mesh::{Mesh, Scratch};
use super::pose::Pose;
use super::side::Side;
use super::touch::Touches;
use glam::DVec3;
use mercury_common::surfaces::Surface;
use std::sync::Arc;

/// The shape of a wall, in the frame in which the scene describes it.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// A half-space.
    Plane(Plane),
    /// A thin round plate.
    Disc(Disc),
    /// A cylindrical shell.
    Cylinder(Cylinder),
    /// A conical shell.
    Cone(Cone),
    /// A spherical shell.
    Sphere(SphereShell),
    /// A polygon turned about an axis.
    Revolution(Revolution),
    /// Triangles.
    Mesh(Arc<Mesh>),
}

impl Shape {
    /// The mesh, if it is one.
    #[must_use]
    pub fn mesh(&self) -> Option<&Mesh> {
        match self {
            Self::Mesh(mesh) => Some(mesh),
            _ => None,
        }
    }

    /// Side on which particles are, of shapes with an inside: neither planes, discs nor meshes.
    pub(super) fn side(&self) -> Option<Side> {
        match self {
            Self::Plane(_) | Self::Disc(_) | Self::Mesh(_) => None,
            Self::Cylinder(cylinder) => Some(cylinder.side()),
            Self::Cone(cone) => Some(cone.0.side()),
            Self::Sphere(sphere) => Some(sphere.side()),
            Self::Revolution(revolution) => Some(revolution.0.side()),
        }
    }

    /// Shapes with the same answer number their features alike.
    #[must_use]
    pub fn feature_numbering(&self) -> String {
        match self {
            Self::Plane(_) => "plane".to_owned(),
            Self::Disc(_) => "disc".to_owned(),
            Self::Cylinder(_) => "cylinder".to_owned(),
            Self::Cone(_) => "cone".to_owned(),
            Self::Sphere(_) => "sphere".to_owned(),
            // By the points of the profile.
            Self::Revolution(revolution) => format!("{revolution:?}"),
            Self::Mesh(mesh) => mesh.feature_numbering(),
        }
    }

    /// Replaces the content of `out` by all places of the wall within `reach` (m, exclusive) of
    /// `centre` (in the wall's own frame): each face onto which the centre projects, and each edge
    /// that is nearer than the faces it ends.
    ///
    /// A centre beyond a one-sided surface gets a negative distance. A plane pushes it back from any
    /// depth; the other shapes only while it is less deep than `reach`, for deeper it is on the other
    /// side. So a caller whose `reach` is larger than the particle's radius (to fill a neighbour list,
    /// or for forces at a distance) leaves out what is deeper than the radius.
    #[inline]
    pub fn touches(&self, centre: DVec3, reach: f64, out: &mut Touches) {
        out.clear();
        match self {
            Self::Plane(plane) => plane.touches(centre, reach, out),
            Self::Disc(disc) => disc.0.touches(centre, reach, out),
            Self::Cylinder(cylinder) => cylinder.touches(centre, reach, out),
            Self::Cone(cone) => cone.0.touches(centre, reach, out),
            Self::Sphere(sphere) => sphere.touches(centre, reach, out),
            Self::Revolution(revolution) => revolution.0.touches(centre, reach, out),
            Self::Mesh(mesh) => mesh.touches(centre, reach, out),
        }
    }

    /// Whether a sphere of radius `reach` (m) whose centre is within `within` (m) of `centre` may touch the surface, or may be
    /// thought near it by [`Mesh::may_be_near`]; false only where none does. `reach` includes round-off.
    pub(super) fn may_be_near(
        &self,
        centre: DVec3,
        within: f64,
        reach: f64,
        scratch: &mut Scratch,
    ) -> bool {
        let reach_of_all = reach + within;
        match self {
            Self::Plane(plane) => plane.touch(centre, reach_of_all).is_some(),
            Self::Disc(disc) => disc.0.is_near(centre, reach_of_all),
            Self::Cylinder(cylinder) => cylinder.is_near(centre, reach_of_all),
            Self::Cone(cone) => cone.0.is_near(centre, reach_of_all),
            Self::Sphere(sphere) => sphere.is_near(centre, reach_of_all),
            Self::Revolution(revolution) => revolution.0.is_near(centre, reach_of_all),
            Self::Mesh(mesh) => mesh.may_be_near_some(centre, within, reach, scratch),
        }
    }

    /// About the largest coordinate in the description of the surface, m: sets the round-off of distances from it.
    pub(super) fn scale(&self) -> f64 {
        match self {
            Self::Plane(plane) => plane.scale(),
            Self::Disc(disc) => disc.0.scale(),
            Self::Cylinder(cylinder) => cylinder.scale(),
            Self::Cone(cone) => cone.0.scale(),
            Self::Sphere(sphere) => sphere.scale(),
            Self::Revolution(revolution) => revolution.0.scale(),
            Self::Mesh(mesh) => {
                let (low, high) = mesh.bounds();
                low.abs().max(high.abs()).max_element()
            }
        }
    }

    /// How far any point of the surface is at most from the surface when it becomes `other` in the same frame, m; infinite where that
    /// is not known. Not for meshes, whose corners move ([`Mesh::reshape`]).
    ///
    /// # Errors
    /// If `other` has not the same faces and edges, which contacts remember.
    pub fn way_to(&self, other: &Self) -> Result<f64, WallError> {
        let way = match (self, other) {
            (Self::Plane(one), Self::Plane(other)) => Some(one.way_to(other)),
            (Self::Disc(one), Self::Disc(other)) => one.0.way_to(&other.0),
            (Self::Cylinder(one), Self::Cylinder(other)) => one.way_to(other),
            (Self::Cone(one), Self::Cone(other)) => one.0.way_to(&other.0),
            (Self::Sphere(one), Self::Sphere(other)) => one.way_to(other),
            (Self::Revolution(one), Self::Revolution(other)) => one.0.way_to(&other.0),
            _ => None,
        };
        way.ok_or(WallError::OtherShape)
    }

    /// The surface in plain numbers, of a mesh the places of its corners (m): with them [`Shape::with_numbers`] makes it again.
    #[must_use]
    pub fn numbers(&self) -> Vec<f64> {
        match self {
            Self::Plane(plane) => plane.numbers(),
            Self::Disc(disc) => disc.0.numbers(),
            Self::Cylinder(cylinder) => cylinder.numbers(),
            Self::Cone(cone) => cone.0.numbers(),
            Self::Sphere(sphere) => sphere.numbers(),
            Self::Revolution(revolution) => revolution.0.numbers(),
            Self::Mesh(mesh) => mesh.corners().iter().flat_map(|x| x.to_array()).collect(),
        }
    }

    /// The surface that has these [`Shape::numbers`], to the bit, of one that it became from.
    ///
    /// # Errors
    /// If the numbers are those of another surface, or of a mesh that cannot have come from this one ([`Mesh::reshape`]).
    pub fn with_numbers(&self, numbers: &[f64]) -> Result<Self, WallError> {
        if let Some(index) = numbers.iter().position(|x| !x.is_finite()) {
            return Err(WallError::NotFinite {
                key: "shape",
                value: numbers[index].to_string(),
            });
        }
        let new = match self {
            Self::Plane(_) => Plane::from_numbers(numbers).map(Self::Plane),
            Self::Disc(disc) => (disc.0.with_numbers(numbers)).map(|new| Self::Disc(Disc(new))),
            Self::Cylinder(cylinder) => cylinder.with_numbers(numbers).map(Self::Cylinder),
            Self::Cone(cone) => (cone.0.with_numbers(numbers)).map(|new| Self::Cone(Cone(new))),
            Self::Sphere(sphere) => sphere.with_numbers(numbers).map(Self::Sphere),
            Self::Revolution(old) => old
                .0
                .with_numbers(numbers)
                .map(|new| Self::Revolution(Revolution(new))),
            Self::Mesh(mesh) => {
                let (corners, rest) = numbers.as_chunks::<3>();
                if !rest.is_empty() {
                    return Err(WallError::OtherShape);
                }
                let corners: Vec<DVec3> = corners.iter().map(|&x| x.into()).collect();
                let mut new = Mesh::clone(mesh);
                new.place(&corners)?;
                Some(Self::Mesh(Arc::new(new)))
            }
        };
        new.ok_or(WallError::OtherShape)
    }

    /// Whether a rolling contact may carry its history from feature `a` to feature `b`: from a face to
    /// an edge of it and back, and from a face to the next one, as a step can be longer than the way
    /// round the edge. No feature is adjacent to itself. Meshes answer by [`Mesh::continues`] instead, which sees places.
    #[must_use]
    pub fn adjacent(&self, a: u32, b: u32) -> bool {
        match self {
            Self::Plane(_) | Self::Sphere(_) | Self::Mesh(_) => false,
            Self::Disc(disc) => disc.0.adjacent(a, b),
            Self::Cylinder(cylinder) => cylinder.adjacent(a, b),
            Self::Cone(cone) => cone.0.adjacent(a, b),
            Self::Revolution(revolution) => revolution.0.adjacent(a, b),
        }
    }

    /// The pose that puts the surface in the same places, of a mesh that goes on for ever along periodic axes: by less than a period.
    #[must_use]
    pub fn reduced(&self, mut pose: Pose) -> Pose {
        if let Self::Mesh(mesh) = self {
            for period in mesh.periods() {
                let along = &mut pose.translation[period.axis];
                *along = period.reduced(*along);
            }
        }
        pose
    }

    /// Surface for a picture, in its own frame.
    #[must_use]
    pub fn outline(&self) -> Surface {
        match self {
            Self::Plane(plane) => plane.outline(),
            Self::Disc(disc) => disc.0.outline(),
            Self::Cylinder(cylinder) => cylinder.outline(),
            Self::Cone(cone) => cone.0.outline(),
            Self::Sphere(sphere) => sphere.outline(),
            Self::Revolution(revolution) => revolution.0.outline(),
            Self::Mesh(mesh) => mesh.outline(),
        }
    }

    /// Smallest and largest coordinate of the surface along each axis in m; infinite where the surface
    /// is unbounded.
    #[must_use]
    pub fn bounds(&self) -> (DVec3, DVec3) {
        match self {
            Self::Plane(plane) => plane.bounds(),
            Self::Disc(disc) => disc.0.bounds(),
            Self::Cylinder(cylinder) => cylinder.bounds(),
            Self::Cone(cone) => cone.0.bounds(),
            Self::Sphere(sphere) => sphere.bounds(),
            Self::Revolution(revolution) => revolution.0.bounds(),
            Self::Mesh(mesh) => mesh.bounds(),
        }
    }

    /// Upper bound in m of how far any point of the surface within `reach` of `about` (a point of the
    /// initial frame) gets from the old surface to the new one between two poses.
    ///
    /// Motions of the shape in itself don't count: zero for a body of revolution that turns about its
    /// own axis, a sphere that turns about its centre, a plane or an endless cylinder that slides in
    /// itself.
    #[must_use]
    pub fn displacement(&self, from: &Pose, to: &Pose, about: DVec3, reach: f64) -> f64 {
        match self {
            Self::Plane(plane) => plane.displacement(from, to, about, reach),
            Self::Disc(disc) => disc.0.displacement(from, to, about, reach),
            Self::Cylinder(cylinder) => cylinder.displacement(from, to, about, reach),
            Self::Cone(cone) => cone.0.displacement(from, to, about, reach),
            Self::Sphere(sphere) => sphere.displacement(from, to, about, reach),
            Self::Revolution(revolution) => revolution.0.displacement(from, to, about, reach),
            Self::Mesh(mesh) => mesh.displacement(from, to, about, reach),
        }
    }
}

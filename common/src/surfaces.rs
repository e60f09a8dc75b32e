//! Surfaces of walls as they are seen: what a run stores of its walls, and as triangles at any time.
//!
//! The solver computes how a wall touches; this module only describes where it is. A [`Surface`] lies in the frame in which the
//! scene describes it, a [`Placement`] gives the place of that frame, [`Surface::triangles`] gives both together for ParaView and
//! pictures. The text form of a surface is in `<prefix>.walls.arrow` (`docs/formats/walls.md`).

mod clip;
#[cfg(test)]
mod tests;
mod text;
mod turned;

use std::collections::HashMap;

use glam::{DQuat, DVec2, DVec3};

pub use clip::HalfSpace;

use crate::formats::mesh::TriangleMesh;

/// The surface of a wall in the frame in which the scene describes it.
#[derive(Debug, Clone, PartialEq)]
pub enum Surface {
    /// An endless plane.
    Plane {
        /// A point of it, m.
        point: DVec3,
        /// Unit normal towards the particles.
        normal: DVec3,
    },
    /// A spherical shell.
    Sphere {
        /// Its centre, m.
        centre: DVec3,
        /// Its radius, m.
        radius: f64,
    },
    /// A profile turned about an axis: discs, cylinders, cones, polygons of revolution.
    Turned {
        /// A point of the axis, m.
        origin: DVec3,
        /// Unit vector along the axis.
        direction: DVec3,
        /// Two unit vectors normal to the axis and to each other.
        across: [DVec3; 2],
        /// Corners: distance from the axis and place along it, m; a closed profile ends where it began.
        profile: Vec<DVec2>,
        /// The profile is one corner that goes on for ever along the axis.
        endless: bool,
    },
    /// Triangles.
    Mesh(TriangleMesh),
}

/// Where a rigid thing is: `x_global = rotation * x + translation`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Unit quaternion.
    pub rotation: DQuat,
    /// In m.
    pub translation: DVec3,
}

impl Default for Placement {
    fn default() -> Self {
        Self {
            rotation: DQuat::IDENTITY,
            translation: DVec3::ZERO,
        }
    }
}

impl Placement {
    /// Global position of a point of the thing, m.
    #[must_use]
    pub fn to_global(&self, own: DVec3) -> DVec3 {
        self.rotation * own + self.translation
    }

    /// A global position in the frame of the thing, m.
    #[must_use]
    pub fn to_own(&self, global: DVec3) -> DVec3 {
        self.rotation.conjugate() * (global - self.translation)
    }
}

impl Surface {
    /// The surface as triangles in the global frame.
    ///
    /// Planes are cut at the domain (lower and upper corner, m) and by `cuts`, given in the global frame too; endless
    /// cylinders end with the domain along their axis. Corners of triangles lie on the surface, curved ones are approximated
    /// by 72 chords around. A surface outside the domain gives no triangles where it is a plane.
    #[must_use]
    pub fn triangles(
        &self,
        placement: &Placement,
        domain: (DVec3, DVec3),
        cuts: &[HalfSpace],
    ) -> TriangleMesh {
        match self {
            Self::Plane { point, normal } => {
                let plane = HalfSpace {
                    point: placement.to_global(*point),
                    normal: placement.rotation * *normal,
                };
                clip::plane_in_box(&plane, clip::with_thickness(domain), cuts)
            }
            Self::Sphere { centre, radius } => {
                let own = turned::sphere(*centre, *radius);
                moved(own, placement)
            }
            Self::Turned {
                origin,
                direction,
                across,
                profile,
                endless,
            } => {
                let ends;
                let profile = if *endless {
                    let corners = clip::corners(clip::with_thickness(domain));
                    let along = corners.map(|x| (placement.to_own(x) - *origin).dot(*direction));
                    let low = along.iter().copied().fold(f64::INFINITY, f64::min);
                    let high = along.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                    let radius = profile.first().map_or(0.0, |corner| corner.x);
                    ends = [DVec2::new(radius, low), DVec2::new(radius, high)];
                    &ends
                } else {
                    profile.as_slice()
                };
                moved(
                    turned::turned(*origin, *direction, *across, profile),
                    placement,
                )
            }
            Self::Mesh(mesh) => moved(mesh.clone(), placement),
        }
    }

    /// The half-space in front of a plane, in the global frame; nothing for other surfaces.
    #[must_use]
    pub fn half_space(&self, placement: &Placement) -> Option<HalfSpace> {
        match self {
            Self::Plane { point, normal } => Some(HalfSpace {
                point: placement.to_global(*point),
                normal: placement.rotation * *normal,
            }),
            _ => None,
        }
    }
}

/// The endings of the names of a box's faces.
/// The faces of a box, as the format names them.
pub const FACES: [&str; 6] = ["-x", "+x", "-y", "+y", "-z", "+z"];

/// For each wall the walls that end it: the other faces of its box, which are named `box.-x`, `box.+x`, ... Of several walls of one name
/// the first is the face.
#[must_use]
pub fn faces_of_one_box(names: &[String]) -> Vec<Vec<usize>> {
    let face = |name: &str| -> Option<(String, usize)> {
        let (stem, ending) = name.rsplit_once('.')?;
        let face = FACES.iter().position(|face| *face == ending)?;
        Some((stem.to_owned(), face))
    };
    let faces: Vec<Option<(String, usize)>> = names.iter().map(|name| face(name)).collect();
    let mut boxes: HashMap<&str, [Option<usize>; 6]> = HashMap::new();
    for (wall, face) in faces.iter().enumerate() {
        if let Some((stem, face)) = face {
            boxes.entry(stem).or_default()[*face].get_or_insert(wall);
        }
    }
    let others = |wall: usize| {
        let known = faces[wall]
            .as_ref()
            .and_then(|(stem, _)| boxes.get(stem.as_str()));
        let all = known.into_iter().flatten().flatten().copied();
        let mut others: Vec<usize> = all.filter(|&other| other != wall).collect();
        others.sort_unstable();
        others
    };
    (0..names.len()).map(others).collect()
}

fn moved(mut mesh: TriangleMesh, placement: &Placement) -> TriangleMesh {
    for vertex in &mut mesh.vertices {
        *vertex = placement.to_global(*vertex);
    }
    mesh
}

//! What a picture of a wall needs to know of its shape.

use glam::{DVec2, DVec3};
use mercury_common::formats::mesh::TriangleMesh;

/// The surface of a wall in plain numbers, in the frame in which the scene describes it.
#[derive(Debug, Clone, PartialEq)]
pub enum Outline {
    /// An endless plane.
    Plane {
        /// A point of it, m.
        point: DVec3,
        /// Unit normal.
        normal: DVec3,
    },
    /// A spherical shell.
    Sphere {
        /// Its centre, m.
        centre: DVec3,
        /// Its radius, m.
        radius: f64,
    },
    /// A profile turned about an axis.
    Turned {
        /// A point of the axis, m.
        origin: DVec3,
        /// Unit vector along the axis.
        direction: DVec3,
        /// Two unit vectors normal to the axis and to each other.
        across: [DVec3; 2],
        /// Corners: distance from the axis and place along it, m.
        profile: Vec<DVec2>,
        /// The profile is one corner that goes on for ever along the axis.
        endless: bool,
    },
    /// Triangles.
    Mesh {
        /// Rims and edges that bend: straight lines between two points each, m.
        edges: Vec<[DVec3; 2]>,
        /// Those that act, in the order of the file, m.
        triangles: TriangleMesh,
    },
}

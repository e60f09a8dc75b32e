//! Walls: where a sphere is near one, and how walls move.
//!
//! [`Shape::touches`] is the one query: given a sphere's centre in the wall's own frame it lists the faces and edges within
//! reach. The frame moves with the wall: [`Motion`] gives its [`Pose`] and its [`RigidVelocity`] at any time, in closed form but
//! for a [`Servo`], whose state the engine keeps. This module does not depend on particles, contact laws or neighbour lists.
//!
//! ```
//! use glam::DVec3;
//! use mercury_engine::walls::{Component, Cylinder, Motion, Shape, Side, Touches};
//!
//! // A drum of radius 0.4 m that turns about its axis, with a sphere of radius 0.01 m at its bottom.
//! let (axis, origin) = (DVec3::Y, DVec3::new(0.5, 0.0, 0.5));
//! let drum = Shape::Cylinder(Cylinder::new(axis, origin, 0.4, None, Side::Inside)?);
//! let motion = Motion::new(vec![Component::Rotation {
//!     axis,
//!     origin,
//!     angular_velocity: 2.0,
//!     from: 0.0,
//!     until: f64::INFINITY,
//! }])?;
//!
//! let (pose, velocity) = (motion.pose(0.3), motion.velocity(0.3));
//! let centre = DVec3::new(0.5, 0.2, 0.109);
//! let mut touches = Touches::new();
//! drum.touches(pose.to_initial(centre), 0.01, &mut touches);
//! let touch = touches.as_slice()[0];
//! let normal = pose.rotation * touch.normal;
//! assert!((touch.distance - 0.009).abs() < 1e-15);
//! assert!((normal - DVec3::Z).length() < 1e-14);
//! // The wall passes below at 0.4 m * 2 rad/s.
//! let speed = velocity.at(centre - normal * touch.distance).length();
//! assert!((speed - 0.8).abs() < 1e-14);
//! # Ok::<(), mercury_engine::walls::WallError>(())
//! ```

mod axis;
mod behind;
mod drive;
mod error;
mod films;
mod images;
mod joined;
mod mesh;
mod motion;
mod motion_table;
mod near_box;
mod now;
mod part;
mod pose;
mod profile;
mod revolved;
mod section;
mod servo;
mod shape;
mod side;
mod symmetry;
mod target;
#[cfg(test)]
mod tests;
mod touch;
mod wall;

pub use drive::Drive;
pub use error::WallError;
pub use films::{WallFilmPlan, WallFilms, WallPlace, film_at};
pub use mesh::{
    Base, Facing, Feature, LeftOut, Mesh, NearMeshes, Period, Precision, SMOOTH_ANGLE, Saddle,
    Scratch, TurnedPair,
};
pub use motion::{Component, Motion};
pub use motion_table::MotionTable;
pub use now::{SavedWall, WallNow};
pub(crate) use part::LoadSeries;
pub use pose::{Pose, RigidVelocity};
pub use section::{SectionBox, area, has_area, plane_section};
pub use servo::{Followed, Servo, ServoState, WallStiffness};
pub use shape::*;
pub use side::Side;
pub use target::{Area, Target};
pub use touch::{Touch, Touches, Turning};
pub use wall::{Wall, WallState};

//! Closed-form physics that simulations are compared with: binary collisions, spheres on planes, dry cohesion, beams,
//! and the parameters that belong to a given collision.
//!
//! Pure functions of numbers in SI units; outside the stated domain they return NaN.

mod beam;
mod bouncing;
mod collisions;
mod jkr;
mod parameters;
mod sphere_on_plane;

pub use beam::*;
pub use bouncing::*;
pub use collisions::*;
pub use jkr::*;
pub use parameters::*;
pub use sphere_on_plane::*;

//! Rigid bodies of several pebbles.
//!
//! Definition: a clump is one rigid body; its pebbles are spheres at fixed places of the body's principal frame. Contacts are
//! found and evaluated between pebbles, which are rows of [`Particles`](crate::state::Particles) like any sphere, with one over
//! the *body's* mass as their inverse mass. The equation of motion is solved for the body alone, once per step:
//!
//! ```text
//! gather      force and torque of the body from the loads on its pebbles
//! advance     kicks, drift, free rotation of the body
//! place       positions and velocities of the pebbles from those of the body
//! ```
//!
//! Their columns are [`Bodies`](crate::state::Bodies). Why columns of their own? A scene without clumps has none of them ([`Particles::bodies`](crate::state::Particles) is
//! `None`), and its passes over particles have no code of bodies.
//!
//! A body takes as many ids as it has pebbles. The first is the id of the body and of its first pebble.

mod clump;
mod motion;
mod new_body;
mod periodic;
mod rotation;
#[cfg(test)]
mod tests;

pub use clump::{Clump, ClumpError};
pub use motion::BodyStep;
pub(crate) use motion::constrained_spin;
pub use new_body::NewBody;
pub use rotation::{angular_velocity, free_rotation};

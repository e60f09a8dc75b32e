//! Everything that changes in a run, and nothing else: particles in one compact record each for the force loop, the rest in
//! columns, bodies.
//!
//! Rows are kept sorted in space (`neighbours`), so a row index is valid only until the next sort; what
//! users see and what files hold is the `id`, which never changes.

mod bodies;
mod codec;
mod columns;
mod index;
mod new_particle;
mod particles;
mod record;
mod sections;
mod unpaired;

pub use crate::plain;
pub use bodies::{Bodies, Body, BodyPebble, PrescribedBody};
pub use codec::{DecodeError, Decoder, Encoder, Piece, Pieces, Plain, VERSION, announced, whole};
pub use columns::{Column, Columns, StartValues};
pub use index::{BodyIndex, Id, MaterialIndex, PebbleIndex, Row, WallIndex};
pub use new_particle::{Material, NewParticle, PrescribedMotion};
pub use particles::{Particles, Prescribed};
pub use rayon::ThreadPool;
pub use record::{FIXED, Load, PEBBLE, PRESCRIBED, Particle, inverse_inertia_factor, volume};
pub use sections::Sections;
pub use unpaired::Unpaired;

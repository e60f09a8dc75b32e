//! The exact capillary force of a liquid bridge between two spheres, or a sphere and a plane, without gravity.
//!
//! [`Branch`] solves the Young-Laplace equation for one bridge, from the touch to the end of its stable branch. [`Table`] holds such
//! solutions for one contact angle, made before a run. [`Bound`] is what it gives for one bridge of a known volume: a few numbers,
//! from which force and energy follow over the gap, cheaply and in lanes. Background, sources and measured errors:
//! `docs/theory/liquid-young-laplace.md`.
//!
//! Lengths are in R_D = 2 R*, R* = R_1 R_2/(R_1 + R_2) (a plane: R_D = 2 R), volumes in R_D^3, forces in gamma R_D and energies in
//! gamma R_D^2, with the surface tension gamma.

mod axis;
mod bound;
mod dual;
mod exact;
mod meridian;
mod node;
mod table;

pub use bound::{Bound, NUMBERS};
pub use exact::{Branch, Failure};
pub use meridian::Bridge;
pub use table::{Binding, Errors, MEASURED_TO, Table, TableError};

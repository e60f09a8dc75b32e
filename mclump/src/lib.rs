//! From a surface and pebbles to a rigid clump that a solver can trust.
//!
//! The way of a body: a surface is read and looked at ([`surface`]), pebbles are read or [generated](generate), mass, centre and inertia
//! are found by every route that applies ([`inertia`]), the principal axes make the frame ([`alignment`]), and the
//! whole becomes a clump file ([`clump`]) and pictures of it ([`output`]).
//!
//! ```
//! use glam::DVec3;
//! use mclump::clump::{Input, Options, build};
//! use mercury_common::formats::clump::Pebble;
//!
//! let pebbles = [-1.0, 0.0, 1.0].map(|x| Pebble { position: DVec3::new(4.0, x, 0.0), radius: 0.5 });
//! let input = Input { name: "rod".into(), surface: None, pebbles: pebbles.to_vec() };
//! let built = build(&input, &Options { density: 2.0, ..Options::default() })?;
//! let clump = &built.file;
//! // The long axis comes first.
//! assert!(clump.pebbles[0].position.abs_diff_eq(DVec3::new(-1.0, 0.0, 0.0), 1e-15));
//! assert!((clump.mass - 2.0 * std::f64::consts::PI / 2.0).abs() < 1e-14);
//! assert_eq!(clump.centre_of_mass, DVec3::new(4.0, 0.0, 0.0));
//! # Ok::<(), mclump::clump::BuildError>(())
//! ```

pub mod alignment;
pub mod clump;
pub mod descriptors;
pub mod fidelity;
pub mod generate;
pub mod inertia;
pub mod output;
pub mod sizes;
pub mod surface;
pub mod table;

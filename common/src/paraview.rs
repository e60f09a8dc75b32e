//! Frames as grids that ParaView shows, and series of them.
//!
//! Every column of a frame becomes an array, also those that this version does not use: three columns that end in x, y, z
//! become a vector, four in w, x, y, z a quaternion. [`particles`] adds what glyphs need, [`contacts`] joins centres by lines, [`bonds`] likewise,
//! [`walls`] and [`clumps`] put surfaces where they stand; [`membranes`] shows elastic sheets; a further kind (bridges, droplets) is a further function that
//! returns a [`VtuGrid`](crate::formats::vtu::VtuGrid), and a further [`Series`].

mod clumps;
mod columns;
mod grids;
mod script;
mod series;
#[cfg(test)]
mod tests;

pub use clumps::clumps;
pub use columns::{Group, clump_column, clump_spec, groups, vectors};
pub use grids::{WallScene, bonds, contacts, membranes, particles, walls};
pub use script::{ScriptParts, script};
pub use series::Series;

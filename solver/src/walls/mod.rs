//! walls.

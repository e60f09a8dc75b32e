//! Liquid of a scene: bridges against the grains that they join, and films of walls.

pub(super) mod bridges;
mod wall_films;

pub(super) use wall_films::wall_films;

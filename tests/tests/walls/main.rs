//! Walls: shapes, meshes, motion, servos, loads, wear.

mod periodic_meshes;
mod servos;
mod travelling_walls;
mod triangle_loads;
mod turning_walls;
mod wear;
mod wide_walls;

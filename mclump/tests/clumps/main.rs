//! `mclump`: surfaces, pebbles and their mass properties.

mod alignment;
mod cli;
#[path = "../common/mod.rs"]
mod common;
mod pebble_routes;
mod surface_moments;
mod surfaces;

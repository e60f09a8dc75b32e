//! Whole runs and the files that they write.

#[path = "../common/mod.rs"]
mod common;

mod bonds;
mod fields;
mod guard;
mod liquid;
mod membranes;
mod particle_tables;
mod passages;
mod rest;
mod tables;
mod tracks;
mod triaxial;

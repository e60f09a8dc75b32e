//! The engine as a whole: conservation, convergence, determinism, rotation, published cases.

mod clump_scale;
mod conservation;
mod convergence;
mod crates;
mod determinism;
mod leaving;
mod observed;
mod part_outside;
mod rotation;
mod state_bytes;

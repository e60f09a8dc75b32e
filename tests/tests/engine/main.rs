//! The engine as a whole: conservation, convergence, determinism, rotation, sleeping, published cases.

mod clump_scale;
mod conservation;
mod convergence;
mod crates;
mod determinism;
mod leaving;
mod rotation;
mod sleeping;
mod sleeping_clumps;
mod state_bytes;

//! The engine of a discrete particle simulation: contact laws, neighbour lists, walls and the time step.
//!
//! The table of modules is in `ARCHITECTURE.md`; each may use those below it.
//! An [`Engine`](step::Engine) starts from a [`Setup`](physics::Setup) and makes steps; it has nothing to do with scenes, plans
//! and files.

#![warn(clippy::disallowed_methods)]
#![cfg_attr(test, allow(clippy::disallowed_methods))]

pub mod audit;
pub mod bodies;
pub mod bonds;
pub mod boundaries;
pub mod cell;
pub mod contact;
pub mod forces;
pub mod guard;
pub mod lanes;
pub mod liquid;
pub mod membrane;
pub mod memory;
pub mod neighbours;
mod parallel;
pub mod physics;
pub mod ranks;
pub mod spray;
pub mod state;
pub mod step;
pub mod sums;
pub mod surface;
pub mod task;
pub mod tracks;
pub mod walls;
pub mod wear;

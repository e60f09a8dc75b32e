//! Discrete particle simulation: contact laws, neighbour lists, walls and the time step.
//!
//! The rooms, each of which may use those below it: [`run`], [`results`], [`output`], [`step`], [`plan`], [`boundaries`],
//! [`bodies`], [`spray`], [`liquid`], [`forces`], [`surface`], [`walls`], [`neighbours`], [`contact`], [`lanes`], [`state`], [`stage`]. Beside them [`study`]: many runs of one scene; [`starters`]: scenes to start from.

#![warn(clippy::disallowed_methods)]
#![cfg_attr(test, allow(clippy::disallowed_methods))]

pub mod bodies;
pub mod boundaries;
pub mod contact;
pub mod forces;
pub mod lanes;
pub mod liquid;
pub mod membrane;
mod memory;
pub mod neighbours;
pub mod output;
pub mod plan;
pub mod results;
pub mod run;
pub mod spray;
pub mod stage;
pub mod starters;
pub mod state;
pub mod step;
pub mod study;
pub mod surface;
pub mod walls;
pub mod wear;

//! What the solver wrote, turned into what people look at.
//!
//! A [`Source`] is a run folder, a file of frames or a `.data` file; it gives [`Snapshot`]s one at a time, with all columns
//! it has. A [`Selection`] says which of them and which rows. Each way out is a room: [`vtu`] for ParaView, [`xballs`],
//! [`tables`] (CSV, Parquet), [`particle_csv`] for scenes, [`lammps`] for LAMMPS and LIGGGHTS,
//! [`pictures`] for people. The rooms share one habit: whole files or
//! none, and nothing is replaced unless asked for ([`output::Output`]).

#![allow(
    clippy::result_large_err,
    reason = "an error ends the export, so its size does not matter"
)]

mod beside;
mod bodies;
mod error;
pub mod lammps;
pub mod output;
pub mod parquet;
pub mod particle_csv;
pub mod pictures;
mod pipeline;
mod selection;
mod source;
pub mod tables;
pub mod vtu;
pub mod xballs;

pub use bodies::ClumpsAs;
pub use error::ExportError;
pub use pipeline::{Told, for_each_snapshot};
pub use selection::{FrameChoice, Region, Selection};
pub use source::{Snapshot, Source};

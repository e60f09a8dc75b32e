//! Conversion of the solver's output into pictures, films and files of other programs.
//!
//! A [`Source`] is a run folder, a file of frames or a `.data` file; it gives [`Snapshot`]s one at a time, with all columns it
//! has. A [`Selection`] chooses frames and rows. The [driver](export) hands them to a [`Sink`], one for each kind of
//! output ([`sinks`]): ParaView, XBalls, CSV, Parquet, particle tables for scenes, LAMMPS and LIGGGHTS, pictures. All share one
//! habit: whole files or none, and nothing is replaced without a request ([`output::Output`]).
//!
//! ```
//! use mercury_export::output::Output;
//! use mercury_export::{Job, Selection, Source, Table, export, sinks};
//!
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("one.data");
//! std::fs::write(&path, "1 0 0 0 0 1 1 1\n0.5 0.5 0.5 0 0 0 0.1 0 0 0 0 0 0 0\n")?;
//! let source = Source::open(&path)?;
//! let output = Output::new(&source, None, "csv", false)?;
//! let job = Job { source, selection: Selection::default(), output };
//! let sink = Box::new(sinks::csv(&job.output, Table::Particles));
//! let (outcome, files) = export(&job, sink, |number| println!("frame {number}"))?;
//! assert_eq!(outcome.frames, 1);
//! assert!(files[0].ends_with("csv/one.particles.0000.csv"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![allow(
    clippy::result_large_err,
    reason = "an error ends the export, so its size does not matter"
)]

mod beside;
mod bodies;
mod driver;
mod error;
pub mod output;
pub mod query;
pub mod run_table;
mod selection;
pub mod sinks;
mod source;
pub mod study_table;
mod xballs_script;

pub use bodies::ClumpsAs;
pub use driver::{Job, Outcome, Sink, export};
pub use error::ExportError;
pub use mercury_common::frames::FrameChoice;
pub use selection::{Region, Selection};
pub use source::{LammpsSource, Snapshot, Source, Table};

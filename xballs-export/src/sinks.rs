//! The kinds of output. Each is a [`Sink`](crate::Sink), or made of one of the two plain ones, [`FilePerFrame`] and [`OneFile`],
//! by an encoder that appends the bytes of a frame. A new kind, the sum of the radii of each frame as a line of one file:
//!
//! ```
//! # use mercury_export::{Job, Selection, Snapshot, Source, export, output::Output};
//! use std::io::Write as _;
//!
//! use mercury_export::sinks::OneFile;
//!
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("a.data");
//! # std::fs::write(&path, "1 0.5 0 0 0 1 1 1\n0.5 0.5 0.5 0 0 0 0.1 0 0 0 0 0 0 0\n")?;
//! # let source = Source::open(&path)?;
//! # let output = Output::new(&source, None, "radii", false)?;
//! # let job = Job { source, selection: Selection::default(), output };
//! let radii = |snapshot: &Snapshot, out: &mut Vec<u8>| {
//!     let sum: f64 = snapshot.numbers("radius")?.iter().sum();
//!     let _ = writeln!(out, "{} {sum}", snapshot.frame.time); // a Vec takes everything
//!     Ok(())
//! };
//! let sink = OneFile::begin(&job.output, "radii.txt", radii)?;
//! let (_, files) = export(&job, Box::new(sink), |_| {})?;
//! assert_eq!(std::fs::read_to_string(&files[0])?, "0.5 0.1\n");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod csv;
mod density;
mod files;
mod lammps;
mod parquet;
mod particle_csv;
pub mod pictures;
mod stl;
mod vtu;
mod xballs;

pub use csv::{csv, push_csv};
pub use files::{Encode, FilePerFrame, OneFile};
pub use lammps::{Density, data_files, dump, push_data_file, push_dump};
pub use parquet::Parquet;
pub use particle_csv::{particle_rows, particle_tables};
pub use stl::Stl;
pub use vtu::{Vtu, VtuChoice};
pub use xballs::{Info, Xballs, XballsChoice, data_frame};

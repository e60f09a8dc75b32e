//! The kinds of output. Each is a [`Sink`](crate::Sink), or made of one of the two plain ones: [`FilePerFrame`] and [`OneFile`].

mod csv;
mod files;
mod lammps;
mod parquet;
mod particle_csv;
pub mod pictures;
mod vtu;
mod xballs;

pub use csv::{csv, push_csv};
pub use files::{Encode, FilePerFrame, OneFile};
pub use lammps::{Density, data_files, dump, push_data_file, push_dump};
pub use parquet::Parquet;
pub use particle_csv::{particle_rows, particle_tables};
pub use vtu::{Vtu, VtuChoice};
pub use xballs::{Info, Xballs, XballsChoice, data_frame};

//! Native frames: what a run leaves of its particles and contacts, as Arrow IPC streams.
//!
//! A file is one Arrow IPC *stream* with one record batch per frame and flat columns, so pyarrow, pandas, polars, R and
//! DuckDB open it as it is (`docs/formats/frames.md` holds the layout and the how-to). Two promises go beyond Arrow:
//!
//! * **Readable while it grows.** At every instant the file is a complete stream of whole frames, see [`FrameWriter`].
//! * **Every frame has its time**, the empty one too: time and step stand in the message of the batch, besides the
//!   column `time`.
//!
//! The modules: [`FrameSchema`], [`Frame`] and [`Column`] describe the stored data; [`FrameWriter`] and [`FrameReader`] move it;
//! a [`Table`] is a type whose rows a file of frames holds, and declares its columns once. [`ParticleFrame`], [`ContactFrame`],
//! [`BodyFrame`], [`BondFrame`], [`WallFrame`], [`TriangleLoadFrame`], [`WearFrame`], [`WearTriangleFrame`],
//! [`MembraneFrame`] and [`MembraneTriangleFrame`] are the tables that the Mercury tools exchange.

// A `FormatError` gives the place of the error, a description and advice. It is made once per file, never in a loop.
#![allow(clippy::result_large_err)]

mod bodies;
mod bonds;
mod choice;
mod clump_surfaces;
mod columns;
mod contacts;
mod droplets;
mod frame;
mod header;
mod membranes;
mod message;
mod particles;
mod positioned;
mod reader;
mod schema;
mod table;
mod triangle_loads;
mod triangles;
mod walls;
mod wear;
mod writer;

pub use bodies::{BodyFrame, BodyReader, BodyWriter};
pub use bonds::{BondFrame, BondNames, BondReader, BondWriter};
pub use choice::FrameChoice;
pub use clump_surfaces::ClumpKind;
pub use columns::{ColumnVisitor, Values};
pub use contacts::{ContactColumns, ContactFrame, ContactReader, ContactWriter, HistoryColumn};
pub use droplets::{DropletFrame, DropletReader, DropletWriter};
pub use frame::{Column, Frame};
pub use header::FramesHeader;
pub use membranes::{
    MembraneFrame, MembraneReader, MembraneTriangleFrame, MembraneTriangleReader,
    MembraneTriangleWriter, MembraneWriter, SheetNow, VERTEX_HELD, sheets,
};
pub use particles::{
    FLAG_FIXED, FLAG_PRESCRIBED, ParticleColumns, ParticleFrame, ParticleReader, ParticleWriter,
};
pub use reader::{FrameInfo, FrameReader};
pub use schema::{ColumnKind, ColumnSpec, FrameSchema, SchemaError};
pub use table::{Table, TableReader, TableWriter};
pub use triangle_loads::{TriangleLoadFrame, TriangleLoadReader, TriangleLoadWriter};
pub use walls::{WallFrame, WallReader, WallWriter};
pub use wear::{
    WearFrame, WearReader, WearTriangleFrame, WearTriangleReader, WearTriangleWriter, WearWriter,
};
pub use writer::{FrameWriteError, FrameWriter};

/// The version of the layout, the value of the schema metadata `mercury_frames`.
pub const FRAMES_VERSION: &str = "1";

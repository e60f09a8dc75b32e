//! VTU and PVD: what ParaView, pyvista and meshio open.
//!
//! A [`VtuGrid`] is points, cells between them, and named arrays on both, all borrowed from the caller; [`write_vtu`] writes it
//! as one `UnstructuredGrid` in appended binary, and [`PvdWriter`] keeps the list of such files with their times. Blocks are
//! compressed on their own, in parallel if wished, and in the same bytes on any number of threads. See `docs/formats/vtu.md`.

mod blocks;
mod encode;
mod pvd;
#[cfg(test)]
mod tests;
mod values;

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::whole_file::{FileError, WholeFile};

pub use encode::encode_vtu;
pub use pvd::{PvdEntry, PvdWriter, pvd_text};
pub use values::VtuValues;

/// Points, cells and arrays: one `.vtu` file.
#[derive(Debug, Clone, Default)]
pub struct VtuGrid<'a> {
    /// Time in s, stored as field data `TimeValue`, which ParaView understands.
    pub time: Option<f64>,
    /// Corners of the cells in m.
    pub points: Cow<'a, [DVec3]>,
    /// Cells that connect the points.
    pub cells: VtuCells<'a>,
    /// Arrays with one entry per point.
    pub point_data: Vec<VtuArray<'a>>,
    /// Arrays with one entry per cell.
    pub cell_data: Vec<VtuArray<'a>>,
}

/// Cells of a grid. Entries are indices of points.
#[derive(Debug, Clone, Default)]
pub enum VtuCells<'a> {
    /// Every point is a cell of its own, as for spheres, so that thresholds and clips of ParaView work on them.
    #[default]
    Vertices,
    /// Straight lines, as for contacts.
    Lines(Cow<'a, [[u32; 2]]>),
    /// Triangles, as for surfaces.
    Triangles(Cow<'a, [[u32; 3]]>),
}

/// A named array on points or cells.
#[derive(Debug, Clone)]
pub struct VtuArray<'a> {
    /// The name that users pick in ParaView.
    pub name: Cow<'a, str>,
    /// The values.
    pub values: VtuValues<'a>,
}

impl<'a> VtuArray<'a> {
    /// An array of numbers or vectors.
    pub fn new(name: impl Into<Cow<'a, str>>, values: impl Into<VtuValues<'a>>) -> Self {
        Self {
            name: name.into(),
            values: values.into(),
        }
    }
}

/// How floating point numbers are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum VtuPrecision {
    /// 64 bits: exact.
    #[default]
    Double,
    /// 32 bits: 7 digits in half the space.
    Single,
}

/// How blocks are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum VtuCompression {
    /// Without compression.
    None,
    /// Deflate (zlib) at its fastest level where a sample of the block shrinks by a tenth, else stored inside zlib's frame:
    /// the digits of measured quantities hardly shrink, and trying costs more time than a disk does.
    #[default]
    Adaptive,
    /// Deflate (zlib) at this level, 1 (fast) to 9 (small), for every block.
    Level(u8),
}

/// How a grid is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VtuOptions {
    /// Precision of floating point numbers.
    pub precision: VtuPrecision,
    /// Compression of blocks.
    pub compression: VtuCompression,
    /// Compress blocks in the current rayon pool; else on the calling thread. The bytes are the same.
    pub parallel: bool,
}

impl VtuOptions {
    /// Exact, compressed where it pays, on all threads.
    pub const DEFAULT: Self = Self {
        precision: VtuPrecision::Double,
        compression: VtuCompression::Adaptive,
        parallel: true,
    };
}

impl Default for VtuOptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Why a file for ParaView was not written.
#[derive(Debug, thiserror::Error)]
pub enum VtuError {
    /// Arrays, points and cells do not fit together.
    #[error("{}: {reason}", path.display())]
    Grid {
        /// The file that was to be written.
        path: PathBuf,
        /// Description of the mismatch.
        reason: String,
    },
    /// A list of files cannot be continued.
    #[error("{}: {found}, expected {expected}", path.display())]
    List {
        /// The `.pvd` file.
        path: PathBuf,
        /// Number of bytes in the file.
        found: String,
        /// Number of bytes that the file should hold.
        expected: String,
    },
    /// The operating system refused.
    #[error(transparent)]
    File(#[from] FileError),
}

/// Writes a grid under a temporary name beside its place, then renames it: the file is there as a whole or not at all.
///
/// # Errors
/// [`VtuError::Grid`] when an array is not as long as its points or cells, two arrays of a kind have one name, or a cell
/// uses a point that is not there; [`VtuError::File`] when the system refuses.
pub fn write_vtu(path: &Path, grid: &VtuGrid, options: VtuOptions) -> Result<(), VtuError> {
    let parts = encode_vtu(grid, options).map_err(|reason| VtuError::Grid {
        path: path.to_owned(),
        reason,
    })?;
    let mut file = WholeFile::create(path)?;
    for part in &parts {
        file.append(part)?;
    }
    file.finish()?;
    Ok(())
}

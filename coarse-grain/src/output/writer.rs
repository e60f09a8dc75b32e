//! Files of blocks, as they come.

use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use mercury_common::formats::number::NumberStyle;
use mercury_common::formats::vtu::{PvdEntry, PvdWriter};
use mercury_common::whole_file::{WholeFile, write_whole};

use super::stat::StatTime;
use super::{chart, csv, stat, vti};
use crate::CgError;
use crate::analysis::{Analysis, Block, TIME_CUTOFF, TimeMode};

/// A kind of file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// MercuryCG's layout.
    Stat,
    /// A table.
    Csv,
    /// Image data for ParaView.
    Vti,
    /// A picture as vectors.
    Svg,
    /// A picture as pixels.
    Png,
}

impl Format {
    /// The kind of file that a name selects by its ending.
    ///
    /// # Errors
    /// When the ending is not known.
    pub fn of(path: &Path) -> Result<Self, CgError> {
        match path.extension().and_then(|ending| ending.to_str()) {
            Some("stat") => Ok(Self::Stat),
            Some("csv") => Ok(Self::Csv),
            Some("vti") => Ok(Self::Vti),
            Some("svg") => Ok(Self::Svg),
            Some("png") => Ok(Self::Png),
            _ => Err(CgError::Input(format!(
                "{}: the name must end in .stat, .csv, .vti, .svg or .png",
                path.display()
            ))),
        }
    }
}

/// How blocks follow each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Succession {
    /// There is one.
    Single,
    /// Each is added to those before.
    Series,
}

/// Writes blocks to a file or a series of files.
#[derive(Debug)]
pub struct Writer {
    path: PathBuf,
    format: Format,
    succession: Succession,
    /// While a run is followed, what is there can be read at any time; otherwise the file appears when it is complete.
    live: bool,
    file: Option<Growing>,
    list: Option<PvdWriter>,
    blocks: usize,
    style: NumberStyle,
}

/// The file of a series of blocks.
#[derive(Debug)]
enum Growing {
    /// The file has its name from the beginning.
    Live(File),
    /// The file gets its name when it is complete.
    Whole(WholeFile),
}

fn failed(path: &Path) -> impl FnOnce(std::io::Error) -> CgError + use<> {
    let path = path.to_owned();
    move |source| CgError::File {
        path,
        action: "the file cannot be written",
        source,
    }
}

impl Writer {
    /// A writer without blocks; nothing is written yet.
    ///
    /// # Errors
    /// When the name has no known ending, or files of the name are there and may not be replaced.
    pub fn new(
        path: &Path,
        succession: Succession,
        live: bool,
        compat: bool,
        force: bool,
    ) -> Result<Self, CgError> {
        let format = Format::of(path)?;
        let writer = Self {
            path: path.to_owned(),
            format,
            succession,
            live,
            file: None,
            list: None,
            blocks: 0,
            // MercuryCG prints six digits.
            style: if compat {
                NumberStyle::Digits(6)
            } else {
                NumberStyle::Digits(10)
            },
        };
        let first = writer.first();
        if first.exists() && !force {
            return Err(CgError::Exists(first));
        }
        Ok(writer)
    }

    fn is_list(&self) -> bool {
        self.format == Format::Vti && self.succession == Succession::Series
    }

    /// A series of files with numbers in their names.
    fn is_numbered(&self) -> bool {
        self.succession == Succession::Series && !matches!(self.format, Format::Stat | Format::Csv)
    }

    fn numbered(&self, number: usize) -> PathBuf {
        let stem = self.path.file_stem().unwrap_or_default().to_string_lossy();
        let ending = self.path.extension().unwrap_or_default().to_string_lossy();
        self.path
            .with_file_name(format!("{stem}.{number:04}.{ending}"))
    }

    /// The file that stands for all of them: replacing it replaces all.
    fn first(&self) -> PathBuf {
        if self.is_list() {
            self.path.with_extension("pvd")
        } else if self.is_numbered() {
            self.numbered(0)
        } else {
            self.path.clone()
        }
    }

    /// Writes a block.
    ///
    /// # Errors
    /// When the system refuses, or the format cannot hold the fields.
    pub fn write(&mut self, analysis: &Analysis, block: &Block) -> Result<(), CgError> {
        let evaluator = &analysis.evaluator;
        let timed = self.succession == Succession::Series;
        let mut bytes = Vec::new();
        match self.format {
            Format::Vti => {
                let encoded = vti::encode(evaluator, block)?;
                return self.write_numbered(block, &encoded);
            }
            Format::Svg => {
                let page = chart::page(evaluator, analysis.time, block)?;
                return self.write_numbered(block, page.svg()?.as_bytes());
            }
            Format::Png => {
                let page = chart::page(evaluator, analysis.time, block)?;
                return self.write_numbered(block, &page.image()?.png()?);
            }
            Format::Csv => {
                push_table(&mut bytes, analysis, block, self.blocks == 0, timed);
            }
            Format::Stat => {
                if self.blocks == 0 || !timed {
                    bytes.extend(
                        stat::header(
                            evaluator,
                            &block.space,
                            stat_time(analysis.time),
                            self.style,
                        )
                        .into_bytes(),
                    );
                }
                if let Some(sums) = &block.sums {
                    stat::push_rows(&mut bytes, block.time, &evaluator.place, sums, self.style);
                }
            }
        }
        self.blocks += 1;
        if !timed {
            return Ok(write_whole(&self.path, &bytes)?);
        }
        let growing = match &mut self.file {
            Some(open) => open,
            None => self.file.insert(if self.live {
                Growing::Live(File::create(&self.path).map_err(failed(&self.path))?)
            } else {
                Growing::Whole(WholeFile::create(&self.path)?)
            }),
        };
        match growing {
            Growing::Live(file) => file.write_all(&bytes).map_err(failed(&self.path)),
            Growing::Whole(file) => Ok(file.append(&bytes)?),
        }
    }

    /// A file of its own for each block of a series.
    fn write_numbered(&mut self, block: &Block, bytes: &[u8]) -> Result<(), CgError> {
        let path = if self.is_numbered() {
            self.numbered(self.blocks)
        } else {
            self.path.clone()
        };
        if self.is_list() && self.blocks == 0 {
            self.list = Some(PvdWriter::create(self.path.with_extension("pvd"))?);
        }
        self.blocks += 1;
        write_whole(&path, bytes)?;
        if let Some(list) = &mut self.list {
            let file = path
                .file_name()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned();
            list.append(&PvdEntry {
                time: block.time,
                file,
            })?;
        }
        Ok(())
    }

    /// Puts the file in its place; returns its name and the number of blocks.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn finish(mut self) -> Result<(PathBuf, usize), CgError> {
        if let Some(Growing::Whole(file)) = self.file.take() {
            file.finish()?;
        }
        Ok((self.first(), self.blocks))
    }
}

/// Appends a block to a table: its rows, before those of the `first` one the heading. A table that is not `timed` holds one block, and so always a
/// heading.
pub fn push_table(out: &mut Vec<u8>, analysis: &Analysis, block: &Block, first: bool, timed: bool) {
    let evaluator = &analysis.evaluator;
    if first || !timed {
        out.extend(about(analysis, block, timed).into_bytes());
        out.extend(csv::header(evaluator, block, timed).into_bytes());
    }
    csv::push_rows(out, evaluator, block, timed);
}

/// A line about the origin of the numbers.
#[must_use]
pub fn about(analysis: &Analysis, block: &Block, timed: bool) -> String {
    let kernel = &analysis.evaluator.kernel;
    let mut line = format!(
        "# mercury-cg {}: coordinates {}, kernel {}, width {:?} m",
        env!("CARGO_PKG_VERSION"),
        analysis.evaluator.coordinates,
        kernel.shape.name(),
        kernel.width
    );
    if kernel.shape == crate::kernel::KernelShape::Gaussian {
        line += &format!(", cut-off {:?} widths", kernel.cutoff);
    }
    if !timed {
        line += &match analysis.time {
            TimeMode::Frames => format!(", t = {:?} s", block.time),
            _ => format!(
                ", mean of {} frames from t = {:?} to {:?} s",
                block.frames, block.span.0, block.span.1
            ),
        };
    }
    line + "\n"
}

fn stat_time(time: TimeMode) -> StatTime {
    match time {
        TimeMode::Frames => StatTime::Frames,
        TimeMode::Average => StatTime::Average,
        TimeMode::Smooth { width, .. } => StatTime::Smooth {
            width,
            cutoff: TIME_CUTOFF * width,
        },
    }
}

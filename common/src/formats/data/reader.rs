//! Reading `.data` frame by frame.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::{DataFrame, DataLayout, MOST_COLUMNS};
use crate::error::FormatError;
use crate::formats::lines::LineReader;

/// Reads one frame at a time; memory holds one frame.
///
/// Blank lines and lines that start with `#` are skipped, and surplus columns are ignored. After an
/// error the iterator ends: an unfinished last frame gives all complete frames and then one error.
#[derive(Debug)]
pub struct DataReader<R> {
    lines: LineReader<R>,
    finished: bool,
    layout: Option<DataLayout>,
}

impl DataReader<BufReader<File>> {
    /// Opens a file.
    ///
    /// # Errors
    /// If it cannot be opened.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, FormatError> {
        let path = path.as_ref();
        let file = crate::formats::open(path)?;
        Ok(Self::new(BufReader::with_capacity(1 << 17, file), path))
    }
}

impl<R: BufRead> DataReader<R> {
    /// Reads from anything; `path` is only used in messages.
    pub fn new(input: R, path: impl Into<PathBuf>) -> Self {
        Self {
            lines: LineReader::new(input, path),
            finished: false,
            layout: None,
        }
    }

    /// The layout of the frame that was read last; `None` before the first particle.
    pub fn layout(&self) -> Option<DataLayout> {
        self.layout
    }

    fn advance(&mut self) -> Result<bool, FormatError> {
        while self.lines.advance()? {
            if !self.lines.is_comment() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn read_frame(&mut self) -> Result<Option<DataFrame>, FormatError> {
        if !self.advance()? {
            return Ok(None);
        }
        let header_line = self.lines.line_number();
        let (mut frame, count) = self.read_header()?;
        // The count is only a promise: no more memory is allocated than the lines themselves need.
        frame.particles.reserve(count.min(256));

        let mut values = [0.0; MOST_COLUMNS];
        let mut layout = None;
        for index in 0..count {
            if !self.advance()? {
                return Err(self.unfinished(&frame, index, count, header_line));
            }
            let layout = match layout {
                Some(layout) => layout,
                None => match self.detect_layout(frame.dimensions) {
                    Ok(found) => *layout.insert(found),
                    // Wrong in the first frame, cut in a later one.
                    Err(error) if self.layout.is_none() => return Err(error),
                    Err(error) => {
                        return Err(self.explain_bad_row(error, &frame, index, count, header_line));
                    }
                },
            };
            let names = layout.columns();
            let mut tokens = self.lines.tokens();
            if let Err(error) = tokens.numbers(&mut values[..names.len()], names) {
                return Err(self.explain_bad_row(error, &frame, index, count, header_line));
            }
            frame.particles.push(layout.row(&values));
        }
        self.layout = layout.or(self.layout);
        Ok(Some(frame))
    }

    /// The header and the number of particles that it promises.
    fn read_header(&self) -> Result<(DataFrame, usize), FormatError> {
        let line = self.lines.line_number();
        let dimensions = match self.lines.tokens().count() {
            6 => 2,
            8 => 3,
            other => {
                return Err(FormatError::at(
                    self.lines.path(),
                    line,
                    Some(1),
                    format!("a line of {other} columns where a frame should begin"),
                    "the header of a frame: N time xMin yMin xMax yMax (2D) \
                     or N time xMin yMin zMin xMax yMax zMax (3D)",
                )
                .with_help(
                    "if this is a particle, the number of particles in the header before it is too small",
                ));
            }
        };
        let names: &[&str] = if dimensions == 2 {
            &["time", "xMin", "yMin", "xMax", "yMax"]
        } else {
            &["time", "xMin", "yMin", "zMin", "xMax", "yMax", "zMax"]
        };
        let mut tokens = self.lines.tokens();
        let count_token = tokens.clone().next();
        let count = tokens.number("the number of particles")?;
        // Above 2^53 not every whole number can be distinguished from its neighbours.
        if !(count >= 0.0 && count.trunc() == count && count < 9_007_199_254_740_992.0) {
            let expected = "a whole number of at least 0";
            return Err(match count_token {
                Some(token) => tokens.unexpected(token, "the number of particles", expected),
                None => FormatError::at(self.lines.path(), line, None, "no number", expected),
            });
        }
        let mut v = [0.0; 7];
        tokens.numbers(&mut v[..names.len()], names)?;
        let (min, max) = if dimensions == 2 {
            (DVec3::new(v[1], v[2], 0.0), DVec3::new(v[3], v[4], 0.0))
        } else {
            (DVec3::new(v[1], v[2], v[3]), DVec3::new(v[4], v[5], v[6]))
        };
        let frame = DataFrame {
            time: v[0],
            dimensions,
            min,
            max,
            particles: Vec::new(),
        };
        Ok((frame, count as usize))
    }

    fn detect_layout(&self, dimensions: u8) -> Result<DataLayout, FormatError> {
        let columns = self.lines.tokens().count();
        DataLayout::detect(dimensions, columns).ok_or_else(|| {
            let expected = if dimensions == 2 {
                "8 columns: x y vx vy r angle omega info"
            } else {
                "14 columns: x y z vx vy vz r ax ay az wx wy wz info \
                 (or 8: x z y vx vz vy r info; or 15: as 14 with one more before info)"
            };
            FormatError::at(
                self.lines.path(),
                self.lines.line_number(),
                Some(1),
                format!("a particle of {columns} columns after a {dimensions}D header"),
                expected,
            )
        })
    }

    fn unfinished(
        &self,
        frame: &DataFrame,
        found: usize,
        count: usize,
        header_line: usize,
    ) -> FormatError {
        FormatError::at(
            self.lines.path(),
            self.lines.line_number(),
            None,
            format!(
                "the file ends after {found} of {count} particles of the frame at t = {}",
                frame.time
            ),
            format!("{count} particle lines after the header in line {header_line}"),
        )
        .with_help(format!(
            "the frame is unfinished (the run was stopped while writing, or still runs); \
             remove line {header_line} and all after it to use the frames before"
        ))
    }

    /// A bad last line usually means that the file was cut, not that a number is wrong.
    fn explain_bad_row(
        &mut self,
        error: FormatError,
        frame: &DataFrame,
        index: usize,
        count: usize,
        header_line: usize,
    ) -> FormatError {
        match self.advance() {
            Ok(false) => self.unfinished(frame, index, count, header_line),
            _ => error,
        }
    }
}

impl<R: BufRead> Iterator for DataReader<R> {
    type Item = Result<DataFrame, FormatError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.finished {
            return None;
        }
        let result = self.read_frame().transpose();
        self.finished = !matches!(result, Some(Ok(_)));
        result
    }
}

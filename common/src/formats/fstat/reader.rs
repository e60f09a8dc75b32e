//! Reading `.fstat` frame by frame.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::{COLUMNS, ContactRow, FstatFrame};
use crate::error::FormatError;
use crate::formats::lines::{LineReader, Tokens};

/// Reads one frame at a time; memory holds one frame.
///
/// Blank lines and surplus columns are ignored. After an error the iterator ends. The format does not store the number of
/// contacts of a frame, so a file that was cut between two lines looks like a complete one: compare with the `.data` file if that
/// matters.
#[derive(Debug)]
pub struct FstatReader<R> {
    lines: LineReader<R>,
    finished: bool,
}

impl FstatReader<BufReader<File>> {
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

impl<R: BufRead> FstatReader<R> {
    /// Reads from anything; `path` is only used in messages.
    pub fn new(input: R, path: impl Into<PathBuf>) -> Self {
        Self {
            lines: LineReader::new(input, path),
            finished: false,
        }
    }

    fn read_frame(&mut self) -> Result<Option<FstatFrame>, FormatError> {
        if !self.lines.advance()? {
            return Ok(None);
        }
        if !self.lines.is_comment() {
            return Err(FormatError::at(
                self.lines.path(),
                self.lines.line_number(),
                Some(1),
                "a line that does not start with # where a frame should begin",
                "\"# time 1\", the first of the three header lines of a frame",
            ));
        }
        let mut v = [0.0; 10];
        self.header_line(&mut v[0..2], &["time", "the marker of contact points"])?;
        let corners = ["xMin", "yMin", "zMin", "xMax", "yMax", "zMax"];
        self.advance_in_header(v[0], "the domain")?;
        self.header_line(&mut v[2..8], &corners)?;
        self.advance_in_header(v[0], "the radii")?;
        self.header_line(
            &mut v[8..10],
            &["the smallest radius", "the largest radius"],
        )?;
        let mut frame = FstatFrame {
            time: v[0],
            has_contact_points: v[1] != 0.0,
            min: DVec3::new(v[2], v[3], v[4]),
            max: DVec3::new(v[5], v[6], v[7]),
            radius_min: v[8],
            radius_max: v[9],
            contacts: Vec::new(),
        };
        while self.lines.advance()? {
            if self.lines.is_comment() {
                self.lines.hold();
                break;
            }
            match contact(self.lines.tokens()) {
                Ok(row) => frame.contacts.push(row),
                Err(error) => return Err(self.explain_bad_row(error, frame.time)),
            }
        }
        Ok(Some(frame))
    }

    fn header_line(&self, values: &mut [f64], names: &[&str]) -> Result<(), FormatError> {
        let mut tokens = self.lines.tokens();
        let mark = tokens.expect("the # of the header", "#")?;
        if mark.text != "#" {
            return Err(tokens.unexpected(
                mark,
                "the beginning of a header line",
                "# and a blank (each frame begins with three such lines)",
            ));
        }
        tokens.numbers(values, names)
    }

    /// Goes to the second or third line of a header.
    fn advance_in_header(&mut self, time: f64, what: &str) -> Result<(), FormatError> {
        if self.lines.advance()? {
            return Ok(());
        }
        Err(FormatError::at(
            self.lines.path(),
            self.lines.line_number(),
            None,
            format!("the file ends within the header of the frame at t = {time}"),
            format!("the header line with {what}"),
        )
        .with_help("the frame is unfinished: remove it to use the frames before"))
    }

    /// A bad last line usually means that the file was cut, not that a number is wrong.
    fn explain_bad_row(&mut self, error: FormatError, time: f64) -> FormatError {
        match self.lines.advance() {
            Ok(false) => error.with_help(format!(
                "this is the last line, so the frame at t = {time} seems unfinished (the run was stopped \
                 while writing, or still runs); remove that frame to use the ones before"
            )),
            _ => error,
        }
    }
}

fn contact(mut tokens: Tokens<'_>) -> Result<ContactRow, FormatError> {
    let time = tokens.number(COLUMNS[0])?;
    let i = tokens.integer(COLUMNS[1])?;
    let j = tokens.integer(COLUMNS[2])?;
    let mut v = [0.0; 13];
    tokens.numbers(&mut v, &COLUMNS[3..])?;
    Ok(ContactRow {
        time,
        i,
        j,
        contact_point: DVec3::new(v[0], v[1], v[2]),
        overlap: v[3],
        tangential_overlap: v[4],
        normal_force: v[5],
        tangential_force: v[6],
        normal: DVec3::new(v[7], v[8], v[9]),
        tangent: DVec3::new(v[10], v[11], v[12]),
    })
}

impl<R: BufRead> Iterator for FstatReader<R> {
    type Item = Result<FstatFrame, FormatError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.finished {
            return None;
        }
        let result = self.read_frame().transpose();
        self.finished = !matches!(result, Some(Ok(_)));
        result
    }
}

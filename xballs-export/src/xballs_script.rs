//! The script `.disp` that starts XBalls.

use std::path::{Path, PathBuf};

use glam::DVec3;
use mercury_common::error::FormatError;

/// How XBalls shall show a `.data` file.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Script {
    /// The file, relative to the script or not.
    pub(crate) data: PathBuf,
    /// 8 in two dimensions, 14 in three.
    pub(crate) format: u8,
    /// Pixels per length, in units of the window.
    pub(crate) scale: f64,
    /// Offsets of the picture along x and upwards, in pixels.
    pub(crate) offset: [i64; 2],
    /// Meaning of the colours: 8 shows `info`, as shades.
    pub(crate) colour_mode: u8,
}

impl Script {
    /// The view that MercuryDPM chooses: the domain (lower and upper corner, m) fills the window, x to the right, up is y in
    /// two dimensions and z in three.
    #[must_use]
    pub(crate) fn for_domain(data: PathBuf, dimensions: u8, (min, max): (DVec3, DVec3)) -> Self {
        let up = if dimensions == 2 { 1 } else { 2 };
        let size = max - min;
        let largest = size.x.max(size[up]);
        let flat = if dimensions == 2 { 1.0 } else { 1.2 };
        let scale = if largest > 0.0 { flat / largest } else { 1.0 };
        let offset = |axis: usize| {
            if size[axis] > 0.0 {
                (-500.0 * min[axis] / size[axis]).trunc() as i64
            } else {
                0
            }
        };
        Self {
            data,
            format: if dimensions == 2 { 8 } else { 14 },
            scale,
            offset: [offset(0), offset(up)],
            colour_mode: 8,
        }
    }

    /// The script as MercuryDPM writes it: it goes to its own folder, so that it can be started from anywhere, and hands its
    /// arguments on. `XBALLS` in the environment is the path of the viewer.
    #[must_use]
    pub(crate) fn to_text(&self) -> String {
        let offset = |name: &str, value: i64| {
            let minus = if value < 0 { "m" } else { "" };
            format!("-{minus}{name} {}", value.unsigned_abs())
        };
        let quoted = self.data.to_string_lossy().replace('\'', r"'\''");
        format!(
            "#!/bin/bash\n\
             cd \"$(dirname \"$0\")\" || exit 1\n\
             \"${{XBALLS:-xballs}}\" -format {} -f '{quoted}' -s {:?} -cmode {} -cmax -sort {} {} \"$@\"\n",
            self.format,
            self.scale,
            self.colour_mode,
            offset("oh", self.offset[0]),
            offset("o", self.offset[1]),
        )
    }

    /// Reads the options of a script of ours or of MercuryDPM; options that are not known here are skipped.
    ///
    /// # Errors
    /// When the file cannot be read or starts no viewer on a file.
    pub(crate) fn read(path: &Path) -> Result<Self, FormatError> {
        let bytes = std::fs::read(path).map_err(|error| {
            FormatError::of_file(path, format!("the file cannot be read: {error}"))
        })?;
        let text = String::from_utf8_lossy(&bytes);
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut found = None;
        for (index, line) in text.lines().enumerate() {
            let words = words(line);
            if !line.trim_start().starts_with('#') && words.iter().any(|word| word == "-f") {
                found = Some(Self::of_words(path, folder, index + 1, &words)?);
            }
        }
        found.ok_or_else(|| FormatError {
            expected: "a line that starts xballs with -f FILE.data".to_owned(),
            ..FormatError::of_file(path, "no command for XBalls")
        })
    }

    fn of_words(
        path: &Path,
        folder: &Path,
        line: usize,
        words: &[String],
    ) -> Result<Self, FormatError> {
        let value = |name: &str| {
            let place = words.iter().position(|word| word == name)?;
            words.get(place + 1)
        };
        let number = |name: &str, default: f64| match value(name) {
            None => Ok(default),
            Some(text) => text.parse::<f64>().map_err(|_| {
                let found = format!("{text} behind {name}");
                FormatError::at(path, line, None, found, "a number")
            }),
        };
        let Some(data) = value("-f") else {
            let found = "-f without a file behind it";
            return Err(FormatError::at(path, line, None, found, "FILE.data"));
        };
        let offset = |plus: &str, minus: &str| -> Result<i64, FormatError> {
            Ok((number(plus, 0.0)? - number(minus, 0.0)?) as i64)
        };
        Ok(Self {
            data: folder.join(data),
            // The default of XBalls.
            format: number("-format", 5.0)? as u8,
            scale: number("-s", 1.0)?,
            offset: [offset("-oh", "-moh")?, offset("-o", "-mo")?],
            colour_mode: number("-cmode", 0.0)? as u8,
        })
    }
}

/// Words of a line of a shell script; quotes group, nothing is expanded.
fn words(line: &str) -> Vec<String> {
    let mut words = Vec::new();
    let mut word: Option<String> = None;
    let mut quote = None;
    let mut letters = line.chars();
    while let Some(letter) = letters.next() {
        match (quote, letter) {
            (None, c) if c.is_whitespace() => words.extend(word.take()),
            (None, '\'' | '"') => {
                quote = Some(letter);
                word.get_or_insert_default();
            }
            (Some(open), c) if c == open => quote = None,
            (None, '\\') => word.get_or_insert_default().extend(letters.next()),
            (_, c) => word.get_or_insert_default().push(c),
        }
    }
    words.extend(word);
    words
}

#[cfg(test)]
mod tests;

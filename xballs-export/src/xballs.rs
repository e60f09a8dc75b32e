//! XBalls: `.data` in the layouts that it reads, and the script `.disp` that starts it.

use std::path::{Path, PathBuf};

use glam::{DQuat, DVec3};
use mercury_common::error::FormatError;
use mercury_common::formats::data::{DataFrame, DataRow, write_frame};
use mercury_common::formats::number::NumberStyle;
use mercury_common::formats::orientation::euler_from_quaternion;
use mercury_common::frames::Column;
use mercury_common::whole_file::FileError;

use crate::output::Output;
use crate::source::EULER;
use crate::{ExportError, Selection, Snapshot, Source, Told, for_each_snapshot};

/// How XBalls shall show a `.data` file.
#[derive(Debug, Clone, PartialEq)]
pub struct Script {
    /// The file, relative to the script or not.
    pub data: PathBuf,
    /// 8 in two dimensions, 14 in three.
    pub format: u8,
    /// Pixels per length, in units of the window.
    pub scale: f64,
    /// Offsets of the picture along x and upwards, in pixels.
    pub offset: [i64; 2],
    /// What the colours mean: 8 shows `info`, as shades.
    pub colour_mode: u8,
}

impl Script {
    /// The view that MercuryDPM chooses: the domain (lower and upper corner, m) fills the window, x to the right, up is y in
    /// two dimensions and z in three.
    #[must_use]
    pub fn for_domain(data: PathBuf, dimensions: u8, (min, max): (DVec3, DVec3)) -> Self {
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
    /// arguments on. `XBALLS` in the environment says where the viewer is.
    #[must_use]
    pub fn to_text(&self) -> String {
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

    /// Reads what a script of ours or of MercuryDPM says; options that are not known here are skipped.
    ///
    /// # Errors
    /// When the file cannot be read or starts no viewer on a file.
    pub fn read(path: &Path) -> Result<Self, FormatError> {
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
            // What XBalls assumes if it is not told.
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

/// What stands in the last column of `.data`, which XBalls colours by.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Info {
    /// The index of the material; of a `.data` file its own info.
    #[default]
    Material,
    /// The magnitude of the velocity, m/s.
    Speed,
    /// A column of the frame.
    Column(String),
}

/// A frame in the layout of `.data`.
///
/// # Errors
/// When it has no positions or radii, or no such column.
pub fn data_frame(
    snapshot: &Snapshot,
    dimensions: u8,
    info: &Info,
) -> Result<DataFrame, ExportError> {
    let input = |found: String| ExportError::Input(format!("{}: {found}", snapshot.path.display()));
    let radius = snapshot.numbers("radius")?;
    let position = snapshot.vectors(["x", "y", "z"]);
    let position = position.ok_or_else(|| input("no positions x, y, z".to_owned()))?;
    let none = || vec![DVec3::ZERO; radius.len()];
    let velocity = snapshot.vectors(["vx", "vy", "vz"]).unwrap_or_else(none);
    let spin = snapshot.vectors(["wx", "wy", "wz"]).unwrap_or_else(none);
    let imaginary = snapshot.vectors(["qx", "qy", "qz"]);
    let as_read = snapshot.vectors(EULER);
    let angles: Vec<DVec3> = match (as_read, snapshot.numbers("qw"), imaginary) {
        (Some(angles), _, _) => angles,
        (None, Ok(real), Some(imaginary)) => {
            let parts = real.iter().zip(imaginary);
            let turns = parts.map(|(&w, v)| DQuat::from_xyzw(v.x, v.y, v.z, w));
            turns.map(euler_from_quaternion).collect()
        }
        _ => none(),
    };
    let column = |name: &str| -> Option<Vec<f64>> {
        Some(match snapshot.column(name)? {
            Column::F64(v) => v.clone(),
            Column::I32(v) => v.iter().map(|&v| v.into()).collect(),
            Column::U8(v) => v.iter().map(|&v| v.into()).collect(),
            Column::U32(v) => v.iter().map(|&v| v.into()).collect(),
            Column::OptionalU32(v) => v.iter().map(|v| v.map_or(-1.0, f64::from)).collect(),
            Column::U64(v) => v.iter().map(|&v| v as f64).collect(),
            Column::Text(_) => return None,
        })
    };
    let info = match info {
        Info::Material => {
            let found = column("info").or_else(|| column("material"));
            found.unwrap_or_else(|| vec![0.0; radius.len()])
        }
        Info::Speed => velocity.iter().map(|v| v.length()).collect(),
        Info::Column(name) => {
            column(name).ok_or_else(|| input(format!("no column `{name}` of numbers")))?
        }
    };
    let (min, max) = snapshot.domain()?;
    let rows = (0..radius.len()).map(|k| DataRow {
        position: position[k],
        velocity: velocity[k],
        radius: radius[k],
        angles: angles[k],
        angular_velocity: spin[k],
        info: info[k],
    });
    Ok(DataFrame {
        time: snapshot.frame.time,
        dimensions,
        min,
        max,
        particles: rows.collect(),
    })
}

/// How `.data` is written.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct XballsChoice {
    /// 2 or 3; what the input says if not given.
    pub dimensions: Option<u8>,
    /// The last column.
    pub info: Info,
    /// How numbers look.
    pub style: NumberStyle,
}

/// Writes `<prefix>.data` with all selected frames and `<prefix>.disp`.
///
/// # Errors
/// When the input cannot be read, a file of an earlier export is in the way, or a file cannot be written.
pub fn export(
    source: &Source,
    selection: &Selection,
    output: &Output,
    choice: &XballsChoice,
    mut progress: impl FnMut(&Snapshot),
) -> Result<(Told, Vec<PathBuf>), ExportError> {
    let script_path = output.path("disp");
    output.claim(&script_path)?;
    let mut file = output.begin(output.path("data"))?;
    let mut script = None;
    let mut out = Vec::new();
    let told = for_each_snapshot(source, selection, |snapshot| {
        progress(&snapshot);
        let dimensions = choice.dimensions.unwrap_or_else(|| snapshot.dimensions());
        let frame = data_frame(&snapshot, dimensions, &choice.info)?;
        script.get_or_insert_with(|| {
            let name = PathBuf::from(format!("{}.data", output.prefix));
            let mut script = Script::for_domain(name, dimensions, (frame.min, frame.max));
            if choice.info != Info::Material {
                // A scale of colours from the least to the largest value.
                script.colour_mode = 14;
            }
            script
        });
        out.clear();
        write_frame(&frame, choice.style, &mut out);
        Ok(file.append(&out)?)
    })?;
    let data = file.path().to_owned();
    file.finish()?;
    if let Some(script) = script {
        output.write(&script_path, script.to_text().as_bytes())?;
        make_executable(&script_path)?;
    }
    Ok((told, vec![data, script_path]))
}

#[cfg(unix)]
fn make_executable(path: &Path) -> Result<(), ExportError> {
    use std::os::unix::fs::PermissionsExt as _;
    let permissions = std::fs::Permissions::from_mode(0o755);
    let made = std::fs::set_permissions(path, permissions);
    Ok(made.map_err(FileError::of(path, "the script cannot be made executable"))?)
}

#[cfg(not(unix))]
fn make_executable(_: &Path) -> Result<(), ExportError> {
    Ok(())
}

#[cfg(test)]
mod tests;

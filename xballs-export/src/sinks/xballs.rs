//! `.data` in the layouts that XBalls reads, and the script that starts it.

use std::path::{Path, PathBuf};

use glam::{DQuat, DVec3};
use mercury_common::formats::data::{DataFrame, DataRow, write_frame};
use mercury_common::formats::number::NumberStyle;
use mercury_common::formats::orientation::euler_from_quaternion;
use mercury_common::frames::Column;
use mercury_common::whole_file::{FileError, WholeFile};

use crate::output::Output;
use crate::source::EULER;
use crate::xballs_script::Script;
use crate::{ExportError, Outcome, Sink, Snapshot};

/// Value in the last column of `.data`, which XBalls colours by.
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
    /// 2 or 3; that of the input if not given.
    pub dimensions: Option<u8>,
    /// The last column.
    pub info: Info,
    /// How numbers look.
    pub style: NumberStyle,
}

/// `<prefix>.data` with all selected frames, and `<prefix>.disp`.
#[derive(Debug)]
pub struct Xballs<'a> {
    output: &'a Output,
    choice: XballsChoice,
    file: WholeFile,
    bytes: Vec<u8>,
    script_path: PathBuf,
    /// From the first frame on, which gives the domain.
    script: Option<Script>,
}

impl<'a> Xballs<'a> {
    /// Begins the file.
    ///
    /// # Errors
    /// When a file of an earlier export is in the way, or it cannot be made.
    pub fn begin(output: &'a Output, choice: XballsChoice) -> Result<Self, ExportError> {
        let script_path = output.path("disp");
        output.claim(&script_path)?;
        Ok(Self {
            output,
            choice,
            file: output.begin(output.path("data"))?,
            bytes: Vec::new(),
            script_path,
            script: None,
        })
    }
}

impl Sink for Xballs<'_> {
    fn write(&mut self, snapshot: Snapshot) -> Result<(), ExportError> {
        let (output, choice) = (self.output, &self.choice);
        let dimensions = choice.dimensions.unwrap_or_else(|| snapshot.dimensions());
        let frame = data_frame(&snapshot, dimensions, &choice.info)?;
        self.script.get_or_insert_with(|| {
            let name = PathBuf::from(format!("{}.data", output.prefix));
            let mut script = Script::for_domain(name, dimensions, (frame.min, frame.max));
            if choice.info != Info::Material {
                // A scale of colours from the least to the largest value.
                script.colour_mode = 14;
            }
            script
        });
        self.bytes.clear();
        write_frame(&frame, choice.style, &mut self.bytes);
        Ok(self.file.append(&self.bytes)?)
    }

    fn finish(self: Box<Self>, _: &mut Outcome) -> Result<Vec<PathBuf>, ExportError> {
        let data = self.file.path().to_owned();
        self.file.finish()?;
        let path = self.script_path;
        if let Some(script) = self.script {
            self.output.write(&path, script.to_text().as_bytes())?;
            make_executable(&path)?;
        }
        Ok(vec![data, path])
    }
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

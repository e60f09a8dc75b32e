//! Mesh walls of a run as they are at each frame: text STL with all digits, in the frame in which the scene describes the wall, so that it can take
//! the place of the file there.

use std::fmt::Write as _;
use std::path::PathBuf;

use mercury_common::formats::mesh::TriangleMesh;
use mercury_common::frames::{WallReader, WearReader};
use mercury_common::surfaces::Surface;

use super::vtu::run_of;
use crate::beside;
use crate::{ExportError, Job, Outcome, Sink, Snapshot};

/// One file per frame and mesh wall.
pub struct Stl<'a> {
    job: &'a Job,
    walls: &'a WallReader,
    wear: Option<&'a WearReader>,
    /// Names of the walls that are meshes as parts of file names, by index.
    names: Vec<Option<String>>,
    files: Vec<PathBuf>,
    last: Option<f64>,
}

impl<'a> Stl<'a> {
    /// Looks at what there is.
    ///
    /// # Errors
    /// When the run has no mesh walls, or a table cannot be read.
    pub fn new(job: &'a Job) -> Result<Self, ExportError> {
        let help = "only a run of mercury-solve with a mesh among its walls, and frames = true in [output], has surfaces";
        let missing = || beside::missing(&job.source, "walls", "", help);
        let run = run_of(&job.source).ok_or_else(missing)?;
        let walls = run
            .walls("mercury-export stl needs it")?
            .ok_or_else(missing)?;
        let wear = run.wear("mercury-export stl needs it")?;
        let names = walls.header().walls.iter().zip(walls.surfaces());
        let names: Vec<Option<String>> = names
            .map(|(name, surface)| {
                let may_stand = |c: char| c.is_alphanumeric() || "-_.".contains(c);
                let part = |c: char| if may_stand(c) { c } else { '_' };
                matches!(surface, Surface::Mesh(_)).then(|| name.chars().map(part).collect())
            })
            .collect();
        if names.iter().all(Option::is_none) {
            let path = walls.frames().path().display();
            return Err(ExportError::Input(format!(
                "{path}: none of the walls is a mesh\nhelp: {help}"
            )));
        }
        Ok(Self {
            job,
            walls,
            wear,
            names,
            files: Vec::new(),
            last: None,
        })
    }
}

impl Sink for Stl<'_> {
    fn write(&mut self, snapshot: Snapshot) -> Result<(), ExportError> {
        self.last = Some(snapshot.frame.time);
        let step = snapshot.frame.step;
        let surfaces = match worn_at(self.wear, step)? {
            Some(wear) => wear.worn_surfaces(self.walls.surfaces()),
            None => self.walls.surfaces().to_vec(),
        };
        let meshes = self.names.iter().zip(&surfaces);
        for (name, surface) in meshes {
            let (Some(name), Surface::Mesh(mesh)) = (name, surface) else {
                continue;
            };
            let path = (self.job.output).path(&format!("{name}.{:04}.stl", snapshot.number));
            self.job
                .output
                .write(&path, text_stl(name, mesh).as_bytes())?;
            self.files.push(path);
        }
        Ok(())
    }

    fn finish(self: Box<Self>, outcome: &mut Outcome) -> Result<Vec<PathBuf>, ExportError> {
        let lost = "later surfaces are as they were at the start";
        let cut =
            (self.wear).and_then(|table| beside::cut(table.frames(), "wear", lost, self.last));
        outcome.warnings.extend(cut);
        Ok(self.files)
    }
}

/// What is worn at a step; none where nothing wears.
pub(super) fn worn_at(
    reader: Option<&WearReader>,
    step: u64,
) -> Result<Option<mercury_common::frames::WearFrame>, ExportError> {
    let Some(reader) = reader else {
        return Ok(None);
    };
    let number = reader.frames().infos().position(|info| info.step == step);
    Ok(number.map(|number| reader.frame(number)).transpose()?)
}

/// A mesh as text STL; numbers read back exactly.
fn text_stl(name: &str, mesh: &TriangleMesh) -> String {
    let mut text = format!("solid {name}\n");
    for triangle in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(triangle);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        // A String takes everything.
        let _ = write!(
            text,
            " facet normal {:e} {:e} {:e}\n  outer loop\n",
            normal.x, normal.y, normal.z
        );
        for corner in [a, b, c] {
            let _ = writeln!(
                text,
                "   vertex {:e} {:e} {:e}",
                corner.x, corner.y, corner.z
            );
        }
        text += "  endloop\n endfacet\n";
    }
    text + &format!("endsolid {name}\n")
}

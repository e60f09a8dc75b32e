//! Mesh walls of a run as they are at each frame: text STL with all digits, in the units and the frame of the mesh file of the scene, so that it can
//! take the place of that file there.

use std::fmt::Write as _;
use std::path::PathBuf;

use glam::{DQuat, DVec3};
use mercury_common::formats::mesh::TriangleMesh;
use mercury_common::frames::{WallReader, WearReader};
use mercury_common::surfaces::Surface;
use mercury_common::turns::about_axis;
use toml::Value;

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
    /// Placement of each wall's file by the scene.
    placed: Vec<Placed>,
    files: Vec<PathBuf>,
    last: Option<f64>,
    warnings: Vec<String>,
}

/// How a scene places a mesh file: scaled, then turned, then moved.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Placed {
    /// Length of a unit of the file, m.
    scale: f64,
    turn: Option<DQuat>,
    /// m
    offset: DVec3,
}

impl Placed {
    /// Placement of a file that lies as the scene has it.
    const SCENE: Self = Self {
        scale: 1.0,
        turn: None,
        offset: DVec3::ZERO,
    };

    /// Placement of a wall by `plan.toml`; none if it has none.
    fn of(wall: &Value) -> Option<Self> {
        let file = wall.get("file")?;
        let vector = |value: &Value| {
            let numbers: Vec<f64> = value
                .as_array()?
                .iter()
                .map(Value::as_float)
                .collect::<Option<_>>()?;
            (numbers.len() == 3).then(|| DVec3::from_slice(&numbers))
        };
        let turn = match file.get("rotate") {
            None => None,
            Some(turn) => {
                let axis = vector(turn.get("axis")?)?;
                let degrees = turn.get("degrees")?.as_float()?;
                Some(about_axis(axis.normalize(), degrees.to_radians()))
            }
        };
        let scale = file.get("scale")?.as_float()?;
        Some(Self {
            scale,
            turn,
            offset: vector(file.get("offset")?)?,
        })
        .filter(|placed| placed.scale > 0.0)
    }

    /// The coordinates in the file of a place in the frame of the scene.
    fn in_file(&self, place: DVec3) -> DVec3 {
        let turned = place - self.offset;
        let scaled = self.turn.map_or(turned, |turn| turn.conjugate() * turned);
        scaled / self.scale
    }
}

impl<'a> Stl<'a> {
    /// Looks at what there is. `scene_frame`: in metres and the frame of the scene, not in those of the mesh files.
    ///
    /// # Errors
    /// When the run has no mesh walls, or a table cannot be read.
    pub fn new(job: &'a Job, scene_frame: bool) -> Result<Self, ExportError> {
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
        let mut warnings = Vec::new();
        let placed = if scene_frame {
            vec![Placed::SCENE; names.len()]
        } else {
            placed(job, &walls.header().walls, &names, &mut warnings)
        };
        Ok(Self {
            job,
            walls,
            wear,
            names,
            placed,
            files: Vec::new(),
            last: None,
            warnings,
        })
    }
}

/// How the scene placed the file of each wall, by `plan.toml`. A wall that is not in it stays in the frame of the scene, with a
/// warning.
fn placed(
    job: &Job,
    walls: &[String],
    names: &[Option<String>],
    warnings: &mut Vec<String>,
) -> Vec<Placed> {
    let path = job.source.folder().join("plan.toml");
    let text = std::fs::read_to_string(&path).unwrap_or_default();
    let plan: toml::Table = text.parse().unwrap_or_default();
    let planned = plan.get("walls").and_then(Value::as_array);
    let of_wall = |(name, part): (&String, &Option<String>)| {
        let mut planned = planned.into_iter().flatten();
        let is_own = |wall: &&Value| wall.get("name").and_then(Value::as_str) == Some(name);
        let found = planned.find(is_own).and_then(Placed::of);
        if found.is_none() && part.is_some() {
            warnings.push(format!(
                "wall `{name}`: {} does not say how the scene placed its file; it is written in metres and the frame of the scene: use it without scale, rotate and offset",
                path.display()
            ));
        }
        found.unwrap_or(Placed::SCENE)
    };
    walls.iter().zip(names).map(of_wall).collect()
}

impl Sink for Stl<'_> {
    fn write(&mut self, snapshot: Snapshot) -> Result<(), ExportError> {
        self.last = Some(snapshot.frame.time);
        let step = snapshot.frame.step;
        let surfaces = match worn_at(self.wear, step)? {
            Some(wear) => wear.worn_surfaces(self.walls.surfaces()),
            None => self.walls.surfaces().to_vec(),
        };
        let meshes = self.names.iter().zip(&self.placed).zip(&surfaces);
        for ((name, placed), surface) in meshes {
            let (Some(name), Surface::Mesh(mesh)) = (name, surface) else {
                continue;
            };
            let mut mesh = mesh.clone();
            for vertex in &mut mesh.vertices {
                *vertex = placed.in_file(*vertex);
            }
            let path = (self.job.output).path(&format!("{name}.{:04}.stl", snapshot.number));
            self.job
                .output
                .write(&path, text_stl(name, &mesh).as_bytes())?;
            self.files.push(path);
        }
        Ok(())
    }

    fn finish(self: Box<Self>, outcome: &mut Outcome) -> Result<Vec<PathBuf>, ExportError> {
        let lost = "later surfaces are as they were at the start";
        let cut =
            (self.wear).and_then(|table| beside::cut(table.frames(), "wear", lost, self.last));
        outcome.warnings.extend(cut);
        outcome.warnings.extend(self.warnings);
        Ok(self.files)
    }
}

/// Worn depths at a step; none where nothing wears.
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Places of the file that the scene scales, turns and moves come back to where they were, to round-off of the largest coordinate.
    #[test]
    fn coordinates_of_the_file_come_back() {
        let wall = |keys: &str| -> Value {
            let table: toml::Table = format!("name = \"bars\"\n{keys}").parse().unwrap();
            Value::Table(table)
        };
        let file = "[file]\npath = \"bars.stl\"\nscale = 0.001\noffset = [0.5, -2.0, 3.0]\n";
        let turn = "[file.rotate]\naxis = [1.0, 2.0, -2.0]\ndegrees = 40.0\n";
        let placed = Placed::of(&wall(&format!("{file}{turn}"))).unwrap();
        // As the solver places it.
        let axis = DVec3::new(1.0, 2.0, -2.0) / 3.0;
        let turn = DQuat::from_axis_angle(axis, 40.0_f64.to_radians());
        for first in [DVec3::ZERO, DVec3::new(12.0, -7.0, 150.0)] {
            let in_scene = turn * (first * 0.001) + DVec3::new(0.5, -2.0, 3.0);
            let back = placed.in_file(in_scene);
            let round_off = 4.0 * f64::EPSILON * 3.0 / 0.001;
            assert!((back - first).length() < round_off, "{back}");
        }
        let unmoved = "[file]\npath = \"bars.stl\"\nscale = 1.0\noffset = [0.0, 0.0, 0.0]\n";
        assert_eq!(Placed::of(&wall(unmoved)), Some(Placed::SCENE));
        // Of an older run, or of a wall that is no mesh.
        assert_eq!(Placed::of(&wall("moves = false")), None);
    }
}

//! Native frames of a run.

use std::path::{Path, PathBuf};

use mercury_common::error::FormatError;
use mercury_common::frames::{
    BodyReader, BondReader, ContactReader, DropletReader, FrameReader, MembraneFrame,
    MembraneReader, MembraneTriangleFrame, MembraneTriangleReader, ParticleReader,
    TriangleLoadReader, WallReader, WearReader, WearTriangleReader,
};

use super::Item;
use super::tables::native;
use crate::FrameChoice;

/// `<prefix>.particles.arrow` and what lies beside it.
#[derive(Debug)]
pub struct RunSource {
    path: PathBuf,
    prefix: String,
    particles: ParticleReader,
    contacts: Beside<ContactReader>,
    bonds: Beside<BondReader>,
    walls: Beside<WallReader>,
    bodies: Beside<BodyReader>,
    /// Why the surfaces of clumps cannot be read, though the bodies can.
    surfaces: Option<FormatError>,
    triangle_loads: Beside<TriangleLoadReader>,
    wear: Beside<WearReader>,
    wear_triangles: Beside<WearTriangleReader>,
    droplets: Beside<DropletReader>,
    membranes: Beside<SheetTables>,
}

/// The tables of elastic sheets, whose frames belong together.
#[derive(Debug)]
pub(crate) struct SheetTables {
    /// Vertices.
    pub(crate) vertices: MembraneReader,
    /// Triangles.
    pub(crate) triangles: MembraneTriangleReader,
}

impl SheetTables {
    /// Both frames of a step, where both were written.
    pub(crate) fn at_step(
        &self,
        step: u64,
    ) -> Result<Option<(MembraneFrame, MembraneTriangleFrame)>, FormatError> {
        let of_step = |table: &FrameReader| table.infos().position(|info| info.step == step);
        let numbers = of_step(self.vertices.frames()).zip(of_step(self.triangles.frames()));
        let Some((vertices, triangles)) = numbers else {
            return Ok(None);
        };
        Ok(Some((
            self.vertices.frame(vertices)?,
            self.triangles.frame(triangles)?,
        )))
    }

    fn open(vertices: &Path, triangles: &Path) -> Result<Self, FormatError> {
        Ok(Self {
            vertices: MembraneReader::open(vertices)?,
            triangles: MembraneTriangleReader::open(triangles)?,
        })
    }
}

/// A table beside the particles: there or not, and what is wrong with it. A caller that does not need the table can ignore it.
type Beside<T> = Result<Option<T>, FormatError>;

impl RunSource {
    /// Opens the particles, and contacts, walls, the loads on their triangles, and bodies if they are there. Damage in the latter
    /// is reported on first use.
    ///
    /// # Errors
    /// When the particles cannot be opened or are something else.
    pub(super) fn open(path: &Path) -> Result<Self, FormatError> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let prefix = name.strip_suffix(".particles.arrow").unwrap_or(&name);
        let beside = |kind: &str| {
            let path = path.with_file_name(format!("{prefix}.{kind}.arrow"));
            path.exists().then_some(path)
        };
        let mut surfaces = None;
        let bodies = beside("bodies").map(|path| {
            BodyReader::open(&path).or_else(|error| {
                let alone = BodyReader::open_alone(&path)?;
                surfaces = Some(error);
                Ok(alone)
            })
        });
        Ok(Self {
            path: path.to_owned(),
            particles: ParticleReader::open(path)?,
            contacts: beside("contacts").map(ContactReader::open).transpose(),
            bonds: beside("bonds").map(BondReader::open).transpose(),
            walls: beside("walls").map(WallReader::open).transpose(),
            bodies: bodies.transpose(),
            surfaces,
            triangle_loads: beside("triangle_loads")
                .map(TriangleLoadReader::open)
                .transpose(),
            wear: beside("wear").map(WearReader::open).transpose(),
            wear_triangles: beside("wear_triangles")
                .map(WearTriangleReader::open)
                .transpose(),
            droplets: beside("droplets").map(DropletReader::open).transpose(),
            membranes: beside("membranes")
                .zip(beside("membrane_triangles"))
                .map(|(vertices, triangles)| SheetTables::open(&vertices, &triangles))
                .transpose(),
            prefix: prefix.to_owned(),
        })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    pub(super) fn prefix(&self) -> &str {
        &self.prefix
    }

    /// The number of whole frames.
    pub(crate) fn len(&self) -> usize {
        self.particles.frames().len()
    }

    /// The particles, by generic frames.
    pub(crate) fn particles(&self) -> &FrameReader {
        self.particles.frames()
    }

    pub(crate) fn contacts(&self, help: &str) -> Result<Option<&ContactReader>, FormatError> {
        there(&self.contacts, help)
    }

    /// Bonds that hold.
    pub(crate) fn bonds(&self, help: &str) -> Result<Option<&BondReader>, FormatError> {
        there(&self.bonds, help)
    }

    pub(crate) fn walls(&self, help: &str) -> Result<Option<&WallReader>, FormatError> {
        there(&self.walls, help)
    }

    /// The bodies, perhaps without the surfaces of their clumps.
    pub(crate) fn bodies(&self, help: &str) -> Result<Option<&BodyReader>, FormatError> {
        there(&self.bodies, help)
    }

    /// Makes sure that nothing is wrong with the surfaces of clumps.
    pub(crate) fn surfaces(&self, help: &str) -> Result<(), FormatError> {
        match &self.surfaces {
            Some(error) => Err(error.clone().with_more_help(help)),
            None => Ok(()),
        }
    }

    pub(crate) fn wear(&self, help: &str) -> Result<Option<&WearReader>, FormatError> {
        there(&self.wear, help)
    }

    /// Triangles of worn walls.
    pub(crate) fn wear_triangles(
        &self,
        help: &str,
    ) -> Result<Option<&WearTriangleReader>, FormatError> {
        there(&self.wear_triangles, help)
    }

    /// Droplets in flight.
    pub(crate) fn droplets(&self, help: &str) -> Result<Option<&DropletReader>, FormatError> {
        there(&self.droplets, help)
    }

    /// Elastic sheets.
    pub(crate) fn membranes(&self, help: &str) -> Result<Option<&SheetTables>, FormatError> {
        there(&self.membranes, help)
    }

    pub(crate) fn triangle_loads(
        &self,
        help: &str,
    ) -> Result<Option<&TriangleLoadReader>, FormatError> {
        there(&self.triangle_loads, help)
    }

    pub(super) fn frames(&self, choice: FrameChoice) -> impl Iterator<Item = Item> + Send + '_ {
        native(self.particles.frames(), self.particles.header(), choice)
    }
}

/// A table if it is there; `help`: how to do without it if it cannot be read.
fn there<'a, T>(table: &'a Beside<T>, help: &str) -> Result<Option<&'a T>, FormatError> {
    match table {
        Ok(table) => Ok(table.as_ref()),
        Err(error) => Err(error.clone().with_more_help(help)),
    }
}

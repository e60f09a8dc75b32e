//! Native frames of a run.

use std::path::{Path, PathBuf};

use mercury_common::error::FormatError;
use mercury_common::frames::{
    BodyReader, ContactReader, FrameReader, ParticleReader, TriangleLoadReader, WallReader,
};

use super::{Item, Snapshot};
use crate::FrameChoice;

/// `<prefix>.particles.arrow` and what lies beside it.
#[derive(Debug)]
pub struct RunSource {
    path: PathBuf,
    prefix: String,
    particles: ParticleReader,
    contacts: Option<ContactReader>,
    walls: Option<WallReader>,
    bodies: Option<BodyReader>,
    triangle_loads: Option<TriangleLoadReader>,
}

impl RunSource {
    /// Opens the particles, and contacts, walls, the loads on their triangles, and bodies if they are there.
    ///
    /// # Errors
    /// When one of the files cannot be opened or is something else.
    pub(super) fn open(path: &Path) -> Result<Self, FormatError> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let prefix = name.strip_suffix(".particles.arrow").unwrap_or(&name);
        let beside = |kind: &str| {
            let path = path.with_file_name(format!("{prefix}.{kind}.arrow"));
            path.exists().then_some(path)
        };
        Ok(Self {
            path: path.to_owned(),
            particles: ParticleReader::open(path)?,
            contacts: beside("contacts").map(ContactReader::open).transpose()?,
            walls: beside("walls").map(WallReader::open).transpose()?,
            bodies: beside("bodies").map(BodyReader::open).transpose()?,
            triangle_loads: beside("triangle_loads")
                .map(TriangleLoadReader::open)
                .transpose()?,
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

    pub(crate) fn contacts(&self) -> Option<&ContactReader> {
        self.contacts.as_ref()
    }

    pub(crate) fn walls(&self) -> Option<&WallReader> {
        self.walls.as_ref()
    }

    pub(crate) fn bodies(&self) -> Option<&BodyReader> {
        self.bodies.as_ref()
    }

    pub(crate) fn triangle_loads(&self) -> Option<&TriangleLoadReader> {
        self.triangle_loads.as_ref()
    }

    pub(super) fn frames(&self, choice: FrameChoice) -> impl Iterator<Item = Item> + Send + '_ {
        let frames = self.particles.frames();
        let first = match choice {
            FrameChoice::Last => frames.len().saturating_sub(1),
            _ => 0,
        };
        let chosen = (first..frames.len()).filter(move |&k| choice.has(k));
        let read = |number: usize| {
            Ok(Snapshot {
                path: self.path.clone(),
                number,
                specs: frames.schema().columns().to_vec(),
                frame: frames.frame(number)?,
                header: self.particles.header().clone(),
            })
        };
        chosen.map(read).chain(frames.damage().cloned().map(Err))
    }
}

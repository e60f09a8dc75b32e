//! Output of a run.

use std::ops::{Deref, DerefMut};
use std::path::PathBuf;

use glam::DVec3;
use mercury_common::formats::number::NumberStyle;
use mercury_common::scene::Switches;

use super::{FieldPlan, getters};
use mercury_engine::boundaries::{CountedRegion, FluxPlan};
use mercury_engine::tracks::Tracking;

/// Output of a run, and the names of its files.
#[derive(Debug, Clone)]
pub struct Outputs {
    pub(super) title: String,
    pub(super) prefix: String,
    pub(super) files: OutputPlan,
    pub(super) regions: Vec<CountedRegion>,
    pub(super) fluxes: Vec<FluxPlan>,
    pub(super) mesh_files: Vec<MeshFile>,
}

/// The file of a mesh wall, and how the scene places it: scaled, then turned about the origin of the file, then moved.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshFile {
    /// Index of the wall.
    pub wall: usize,
    /// The file, with its folder.
    pub path: PathBuf,
    /// Length of a unit of the file, m.
    pub scale: f64,
    /// Axis and angle in degrees.
    pub rotate: Option<(DVec3, f64)>,
    /// m
    pub offset: DVec3,
}

impl Outputs {
    getters! {
        /// Title of the scene.
        borrow title: str;
        /// Prefix of all output files: the stem of the scene file.
        borrow prefix: str;
        /// The files, and when they are written.
        borrow files: OutputPlan;
        /// Regions whose content is counted.
        borrow regions: [CountedRegion];
        /// Planes that count what crosses them.
        borrow fluxes: [FluxPlan];
        /// The files of mesh walls.
        borrow mesh_files: [MeshFile];
    }

    /// Whether any table has rows at [`OutputPlan::rows_interval`].
    #[must_use]
    pub fn has_rows(&self) -> bool {
        let files = &self.files;
        files.ene || files.walls || !(self.regions.is_empty() && self.fluxes.is_empty())
    }
}

/// Output files, and the times at which they are written.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputPlan {
    /// Files that are written; those that would stay empty are switched off. `plan.frames` is `plan.switches.frames`.
    pub switches: Switches,
    /// Time between frames, s.
    pub interval: f64,
    /// Time between rows of loads on walls, regions, fluxes and energies, s.
    pub rows_interval: f64,
    /// Time between contact frames, s.
    pub fstat_interval: f64,
    /// Time between files for ParaView, s.
    pub vtk_interval: f64,
    /// Simulated time between checkpoints, s; `None`: only by the clock and at the end.
    pub restart_interval: Option<f64>,
    /// Simulated time between links of the chain, s.
    pub link_interval: f64,
    /// Checkpoints at links that stay, at most.
    pub keep_checkpoints: u64,
    /// Rows of `.data`, which `.fstat` refers to, are pebbles instead of bodies.
    pub pebbles: bool,
    /// Particles and bodies to follow: name and id.
    pub track: Vec<(String, u32)>,
    /// Insertions whose grains are followed: name and index.
    pub track_insertions: Vec<(String, usize)>,
    /// Every n-th of these grains, from the first.
    pub track_every: u64,
    /// Time between rows of tracks, s.
    pub track_interval: f64,
    /// Fields of the continuum, each with a schedule of its own; at most [`MOST_FIELDS`](super::MOST_FIELDS).
    pub fields: Vec<FieldPlan>,
    /// Significant digits of `.data`, `.fstat` and `.ene`; `None` writes the shortest that read back exactly.
    pub digits: Option<u8>,
}

impl OutputPlan {
    /// Whether anything is followed.
    #[must_use]
    pub fn has_tracks(&self) -> bool {
        !(self.track.is_empty() && self.track_insertions.is_empty())
    }

    /// The names of the tracks, as the particles are marked with them: 1 stands for the first.
    #[must_use]
    pub fn track_names(&self) -> Vec<String> {
        let singles = self.track.iter().map(|(name, _)| name);
        let insertions = self.track_insertions.iter().map(|(name, _)| name);
        singles.chain(insertions).cloned().collect()
    }

    /// Particles that an engine has to follow for it.
    #[must_use]
    pub fn tracking(&self) -> Tracking {
        Tracking {
            particles: self.track.iter().map(|(_, id)| *id).collect(),
            insertions: self
                .track_insertions
                .iter()
                .map(|(_, index)| *index)
                .collect(),
            every: self.track_every,
        }
    }

    /// How `.data`, `.fstat` and `.ene` print numbers.
    #[must_use]
    pub fn number_style(&self) -> NumberStyle {
        self.digits
            .map_or(NumberStyle::Shortest, NumberStyle::Digits)
    }
}

impl Deref for OutputPlan {
    type Target = Switches;

    fn deref(&self) -> &Switches {
        &self.switches
    }
}

impl DerefMut for OutputPlan {
    fn deref_mut(&mut self) -> &mut Switches {
        &mut self.switches
    }
}

impl Default for OutputPlan {
    /// Nothing is written.
    fn default() -> Self {
        Self {
            switches: Switches::default(),
            interval: f64::INFINITY,
            rows_interval: f64::INFINITY,
            fstat_interval: f64::INFINITY,
            vtk_interval: f64::INFINITY,
            restart_interval: None,
            link_interval: f64::INFINITY,
            keep_checkpoints: 0,
            pebbles: false,
            track: Vec::new(),
            track_insertions: Vec::new(),
            track_every: 1,
            track_interval: f64::INFINITY,
            fields: Vec::new(),
            digits: None,
        }
    }
}

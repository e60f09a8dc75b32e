//! The expected size of a run's output on the disk, reported before the start.

use mercury_common::readable::bytes;

use super::{Expected, Plan, expected};
use mercury_engine::bonds::BondPlan;
use mercury_engine::contact::parameter::short;

/// Frames above which a run draws a warning: a film of 10,000 pictures lasts 7 minutes.
const MANY_FRAMES: f64 = 10_000.0;
/// Bytes above which it does.
const MANY_BYTES: f64 = 100e9;

/// Bytes of `plan.toml`, `summary.json`, `run.log` and the copy of the scene.
const PAPERS: f64 = 10e3;

/// Bytes of a row in each file, as they come out with the shortest digits: of scenes/settle.toml and scenes/bench/dense-2k.toml, rows of which some numbers are
/// zero being shorter in text.
mod row {
    /// A sphere in `.particles.arrow`.
    pub(super) const FRAME: f64 = 195.0;
    /// A sphere in `.data`.
    pub(super) const DATA: f64 = 205.0;
    /// A body in `.bodies.arrow`, beside its pebbles.
    pub(super) const BODY: f64 = 280.0;
    /// A sphere in the files for ParaView.
    pub(super) const VTK: f64 = 130.0;
    /// A contact in `.contacts.arrow`.
    pub(super) const CONTACT: f64 = 149.0;
    /// A contact in `.fstat`, which has a line for each of its partners.
    pub(super) const FSTAT: f64 = 500.0;
    /// A contact in the files for ParaView.
    pub(super) const VTK_CONTACT: f64 = 174.0;
    /// A row of `.ene`.
    pub(super) const ENE: f64 = 150.0;
    /// A wall in `.walls.csv`, and a wall's pose in `.walls.arrow`.
    pub(super) const WALL: f64 = 300.0;
    /// A material of a region or flux in its table.
    pub(super) const COUNTED: f64 = 120.0;
    /// A particle in `.track.csv`.
    pub(super) const TRACK: f64 = 360.0;
    /// A grain in `.left.csv`.
    pub(super) const LEFT: f64 = 190.0;
    /// A bond in `.bonds.arrow`: 16 numbers, three ids, and their validity.
    pub(super) const BOND: f64 = 150.0;
    /// A number of a table of fields: of scenes/profiles.toml, in text.
    pub(super) const FIELD: f64 = 17.0;
}

/// Number of frames of each kind in a run that goes on to its end, and the bytes of all of them once all particles are there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disk {
    /// Frames of particles.
    pub frames: f64,
    /// Rows of loads on walls, regions, fluxes and energies, each of a time.
    pub rows: f64,
    /// Frames of contacts.
    pub contact_frames: f64,
    /// Frames for ParaView.
    pub vtk_frames: f64,
    /// All files but checkpoints and pictures, bytes.
    pub bytes: f64,
}

impl Disk {
    /// Space for the run of a plan.
    #[must_use]
    pub fn of(plan: &Plan) -> Self {
        let (physics, files) = (plan.physics(), plan.outputs().files());
        let end = physics.steps as f64 * physics.time_step;
        // One at the start, and one at the end.
        let frames = |interval: f64, is_written: bool| match is_written {
            true => (end / interval - 1e-6).ceil().max(1.0) + 1.0,
            false => 0.0,
        };
        let particles = files.data || files.frames || files.ene || files.walls;
        let disk = Self {
            frames: frames(files.interval, particles),
            rows: frames(files.rows_interval, plan.outputs().has_rows()),
            contact_frames: frames(files.fstat_interval, files.fstat),
            vtk_frames: frames(files.vtk_interval, files.vtk),
            bytes: 0.0,
        };
        let Expected {
            bodies,
            spheres,
            touching,
            ..
        } = expected(plan);
        let of = |bytes: f64, is_written: bool| if is_written { bytes } else { 0.0 };
        let rows_of_data = if files.pebbles {
            spheres
        } else {
            spheres + bodies
        };
        let frame = of(row::FRAME * spheres + row::BODY * bodies, files.frames)
            + of(row::DATA * rows_of_data, files.data)
            + of(
                row::BOND * touching,
                files.bonds && physics.plans.get::<BondPlan>().is_some(),
            );
        let contacts = (row::CONTACT + row::FSTAT) * touching;
        let with_contacts = of(row::VTK_CONTACT * touching, files.fstat);
        let vtk = row::VTK * spheres + with_contacts;
        let bytes = disk.frames * frame + disk.contact_frames * contacts + disk.vtk_frames * vtk;
        let numbers: f64 = files.fields.iter().map(|table| table.numbers(end)).sum();
        let tables = plan.outputs().regions().len() + plan.outputs().fluxes().len();
        let of_each_row = of(row::ENE, files.ene)
            + of(row::WALL * physics.walls.len() as f64, files.walls)
            + row::COUNTED * tables as f64;
        let of_insertions = match files.track_insertions.is_empty() {
            true => 0.0,
            // As if all that are there came by these.
            false => (spheres + bodies) / files.track_every as f64,
        };
        let tracked = files.track.len() as f64 + of_insertions;
        // As if each passed once.
        let bytes = bytes + of(row::LEFT * (spheres + bodies), files.left);
        let bytes = bytes + row::TRACK * tracked * frames(files.track_interval, files.has_tracks());
        let bytes = bytes + row::FIELD * numbers + disk.rows * of_each_row + PAPERS;
        Self { bytes, ..disk }
    }

    /// The most frames of any kind.
    fn most_frames(&self) -> f64 {
        self.frames.max(self.contact_frames).max(self.vtk_frames)
    }

    /// The warning before the start of such a run, if one is needed.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        let is_much = self.most_frames() > MANY_FRAMES || self.bytes > MANY_BYTES;
        is_much.then(|| {
            format!(
                "output: {} frames, which take about {} on the disk; a larger output.interval (or fstat_interval, vtk_interval, that of [[fields]]) makes them fewer",
                short(self.most_frames()),
                bytes(self.bytes)
            )
        })
    }

    /// A line for each kind of frame: what it is, and how many come.
    pub(super) fn lines(&self, plan: &Plan) -> Vec<(&'static str, String)> {
        let files = plan.outputs().files();
        // With each frame comes a row.
        let rows = match files.rows_interval == files.interval {
            true => 0.0,
            false => self.rows,
        };
        let kinds = [
            ("frames", self.frames, files.interval),
            ("rows of tables", rows, files.rows_interval),
            (
                "frames of contacts",
                self.contact_frames,
                files.fstat_interval,
            ),
            ("frames for ParaView", self.vtk_frames, files.vtk_interval),
        ];
        let written = kinds.into_iter().filter(|(_, frames, _)| *frames > 0.0);
        let mut lines: Vec<_> = written
            .map(|(name, frames, interval)| {
                let every = format!("{}, every {} s", short(frames), short(interval));
                (name, every)
            })
            .collect();
        let size = format!(
            "about {}, once all particles are there; checkpoints besides",
            bytes(self.bytes)
        );
        lines.push(("on the disk", size));
        lines
    }
}

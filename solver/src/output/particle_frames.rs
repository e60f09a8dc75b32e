//! `<prefix>.particles.arrow`: the native frames of particles.

use mercury_common::frames::{
    ColumnSpec, FLAG_FIXED, FLAG_PRESCRIBED, FramesHeader, ParticleColumns, ParticleFrame,
    ParticleWriter, Table as _,
};
use mercury_common::particle_properties::{FILM_VOLUME, LIQUID_VOLUME};

use super::stream::{Beginning, Sink, Stream, StreamKind};
use super::{FrameCopy, OutputError};
use crate::plan::Plan;
use mercury_engine::state::{FIXED, PRESCRIBED, volume};

pub(super) struct ParticleFrames {
    writer: ParticleWriter,
    table: ParticleTable,
}

impl StreamKind for ParticleFrames {
    const NAME: &'static str = "particles.arrow";

    fn is_wanted(plan: &Plan) -> bool {
        plan.outputs().files().frames
    }

    fn begin(run: &Beginning<'_>) -> Result<Self, OutputError> {
        let plan = run.plan;
        let table = ParticleTable::new(plan);
        Ok(Self {
            writer: run.frames(Self::NAME, &table.columns)?,
            table,
        })
    }
}

/// Which columns the particles of a run have.
pub(super) struct ParticleTable {
    pub(super) columns: ParticleColumns,
    dimensions: u8,
}

impl ParticleTable {
    pub(super) fn new(plan: &Plan) -> Self {
        let columns = ParticleColumns {
            body: plan.physics().has_bodies(),
            orientation: plan.physics().orientations,
            angular_velocity: true,
            force: true,
            torque: plan.physics().laws.turns(),
            more: Vec::new(),
        };
        let has_liquid = plan.physics().has_property(&FILM_VOLUME);
        let liquid = has_liquid.then_some(&LIQUID_VOLUME);
        let properties = plan.physics().properties.iter().copied().chain(liquid);
        Self {
            columns: columns.with_properties(properties),
            dimensions: plan.physics().dimensions,
        }
    }
}

/// The columns of the frames of particles that a run of this plan writes.
#[must_use]
pub fn particle_columns(plan: &Plan) -> Vec<ColumnSpec> {
    ParticleFrame::specs(&ParticleTable::new(plan).columns)
}

/// The particles of a state in order of ids, and their columns.
pub(crate) fn particle_table(plan: &Plan, state: &FrameCopy) -> (Vec<ColumnSpec>, ParticleFrame) {
    let table = ParticleTable::new(plan);
    (ParticleFrame::specs(&table.columns), table.frame(state))
}

/// Facts about the run in files of frames.
pub(super) fn frames_header(plan: &Plan) -> FramesHeader {
    let materials = plan
        .physics()
        .materials
        .iter()
        .map(|material| material.name.clone());
    FramesHeader {
        title: plan.outputs().title().to_owned(),
        materials: materials.collect(),
        walls: plan
            .physics()
            .walls
            .iter()
            .map(|wall| wall.name.clone())
            .collect(),
        domain: Some(plan.physics().cell.corners()),
        periodic: plan.physics().cell.periodic(),
        dimensions: Some(plan.physics().dimensions),
        gravity: Some(plan.physics().gravity),
    }
}

impl Stream for ParticleFrames {
    fn write(&mut self, state: &FrameCopy) -> Result<(), OutputError> {
        if state.due.frame {
            self.writer.append(self.table.frame(state))?;
        }
        Ok(())
    }

    fn sink(&self) -> Sink<'_> {
        Sink::Frames(self.writer.frames())
    }
}

/// The flags that files of frames have.
pub(super) fn frame_flags(flags: u32) -> u8 {
    let bit = |mine, theirs| if flags & mine != 0 { theirs } else { 0 };
    bit(FIXED, FLAG_FIXED) | bit(PRESCRIBED, FLAG_PRESCRIBED)
}

impl ParticleTable {
    /// The particles of a state.
    pub(super) fn frame(&self, state: &FrameCopy) -> ParticleFrame {
        let particles = &state.particles;
        ParticleFrame {
            time: state.time,
            step: state.step,
            id: state.ids.clone(),
            material: particles.iter().map(|p| p.material.number()).collect(),
            flags: particles.iter().map(|p| frame_flags(p.flags)).collect(),
            mass: state.masses.clone(),
            volume: particles
                .iter()
                .enumerate()
                .map(|(rank, p)| match state.body(rank) {
                    None => volume(p.radius, self.dimensions),
                    // The share of the volume is that of the mass.
                    Some(body) => state.masses[rank] / body.mass * body.volume,
                })
                .collect(),
            radius: particles.iter().map(|p| p.radius).collect(),
            position: particles.iter().map(|p| p.position).collect(),
            velocity: particles.iter().map(|p| p.velocity).collect(),
            body: self.columns.body.then(|| {
                let ranks = 0..particles.len();
                ranks
                    .map(|rank| state.body(rank).map(|body| body.id.number()))
                    .collect()
            }),
            orientation: state.orientations.clone(),
            angular_velocity: Some(particles.iter().map(|p| p.angular_velocity).collect()),
            force: Some(state.loads.iter().map(|load| load.force).collect()),
            torque: self
                .columns
                .torque
                .then(|| state.loads.iter().map(|load| load.torque).collect()),
            more: state.properties.clone(),
        }
    }
}

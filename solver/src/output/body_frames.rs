//! `<prefix>.bodies.arrow`: the native frames of rigid bodies, and beside it the surfaces of their clumps.

use mercury_common::frames::{BodyFrame, BodyWriter, ClumpKind};

use super::particle_frames::frame_flags;
use super::stream::{Beginning, Sink, Stream, StreamKind};
use super::{FrameCopy, OutputError};
use crate::plan::Plan;

pub(super) struct BodyFrames {
    writer: BodyWriter,
    table: BodyTable,
}

impl StreamKind for BodyFrames {
    const NAME: &'static str = "bodies.arrow";

    fn is_wanted(plan: &Plan) -> bool {
        plan.outputs().files().frames && plan.physics().has_bodies()
    }

    fn begin(run: &Beginning<'_>) -> Result<Self, OutputError> {
        let plan = run.plan;
        let kinds = plan.physics().clumps.iter().map(|clump| ClumpKind {
            name: clump.name.clone(),
            surface: clump.surface.clone(),
        });
        let kinds: Vec<ClumpKind> = kinds.collect();
        Ok(Self {
            writer: run.frames(Self::NAME, &kinds)?,
            table: BodyTable::new(plan),
        })
    }
}

impl Stream for BodyFrames {
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

/// From states to tables of bodies.
pub(super) struct BodyTable {
    /// Circumscribed radius of each clump at scale 1, m.
    radii: Vec<f64>,
}

impl BodyTable {
    pub(super) fn new(plan: &Plan) -> Self {
        Self {
            radii: plan
                .physics()
                .clumps
                .iter()
                .map(|clump| clump.radius)
                .collect(),
        }
    }

    /// The bodies of a state, in the order of their ids.
    pub(super) fn frame(&self, state: &FrameCopy) -> BodyFrame {
        let bodies = || state.bodies.iter();
        BodyFrame {
            time: state.time,
            step: state.step,
            id: bodies().map(|body| body.id.number()).collect(),
            clump: bodies().map(|body| body.clump).collect(),
            material: bodies().map(|body| body.material.number()).collect(),
            flags: bodies().map(|body| frame_flags(body.flags)).collect(),
            mass: bodies().map(|body| body.mass).collect(),
            volume: bodies().map(|body| body.volume).collect(),
            scale: bodies()
                .map(|body| body.radius / self.radii[body.clump as usize])
                .collect(),
            radius: bodies().map(|body| body.radius).collect(),
            position: bodies().map(|body| body.position).collect(),
            velocity: bodies().map(|body| body.velocity).collect(),
            orientation: bodies().map(|body| body.orientation).collect(),
            angular_velocity: bodies().map(|body| body.angular_velocity).collect(),
            principal_moments: bodies().map(|body| body.moments).collect(),
            force: bodies().map(|body| body.load.force).collect(),
            torque: bodies().map(|body| body.load.torque).collect(),
        }
    }
}

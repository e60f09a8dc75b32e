//! `<prefix>.walls.arrow`: the surfaces of the walls, and their poses in each frame.

use mercury_common::frames::{WallFrame, WallWriter};
use mercury_common::surfaces::{Placement, Surface};

use super::stream::{Beginning, Sink, Stream, StreamKind};
use super::{FrameCopy, OutputError};
use crate::plan::Plan;

pub(super) struct WallFrames {
    writer: WallWriter,
}

impl StreamKind for WallFrames {
    const NAME: &'static str = "walls.arrow";

    fn is_wanted(plan: &Plan) -> bool {
        plan.outputs().files().frames && !plan.physics().walls.is_empty()
    }

    fn begin(run: &Beginning<'_>) -> Result<Self, OutputError> {
        let plan = run.plan;
        Ok(Self {
            writer: run.frames(Self::NAME, &surfaces(plan))?,
        })
    }
}

impl Stream for WallFrames {
    fn write(&mut self, state: &FrameCopy) -> Result<(), OutputError> {
        if state.due.frame {
            self.writer.append(wall_frame(state))?;
        }
        Ok(())
    }

    fn sink(&self) -> Sink<'_> {
        Sink::Frames(self.writer.frames())
    }
}

/// The surfaces of the walls, each in the frame in which the scene describes it.
pub(super) fn surfaces(plan: &Plan) -> Vec<Surface> {
    plan.physics()
        .walls
        .iter()
        .map(|wall| wall.shape.outline())
        .collect()
}

/// Where the walls stand.
pub(super) fn wall_frame(state: &FrameCopy) -> WallFrame {
    let (present, placement) = (state.walls.iter())
        .map(|wall| {
            let placement = Placement {
                rotation: wall.pose.rotation,
                translation: wall.pose.translation,
            };
            (wall.present, placement)
        })
        .unzip();
    WallFrame {
        time: state.time,
        step: state.step,
        present,
        placement,
    }
}

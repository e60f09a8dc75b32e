//! `<prefix>.walls.arrow`: the surfaces of the walls, and their poses in each frame.

use std::path::Path;

use mercury_common::frames::{WallFrame, WallWriter};
use mercury_common::surfaces::{Placement, Surface};

use super::particle_frames::frames_header;
use super::stream::{Begin, Sink, Stream, begin_frames};
use super::{OrderedFrame, OutputError};
use crate::plan::Plan;
use mercury_engine::walls::{Outline, Shape};

pub(super) struct WallFrames {
    writer: WallWriter,
}

impl WallFrames {
    pub(super) fn begin(folder: &Path, plan: &Plan, begin: Begin) -> Result<Self, OutputError> {
        let path = folder.join(format!("{}.walls.arrow", plan.outputs().prefix()));
        Ok(Self {
            writer: begin_frames(path, &frames_header(plan), &surfaces(plan), begin)?,
        })
    }
}

impl Stream for WallFrames {
    fn write(&mut self, state: &OrderedFrame) -> Result<(), OutputError> {
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
        .map(|wall| surface(&wall.shape))
        .collect()
}

/// Where the walls stand.
pub(super) fn wall_frame(state: &OrderedFrame) -> WallFrame {
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

fn surface(shape: &Shape) -> Surface {
    match shape.outline() {
        Outline::Plane { point, normal } => Surface::Plane { point, normal },
        Outline::Mesh { triangles, .. } => Surface::Mesh(triangles),
        Outline::Sphere { centre, radius } => Surface::Sphere { centre, radius },
        Outline::Turned {
            origin,
            direction,
            across,
            profile,
            endless,
        } => Surface::Turned {
            origin,
            direction,
            across,
            profile,
            endless,
        },
    }
}

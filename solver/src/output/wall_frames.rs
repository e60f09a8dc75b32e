//! `<prefix>.walls.arrow`: what the walls look like, and where they stand in each frame.

use std::path::Path;

use mercury_common::frames::{WallFrame, WallWriter};
use mercury_common::surfaces::{Placement, Surface};

use super::particle_frames::frames_header;
use super::stream::Stream;
use super::{OutputError, State};
use crate::plan::Plan;
use crate::walls::{Outline, Shape, Wall};

pub(super) struct WallFrames {
    writer: WallWriter,
    walls: StandingWalls,
}

impl WallFrames {
    pub(super) fn create(folder: &Path, plan: &Plan) -> Result<Self, OutputError> {
        let path = folder.join(format!("{}.walls.arrow", plan.prefix));
        let walls = StandingWalls::new(plan);
        Ok(Self {
            writer: WallWriter::create(path, &frames_header(plan), &walls.surfaces())?,
            walls,
        })
    }
}

impl Stream for WallFrames {
    fn write(&mut self, state: &State) -> Result<(), OutputError> {
        if state.frame {
            self.writer.append(&self.walls.frame(state))?;
        }
        Ok(())
    }
}

/// The walls of a run, which know by themselves where they stand at any time.
pub(super) struct StandingWalls {
    walls: Vec<Wall>,
    time_step: f64,
}

impl StandingWalls {
    pub(super) fn new(plan: &Plan) -> Self {
        Self {
            walls: plan.walls.clone(),
            time_step: plan.time_step,
        }
    }

    /// What they look like, each in the frame in which the scene describes it.
    pub(super) fn surfaces(&self) -> Vec<Surface> {
        self.walls.iter().map(|wall| surface(&wall.shape)).collect()
    }

    /// Where they stand.
    pub(super) fn frame(&self, state: &State) -> WallFrame {
        let states = self
            .walls
            .iter()
            .map(|wall| wall.state(state.time, self.time_step));
        let (present, placement) = states
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

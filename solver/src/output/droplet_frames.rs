//! `<prefix>.droplets.arrow`: droplets in flight.

use std::path::Path;

use mercury_common::frames::{DropletFrame, DropletWriter};

use super::particle_frames::frames_header;
use super::stream::{Begin, Sink, Stream, begin_frames};
use super::{OrderedFrame, OutputError};
use crate::plan::Plan;

/// A frame for each output interval.
pub(super) struct DropletFrames {
    writer: DropletWriter,
}

impl DropletFrames {
    pub(super) fn begin(folder: &Path, plan: &Plan, begin: Begin) -> Result<Self, OutputError> {
        let path = folder.join(format!("{}.droplets.arrow", plan.outputs().prefix()));
        Ok(Self {
            writer: begin_frames(path, &frames_header(plan), &(), begin)?,
        })
    }
}

impl Stream for DropletFrames {
    fn write(&mut self, state: &OrderedFrame) -> Result<(), OutputError> {
        if !state.due.frame {
            return Ok(());
        }
        let droplets = &state.droplets;
        self.writer.append(DropletFrame {
            time: state.time,
            step: state.step,
            id: droplets.iter().map(|droplet| droplet.id as u32).collect(),
            spray: droplets.iter().map(|droplet| droplet.nozzle).collect(),
            position: droplets.iter().map(|droplet| droplet.position).collect(),
            velocity: droplets.iter().map(|droplet| droplet.velocity).collect(),
            radius: droplets.iter().map(|droplet| droplet.radius).collect(),
        })?;
        Ok(())
    }

    fn sink(&self) -> Sink<'_> {
        Sink::Frames(self.writer.frames())
    }
}

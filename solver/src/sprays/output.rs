//! `<prefix>.droplets.arrow`: droplets in flight.

use mercury_common::frames::{DropletFrame, DropletWriter};

use crate::output::stream::{Beginning, Sink, Stream, StreamKind};
use crate::output::{FrameCopy, OutputError};
use crate::plan::Plan;
use mercury_engine::spray::SprayPlan;

/// A frame for each output interval.
pub(crate) struct DropletFrames {
    writer: DropletWriter,
}

impl StreamKind for DropletFrames {
    const NAME: &'static str = "droplets.arrow";

    fn is_wanted(plan: &Plan) -> bool {
        let files = plan.outputs().files();
        files.frames && files.droplets && plan.physics().plans.get::<SprayPlan>().is_some()
    }

    fn begin(run: &Beginning<'_>) -> Result<Self, OutputError> {
        Ok(Self {
            writer: run.frames(Self::NAME, &())?,
        })
    }
}

impl Stream for DropletFrames {
    fn write(&mut self, state: &FrameCopy) -> Result<(), OutputError> {
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

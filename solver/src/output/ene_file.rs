//! `<prefix>.ene`: the energies in MercuryDPM's layout.

use glam::DVec3;
use mercury_common::formats::ene::{write_header, write_row};
use mercury_common::formats::number::NumberStyle;

use super::stream::{Beginning, Sink, Stream, StreamKind, TextFile};
use super::{FrameCopy, OutputError, energies};
use crate::plan::Plan;

pub(super) struct EneFile {
    file: TextFile,
    style: NumberStyle,
    gravity: DVec3,
    dimensions: u8,
}

impl StreamKind for EneFile {
    const NAME: &'static str = "ene";

    fn is_wanted(plan: &Plan) -> bool {
        plan.outputs().files().ene
    }

    fn begin(run: &Beginning<'_>) -> Result<Self, OutputError> {
        let plan = run.plan;
        let style = plan.outputs().files().number_style();
        let mut head = Vec::new();
        write_header(style, &mut head);
        let file = run.text(Self::NAME, &head)?;
        Ok(Self {
            file,
            style,
            gravity: plan.physics().gravity,
            dimensions: plan.physics().dimensions,
        })
    }
}

impl Stream for EneFile {
    fn write(&mut self, state: &FrameCopy) -> Result<(), OutputError> {
        if !state.due.rows {
            return Ok(());
        }
        let row = energies(state, self.gravity, self.dimensions);
        write_row(&row, self.style, &mut self.file.buffer);
        self.file.flush()
    }

    fn sink(&self) -> Sink<'_> {
        Sink::Text(&self.file)
    }
}

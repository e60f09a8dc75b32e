//! `<prefix>.ene`: the energies in MercuryDPM's layout.

use std::path::Path;

use glam::DVec3;
use mercury_common::formats::ene::{write_header, write_row};
use mercury_common::formats::number::NumberStyle;

use super::stream::{Begin, Sink, Stream, TextFile};
use super::{OrderedFrame, OutputError, energies};
use crate::plan::Plan;

pub(super) struct EneFile {
    file: TextFile,
    style: NumberStyle,
    gravity: DVec3,
    dimensions: u8,
}

impl EneFile {
    pub(super) fn begin(folder: &Path, plan: &Plan, begin: Begin) -> Result<Self, OutputError> {
        let style = plan.outputs().files().number_style();
        let mut head = Vec::new();
        write_header(style, &mut head);
        let name = format!("{}.ene", plan.outputs().prefix());
        let file = TextFile::begin(folder, &name, &head, begin)?;
        Ok(Self {
            file,
            style,
            gravity: plan.physics().gravity,
            dimensions: plan.physics().dimensions,
        })
    }
}

impl Stream for EneFile {
    fn write(&mut self, state: &OrderedFrame) -> Result<(), OutputError> {
        if !state.due.frame {
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

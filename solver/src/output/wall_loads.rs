//! `<prefix>.walls.csv`: force and torque of the particles on each wall, and the power of the wall.

use std::path::Path;

use mercury_common::formats::number::{NumberStyle, push_number};

use super::stream::{Begin, Stream, TextFile, push_csv_name};
use super::{OutputError, State};
use crate::plan::Plan;

pub(super) struct WallLoads {
    file: TextFile,
    names: Vec<String>,
}

impl WallLoads {
    pub(super) fn begin(folder: &Path, plan: &Plan, begin: Begin) -> Result<Self, OutputError> {
        let name = format!("{}.walls.csv", plan.outputs().prefix());
        let head = b"time,name,fx,fy,fz,tx,ty,tz,power\n";
        let file = TextFile::begin(folder, &name, head, begin)?;
        Ok(Self {
            file,
            names: plan
                .physics()
                .walls()
                .iter()
                .map(|wall| wall.name.clone())
                .collect(),
        })
    }
}

impl Stream for WallLoads {
    fn write(&mut self, state: &State) -> Result<(), OutputError> {
        if !state.due.frame {
            return Ok(());
        }
        let out = &mut self.file.buffer;
        for (name, (load, power)) in self.names.iter().zip(&state.observation.walls) {
            push_number(out, state.time, NumberStyle::Shortest);
            out.push(b',');
            push_csv_name(out, name);
            let (f, t) = (load.force, load.torque);
            for value in [f.x, f.y, f.z, t.x, t.y, t.z, *power] {
                out.push(b',');
                push_number(out, value, NumberStyle::Shortest);
            }
            out.push(b'\n');
        }
        self.file.flush()
    }

    fn position(&self) -> u64 {
        self.file.position()
    }

    fn sync(&self) -> Result<(), OutputError> {
        self.file.sync()
    }
}

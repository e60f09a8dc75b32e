//! `<prefix>.left.csv`: the grains that left or crossed a plane, one by one.

use mercury_common::formats::number::{NumberStyle, push_integer, push_number};
use mercury_common::formats::table_head::TableColumn;
use mercury_common::surfaces::FACES;

use super::stream::{Beginning, Sink, Stream, StreamKind, TIME, TextFile, push_csv_name};
use super::{OrderedFrame, OutputError};
use crate::plan::Plan;
use mercury_engine::boundaries::{Gate, Passage};

/// A row for each grain.
pub(super) struct PassageFile {
    file: TextFile,
    planes: Vec<String>,
    regions: Vec<String>,
    materials: Vec<String>,
    clumps: Vec<String>,
}

/// Columns of values.
const COLUMNS: &[TableColumn] = &[
    ("at", ""),
    ("name", ""),
    ("direction", "1"),
    ("id", ""),
    ("clump", ""),
    ("material", ""),
    ("diameter", "m"),
    ("x", "m"),
    ("y", "m"),
    ("z", "m"),
    ("vx", "m/s"),
    ("vy", "m/s"),
    ("vz", "m/s"),
];

impl StreamKind for PassageFile {
    const NAME: &'static str = "left.csv";

    fn is_wanted(plan: &Plan) -> bool {
        plan.outputs().files().left
    }

    fn begin(run: &Beginning<'_>) -> Result<Self, OutputError> {
        let (physics, outputs) = (run.plan.physics(), run.plan.outputs());
        Ok(Self {
            file: run.table(Self::NAME, &[TIME], COLUMNS)?,
            planes: (outputs.fluxes().iter())
                .map(|plane| plane.name.clone())
                .collect(),
            regions: (physics.deletions.iter())
                .map(|region| region.name.clone())
                .collect(),
            materials: (physics.materials.iter())
                .map(|material| material.name.clone())
                .collect(),
            clumps: (physics.clumps.iter())
                .map(|clump| clump.name.clone())
                .collect(),
        })
    }
}

impl PassageFile {
    fn push(&mut self, passage: &Passage) {
        let named = |names: &[String], index: u32| -> String {
            names.get(index as usize).cloned().unwrap_or_default()
        };
        let (at, name, direction) = match passage.gate {
            Gate::Plane { index, forward } => {
                let direction = if forward { 1 } else { -1 };
                ("plane", named(&self.planes, index), direction)
            }
            Gate::Region(index) => ("region", named(&self.regions, index), 1),
            Gate::Face(index) => ("face", FACES[index as usize % FACES.len()].to_owned(), 1),
        };
        let clump = passage
            .clump
            .map_or_else(String::new, |index| named(&self.clumps, index));
        let material = named(&self.materials, passage.material);
        let out = &mut self.file.buffer;
        push_number(out, passage.time, NumberStyle::Shortest);
        out.extend_from_slice(format!(",{at},").as_bytes());
        push_csv_name(out, &name);
        out.extend_from_slice(format!(",{direction},").as_bytes());
        push_integer(out, i64::from(passage.id));
        for name in [&clump, &material] {
            out.push(b',');
            push_csv_name(out, name);
        }
        let (x, v) = (passage.position, passage.velocity);
        for value in [passage.diameter, x.x, x.y, x.z, v.x, v.y, v.z] {
            out.push(b',');
            push_number(out, value, NumberStyle::Shortest);
        }
        out.push(b'\n');
    }
}

impl Stream for PassageFile {
    fn write(&mut self, state: &OrderedFrame) -> Result<(), OutputError> {
        for passage in &state.passages {
            self.push(passage);
        }
        self.file.flush()
    }

    fn sink(&self) -> Sink<'_> {
        Sink::Text(&self.file)
    }
}

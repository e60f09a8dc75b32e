//! `<prefix>.flux.csv`: the particles that crossed each flux plane since the last row, material by material.

use mercury_common::formats::number::{NumberStyle, push_integer, push_number};
use mercury_common::formats::table_head::TableColumn;

use super::region_counts::materials;
use super::stream::{
    Beginning, MATERIAL, NAME, Sink, Stream, StreamKind, TIME, TextFile, push_csv_name,
};
use super::{OrderedFrame, OutputError};
use crate::plan::Plan;
use mercury_engine::state::MaterialIndex;

/// Columns of values of `.flux.csv`.
pub const COLUMNS: &[TableColumn] = &[
    ("forward", "1"),
    ("backward", "1"),
    ("mass", "kg"),
    ("volume", "m3"),
    ("px", "kg m/s"),
    ("py", "kg m/s"),
    ("pz", "kg m/s"),
    ("d10", "m"),
    ("d32", "m"),
    ("d43", "m"),
];

pub(super) struct FluxCounts {
    file: TextFile,
    planes: Vec<String>,
    /// Index and name of every material of present and inserted particles, ascending.
    materials: Vec<(MaterialIndex, String)>,
    /// Materials of the plan.
    columns: usize,
}

impl StreamKind for FluxCounts {
    const NAME: &'static str = "flux.csv";

    fn is_wanted(plan: &Plan) -> bool {
        !plan.outputs().fluxes().is_empty()
    }

    fn begin(run: &Beginning<'_>) -> Result<Self, OutputError> {
        let plan = run.plan;
        let file = run.table(Self::NAME, &[TIME, NAME, MATERIAL], COLUMNS)?;
        let planes = plan.outputs().fluxes().iter();
        Ok(Self {
            file,
            planes: planes.map(|plane| plane.name.clone()).collect(),
            materials: materials(plan),
            columns: plan.physics().materials.len(),
        })
    }
}

impl Stream for FluxCounts {
    fn write(&mut self, state: &OrderedFrame) -> Result<(), OutputError> {
        if !state.due.frame {
            return Ok(());
        }
        let out = &mut self.file.buffer;
        let by_plane = state.crossed.chunks_exact(self.columns.max(1));
        for (plane, crossed) in self.planes.iter().zip(by_plane) {
            for (material, name) in &self.materials {
                let crossed = &crossed[material.index()];
                push_number(out, state.time, NumberStyle::Shortest);
                out.push(b',');
                push_csv_name(out, plane);
                out.push(b',');
                push_csv_name(out, name);
                for number in [crossed.forward, crossed.backward] {
                    out.push(b',');
                    push_integer(out, number as i64);
                }
                let p = crossed.momentum;
                for value in [
                    crossed.mass,
                    crossed.volume,
                    p.x,
                    p.y,
                    p.z,
                    crossed.mean_diameter(1),
                    crossed.mean_diameter(3),
                    crossed.mean_diameter(4),
                ] {
                    out.push(b',');
                    push_number(out, value, NumberStyle::Shortest);
                }
                out.push(b'\n');
            }
        }
        self.file.flush()
    }

    fn sink(&self) -> Sink<'_> {
        Sink::Text(&self.file)
    }
}

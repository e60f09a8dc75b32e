//! The memory that outputs take.

use mercury_common::frames::{
    BondFrame, BondNames, ColumnKind, MembraneFrame, MembraneTriangleFrame, ParticleFrame, Table,
};

use super::particle_frames::ParticleTable;
use crate::plan::{Expected, FieldPlan, Plan};
use mercury_engine::bonds::{Bond, BondPlan};
use mercury_engine::contact::HistoryNumber;
use mercury_engine::forces::ContactRecord;
use mercury_engine::membrane::MembranePlan;
use mercury_engine::memory::GROWTH;
use mercury_engine::state::{Bodies, Particles};

/// Characters of a number in a text file, its separator among them.
const TEXT: f64 = 20.0;
/// Numbers in a line of `.data` and of `.fstat`.
const NUMBERS: [f64; 2] = [14.0, 16.0];

/// Bytes of a particle and of a contact as coarse-graining takes them.
const FIELD_ROWS: [f64; 2] = [137.0, 170.0];

/// Bytes that outputs take.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct OutputBytes {
    /// From the first output on: the last state that was written, and texts, whose memory is used again.
    pub kept: f64,
    /// While files are written, beside what is kept.
    pub writing: f64,
}

/// The memory of a run's outputs when the run is as large as expected. `history`: the length of a contact's history.
///
/// The writer is taken to keep up: up to four more states may wait for a slow disk. Pictures are made when the run is over, and not
/// counted.
#[must_use]
pub fn output_bytes(plan: &Plan, expected: &Expected, history: &[HistoryNumber]) -> OutputBytes {
    let output = plan.outputs().files();
    let rows = expected.spheres;
    let touching = expected.touching;
    let mut kept = rows * state_bytes(plan);
    if expected.bodies > 0.0 {
        kept += Bodies::bytes(expected.bodies, expected.pebbles, rows);
    }
    // A state is sorted column by column; then the frame takes its own columns, which are encoded as a whole.
    let mut writing = 0.0f64;
    let columns = row_bytes::<ParticleFrame>(&ParticleTable::new(plan).columns);
    if output.frames || output.vtk || !output.fields.is_empty() {
        writing = writing.max(2.0 * rows * columns);
    }
    let sheets: f64 = plan.physics().plans.all().iter().map(sheet_bytes).sum();
    kept += GROWTH * sheets;
    writing += sheets;
    if output.data {
        kept += GROWTH * rows * NUMBERS[0] * TEXT;
        writing = writing.max(rows * NUMBERS[0] * 8.0);
    }
    let of_contacts = output.fields.iter().any(FieldPlan::needs_contacts);
    if output.fstat || output.vtk || of_contacts {
        let records = touching * ContactRecord::bytes(history.len()) as f64;
        // Once in the loop's blocks, which the writer's frame follows.
        writing += GROWTH * records + records;
    }
    if output.fstat {
        kept += GROWTH * 2.0 * touching * NUMBERS[1] * TEXT;
        writing += 2.0 * touching * NUMBERS[1] * 8.0;
    }
    if plan.physics().plans.get::<BondPlan>().is_some() {
        // As many as touches, as the engine estimates.
        kept += GROWTH * touching * size_of::<Bond>() as f64;
        if output.frames && output.bonds || output.vtk {
            writing += 2.0 * touching * row_bytes::<BondFrame>(&BondNames::default());
        }
    }
    if !output.fields.is_empty() {
        // The frames as coarse-graining takes them: lists of particles and of contacts, and tables of where each is.
        let grains = expected.particles + expected.bodies;
        let touching = if of_contacts { touching } else { 0.0 };
        let states = rows * 40.0 + grains * FIELD_ROWS[0] + touching * FIELD_ROWS[1];
        let end = plan.physics().steps as f64 * plan.physics().time_step;
        let mut spreading = 0.0f64;
        for fields in &output.fields {
            let looks = fields.looks(end);
            let all = fields.analysis.bytes(grains, touching, looks);
            // Memory of the analysis is kept, memory of a sample is used for one table after the other.
            let look = fields.analysis.bytes(grains, touching, 0.0);
            kept += all - look;
            spreading = spreading.max(look);
        }
        writing += states + spreading;
    }
    OutputBytes { kept, writing }
}

/// Bytes of a row in a state as it is written.
fn state_bytes(plan: &Plan) -> f64 {
    // Its rank, but not where it was listed.
    let row = Particles::bytes_per_row(plan.physics().orientations) + size_of::<u32>();
    (row - size_of::<glam::DVec3>()) as f64
}

/// Bytes of the tables of a sheet.
fn sheet_bytes(MembranePlan { surface, .. }: &MembranePlan) -> f64 {
    surface.vertices.len() as f64 * row_bytes::<MembraneFrame>(&())
        + surface.triangles.len() as f64 * row_bytes::<MembraneTriangleFrame>(&())
}

/// Bytes of a row of a table.
fn row_bytes<T: Table>(layout: &T::Layout) -> f64 {
    let columns = T::specs(layout);
    let bytes: usize = columns.iter().map(|column| bytes(column.kind)).sum();
    bytes as f64
}

fn bytes(kind: ColumnKind) -> usize {
    match kind {
        ColumnKind::U8 => 1,
        ColumnKind::I32 | ColumnKind::U32 | ColumnKind::OptionalU32 => 4,
        ColumnKind::U64 | ColumnKind::F64 | ColumnKind::Text => 8,
    }
}

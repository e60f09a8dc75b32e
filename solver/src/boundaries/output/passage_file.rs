//! `<prefix>.left.csv`: the grains that left or crossed a plane, one by one.

use mercury_common::run_tables::{LEFT, TableSpec};
use mercury_common::surfaces::FACES;

use crate::output::table_file::{Rows, RunTable};
use crate::output::{Due, FrameCopy};
use crate::plan::Plan;
use mercury_engine::boundaries::Gate;

/// A row for each grain.
pub(crate) struct PassageFile {
    planes: Vec<String>,
    regions: Vec<String>,
    materials: Vec<String>,
    clumps: Vec<String>,
}

/// The name of an index; empty where there is none.
fn named(names: &[String], index: u32) -> &str {
    names.get(index as usize).map_or("", String::as_str)
}

impl RunTable for PassageFile {
    const SPEC: &'static TableSpec = &LEFT;

    fn is_wanted(plan: &Plan) -> bool {
        plan.outputs().files().left
    }

    fn new(plan: &Plan) -> Self {
        let (physics, outputs) = (plan.physics(), plan.outputs());
        Self {
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
        }
    }

    /// There are none but where a frame is due.
    fn is_due(_: Due) -> bool {
        true
    }

    fn push_rows(&self, state: &FrameCopy, rows: &mut Rows<'_>) {
        for passage in &state.passages {
            let (at, name, direction) = match passage.gate {
                Gate::Plane { index, forward } => {
                    let direction = if forward { 1 } else { -1 };
                    ("plane", named(&self.planes, index), direction)
                }
                Gate::Region(index) => ("region", named(&self.regions, index), 1),
                Gate::Face(index) => ("face", FACES[index as usize % FACES.len()], 1),
            };
            let clump = passage.clump.map_or("", |index| named(&self.clumps, index));
            rows.number(passage.time).text(at).text(name);
            rows.whole(direction).whole(i64::from(passage.id));
            rows.text(clump)
                .text(named(&self.materials, passage.material));
            rows.number(passage.diameter);
            rows.numbers(passage.position.to_array());
            rows.numbers(passage.velocity.to_array()).end();
        }
    }
}

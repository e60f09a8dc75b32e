//! `<prefix>.flux.csv`: the particles that crossed each flux plane since the last row, material by material.

use mercury_common::run_tables::{FLUX, TableSpec};

use super::region_counts::materials;
use crate::output::table_file::{Rows, RunTable};
use crate::output::{Due, FrameCopy};
use crate::plan::Plan;
use mercury_engine::state::MaterialIndex;

/// A row for each plane, each material and each time of rows.
pub(crate) struct FluxCounts {
    planes: Vec<String>,
    /// Index and name of every material of present and inserted particles, ascending.
    materials: Vec<(MaterialIndex, String)>,
    /// Materials of the plan.
    columns: usize,
}

impl RunTable for FluxCounts {
    const SPEC: &'static TableSpec = &FLUX;

    fn is_wanted(plan: &Plan) -> bool {
        !plan.outputs().fluxes().is_empty()
    }

    fn new(plan: &Plan) -> Self {
        let planes = plan.outputs().fluxes().iter();
        Self {
            planes: planes.map(|plane| plane.name.clone()).collect(),
            materials: materials(plan),
            columns: plan.physics().materials.len(),
        }
    }

    fn is_due(due: Due) -> bool {
        due.rows
    }

    fn push_rows(&self, state: &FrameCopy, rows: &mut Rows<'_>) {
        let by_plane = state.crossed.chunks_exact(self.columns.max(1));
        for (plane, crossed) in self.planes.iter().zip(by_plane) {
            for (material, name) in &self.materials {
                let crossed = &crossed[material.index()];
                rows.number(state.time).text(plane).text(name);
                rows.counts([crossed.forward, crossed.backward]);
                rows.numbers([crossed.mass, crossed.volume]);
                rows.numbers(crossed.momentum.to_array());
                rows.numbers([1, 3, 4].map(|order| crossed.mean_diameter(order)))
                    .end();
            }
        }
    }
}

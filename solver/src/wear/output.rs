//! `<prefix>.wear.csv`, `<prefix>.wear.arrow`, `<prefix>.wear_triangles.arrow`: the volumes owed and removed by wear, in all, by
//! vertices and by triangles.

use mercury_common::frames::{WearFrame, WearTriangleFrame, WearTriangleWriter, WearWriter};
use mercury_common::run_tables::{TableSpec, WEAR};

use crate::output::stream::{Beginning, Sink, Stream, StreamKind};
use crate::output::table_file::{Rows, RunTable};
use crate::output::{FrameCopy, OutputError};
use crate::plan::Plan;
use mercury_engine::wear::{Wear, WearPlan, WearRow};

/// Worn walls at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct WearState {
    /// Index of each wall that wears, and its numbers.
    pub rows: Vec<(usize, WearRow)>,
    /// Worn vertices.
    pub vertices: WearFrame,
    /// Worn triangles.
    pub triangles: WearTriangleFrame,
}

impl WearState {
    /// Of walls at a time (s) after so many steps.
    #[must_use]
    pub fn new(wear: &Wear, (time, step): (f64, u64)) -> Self {
        let mut vertices = WearFrame {
            time,
            step,
            ..WearFrame::default()
        };
        let mut triangles = WearTriangleFrame {
            time,
            step,
            ..WearTriangleFrame::default()
        };
        for worn in &wear.walls {
            let wall = worn.plan().wall as u32;
            for vertex in worn.vertices() {
                vertices.wall.push(wall);
                vertices.vertex.push(vertex.vertex);
                vertices.first.push(vertex.first);
                vertices.displacement.push(vertex.displacement);
                vertices.depth.push(vertex.depth);
                vertices.owed.push(vertex.owed);
            }
            for (triangle, owed, removed) in worn.triangles() {
                triangles.wall.push(wall);
                triangles.triangle.push(triangle);
                triangles.owed.push(owed);
                triangles.removed.push(removed);
            }
        }
        let row = |worn: &mercury_engine::wear::Worn| (worn.plan().wall, worn.row());
        Self {
            rows: wear.walls.iter().map(row).collect(),
            vertices,
            triangles,
        }
    }
}

/// A row for each wall that wears and each output interval.
pub(crate) struct WearCsv {
    names: Vec<String>,
}

impl RunTable for WearCsv {
    const SPEC: &'static TableSpec = &WEAR;

    fn is_wanted(plan: &Plan) -> bool {
        plan.physics().plans.get::<WearPlan>().is_some()
    }

    fn new(plan: &Plan) -> Self {
        let walls = plan.physics().walls.iter();
        Self {
            names: walls.map(|wall| wall.name.clone()).collect(),
        }
    }

    fn push_rows(&self, state: &FrameCopy, rows: &mut Rows<'_>) {
        for (wall, row) in state.wear.iter().flat_map(|wear| &wear.rows) {
            rows.number(state.time).text(&self.names[*wall]);
            rows.numbers([row.owed, row.removed, row.pending]);
            rows.numbers([row.front, row.back, row.max_depth]);
            rows.numbers(row.place.to_array());
            rows.counts([row.moves, row.blocked]).end();
        }
    }
}

pub(crate) struct WearFrames {
    writer: WearWriter,
}

impl StreamKind for WearFrames {
    const NAME: &'static str = "wear.arrow";

    fn is_wanted(plan: &Plan) -> bool {
        plan.outputs().files().frames && plan.physics().plans.get::<WearPlan>().is_some()
    }

    fn begin(run: &Beginning<'_>) -> Result<Self, OutputError> {
        let writer = run.frames(Self::NAME, &())?;
        Ok(Self { writer })
    }
}

impl Stream for WearFrames {
    fn write(&mut self, state: &FrameCopy) -> Result<(), OutputError> {
        if let (Some(wear), true) = (&state.wear, state.due.frame) {
            self.writer.append(wear.vertices.clone())?;
        }
        Ok(())
    }

    fn sink(&self) -> Sink<'_> {
        Sink::Frames(self.writer.frames())
    }
}

pub(crate) struct WearTriangles {
    writer: WearTriangleWriter,
}

impl StreamKind for WearTriangles {
    const NAME: &'static str = "wear_triangles.arrow";

    fn is_wanted(plan: &Plan) -> bool {
        plan.outputs().files().frames && plan.physics().plans.get::<WearPlan>().is_some()
    }

    fn begin(run: &Beginning<'_>) -> Result<Self, OutputError> {
        let writer = run.frames(Self::NAME, &())?;
        Ok(Self { writer })
    }
}

impl Stream for WearTriangles {
    fn write(&mut self, state: &FrameCopy) -> Result<(), OutputError> {
        if let (Some(wear), true) = (&state.wear, state.due.frame) {
            self.writer.append(wear.triangles.clone())?;
        }
        Ok(())
    }

    fn sink(&self) -> Sink<'_> {
        Sink::Frames(self.writer.frames())
    }
}

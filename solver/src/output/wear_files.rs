//! `<prefix>.wear.csv`, `<prefix>.wear.arrow`, `<prefix>.wear_triangles.arrow`: the volumes owed and removed by wear, in all, by
//! vertices and by triangles.

use mercury_common::formats::number::{NumberStyle, push_integer, push_number};
use mercury_common::formats::table_head::TableColumn;
use mercury_common::frames::{WearFrame, WearTriangleFrame, WearTriangleWriter, WearWriter};

use super::stream::{Beginning, NAME, Sink, Stream, StreamKind, TIME, TextFile, push_csv_name};
use super::{OrderedFrame, OutputError};
use crate::plan::Plan;
use mercury_engine::wear::{Wear, WearRow};

/// Columns of values of `.wear.csv`.
const COLUMNS: &[TableColumn] = &[
    ("owed", "m3"),
    ("removed", "m3"),
    ("pending", "m3"),
    ("front", "m3"),
    ("back", "m3"),
    ("max_depth", "m"),
    ("x", "m"),
    ("y", "m"),
    ("z", "m"),
    ("moves", ""),
    ("blocked", ""),
];

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
pub(super) struct WearCsv {
    file: TextFile,
    names: Vec<String>,
}

impl StreamKind for WearCsv {
    const NAME: &'static str = "wear.csv";

    fn is_wanted(plan: &Plan) -> bool {
        !plan.physics().wear.is_empty()
    }

    fn begin(run: &Beginning<'_>) -> Result<Self, OutputError> {
        let plan = run.plan;
        let walls = plan.physics().walls.iter();
        Ok(Self {
            file: run.table(Self::NAME, &[TIME, NAME], COLUMNS)?,
            names: walls.map(|wall| wall.name.clone()).collect(),
        })
    }
}

impl Stream for WearCsv {
    fn write(&mut self, state: &OrderedFrame) -> Result<(), OutputError> {
        let Some(wear) = state.wear.as_ref().filter(|_| state.due.frame) else {
            return Ok(());
        };
        for (wall, row) in &wear.rows {
            let out = &mut self.file.buffer;
            push_number(out, state.time, NumberStyle::Shortest);
            out.push(b',');
            push_csv_name(out, &self.names[*wall]);
            let [x, y, z] = row.place.to_array();
            for number in [
                row.owed,
                row.removed,
                row.pending,
                row.front,
                row.back,
                row.max_depth,
                x,
                y,
                z,
            ] {
                out.push(b',');
                push_number(out, number, NumberStyle::Shortest);
            }
            for count in [row.moves, row.blocked] {
                out.push(b',');
                push_integer(out, count as i64);
            }
            out.push(b'\n');
        }
        self.file.flush()
    }

    fn sink(&self) -> Sink<'_> {
        Sink::Text(&self.file)
    }
}

pub(super) struct WearFrames {
    writer: WearWriter,
}

impl StreamKind for WearFrames {
    const NAME: &'static str = "wear.arrow";

    fn is_wanted(plan: &Plan) -> bool {
        plan.outputs().files().frames && !plan.physics().wear.is_empty()
    }

    fn begin(run: &Beginning<'_>) -> Result<Self, OutputError> {
        let writer = run.frames(Self::NAME, &())?;
        Ok(Self { writer })
    }
}

impl Stream for WearFrames {
    fn write(&mut self, state: &OrderedFrame) -> Result<(), OutputError> {
        if let (Some(wear), true) = (&state.wear, state.due.frame) {
            self.writer.append(wear.vertices.clone())?;
        }
        Ok(())
    }

    fn sink(&self) -> Sink<'_> {
        Sink::Frames(self.writer.frames())
    }
}

pub(super) struct WearTriangles {
    writer: WearTriangleWriter,
}

impl StreamKind for WearTriangles {
    const NAME: &'static str = "wear_triangles.arrow";

    fn is_wanted(plan: &Plan) -> bool {
        plan.outputs().files().frames && !plan.physics().wear.is_empty()
    }

    fn begin(run: &Beginning<'_>) -> Result<Self, OutputError> {
        let writer = run.frames(Self::NAME, &())?;
        Ok(Self { writer })
    }
}

impl Stream for WearTriangles {
    fn write(&mut self, state: &OrderedFrame) -> Result<(), OutputError> {
        if let (Some(wear), true) = (&state.wear, state.due.frame) {
            self.writer.append(wear.triangles.clone())?;
        }
        Ok(())
    }

    fn sink(&self) -> Sink<'_> {
        Sink::Frames(self.writer.frames())
    }
}

//! `<prefix>.walls.csv`: force and torque of the particles on each wall, the power of the wall, its pose and its velocity.

use mercury_common::frames::{Column, ColumnKind, ColumnSpec, Frame};
use mercury_common::run_tables::{Role, TableSpec, WALLS};

use super::table_file::{Rows, RunTable};
use super::{Due, FrameCopy};
use crate::plan::Plan;

/// A row for each wall and each time of rows.
pub(super) struct WallLoads {
    names: Vec<String>,
}

impl RunTable for WallLoads {
    const SPEC: &'static TableSpec = &WALLS;

    fn is_wanted(plan: &Plan) -> bool {
        plan.outputs().files().walls && !plan.physics().walls.is_empty()
    }

    fn new(plan: &Plan) -> Self {
        let walls = plan.physics().walls.iter();
        Self {
            names: walls.map(|wall| wall.name.clone()).collect(),
        }
    }

    fn is_due(due: Due) -> bool {
        due.rows
    }

    fn push_rows(&self, state: &FrameCopy, rows: &mut Rows<'_>) {
        for (name, numbers) in self.names.iter().zip(numbers(state)) {
            rows.number(state.time).text(name).numbers(numbers).end();
        }
    }
}

/// Columns of each wall behind its name.
const NUMBERS: usize = 20;

/// The numbers of all walls of a state.
fn numbers(state: &FrameCopy) -> impl Iterator<Item = [f64; NUMBERS]> + '_ {
    let felt = state.observation.walls.iter().zip(&state.walls);
    felt.map(|((load, power), wall)| {
        let (x, v) = (wall.reference, wall.velocity.at(wall.reference));
        let (q, w) = (wall.pose.rotation, wall.velocity.angular_velocity);
        let (f, t) = (load.force, load.torque);
        [
            f.x, f.y, f.z, t.x, t.y, t.z, *power, x.x, x.y, x.z, q.w, q.x, q.y, q.z, v.x, v.y, v.z,
            w.x, w.y, w.z,
        ]
    })
}

/// The walls of a state, and their columns.
pub(crate) fn wall_table(plan: &Plan, state: &FrameCopy) -> (Vec<ColumnSpec>, Frame) {
    let kind = |role| match role {
        Role::Label => ColumnKind::Text,
        _ => ColumnKind::F64,
    };
    let columns = WALLS.columns.iter().skip(1);
    let specs = columns.map(|column| ColumnSpec::new(column.name, kind(column.role), column.unit));
    let rows: Vec<[f64; NUMBERS]> = numbers(state).collect();
    let walls = plan.physics().walls.iter();
    let names = walls.map(|wall| wall.name.clone()).collect();
    let column = |at: usize| Column::F64(rows.iter().map(|row| row[at]).collect());
    let frame = Frame {
        time: state.time,
        step: state.step,
        columns: std::iter::once(Column::Text(names))
            .chain((0..NUMBERS).map(column))
            .collect(),
    };
    (specs.collect(), frame)
}

//! `<prefix>.walls.csv`: force and torque of the particles on each wall, the power of the wall, its pose and its velocity.

use mercury_common::run_tables::{TableSpec, WALLS};

use super::FrameCopy;
use super::table_file::{Rows, RunTable};
use crate::plan::Plan;

/// A row for each wall and each output interval.
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

    fn push_rows(&self, state: &FrameCopy, rows: &mut Rows<'_>) {
        let felt = state.observation.walls.iter().zip(&state.walls);
        for (name, ((load, power), wall)) in self.names.iter().zip(felt) {
            let (x, v) = (wall.reference, wall.velocity.at(wall.reference));
            let q = wall.pose.rotation;
            rows.number(state.time).text(name);
            rows.numbers(load.force.to_array());
            rows.numbers(load.torque.to_array()).number(*power);
            rows.numbers(x.to_array()).numbers([q.w, q.x, q.y, q.z]);
            rows.numbers(v.to_array());
            rows.numbers(wall.velocity.angular_velocity.to_array())
                .end();
        }
    }
}

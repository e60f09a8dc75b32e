//! `<prefix>.walls.csv`: force and torque of the particles on each wall, the power of the wall, its pose and its velocity.

use mercury_common::formats::number::{NumberStyle, push_number};
use mercury_common::formats::table_head::TableColumn;

use super::stream::{Beginning, NAME, Sink, Stream, StreamKind, TIME, TextFile, push_csv_name};
use super::{OrderedFrame, OutputError};
use crate::plan::Plan;

/// Columns of values of `.walls.csv`.
pub const COLUMNS: &[TableColumn] = &[
    ("fx", "N"),
    ("fy", "N"),
    ("fz", "N"),
    ("tx", "N m"),
    ("ty", "N m"),
    ("tz", "N m"),
    ("power", "W"),
    ("x", "m"),
    ("y", "m"),
    ("z", "m"),
    ("qw", "1"),
    ("qx", "1"),
    ("qy", "1"),
    ("qz", "1"),
    ("vx", "m/s"),
    ("vy", "m/s"),
    ("vz", "m/s"),
    ("wx", "rad/s"),
    ("wy", "rad/s"),
    ("wz", "rad/s"),
];

pub(super) struct WallLoads {
    file: TextFile,
    names: Vec<String>,
}

impl StreamKind for WallLoads {
    const NAME: &'static str = "walls.csv";

    fn is_wanted(plan: &Plan) -> bool {
        plan.outputs().files().walls && !plan.physics().walls.is_empty()
    }

    fn begin(run: &Beginning<'_>) -> Result<Self, OutputError> {
        let plan = run.plan;
        let file = run.table(Self::NAME, &[TIME, NAME], COLUMNS)?;
        Ok(Self {
            file,
            names: plan
                .physics()
                .walls
                .iter()
                .map(|wall| wall.name.clone())
                .collect(),
        })
    }
}

impl Stream for WallLoads {
    fn write(&mut self, state: &OrderedFrame) -> Result<(), OutputError> {
        if !state.due.frame {
            return Ok(());
        }
        let out = &mut self.file.buffer;
        let felt = state.observation.walls.iter().zip(&state.walls);
        for (name, ((load, power), wall)) in self.names.iter().zip(felt) {
            push_number(out, state.time, NumberStyle::Shortest);
            out.push(b',');
            push_csv_name(out, name);
            let (f, t, q) = (load.force, load.torque, wall.pose.rotation);
            let (x, v) = (wall.reference, wall.velocity.at(wall.reference));
            let w = wall.velocity.angular_velocity;
            let loads = [f.x, f.y, f.z, t.x, t.y, t.z, *power];
            let place = [x.x, x.y, x.z, q.w, q.x, q.y, q.z];
            let motion = [v.x, v.y, v.z, w.x, w.y, w.z];
            for value in loads.into_iter().chain(place).chain(motion) {
                out.push(b',');
                push_number(out, value, NumberStyle::Shortest);
            }
            out.push(b'\n');
        }
        self.file.flush()
    }

    fn sink(&self) -> Sink<'_> {
        Sink::Text(&self.file)
    }
}

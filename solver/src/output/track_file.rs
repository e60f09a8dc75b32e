//! `<prefix>.track.csv`: the motion of named particles and bodies, and of grains that insertions bring.

use mercury_common::formats::number::{NumberStyle, push_integer, push_number};
use mercury_common::formats::table_head::TableColumn;

use super::frame_copy::TrackPoint;
use super::stream::{Beginning, NAME, Sink, Stream, StreamKind, TIME, TextFile, push_csv_name};
use super::{OrderedFrame, OutputError};
use crate::plan::Plan;

/// Columns of values.
pub const COLUMNS: &[TableColumn] = &[
    ("x", "m"),
    ("y", "m"),
    ("z", "m"),
    ("vx", "m/s"),
    ("vy", "m/s"),
    ("vz", "m/s"),
    ("qw", "1"),
    ("qx", "1"),
    ("qy", "1"),
    ("qz", "1"),
    ("wx", "rad/s"),
    ("wy", "rad/s"),
    ("wz", "rad/s"),
    ("fx", "N"),
    ("fy", "N"),
    ("fz", "N"),
    ("tx", "N m"),
    ("ty", "N m"),
    ("tz", "N m"),
];

pub(super) struct TrackFile {
    file: TextFile,
    names: Vec<String>,
}

impl StreamKind for TrackFile {
    const NAME: &'static str = "track.csv";

    fn is_wanted(plan: &Plan) -> bool {
        plan.outputs().files().has_tracks()
    }

    fn begin(run: &Beginning<'_>) -> Result<Self, OutputError> {
        let plan = run.plan;
        let file = run.table(Self::NAME, &[TIME, NAME, ("id", "")], COLUMNS)?;
        Ok(Self {
            file,
            names: plan.outputs().files().track_names(),
        })
    }
}

impl Stream for TrackFile {
    fn write(&mut self, state: &OrderedFrame) -> Result<(), OutputError> {
        if !state.due.tracks {
            return Ok(());
        }
        let out = &mut self.file.buffer;
        // A particle that was deleted has no more rows.
        for point in &state.tracks {
            let TrackPoint {
                position: x,
                velocity: v,
                angular_velocity: w,
                orientation: q,
                load,
                ..
            } = point;
            let (f, t) = (load.force, load.torque);
            push_number(out, state.time, NumberStyle::Shortest);
            out.push(b',');
            let name = self.names.get(point.track as usize - 1);
            push_csv_name(out, name.map_or("", String::as_str));
            out.push(b',');
            push_integer(out, i64::from(point.id));
            for value in [
                x.x, x.y, x.z, v.x, v.y, v.z, q.w, q.x, q.y, q.z, w.x, w.y, w.z, f.x, f.y, f.z,
                t.x, t.y, t.z,
            ] {
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

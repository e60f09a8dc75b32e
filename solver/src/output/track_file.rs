//! `<prefix>.track.csv`: the motion of named particles and bodies, and of grains that insertions bring.

use mercury_common::formats::number::{NumberStyle, push_integer, push_number};

use super::frame_copy::TrackPoint;
use super::stream::{Beginning, Sink, Stream, StreamKind, TextFile, push_csv_name};
use super::{OrderedFrame, OutputError};
use crate::plan::Plan;

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
        let head = b"time,name,id,x,y,z,vx,vy,vz,qw,qx,qy,qz,wx,wy,wz,fx,fy,fz,tx,ty,tz\n";
        let file = run.text(Self::NAME, head)?;
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

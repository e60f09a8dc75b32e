//! `<prefix>.track.csv`: the motion of named particles and bodies.

use std::path::Path;

use mercury_common::formats::number::{NumberStyle, push_integer, push_number};

use super::stream::{Begin, Sink, Stream, TextFile, push_csv_name};
use super::{OutputError, State};
use crate::plan::Plan;

pub(super) struct TrackFile {
    file: TextFile,
    track: Vec<(String, u32)>,
}

impl TrackFile {
    pub(super) fn begin(folder: &Path, plan: &Plan, begin: Begin) -> Result<Self, OutputError> {
        let name = format!("{}.track.csv", plan.outputs().prefix());
        let head = b"time,name,id,x,y,z,vx,vy,vz,qw,qx,qy,qz,wx,wy,wz\n";
        let file = TextFile::begin(folder, &name, head, begin)?;
        Ok(Self {
            file,
            track: plan.outputs().files().track.clone(),
        })
    }
}

impl Stream for TrackFile {
    fn write(&mut self, state: &State) -> Result<(), OutputError> {
        if !state.due.frame {
            return Ok(());
        }
        let out = &mut self.file.buffer;
        for (name, id) in &self.track {
            // A particle that was deleted has no more rows.
            let Ok(rank) = state.ids.binary_search(id) else {
                continue;
            };
            let (x, v, w, q) = match state.body(rank) {
                Some(body) => (
                    body.position,
                    body.velocity,
                    body.angular_velocity,
                    body.orientation,
                ),
                None => {
                    let particle = &state.particles[rank];
                    (
                        particle.position,
                        particle.velocity,
                        particle.angular_velocity,
                        state.orientation(rank),
                    )
                }
            };
            push_number(out, state.time, NumberStyle::Shortest);
            out.push(b',');
            push_csv_name(out, name);
            out.push(b',');
            push_integer(out, i64::from(*id));
            for value in [
                x.x, x.y, x.z, v.x, v.y, v.z, q.w, q.x, q.y, q.z, w.x, w.y, w.z,
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

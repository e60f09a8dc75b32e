//! `<prefix>.walls.csv`: force and torque of the particles on each wall, the power of the wall, its pose and its velocity.

use mercury_common::formats::number::{NumberStyle, push_number};

use super::stream::{Beginning, Sink, Stream, StreamKind, TextFile, push_csv_name};
use super::{OrderedFrame, OutputError};
use crate::plan::Plan;

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
        let head = b"time,name,fx,fy,fz,tx,ty,tz,power,x,y,z,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz\n";
        let file = run.text(Self::NAME, head)?;
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

//! `<prefix>.data`: the particles in MercuryDPM's layout.

use glam::DVec3;
use mercury_common::formats::data::{DataFrame, DataRow, write_frame};
use mercury_common::formats::number::NumberStyle;
use mercury_common::formats::orientation::euler_from_quaternion;

use super::data_rows::{DataRows, Row};
use super::stream::{Beginning, Sink, Stream, StreamKind, TextFile};
use super::{FrameCopy, OutputError};
use crate::plan::Plan;

pub(super) struct DataFile {
    file: TextFile,
    style: NumberStyle,
    dimensions: u8,
    domain: (DVec3, DVec3),
    pebbles: bool,
}

impl StreamKind for DataFile {
    const NAME: &'static str = "data";

    fn is_wanted(plan: &Plan) -> bool {
        plan.outputs().files().data
    }

    fn begin(run: &Beginning<'_>) -> Result<Self, OutputError> {
        let plan = run.plan;
        Ok(Self {
            file: run.text(Self::NAME, b"")?,
            style: plan.outputs().files().number_style(),
            dimensions: plan.physics().dimensions,
            domain: plan.physics().cell.corners(),
            pebbles: plan.outputs().files().pebbles,
        })
    }
}

impl Stream for DataFile {
    fn write(&mut self, state: &FrameCopy) -> Result<(), OutputError> {
        if !state.due.frame {
            return Ok(());
        }
        let rows = DataRows::new(state, self.pebbles).rows;
        let rows = rows.into_iter().map(|row| match row {
            Row::Particle(rank) => {
                let particle = &state.particles[rank];
                let angles = match &state.orientations {
                    Some(orientations) => euler_from_quaternion(orientations[rank]),
                    None => DVec3::ZERO,
                };
                DataRow {
                    position: particle.position,
                    velocity: particle.velocity,
                    radius: particle.radius,
                    angles,
                    angular_velocity: particle.angular_velocity,
                    info: f64::from(particle.material.number()),
                }
            }
            Row::Body(place) => {
                let body = &state.bodies[place];
                DataRow {
                    position: body.position,
                    velocity: body.velocity,
                    radius: body.radius,
                    angles: euler_from_quaternion(body.orientation),
                    angular_velocity: body.angular_velocity,
                    info: f64::from(body.material.number()),
                }
            }
        });
        let frame = DataFrame {
            time: state.time,
            dimensions: self.dimensions,
            min: self.domain.0,
            max: self.domain.1,
            particles: rows.collect(),
        };
        write_frame(&frame, self.style, &mut self.file.buffer);
        self.file.flush()
    }

    fn sink(&self) -> Sink<'_> {
        Sink::Text(&self.file)
    }
}

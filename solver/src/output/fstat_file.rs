//! `<prefix>.fstat`: the contacts in MercuryDPM's layout.

use glam::DVec3;
use mercury_common::formats::fstat::{ContactRow, FstatFrame, write_frame};
use mercury_common::formats::number::NumberStyle;

use super::data_rows::DataRows;
use super::stream::{Beginning, Sink, Stream, StreamKind, TextFile};
use super::{FrameCopy, OutputError};
use crate::plan::Plan;
use mercury_engine::forces::Partner;

pub(super) struct FstatFile {
    file: TextFile,
    style: NumberStyle,
    domain: (DVec3, DVec3),
    pebbles: bool,
}

impl StreamKind for FstatFile {
    const NAME: &'static str = "fstat";

    fn is_wanted(plan: &Plan) -> bool {
        plan.outputs().files().fstat
    }

    fn begin(run: &Beginning<'_>) -> Result<Self, OutputError> {
        let plan = run.plan;
        Ok(Self {
            file: run.text(Self::NAME, b"")?,
            style: plan.outputs().files().number_style(),
            domain: plan.physics().cell.corners(),
            pebbles: plan.outputs().files().pebbles,
        })
    }
}

impl Stream for FstatFile {
    fn write(&mut self, state: &FrameCopy) -> Result<(), OutputError> {
        if !state.due.contacts {
            return Ok(());
        }
        let radii = || state.particles.iter().map(|particle| particle.radius);
        let frame = FstatFrame {
            time: state.time,
            has_contact_points: true,
            min: self.domain.0,
            max: self.domain.1,
            radius_min: radii().fold(f64::NAN, f64::min),
            radius_max: radii().fold(f64::NAN, f64::max),
            contacts: contact_rows(state, self.pebbles),
        };
        write_frame(&frame, self.style, &mut self.file.buffer);
        self.file.flush()
    }

    fn sink(&self) -> Sink<'_> {
        Sink::Text(&self.file)
    }
}

/// The lines of all contacts, sorted by the two indices: two for a pair, one for a wall, none for the side of a fixed particle.
///
/// Both lines of a pair carry the point on the side of the lower index; normal and tangent of a wall contact are
/// reversed. These are MercuryDPM's conventions. Indices are those of the rows of `.data`: of bodies, or with `pebbles` of pebbles.
pub(super) fn contact_rows(state: &FrameCopy, pebbles: bool) -> Vec<ContactRow> {
    let row_of_rank = DataRows::new(state, pebbles).row_of_rank;
    let mut rows = Vec::with_capacity(2 * state.observation.records.len());
    for record in &state.observation.records {
        let i = state.rank(record.row);
        let particle = &state.particles[i];
        let lever = particle.radius - 0.5 * record.overlap;
        let tangential_force = record.tangential.length();
        let row = ContactRow {
            time: state.time,
            i: i64::from(row_of_rank[i]),
            j: 0,
            contact_point: particle.position - record.normal * lever,
            overlap: record.overlap,
            tangential_overlap: record.tangential_overlap,
            normal_force: record.force.dot(record.normal),
            tangential_force,
            normal: record.normal,
            tangent: if tangential_force > 0.0 {
                record.tangential / tangential_force
            } else {
                DVec3::ZERO
            },
        };
        let reversed = ContactRow {
            normal: -row.normal,
            tangent: -row.tangent,
            ..row
        };
        match record.partner {
            Partner::Particle { row: partner, .. } => {
                let j = state.rank(partner);
                let to = i64::from(row_of_rank[j]);
                if !state.is_fixed(i) {
                    rows.push(ContactRow { j: to, ..row });
                }
                if !state.is_fixed(j) {
                    rows.push(ContactRow {
                        i: to,
                        j: row.i,
                        ..reversed
                    });
                }
            }
            Partner::Wall { wall, .. } => rows.push(ContactRow {
                j: ContactRow::j_of_wall(u32::from(wall.number())),
                ..reversed
            }),
        }
    }
    // Stable: two features of one wall stay in the order in which the state holds them.
    rows.sort_by_cached_key(|row| (row.i, row.j));
    rows
}

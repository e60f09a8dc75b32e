//! `<prefix>.contacts.arrow`: the native frames of contacts.

use mercury_common::frames::{
    ColumnSpec, ContactColumns, ContactFrame, ContactWriter, HistoryColumn, Table as _,
};

use super::stream::{Beginning, Sink, Stream, StreamKind};
use super::{FrameCopy, OutputError};
use crate::plan::Plan;
use mercury_engine::contact::{AnyRolling, HistoryNumber};
use mercury_engine::forces::Partner;
use mercury_engine::membrane::MembranePlan;

pub(super) struct ContactFrames {
    writer: ContactWriter,
    columns: ContactColumns,
}

impl StreamKind for ContactFrames {
    const NAME: &'static str = "contacts.arrow";

    fn is_wanted(plan: &Plan) -> bool {
        plan.outputs().files().frames && plan.outputs().files().fstat
    }

    fn begin(run: &Beginning<'_>) -> Result<Self, OutputError> {
        let columns = contact_columns(run.plan, run.history);
        Ok(Self {
            writer: run.frames(Self::NAME, &columns)?,
            columns,
        })
    }
}

/// Which columns the contacts of a run have.
pub(super) fn contact_columns(plan: &Plan, history: &[HistoryNumber]) -> ContactColumns {
    let mut laws = plan.physics().laws.laws.iter().flatten();
    ContactColumns {
        torque: laws.any(|law| law.rolling != AnyRolling::None),
        bridge: plan.physics().laws.has_liquid(),
        adhesion: plan.physics().laws.has_dry_cohesion(),
        membrane: plan.physics().plans.get::<MembranePlan>().is_some(),
        history: history
            .iter()
            .map(|&(unit, description)| HistoryColumn {
                unit: unit.to_owned(),
                description: description.to_owned(),
            })
            .collect(),
    }
}

impl Stream for ContactFrames {
    fn write(&mut self, state: &FrameCopy) -> Result<(), OutputError> {
        if !state.due.contacts {
            return Ok(());
        }
        self.writer.append(contact_frame(state, &self.columns))?;
        Ok(())
    }

    fn sink(&self) -> Sink<'_> {
        Sink::Frames(self.writer.frames())
    }
}

/// The contacts of a state in order of ids, and their columns.
pub(crate) fn contact_table(
    plan: &Plan,
    history: &[HistoryNumber],
    state: &FrameCopy,
) -> (Vec<ColumnSpec>, ContactFrame) {
    let columns = contact_columns(plan, history);
    let frame = contact_frame(state, &columns);
    (ContactFrame::specs(&columns), frame)
}

/// The contacts sorted by the lower id, then pairs by the higher one, then walls, then membranes.
pub(super) fn contact_frame(state: &FrameCopy, columns: &ContactColumns) -> ContactFrame {
    let mut records: Vec<_> = state.observation.records.iter().collect();
    records.sort_by_cached_key(|record| {
        let partner = match record.partner {
            Partner::Particle { row, .. } => (0, state.rank(row)),
            Partner::Wall { wall, .. } => (1, wall.index()),
        };
        (state.rank(record.row), partner)
    });
    let mut frame = ContactFrame {
        time: state.time,
        step: state.step,
        torque: columns.torque.then(Vec::new),
        membrane: columns.membrane.then(Vec::new),
        bridge_volume: columns.bridge.then(Vec::new),
        bridge_normal: columns.bridge.then(Vec::new),
        bridge_shear: columns.bridge.then(Vec::new),
        adhesion: columns.adhesion.then(Vec::new),
        history: vec![Vec::with_capacity(records.len()); columns.history.len()],
        ..ContactFrame::default()
    };
    for record in records {
        let i = state.rank(record.row);
        let particle = &state.particles[i];
        let mut lever = particle.radius - 0.5 * record.overlap;
        let mut membrane = None;
        let (j, wall, length) = match record.partner {
            Partner::Particle { row, .. } => {
                let j = state.rank(row);
                let distance = particle.radius + state.particles[j].radius - record.overlap;
                (Some(state.ids[j]), None, distance)
            }
            // Behind the walls come the shapes of membranes, which are touched where they are.
            Partner::Wall { wall, .. } if columns.membrane && wall.index() >= state.walls.len() => {
                membrane = Some((wall.index() - state.walls.len()) as u32);
                lever = particle.radius - record.overlap;
                (None, None, lever)
            }
            Partner::Wall { wall, .. } => (None, Some(u32::from(wall.number())), lever),
        };
        frame.i.push(state.ids[i]);
        frame.j.push(j);
        frame.wall.push(wall);
        if let Some(membranes) = &mut frame.membrane {
            membranes.push(membrane);
        }
        frame.point.push(particle.position - record.normal * lever);
        frame.branch.push(record.normal * length);
        frame.normal.push(record.normal);
        frame.force.push(record.force);
        frame.overlap.push(record.overlap);
        if let Some(torque) = &mut frame.torque {
            torque.push(record.couple);
        }
        if let (Some(volume), Some(normal), Some(shear)) = (
            &mut frame.bridge_volume,
            &mut frame.bridge_normal,
            &mut frame.bridge_shear,
        ) {
            volume.push(record.bridge_volume);
            normal.push(record.bridge_normal);
            shear.push(record.bridge_shear);
        }
        if let Some(adhesion) = &mut frame.adhesion {
            adhesion.push(record.adhesion);
        }
        for (column, &number) in frame.history.iter_mut().zip(&record.history) {
            column.push(number);
        }
    }
    frame
}

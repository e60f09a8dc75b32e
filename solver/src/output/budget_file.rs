//! `<prefix>.budget.csv`: the energy budget.

use std::path::Path;

use mercury_common::formats::number::{NumberStyle, push_number};

use super::stream::{Begin, Sink, Stream, TextFile};
use super::{OrderedFrame, OutputError};
use crate::plan::Plan;

const HEAD: &[u8] = b"time,kinetic,rotational,gravitational,elastic,dissipated_normal,dissipated_tangential,dissipated_rolling,dissipated_liquid,wall_work,servo_work,inserted,deleted,deleted_elastic,vanished_walls,error,closure\n";
/// How it ends.
const END: &[u8] = b"error,closure\n";

/// A row for each output interval; energies in J.
pub(super) struct BudgetFile {
    file: TextFile,
    /// Whether the run has sheets, for which there are further columns.
    has_sheets: bool,
}

/// Columns of runs with elastic sheets, before the error.
const OF_SHEETS: &str = "membrane_kinetic,membrane_gravitational,membrane_stretching,membrane_bending,membrane_dissipated,pressure_work,hold_work,";

impl BudgetFile {
    pub(super) fn begin(folder: &Path, plan: &Plan, begin: Begin) -> Result<Self, OutputError> {
        let name = format!("{}.budget.csv", plan.outputs().prefix());
        let has_sheets = !plan.physics().membranes().is_empty();
        let mut head = HEAD.to_vec();
        if has_sheets {
            let at = HEAD.len() - END.len();
            head.splice(at..at, OF_SHEETS.bytes());
        }
        let file = TextFile::begin(folder, &name, &head, begin)?;
        Ok(Self { file, has_sheets })
    }
}

impl Stream for BudgetFile {
    fn write(&mut self, state: &OrderedFrame) -> Result<(), OutputError> {
        let Some(budget) = state.budget.as_ref().filter(|_| state.due.frame) else {
            return Ok(());
        };
        let row = &budget.energies;
        let flows = row.flows.unwrap_or_default();
        let out = &mut self.file.buffer;
        push_number(out, row.time, NumberStyle::Shortest);
        for energy in [
            row.kinetic,
            row.rotational,
            row.gravitational,
            row.elastic,
            flows.dissipated_normal,
            flows.dissipated_tangential,
            flows.dissipated_rolling,
            flows.dissipated_liquid,
            flows.wall_work,
            flows.servo_work,
            flows.inserted,
            flows.deleted,
            flows.deleted_elastic,
            flows.vanished_walls,
        ] {
            out.push(b',');
            push_number(out, energy, NumberStyle::Shortest);
        }
        if self.has_sheets {
            let sheets = &flows.sheets;
            for energy in [
                sheets.kinetic,
                sheets.gravitational,
                sheets.stretching,
                sheets.bending,
                sheets.dissipated,
                sheets.pressure_work,
                sheets.hold_work,
            ] {
                out.push(b',');
                push_number(out, energy, NumberStyle::Shortest);
            }
        }
        // Empty where the budget cannot close, as tables say that a number is missing.
        for number in [
            budget.gap.map(|gap| gap.error),
            budget.gap.map(|gap| gap.relative),
        ] {
            out.push(b',');
            if let Some(number) = number {
                push_number(out, number, NumberStyle::Shortest);
            }
        }
        out.push(b'\n');
        self.file.flush()
    }

    fn sink(&self) -> Sink<'_> {
        Sink::Text(&self.file)
    }
}

//! `<prefix>.budget.csv`: the energy budget.

use mercury_common::formats::number::{NumberStyle, push_number};
use mercury_common::formats::table_head::cell;
use mercury_pictures::EnergyFlows;

use super::stream::{Beginning, Sink, Stream, StreamKind, TIME, TextFile};
use super::{OrderedFrame, OutputError};
use crate::plan::Plan;

/// Energies, before the losses.
const ENERGIES: [&str; 4] = ["kinetic", "rotational", "gravitational", "elastic"];
/// Energies behind the losses.
const FLOWS: [&str; 6] = [
    "wall_work",
    "servo_work",
    "inserted",
    "deleted",
    "deleted_elastic",
    "vanished_walls",
];

/// A row for each output interval; energies in J.
pub(super) struct BudgetFile {
    file: TextFile,
    /// Whether the run has sheets, for which there are further columns.
    has_sheets: bool,
}

/// Energies of runs with elastic sheets.
const OF_SHEETS: [&str; 7] = [
    "membrane_kinetic",
    "membrane_gravitational",
    "membrane_stretching",
    "membrane_bending",
    "membrane_dissipated",
    "pressure_work",
    "hold_work",
];

impl StreamKind for BudgetFile {
    const NAME: &'static str = "budget.csv";

    fn is_wanted(plan: &Plan) -> bool {
        plan.physics().energy_budget
    }

    /// `losses`: with the names of all that takes energy.
    fn begin(run: &Beginning<'_>) -> Result<Self, OutputError> {
        let plan = run.plan;
        let has_sheets = !plan.physics().membranes.is_empty();
        let named = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        let losses = run.losses.iter().map(|(name, _)| column(name)).collect();
        let of_sheets: &[&str] = if has_sheets { &OF_SHEETS } else { &[] };
        let energies: [Vec<String>; 5] = [
            named(&ENERGIES),
            losses,
            named(&FLOWS),
            named(of_sheets),
            named(&["error"]),
        ];
        let cells = energies.iter().flatten().map(|name| cell(name, "J"));
        let cells: Vec<String> = cells.collect();
        let head = format!("{},{},closure\n", cell(TIME.0, TIME.1), cells.join(","));
        let file = run.text(Self::NAME, head.as_bytes())?;
        Ok(Self { file, has_sheets })
    }
}

/// The column of a loss: `dissipated_` and its name, in which all but letters and digits is an underscore.
fn column(name: &str) -> String {
    let letter = |c: char| if c.is_alphanumeric() { c } else { '_' };
    let name: String = name.chars().map(letter).collect();
    format!("dissipated_{name}")
}

impl Stream for BudgetFile {
    fn write(&mut self, state: &OrderedFrame) -> Result<(), OutputError> {
        let Some(budget) = state.budget.as_ref().filter(|_| state.due.frame) else {
            return Ok(());
        };
        let row = &budget.energies;
        let none = EnergyFlows::default();
        let flows = row.flows.as_ref().unwrap_or(&none);
        let out = &mut self.file.buffer;
        push_number(out, row.time, NumberStyle::Shortest);
        let stored = [row.kinetic, row.rotational, row.gravitational, row.elastic];
        let losses = flows.dissipated.iter().map(|(_, energy)| *energy);
        let others = [
            flows.wall_work,
            flows.servo_work,
            flows.inserted,
            flows.deleted,
            flows.deleted_elastic,
            flows.vanished_walls,
        ];
        for energy in stored.into_iter().chain(losses).chain(others) {
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
        // Empty where the budget cannot close, which in tables means a missing number.
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

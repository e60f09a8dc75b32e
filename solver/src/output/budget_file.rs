//! `<prefix>.budget.csv`: the energy budget.

use mercury_common::run_tables::{BUDGET, BUDGET_OF_SHEETS, DISSIPATED, TableSpec};
use mercury_pictures::EnergyFlows;

use super::FrameCopy;
use super::table_file::{Rows, RunTable};
use crate::plan::Plan;
use mercury_engine::audit::Losses;
use mercury_engine::membrane::MembranePlan;

/// A row for each output interval.
pub(super) struct BudgetFile {
    /// Whether the run has sheets, for which there are further columns.
    has_sheets: bool,
}

/// The column of a loss: `dissipated_` and its name, in which all but letters and digits is an underscore.
fn column_of(loss: &str) -> String {
    let letter = |c: char| if c.is_alphanumeric() { c } else { '_' };
    let name: String = loss.chars().map(letter).collect();
    DISSIPATED.replace("NAME", &name)
}

impl RunTable for BudgetFile {
    const SPEC: &'static TableSpec = &BUDGET;

    fn is_wanted(plan: &Plan) -> bool {
        plan.physics().energy_budget
    }

    fn new(plan: &Plan) -> Self {
        Self {
            has_sheets: plan.physics().plans.get::<MembranePlan>().is_some(),
        }
    }

    fn columns(&self, losses: &Losses) -> Vec<(String, &'static str)> {
        let mut columns = Vec::new();
        for column in Self::SPEC.columns {
            if column.name == DISSIPATED {
                let names = losses.iter().map(|(name, _)| column_of(name));
                columns.extend(names.map(|name| (name, column.unit)));
            } else if self.has_sheets || !BUDGET_OF_SHEETS.contains(&column.name) {
                columns.push((column.name.to_owned(), column.unit));
            }
        }
        columns
    }

    fn push_rows(&self, state: &FrameCopy, rows: &mut Rows<'_>) {
        let Some(budget) = &state.budget else { return };
        let row = &budget.energies;
        let none = EnergyFlows::default();
        let flows = row.flows.as_ref().unwrap_or(&none);
        rows.numbers([row.time, row.kinetic, row.rotational]);
        rows.numbers([row.gravitational, row.elastic]);
        rows.numbers(flows.dissipated.iter().map(|(_, energy)| *energy));
        rows.numbers([flows.wall_work, flows.servo_work, flows.inserted]);
        rows.numbers([flows.deleted, flows.deleted_elastic, flows.vanished_walls]);
        if self.has_sheets {
            let sheets = &flows.sheets;
            rows.numbers([sheets.kinetic, sheets.gravitational]);
            rows.numbers([sheets.stretching, sheets.bending, sheets.dissipated]);
            rows.numbers([sheets.pressure_work, sheets.hold_work]);
        }
        // Empty where the budget cannot close, which in tables means a missing number.
        rows.perhaps(budget.gap.map(|gap| gap.error));
        rows.perhaps(budget.gap.map(|gap| gap.relative)).end();
    }
}

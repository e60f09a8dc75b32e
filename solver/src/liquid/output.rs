//! `<prefix>.liquid.csv`: where the liquid is, and how it left.

use mercury_common::particle_properties::FILM_VOLUME;
use mercury_common::run_tables::{LIQUID, TableSpec};

use crate::output::FrameCopy;
use crate::output::table_file::{Rows, RunTable};
use crate::plan::Plan;

/// A row for each output interval.
pub(crate) struct LiquidFile;

impl RunTable for LiquidFile {
    const SPEC: &'static TableSpec = &LIQUID;

    fn is_wanted(plan: &Plan) -> bool {
        plan.outputs().files().liquid && plan.physics().has_property(&FILM_VOLUME)
    }

    fn new(_: &Plan) -> Self {
        Self
    }

    fn push_rows(&self, state: &FrameCopy, rows: &mut Rows<'_>) {
        let Some(row) = &state.liquid else { return };
        let balance = &row.balance;
        let [in_flight, emitted, absorbed, lost, left] = row.sprayed;
        rows.number(state.time);
        rows.numbers([row.films, row.bridges, row.wall_films]);
        rows.numbers([in_flight, emitted, absorbed, lost]);
        rows.number(balance.left.value() + left);
        let amounts = [&balance.evaporated, &balance.inserted, &balance.deleted];
        rows.numbers(amounts.map(|amount| amount.value()))
            .number(row.error);
        rows.counts([row.bridge_count, balance.formed, balance.ruptured])
            .end();
    }
}

//! `<prefix>.bonds.arrow` and `<prefix>.breaks.csv`: bonds that hold, and those that broke.

use mercury_common::frames::{BondFrame, BondNames, BondWriter};
use mercury_common::run_tables::{BREAKS, TableSpec};

use crate::output::stream::{Beginning, Sink, Stream, StreamKind};
use crate::output::table_file::{Rows, RunTable};
use crate::output::{Due, FrameCopy, OutputError};
use crate::plan::Plan;
use mercury_engine::bonds::{Bond, BondPlan};

/// Whether a run writes its bonds.
fn writes_bonds(plan: &Plan) -> bool {
    plan.outputs().files().bonds && plan.physics().plans.get::<BondPlan>().is_some()
}

/// Names of the entries of bonds, in their order.
fn names(plan: &Plan) -> Vec<String> {
    let entries = plan.physics().plans.all::<BondPlan>().iter();
    entries.map(|entry| entry.name.clone()).collect()
}

/// The bonds that hold, and their loads.
pub(crate) fn bond_frame(state: &FrameCopy) -> BondFrame {
    let bonds = &state.bonds;
    let partner = |bond: &Bond, is_wall: bool| (bond.is_wall == is_wall).then_some(bond.ids[1]);
    let middle = |bond: &Bond| {
        // The end is there as long as the bond is.
        let rank = state.ids.binary_search(&bond.ids[0]).unwrap_or_default();
        state.particles[rank].position + 0.5 * bond.branch
    };
    let loads: Vec<_> = bonds.iter().map(Bond::load_at_middle).collect();
    let stress = |k: usize| bonds.iter().map(|bond| bond.now.stresses[k]).collect();
    BondFrame {
        time: state.time,
        step: state.step,
        i: bonds.iter().map(|bond| bond.ids[0]).collect(),
        j: bonds.iter().map(|bond| partner(bond, false)).collect(),
        wall: bonds.iter().map(|bond| partner(bond, true)).collect(),
        bond: bonds.iter().map(|bond| bond.plan).collect(),
        force: loads.iter().map(|load| load[0]).collect(),
        couple: loads.iter().map(|load| load[1]).collect(),
        tension: stress(0),
        shear: stress(1),
        middle: bonds.iter().map(middle).collect(),
        branch: bonds.iter().map(|bond| -bond.branch).collect(),
    }
}

/// A frame for each output interval.
pub(crate) struct BondFrames {
    writer: BondWriter,
}

impl StreamKind for BondFrames {
    const NAME: &'static str = "bonds.arrow";

    fn is_wanted(plan: &Plan) -> bool {
        plan.outputs().files().frames && writes_bonds(plan)
    }

    fn begin(run: &Beginning<'_>) -> Result<Self, OutputError> {
        let names = BondNames(names(run.plan));
        Ok(Self {
            writer: run.frames(Self::NAME, &names)?,
        })
    }
}

impl Stream for BondFrames {
    fn write(&mut self, state: &FrameCopy) -> Result<(), OutputError> {
        if !state.due.frame {
            return Ok(());
        }
        self.writer.append(bond_frame(state))?;
        Ok(())
    }

    fn sink(&self) -> Sink<'_> {
        Sink::Frames(self.writer.frames())
    }
}

/// A row for each bond that broke.
pub(crate) struct BreakFile {
    names: Vec<String>,
    walls: Vec<String>,
}

impl RunTable for BreakFile {
    const SPEC: &'static TableSpec = &BREAKS;

    fn is_wanted(plan: &Plan) -> bool {
        writes_bonds(plan)
    }

    fn new(plan: &Plan) -> Self {
        let walls = plan.physics().walls.iter();
        Self {
            names: names(plan),
            walls: walls.map(|wall| wall.name.clone()).collect(),
        }
    }

    /// There are none but where a frame is due.
    fn is_due(_: Due) -> bool {
        true
    }

    fn push_rows(&self, state: &FrameCopy, rows: &mut Rows<'_>) {
        for broken in &state.breaks {
            let [i, other] = broken.ids;
            let (j, wall) = if broken.is_wall {
                (String::new(), self.walls[other as usize].as_str())
            } else {
                (other.to_string(), "")
            };
            rows.number(broken.time).whole(i64::from(i)).text(&j);
            rows.text(&self.names[broken.plan as usize])
                .text(broken.mode.name());
            rows.numbers(broken.position.to_array())
                .number(broken.energy)
                .text(wall)
                .end();
        }
    }
}

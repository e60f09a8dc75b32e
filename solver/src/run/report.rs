//! The final report of a run.

use std::fmt;

use mercury_common::readable::{duration, rounded, significant};

use super::budget::{Budget, energy_summary};
use super::shortfall::{all_left, shortfalls};
use super::{Ending, RunOptions, StopReason, exit_report, insertions, servos};
use crate::output::Written;
use crate::output::summary::{
    BondSummary, FragmentSummary, LiquidSummary, MembraneSummary, RanksSummary, ResultValue,
    Status, Summary, WearSummary,
};
use crate::plan::Plan;
use mercury_engine::bonds::{BondPlan, Bonds};
use mercury_engine::membrane::MembranePlan;
use mercury_engine::step::Engine;

/// A finished run. Printed, it is the closing report.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// Content of `summary.json`.
    pub summary: Summary,
    /// Why it is over.
    pub ending: Ending,
    /// Time from which an interrupted run continued, s.
    pub resumed_at: Option<f64>,
    /// Budgets of mass and momentum.
    pub budget: Budget,
    /// Names of the files in the run's folder.
    pub files: Vec<String>,
    /// The folder, as the user named it.
    pub folder: String,
    /// A line for each insertion: the particles placed, and whether their sizes are right.
    pub insertions: Vec<String>,
    /// A line for each face, deletion and plane: the particles that left.
    pub exits: Vec<String>,
    /// A line for each servo: its target and the load that it held.
    pub servos: Vec<String>,
    /// Times the candidate list was built.
    pub rebuilds: u64,
    /// Pairs listed at the end.
    pub listed: usize,
    /// The laws that the contact loop was compiled for.
    pub laws: String,
    /// Share of the particle-steps that one thread made, as that was faster.
    pub share_alone: f64,
    /// From the start of the run to its end, s.
    pub total_seconds: f64,
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (s, b) = (&self.summary, &self.budget);
        let how = match self.ending {
            Ending::Planned | Ending::AtRest => "finished",
            Ending::Worn => "finished, worn to until_depth,",
            Ending::Known => "finished, with known results,",
            Ending::Stopped(StopReason::File) => "stopped by the file STOP",
            Ending::Stopped(StopReason::TimeLimit) => "stopped by the time limit",
            Ending::Stopped(StopReason::Request) => "stopped",
        };
        writeln!(
            f,
            "{}: {how} at t = {} s after {} steps",
            s.title,
            rounded(s.time, 12),
            s.steps
        )?;
        if let Some(time) = self.resumed_at {
            writeln!(f, "  resumed    from t = {} s", rounded(time, 12))?;
        }
        writeln!(
            f,
            "  particles  {} ({} inserted, {} deleted), {} contacts, {} with walls, coordination number {:.3}",
            s.particles, s.inserted, s.deleted, s.contacts, s.wall_contacts, s.coordination_number
        )?;
        writeln!(
            f,
            "  mass       {:.6e} + {:.6e} inserted - {:.6e} deleted = {:.6e} kg (error {:.1e} kg)",
            b.initial_mass,
            b.inserted_mass,
            b.deleted_mass,
            b.final_mass,
            b.mass_error()
        )?;
        let (p, q) = (b.initial_momentum, b.final_momentum);
        writeln!(
            f,
            "  momentum   ({:.3e}, {:.3e}, {:.3e}) -> ({:.3e}, {:.3e}, {:.3e}) kg m/s",
            p.x, p.y, p.z, q.x, q.y, q.z
        )?;
        let e = &s.energy;
        writeln!(
            f,
            "  energy     kinetic {:.4e}, rotational {:.4e}, gravitational {:.4e}, elastic {:.4e} J",
            e.kinetic, e.rotational, e.gravitational, e.elastic
        )?;
        if let (Some(lost), Some(work)) = (&e.dissipated, e.wall_work) {
            let lost = lost
                .iter()
                .map(|(name, energy)| format!("{name} {energy:.4e}"));
            let lost = lost.collect::<Vec<_>>().join(", ");
            writeln!(
                f,
                "  dissipated {lost} J; work of walls {work:.4e} J{}",
                match e.servo_work {
                    Some(servos) if servos != 0.0 => format!(", of it of servos {servos:.4e} J"),
                    _ => String::new(),
                }
            )?;
        }
        if let Some(left) = e.deleted_elastic.filter(|left| left.total() != 0.0) {
            writeln!(
                f,
                "  deleted    elastic energy of the contacts of what left: normal {:.4e}, tangential {:.4e}, rolling {:.4e} J",
                left.normal, left.tangential, left.rolling
            )?;
        }
        if let Some(error) = e.closure_error {
            writeln!(f, "  closure    {error:.1e} of the largest energy")?;
        }
        for (name, bonds) in &s.bonds {
            writeln!(
                f,
                "  bonds      {name}: {} made, {} broken, {} left",
                bonds.made, bonds.broken, bonds.left
            )?;
        }
        if let Some(liquid) = &s.liquid {
            writeln!(
                f,
                "  liquid     {:.6e} in films + {:.6e} in {} bridges + {:.6e} on walls + {:.6e} in flight + {:.6e} lost + {:.6e} left and deleted + {:.6e} evaporated = {:.6e} at the start + {:.6e} inserted + {:.6e} sprayed m3 (error {:.1e} m3); {} bridges formed, {} broke",
                liquid.films,
                liquid.bridges,
                liquid.bridge_count,
                liquid.wall_films,
                liquid.in_flight,
                liquid.lost,
                liquid.left + liquid.deleted,
                liquid.evaporated,
                liquid.initial,
                liquid.inserted,
                liquid.emitted,
                liquid.error,
                liquid.formed,
                liquid.ruptured
            )?;
            if liquid.clamped > 0 {
                writeln!(
                    f,
                    "             {} times a bridge formed or took liquid with a volume below those of the table of `young-laplace`: the force of the smallest one there stood for it",
                    liquid.clamped
                )?;
            }
        }
        for wear in &s.wear {
            writeln!(
                f,
                "  wear       {}: {:.6e} m3 owed, {:.6e} removed, {:.1e} pending; {:.3e} m deep after {} moves",
                wear.name, wear.owed, wear.removed, wear.pending, wear.max_depth, wear.moves
            )?;
        }
        for sheet in &s.membranes {
            writeln!(
                f,
                "  membrane   {}: area {:.6e} m2, volume {:.6e} m3, pressure {:.4e} Pa, edges of {} to {} of their length without force",
                sheet.name,
                sheet.area,
                sheet.volume,
                sheet.pressure,
                rounded(sheet.min_stretch, 4),
                rounded(sheet.max_stretch, 4)
            )?;
        }
        let threads = match s.threads {
            1 => "1 thread".to_owned(),
            threads if self.share_alone < 0.005 => format!("{threads} threads"),
            threads => {
                let share = 100.0 * self.share_alone;
                format!("{threads} threads ({share:.0} % of them on one, which was faster)")
            }
        };
        writeln!(
            f,
            "  speed      {:.3e} particle-steps/s on {threads}, {} in the time loop, {} in all",
            s.particle_steps_per_second,
            duration(s.wall_seconds),
            duration(self.total_seconds)
        )?;
        for line in &self.insertions {
            writeln!(f, "  insertion  {line}")?;
        }
        for line in &self.exits {
            writeln!(f, "  left       {line}")?;
        }
        for line in &self.servos {
            writeln!(f, "  servo      {line}")?;
        }
        for (name, result) in &s.results {
            writeln!(f, "  result     {name}{}", reported_result(result))?;
        }
        for warning in &s.warnings {
            writeln!(f, "  warning    {warning}")?;
        }
        write!(f, "  files      {}: {}", self.folder, self.files.join(" "))
    }
}

/// A result in words, behind its name.
fn reported_result(result: &ResultValue) -> String {
    let Some(value) = result.value else {
        let problem = result.problem.as_deref().unwrap_or_default();
        return format!(": {problem}");
    };
    let unit = match result.unit.as_str() {
        "1" => String::new(),
        unit => format!(" {unit}"),
    };
    let note = result.note.iter().map(|note| format!(" ({note})"));
    let note: String = note.collect();
    let estimate = result.estimate.as_ref();
    let known = estimate.and_then(|known| Some((known, known.error?, known.interval?)));
    let Some((known, error, [low, high])) = known.filter(|(_, error, _)| *error > 0.0) else {
        return format!(" = {}{unit}{note}", significant(value, 6));
    };
    // The error to two digits, the value to as many places.
    let digits = 2 + libm::log10((value / error).abs()).floor().clamp(0.0, 12.0) as usize;
    let share = match value == 0.0 {
        true => String::new(),
        false => format!(" ({} %)", significant(100.0 * (error / value).abs(), 2)),
    };
    let [low, high] = [low, high].map(|end| significant(end, digits.max(3)));
    let times = known.window.map(|times| {
        let [from, to] = times.map(|time| significant(time, 4));
        format!("; {from} to {to} s")
    });
    let batches = known.batches.map(|batches| {
        let batches = batches.round();
        format!(", {batches} independent batches")
    });
    format!(
        " = {} ± {}{unit}{share}, 95 %: {low} to {high}{unit}{}{}{note}",
        significant(value, digits.max(3)),
        significant(error, 2),
        times.unwrap_or_default(),
        batches.unwrap_or_default(),
    )
}

/// The messages of the time loop.
#[derive(Debug)]
pub(super) struct Looped {
    /// Seconds without output.
    pub(super) seconds: f64,
    pub(super) particle_steps: u64,
    /// The steps that one thread made although there are more.
    pub(super) alone: u64,
    pub(super) ending: Ending,
    pub(super) resumed_at: Option<u64>,
}

/// The messages at the end of a run.
pub(super) fn report(
    plan: &Plan,
    engine: &Engine,
    options: &RunOptions,
    starting: u64,
    looped: &Looped,
    written: &Written,
) -> Report {
    let particles = engine.particles.grains();
    let observation = written.last.as_ref().map(|state| &state.observation);
    let contacts = observation.map_or(0, |observation| observation.particle_contacts);
    let created = engine.particles.grains_created();
    let mut warnings = Vec::from_iter(all_left(engine));
    warnings.extend_from_slice(plan.notes().warnings());
    let boundaries = engine.boundaries().state();
    let have_places = engine.have_places();
    warnings.extend(shortfalls(plan, &boundaries, &have_places, engine.time()));
    warnings.extend(insertions::behind(plan, engine.boundaries()));
    warnings.extend(servos::missed(engine));
    warnings.extend(engine.warnings());
    if written.deep_frames > 0 {
        warnings.push(format!(
            "overlaps above 10 % of a radius at {} of {} output times (the largest {:.0} %): the contacts are too soft, or particles were placed inside one another",
            written.deep_frames,
            written.energies.len(),
            100.0 * written.deepest
        ));
    }
    let (rebuilds, listed) = engine.list_statistics();
    Report {
        summary: Summary {
            title: plan.outputs().title().to_owned(),
            steps: engine.steps(),
            time: engine.time(),
            time_step: plan.physics().time_step,
            particles,
            contacts,
            wall_contacts: observation.map_or(0, |observation| observation.wall_contacts),
            wall_seconds: looped.seconds,
            particle_steps_per_second: if looped.seconds > 0.0 {
                looped.particle_steps as f64 / looped.seconds
            } else {
                0.0
            },
            threads: options.threads.max(1),
            ranks: engine.traffic().map(|(count, traffic)| RanksSummary {
                count,
                messages: traffic.messages,
                bytes: traffic.bytes,
                bytes_of_lists: traffic.bytes_of_lists,
                bytes_of_looks: traffic.bytes_of_looks,
            }),
            coordination_number: 2.0 * contacts as f64 / particles.max(1) as f64,
            energy: energy_summary(engine, written),
            inserted: created - starting,
            deleted: created - particles as u64,
            inserted_behind_walls: insertions::number_behind(plan, engine.boundaries()),
            liquid: engine.liquid().map(LiquidSummary::from),
            bonds: bonds(engine),
            fragments: fragments(engine),
            wear: wear(engine),
            membranes: membranes(engine),
            settled: plan.settled().time,
            warnings,
            results: Vec::new(),
            until: Vec::new(),
            physics: None,
            link: None,
            branch_of: options.branch_of.clone(),
            status: match looped.ending {
                Ending::Stopped(_) => Status::Stopped,
                Ending::Planned | Ending::AtRest | Ending::Worn | Ending::Known => Status::Finished,
            },
            cause: looped.ending.cause(),
        },
        ending: looped.ending,
        resumed_at: looped
            .resumed_at
            .map(|step| step as f64 * plan.physics().time_step),
        budget: Budget::new(engine, written),
        files: Vec::new(),
        folder: options.folder.display().to_string(),
        insertions: insertions::reported(plan, engine.boundaries(), &have_places),
        servos: servos::reported(engine),
        exits: exit_report::reported(plan, engine, options),
        share_alone: looped.alone as f64 / looped.particle_steps.max(1) as f64,
        rebuilds,
        listed,
        laws: engine.law_names().to_owned(),
        total_seconds: 0.0,
    }
}

/// Bonds in numbers, by the names of their entries.
fn bonds(engine: &Engine) -> Vec<(String, BondSummary)> {
    let counts = engine.part::<Bonds>().map_or(&[][..], Bonds::counts);
    let entries = engine.physics().plans.all::<BondPlan>().iter().zip(counts);
    let summary = entries.map(|(entry, counts)| {
        let summary = BondSummary {
            made: counts.made,
            broken: counts.broken,
            left: counts.left(),
        };
        (entry.name.clone(), summary)
    });
    summary.collect()
}

/// Grains that hang together, by their number.
fn fragments(engine: &Engine) -> Vec<FragmentSummary> {
    let sizes = (engine.part::<Bonds>()).map(|bonds| bonds.fragments(&engine.particles));
    let summary = |(grains, count)| FragmentSummary { grains, count };
    sizes.into_iter().flatten().map(summary).collect()
}

/// Worn walls in numbers.
fn wear(engine: &Engine) -> Vec<WearSummary> {
    let walls = &engine.physics().walls;
    let worn = engine.wear().into_iter().flat_map(|wear| &wear.walls);
    worn.map(|worn| {
        let row = worn.row();
        WearSummary {
            name: walls[worn.plan().wall].name.clone(),
            owed: row.owed,
            removed: row.removed,
            pending: row.pending,
            max_depth: row.max_depth,
            moves: row.moves,
            blocked: row.blocked,
        }
    })
    .collect()
}

/// Elastic sheets in numbers.
fn membranes(engine: &Engine) -> Vec<MembraneSummary> {
    let plans = engine.physics().plans.all::<MembranePlan>().iter();
    let sheets = plans.zip(engine.surfaces()).zip(engine.membranes());
    sheets
        .map(|((plan, surface), membrane)| {
            let seen = plan.sheet.seen(&surface.positions);
            MembraneSummary {
                name: plan.surface.name.clone(),
                area: seen.area,
                volume: plan.sheet.enclosed(&surface.positions).volume,
                pressure: membrane.pressure,
                min_stretch: seen.least_stretch,
                max_stretch: seen.largest_stretch,
            }
        })
        .collect()
}

/// The lines of a log before the result of the run.
pub(super) fn log_head(options: &RunOptions) -> String {
    let mut log = format!("mercury-solve {}\n", env!("CARGO_PKG_VERSION"));
    if !options.command_line.is_empty() {
        log += &format!("command: {}\n", options.command_line);
    }
    for note in &options.notes {
        log += &format!("{note}\n");
    }
    log
}

/// The lines of a log with the results.
pub(super) fn log_body(report: &Report) -> String {
    let steps = report.summary.steps;
    format!(
        "{report}\nlaws: {}\nneighbour list: built {} times, every {:.1} steps, {} pairs listed at the end\nwarnings: {}\n",
        report.laws,
        report.rebuilds,
        steps as f64 / report.rebuilds.max(1) as f64,
        report.listed,
        report.summary.warnings.len()
    )
}

//! What a run tells when it is over.

use std::fmt;

use mercury_common::readable::{duration, rounded};

use super::StopReason;
use super::budget::Budget;
use crate::output::summary::{Status, Summary};

/// A run that is over. Printed, it is the closing report.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// What `summary.json` says.
    pub summary: Summary,
    /// What stopped it, if it has not come to its end.
    pub stopped: Option<StopReason>,
    /// Time from which an interrupted run went on, s.
    pub resumed_at: Option<f64>,
    /// Budgets of mass and momentum.
    pub budget: Budget,
    /// Names of the files in the run's folder.
    pub files: Vec<String>,
    /// The folder, as the user named it.
    pub folder: String,
    /// What insertions brought, and whether their sizes are right, a line each.
    pub insertions: Vec<String>,
    /// What left by faces, deletions and planes, a line each.
    pub exits: Vec<String>,
    /// What servos were to hold and held, a line each.
    pub servos: Vec<String>,
    /// Why a run that would have ended at rest came to its end before.
    pub not_at_rest: Option<String>,
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
        let how = match (s.status, self.stopped) {
            (Status::Finished, _) => "finished",
            (_, Some(StopReason::File)) => "stopped by the file STOP",
            (_, Some(StopReason::TimeLimit)) => "stopped by the time limit",
            (Status::Stopped, _) => "stopped",
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
        if let (Some(lost), Some(work)) = (e.dissipated, e.wall_work) {
            writeln!(
                f,
                "  dissipated normal {:.4e}, tangential {:.4e}, rolling {:.4e} J; work of walls {work:.4e} J",
                lost.normal, lost.tangential, lost.rolling
            )?;
        }
        if let Some(error) = e.closure_error {
            writeln!(f, "  closure    {error:.1e} of the largest energy")?;
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
        if let Some(why) = &self.not_at_rest {
            writeln!(f, "  rest       not before the end: {why}")?;
        }
        for warning in &s.warnings {
            writeln!(f, "  warning    {warning}")?;
        }
        write!(f, "  files      {}: {}", self.folder, self.files.join(" "))
    }
}

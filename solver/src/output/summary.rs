//! `summary.json`: a run in numbers, under names that scripts rely on.

use serde::{Deserialize, Serialize, Serializer};

use mercury_engine::audit::Losses;
use mercury_engine::liquid::LiquidRow;

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// As planned.
    Finished,
    /// By a request.
    Stopped,
}

/// A run in numbers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// Title of the scene.
    pub title: String,
    /// Steps made.
    pub steps: u64,
    /// Simulated time, s.
    pub time: f64,
    /// Time step, s.
    pub time_step: f64,
    /// Particles at the end.
    pub particles: usize,
    /// Contacts between particles at the end.
    pub contacts: u64,
    /// Contacts with walls at the end.
    pub wall_contacts: u64,
    /// Duration of the time loop without start-up and output, s.
    pub wall_seconds: f64,
    /// Particles times steps in each of these seconds.
    pub particle_steps_per_second: f64,
    /// Threads.
    pub threads: usize,
    /// The ranks that made the run together, where there were several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ranks: Option<RanksSummary>,
    /// Twice the contacts between particles over the particles; 0 without particles.
    pub coordination_number: f64,
    /// Energies at the end.
    pub energy: EnergySummary,
    /// Particles that came in after the start of the scene.
    pub inserted: u64,
    /// Particles that went out.
    pub deleted: u64,
    /// Particles that were placed behind two-sided walls that moved through their insertion's region, if there are such walls.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inserted_behind_walls: Option<u64>,
    /// Where the liquid is, in scenes that have any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub liquid: Option<LiquidSummary>,
    /// Bonds by the names of their entries, in scenes that have any.
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "by_name")]
    pub bonds: Vec<(String, BondSummary)>,
    /// Grains that hang together by bonds, by their number; those without bonds are fragments of one grain.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub fragments: Vec<FragmentSummary>,
    /// Walls that wear, in scenes that have any.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub wear: Vec<WearSummary>,
    /// Elastic sheets, in scenes that have any.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub membranes: Vec<MembraneSummary>,
    /// Time behind which the scene schedules nothing, s: from it on `steady` windows count.
    pub settled: f64,
    /// Warnings for the user.
    pub warnings: Vec<String>,
    /// Requested numbers, by their names.
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "by_name")]
    pub results: Vec<(String, ResultValue)>,
    /// Results that end the run when they are known, in scenes that have such.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub until: Vec<UntilSummary>,
    /// [`PHYSICS`](super::chain::PHYSICS) of a run with a chain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub physics: Option<u32>,
    /// Last link of its chain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub link: Option<String>,
    /// The run from which it branched off.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub branch_of: Option<BranchOf>,
    /// How it ended.
    pub status: Status,
    /// Why it ended: `planned`, `at_rest`, `worn`, `known`, `request`, `file` (STOP) or `time_limit`.
    pub cause: &'static str,
}

/// Ranks that made a run together, and what they have sent since this process began: sums over all of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct RanksSummary {
    /// Their number.
    pub count: usize,
    /// Messages of steps: records, shares of contacts.
    pub messages: u64,
    /// Bytes of these.
    pub bytes: u64,
    /// Bytes of new lists.
    pub bytes_of_lists: u64,
    /// Bytes to the first rank for looks and checkpoints.
    pub bytes_of_looks: u64,
}

/// Where a run branched off from another one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BranchOf {
    /// Folder of the other run, as it was named.
    pub run: String,
    /// Step from which on the new scene holds.
    pub step: u64,
    /// Its time, s.
    pub time: f64,
    /// Link of the other run at this step or before; none before its first.
    pub link: Option<String>,
}

/// A result that ends a run when it is known.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UntilSummary {
    /// Its name.
    pub result: String,
    /// Standard error at which it is known, in its unit; none without a value.
    pub wanted: Option<f64>,
    /// Whether it ended the run.
    pub reached: bool,
    /// Simulated time that is missing, about, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub more: Option<f64>,
}

/// A requested number.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ResultValue {
    /// Definition of the value, as it was written.
    pub of: String,
    /// Its value; none if there is a problem.
    pub value: Option<f64>,
    /// Of the value; `1` of a plain number.
    pub unit: String,
    /// Why there is no value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub problem: Option<String>,
    /// Remark on the value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
    /// How well it is known; none without a value.
    #[serde(flatten)]
    pub estimate: Option<ResultEstimate>,
}

/// How well a requested number is known from one run.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct ResultEstimate {
    /// One standard error, in the unit of the value.
    pub error: Option<f64>,
    /// Why there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub why_no_error: Option<String>,
    /// The 95 % interval.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval: Option<[f64; 2]>,
    /// Number of independent batches.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub batches: Option<f64>,
    /// Times of the first and the last row that count, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub window: Option<[f64; 2]>,
    /// Start-up that was cut, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub warm_up: Option<f64>,
    /// Whether the rows are steady behind the start-up; in a window given in numbers, from its beginning.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steady: Option<bool>,
}

/// A list as an object whose members are in the order of the list.
fn by_name<S: Serializer, T: Serialize>(
    results: &[(String, T)],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_map(results.iter().map(|(name, value)| (name, value)))
}

/// Energies at the end of a run, J; fixed particles do not count. The budget is there only if the scene enables it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EnergySummary {
    /// Of translation.
    pub kinetic: f64,
    /// Of rotation.
    pub rotational: f64,
    /// In gravity, -sum m g.x.
    pub gravitational: f64,
    /// Stored in contacts.
    pub elastic: f64,
    /// Dissipated since the start, by what took it.
    #[serde(serialize_with = "losses_by_name")]
    pub dissipated: Option<Losses>,
    /// Work that the walls did on the particles.
    pub wall_work: Option<f64>,
    /// The part of it that walls with a servo did.
    pub servo_work: Option<f64>,
    /// Brought in by particles that came.
    pub inserted: Option<f64>,
    /// Energy of the particles that left, with the energy stored in their contacts.
    pub deleted: Option<f64>,
    /// The part of it that was stored in their contacts, by springs.
    pub deleted_elastic: Option<Springs>,
    /// Stored in contacts with walls that vanished.
    pub vanished_walls: Option<f64>,
    /// (initial + work + inserted - deleted - vanished - final - dissipated) over the largest energy of the run. Also null where
    /// work is done that is not measured: prescribed particles, gravity along a periodic axis.
    pub closure_error: Option<f64>,
}

fn losses_by_name<S: Serializer>(
    losses: &Option<Losses>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    match losses {
        Some(losses) => serializer.collect_map(losses.iter()),
        None => serializer.serialize_none(),
    }
}

/// Energy that springs of contacts store, J.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Springs {
    /// Normal forces, and bonds by adhesion, which count negative.
    pub normal: f64,
    /// Tangential springs.
    pub tangential: f64,
    /// Rolling and torsion springs.
    pub rolling: f64,
}

impl Springs {
    /// Of all springs, J.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.normal + self.tangential + self.rolling
    }
}

/// The liquid balance at the end of a run; volumes in m^3, as in the last row of `.liquid.csv`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LiquidSummary {
    /// At the start.
    pub initial: f64,
    /// In films.
    pub films: f64,
    /// In bridges.
    pub bridges: f64,
    /// On walls.
    pub wall_films: f64,
    /// In droplets in flight.
    pub in_flight: f64,
    /// On particles that were inserted.
    pub inserted: f64,
    /// In droplets that left the nozzles.
    pub emitted: f64,
    /// In droplets that particles caught.
    pub absorbed: f64,
    /// In droplets that were lost at walls.
    pub lost: f64,
    /// On particles and in droplets that left through a face of the domain.
    pub left: f64,
    /// On particles that were deleted in a region.
    pub deleted: f64,
    /// Evaporated.
    pub evaporated: f64,
    /// The present liquid and the losses, less the liquid at the start: round-off.
    pub error: f64,
    /// Bridges at the end.
    pub bridge_count: u64,
    /// Bridges that formed.
    pub formed: u64,
    /// Bridges that broke.
    pub ruptured: u64,
    /// Bridges that dried up.
    pub dried: u64,
    /// How often a bridge formed or took liquid that lies outside of the table of `young-laplace`.
    pub clamped: u64,
}

impl From<LiquidRow> for LiquidSummary {
    fn from(row: LiquidRow) -> Self {
        let [in_flight, emitted, absorbed, lost, left] = row.sprayed;
        Self {
            initial: row.balance.initial,
            films: row.films,
            bridges: row.bridges,
            wall_films: row.wall_films,
            in_flight,
            inserted: row.balance.inserted.value(),
            emitted,
            absorbed,
            lost,
            left: row.balance.left.value() + left,
            deleted: row.balance.deleted.value(),
            evaporated: row.balance.evaporated.value(),
            error: row.error,
            bridge_count: row.bridge_count,
            formed: row.balance.formed,
            ruptured: row.balance.ruptured,
            dried: row.balance.dried,
            clamped: row.balance.clamped,
        }
    }
}

/// Bonds of an entry at the end of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct BondSummary {
    /// Glued since the start.
    pub made: u64,
    /// Broken since the start, also by the removal of an end.
    pub broken: u64,
    /// Those that hold.
    pub left: u64,
}

/// Fragments of one size at the end of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct FragmentSummary {
    /// Grains of the fragment.
    pub grains: u64,
    /// Fragments of this size.
    pub count: u64,
}

/// A worn wall at the end of a run, as in the last rows of `.wear.csv`; volumes in m^3.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WearSummary {
    /// Its name.
    pub name: String,
    /// By the law, of all contacts.
    pub owed: f64,
    /// Signed volume between the first surface and the present one.
    pub removed: f64,
    /// Worn volume that has not yet moved the surface.
    pub pending: f64,
    /// Depth of the deepest vertex, m.
    pub max_depth: f64,
    /// Moves of the surface.
    pub moves: u64,
    /// Vertices that cannot move.
    pub blocked: u64,
}

/// An elastic sheet at the end of a run, as in the last rows of `.membranes.csv`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MembraneSummary {
    /// Its name.
    pub name: String,
    /// m^2
    pub area: f64,
    /// Enclosed volume, open rims closed by fans, m^3.
    pub volume: f64,
    /// Pa
    pub pressure: f64,
    /// Least length of an edge over its length without force.
    pub min_stretch: f64,
    /// Largest.
    pub max_stretch: f64,
}

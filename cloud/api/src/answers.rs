//! Bodies of answers.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::head::{Beat, Cause, Note};
use crate::lifecycle::RunState;
use crate::problem::SceneProblem;
use crate::requests::Role;
use crate::spec::Spec;

/// A run in a list.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RunRow {
    /// Its name.
    pub id: String,
    /// Title.
    pub title: String,
    /// A word that groups runs.
    pub label: String,
    /// The study that it belongs to.
    pub study: Option<String>,
    /// Name of its owner.
    pub owner: String,
    /// The project whose members see it.
    pub project: Option<String>,
    /// State.
    pub state: RunState,
    /// Unix time of its submission, in s.
    pub created: f64,
    /// Unix time of the last change, in s.
    pub changed: f64,
    /// Attempts so far.
    pub epoch: u64,
    /// Steps made.
    pub step: u64,
    /// Steps of the whole run, where it is known.
    pub of_steps: Option<u64>,
    /// Simulated time, in s.
    pub time: f64,
    /// Ranks of MPI of its attempts; 1: a single process.
    pub ranks: u32,
    /// Core seconds spent so far: processor time of the solver; of several ranks the time of their cores by the clock.
    pub core_seconds: f64,
    /// Time by the clock after which the run is stopped, in s; none: no limit.
    pub time_limit: Option<f64>,
    /// Cost of its attempts, in the currency of the server, where it has prices.
    pub cost: Option<f64>,
    /// Savings against the full price.
    pub saved: Option<f64>,
    /// Cause of the last attempt's end.
    pub cause: Option<Cause>,
    /// Message about that end.
    pub message: String,
    /// Seconds left, as the solver expects.
    pub seconds_left: Option<f64>,
    /// Reason for which its job waits in the queue of the engine, as that says it.
    pub waits: Option<String>,
    /// Particles at present.
    pub particles: Option<u64>,
    /// `--set` of this run.
    pub set: Vec<String>,
}

/// A project with its members.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ProjectRow {
    /// Its id in requests.
    pub id: String,
    /// Name, for people.
    pub name: String,
    /// Role of this user.
    pub role: Role,
    /// How many runs it has.
    pub runs: u64,
    /// Its members by name.
    pub members: Vec<MemberRow>,
}

/// A member of a project.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MemberRow {
    /// Name of the user.
    pub name: String,
    /// Role of the user.
    pub role: Role,
}

/// A page of a list.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RunList {
    /// At most 200 runs, newest first.
    pub runs: Vec<RunRow>,
    /// Value of `after` for the next page.
    pub after: Option<String>,
    /// How many runs there are in each state.
    pub states: BTreeMap<String, u64>,
}

/// All of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RunAnswer {
    /// As in lists.
    #[serde(flatten)]
    pub row: RunRow,
    /// Its specification.
    pub spec: Spec,
    /// Text of the scene.
    pub scene: String,
    /// The last sign of life, while it runs.
    pub beat: Option<Beat>,
    /// Notes of attempts.
    pub notes: Vec<Note>,
    /// Seconds since the server saw the run last, where that is longer than it should be.
    pub unseen: Option<f64>,
    /// Whether this user may change it.
    pub writable: bool,
}

/// An attempt of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Attempt {
    /// Its number.
    pub epoch: u64,
    /// Engine that ran it.
    pub engine: String,
    /// Unix time of its begin, in s.
    pub started: f64,
    /// Unix time of its end, in s.
    pub ended: Option<f64>,
    /// Why it ended.
    pub cause: Option<Cause>,
    /// Exit code of the solver.
    pub code: Option<i32>,
    /// Message about it.
    pub message: String,
    /// Machine.
    pub machine: String,
    /// Committed step at its end.
    pub step: Option<u64>,
    /// Its cost, in the currency of the server, where it has prices.
    pub cost: Option<f64>,
}

/// Prices of cores.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Price {
    /// Currency.
    pub currency: String,
    /// A core for an hour, where a new run goes first.
    pub core_hour: f64,
}

/// A file of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RunFile {
    /// Path within the folder of the run.
    pub name: String,
    /// Length in bytes.
    pub bytes: u64,
    /// Whether it may still grow.
    pub grows: bool,
}

/// Answer of `POST /check`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Checked {
    /// Problems; empty: the scene can run, or was not checked.
    pub problems: Vec<SceneProblem>,
    /// The plan, as `mercury-solve --check --json` gives it.
    #[schema(value_type = Option<Object>)]
    pub plan: Option<serde_json::Value>,
    /// Reason why the scene was not checked: it is too large for a check. It can be submitted, and its run says what is wrong.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unchecked: Option<String>,
}

/// Whether a run was verified.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// It was not verified since its end.
    #[default]
    Never,
    /// It is being verified.
    Running,
    /// Nothing differs.
    Verified,
    /// Something differs.
    Differs,
    /// It could not be verified.
    Unverifiable,
}

/// Answer of `GET /runs/R/verification`: the files of a finished run against its chain, and a share of its steps made again.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Verification {
    /// Result.
    pub verdict: Verdict,
    /// Unix time of its end, in s.
    pub at: Option<i64>,
    /// Share of the steps that were made again, 0 to 1.
    pub share: Option<f64>,
    /// Last link of the chain: equal links are equal runs.
    pub link: Option<String>,
    /// The first difference, or why it could not be verified.
    pub message: String,
}

/// Answer of `POST /studies/check`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StudyChecked {
    /// Problems; empty: all runs can run.
    pub problems: Vec<SceneProblem>,
    /// Keys that differ between the runs.
    pub keys: Vec<String>,
    /// Names of the runs.
    pub runs: Vec<String>,
    /// Names of the results.
    pub results: Vec<String>,
}

/// A study in a list.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StudyRow {
    /// Its name in paths.
    pub id: String,
    /// Title.
    pub title: String,
    /// Unix time of its submission, in s.
    pub created: f64,
    /// How many of its runs are in each state.
    pub states: BTreeMap<String, u64>,
}

/// A page of studies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StudyList {
    /// At most 200 studies, newest first.
    pub studies: Vec<StudyRow>,
    /// Value of `after` for the next page.
    pub after: Option<String>,
}

/// Answer of `POST /studies`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StudySubmitted {
    /// Its name in paths.
    pub id: String,
    /// Its runs, in the order of the table.
    pub runs: Vec<String>,
}

/// The table of a study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StudyTable {
    /// As in lists.
    #[serde(flatten)]
    pub row: StudyRow,
    /// Keys that differ between the runs.
    pub keys: Vec<String>,
    /// Results, in the order of their columns.
    pub results: Vec<ResultColumn>,
    /// Results to be drawn; empty: all.
    pub plots: Vec<String>,
    /// The runs that are still there.
    pub rows: Vec<StudyRun>,
    /// Means of the runs that differ in their `seed` alone; empty where each point has one run.
    pub means: Vec<StudyPoint>,
}

/// A point of a study: its runs differ in their `seed` alone. Seeds count in their order, up to the first without all results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StudyPoint {
    /// A value for each key but `seed`, as TOML; none: what the scene says.
    pub values: Vec<Option<String>>,
    /// How many seeds count.
    pub seeds: u64,
    /// How many of them the first point has, too: those of the differences.
    pub pairs: u64,
    /// A mean for each result.
    pub results: Vec<PointResult>,
}

/// A result of a point, as in the solver's `study.means.csv` and `study.differences.csv`. None: there are too few seeds for it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PointResult {
    /// Mean over the seeds.
    pub mean: Option<f64>,
    /// Standard error of the mean. Few seeds widen it, by Student's distribution.
    pub error: Option<f64>,
    /// Lower end of the 95 % interval.
    pub low: Option<f64>,
    /// Upper end of the 95 % interval.
    pub high: Option<f64>,
    /// Standard deviation of one seed.
    pub spread: Option<f64>,
    /// Root mean square of the errors that the runs have by themselves.
    pub within: Option<f64>,
    /// Mean difference from the first point, seed by seed.
    pub difference: Option<f64>,
    /// Standard error of that difference.
    pub difference_error: Option<f64>,
    /// Correlation of the two points over their seeds.
    pub correlation: Option<f64>,
}

/// A column of the table of a study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ResultColumn {
    /// Name.
    pub name: String,
    /// Its definition, as in `--result NAME=WHAT`.
    pub what: String,
    /// Unit, once a run has finished.
    pub unit: String,
}

/// A run in the table of a study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StudyRun {
    /// The run.
    pub id: String,
    /// Its name within the study.
    pub name: String,
    /// State.
    pub state: RunState,
    /// Why it failed.
    pub problem: String,
    /// Steps made.
    pub step: u64,
    /// Core seconds spent.
    pub core_seconds: f64,
    /// A value for each key, as TOML; none: what the scene says.
    pub values: Vec<Option<String>>,
    /// A value for each result.
    pub results: Vec<Option<f64>>,
    /// The standard error of each result, where its run alone gives one.
    pub errors: Vec<Option<f64>>,
    /// A remark on each result, or the reason why it has no value or no error.
    pub remarks: Vec<Option<String>>,
}

/// A scene to start from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Template {
    /// Name for `mercury-solve new`.
    pub name: String,
    /// Its quantity.
    pub title: String,
    /// Name of the scene file.
    pub scene: String,
    /// Text of the scene file.
    pub text: String,
    /// Further files: name to SHA-256; they are in the store already.
    pub files: BTreeMap<String, String>,
}

/// One thing that happened to a run, as `GET /events` sends it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct EventRow {
    /// Counts over all runs.
    pub id: i64,
    /// The run.
    pub run: String,
    /// Unix time, in s.
    pub time: f64,
    /// `state`, `attempt`, `progress`, `note`.
    pub kind: String,
    /// Its data.
    #[schema(value_type = Object)]
    pub data: serde_json::Value,
}

/// Columns of a table of a run, reduced for a chart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Chart {
    /// File.
    pub file: String,
    /// Column.
    pub column: String,
    /// Key of the rows (wall, region), where the table has one.
    pub name: Option<String>,
    /// Rows that the table has.
    pub rows: u64,
    /// Times, in s.
    pub time: Vec<f64>,
    /// Least value of each bin.
    pub min: Vec<Option<f64>>,
    /// Largest value of each bin.
    pub max: Vec<Option<f64>>,
}

/// A table that charts can be made of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TableInfo {
    /// File.
    pub file: String,
    /// Columns with numbers.
    pub columns: Vec<String>,
    /// Units of these columns; empty or `1`: none.
    pub units: Vec<String>,
    /// Values of the column `name` (walls, regions, planes), empty where the table has none.
    pub names: Vec<String>,
}

/// The user that is logged in.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Session {
    /// Name; empty for a link to a run, which shows nothing of its owner.
    pub user: String,
    /// Whether the user manages others.
    pub admin: bool,
    /// Whether the session may read only.
    pub read_only: bool,
    /// Cores that are free for runs, and all.
    pub cores: [u32; 2],
    /// The most ranks of a run; 1: runs are single processes.
    pub ranks: u32,
    /// Version of the solver.
    pub solver: String,
    /// Usage of this user.
    pub usage: Usage,
    /// Prices of cores, where the server has them.
    pub price: Option<Price>,
}

/// Usage of a user, and its limits.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Usage {
    /// Cores of runs that are on their way.
    pub cores: u64,
    /// The most cores at once; none: no limit.
    pub most_cores: Option<u64>,
    /// Length of all runs and inputs, in bytes.
    pub disk: u64,
    /// The most of them; none: no limit.
    pub most_disk: Option<u64>,
    /// Core seconds that all runs have spent, also those that were removed.
    pub core_seconds: f64,
    /// The most of them; none: no limit.
    pub most_core_seconds: Option<f64>,
    /// Their cost, in the currency of the server, where it has prices.
    pub cost: Option<f64>,
}

/// A user, for administrators.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct UserRow {
    /// Name.
    pub name: String,
    /// Whether the user manages others.
    pub admin: bool,
    /// Usage of the user.
    pub usage: Usage,
}

/// A content that a user has sent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct InputRow {
    /// SHA-256 of the content, 64 hexadecimal digits.
    pub sha256: String,
    /// Length in bytes.
    pub bytes: u64,
    /// How many runs of the user name it.
    pub runs: u64,
}

/// A session as lists show it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SessionRow {
    /// Its number.
    pub id: i64,
    /// Name of the token that it was begun with; none: a password, or the link of the machine.
    pub token: Option<String>,
    /// Unix time of its begin, in s.
    pub created: f64,
    /// Unix time of its end, in s.
    pub expires: f64,
    /// Whether it may read only.
    pub read_only: bool,
    /// Whether it is that of the request.
    pub current: bool,
}

/// A request that has changed something, as the audit log has it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct AuditRow {
    /// Its number; later ones are larger.
    pub id: i64,
    /// Unix time of its answer, in s.
    pub time: f64,
    /// Name of the user; `guest` for a link to a run, empty for a login that failed.
    pub user: String,
    /// Address of the client; of IPv6 its network.
    pub address: String,
    /// Method.
    pub method: String,
    /// Path, behind `/api/v1`.
    pub path: String,
    /// Status of the answer.
    pub status: u16,
}

/// A token, or a link to a run, as lists show it: without the secret.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TokenRow {
    /// Its number.
    pub id: i64,
    /// Its purpose.
    pub name: String,
    /// The run, of a link to one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub run: Option<String>,
    /// Unix time of its end, in s.
    pub expires: f64,
    /// Whether it may read only.
    pub read_only: bool,
    /// The secret, in the answer that makes the token only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub secret: Option<String>,
}

/// The web hook of a user.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Hook {
    /// Where ends of runs are sent; none: nowhere.
    pub url: Option<String>,
    /// The last deliveries, newest first; at most 100.
    pub deliveries: Vec<DeliveryRow>,
}

/// A message to the web hook of a user.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct DeliveryRow {
    /// Its number, which the message has as well.
    pub id: i64,
    /// The run; none: a test.
    pub run: Option<String>,
    /// State in which the run ended, or `test`.
    pub state: String,
    /// Unix time of the end, in s.
    pub created: f64,
    /// How often it was sent.
    pub tries: u32,
    /// Unix time at which it is sent again, in s; none: it is over.
    pub next: Option<f64>,
    /// Status of the last answer; none: there was none.
    pub status: Option<u16>,
    /// Reason for which it is not delivered; empty: it is.
    pub message: String,
}

/// The secret of a web hook, in the answer that sets the hook only.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct HookSecret {
    /// Key of the signatures of messages.
    pub secret: String,
}

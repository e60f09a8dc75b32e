//! Bodies of requests.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// A scene with its files, as `POST /check`, `POST /preview` and `POST /runs` take it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Name of the scene file.
    #[serde(default = "scene_name")]
    pub name: String,
    /// Text of the scene file.
    pub text: String,
    /// Further files: name to the SHA-256 of a content that was sent to `PUT /inputs/SHA256`.
    #[serde(default)]
    pub files: BTreeMap<String, String>,
    /// Arguments of `--set`, `key=value`.
    #[serde(default)]
    pub set: Vec<String>,
}

fn scene_name() -> String {
    "scene.toml".to_owned()
}

/// Body of `POST /check`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Check {
    /// The scene.
    pub scene: Scene,
    /// Whether to make the first steps, and say how long the run will take.
    #[serde(default)]
    pub trial: bool,
}

/// Body of `POST /runs`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Submit {
    /// The scene.
    pub scene: Scene,
    /// Title for lists; without it the scene's own, or the name of its file.
    #[serde(default)]
    pub title: Option<String>,
    /// A word that groups runs.
    #[serde(default)]
    pub label: Option<String>,
    /// Threads that compute.
    #[serde(default = "one")]
    pub threads: u32,
    /// Ranks of MPI, each with so many threads; more than one where the server offers that.
    #[serde(default = "one")]
    pub ranks: u32,
    /// Time by the clock after which the run is stopped, with a checkpoint, in s: that of its attempts since it was submitted, resumed or
    /// extended. Without it there is no limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_limit: Option<f64>,
    /// Arguments of `--result`, `name=what`.
    #[serde(default)]
    pub result: Vec<String>,
    /// The project whose members see the run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub project: Option<String>,
}

fn one() -> u32 {
    1
}

/// Body of `POST /studies` and `POST /studies/check`: a scene, and either a grid of values or a study file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Study {
    /// Scene and settings of all runs; its title names the study.
    pub base: Submit,
    /// A grid: arguments of `--sweep`, `key=a,b,c` or `key=a..b/n`, the first key slowest.
    #[serde(default)]
    pub sweep: Vec<String>,
    /// Text of a study file, as `mercury-solve study.toml` takes it; its scene is that of `base`.
    #[serde(default)]
    pub file: Option<String>,
}

/// Body of `POST /runs/R/extend`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Extend {
    /// The new end of simulated time, in s.
    pub end: f64,
}

/// Body of `POST /runs/R/branch`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct BranchOff {
    /// Simulated time of the branch, in s: up to there the new run is that one.
    pub at: f64,
    /// Changes of the scene, arguments of `--set`.
    #[serde(default)]
    pub set: Vec<String>,
    /// Title for lists; without it that of the run.
    #[serde(default)]
    pub title: Option<String>,
}

/// Body of `PATCH /runs/R`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Patch {
    /// A new title.
    #[serde(default)]
    pub title: Option<String>,
    /// A new label.
    #[serde(default)]
    pub label: Option<String>,
    /// Another project; empty: none. For the owner of the run.
    #[serde(default)]
    pub project: Option<String>,
}

/// Role of a member of a project.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Looks at runs, fetches and clones them.
    Viewer,
    /// Also submits to the project, stops, resumes, extends and deletes its runs.
    Member,
    /// Also chooses the members.
    Manager,
}

/// Body of `POST /projects`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewProject {
    /// Name, for people.
    pub name: String,
}

/// Body of `PUT /projects/P/members/NAME`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewMember {
    /// Role of the user.
    pub role: Role,
}

/// Body of `POST /session`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LogIn {
    /// The link's token, or an API token.
    #[serde(default)]
    pub token: Option<String>,
    /// Name of the user.
    #[serde(default)]
    pub name: Option<String>,
    /// Password of the user.
    #[serde(default)]
    pub password: Option<String>,
}

/// A value that is there, also where it is `null`.
fn given<'de, T: Deserialize<'de>, D: serde::Deserializer<'de>>(
    from: D,
) -> Result<Option<T>, D::Error> {
    T::deserialize(from).map(Some)
}

/// Body of `POST /users`. What is left out stays as it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewUser {
    /// Name: letters, digits, `. _ -`.
    pub name: String,
    /// Password, at least 10 characters. A new user needs one. A new one ends the sessions of the old one.
    #[serde(default)]
    pub password: Option<String>,
    /// Whether the user manages others.
    #[serde(default)]
    pub admin: Option<bool>,
    /// The most cores that the user's runs may have at once; `null`: no limit.
    #[serde(
        default,
        deserialize_with = "given",
        skip_serializing_if = "Option::is_none"
    )]
    #[schema(value_type = Option<u32>)]
    pub cores: Option<Option<u32>>,
    /// The most bytes that the user's runs and inputs may take; `null`: no limit.
    #[serde(
        default,
        deserialize_with = "given",
        skip_serializing_if = "Option::is_none"
    )]
    #[schema(value_type = Option<u64>)]
    pub disk: Option<Option<u64>>,
    /// The most core seconds that all runs of the user may spend, also those that were removed; `null`: no limit.
    #[serde(
        default,
        deserialize_with = "given",
        skip_serializing_if = "Option::is_none"
    )]
    #[schema(value_type = Option<f64>)]
    pub core_seconds: Option<Option<f64>>,
}

/// Body of `POST /tokens`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewToken {
    /// Its purpose.
    pub name: String,
    /// Days until it expires, at most 366.
    #[serde(default = "month")]
    pub days: u32,
    /// Whether it may read only.
    #[serde(default)]
    pub read_only: bool,
}

fn month() -> u32 {
    30
}

/// Body of `POST /links`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewLink {
    /// Whether the secrets of the machine are made anew, and the sessions of its user end.
    #[serde(default)]
    pub rotate: bool,
}

/// Body of `POST /runs/R/share`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewShare {
    /// Days until the link expires, at most 366.
    #[serde(default = "month")]
    pub days: u32,
}

/// Body of `PUT /hook`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewHook {
    /// Where ends of runs are sent: `https://`, at most 2,000 bytes. To the hosts of `serve --hooks-to` also `http://`.
    pub url: String,
}

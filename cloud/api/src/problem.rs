//! Errors in answers: `application/problem+json` (RFC 9457), with the solver's own problems where there are some.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// The body of an answer that is an error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Problem {
    /// The problem, in few words.
    pub title: String,
    /// Status of the answer.
    pub status: u16,
    /// Expected value, and a way out.
    #[serde(default)]
    pub detail: String,
    /// Where it is wrong, as the solver says it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub problems: Vec<SceneProblem>,
}

/// One thing that is wrong in a scene or in a file that it names.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default)]
pub struct SceneProblem {
    /// File, without folders.
    pub file: Option<String>,
    /// Line, from 1 on.
    pub line: Option<u64>,
    /// Column, from 1 on.
    pub column: Option<u64>,
    /// Key of the scene.
    pub key: Option<String>,
    /// The problem.
    pub message: String,
    /// A way out.
    pub help: Option<String>,
    /// The setting that is wrong, as it was given (`KEY=VALUE`), where it is none of the scene's text.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub set: Option<String>,
}

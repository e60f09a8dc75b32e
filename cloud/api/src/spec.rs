//! Specification of a run: its scene, its files, its limits. Never changed; a longer run has a further revision.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::RunId;

/// `runs/R/spec.<revision>.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Spec {
    /// Counts from 1; each extension of the run adds one.
    pub revision: u32,
    /// Title of the run, for lists.
    pub title: String,
    /// Name of the scene among the files.
    pub scene: String,
    /// Name (flat) to content.
    pub files: BTreeMap<String, InputFile>,
    /// Arguments of `--set`, `key=value`.
    #[serde(default)]
    pub set: Vec<String>,
    /// Columns of the results table of a study, arguments of `--result`.
    #[serde(default)]
    pub result: Vec<String>,
    /// Threads that compute.
    pub threads: u32,
    /// The most bytes that the outputs may take.
    pub disk: u64,
    /// The most bytes of memory; the worker sets it as a limit.
    pub memory: u64,
    /// Version of the solver that the run is bound to, as `mercury-solve --version` says it.
    pub solver: String,
    /// Where it branches off from another run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub branch: Option<Branch>,
}

/// Where a run branches off from another one. Needed until its first checkpoint is in the store.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Branch {
    /// The other run.
    #[schema(value_type = String)]
    pub run: RunId,
    /// Simulated time in s.
    pub at: f64,
    /// Changes of its scene, `key=value`.
    pub set: Vec<String>,
}

/// A file that a scene needs, by its content.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct InputFile {
    /// SHA-256 of the content, 64 hexadecimal digits.
    pub sha256: String,
    /// Length in bytes.
    pub bytes: u64,
}

/// The most memory of each of several ranks of a run, in bytes, where the run alone has at most `memory`: half of it, and its share of the other
/// half. Each rank has columns of all particles (250 bytes of 690 to 1,400 for a sphere), and the first one gathers what is written (200 bytes,
/// twice); contacts and lists are divided (`docs/theory/distribution.md`).
pub fn memory_of_rank(memory: u64, ranks: u32) -> u64 {
    memory / 2 + (memory / 2).div_ceil(u64::from(ranks.max(1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_rank_has_all_memory_and_each_of_many_half_of_it() {
        assert_eq!(memory_of_rank(1000, 1), 1000);
        assert_eq!(memory_of_rank(1000, 2), 750);
        assert_eq!(memory_of_rank(1000, 4), 625);
        assert_eq!(memory_of_rank(1000, 1000), 501);
    }
}

//! Origin of a run, at the head of its `plan.toml`: where its scene lay, and from which run it branched off.

use std::path::{Component, Path, PathBuf};

use super::RunOptions;
use crate::output::OutputError;
use crate::output::summary::BranchOf;
use serde::{Deserialize, Serialize};

/// Origin of a run.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Origin {
    /// Folder from which the scene names its files, seen from that of the run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scene_folder: Option<PathBuf>,
    /// The run from which it branched off.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub branch_of: Option<BranchOf>,
}

/// The lines for `plan.toml`, in front of all others.
pub(super) fn of(options: &RunOptions) -> Result<String, OutputError> {
    let origin = Origin {
        scene_folder: (options.scene_folder.as_ref())
            .map(|scene| seen_from(&options.folder, scene)),
        branch_of: options.branch_of.clone(),
    };
    // An inline table, as the lines of others follow.
    let value =
        toml::Value::try_from(&origin).map_err(|error| OutputError::Plan(error.to_string()))?;
    let table = value.as_table().into_iter().flatten();
    Ok(table
        .map(|(key, value)| format!("{key} = {value}\n"))
        .collect())
}

impl Origin {
    /// The origin of the run in a folder; nothing of one whose plan does not have it.
    #[must_use]
    pub fn read(folder: &Path) -> Self {
        let text = std::fs::read_to_string(folder.join("plan.toml"));
        let read = text.ok().and_then(|text| toml::from_str(&text).ok());
        read.unwrap_or_default()
    }
}

/// A folder as it is seen from another one, if both are there; else as it is.
fn seen_from(folder: &Path, other: &Path) -> PathBuf {
    let whole = |path: &Path| match path.as_os_str().is_empty() {
        true => Path::new(".").canonicalize(),
        false => path.canonicalize(),
    };
    let (Ok(from), Ok(to)) = (whole(folder), whole(other)) else {
        return other.to_owned();
    };
    let common = from.components().zip(to.components());
    let common = common.take_while(|(a, b)| a == b).count();
    if common == 0 {
        return to;
    }
    let up = from.components().skip(common).map(|_| Component::ParentDir);
    let path: PathBuf = up.chain(to.components().skip(common)).collect();
    match path.as_os_str().is_empty() {
        true => PathBuf::from("."),
        false => path,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_are_named_as_seen_from_the_run() {
        let place = tempfile::tempdir().unwrap();
        let at = |name: &str| place.path().join(name);
        std::fs::create_dir_all(at("a/run")).unwrap();
        std::fs::create_dir_all(at("b/c")).unwrap();
        let seen = |from, to| seen_from(&at(from), &at(to));
        assert_eq!(seen("a/run", "a"), Path::new(".."));
        assert_eq!(seen("a/run", "b/c"), Path::new("../../b/c"));
        assert_eq!(seen("a", "a"), Path::new("."));
        assert_eq!(seen("a", "a/run"), Path::new("run"));
        assert_eq!(seen("a", "gone"), at("gone"));
    }
}

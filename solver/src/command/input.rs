//! The input of the program: the text of a scene or a study, and the files that it may name.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::plan::{read_all, refusal};
use crate::run::SceneInput;
use mercury_common::cli::Failure;
use mercury_common::problem::Problem;
use mercury_common::scene::{
    Files, STANDARD_INPUT, Scene, SceneErrors, read_scene_from, read_scene_text,
};
use mercury_common::within::Within;

/// The text of a scene or a study.
#[derive(Debug, Clone)]
pub(crate) struct Input {
    /// The file, as it was named.
    pub(crate) path: PathBuf,
    /// Its text.
    pub(crate) text: String,
    files: Files,
}

impl Input {
    /// Reads the file, which must lie `within` a folder if one is named.
    pub(crate) fn read(path: &Path, within: Option<&Arc<Within>>) -> Result<Self, Failure> {
        lies_within(within, path)?;
        let text = read_scene_text(path).map_err(|errors| refused(&errors))?;
        Ok(Self {
            path: path.to_owned(),
            text,
            files: allowed(within),
        })
    }

    /// The scene of another run.
    pub(crate) fn of_run(input: &SceneInput) -> Self {
        Self {
            path: input.path.clone(),
            text: input.text.clone(),
            files: Files::MustExist,
        }
    }

    /// Reads standard input, whose files are looked for in the folder in which the program runs.
    pub(crate) fn of_standard_input(within: Option<&Arc<Within>>) -> Result<Self, Failure> {
        let text = read_scene_from(std::io::stdin().lock()).map_err(|errors| refused(&errors))?;
        Ok(Self {
            path: PathBuf::from(STANDARD_INPUT),
            text,
            files: allowed(within),
        })
    }

    /// The scene that it is, with these `KEY=VALUE` on top. Where its keys are wrong, what the plan would find is reported with them.
    pub(crate) fn scene(&self, overrides: &[String]) -> Result<Scene, Failure> {
        read_all(&self.path, &self.text, overrides, self.files.clone())
            .map_err(|errors| refused(&errors))
    }
}

/// Files that may be named.
fn allowed(within: Option<&Arc<Within>>) -> Files {
    within.map_or(Files::MustExist, |within| Files::Within(Arc::clone(within)))
}

/// A scene that cannot be run.
pub(crate) fn refused(errors: &SceneErrors) -> Failure {
    Failure::input(refusal(errors)).with_problems(Problem::of_scene(errors))
}

/// Refuses a file or folder that lies outside of the one that --within names.
pub(crate) fn lies_within(within: Option<&Arc<Within>>, path: &Path) -> Result<(), Failure> {
    let Some(Err(outside)) = within.map(|within| within.check(path)) else {
        return Ok(());
    };
    let problem = Problem {
        file: Some(path.display().to_string()),
        message: outside.to_string(),
        ..Problem::default()
    };
    Err(Failure::input(format!("{}: {outside}", path.display())).with_problems(vec![problem]))
}

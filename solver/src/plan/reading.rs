//! Reads scenes with the laws that this solver has.

use std::path::Path;

use mercury_common::scene::{Files, Scene, SceneErrors, parse_scene_with, read_scene_with};

use mercury_engine::contact::law_keys;

/// Reads a scene file with the `KEY=VALUE` of the command line put on top, in their order.
///
/// # Errors
/// All mistakes of the file and the command line at once.
pub fn read_scene(path: &Path, overrides: &[String]) -> Result<Scene, SceneErrors> {
    read_scene_with(&law_keys(), path, overrides)
}

/// Reads a scene from its text. `path` names it in messages and gives the folder of its files.
///
/// # Errors
/// As [`read_scene`].
pub fn parse_scene(
    path: &Path,
    text: &str,
    overrides: &[String],
    files: Files,
) -> Result<Scene, SceneErrors> {
    parse_scene_with(&law_keys(), path, text, overrides, files)
}

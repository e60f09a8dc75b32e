//! All mistakes of a scene in one round: those of its keys, and those that only its plan finds.

use std::path::Path;

use mercury_common::scene::{Files, Scene, SceneError, SceneErrors, mend_scene_with};

use super::{parse_scene, sketch};
use mercury_engine::contact::law_keys;

/// Scales of the numbers that stand in for wrong ones: what is wrong with both, in the same words, does not depend on them.
const SCALES: [f64; 2] = [1.0, 1.0 / 16.0];

/// Bytes of a scene that is read again and again for that: more than a scene has that was typed.
const LONGEST: usize = 1_000_000;

/// Reads a scene from its text, as [`parse_scene`] does.
///
/// # Errors
/// Where its keys are wrong, also what the plan would find.
pub fn read_all(
    path: &Path,
    text: &str,
    overrides: &[String],
    files: Files,
) -> Result<Scene, SceneErrors> {
    parse_scene(path, text, overrides, files.clone())
        .map_err(|errors| all_mistakes(errors, path, text, overrides, &files))
}

/// Mistakes that the plan finds in a scene beside `errors`, which the reader has found. Of a scene whose mistakes cannot be put right
/// one by one, or that is longer than a megabyte, `errors` alone.
#[must_use]
fn all_mistakes(
    errors: SceneErrors,
    path: &Path,
    text: &str,
    overrides: &[String],
    files: &Files,
) -> SceneErrors {
    if text.len() > LONGEST {
        return errors;
    }
    let found = |scale: f64| -> Option<Vec<SceneError>> {
        let laws = law_keys();
        let mended = mend_scene_with(&laws, path, text, overrides, files.clone(), scale)?;
        let errors = sketch(&mended.scene)
            .err()
            .map_or_else(Vec::new, |errors| errors.0);
        let own = errors.into_iter().filter(|error| !mended.has_caused(error));
        Some(own.collect())
    };
    let [first, second] = SCALES;
    let Some(first) = found(first).filter(|first| !first.is_empty()) else {
        return errors;
    };
    let Some(second) = found(second) else {
        return errors;
    };
    let is_in_both = |error: &SceneError| second.contains(error);
    errors.and(first.into_iter().filter(is_in_both).collect())
}

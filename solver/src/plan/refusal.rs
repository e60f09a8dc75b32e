//! A scene that cannot be run, in the words its user reads.

use mercury_common::scene::SceneErrors;

/// All mistakes of a scene, each with its place, and how many there are. No line end behind the last line.
#[must_use]
pub fn refusal(errors: &SceneErrors) -> String {
    let count = match errors.0.len() {
        1 => "1 problem; nothing was run".to_owned(),
        count => format!("{count} problems; nothing was run"),
    };
    format!("{errors}\n{count}")
}

//! Reading the next frame while the last one is written.

use std::sync::mpsc::sync_channel;

use mercury_common::error::FormatError;

use crate::{ExportError, Selection, Snapshot, Source};

/// What an export of frames did.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Told {
    /// Frames that were given out.
    pub frames: usize,
    /// What is wrong with the rest of the input.
    pub damage: Option<FormatError>,
    /// Frames that are in the files: fewer than `frames` in a film strip.
    pub written: usize,
    /// What the user should know.
    pub notes: Vec<String>,
    /// What the user must know: something is not in the files that was asked for.
    pub warnings: Vec<String>,
}

/// The warning when a selection leaves nothing.
pub(crate) const NOBODY: &str = "no particle is selected in any frame";

/// Gives the selected frames with the selected particles to `write`, in order, one after the other; a thread reads ahead by
/// one frame. A damaged input gives its good frames, and what is wrong in [`Told::damage`].
///
/// # Errors
/// The first error of `write` or of the selection; the damage itself if there is no good frame; when no frame is selected.
pub fn for_each_snapshot(
    source: &Source,
    selection: &Selection,
    mut write: impl FnMut(Snapshot) -> Result<(), ExportError>,
) -> Result<Told, ExportError> {
    let mut told = Told::default();
    let (mut before, mut after) = (0, 0);
    std::thread::scope(|scope| {
        let (sender, receiver) = sync_channel(1);
        scope.spawn(move || {
            for item in source.frames(selection.frames) {
                // The receiver is gone after an error of its own.
                if sender.send(item).is_err() {
                    break;
                }
            }
        });
        for item in receiver {
            match item {
                Ok(mut snapshot) => {
                    before += snapshot.frame.rows();
                    selection.apply(&mut snapshot)?;
                    after += snapshot.frame.rows();
                    write(snapshot)?;
                    told.frames += 1;
                }
                Err(damage) => told.damage = Some(damage),
            }
        }
        Ok::<(), ExportError>(())
    })?;
    if before > 0 && after == 0 {
        told.warnings.push(NOBODY.to_owned());
    }
    told.written = told.frames;
    match (told.frames, told.damage) {
        (0, Some(damage)) => Err(damage.into()),
        (0, None) => Err(ExportError::Input(no_frame(source))),
        (_, damage) => Ok(Told { damage, ..told }),
    }
}

fn no_frame(source: &Source) -> String {
    let name = source.path().display();
    match source.len_hint() {
        Some(0) => format!("{name}: the input has no frame"),
        Some(count) => format!("{name}: no frame is selected; there are 0 to {}", count - 1),
        None => format!("{name}: no frame is selected, or the input has none"),
    }
}

//! Tables beside the particles: messages when one is missing, or ends before the particles do.

use mercury_common::frames::FrameReader;
use mercury_common::readable::counted;

use crate::{ExportError, Source};

/// Advice where a run has no bonds.
pub(crate) const NO_BONDS: &str =
    "[[bonds]] in the scene and bonds = true in [output] make a run write them";

/// Error of a missing table (`contacts`, `bodies`) beside the particles. `why` is the likely cause, `help` the advice.
pub(crate) fn missing(source: &Source, kind: &str, why: &str, help: &str) -> ExportError {
    let path = source.path().display();
    let folder = source.folder();
    let table = folder.join(format!("{}.{kind}.arrow", source.prefix()));
    let is_data = matches!(source, Source::Data(_));
    if matches!(source, Source::Lammps(_)) {
        return ExportError::Input(format!("{path}: this file holds no {kind}\nhelp: {help}"));
    }
    ExportError::Input(if is_data && table.exists() {
        format!(
            "{path}: a .data file holds no {kind}; those of this run lie in {}\nhelp: give the run folder: {}",
            table.display(),
            folder.display()
        )
    } else if is_data {
        format!("{path}: a .data file holds no {kind}\nhelp: {help}")
    } else {
        format!("{path}: no file of {kind} beside the particles{why}\nhelp: {help}")
    })
}

/// A warning if a table was cut and the frames up to the time `last` (s) need more than is left of it. `what` names the
/// frames, `lost` what is done without them.
pub(crate) fn cut(
    table: &FrameReader,
    what: &str,
    lost: &str,
    last: Option<f64>,
) -> Option<String> {
    let damage = table.damage()?;
    let end = table.infos().last().map(|info| info.time);
    if end.is_some_and(|end| last.is_none_or(|last| last <= end)) {
        return None;
    }
    Some(match end {
        Some(end) => {
            let count = counted(table.len(), "frame");
            format!(
                "only the first {count} of {what} could be used, up to t = {end} s; {lost}\n{damage}"
            )
        }
        None => format!("no frame of {what} could be used; {lost}\n{damage}"),
    })
}

//! The files of a run by their names: which file of a folder holds its particles, which files make one series, which run they are of.

use std::path::{Path, PathBuf};

use crate::error::FormatError;

/// How the name of a run's native frames of particles ends.
pub const FRAMES: &str = ".particles.arrow";

/// Endings of files of particles, the first in a folder counting before the others: native frames, `.data`, the same packed, and the first
/// file of a series.
pub const PARTICLES: [&str; 5] = [FRAMES, ".data", ".data.gz", ".data.0000", ".data.0"];

/// The file of a folder that holds the particles of its run.
///
/// ```
/// use mercury_common::run_files::particles_in;
///
/// let folder = tempfile::tempdir()?;
/// for name in ["drum.data", "drum.particles.arrow", "drum.ene"] {
///     std::fs::write(folder.path().join(name), "")?;
/// }
/// assert!(particles_in(folder.path())?.ends_with("drum.particles.arrow"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the folder cannot be read, holds no particles, or those of several runs.
pub fn particles_in(folder: &Path) -> Result<PathBuf, FormatError> {
    let failed =
        |error| FormatError::of_file(folder, format!("the folder cannot be read: {error}"));
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        paths.push(entry.map_err(failed)?.path());
    }
    paths.sort();
    for ending in PARTICLES {
        let has = |path: &&PathBuf| path.to_string_lossy().ends_with(ending);
        let mut found = paths.iter().filter(has);
        match (found.next(), found.next()) {
            (None, _) => {}
            (Some(path), None) => return Ok(path.clone()),
            (Some(first), Some(second)) => {
                let found = format!("several runs: {}, {}", first.display(), second.display());
                let help = "name the file instead of the folder";
                return Err(FormatError::of_file(folder, found).with_help(help));
            }
        }
    }
    Err(FormatError {
        expected: "a folder of mercury-solve, with a .particles.arrow or .data file".to_owned(),
        ..FormatError::of_file(folder, "no particles in this folder")
    })
}

/// The number behind `.data.` of a file of a series, and the digits that it is written with.
///
/// ```
/// use mercury_common::run_files::series_number;
///
/// assert_eq!(series_number("chute.data.0012"), Some((12, 4)));
/// assert_eq!(series_number("chute.data.gz"), None);
/// ```
#[must_use]
pub fn series_number(name: &str) -> Option<(u64, usize)> {
    let (_, number) = name.rsplit_once(".data.")?;
    let digits = number.bytes().all(|b| b.is_ascii_digit());
    let value: u64 = number.parse().ok().filter(|_| digits)?;
    Some((value, number.len()))
}

/// A `.data` file, and of a numbered series (`NAME.data.0`, `NAME.data.1`, ...) those that follow it without a gap.
#[must_use]
pub fn series_from(path: &Path) -> Vec<PathBuf> {
    let name = file_name(path);
    let Some((first, digits)) = series_number(&name) else {
        return vec![path.to_owned()];
    };
    let (stem, _) = name.rsplit_once('.').unwrap_or((&name, ""));
    // MercuryDPM pads to four digits or not at all, and writes longer numbers in full.
    let width = if digits >= 4 { 4 } else { 0 };
    let file = |k: u64| path.with_file_name(format!("{stem}.{k:0width$}"));
    let files = (first..=u64::MAX).map(file);
    files.take_while(|path| path.exists()).collect()
}

/// What the names of all files of a run begin with, by the name of its file of particles (or `.restart`).
///
/// ```
/// use std::path::Path;
/// use mercury_common::run_files::prefix;
///
/// for name in ["drum.particles.arrow", "drum.data", "drum.data.gz", "drum.data.0000", "drum.restart"] {
///     assert_eq!(prefix(&Path::new("runs").join(name)), "drum");
/// }
/// ```
#[must_use]
pub fn prefix(path: &Path) -> String {
    let mut name = file_name(path);
    let ends = [FRAMES, ".restart"];
    let end = ends.iter().find_map(|ending| name.strip_suffix(ending));
    let end = end.map_or_else(|| name.rfind(".data"), |prefix| Some(prefix.len()));
    name.truncate(end.unwrap_or(name.len()));
    name
}

fn file_name(path: &Path) -> String {
    path.file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(names: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for name in names {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        folder
    }

    #[test]
    fn the_best_file_of_a_folder_is_taken() {
        for (names, expected) in [
            (
                &["a.data", "a.particles.arrow", "a.contacts.arrow"][..],
                "a.particles.arrow",
            ),
            (&["a.data.gz", "a.data", "b.ene"], "a.data"),
            (&["a.data.gz", "a.fstat.gz"], "a.data.gz"),
            (&["a.data.0001", "a.data.0000"], "a.data.0000"),
            (&["a.data.0", "a.data.1"], "a.data.0"),
        ] {
            let folder = folder(names);
            assert_eq!(
                particles_in(folder.path()).unwrap(),
                folder.path().join(expected)
            );
        }
    }

    #[test]
    fn folders_without_one_run_are_refused() {
        for (names, expected) in [
            (&["a.ene"][..], "no particles in this folder"),
            (&["a.data", "b.data"], "several runs"),
        ] {
            let folder = folder(names);
            let error = particles_in(folder.path()).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
        let error = particles_in(Path::new("nowhere")).unwrap_err().to_string();
        assert!(error.contains("the folder cannot be read"), "{error}");
    }

    #[test]
    fn series_end_at_the_first_gap() {
        let names = [
            "a.data.8",
            "a.data.9",
            "a.data.10",
            "a.data.12",
            "b.data.11",
        ];
        let folder = folder(&names);
        let found = series_from(&folder.path().join("a.data.8"));
        let expected: Vec<_> = names[..3]
            .iter()
            .map(|name| folder.path().join(name))
            .collect();
        assert_eq!(found, expected);
        let padded = self::folder(&["a.data.9998", "a.data.9999", "a.data.10000"]);
        assert_eq!(series_from(&padded.path().join("a.data.9998")).len(), 3);
        let single = folder.path().join("a.data");
        assert_eq!(series_from(&single), [single]);
    }
}

//! The files of a run by their names: which file of a folder holds its particles, which files make one series, which run they are of.

use std::path::{Path, PathBuf};

use crate::error::FormatError;

/// How the name of a run's native frames of particles ends.
pub const FRAMES: &str = ".particles.arrow";

/// Endings of files of particles, the first in a folder counting before the others: native frames, `.data`, and the first file of a series; the text
/// files may be packed, see [`Packing`].
pub const PARTICLES: [&str; 4] = [FRAMES, ".data", ".data.0000", ".data.0"];

/// A way in which text files are packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Packing {
    /// `gzip`.
    Gzip,
    /// `zstd`.
    Zstd,
    /// `xz`.
    Xz,
    /// `bzip2`.
    Bzip2,
}

impl Packing {
    /// All of them, in the order in which files are looked for.
    pub const ALL: [Self; 4] = [Self::Gzip, Self::Zstd, Self::Xz, Self::Bzip2];

    /// Ending that is appended to the name of a file.
    #[must_use]
    pub fn ending(self) -> &'static str {
        match self {
            Self::Gzip => ".gz",
            Self::Zstd => ".zst",
            Self::Xz => ".xz",
            Self::Bzip2 => ".bz2",
        }
    }

    /// The bytes that a packed file begins with.
    #[must_use]
    pub fn magic(self) -> &'static [u8] {
        match self {
            Self::Gzip => &[0x1f, 0x8b],
            Self::Zstd => &[0x28, 0xb5, 0x2f, 0xfd],
            Self::Xz => &[0xfd, b'7', b'z', b'X', b'Z', 0],
            Self::Bzip2 => b"BZh",
        }
    }

    /// The command that unpacks a file.
    #[must_use]
    pub fn command(self) -> &'static str {
        match self {
            Self::Gzip => "gunzip",
            Self::Zstd => "unzstd",
            Self::Xz => "unxz",
            Self::Bzip2 => "bunzip2",
        }
    }

    /// How a file is packed that begins with these bytes.
    #[must_use]
    pub fn of(start: &[u8]) -> Option<Self> {
        // Files of zstd may begin with a frame that is to be passed over (RFC 8878, 3.1.2).
        if let [0x50..=0x5f, 0x2a, 0x4d, 0x18, ..] = start {
            return Some(Self::Zstd);
        }
        let mut all = Self::ALL.into_iter();
        all.find(|packing| start.starts_with(packing.magic()))
    }
}

/// The name without the ending of a packed file, and that ending: `chute.data` and `.gz` of `chute.data.gz`.
///
/// ```
/// use mercury_common::run_files::plain_name;
///
/// assert_eq!(plain_name("chute.data.0012.xz"), ("chute.data.0012", ".xz"));
/// assert_eq!(plain_name("chute.data"), ("chute.data", ""));
/// ```
#[must_use]
pub fn plain_name(name: &str) -> (&str, &str) {
    let mut endings = Packing::ALL.into_iter().map(Packing::ending);
    let found = endings.find_map(|ending| Some((name.strip_suffix(ending)?, ending)));
    found.unwrap_or((name, ""))
}

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
    let packings = [""].into_iter();
    let packings = packings.chain(Packing::ALL.map(Packing::ending));
    let packings: Vec<&str> = packings.collect();
    let endings = PARTICLES.iter().flat_map(|ending| {
        let count = if *ending == FRAMES { 1 } else { packings.len() };
        packings[..count]
            .iter()
            .map(move |packing| format!("{ending}{packing}"))
    });
    for ending in endings {
        let has = |path: &&PathBuf| path.to_string_lossy().ends_with(&ending);
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

/// The number behind `.data.` of a file of a series, packed or not, and the digits that it is written with.
///
/// ```
/// use mercury_common::run_files::series_number;
///
/// assert_eq!(series_number("chute.data.0012"), Some((12, 4)));
/// assert_eq!(series_number("chute.data.7.gz"), Some((7, 1)));
/// assert_eq!(series_number("chute.data.gz"), None);
/// ```
#[must_use]
pub fn series_number(name: &str) -> Option<(u64, usize)> {
    let (_, number) = plain_name(name).0.rsplit_once(".data.")?;
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
    let (plain, packing) = plain_name(&name);
    let (stem, _) = plain.rsplit_once('.').unwrap_or((plain, ""));
    // MercuryDPM pads to four digits or not at all, and writes longer numbers in full.
    let width = if digits >= 4 { 4 } else { 0 };
    let file = |k: u64| path.with_file_name(format!("{stem}.{k:0width$}{packing}"));
    let files = (first..=u64::MAX).map(file);
    files.take_while(|path| path.exists()).collect()
}

/// Common beginning of the names of all files of a run, from the name of its file of particles (or `.restart`).
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
            (&["a.data.xz", "a.data.zst"], "a.data.zst"),
            (&["a.data.0.bz2", "a.data.1.bz2"], "a.data.0.bz2"),
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
        let packed = self::folder(&["a.data.0.xz", "a.data.1.xz", "a.data.2"]);
        assert_eq!(series_from(&packed.path().join("a.data.0.xz")).len(), 2);
        let padded = self::folder(&["a.data.9998", "a.data.9999", "a.data.10000"]);
        assert_eq!(series_from(&padded.path().join("a.data.9998")).len(), 3);
        let single = folder.path().join("a.data");
        assert_eq!(series_from(&single), [single]);
    }
}

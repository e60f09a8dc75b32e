//! The folder of a run: what may be there before, and what may be removed.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Why a run cannot use a folder.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// A run is there already.
    #[error(
        "{}: this folder holds a run already (there is a {found})\nhelp: --force replaces it, --output DIR writes elsewhere",
        path.display()
    )]
    HoldsRun {
        /// The folder.
        path: PathBuf,
        /// A file of that run.
        found: String,
    },
    /// The name belongs to something else.
    #[error("{}: this is not a folder\nhelp: choose another one with --output DIR", path.display())]
    NotAFolder {
        /// The name.
        path: PathBuf,
    },
    /// The operating system refused.
    #[error("{}: {action}: {source}\nhelp: choose another folder with --output DIR", path.display())]
    System {
        /// The folder or file.
        path: PathBuf,
        /// What was tried.
        action: &'static str,
        /// What the system said.
        source: io::Error,
    },
}

/// Endings of the files that a run writes behind its prefix.
const ENDINGS: [&str; 20] = [
    "data",
    "ene",
    "fstat",
    "particles.arrow",
    "contacts.arrow",
    "walls.arrow",
    "surfaces.arrow",
    "bodies.arrow",
    "clumps.arrow",
    "triangle_loads.arrow",
    "track.csv",
    "walls.csv",
    "regions.csv",
    "flux.csv",
    "0.restart",
    "1.restart",
    "final.png",
    "final.svg",
    "energy.png",
    "energy.svg",
];

/// Files that every run writes under the same name.
const FIXED_NAMES: [&str; 3] = ["plan.toml", "summary.json", "run.log"];

/// All names that a run with this prefix may write.
pub fn names(prefix: &str) -> impl Iterator<Item = String> + '_ {
    let fixed = FIXED_NAMES.iter().map(|&name| name.to_owned());
    fixed.chain(
        ENDINGS
            .iter()
            .map(move |ending| format!("{prefix}.{ending}")),
    )
}

/// The names of a run with this prefix that are in the folder.
#[must_use]
pub fn present(folder: &Path, prefix: &str) -> Vec<String> {
    // Also links that lead nowhere count: they are in the way.
    names(prefix)
        .filter(|name| folder.join(name).symlink_metadata().is_ok())
        .collect()
}

/// Makes a folder ready for a run: there, writable, without a run.
///
/// With `force` the files of an earlier run are removed, and nothing but these.
///
/// # Errors
/// If the folder holds a run and `force` is off, is no folder, or cannot be made, emptied or written.
pub fn prepare(folder: &Path, prefix: &str, force: bool) -> Result<(), FolderError> {
    let system = |path: &Path, action, source| FolderError::System {
        path: path.to_owned(),
        action,
        source,
    };
    if folder.exists() && !folder.is_dir() {
        return Err(FolderError::NotAFolder {
            path: folder.to_owned(),
        });
    }
    fs::create_dir_all(folder)
        .map_err(|source| system(folder, "the folder cannot be made", source))?;
    let present = present(folder, prefix);
    if let (Some(found), false) = (present.first(), force) {
        return Err(FolderError::HoldsRun {
            path: folder.to_owned(),
            found: found.clone(),
        });
    }
    let probe = folder.join(format!(".mercury-{}", std::process::id()));
    fs::write(&probe, b"")
        .and_then(|()| fs::remove_file(&probe))
        .map_err(|source| system(folder, "nothing can be written in the folder", source))?;
    for name in present {
        let path = folder.join(name);
        fs::remove_file(&path)
            .map_err(|source| system(&path, "the file cannot be removed", source))?;
    }
    Ok(())
}

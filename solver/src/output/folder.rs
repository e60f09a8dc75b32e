//! The folder of a run: the files that may be there before, and those that may be removed.

mod lock;

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use mercury_common::paraview::Series;
use mercury_common::run_tables::RESULTS;
use mercury_common::scene::is_json;
use mercury_common::whole_file::{FileError, TEMPORARY, write_whole};

use super::STREAMS;
use super::chain::{CHAIN, kept_checkpoints, kept_folder};
pub use lock::FolderLock;
pub use mercury_common::folder_owner::{LOCK, Owner};

/// Why a run cannot use a folder.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// A run is there already.
    #[error(
        "{}: this folder holds a run already (there is a {found})\nhelp: --resume goes on with it, --force replaces it, --output DIR writes elsewhere",
        path.display()
    )]
    HoldsRun {
        /// The folder.
        path: PathBuf,
        /// A file of that run.
        found: String,
    },
    /// The run in the folder is of another scene, so that this one cannot continue it.
    #[error(
        "{}: the run in this folder is one of `{other}`, not of `{prefix}`, and cannot be resumed as such\nhelp: --output DIR names the folder of the run to go on with, or an empty one; --force replaces what is here",
        path.display()
    )]
    OfAnotherScene {
        /// The folder.
        path: PathBuf,
        /// Whose run it is.
        other: String,
        /// The prefix of this run.
        prefix: String,
    },
    /// Another run writes into the folder at this moment.
    #[error(
        "{}: this folder is being written by another run{}\nhelp: wait for its end or stop it, or choose another folder with --output DIR{}",
        path.display(), by(owner), if_dead(owner)
    )]
    InUse {
        /// The folder.
        path: PathBuf,
        /// That run.
        owner: Owner,
    },
    /// Another study writes its table there at this moment.
    #[error(
        "{}: another study is being run in this folder{}\nhelp: wait for its end or stop it, or choose another folder with --output DIR{}",
        path.display(), by(owner), if_dead(owner)
    )]
    OfAnotherStudy {
        /// The folder.
        path: PathBuf,
        /// That study.
        owner: Owner,
    },
    /// The name belongs to something else.
    #[error("{}: this is not a folder\nhelp: choose another one with --output DIR", path.display())]
    NotAFolder {
        /// The name.
        path: PathBuf,
    },
    /// There is a link to a missing target in its place.
    #[error("{}: this link leads to {}, which is not there\nhelp: make that folder, remove the link, or choose another folder with --output DIR", path.display(), target.display())]
    LeadsNowhere {
        /// The link.
        path: PathBuf,
        /// Where it leads.
        target: PathBuf,
    },
    /// The operating system refused.
    #[error("{}: {action}: {source}\nhelp: choose another folder with --output DIR", path.display())]
    System {
        /// The folder or file.
        path: PathBuf,
        /// Failed action.
        action: &'static str,
        /// Error of the system.
        source: io::Error,
    },
}

/// Endings of files of a run behind its prefix, beside those of its [`STREAMS`].
const ENDINGS: &[&str] = &[
    "scene.toml",
    "scene.json",
    // Beside the streams of walls and bodies: the surfaces that their rows refer to.
    "surfaces.arrow",
    "clumps.arrow",
    "0.restart",
    "1.restart",
    CHAIN,
    // Written as a whole at each look.
    RESULTS.file,
    "final.png",
    "final.svg",
    "energy.png",
    "energy.svg",
];

/// Files that every run writes under the same name.
const FIXED_NAMES: [&str; 3] = ["plan.toml", "summary.json", "run.log"];

/// Keeps the text of a scene beside what its run writes, as `<prefix>.scene.toml` or `.scene.json`.
///
/// # Errors
/// If the file cannot be written.
pub fn copy_scene(folder: &Path, prefix: &str, text: &str) -> Result<(), FileError> {
    let (ending, other) = match is_json("", text) {
        true => ("json", "toml"),
        false => ("toml", "json"),
    };
    // The run that is resumed may have been begun from the other kind.
    let _ = fs::remove_file(folder.join(format!("{prefix}.scene.{other}")));
    write_whole(
        &folder.join(format!("{prefix}.scene.{ending}")),
        text.as_bytes(),
    )
}

/// Whether a file belongs to the run that is in the folder: its own copy of a scene, for example.
#[must_use]
pub fn is_of_earlier_run(folder: &Path, file: &Path) -> bool {
    let place = |path: &Path| path.canonicalize().ok();
    let beside = file.parent().and_then(|beside| match beside {
        empty if empty == Path::new("") => place(Path::new(".")),
        beside => place(beside),
    });
    let name = file.file_name().map(|name| name.to_string_lossy());
    let (Some(beside), Some(name), Some(prefix)) = (beside, name, earlier_prefix(folder)) else {
        return false;
    };
    Some(beside) == place(folder) && names(&prefix).any(|of_run| of_run == name)
}

/// All names that a run with this prefix may write, but for the files for ParaView.
pub fn names(prefix: &str) -> impl Iterator<Item = String> + '_ {
    let fixed = FIXED_NAMES.iter().map(|&name| name.to_owned());
    let of_streams = STREAMS.iter().map(|kind| &kind.name);
    let of_streams = of_streams.filter(|&&name| name != VTK);
    let endings = of_streams.chain(ENDINGS);
    fixed.chain(endings.map(move |ending| format!("{prefix}.{ending}")))
}

/// The names of a run with this prefix that are in the folder.
#[must_use]
pub fn present(folder: &Path, prefix: &str) -> Vec<String> {
    // Links without a target count, too: they are in the way.
    let known = names(prefix).filter(|name| folder.join(name).symlink_metadata().is_ok());
    known.chain(field_tables(folder, prefix)).collect()
}

/// Tables of fields, which have names of their own (`<prefix>.fields.NAME.csv`).
fn field_tables(folder: &Path, prefix: &str) -> Vec<String> {
    let begin = format!("{prefix}.fields.");
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
    // Not <prefix>.fields.csv, which mercury-cg writes.
    let is_table = |name: &String| {
        let rest = name
            .strip_prefix(&begin)
            .and_then(|rest| rest.strip_suffix(".csv"));
        rest.is_some_and(|rest| !rest.is_empty() && !rest.contains('.'))
    };
    let mut found: Vec<String> = names.filter(is_table).collect();
    found.sort();
    found
}

fn by(owner: &Owner) -> String {
    match owner.host.as_str() {
        "" => String::new(),
        host => format!(" (process {} on {host})", owner.process),
    }
}

fn if_dead(owner: &Owner) -> &'static str {
    match owner.is_running() {
        None if !owner.host.is_empty() => "; if that run has ended, remove the file .lock there",
        _ => "",
    }
}

/// The treatment of an earlier run in the folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Earlier {
    /// It stays, and the new run goes elsewhere.
    Refuse,
    /// Its files are removed, and nothing but these.
    Replace,
    /// The new run goes on with it.
    Continue,
}

/// State of the folder before the run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Found {
    /// No run; or one that was removed.
    Nothing,
    /// A run, which is still there.
    Run,
}

/// Makes a folder ready for a run: existing, writable, without a run or with one to be resumed. It belongs to this run until the
/// lock is dropped.
///
/// # Errors
/// If another run is writing into the folder, whatever is requested; if the folder holds a run that is not to be touched, or one of another scene that is to be continued; if it is no folder, or cannot be made, emptied or written.
pub fn prepare(
    folder: &Path,
    prefix: &str,
    earlier: Earlier,
) -> Result<(FolderLock, Found), FolderError> {
    make(folder)?;
    // First of all: the files of a running run must not be judged. A failed lock is reported below.
    let locked = match lock::lock(folder) {
        Ok(Ok(lock)) => Ok(lock),
        Err(error) => Err(error),
        Ok(Err(owner)) => {
            return Err(FolderError::InUse {
                path: folder.to_owned(),
                owner,
            });
        }
    };
    let present = present(folder, prefix);
    if let (Some(found), Earlier::Refuse) = (present.first(), earlier) {
        return Err(FolderError::HoldsRun {
            path: folder.to_owned(),
            found: found.clone(),
        });
    }
    let cannot = |source| system(folder, "nothing can be written in the folder", source);
    let probe = folder.join(format!("{PROBE}{}", std::process::id()));
    fs::write(&probe, b"")
        .and_then(|()| fs::remove_file(&probe))
        .map_err(cannot)?;
    let lock = locked.map_err(cannot)?;
    if earlier == Earlier::Continue
        && let Some(other) = earlier_prefix(folder)
        && other != prefix
    {
        return Err(FolderError::OfAnotherScene {
            path: folder.to_owned(),
            other,
            prefix: prefix.to_owned(),
        });
    }
    if earlier == Earlier::Continue && !present.is_empty() {
        remove_unfinished(folder, prefix)?;
        return Ok((lock, Found::Run));
    }
    clear(folder, prefix)?;
    Ok((lock, Found::Nothing))
}

/// Makes a folder, with those above it, where it is not there.
///
/// # Errors
/// If something else has its name, or it cannot be made.
pub fn make(folder: &Path) -> Result<(), FolderError> {
    if folder.exists() && !folder.is_dir() {
        return Err(FolderError::NotAFolder {
            path: folder.to_owned(),
        });
    }
    for path in folder.ancestors().filter(|path| !path.exists()) {
        if let Ok(target) = fs::read_link(path) {
            let path = path.to_owned();
            return Err(FolderError::LeadsNowhere { path, target });
        }
    }
    fs::create_dir_all(folder).map_err(|source| system(folder, "the folder cannot be made", source))
}

/// Locks an existing folder for a study, whose runs have folders of their own in it. The folder belongs to the study until the
/// lock is dropped; where locks are not available, an error appears when something is written.
///
/// # Errors
/// If another one has it.
pub fn take(folder: &Path) -> Result<Option<FolderLock>, FolderError> {
    match lock::lock(folder) {
        Ok(Ok(lock)) => Ok(Some(lock)),
        Ok(Err(owner)) => Err(FolderError::OfAnotherStudy {
            path: folder.to_owned(),
            owner,
        }),
        Err(_) => Ok(None),
    }
}

fn system(path: &Path, action: &'static str, source: io::Error) -> FolderError {
    FolderError::System {
        path: path.to_owned(),
        action,
        source,
    }
}

/// Removes the files of a run with this prefix, and of the run that wrote the folder's `plan.toml`; nothing else.
///
/// # Errors
/// If one cannot be removed.
pub fn clear(folder: &Path, prefix: &str) -> Result<(), FolderError> {
    let earlier = earlier_prefix(folder).filter(|earlier| earlier != prefix);
    let prefixes = || [Some(prefix), earlier.as_deref()].into_iter().flatten();
    let mut names: BTreeSet<String> =
        (prefixes().flat_map(|prefix| present(folder, prefix))).collect();
    let plan = names.take("plan.toml");
    let (checkpoints, others): (Vec<_>, Vec<_>) =
        (names.into_iter()).partition(|name| name.ends_with(".restart"));
    for prefix in prefixes() {
        remove_unfinished(folder, prefix)?;
    }
    // If the process is killed during this, the folder holds nothing that could be resumed, and the name of the old run is the
    // last to go.
    for name in checkpoints.iter().chain(&others) {
        remove(&folder.join(name))?;
    }
    for prefix in prefixes() {
        let kept = kept_checkpoints(folder, prefix).into_values();
        for path in vtk_files(folder, prefix).into_iter().chain(kept) {
            remove(&path)?;
        }
        // Only if it holds no other files.
        let _ = fs::remove_dir(kept_folder(folder, prefix));
    }
    // Only if it holds no other files.
    let _ = fs::remove_dir(folder.join(VTK));
    plan.map_or(Ok(()), |name| remove(&folder.join(name)))
}

/// The folder of the files for ParaView inside that of the run.
pub const VTK: &str = "vtk";

/// The files for ParaView of a run with this prefix.
fn vtk_files(folder: &Path, prefix: &str) -> Vec<PathBuf> {
    let folder = folder.join(VTK);
    let mut files = vec![folder.join(format!("{prefix}.paraview.py"))];
    for kind in ["particles", "contacts", "walls", "bodies"] {
        let stem = format!("{prefix}.{kind}");
        files.extend(Series::frames_in(&folder, &stem));
        files.push(folder.join(format!("{stem}.pvd")));
    }
    files.retain(|path| path.symlink_metadata().is_ok());
    files
}

/// The prefix of the run whose `plan.toml` is there: it may have been another scene's.
#[must_use]
pub fn earlier_prefix(folder: &Path) -> Option<String> {
    let plan: toml::Table = fs::read_to_string(folder.join("plan.toml"))
        .ok()?
        .parse()
        .ok()?;
    let prefix = plan.get("prefix")?.as_str()?;
    // It names files in this folder, whatever the origin of the plan.
    let is_name = !prefix.contains(['/', '\\']);
    is_name.then(|| prefix.to_owned())
}

/// The prefix of the file by which a run tests whether it may write; the process follows.
const PROBE: &str = ".mercury-";

/// Removes the temporary files of a killed run.
fn remove_unfinished(folder: &Path, prefix: &str) -> Result<(), FolderError> {
    let kept = kept_folder(folder, prefix);
    for inside in [folder, &folder.join(VTK), &kept] {
        for entry in fs::read_dir(inside).into_iter().flatten().flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            let is_number = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
            if name.strip_prefix(PROBE).is_some_and(is_number) {
                remove(&entry.path())?;
                continue;
            }
            let Some((whole, mark)) = name.rsplit_once(TEMPORARY) else {
                continue;
            };
            let is_ours = whole
                .strip_prefix(prefix)
                .is_some_and(|rest| rest.starts_with('.'))
                || FIXED_NAMES.contains(&whole)
                || inside == kept && whole.ends_with(".restart");
            if is_ours && mark.bytes().all(|byte| byte.is_ascii_alphanumeric()) {
                remove(&entry.path())?;
            }
        }
    }
    Ok(())
}

fn remove(path: &Path) -> Result<(), FolderError> {
    fs::remove_file(path).map_err(|source| system(path, "the file cannot be removed", source))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn force_removes_what_the_earlier_run_wrote_and_nothing_else() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path();
        fs::create_dir(folder.join(VTK)).unwrap();
        let earlier = [
            "plan.toml",
            "summary.json",
            "lid.data",
            "lid.budget.csv",
            "lid.1.restart",
            "lid.particles.arrow.tmp-a1B2c3",
            ".mercury-17",
            "vtk/lid.particles.pvd",
            "vtk/lid.particles.0000.vtu",
            "vtk/lid.walls.10000.vtu",
            "vtk/lid.paraview.py",
            "drum.ene",
        ];
        let others = [
            "notes.txt",
            "lid.toml",
            "lid.data.bak",
            "vtk/mine.vtu",
            "lida.data",
        ];
        for name in earlier.iter().chain(&others) {
            fs::write(folder.join(name), "prefix = \"lid\"\n").unwrap();
        }
        let (lock, found) = prepare(folder, "drum", Earlier::Replace).unwrap();
        assert_eq!(found, Found::Nothing);
        drop(lock);
        for name in earlier {
            assert!(!folder.join(name).exists(), "{name}");
        }
        for name in others {
            assert!(folder.join(name).exists(), "{name}");
        }
    }

    /// A folder in the place of a file cannot be removed as one: it stops the removal as a kill would.
    #[test]
    fn a_removal_that_is_interrupted_leaves_nothing_to_resume_and_says_whose_the_rest_is() {
        for prefix in ["lid", "drum"] {
            let place = tempfile::tempdir().unwrap();
            let folder = place.path();
            let files = ["summary.json", "run.log", "lid.0.restart", "lid.1.restart"];
            for name in files.iter().chain(&["plan.toml", "lid.data"]) {
                fs::write(folder.join(name), "prefix = \"lid\"\n").unwrap();
            }
            let obstacle = folder.join("lid.ene");
            fs::create_dir(&obstacle).unwrap();
            prepare(folder, prefix, Earlier::Replace).unwrap_err();
            assert!(!folder.join("lid.0.restart").exists());
            assert!(!folder.join("lid.1.restart").exists());
            assert_eq!(earlier_prefix(folder).as_deref(), Some("lid"));
            fs::remove_dir(&obstacle).unwrap();
            prepare(folder, prefix, Earlier::Replace).unwrap();
            assert_eq!(fs::read_dir(folder).unwrap().count(), 0);
        }
    }

    #[test]
    fn a_run_of_another_scene_is_not_gone_on_with_nor_removed() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path();
        for name in ["plan.toml", "lid.data"] {
            fs::write(folder.join(name), "prefix = \"lid\"\n").unwrap();
        }
        let refused = prepare(folder, "drum", Earlier::Continue).unwrap_err();
        let reported = "the run in this folder is one of `lid`, not of `drum`";
        assert!(refused.to_string().contains(reported), "{refused}");
        assert!(folder.join("lid.data").exists() && folder.join("plan.toml").exists());
    }

    #[test]
    fn a_run_in_progress_is_left_alone_whatever_is_requested() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("run");
        let first = prepare(&folder, "a", Earlier::Refuse).unwrap();
        for earlier in [Earlier::Refuse, Earlier::Replace, Earlier::Continue] {
            let refused = prepare(&folder, "b", earlier).unwrap_err().to_string();
            let begin = format!(
                "{}: this folder is being written by another run (process {} on ",
                folder.display(),
                std::process::id()
            );
            assert!(refused.starts_with(&begin), "{refused}");
        }
        assert!(folder.join(LOCK).exists());
        drop(first);
        assert!(!folder.join(LOCK).exists());
    }
}

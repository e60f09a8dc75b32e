//! Input that an argument of the command line names: a table, a law, a list of sizes, a run.

use std::io::Read as _;
use std::path::{Path, PathBuf};

use mercury_common::error::FormatError;
use mercury_common::readable::shortened;
use mercury_common::scene::{Located, Psd, SceneErrors, parse_psd, read_psd};
use mercury_common::sizes::table::{self, Content, Options, SizeTable};
use mercury_common::sizes::{SizeDistribution, SizeError};

use crate::check::run::{Run, RunError, Selection};
use crate::parquet;
use crate::sample::{Sample, SampleError};

/// Sizes that were measured, stated or counted.
#[derive(Debug, Clone)]
#[expect(
    clippy::large_enum_variant,
    reason = "there are a handful of them, and most are distributions"
)]
pub enum Sizes {
    /// A distribution; with the table it was read from.
    Distribution(SizeDistribution, Option<SizeTable>),
    /// Particles one by one.
    Sample(Sample),
}

/// Sizes with a name for reports.
#[derive(Debug, Clone)]
pub struct Source {
    /// Name in reports.
    pub name: String,
    /// The sizes.
    pub sizes: Sizes,
    /// Notes of what was repaired or left out while reading.
    pub notes: Vec<String>,
    /// Whether it is a list that was drawn by quota, by its own comment.
    pub by_quota: bool,
}

/// Why an argument stands for nothing.
#[derive(Debug, thiserror::Error)]
pub enum InputError {
    /// A table that is wrong.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// A law that is wrong.
    #[error(transparent)]
    Law(#[from] SceneErrors),
    /// A law that is no distribution.
    #[error(transparent)]
    Sizes(#[from] SizeError),
    /// A run that is none.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A list that is no sample.
    #[error("{}: {error}", .path.display())]
    Sample {
        /// The file.
        path: PathBuf,
        /// Description of the problem.
        error: SampleError,
    },
    /// A law on the command line that is no TOML.
    #[error("{argument}: {problem}")]
    Inline {
        /// Argument as typed.
        argument: String,
        /// Description of the problem.
        problem: String,
    },
}

/// Reads an argument: `{ kind = ... }` is a law as in a scene, a folder is a run (one source for each kind of its particles), a
/// file `.toml` holds a law, any other file a table or list.
///
/// # Errors
/// [`InputError`].
pub fn read(argument: &str, options: &Options) -> Result<Vec<Source>, InputError> {
    if argument.trim_start().starts_with('{') {
        return Ok(vec![inline(argument)?]);
    }
    let path = Path::new(argument);
    if path.is_dir() {
        return of_run(path, &Selection::default());
    }
    let name = path.file_name().map_or_else(
        || argument.to_owned(),
        |name| name.to_string_lossy().into_owned(),
    );
    if path.extension().is_some_and(|ending| ending == "toml") {
        return Ok(vec![of_law(name, &read_psd(path)?)?]);
    }
    Ok(vec![match content(path, options)? {
        Content::Table(table) => {
            let sizes = SizeDistribution::from_classes(table.classes.clone(), table.weighting);
            let mut notes = noted(&table.notes, table.classes.edges());
            notes.extend(sizes.warning_of_fines());
            Source {
                name,
                notes,
                sizes: Sizes::Distribution(sizes, Some(table)),
                by_quota: false,
            }
        }
        Content::Sizes(list) => {
            let sample = Sample::new(list.diameters).map_err(|error| InputError::Sample {
                path: path.to_owned(),
                error,
            })?;
            Source {
                name,
                notes: noted(&[], &[sample.smallest(), sample.largest()]),
                sizes: Sizes::Sample(sample),
                by_quota: list.by_quota,
            }
        }
    }])
}

/// Content of a file of sizes, text or Parquet.
fn content(path: &Path, options: &Options) -> Result<Content, FormatError> {
    let mut magic = [0; 4];
    let is_read = std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut magic));
    if is_read.is_ok() && parquet::is_one(&magic) {
        return table::parse(path, &parquet::as_text(path)?, options);
    }
    table::read_content(path, options)
}

/// One source for each kind of particles of a run.
///
/// # Errors
/// [`InputError::Run`].
pub fn of_run(folder: &Path, selection: &Selection) -> Result<Vec<Source>, InputError> {
    let run = Run::open(folder)?;
    let name = folder.file_name().map_or_else(
        || folder.display().to_string(),
        |name| name.to_string_lossy().into_owned(),
    );
    let mut sources = Vec::new();
    for (kind, group) in run.sizes(selection)? {
        let sample = Sample::new(group.diameters).map_err(|error| InputError::Sample {
            path: folder.to_owned(),
            error,
        })?;
        sources.push(Source {
            name: format!("{name}: {kind}"),
            sizes: Sizes::Sample(sample),
            notes: Vec::new(),
            by_quota: false,
        });
    }
    if sources.is_empty() {
        return Err(RunError::Folder {
            path: folder.to_owned(),
            what: "no inserted particles".to_owned(),
        }
        .into());
    }
    Ok(sources)
}

fn inline(argument: &str) -> Result<Source, InputError> {
    let wrong = |problem: String| InputError::Inline {
        argument: shortened(argument, 200).into_owned(),
        problem: shortened(&problem, 500).into_owned(),
    };
    let document: toml::Table = format!("psd = {argument}")
        .parse()
        .map_err(|error: toml::de::Error| wrong(error.message().to_owned()))?;
    let Some(psd) = document.get("psd").and_then(toml::Value::as_table) else {
        return Err(wrong(
            "expected a law such as { kind = \"lognormal\", ... }".to_owned(),
        ));
    };
    let law = parse_psd("law", &psd.to_string(), None)?;
    let kind = psd
        .get("kind")
        .and_then(toml::Value::as_str)
        .unwrap_or("law");
    of_law(kind.to_owned(), &law)
}

fn of_law(name: String, law: &Located<Psd>) -> Result<Source, InputError> {
    let sizes = SizeDistribution::from_scene(law)?;
    let mut notes = noted(&[], &[sizes.smallest(), sizes.largest()]);
    notes.extend(law.value.warning_of_shares());
    notes.extend(sizes.warning_of_fines());
    Ok(Source {
        name,
        notes,
        sizes: Sizes::Distribution(sizes, None),
        by_quota: false,
    })
}

/// Grains above a metre and below a nanometre are rare; forgotten units are not.
fn noted(notes: &[String], diameters: &[f64]) -> Vec<String> {
    let mut notes = notes.to_vec();
    let (Some(&first), Some(&last)) = (diameters.first(), diameters.last()) else {
        return notes;
    };
    if last > 1.0 {
        notes.push(format!(
            "the largest diameter is {last} m: is the unit right?"
        ));
    }
    if first > 0.0 && last < 1e-9 {
        notes.push(format!(
            "the largest diameter is {last} m: is the unit right?"
        ));
    }
    notes
}

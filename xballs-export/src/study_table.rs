//! The table of a study, `study.csv`, as Parquet.

use std::path::{Path, PathBuf};

use mercury_tables::Table;

use crate::ExportError;
use crate::output::{ending_of_file, takes_folder};

/// Name of the solver's table of a study.
const FILE: &str = "study.csv";

/// The table, if the input is a study: its folder, or the table itself.
#[must_use]
pub fn table_in(input: &Path) -> Option<PathBuf> {
    if input.is_dir() {
        return Some(input.join(FILE)).filter(|path| path.is_file());
    }
    (input.file_name()? == FILE).then(|| input.to_owned())
}

/// Writes it as `study.parquet` into the folder `output`, or beside the table, or into the file `output` if that ends in
/// `.parquet`: columns whose cells are all numbers as numbers (empty cells as missing ones), the others as text. Returns the path
/// and the number of runs in the table.
///
/// # Errors
/// When the table cannot be read, the file is there already and may not be replaced, or cannot be written.
pub fn to_parquet(
    table: &Path,
    output: Option<&Path>,
    force: bool,
) -> Result<(PathBuf, usize), ExportError> {
    let read = Table::read_text(table)?;
    let is_file = |path: &&Path| ending_of_file(path).as_deref() == Some("parquet");
    let (folder, path) = match output.filter(is_file) {
        Some(file) => (file.parent().unwrap_or(Path::new("")), file.to_owned()),
        None => {
            takes_folder("parquet", output)?;
            let folder = output.or(table.parent()).unwrap_or(Path::new(""));
            (folder, folder.join("study.parquet"))
        }
    };
    if !force && path.symlink_metadata().is_ok() {
        return Err(ExportError::Exists(path));
    }
    if folder != Path::new("") {
        let made = std::fs::create_dir_all(folder);
        made.map_err(mercury_common::whole_file::FileError::of(
            folder,
            "the folder cannot be made",
        ))?;
    }
    let rows = read.rows();
    read.typed().write_parquet(&path)?;
    Ok((path, rows))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn numbers_are_numbers_and_the_rest_is_text() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(FILE);
        fs::write(
            &path,
            "run,seed,problem,speed [m/s]\n\"a,b\",1,,0.5\nc,2,it broke,\n",
        )
        .unwrap();
        assert_eq!(table_in(folder.path()), Some(path.clone()));
        assert_eq!(table_in(&path), Some(path.clone()));
        let (written, rows) = to_parquet(&path, None, false).unwrap();
        assert_eq!((rows, written.parent()), (2, Some(folder.path())));
        let table = Table::read_parquet(&written).unwrap();
        assert_eq!(table.values::<String>("run").unwrap(), ["a,b", "c"]);
        assert_eq!(table.values::<f64>("seed").unwrap(), [1.0, 2.0]);
        let unit = |name: &str| {
            let column = table.columns().iter().find(|column| column.name == name);
            column.unwrap().unit.clone()
        };
        assert_eq!((unit("speed").as_str(), unit("seed").as_str()), ("m/s", ""));
        let speed = table.values::<f64>("speed").unwrap();
        assert!(speed[0] == 0.5 && speed[1].is_nan());
        // Not replaced without a request.
        let again = to_parquet(&path, None, false);
        assert!(matches!(again, Err(ExportError::Exists(_))), "{again:?}");
        assert!(to_parquet(&path, None, true).is_ok());
        let elsewhere = folder.path().join("x/y");
        assert!(to_parquet(&path, Some(&elsewhere), false).is_ok());
        assert!(elsewhere.join("study.parquet").exists());
        let file = folder.path().join("y/z.parquet");
        assert!(to_parquet(&path, Some(&file), false).is_ok() && file.is_file());
        assert!(to_parquet(&path, Some(&folder.path().join("z.csv")), false).is_err());
    }

    #[test]
    fn what_is_no_table_is_reported() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(table_in(folder.path()), None);
        assert_eq!(table_in(&folder.path().join("a.data")), None);
        let path = folder.path().join(FILE);
        for text in ["", "a,a\n1,2\n", "a,b\n1\n", "a\n\"1\n"] {
            fs::write(&path, text).unwrap();
            let error = to_parquet(&path, None, false).unwrap_err();
            assert!(
                error.is_input() && error.to_string().contains(FILE),
                "{text:?}: {error}"
            );
        }
    }
}

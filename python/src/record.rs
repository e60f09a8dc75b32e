//! The files of a run that is there.

use std::path::{Path, PathBuf};

use mercury_common::formats::delimited;
use mercury_common::formats::ene::EnergyReader;
use mercury_common::frames::{self, ColumnKind, ColumnSpec, Frame, FrameReader};
use mercury_common::run_tables::{self, ENERGIES, TableSpec};
use mercury_solver::output::folder;
use mercury_solver::results::NamedResult;
use mercury_solver::run::Rows;
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;

use crate::errors::{run_error, without_interpreter};
use crate::estimate::{Estimate, Summary};
use crate::table::{Column, Table, no_column};
use crate::verification::{Verification, verified};

/// A run that is there, ended or not.
#[pyclass(frozen, module = "mercury_dem")]
pub(crate) struct Record {
    folder: PathBuf,
    prefix: String,
}

/// Opens a run that is there.
#[pyfunction]
pub(crate) fn open(py: Python<'_>, run: PathBuf) -> PyResult<Record> {
    let Some(prefix) = folder::earlier_prefix(&run) else {
        return Err(run_error(
            py,
            format!(
                "{}: no run is there: its file plan.toml is missing or cannot be read",
                run.display()
            ),
        ));
    };
    Ok(Record {
        folder: run,
        prefix,
    })
}

/// The numbers of a table of text, column by column; columns that hold other words are texts.
fn columns_of(text: &str, spec: Option<&TableSpec>) -> (Vec<ColumnSpec>, Vec<frames::Column>) {
    let rows = delimited::Rows::new(text);
    let names = rows.names.clone();
    let mut texts: Vec<Vec<String>> = vec![Vec::new(); names.len()];
    for row in rows {
        for (column, cell) in texts.iter_mut().zip(row.iter()) {
            column.push(cell.to_string());
        }
    }
    let number = |text: &String| match text.as_str() {
        "" => Some(f64::NAN),
        text => text.parse::<f64>().ok(),
    };
    let columns = names.iter().zip(texts).map(|(name, texts)| {
        let numbers: Option<Vec<f64>> = texts.iter().map(number).collect();
        let known = spec.and_then(|spec| spec.column(name));
        let unit = known.map_or("1", |column| column.unit);
        match numbers.filter(|_| known.is_none_or(|column| !column.unit.is_empty())) {
            Some(numbers) => (
                ColumnSpec::new(name, ColumnKind::F64, unit),
                frames::Column::F64(numbers),
            ),
            None => (
                ColumnSpec::new(name, ColumnKind::Text, "1"),
                frames::Column::Text(texts),
            ),
        }
    });
    columns.unzip()
}

/// The energies of a run.
fn energies(path: &Path) -> Result<(Vec<ColumnSpec>, Vec<frames::Column>), String> {
    let reader = EnergyReader::open(path).map_err(|error| error.to_string())?;
    let mut columns = vec![Vec::new(); ENERGIES.columns.len()];
    for row in reader {
        let row = row.map_err(|error| error.to_string())?;
        for (column, value) in columns.iter_mut().zip(row.values()) {
            column.push(value);
        }
    }
    let specs = ENERGIES.columns.iter();
    let specs = specs.map(|column| ColumnSpec::new(column.name, ColumnKind::F64, column.unit));
    Ok((
        specs.collect(),
        columns.into_iter().map(frames::Column::F64).collect(),
    ))
}

impl Record {
    fn path(&self, ending: &str) -> PathBuf {
        self.folder.join(format!("{}.{ending}", self.prefix))
    }

    fn frames(&self, py: Python<'_>, ending: &str) -> PyResult<FrameReader> {
        let path = self.path(ending);
        let opened = without_interpreter(py, || FrameReader::open(path))?;
        opened.map_err(|error| run_error(py, error))
    }

    /// A frame of a file.
    fn table_of(
        &self,
        py: Python<'_>,
        ending: &str,
        number: isize,
        names: Option<&[String]>,
    ) -> PyResult<Table> {
        let reader = self.frames(py, ending)?;
        let count = reader.len();
        let place = match number < 0 {
            true => number
                .checked_add_unsigned(count)
                .and_then(|k| usize::try_from(k).ok()),
            false => usize::try_from(number).ok(),
        };
        let Some((place, info)) = place.and_then(|k| Some((k, reader.info(k)?))) else {
            let file = reader.path().display();
            let text = format!("no frame {number}: {file} has {count}");
            return Err(PyIndexError::new_err(text));
        };
        let specs = reader.schema().columns();
        let known: Vec<&str> = specs.iter().map(|spec| spec.name.as_str()).collect();
        let chosen: Vec<&str> = match names {
            None => known.clone(),
            Some(names) => names.iter().map(String::as_str).collect(),
        };
        let find = |name: &&str| specs.iter().find(|spec| spec.name == **name);
        if let Some(unknown) = chosen.iter().find(|name| find(name).is_none()) {
            return Err(no_column(unknown, &known));
        }
        let columns = without_interpreter(py, || reader.columns(place, &chosen))?;
        let rows = Rows {
            specs: chosen.iter().filter_map(find).cloned().collect(),
            frame: Frame {
                time: info.time,
                step: info.step,
                columns: columns.map_err(|error| run_error(py, error))?,
            },
        };
        Table::of_state(py, rows, None)
    }
}

#[pymethods]
impl Record {
    #[getter]
    fn folder(&self) -> String {
        self.folder.display().to_string()
    }

    #[getter]
    fn summary(&self, py: Python<'_>) -> PyResult<Option<Summary>> {
        let path = self.folder.join("summary.json");
        let failed = |error: String| run_error(py, format!("{}: {error}", path.display()));
        match std::fs::read_to_string(&path) {
            Ok(text) => {
                let content = serde_json::from_str(&text);
                let content = content.map_err(|error| failed(error.to_string()))?;
                Ok(Some(Summary::new(content)))
            }
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(failed(error.to_string())),
        }
    }

    #[getter]
    fn times(&self, py: Python<'_>) -> PyResult<Column> {
        let reader = self.frames(py, "particles.arrow")?;
        let times = reader.infos().map(|info| info.time).collect();
        let spec = ColumnSpec::new("time", ColumnKind::F64, "s");
        Ok(Column::new(&spec, frames::Column::F64(times)))
    }

    #[pyo3(signature = (number = -1, columns = None))]
    fn frame(
        &self,
        py: Python<'_>,
        number: isize,
        columns: Option<Vec<String>>,
    ) -> PyResult<Table> {
        self.table_of(py, "particles.arrow", number, columns.as_deref())
    }

    #[pyo3(signature = (number = -1, columns = None))]
    fn contacts(
        &self,
        py: Python<'_>,
        number: isize,
        columns: Option<Vec<String>>,
    ) -> PyResult<Table> {
        self.table_of(py, "contacts.arrow", number, columns.as_deref())
    }

    fn table(&self, py: Python<'_>, name: &str) -> PyResult<Table> {
        let spec = run_tables::ALL.into_iter().find(|spec| spec.name() == name);
        let ending = match name {
            "energy" => "ene".to_owned(),
            name => format!("{name}.csv"),
        };
        if spec.is_none() && !matches!(name, "energy" | "results") {
            let known = run_tables::ALL.iter().map(|spec| spec.name());
            let known: Vec<&str> = ["energy", "results"].into_iter().chain(known).collect();
            let text = format!("no table `{name}`; there are: {}", known.join(", "));
            return Err(run_error(py, text));
        }
        let path = self.path(&ending);
        let read = without_interpreter(py, || match name {
            "energy" => energies(&path),
            _ => match std::fs::read_to_string(&path) {
                Ok(text) => Ok(columns_of(&text, spec)),
                Err(error) => {
                    let from = spec.map_or(String::new(), |spec| {
                        format!("; it comes from {}", spec.from)
                    });
                    Err(format!("{} cannot be read: {error}{from}", path.display()))
                }
            },
        })?;
        let (specs, columns) = read.map_err(|error| run_error(py, error))?;
        Table::new(py, None, &specs, columns)
    }

    fn result(&self, py: Python<'_>, request: &str) -> PyResult<Estimate> {
        let result = NamedResult::new("result", request).map_err(|error| run_error(py, error))?;
        let read = without_interpreter(py, || result.read(&self.folder, &self.prefix, None))?;
        Ok(Estimate::read("result", &read))
    }

    #[pyo3(signature = (steps = 0.01, *, seed = None))]
    fn verify(&self, py: Python<'_>, steps: f64, seed: Option<u64>) -> PyResult<Verification> {
        verified(py, &self.folder, steps, seed)
    }

    fn __repr__(&self) -> String {
        format!("<Record of {} in {}>", self.prefix, self.folder.display())
    }
}

//! Columns and tables, which other packages of Python read without a copy.

use std::collections::HashMap;
use std::sync::Arc;

use arrow_array::cast::AsArray as _;
use arrow_array::ffi::to_ffi;
use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::types::{Float64Type, Int32Type, UInt8Type, UInt32Type, UInt64Type};
use arrow_array::{
    Array as _, ArrayRef, ArrowPrimitiveType, PrimitiveArray, RecordBatch, RecordBatchIterator,
    StringArray,
};
use arrow_schema::{ArrowError, DataType, Field, Schema, SchemaRef};
use mercury_common::frames::{self, ColumnSpec, Frame};
use mercury_solver::run::Rows;
use pyo3::IntoPyObjectExt as _;
use pyo3::exceptions::{PyIndexError, PyKeyError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyDict, PyList, PyTuple};

use crate::errors::run_error;
use crate::values::escaped;

/// Values of one length, shared with what reads them.
#[pyclass(frozen, module = "mercury_dem")]
pub(crate) struct Column {
    field: Arc<Field>,
    values: ArrayRef,
}

/// The values in the memory that they have. The time is in s, numbers have their SI units in the metadata of the field.
fn array(values: frames::Column) -> ArrayRef {
    fn numbers<T: ArrowPrimitiveType>(values: Vec<T::Native>) -> ArrayRef {
        Arc::new(PrimitiveArray::<T>::new(values.into(), None))
    }
    match values {
        frames::Column::F64(values) => numbers::<Float64Type>(values),
        frames::Column::I32(values) => numbers::<Int32Type>(values),
        frames::Column::U8(values) => numbers::<UInt8Type>(values),
        frames::Column::U32(values) => numbers::<UInt32Type>(values),
        frames::Column::U64(values) => numbers::<UInt64Type>(values),
        frames::Column::OptionalU32(values) => Arc::new(PrimitiveArray::<UInt32Type>::from(values)),
        frames::Column::Text(values) => Arc::new(StringArray::from(values)),
    }
}

impl Column {
    pub(crate) fn new(spec: &ColumnSpec, values: frames::Column) -> Self {
        let values = array(values);
        let entries = [
            ("unit", Some(spec.unit.as_str())),
            ("description", spec.description.as_deref()),
        ];
        let entries = entries.into_iter().filter_map(|(key, value)| {
            let value = value.filter(|value| !value.is_empty())?;
            Some((key.to_owned(), value.to_owned()))
        });
        let may_be_missing = values.null_count() > 0;
        let field = Field::new(&spec.name, values.data_type().clone(), may_be_missing);
        Self {
            field: Arc::new(field.with_metadata(entries.collect::<HashMap<_, _>>())),
            values,
        }
    }

    fn value<'py>(&self, py: Python<'py>, row: usize) -> PyResult<Bound<'py, PyAny>> {
        if self.values.is_null(row) {
            return Ok(py.None().into_bound(py));
        }
        let values = &self.values;
        match values.data_type() {
            DataType::Float64 => values
                .as_primitive::<Float64Type>()
                .value(row)
                .into_bound_py_any(py),
            DataType::Int32 => values
                .as_primitive::<Int32Type>()
                .value(row)
                .into_bound_py_any(py),
            DataType::UInt8 => values
                .as_primitive::<UInt8Type>()
                .value(row)
                .into_bound_py_any(py),
            DataType::UInt32 => values
                .as_primitive::<UInt32Type>()
                .value(row)
                .into_bound_py_any(py),
            DataType::UInt64 => values
                .as_primitive::<UInt64Type>()
                .value(row)
                .into_bound_py_any(py),
            _ => values.as_string::<i32>().value(row).into_bound_py_any(py),
        }
    }

    fn list<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let list = PyList::empty(py);
        for row in 0..self.values.len() {
            list.append(self.value(py, row)?)?;
        }
        Ok(list)
    }
}

#[pymethods]
impl Column {
    #[getter]
    fn name(&self) -> &str {
        self.field.name()
    }

    #[getter]
    fn unit(&self) -> &str {
        self.field
            .metadata()
            .get("unit")
            .map_or("1", String::as_str)
    }

    fn __len__(&self) -> usize {
        self.values.len()
    }

    fn __getitem__<'py>(&self, py: Python<'py>, row: isize) -> PyResult<Bound<'py, PyAny>> {
        let count = self.values.len();
        let place = match row < 0 {
            true => row
                .checked_add_unsigned(count)
                .and_then(|row| usize::try_from(row).ok()),
            false => usize::try_from(row).ok(),
        };
        match place.filter(|place| *place < count) {
            Some(place) => self.value(py, place),
            None => Err(PyIndexError::new_err(format!(
                "row {row} of column `{}`, which has {count}",
                self.name()
            ))),
        }
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(self.list(py)?.try_iter()?.into_any())
    }

    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_array__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        // Another type is a wish, which the interface lets a producer leave out.
        let _ = requested_schema;
        let failed = |error: ArrowError| run_error(py, error);
        let (array, _) = to_ffi(&self.values.to_data()).map_err(failed)?;
        let schema = arrow_schema::ffi::FFI_ArrowSchema::try_from(self.field.as_ref());
        let schema = schema.map_err(failed)?;
        let schema = PyCapsule::new_with_value(py, schema, c"arrow_schema")?;
        let array = PyCapsule::new_with_value(py, array, c"arrow_array")?;
        PyTuple::new(py, [schema, array])
    }

    #[getter]
    fn __array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let of_type = match self.values.data_type() {
            DataType::Float64 => "<f8",
            DataType::Int32 => "<i4",
            DataType::UInt8 => "|u1",
            DataType::UInt32 => "<u4",
            DataType::UInt64 => "<u8",
            _ => return Err(self.no_array("texts")),
        };
        if self.values.null_count() > 0 {
            return Err(self.no_array("rows without a value"));
        }
        let data = self.values.to_data();
        let address = data.buffers()[0].as_ptr() as usize;
        let interface = PyDict::new(py);
        interface.set_item("version", 3)?;
        interface.set_item("shape", (self.values.len(),))?;
        interface.set_item("typestr", of_type)?;
        let is_read_only = true;
        interface.set_item("data", (address, is_read_only))?;
        Ok(interface)
    }

    fn __repr__(&self) -> String {
        format!(
            "<Column {} [{}]: {} rows>",
            self.name(),
            self.unit(),
            self.values.len()
        )
    }
}

impl Column {
    fn no_array(&self, what: &str) -> PyErr {
        PyTypeError::new_err(format!(
            "column `{}` has {what}, which an array of numpy does not hold: read it by list(column), polars or pyarrow",
            self.name()
        ))
    }
}

/// Columns of one length.
#[pyclass(frozen, module = "mercury_dem")]
pub(crate) struct Table {
    /// Time (s) and step of a single state.
    moment: Option<(f64, u64)>,
    rows: usize,
    columns: Vec<Py<Column>>,
}

/// Rows at the beginning and the end that a page shows.
const SHOWN: usize = 5;

impl Table {
    /// Of columns with their specifications.
    pub(crate) fn new(
        py: Python<'_>,
        moment: Option<(f64, u64)>,
        specs: &[ColumnSpec],
        values: Vec<frames::Column>,
    ) -> PyResult<Self> {
        let rows = values.first().map_or(0, frames::Column::len);
        let columns = specs.iter().zip(values);
        let columns = columns.map(|(spec, values)| Py::new(py, Column::new(spec, values)));
        Ok(Self {
            moment,
            rows,
            columns: columns.collect::<PyResult<_>>()?,
        })
    }

    /// A state of a run; `names`: its columns, all by default.
    pub(crate) fn of_state(py: Python<'_>, rows: Rows, names: Option<&[String]>) -> PyResult<Self> {
        let Rows { specs, frame } = rows;
        let Frame {
            time,
            step,
            columns,
        } = frame;
        let moment = Some((time, step));
        let Some(names) = names else {
            return Self::new(py, moment, &specs, columns);
        };
        let mut columns: Vec<Option<frames::Column>> = columns.into_iter().map(Some).collect();
        let mut chosen = (Vec::new(), Vec::new());
        for name in names {
            let place = specs.iter().position(|spec| spec.name == *name);
            let taken = place.and_then(|place| Some((place, columns[place].take()?)));
            let Some((place, values)) = taken else {
                let known: Vec<&str> = specs.iter().map(|spec| spec.name.as_str()).collect();
                return Err(no_column(name, &known));
            };
            chosen.0.push(specs[place].clone());
            chosen.1.push(values);
        }
        Self::new(py, moment, &chosen.0, chosen.1)
    }

    fn names(&self) -> Vec<&str> {
        self.columns
            .iter()
            .map(|column| column.get().name())
            .collect()
    }

    fn schema(&self) -> SchemaRef {
        let fields = self
            .columns
            .iter()
            .map(|column| Arc::clone(&column.get().field));
        Arc::new(Schema::new(fields.collect::<Vec<_>>()))
    }
}

/// An unknown column.
pub(crate) fn no_column(name: &str, known: &[&str]) -> PyErr {
    let known = known.join(", ");
    PyKeyError::new_err(format!("no column `{name}`, or twice; there are: {known}"))
}

#[pymethods]
impl Table {
    #[getter]
    fn time(&self) -> Option<f64> {
        self.moment.map(|(time, _)| time)
    }

    #[getter]
    fn step(&self) -> Option<u64> {
        self.moment.map(|(_, step)| step)
    }

    #[getter]
    fn columns<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.names())
    }

    fn __len__(&self) -> usize {
        self.rows
    }

    fn __getitem__(&self, py: Python<'_>, name: &str) -> PyResult<Py<Column>> {
        let mut columns = self.columns.iter();
        match columns.find(|column| column.get().name() == name) {
            Some(column) => Ok(column.clone_ref(py)),
            None => Err(no_column(name, &self.names())),
        }
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(PyList::new(py, self.names())?.try_iter()?.into_any())
    }

    fn __contains__(&self, name: &str) -> bool {
        self.names().contains(&name)
    }

    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        let _ = requested_schema;
        let schema = self.schema();
        let columns = self
            .columns
            .iter()
            .map(|column| Arc::clone(&column.get().values));
        let batch = RecordBatch::try_new(Arc::clone(&schema), columns.collect());
        let batch = batch.map_err(|error| run_error(py, error))?;
        let batches = RecordBatchIterator::new([Ok(batch)], schema);
        let stream = FFI_ArrowArrayStream::new(Box::new(batches));
        PyCapsule::new_with_value(py, stream, c"arrow_array_stream")
    }

    fn __repr__(&self) -> String {
        let columns = self.names().join(", ");
        format!("<Table of {} rows: {columns}>", self.rows)
    }

    fn _repr_html_(&self, py: Python<'_>) -> PyResult<String> {
        let mut html = String::from("<table><thead><tr>");
        for column in &self.columns {
            let column = column.get();
            let unit = match column.unit() {
                "1" => String::new(),
                unit => format!("<br>{}", escaped(unit)),
            };
            html += &format!("<th>{}{unit}</th>", escaped(column.name()));
        }
        html += "</tr></thead><tbody>";
        let is_long = self.rows > 2 * SHOWN;
        for row in 0..self.rows {
            if is_long && (SHOWN..self.rows - SHOWN).contains(&row) {
                if row == SHOWN {
                    html += &format!("<tr><td colspan=\"{}\">…</td></tr>", self.columns.len());
                }
                continue;
            }
            html += "<tr>";
            for column in &self.columns {
                let value = column.get().value(py, row)?;
                html += &format!("<td>{}</td>", escaped(&value.str()?.to_cow()?));
            }
            html += "</tr>";
        }
        html += "</tbody></table>";
        let rows = self.rows;
        let moment = self
            .time()
            .map_or(String::new(), |time| format!(" at t = {time} s"));
        Ok(html + &format!("<p>{rows} rows{moment}</p>"))
    }
}

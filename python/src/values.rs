//! Values of Python as JSON and TOML.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyBytes, PyFloat, PyInt, PyMapping, PySequence, PyString};
use serde_json::{Map, Number, Value};

/// Lists and mappings inside each other, as many as a scene may have.
const MOST_DEEP: usize = 80;

/// A value of a scene. Numbers of numpy count as numbers, arrays as lists, and paths as strings.
pub(crate) fn to_json(value: &Bound<'_, PyAny>) -> PyResult<Value> {
    json_at(value, "", 0)
}

fn json_at(value: &Bound<'_, PyAny>, key: &str, depth: usize) -> PyResult<Value> {
    let place = || if key.is_empty() { "the scene" } else { key };
    if depth > MOST_DEEP {
        return Err(PyValueError::new_err(format!(
            "{}: more than {MOST_DEEP} lists and dicts inside each other; does one hold itself?",
            place()
        )));
    }
    if value.is_instance_of::<PyBool>() {
        return Ok(Value::Bool(value.extract()?));
    }
    if value.is_instance_of::<PyString>() {
        return Ok(Value::String(value.extract()?));
    }
    if value.is_instance_of::<PyInt>() || (value.hasattr("__index__")? && !is_list(value)) {
        let number = value.call_method0("__index__")?;
        let number: i64 = number.extract().map_err(|_| {
            PyValueError::new_err(format!("{}: {number} has more than 64 bits", place()))
        })?;
        return Ok(number.into());
    }
    if value.is_instance_of::<PyFloat>() || (value.hasattr("__float__")? && !is_list(value)) {
        let number: f64 = value.extract()?;
        let number = Number::from_f64(number).ok_or_else(|| {
            PyValueError::new_err(format!("{}: {number} is not a finite number", place()))
        })?;
        return Ok(Value::Number(number));
    }
    if let Ok(mapping) = value.cast::<PyMapping>() {
        let mut object = Map::new();
        for item in mapping.items()?.iter() {
            let (name, item): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item.extract()?;
            let Ok(name) = name.extract::<String>() else {
                return Err(PyTypeError::new_err(format!(
                    "{}: keys of a scene are text, and {} is not",
                    place(),
                    name.repr()?
                )));
            };
            let below = match key {
                "" => name.clone(),
                key => format!("{key}.{name}"),
            };
            object.insert(name, json_at(&item, &below, depth + 1)?);
        }
        return Ok(Value::Object(object));
    }
    if value.hasattr("__fspath__")? {
        return Ok(Value::String(value.call_method0("__fspath__")?.extract()?));
    }
    if is_list(value) && !value.is_instance_of::<PyBytes>() {
        let items = value.try_iter()?.enumerate();
        let items = items.map(|(at, item)| json_at(&item?, &format!("{key}[{at}]"), depth + 1));
        return Ok(Value::Array(items.collect::<PyResult<_>>()?));
    }
    let kind = value.get_type().qualname()?;
    let help = match kind.to_cow()?.as_ref() {
        "set" | "frozenset" => ": a set has no order, write a list",
        "NoneType" => ": leave the key out",
        _ => ", expected numbers, texts, booleans, lists and dicts",
    };
    Err(PyTypeError::new_err(format!(
        "{}: a scene has no value of type {kind}{help}",
        place()
    )))
}

/// Whether it is a list, a tuple, or an array with at least one dimension.
fn is_list(value: &Bound<'_, PyAny>) -> bool {
    let of_array = |value: &Bound<'_, PyAny>| value.getattr("ndim")?.extract::<usize>();
    match of_array(value) {
        Ok(dimensions) => dimensions > 0,
        Err(_) => value.cast::<PySequence>().is_ok(),
    }
}

/// `KEY=VALUE` of each entry, as the command line takes it.
pub(crate) fn overrides(changes: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<String>> {
    let Some(changes) = changes else {
        return Ok(Vec::new());
    };
    let Ok(changes) = changes.cast::<PyMapping>() else {
        return Err(PyTypeError::new_err(
            "`set` is a mapping from keys to values, as in {\"time.end\": 0.1}",
        ));
    };
    let mut all = Vec::new();
    for item in changes.items()?.iter() {
        let (key, value): (String, Bound<'_, PyAny>) = item.extract()?;
        all.push(format!("{key}={}", toml(&json_at(&value, &key, 0)?)));
    }
    Ok(all)
}

/// A value in TOML.
fn toml(value: &Value) -> String {
    let joined = |items: Vec<String>| items.join(", ");
    match value {
        Value::Array(items) => format!("[{}]", joined(items.iter().map(toml).collect())),
        Value::Object(entries) => {
            let entry = |(key, value): (&String, &Value)| {
                // Strings of JSON are strings of TOML.
                format!("{} = {}", Value::String(key.clone()), toml(value))
            };
            format!("{{{}}}", joined(entries.iter().map(entry).collect()))
        }
        other => other.to_string(),
    }
}

/// JSON as objects of Python.
pub(crate) fn from_json<'py>(py: Python<'py>, json: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (json,))
}

/// A text for HTML.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

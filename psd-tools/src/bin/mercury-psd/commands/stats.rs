//! `mercury-psd stats`

use std::fmt::Write as _;

use mercury_common::cli::{Outcome, say};
use mercury_psd::statistics::{Quantiles, Statistics, described};
use serde_json::{Value, json};

use super::{notes, say_json, sources};
use crate::arguments::StatsArguments;

pub(crate) fn run(arguments: &StatsArguments) -> Outcome {
    let sources = sources(&arguments.files, &arguments.common.reading.options())?;
    let quantiles = match arguments.common.reading.compat {
        Some(_) => Quantiles::Mercury,
        None => Quantiles::Exact,
    };
    let mut text = String::new();
    let mut values = serde_json::Map::new();
    for source in &sources {
        let mut statistics = Statistics::of(&source.sizes, quantiles);
        statistics.add_means(&source.sizes, &arguments.mean);
        if arguments.common.json {
            let mut value = statistics.json();
            value["what"] = json!(described(&source.sizes));
            value["notes"] = json!(source.notes);
            values.insert(source.name.clone(), value);
            continue;
        }
        let _ = write!(
            text,
            "{}: {}\n{}{}",
            source.name,
            described(&source.sizes),
            notes(source),
            statistics.text()
        );
    }
    if arguments.common.json {
        return say_json(&Value::Object(values));
    }
    say(&text)
}

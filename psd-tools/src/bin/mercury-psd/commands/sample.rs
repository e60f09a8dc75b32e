//! `mercury-psd sample`

use mercury_common::cli::{Failure, Outcome, say};
use mercury_common::sizes::table::SizeKind;
use mercury_psd::convert::list;
use mercury_psd::draw::{Method, draw};
use mercury_psd::input::Sizes;
use mercury_psd::sample::Sample;
use mercury_psd::statistics::{Quantiles, Statistics};
use serde_json::json;

use super::{notes, say_beside, say_json, source, unit, write};
use crate::arguments::SampleArguments;

pub(crate) fn run(arguments: &SampleArguments) -> Outcome {
    let source = source(&arguments.file, &arguments.common.reading.options())?;
    let Sizes::Distribution(sizes, _) = &source.sizes else {
        let message = format!("{}: a list of sizes is a sample already", source.name);
        return Err(Failure::input(message).with_help("fit a law to it, or convert it to a table"));
    };
    let unit = unit(&arguments.to_unit)?;
    let diameters = draw(
        sizes,
        arguments.number as usize,
        arguments.method,
        arguments.seed,
    );
    let size = if arguments.to_radius {
        SizeKind::Radius
    } else {
        SizeKind::Diameter
    };
    let by_quota = arguments.method == Method::Quota;
    let text = list(&diameters, size, unit, by_quota);
    let sample = Sample::new(diameters).map_err(Failure::run)?;
    let statistics = Statistics::of(&Sizes::Sample(sample), Quantiles::Exact);
    match &arguments.output {
        Some(path) => {
            write(path, &text)?;
            if arguments.common.json {
                return say_json(&json!({
                    "file": path, "number": arguments.number, "statistics": statistics.json(), "notes": source.notes,
                }));
            }
            say(&format!(
                "{}: {} diameters drawn\n{}{}written: {}",
                source.name,
                arguments.number,
                notes(&source),
                statistics.text(),
                path.display()
            ))
        }
        None if arguments.common.json => say_json(&json!({
            "number": arguments.number, "statistics": statistics.json(), "notes": source.notes,
        })),
        None => {
            // The list has standard output for itself.
            say_beside(&notes(&source));
            say(&String::from_utf8_lossy(&text))
        }
    }
}

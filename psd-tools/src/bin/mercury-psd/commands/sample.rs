//! `mercury-psd sample`

use mercury_common::cli::{Failure, Outcome, say};
use mercury_common::sizes::table::SizeKind;
use mercury_psd::convert::list;
use mercury_psd::draw::draw;
use mercury_psd::input::Sizes;
use mercury_psd::sample::Sample;
use mercury_psd::statistics::{Quantiles, Statistics};
use serde_json::json;

use super::{say_json, source, unit, write};
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
    let text = list(&diameters, size, unit);
    let sample = Sample::new(diameters).map_err(Failure::run)?;
    let statistics = Statistics::of(&Sizes::Sample(sample), Quantiles::Exact);
    match &arguments.output {
        Some(path) => {
            write(path, &text)?;
            if arguments.common.json {
                return say_json(
                    &json!({ "file": path, "number": arguments.number, "statistics": statistics.json() }),
                );
            }
            say(&format!(
                "{}: {} diameters drawn\n{}written: {}",
                source.name,
                arguments.number,
                statistics.text(),
                path.display()
            ))
        }
        None if arguments.common.json => {
            say_json(&json!({ "number": arguments.number, "statistics": statistics.json() }))
        }
        None => say(&String::from_utf8_lossy(&text)),
    }
}

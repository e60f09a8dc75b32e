//! `mercury-psd plot`

use mercury_common::cli::{Outcome, say};
use mercury_psd::charts;
use serde_json::json;

use super::{draw, notes, say_json, sources};
use crate::arguments::PlotArguments;

pub(crate) fn run(arguments: &PlotArguments) -> Outcome {
    let sources = sources(&arguments.files, &arguments.common.reading.options())?;
    let page = charts::curves(
        &arguments.title,
        &sources,
        arguments.by,
        arguments.looking.look(),
    );
    let written = draw(&page, &arguments.output)?;
    if arguments.common.json {
        let stem = arguments.output.display();
        return say_json(&json!({ "files": [format!("{stem}.svg"), format!("{stem}.png")] }));
    }
    let notes: String = sources.iter().map(notes).collect();
    say(&(notes + &written))
}

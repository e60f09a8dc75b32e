//! `mercury-psd convert`

use std::fmt::Write as _;

use mercury_common::cli::{Failure, Outcome, say};
use mercury_common::sizes::changes::{self, Effect};
use mercury_common::sizes::table::{SizeKind, ValueKind};
use mercury_common::sizes::{SizeDistribution, Weighting};
use mercury_psd::convert::{Form, classes, law, table};
use mercury_psd::input::Sizes;
use mercury_psd::statistics::{deciles_text, described, stated};
use serde_json::{Value, json};

use super::{say_beside, say_json, source, unit, write};
use crate::arguments::ConvertArguments;

pub(crate) fn run(arguments: &ConvertArguments) -> Outcome {
    let source = source(&arguments.file, &arguments.common.reading.options())?;
    let measured = stated(&source.sizes);
    let (kind, weighting) = arguments.to.unwrap_or((ValueKind::Cumulative, measured));
    let form = Form {
        kind,
        weighting,
        size: match (arguments.to_radius, kind) {
            (true, _) => SizeKind::Radius,
            (false, kind) if kind.is_of_sieves() => SizeKind::Sieve,
            _ => SizeKind::Diameter,
        },
        unit: unit(&arguments.to_unit)?,
        percent: arguments.percent,
        classes: arguments.classes as usize,
    };
    let one_size = || {
        Failure::input(format!(
            "{}: all particles have one size, which is no table",
            source.name
        ))
        .with_help("in a scene: psd = { kind = \"monodisperse\", diameter = ... }")
    };
    // Changes need a distribution: particles are counted in classes first.
    let mut sizes = match &source.sizes {
        Sizes::Distribution(sizes, _) => sizes.clone(),
        Sizes::Sample(_) => {
            let counted = classes(&source.sizes, &form).ok_or_else(one_size)?;
            SizeDistribution::from_classes(counted, Weighting::Number)
        }
    };
    let by = arguments.by.unwrap_or(measured);
    let mut done = Vec::new();
    if let Some([low, high]) = arguments.cut {
        let (after, effect) = changes::cut(&sizes, by, low, high).map_err(Failure::input)?;
        done.push((
            format!("cut to the quantiles {low} to {high} by {}", by.word()),
            effect,
        ));
        sizes = after;
    }
    if let Some(factor) = arguments.squeeze {
        let (after, effect) = changes::squeeze(&sizes, by, factor).map_err(Failure::input)?;
        done.push((
            format!("squeezed by {factor} about the median by {}", by.word()),
            effect,
        ));
        sizes = after;
    }
    if let Some(factor) = arguments.scale {
        let (after, effect) = changes::scale(&sizes, factor).map_err(Failure::input)?;
        done.push((format!("scaled by {factor}"), effect));
        sizes = after;
    }
    let writes_law = (arguments.output.as_ref())
        .is_some_and(|path| path.extension().is_some_and(|ending| ending == "toml"));
    let text = if writes_law {
        law(&sizes)
    } else {
        let sizes = Sizes::Distribution(sizes.clone(), None);
        let classes = classes(&sizes, &form).ok_or_else(one_size)?;
        table(&classes, &form)
    };
    let mut report = format!(
        "{}: {}\n{}",
        source.name,
        described(&source.sizes),
        super::notes(&source)
    );
    for (what, effect) in &done {
        report += &effect_text(what, effect);
    }
    match &arguments.output {
        Some(path) => {
            write(path, text.as_bytes())?;
            let _ = writeln!(report, "written: {}", path.display());
            if arguments.common.json {
                return say_json(&report_json(&done, &text));
            }
            say(&report)
        }
        None if arguments.common.json => say_json(&report_json(&done, &text)),
        // The table is the output; what was changed must not get into it.
        None => {
            if !done.is_empty() || !source.notes.is_empty() {
                say_beside(&report);
            }
            say(&text)
        }
    }
}

fn effect_text(what: &str, effect: &Effect) -> String {
    let mut text = format!("{what}:\n");
    if let Some(classes) = effect.classes {
        let _ = writeln!(text, "  the law is divided into {classes} classes first");
    }
    if effect.removed_number > 0.0 || effect.removed_volume > 0.0 {
        let _ = writeln!(
            text,
            "  removed: {:.4} % of the particles, {:.4} % of the volume",
            100.0 * effect.removed_number,
            100.0 * effect.removed_volume
        );
    }
    let _ = writeln!(text, "  {}", deciles_text("before", effect.before));
    let _ = writeln!(text, "  {}", deciles_text("after ", effect.after));
    text
}

fn report_json(done: &[(String, Effect)], text: &str) -> Value {
    let changes: Vec<Value> = done
        .iter()
        .map(|(what, effect)| {
            json!({
                "what": what, "removed_number": effect.removed_number, "removed_volume": effect.removed_volume,
                "before": effect.before, "after": effect.after, "classes": effect.classes,
            })
        })
        .collect();
    json!({ "changes": changes, "text": text })
}

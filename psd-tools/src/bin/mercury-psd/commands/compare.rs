//! `mercury-psd compare`

use std::fmt::Write as _;

use mercury_common::cli::{Failure, Outcome, say};
use mercury_common::sizes::Weighting;
use mercury_psd::charts;
use mercury_psd::check::{Goodness, Statistic, TwoSamples, anderson_darling_samples};
use mercury_psd::compare::{Comparison, compare};
use mercury_psd::input::{Sizes, Source};
use mercury_psd::statistics::{Unit, described, significant};
use serde_json::{Value, json};

use super::{draw, notes, say_json, sources};
use crate::arguments::CompareArguments;

pub(crate) fn run(arguments: &CompareArguments) -> Outcome {
    let sources = sources(&arguments.files, &arguments.common.reading.options())?;
    let [reference, others @ ..] = &sources[..] else {
        return Err(Failure::input("nothing to compare"));
    };
    if others.is_empty() {
        return Err(Failure::input(
            "one distribution: give a second one to compare it with",
        ));
    }
    let mut text = format!(
        "reference {}: {}\n{}",
        reference.name,
        described(&reference.sizes),
        notes(reference)
    );
    let mut values = Vec::new();
    for other in others {
        let comparison = compare(&reference.sizes, &other.sizes);
        let tests = tests(reference, other, arguments.level);
        if arguments.common.json {
            let mut value = comparison_json(&comparison);
            value["name"] = json!(other.name);
            value["tests"] = json!(tests);
            values.push(value);
            continue;
        }
        let _ = write!(
            text,
            "{}: {}\n{}",
            other.name,
            described(&other.sizes),
            notes(other)
        );
        text += &comparison_text(&comparison);
        for (name, p) in tests {
            let _ = writeln!(text, "  {name}: p = {}", significant(p, 3));
        }
    }
    let together = all_samples(&sources);
    if let Some((number, test)) = together {
        let _ = writeln!(
            text,
            "all {number} samples: Anderson-Darling, p = {}",
            significant(test.p, 3)
        );
    }
    if let Some(stem) = &arguments.output {
        let (by, look) = (arguments.by, arguments.looking.look());
        text += &draw(&charts::curves("", &sources, by, look), stem)?;
    }
    if arguments.common.json {
        let mut value = json!({ "reference": reference.name, "others": values });
        if let Some((number, test)) = together {
            value["all_samples"] =
                json!({ "number": number, "anderson_darling": test.value, "p": test.p });
        }
        return say_json(&value);
    }
    say(&text)
}

/// Whether three or more samples are of one distribution, and how many there are.
fn all_samples(sources: &[Source]) -> Option<(usize, Statistic)> {
    let samples: Vec<&[f64]> = sources
        .iter()
        .filter_map(|source| match &source.sizes {
            Sizes::Sample(sample) => Some(sample.diameters()),
            Sizes::Distribution(..) => None,
        })
        .collect();
    let test = anderson_darling_samples(&samples).filter(|_| samples.len() > 2)?;
    Some((samples.len(), test))
}

/// p-values, where one of the two at least is a sample.
fn tests(reference: &Source, other: &Source, level: f64) -> Vec<(String, f64)> {
    match (&reference.sizes, &other.sizes) {
        (Sizes::Sample(a), Sizes::Sample(b)) => {
            let result = TwoSamples::of(a, b, level);
            let tests = result.tests().into_iter();
            tests
                .map(|(name, _, test)| (format!("{name}, two samples"), test.p))
                .collect()
        }
        (Sizes::Sample(sample), Sizes::Distribution(target, _))
        | (Sizes::Distribution(target, _), Sizes::Sample(sample)) => {
            let goodness = Goodness::of(sample, target, level, 0);
            let tests = [
                ("Kolmogorov-Smirnov", goodness.kolmogorov),
                ("Anderson-Darling", goodness.anderson_darling),
            ];
            tests
                .into_iter()
                .filter_map(|(name, test)| Some((name.to_owned(), test?.p)))
                .collect()
        }
        _ => Vec::new(),
    }
}

fn comparison_text(comparison: &Comparison) -> String {
    let mut text = format!(
        "  {:8}{:>12}{:>12}{:>12}{:>14}{:>12}\n",
        "by", "d10", "d50", "d90", "distance", "W1"
    );
    for row in &comparison.rows {
        let change = |x: f64| format!("{:>+10.3} %", 100.0 * x);
        let unit = Unit::for_length(row.wasserstein);
        let _ = writeln!(
            text,
            "  {:8}{}{}{}{:>14}{:>12}",
            row.weighting.word(),
            change(row.deciles[0]),
            change(row.deciles[1]),
            change(row.deciles[2]),
            significant(row.distance, 4),
            format!(
                "{} {}",
                significant(row.wasserstein * unit.per_metre, 4),
                unit.name
            ),
        );
    }
    text
}

fn comparison_json(comparison: &Comparison) -> Value {
    let rows: serde_json::Map<String, Value> = comparison
        .rows
        .iter()
        .map(|row| {
            let value = json!({
                "d10": row.deciles[0], "d50": row.deciles[1], "d90": row.deciles[2],
                "distance": row.distance, "wasserstein": row.wasserstein,
            });
            (Weighting::word(row.weighting).to_owned(), value)
        })
        .collect();
    json!({ "by": rows })
}

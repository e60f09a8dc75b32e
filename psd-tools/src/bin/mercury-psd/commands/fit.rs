//! `mercury-psd fit`

use std::fmt::Write as _;
use std::path::PathBuf;

use mercury_common::cli::{Failure, Outcome, say};
use mercury_common::scene::parse_psd;
use mercury_common::sizes::SizeDistribution;
use mercury_psd::charts;
use mercury_psd::fit::{Data, Family, Fitted, Parameter, fit, fit_with_p};
use mercury_psd::input::{Sizes, Source};
use mercury_psd::statistics::{Spectrum as _, Unit, described, significant};
use serde_json::{Value, json};
use toml::Table;

use super::{draw, notes, say_json, source, write};
use crate::arguments::FitArguments;

/// The number of curves that a chart can distinguish.
const SHOWN: usize = 3;

pub(crate) fn run(arguments: &FitArguments) -> Outcome {
    let source = source(&arguments.file, &arguments.common.reading.options())?;
    let families: Vec<Family> = match &arguments.family[..] {
        [] => Family::all().collect(),
        some => some.to_vec(),
    };
    let (data, origin) = measurement(&source, arguments, &families)?;
    let mut fits = Vec::new();
    let mut failed = Vec::new();
    for &family in &families {
        let fitted = match arguments.bootstrap {
            0 => fit(&data, family, arguments.level),
            draws => fit_with_p(
                &data,
                family,
                arguments.level,
                draws as usize,
                arguments.seed,
            ),
        };
        match fitted {
            Ok(fitted) => fits.push(fitted),
            Err(error) => failed.push(error.to_string()),
        }
    }
    fits.sort_by(|a, b| a.bic.total_cmp(&b.bic));
    let Some(best) = fits.first() else {
        return Err(Failure::run(format!(
            "{}: {}",
            source.name,
            failed.join("; ")
        )));
    };
    let (law, cut) = statement(best, source.sizes.range());
    let mut files = Vec::new();
    let mut written = String::new();
    if let Some(stem) = &arguments.output {
        let mut path = stem.clone().into_os_string();
        path.push(".psd.toml");
        let path = PathBuf::from(path);
        let head = format!("# {} fitted to {}\n", best.family.word(), source.name);
        write(&path, (head + &law.to_string()).as_bytes())?;
        let shown = &fits[..fits.len().min(SHOWN)];
        let page = charts::fitted("", &source, &data, shown, arguments.looking.look());
        written = format!("written: {}\n{}", path.display(), draw(&page, stem)?);
        if shown.len() < fits.len() {
            let _ = writeln!(
                written,
                "the chart shows the {SHOWN} families of least BIC of {}; --family chooses others",
                fits.len()
            );
        }
        let stem = stem.display();
        files = vec![
            path.display().to_string(),
            format!("{stem}.svg"),
            format!("{stem}.png"),
        ];
    }
    if arguments.common.json {
        let fits: Vec<Value> = fits.iter().map(fit_json).collect();
        return say_json(&json!({
            "number": data.number(), "number_from": origin, "weighting": data.weighting().word(),
            "fits": fits, "failed": failed, "psd": law.to_string(), "files": files,
        }));
    }
    let mut text = format!(
        "{}: {}\n{}",
        source.name,
        described(&source.sizes),
        notes(&source)
    );
    let _ = writeln!(
        text,
        "  fitted by {} to {} particles ({origin})",
        data.weighting().word(),
        significant(data.number(), 6)
    );
    if let Some(classes) = data.gathered() {
        let _ = writeln!(text, "  they are gathered in {classes} narrow classes");
    }
    for fitted in &fits {
        text += &fit_text(fitted, best);
    }
    for message in failed {
        let _ = writeln!(text, "{message}");
    }
    if cut {
        text +=
            "the law is cut to the measured sizes, as it holds infinitely many particles near 0\n";
    }
    let open: Vec<&str> = (best.parameters.iter())
        .filter(|parameter| parameter.error.is_none())
        .map(|parameter| parameter.name.as_str())
        .collect();
    let open = match &open[..] {
        [] => String::new(),
        some => format!(" (without standard error: {})", some.join(", ")),
    };
    let _ = write!(
        text,
        "least BIC: {}{open}\n{}{written}",
        best.family.word(),
        indented(&law)
    );
    say(&text)
}

fn measurement(
    source: &Source,
    arguments: &FitArguments,
    families: &[Family],
) -> Result<(Data, &'static str), Failure> {
    match &source.sizes {
        Sizes::Sample(sample) => {
            if arguments.count.is_some() {
                let message = "--count is for tables: a list of sizes counts its particles itself";
                return Err(Failure::input(message));
            }
            let data = Data::from_sample(sample).map_err(Failure::input)?;
            Ok((data, "counted"))
        }
        Sizes::Distribution(_, Some(table)) => match arguments.count.or(table.counted) {
            Some(number) => {
                let data = Data::from_table(table, number).map_err(Failure::input)?;
                Ok((
                    data,
                    if arguments.count.is_some() {
                        "given"
                    } else {
                        "counted"
                    },
                ))
            }
            None => {
                let data = Data::from_table(table, 1e4).map_err(Failure::input)?;
                let data = data
                    .with_estimated_number(families)
                    .map_err(Failure::input)?;
                Ok((
                    data,
                    "estimated: as many as make the best fit just probable",
                ))
            }
        },
        Sizes::Distribution(_, None) => {
            let message = format!("{}: a law has its parameters already", source.name);
            Err(Failure::input(message).with_help("fit a table or a list of sizes"))
        }
    }
}

/// The law as a scene takes it: where it has no number of particles as it is, cut to the sizes that were measured.
fn statement(fitted: &Fitted, range: [f64; 2]) -> (Table, bool) {
    let plain = fitted.statement(None);
    let can_be_drawn = parse_psd("fit", &plain.to_string(), None)
        .is_ok_and(|psd| SizeDistribution::from_scene(&psd).is_ok());
    if can_be_drawn {
        (plain, false)
    } else {
        (fitted.statement(Some(range)), true)
    }
}

fn indented(law: &Table) -> String {
    law.to_string()
        .lines()
        .map(|line| format!("  {line}\n"))
        .collect()
}

fn show(parameter: &Parameter, value: f64) -> String {
    if parameter.unit == "m" {
        let unit = Unit::for_length(parameter.value);
        format!("{} {}", significant(value * unit.per_metre, 6), unit.name)
    } else {
        significant(value, 6)
    }
}

fn fit_text(fitted: &Fitted, best: &Fitted) -> String {
    let mut text = format!(
        "{}: AIC {} (+{}), BIC {} (+{})",
        fitted.family.word(),
        significant(fitted.aic, 7),
        significant(fitted.aic - best.aic.min(fitted.aic), 4),
        significant(fitted.bic, 7),
        significant(fitted.bic - best.bic, 4),
    );
    if let Some(p) = fitted.p {
        let _ = write!(text, ", bootstrap p = {}", significant(p, 3));
    }
    text.push('\n');
    for parameter in &fitted.parameters {
        let _ = write!(
            text,
            "  {} = {}",
            parameter.name,
            show(parameter, parameter.value)
        );
        match (parameter.error, parameter.interval) {
            (Some(error), Some([low, high])) => {
                let _ = writeln!(
                    text,
                    " +- {} ({} ... {})",
                    show(parameter, error),
                    show(parameter, low),
                    show(parameter, high)
                );
            }
            _ => {
                let why = parameter.lack.as_deref();
                let _ = writeln!(text, ", {}", why.unwrap_or("no standard error"));
            }
        }
    }
    let [d10, d50, d90] = [0.1, 0.5, 0.9].map(|u| fitted.quantile(u));
    let _ = writeln!(
        text,
        "  {}",
        mercury_psd::statistics::deciles_text("quantiles", [d10, d50, d90])
    );
    text
}

fn fit_json(fitted: &Fitted) -> Value {
    let parameters: serde_json::Map<String, Value> = fitted
        .parameters
        .iter()
        .map(|p| {
            let value = json!({
                "value": p.value, "error": p.error, "interval": p.interval, "unit": p.unit, "not_determined": p.lack,
            });
            (p.name.clone(), value)
        })
        .collect();
    json!({
        "family": fitted.family.word(), "parameters": parameters, "log_likelihood": fitted.log_likelihood,
        "aic": fitted.aic, "bic": fitted.bic, "distance": fitted.distance, "p": fitted.p,
        "d10": fitted.quantile(0.1), "d50": fitted.quantile(0.5), "d90": fitted.quantile(0.9),
    })
}

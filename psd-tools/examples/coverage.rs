//! Coverage of the 95 % intervals of fits: 1000 synthetic measurements of each law, as single sizes and as counts in classes.
//! Writes the table of docs/theory/size-distributions.md.
//!
//!     cargo run --release -p psd-tools --example coverage

use std::path::Path;

use mercury_common::scene::parse_psd;
use mercury_common::sizes::SizeDistribution;
use mercury_common::sizes::table::{Content, Options, parse};
use mercury_psd::draw::{Method, draw};
use mercury_psd::fit::{Data, Family, fit};
use mercury_psd::sample::Sample;
use rayon::prelude::*;

const TRIALS: u64 = 1000;

struct Case {
    family: &'static str,
    keys: &'static str,
    /// In the order of the fitted parameters.
    truth: &'static [f64],
    number: usize,
    classes: usize,
}

const CASES: [Case; 6] = [
    Case {
        family: "lognormal",
        keys: "kind = \"lognormal\"\nmedian_diameter = 1.0\nsigma = 0.3\n",
        truth: &[1.0, 0.3],
        number: 500,
        classes: 15,
    },
    Case {
        family: "normal",
        keys: "kind = \"normal\"\nmean_diameter = 1.0\nstandard_deviation = 0.15\n",
        truth: &[1.0, 0.15],
        number: 500,
        classes: 15,
    },
    Case {
        family: "rosin-rammler",
        keys: "kind = \"rosin-rammler\"\nd63 = 1.0\nexponent = 3.5\n",
        truth: &[1.0, 3.5],
        number: 500,
        classes: 15,
    },
    Case {
        family: "ggs",
        keys: "kind = \"ggs\"\nmax_diameter = 1.0\nexponent = 2.0\n",
        truth: &[1.0, 2.0],
        number: 500,
        classes: 15,
    },
    Case {
        family: "two-lognormal",
        keys: "kind = \"mixture\"\nof = [{ share = 0.4, kind = \"lognormal\", median_diameter = 0.6, sigma = 0.12 },\n\
               { share = 0.6, kind = \"lognormal\", median_diameter = 1.3, sigma = 0.15 }]\n",
        truth: &[0.4, 0.6, 0.12, 1.3, 0.15],
        number: 2000,
        classes: 25,
    },
    Case {
        family: "two-normal",
        keys: "kind = \"mixture\"\nof = [{ share = 0.5, kind = \"normal\", mean_diameter = 0.7, standard_deviation = 0.08 },\n\
               { share = 0.5, kind = \"normal\", mean_diameter = 1.4, standard_deviation = 0.15 }]\n",
        truth: &[0.5, 0.7, 0.08, 1.4, 0.15],
        number: 2000,
        classes: 25,
    },
];

/// Counts in classes whose ends lie beyond all sizes.
fn counted(sample: &Sample, target: &SizeDistribution, classes: usize) -> Option<Data> {
    let (low, high) = (
        target.sample_diameter(1e-4) * 0.9,
        target.sample_diameter(1.0 - 1e-4) * 1.1,
    );
    let (low, high) = (
        low.min(sample.smallest() * 0.999),
        high.max(sample.largest() * 1.001),
    );
    let sizes = sample.diameters();
    let mut rows = String::from("diameter [m],fraction number [count]\n");
    let mut before = 0;
    for i in 0..=classes {
        let edge = low + (high - low) * i as f64 / classes as f64;
        let below = sizes.partition_point(|&d| d <= edge);
        rows += &format!("{edge},{}\n", below - before);
        before = below;
    }
    match parse(Path::new("counts"), &rows, &Options::default()) {
        Ok(Content::Table(table)) => Data::from_table(&table, sizes.len() as f64).ok(),
        _ => None,
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("| law | data | parameter | intervals that hold it |\n|---|---|---|---|");
    for case in &CASES {
        let family: Family = case.family.parse()?;
        let psd = parse_psd(
            "law",
            &format!("{}weighting = \"number\"\n", case.keys),
            None,
        )?;
        let target = SizeDistribution::from_scene(&psd)?;
        for in_classes in [false, true] {
            let trials: Vec<Vec<(String, Option<bool>)>> = (0..TRIALS)
                .into_par_iter()
                .filter_map(|seed| {
                    let sample =
                        Sample::new(draw(&target, case.number, Method::Random, seed)).ok()?;
                    let data = if in_classes {
                        counted(&sample, &target, case.classes)?
                    } else {
                        Data::from_sample(&sample).ok()?
                    };
                    let fitted = fit(&data, family, 0.05).ok()?;
                    let held = fitted.parameters.iter().zip(case.truth).map(|(p, truth)| {
                        let holds = |[low, high]: [f64; 2]| low <= *truth && *truth <= high;
                        (p.name.clone(), p.interval.map(holds))
                    });
                    Some(held.collect())
                })
                .collect();
            let data = if in_classes {
                format!("{} particles in {} classes", case.number, case.classes)
            } else {
                format!("{} sizes", case.number)
            };
            for (i, (name, _)) in trials[0].iter().enumerate() {
                let known: Vec<bool> = trials.iter().filter_map(|trial| trial[i].1).collect();
                if known.is_empty() {
                    println!(
                        "| {} | {data} | {name} | none: the largest size |",
                        case.family
                    );
                    continue;
                }
                let held = known.iter().filter(|&&held| held).count();
                let share = 100.0 * held as f64 / known.len() as f64;
                println!(
                    "| {} | {data} | {name} | {share:.1} % of {} |",
                    case.family,
                    known.len()
                );
            }
        }
    }
    Ok(())
}

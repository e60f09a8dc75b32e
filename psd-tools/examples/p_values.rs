//! Whether the p-values of `check` are uniform: 1000 unbiased samples, their Kolmogorov test. Writes the table of
//! docs/theory/size-distributions.md.
//!
//!     cargo run --release -p psd-tools --example p_values

use mercury_common::scene::parse_psd;
use mercury_common::sizes::SizeDistribution;
use mercury_psd::check::{Goodness, TwoSamples};
use mercury_psd::draw::{Method, draw};
use mercury_psd::sample::Sample;
use mercury_psd::special::kolmogorov_tail;
use rayon::prelude::*;

const SAMPLES: u64 = 1000;

fn uniform(mut list: Vec<f64>) -> (f64, f64) {
    list.sort_by(f64::total_cmp);
    let n = list.len() as f64;
    let distance = |(i, &p): (usize, &f64)| (p - i as f64 / n).max((i + 1) as f64 / n - p);
    let d = list.iter().enumerate().map(distance).fold(0.0, f64::max);
    let rejected = list.iter().filter(|&&p| p < 0.05).count() as f64 / n;
    (kolmogorov_tail(d, list.len()), rejected)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let laws = [
        "{ kind = \"lognormal\", median_diameter = 1e-3, sigma = 0.3, weighting = \"volume\" }",
        "{ kind = \"classes\", weighting = \"volume\", diameters = [3.0, 3.5, 4.0, 4.5, 5.0, 5.6], shares = [8, 23, 32, 25, 12] }",
    ];
    println!("| law | particles | test | KS p of the p-values | p < 0.05 |\n|---|---|---|---|---|");
    // Each case has samples of its own: the tests that look at cumulative numbers alone would give equal results for every law.
    let mut first = 0;
    for text in laws {
        let table: toml::Table = format!("psd = {text}").parse()?;
        let keys = table["psd"].as_table().ok_or("a table")?.to_string();
        let psd = parse_psd("law", &keys, None)?;
        let target = SizeDistribution::from_scene(&psd)?;
        let kind = table["psd"]["kind"].as_str().unwrap_or("");
        for number in [50, 500, 5000] {
            let seeds = first..first + SAMPLES;
            first += 2 * SAMPLES;
            let rows: Vec<[f64; 4]> = seeds
                .into_par_iter()
                .filter_map(|seed| {
                    let sample = Sample::new(draw(&target, number, Method::Random, seed)).ok()?;
                    let other =
                        Sample::new(draw(&target, number + 7, Method::Random, seed + SAMPLES))
                            .ok()?;
                    let goodness = Goodness::of(&sample, &target, 0.05, seed);
                    let two = TwoSamples::of(&sample, &other, 0.05);
                    Some([
                        goodness.kolmogorov?.p,
                        goodness.anderson_darling?.p,
                        two.kolmogorov.p,
                        two.anderson_darling?.p,
                    ])
                })
                .collect();
            if rows.len() as u64 != SAMPLES {
                return Err(format!("{} of {SAMPLES} samples could be tested", rows.len()).into());
            }
            let names = [
                "Kolmogorov-Smirnov",
                "Anderson-Darling",
                "two samples: KS",
                "two samples: AD",
            ];
            for (i, name) in names.iter().enumerate() {
                let (p, rejected) = uniform(rows.iter().map(|row| row[i]).collect());
                println!("| {kind} | {number} | {name} | {p:.3} | {rejected:.3} |");
            }
        }
    }
    Ok(())
}

//! Helpers that several tests use.

use std::path::PathBuf;

use mercury_common::reference_data::shared;
use mercury_common::scene::parse_psd;
use mercury_common::sizes::SizeDistribution;
use mercury_common::sizes::table::{Options, SizeKind, parse_type};

use crate::input::{self, Sizes};
use crate::sample::Sample;
use crate::special::kolmogorov_tail;

/// A file of the reference data on sizes.
pub(crate) fn data(name: &str) -> Option<PathBuf> {
    shared(&format!("data/shapes/psd/{name}"))
}

fn read(name: &str, values: Option<&str>) -> Option<Sizes> {
    let path = data(name)?;
    let options = Options {
        size: Some(SizeKind::Radius),
        per_metre: Some(if name.contains("Lactose") { 1e6 } else { 1.0 }),
        values: values.and_then(|kind| parse_type(kind).ok()),
        mercury: values.is_some(),
        ..Options::default()
    };
    let sources = input::read(&path.to_string_lossy(), &options).expect("sizes");
    sources.into_iter().next().map(|source| source.sizes)
}

pub(crate) fn apapm() -> Option<SizeDistribution> {
    match read("APAPM.csv", Some("cumulative-number"))? {
        Sizes::Distribution(sizes, _) => Some(sizes),
        Sizes::Sample(_) => None,
    }
}

pub(crate) fn lactose() -> Option<SizeDistribution> {
    match read("CVDFLactose.csv", Some("cumulative-volume"))? {
        Sizes::Distribution(sizes, _) => Some(sizes),
        Sizes::Sample(_) => None,
    }
}

pub(crate) fn radii(name: &str) -> Option<Sample> {
    match read(name, None)? {
        Sizes::Sample(sample) => Some(sample),
        Sizes::Distribution(..) => None,
    }
}

pub(crate) fn law(text: &str) -> SizeDistribution {
    let psd = parse_psd("law.toml", text, None).expect("a law");
    SizeDistribution::from_scene(&psd).expect("sizes")
}

/// The p of the Kolmogorov test of p-values against the uniform law.
pub(crate) fn uniform_p(p_values: &[f64]) -> f64 {
    let mut sorted = p_values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len() as f64;
    let distance = |(i, &p): (usize, &f64)| (p - i as f64 / n).max((i + 1) as f64 / n - p);
    let d = sorted.iter().enumerate().map(distance).fold(0.0, f64::max);
    kolmogorov_tail(d, sorted.len())
}

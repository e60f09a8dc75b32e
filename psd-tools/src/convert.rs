//! Distributions as tables of any type.

use mercury_common::formats::number::{NumberStyle, push_number};
use mercury_common::sizes::table::{BY_QUOTA, SizeKind, ValueKind};
use mercury_common::sizes::{ClassModel, Classes, SizeDistribution, Weighting, changes};

use crate::input::Sizes;
use crate::sample::Sample;
use crate::statistics::Unit;

/// How a table is to look.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Form {
    /// Meaning of the values.
    pub kind: ValueKind,
    /// Quantity that is counted.
    pub weighting: Weighting,
    /// Meaning of the sizes.
    pub size: SizeKind,
    /// Their unit.
    pub unit: Unit,
    /// In percent.
    pub percent: bool,
    /// Number of classes into which a law or sample is divided.
    pub classes: usize,
}

/// The classes of a table. A law is divided into classes of equal share of the quantity, a sample into classes of equal width of
/// ln d; a measured table keeps its own. `None` where there is but one size.
#[must_use]
pub fn classes(sizes: &Sizes, form: &Form) -> Option<Classes> {
    match sizes {
        Sizes::Distribution(sizes, _) => match sizes.classes() {
            Some(classes) => Some(classes.clone()),
            None => changes::divided(sizes, form.weighting, form.classes),
        },
        Sizes::Sample(sample) => counted(sample, form.classes),
    }
}

/// Particles counted in classes.
fn counted(sample: &Sample, count: usize) -> Option<Classes> {
    let (low, high) = (sample.smallest(), sample.largest());
    if low == high {
        return None;
    }
    let step = libm::log(high / low) / count as f64;
    let mut edges: Vec<f64> = (0..=count)
        .map(|i| low * libm::exp(step * i as f64))
        .collect();
    edges[count] = high;
    let sizes = sample.diameters();
    let shares: Vec<f64> = edges
        .windows(2)
        .enumerate()
        .map(|(i, class)| {
            // The first class holds its lower end too.
            let from = if i == 0 {
                0
            } else {
                sizes.partition_point(|&d| d <= class[0])
            };
            let to = if i + 1 == count {
                sizes.len()
            } else {
                sizes.partition_point(|&d| d <= class[1])
            };
            to.saturating_sub(from) as f64
        })
        .collect();
    Classes::new(&edges, &shares, Weighting::Number, ClassModel::default()).ok()
}

/// The table as a file that all readers of tables take.
#[must_use]
pub fn table(classes: &Classes, form: &Form) -> String {
    let mut out = Vec::new();
    let size = match form.size {
        SizeKind::Diameter => "diameter",
        SizeKind::Radius => "radius",
        SizeKind::Sieve => "sieve",
    };
    let kind = match form.kind {
        ValueKind::Cumulative => "cumulative",
        ValueKind::Fraction => "fraction",
        ValueKind::Retained => "retained",
        ValueKind::CumulativeRetained => "cumulative retained",
    };
    let unit = if form.percent { "%" } else { "-" };
    out.extend_from_slice(
        format!(
            "# in-class: {}\n{size} [{}],{kind} {} [{unit}]\n",
            classes.model().word(),
            form.unit.name,
            form.weighting.word()
        )
        .as_bytes(),
    );
    let all = if form.percent { 100.0 } else { 1.0 };
    let values: Vec<f64> = match form.kind {
        ValueKind::Cumulative => classes.cumulative(form.weighting),
        ValueKind::Fraction => std::iter::once(0.0)
            .chain(classes.shares(form.weighting))
            .collect(),
        ValueKind::Retained => classes
            .shares(form.weighting)
            .into_iter()
            .chain(std::iter::once(0.0))
            .collect(),
        // Summed from the coarse end: nothing, exactly, stays on the largest size.
        ValueKind::CumulativeRetained => {
            let mut retained = vec![0.0];
            for share in classes.shares(form.weighting).into_iter().rev() {
                retained.push(retained[retained.len() - 1] + share);
            }
            retained.reverse();
            retained
        }
    };
    let part = if form.size == SizeKind::Radius {
        0.5
    } else {
        1.0
    };
    for (edge, value) in classes.edges().iter().zip(values) {
        push_number(
            &mut out,
            edge * part * form.unit.per_metre,
            NumberStyle::Shortest,
        );
        out.push(b',');
        push_number(&mut out, all * value, NumberStyle::Shortest);
        out.push(b'\n');
    }
    String::from_utf8_lossy(&out).into_owned()
}

/// A list of sizes as a file; one that was drawn by quota has a comment of it.
#[must_use]
pub fn list(diameters: &[f64], size: SizeKind, unit: Unit, by_quota: bool) -> Vec<u8> {
    let (name, part) = match size {
        SizeKind::Radius => ("radius", 0.5),
        SizeKind::Diameter | SizeKind::Sieve => ("diameter", 1.0),
    };
    let comment = match by_quota {
        true => format!("# {}: {}\n", BY_QUOTA[0], BY_QUOTA[1]),
        false => String::new(),
    };
    let mut out = format!("{comment}{name} [{}]\n", unit.name).into_bytes();
    for d in diameters {
        push_number(&mut out, d * part * unit.per_metre, NumberStyle::Shortest);
        out.push(b'\n');
    }
    out
}

/// A law or classes as the keys of a scene's `psd`.
#[must_use]
pub fn law(sizes: &SizeDistribution) -> String {
    sizes.statement().to_string()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use mercury_common::sizes::table::{self as tables, Content, Options};
    use proptest::prelude::*;

    fn form(kind: ValueKind, weighting: Weighting) -> Form {
        Form {
            kind,
            weighting,
            size: SizeKind::Diameter,
            unit: Unit {
                name: "m",
                per_metre: 1.0,
            },
            percent: false,
            classes: 20,
        }
    }

    fn read(text: &str) -> tables::SizeTable {
        match tables::parse(Path::new("t.csv"), text, &Options::default()) {
            Ok(Content::Table(table)) => table,
            other => panic!("{text}: {other:?}"),
        }
    }

    proptest! {
        /// number -> any type, as a file -> number, to 1e-12.
        #[test]
        fn tables_go_round(
            widths in prop::collection::vec(0.01_f64..1.0, 1..20),
            shares in prop::collection::vec(0.01_f64..1.0, 20),
            kind in 0..4_usize,
            by in 0..4_usize,
            size in 0..2_usize,
            percent: bool,
            model in 0..8_usize,
        ) {
            let mut edges = vec![1e-3];
            for width in &widths {
                edges.push(edges[edges.len() - 1] * (1.0 + width));
            }
            let (_, model) = ClassModel::all().nth(model).unwrap();
            let classes = Classes::new(&edges, &shares[..widths.len()], Weighting::Number, model).unwrap();
            let form = Form {
                size: [SizeKind::Diameter, SizeKind::Radius][size],
                percent,
                ..form([ValueKind::Cumulative, ValueKind::Fraction, ValueKind::Retained, ValueKind::CumulativeRetained][kind], Weighting::ALL[by])
            };
            let back = read(&super::table(&classes, &form));
            prop_assert_eq!(back.weighting, Weighting::ALL[by]);
            prop_assert_eq!(back.classes.model(), model);
            let (a, b) = (classes.shares(Weighting::Number), back.classes.shares(Weighting::Number));
            prop_assert_eq!(a.len(), b.len());
            for (x, y) in a.iter().zip(&b) {
                // Cumulative shares are written with an error of 1e-16; by volume the finest class may hold 1e-12 of it, and is
                // then known to 1e-4 only: the bound is on what the file holds.
                let tolerance = if matches!(form.kind, ValueKind::Cumulative | ValueKind::CumulativeRetained) {
                    1e-12 + 4e-16 * (edges[edges.len() - 1] / edges[0]).powi(3)
                } else {
                    1e-12
                };
                prop_assert!((x - y).abs() < tolerance, "{} {}", x, y);
            }
        }
    }

    #[test]
    fn samples_are_counted_and_laws_divided() {
        let sample = Sample::new(vec![1.0, 1.1, 1.9, 2.0, 4.0]).unwrap();
        let of_sample = Form {
            classes: 2,
            ..form(ValueKind::Fraction, Weighting::Number)
        };
        let classes = super::classes(&Sizes::Sample(sample), &of_sample).unwrap();
        assert_eq!(classes.shares(Weighting::Number), [0.8, 0.2]);
        let one = Sample::new(vec![1.0, 1.0]).unwrap();
        assert!(super::classes(&Sizes::Sample(one), &of_sample).is_none());
    }

    #[test]
    fn lists_are_read_back() {
        let unit = Unit {
            name: "mm",
            per_metre: 1e3,
        };
        let text = |by_quota| {
            let bytes = list(&[1e-3, 2.5e-3], SizeKind::Radius, unit, by_quota);
            String::from_utf8(bytes).unwrap()
        };
        assert_eq!(text(false), "radius [mm]\n0.5\n1.25\n");
        assert_eq!(text(true), "# sampling: quota\nradius [mm]\n0.5\n1.25\n");
    }
}

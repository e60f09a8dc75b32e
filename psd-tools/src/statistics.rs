//! The numbers that describe a distribution or a sample.

use std::fmt::Write as _;

use mercury_common::sizes::{Classes, SizeDistribution, Weighting};
use serde_json::{Value, json};

use crate::input::Sizes;

/// Mean diameters D\[p,q\] = (M_p/M_q)^(1/(p-q)) that are always given.
const MEANS: [(i32, i32); 6] = [(1, 0), (2, 0), (3, 0), (2, 1), (3, 2), (4, 3)];

/// How quantiles of measured classes are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Quantiles {
    /// Exactly, in the model of the classes.
    #[default]
    Exact,
    /// Linear on the converted cumulative curve, as MercuryDPM does.
    Mercury,
}

/// Queries that a distribution and a sample both answer.
pub trait Spectrum {
    /// The diameter below which a share `u` of a quantity lies, m.
    fn quantile(&self, weighting: Weighting, u: f64) -> f64;
    /// The mean of d^j by number, m^j.
    fn moment(&self, j: i32) -> f64;
    /// Smallest and largest diameter, m.
    fn range(&self) -> [f64; 2];
}

impl Spectrum for Sizes {
    fn quantile(&self, weighting: Weighting, u: f64) -> f64 {
        match self {
            Sizes::Distribution(sizes, _) => sizes.by(weighting).quantile(u),
            Sizes::Sample(sample) => sample.quantile(weighting, u),
        }
    }

    fn moment(&self, j: i32) -> f64 {
        match self {
            Sizes::Distribution(sizes, _) => sizes.moment(j),
            Sizes::Sample(sample) => sample.moment(j),
        }
    }

    fn range(&self) -> [f64; 2] {
        match self {
            Sizes::Distribution(sizes, _) => [sizes.smallest(), sizes.largest()],
            Sizes::Sample(sample) => [sample.smallest(), sample.largest()],
        }
    }
}

/// Statistics in one weighting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// The weighting of the shares.
    pub weighting: Weighting,
    /// Diameters below which 10, 30, 50, 60 and 90 % lie, m.
    pub d10: f64,
    /// 30 %
    pub d30: f64,
    /// 50 %
    pub d50: f64,
    /// 60 %
    pub d60: f64,
    /// 90 %
    pub d90: f64,
    /// Mean diameter, m.
    pub mean: f64,
    /// Standard deviation of the diameter, m.
    pub deviation: f64,
    /// Skewness of the diameter.
    pub skewness: f64,
}

impl Row {
    /// (d90 - d10) / d50
    #[must_use]
    pub fn span(&self) -> f64 {
        (self.d90 - self.d10) / self.d50
    }

    /// Coefficient of uniformity, d60 / d10.
    #[must_use]
    pub fn uniformity(&self) -> f64 {
        self.d60 / self.d10
    }

    /// Coefficient of curvature, d30^2 / (d10 d60).
    #[must_use]
    pub fn curvature(&self) -> f64 {
        self.d30 * self.d30 / (self.d10 * self.d60)
    }
}

/// All statistics.
#[derive(Debug, Clone, PartialEq)]
pub struct Statistics {
    /// In the four weightings.
    pub rows: [Row; 4],
    /// D\[p,q\] with p and q, m.
    pub means: Vec<(i32, i32, f64)>,
    /// Means of d^j by number, j = 1 ... 4, m^j.
    pub moments: [f64; 4],
    /// Surface per volume, 6 / D\[3,2\], 1/m.
    pub specific_surface: f64,
    /// Smallest and largest diameter, m.
    pub range: [f64; 2],
}

impl Statistics {
    /// Statistics of a distribution or a sample.
    #[must_use]
    pub fn of(sizes: &Sizes, quantiles: Quantiles) -> Self {
        let classes = match (quantiles, sizes) {
            (Quantiles::Mercury, Sizes::Distribution(sizes, _)) => sizes.classes(),
            _ => None,
        };
        let quantile = |weighting, u| match classes {
            Some(classes) => linear_quantile(classes, weighting, u),
            None => sizes.quantile(weighting, u),
        };
        let range = sizes.range();
        // Moments in units of the largest size keep their digits and their range.
        let scale = range[1];
        let moment = |j: i32| sizes.moment(j) / scale.powi(j);
        let rows = Weighting::ALL.map(|weighting| {
            let k = i32::from(weighting.power());
            let of = |j: i32| moment(j + k) / moment(k);
            let mean = of(1);
            let variance = (of(2) - mean * mean).max(0.0);
            let third = of(3) - 3.0 * mean * of(2) + 2.0 * mean * mean * mean;
            let [d10, d30, d50, d60, d90] =
                [0.1, 0.3, 0.5, 0.6, 0.9].map(|u| quantile(weighting, u));
            Row {
                weighting,
                d10,
                d30,
                d50,
                d60,
                d90,
                mean: mean * scale,
                deviation: variance.sqrt() * scale,
                skewness: if variance > 1e-20 {
                    third / variance.powf(1.5)
                } else {
                    0.0
                },
            }
        });
        let means: Vec<(i32, i32, f64)> = MEANS
            .iter()
            .map(|&(p, q)| (p, q, mean_diameter(sizes, p, q)))
            .collect();
        Self {
            rows,
            specific_surface: 6.0 / mean_diameter(sizes, 3, 2),
            means,
            moments: [1, 2, 3, 4].map(|j| sizes.moment(j)),
            range,
        }
    }

    /// Adds further mean diameters, each once.
    pub fn add_means(&mut self, sizes: &Sizes, wanted: &[(i32, i32)]) {
        for &(p, q) in wanted {
            if !self.means.iter().any(|&(a, b, _)| (a, b) == (p, q)) {
                self.means.push((p, q, mean_diameter(sizes, p, q)));
            }
        }
    }

    /// For scripts.
    #[must_use]
    pub fn json(&self) -> Value {
        let rows: serde_json::Map<String, Value> = self
            .rows
            .iter()
            .map(|row| {
                let value = json!({
                    "d10": row.d10, "d30": row.d30, "d50": row.d50, "d60": row.d60, "d90": row.d90,
                    "span": row.span(), "uniformity": row.uniformity(), "curvature": row.curvature(),
                    "mean": row.mean, "standard_deviation": row.deviation, "skewness": row.skewness,
                });
                (row.weighting.word().to_owned(), value)
            })
            .collect();
        let means: serde_json::Map<String, Value> = self
            .means
            .iter()
            .map(|(p, q, d)| (format!("D[{p},{q}]"), json!(d)))
            .collect();
        json!({
            "smallest": self.range[0], "largest": self.range[1],
            "by": rows, "mean_diameters": means, "number_moments": self.moments,
            "specific_surface": self.specific_surface,
        })
    }

    /// For people.
    #[must_use]
    pub fn text(&self) -> String {
        let unit = Unit::for_length(self.rows[3].d50);
        let length = |d: f64| format!("{:>10}", unit.show(d));
        let mut text = format!(
            "  diameters in {}\n  {:8}{:>10}{:>10}{:>10}{:>10}{:>10}{:>9}{:>9}{:>9}\n",
            unit.name, "by", "d10", "d50", "d90", "mean", "st.dev.", "span", "d60/d10", "curv."
        );
        for row in &self.rows {
            let _ = writeln!(
                text,
                "  {:8}{}{}{}{}{}{:>9.4}{:>9.4}{:>9.4}",
                row.weighting.word(),
                length(row.d10),
                length(row.d50),
                length(row.d90),
                length(row.mean),
                length(row.deviation),
                row.span(),
                row.uniformity(),
                row.curvature()
            );
        }
        let means = self
            .means
            .iter()
            .map(|(p, q, d)| format!("D[{p},{q}] {}", unit.show(*d)));
        let means: Vec<String> = means.collect();
        let _ = writeln!(text, "  {}", means.join("   "));
        let _ = writeln!(
            text,
            "  from {} to {} {} (ratio {:.4}), specific surface {} 1/m",
            unit.show(self.range[0]),
            unit.show(self.range[1]),
            unit.name,
            self.range[1] / self.range[0],
            significant(self.specific_surface, 6)
        );
        text
    }
}

/// D\[p,q\] = (M_p / M_q)^(1/(p-q)), m. NaN for p = q, whose limit whole moments do not give.
#[must_use]
pub fn mean_diameter(sizes: &Sizes, p: i32, q: i32) -> f64 {
    let scale = sizes.range()[1];
    let moment = |j: i32| sizes.moment(j) / scale.powi(j);
    if p == q {
        return f64::NAN;
    }
    scale * libm::pow(moment(p) / moment(q), 1.0 / f64::from(p - q))
}

/// MercuryDPM's quantile: linear between the edges of the classes on the cumulative curve of the weighting.
#[must_use]
pub fn linear_quantile(classes: &Classes, weighting: Weighting, u: f64) -> f64 {
    let cumulative = classes.cumulative(weighting);
    let edges = classes.edges();
    let above = cumulative
        .partition_point(|&share| share < u)
        .clamp(1, edges.len() - 1);
    let (low, high) = (cumulative[above - 1], cumulative[above]);
    if high <= low {
        return edges[above - 1];
    }
    edges[above - 1] + (u - low) / (high - low) * (edges[above] - edges[above - 1])
}

/// A unit of length for tables.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Name as files write it.
    pub name: &'static str,
    /// Number of units in a metre.
    pub per_metre: f64,
}

impl Unit {
    /// The unit in which a length has one to three digits before the point.
    #[must_use]
    pub fn for_length(length: f64) -> Self {
        let units = [("m", 1.0), ("mm", 1e3), ("um", 1e6), ("nm", 1e9)];
        let (name, per_metre) = units
            .into_iter()
            .find(|(_, per_metre)| length * per_metre >= 1.0)
            .unwrap_or(("nm", 1e9));
        Self { name, per_metre }
    }

    /// A length (m) in the unit, six digits.
    #[must_use]
    pub fn show(&self, length: f64) -> String {
        significant(length * self.per_metre, 6)
    }
}

/// The four deciles of a distribution in a line: for effects of changes.
#[must_use]
pub fn deciles_text(name: &str, deciles: [f64; 3]) -> String {
    let unit = Unit::for_length(deciles[1]);
    let [d10, d50, d90] = deciles.map(|d| unit.show(d));
    format!("{name}: d10 {d10}, d50 {d50}, d90 {d90} {}", unit.name)
}

/// A number with at most so many significant digits.
#[must_use]
pub fn significant(number: f64, digits: usize) -> String {
    if number == 0.0 || !number.is_finite() {
        return format!("{number}");
    }
    let magnitude = number.abs().log10().floor();
    if !(-5.0..7.0).contains(&magnitude) {
        let text = format!("{number:.*e}", digits.saturating_sub(1));
        return match text.split_once('e') {
            Some((digits, exponent)) if digits.contains('.') => {
                format!(
                    "{}e{exponent}",
                    digits.trim_end_matches('0').trim_end_matches('.')
                )
            }
            _ => text,
        };
    }
    let decimals = (digits as f64 - 1.0 - magnitude).max(0.0) as usize;
    let text = format!("{number:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// The weighting of a distribution as it was stated; of particles counted one by one number.
#[must_use]
pub fn stated(sizes: &Sizes) -> Weighting {
    match sizes {
        Sizes::Distribution(sizes, _) => sizes.weighting(),
        Sizes::Sample(_) => Weighting::Number,
    }
}

/// In a few words what it is.
#[must_use]
pub fn described(sizes: &Sizes) -> String {
    match sizes {
        Sizes::Sample(sample) => format!("{} particles", sample.len()),
        Sizes::Distribution(sizes, table) => described_distribution(sizes, table.is_some()),
    }
}

fn described_distribution(sizes: &SizeDistribution, is_table: bool) -> String {
    match sizes.classes() {
        Some(classes) => format!(
            "{} classes by {}, {} inside",
            classes.edges().len() - 1,
            sizes.weighting().word(),
            classes.model().word()
        ),
        None if is_table => "a table".to_owned(),
        None => {
            let keys = sizes.statement();
            let kind = keys
                .get("kind")
                .and_then(toml::Value::as_str)
                .unwrap_or("law");
            format!("{kind} by {}", sizes.weighting().word())
        }
    }
}

#[cfg(test)]
mod tests;

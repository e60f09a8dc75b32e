//! Reports of a check, as text and as JSON.

use std::fmt::Write as _;

use mercury_common::sizes::{SizeDistribution, Weighting};
use serde_json::{Value, json};

use crate::check::{
    Finding, Goodness, Interval, Statistic, TwoSamples, Verdict, number_band, number_interval,
    too_few, volume_interval,
};
use crate::sample::Sample;
use crate::statistics::{Unit, significant};

const DECILES: [(&str, f64); 3] = [("d10", 0.1), ("d50", 0.5), ("d90", 0.9)];

/// A sample that was tested.
#[derive(Debug, Clone, Copy)]
pub struct Check<'a> {
    /// Name of the sample.
    pub name: &'a str,
    /// The particles.
    pub sample: &'a Sample,
    /// Distribution that the sizes should have.
    pub target: &'a SizeDistribution,
    /// The tests.
    pub goodness: &'a Goodness,
    /// Verdict on the sample.
    pub verdict: &'a Verdict,
    /// 1 - level is the confidence of bands and intervals.
    pub level: f64,
    /// Mass present and mass set by the scene, kg.
    pub masses: Option<[f64; 2]>,
    /// Number of quotas that the sizes come by; 0: at random, some or all.
    pub quotas: usize,
}

impl Check<'_> {
    fn intervals(&self) -> Vec<(Weighting, &'static str, Interval, f64)> {
        let mut rows = Vec::new();
        for weighting in [Weighting::Number, Weighting::Volume] {
            let view = self.target.by(weighting);
            for (name, u) in DECILES {
                let interval = match weighting {
                    Weighting::Volume => volume_interval(self.sample, u, self.level),
                    _ => number_interval(self.sample, u, self.level),
                };
                rows.push((weighting, name, interval, view.quantile(u)));
            }
        }
        rows
    }

    fn tests(&self) -> Vec<(&'static str, &'static str, Statistic)> {
        let goodness = self.goodness;
        [
            ("Kolmogorov-Smirnov", "D", goodness.kolmogorov),
            ("Anderson-Darling", "A^2", goodness.anderson_darling),
        ]
        .into_iter()
        .filter_map(|(name, letter, statistic)| Some((name, letter, statistic?)))
        .collect()
    }

    /// For people.
    #[must_use]
    pub fn text(&self) -> String {
        let goodness = self.goodness;
        let unit = Unit::for_length(self.target.quantile(0.5));
        let mut text = format!("{}: {} particles\n", self.name, goodness.number);
        for (name, letter, statistic) in self.tests() {
            let _ = writeln!(
                text,
                "  {name:20} {letter:4}= {:<12} p = {}",
                significant(statistic.value, 4),
                probability(statistic.p)
            );
        }
        let band = number_band(goodness.number, self.level);
        // Of single sizes the curves are steps at the same places, and their distance there has no meaning.
        if !self.target.has_single_sizes() {
            let _ = writeln!(
                text,
                "  {:20} {:4}= {:<12} {}, as if of {} equal particles",
                "volume",
                "D",
                significant(goodness.volume_distance, 4),
                if goodness.volume_band.half_width < 1.0 {
                    format!(
                        "{} % band +-{}",
                        significant(100.0 * (1.0 - self.level), 4),
                        significant(goodness.volume_band.half_width, 3)
                    )
                } else {
                    "no band".to_owned()
                },
                significant(goodness.volume_band.effective_number, 3)
            );
        }
        let _ = writeln!(
            text,
            "  Wasserstein distance {} {} = {} % of d50; {}",
            significant(goodness.wasserstein * unit.per_metre, 4),
            unit.name,
            significant(
                100.0 * goodness.wasserstein / self.target.by(Weighting::Number).quantile(0.5),
                3
            ),
            if band < 1.0 {
                format!("band of the number +-{}", significant(band, 3))
            } else {
                "no band of the number".to_owned()
            }
        );
        let _ = writeln!(
            text,
            "  {:8}{:5}{:>12}{:>12}{:>26}{:>10}",
            "by", unit.name, "target", "sample", "interval", "off"
        );
        for (weighting, name, interval, wanted) in self.intervals() {
            let _ = writeln!(
                text,
                "  {:8}{:5}{:>12}{:>12}{:>26}{:>+8.2} %",
                weighting.word(),
                name,
                unit.show(wanted),
                unit.show(interval.value),
                ends(&interval, |end| unit.show(end)),
                100.0 * (interval.value / wanted - 1.0)
            );
        }
        if let Some([mass, wanted]) = self.masses {
            let _ = writeln!(
                text,
                "  mass {} kg, expected for the total {} kg ({:+.3} %)",
                significant(mass, 6),
                significant(wanted, 6),
                100.0 * (mass / wanted - 1.0)
            );
        }
        for note in self.notes() {
            let _ = writeln!(text, "  note: {note}");
        }
        let word = self.verdict.finding.word();
        let _ = writeln!(text, "  {word}: {}", self.verdict.reasons.join("; "));
        text
    }

    /// Whether these are all sizes of a quota, or of several.
    ///
    /// Sizes come in random order: the first ones are like a random sample. Of n that are whole the curve of the n_i sizes of
    /// each keeps within 1/n_i of the target, so that of all N within n/N; and the mass of each misses its target by half of the
    /// largest particle at most, and by one more where a total by number is shared out by rounding.
    #[must_use]
    pub fn is_whole_quota(&self) -> bool {
        let (quotas, number) = (self.quotas as f64, self.goodness.number as f64);
        let within = quotas * (1.0 + 1e-6) / number;
        let has_all_sizes = (self.goodness.kolmogorov).is_none_or(|test| test.value <= within);
        let has_all_mass = self.masses.is_none_or(|[mass, wanted]| {
            // Mean volume over largest; densities are the same. Of discs less than the mean area over the largest, and the bound wider.
            let relative = self.sample.moment(3) / self.target.largest().powi(3);
            let largest = mass / number / relative;
            (wanted - mass).abs() <= 1.5 * quotas * largest * (1.0 + 1e-6)
        });
        self.quotas > 0 && has_all_sizes && has_all_mass
    }

    fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        let is_complete = self.is_whole_quota();
        if self.quotas > 0 && !is_complete {
            notes.push("the quota is not complete: its sizes come in random order, and what came fits like random sizes".to_owned());
        } else if self.quotas > 0 {
            notes.push("sizes follow by quota, which fits better than chance: p-values near 1 are to be expected".to_owned());
        }
        if self.goodness.kolmogorov.is_some() && self.target.has_single_sizes() {
            notes.push("the target has single sizes: p is an upper bound".to_owned());
        }
        if self.goodness.number > 100_000 && self.verdict.finding == Finding::Failed {
            notes.push("with so many particles differences that do not matter are significant; --tolerance judges by size".to_owned());
        }
        notes
    }

    /// For scripts.
    #[must_use]
    pub fn json(&self) -> Value {
        let goodness = self.goodness;
        let tests: serde_json::Map<String, Value> = self
            .tests()
            .into_iter()
            .map(|(name, _, test)| (name.to_owned(), json!({ "value": test.value, "p": test.p })))
            .collect();
        let quantiles: Vec<Value> = self
            .intervals()
            .into_iter()
            .map(|(weighting, name, interval, wanted)| {
                json!({
                    "by": weighting.word(), "name": name, "target": wanted, "sample": interval.value,
                    "low": interval.low, "high": interval.high,
                })
            })
            .collect();
        json!({
            "number": goodness.number, "passed": self.verdict.passed(), "verdict": self.verdict.finding.word().to_lowercase(),
            "reasons": self.verdict.reasons,
            "tests": tests,
            "wasserstein": goodness.wasserstein, "number_band": number_band(goodness.number, self.level),
            "volume_distance": goodness.volume_distance, "volume_band": goodness.volume_band.half_width,
            "volume_p": goodness.volume_band.p, "effective_number_by_volume": goodness.volume_band.effective_number,
            "smaller": goodness.outside.below, "larger": goodness.outside.above,
            "quantiles": quantiles, "mass": self.masses.map(|m| m[0]), "requested_mass": self.masses.map(|m| m[1]),
            "notes": self.notes(),
        })
    }
}

/// Small probabilities as powers of ten.
fn probability(p: f64) -> String {
    if p == 0.0 {
        "< 1e-300".to_owned()
    } else if p < 1e-3 {
        format!("{p:.1e}")
    } else {
        format!("{p:.3}")
    }
}

/// Comparison of two samples, as text.
#[must_use]
pub fn two_samples_text(name: &str, result: &TwoSamples, level: f64) -> String {
    let unit = Unit::for_length(result.wasserstein);
    let mut text = format!(
        "{name}: {} against {} particles\n",
        result.numbers[0], result.numbers[1]
    );
    for (name, letter, test) in result.tests() {
        let _ = writeln!(
            text,
            "  {name:20} {letter:4}= {:<12} p = {}",
            significant(test.value, 4),
            probability(test.p)
        );
    }
    let _ = writeln!(
        text,
        "  Wasserstein distance {} {}, largest distance by volume {}",
        significant(result.wasserstein * unit.per_metre, 4),
        unit.name,
        significant(result.volume_distance, 4)
    );
    for (weighting, name, interval) in &result.differences {
        let _ = writeln!(
            text,
            "  {name} by {:7}{:>+9.3} %  ({})",
            weighting.word(),
            100.0 * interval.value,
            ends(interval, |end| format!("{:+.3} %", 100.0 * end)),
        );
    }
    if result.ties {
        text += "  note: equal sizes occur, so the p-values are approximate\n";
    }
    let finding = result.finding(level);
    let why = match finding {
        Finding::Passed => format!("no difference is seen at level {level}"),
        Finding::Failed => format!("the two differ at level {level}"),
        Finding::Undetermined => {
            let [first, second] = result.numbers;
            too_few(&format!("{first} against {second}"), level)
        }
    };
    let _ = writeln!(text, "  {}: {why}", finding.word());
    text
}

/// An interval in words.
fn ends(interval: &Interval, show: impl Fn(f64) -> String) -> String {
    match (interval.low, interval.high) {
        (Some(low), Some(high)) => format!("{} ... {}", show(low), show(high)),
        (Some(low), None) => format!("from {} on", show(low)),
        (None, Some(high)) => format!("up to {}", show(high)),
        (None, None) => "too few to tell".to_owned(),
    }
}

/// Comparison of two samples, as JSON.
#[must_use]
pub fn two_samples_json(result: &TwoSamples, level: f64) -> Value {
    let differences: Vec<Value> = result
        .differences
        .iter()
        .map(|(weighting, name, interval)| {
            json!({
                "by": weighting.word(), "name": name, "difference": interval.value,
                "low": interval.low, "high": interval.high,
            })
        })
        .collect();
    let mut object = json!({
        "numbers": result.numbers, "passed": result.finding(level) == Finding::Passed,
        "verdict": result.finding(level).word().to_lowercase(),
        "wasserstein": result.wasserstein, "volume_distance": result.volume_distance,
        "differences": differences, "ties": result.ties,
    });
    for (name, _, test) in result.tests() {
        object[name] = json!({ "value": test.value, "p": test.p });
    }
    object
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::Criterion;
    use crate::draw::{Method, draw};
    use crate::test_support::law;

    /// Whether the sizes are called the whole of so many quotas of which this share of the mass came.
    fn is_whole(sizes: &[f64], target: &SizeDistribution, quotas: usize, came: f64) -> bool {
        let sample = Sample::new(sizes.to_vec()).expect("sizes");
        let goodness = Goodness::of(&sample, target, 0.01, 0);
        let verdict = Verdict::of(&goodness, &sample, target, Criterion::Level(0.01));
        let check = Check {
            name: "grain",
            sample: &sample,
            target,
            goodness: &goodness,
            verdict: &verdict,
            level: 0.01,
            masses: Some([came, 1.0]),
            quotas,
        };
        let notes = check.notes().join("; ");
        assert_eq!(check.is_whole_quota(), !notes.contains("not complete"));
        check.is_whole_quota()
    }

    #[test]
    fn a_quota_is_whole_when_its_sizes_and_its_mass_are_there() {
        let narrow = law(
            "kind = \"uniform\"\nmin_diameter = 1e-3\nmax_diameter = 1.01e-3\nweighting = \"number\"",
        );
        let quota = |number, seed| draw(&narrow, number, Method::Quota, seed);
        // All but two of 10,000: more than 99.9 % of the mass.
        let all = quota(10_000, 1);
        assert!(is_whole(&all, &narrow, 1, 1.0));
        let share = 9998.0 / 10_000.0;
        assert!(!is_whole(&all[..9998], &narrow, 1, share));
        // Three particles, whose mass is what fits best: a tenth of one too little.
        assert!(is_whole(&quota(3, 1), &narrow, 1, 1.0 - 0.1 / 3.0));
        // One of a thousand fits as well as one size can.
        assert!(!is_whole(&[1.005e-3], &narrow, 1, 1e-3));
        // Two quotas of one distribution: each within 1/n_i, so all within 2/N.
        let two: Vec<f64> = [quota(30, 1), quota(70, 2)].concat();
        assert!(is_whole(&two, &narrow, 2, 1.0));
        assert!(!is_whole(&two[..90], &narrow, 2, 0.9));

        // For single sizes only the mass is informative.
        let beads = law("kind = \"monodisperse\"\ndiameter = 1e-3");
        assert!(is_whole(&[1e-3; 50], &beads, 1, 1.0));
        assert!(!is_whole(&[1e-3; 48], &beads, 1, 0.96));
    }
}

//! Laws fitted to measurements by maximum likelihood, in the weighting that was measured.
//!
//! `family` holds the laws, `data` what was measured and its likelihood, `minimise` the search, `determined` what the data leave open,
//! `bootstrap` the p-values.
//! Parameters are searched as logarithms (means of normal laws as they are, shares of mixtures as logits), with diameters in units of
//! the median of the data; standard errors come from the second derivatives of the likelihood there (the observed
//! information), intervals are those of the searched parameters, carried over.

mod bootstrap;
mod data;
mod determined;
mod family;
mod minimise;

use mercury_common::normal::normal_quantile;
use mercury_common::sizes::Weighting;
use toml::{Table, Value};

pub use data::{Data, DataError};
pub use family::{Family, Shape};

use determined::Lack;
use family::Law;
use minimise::{Minimum, minimise};

/// A parameter of a fitted law.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// The key of the scene format, for mixtures with the number of the component: `median_diameter`, `sigma 2`.
    pub name: String,
    /// `m`, or empty for a pure number.
    pub unit: &'static str,
    /// Its value.
    pub value: f64,
    /// Standard error; none where the data do not determine it, or it lies at the end of the data.
    pub error: Option<f64>,
    /// Ends of the confidence interval.
    pub interval: Option<[f64; 2]>,
    /// Why it has neither.
    pub lack: Option<String>,
}

/// Observed against expected: for the plot of residuals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Residual {
    /// Bounds of a class, m; equal for a single size.
    pub low: f64,
    /// Bounds of a class, m.
    pub high: f64,
    /// Residual of a class: (observed - expected) over the binomial standard deviation. Of a single size: the distance of the
    /// cumulative shares, sample less law, times the root of the number.
    pub value: f64,
}

/// A fitted law.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// Family of the law.
    pub family: Family,
    /// Quantity that was measured.
    pub weighting: Weighting,
    /// The parameters, in the order of the scene's keys.
    pub parameters: Vec<Parameter>,
    /// Number of particles in the likelihood.
    pub number: f64,
    /// The logarithm of the likelihood, without the constant that depends on the data alone.
    pub log_likelihood: f64,
    /// Akaike's criterion: 2 k - 2 ln L. Smaller is better; differences below 2 mean little.
    pub aic: f64,
    /// Schwarz's criterion: k ln N - 2 ln L.
    pub bic: f64,
    /// A^2 for single sizes, the deviance for classes: how far the data are from the law.
    pub distance: f64,
    /// Share of data drawn from the fitted law, and fitted again, that are farther; `None` if it was not requested.
    pub p: Option<f64>,
    /// Class by class or size by size.
    pub residuals: Vec<Residual>,
    /// The law in units of m.
    law: Law,
}

impl Fitted {
    /// The share below `diameter` (m).
    #[must_use]
    pub fn cdf(&self, diameter: f64) -> f64 {
        self.law.cdf(diameter)
    }

    /// The diameter below which a share `u` lies, m.
    #[must_use]
    pub fn quantile(&self, u: f64) -> f64 {
        self.law.quantile(u)
    }

    /// The keys of a scene's `psd`. `range`: cut to these diameters (m), for laws that need it.
    #[must_use]
    pub fn statement(&self, range: Option<[f64; 2]>) -> Table {
        let mut keys = Table::new();
        let word = self.family.shape.word();
        match &self.law.parts[..] {
            [(_, part)] => part_keys(word, part, &mut keys),
            parts => {
                keys.insert("kind".into(), "mixture".into());
                let of = parts.iter().map(|(share, part)| {
                    let mut keys = Table::new();
                    keys.insert("share".into(), Value::Float(*share));
                    part_keys(word, part, &mut keys);
                    if let Some(range) = range {
                        keys.insert("cut".into(), cut(range.map(|d| part.cdf(d))));
                    }
                    Value::Table(keys)
                });
                keys.insert("of".into(), Value::Array(of.collect()));
            }
        }
        keys.insert("weighting".into(), self.weighting.word().into());
        if let (Some(range), [(_, part)]) = (range, &self.law.parts[..]) {
            keys.insert("cut".into(), cut(range.map(|d| part.cdf(d))));
        }
        keys
    }
}

fn cut(quantiles: [f64; 2]) -> Value {
    Value::Array(quantiles.map(Value::Float).to_vec())
}

fn part_keys(word: &str, part: &family::Part, keys: &mut Table) {
    keys.insert("kind".into(), word.into());
    for (name, value) in part.shape.names().iter().zip(part.values()) {
        keys.insert((*name).into(), Value::Float(value));
    }
}

/// Fits a law. `level`: of the intervals.
///
/// # Errors
/// [`DataError`] where the data cannot determine the law.
pub fn fit(data: &Data, family: Family, level: f64) -> Result<Fitted, DataError> {
    data.check(family)?;
    let minimum = search(data, family)?;
    Ok(finished(data, family, minimum, level))
}

/// Fits a law, and draws `draws` samples from it to see how often chance alone takes data as far from their law.
///
/// # Errors
/// As [`fit`].
pub fn fit_with_p(
    data: &Data,
    family: Family,
    level: f64,
    draws: usize,
    seed: u64,
) -> Result<Fitted, DataError> {
    data.check(family)?;
    let minimum = search(data, family)?;
    let p = bootstrap::p_value(data, family, &minimum, draws, seed);
    let fitted = finished(data, family, minimum, level);
    Ok(Fitted {
        p: Some(p),
        ..fitted
    })
}

/// The best of searches from several starts.
fn search(data: &Data, family: Family) -> Result<Minimum, DataError> {
    if let Some(minimum) = data.closed_form(family) {
        return Ok(minimum);
    }
    let mut best: Option<Minimum> = None;
    let mut is_unbounded = false;
    for start in data.starts(family) {
        let found = minimise(|theta| data.minus_log_likelihood(family, theta), &start);
        if !found.value.is_finite() {
            continue;
        }
        if !data.is_maximum(family, &found) {
            is_unbounded = true;
            continue;
        }
        if best.as_ref().is_none_or(|b| found.value < b.value) {
            best = Some(found);
        }
    }
    best.ok_or(if is_unbounded {
        DataError::Unbounded {
            number: data.number(),
            family,
        }
    } else {
        DataError::NoFit(family)
    })
}

/// Searched again from a start that is known to be near.
fn search_near(data: &Data, family: Family, start: &[f64]) -> Minimum {
    data.closed_form(family)
        .unwrap_or_else(|| minimise(|theta| data.minus_log_likelihood(family, theta), start))
}

fn finished(data: &Data, family: Family, minimum: Minimum, level: f64) -> Fitted {
    let unit = data.unit();
    let law = Law::of(family, &minimum.at).scaled(unit);
    let free = minimum.at.len() as f64;
    let number = data.number();
    let log_likelihood = -minimum.value;
    let z = normal_quantile(1.0 - 0.5 * level);
    let errors = if data.is_at_end(family) {
        data.end_errors(&minimum)
    } else {
        minimum.errors(|theta| data.minus_log_likelihood(family, theta))
    };
    let lacks = determined::lacks(data, family, &minimum, &errors, z);
    let known: Vec<Result<f64, Option<Lack>>> = (errors.iter().zip(lacks))
        .map(|(error, lack)| match (error, lack) {
            (Some(error), None) => Ok(*error),
            (_, lack) => Err(lack),
        })
        .collect();
    Fitted {
        family,
        weighting: data.weighting(),
        parameters: parameters(family, &minimum.at, &known, unit, z),
        number,
        log_likelihood,
        aic: 2.0 * free - 2.0 * log_likelihood,
        bic: free * libm::log(number) - 2.0 * log_likelihood,
        distance: data.distance(&Law::of(family, &minimum.at)),
        p: None,
        residuals: data.residuals(&law),
        law,
    }
}

/// In words, `at` being where the parameter is followed to.
fn why(lack: Lack, at: &str, z: f64) -> String {
    match lack {
        Lack::AtEnd => "no standard error: the largest of the sizes".to_owned(),
        Lack::Flat { fall, .. } => format!(
            "not determined by these data: {at} the other parameters make up for it, ln L falls by {:.2} only, and an interval ends where it falls by {:.2}",
            fall.max(0.0),
            0.5 * z * z
        ),
        Lack::Absent { fall } => format!(
            "not determined by these data: of one part alone ln L is smaller by {:.2} only, and an interval ends where it falls by {:.2}",
            fall.max(0.0),
            0.5 * z * z
        ),
        Lack::Others => {
            "no standard error: ln L is flat here, as other parameters are not determined"
                .to_owned()
        }
    }
}

/// Searched parameters and their errors (or why there are none) as those of the law, the smaller component first.
fn parameters(
    family: Family,
    theta: &[f64],
    errors: &[Result<f64, Option<Lack>>],
    unit: f64,
    z: f64,
) -> Vec<Parameter> {
    let mut list = Vec::new();
    let names = family.shape.names();
    let parts: Vec<usize> = match family.components {
        1 => vec![0],
        // As `Law::of` orders them.
        _ if family::first_is_smaller(family, theta) => vec![1, 3],
        _ => vec![3, 1],
    };
    if family.components == 2 {
        let first = parts[0] == 1;
        let sign = if first { 1.0 } else { -1.0 };
        let logistic = |t: f64| 1.0 / (1.0 + libm::exp(-t));
        let t = sign * theta[0];
        let share = logistic(t);
        let error = errors[0].ok();
        list.push(Parameter {
            name: "share 1".to_owned(),
            unit: "",
            value: share,
            error: error.map(|e| e * share * (1.0 - share)),
            interval: error.map(|e| [logistic(t - z * e), logistic(t + z * e)]),
            lack: errors[0].err().flatten().map(|lack| why(lack, "", z)),
        });
    }
    for (number, &start) in parts.iter().enumerate() {
        for (i, name) in names.iter().enumerate() {
            let (t, error) = (theta[start + i], errors[start + i].ok());
            let is_length = family.shape.is_length(i);
            let unit_of = if is_length { unit } else { 1.0 };
            let (natural, slope): (Box<dyn Fn(f64) -> f64>, f64) = if family.shape.is_plain(i) {
                (Box::new(move |t| unit_of * t), unit_of)
            } else {
                (
                    Box::new(move |t| unit_of * libm::exp(t)),
                    unit_of * libm::exp(t),
                )
            };
            list.push(Parameter {
                name: match family.components {
                    1 => (*name).to_owned(),
                    _ => format!("{name} {}", number + 1),
                },
                unit: if is_length { "m" } else { "" },
                value: natural(t),
                error: error.map(|e| e * slope),
                interval: error.map(|e| [natural(t - z * e), natural(t + z * e)]),
                lack: errors[start + i].err().flatten().map(|lack| {
                    let upwards = matches!(lack, Lack::Flat { upwards: true, .. });
                    let at = match (upwards, family.shape.is_plain(i)) {
                        (false, false) => "a hundred times smaller",
                        (true, false) => "a hundred times larger",
                        (false, true) => "far below",
                        (true, true) => "far above",
                    };
                    why(lack, at, z)
                }),
            });
        }
    }
    list
}

#[cfg(test)]
mod tests;

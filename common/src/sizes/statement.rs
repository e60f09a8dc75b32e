//! A distribution in words: the keys of a scene's `psd`, which read back as the same distribution.

use toml::{Table, Value};

use super::Weighting;
use super::distribution::{Form, SizeDistribution};
use super::laws::{CutLaw, Law};
use super::powers::whole_power;

impl Weighting {
    /// The word of files: `number`, `length`, `area`, `volume`.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Weighting::Number => "number",
            Weighting::Length => "length",
            Weighting::Area => "area",
            Weighting::Volume => "volume",
        }
    }

    /// All four, from number to volume.
    pub const ALL: [Self; 4] = [
        Weighting::Number,
        Weighting::Length,
        Weighting::Area,
        Weighting::Volume,
    ];
}

impl SizeDistribution {
    /// The keys of a scene's `psd` for this distribution; a table in a file is written out as its classes.
    ///
    /// ```
    /// use mercury_common::scene::parse_psd;
    /// use mercury_common::sizes::SizeDistribution;
    /// let text = "kind = \"lognormal\"\nmedian_diameter = 0.003\nsigma = 0.2\nweighting = \"volume\"\n";
    /// let sizes = SizeDistribution::from_scene(&parse_psd("x.toml", text, None).unwrap())?;
    /// assert_eq!(sizes.statement().to_string(), text);
    /// # Ok::<(), mercury_common::sizes::SizeError>(())
    /// ```
    #[must_use]
    pub fn statement(&self) -> Table {
        let mut keys = Table::new();
        match self.form() {
            Form::Law(law) => law_keys(law, &mut keys),
            Form::Classes(classes) => {
                let numbers = |values: &[f64]| {
                    Value::Array(values.iter().map(|&v| Value::Float(v)).collect())
                };
                keys.insert("kind".into(), "classes".into());
                keys.insert("diameters".into(), numbers(classes.edges()));
                let shares = classes.shares(self.weighting());
                keys.insert("shares".into(), numbers(&shares));
                keys.insert("model".into(), classes.model().word().into());
            }
            Form::Mixture(parts) => {
                keys.insert("kind".into(), "mixture".into());
                let k = i32::from(self.weighting().power());
                // In units of the largest size, so that powers stay in range.
                let scale = self.largest();
                let weights: Vec<f64> = parts
                    .iter()
                    .map(|(number, part)| number * (part.moment(k) / whole_power(scale, k)))
                    .collect();
                let sum: f64 = weights.iter().sum();
                let of = weights.iter().zip(parts).map(|(weight, (_, part))| {
                    let mut keys = Table::new();
                    keys.insert("share".into(), Value::Float(weight / sum));
                    keys.extend(part.statement());
                    Value::Table(keys)
                });
                keys.insert("of".into(), Value::Array(of.collect()));
            }
        }
        if !self.is_one_size() {
            keys.insert("weighting".into(), self.weighting().word().into());
        }
        if let Form::Law(law) = self.form()
            && let Some(cut) = law.stated_cut()
        {
            let cut = cut.map(Value::Float).to_vec();
            keys.insert("cut".into(), Value::Array(cut));
        }
        keys
    }

    fn is_one_size(&self) -> bool {
        matches!(self.form(), Form::Law(law) if matches!(law.law, Law::Monodisperse(_)))
    }
}

fn law_keys(law: &CutLaw, keys: &mut Table) {
    let (kind, values): (&str, Vec<(&str, f64)>) = match law.law {
        Law::Monodisperse(diameter) => ("monodisperse", vec![("diameter", diameter)]),
        Law::Uniform { min, max } => (
            "uniform",
            vec![("min_diameter", min), ("max_diameter", max)],
        ),
        Law::Normal { mean, deviation } => (
            "normal",
            vec![("mean_diameter", mean), ("standard_deviation", deviation)],
        ),
        Law::Lognormal { median, sigma } => (
            "lognormal",
            vec![("median_diameter", median), ("sigma", sigma)],
        ),
        Law::RosinRammler { d63, exponent } => {
            ("rosin-rammler", vec![("d63", d63), ("exponent", exponent)])
        }
        Law::Power { max, exponent } => {
            ("ggs", vec![("max_diameter", max), ("exponent", exponent)])
        }
    };
    keys.insert("kind".into(), kind.into());
    for (key, value) in values {
        keys.insert(key.into(), Value::Float(value));
    }
}

//! Distribution that particle sizes are drawn from: a law, a measured table, or a mixture.

use std::f64::consts::PI;

use super::classes::Classes;
use super::error::SizeError;
use super::laws::{CutLaw, Law};
use super::open_files::OpenFiles;
use super::powers::whole_power;
use super::table;
use super::weighted::{Way, Weighted};
use crate::scene::{Located, Psd, SizeLaw, Weighting, read_psd_with};

/// A distribution of the diameter that particles can be drawn from. Diameters in m.
///
/// Built from a scene by [`SizeDistribution::from_scene`], from a measurement by [`SizeDistribution::from_classes`].
#[derive(Debug, Clone)]
pub struct SizeDistribution {
    form: Form,
    weighting: Weighting,
    /// The view by which particles are drawn.
    number: Weighted,
}

#[derive(Debug, Clone)]
pub(super) enum Form {
    Law(CutLaw),
    Classes(Classes),
    /// Parts with their shares by number, whose sum is 1.
    Mixture(Vec<(f64, SizeDistribution)>),
}

impl SizeDistribution {
    /// The distribution that a scene describes. The file of a measured distribution is read.
    ///
    /// # Errors
    /// [`SizeError::Improper`] where the law as stated holds infinitely many particles at d = 0 or
    /// reaches d <= 0, and where files of laws name each other, with the place in the scene and the remedy;
    /// [`SizeError::File`] where a table is wrong; [`SizeError::Law`] where a file with a law is.
    pub fn from_scene(psd: &Located<Psd>) -> Result<Self, SizeError> {
        Self::resolved(psd, &mut OpenFiles::of(psd))
    }

    fn resolved(psd: &Located<Psd>, open: &mut OpenFiles) -> Result<Self, SizeError> {
        let weighting = psd.weighting.unwrap_or(Weighting::Number);
        let cut = psd.cut.as_ref().map(|cut| cut.value);
        let law = match &psd.law {
            SizeLaw::Monodisperse { diameter } => Law::Monodisperse(**diameter),
            SizeLaw::Uniform {
                min_diameter,
                max_diameter,
            } => {
                if **min_diameter == **max_diameter {
                    Law::Monodisperse(**min_diameter)
                } else {
                    Law::Uniform {
                        min: **min_diameter,
                        max: **max_diameter,
                    }
                }
            }
            SizeLaw::Normal {
                mean_diameter,
                standard_deviation,
            } => Law::Normal {
                mean: **mean_diameter,
                deviation: **standard_deviation,
            },
            SizeLaw::Lognormal {
                median_diameter,
                sigma,
            } => Law::Lognormal {
                median: **median_diameter,
                sigma: **sigma,
            },
            // phi = -log2(d / 1 mm) is normal exactly when ln d is, with ln 2 between their widths.
            SizeLaw::PhiNormal {
                median_diameter,
                sigma_phi,
            } => Law::Lognormal {
                median: **median_diameter,
                sigma: **sigma_phi * std::f64::consts::LN_2,
            },
            SizeLaw::RosinRammler { d63, exponent } => Law::RosinRammler {
                d63: **d63,
                exponent: **exponent,
            },
            SizeLaw::Ggs {
                max_diameter,
                exponent,
            } => Law::Power {
                max: **max_diameter,
                exponent: **exponent,
            },
            SizeLaw::Mixture { of } => {
                let mut parts = Vec::new();
                for part in of {
                    parts.push((part.share, Self::resolved(&part.psd, open)?));
                }
                return Self::mixture(parts, weighting).ok_or_else(|| {
                    SizeError::Improper(psd.error("all shares of the mixture are 0"))
                });
            }
            SizeLaw::Classes {
                diameters,
                shares,
                model,
            } => {
                let classes = Classes::new(diameters, shares, weighting, *model)
                    .map_err(|problem| SizeError::Improper(psd.error(problem.to_string())))?;
                return Self::from_classes(classes, weighting)
                    .cut(cut)
                    .map_err(|problem| SizeError::Improper(psd.error(problem)));
            }
            SizeLaw::File { file } => {
                let problem = |problem| SizeError::Improper(psd.error(problem));
                open.count(file)?;
                if file.extension().is_some_and(|ending| ending == "toml") {
                    open.enter(file)?;
                    let files = file.place.files().clone();
                    let law = read_psd_with(file, files).map_err(SizeError::Law)?;
                    if let SizeLaw::File { file: inner } = &law.law {
                        let message = "the law of a file must not be a file again";
                        return Err(SizeError::Improper(inner.error(message)));
                    }
                    let sizes = Self::resolved(&law, open)?;
                    open.leave();
                    return sizes.cut(cut).map_err(problem);
                }
                let table = table::read(file).map_err(SizeError::File)?;
                return Self::from_classes(table.classes, table.weighting)
                    .cut(cut)
                    .map_err(problem);
            }
        };
        let law = CutLaw::new(law, i32::from(weighting.power()), cut);
        law.map(|law| Self::of(Form::Law(law), weighting))
            .map_err(|problem| {
                let error = psd.error(format!("the distribution {problem}"));
                let help = "cut it at quantiles of its weighting, for example cut = [0.01, 0.99]";
                SizeError::Improper(error.with_help(help))
            })
    }

    /// One size, a diameter above 0 (m).
    #[must_use]
    pub fn single(diameter: f64) -> Option<Self> {
        let law = CutLaw::new(Law::Monodisperse(diameter), 0, None).ok()?;
        Some(Self::of(Form::Law(law), Weighting::Number))
    }

    /// A measured distribution; `weighting` is what was measured.
    #[must_use]
    pub fn from_classes(classes: Classes, weighting: Weighting) -> Self {
        Self::of(Form::Classes(classes), weighting)
    }

    /// Distributions mixed by shares of a quantity, in any unit; `None` if no share is above 0.
    #[must_use]
    pub fn mixture(parts: Vec<(f64, Self)>, weighting: Weighting) -> Option<Self> {
        let k = i32::from(weighting.power());
        let parts: Vec<(f64, Self)> = parts
            .into_iter()
            .filter(|(share, _)| *share > 0.0)
            .collect();
        // In units of the largest diameter, so that powers stay in range.
        let scale = parts
            .iter()
            .fold(0.0, |d: f64, (_, part)| d.max(part.largest()));
        let numbers: Vec<f64> = parts
            .iter()
            .map(|(share, part)| share / (part.moment(k) / whole_power(scale, k)))
            .collect();
        let sum: f64 = numbers.iter().sum();
        let parts: Vec<(f64, Self)> = numbers
            .iter()
            .zip(parts)
            .map(|(number, (_, part))| (number / sum, part))
            .collect();
        (!parts.is_empty()).then(|| Self::of(Form::Mixture(parts), weighting))
    }

    fn of(form: Form, weighting: Weighting) -> Self {
        let number = view(&form, Weighting::Number);
        Self {
            form,
            weighting,
            number,
        }
    }

    /// Part between two quantiles of the stated weighting.
    fn cut(self, cut: Option<[f64; 2]>) -> Result<Self, String> {
        let Some([low, high]) = cut else {
            return Ok(self);
        };
        match &self.form {
            Form::Classes(classes) => {
                let classes = classes.between(self.quantile(low), self.quantile(high));
                let classes = classes.map_err(|problem| problem.to_string())?;
                Ok(Self::from_classes(classes, self.weighting))
            }
            Form::Law(_) | Form::Mixture(_) => {
                Err("the file holds a law: give the cut there".to_owned())
            }
        }
    }

    /// Ready to evaluate where a quantity is counted.
    ///
    /// ```
    /// use mercury_common::sizes::{ClassModel, Classes, SizeDistribution, Weighting};
    /// let by_number = Weighting::Number;
    /// let classes = Classes::new(&[1.0, 3.0], &[1.0], by_number, ClassModel::default())?;
    /// let sizes = SizeDistribution::from_classes(classes, by_number);
    /// // By volume the density goes with d^3 on [1, 3]: half lies below ((1 + 81) / 2)^(1/4).
    /// let median = sizes.by(Weighting::Volume).quantile(0.5);
    /// assert!((median - 41.0_f64.powf(0.25)).abs() < 1e-15 * 4.0);
    /// # Ok::<(), mercury_common::sizes::ClassProblem>(())
    /// ```
    #[must_use]
    pub fn by(&self, weighting: Weighting) -> Weighted {
        view(&self.form, weighting)
    }

    /// Weighting by which the distribution was stated or measured.
    #[must_use]
    pub fn weighting(&self) -> Weighting {
        self.weighting
    }

    /// The classes of a measured distribution.
    #[must_use]
    pub fn classes(&self) -> Option<&Classes> {
        match &self.form {
            Form::Classes(classes) => Some(classes),
            _ => None,
        }
    }

    pub(super) fn form(&self) -> &Form {
        &self.form
    }

    pub(super) fn of_law(law: CutLaw, weighting: Weighting) -> Self {
        Self::of(Form::Law(law), weighting)
    }

    /// This distribution with another stated weighting.
    pub(super) fn stated_by(self, weighting: Weighting) -> Self {
        Self { weighting, ..self }
    }

    /// Whether many particles have exactly the same size.
    #[must_use]
    pub fn has_single_sizes(&self) -> bool {
        match &self.form {
            Form::Law(law) => matches!(law.law, Law::Monodisperse(_)),
            Form::Classes(_) => false,
            Form::Mixture(parts) => parts.iter().any(|(_, part)| part.has_single_sizes()),
        }
    }

    /// Smallest diameter that is drawn, m: the lower cut, or the quantile 1e-9 (in the stated
    /// weighting) of a law that reaches down to 0.
    #[must_use]
    pub fn smallest(&self) -> f64 {
        self.number.smallest
    }

    /// Largest diameter that is drawn, m: the upper cut, or the quantile 1 - 1e-9 (in the stated
    /// weighting) of a law without upper end, for a lognormal law 5.998 sigma above the median.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.number.largest
    }

    /// The diameter below which a share `q` of the cut law lies, counted in the stated weighting, m.
    /// `q` is clipped to [0, 1].
    #[must_use]
    pub fn quantile(&self, q: f64) -> f64 {
        match &self.form {
            Form::Law(law) => law.quantile(q.clamp(0.0, 1.0)),
            _ => self.by(self.weighting).quantile(q),
        }
    }

    /// A random diameter, m, from a uniform random number in [0, 1]: the inverse of
    /// [`SizeDistribution::number_cdf`], increasing in `u`. `u` is clipped to [0, 1].
    #[must_use]
    pub fn sample_diameter(&self, u: f64) -> f64 {
        self.number.quantile(u)
    }

    /// Share of the particles, by number, that are smaller than `diameter` (m).
    #[must_use]
    pub fn number_cdf(&self, diameter: f64) -> f64 {
        self.number.cdf(diameter)
    }

    /// Mean diameter by number, m.
    #[must_use]
    pub fn mean_diameter(&self) -> f64 {
        self.moment(1)
    }

    /// Mean volume of a particle, by number: the mean of pi/6 d^3, m3.
    ///
    /// ```
    /// # use std::path::Path;
    /// # use mercury_common::scene::{Files, parse_scene};
    /// # use mercury_common::sizes::SizeDistribution;
    /// # let text = "[time]\nend = 1.0\nstep = 0.1\n[domain]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n[output]\ninterval = 0.1\n\
    /// # [materials.m]\ndensity = 1.0\nnormal = { law = \"linear\", stiffness = 1.0, dissipation = 0.0 }\n\
    /// # [[insertions]]\nname = \"feed\"\nregion = { shape = \"sphere\", origin = [0, 0, 0], radius = 1 }\nmaterial = \"m\"\ntotal = { full = true }\n\
    /// # psd = { kind = \"uniform\", min_diameter = 1.0, max_diameter = 3.0, weighting = \"number\" }\n";
    /// # let scene = parse_scene(Path::new("box.toml"), text, &[], Files::Unchecked).unwrap();
    /// // psd = { kind = "uniform", min_diameter = 1.0, max_diameter = 3.0, weighting = "number" }
    /// let sizes = SizeDistribution::from_scene(scene.insertions[0].mixture[0].psd.as_ref().unwrap())?;
    /// // The mean of d^3 over [1, 3] is (3^4 - 1^4) / (4 * 2) = 10.
    /// assert!((sizes.mean_volume() - std::f64::consts::PI / 6.0 * 10.0).abs() < 1e-14);
    /// # Ok::<(), mercury_common::sizes::SizeError>(())
    /// ```
    #[must_use]
    pub fn mean_volume(&self) -> f64 {
        PI / 6.0 * self.moment(3)
    }

    /// Mean of d^j by number, m^j.
    #[must_use]
    pub fn moment(&self, j: i32) -> f64 {
        match &self.form {
            Form::Law(law) => law.moment(j),
            Form::Classes(classes) => classes.moment(j),
            Form::Mixture(parts) => parts
                .iter()
                .map(|(share, part)| share * part.moment(j))
                .sum(),
        }
    }
}

fn view(form: &Form, weighting: Weighting) -> Weighted {
    match form {
        Form::Law(law) => Weighted {
            smallest: law.smallest,
            largest: law.largest,
            way: Way::Law(law.by(weighting)),
        },
        Form::Classes(classes) => Weighted {
            smallest: classes.edges()[0],
            largest: classes.edges()[classes.edges().len() - 1],
            way: Way::Classes(classes.by(weighting)),
        },
        Form::Mixture(parts) => {
            let k = i32::from(weighting.power());
            let largest = parts.iter().map(|(_, part)| part.largest());
            let largest = largest.fold(0.0, f64::max);
            let smallest = parts.iter().map(|(_, part)| part.smallest());
            // By number the shares are known; else each part counts with its mean of d^k.
            let weights: Vec<f64> = parts
                .iter()
                .map(|(number, part)| match k {
                    0 => *number,
                    k => number * (part.moment(k) / whole_power(largest, k)),
                })
                .collect();
            let sum: f64 = weights.iter().sum();
            Weighted {
                smallest: smallest.fold(f64::INFINITY, f64::min),
                largest,
                way: Way::Mixture(
                    weights
                        .iter()
                        .zip(parts)
                        .map(|(weight, (_, part))| (weight / sum, part.by(weighting)))
                        .collect(),
                ),
            }
        }
    }
}

#[cfg(test)]
mod tests;

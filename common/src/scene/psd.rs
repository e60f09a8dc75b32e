//! Size distributions as a scene asks for them: `psd = { kind = "lognormal", ... }`.

use std::path::PathBuf;

use super::item::Item;
use super::source::Located;

/// A requested size distribution of diameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Psd {
    /// The family and its parameters.
    pub law: SizeLaw,
    /// The quantity whose share the law describes; `None` for a file, whose header says it.
    pub weighting: Option<Weighting>,
    /// Quantiles [low, high], in the stated weighting, outside which sizes are cut off.
    pub cut: Option<Located<[f64; 2]>>,
}

/// What is counted when one says "10 % are smaller than d".
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Weighting {
    /// Particles.
    Number,
    /// The sum of diameters.
    Length,
    /// The sum of surfaces.
    Area,
    /// The sum of volumes (or masses, at one density).
    Volume,
}

impl Weighting {
    /// The power k of the diameter in the weighted density, q_k(d) proportional to d^k q_0(d).
    #[must_use]
    pub fn power(self) -> u8 {
        match self {
            Weighting::Number => 0,
            Weighting::Length => 1,
            Weighting::Area => 2,
            Weighting::Volume => 3,
        }
    }
}

/// Families of size distributions; all lengths in m.
#[derive(Debug, Clone, PartialEq)]
pub enum SizeLaw {
    /// One size.
    Monodisperse {
        /// Diameter, m.
        diameter: Located<f64>,
    },
    /// Constant density between two diameters.
    Uniform {
        /// Smallest diameter, m.
        min_diameter: Located<f64>,
        /// Largest diameter, m.
        max_diameter: Located<f64>,
    },
    /// Normal law of the diameter, positive diameters only.
    Normal {
        /// Mean diameter, m.
        mean_diameter: Located<f64>,
        /// Standard deviation of the diameter, m.
        standard_deviation: Located<f64>,
    },
    /// Normal law of ln d.
    Lognormal {
        /// Median diameter, m.
        median_diameter: Located<f64>,
        /// Standard deviation of ln d.
        sigma: Located<f64>,
    },
    /// Rosin-Rammler (Weibull) law: Q(d) = 1 - exp(-(d/d63)^n).
    RosinRammler {
        /// Diameter below which 1 - 1/e = 63.2 % lie, m.
        d63: Located<f64>,
        /// Exponent n.
        exponent: Located<f64>,
    },
    /// Gates-Gaudin-Schuhmann law: Q(d) = (d/d_max)^n.
    Ggs {
        /// Largest diameter, m.
        max_diameter: Located<f64>,
        /// Exponent n.
        exponent: Located<f64>,
    },
    /// Normal law of phi = -log2(d / 1 mm).
    PhiNormal {
        /// Median diameter, m.
        median_diameter: Located<f64>,
        /// Standard deviation of phi.
        sigma_phi: Located<f64>,
    },
    /// A measured distribution.
    File {
        /// The table, resolved against the folder of the scene.
        file: Located<PathBuf>,
    },
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Monodisperse,
    Uniform,
    Normal,
    Lognormal,
    RosinRammler,
    Ggs,
    PhiNormal,
    File,
}

const KINDS: [(&str, Kind); 8] = [
    ("monodisperse", Kind::Monodisperse),
    ("uniform", Kind::Uniform),
    ("normal", Kind::Normal),
    ("lognormal", Kind::Lognormal),
    ("rosin-rammler", Kind::RosinRammler),
    ("ggs", Kind::Ggs),
    ("phi-normal", Kind::PhiNormal),
    ("file", Kind::File),
];

const WEIGHTINGS: [(&str, Weighting); 4] = [
    ("number", Weighting::Number),
    ("length", Weighting::Length),
    ("area", Weighting::Area),
    ("volume", Weighting::Volume),
];

pub(super) fn read(item: &Item<'_>) -> Option<Located<Psd>> {
    let fields = item.table()?;
    // A file alone says that it is one.
    let kind = if fields.has("file") && !fields.has("kind") {
        Kind::File
    } else {
        fields.need("kind")?.word("size distribution", &KINDS)?
    };
    fields.get("kind");
    let positive = |key| fields.need(key).and_then(|item| item.positive());
    let law =
        match kind {
            Kind::Monodisperse => {
                positive("diameter").map(|diameter| SizeLaw::Monodisperse { diameter })
            }
            Kind::Uniform => {
                let min = positive("min_diameter");
                let max = positive("max_diameter");
                min.zip(max).and_then(|(min_diameter, max_diameter)| {
                    if *min_diameter > *max_diameter {
                        let message =
                            format!("must be >= min_diameter = {}", min_diameter.place.text());
                        item.context.report(max_diameter.error(message));
                        return None;
                    }
                    Some(SizeLaw::Uniform {
                        min_diameter,
                        max_diameter,
                    })
                })
            }
            Kind::Normal => positive("mean_diameter")
                .zip(positive("standard_deviation"))
                .map(|(mean_diameter, standard_deviation)| SizeLaw::Normal {
                    mean_diameter,
                    standard_deviation,
                }),
            Kind::Lognormal => positive("median_diameter").zip(positive("sigma")).map(
                |(median_diameter, sigma)| SizeLaw::Lognormal {
                    median_diameter,
                    sigma,
                },
            ),
            Kind::RosinRammler => positive("d63")
                .zip(positive("exponent"))
                .map(|(d63, exponent)| SizeLaw::RosinRammler { d63, exponent }),
            Kind::Ggs => positive("max_diameter").zip(positive("exponent")).map(
                |(max_diameter, exponent)| SizeLaw::Ggs {
                    max_diameter,
                    exponent,
                },
            ),
            Kind::PhiNormal => positive("median_diameter").zip(positive("sigma_phi")).map(
                |(median_diameter, sigma_phi)| SizeLaw::PhiNormal {
                    median_diameter,
                    sigma_phi,
                },
            ),
            Kind::File => fields
                .need("file")
                .and_then(|item| item.file())
                .map(|file| SizeLaw::File { file }),
        };
    // With one size there is nothing to weight, and a measured table says in its header what it
    // counts; everywhere else a silent choice would be wrong for half the users.
    let weighting = match kind {
        Kind::Monodisperse => {
            let given = fields.get("weighting");
            Some(given.map_or(Some(Weighting::Number), |w| {
                w.word("weighting", &WEIGHTINGS)
            })?)
        }
        Kind::File => None,
        _ => {
            let help = "of what is it the distribution? number, length, area or volume";
            let given = fields.need_or_help("weighting", Some(help));
            Some(given.and_then(|w| w.word("weighting", &WEIGHTINGS))?)
        }
    };
    let cut = match kind {
        Kind::Monodisperse => None,
        _ => fields.get("cut").and_then(|item| {
            let cut = item.range()?;
            if cut[0] < 0.0 || cut[1] > 1.0 {
                item.report("both quantiles must lie in [0, 1]");
                return None;
            }
            Some(cut)
        }),
    };
    fields.finish();
    Some(Located {
        value: Psd {
            law: law?,
            weighting,
            cut,
        },
        place: item.place.clone(),
    })
}

//! Size distributions as a scene describes them: `psd = { kind = "lognormal", ... }`.

use std::cell::RefCell;
use std::path::{Path, PathBuf};

use super::cursor::{Context, Fields, Files};
use super::error::SceneErrors;
use super::item::Item;
use super::quantities;
use super::source::{Located, Place, Source};
use super::tree::{self, Value};
use crate::sizes::ClassModel;

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
    /// Several distributions together, with shares of what the distribution is stated of.
    Mixture {
        /// At least one.
        of: Vec<MixturePart>,
    },
    /// Shares of classes, as a table in the scene itself.
    Classes {
        /// Diameters between classes, m; one more than shares.
        diameters: Vec<f64>,
        /// Shares of the classes, of any sum.
        shares: Vec<f64>,
        /// What is assumed inside a class; default number-uniform.
        model: ClassModel,
    },
    /// A measured distribution, or a law in a file of its own.
    File {
        /// The table (.csv) or law (.toml), resolved against the folder of the scene.
        file: Located<PathBuf>,
    },
}

/// One part of a mixture of distributions.
#[derive(Debug, Clone, PartialEq)]
pub struct MixturePart {
    /// Its share as it is written; all are scaled to the sum 1.
    pub share: f64,
    /// Its distribution; stated by the weighting of the mixture unless it says another.
    pub psd: Located<Psd>,
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
    Mixture,
    Classes,
    File,
}

const KINDS: [(&str, Kind); 10] = [
    ("monodisperse", Kind::Monodisperse),
    ("uniform", Kind::Uniform),
    ("normal", Kind::Normal),
    ("lognormal", Kind::Lognormal),
    ("rosin-rammler", Kind::RosinRammler),
    ("ggs", Kind::Ggs),
    ("phi-normal", Kind::PhiNormal),
    ("mixture", Kind::Mixture),
    ("classes", Kind::Classes),
    ("file", Kind::File),
];

const WEIGHTINGS: [(&str, Weighting); 4] = [
    ("number", Weighting::Number),
    ("length", Weighting::Length),
    ("area", Weighting::Area),
    ("volume", Weighting::Volume),
];

/// Reads a law from a file of its own: the keys of a scene's `psd` at the top level.
///
/// # Errors
/// All mistakes of the file at once.
pub fn read_psd(path: &Path) -> Result<Located<Psd>, SceneErrors> {
    read_psd_with(path, Files::MustExist)
}

/// Reads a law from a file as [`read_psd`] does, and says which files it may name.
///
/// # Errors
/// As [`read_psd`].
pub fn read_psd_with(path: &Path, files: Files) -> Result<Located<Psd>, SceneErrors> {
    let text = super::read_text(path, "size distribution")?;
    parse(&path.display().to_string(), &text, path.parent(), files)
}

/// Reads a law from its text, called `name` in messages. Files that it names are looked for in `folder`.
///
/// # Errors
/// As [`read_psd`].
pub fn parse_psd(
    name: &str,
    text: &str,
    folder: Option<&Path>,
) -> Result<Located<Psd>, SceneErrors> {
    parse(name, text, folder, Files::MustExist)
}

fn parse(
    name: &str,
    text: &str,
    folder: Option<&Path>,
    files: Files,
) -> Result<Located<Psd>, SceneErrors> {
    let source = Source::file(name, text, &files);
    let mut document = tree::parse_document(&source, text)?;
    let mut wrong_units = Vec::new();
    quantities::settle(&mut document, None, &[], &mut wrong_units);
    let context = Context {
        errors: RefCell::new(Vec::new()),
        directory: folder.unwrap_or(Path::new("")).to_owned(),
        files,
        materials: Vec::new(),
        clumps: Vec::new(),
        laws: None,
        named: RefCell::default(),
    };
    let place = Place::new(&source, 0..0, "");
    let psd = match &document.value {
        Value::Table(table) => read_fields(
            &Fields::new(&context, table, place.clone()),
            place.clone(),
            None,
        ),
        _ => None,
    };
    let mut errors = context.errors.into_inner();
    quantities::with_units(&mut errors, wrong_units);
    errors.sort_by_key(|error| error.place.order());
    match psd {
        Some(psd) if errors.is_empty() => Ok(psd),
        _ if errors.is_empty() => Err(place.error("this is not a size distribution").into()),
        _ => Err(SceneErrors(errors)),
    }
}

pub(super) fn read(item: &Item<'_>) -> Option<Located<Psd>> {
    read_fields(&item.table()?, item.place.clone(), None)
}

/// `inherited`: the weighting of the mixture that this is a part of.
fn read_fields(
    fields: &Fields<'_>,
    place: Place,
    inherited: Option<Weighting>,
) -> Option<Located<Psd>> {
    // A file alone says that it is one.
    let kind = if fields.has("file") && !fields.has("kind") {
        Kind::File
    } else {
        fields.need("kind")?.word("size distribution", &KINDS)?
    };
    fields.get("kind");
    // With one size there is nothing to weight, and a measured table says in its header what it
    // counts; everywhere else a silent choice would be wrong for half the users.
    let weighting = match kind {
        Kind::Monodisperse => {
            let given = fields.get("weighting");
            let given = given.map_or(Some(Weighting::Number), |w| {
                w.word("weighting", &WEIGHTINGS)
            });
            given.map(Some)
        }
        Kind::File => Some(None),
        _ => match inherited {
            Some(weighting) if !fields.has("weighting") => Some(Some(weighting)),
            _ => {
                let help = "of what is it the distribution? number, length, area or volume";
                let given = fields.need_or_help("weighting", Some(help));
                let given = given.and_then(|w| w.word("weighting", &WEIGHTINGS));
                given.map(Some)
            }
        },
    };
    // Without it the rest is read all the same, so that all that is wrong is said at once.
    let law = read_law(fields, kind, weighting.unwrap_or(Some(Weighting::Number)));
    let cut = match kind {
        Kind::Monodisperse | Kind::Mixture => None,
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
            weighting: weighting?,
            cut,
        },
        place,
    })
}

fn read_law(fields: &Fields<'_>, kind: Kind, weighting: Option<Weighting>) -> Option<SizeLaw> {
    let positive = |key| fields.need(key).and_then(|item| item.positive());
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
                    fields.context.report(max_diameter.error(message));
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
        Kind::Lognormal => {
            positive("median_diameter")
                .zip(positive("sigma"))
                .map(|(median_diameter, sigma)| SizeLaw::Lognormal {
                    median_diameter,
                    sigma,
                })
        }
        Kind::RosinRammler => positive("d63")
            .zip(positive("exponent"))
            .map(|(d63, exponent)| SizeLaw::RosinRammler { d63, exponent }),
        Kind::Ggs => {
            positive("max_diameter")
                .zip(positive("exponent"))
                .map(|(max_diameter, exponent)| SizeLaw::Ggs {
                    max_diameter,
                    exponent,
                })
        }
        Kind::PhiNormal => positive("median_diameter").zip(positive("sigma_phi")).map(
            |(median_diameter, sigma_phi)| SizeLaw::PhiNormal {
                median_diameter,
                sigma_phi,
            },
        ),
        Kind::Mixture => read_mixture(fields, weighting),
        Kind::Classes => {
            let diameters = fields.need("diameters").and_then(|item| numbers(&item));
            let shares = fields.need("shares").and_then(|item| numbers(&item));
            let model = match fields.get("model") {
                Some(item) => {
                    let words: Vec<(&str, ClassModel)> = ClassModel::all().collect();
                    item.word("model of a class", &words)
                }
                None => Some(ClassModel::default()),
            };
            Some(SizeLaw::Classes {
                diameters: diameters?,
                shares: shares?,
                model: model?,
            })
        }
        Kind::File => fields
            .need("file")
            .and_then(|item| item.file())
            .map(|file| SizeLaw::File { file }),
    }
}

fn read_mixture(fields: &Fields<'_>, weighting: Option<Weighting>) -> Option<SizeLaw> {
    let item = fields.need("of")?;
    let parts = item.list()?;
    if parts.is_empty() {
        item.report("must list at least one distribution");
        return None;
    }
    let part = |item: &Item<'_>| {
        let fields = item.table()?;
        let share = fields.need("share").and_then(|item| item.non_negative());
        let psd = read_fields(&fields, item.place.clone(), weighting);
        Some(MixturePart {
            share: share?.value,
            psd: psd?,
        })
    };
    let read: Vec<Option<MixturePart>> = parts.iter().map(part).collect();
    let of: Vec<MixturePart> = read.into_iter().collect::<Option<_>>()?;
    let sum: f64 = of.iter().map(|part| part.share).sum();
    if sum <= 0.0 || !sum.is_finite() {
        item.report(format!("the shares must have a sum > 0, it is {sum}"));
        return None;
    }
    Some(SizeLaw::Mixture { of })
}

/// A list of finite numbers.
fn numbers(item: &Item<'_>) -> Option<Vec<f64>> {
    let read: Vec<Option<Located<f64>>> = item.list()?.iter().map(Item::number).collect();
    read.into_iter().map(|number| Some(number?.value)).collect()
}

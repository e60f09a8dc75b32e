//! Size distributions as a scene describes them: `psd = { kind = "lognormal", ... }`.

use std::cell::RefCell;
use std::path::{Path, PathBuf};

use super::cursor::{Context, Fields, Files};
use super::error::SceneErrors;
use super::from_item::{FromItem, Untyped};
use super::item::Item;
use super::keys::{
    Kind, SceneKey, TableKeys, Variant, Variants, Word, key, non_negative, number, positive,
    variant, word,
};
use super::quantities;
use super::source::{Located, Source, SourceSpan};
use super::tree::{self, Value};
use crate::sizes::ClassModel;

/// A requested size distribution of diameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Psd {
    /// The family and its parameters.
    pub law: SizeLaw,
    /// The quantity whose share the law describes; `None` for a file, whose header gives it.
    pub weighting: Option<Weighting>,
    /// Quantiles [low, high], in the stated weighting, outside which sizes are cut off.
    pub cut: Option<Located<[f64; 2]>>,
}

/// Quantity that is counted in "10 % are smaller than d".
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
        /// Distribution inside a class; default number-uniform.
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
    /// Its distribution; stated by the weighting of the mixture unless it states another.
    pub psd: Located<Psd>,
}

impl Word for Weighting {
    const WHAT: &'static str = "weighting";
    const WORDS: &'static [(&'static str, Self)] = &[
        ("number", Self::Number),
        ("length", Self::Length),
        ("area", Self::Area),
        ("volume", Self::Volume),
    ];
}

impl FromItem for ClassModel {
    fn from_item(item: &Item<'_>, _: &'static Kind) -> Option<Self> {
        let words: Vec<(&str, ClassModel)> = ClassModel::all().collect();
        item.word("model of a class", &words)
    }
}

fn class_models() -> Vec<&'static str> {
    ClassModel::all().map(|(word, _)| word).collect()
}

const fn diameter(name: &'static str, example: &'static str, text: &'static str) -> SceneKey {
    key(name, positive("m"), example, text)
}

#[rustfmt::skip]
const WEIGHTING: SceneKey = key("weighting", word::<Weighting>(), "\"volume\"   # of what is it the distribution? number, length, area or volume", "of what the law is the distribution; particles are drawn by number whatever it is");
/// The keys of all laws but few.
#[rustfmt::skip]
const STATED: &[SceneKey] = &[
    WEIGHTING.needed("but in a part of a mixture, which has that of the mixture"),
    key("cut", Kind::Interval(""), "[0.01, 0.99]", "quantiles in that weighting, in [0, 1], outside which sizes are cut off").or_open("1e-9 and 1 - 1e-9 where the law reaches 0 or infinity"),
];
const EXPONENT: SceneKey = key("exponent", positive(""), "4.0", "exponent of the law");
#[rustfmt::skip]
const MEDIAN: SceneKey = diameter("median_diameter", "2e-3", "half of the weight lies below it");
#[rustfmt::skip]
const FILE: Variant = variant("file", &[&[
    key("file", Kind::File(""), "\"grain.psd.csv\"", "a [table](size-table.md) (`.csv`) or a [law](size-table.md#laws) (`.toml`)"),
    key("cut", Kind::Interval(""), "[0.01, 0.99]", "as above").or_open("none"),
]], "a measured distribution, or a law in a file of its own; `file` alone says it");
#[rustfmt::skip]
static KINDS: [Variant; 10] = [
    variant("monodisperse", &[&[
        diameter("diameter", "2e-3", "of all particles"),
        WEIGHTING.or_word("number"),
    ]], "one size"),
    variant("uniform", &[&[
        diameter("min_diameter", "1e-3", "smallest diameter"),
        diameter("max_diameter", "3e-3", "not below `min_diameter`"),
    ], STATED], "constant density between two diameters"),
    variant("normal", &[&[
        diameter("mean_diameter", "2e-3", "mean of the diameter"),
        diameter("standard_deviation", "2e-4", "of the diameter"),
    ], STATED], "normal law of the diameter, positive diameters only"),
    variant("lognormal", &[&[
        MEDIAN,
        key("sigma", positive(""), "0.3   # of ln d", "standard deviation of ln d"),
    ], STATED], "normal law of ln d"),
    variant("rosin-rammler", &[&[
        diameter("d63", "2e-3", "63.2 % lie below it"),
        EXPONENT,
    ], STATED], "Q(d) = 1 - exp(-(d/d63)^exponent)"),
    variant("ggs", &[&[
        diameter("max_diameter", "3e-3", "largest diameter"),
        EXPONENT,
    ], STATED], "Gates-Gaudin-Schuhmann: Q(d) = (d/max_diameter)^exponent"),
    variant("phi-normal", &[&[
        MEDIAN,
        key("sigma_phi", positive(""), "0.3   # of -log2(d / 1 mm)", "standard deviation of -log2(d / 1 mm)"),
    ], STATED], "normal law of -log2(d / 1 mm)"),
    variant("mixture", &[&[
        key("of", Kind::List("distribution", &Kind::Table(&PART)), "[{ share = 1.0, kind = \"monodisperse\", diameter = 2e-3 }]", "the distributions, each with its `share`, which counts in the mixture's `weighting`"),
        WEIGHTING.needed("but in a part of a mixture, which has that of the mixture"),
    ]], "several distributions together"),
    variant("classes", &[&[
        key("diameters", Kind::List("", &number("m")), "[1e-3, 2e-3, 3e-3]   # m, one more than shares", "between the classes, one more than `shares`"),
        key("shares", Kind::List("", &number("")), "[0.4, 0.6]", "of the classes, of any sum"),
        key("model", Kind::Word("model of a class", class_models), "\"number-uniform\"", "[what lies inside a class](size-table.md#what-lies-inside-a-class)").or_open("number-uniform"),
    ], STATED], "a table in the scene itself"),
    FILE,
];
static BY_KIND: Variants = Variants::Word {
    key: "kind",
    what: "size distribution",
    example: "\"monodisperse\"   # or uniform, normal, lognormal, rosin-rammler, ggs, phi-normal, mixture, classes, file",
    text: "the law",
    absent: Some(&FILE),
    of: &KINDS,
};

/// A size distribution.
pub(super) static PSD: TableKeys = TableKeys::new(&[]).with_variants(BY_KIND);

/// A part of a mixture of distributions.
#[rustfmt::skip]
static PART: TableKeys = TableKeys::new(&[&[
    key("share", non_negative(""), "0.5   # in the weighting of the mixture", "its part of the mixture; all are scaled to the sum 1"),
]]).with_variants(BY_KIND);

/// Reads a law from a file of its own: the keys of a scene's `psd` at the top level.
///
/// # Errors
/// All mistakes of the file at once.
pub fn read_psd(path: &Path) -> Result<Located<Psd>, SceneErrors> {
    read_psd_with(path, Files::MustExist)
}

/// Reads a law from a file as [`read_psd`] does; `files`: which files it may name.
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
    quantities::settle(&mut document, &PSD, None, &[], &mut wrong_units);
    let context = Context {
        errors: RefCell::new(Vec::new()),
        directory: folder.unwrap_or(Path::new("")).to_owned(),
        files,
        materials: Vec::new(),
        clumps: Vec::new(),
        laws: None,
        named: RefCell::default(),
    };
    let place = SourceSpan::new(&source, 0..0, "");
    let psd = match &document.value {
        Value::Table(table) => {
            let mut fields = Fields::new(&context, table, place.clone());
            fields.hold_to(&PSD);
            read_fields(&fields, None).map(|psd| Located {
                value: psd,
                place: place.clone(),
            })
        }
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

impl FromItem for Psd {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        read_fields(&item.fields(kind)?, None)
    }
}

/// `inherited`: the weighting of the mixture that this is a part of.
fn read_fields(fields: &Fields<'_>, inherited: Option<Weighting>) -> Option<Psd> {
    let kind = fields.variant()?;
    // With one size there is nothing to weight, and a measured table gives in its header what it
    // counts; everywhere else a silent choice would be wrong for half the users.
    let weighting = match (kind, inherited) {
        ("monodisperse", _) => Some(fields.read("weighting")),
        ("file", _) => None,
        (_, Some(inherited)) if !fields.has("weighting") => Some(inherited),
        _ => Some(fields.require("weighting")),
    };
    let law = match kind {
        "monodisperse" => SizeLaw::Monodisperse {
            diameter: fields.read("diameter"),
        },
        "uniform" => SizeLaw::Uniform {
            min_diameter: fields.read("min_diameter"),
            max_diameter: fields.read("max_diameter"),
        },
        "normal" => SizeLaw::Normal {
            mean_diameter: fields.read("mean_diameter"),
            standard_deviation: fields.read("standard_deviation"),
        },
        "lognormal" => SizeLaw::Lognormal {
            median_diameter: fields.read("median_diameter"),
            sigma: fields.read("sigma"),
        },
        "rosin-rammler" => SizeLaw::RosinRammler {
            d63: fields.read("d63"),
            exponent: fields.read("exponent"),
        },
        "ggs" => SizeLaw::Ggs {
            max_diameter: fields.read("max_diameter"),
            exponent: fields.read("exponent"),
        },
        "phi-normal" => SizeLaw::PhiNormal {
            median_diameter: fields.read("median_diameter"),
            sigma_phi: fields.read("sigma_phi"),
        },
        "mixture" => read_mixture(fields, weighting)?,
        "classes" => SizeLaw::Classes {
            diameters: fields.read("diameters"),
            shares: fields.read("shares"),
            model: fields.read::<Option<_>>("model").unwrap_or_default(),
        },
        "file" => SizeLaw::File {
            file: fields.read("file"),
        },
        _ => return None,
    };
    if let SizeLaw::Uniform {
        min_diameter: min,
        max_diameter: max,
    } = &law
        && **min > **max
    {
        let message = format!("must be >= min_diameter = {}", min.place.text());
        fields.context.report(max.error(message));
    }
    let cut: Option<Located<[f64; 2]>> = match kind {
        "monodisperse" | "mixture" => None,
        _ => fields.read("cut"),
    };
    if let Some(cut) = &cut
        && (cut[0] < 0.0 || cut[1] > 1.0)
    {
        let error = cut.error("both quantiles must lie in [0, 1]");
        fields.context.report(error);
    }
    Some(Psd {
        law,
        weighting,
        cut,
    })
}

fn read_mixture(fields: &Fields<'_>, weighting: Option<Weighting>) -> Option<SizeLaw> {
    let items: Option<Located<Vec<Untyped>>> = fields.read("of");
    let list = fields.get("of").filter(|_| items.is_some())?;
    let read = |item: &Item<'_>| {
        let fields = item.open(&PART)?;
        let share = fields.read("share");
        let psd = item.located(read_fields(&fields, weighting)?);
        Some(MixturePart { share, psd })
    };
    let read: Vec<Option<MixturePart>> = list.list()?.iter().map(read).collect();
    let of: Vec<MixturePart> = read.into_iter().collect::<Option<_>>()?;
    let sum: f64 = of.iter().map(|part| part.share).sum();
    if sum <= 0.0 || sum.is_infinite() {
        let message = format!("the shares must have a sum > 0, it is {sum}");
        list.report(message);
    }
    Some(SizeLaw::Mixture { of })
}

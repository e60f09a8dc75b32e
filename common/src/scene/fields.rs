//! `[[fields]]`: fields of the continuum that are computed while the run goes on.

use std::collections::BTreeMap;
use std::path::PathBuf;

use glam::DVec3;

use super::MaterialIndex;
use super::cursor::Fields;
use super::from_item::FromItem;
use super::item::Item;
use super::keys::{
    Absent, Choice, Kind, TableKeys, Word, key, non_negative, positive, vector, word,
};
use super::laws::Range;
use super::settings::Axis;
use super::source::{Located, SourceSpan};

/// An entry of `[[fields]]`. Words that coarse-graining defines are checked where the fields are planned.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldTable {
    /// Where the entry stands.
    pub place: SourceSpan,
    /// Unique among field tables: part of the file's name.
    pub name: Located<String>,
    /// Names of fields; none: the standard ones.
    pub fields: Vec<Located<String>>,
    /// Resolved coordinates; none: all that the domain has.
    pub coordinates: Option<Located<String>>,
    /// Cells along each of them.
    pub grid: Option<Located<Vec<u64>>>,
    /// Sizes of cells, m (rad); one for all, or one for each coordinate.
    pub spacing: Option<Located<Vec<f64>>>,
    /// Or a file of points.
    pub points: Option<Located<PathBuf>>,
    /// Limits of coordinates, m (rad).
    pub limits: BTreeMap<&'static str, Located<[f64; 2]>>,
    /// Name of the kernel.
    pub kernel: &'static str,
    /// Its width; none: one mean diameter.
    pub width: Option<Located<FieldWidth>>,
    /// Where a Gaussian is cut, in widths.
    pub cutoff: Option<Located<f64>>,
    /// Error of line integrals of a Gaussian, of their largest value.
    pub tolerance: Option<Located<f64>>,
    /// Faces of the domain that mirror particles and contacts.
    pub mirror: Vec<Located<String>>,
    /// Direction of the axis of cylindrical coordinates: 0, 1 or 2.
    pub axis: Option<usize>,
    /// A point on it, m; none: the middle of the domain.
    pub through: Option<Located<DVec3>>,
    /// Whether each material has fields of its own, too; default false.
    pub by_material: bool,
    /// Materials with fields of their own.
    pub materials: Vec<Located<MaterialIndex>>,
    /// Whether displacements are those since the first look, instead of the look before; default false.
    pub since_first: bool,
    /// Between two looks, s; none: `output.interval`.
    pub interval: Option<Located<f64>>,
    /// No look before, s; default 0.
    pub from: Option<Located<f64>>,
    /// No look after, s; default never.
    pub until: Option<Located<f64>>,
    /// One mean over all looks, with standard errors; default false.
    pub average: bool,
    /// Standard deviation and distance of means over looks near in time, s.
    pub smooth: Option<Located<[f64; 2]>>,
}

impl FieldTable {
    /// Where a key of the entry stands; the place of its name for one that is not there.
    #[must_use]
    pub fn place_of(&self, key: &str) -> &SourceSpan {
        let found = match key {
            "fields" => self.fields.first().map(|name| &name.place),
            "coordinates" => self.coordinates.as_ref().map(|word| &word.place),
            "grid" => self.grid.as_ref().map(|cells| &cells.place),
            "spacing" => self.spacing.as_ref().map(|sizes| &sizes.place),
            "points" => self.points.as_ref().map(|file| &file.place),
            "limits" => self.limits.values().next().map(|range| &range.place),
            "width" => self.width.as_ref().map(|width| &width.place),
            "cutoff" => self.cutoff.as_ref().map(|widths| &widths.place),
            "tolerance" => self.tolerance.as_ref().map(|error| &error.place),
            "materials" => self.materials.first().map(|name| &name.place),
            "smooth" => self.smooth.as_ref().map(|both| &both.place),
            "mirror" => self.mirror.first().map(|face| &face.place),
            "through" => self.through.as_ref().map(|point| &point.place),
            _ => None,
        };
        found.unwrap_or(&self.name.place)
    }
}

/// The width of a kernel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FieldWidth {
    /// In m.
    Metres(f64),
    /// In mean diameters of the start.
    Diameters(f64),
}

/// The kernels by name.
#[derive(Clone, Copy)]
struct Kernel(&'static str);

impl Word for Kernel {
    const WHAT: &'static str = "kernel";
    const WORDS: &'static [(&'static str, Self)] = &[
        ("gaussian", Self("gaussian")),
        ("lucy", Self("lucy")),
        ("linear", Self("linear")),
        ("heaviside", Self("heaviside")),
    ];
}

/// The sample that displacements count from.
#[derive(Clone, Copy, PartialEq)]
enum Since {
    First,
    Previous,
}

impl Word for Since {
    const WHAT: &'static str = "look";
    const WORDS: &'static [(&'static str, Self)] =
        &[("first", Self::First), ("previous", Self::Previous)];
}

/// `[[fields]]`
#[rustfmt::skip]
pub(super) static FIELD: TableKeys = TableKeys::new(&[&[
    key("name", Kind::Name, "\"profile\"   # part of the file's name", "part of the file's name: letters, digits, - and _"),
    key("fields", Kind::List("", &Kind::Text), "[\"standard\"]", "names as of `mercury-cg --list-fields`, `\"standard\"`, `\"all\"`").or_open("standard"),
    key("coordinates", Kind::Text, "\"Z\"", "`\"O\"`, `\"X\"` ... `\"XYZ\"`, `\"R\"`, `\"RZ\"`, `\"Rphi\"`, `\"RphiZ\"`").or_open("`\"XYZ\"`, in 2D `\"XY\"`"),
    key("grid", Kind::List("", &Kind::Whole(1, u64::MAX)), "[20, 40]", "cells along each coordinate").or_open("by `spacing`"),
    key("spacing", Kind::List("", &Kind::OneOf(&[positive("m"), positive("rad")])), "[2e-3]   # m", "size of cells, one for all or one for each coordinate (rad for phi)").or_open("that of the width"),
    key("points", Kind::File(""), "\"points.txt\"", "in place of a grid: a file with a line of coordinates for each point").or_open("none"),
    key("limits", Kind::Table(&LIMITS), "{ z = [0.0, 0.1] }   # m", "of coordinates").absent(Absent::EmptyTable),
    key("kernel", word::<Kernel>(), "\"lucy\"", "the kernel of coarse-graining").or_word("gaussian"),
    key("width", Kind::OneOf(&[positive("m"), Kind::Diameters]), "2e-3   # m, or \"1.5d\"", "of the kernel; m, or mean diameters of the start as in `\"1.5d\"` (of what the insertions bring, by number, where nothing moves at the start)").or_open("`\"1d\"`"),
    key("cutoff", Kind::Number("", Range::Between(1.0, 38.0)), "4.0", "where a Gaussian is cut, in widths").or_open("4"),
    key("tolerance", Kind::Number("", Range::Between(1e-16, 0.1)), "1e-3", "error of line integrals of a Gaussian").or_open("1e-3"),
    key("mirror", Kind::List("", &Kind::Text), "[\"-z\"]", "faces of the domain that mirror").or_open("none"),
    key("axis", word::<Axis>(), "\"z\"", "of cylindrical coordinates").or_open("`\"z\"`"),
    key("through", vector("m"), "[0.05, 0.05, 0.0]", "a point on that axis").or_open("the middle of the domain"),
    key("by_material", Kind::Flag, "true", "each material's fields beside those of all").or_flag(false),
    key("materials", Kind::List("", &Kind::Material), "[\"glass\"]", "or those of some").or_open("none"),
    key("since", word::<Since>(), "\"first\"", "displacements are those since the `\"first\"` sample, or the sample before").or_word("previous"),
    key("interval", positive("s"), "0.01", "between two samples; also at the start and at the end").or_open("`output.interval`"),
    key("from", non_negative("s"), "0.5", "no sample before").or_open("0"),
    key("until", non_negative("s"), "1.0", "no sample after").or_open("never"),
    key("average", Kind::Flag, "true", "one mean over all samples with standard errors, which can be read while it grows, instead of a block for each sample").or_flag(false),
    key("smooth", Kind::Numbers("s", 2, Range::Positive), "[0.1, 0.05]", "`[width, step]`: instead, means every `step` over the samples around it, weighted by a Gaussian that is cut at three widths").or_open("none"),
]]).with_choices(&[Choice { keys: &["grid", "spacing", "points"], needed: false }]);

#[rustfmt::skip]
static LIMITS: TableKeys = TableKeys::new(&[&[
    key("x", Kind::Interval("m"), "[0.0, 0.1]", "of Cartesian coordinates").or_open("the domain"),
    key("y", Kind::Interval("m"), "[0.0, 0.1]", "of Cartesian coordinates").or_open("the domain"),
    key("z", Kind::Interval("m"), "[0.0, 0.1]", "also along the axis").or_open("the domain"),
    key("r", Kind::Interval("m"), "[0.0, 0.05]", "from the axis").or_open("the domain"),
    key("phi", Kind::Interval("rad"), "[0.0, 1.0]", "about the axis").or_open("the whole circle"),
]]);

/// Reads an entry of `[[fields]]`.
pub(super) fn read(item: &Item<'_>) -> Option<FieldTable> {
    let fields = item.open(&FIELD)?;
    let name: Located<String> = fields.read("name");
    let may = |c: char| c.is_alphanumeric() || c == '-' || c == '_';
    if !name.chars().all(may) {
        let error = name.error("is part of a file's name: only letters, digits, - and _");
        fields.context.report(error);
    }
    let limits = fields.section("limits");
    let limits = limits.iter().flat_map(|limits| {
        let names = ["x", "y", "z", "r", "phi"].into_iter();
        names.filter_map(|name| Some((name, limits.read::<Option<_>>(name)?)))
    });
    let average = fields.read("average");
    if average && let Some(item) = fields.get("smooth") {
        item.report("cannot be used together with average = true");
    }
    let kernel: Kernel = fields.read("kernel");
    let axis: Option<Axis> = fields.read("axis");
    let since: Since = fields.read("since");
    Some(FieldTable {
        place: item.place.clone(),
        name,
        fields: names(&fields, "fields"),
        coordinates: fields.read("coordinates"),
        grid: fields.read("grid"),
        spacing: fields.read("spacing"),
        points: fields.read("points"),
        limits: limits.collect(),
        kernel: kernel.0,
        width: fields.read("width"),
        cutoff: fields.read("cutoff"),
        tolerance: fields.read("tolerance"),
        mirror: names(&fields, "mirror"),
        axis: axis.map(|axis| axis.0),
        through: fields.read("through"),
        by_material: fields.read("by_material"),
        materials: fields.read::<Option<_>>("materials").unwrap_or_default(),
        since_first: since == Since::First,
        interval: fields.read("interval"),
        from: fields.read("from"),
        until: fields.read("until"),
        average,
        smooth: fields.read("smooth"),
    })
}

/// A list of names; none where it is left out.
fn names(fields: &Fields<'_>, key: &'static str) -> Vec<Located<String>> {
    fields.read::<Option<_>>(key).unwrap_or_default()
}

/// A length in m, or a text as "1.5d".
impl FromItem for FieldWidth {
    fn from_item(item: &Item<'_>, kind: &'static Kind) -> Option<Self> {
        if !item.is_text() {
            return f64::from_item(item, kind).map(FieldWidth::Metres);
        }
        let text = item.text()?.value;
        let times = text
            .strip_suffix('d')
            .and_then(|times| times.trim().parse().ok());
        let width = times.filter(|times: &f64| *times > 0.0 && times.is_finite());
        if width.is_none() {
            item.report(format!(
                "expected a length in m, or mean diameters as in \"1.5d\", got {text:?}"
            ));
        }
        width.map(FieldWidth::Diameters)
    }
}
